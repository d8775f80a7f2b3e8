"""Missions as formulas: signal temporal logic over named regions, read from text, in negation normal form.

    always[0, 16] (dock -> eventually[0, 4] left)        not lab until[0, 24] key        eventually[3, 5] always[0, 2] dock

A formula is about a tube, the box gamma(t) of all states that it allows: `dock` holds while all of gamma(t) is in the dock,
`not dock` while all of it keeps off. What holds of the tube so holds of every trajectory in it (docs/missions.md).
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

from stt_codegen.decimals import decimal, exact_decimal

ZERO = Fraction(0)
WORDS = ("always", "eventually", "until", "and", "or", "not")
TOKEN = re.compile(r"\s*(?:(->)|([A-Za-z][A-Za-z0-9_]*)|(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|([\[\](),]))")
MOST_TEXT = 2000  # characters of a formula
MOST_NESTED = 40  # operators in one another
PRECEDENCE = ("->", "or", "and", "until")  # from what binds least


@dataclass(frozen=True)
class Interval:
    """From `begin` to `end` seconds after now; end None: for ever."""

    begin: Fraction = ZERO
    end: Fraction | None = None

    def __str__(self) -> str:
        return (
            ""
            if self == Interval()
            else f"[{exact_decimal(self.begin)}, {'inf' if self.end is None else exact_decimal(self.end)}]"
        )


class Formula:
    """A formula; `str` writes it so that it can be read again."""


@dataclass(frozen=True)
class In(Formula):
    """In a region, or, where it is `kept` off, out of it."""

    region: str
    kept: bool = False

    def __str__(self) -> str:
        return f"not {self.region}" if self.kept else self.region


@dataclass(frozen=True)
class And(Formula):
    """All of several."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' and '.join(map(str, self.parts))})"


@dataclass(frozen=True)
class Or(Formula):
    """At least one of several."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' or '.join(map(str, self.parts))})"


@dataclass(frozen=True)
class Always(Formula):
    """At all times of an interval from now."""

    over: Interval
    part: Formula

    def __str__(self) -> str:
        return f"always{self.over} {self.part}"


@dataclass(frozen=True)
class Eventually(Formula):
    """At some time of an interval from now."""

    over: Interval
    part: Formula

    def __str__(self) -> str:
        return f"eventually{self.over} {self.part}"


@dataclass(frozen=True)
class Until(Formula):
    """`last` at some time of an interval from now, and `first` from now until then, that time included."""

    over: Interval
    first: Formula
    last: Formula

    def __str__(self) -> str:
        return f"({self.first} until{self.over} {self.last})"


def both(*parts: Formula) -> Formula:
    """`And`, of one part that part."""
    flat = tuple(p for part in parts for p in (part.parts if isinstance(part, And) else (part,)))
    return flat[0] if len(flat) == 1 else And(flat)


def either(*parts: Formula) -> Formula:
    """`Or`, of one part that part."""
    flat = tuple(p for part in parts for p in (part.parts if isinstance(part, Or) else (part,)))
    return flat[0] if len(flat) == 1 else Or(flat)


def negated(formula: Formula) -> Formula:
    """A formula that holds of a trajectory only where this one does not: "not" goes down to the regions. What becomes of "until"
    asks a little more than that, where both change at one moment."""
    match formula:
        case In(region, out):
            return In(region, not out)
        case And(parts):
            return either(*map(negated, parts))
        case Or(parts):
            return both(*map(negated, parts))
        case Always(over, part):
            return Eventually(over, negated(part))
        case Eventually(over, part):
            return Always(over, negated(part))
        case Until(over, first, last):
            gone, kept, wait = negated(first), negated(last), Interval(over.begin, over.begin)
            length = None if over.end is None else over.end - over.begin
            released = Eventually(wait, Until(Interval(ZERO, length), kept, both(gone, kept)))
            return either(Always(over, kept), Eventually(Interval(ZERO, over.begin), gone), released)
    raise TypeError(formula)


def mapped(formula: Formula, leaf: Callable[[In], Formula]) -> Formula:
    """The same formula with something else in place of each region."""
    match formula:
        case In():
            return leaf(formula)
        case And(parts):
            return both(*(mapped(p, leaf) for p in parts))
        case Or(parts):
            return either(*(mapped(p, leaf) for p in parts))
        case Always(over, part):
            return Always(over, mapped(part, leaf))
        case Eventually(over, part):
            return Eventually(over, mapped(part, leaf))
        case Until(over, first, last):
            return Until(over, mapped(first, leaf), mapped(last, leaf))
    raise TypeError(formula)


def parts_of(formula: Formula) -> tuple[Formula, ...]:
    """What a formula is made of, directly."""
    match formula:
        case And(parts) | Or(parts):
            return parts
        case Always(_, part) | Eventually(_, part):
            return (part,)
        case Until(_, first, last):
            return (first, last)
    return ()


def regions_of(formula: Formula) -> Iterator[In]:
    """Every region that a formula names, as often as it does."""
    if isinstance(formula, In):
        yield formula
    for part in parts_of(formula):
        yield from regions_of(part)


def windows_of(formula: Formula) -> Iterator[Interval]:
    """Every interval that a formula gives."""
    if isinstance(formula, Always | Eventually | Until):
        yield formula.over
    for part in parts_of(formula):
        yield from windows_of(part)


def read(text: str) -> Formula:
    """The formula that a text says, in negation normal form. Raises `ValueError` with the place and what would be right."""
    if len(text) > MOST_TEXT:
        raise ValueError(f"has {len(text)} characters; at most {MOST_TEXT} are taken, use several entries")
    return _Reader(text).whole()


class _Reader:
    """A reader by descent: each method reads what its name says and leaves the place behind it."""

    def __init__(self, text: str) -> None:
        self.text, self.words, self.at, self.depth = text, list(self._tokens(text)), 0, 0

    @staticmethod
    def _tokens(text: str) -> Iterator[tuple[str, int]]:
        place = 0
        while text[place:].strip():
            found = TOKEN.match(text, place)
            if found is None:
                rest = text[place:].lstrip()
                place = len(text) - len(rest)
                raise ValueError(
                    f"{rest[:12]!r} at character {place + 1} is no word of a formula; regions, {', '.join(WORDS)} are"
                )
            yield found.group().strip(), found.end() - len(found.group().strip())
            place = found.end()

    @property
    def word(self) -> str:
        return self.words[self.at][0] if self.at < len(self.words) else ""

    def fail(self, wanted: str) -> ValueError:
        if self.at >= len(self.words):
            return ValueError(f"ends where {wanted} is needed")
        before = self.words[self.at - 1][0] if self.at else ""
        close = difflib.get_close_matches(before.lower(), ("always", "eventually", "until"), 1) if before not in WORDS else []
        if self.word == "[" and before:
            return ValueError(
                f"has a window after {before!r}, which is no operator" + (f"; did you mean {close[0]!r}?" if close else "")
            )
        return ValueError(f"has {self.word!r} at character {self.words[self.at][1] + 1}, where {wanted} is needed")

    def need(self, word: str) -> None:
        if self.word != word:
            raise self.fail(repr(word))
        self.at += 1

    def whole(self) -> Formula:
        found = self.binary(0)
        if self.at < len(self.words):
            raise self.fail("the end, or one of and, or, until, ->,")
        return found

    def binary(self, level: int) -> Formula:
        """What is joined by the operators of PRECEDENCE from `level` on."""
        self.depth += 1
        if self.depth > MOST_NESTED * (len(PRECEDENCE) + 1):
            raise ValueError(f"is nested more than {MOST_NESTED} deep; use several entries")
        if level == len(PRECEDENCE):
            found = self.unary()
        else:
            sign, found = PRECEDENCE[level], self.binary(level + 1)
            while self.word == sign:
                self.at += 1
                if sign == "->":  # a -> b -> c is a -> (b -> c)
                    found = either(negated(found), self.binary(level))
                elif sign == "until":
                    found = Until(self.interval(), found, self.binary(level + 1))
                else:
                    found = (both if sign == "and" else either)(found, self.binary(level + 1))
        self.depth -= 1
        return found

    def unary(self) -> Formula:
        word = self.word
        if word in ("not", "always", "eventually"):
            self.at += 1
            if word == "not":
                return negated(self.binary(len(PRECEDENCE)))
            over = self.interval()
            return (Always if word == "always" else Eventually)(over, self.binary(len(PRECEDENCE)))
        if word == "(":
            self.at += 1
            found = self.binary(0)
            self.need(")")
            return found
        if not re.fullmatch(r"[A-Za-z]\w*", word) or word in WORDS:
            raise self.fail("a region, a bracket, not, always or eventually")
        self.at += 1
        return In(word)

    def interval(self) -> Interval:
        if self.word != "[":
            return Interval()
        self.at += 1
        begin = self.number()
        self.need(",")
        if self.word == "inf":
            self.at += 1
            end = None
        else:
            end = self.number()
        self.need("]")
        if end is not None and end < begin:
            raise ValueError(f"has a window from {decimal(begin)} to {decimal(end)}; from must not be after to")
        return Interval(begin, end)

    def number(self) -> Fraction:
        if not self.word[:1].isdigit():
            raise self.fail("a number of seconds")
        self.at += 1
        value = Decimal(self.words[self.at - 1][0])
        if value and not -10 < value.adjusted() < 10:
            raise ValueError(f"has the number {value}; use 0 or seconds from 1e-9 to 1e9")
        return Fraction(value)
