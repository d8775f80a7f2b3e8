"""The least slack of rows over the pieces of a spline, in exact integers.

A cubic lies within the hull of its Bezier coefficients, and so does every row, which is linear in the edges; where that is too
coarse the piece is halved by de Casteljau's rule, exactly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.constraints import Avoidance, Constraint
from stt_codegen.designs import COEFFICIENT_BIT_LIMIT

ZERO, ONE = Fraction(0), Fraction(1)
DEPTH = 20  # a piece is halved at most this often before its property counts as failed
CHUNK = 1 << 20  # rows times pieces that are looked at together
LARGEST_BEZIER = 6 << COEFFICIENT_BIT_LIMIT  # of a coefficient, in units of the table

Found = tuple[Fraction, Fraction, npt.NDArray[Any]]  # from, to, and the slack of every row
Pieces = npt.NDArray[Any]  # Bezier coefficients (P, n, 2, 4): int64, or Fraction objects once halved


@dataclass(frozen=True)
class Least:
    """Least slack in units of the table: where, in spline time, and of which row and set."""

    slack: Fraction
    interval: tuple[Fraction, Fraction]
    row: int
    choice: int


@dataclass(frozen=True)
class RowBlock:
    """Rows in units of the table. coefficient (R, n, 2), bound (R,): whole numbers, bounds rounded up. first: of a choice of
    rows, where each set's begin; else every row must hold. names: of the sets."""

    rows: tuple[Constraint, ...]
    coefficient: npt.NDArray[Any]
    bound: npt.NDArray[Any]
    per: npt.NDArray[Any]
    first: npt.NDArray[np.int64]
    names: tuple[str, ...]

    @classmethod
    def of(cls, rows: Sequence[Constraint], unit: Fraction) -> RowBlock:
        """A block whose rows must all hold."""
        return cls._made(tuple(rows), unit, list(range(len(rows))), ())

    @classmethod
    def choice(cls, sets: Sequence[Avoidance], unit: Fraction) -> RowBlock:
        """A block of which, for each unsafe set, one row must hold at every moment."""
        rows = [row for one in sets for row in one.alternatives]
        first = np.cumsum([0, *(len(one.alternatives) for one in sets[:-1])]).tolist()
        return cls._made(tuple(rows), unit, first, tuple(one.name for one in sets))

    @classmethod
    def _made(cls, rows: tuple[Constraint, ...], unit: Fraction, first: list[int], names: tuple[str, ...]) -> RowBlock:
        n = 1 + max(i for row in rows for i, _, _ in row.terms)
        bound = [units_above(row.bound + row.clearance if row.clearance else row.bound, unit) for row in rows]
        largest = max(row.size for row in rows) * LARGEST_BEZIER + max(map(abs, bound))
        kind: Any = np.int64 if largest < 1 << 62 else object
        coefficient = np.zeros((len(rows), n, 2), dtype=kind)
        for r, row in enumerate(rows):
            for i, side, c in row.terms:
                coefficient[r, i, side] = c
        return cls(
            rows,
            coefficient,
            np.array(bound, dtype=kind),
            np.array([row.slack_per_distance for row in rows]),
            np.array(first),
            names,
        )

    @cached_property
    def single(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]] | None:
        """Rows, dimensions and sides, where each row is plus or minus one edge; else None."""
        rows, dimensions, sides = np.nonzero(self.coefficient)
        plain = len(rows) == len(self.rows) and bool((np.abs(self.coefficient[rows, dimensions, sides]) == 1).all())
        return (self.coefficient[rows, dimensions, sides].astype(np.int64), dimensions, sides) if plain else None

    def slack(self, pieces: Pieces) -> tuple[Any, Any]:
        """For every piece the least slack over the rows (or sets), told as a distance and rounded down, and its row: both
        (P,)."""
        left = self.told(pieces)
        if not self.names:
            worst = left.argmin(axis=1)
            return left[np.arange(len(left)), worst], worst
        best = np.maximum.reduceat(left, self.first, axis=1)  # (P, J)
        j = best.argmin(axis=1)
        slack = best[np.arange(len(left)), j]
        ends = np.append(self.first[1:], len(self.rows))
        chosen = [int(self.first[a] + left[p, self.first[a] : ends[a]].argmax()) for p, a in enumerate(j.tolist())]
        return slack, np.array(chosen)

    def told(self, pieces: Pieces, _begin: Fraction = ZERO, _length: Fraction = ONE) -> Any:
        """The slack of every row on every piece, told as a distance, whole units of the table rounded down: (P, R). For sets that
        move: _begin of the first piece, in spline time; _length of each, one after the other."""
        left = self._left(pieces) - self.bound
        if (self.per != 1).any():
            left = left // self.per if pieces.dtype == np.int64 else left * Fraction(1) / self.per
        return left

    def told_of(self, told: Any) -> Any:
        """The least of `told` over rows that must all hold, the best over those of one set: (P,)."""
        return told.max(axis=1) if self.names else told.min(axis=1)

    def _left(self, pieces: Pieces) -> Any:
        """The least of the left side's Bezier coefficients: (P, R)."""
        if self.single is not None:
            sign, dimensions, sides = self.single
            low, high = pieces.min(axis=3), pieces.max(axis=3)
            return np.where(sign > 0, low[:, dimensions, sides], -high[:, dimensions, sides])
        return self.values(pieces).min(axis=-1)

    def values(self, pieces: Pieces) -> Any:
        """The left side's Bezier coefficients, (P, R, 4)."""
        if self.single is not None:
            sign, dimensions, sides = self.single
            return sign[:, None] * pieces[:, dimensions, sides]
        n = self.coefficient.shape[1]
        edges, rows = pieces[:, :n].reshape(len(pieces), 2 * n, 4), self.coefficient.reshape(len(self.rows), 2 * n)
        total: Any = 0
        for k in range(2 * n):
            total = total + rows[None, :, k, None] * edges[:, None, k]
        return total

    def set_of(self, row: int) -> int:
        """The number of the set that a row belongs to."""
        return int(np.searchsorted(self.first, row, side="right")) - 1


def least_slack(bezier: npt.NDArray[np.int64], block: RowBlock, unit_error: Fraction) -> Least:
    """The least slack of the rows over all segments, halving those whose hull does not show what an error of `unit_error` (in
    units of the table) in every edge may take. Pieces are looked at CHUNK rows at a time, so that memory stays small."""
    required = unit_error * max(Fraction(*pair) for pair in {(row.size, row.slack_per_distance) for row in block.rows})
    each = max(1, CHUNK // max(1, len(block.rows)))
    parts = [block.slack(bezier[k : k + each]) for k in range(0, len(bezier), each)]
    slack, row = (np.concatenate([part[q] for part in parts]) for q in (0, 1))

    def interval(k: int) -> tuple[Fraction, Fraction]:
        return Fraction(k), Fraction(k + 1)

    sound = slack >= math.ceil(required)  # whole numbers
    doubtful = np.nonzero(~sound)[0].tolist()
    candidates = [_halve(bezier[k].astype(object), interval(k), block, required, DEPTH) for k in doubtful]
    if sound.any():
        k = int(np.where(sound, slack, slack.max() + 1).argmin())
        candidates.append(_least_of(block, slack[k], interval(k), row[k]))
    return min(candidates, key=lambda c: c.slack)


def _halve(piece: Pieces, interval: tuple[Fraction, Fraction], block: RowBlock, required: Fraction, depth: int) -> Least:
    """Least slack of one piece (shape (n, 2, 4)) by halving until the hull shows `required` or `depth` is used up; the
    slack at one failing point as soon as one is met."""
    slack, row = block.slack(piece[None])
    if slack[0] >= required or depth == 0:
        return _least_of(block, slack[0], interval, row[0])
    at_start = block.slack(np.repeat(piece[None, ..., :1], 4, axis=-1))
    if at_start[0][0] < required:  # the curve itself fails here: halving cannot help
        return _least_of(block, at_start[0][0], (interval[0], interval[0]), at_start[1][0])
    early, late = halves(piece * Fraction(1))
    middle = (interval[0] + interval[1]) / 2
    first = _halve(early, (interval[0], middle), block, required, depth - 1)
    second = _halve(late, (middle, interval[1]), block, required, depth - 1)
    return first if first.slack <= second.slack else second


def pieces_of(bezier: npt.NDArray[np.int64], block: RowBlock, required: Fraction) -> list[Found]:
    """Every segment with the slack of every row, told as a distance; halved where its hull does not show what is required."""
    slack = block.told(bezier)
    shown = block.told_of(slack) >= required
    result: list[Found] = []
    for k, good in enumerate(shown.tolist()):
        if good:
            result.append((Fraction(k), Fraction(k + 1), slack[k]))
        else:
            result += _halved(bezier[k].astype(object), Fraction(k), Fraction(1), block, required, DEPTH)
    return result


def _halved(piece: Pieces, begin: Fraction, length: Fraction, block: RowBlock, required: Fraction, depth: int) -> list[Found]:
    """A piece of shape (n, 2, 4), in halves until the hull shows what is required; whole where the curve itself lacks it."""
    slack = block.told(piece[None], begin, length)
    lacks = block.told_of(block.told(np.repeat(piece[None, ..., :1], 4, axis=-1), begin, ZERO))[0] < required
    if lacks or depth == 0 or block.told_of(slack)[0] >= required:
        return [(begin, begin + length, slack[0])]
    early, late = halves(piece * Fraction(1))
    first = _halved(early, begin, length / 2, block, required, depth - 1)
    return first + _halved(late, begin + length / 2, length / 2, block, required, depth - 1)


def halves(piece: Pieces) -> tuple[Pieces, Pieces]:
    """The Bezier coefficients of both halves of cubics (the last axis), by de Casteljau's rule."""
    c0, c1, c2, c3 = (piece[..., j] for j in range(4))
    a, b, c = (c0 + c1) / 2, (c1 + c2) / 2, (c2 + c3) / 2
    d, e = (a + b) / 2, (b + c) / 2
    f = (d + e) / 2
    return np.stack([c0, a, d, f], axis=-1), np.stack([f, e, c, c3], axis=-1)


def _least_of(block: RowBlock, slack: Any, interval: tuple[Fraction, Fraction], row: Any) -> Least:
    exact = slack if isinstance(slack, Fraction) else Fraction(int(slack))
    return Least(exact, interval, int(row), block.set_of(int(row)))


def units_above(value: Fraction, unit: Fraction) -> int:
    """The least whole number of units that is not below the value."""
    return -(-value.numerator * unit.denominator // (value.denominator * unit.numerator))
