"""P4 for a set that moves, or is unsafe only at times: constraints whose bounds are linear in time, leg by leg.

On a leg every bound of a constraint is linear in time, one for each displacement of the set, so it has Bezier coefficients like
the edges. A constraint holds on a piece where every coefficient of its left side is at least that of every bound. A piece in
which a leg begins or ends is cut there, exactly. Where the set is safe nothing is required. The lemmas `moving.*` prove this.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.slack import UNIT, ZERO, ConstraintBlock, LocatedSlack, Pieces, PieceSlack, slack_by_piece
from stt_codegen.constraints import Avoidance
from stt_codegen.designs import RefinedDesign
from stt_codegen.task.sets import Leg

UNREQUIRED_SLACK = 1 << 400  # the slack where nothing is required, far above any other
LARGEST_INT = 1 << 62  # of 64 bits, so that a sum does not overflow


@dataclass(frozen=True)
class MovingBounds:
    """The bounds of a set's constraints, clearance included, on one leg from `begin` to `end`.

    A bound is (constant + slope t) / denominator for each constraint and displacement, (R, C) whole numbers. Times are in parts
    of a unit of time, bounds in a unit of length, both chosen by the caller.
    """

    begin: Fraction
    end: Fraction
    constant: npt.NDArray[Any]
    slope: npt.NDArray[Any]
    denominator: int

    @classmethod
    def of(cls, avoidance: Avoidance, leg: Leg, time: Fraction = UNIT, length: Fraction = UNIT) -> MovingBounds:
        """Return bound + clearance + n.d(t) + growth_rate growth(t), by constraints and displacements.

        The numbers are whole for speed, because a motion may have many legs. time, length: the units.
        """
        (first, last), common = _bounds_at_ends(avoidance, leg, length)
        a, b = (t / time for t in (leg.begin, leg.end))
        span = b - a
        rise = (last - first) * (span.denominator * a.denominator)
        constant = first * (span.numerator * a.denominator) - (last - first) * (span.denominator * a.numerator)
        denominator = common * span.numerator * a.denominator
        divisor = math.gcd(denominator, *map(int, rise.ravel()), *map(int, constant.ravel()))
        return cls(a, b, constant // divisor, rise // divisor, denominator // divisor)

    def at(self, t: Fraction) -> list[list[Fraction]]:
        """Return the bounds at a time, by constraints and displacements."""
        return [
            [(c + s * t) / self.denominator for c, s in zip(*pair, strict=True)]
            for pair in zip(self.constant.tolist(), self.slope.tolist(), strict=True)
        ]

    def bounds(self, times: npt.NDArray[Any], per: int) -> Any:
        """Return the smallest whole numbers not below any bound, at the times (P, 4) / per: shape (P, R, 4)."""
        latest = max(1, int(np.abs(times).max()))  # at time 0 the slope itself must fit too
        largest = max(map(abs, self.constant.ravel())) * per + max(map(abs, self.slope.ravel())) * latest
        kind: Any = np.int64 if max(largest, self.denominator * per) < LARGEST_INT else object
        constant, slope = (v.astype(kind)[None, :, :, None] for v in (self.constant * per, self.slope))
        value = -((constant + slope * times.astype(kind)[:, None, None, :]) // -(self.denominator * per))
        return value.max(axis=2)


def _bounds_at_ends(avoidance: Avoidance, leg: Leg, length: Fraction) -> tuple[list[npt.NDArray[Any]], int]:
    """Return the bounds at the begin and at the end of a leg, (R, C) whole numbers, and their common denominator.

    Bounds are in units of `length`.
    """
    assert avoidance.course is not None
    pairs = list(zip(avoidance.alternatives, avoidance.growth_rates, strict=True))
    growths = [avoidance.course.growth(t) for t in (leg.begin, leg.end)]
    still = [[(c.bound + c.clearance + rate * growth) / length for c, rate in pairs] for growth in growths]
    moved = [[[v / length for v in displacement[k]] for displacement in leg.displacements] for k in (0, 1)]
    common = math.lcm(*(v.denominator for values in (*still, *(d for end in moved for d in end)) for v in values))
    n = 1 + max(i for constraint in avoidance.alternatives for i, _, _ in constraint.terms)
    normal = np.zeros((len(avoidance.alternatives), n), dtype=object)
    for r, constraint in enumerate(avoidance.alternatives):
        for i, _, c in constraint.terms:
            normal[r, i] = c
    at_ends = []
    for bounds, displacements in zip(still, moved, strict=True):
        scaled = np.array([[int(v * common) for v in displacement[:n]] for displacement in displacements], dtype=object)
        at_ends.append(np.array([int(v * common) for v in bounds], dtype=object)[:, None] + normal @ scaled.T)
    return at_ends, common


@dataclass(frozen=True, kw_only=True)
class MovingBlock(ConstraintBlock):
    """The constraints of one set, of which one must hold at every moment at which the set may be unsafe."""

    moving_bounds: tuple[MovingBounds, ...]

    @classmethod
    def of_set(cls, avoidance: Avoidance, design: RefinedDesign) -> MovingBlock:
        """Return the block of a set that moves, in spline time and units of the table."""
        plain, course = ConstraintBlock.choice([avoidance], design.unit), avoidance.course
        assert course is not None
        segment = design.prescribed_time / design.segments
        moving_bounds = tuple(MovingBounds.of(avoidance, leg, segment, design.unit) for leg in course.legs)
        return cls(
            constraints=plain.constraints,
            coefficient=plain.coefficient,
            bound=plain.bound,
            slack_per_distance=plain.slack_per_distance,
            first=plain.first,
            names=plain.names,
            moving_bounds=moving_bounds,
        )

    def slack_by_constraint(self, pieces: Pieces, begin: Fraction = ZERO, length: Fraction = UNIT) -> Any:
        """Return the slack of every constraint on every piece, the smallest over all legs: (P, R), whole units.

        begin: of the first piece, in spline time. length: of each piece; 0 where the pieces are one point.
        """
        slack = np.full((len(pieces), len(self.constraints)), UNREQUIRED_SLACK, dtype=object)
        for bounds in self.moving_bounds:
            if length:
                self._lower_by_leg(slack, pieces, bounds, begin, length)
            elif bounds.begin <= begin <= bounds.end:
                times = np.array([[begin.numerator] * 4])
                slack[0] = np.minimum(slack[0], self._slack(pieces, bounds, times, begin.denominator)[0])
        return slack

    def _lower_by_leg(
        self, slack: npt.NDArray[Any], pieces: Pieces, bounds: MovingBounds, begin: Fraction, length: Fraction
    ) -> None:
        """Lower `slack` (P, R) to what one leg leaves: on pieces within the leg at once, on those that it cuts part by part."""
        first, last = (bounds.begin - begin) / length, (bounds.end - begin) / length
        inside = range(max(math.ceil(first), 0), min(math.floor(last), len(pieces)))
        if inside:
            per = 3 * math.lcm(begin.denominator, length.denominator)
            step, start = int(length * per) // 3, int(begin * per)
            times = start + step * (3 * np.arange(inside.start, inside.stop)[:, None] + np.arange(4))
            within = slice(inside.start, inside.stop)
            slack[within] = np.minimum(slack[within], self._slack(pieces[within], bounds, times, per))
        for k in {math.floor(first), math.floor(last)} - set(inside):
            a, b = max(Fraction(k), first), min(Fraction(k + 1), last)
            if 0 <= k < len(pieces) and a < b:
                part = cut(pieces[k].astype(object), a - k, b - k)
                slack[k] = np.minimum(slack[k], self._slack_of_part(part, bounds, begin + length * a, begin + length * b))

    def _slack_of_part(self, part: Pieces, bounds: MovingBounds, begin: Fraction, end: Fraction) -> Any:
        """Return the slack of every constraint on a part of a piece, from `begin` to `end` in spline time: (R,)."""
        moments = [begin + (end - begin) * Fraction(j, 3) for j in range(4)]
        per = math.lcm(*(t.denominator for t in moments))
        times = np.array([[int(t * per) for t in moments]], dtype=object)
        return self._slack(part[None], bounds, times, per)[0]

    def _slack(self, pieces: Pieces, bounds: MovingBounds, times: npt.NDArray[Any], per: int) -> Any:
        """Return the slack of every constraint on pieces whose Bezier coefficients belong to times / per: (P, R), whole units."""
        slack = (self.left_side(pieces) - bounds.bounds(times, per)).min(axis=-1)
        return (slack // self.slack_per_distance).astype(object)


def cut(piece: Pieces, a: Fraction, b: Fraction) -> Pieces:
    """Return the Bezier coefficients of cubics (the last axis) from share a to share b of their piece: values of the blossom."""

    def blossom(*shares: Fraction) -> Any:
        c = [piece[..., j] for j in range(4)]
        for share in shares:
            c = [u + share * (v - u) for u, v in pairwise(c)]
        return c[0]

    return np.stack([blossom(a, a, a), blossom(a, a, b), blossom(a, b, b), blossom(b, b, b)], axis=-1)


def moving_slack_by_piece(avoidance: Avoidance, design: RefinedDesign, required: Fraction) -> Iterator[PieceSlack]:
    """Yield every piece of the tube with the slack of a moving set's constraints, halved where no single normal is enough."""
    yield from slack_by_piece(design.bezier(), MovingBlock.of_set(avoidance, design), required)


def smallest_moving_slack(avoidance: Avoidance, design: RefinedDesign, required: Fraction) -> LocatedSlack:
    """Return the smallest slack of a moving set, with its interval and its constraint."""
    pieces = moving_slack_by_piece(avoidance, design, required)
    slack, begin, end, constraint = min((int(p.slack.max()), p.begin, p.end, int(p.slack.argmax())) for p in pieces)
    return LocatedSlack(Fraction(slack), (begin, end), constraint, 0)
