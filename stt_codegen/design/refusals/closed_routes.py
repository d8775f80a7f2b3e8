"""The message where no route is found among sets that move: what closes the routes and when, and which options would open one.

Only routes are sought here, not tubes: with a value from the message a route is open, and the next run shows whether a tube fits
along it. advice.py calls `explain_closed_routes`.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stt_codegen.decimals import below, decimal
from stt_codegen.design.arena import Arena, arena_of, normalise, starting_box
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.moving_half_spaces import TimedObstacle
from stt_codegen.design.spacetime import SliceSearch, has_timed_route, slice_searches
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.properties import Property
from stt_codegen.task import Task

HALVINGS = 8  # to find the value of an option: cells are a hundredth of the space
OBSTACLE_LIMIT = 40  # so many sets are examined whether they close all routes,
SEARCH_LIMIT = 6  # each on so many of the fields that are searched: all of them in up to three dimensions
LONGER_TIMES = (Fraction(5, 4), Fraction(3, 2), Fraction(2), Fraction(3))  # times prescribed_time
FINER_STEPS = (Fraction(1, 8), Fraction(1, 4), Fraction(1, 2))  # from one of the longer times to the next
REDUCED_PARTS = tuple(Fraction(part, 8) for part in range(7, -1, -1))  # of an uncertainty or a growth
HasRoute = Callable[[Arena], bool]


def explain_closed_routes(task: Task, arena: Arena, segments: int) -> str:
    """Return the refusal in one sentence. segments: the number of segments of time that a route has."""

    def has_route(trial: Arena) -> bool:
        with suppress(NotCertified):
            return has_timed_route(trial, *_narrowest_start(trial), segments)
        return False

    reason = f"{Property.AVOID.label}: no way was found from the initial set to the target set among the unsafe sets as they move"
    if has_route(arena):
        return f"{reason}: cells have a way, but no spline tube was found along it; lower tube.min_width or tube.clearance"
    searched = list(itertools.islice(slice_searches(arena, *_narrowest_start(arena), segments), SEARCH_LIMIT))
    obstacles = arena.timed_obstacles[:OBSTACLE_LIMIT]
    closing = [text for obstacle in obstacles if (text := _describe_closing(arena, obstacle, searched))]
    if closing:
        cause = f"{' and '.join(closing)} close{'s' if len(closing) == 1 else ''} it"
    else:
        cause = _describe_last_free_time(arena, searched)
    remedies = [*_opening_lengths(arena, has_route), *_opening_options(task, has_route)]
    if remedies:
        return f"{reason}: {cause}; a way opens at, for example, {', or at '.join(remedies)}"
    return f"{reason}: {cause}; move a set, or let it be safe earlier or longer"


def _narrowest_start(arena: Arena) -> tuple[Array, Array]:
    """Return the centre of gamma(0) and the minimum width, (n,) each."""
    box = starting_box(arena)
    return (box[0] + box[1]) / 2, np.full(arena.dimension, arena.min_width)


def _opening_lengths(arena: Arena, has_route: HasRoute) -> Iterator[str]:
    """Yield the largest clearance, and the largest width, at which there is a route."""
    allowance = arena.allowance
    options: tuple[tuple[str, float, float, Callable[[float], Arena]], ...] = (
        ("clearance", allowance, arena.clearance, lambda v: replace(arena, clearance=v)),
        ("min_width", 2 * allowance, arena.min_width, lambda v: replace(arena, min_width=v)),
    )
    for name, zero, current, arena_with in options:  # zero: the arena's value for an option of 0
        if has_route(arena_with(zero)):
            value = _last_that_holds(lambda v, with_=arena_with: has_route(with_(v)), zero, current)  # type: ignore[misc]
            yield f"tube.{name} = {below(Fraction(max((value - zero) * arena.length_unit, 0.0)), 3):g}"


def _last_that_holds(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """Return a value at which something holds, near the last one from a good value towards a bad one."""
    for _ in range(HALVINGS):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def _opening_options(task: Task, has_route: HasRoute) -> Iterator[str]:
    """Yield a smaller start delay, timing uncertainty or growth, and a longer time, each of which alone opens a route."""
    if task.start_delay:
        part = _largest_part(lambda part: _has_route_with(task, {"start_delay": task.start_delay * part}, has_route))
        yield from () if part is None else (f"start_delay = {decimal(task.start_delay * part)}",)
    for key in ("timing", "spread"):
        names = [s.name for s in task.as_stated.unsafe if getattr(s, key)]
        if names:
            part = _largest_part(lambda part, key=key: _has_route_with(task, _with_part(task, key, part), has_route))  # type: ignore[misc]
            if part is not None:
                values = sorted({part * getattr(s, key) for s in task.unsafe if getattr(s, key)})
                yield f"{key} = {' and '.join(decimal(v) for v in values)} of {' and '.join(names)}"
    factor = _opening_time_factor(task, has_route)
    if factor is not None:
        yield f"prescribed_time = {decimal(factor * task.prescribed_time)}"


def _with_part(task: Task, key: str, part: Fraction) -> dict[str, object]:
    """Return the change of a task in which every unsafe set has a part of its value for a key."""
    values = ((s, getattr(s, key)) for s in task.as_stated.unsafe)
    return {"unsafe": tuple(s.model_copy(update={key: part * value}) if value else s for s, value in values)}


def _largest_part(opens_route: Callable[[Fraction], bool]) -> Fraction | None:
    """Return the largest of the reduced parts of a value with which there is a route; None where none opens one."""
    return next((part for part in REDUCED_PARTS if opens_route(part)), None)


def _opening_time_factor(task: Task, has_route: HasRoute) -> Fraction | None:
    """Return a factor for prescribed_time at which there is a route, near the smallest one; None up to the largest factor."""
    for shorter, longer in pairwise((Fraction(1), *LONGER_TIMES)):
        if _has_route_with(task, {"prescribed_time": longer * task.prescribed_time}, has_route):
            trials = (shorter + step * (longer - shorter) for step in FINER_STEPS)
            changes = ((trial, {"prescribed_time": trial * task.prescribed_time}) for trial in trials)
            return next((trial for trial, change in changes if _has_route_with(task, change, has_route)), longer)
    return None


def _has_route_with(task: Task, change: Mapping[str, object], has_route: HasRoute) -> bool:
    """Return whether there is a route for the task with some fields changed."""
    with suppress(BadInput, NotCertified):
        trial = task.changed(**change)
        lattice = lattice_of(trial)
        return has_route(normalise(arena_of(trial, lattice), lattice.exponent))
    return False


def _describe_closing(arena: Arena, obstacle: TimedObstacle, searched: Sequence[SliceSearch]) -> str | None:
    """Return the name of a set without which there would be a route, and when it closes the route; None for another set."""
    for search in searched:
        free_of_obstacle = np.ones_like(search.free)
        search.cells.block(free_of_obstacle, obstacle)
        if free_of_obstacle.all():
            continue
        free_of_rest = search.cells.free_cells(arena)
        for other_obstacle in arena.timed_obstacles:
            if other_obstacle is not obstacle:
                search.cells.block(free_of_rest, other_obstacle)
        free_of_rest[0][search.start_cell] = True
        if replace(search, free=free_of_rest).has_route():
            times = (f"{k / len(search.free) * arena.time_unit:.3g} s" for k in _closing_segments(search, free_of_rest))
            return f"{obstacle.name} (a way would open if it were safe from {' to '.join(times)})"
    return None


def _closing_segments(search: SliceSearch, free_of_rest: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return from which to which segment a set must be safe at least, so that a route leads. free_of_rest: without the set."""
    count = len(search.free)

    def leads_where_safe(begin: int, end: int) -> bool:
        free = np.concatenate([search.free[:begin], free_of_rest[begin:end], search.free[end:]])
        return replace(search, free=free).has_route()

    begin = bisect_left(range(count), True, key=lambda k: not leads_where_safe(k, count)) - 1
    end = bisect_left(range(begin + 1, count), True, key=lambda k: leads_where_safe(begin, k)) + begin + 1
    return begin, end


def _describe_last_free_time(arena: Arena, searched: Sequence[SliceSearch]) -> str:
    """Return until when a free cell can be reached, for routes that no set closes alone."""
    last = 0.0
    for search in searched:
        is_open = [bool(cells.any()) for cells in search.reachable_cells()]
        ends = [k for k, (now, later) in enumerate(pairwise([*is_open, False])) if now and not later]
        last = max([last, *(k / len(search.free) for k in ends)])
    if last < 1:
        return f"the search reached no free place after {last * arena.time_unit:.3g} s"
    return "no moving set alone closes it"
