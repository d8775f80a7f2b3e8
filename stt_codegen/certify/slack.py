"""The slack of constraints over the pieces of a spline, in exact integers.

A cubic lies within the hull of its Bezier coefficients, and so does every constraint, which is linear in the edges. Where the
hull is too coarse the piece is halved by de Casteljau's rule, exactly. The certificate (exact.py), its claims (claims.py) and
missions use this file; the lemmas `rows.*` and `refined.*` prove it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.constraints import Avoidance, Constraint
from stt_codegen.designs import COEFFICIENT_BIT_LIMIT

ZERO, UNIT = Fraction(0), Fraction(1)
HALVING_LIMIT = 20  # a piece is halved at most this often before its property counts as failed
BATCH_SIZE = 1 << 20  # constraints times pieces that are evaluated together
LARGEST_BEZIER = 6 << COEFFICIENT_BIT_LIMIT  # of a coefficient, in units of the table

Pieces = npt.NDArray[Any]  # Bezier coefficients (P, n, 2, 4): int64, or Fraction objects once halved


class PieceSlack(NamedTuple):
    """A piece of the spline, from `begin` to `end` in spline time, and the slack of every constraint on it, (R,)."""

    begin: Fraction
    end: Fraction
    slack: npt.NDArray[Any]


@dataclass(frozen=True)
class LocatedSlack:
    """A smallest slack in units of the table, with its interval of spline time, its constraint and its set, both from 0."""

    slack: Fraction
    interval: tuple[Fraction, Fraction]
    constraint: int
    set_index: int


@dataclass(frozen=True, kw_only=True)
class ConstraintBlock:
    """Constraints in units of the table.

    coefficient (R, n, 2), bound (R,): whole numbers, bounds rounded up. slack_per_distance (R,): as in `Constraint`. first: where
    the alternatives of each set begin, if one of each set must hold; without sets every constraint must hold. names: of the sets.
    """

    constraints: tuple[Constraint, ...]
    coefficient: npt.NDArray[Any]
    bound: npt.NDArray[Any]
    slack_per_distance: npt.NDArray[Any]
    first: npt.NDArray[np.int64]
    names: tuple[str, ...]

    @classmethod
    def of(cls, constraints: Sequence[Constraint], unit: Fraction) -> ConstraintBlock:
        """Return a block whose constraints must all hold."""
        return cls._build(tuple(constraints), unit, list(range(len(constraints))), ())

    @classmethod
    def choice(cls, sets: Sequence[Avoidance], unit: Fraction) -> ConstraintBlock:
        """Return a block of which one alternative must hold at every moment, for each unsafe set."""
        constraints = [constraint for avoidance in sets for constraint in avoidance.alternatives]
        first = np.cumsum([0, *(len(avoidance.alternatives) for avoidance in sets[:-1])]).tolist()
        return cls._build(tuple(constraints), unit, first, tuple(avoidance.name for avoidance in sets))

    @classmethod
    def _build(
        cls, constraints: tuple[Constraint, ...], unit: Fraction, first: list[int], names: tuple[str, ...]
    ) -> ConstraintBlock:
        """Return a block in 64 bits where no sum overflows, else in Python's whole numbers."""
        n = 1 + max(i for c in constraints for i, _, _ in c.terms)
        bound = [units_above(c.bound + c.clearance if c.clearance else c.bound, unit) for c in constraints]
        largest = max(c.size for c in constraints) * LARGEST_BEZIER + max(map(abs, bound))
        kind: Any = np.int64 if largest < 1 << 62 else object
        coefficient = np.zeros((len(constraints), n, 2), dtype=kind)
        for r, constraint in enumerate(constraints):
            for i, side, c in constraint.terms:
                coefficient[r, i, side] = c
        return cls(
            constraints=constraints,
            coefficient=coefficient,
            bound=np.array(bound, dtype=kind),
            slack_per_distance=np.array([c.slack_per_distance for c in constraints]),
            first=np.array(first),
            names=names,
        )

    @cached_property
    def single(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]] | None:
        """Signs, dimensions and sides, where each constraint is on plus or minus one edge; else None."""
        rows, dimensions, sides = np.nonzero(self.coefficient)
        signs = self.coefficient[rows, dimensions, sides]
        is_single = len(rows) == len(self.constraints) and bool((np.abs(signs) == 1).all())
        return (signs.astype(np.int64), dimensions, sides) if is_single else None

    def slack(self, pieces: Pieces) -> tuple[Any, Any]:
        """Return for every piece the smallest slack over constraints (or sets), and the number of its constraint: both (P,).

        The slack is a distance in whole units, rounded down.
        """
        slack = self.slack_by_constraint(pieces)
        if not self.names:
            worst = slack.argmin(axis=1)
            return slack[np.arange(len(slack)), worst], worst
        best = np.maximum.reduceat(slack, self.first, axis=1)  # (P, J)
        j = best.argmin(axis=1)
        ends = np.append(self.first[1:], len(self.constraints))
        chosen = [int(self.first[a] + slack[p, self.first[a] : ends[a]].argmax()) for p, a in enumerate(j.tolist())]
        return best[np.arange(len(slack)), j], np.array(chosen)

    def slack_by_constraint(self, pieces: Pieces, _begin: Fraction = ZERO, _length: Fraction = UNIT) -> Any:
        """Return the slack of every constraint on every piece as a distance, in whole units rounded down: (P, R).

        For sets that move: _begin of the first piece, in spline time; _length of each piece, one after the other.
        """
        slack = self._smallest_left_side(pieces) - self.bound
        if (self.slack_per_distance != 1).any():
            is_integer = pieces.dtype == np.int64
            slack = slack // self.slack_per_distance if is_integer else slack * Fraction(1) / self.slack_per_distance
        return slack

    def slack_of_block(self, slack: Any) -> Any:
        """Return the smallest slack if all constraints must hold, the largest if they are alternatives of one set: (P,).

        slack: of every constraint on every piece, (P, R).
        """
        return slack.max(axis=1) if self.names else slack.min(axis=1)

    def _smallest_left_side(self, pieces: Pieces) -> Any:
        """Return the smallest Bezier coefficient of every left side on every piece: (P, R)."""
        if self.single is not None:
            sign, dimensions, sides = self.single
            low, high = pieces.min(axis=3), pieces.max(axis=3)
            return np.where(sign > 0, low[:, dimensions, sides], -high[:, dimensions, sides])
        return self.left_side(pieces).min(axis=-1)

    def left_side(self, pieces: Pieces) -> Any:
        """Return the Bezier coefficients of every left side on every piece, (P, R, 4)."""
        if self.single is not None:
            sign, dimensions, sides = self.single
            return sign[:, None] * pieces[:, dimensions, sides]
        n = self.coefficient.shape[1]
        edges = pieces[:, :n].reshape(len(pieces), 2 * n, 4)
        coefficient = self.coefficient.reshape(len(self.constraints), 2 * n)
        total: Any = 0
        for k in range(2 * n):
            total = total + coefficient[None, :, k, None] * edges[:, None, k]
        return total

    def set_of(self, constraint: int) -> int:
        """Return the number of the set that a constraint belongs to."""
        return int(np.searchsorted(self.first, constraint, side="right")) - 1


def smallest_slack(bezier: npt.NDArray[np.int64], block: ConstraintBlock, unit_error: Fraction) -> LocatedSlack:
    """Return the smallest slack over all segments, and where it is.

    unit_error: the error of every edge, in units of the table. Segments are halved where their hull does not prove the slack that
    this error needs. Pieces are evaluated in batches, so that memory stays small.
    """
    required = unit_error * max(Fraction(*pair) for pair in {(c.size, c.slack_per_distance) for c in block.constraints})
    step = max(1, BATCH_SIZE // max(1, len(block.constraints)))
    parts = [block.slack(bezier[k : k + step]) for k in range(0, len(bezier), step)]
    slack, constraint = (np.concatenate([part[q] for part in parts]) for q in (0, 1))

    def interval(k: int) -> tuple[Fraction, Fraction]:
        return Fraction(k), Fraction(k + 1)

    is_proved = slack >= math.ceil(required)  # whole numbers
    unproved = np.nonzero(~is_proved)[0].tolist()
    candidates = [_halve(bezier[k].astype(object), interval(k), block, required, HALVING_LIMIT) for k in unproved]
    if is_proved.any():
        k = int(np.where(is_proved, slack, slack.max() + 1).argmin())
        candidates.append(_located(block, slack[k], interval(k), constraint[k]))
    return min(candidates, key=lambda candidate: candidate.slack)


def _halve(
    piece: Pieces, interval: tuple[Fraction, Fraction], block: ConstraintBlock, required: Fraction, depth: int
) -> LocatedSlack:
    """Return the smallest slack of one piece (n, 2, 4), halved until its hull proves `required` or `depth` is used up.

    Where the curve itself lacks the slack at some point, the slack at the first such point is returned.
    """
    slack, constraint = block.slack(piece[None])
    if slack[0] >= required or depth == 0:
        return _located(block, slack[0], interval, constraint[0])
    at_start = block.slack(np.repeat(piece[None, ..., :1], 4, axis=-1))
    if at_start[0][0] < required:  # the curve itself fails here: halving cannot help
        return _located(block, at_start[0][0], (interval[0], interval[0]), at_start[1][0])
    early, late = halves(piece * Fraction(1))
    middle = (interval[0] + interval[1]) / 2
    first = _halve(early, (interval[0], middle), block, required, depth - 1)
    second = _halve(late, (middle, interval[1]), block, required, depth - 1)
    return first if first.slack <= second.slack else second


def slack_by_piece(bezier: npt.NDArray[np.int64], block: ConstraintBlock, required: Fraction) -> list[PieceSlack]:
    """Return every segment with the slack of every constraint, halved where its hull does not prove what is required."""
    slack = block.slack_by_constraint(bezier)
    is_proved = block.slack_of_block(slack) >= required
    result: list[PieceSlack] = []
    for k, good in enumerate(is_proved.tolist()):
        if good:
            result.append(PieceSlack(Fraction(k), Fraction(k + 1), slack[k]))
        else:
            halving = _Halving(block, required)
            result += halving.pieces(bezier[k].astype(object), Fraction(k), Fraction(1), HALVING_LIMIT)
    return result


@dataclass(frozen=True)
class _Halving:
    """The halving of pieces until the hull of each proves the required slack of a block."""

    block: ConstraintBlock
    required: Fraction

    def pieces(self, piece: Pieces, begin: Fraction, length: Fraction, depth: int) -> list[PieceSlack]:
        """Return the parts of a piece (n, 2, 4) that begins at `begin`; a part stays undivided where the curve itself fails."""
        block = self.block
        slack = block.slack_by_constraint(piece[None], begin, length)
        at_start = block.slack_by_constraint(np.repeat(piece[None, ..., :1], 4, axis=-1), begin, ZERO)
        fails = block.slack_of_block(at_start)[0] < self.required
        if fails or depth == 0 or block.slack_of_block(slack)[0] >= self.required:
            return [PieceSlack(begin, begin + length, slack[0])]
        early, late = halves(piece * Fraction(1))
        first = self.pieces(early, begin, length / 2, depth - 1)
        return first + self.pieces(late, begin + length / 2, length / 2, depth - 1)


def halves(piece: Pieces) -> tuple[Pieces, Pieces]:
    """Return the Bezier coefficients of both halves of cubics (the last axis), by de Casteljau's rule."""
    c0, c1, c2, c3 = (piece[..., j] for j in range(4))
    a, b, c = (c0 + c1) / 2, (c1 + c2) / 2, (c2 + c3) / 2
    d, e = (a + b) / 2, (b + c) / 2
    f = (d + e) / 2
    return np.stack([c0, a, d, f], axis=-1), np.stack([f, e, c, c3], axis=-1)


def _located(block: ConstraintBlock, slack: Any, interval: tuple[Fraction, Fraction], constraint: Any) -> LocatedSlack:
    """Return a slack of a block with its place, as an exact fraction."""
    exact = slack if isinstance(slack, Fraction) else Fraction(int(slack))
    return LocatedSlack(exact, interval, int(constraint), block.set_of(int(constraint)))


def units_above(value: Fraction, unit: Fraction) -> int:
    """Return the smallest whole number of units that is not below the value."""
    return -(-value.numerator * unit.denominator // (value.denominator * unit.numerator))
