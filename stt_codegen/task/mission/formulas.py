"""Missions as formulas: signal temporal logic over named regions, in negation normal form. grammar.py reads them.

    always[0, 16] (dock -> eventually[0, 4] left)        not lab until[0, 24] key        eventually[3, 5] always[0, 2] dock

A formula is about a tube, the box gamma(t) of all states that it allows: `dock` holds while all of gamma(t) is in the dock,
`not dock` while all of it keeps off. What holds of the tube so holds of every trajectory in it (docs/missions.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.decimals import exact_decimal

ZERO = Fraction(0)
WORDS = ("always", "eventually", "until", "and", "or", "not")


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
class InRegion(Formula):
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


def conjunction(*parts: Formula) -> Formula:
    """`And`, of one part that part."""
    flat = tuple(p for part in parts for p in (part.parts if isinstance(part, And) else (part,)))
    return flat[0] if len(flat) == 1 else And(flat)


def disjunction(*parts: Formula) -> Formula:
    """`Or`, of one part that part."""
    flat = tuple(p for part in parts for p in (part.parts if isinstance(part, Or) else (part,)))
    return flat[0] if len(flat) == 1 else Or(flat)


def negation(formula: Formula) -> Formula:
    """A formula that holds of a trajectory only where this one does not: "not" goes down to the regions. What becomes of "until"
    asks a little more than that, where both change at one moment."""
    match formula:
        case InRegion(region, out):
            return InRegion(region, not out)
        case And(parts):
            return disjunction(*map(negation, parts))
        case Or(parts):
            return conjunction(*map(negation, parts))
        case Always(over, part):
            return Eventually(over, negation(part))
        case Eventually(over, part):
            return Always(over, negation(part))
        case Until(over, first, last):
            gone, kept, wait = negation(first), negation(last), Interval(over.begin, over.begin)
            length = None if over.end is None else over.end - over.begin
            released = Eventually(wait, Until(Interval(ZERO, length), kept, conjunction(gone, kept)))
            return disjunction(Always(over, kept), Eventually(Interval(ZERO, over.begin), gone), released)
    raise TypeError(formula)


def replace_regions(formula: Formula, leaf: Callable[[InRegion], Formula]) -> Formula:
    """The same formula with something else in place of each region."""
    match formula:
        case InRegion():
            return leaf(formula)
        case And(parts):
            return conjunction(*(replace_regions(p, leaf) for p in parts))
        case Or(parts):
            return disjunction(*(replace_regions(p, leaf) for p in parts))
        case Always(over, part):
            return Always(over, replace_regions(part, leaf))
        case Eventually(over, part):
            return Eventually(over, replace_regions(part, leaf))
        case Until(over, first, last):
            return Until(over, replace_regions(first, leaf), replace_regions(last, leaf))
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


def regions_of(formula: Formula) -> Iterator[InRegion]:
    """Every region that a formula names, as often as it does."""
    if isinstance(formula, InRegion):
        yield formula
    for part in parts_of(formula):
        yield from regions_of(part)


def intervals_of(formula: Formula) -> Iterator[Interval]:
    """Every interval that a formula gives."""
    if isinstance(formula, Always | Eventually | Until):
        yield formula.over
    for part in parts_of(formula):
        yield from intervals_of(part)
