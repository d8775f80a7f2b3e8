"""Sets in time: where an unsafe set may be at a time of the controller.

    U(tau) = C + d(tau) + spread tau,  tau in the active interval      tau: the time on the sets' clock
    t - clock_lag <= tau <= t + clock_lead                             t: the time on the controller's clock

The displacement d is piecewise linear, and constant before its first knot and after its last. So at time t the set may be
anywhere along a path. The time splits into legs: during a leg the corners of that path stand still or move at constant velocity.
A half-space that holds the set at these corners holds it everywhere along the path (lemmas "moving.*", docs/lemmas.md).

Design, certificate, closed loop and pictures read the courses of a task. All numbers are exact fractions.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise

from stt_codegen.task.sets.convex_sets import ZERO, ConvexSet, Normal, PlanePoints, RouteCorner, Vector

Knot = tuple[Fraction, Vector]  # a time on the sets' clock, and the displacement then
ActiveInterval = tuple[Fraction, Fraction]  # first and last time on the sets' clock


@dataclass(frozen=True)
class Leg:
    """An interval of the controller's time, closed, in which the set is displaced by the hull of a few displacements.

    Each pair in `displacements` is one corner of that hull: the displacement at `begin` and the one at `end`, linear between.
    """

    begin: Fraction
    end: Fraction
    displacements: tuple[tuple[Vector, Vector], ...]

    def displacements_at(self, t: Fraction) -> tuple[Vector, ...]:
        """Return the corners of the hull of displacements at time t of the leg."""
        share = (t - self.begin) / (self.end - self.begin)
        return tuple(tuple(v + share * (w - v) for v, w in zip(a, b, strict=True)) for a, b in self.displacements)


@dataclass(frozen=True, kw_only=True)
class Course:
    """How one set moves and when it is active, in seconds and in the task's units.

    knots: displacements in all dimensions, by time; active_interval: when the set is unsafe, None for always; clock_lag and
    clock_lead: how far the sets' clock may be behind and ahead of the controller's; spread: growth per second on every side; t_c:
    the prescribed time.
    """

    knots: tuple[Knot, ...]
    active_interval: ActiveInterval | None
    clock_lag: Fraction
    clock_lead: Fraction
    spread: Fraction
    t_c: Fraction

    def displacement(self, tau: Fraction) -> Vector:
        """Return d(tau), tau on the sets' clock."""
        knots = self.knots
        k = bisect_left(knots, tau, key=lambda knot: knot[0])
        if k in (0, len(knots)):
            return knots[min(k, len(knots) - 1)][1]
        (a, before), (b, after) = knots[k - 1], knots[k]
        return tuple(v + (tau - a) / (b - a) * (w - v) for v, w in zip(before, after, strict=True))

    def is_unsafe_at(self, tau: Fraction) -> bool:
        """Whether the set is unsafe at tau on its clock; an active interval that ends at t_c never ends."""
        first, last = self.active_interval or (ZERO, self.t_c)
        return self.active_interval is None or (first <= tau and (tau <= last or last == self.t_c))

    def growth(self, t: Fraction) -> Fraction:
        """Return the most that the set can have grown on a side by time t of the controller."""
        return self.spread * (t + self.clock_lead)

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """The legs, in order, that cover every time of the controller up to t_c at which the set may be unsafe."""
        first, last = self.active_interval or (-self.clock_lag, self.t_c + self.clock_lead)
        begin, end = max(ZERO, first - self.clock_lead), min(self.t_c, last + self.clock_lag)
        turns = sorted({first, last, *(at for at, _ in self.knots if first < at < last)})

        def active_displacement(tau: Fraction) -> Vector:
            return self.displacement(min(max(tau, first), last))

        # the path changes its corners when a turn enters or leaves [t - clock_lag, t + clock_lead]
        cuts = {v for tau in turns for v in (tau + self.clock_lag, tau - self.clock_lead) if begin < v < end}
        legs = []
        for a, b in pairwise(sorted({begin, end, *cuts})):
            passed = [active_displacement(tau) for tau in turns if b - self.clock_lag <= tau <= a + self.clock_lead]
            ends = [(active_displacement(a + s), active_displacement(b + s)) for s in (-self.clock_lag, self.clock_lead)]
            legs.append(Leg(a, b, tuple(dict.fromkeys([*ends, *((by, by) for by in passed)]))))
        return tuple(legs)

    @property
    def is_moving(self) -> bool:
        """Whether the set is ever displaced from its first position."""
        return any(by != self.knots[0][1] for _, by in self.knots)


@lru_cache(maxsize=1024)
def course_of(
    *,
    knots: tuple[Knot, ...],
    active_interval: ActiveInterval | None,
    clock_lag: Fraction,
    clock_lead: Fraction,
    spread: Fraction,
    t_c: Fraction,
) -> Course:
    """Return the course of these numbers, the same object for equal numbers, so that its legs are computed once."""
    return Course(
        knots=knots, active_interval=active_interval, clock_lag=clock_lag, clock_lead=clock_lead, spread=spread, t_c=t_c
    )


class DisplacedSet(ConvexSet):
    """A set displaced by a vector."""

    def __init__(self, inner: ConvexSet, by: Vector) -> None:
        self.inner, self.by, self.name = inner, by, inner.name

    def _displaced(self, point: Vector) -> Vector:
        return tuple(v + d for v, d in zip(point, self.by, strict=True))

    def _to_inner(self, point: Vector) -> Vector:
        """Return the point of the inner set's frame that this point is displaced from."""
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
        return tuple(map(self._displaced, self.inner.vertices))

    @property
    def route_corners(self) -> tuple[RouteCorner, ...]:
        return tuple((self._displaced(point), signs) for point, signs in self.inner.route_corners)

    @property
    def radius(self) -> Fraction:
        return self.inner.radius

    @property
    def segment_ends(self) -> tuple[Vector, Vector]:
        first, last = self.inner.segment_ends
        return self._displaced(first), self._displaced(last)

    def projection(self, i: int, j: int) -> PlanePoints:
        a, b = float(self.by[i]), float(self.by[j])
        return [(x + a, y + b) for x, y in self.inner.projection(i, j)]

    def is_apart_from(self, lower: Vector, upper: Vector) -> bool:
        return self.inner.is_apart_from(self._to_inner(lower), self._to_inner(upper))

    def covers(self, lower: Vector, upper: Vector) -> bool:
        return self.inner.covers(self._to_inner(lower), self._to_inner(upper))


def possible_sets(convex: ConvexSet, course: Course | None, t: Fraction) -> list[ConvexSet]:
    """Return the set, grown as far as it may be, at each corner of the path that it may be on at time t of the controller.

    Their hull holds the set. The list is empty while the set is not active."""
    if course is None:
        return [convex]
    displacements = dict.fromkeys(by for leg in course.legs if leg.begin <= t <= leg.end for by in leg.displacements_at(t))
    grown = convex.inflated(course.growth(t)) if course.spread else convex
    return [DisplacedSet(grown, by) for by in displacements]
