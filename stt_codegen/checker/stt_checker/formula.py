"""Missions as formulas, and when a formula holds. For tasks with a mission.

A formula is ("in", region), ("out", region), ("and", f, ..), ("or", f, ..), or (operator, (from, to), f, ..) with one of the
operators always, eventually, until. "not" is moved to the regions. An interval of time is a pair, its end perhaps infinite.
"""

import math
import re
from fractions import Fraction
from typing import Any

from .exact import Unusable, decimal, number, require, vector

Formula = Any
Interval = tuple[Any, Any]
ZERO = Fraction(0)
FORMULA_LIMIT = 10_000  # parts of a formula whose negation is written out
CYCLE_LIMIT = 1_000  # of a tube that repeats, which a formula may look ahead
PRECEDENCE = ("->", "or", "and", "until")
SPELLINGS = {  # of each operator, in small letters
    "->": "implies =>", "<->": "iff <=>", "or": "|| | \\/", "and": "&& & /\\", "until": "u until_", "not": "! ~",
    "always": "g globally alw alw_", "eventually": "f finally ev ev_",
}  # fmt: skip
OPERATOR = {word: sign for sign, words in SPELLINGS.items() for word in (sign, *words.split())}
UNITS = {"s": Fraction(1), "ms": Fraction(1, 10**3), "us": Fraction(1, 10**6), "ns": Fraction(1, 10**9)}
TOKEN = r"<->|<=>|->|=>|&&|\|\||/\\|\\/|[A-Za-z]\w*|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\S"
WORDS = (*PRECEDENCE, "always", "eventually", "not", "inf")
DUAL = {"in": "out", "out": "in", "and": "or", "or": "and", "always": "eventually", "eventually": "always"}


def joined(sign: str, *parts: Formula) -> Formula:
    """Join formulas by "and" or by "or", without nesting."""
    flat = [p for part in parts for p in (part[1:] if part[0] == sign else (part,))]
    return flat[0] if len(flat) == 1 else (sign, *flat)


def negated(f: Formula) -> Formula:
    """Return a formula that holds only where f does not."""
    kind, *parts = f
    if kind in ("in", "out"):
        return (DUAL[kind], *parts)
    if kind in ("and", "or"):
        return joined(DUAL[kind], *map(negated, parts))
    if kind in ("always", "eventually"):
        return (DUAL[kind], parts[0], negated(parts[1]))
    (a, b), first, last = parts[0], negated(parts[1]), negated(parts[2])  # of f until g
    release = ("eventually", (a, a), ("until", (ZERO, b - a), last, joined("and", first, last)))
    result = joined("or", ("always", (a, b), last), ("eventually", (ZERO, a), first), release)
    if part_count(result) > FORMULA_LIMIT:
        raise Unusable("a formula has more negations of `until` than can be checked in good time")
    return result


def part_count(f: Formula) -> int:
    return 1 + sum(part_count(p) for p in f[1:] if isinstance(p, tuple) and isinstance(p[0], str))


def binary_operator(word: str) -> str:
    """Return the operator between two formulas that a word is; an empty text for none."""
    sign = OPERATOR.get(word.lower(), "")
    return sign if sign in (*PRECEDENCE, "<->") else ""


def seconds(words: list[str]) -> tuple[Fraction, str]:
    """Read a number of seconds, perhaps with a unit, and return that too."""
    value, unit = Fraction(decimal(words.pop(0))), words.pop(0) if words[0] in UNITS else ""
    return value * UNITS[unit or "s"], unit


def expect(words: list[str], *allowed: str) -> None:
    """Read one of the allowed words."""
    if words.pop(0) not in allowed:
        raise Unusable(f"a formula of the mission lacks a {allowed[0]!r}")


def window(words: list[str]) -> Interval:
    """Read [from, to]; without it the window has no end."""
    if words[0] != "[":
        return ZERO, math.inf
    words.pop(0)
    begin, first_unit = seconds(words)
    expect(words, ",", ":")
    if words[0] == "inf":
        words.pop(0)
        expect(words, "]", ")")
        return begin, math.inf
    end, last_unit = seconds(words)
    expect(words, "]")
    if begin and "" in (first_unit, last_unit) and {first_unit, last_unit} - {"", "s"}:
        raise Unusable("a formula of the mission has a window with one unit, which tools read in different ways")
    if end < begin:
        raise Unusable("a formula of the mission has a window that ends before it begins")
    return begin, end


def parse(text: Any) -> Formula:
    """Read a formula by recursive descent."""
    if not isinstance(text, str):
        raise Unusable("a formula is no text")
    words = [*re.findall(TOKEN, text), ""]

    def binary(level: int) -> Formula:
        """Read formulas joined by an operator of this level or a later one of PRECEDENCE. Chains need brackets."""
        if level == len(PRECEDENCE):
            return unary()
        signs, before, f = ("->", "<->") if level == 0 else (PRECEDENCE[level],), "", binary(level + 1)
        while (sign := binary_operator(words[0])) in signs:
            if before and sign not in ("and", "or"):
                raise Unusable(f"a formula needs brackets: (f {before} g) {words[0]} h, or f {before} (g {words[0]} h)")
            before, over = words.pop(0), window(words) if sign == "until" else None
            last = binary(level + 1)
            if level:
                f = ("until", over, f, last) if sign == "until" else joined(sign, f, last)
            else:
                forward = joined("or", negated(f), last)
                f = forward if sign == "->" else joined("and", forward, joined("or", negated(last), f))
                if part_count(f) > FORMULA_LIMIT:
                    raise Unusable("a formula has more -> and <-> than can be checked in good time")
        return f

    def unary() -> Formula:
        """Read a region, a negation, an operator of time, or what is in brackets."""
        word = words.pop(0)  # a word such as G is an operator where a formula or a window follows it, as none follows a region
        is_followed = bool(re.match(r"[A-Za-z(\[!~]", words[0])) and not binary_operator(words[0])
        sign = OPERATOR.get(word.lower()) if word in WORDS or word in ("!", "~") or is_followed else None
        if sign == "not":
            return negated(unary())
        if sign in ("always", "eventually"):
            return (sign, window(words), unary())
        if word == "(":
            f = binary(0)
            expect(words, ")")
            return f
        if not re.fullmatch(r"[A-Za-z]\w*", word) or word in PRECEDENCE:
            raise Unusable(f"the formula {text!r:.80} has {word!r} where a region is needed")
        return ("in", word)

    f = binary(0)
    expect(words, "")
    return f


def of_entry(table: Any, t_c: Fraction, repeats: bool) -> Formula:
    """Return an entry of the mission as a formula."""
    keys = {"visit": "between stay then within", "never": "before", "patrol": "every until", "formula": ""}
    forms = [k for k in keys if k in table]
    if len(forms) != 1 or not {*table} <= {forms[0], *keys[forms[0]].split()}:
        raise Unusable("the task has an entry of its mission with keys that are unknown here")
    (form,) = forms
    if form == "formula":
        return parse(table["formula"])
    if form == "never":
        out = ("out", str(table["never"]))
        is_until = "before" in table
        return ("until", (ZERO, t_c), out, ("in", str(table["before"]))) if is_until else ("always", (ZERO, math.inf), out)
    if form == "patrol":
        pause, until = number(table["every"]), number(table["until"]) if "until" in table else t_c
        if not 0 < pause <= until or not isinstance(table["patrol"], list) or not table["patrol"]:
            raise Unusable("the task has a patrol that is shorter than its rounds, or of no regions")
        over = (ZERO, math.inf if repeats and "until" not in table else until - pause)
        return joined("and", *(("always", over, ("eventually", (ZERO, pause), ("in", str(r)))) for r in table["patrol"]))
    stay, gap = number(table.get("stay", 0)), number(table["within"]) if "within" in table else t_c
    begin, end = vector(table["between"], 2) if "between" in table else (ZERO, t_c)
    visit: Formula = ("in", str(table["visit"]))
    visit = ("always", (ZERO, stay), visit) if stay else visit
    if "then" in table:
        visit = joined("and", visit, ("eventually", (stay, stay + gap), ("in", str(table["then"]))))
    if stay < 0 or not 0 <= begin <= end or gap <= 0 or ("within" in table and "then" not in table):
        raise Unusable("the task has a visit in no time, or `within` without `then`")
    return ("eventually", (begin, end), visit)


# ---- when a formula holds


def union(intervals: Any) -> list[Interval]:
    """Return intervals as disjoint ones, in order; an empty one is dropped."""
    merged: list[Interval] = []
    for a, b in sorted((a, b) for a, b in intervals if a <= b):
        if merged and a <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
        else:
            merged.append((a, b))
    return merged


def earlier(t: Any, by: Any) -> Any:
    """Return t - by, where t may be infinite."""
    return t if math.isinf(t) else t - by


class Cycle:
    """The time from `begin` to `end` of a tube that repeats it. Every time may be wrong by the margin."""

    def __init__(self, begin: Fraction, end: Fraction, margin: Fraction) -> None:
        self.begin, self.end, self.length, self.margin = begin, end, end - begin, margin

    def unrolled(self, intervals: list[Interval], until: Fraction) -> list[Interval]:
        """Repeat what is known until `end` as far as `until`, and take the margin off both ends of every interval."""
        require((until - self.end) / self.length <= CYCLE_LIMIT, "P10 does not hold: the mission looks too far ahead")
        copies, by = list(intervals), self.length
        while self.end + by - self.length < until + self.margin:
            copies += [(max(u, self.begin) + by, v + by) for u, v in intervals if v >= self.begin]
            by += self.length
        return union((u + self.margin, min(v - self.margin, until)) for u, v in union(copies))

    def horizon(self, window: Interval, until: Fraction) -> Fraction:
        """Return until when a part must be known; what holds for one cycle holds for ever."""
        a, b = window
        return max(until, self.end) + a + self.length if math.isinf(b) else until + b


def satisfied(
    f: Formula, known: dict[Formula, list[Interval]], cycle: Cycle | None = None, until: Fraction = ZERO
) -> list[Interval]:
    """Return when a formula holds, as far as it follows from when its parts are known to hold. Where the tube repeats, the answer
    is about times up to `until`, and says nothing about later ones."""
    if f in known:
        return union(known[f]) if cycle is None else cycle.unrolled(union(known[f]), until)
    kind, *parts = f
    if kind in ("in", "out"):  # nothing is claimed about it
        return []
    if kind in ("and", "or"):
        times, *more = [satisfied(p, known, cycle, until) for p in parts]
        for part in more:
            times = union(times + part if kind == "or" else [(max(a, c), min(b, d)) for a, b in times for c, d in part])
        return times
    a, b = parts[0]
    horizon = until if cycle is None else cycle.horizon((a, b), until)
    first, *more = (satisfied(p, known, cycle, horizon) for p in parts[1:])
    if kind == "always":
        is_endless = cycle is not None and math.isinf(b)
        intervals = [(earlier(u, a), earlier(math.inf if is_endless and v == horizon else v, b)) for u, v in first]
    elif kind == "eventually":
        intervals = [(earlier(u, b), earlier(v, a)) for u, v in first]
    else:
        overlaps = [(u, v, max(u, c), min(v, d)) for u, v in first for c, d in more[0]]
        intervals = [(max(u, earlier(c, b)), min(v, earlier(d, a))) for u, v, c, d in overlaps if c <= d]
    return union(intervals if cycle is None else [(u, min(v, until)) for u, v in intervals])
