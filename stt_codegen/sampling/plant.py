"""What a plant does over a box, enclosed by Arb: the numbers that Theorem 4.1 and the sampled statements ask for.

f and g are lowered to a kernel like every other equation and read in balls, on pieces of the box, so a bound holds for every
state in it. The eigenvalue bounds are Weyl's: those of the middle matrix, shown by a Cholesky factor in balls, less the
norm of what the balls leave.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.plants import Model, model
from stt_codegen.program import Program, Var, operands
from stt_codegen.program.ball_arithmetic import Ball, hull
from stt_codegen.program.balls import Enclosure
from stt_codegen.program.lower import lower
from stt_codegen.task import Task

PIECES = 64  # of a box, at most
Array = npt.NDArray[Any]
Sides = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Bounds:
    """Over a box, by component i: push >= |f_i + w_i|, least <= g_ii <= most, cross[i][j] >= |g_ij| (0 on the diagonal), all
    for sign * g; and of the whole: push_norm >= |f + w|, definite <= the least eigenvalue of g_s, norm >= |g|."""

    push: Array
    least: Array
    most: Array
    cross: Array
    push_norm: float
    definite: float
    norm: float


def bounds_of_task(task: Task) -> Bounds:
    """The bounds that a task's [plant] states; without any, those of xdot = u.

    f_max, w_max bound norms, so every component too; g_min and g_max bound g_s from below and |g|, and so every g_ii; g_cross
    bounds every |g_ij|, and without it inputs count as decoupled (g diagonal) in the statements that go by component."""
    n, plant = task.dimension, task.plant
    push = _double((plant.f_max or Fraction(0)) + (plant.w_max or Fraction(0)), math.inf)
    low, high = task.g_range
    least, most = _double(low, -math.inf), _double(high, math.inf)
    cross = _double(plant.g_cross or Fraction(0), math.inf) * (1 - np.eye(n))
    return Bounds(np.full(n, push), np.full(n, least), np.full(n, most), cross, push, least, most)


def _double(value: Fraction, toward: float) -> float:
    """The fraction as a double; rounded toward that side where it is none."""
    double = float(value)
    return double if Fraction(double) == value else math.nextafter(double, toward)


class PlantEnclosure:
    """A plant of n dimensions in balls, of order 2 over boxes of x and v. Raises `BadInput` as `model` does."""

    def __init__(self, plant: Model, dimension: int, sign: int, order: int = 1) -> None:
        self.dimension, self.sign, self.w_max = dimension, sign, _double(plant.w_max, math.inf)
        kernel = lower(model(plant, dimension, order))
        read = {o.name for a in kernel.body for o in operands(a.value) if isinstance(o, Var)} | {
            o.name for o in kernel.outputs if isinstance(o, Var)
        }
        self.matters = [v.name in read for v in kernel.inputs]
        self.enclosure = Enclosure(Program("plant", dimension, "double", (), (kernel,), ()), rounding=False)

    def over(self, box: Sides) -> Bounds:
        """Bounds over a box, given as (lower, upper) by dimension."""
        found = [self._piece(piece) for piece in _pieces(box, self.matters)]
        worst = [np.max([getattr(b, name) for b in found], axis=0) for name in ("push", "most", "cross", "push_norm", "norm")]
        least = [np.min([getattr(b, name) for b in found], axis=0) for name in ("least", "definite")]
        return Bounds(worst[0], least[0], worst[1], worst[2], float(worst[3]), float(least[1]), float(worst[4]))

    def _piece(self, box: Sides) -> Bounds:
        n = self.dimension
        values = self.enclosure.kernel("plant", *(hull(a, b) for a, b in box))
        f = values[:n]
        g = [[self.sign * values[n + i + j * n] for j in range(n)] for i in range(n)]  # CasADi stores columns
        push = np.array([_most(abs(v)) for v in f])
        diagonal = [g[i][i] for i in range(n)]
        cross = np.array([[0.0 if i == j else _most(abs(g[i][j])) for j in range(n)] for i in range(n)])
        squares = [[sum(g[k][i] * g[k][j] for k in range(n)) for j in range(n)] for i in range(n)]
        symmetric = [[(g[i][j] + g[j][i]) / 2 for j in range(n)] for i in range(n)]
        largest = -least_eigenvalue([[-v for v in row] for row in squares])
        return Bounds(
            np.array([_up(p + self.w_max) for p in push]),
            np.array([_least(v) for v in diagonal]),
            np.array([_most(abs(v)) for v in diagonal]),
            cross,
            _up(math.sqrt(float(np.sum(push**2)))) * (1 + 1e-12) + self.w_max,
            least_eigenvalue(symmetric),
            math.sqrt(largest) if largest in (0.0, 1.0) else _up(math.sqrt(max(largest, 0.0)) * (1 + 1e-12)),
        )


def least_eigenvalue(matrix: Sequence[Sequence[Ball]]) -> float:
    """A lower bound on the eigenvalues of every symmetric matrix within a matrix of balls; -inf where nothing is known."""
    n = len(matrix)
    if not all(v.is_finite() for row in matrix for v in row):
        return -math.inf
    if all(matrix[i][j].is_zero() for i in range(n) for j in range(n) if i != j):
        return min(_least(matrix[i][i]) for i in range(n))
    middle = [[arb(matrix[i][j].mid()) for j in range(n)] for i in range(n)]
    radius = sum((float(matrix[i][j].rad()) ** 2 for i in range(n) for j in range(n)), 0.0)
    plain = np.array([[float(v) for v in row] for row in middle])
    scale = 1e-12 * (1.0 + float(np.abs(plain).max()))
    guess = float(np.linalg.eigvalsh((plain + plain.T) / 2)[0]) - scale
    while not _positive_definite([[v - (guess if i == j else 0) for j, v in enumerate(row)] for i, row in enumerate(middle)]):
        scale *= 16
        guess -= scale
        if scale > 1e6:
            return -math.inf
    return _down(guess - _up(math.sqrt(radius) * (1 + 1e-12)))


def _positive_definite(matrix: Sequence[Sequence[Ball]]) -> bool:
    """Whether Cholesky's factor exists for certain."""
    n = len(matrix)
    factor = [[arb(0)] * n for _ in range(n)]
    for i, j in itertools.product(range(n), range(n)):
        if j > i:
            continue
        rest = matrix[i][j] - sum((factor[i][k] * factor[j][k] for k in range(j)), arb(0))
        if i == j and not rest > 0:
            return False
        factor[i][j] = rest.sqrt() if i == j else rest / factor[j][j]
    return True


def _pieces(box: Sides, matters: Sequence[bool]) -> list[Sides]:
    """The box cut alike in the dimensions that matter, into at most PIECES (at least one)."""
    cuts = max(1, math.floor(PIECES ** (1 / max(1, sum(matters))) + 1e-9))
    edges = [np.linspace(a, b, cuts + 1 if m else 2).tolist() for (a, b), m in zip(box, matters, strict=True)]
    return [list(piece) for piece in itertools.product(*(list(itertools.pairwise(e)) for e in edges))]


def _most(value: Ball) -> float:
    if value.is_exact():
        return float(value)
    return math.nextafter(float(value.upper()), math.inf) if value.is_finite() else math.inf


def _least(value: Ball) -> float:
    if value.is_exact():
        return float(value)
    return math.nextafter(float(value.lower()), -math.inf) if value.is_finite() else -math.inf


def _up(value: float) -> float:
    return math.nextafter(value, math.inf) if value else value


def _down(value: float) -> float:
    return math.nextafter(value, -math.inf)
