"""Every backend against the reference, on points that include the edges, each quantity within a derived bound.

eps is half a unit in the last place of 1 in the backend's scalar (2^-24 or 2^-53). delta is property P7's bound on an
emitted edge. The bounds, first-order terms rounded up:

    tube, tube rate   `certify.arithmetic`: delta, and its like for the rate
    e                 8 eps           a, b, width: 3 roundings each; difference, quotient, clamp
    epsilon           (8 + 4 |epsilon|) eps    a/b within 7 eps, and a logarithm within 2 units in its last place
    xi                12 eps xi       a/b, 1 + a/b, division by a
    u                 h(a, b) = (1/a + 1/b) ln(a/b) rises in a and falls in b, so edges moved by delta change k h by no
                      more than to the two corners (a +- delta, b -+ delta) clamped in a width changed by 2 delta; plus
                      |k| xi (8 + 4 |epsilon|) eps + 16 eps |u| for the arithmetic of the law
    status            may differ only where x is within delta (plus rounding) of an edge
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.backends import Backend, CasadiKernels, CompiledC, GeneratedPython
from stt_codegen.certify.arithmetic import edge_error, rate_error
from stt_codegen.pipeline import Controller, build_program, build_task
from stt_codegen.program.number import FORMATS
from stt_codegen.task import Task

Array = npt.NDArray[Any]
POINTS = 10_000


@dataclass(frozen=True)
class Row:
    """One quantity of one backend: largest error, the same in units in the last place of the quantity's scale (see
    `compare_backend`), largest share of the bound used, points compared."""

    backend: str
    quantity: str
    error: float
    ulps: float
    share: float
    points: int

    @property
    def holds(self) -> bool:
        return self.share <= 1.0


def compare(task: Task, points: int = POINTS, progress: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Compare CasADi, the emitted Python, and the emitted C in both precisions with the reference."""
    rows: list[Row] = []
    for controller, backend in _backends(task):
        progress(f"{task.name}: {backend.name}")
        rows += compare_backend(controller, backend, points)
    return rows


def _backends(task: Task) -> Iterator[tuple[Controller, Backend]]:
    double, single = (build_task(task.with_options(scalar=s), uncertified=True) for s in ("double", "float"))
    yield double, CasadiKernels(task, double.design)
    yield double, GeneratedPython(task, double.files)
    yield double, CompiledC(task, double.files, "double")
    yield single, CompiledC(task, single.files, "float")


def compare_backend(controller: Controller, backend: Backend, points: int = POINTS) -> list[Row]:
    """The rows of one backend.

    Units in the last place are those of the largest edge (tube), the largest rate, 1 (e), max(1, |epsilon|), xi, and
    |k| xi max(1, |epsilon|) for u: the sizes whose rounding each quantity inherits.
    """
    task, design = controller.task, controller.design
    number = np.float32 if backend.scalar == "float" else np.float64
    eps = float(FORMATS[backend.scalar].roundoff)
    plan = build_program(task.with_options(scalar=backend.scalar), design)
    delta = np.array([float(v) for v in edge_error(design, plan)])
    rate_bound = np.array([float(v) for v in rate_error(design, plan)])
    t, x = sample_points(controller, points, number)
    table, unit, t_c = design.integers(), design.unit, design.prescribed_time
    k, e_max = task.control.gain, task.control.e_max

    low, high = reference.tube(table, unit, t_c, t)
    rows = []

    def row(quantity: str, got: npt.ArrayLike, want: npt.ArrayLike, bound: npt.ArrayLike, scale: npt.ArrayLike) -> None:
        truth = np.asarray(want, dtype=np.longdouble)
        error = np.abs(np.asarray(got, dtype=np.longdouble) - truth)
        error = np.where(np.isnan(error), np.inf, error)
        ulp = 2 * eps * np.exp2(np.floor(np.log2(np.maximum(np.asarray(scale, dtype=float), 1e-300))))
        share = error / np.maximum(np.asarray(bound, dtype=np.longdouble), 1e-300)
        rows.append(Row(backend.name, quantity, float(error.max()), float((error / ulp).max()), float(share.max()), error.size))

    lower, upper = backend.tube(t)
    largest = max(float(np.abs(low).max()), float(np.abs(high).max()))
    row("tube", np.stack([lower, upper]), np.stack([low, high]), delta[None, None], largest)
    rates = reference.tube_rate(table, unit, t_c, t)
    fastest = max(float(np.abs(rates[0]).max()), float(np.abs(rates[1]).max()), 1e-30)
    row("tube rate", np.stack(backend.tube_rate(t)), np.stack(rates), rate_bound[None, None], fastest)

    e, epsilon, xi = reference.transform(lower, upper, x, e_max)
    got_e, got_epsilon, got_xi = backend.transform(lower, upper, x)
    size = np.maximum(1.0, np.abs(epsilon))
    row("e", got_e, e, 8 * eps, 1.0)
    row("epsilon", got_epsilon, epsilon, (8 + 4 * np.abs(epsilon)) * eps, size)
    row("xi", got_xi, xi, 12 * eps * xi, xi)

    status, u = reference.control(low, high, x, k, e_max, task.control.u_max)
    got_status, got_u = backend.control(t, x)
    _, epsilon, xi = reference.transform(low, high, x, e_max)
    gain = abs(float(k))
    spread = _law_spread(low, high, x, delta + 2 * eps * np.maximum(np.abs(low), np.abs(high)), float(e_max))
    bound = gain * spread + gain * xi * (8 + 4 * np.abs(epsilon)) * eps + 16 * eps * np.abs(u)
    row("u", got_u, u, bound, gain * xi * np.maximum(1.0, np.abs(epsilon)))
    distance = np.minimum(np.abs(x - low), np.abs(high - x)) - delta - 2 * eps * np.abs(x)
    wrong = (status != got_status) & (distance.min(axis=1) > 0)
    rows.append(Row(backend.name, "status", float(wrong.sum()), float(wrong.sum()), 2.0 if wrong.any() else 0.0, len(t)))
    return rows


def _law_spread(low: Array, high: Array, x: Array, delta: Array, e_max: float) -> Array:
    """How far (1/a + 1/b) ln(a/b) can move when each edge moves by delta (see the module's text)."""
    share = (1 - e_max) / 2

    def clamped(distance: Array, width: Array) -> Array:
        return np.clip(distance, share * width, (1 - share) * width)

    def h(a: Array, b: Array) -> Array:
        return np.asarray((1 / a + 1 / b) * np.log(a / b))

    width, a, b = high - low, x - low, high - x
    middle = h(clamped(a, width), clamped(b, width))
    most = h(clamped(a + delta, width + 2 * delta), clamped(b - delta, width - 2 * delta))
    least = h(clamped(a - delta, width - 2 * delta), clamped(b + delta, width + 2 * delta))
    return np.asarray(np.maximum(most - middle, middle - least))


def sample_points(controller: Controller, points: int, number: type) -> tuple[Array, Array]:
    """Times and states, all numbers of the backend's type: random ones in the tube and around it, and the edges.

    Edges: t at, just before and just after 0, every knot and t_c, far outside [0, t_c]; x on the tube's edges, just
    inside and outside, at the clamp, and very far away.
    """
    task, design = controller.task, controller.design
    random = np.random.default_rng(20240)
    t_c, n = float(task.prescribed_time), task.dimension
    knots = np.linspace(0, t_c, design.segments + 1)
    near = [number(v) for v in knots]
    special = [*near, *(np.nextafter(v, number(np.inf)) for v in near), *(np.nextafter(v, number(-np.inf)) for v in near)]
    special += [number(v) for v in (-1.0, -1e30, 1e-30, 2 * t_c, 1e30, -0.0)]
    t = np.concatenate([np.repeat(np.array(special, dtype=number), 8), random.uniform(-0.02 * t_c, 1.02 * t_c, points)])
    t = t.astype(number)
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
    width = high - low
    count = len(t)
    e = random.uniform(-1, 1, (count, n))
    kind = random.integers(0, 10, (count, n))
    e_max = float(task.control.e_max)
    tail = np.sign(e) * (1 - 10.0 ** -random.uniform(0, 7, (count, n)))
    e = np.select([kind == 0, kind == 1, kind == 2, kind == 3], [np.sign(e), np.sign(e) * e_max, tail, 1.5 * e], e)
    x: Array = np.asarray((high + low + width * e) / 2, dtype=number)
    x[kind == 4] = (random.choice([-1.0, 1.0], (count, n)) * 10.0 ** random.uniform(0, 30, (count, n))).astype(number)[kind == 4]
    return t, x
