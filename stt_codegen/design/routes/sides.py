"""For every unsafe set, which normal separates the tube from it along the route: the sides that last longest.

Along a route the side must change from time to time, at points where both the old and the new side separate. These sides serve
where the widest gaps (segment_bounds.py) give no tube, and with many unsafe sets; spline_tubes/stretch_times.py gives them times.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.routes.corner_search import Route
from stt_codegen.design.routes.segment_bounds import ABOVE, BELOW, TOLERANCE, SegmentBounds

BEYOND = 2
PARAMETER_TOLERANCE = 1e-7  # of route parameters: a side must hold on both sides of a change


@dataclass(frozen=True)
class SideInterval:
    """Until route parameter `until` (vertex number plus fraction) the tube is on this `side` of U_j.

    That is BELOW or ABOVE it in dimension `index`, or BEYOND oblique face number `index` of the arena.
    """

    until: float
    index: int
    side: int


Sides = tuple[tuple[SideInterval, ...], ...]  # of every unsafe set, in order along the route


def choose_sides(arena: Arena, route: Route, start: Array) -> Sides | None:
    """Return for every unsafe set its sides in order, the last one until the route's end; as few changes as possible.

    `start` is gamma(0), shape (2, n): the first side must already separate it. None when some set has no such sides.
    """
    sides_of_sets = [_longest_sides(arena, route, start, j) for j in range(len(arena.names))]
    if not all(sides_of_sets):
        return None
    changes = iter(_common_changes([side.change for sides in sides_of_sets for side in sides]))
    return tuple(tuple(SideInterval(next(changes), side.index, side.side) for side in sides) for sides in sides_of_sets)


@dataclass(frozen=True)
class _FlexibleSide:
    """A side that may end at any route parameter within `change`: until then it holds, from there the next one does."""

    index: int
    side: int
    change: tuple[float, float]


def _common_changes(intervals: list[tuple[float, float]]) -> list[float]:
    """Return a moment in each interval, as few different ones as there can be: each in the middle of what its intervals share."""
    order = sorted(range(len(intervals)), key=lambda k: intervals[k][1])
    moments = [0.0] * len(intervals)
    group: list[int] = []
    for k in [*order, -1]:
        if k >= 0 and (not group or intervals[k][0] <= intervals[group[0]][1]):
            group.append(k)
            continue
        middle = (max(intervals[g][0] for g in group) + intervals[group[0]][1]) / 2 if group else 0.0
        for g in group:
            moments[g] = middle
        group = [k]
    return moments


class _SideSpan(NamedTuple):
    """A part of the route on which a side separates; in the order in which a longer one is preferred."""

    end: float
    smallest_gap: float
    normal_index: int
    side: int
    begin: float


def _longest_sides(arena: Arena, route: Route, start: Array, j: int) -> tuple[_FlexibleSide, ...]:
    """Return the sides of U_j along the route; each time the one that lasts longest.

    There are none when no side separates the start, or when the route touches the grown set.
    """
    spans = _side_spans(arena, route, j)
    first_spans = [s for s in spans if s.begin <= TOLERANCE and _separates(arena, start, j, s)]
    if not first_spans:
        return ()
    current = max(first_spans)
    end = float(len(route.points) - 1)
    sides: list[_FlexibleSide] = []
    last_change = 0.0  # where the last side ended at the latest
    while current.end < end - TOLERANCE:
        until = current.end
        next_spans = [s for s in spans if s.begin <= until + PARAMETER_TOLERANCE and s.end > until + PARAMETER_TOLERANCE]
        if not next_spans:
            return ()
        longest = max(next_spans)
        sides.append(_FlexibleSide(current.normal_index, current.side, (min(max(longest.begin, last_change), until), until)))
        last_change, current = until, longest
    return (*sides, _FlexibleSide(current.normal_index, current.side, (end, end)))


def _side_spans(arena: Arena, route: Route, j: int) -> list[_SideSpan]:
    """Return the parts of the route on which each side separates the grown set U_j from the centre."""
    spans: list[_SideSpan] = []

    def add(gap: Array, index: int, side: int) -> None:
        spans.extend(_SideSpan(end, float(gap.min()), index, side, begin) for begin, end in _where_positive(gap))

    for i in range(arena.dimension):
        add(arena.unsafe[j, 0, i] - route.growth[i] - route.points[:, i], i, BELOW)
        add(route.points[:, i] - arena.unsafe[j, 1, i] - route.growth[i], i, ABOVE)
    faces = arena.oblique_faces
    indices = faces.indices_of(j)
    gaps = faces.distances_beyond(np.stack([route.points.T, route.points.T]), indices.start, indices.stop)
    for x, gap in zip(indices, gaps - faces.box_support(route.growth)[indices][:, None], strict=True):
        add(gap, x, BEYOND)
    return spans


def _separates(arena: Arena, start: Array, j: int, span: _SideSpan) -> bool:
    """Return whether gamma(0) is on the span's side of U_j, with the clearance."""
    i = span.normal_index
    if span.side == BEYOND:
        return bool(arena.oblique_faces.distances_beyond(start, i, i + 1)[0] >= arena.clearance - TOLERANCE)
    if span.side == BELOW:
        return bool(start[1, i] <= arena.unsafe[j, 0, i] - arena.clearance + TOLERANCE)
    return bool(start[0, i] >= arena.unsafe[j, 1, i] + arena.clearance - TOLERANCE)


def _where_positive(gap: Array) -> list[tuple[float, float]]:
    """Return the intervals of the route parameter in which the piecewise linear `gap` (a value for each vertex) is not
    negative."""
    intervals: list[tuple[float, float]] = []
    for k in range(len(gap) - 1):
        a, b = float(gap[k]), float(gap[k + 1])
        if a < -TOLERANCE and b < -TOLERANCE:
            continue
        begin = float(k) if a >= -TOLERANCE else k + a / (a - max(b, 0.0))
        end = float(k + 1) if b >= -TOLERANCE else k + max(a, 0.0) / (max(a, 0.0) - b)
        if intervals and begin - intervals[-1][1] < TOLERANCE:
            intervals[-1] = (intervals[-1][0], end)
        else:
            intervals.append((begin, end))
    return intervals


def bounds_by_stretch(arena: Arena, sides: Sides, changes: tuple[tuple[int, ...], ...], count: int) -> SegmentBounds:
    """Return what the sides leave of each of `count` stretches of time.

    `changes[j][q]` is the stretch at which side q of U_j ends.
    """
    bounds = SegmentBounds.of_space(arena, count)
    edges = bounds.edges
    for j, intervals in enumerate(sides):
        first = 0
        for interval, last in zip(intervals, changes[j], strict=True):
            i = interval.index
            if interval.side == BELOW:
                edges[first:last, 1, i] = np.minimum(edges[first:last, 1, i], arena.unsafe[j, 0, i] - arena.clearance)
            elif interval.side == ABOVE:
                edges[first:last, 0, i] = np.maximum(edges[first:last, 0, i], arena.unsafe[j, 1, i] + arena.clearance)
            else:
                bounds.beyond_faces[first:last, i] = True
            first = last
    return bounds
