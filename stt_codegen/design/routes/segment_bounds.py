"""What a choice of sides leaves of every segment of time: bounds on edges, and the half-spaces that the tube must be beyond.

A box avoids U_j as long as it is strictly beyond U_j along one separating normal: on one side of it in one dimension, or beyond
one of its oblique faces. With the sides chosen, "avoid" is a list of constraints, bounds on single edges for the most part, which
is what makes the design a linear program. The functions here choose for every segment the side with the widest gap to a box that
moves along a route, or to a tube that is already designed; sides.py has the sides that last longest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.moving_half_spaces import INACTIVE, TimedObstacle
from stt_codegen.design.routes.corner_search import Route

BELOW, ABOVE = 0, 1
TOLERANCE = 1e-9  # of distances, in the arena's units


@dataclass(frozen=True)
class SegmentBounds:
    """The bounds of every segment of time.

    edges: bounds on single edges, shape (count, 2, n), [k, 0] on the lower edge from below, [k, 1] on the upper one from above.
    beyond_faces: which oblique faces the tube must be beyond, (count, X). timed_sides: for every timed obstacle which of its
    half-spaces the tube must be beyond, (count,), -1 for none.
    """

    edges: Array
    beyond_faces: npt.NDArray[np.bool_]
    timed_sides: tuple[npt.NDArray[np.int64], ...] = ()

    @classmethod
    def of_space(cls, arena: Arena, count: int) -> SegmentBounds:
        """Return the bounds that the state space sets, before any choice of sides."""
        return cls(np.repeat(arena.space[None], count, axis=0), np.zeros((count, len(arena.oblique_faces.set_index)), dtype=bool))

    def equals(self, bounds: SegmentBounds) -> bool:
        """Return whether both are the same bounds."""
        arrays, other_arrays = ((v.edges, v.beyond_faces, *v.timed_sides) for v in (self, bounds))
        return all(bool((a == b).all()) for a, b in zip(arrays, other_arrays, strict=True))

    def coefficient_bounds(self, arena: Arena) -> Array:
        """Return the bounds on single edges for every Bezier coefficient, those of timed obstacles too: (count, 4, 2, n)."""
        coefficients, n = np.repeat(self.edges[:, None], 4, axis=1), arena.dimension
        for obstacle, sides in zip(arena.timed_obstacles, self.timed_sides, strict=True):
            bounds = obstacle.bounds(len(self.edges))
            for x in np.unique(sides[(sides >= 0) & (sides < 2 * n)]).tolist():
                segments, (i, above) = np.nonzero(sides == x)[0], divmod(x, 2)
                limit, edge = bounds[x, segments] + arena.clearance, coefficients[segments, :, 1 - above, i]
                coefficients[segments, :, 1 - above, i] = np.maximum(edge, limit) if above else np.minimum(edge, -limit)
        return coefficients

    @property
    def faces_in_use(self) -> list[int]:
        """The oblique faces that the tube must be beyond at some time."""
        return [int(x) for x in np.nonzero(self.beyond_faces.any(axis=0))[0]] if self.beyond_faces.size else []


def bounds_along_route(
    arena: Arena, start: Array, route: Route, width: Array, *, segments: int, corner_rest: float, ramp: float = 0.0
) -> SegmentBounds:
    """Return the bounds for the box of this width that follows the route at constant speed, in the largest component.

    Every segment and unsafe set has the side with the widest gap. corner_rest: for how many segments the box rests at every
    corner. ramp: the time in which it speeds up, and slows down again, in parts of the whole time.
    """
    points = route.points
    steps = arena.distance(points[1:] - points[:-1])
    rest = corner_rest * float(np.cumsum(steps)[-1]) / segments if len(steps) else 0.0
    knots, positions = [0.0], [points[0]]
    for k, step in enumerate(steps.tolist()):
        knots.append(knots[-1] + step)
        positions.append(points[k + 1])
        if corner_rest and k < len(steps) - 1:
            knots.append(knots[-1] + rest)
            positions.append(points[k + 1])
    centre = _positions_at_equal_times(np.array(knots), np.array(positions), segments, ramp)  # (n, K + 1)
    half = width[:, None] / 2
    low, high = np.minimum(centre[:, 1:], centre[:, :-1]) - half, np.maximum(centre[:, 1:], centre[:, :-1]) + half
    low[:, 0], high[:, 0] = np.minimum(low[:, 0], start[0]), np.maximum(high[:, 0], start[1])
    return _widest_gap_bounds(arena, np.stack([low, high])[..., None], start)


def _positions_at_equal_times(knots: Array, positions: Array, count: int, ramp: float = 0.0) -> Array:
    """Return positions at count + 1 equal times, through the knots at one speed but for the ramps at both ends: (n, count + 1).

    positions: (P, n), at the knots (P,). NumPy's interpolation differs by machine.
    """
    t = knots[-1] * np.arange(count + 1) / count
    if ramp:
        time = np.arange(count + 1) / count  # in parts of the whole
        from_end = np.minimum(time, 1 - time)  # the time to the nearer end
        covered = np.where(from_end < ramp, from_end * from_end / (2 * ramp), from_end - ramp / 2) / (1 - ramp)
        t = knots[-1] * np.where(time < 0.5, covered, 1 - covered)
    k = np.minimum(np.searchsorted(knots, t, side="right") - 1, len(knots) - 2)
    length = knots[k + 1] - knots[k]
    part = np.where(length > 0, (t - knots[k]) / np.where(length > 0, length, 1.0), 1.0)
    return np.asarray((positions[k] + (positions[k + 1] - positions[k]) * np.minimum(part, 1.0)[:, None]).T)


def bounds_along_timed_route(arena: Arena, start: Array, centre: Array, width: Array) -> SegmentBounds:
    """Return the bounds for the box of this width whose centre moves through these points, (count + 1, n).

    A point is at the end of each of `count` equal segments of time; every segment and unsafe set has the side with the widest
    gap.
    """
    half, parts = width[:, None, None] / 2, np.arange(4) / 3
    middle = (centre[:-1, :, None] + (centre[1:] - centre[:-1])[:, :, None] * parts).transpose(1, 0, 2)  # (n, count, 4)
    bezier = np.stack([middle - half, middle + half])
    bezier[0, :, 0] = np.minimum(bezier[0, :, 0], start[0][:, None])
    bezier[1, :, 0] = np.maximum(bezier[1, :, 0], start[1][:, None])
    return _widest_gap_bounds(arena, bezier, start)


def bounds_around_tube(arena: Arena, bezier: Array) -> SegmentBounds:
    """Return the bounds with, for every segment and unsafe set, the side on which this tube has the widest gap.

    bezier: the coefficients of its segments, shape (2, n, K, 4).
    """
    return _widest_gap_bounds(arena, bezier)


def _widest_gap_bounds(arena: Arena, bezier: Array, start: Array | None = None) -> SegmentBounds:
    """Return the bounds with, for every segment and unsafe set, the side on which the gap to the edges is widest.

    bezier: coefficients of the edges, (2, n, K, q). start: at t = 0 a side counts only where gamma(0) already is beyond it.
    """
    count = bezier.shape[2]
    bounds = SegmentBounds.of_space(arena, count)
    if arena.timed_obstacles:
        sides = tuple(_widest_timed_sides(arena, obstacle, bezier, count, start) for obstacle in arena.timed_obstacles)
        bounds = replace(bounds, timed_sides=sides)
    if arena.names:
        _apply_sides(arena, _widest_sides(arena, bezier, start), bounds)
    return bounds


def _widest_sides(arena: Arena, bezier: Array, start: Array | None) -> npt.NDArray[np.int64]:
    """Return for every unsafe set and segment the side with the widest gap, (J, K): side * n + i, or 2n + x for the face x."""
    lowest, highest = bezier[0].min(axis=-1), bezier[1].max(axis=-1)
    n, count = lowest.shape
    below, above = arena.unsafe[:, 0, :, None] - highest[None], lowest[None] - arena.unsafe[:, 1, :, None]
    gaps = np.stack([below, above], axis=1)  # (J, side, n, K)
    if start is not None:
        start_gaps = np.stack([arena.unsafe[:, 0] - start[1], start[0] - arena.unsafe[:, 1]], axis=1)
        gaps[..., 0] = np.where(start_gaps >= arena.clearance - TOLERANCE, gaps[..., 0], -np.inf)
    flat = gaps.reshape(len(arena.names), 2 * n, count)
    sides, widest = flat.argmax(axis=1), flat.max(axis=1)
    faces = arena.oblique_faces
    face_gaps = faces.distances_beyond(bezier).min(axis=-1)
    if start is not None:
        face_gaps[faces.distances_beyond(start) < arena.clearance - TOLERANCE, 0] = -np.inf
    for x, (j, gap) in enumerate(zip(faces.set_index.tolist(), face_gaps, strict=True)):
        wider = gap > widest[j]
        sides[j], widest[j] = np.where(wider, 2 * n + x, sides[j]), np.where(wider, gap, widest[j])
    return np.asarray(sides)


def _apply_sides(arena: Arena, sides: npt.NDArray[np.int64], bounds: SegmentBounds) -> None:
    """Write the bounds of these sides (`_widest_sides`) into `bounds`."""
    n = arena.dimension
    for side in (BELOW, ABOVE):
        for i in range(n):
            applies = sides == side * n + i
            if side == BELOW:
                limit = np.where(applies, (arena.unsafe[:, 0, i] - arena.clearance)[:, None], np.inf).min(axis=0)
                bounds.edges[:, 1, i] = np.minimum(bounds.edges[:, 1, i], limit)
            else:
                limit = np.where(applies, (arena.unsafe[:, 1, i] + arena.clearance)[:, None], -np.inf).max(axis=0)
                bounds.edges[:, 0, i] = np.maximum(bounds.edges[:, 0, i], limit)
    for x, j in enumerate(arena.oblique_faces.set_index.tolist()):
        bounds.beyond_faces[:, x] = sides[j] == 2 * n + x


def _widest_timed_sides(
    arena: Arena, obstacle: TimedObstacle, bezier: Array, count: int, start: Array | None
) -> npt.NDArray[np.int64]:
    """Return for every segment the half-space of the obstacle with the widest gap, -1 where the set is safe: (count,)."""
    bounds = obstacle.bounds(count)
    with np.errstate(invalid="ignore"):
        gaps = obstacle.distances_beyond(bezier, bounds).min(axis=-1)
    first = obstacle.bounds_at_start()
    if start is not None and first is not None:
        gaps[obstacle.distances_beyond(start, first) < arena.clearance - TOLERANCE, 0] = -np.inf
    is_safe = (bounds == INACTIVE).all(axis=(0, 2))
    return np.asarray(np.where(is_safe, -1, gaps.argmax(axis=0)))
