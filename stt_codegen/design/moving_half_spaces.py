"""Unsafe sets that move, or are unsafe only at times, in floating point: how far out each of their half-spaces is, over time.

Normals are over |n|_1, as in `half_spaces.py`, so that what is left of an inequality is by how much the tube's box may grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from stt_codegen.constraints import Avoidance
from stt_codegen.design.half_spaces import Array
from stt_codegen.task.sets import Leg

NEVER = -np.inf  # the bound of a half-space while the set is safe


@dataclass(frozen=True)
class Stage:
    """From `begin` to `end` the bounds of the half-spaces, (N, C): for each place on the set's path, at both times."""

    begin: float
    end: float
    first: Array
    last: Array

    def at(self, t: Array) -> Array:
        """The bounds at times of the stage, the most of all places: (N, T)."""
        share = (t - self.begin) / (self.end - self.begin)
        found = self.first[..., None] + share * (self.last - self.first)[..., None]
        return np.asarray(found.max(axis=1))


@dataclass(frozen=True)
class Mover:
    """One set: normal (N, n), of which the first 2n are -e_1, +e_1, -e_2, ..; stages one after the other, while it may be
    unsafe."""

    name: str
    normal: Array
    stages: tuple[Stage, ...]
    known: dict[int, Array] = field(default_factory=dict, compare=False, repr=False)  # of `bounds`

    def scaled(self, length: float, time: float) -> Mover:
        """With lengths and times in these units."""
        stages = [Stage(s.begin / time, s.end / time, s.first / length, s.last / length) for s in self.stages]
        return Mover(self.name, self.normal, tuple(stages))

    def at_start(self) -> Array | None:
        """The bounds at t = 0, (N,); None where the set is safe then."""
        first = self.stages[0] if self.stages else None
        return first.at(np.zeros(1))[:, 0] if first is not None and first.begin <= 0 else None

    def bounds(self, count: int) -> Array:
        """Of `count` equal parts of [0, 1] the Bezier coefficients of lines, or the least of them, that are no less than the
        bounds are in that part: (N, count, 4); NEVER where the set is safe all the time."""
        if count in self.known:
            return self.known[count]
        found = self.known[count] = np.full((len(self.normal), count, 4), NEVER)
        parts = np.arange(4) / 3
        for k in range(count):
            a, b = k / count, (k + 1) / count
            pieces = [(s, max(s.begin, a), min(s.end, b)) for s in self.stages if min(s.end, b) > max(s.begin, a)]
            if len(pieces) == 1:  # where it is safe in a part of the time, its lines are taken for all of it
                found[:, k] = pieces[0][0].at(a + (b - a) * parts)
            elif pieces:
                times = np.array([t for _, p, q in pieces for t in (p, q)])
                values = np.concatenate([s.at(np.array([p, q])) for s, p, q in pieces], axis=1)
                slope = (values[:, -1] - values[:, 0]) / (times[-1] - times[0])
                least = (values - slope[:, None] * times).max(axis=1)
                found[:, k] = least[:, None] + slope[:, None] * (a + (b - a) * parts)
        return found

    def room(self, edges: Array, bounds: Array) -> Array:
        """How far boxes, edges of shape (2, n, ...), are beyond each half-space in the largest component, bounds (N, ...)."""
        total = -bounds
        for i in range(self.normal.shape[1]):
            c = self.normal[:, i].reshape(-1, *(1 for _ in edges.shape[2:]))
            total = total + np.maximum(c, 0.0) * edges[0, i] + np.minimum(c, 0.0) * edges[1, i]
        return np.asarray(total)


def mover_of(one: Avoidance, origin: Sequence[Fraction]) -> Mover:
    """A set over time, without the clearance, seen from the origin."""
    assert one.course is not None
    normal = np.zeros((len(one.rows), len(origin)))
    for x, row in enumerate(one.rows):
        for i, _, c in row.terms:
            normal[x, i] = float(Fraction(c, row.per))

    still = np.array([float(row.seen_from(origin) / row.per) for row in one.rows])
    growing = np.array([float(g / row.per) for row, g in zip(one.rows, one.growing, strict=True)])

    def bounds(leg: Leg, t: Fraction) -> Array:
        assert one.course is not None
        found = np.repeat((still + growing * float(one.course.growth(t)))[:, None], len(leg.places), axis=1)
        for c, by in enumerate(leg.at(t)):
            for i, d in enumerate(by):
                found[:, c] += normal[:, i] * float(d)
        return found

    legs = one.course.legs
    stages = [Stage(float(leg.begin), float(leg.end), bounds(leg, leg.begin), bounds(leg, leg.end)) for leg in legs]
    return Mover(one.name, normal, tuple(stages))
