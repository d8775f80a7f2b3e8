"""For every unsafe set, which normal separates the tube from it, along the route.

A box avoids U_j as long as it is strictly beyond U_j along one normal: on one side of it in one dimension, or beyond one of its
faces. Along a route the choice must change from time to time, at points where both the old and the new choice hold. The choices
turn "avoid" into rows, bounds on single edges for the most part, which is what makes the design a linear program.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.moving_half_spaces import INACTIVE, TimedObstacle
from stt_codegen.design.routes.shortest_route import Route

BELOW, ABOVE, BEYOND = 0, 1, 2
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Stay:
    """Until route parameter `until` (vertex number plus fraction) the tube is on this `side` of U_j: BELOW or ABOVE it in
    dimension `index`, or BEYOND face number `index` of the arena."""

    until: float
    index: int
    side: int


@dataclass(frozen=True)
class Limits:
    """What the choices leave of every stretch of time. edges: bounds on single edges, shape (count, 2, n), [k, 0] on the lower
    edge from below, [k, 1] on the upper one from above; beyond: which faces the tube must be beyond, (count, X); beside: of every
    obstacle which of its half-spaces, (count,), -1 for none."""

    edges: Array
    beyond: npt.NDArray[np.bool_]
    beside: tuple[npt.NDArray[np.int64], ...] = ()

    def same(self, other: Limits) -> bool:
        """Whether both ask the same."""
        own, others = ((v.edges, v.beyond, *v.beside) for v in (self, other))
        return all(bool((a == b).all()) for a, b in zip(own, others, strict=True))

    def coefficients(self, arena: Arena) -> Array:
        """The bounds on single edges by segment and Bezier coefficient, those of timed obstacles too: (count, 4, 2, n)."""
        found, n = np.repeat(self.edges[:, None], 4, axis=1), arena.dimension
        for obstacle, chosen in zip(arena.timed_obstacles, self.beside, strict=True):
            bounds = obstacle.bounds(len(self.edges))
            for x in np.unique(chosen[(chosen >= 0) & (chosen < 2 * n)]).tolist():
                here, (i, above) = np.nonzero(chosen == x)[0], divmod(x, 2)
                limit, edge = bounds[x, here] + arena.clearance, found[here, :, 1 - above, i]
                found[here, :, 1 - above, i] = np.maximum(edge, limit) if above else np.minimum(edge, -limit)
        return found

    @property
    def faces(self) -> list[int]:
        """The faces that the tube must be beyond at some time."""
        return [int(x) for x in np.nonzero(self.beyond.any(axis=0))[0]] if self.beyond.size else []

    @classmethod
    def of_space(cls, arena: Arena, count: int) -> Limits:
        """The limits that the state space sets, before any choice of sides."""
        return cls(np.repeat(arena.space[None], count, axis=0), np.zeros((count, len(arena.oblique_faces.set_index)), dtype=bool))


def choose_sides(arena: Arena, route: Route, start: Array) -> tuple[tuple[Stay, ...], ...] | None:
    """For every unsafe set the choices in order, the last one until the route's end; as few changes as possible.

    `start` is gamma(0), shape (2, n): the first choice must already separate it. None when there is no such
    choice for some set.
    """
    found = [_choices(arena, route, start, j) for j in range(len(arena.names))]
    if not all(found):
        return None
    changes = _common_changes([choice.change for choices in found for choice in choices])
    moment = iter(changes)
    return tuple(tuple(Stay(next(moment), c.index, c.side) for c in choices) for choices in found)


@dataclass(frozen=True)
class _Choice:
    """A choice that may end at any route parameter within `change`: until then it holds, from there the next one does."""

    index: int
    side: int
    change: tuple[float, float]


def _common_changes(intervals: list[tuple[float, float]]) -> list[float]:
    """A moment in each interval, as few different ones as there can be: each is the middle of what its intervals share."""
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


def _choices(arena: Arena, route: Route, start: Array, j: int) -> tuple[_Choice, ...]:
    """The choices for U_j; empty when none separates the start, or the route touches the grown set. Each time, the choice
    that lasts longest is taken."""
    end = float(len(route.points) - 1)
    spans: list[tuple[float, float, float, int, int]] = []  # from, to, least gap, index, side
    faces = arena.oblique_faces
    for i in range(arena.dimension):
        for side in (BELOW, ABOVE):
            gap = (
                arena.unsafe[j, 0, i] - route.reach[i] - route.points[:, i]
                if side == BELOW
                else route.points[:, i] - arena.unsafe[j, 1, i] - route.reach[i]
            )
            spans += [(a, b, float(gap.min()), i, side) for a, b in _where_positive(gap)]
    own = faces.indices_of(j)
    beyond = faces.distances_beyond(np.stack([route.points.T, route.points.T]), own.start, own.stop)
    for x, gap in zip(own, beyond - faces.box_support(route.reach)[own][:, None], strict=True):
        spans += [(a, b, float(gap.min()), x, BEYOND) for a, b in _where_positive(gap)]

    def separates_start(i: int, side: int) -> bool:
        if side == BEYOND:
            return bool(faces.distances_beyond(start, i, i + 1)[0] >= arena.clearance - TOLERANCE)
        if side == BELOW:
            return bool(start[1, i] <= arena.unsafe[j, 0, i] - arena.clearance + TOLERANCE)
        return bool(start[0, i] >= arena.unsafe[j, 1, i] + arena.clearance - TOLERANCE)

    here = [(b, gap, i, s) for a, b, gap, i, s in spans if a <= TOLERANCE and separates_start(i, s)]
    if not here:
        return ()
    until, _, i, side = max(here)
    chosen, before = [], 0.0  # `before`: where the last choice ended at the latest
    while until < end - TOLERANCE:
        onward = [(b, gap, k, s, a) for a, b, gap, k, s in spans if a <= until + 1e-7 and b > until + 1e-7]
        if not onward:
            return ()
        to, _, next_i, next_side, a = max(onward)
        chosen.append(_Choice(i, side, (min(max(a, before), until), until)))
        before, i, side, until = until, next_i, next_side, to
    return (*chosen, _Choice(i, side, (end, end)))


def _where_positive(gap: Array) -> list[tuple[float, float]]:
    """The intervals of the route parameter in which the piecewise linear `gap` (value at each vertex) is not negative."""
    spans: list[tuple[float, float]] = []
    for k in range(len(gap) - 1):
        a, b = float(gap[k]), float(gap[k + 1])
        if a < -TOLERANCE and b < -TOLERANCE:
            continue
        first = float(k) if a >= -TOLERANCE else k + a / (a - max(b, 0.0))
        final = float(k + 1) if b >= -TOLERANCE else k + max(a, 0.0) / (max(a, 0.0) - b)
        if spans and first - spans[-1][1] < TOLERANCE:
            spans[-1] = (spans[-1][0], final)
        else:
            spans.append((first, final))
    return spans


def limits_by_stretch(
    arena: Arena, sides: tuple[tuple[Stay, ...], ...], changes: tuple[tuple[int, ...], ...], count: int
) -> Limits:
    """What the choices leave of each of `count` stretches of time. `changes[j][q]` is the stretch at which choice q of U_j
    ends."""
    limits = Limits.of_space(arena, count)
    bounds = limits.edges
    for j, stays in enumerate(sides):
        first = 0
        for stay, last in zip(stays, changes[j], strict=True):
            i = stay.index
            if stay.side == BELOW:
                bounds[first:last, 1, i] = np.minimum(bounds[first:last, 1, i], arena.unsafe[j, 0, i] - arena.clearance)
            elif stay.side == ABOVE:
                bounds[first:last, 0, i] = np.maximum(bounds[first:last, 0, i], arena.unsafe[j, 1, i] + arena.clearance)
            else:
                limits.beyond[first:last, i] = True
            first = last
    return limits


def limits_along(arena: Arena, start: Array, route: Route, width: Array, segments: int, hold: float, ramp: float = 0.0) -> Limits:
    """What the box of this width leaves that follows the route at constant speed, in the largest component: for every segment and
    unsafe set the side with most room. hold: segments that it stands at every corner; ramp: the share of the time in which it
    gets up to speed, and as long to rest."""
    points = route.points
    steps = arena.distance(points[1:] - points[:-1])
    rest = hold * float(np.cumsum(steps)[-1]) / segments if len(steps) else 0.0
    knots, places = [0.0], [points[0]]
    for k, step in enumerate(steps.tolist()):
        knots.append(knots[-1] + step)
        places.append(points[k + 1])
        if hold and k < len(steps) - 1:
            knots.append(knots[-1] + rest)
            places.append(points[k + 1])
    centre = _polyline(np.array(knots), np.array(places), segments, ramp)  # (n, K + 1)
    half = width[:, None] / 2
    low, high = np.minimum(centre[:, 1:], centre[:, :-1]) - half, np.maximum(centre[:, 1:], centre[:, :-1]) + half
    low[:, 0], high[:, 0] = np.minimum(low[:, 0], start[0]), np.maximum(high[:, 0], start[1])
    return _by_room(arena, low, high, np.stack([low, high])[..., None], start)


def _polyline(knots: Array, places: Array, count: int, ramp: float = 0.0) -> Array:
    """Places (P, n) at count + 1 equal times, through the knots at one speed but for the ramps at both ends: (n, count + 1).
    NumPy's interpolation differs by machine."""
    t = knots[-1] * np.arange(count + 1) / count
    if ramp:
        share = np.arange(count + 1) / count
        rest = np.minimum(share, 1 - share)  # to the nearer end
        way = np.where(rest < ramp, rest * rest / (2 * ramp), rest - ramp / 2) / (1 - ramp)
        t = knots[-1] * np.where(share < 0.5, way, 1 - way)
    k = np.minimum(np.searchsorted(knots, t, side="right") - 1, len(knots) - 2)
    length = knots[k + 1] - knots[k]
    part = np.where(length > 0, (t - knots[k]) / np.where(length > 0, length, 1.0), 1.0)
    return np.asarray((places[k] + (places[k + 1] - places[k]) * np.minimum(part, 1.0)[:, None]).T)


def limits_of_tube(arena: Arena, bezier: Array) -> Limits:
    """The same with, for every piece and unsafe set, the side on which this tube has most room. bezier: the coefficients of its
    pieces, shape (2, n, K, 4)."""
    return _by_room(arena, bezier[0].min(axis=-1), bezier[1].max(axis=-1), bezier)


def _by_room(arena: Arena, lowest: Array, highest: Array, bezier: Array, start: Array | None = None) -> Limits:
    """For every piece and unsafe set the side with most room. lowest, highest: of the pieces, (n, K). start: at t = 0 a side
    counts only where gamma(0) already is beyond it."""
    n, count = lowest.shape
    limits = Limits.of_space(arena, count)
    if arena.timed_obstacles:
        limits = replace(
            limits, beside=tuple(_beside(arena, obstacle, bezier, count, start) for obstacle in arena.timed_obstacles)
        )
    if not arena.names:
        return limits
    gaps = np.stack(
        [arena.unsafe[:, 0, :, None] - highest[None], lowest[None] - arena.unsafe[:, 1, :, None]], axis=1
    )  # (J, side, n, K)
    if start is not None:
        here = np.stack([arena.unsafe[:, 0] - start[1], start[0] - arena.unsafe[:, 1]], axis=1)
        gaps[..., 0] = np.where(here >= arena.clearance - TOLERANCE, gaps[..., 0], -np.inf)
    flat = gaps.reshape(len(arena.names), 2 * n, count)
    choice, most = flat.argmax(axis=1), flat.max(axis=1)
    rooms = arena.oblique_faces.distances_beyond(bezier).min(axis=-1)
    if start is not None:
        rooms[arena.oblique_faces.distances_beyond(start) < arena.clearance - TOLERANCE, 0] = -np.inf
    for x, (j, room) in enumerate(zip(arena.oblique_faces.set_index.tolist(), rooms, strict=True)):
        better = room > most[j]
        choice[j], most[j] = np.where(better, 2 * n + x, choice[j]), np.where(better, room, most[j])
    for side in (BELOW, ABOVE):
        for i in range(n):
            chosen = choice == side * n + i
            if side == BELOW:
                limit = np.where(chosen, (arena.unsafe[:, 0, i] - arena.clearance)[:, None], np.inf).min(axis=0)
                limits.edges[:, 1, i] = np.minimum(limits.edges[:, 1, i], limit)
            else:
                limit = np.where(chosen, (arena.unsafe[:, 1, i] + arena.clearance)[:, None], -np.inf).max(axis=0)
                limits.edges[:, 0, i] = np.maximum(limits.edges[:, 0, i], limit)
    for x, j in enumerate(arena.oblique_faces.set_index.tolist()):
        limits.beyond[:, x] = choice[j] == 2 * n + x
    return limits


def _beside(arena: Arena, obstacle: TimedObstacle, bezier: Array, count: int, start: Array | None) -> npt.NDArray[np.int64]:
    """For every segment the half-space of a obstacle with most room, -1 where it is safe: (count,)."""
    bounds = obstacle.bounds(count)
    with np.errstate(invalid="ignore"):
        rooms = obstacle.distances_beyond(bezier, bounds).min(axis=-1)
    first = obstacle.bounds_at_start()
    if start is not None and first is not None:
        rooms[obstacle.distances_beyond(start, first) < arena.clearance - TOLERANCE, 0] = -np.inf
    safe = (bounds == INACTIVE).all(axis=(0, 2))
    return np.asarray(np.where(safe, -1, rooms.argmax(axis=0)))


def limits_in_time(arena: Arena, start: Array, centre: Array, width: Array) -> Limits:
    """What the box of this width leaves whose centre moves through these points (count + 1, n), one at the end of each of `count`
    equal times: for every time and unsafe set the side with most room."""
    half, parts = width[:, None, None] / 2, np.arange(4) / 3
    middle = (centre[:-1, :, None] + (centre[1:] - centre[:-1])[:, :, None] * parts).transpose(1, 0, 2)  # (n, count, 4)
    bezier = np.stack([middle - half, middle + half])
    bezier[0, :, 0], bezier[1, :, 0] = (
        np.minimum(bezier[0, :, 0], start[0][:, None]),
        np.maximum(bezier[1, :, 0], start[1][:, None]),
    )
    return _by_room(arena, bezier[0].min(axis=-1), bezier[1].max(axis=-1), bezier, start)
