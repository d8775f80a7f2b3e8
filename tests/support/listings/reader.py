"""Read a filled listing: its directives, its tables, and its functions as statements of one operation each.

`read_listing` takes the tokens of `source.fill`. Holes of the listing may be filled with words: machine.py knows the values of these.
A statement that is no single operation is refused, so that every rounding of the C is one operation here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

PREFIX = "c"  # the name of the task that listings are filled for
NAME, INTEGER_LOOP = r"[A-Za-z_]\w*", r"for \( int32_t (\w+) = 0 ; \1 < (\w+) ; \+\+ \1 \)"
OPERAND = rf"(?:{NAME}|\d\S*|\( - \S+ \)|\( {PREFIX}_real \) NAN)"
KINDS_OF_VALUES = {
    f"{PREFIX}_real": "real", "int32_t": "int", "uint32_t": "uint", "bool": "bool", f"{PREFIX}_status": "status", "void": "void",
}  # fmt: skip
TYPE = "|".join(KINDS_OF_VALUES)
EXPRESSIONS = {  # by kind; the groups are its operands
    "operand": rf"({OPERAND})",
    "choice": rf"({OPERAND}) \? ({OPERAND}) : ({OPERAND})",
    "operation": rf"({OPERAND}) (<=|&&|[-+*/<]) ({OPERAND})",
    "negation": rf"- ({OPERAND})",
    "not": rf"! ({OPERAND})",
    "cast": rf"\( ({TYPE}) \) ({OPERAND})",
    "load": rf"({NAME}) \[ ({NAME}) \]",
    "table": rf"{PREFIX.upper()}_READ_(\w+) \( {PREFIX}_(\w+) \[ ({NAME}) \] \)",  # bits, table, index
    "low half": rf"\( int32_t \) \( int16_t \) ({NAME})",
    "finite": rf"isfinite \( ({OPERAND}) \) != 0",
    "call": rf"({NAME}) \( (.+) \)",
}
STATEMENTS = {  # by kind
    "declare": rf"(?P<type>{TYPE}) (?P<target>{NAME})",
    "define": rf"(?P<constant>const )?(?P<type>{TYPE}) (?P<target>{NAME}) = (?P<value>.+)",
    "output": rf"\* (?P<target>{NAME}) = (?P<value>.+)",
    "assign": rf"(?P<target>{NAME}) = (?P<value>.+)",
    "store": rf"(?P<target>{NAME}) \[ (?P<index>{NAME}) \] = (?P<value>.+)",
    "return": r"return(?: (?P<value>.+))?",
    "call": rf"(?P<value>{NAME} \( .+ \))",
}


class UnknownMeaning(Exception):
    """A listing has something that is not read here, or means something else than it should."""


def require(holds: bool, problem: str) -> None:
    """Raise `UnknownMeaning` with the problem where a condition does not hold."""
    if not holds:
        raise UnknownMeaning(problem)


class Expression(NamedTuple):
    """One operation. kind: of EXPRESSIONS; parts: its operands, and for an operation its sign between them."""

    kind: str
    parts: tuple[str, ...]


@dataclass(frozen=True)
class Statement:
    """kind: of STATEMENTS; target: the name that gets the value; value_type: of the target, where it is declared."""

    kind: str
    text: str
    target: str = ""
    value_type: str = ""
    is_constant: bool = False
    index: str = ""
    value: Expression | None = None


@dataclass(frozen=True)
class Block:
    """A loop over the components (index, count), or a branch (condition), with its statements."""

    head: str
    body: tuple[Statement | Block, ...]
    index: str = ""
    count: str = ""
    condition: str = ""


class Parameter(NamedTuple):
    """passing: "value", "array" that is read, "result" array that is written, or "output" through a pointer."""

    value_type: str
    name: str
    passing: str


@dataclass(frozen=True)
class Function:
    """head: its tokens up to the body. is_kernel: it is `static inline`, for the other functions alone."""

    name: str
    head: str
    result: str
    parameters: tuple[Parameter, ...]
    tokens: tuple[str, ...]
    is_kernel: bool

    @cached_property
    def body(self) -> tuple[Statement | Block, ...]:
        return tuple(statements(iter(self.tokens)))


class Table(NamedTuple):
    """Words for the number of entries, for the entries, and for the type of one."""

    size: str
    entries: str
    entry_type: str


@dataclass(frozen=True)
class Listing:
    """A filled listing. assertions: type definitions that compile only where something holds."""

    directives: tuple[str, ...]
    tables: dict[str, Table]
    functions: dict[str, Function]
    assertions: tuple[str, ...]


def read_expression(text: str) -> Expression:
    for kind, shape in EXPRESSIONS.items():
        if match := re.fullmatch(shape, text):
            return Expression(kind, match.groups())
    raise UnknownMeaning(f"this is no single operation: {text[:80]}")


def read_statement(text: str) -> Statement:
    """Return a statement from its tokens with a blank between them."""
    for kind, shape in STATEMENTS.items():
        if match := re.fullmatch(shape, text):
            parts = match.groupdict()
            value = None if parts.get("value") is None else read_expression(parts["value"])
            value_type = KINDS_OF_VALUES.get(parts.get("type") or "", "")
            is_constant = parts.get("constant") is not None
            return Statement(kind, text, parts.get("target") or "", value_type, is_constant, parts.get("index") or "", value)
    raise UnknownMeaning(f"this is no statement of one operation: {text[:80]}")


def statements(tokens: Iterator[str]) -> Iterator[Statement | Block]:
    """Yield statements and blocks up to the end of the tokens, or up to the brace that ends the block which began before them."""
    words: list[str] = []
    for token in tokens:
        if token == "}":
            break
        if token == "{":
            head, body = " ".join(words), tuple(statements(tokens))
            loop, branch = re.fullmatch(INTEGER_LOOP, head), re.fullmatch(rf"if \( ({NAME}) \)", head)
            require(bool(loop or branch), f"this is no loop over the components and no branch: {head[:80]}")
            yield (
                Block(head, body, index=loop[1], count=loop[2])
                if loop
                else Block(head, body, condition=branch[1] if branch else "")
            )
            words = []
        elif token == ";" and words.count("(") == words.count(")"):
            yield read_statement(" ".join(words))
            words = []
        else:
            words.append(token)
    require(not words, f"this statement does not end: {' '.join(words)[:80]}")


def read_parameter(text: str) -> Parameter:
    match = re.fullmatch(rf"(const )?({TYPE}) (\* )?({NAME})( \[ {PREFIX.upper()}_N \])?", text)
    require(match is not None, f"this is no parameter: {text}")
    assert match is not None
    is_constant, is_output, is_array = (match[k] is not None for k in (1, 3, 5))
    require(not (is_output and is_array) and (is_array or not is_constant), f"this is no parameter: {text}")
    passing = ("array" if is_constant else "result") if is_array else "output" if is_output else "value"
    return Parameter(KINDS_OF_VALUES[match[2]], match[4], passing)


def read_function(head: str, body: Sequence[str]) -> Function:
    match = re.fullmatch(rf"(static inline )?({TYPE}) {PREFIX}_(\w+) \( (.*) \)", head)
    require(match is not None, f"this is no function: {head[:80]}")
    assert match is not None
    parameters = tuple(read_parameter(text) for text in match[4].split(" , "))
    require(len({p.name for p in parameters}) == len(parameters), f"{match[3]} has two parameters of one name")
    return Function(match[3], head, KINDS_OF_VALUES[match[2]], parameters, tuple(body), match[1] is not None)


def read_directives(tokens: Sequence[str]) -> tuple[list[str], int]:
    """Return the directives at the beginning, one text for each, and how many tokens they have."""
    lines, begin = list[str](), 0
    while begin < len(tokens) and tokens[begin].startswith("#"):
        end = tokens.index("\n", begin)
        lines.append(" ".join(tokens[begin:end]))
        begin = end + 1
    return lines, begin


def read_listing(tokens: Sequence[str]) -> Listing:
    """Return the parts of a C file. Raises `UnknownMeaning` for a directive behind the first table, and for what is neither a table
    nor a function."""
    directives, at = read_directives(tokens)
    tables: dict[str, Table] = {}
    functions: dict[str, Function] = {}
    assertions = list[str]()
    while at < len(tokens):
        require(not tokens[at].startswith("#"), f"a directive stands behind code: {tokens[at]}")
        end = next(k for k in range(at, len(tokens)) if tokens[k] in ("{", ";"))
        head = " ".join(tokens[at:end])
        if tokens[end] == ";":
            assertions.append(head)
            at = end + 1
            continue
        close = matching_brace(tokens, end)
        body, at = tokens[end + 1 : close], close + 1
        table = re.fullmatch(rf"static const (\w+) {PREFIX}_(\w+) \[ (\w+) \] (?:{PREFIX.upper()}_FLASH )?=", head)
        if table:
            require(table[2] not in tables and len(body) == 1 and tokens[at] == ";", f"this is no table: {head}")
            tables[table[2]], at = Table(table[3], body[0], table[1]), at + 1
        else:
            function = read_function(head, body)
            require(function.name not in functions, f"there are two functions {function.name}")
            functions[function.name] = function
    return Listing(tuple(directives), tables, functions, tuple(assertions))


def matching_brace(tokens: Sequence[str], begin: int) -> int:
    """Return the index of the brace that closes the one at `begin`."""
    depth = 0
    for k in range(begin, len(tokens)):
        depth += (tokens[k] == "{") - (tokens[k] == "}")
        if depth == 0:
            return k
    raise UnknownMeaning("the braces do not match")
