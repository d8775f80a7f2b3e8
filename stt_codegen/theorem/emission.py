"""Print what proof/Emission.v and proof/Read.v have of the emitted C from the checker's listing, in Coq's syntax.

    python -m stt_codegen.theorem.emission        # writes both files again, between the comments that mark what is printed

The stand-alone checker requires that a C file is listing_controller.c with the numbers of its task. The theorems are about the
same text: between the marks is the listing for order 1, one definition for each function and for each piece of a body. A number
of the listing becomes a constant of the record `constants` in Emission.v, and a condition becomes an `if` on it.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from stt_codegen.checker.stt_checker.source import pieces
from stt_codegen.theorem.coq import library_folder

MARKS = ("(* Printed from the checker's listing: *)\n", "(* End of what is printed. *)\n")
FUNCTION_PIECES = (
    "segment of a time",
    "segment of a tick",
    "basis",
    "edge",
    "error transform and law",
    "tube",
    "control",
    "control at a tick",
)
SKIPPED_FUNCTIONS = ("normalized_error",)  # no theorem is about it
SKIPPED_CONDITIONS = {"order 2", "scaled", "differences"}  # no theorem is about such a C
UNCONDITIONAL = {"order 1", "ticks"}  # `emitted_functions` leaves out the functions of ticks
CONDITIONS = {  # of a line: a definition of Emission.v, and what it is where the line is there
    "inline": ("has_inline_log", True), "libm": ("has_inline_log", False), "gains": ("gains_differ", True),
    "one gain": ("gains_differ", False), "clamps": ("clamp_shares_differ", True), "one clamp": ("clamp_shares_differ", False),
    "limits": ("has_limits", True), "no limits": ("has_limits", False),
    "float": ("is_single", True), "double": ("is_single", False),
}  # fmt: skip
TYPES = {"P_real": "TReal", "int32_t": "TInt", "bool": "TBool", "uint32_t": "TUnsigned"}
RESULTS = {"void": "void", "P_real": "@real", "P_status": "@status"}
OPERATORS = {"+": "Plus", "-": "Minus", "*": "Times", "/": "Divide", "<": "Less", "<=": "AtMost"}
OPERANDS = {
    "0.0": "RealLiteral literal_zero", "1.0": "RealLiteral literal_one", "2.0": "RealLiteral literal_two",
    "3.0": "RealLiteral literal_three", "true": "BoolLiteral true", "false": "BoolLiteral false", "(P_real)NAN": "NotANumber",
    "M_OK": "IntLiteral 0", "M_OUTSIDE_TUBE": "IntLiteral 1", "M_BAD_INPUT": "IntLiteral 2",
    "$per_second": "RealLiteral (time_rate consts)", "$last": "RealLiteral (last_spline_time consts)",
    "$gain": "RealLiteral (gain_lower consts)", "$gain_minus": "RealLiteral (gain_upper consts)",
    "$smallest_share": "RealLiteral (clamp_share consts)", "$bend": "RealLiteral log_coefficient", "$ln_2": "RealLiteral ln_two",
    "$pairs": "IntLiteral (2 * dimensions consts)", "$row_1": "IntLiteral (2 * dimensions consts)",
    "$row_2": "IntLiteral (4 * dimensions consts)", "$row_3": "IntLiteral (6 * dimensions consts)",
    "$ticksU": "UnsignedLiteral (tick_limit c)", "$tick_num": "IntLiteral (tick_multiplier c)",
    "$tick_den": "IntLiteral (tick_divisor c)", "$tick_end": "IntLiteral (tick_divisor c * tick_segments c)",
    "$last_segment": "IntLiteral (tick_segments c - 1)", "$tick_real": "RealLiteral (tick_divisor_real c)",
}  # fmt: skip


Condition = tuple[str, bool] | None  # a definition of Emission.v with the value that it needs; None for lines of every C
Lines = Iterator[tuple[Condition, str]]


class Item(NamedTuple):
    """A statement in Coq's syntax, or where is_list is set the name of a definition that has several."""

    condition: Condition
    text: str
    is_list: bool = False


def operand(word: str) -> str:
    """Return a variable or a literal as a term of `operand` of proof/Syntax.v."""
    return OPERANDS.get(word) or (f"IntLiteral {word}" if word.isdigit() else f'Var "{name(word)}"')


def bracketed(*words: str) -> str:
    """Return operands as arguments of a constructor."""
    return " ".join(f"({term})" if " " in term else term for term in map(operand, words))


def name(word: str) -> str:
    """Return a name of the C with @ for the task's name. Raises `ValueError` for what is no name."""
    if not re.fullmatch(r"[A-Za-z]\w*", word):
        raise ValueError(f"the listing has {word!r} where proof/Emission.v needs a name")
    return re.sub(r"^P_", "@", word)


def expression(text: str) -> str:
    """Return the right side of an assignment as a term of `expression` of proof/Syntax.v."""
    if text in OPERANDS or re.fullmatch(r"[\w$.]+", text):
        return f"Operand {bracketed(text)}"
    if match := re.fullmatch(r"isfinite\((\w+)\) != 0", text):
        return f"IsFinite {bracketed(match[1])}"
    if match := re.fullmatch(r"(\S+?)\(([^()]*)\)", text):
        function = "(log_name consts)" if match[1] == "$log" else f'"{name(match[1])}"'
        return f"CallFunction {function} [{'; '.join(map(operand, match[2].split(', ')))}]"
    if match := re.fullmatch(r"(\S+) \? (\S+) : (\S+)", text):
        return f"Select {bracketed(*match.groups())}"
    if match := re.fullmatch(r"(\S+) (\S+) (\S+)", text):
        return f"Binary {OPERATORS[match[2]]} {bracketed(match[1], match[3])}"
    if match := re.fullmatch(r"([-!])(\w+)", text):
        return f"{'Not' if match[1] == '!' else 'Negate'} {bracketed(match[2])}"
    if match := re.fullmatch(r"\((\w+)\)(\w+)", text):
        return f"Cast {TYPES[match[1]]} {bracketed(match[2])}"
    if match := re.fullmatch(r"(\w+)\[(\w+)\]", text):
        return f'Load "{name(match[1])}" {bracketed(match[2])}'
    raise ValueError(f"the listing has {text!r}, which proof/Syntax.v does not have")


def statement(text: str) -> str:
    """Return a statement that is one line of the listing as a term of `statement` of proof/Syntax.v."""
    if match := re.fullmatch(r"return( .+)?;", text):
        return f"Return (Some ({expression(match[1].strip())}))" if match[1] else "Return None"
    if match := re.fullmatch(r"(?:const )?(\w+) (\w+) = (.+);", text):
        return f'Let {TYPES[match[1]]} "{name(match[2])}" ({expression(match[3])})'
    if match := re.fullmatch(r"(\w+) (\w+);", text):
        return f'Declare {TYPES[match[1]]} "{name(match[2])}"'
    if match := re.fullmatch(r"(\*?)(\w+) = (.+);", text):
        return f'{"AssignResult" if match[1] else "Assign"} "{name(match[2])}" ({expression(match[3])})'
    if match := re.fullmatch(r"(\w+)\[(\w+)\] = (.+);", text):
        return f'Store "{name(match[1])}" {bracketed(match[2])} ({expression(match[3])})'
    if match := re.fullmatch(r"(\w+)\((.*)\);", text):
        arguments = match[2].split(", ")
        inputs = "; ".join(operand(word) for word in arguments if word[0] != "&")
        outputs = "; ".join(f'"{name(word[1:])}"' for word in arguments if word[0] == "&")
        return f'CallKernel "{name(match[1])}" [{inputs}] [{outputs}]'
    raise ValueError(f"the listing has {text!r}, which proof/Syntax.v does not have")


def conditional_lines(piece: str) -> Lines:
    """Yield the lines of a piece that a C of order 1 may have, each with its condition. A piece within it whose brackets do not
    close in it is yielded in place."""
    for line in pieces()[piece]:
        text, _, words = line.removesuffix("]").partition("  [") if line.endswith("]") else (line, "", "")
        conditions = {*words.split(", ")} - UNCONDITIONAL - {""}
        if conditions & SKIPPED_CONDITIONS:
            continue
        condition = CONDITIONS[conditions.pop()] if conditions else None
        inner = re.fullmatch(r" *<<(.+)>>", text)
        if inner and not is_closed(inner[1]):
            yield from conditional_lines(inner[1])
        elif text:
            yield condition, text.strip()


def is_closed(piece: str) -> bool:
    text = "\n".join(pieces()[piece])
    return text.count("{") == text.count("}")


def block(lines: Lines) -> list[Item]:
    """Return the statements up to the bracket that closes the block, or to the end."""
    items = list[Item]()
    for condition, text in lines:
        if text == "}":
            break
        if text.startswith("/*"):
            continue
        if inner := re.fullmatch(r"<<(.+)>>", text):
            items.append(Item(condition, definition_name(inner[1]), is_list=True))
        elif loop := re.fullmatch(r"for \(int32_t (\w+) = 0; \1 < \$n; \+\+\1\) \{", text):
            items.append(Item(condition, f'For "{loop[1]}" (dimensions consts) ({inner_block(lines)})'))
        elif test := re.fullmatch(r"if \((\w+)\) \{", text):
            items.append(Item(condition, f"IfTrue {bracketed(test[1])} ({inner_block(lines)})"))
        else:
            items.append(Item(condition, statement(text)))
    return items


def inner_block(lines: Lines) -> str:
    return joined(block(lines)).replace("\n", "\n  ")


def joined(items: list[Item]) -> str:
    """Return one list of Coq from statements, lists and conditions."""
    parts = list[tuple[Condition, str]]()
    for (condition, is_list), group in itertools.groupby(items, lambda item: (item.condition, item.is_list)):
        texts = [item.text for item in group]
        parts.append((condition, " ++ ".join(texts) if is_list else "[\n    " + ";\n    ".join(texts) + "]"))
    terms = list[str]()
    while parts:
        condition, text = parts.pop(0)
        if condition is not None:
            word, value = condition
            has_alternative = bool(parts) and parts[0][0] == (word, not value)  # the lines where the condition is false follow
            texts = [text, parts.pop(0)[1] if has_alternative else "[]"]
            text = "(if {} consts then {} else {})".format(word, *(texts if value else reversed(texts)))
        terms.append(text)
    return " ++ ".join(terms)


def definition_name(piece: str) -> str:
    return f"{piece.replace(' ', '_')}_statements"


def inner_pieces(piece: str) -> Iterator[str]:
    """Yield the pieces that become definitions of their own and are used in this one, each after those that it uses."""
    for _, text in conditional_lines(piece):
        if inner := re.fullmatch(r"<<(.+)>>", text):
            yield from inner_pieces(inner[1])
            yield inner[1]


def functions(piece: str) -> Iterator[str]:
    """Yield the definitions of a piece's functions."""
    lines, comment = conditional_lines(piece), ""
    for _, text in lines:
        if text.startswith("/*"):
            comment = f"  (*{text[2:-2]}*)\n"
            continue
        match = re.fullmatch(r"(?:static inline )?(\w+) P_(\w+)\((.+)\)", text)
        if match is None or next(lines, (None, ""))[1] != "{":
            raise ValueError(f"the listing has {text!r} where a function begins")
        result, function, parameters = match.groups()
        body = joined(block(lines))
        if function in SKIPPED_FUNCTIONS:
            continue
        ticks = " (c : tick_numbers)" if " c)" in body else ""
        header = f'"@{function}" "{RESULTS[result]}" [{"; ".join(map(parameter, parameters.split(", ")))}]'
        yield f"{comment}  Definition {function}_function{ticks} := Function {header} ({body}).\n"
        comment = ""


def parameter(text: str) -> str:
    """Return a parameter of a function as a term of `parameter` of proof/Syntax.v."""
    if match := re.fullmatch(r"(const )?P_real (\w+)\[M_N\]", text):
        return f'{"ArrayIn" if match[1] else "ArrayOut"} "{match[2]}"'
    kind, _, label = text.partition(" ")
    return f'{"ByPointer" if label[0] == "*" else "ByValue"} {TYPES[kind]} "{name(label.lstrip("*"))}"'


def printed_functions() -> str:
    """Return the definitions of the functions of a C of order 1 and of the pieces in their bodies."""
    definitions = dict[str, None]()  # in order, each once
    for piece in FUNCTION_PIECES:
        for inner in inner_pieces(piece):
            definitions[f"  Definition {definition_name(inner)} := {joined(block(conditional_lines(inner)))}.\n"] = None
        definitions.update(dict.fromkeys(functions(piece)))
    return "".join(definitions)


def printed_directives() -> str:
    """Return the definition of the directives that a C file must have, each as it stands in its line."""
    values = {"scalar": '(if is_single consts then "float" else "double")', "": "task"}
    lines = [line for piece in ("controller", "compiler flags") for line in conditional_lines(piece) if line[1].startswith("#")]
    items = [Item(condition, coq_text(text, values)) for condition, text in lines]
    return f"  Definition expected_directives (task : string) : list string := {joined(items)}.\n"


def printed_helpers() -> str:
    """Return the definitions of three texts, for a task named p: the check of a number's size, and the functions that take its
    exponent and mantissa from its bits."""
    text = " ".join(text for _, text in conditional_lines("exponent and mantissa") if not text.startswith("/*"))
    parts = re.split(r" (?=static inline )", re.sub(r"\bP_", "p_", text))
    definitions = []
    for helper, part in zip(("size_check", "exponent_helper", "mantissa_helper"), parts, strict=True):
        holes = list(dict.fromkeys(re.findall(r"\$([a-z]+)", part)))
        text = coq_text(part, {hole: hole for hole in holes})
        definitions.append(f"Definition {helper}_text ({' '.join(holes)} : string) : string := {text}.\n")
    return "".join(definitions)


def coq_text(text: str, values: dict[str, str]) -> str:
    """Return a text of the listing as a string of Coq.

    values: terms for the names after $, and under "" one for the task's name."""
    quoted = text.replace('"', '""')
    term = re.sub(r"\$([a-z]+)|\bP(?=[_.])", lambda hole: f'" ++ {values[hole[1] or ""]} ++ "', quoted)
    return f'("{term}")%string' if term != quoted else f'"{quoted}"'


def printed(text: str, parts: str) -> str:
    """Return the text of a file of proof/ with these parts between its marks. Raises `ValueError` where it has no marks."""
    before, begin, rest = text.partition(MARKS[0])
    _, end, after = rest.partition(MARKS[1])
    if not begin or not end:
        raise ValueError("a file of proof/ lacks the comments between which the listing is printed")
    return f"{before}{begin}{parts}{end}{after}"


def printed_files() -> dict[Path, str]:
    """Return the files of proof/ that have parts of the listing, with these parts as they are to be."""
    parts = {"Emission.v": printed_directives() + printed_functions(), "Read.v": printed_helpers()}
    return {library_folder() / file: printed((library_folder() / file).read_text(), text) for file, text in parts.items()}


if __name__ == "__main__":
    for path, file_text in printed_files().items():
        path.write_text(file_text)
