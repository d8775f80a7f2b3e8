"""Bounds on a plant over a box, for Theorem 4.1 and the sampling conditions: from [plant], or from the plant's own functions.

f and g are lowered to a kernel like every other equation and evaluated in balls (Arb) on pieces of the box, so a bound holds for
every state in it. The bounds on eigenvalues are Weyl's: those of the matrix of midpoints, proved by a Cholesky factor in balls,
less the norm of the radii (the lemmas `plant.*`).
Long because all bounds of a plant are found here, by one way of cutting its box.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.errors import BadInput
from stt_codegen.plants import Model, model
from stt_codegen.program import Op, Program, Var, operands
from stt_codegen.program.analyse import Ball, Enclosure, hull
from stt_codegen.program.convert import lower
from stt_codegen.sampling.numbers import DOUBLES, Numbers
from stt_codegen.task import Task

PIECE_COUNT_LIMIT = 256  # of a box
Array = npt.NDArray[Any]
Sides = Sequence[tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Bounds on a plant over a box, for sign * g.

    By component i: disturbance >= |f_i + w_i|, diagonal_min <= g_ii <= diagonal_max, cross[i][j] >= |g_ij| (0 on the diagonal).
    Of vectors and matrices: disturbance_norm >= |f + w|, eigenvalue_min <= the smallest eigenvalue of g_s, norm >= |g|.
    """

    disturbance: Array
    diagonal_min: Array
    diagonal_max: Array
    cross: Array
    disturbance_norm: Any
    eigenvalue_min: Any
    norm: Any


class _InputBounds(NamedTuple):
    """Bounds on g alone, over one piece of a box; named as in `Bounds`."""

    diagonal_min: Array
    diagonal_max: Array
    cross: Array
    eigenvalue_min: float
    norm: float


def bounds_of_task(task: Task, numbers: Numbers = DOUBLES) -> Bounds:
    """Return the bounds that a task's [plant] states; without [plant], those of xdot = u.

    f_max and w_max bound norms, so every component too. g_min and g_max bound g_s from below and |g|, and so every g_ii. g_cross
    bounds every |g_ij|; without it inputs count as decoupled (g diagonal) in conditions by component. A list bounds each
    component by itself; then the norm of |f + w| is the root of their squares, and g_s and |g| follow by Gershgorin.
    """
    n, stated, plant = task.dimension, task.plant_bounds, task.plant

    def bounds(name: str, end: float) -> Array:
        return np.array([numbers.toward(getattr(b, name), end) for b in stated])

    disturbance, diagonal_max, cross = (bounds(name, math.inf) for name in ("force", "g_max", "cross"))
    diagonal_min = bounds("g_min", -math.inf)
    listed = [isinstance(v, tuple) for v in (plant.f_max or plant.w_max, plant.w_max or plant.f_max, plant.g_min, plant.g_max)]
    off_diagonal = numbers.outward(numbers.of((n - 1) * cross.max()), 1e-12)
    disturbance_norm = numbers.of(numbers.root_above((disturbance**2).sum()) if any(listed[:2]) else disturbance[0])
    eigenvalue_min, norm = (numbers.of(v) for v in (diagonal_min.min(), diagonal_max.max()))
    return Bounds(
        disturbance=disturbance,
        diagonal_min=diagonal_min,
        diagonal_max=diagonal_max,
        cross=cross[:, None] * (1 - np.eye(n, dtype=int)),
        disturbance_norm=disturbance_norm,
        eigenvalue_min=eigenvalue_min - off_diagonal if listed[2] else eigenvalue_min,
        norm=norm + off_diagonal if listed[3] else norm,
    )


SMOOTH = frozenset("add sub mul div neg sqrt exp expm1 log log1p tanh sinh cosh atanh sin cos tan".split())


class _Part:
    """One output of a plant's function, f or g, in balls over pieces of a box.

    The box is cut where a cut narrows the values most. Where all operations are smooth, the value over a piece
    with midpoint m is also within its value at m plus J (y - m), with the Jacobian J over the piece. For a quotient of functions
    of one state this is far narrower than the operations alone.
    """

    def __init__(self, value: Any, sides: Any, dimension: int) -> None:
        """Lower the output to kernels; value: a CasADi expression of `sides`, a column."""
        import casadi as ca

        self.kernel = lower(ca.Function("part", [sides], [value], ["x"], ["value"]))
        read = {o.name for a in self.kernel.body for o in operands(a.value) if isinstance(o, Var)}
        read |= {o.name for o in self.kernel.outputs if isinstance(o, Var)}
        self.is_read = [v.name in read for v in self.kernel.inputs]
        kernels = [self.kernel]
        self.is_smooth = all(isinstance(a.value, Op) and a.value.name in SMOOTH for a in self.kernel.body) and any(self.is_read)
        if self.is_smooth:
            kernels.append(lower(ca.Function("slopes", [sides], [ca.densify(ca.jacobian(value, sides))], ["x"], ["slopes"])))
        self.enclosure = Enclosure(Program("plant", dimension, "double", (), tuple(kernels), functions=()), rounding=False)

    def pieces(self, box: Sides) -> Iterator[tuple[Ball, ...]]:
        """Yield the values over each of PIECE_COUNT_LIMIT pieces that make up a box; of fewer where a cut narrows nothing.

        Each step halves the piece with the widest values, across the side that widens them most.
        """
        order = itertools.count()
        values = self._over(box)
        heap: list[Any] = [(-_total_radius(values), next(order), tuple(box), values)]
        while len(heap) < PIECE_COUNT_LIMIT and heap[0][0]:
            widest = heap[0]
            side = self._widening_side(widest[2])
            if side is None:
                break
            heapq.heappop(heap)
            for piece in _halves(widest[2], side):
                values = self._over(piece)
                heapq.heappush(heap, (-_total_radius(values), next(order), piece, values))
        yield from (values for *_, values in heap)

    def _widening_side(self, piece: Sides) -> int | None:
        """Return the side of a piece that widens the values most, by the slopes, or the longest one; None for a point."""
        lengths = {k: b - a for k, (a, b) in enumerate(piece) if self.is_read[k] and a < (a + b) / 2 < b}
        if not lengths:
            return None
        if not self.is_smooth:
            return max(lengths, key=lambda k: lengths[k])
        slopes = self.enclosure.kernel("slopes", *(hull(a, b) for a, b in piece))
        rows = len(slopes) // len(piece)
        steepness = {k: sum(_upper_end(abs(slope)) for slope in slopes[rows * k : rows * (k + 1)]) for k in lengths}
        if not all(map(math.isfinite, steepness.values())):
            return max(lengths, key=lambda k: lengths[k])
        return max(lengths, key=lambda k: steepness[k] * lengths[k])

    def _over(self, piece: Sides) -> tuple[Ball, ...]:
        """Return the values over one piece, by plain balls and, where it is smooth, by the mean value form too."""
        balls = [hull(a, b) for a, b in piece]
        plain = self.enclosure.kernel("part", *balls)
        if not self.is_smooth:
            return plain
        slopes = self.enclosure.kernel("slopes", *balls)
        middle = [arb(v.mid()) for v in balls]
        at_middle = self.enclosure.kernel("part", *middle)
        offsets, rows = [v - m for v, m in zip(balls, middle, strict=True)], len(plain)
        centred = [m + sum((slopes[i + rows * k] * d for k, d in enumerate(offsets)), arb(0)) for i, m in enumerate(at_middle)]
        return tuple(_both(a, b) for a, b in zip(plain, centred, strict=True))


def _halves(piece: Sides, side: int) -> tuple[Sides, Sides]:
    """Return the two halves of a piece across a side."""
    (a, b), before, after = piece[side], tuple(piece[:side]), tuple(piece[side + 1 :])
    middle = (a + b) / 2
    return (*before, (a, middle), *after), (*before, (middle, b), *after)


def _both(first: Ball, second: Ball) -> Ball:
    """Return the intersection of two enclosures of one number."""
    if not second.is_finite():
        return first
    return first.intersection(second) if first.is_finite() else second


def _total_radius(values: Sequence[Ball]) -> float:
    """Return the sum of the radii; infinite where a ball is not finite."""
    return sum((float(v.rad()) for v in values), 0.0) if all(v.is_finite() for v in values) else math.inf


class PlantEnclosure:
    """A plant of n dimensions in balls, over boxes of x, or for order 2 of x and v. Raises `BadInput` as `model` does.

    sign: 1, or -1 for a plant whose -g is positive definite.
    """

    def __init__(self, plant: Model, dimension: int, sign: int, order: int = 1) -> None:
        self.dimension, self.sign, self.w_max, self.plant = dimension, sign, DOUBLES.toward(plant.w_max, math.inf), plant
        import casadi as ca

        function = model(plant, dimension, order)
        sides, sample = ca.SX.sym("y", function.nnz_in(0)), dimension if plant.mixing is not None else 0
        past = sides.shape[0] - sample  # the sample's x is stated by its distance from x
        arguments = ca.vertcat(sides[:past], *(sides[i] + sides[past + i] for i in range(sample)))
        self.parts = [_Part(value, sides, dimension) for value in function(arguments)]

    def over(self, box: Sides, drift: Sequence[float] = ()) -> Bounds:
        """Return the bounds over a box, for all constants of the plant.

        box: (lower, upper) by dimension. drift: a bound on the distance of the sample's x from x, by dimension, where the plant
        mixes. Raises `BadInput` where f or g cannot be enclosed.
        """
        sample = [(-d, d) for d in drift] if self.plant.mixing is not None else []
        sides = [*box, *self.plant.constants, *sample]
        try:
            disturbances = [self._disturbance(values) for values in self.parts[0].pieces(sides)]
            inputs = [self._input_bounds(values) for values in self.parts[1].pieces(sides)]
        except (OverflowError, TypeError, ZeroDivisionError) as error:  # a value that is no number throughout the box
            cause = f"f or g cannot be enclosed over the tube ({type(error).__name__}: {error})"
            raise BadInput(f"--plant {self.plant.name}: {cause}; is there a pole, or a root of what may be negative?") from None
        by_component, norms = zip(*disturbances, strict=True)

        def largest(values: Sequence[Array]) -> Array:
            return np.asarray(np.max(np.array(values), axis=0))

        return Bounds(
            disturbance=largest(by_component),
            diagonal_min=np.asarray(np.min(np.array([b.diagonal_min for b in inputs]), axis=0)),
            diagonal_max=largest([b.diagonal_max for b in inputs]),
            cross=largest([b.cross for b in inputs]),
            disturbance_norm=max(norms),
            eigenvalue_min=min(b.eigenvalue_min for b in inputs),
            norm=max(b.norm for b in inputs),
        )

    @np.errstate(over="ignore")  # an overflow means that no bound is known
    def _disturbance(self, f: Sequence[Ball]) -> tuple[Array, float]:
        """Return bounds on |f_i + w_i| by component, and on |f + w|, on a piece."""
        drift = np.array([_upper_end(abs(v)) for v in f])
        norm = _up(math.sqrt(float(np.sum(drift**2)))) * (1 + 1e-12) + self.w_max if drift.any() else self.w_max
        return np.array([_up(v + self.w_max) if v else self.w_max for v in drift]), norm

    def _input_bounds(self, values: Sequence[Ball]) -> _InputBounds:
        """Return the bounds on g on a piece; values: its entries column by column, as CasADi stores them."""
        n = self.dimension
        g = [[self.sign * values[i + j * n] for j in range(n)] for i in range(n)]
        diagonal = [g[i][i] for i in range(n)]
        squares = [[sum(g[k][i] * g[k][j] for k in range(n)) for j in range(n)] for i in range(n)]
        symmetric = [[(g[i][j] + g[j][i]) / 2 for j in range(n)] for i in range(n)]
        largest = -minimum_eigenvalue([[-v for v in row] for row in squares])
        return _InputBounds(
            diagonal_min=np.array([_lower_end(v) for v in diagonal]),
            diagonal_max=np.array([_upper_end(abs(v)) for v in diagonal]),
            cross=np.array([[0.0 if i == j else _upper_end(abs(g[i][j])) for j in range(n)] for i in range(n)]),
            eigenvalue_min=minimum_eigenvalue(symmetric),
            norm=math.sqrt(largest) if largest in (0.0, 1.0) else _up(math.sqrt(max(largest, 0.0)) * (1 + 1e-12)),
        )


def minimum_eigenvalue(matrix: Sequence[Sequence[Ball]]) -> float:
    """Return a lower bound on the eigenvalues of every symmetric matrix within a matrix of balls; -inf where none is known."""
    n = len(matrix)
    if not all(v.is_finite() for row in matrix for v in row):
        return -math.inf
    if all(matrix[i][j].is_zero() for i in range(n) for j in range(n) if i != j):
        return min(_lower_end(matrix[i][i]) for i in range(n))
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
    """Return whether Cholesky's factor exists for certain."""
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


def _upper_end(value: Ball) -> float:
    """Return the smallest double above a ball; infinite where the ball is not finite."""
    if value.is_exact():
        return float(value)
    return math.nextafter(float(value.upper()), math.inf) if value.is_finite() else math.inf


def _lower_end(value: Ball) -> float:
    """Return the largest double below a ball; minus infinity where the ball is not finite."""
    if value.is_exact():
        return float(value)
    return math.nextafter(float(value.lower()), -math.inf) if value.is_finite() else -math.inf


def _up(value: float) -> float:
    """Return the next double above; 0 stays 0."""
    return math.nextafter(value, math.inf) if value else value


def _down(value: float) -> float:
    return math.nextafter(value, -math.inf)
