"""Missions as formulas: signal temporal logic over named regions, in negation normal form. grammar.py reads them.

    always[0, 16] (dock -> eventually[0, 4] left)        not lab until[0, 24] key        eventually[3, 5] always[0, 2] dock

A formula is about a tube, the box gamma(t) of all states that it allows: `dock` holds while all of gamma(t) is in the dock,
`not dock` while all of it avoids the dock. So what holds of the tube holds of every trajectory in it (docs/missions.md).

The certificate (certify/monitor.py), the search for a plan (design/missions/) and the closed loop evaluate formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.decimals import exact_decimal

ZERO = Fraction(0)
KEYWORDS = ("always", "eventually", "until", "and", "or", "not")


@dataclass(frozen=True)
class Interval:
    """The times from `begin` to `end` seconds after now; without an end where `end` is None."""

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
    """True while the state is in a region; where it is negated, while the state is outside."""

    region: str
    is_negated: bool = False

    def __str__(self) -> str:
        return f"not {self.region}" if self.is_negated else self.region


@dataclass(frozen=True)
class And(Formula):
    """True where all parts are."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' and '.join(map(str, self.parts))})"


@dataclass(frozen=True)
class Or(Formula):
    """True where at least one part is."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' or '.join(map(str, self.parts))})"


@dataclass(frozen=True)
class Always(Formula):
    """True where the part is true at all times of an interval from now."""

    over: Interval
    part: Formula

    def __str__(self) -> str:
        return f"always{self.over} {self.part}"


@dataclass(frozen=True)
class Eventually(Formula):
    """True where the part is true at some time of an interval from now."""

    over: Interval
    part: Formula

    def __str__(self) -> str:
        return f"eventually{self.over} {self.part}"


@dataclass(frozen=True)
class Until(Formula):
    """True where `last` is true at some time of an interval from now, and `first` from now up to and including that time."""

    over: Interval
    first: Formula
    last: Formula

    def __str__(self) -> str:
        return f"({self.first} until{self.over} {self.last})"


def conjunction(*parts: Formula) -> Formula:
    """Return `And` of the parts, nested ones flattened; a single part stays itself."""
    flat = tuple(p for part in parts for p in (part.parts if isinstance(part, And) else (part,)))
    return flat[0] if len(flat) == 1 else And(flat)


def disjunction(*parts: Formula) -> Formula:
    """Return `Or` of the parts, nested ones flattened; a single part stays itself."""
    flat = tuple(p for part in parts for p in (part.parts if isinstance(part, Or) else (part,)))
    return flat[0] if len(flat) == 1 else Or(flat)


def negation(formula: Formula) -> Formula:
    """Return a formula, negated at its regions only, that holds of a trajectory only where this one does not.

    The negation of "until" demands a little more than that where both of its parts change at one moment.
    """
    match formula:
        case InRegion(region, is_negated):
            return InRegion(region, not is_negated)
        case And(parts):
            return disjunction(*map(negation, parts))
        case Or(parts):
            return conjunction(*map(negation, parts))
        case Always(over, part):
            return Eventually(over, negation(part))
        case Eventually(over, part):
            return Always(over, negation(part))
        case Until(over, first, last):
            not_first, not_last, at_begin = negation(first), negation(last), Interval(over.begin, over.begin)
            length = None if over.end is None else over.end - over.begin
            first_ends = Eventually(at_begin, Until(Interval(ZERO, length), not_last, conjunction(not_first, not_last)))
            return disjunction(Always(over, not_last), Eventually(Interval(ZERO, over.begin), not_first), first_ends)
    raise TypeError(formula)


def replace_regions(formula: Formula, replacement: Callable[[InRegion], Formula]) -> Formula:
    """Return the formula with the replacement of each `InRegion` in its place."""
    match formula:
        case InRegion():
            return replacement(formula)
        case And(parts):
            return conjunction(*(replace_regions(p, replacement) for p in parts))
        case Or(parts):
            return disjunction(*(replace_regions(p, replacement) for p in parts))
        case Always(over, part):
            return Always(over, replace_regions(part, replacement))
        case Eventually(over, part):
            return Eventually(over, replace_regions(part, replacement))
        case Until(over, first, last):
            return Until(over, replace_regions(first, replacement), replace_regions(last, replacement))
    raise TypeError(formula)


def parts_of(formula: Formula) -> tuple[Formula, ...]:
    """Return the operands of a formula's outermost operator; none for a region."""
    match formula:
        case And(parts) | Or(parts):
            return parts
        case Always(_, part) | Eventually(_, part):
            return (part,)
        case Until(_, first, last):
            return (first, last)
    return ()


def regions_of(formula: Formula) -> Iterator[InRegion]:
    """Yield every `InRegion` of a formula, as often as it occurs."""
    if isinstance(formula, InRegion):
        yield formula
    for part in parts_of(formula):
        yield from regions_of(part)


def intervals_of(formula: Formula) -> Iterator[Interval]:
    """Yield the interval of every operator of a formula that has one."""
    if isinstance(formula, Always | Eventually | Until):
        yield formula.over
    for part in parts_of(formula):
        yield from intervals_of(part)
