"""Sets in time: where an unsafe set may be while the tube is somewhere.

    U(tau) = C + d(tau) + spread tau,  tau in `during`          tau: the time on the sets' clock
    t - timing <= tau <= t + start_delay + timing               t: the time on the controller's

d is piecewise linear, constant before its first entry and after its last. So at the controller's time t the set may be at any
place of a path; between two times at which nothing turns (a leg) the corners of that path move evenly or stand. A half-space
that holds the set at these corners holds it at all places between. Everything is in exact fractions.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise

from stt_codegen.task.sets.convex_sets import ZERO, Bend, ConvexSet, Normal, Shadow, Vector

Knot = tuple[Fraction, Vector]  # a time on the sets' clock, and the displacement then

Window = tuple[Fraction, Fraction]  # from and to, on the sets' clock


@dataclass(frozen=True)
class Leg:
    """From one time of the controller's to another, both closed: the set may be displaced by the hull of these places, each from
    where it is at the begin evenly to where it is at the end."""

    begin: Fraction
    end: Fraction
    places: tuple[tuple[Vector, Vector], ...]

    def at(self, t: Fraction) -> tuple[Vector, ...]:
        """The places at a time of the leg."""
        share = (t - self.begin) / (self.end - self.begin)
        return tuple(tuple(v + share * (w - v) for v, w in zip(a, b, strict=True)) for a, b in self.places)


@dataclass(frozen=True, kw_only=True)
class Course:
    """How one set moves, in seconds and the task's units. knots: displacements, in all dimensions; window: the sets' times in
    which it is unsafe; early, late: by how much the sets' clock may be behind and ahead of the controller's; spread: what it
    grows by in a second; t_c."""

    knots: tuple[Knot, ...]
    window: Window | None
    early: Fraction
    late: Fraction
    spread: Fraction
    t_c: Fraction

    def displaced(self, tau: Fraction) -> Vector:
        """d at a time on the sets' clock."""
        knots = self.knots
        k = bisect_left(knots, tau, key=lambda knot: knot[0])
        if k in (0, len(knots)):
            return knots[min(k, len(knots) - 1)][1]
        (a, here), (b, there) = knots[k - 1], knots[k]
        return tuple(v + (tau - a) / (b - a) * (w - v) for v, w in zip(here, there, strict=True))

    def unsafe_at(self, tau: Fraction) -> bool:
        """Whether the set is unsafe at a time on its clock; a window that ends at t_c stays closed."""
        first, last = self.window or (ZERO, self.t_c)
        return self.window is None or (first <= tau and (tau <= last or last == self.t_c))

    def growth(self, t: Fraction) -> Fraction:
        """What the set may have grown by at a time of the controller's."""
        return self.spread * (t + self.late)

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The controller's times up to t_c at which the set may be unsafe, one leg after the other."""
        first, last = self.window or (-self.early, self.t_c + self.late)
        begin, end = max(ZERO, first - self.late), min(self.t_c, last + self.early)
        turns = sorted({first, last, *(at for at, _ in self.knots if first < at < last)})

        def place(tau: Fraction) -> Vector:
            return self.displaced(min(max(tau, first), last))

        cuts = {v for tau in turns for v in (tau + self.early, tau - self.late) if begin < v < end}
        found = []
        for a, b in pairwise(sorted({begin, end, *cuts})):
            between = [(place(tau), place(tau)) for tau in turns if b - self.early <= tau <= a + self.late]
            ends = [(place(a + s), place(b + s)) for s in (-self.early, self.late)]
            found.append(Leg(a, b, tuple(dict.fromkeys([*ends, *between]))))
        return tuple(found)

    @property
    def moves(self) -> bool:
        """Whether it is ever displaced from where it was first."""
        return any(by != self.knots[0][1] for _, by in self.knots)


@lru_cache(maxsize=1024)
def course_of(
    knots: tuple[Knot, ...],
    window: tuple[Fraction, Fraction] | None,
    early: Fraction,
    late: Fraction,
    spread: Fraction,
    t_c: Fraction,
) -> Course:
    """The course, the same object for the same numbers: its legs are found once."""
    return Course(knots=knots, window=window, early=early, late=late, spread=spread, t_c=t_c)


class Moved(ConvexSet):
    """A set displaced."""

    def __init__(self, inner: ConvexSet, by: Vector) -> None:
        self.inner, self.by, self.name = inner, by, inner.name

    def _shifted(self, point: Vector) -> Vector:
        return tuple(v + d for v, d in zip(point, self.by, strict=True))

    def _back(self, point: Vector) -> Vector:
        return tuple(v - d for v, d in zip(point, self.by, strict=True))

    @property
    def dimension(self) -> int:
        return self.inner.dimension

    @property
    def bounded_axes(self) -> tuple[int, ...]:
        return self.inner.bounded_axes

    @property
    def normals(self) -> tuple[Normal, ...]:
        return self.inner.normals

    def support(self, normal: Normal) -> Fraction:
        return self.inner.support(normal) + sum((c * d for c, d in zip(normal, self.by, strict=True) if c), ZERO)

    @property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(map(self._shifted, self.inner.vertices))

    @property
    def bends(self) -> tuple[Bend, ...]:
        return tuple((self._shifted(point), signs) for point, signs in self.inner.bends)

    @property
    def radius(self) -> Fraction:
        return self.inner.radius

    @property
    def line(self) -> tuple[Vector, Vector]:
        first, last = self.inner.line
        return self._shifted(first), self._shifted(last)

    def shadow(self, i: int, j: int) -> Shadow:
        a, b = float(self.by[i]), float(self.by[j])
        return [(x + a, y + b) for x, y in self.inner.shadow(i, j)]

    def apart(self, lower: Vector, upper: Vector) -> bool:
        return self.inner.apart(self._back(lower), self._back(upper))

    def covers(self, lower: Vector, upper: Vector) -> bool:
        return self.inner.covers(self._back(lower), self._back(upper))


def places(convex: ConvexSet, course: Course | None, t: Fraction) -> list[ConvexSet]:
    """Where a set may be at a time of the controller's, as large as it may be, at the corners of the path that it may be on; none
    while it is safe."""
    if course is None:
        return [convex]
    found = dict.fromkeys(by for leg in course.legs if leg.begin <= t <= leg.end for by in leg.at(t))
    grown = convex.spread(course.growth(t)) if course.spread else convex
    return [Moved(grown, by) for by in found]
