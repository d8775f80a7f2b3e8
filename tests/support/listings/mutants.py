"""Wrong listings: one sign, comparison, choice, name or number of one statement is another one.

A mutant compiles in most cases. It should be noticed by whoever says what the listings mean, unless it means the same.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from random import Random
from typing import NamedTuple

from stt_codegen.checker.stt_checker import source
from tests.support.listings.changes import changed_pieces

SIGNS = {" + ": " - ", " - ": " + ", " * ": " + ", " / ": " * ", " < ": " <= ", " <= ": " < "}
NUMBERS = {"0.0": "0.5", "0.5": "0.25", "1.0": "2.0", "2.0": "1.0", "3.0": "2.0", "true": "false", "false": "true"}
LOCAL = re.compile(r"(?<![\w$.&])(?!P_|M_|true\b|false\b|return\b|NAN\b|isfinite\b|int32_t\b)[a-z]\w*\b(?!\()")
ARITHMETIC = "arithmetic of integers"
CALLS = {"shift_down": "shift_up", "shift_up": "shift_down", "product": "high_product", "high_product": "product"}
HOLE, INTEGER = re.compile(r"\$([a-z]\w*?)(?=U?\b)"), re.compile(r"(?<![\w.$])(?:0x[0-9a-f]+|\d+)(?=U?(?![\w.]))")
ARITHMETIC_SIGNS = {" & ": " | ", " << ": " >> ", " >> ": " << ", "<<=": ">>=", ">>=": "<<=", " >= ": " > ", " > ": " >= ", " += ": " -= ",
                    " &= ": " |= ", " || ": " && ", " && ": " || ", " != ": " == "}  # fmt: skip
DECLARED = re.compile(r"(?:const )?(P_real|int32_t|bool) (?:\*)?(\w+)(?: = |;|,|\))")


class Mutant(NamedTuple):
    """A line of a piece, and what stands there in its place."""

    heading: str
    number: int
    line: str
    replacement: str

    def __str__(self) -> str:
        return f"{self.heading}: {self.line.strip()} -> {self.replacement.strip()}"

    def notices(self, check: Callable[[], object]) -> bool:
        """Whether a check fails with the changed listing, or cannot read it: such a mutant does not compile either."""
        lines = [*source.pieces()[self.heading]]
        lines[self.number] = self.replacement
        with changed_pieces({self.heading: lines}):
            try:
                check()
            except Exception:
                return True
        return False


def headings(first: str) -> list[str]:
    """Return the headings of all pieces in a file's listing, in their order."""
    reached, pending = list[str](), [first]
    while pending:
        heading = pending.pop(0)
        if heading not in reached:
            reached.append(heading)
            pending += [name for line in source.pieces()[heading] for name in re.findall(r"^ *<<(.+)>>", line)]
    return reached


def types_of_names(heading: str) -> dict[str, str]:
    """Return the types of the names that a piece declares, functions of several components together."""
    text = "\n".join(source.pieces()[heading])
    return {name: value_type for value_type, name in DECLARED.findall(text)}


def mutants(first: str = "controller") -> Iterator[Mutant]:
    """Yield all mutants of a file's listing, the same in each run."""
    are_integers = first == "integer controller"
    types_of_all = {name: value_type for heading in headings(first) for name, value_type in types_of_names(heading).items()}
    for heading in headings(first):
        types = types_of_names(heading)
        for number, line in enumerate(source.pieces()[heading]):
            statement, tail = re.fullmatch(r"(.*?)((?:  \[.*\])?)", line).groups()  # type: ignore[union-attr]
            formula, unchanged = (
                (r" = |return |[<>&]", "__asm__") if heading == ARITHMETIC else (r" = |return |^ *P_\w+\(", r"\bfor \(")
            )
            if not re.search(formula, statement) or re.search(rf"/\*|#|{unchanged}", statement):
                continue
            random = Random(f"{heading} {statement}")
            if are_integers:
                names = names_near(heading, number)
                types = {name: value_type for name, value_type in types_of_all.items() if name in names}
            replacements = {*changed_statements(statement, types, random)} - {statement}
            if are_integers:
                replacements = {
                    text
                    for text in {*replacements, *changed_integers(statement, heading, random)}
                    if is_well_formed(text, statement)
                }
            yield from (Mutant(heading, number, line, text + tail) for text in sorted(replacements))


def changed_statements(statement: str, types: dict[str, str], random: Random) -> Iterator[str]:
    """Yield a statement with another sign, number, order of operands or names of the same type."""
    target, equals, formula = statement.rpartition(" = ") if " = " in statement else ("", "", statement)
    for old, new in SIGNS.items():
        if old in formula:
            yield target + equals + formula.replace(old, new, 1)
    for old, new in NUMBERS.items():
        if re.search(rf"(?<![\w.]){re.escape(old)}\b", formula):
            yield target + equals + re.sub(rf"(?<![\w.]){re.escape(old)}\b", new, formula, count=1)
    if choice := re.search(r"\? (.+) : (.+);", formula):
        yield target + equals + formula.replace(choice[0], f"? {choice[2]} : {choice[1]};")
    if comparison := re.fullmatch(r"(.+) (<|<=|-|/) (.+);", formula):
        yield f"{target}{equals}{comparison[3]} {comparison[2]} {comparison[1]};"
    for match in LOCAL.finditer(formula):
        name = match.group()
        same_type = sorted(v for v, value_type in types.items() if value_type == types.get(name) and v != name)
        if same_type and types.get(name):
            changed = formula[: match.start()] + random.choice(same_type) + formula[match.end() :]
            yield target + equals + changed


def names_near(heading: str, number: int) -> set[str]:
    """Return the names in a piece; of the arithmetic of integers those in the function of a line, as a blank line ends it."""
    lines = source.pieces()[heading]
    if heading == ARITHMETIC:
        begin = max(k for k in range(number + 1) if not lines[k] or k == 0)
        lines = lines[begin : next(k for k in range(number, len(lines) + 1) if k == len(lines) or not lines[k])]
    return {*re.findall(r"[a-z]\w*", "\n".join(lines))}


def is_well_formed(text: str, statement: str) -> bool:
    """Whether a changed statement has its brackets in order, where it is another one."""
    nesting = [re.match(r" *", v)[0] + re.sub(r"[^](){}[;?:]", "", v) for v in (text, statement)]  # type: ignore[index]
    return text != statement and nesting[0] == nesting[1]


def changed_integers(statement: str, heading: str, random: Random) -> Iterator[str]:
    """Yield a statement of a listing in integers with another whole number, hole, operation or order of its operands."""
    begin = statement.find(" = ") if " = " in statement else 0
    for match in INTEGER.finditer(statement, begin):
        number = int(match[0], 0) + 1
        yield statement[: match.start()] + (hex(number) if "x" in match[0] else str(number)) + statement[match.end() :]
    holes = sorted({*HOLE.findall("\n".join(source.pieces()[heading]))} | {"n", "pairs"})
    for match in HOLE.finditer(statement, begin):
        name = random.choice([v for v in holes if v != match[1]])
        yield f"{statement[: match.start()]}${name}{statement[match.end() :]}"
    for match in re.finditer(r"P_(\w+)\(", statement):
        if match[1] in CALLS:
            yield f"{statement[: match.start()]}P_{CALLS[match[1]]}({statement[match.end() :]}"
    if match := re.search(r"(P_\w+\(.*?)([\w&$]+), ([\w&$]+)(.*)", statement):
        yield f"{statement[: match.start()]}{match[1]}{match[3]}, {match[2]}{match[4]}"
    if heading == ARITHMETIC:
        for old, new in ARITHMETIC_SIGNS.items():
            for match in re.finditer(re.escape(old), statement):
                yield statement[: match.start()] + new + statement[match.end() :]


def combinations_with(mutant: Mutant, combinations: Sequence[set[str]], first: str = "controller") -> list[set[str]]:
    """Return the combinations of options in which the mutant's line stands."""
    statement, tail = re.fullmatch(r"(.*?)((?:  \[.*\])?)", mutant.line).groups()  # type: ignore[union-attr]
    lines = [*source.pieces()[mutant.heading]]
    lines[mutant.number] = f"{statement} /* marked */{tail}"
    with changed_pieces({mutant.heading: lines}):
        return [o for o in combinations if any(line.endswith("/* marked */") for line in source.chosen_lines(first, o))]
