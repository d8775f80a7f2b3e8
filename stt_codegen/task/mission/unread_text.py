"""What other tools write and no formula here has, with messages that say what to write instead. grammar.py calls this."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.task.mission.formulas import ZERO

PAST = "is about the past; a formula is about times to come, from now on: eventually[a, b], always[a, b]"
EDGE = "asks for the moment at which a region is {}, which is about the past; `always ({} -> f)` asks for f there too"
WEAK_UNTIL = (
    "is no operator here; for `f {0} g` write (f until g) or always f, for `f {0}[a, b] g` (f until[a, b] g) or always[0, b] f"
)
# Operators of other tools, by their small letters, that have no synonym here, and what to write instead.
UNREAD_PREFIXES = {
    **dict.fromkeys(("next", "x"), "asks for a next step; time is continuous here: write eventually[a, b]"),
    **dict.fromkeys(("once", "historically", "previous", "prev"), PAST),
    "rise": EDGE.format("entered", "A"),
    "fall": EDGE.format("left", "not A"),
}
UNREAD_BINARY = {
    **dict.fromkeys(("release", "r"), "is no operator here; for `f release g` write not (not f until not g)"),
    **{word: WEAK_UNTIL.format(name) for word, name in (("w", "W"), ("weak_until", "weak_until"), ("unless", "unless"))},
    **dict.fromkeys(("xor", "^"), "is no operator here; for `f xor g` write (f and not g) or (not f and g)"),
    **dict.fromkeys(("since", "s"), PAST),
}
COMPARISON = re.compile(r"\s*(?:!=|[<>=+*/-])")
ASSIGNMENT = re.compile(r"\s*([A-Za-z]\w*\s*:?=)(?![=>])(?=\s*[A-Za-z(!~])(?!\s*\w+\s*(?:[+*]|-(?!>)|/(?!\\)))")
# What ends a comparison of numbers on either side, where it stands within a formula.
BOUNDARY = re.compile(
    r"[()\[\];]|&&?|\|\|?|/\\|\\/|<->|->|<=>|=>|!(?!=)|~"
    r"|\b(?:and|or|not|implies|iff|always|eventually|until_?|globally|finally|alw_?|ev_?)\b|\b[GFU](?=\s+-?[\w(])",
    re.IGNORECASE,
)
TERM = re.compile(r"\s*([+-]?)\s*(?:(\d{1,15}(?:\.\d{1,15})?)\s*(?:\*\s*)?)?([A-Za-z]\w*)?\s*")
CHAIN_TEXT_LIMIT = 300  # characters of a chain of which a message shows all operands


def require_no_assignment(text: str) -> None:
    """Raise `ValueError` where a formula has a name before it or a semicolon behind it, as lines of other tools have."""
    if assignment := ASSIGNMENT.match(text):
        raise ValueError(f"begins with {assignment[1]!r}, and a formula has no name here; leave `{assignment[1]}` out")
    if ";" in text:
        is_last = text.rstrip().endswith(";") and text.count(";") == 1
        remedy = "leave it out" if is_last else "use an entry for each formula"
        raise ValueError(f"has ';' at character {text.index(';') + 1}; {remedy}")


def unread_character(text: str, position: int) -> ValueError:
    """Return the error about a character that no formula has. position: of its first character, from 0."""
    rest = text[position:]
    where = f"{rest[:12]!r} at character {position + 1}"
    if rest[0] in UNREAD_BINARY:
        return ValueError(f"{rest[0]!r} at character {position + 1} {UNREAD_BINARY[rest[0]]}")
    if not COMPARISON.match(rest):
        words = "regions, always, eventually, until, and, or, not"
        return ValueError(f"{where} is no word of a formula; {words} are")
    problem = f"{where} compares numbers, and a formula is about regions: add one, as [[region]] with "
    comparison = _comparison_at(text, position)
    lines = _half_space(comparison)
    example = 'axes = ["x", "y"], normals = [[1, 1]] and offsets = [3] for x + y <= 3, or with lower and upper'
    remedy = f"{lines} for {comparison}" if lines else example
    return ValueError(f"{problem}{remedy}, and write its name")


def _comparison_at(text: str, position: int) -> str:
    """Return the comparison of numbers around a position: the text between the operators and brackets on either side."""
    begin = max((m.end() for m in BOUNDARY.finditer(text) if m.end() <= position), default=0)
    end = min((m.start() for m in BOUNDARY.finditer(text) if m.start() > position), default=len(text))
    return text[begin:end].strip()


def _half_space(comparison: str) -> str:
    """Return the lines of a region in which a comparison holds, such as x + 2*y >= 3; empty where it is not linear."""
    sides = re.split(r"(<=|>=|<|>)", comparison)
    if len(sides) != 3:
        return ""
    left, right = _linear_terms(sides[0]), _linear_terms(sides[2])
    if left is None or right is None:
        return ""
    sign = 1 if sides[1].startswith("<") else -1  # a region is below its offsets
    terms = {name: sign * (left.get(name, ZERO) - right.get(name, ZERO)) for name in (*left, *right)}
    offset = -terms.pop("", ZERO)
    if not any(terms.values()):
        return ""
    names = ", ".join(f'"{name}"' for name in terms)
    return f"axes = [{names}], normals = [[{', '.join(map(decimal, terms.values()))}]] and offsets = [{decimal(offset)}]"


def _linear_terms(side: str) -> dict[str, Fraction] | None:
    """Return the factor of each name in a sum, that of "" being the number without a name; None for what is no such sum."""
    factors: dict[str, Fraction] = {}
    position = 0
    if re.search(r"\d[eE][+-]?\d", side):
        return None
    while position < len(side):
        term = TERM.match(side, position)
        if term is None or not (term[2] or term[3]) or (position and not term[1]):
            return None
        factor = Fraction(term[2] or 1) * (-1 if term[1] == "-" else 1)
        factors[term[3] or ""] = factors.get(term[3] or "", ZERO) + factor
        position = term.end()
    return factors or None


def chain_error(text: str, operands: Sequence[tuple[int, int]], operators: Sequence[str]) -> ValueError:
    """Return the error about a chain of ->, <-> or until without brackets, which tools read in different ways.

    operands: begin and end of each in the text; operators: those between them, with their windows, one fewer.
    """
    begin, end = operands[0][0], operands[-1][1]
    is_cut = end - begin > CHAIN_TEXT_LIMIT
    parts = [text[a:b] for a, b in operands[: 3 if is_cut else None]]
    from_left, from_right = parts[0], parts[-1]
    for k, (operator, part) in enumerate(zip(operators, parts[1:], strict=False)):
        from_left = f"{f'({from_left})' if k else from_left} {operator} {part}"
    for k, (operator, part) in enumerate(reversed(list(zip(operators, parts[:-1], strict=False)))):
        from_right = f"{part} {operator} {f'({from_right})' if k else from_right}"
    rest = " .." if is_cut else ""
    return ValueError(
        f"has {' and '.join(dict.fromkeys(operator.partition('[')[0] for operator in operators))} in a chain without brackets at "
        f"character {begin + 1}, which tools read in different ways; write {from_left}{rest} or {from_right}{rest}"
    )
