"""Every backend against the reference, on points that include the edges, each quantity within a derived bound.

eps is half a unit in the last place of 1 in the backend's scalar (2^-24 or 2^-53). delta is property P7's bound on an
emitted edge. The bounds, first-order terms rounded up:

    tube, tube rate   refined: `controller.edge_errors`, delta and its like for the rate
    margin m          (1 + 2 |m|) delta over the width (an edge in the distance, both in the width), and 8 eps
    e                 8 eps           the nearer distance: 3 roundings, the farther what it leaves; difference, quotient
    epsilon           (8 + 4 |epsilon|) eps    a/b within 7 eps, and a logarithm within 2 units in its last place; written out
                      (`math = "inline"`): `controller.kernels.logarithm`'s relative error more, for u too
    xi                12 eps xi       b/a, 1 + b/a, division by b
    u                 refined: h(a, b) = (1/a + 1/b) ln(a/b) rises in a and falls in b, so edges moved by delta change k h by no
                      more than to the two corners (a +- delta, b -+ delta) clamped in a width changed by 2 delta; plus
                      |k| xi (8 + 4 |epsilon|) eps + 16 eps |u| for the arithmetic of the law
    status            may differ only where x is within delta (plus rounding) of an edge

Everything of the adaptive and literal designs that depends on t and alpha (and their u) is bounded by
`program.analyse.running`: a forward error analysis of every statement of the very program, at every point. Newton's iterates in
alpha_step count as settled: Newton's map has slope zero at the root, so the error of one iterate enters the next squared.

Long because the bounds of all quantities stand beside one another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.casadi_backends import CasadiAdaptive, CasadiRefined
from stt_codegen.compare.integer_comparison import integer_rows, same_as_python
from stt_codegen.compare.law_bounds import law_spread, logarithm_error
from stt_codegen.compare.points import random_alpha, random_states, random_times, with_trajectory
from stt_codegen.compare.start_comparison import covered_row
from stt_codegen.controller import edge_error, edge_and_rate_errors, probe_program, rate_error, tick_constants
from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs import MINIMUM_WIDTH, AdaptiveDesign, Design, RefinedDesign, for_any_design, parameters_of
from stt_codegen.errors import MissingTool, NotCertified
from stt_codegen.pipeline import EmittedController, build_program, build_task, render_files
from stt_codegen.program import FORMATS
from stt_codegen.program.analyse import Runner
from stt_codegen.program.targets import targets_of
from stt_codegen.program.targets.backend import Backend
from stt_codegen.task import Task

Array = npt.NDArray[Any]
POINTS = 10_000
FAR = 100.0  # states of order 2 are no farther: beyond, what they round to is all that is seen


@dataclass(frozen=True)
class Row:
    """One quantity of one backend: largest error, the same in units in the last place of the quantity's scale (see
    `compare_backend`), largest share of the bound used, points compared."""

    backend: str
    quantity: str
    error: float
    ulps: float
    share: float
    _: KW_ONLY
    points: int

    @property
    def holds(self) -> bool:
        return self.share <= 1.0


def compare(task: Task, points: int = POINTS, progress: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Compare CasADi, the emitted Python, and the emitted C (and Rust) in both precisions with the reference; of a controller in
    integers the Python and the C, and both with one another, bit for bit. A task of doubles
    for which no float has room (far from the origin) is compared in double alone, and `progress` says so."""
    rows: list[Row] = []
    known: dict[str, _Truth] = {}
    for controller, make in _backends(task, progress):
        backend = make(controller)
        progress(f"comparing {task.name}: {backend.name}")
        rows += compare_backend(controller, make, points, known)
    return rows


Maker = Callable[[EmittedController], Backend]


def _backends(task: Task, progress: Callable[[str], None]) -> Iterator[tuple[EmittedController, Maker]]:
    if task.emit.scalar == "fixed":
        yield from _printed(build_task(task, uncertified=True), progress)
        return
    double = build_task(task.with_options(scalar="double"), uncertified=True)
    casadi = BY_KIND[double.design.kind].casadi
    yield double, lambda controller: casadi(controller, controller.design)
    yield from _printed(double, progress)
    try:
        single = build_task(task.with_options(scalar="float"), uncertified=True)
    except NotCertified:
        if task.emit.scalar == "float":
            raise
        progress(f"{task.name}: a float has no room for this task, so double alone is compared")
    else:
        yield from _printed(single, progress)


def _printed(controller: EmittedController, progress: Callable[[str], None]) -> Iterator[tuple[EmittedController, Maker]]:
    """The backend of each language of the task. One that the task has to ask for is left out where its tools are missing."""
    scalar = controller.task.emit.scalar
    for target in targets_of(controller.task.emit):
        if scalar not in (*target.scalars, "fixed"):
            continue
        try:
            make = target.runner()
        except MissingTool as error:
            if not target.option:
                raise
            progress(f"{controller.task.name}: the {scalar} {target.title} is not compared: {error}")
        else:
            yield controller, make


def compare_backend(
    controller: EmittedController, make: Maker, points: int = POINTS, known: dict[str, _Truth] | None = None
) -> list[Row]:
    """The rows of one backend, made by `make`. `known` keeps the reference's values by scalar type between backends."""
    backend = make(controller)
    task = controller.task.with_options(scalar=backend.scalar)
    controller = replace(controller, task=task, program=build_program(task, controller.design))
    rows = _Rows(backend.name, float(FORMATS[backend.scalar].roundoff))
    BY_KIND[controller.design.kind].add_rows(
        rows, controller.design, _Compared(controller, make, backend, points, {} if known is None else known)
    )
    return rows.rows


@dataclass(frozen=True)
class _Compared:
    """One backend of a controller, how it is made, and the reference's values that are known already, by scalar type."""

    controller: EmittedController
    make: Maker
    backend: Backend
    points: int
    known: dict[str, _Truth]


class _Rows:
    """Collects the rows of one backend; eps is half a unit in the last place of 1 in its scalar.

    Units in the last place are those of the largest edge (tube), the largest rate, 1 (e), max(1, |epsilon|), xi, and
    |k| xi max(1, |epsilon|) for u: the sizes whose rounding each quantity inherits.
    """

    def __init__(self, backend: str, eps: float) -> None:
        self.backend, self.eps = backend, eps
        self.rows: list[Row] = []

    def add(self, quantity: str, got: npt.ArrayLike, want: npt.ArrayLike, bound: npt.ArrayLike, scale: npt.ArrayLike) -> None:
        truth = np.asarray(want, dtype=np.longdouble)
        error = np.abs(np.asarray(got, dtype=np.longdouble) - truth)
        error = np.where(np.isnan(error), np.inf, error)
        ulp = 2 * self.eps * np.exp2(np.floor(np.log2(np.maximum(np.asarray(scale, dtype=float), 1e-300))))
        limit = np.maximum(np.asarray(bound, dtype=np.longdouble), 1e-300)
        share = np.where(np.isfinite(limit), error / limit, np.inf)  # a bound that says nothing is no bound
        self.rows.append(
            Row(self.backend, quantity, float(error.max()), float((error / ulp).max()), float(share.max()), points=error.size)
        )

    def transform(self, controller: EmittedController, backend: Backend, lower: Array, upper: Array, x: Array) -> None:
        """Compare e, epsilon and xi of (13), for the same boxes and states in every backend."""
        own = logarithm_error(controller)
        e, epsilon, xi = reference.transform(lower, upper, x, controller.task.e_max)
        got_e, got_epsilon, got_xi = backend.transform(lower, upper, x)
        self.add("e", got_e, e, 8 * self.eps, 1.0)
        size = np.maximum(1.0, np.abs(epsilon))
        self.add("epsilon", got_epsilon, epsilon, (8 + 4 * np.abs(epsilon)) * self.eps + own * np.abs(epsilon), size)
        self.add("xi", got_xi, xi, 12 * self.eps * xi, xi)

    def status(self, got: Array, want: Array, distance: Array, label: str = "") -> None:
        """Statuses; `distance` (P, n): how much farther x is from each edge than the arithmetic can move it."""
        wrong = (got != want) & (distance.min(axis=1) > 0)
        self.rows.append(
            Row(
                self.backend,
                "status" + label,
                float(wrong.sum()),
                float(wrong.sum()),
                2.0 if wrong.any() else 0.0,
                points=len(got),
            )
        )


def _rows_of_refined(rows: _Rows, design: RefinedDesign, compared: _Compared) -> None:
    """Compare a refined tube, in integers or in floating point."""
    add_rows = _refined_rows if compared.controller.program.tick is None else _integer_rows
    add_rows(rows, compared.controller, design, compared.backend, compared.points)


def _integer_rows(rows: _Rows, controller: EmittedController, design: RefinedDesign, backend: Backend, points: int) -> None:
    edge, rate = (np.array([float(v) for v in error]) for error in edge_and_rate_errors(design, controller.program))
    integer_rows(controller, design, backend, points, (edge, rate), rows.add, rows.status)
    other = same_as_python(controller, design, backend, points)
    rows.rows.append(Row(backend.name, "bits as Python's", float(other), float(other), 2.0 if other else 0.0, points=points))


def _refined_rows(rows: _Rows, controller: EmittedController, design: RefinedDesign, backend: Backend, points: int) -> None:
    task, eps = controller.task, rows.eps
    delta = np.array([float(v) for v in edge_error(design, controller.program)])
    rate_bound = np.array([float(v) for v in rate_error(design, controller.program)])
    table, unit, t_c = design.integers(), design.unit, design.prescribed_time
    t = random_times(task, np.linspace(0, float(t_c), design.segments + 1), points, backend.scalar)
    low, high = reference.tube(table, unit, t_c, t)
    x = with_trajectory(task, t, low, high, random_states(task, low, high, backend.scalar))

    lower, upper = backend.tube(t)
    largest = max(float(np.abs(low).max()), float(np.abs(high).max()))
    rows.add("tube", np.stack([lower, upper]), np.stack([low, high]), delta[None, None], largest)
    rates = reference.tube_rate(table, unit, t_c, t)
    fastest = max(float(np.abs(rates[0]).max()), float(np.abs(rates[1]).max()), 1e-30)
    rows.add("tube rate", np.stack(backend.tube_rate(t)), np.stack(rates), rate_bound[None, None], fastest)
    rows.transform(controller, backend, lower, upper, x)
    if design.capabilities.emits_covered_starts:
        rows.add("covered", *covered_row(controller, design, backend, points, eps), 1.0)

    if task.order == 2:
        _inertial_rows(rows, controller, design, backend, t, (delta, rate_bound))
        return
    want = reference.margin(low, high, x, float(MINIMUM_WIDTH))
    width = np.maximum(high - low, float(MINIMUM_WIDTH))
    moved = (delta + 2 * eps * np.maximum(np.abs(low), np.abs(high))) / (width - 2 * delta)  # an edge, over the width
    weight = 1 + 2 * np.abs(np.clip(np.minimum(x - low, high - x) / width, -1, 0.5))  # of the distance, and twice of the width
    rows.add("margin", backend.margin(t, x), want, (moved * weight).max(axis=1) + 8 * eps, 1.0)
    by_component = reference.margins(low, high, x, float(MINIMUM_WIDTH))
    rows.add("margins", backend.call("margins", t, x)[0], by_component, moved * weight + 8 * eps, 1.0)
    _law_rows(rows, controller, (low, high, delta), x, backend.control(t, x), "")
    period = task.emit.tick_period
    if period is not None:
        ends = np.array([0, 1, *(tick_constants(design, period).end_tick + k for k in (-2, -1, 0, 1)), 2**32 - 1])
        ticks = np.clip(np.rint(t.astype(float) / float(period)), 0, 2**32 - 1).astype(np.int64)
        ticks[: len(ends)] = np.maximum(ends, 0)
        low, high = reference.tube(table, unit, t_c, ticks.astype(np.longdouble) * reference.exact(period))
        got = backend.call("control_tick", ticks, x)
        _law_rows(rows, controller, (low, high, delta), x, (got[0], got[1]), " at a tick")


def _inertial_rows(
    rows: _Rows, controller: EmittedController, design: RefinedDesign, backend: Backend, t: Array, delta: tuple[Array, Array]
) -> None:
    """What is there for order 2 alone: the filtered tube, and the law that holds v + lambda x in it. A distance (v - L') +
    lambda (x - L) is wrong by what both edges are, and by 8 roundings of its terms."""
    task, table, unit, t_c = controller.task, design.integers(), design.unit, design.prescribed_time
    low, high = reference.tube(table, unit, t_c, t)
    slopes = reference.tube_rate(table, unit, t_c, t)
    value = np.array([reference.exact(v) for v in design.filter])
    edges = [rate + value * place for rate, place in zip(slopes, (low, high), strict=True)]
    x = np.clip(random_states(task, low, high, backend.scalar), -FAR, FAR)
    held = np.clip(random_states(task, edges[0], edges[1], backend.scalar), -FAR, FAR)
    v = np.asarray(held - value * x, dtype=x.dtype)
    truth = v.astype(np.longdouble) + value * x
    wrong = np.array([float(r + v * e) for e, r, v in zip(*delta, value, strict=True)])
    size = np.abs(v) + value * np.abs(x) + sum(np.abs(s) + value * np.abs(e) for s, e in zip(slopes, (low, high), strict=True))
    moved = wrong + 8 * rows.eps * size
    largest = float(max(np.abs(e).max() for e in edges))
    rows.add("filtered tube", np.stack(backend.call("filtered_tube", t)), np.stack(edges), moved[None], largest)
    rooms = [(np.minimum(z - a, b - z), b - a, d) for z, a, b, d in ((truth, *edges, moved), (x, low, high, moved / value))]
    shares = [np.clip(near / wide, -1, 0.5) for near, wide, _ in rooms]
    bounds = [(1 + 2 * np.abs(s)) * d / (wide - 2 * d) for s, (_, wide, d) in zip(shares, rooms, strict=True)]
    want, bound = np.minimum(*shares), np.maximum(*bounds) + 8 * rows.eps
    rows.add("margins", backend.call("margins", t, x, v)[0], want, bound, 1.0)
    bound = np.maximum(*(b.max(axis=1) for b in bounds)) + 8 * rows.eps
    rows.add("margin", backend.call("margin", t, x, v)[0], want.min(axis=1), bound, 1.0)
    if task.uses_differences:
        dt = np.abs(v[:, 0]) % np.asarray(2, dtype=x.dtype) + np.asarray(float(task.shortest_period), dtype=x.dtype)
        dt[::16] = np.array([0, -1], dtype=x.dtype)[np.arange(len(dt[::16])) % 2]
        before = np.asarray(x + dt[:, None] * np.clip(v, -1, 1), dtype=x.dtype)
        with np.errstate(all="ignore"):
            mean = np.where(dt[:, None] > 0, (x.astype(np.longdouble) - before) / dt[:, None], np.nan)
        sure = 4 * rows.eps * np.abs(np.where(np.isnan(mean), 0, mean))
        got = backend.call("velocity", dt, x, before)[0]
        none = np.isnan(mean)
        rows.add("velocity", np.where(none, np.where(np.isnan(got), 0, 1), got), np.where(none, 0, mean), sure, 1.0)
    status, u = backend.call("control", t, x, v)
    _input_row(rows, controller, (*edges, moved), truth, u, "")
    inside = np.all([(a < z) & (z < b) for z, a, b in ((truth, *edges), (x, low, high))], axis=(0, 2))
    near = [
        np.minimum(np.abs(z - a), np.abs(b - z)) - d for z, a, b, d in ((truth, *edges, moved), (x, low, high, moved / value))
    ]
    rows.status(status, np.where(inside, 0, 1), np.minimum(*near))


def _law_rows(
    rows: _Rows, controller: EmittedController, tube: tuple[Array, Array, Array], x: Array, got: tuple[Array, ...], label: str
) -> None:
    """u and status for states x in a tube (lower, upper, and how far the arithmetic may move either)."""
    task = controller.task
    low, high, delta = tube
    status, _ = reference.control(low, high, x, task.gain, task.e_max, u_max=task.u_max)
    _input_row(rows, controller, tube, x, got[1], label)
    room = np.minimum(np.abs(x - low), np.abs(high - x)) - delta - 2 * rows.eps * np.abs(x)
    rows.status(got[0], status, room, label)


def _input_row(
    rows: _Rows, controller: EmittedController, tube: tuple[Array, Array, Array], x: Array, got: Array, label: str
) -> None:
    """u for what is held, x, in its tube, as for `_law_rows`."""
    task, eps = controller.task, rows.eps
    low, high, delta = tube
    _, u = reference.control(low, high, x, task.gain, task.e_max, u_max=None if task.scales_input else task.u_max)
    _, epsilon, xi = reference.transform(low, high, x, task.e_max)
    gain = np.array([abs(float(v)) for v in task.gain])
    clamp = np.array([float(v) for v in task.e_max])
    spread = law_spread(low, high, x, delta + 2 * eps * np.maximum(np.abs(low), np.abs(high)), clamp)
    bound = gain * spread + gain * xi * (8 + 4 * np.abs(epsilon)) * eps + (16 * eps + logarithm_error(controller)) * np.abs(u)
    if task.scales_input:  # u and the factor are both wrong; the factor by what the largest is
        assert task.u_max is not None
        largest = np.maximum(np.abs(u).max(axis=1, keepdims=True), float(task.u_max[0]))
        wrong = bound.max(axis=1, keepdims=True) / largest
        _, scaled = reference.control(low, high, x, task.gain, task.e_max, u_max=task.u_max, scales=True)
        share = float(task.u_max[0]) / largest
        bound = (share * bound + np.abs(scaled) * wrong) / np.maximum(1 - wrong, 1e-6) + 16 * eps * np.abs(scaled)
        u = scaled
    rows.add("u" + label, got, u, bound, gain * xi * np.maximum(1.0, np.abs(epsilon)))


@dataclass(frozen=True, kw_only=True)
class _Truth:
    """Points and, for every quantity of an adaptive or literal design there, the reference's value and the bound."""

    t: Array
    dt: Array
    alpha: Array
    x: Array
    status: Array
    distance: Array
    values: dict[str, tuple[Array, Array]]


def _adaptive_truth(controller: EmittedController, design: AdaptiveDesign, points: int) -> _Truth:
    """All that the reference and the error analysis say; the same for every backend of one scalar type."""
    task, n, scalar = controller.task, design.dimension, controller.program.scalar
    p = parameters_of(design)
    windows = [float(v) for b in design.bumps for v in (b.middle - b.radius, b.middle, b.middle + b.radius)]
    t = random_times(task, np.array([0.0, float(design.prescribed_time), *windows]), points, scalar)
    alpha, dt = random_alpha(design, t, scalar)
    both = np.stack([alpha[:, :n], alpha[:, n:]], axis=2)
    now = reference.lines(p, t)
    gamma, rates = reference.adaptive_tube(p, now, both)
    low, high = gamma[:, :, 0], gamma[:, :, 1]
    x = with_trajectory(task, t, low, high, random_states(task, low, high, scalar))
    rate, jacobian = reference.alpha_rate(p, now.psi, now.theta, both)
    status, u = reference.control(low, high, x, task.gain, task.e_max, u_max=task.u_max)

    probed = Runner(probe_program(task, design)).run("probe", {"t": t})
    run = Runner(controller.program, newton_iterates=("low_z", "high_z")).run
    tube = run("tube", {"t": t, "alpha": alpha})
    tube_rate = run("tube_rate", {"t": t, "alpha": alpha})
    update = run("alpha_rate", {"t": t, "alpha": alpha})
    step = run("alpha_step", {"t": t, "dt": dt, "alpha": alpha})
    law = run("control", {"t": t, "alpha": alpha, "x": x})
    watched, by_component = (run(name, {"t": t, "alpha": alpha, "x": x}) for name in ("margin", "margins"))

    def flat(values: Array) -> Array:
        return np.hstack([values[:, :, 0], values[:, :, 1]])

    moved = np.hstack([tube["lower"].error, tube["upper"].error])
    values = {
        "sigma": (now.sigma[:, None], probed["sigma"].error[:, :1]),
        "rho": (flat(now.rho), probed["rho"].error),
        "beta": (flat(now.beta), probed["beta"].error),
        "psi": (flat(now.psi), probed["psi"].error),
        "theta": (flat(now.theta), probed["theta"].error),
        "alpha rate": (flat(rate), update["rate"].error),
        "jacobian": (flat(jacobian), update["jacobian"].error),
        "alpha step": (flat(reference.alpha_steps(p, t, dt, both)), step["alpha"].error),
        "tube": (flat(gamma), moved),
        "tube rate": (flat(rates), np.hstack([tube_rate["lower_rate"].error, tube_rate["upper_rate"].error])),
        "u": (u, law["u"].error),
        "margin": (reference.margin(low, high, x, float(MINIMUM_WIDTH))[:, None], watched["return"].error[:, None]),
        "margins": (
            reference.margins(low, high, x, float(MINIMUM_WIDTH)),
            by_component["margin"].error,
        ),
    }
    mu = float(design.mu)
    held = 4e-35 * float(design.theta0) * (1 + mu**-2 + 2 * mu**-3)  # y in theta is held at 40, where psi + alpha > mu
    own = {name: 2.0**-60 * float(np.abs(want).max()) for name, (want, _) in values.items()}  # the reference's rounding
    values = {name: (want, bound + held + own[name]) for name, (want, bound) in values.items()}
    room = np.minimum(np.abs(x - low), np.abs(high - x)) - np.maximum(moved[:, :n], moved[:, n:])
    eps = float(FORMATS[scalar].roundoff)
    return _Truth(t=t, dt=dt, alpha=alpha, x=x, status=status, distance=room - 2 * eps * np.abs(x), values=values)


def _rows_of_adaptive(rows: _Rows, design: AdaptiveDesign, compared: _Compared) -> None:
    """Compare (4)-(11) from the probe, then what the public functions return."""
    controller, make, known = compared.controller, compared.make, compared.known
    scalar = compared.backend.scalar
    if scalar not in known:
        known[scalar] = _adaptive_truth(controller, design, compared.points)
    truth, backend = known[scalar], make(controller)
    probe = probe_program(controller.task, design)
    probed = make(replace(controller, program=probe, files=render_files(controller.task, design, probe, controller.certificate)))
    t, alpha = truth.t, truth.alpha
    got = dict(zip(("sigma", "rho", "beta", "psi", "theta"), probed.call("probe", t), strict=True))
    got["alpha rate"], got["jacobian"] = backend.call("alpha_rate", t, alpha)
    (got["alpha step"],) = backend.call("alpha_step", t, truth.dt, alpha)
    lower, upper = backend.tube(t, alpha)
    got["tube"] = np.hstack([lower, upper])
    got["tube rate"] = np.hstack(backend.tube_rate(t, alpha))
    status, got["u"] = backend.control(t, alpha, truth.x)
    got["margin"] = backend.margin(t, alpha, truth.x)[:, None]
    (got["margins"],) = backend.call("margins", t, alpha, truth.x)
    for name, (want, bound) in truth.values.items():
        if name == "u":
            rows.transform(controller, backend, lower, upper, truth.x)
        rows.add(name, got[name][:, : want.shape[1]], want, bound, float(np.abs(want).max()))
    rows.status(status, truth.status, truth.distance)


@dataclass(frozen=True)
class _KindComparison:
    """How a kind of tube is compared: its CasADi backend, and what adds the rows of any backend."""

    casadi: Callable[[EmittedController, Design], Backend]
    add_rows: Callable[[_Rows, Design, _Compared], None]


_OF_ADAPTIVE = _KindComparison(for_any_design(AdaptiveDesign, CasadiAdaptive), for_any_design(AdaptiveDesign, _rows_of_adaptive))
BY_KIND: Mapping[DesignKind, _KindComparison] = {
    "refined": _KindComparison(for_any_design(RefinedDesign, CasadiRefined), for_any_design(RefinedDesign, _rows_of_refined)),
    "adaptive": _OF_ADAPTIVE,
    "literal": _OF_ADAPTIVE,
}
