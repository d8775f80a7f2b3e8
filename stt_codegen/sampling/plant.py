"""What a plant does over a box, enclosed by Arb: the numbers that Theorem 4.1 and the sampled statements ask for.

f and g are lowered to a kernel like every other equation and read in balls, on pieces of the box, so a bound holds for every
state in it. The eigenvalue bounds are Weyl's: those of the middle matrix, shown by a Cholesky factor in balls, less the
norm of what the balls leave.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

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

PIECES = 128  # of a box, at most
Array = npt.NDArray[Any]
Sides = Sequence[tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Over a box, by component i: push >= |f_i + w_i|, least <= g_ii <= most, cross[i][j] >= |g_ij| (0 on the diagonal), all
    for sign * g; and of the whole: push_norm >= |f + w|, definite <= the least eigenvalue of g_s, norm >= |g|."""

    push: Array
    least: Array
    most: Array
    cross: Array
    push_norm: Any
    definite: Any
    norm: Any


def bounds_of_task(task: Task, numbers: Numbers = DOUBLES) -> Bounds:
    """The bounds that a task's [plant] states; without any, those of xdot = u.

    f_max, w_max bound norms, so every component too; g_min and g_max bound g_s from below and |g|, and so every g_ii; g_cross
    bounds every |g_ij|, and without it inputs count as decoupled (g diagonal) in the statements that go by component. Lists bound
    every component by itself; the norms then are what these leave: |f + w| their root of squares, g_s and |g| by Gershgorin."""
    n, stated, plant = task.dimension, task.plant_bounds, task.plant

    def bounds(name: str, end: float) -> Array:
        return np.array([numbers.toward(getattr(b, name), end) for b in stated])

    push, most, cross = (bounds(name, math.inf) for name in ("force", "g_max", "cross"))
    least = bounds("g_min", -math.inf)
    listed = [isinstance(v, tuple) for v in (plant.f_max or plant.w_max, plant.w_max or plant.f_max, plant.g_min, plant.g_max)]
    beside = numbers.outward(numbers.of((n - 1) * cross.max()), 1e-12)
    whole = numbers.of(numbers.root_above((push**2).sum()) if any(listed[:2]) else push[0])
    definite, norm = (numbers.of(v) for v in (least.min(), most.max()))
    return Bounds(
        push=push,
        least=least,
        most=most,
        cross=cross[:, None] * (1 - np.eye(n, dtype=int)),
        push_norm=whole,
        definite=definite - beside if listed[2] else definite,
        norm=norm + beside if listed[3] else norm,
    )


SMOOTH = frozenset("add sub mul div neg sqrt exp expm1 log log1p tanh sinh cosh atanh sin cos tan".split())


class _Part:
    """One output of a plant's function in balls, over pieces of a box: cut where a cut narrows it most. Over a piece of middle m
    it is within its value at m plus J (y - m), J over the piece, where its operations are smooth: of a quotient of functions of
    one state this is far narrower than what the operations give by themselves."""

    def __init__(self, value: Any, sides: Any, dimension: int) -> None:
        """value: a CasADi expression of `sides`, a column."""
        import casadi as ca

        self.kernel = lower(ca.Function("part", [sides], [value], ["x"], ["value"]))
        read = {o.name for a in self.kernel.body for o in operands(a.value) if isinstance(o, Var)}
        read |= {o.name for o in self.kernel.outputs if isinstance(o, Var)}
        self.matters = [v.name in read for v in self.kernel.inputs]
        kernels = [self.kernel]
        self.smooth = all(isinstance(a.value, Op) and a.value.name in SMOOTH for a in self.kernel.body) and any(self.matters)
        if self.smooth:
            kernels.append(lower(ca.Function("slopes", [sides], [ca.densify(ca.jacobian(value, sides))], ["x"], ["slopes"])))
        self.enclosure = Enclosure(Program("plant", dimension, "double", (), tuple(kernels), ()), rounding=False)

    def pieces(self, box: Sides) -> Iterator[tuple[Ball, ...]]:
        """What it is over each piece."""
        edges = [np.linspace(a, b, k + 1).tolist() for (a, b), k in zip(box, self._cuts(box), strict=True)]
        for piece in itertools.product(*(list(itertools.pairwise(e)) for e in edges)):
            yield self._over(piece)

    def _over(self, piece: Sides) -> tuple[Ball, ...]:
        balls = [hull(a, b) for a, b in piece]
        plain = self.enclosure.kernel("part", *balls)
        if not self.smooth:
            return plain
        slopes = self.enclosure.kernel("slopes", *balls)
        middle = [arb(v.mid()) for v in balls]
        at_middle = self.enclosure.kernel("part", *middle)
        away, rows = [v - m for v, m in zip(balls, middle, strict=True)], len(plain)
        centred = [m + sum((slopes[i + rows * k] * d for k, d in enumerate(away)), arb(0)) for i, m in enumerate(at_middle)]
        return tuple(_both(a, b) for a, b in zip(plain, centred, strict=True))

    def _cuts(self, box: Sides) -> list[int]:
        """Into how many each side is cut, at most PIECES in all: by turns the side is halved that alone, the others in their
        middle, widens the values most."""
        cuts = [1] * len(box)
        open_ = [k for k, (a, b) in enumerate(box) if b > a and self.matters[k]]
        if not open_:
            return cuts
        middle = [((a + b) / 2, (a + b) / 2) for a, b in box]

        def alone(k: int) -> float:
            (m, _), half = middle[k], (box[k][1] - box[k][0]) / 2 / cuts[k]
            return _spread(self._over([(m - half, m + half) if j == k else m_ for j, m_ in enumerate(middle)]))

        widened = {k: alone(k) for k in open_}
        while 2 * math.prod(cuts) <= PIECES:
            k = max(open_, key=lambda k: widened[k])
            cuts[k] *= 2
            widened[k] = alone(k)
        return cuts


def _both(first: Ball, second: Ball) -> Ball:
    """What is in both: two enclosures of one number."""
    if not second.is_finite():
        return first
    return first.intersection(second) if first.is_finite() else second


def _spread(values: Sequence[Ball]) -> float:
    """How wide they are together; without end where one is not finite."""
    return sum((float(v.rad()) for v in values), 0.0) if all(v.is_finite() for v in values) else math.inf


class PlantEnclosure:
    """A plant of n dimensions in balls, of order 2 over boxes of x and v. Raises `BadInput` as `model` does."""

    def __init__(self, plant: Model, dimension: int, sign: int, order: int = 1) -> None:
        self.dimension, self.sign, self.w_max, self.plant = dimension, sign, DOUBLES.toward(plant.w_max, math.inf), plant
        import casadi as ca

        function = model(plant, dimension, order)
        sides, sample = ca.SX.sym("y", function.nnz_in(0)), dimension if plant.mixing is not None else 0
        past = sides.shape[0] - sample  # of the sample's x is told how far it is from x
        given = ca.vertcat(sides[:past], *(sides[i] + sides[past + i] for i in range(sample)))
        self.parts = [_Part(value, sides, dimension) for value in function(given)]

    def over(self, box: Sides, drift: Sequence[float] = ()) -> Bounds:
        """Bounds over a box, given as (lower, upper) by dimension, for all constants of the plant. drift: how far x of the sample
        may be from x, by dimension, where the plant mixes."""
        sample = [(-d, d) for d in drift] if self.plant.mixing is not None else []
        sides = [*box, *self.plant.constants, *sample]
        try:
            pushes = [self._push(values) for values in self.parts[0].pieces(sides)]
            inputs = [self._input(values) for values in self.parts[1].pieces(sides)]
        except (OverflowError, TypeError, ZeroDivisionError) as error:  # what is no number all over the box
            told = f"f or g cannot be enclosed over the tube ({type(error).__name__}: {error})"
            raise BadInput(f"--plant {self.plant.name}: {told}; is there a pole, or a root of what may be negative?") from None
        (push, push_norm), (most, cross, norm, least, definite) = (list(zip(*found, strict=True)) for found in (pushes, inputs))
        worst = [np.asarray(np.max(np.array(v), axis=0)) for v in (push, most, cross)]
        lowest = np.asarray(np.min(np.array(least), axis=0))
        return Bounds(
            push=worst[0],
            least=lowest,
            most=worst[1],
            cross=worst[2],
            push_norm=max(push_norm),
            definite=min(definite),
            norm=max(norm),
        )

    @np.errstate(over="ignore")  # then no bound is known
    def _push(self, f: Sequence[Ball]) -> tuple[Array, float]:
        push = np.array([_most(abs(v)) for v in f])
        total = _up(math.sqrt(float(np.sum(push**2)))) * (1 + 1e-12) + self.w_max if push.any() else self.w_max
        return np.array([_up(p + self.w_max) if p else self.w_max for p in push]), total

    def _input(self, values: Sequence[Ball]) -> tuple[Array, Array, float, Array, float]:
        """most, cross, norm, least, definite of g on a piece."""
        n = self.dimension
        g = [[self.sign * values[i + j * n] for j in range(n)] for i in range(n)]  # CasADi stores columns
        diagonal = [g[i][i] for i in range(n)]
        cross = np.array([[0.0 if i == j else _most(abs(g[i][j])) for j in range(n)] for i in range(n)])
        squares = [[sum(g[k][i] * g[k][j] for k in range(n)) for j in range(n)] for i in range(n)]
        symmetric = [[(g[i][j] + g[j][i]) / 2 for j in range(n)] for i in range(n)]
        largest = -least_eigenvalue([[-v for v in row] for row in squares])
        return (
            np.array([_most(abs(v)) for v in diagonal]),
            cross,
            math.sqrt(largest) if largest in (0.0, 1.0) else _up(math.sqrt(max(largest, 0.0)) * (1 + 1e-12)),
            np.array([_least(v) for v in diagonal]),
            least_eigenvalue(symmetric),
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
