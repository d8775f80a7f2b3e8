"""The reason why no route is found among sets that move: what closes the routes, and when.

reasons.py calls `explain_closed_routes`.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.moving_half_spaces import TimedObstacle
from stt_codegen.design.spacetime import SliceSearch, has_timed_route, slice_searches
from stt_codegen.errors import Reason
from stt_codegen.properties import Property

OBSTACLE_LIMIT = 40  # so many sets are examined whether they close all routes,
SEARCH_LIMIT = 6  # each on so many of the fields that are searched: all of them in up to three dimensions


def explain_closed_routes(arena: Arena, segments: int) -> Reason:
    """Return why no route is found. segments: the number of segments of time that a route has."""
    reason = f"{Property.AVOID.label}: no way was found from the initial set to the target set among the unsafe sets as they move"
    codes = (Property.AVOID.code,)
    if has_timed_route(arena, *_narrowest_start(arena), segments):
        problem = f"{reason}: cells have a way, but no spline tube was found along it"
        return Reason(problem, "lower tube.min_width or tube.clearance", codes=codes)
    searched = list(itertools.islice(slice_searches(arena, *_narrowest_start(arena), segments), SEARCH_LIMIT))
    obstacles = arena.timed_obstacles[:OBSTACLE_LIMIT]
    closing = [text for obstacle in obstacles if (text := _describe_closing(arena, obstacle, searched))]
    if closing:
        cause = f"{' and '.join(closing)} close{'s' if len(closing) == 1 else ''} it"
    else:
        cause = _describe_last_free_time(arena, searched)
    return Reason(f"{reason}: {cause}", "move a set, or let it be safe earlier or longer", codes=codes)


def _narrowest_start(arena: Arena) -> tuple[Array, Array]:
    """Return the centre of gamma(0) and the minimum width, (n,) each."""
    box = starting_box(arena)
    return (box[0] + box[1]) / 2, arena.min_widths


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
