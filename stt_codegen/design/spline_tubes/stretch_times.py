"""How long every stretch of a route takes: the polyline tube of least time, by a linear program, and its times on a spline's
segments.

A stretch ends where a side changes (routes/sides.py). widest.py calls this where the widest gaps give no tube.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import LinearProgram, face_bound, face_terms
from stt_codegen.design.routes import Route, SegmentBounds, Sides, bounds_by_stretch
from stt_codegen.designs import LOWER, UPPER

MINIMUM_SEGMENTS = (0, 1, 4)  # that every stretch of the polyline tube gets; tried in this order


@dataclass(frozen=True)
class StretchTiming:
    """The polyline tube of least time: route parameters of its vertices and the share of time of each stretch.

    length: sum of the stretches' lengths (largest movement of any edge), a distance; length / t_c bounds the peak
    speed of any tube with these sides from below.
    """

    vertices: tuple[float, ...]
    shares: tuple[float, ...]
    length: float


def minimum_times(arena: Arena, sides: Sides, start: Array, route: Route, width: Array) -> StretchTiming | None:
    """Return the times of a polyline tube with a vertex at every change of side, its total movement least.

    One duration for each stretch, shared by all dimensions; no edge moves by more than the duration. None when no tube
    of these widths (n,) fits.
    """
    inner = sorted({round(interval.until, 9) for intervals in sides for interval in intervals[:-1]})
    vertices = (0.0, *(v for v in inner if v > 0), float(len(route.points) - 1))
    m = len(vertices) - 1
    stretch_of = {v: k for k, v in enumerate(vertices)}
    changes = tuple((*(stretch_of.get(round(s.until, 9), m) for s in intervals[:-1]), m) for intervals in sides)
    durations = _durations(arena, bounds_by_stretch(arena, sides, changes, m), start, width)
    if durations is None:
        return None
    length = float(np.cumsum(durations)[-1])
    shares = tuple(d / length for d in durations) if length > 0 else (1.0 / m,) * m
    return StretchTiming(vertices, shares, length)


def _durations(arena: Arena, bounds: SegmentBounds, start: Array, width: Array) -> list[float] | None:
    """Return the durations of the stretches, the solution of the linear program; None when there is none."""
    n, m = arena.dimension, len(bounds.edges)
    program = LinearProgram(2 * n * (m + 1) + m)
    edge = np.arange(2 * n * (m + 1)).reshape(m + 1, 2, n)
    duration = 2 * n * (m + 1) + np.arange(m)
    program.cost[duration] = 1.0
    program.lower[duration] = 0.0
    for v in range(m + 1):
        near = bounds.edges[max(v - 1, 0) : v + 1]
        low, high = near[:, 0].max(axis=0), near[:, 1].min(axis=0)
        if v == m:
            low, high = np.maximum(low, arena.target[0]), np.minimum(high, arena.target[1])
        program.lower[edge[v]] = start if v == 0 else low
        program.upper[edge[v]] = start if v == 0 else high
    for v in range(1, m + 1):
        program.add_rows(np.stack([edge[v, UPPER], edge[v, LOWER]], axis=1), [1, -1], width, np.inf)
        columns = np.stack([np.full(2 * n, duration[v - 1]), edge[v].ravel(), edge[v - 1].ravel()], axis=1)
        for sign in (-1.0, 1.0):
            values = np.tile([1.0, sign, -sign], (2 * n, 1))
            values[:, 0] = np.tile(arena.relative_speeds, 2)
            program.add_rows(columns, values, 0.0, np.inf)
    for v in range(m + 1):
        for x in np.nonzero(bounds.beyond_faces[max(v - 1, 0) : v + 1].any(axis=0))[0]:
            program.add_rows(*face_terms(arena, int(x), edge[v]), face_bound(arena, int(x)), np.inf)
    solution = program.solve()
    return None if solution is None else [max(float(d), 0.0) for d in solution[duration]]


def time_plans(timing: StretchTiming, segments: int) -> list[tuple[float, ...]]:
    """Return shares of time to try: as the linear program has them, then with some segments at least for every stretch.

    With these a spline can turn where the polyline has a corner.
    """
    plans: list[tuple[float, ...]] = []
    for minimum in MINIMUM_SEGMENTS:
        longer_shares = [max(share, minimum / segments) for share in timing.shares]
        total = float(np.cumsum(longer_shares)[-1])
        plan = tuple(share / total for share in longer_shares)
        if minimum * len(longer_shares) < segments and plan not in plans:
            plans.append(plan)
    return plans


def changes_at(
    timing: StretchTiming, sides: Sides, shares: tuple[float, ...], segments: int
) -> tuple[tuple[int, ...], ...] | None:
    """Return the segment at which each side ends, at least one segment for each side; None when they do not fit."""
    times = np.concatenate([[0.0], np.cumsum(shares)]) * segments
    time_of = {round(v, 9): float(t) for v, t in zip(timing.vertices, times, strict=True)}
    changes = []
    for intervals in sides:
        if len(intervals) > segments:
            return None
        ends, last = [], 0
        for q, interval in enumerate(intervals[:-1]):
            latest = segments - (len(intervals) - 1 - q)
            last = min(max(round(time_of[round(interval.until, 9)]), last + 1), latest)
            ends.append(last)
        changes.append((*ends, segments))
    return tuple(changes)
