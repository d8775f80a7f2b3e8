"""Find regions that a mission asks for at one moment and that exclude one another, as A and B of `A until B` that do not meet.

The initial set and the target count too: the tube begins in the one, and stands in the other from t_c on. unmet_missions.py
calls this before it looks for orders and times, for no change of time, speed or width helps.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

from stt_codegen.decimals import above, exact_decimal
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
        for first, last in combinations(_in_order(regions), 2):
            if relation := _exclusion(task, first, last):
                problem = f"{first} and {last} must hold at one moment, and {relation}"
                return problem, UNTIL_HINT if is_end_of_until else "change one of them, or the entry that asks for both"
    return _excluded_at_ends(task, formula)


def _excluded_at_ends(task: Task, formula: Formula) -> tuple[str, str] | None:
    """Return a problem and a hint where the tube may not begin in the initial set, or not end in the target."""
    for region in _in_order(needed_now(formula)):
        if relation := _exclusion_of_set(task, "the initial set", task.initial_set.convex(), region):
            return f"at t = 0 the tube is in the initial set, and must be in {region}; {relation}", "move or shrink one of them"
    if task.target_set is not None and not task.repeat:
        for region in _in_order(needed_finally(formula, task.prescribed_time)):
            if relation := _exclusion_of_set(task, "the target", task.target, region):
                problem = f"from t_c on the tube stands in the target, and must be in {region}; {relation}"
                return problem, "move or shrink one of them, or leave the target out"
    return None


def _in_order(regions: Regions) -> list[InRegion]:
    """Return regions in the order in which messages name them."""
    return sorted(regions, key=lambda r: (r.is_negated, r.region))


def explain_early_visit(task: Task, segments: int) -> tuple[str, str] | None:
    """Return a problem and a hint where a region must be reached sooner than the first of this number of segments ends."""
    formula = conjunction(*(entry.meaning(task.prescribed_time, task.repeat) for entry in task.mission))
    step = task.prescribed_time / segments
    for part in formula.parts if isinstance(formula, And) else (formula,):
        if not isinstance(part, Eventually) or part.over.end is None or part.over.end >= step:
            continue
        for region in _in_order(needed_now(part.part)):
            if relation := _exclusion_of_set(task, "the initial set", task.initial_set.convex(), region):
                problem = (
                    f"the tube begins in the initial set, and {region} must hold by {exact_decimal(part.over.end)} s; {relation}"
                )
                knots = f"the search reaches regions at ends of up to {segments} segments, the first at {above(step, 3):g} s"
                return f"{problem}, and {knots}", "give the window a later end"
    return None


def _required_at_once(formula: Formula, lasting: Regions, is_end_of_until: bool) -> Iterator[RegionsAtOnce]:
    """Yield the regions of each moment that the formula needs in every case. lasting: regions that hold from now on."""
    yield RegionsAtOnce(needed_now(formula) | lasting, is_end_of_until)
    match formula:
        case And(parts):
            lasting = lasting.union(*map(_needed_always, parts))
            for part in parts:
                yield from _required_at_once(part, lasting, is_end_of_until)
        case Always(_, part) | Eventually(_, part):
            yield from _required_at_once(part, lasting, False)
        case Until(_, first, last):
            yield from _required_at_once(first, lasting, False)
            yield from _required_at_once(last, lasting | needed_now(first), True)


def needed_now(formula: Formula) -> Regions:
    """Return the regions that must hold now for the formula to hold now."""
    match formula:
        case InRegion():
            return frozenset({formula})
        case And(parts):
            return NOTHING.union(*map(needed_now, parts))
        case Or(parts):
            return frozenset.intersection(*map(needed_now, parts))
        case Always(over, part) if over.begin == 0:
            return needed_now(part)
        case Eventually(over, part) if over == NOW:
            return needed_now(part)
        case Until(_, first, _):
            return needed_now(first)
    return NOTHING


def _needed_always(formula: Formula) -> Regions:
    """Return the regions that must hold from now on, for ever, for the formula to hold now."""
    match formula:
        case Always(over, part) if over == Interval():
            return needed_now(part)
        case And(parts):
            return NOTHING.union(*map(_needed_always, parts))
    return NOTHING


def needed_finally(formula: Formula, t_c: Fraction) -> Regions:
    """Return the regions that must hold at all late times for the formula to hold now, where the tube stands from t_c on."""
    match formula:
        case And(parts):
            return NOTHING.union(*(needed_finally(part, t_c) for part in parts))
        case Or(parts):
            return frozenset.intersection(*(needed_finally(part, t_c) for part in parts))
        case Always(over, part) if over.end is None or over.end >= t_c:
            return _needed_at_rest(part)
        case Eventually(over, part) if over.begin >= t_c:
            return _needed_at_rest(part)
        case Always(_, part) | Eventually(_, part) | Until(_, _, part):
            return needed_finally(part, t_c)
    return NOTHING


def _needed_at_rest(formula: Formula) -> Regions:
    """Return the regions that must hold for the formula to hold while the tube stands for ever."""
    match formula:
        case InRegion():
            return frozenset({formula})
        case And(parts):
            return NOTHING.union(*map(_needed_at_rest, parts))
        case Or(parts):
            return frozenset.intersection(*map(_needed_at_rest, parts))
        case Always(_, part) | Eventually(_, part):
            return _needed_at_rest(part)
        case Until(_, first, last):
            return _needed_at_rest(first) | _needed_at_rest(last)
    return NOTHING


def _exclusion_of_set(task: Task, name: str, occupied: ConvexSet, region: InRegion) -> str:
    """Say why no tube that is in a set satisfies what is asked of a region; empty where one may."""
    members = list(_members(task, region.region))
    if region.is_negated:
        return f"{name} lies in {region.region}" if any(_is_inside(occupied, member) for member in members) else ""
    return "they do not meet" if all(_are_apart(occupied, member) for member in members) else ""


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
