"""Unsafe sets that move, or are unsafe only at times, in floating point: the bounds of their half-spaces over time.

The arena (arena.py) holds them for all searches; what a mission requires of the tube for a while comes in the same form
(missions/state_constraints.py). Normals are over |n|_1, as in half_spaces.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from stt_codegen.constraints import Avoidance
from stt_codegen.design.half_spaces import Array, distances_beyond
from stt_codegen.task.sets import Leg

INACTIVE = -np.inf  # the bound of a half-space while the set is safe


@dataclass(frozen=True)
class LinearBounds:
    """The bounds of a set's half-spaces from the time `begin` to the time `end`, linear in between.

    at_begin, at_end: (N, C), for each of N half-spaces and each of C places on the set's path.
    """

    begin: float
    end: float
    at_begin: Array
    at_end: Array

    def at(self, t: Array) -> Array:
        """Return the bounds at times (T,) from begin to end, the largest over all places: (N, T)."""
        progress = (t - self.begin) / (self.end - self.begin)
        bounds = self.at_begin[..., None] + progress * (self.at_end - self.at_begin)[..., None]
        return np.asarray(bounds.max(axis=1))


@dataclass(frozen=True)
class TimedObstacle:
    """A set whose half-spaces depend on time: a box is clear of the set where it is beyond one of them.

    normal: (N, n), of which the first 2n are -e_1, +e_1, -e_2, .. pieces: the bounds while the set may be unsafe, one piece after
    the other. cached_bounds: by the number of segments what `bounds` returned.
    """

    name: str
    normal: Array
    pieces: tuple[LinearBounds, ...]
    cached_bounds: dict[int, Array] = field(default_factory=dict, compare=False, repr=False)

    def scaled(self, length: float, time: float) -> TimedObstacle:
        """Return the same set with lengths and times measured in these units."""
        pieces = [LinearBounds(p.begin / time, p.end / time, p.at_begin / length, p.at_end / length) for p in self.pieces]
        return TimedObstacle(self.name, self.normal, tuple(pieces))

    def bounds_at_start(self) -> Array | None:
        """Return the bounds at t = 0, (N,); None where the set is safe then."""
        first = self.pieces[0] if self.pieces else None
        return first.at(np.zeros(1))[:, 0] if first is not None and first.begin <= 0 else None

    def bounds(self, segments: int) -> Array:
        """Return for each of so many equal segments of [0, 1] the Bezier coefficients of a cubic nowhere below the bounds.

        The shape is (N, segments, 4). A segment in which the set is safe all the time has INACTIVE.
        """
        if segments in self.cached_bounds:
            return self.cached_bounds[segments]
        coefficients = self.cached_bounds[segments] = np.full((len(self.normal), segments, 4), INACTIVE)
        for k in range(segments):
            begin, end = k / segments, (k + 1) / segments
            parts = [(p, max(p.begin, begin), min(p.end, end)) for p in self.pieces if min(p.end, end) > max(p.begin, begin)]
            times = begin + (end - begin) * (np.arange(4) / 3)
            if len(parts) == 1:  # the line of the piece stands for the whole segment, also for a part in which the set is safe
                coefficients[:, k] = parts[0][0].at(times)
            elif parts:
                coefficients[:, k] = _line_above(parts, times)
        return coefficients

    def distances_beyond(self, edges: Array, bounds: Array) -> Array:
        """Return how far boxes, edges (2, n, ...), are beyond each half-space in the largest component; bounds: (N, ...)."""
        return distances_beyond(self.normal, bounds, edges)


def _line_above(parts: Sequence[tuple[LinearBounds, float, float]], times: Array) -> Array:
    """Return at these times (T,) the lowest line with the mean slope that is nowhere below the bounds: (N, T).

    parts: the pieces that the segment meets, each with the times from which and until which.
    """
    ends = np.array([t for _, begin, end in parts for t in (begin, end)])
    values = np.concatenate([piece.at(np.array([begin, end])) for piece, begin, end in parts], axis=1)
    slope = (values[:, -1] - values[:, 0]) / (ends[-1] - ends[0])
    offset = (values - slope[:, None] * ends).max(axis=1)
    return np.asarray(offset[:, None] + slope[:, None] * times)


def timed_obstacle_of(avoidance: Avoidance, origin: Sequence[Fraction]) -> TimedObstacle:
    """Return a set with a course as half-spaces over time, without the clearance, seen from the origin."""
    course, constraints = avoidance.course, avoidance.alternatives
    assert course is not None
    normal = np.zeros((len(constraints), len(origin)))
    for x, constraint in enumerate(constraints):
        for i, _, c in constraint.terms:
            normal[x, i] = float(Fraction(c, constraint.slack_per_distance))

    resting = np.array([float(constraint.bound_from(origin) / constraint.slack_per_distance) for constraint in constraints])
    growth = np.array(
        [float(g / constraint.slack_per_distance) for constraint, g in zip(constraints, avoidance.growth_rates, strict=True)]
    )

    def bounds_at(leg: Leg, t: Fraction) -> Array:
        """Return the bounds at a time of the leg, (N, C)."""
        bounds = np.repeat((resting + growth * float(course.growth(t)))[:, None], len(leg.displacements), axis=1)
        for c, displacement in enumerate(leg.displacements_at(t)):
            for i, d in enumerate(displacement):
                bounds[:, c] += normal[:, i] * float(d)
        return bounds

    pieces = [
        LinearBounds(float(leg.begin), float(leg.end), bounds_at(leg, leg.begin), bounds_at(leg, leg.end)) for leg in course.legs
    ]
    return TimedObstacle(avoidance.name, normal, tuple(pieces))
