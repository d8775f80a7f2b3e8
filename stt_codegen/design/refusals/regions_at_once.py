"""Find regions that a mission asks for at one moment and that exclude one another, as A and B of `A until B` that do not meet.

unmet_missions.py calls this before it looks for orders and times, for no change of time, speed or width helps.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

from stt_codegen.task import Task
from stt_codegen.task.mission import (
    Always,
    And,
    Eventually,
    Formula,
    InRegion,
    Interval,
    Or,
    RegionUnion,
    Until,
    conjunction,
)
from stt_codegen.task.sets import ConvexSet

UNTIL_HINT = (
    "`f until g` asks for f up to and including the moment of g: use regions that overlap, or for f what a tube in g satisfies"
)
Regions = frozenset[InRegion]
NOTHING: Regions = frozenset()
NOW = Interval(end=Interval().begin)


class RegionsAtOnce(NamedTuple):
    """Regions that must hold at one moment; is_end_of_until: the moment is the one at which an "until" ends."""

    regions: Regions
    is_end_of_until: bool


def excluded_regions(task: Task) -> tuple[str, str] | None:
    """Return a problem and a hint where every way to carry out the mission needs two regions at once that exclude one another."""
    formula = conjunction(*(entry.meaning(task.prescribed_time, task.repeat) for entry in task.mission))
    for regions, is_end_of_until in _required_at_once(formula, NOTHING, False):
        for first, last in combinations(sorted(regions, key=lambda r: (r.is_negated, r.region)), 2):
            if relation := _exclusion(task, first, last):
                problem = f"{first} and {last} must hold at one moment, and {relation}"
                return problem, UNTIL_HINT if is_end_of_until else "change one of them, or the entry that asks for both"
    return None


def _required_at_once(formula: Formula, lasting: Regions, is_end_of_until: bool) -> Iterator[RegionsAtOnce]:
    """Yield the regions of each moment that the formula needs in every case. lasting: regions that hold from now on."""
    yield RegionsAtOnce(_needed_now(formula) | lasting, is_end_of_until)
    match formula:
        case And(parts):
            lasting = lasting.union(*map(_needed_always, parts))
            for part in parts:
                yield from _required_at_once(part, lasting, is_end_of_until)
        case Always(_, part) | Eventually(_, part):
            yield from _required_at_once(part, lasting, False)
        case Until(_, first, last):
            yield from _required_at_once(first, lasting, False)
            yield from _required_at_once(last, lasting | _needed_now(first), True)


def _needed_now(formula: Formula) -> Regions:
    """Return the regions that must hold now for the formula to hold now."""
    match formula:
        case InRegion():
            return frozenset({formula})
        case And(parts):
            return NOTHING.union(*map(_needed_now, parts))
        case Or(parts):
            return frozenset.intersection(*map(_needed_now, parts))
        case Always(over, part) if over.begin == 0:
            return _needed_now(part)
        case Eventually(over, part) if over == NOW:
            return _needed_now(part)
        case Until(_, first, _):
            return _needed_now(first)
    return NOTHING


def _needed_always(formula: Formula) -> Regions:
    """Return the regions that must hold from now on, for ever, for the formula to hold now."""
    match formula:
        case Always(over, part) if over == Interval():
            return _needed_now(part)
        case And(parts):
            return NOTHING.union(*map(_needed_always, parts))
    return NOTHING


def _exclusion(task: Task, first: InRegion, last: InRegion) -> str:
    """Say why no tube satisfies both; empty where one may. `first` is in its region where one of both is."""
    if first.is_negated:
        return ""
    sets, avoided = list(_members(task, first.region)), list(_members(task, last.region))
    if not last.is_negated:
        is_apart = all(_are_apart(a, b) for a in sets for b in avoided)
        return "they do not meet" if is_apart else ""
    if first.region == last.region:
        return "they exclude one another"
    return f"{first} lies in {last.region}" if all(any(_is_inside(a, b) for b in avoided) for a in sets) else ""


def _members(task: Task, name: str) -> Iterator[ConvexSet]:
    """Yield the set of a region, or those of all members of a union."""
    region = task.regions[name]
    if isinstance(region, RegionUnion):
        for member in region.any_of:
            yield from _members(task, member)
    else:
        yield region.to_set_in(task.state_space, task.axis_indices(region))


def _are_apart(first: ConvexSet, last: ConvexSet) -> bool:
    """Return whether a normal of one of two sets separates them, so that no box with a width is in both."""
    return any(a.support(n) + b.support(tuple(-c for c in n)) <= 0 for a, b in ((first, last), (last, first)) for n in a.normals)


def _is_inside(inner: ConvexSet, outer: ConvexSet) -> bool:
    """Return whether the box about a set is inside another one."""
    spans = [inner.span(i) for i in range(inner.dimension)]
    return outer.covers(tuple(a for a, _ in spans), tuple(b for _, b in spans))
