"""P4 for a set that moves, or is unsafe only at times: rows whose bounds are lines in time, leg by leg.

On a leg every bound of a row is linear, one for each place, so it has Bezier coefficients like the edges: a row holds on a piece
where every coefficient of its left side is at least that of every bound. A piece in which something turns is cut there, exactly;
where the set is safe nothing is asked.
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

from stt_codegen.certify.slack import ONE, ZERO, Found, Least, Pieces, RowBlock, pieces_of
from stt_codegen.constraints import Avoidance
from stt_codegen.designs import RefinedDesign
from stt_codegen.task.sets import Leg

FREE = 1 << 400  # the slack where nothing is asked, far above any other
LARGEST = 1 << 62  # of whole numbers of 64 bits, with room for a sum


@dataclass(frozen=True)
class Lines:
    """The bounds of a set's rows, clearance included, while nothing turns, from `begin` to `end`: (constant + slope t) / whole
    for each row and place, (R, C) whole numbers. Times in parts of a unit of time, bounds in a unit of length, as asked for."""

    begin: Fraction
    end: Fraction
    constant: npt.NDArray[Any]
    slope: npt.NDArray[Any]
    whole: int

    @classmethod
    def of(cls, one: Avoidance, leg: Leg, time: Fraction = ONE, length: Fraction = ONE) -> Lines:
        """bound + keep + n.d(t) + growing growth(t), by rows and places; in whole numbers, for a motion may have many turns."""
        assert one.course is not None
        ends, pairs = (leg.begin, leg.end), list(zip(one.alternatives, one.growth_rates, strict=True))
        grown = [one.course.growth(t) for t in ends]
        still = [[(row.bound + row.clearance + g * more) / length for row, g in pairs] for more in grown]
        moved = [[[v / length for v in place[e]] for place in leg.displacements] for e in (0, 1)]
        common = math.lcm(*(v.denominator for told in (*still, *(p for end in moved for p in end)) for v in told))
        n = 1 + max(i for row in one.alternatives for i, _, _ in row.terms)
        normal = np.zeros((len(one.alternatives), n), dtype=object)
        for r, row in enumerate(one.alternatives):
            for i, _, c in row.terms:
                normal[r, i] = c
        values = []
        for told, end in zip(still, moved, strict=True):
            places = np.array([[int(v * common) for v in place[:n]] for place in end], dtype=object)
            values.append(np.array([int(v * common) for v in told], dtype=object)[:, None] + normal @ places.T)
        a, b = (t / time for t in ends)
        span = b - a
        rise = (values[1] - values[0]) * (span.denominator * a.denominator)
        constant = values[0] * (span.numerator * a.denominator) - (values[1] - values[0]) * (span.denominator * a.numerator)
        whole = common * span.numerator * a.denominator
        shared = math.gcd(whole, *map(int, rise.ravel()), *map(int, constant.ravel()))
        return cls(a, b, constant // shared, rise // shared, whole // shared)

    def at(self, t: Fraction) -> list[list[Fraction]]:
        """The bounds at a time, by rows and places."""
        return [
            [(c + s * t) / self.whole for c, s in zip(*pair, strict=True)]
            for pair in zip(self.constant.tolist(), self.slope.tolist(), strict=True)
        ]

    def bounds(self, places: npt.NDArray[Any], per: int) -> Any:
        """The least whole numbers that are no less than any bound, at the times places / per, (P, 4): shape (P, R, 4)."""
        farthest = max(1, int(np.abs(places).max()))  # at time 0 the slope itself must fit too
        most = max(map(abs, self.constant.ravel())) * per + max(map(abs, self.slope.ravel())) * farthest
        kind: Any = np.int64 if max(most, self.whole * per) < LARGEST else object
        constant, slope = (v.astype(kind)[None, :, :, None] for v in (self.constant * per, self.slope))
        value = -((constant + slope * places.astype(kind)[:, None, None, :]) // -(self.whole * per))
        return value.max(axis=2)


@dataclass(frozen=True)
class MovingBlock(RowBlock):
    """The rows of one set, of which one must hold at every moment at which it may be unsafe."""

    lines: tuple[Lines, ...]

    @classmethod
    def moving(cls, one: Avoidance, design: RefinedDesign) -> MovingBlock:
        plain, course = RowBlock.choice([one], design.unit), one.course
        assert course is not None
        segment = design.prescribed_time / design.segments
        lines = [Lines.of(one, leg, segment, design.unit) for leg in course.legs]
        return cls(plain.rows, plain.coefficient, plain.bound, plain.per, plain.first, plain.names, tuple(lines))

    def told(self, pieces: Pieces, begin: Fraction = ZERO, length: Fraction = ONE) -> Any:
        found = np.full((len(pieces), len(self.rows)), FREE, dtype=object)
        for line in self.lines:
            if not length:
                if line.begin <= begin <= line.end:
                    found[0] = np.minimum(
                        found[0], self._slack(pieces, line, np.array([[begin.numerator] * 4]), begin.denominator)[0]
                    )
                continue
            first, last = (line.begin - begin) / length, (line.end - begin) / length
            inside = range(max(math.ceil(first), 0), min(math.floor(last), len(pieces)))
            if inside:
                whole = 3 * math.lcm(begin.denominator, length.denominator)
                step, start = int(length * whole) // 3, int(begin * whole)
                places = start + step * (3 * np.arange(inside.start, inside.stop)[:, None] + np.arange(4))
                here = slice(inside.start, inside.stop)
                found[here] = np.minimum(found[here], self._slack(pieces[here], line, places, whole))
            for k in {math.floor(first), math.floor(last)} - set(inside):
                a, b = max(Fraction(k), first), min(Fraction(k + 1), last)
                if 0 <= k < len(pieces) and a < b:
                    found[k] = np.minimum(found[k], self._part(pieces[k], line, begin + k * length, length, a - k, b - k))
        return found

    def _part(self, piece: Pieces, line: Lines, begin: Fraction, length: Fraction, a: Fraction, b: Fraction) -> Any:
        """The slack of every row on a part of a piece, from the share a to the share b of it."""
        times = [begin + length * (a + (b - a) * Fraction(j, 3)) for j in range(4)]
        per = math.lcm(*(t.denominator for t in times))
        places = np.array([[int(t * per) for t in times]], dtype=object)
        return self._slack(cut(piece.astype(object), a, b)[None], line, places, per)[0]

    def _slack(self, pieces: Pieces, line: Lines, places: npt.NDArray[Any], per: int) -> Any:
        """The slack of every row on pieces whose Bezier coefficients belong to the times places / per: (P, R), whole units."""
        left = (self.values(pieces) - line.bounds(places, per)).min(axis=-1)
        return (left // self.per).astype(object)


def cut(piece: Pieces, a: Fraction, b: Fraction) -> Pieces:
    """The Bezier coefficients of cubics (the last axis) from the share a to the share b of their piece: values of the blossom."""

    def blossom(*s: Fraction) -> Any:
        c = [piece[..., j] for j in range(4)]
        for share in s:
            c = [u + share * (v - u) for u, v in pairwise(c)]
        return c[0]

    return np.stack([blossom(a, a, a), blossom(a, a, b), blossom(a, b, b), blossom(b, b, b)], axis=-1)


def moving_pieces(one: Avoidance, design: RefinedDesign, required: Fraction) -> Iterator[Found]:
    """Every piece of the tube with the slack of every row of a moving set, halved where one normal does not do."""
    yield from pieces_of(design.bezier(), MovingBlock.moving(one, design), required)


def least_moving(one: Avoidance, design: RefinedDesign, required: Fraction) -> Least:
    """The least slack of a moving set, and the number of its row."""
    found = ((int(slack.max()), a, b, int(slack.argmax())) for a, b, slack in moving_pieces(one, design, required))
    slack, a, b, row = min(found)
    return Least(Fraction(slack), (a, b), row, 0)
