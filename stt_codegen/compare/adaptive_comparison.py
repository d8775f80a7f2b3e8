"""An adaptive or literal controller against the reference: (4)-(11) from a probe, then what its public functions return.

Every bound but those of e, epsilon, xi and status is from `program.analyse.Runner`: a forward error analysis of every statement
of the very program, at every point. comparison.py calls `add_adaptive_rows`. Arrays are (P, n), or (P, 2 n) where they are laid
out as alpha: lower side by dimension, then upper side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.comparison_rows import ComparedBackend, RowCollector
from stt_codegen.compare.law_comparison import add_transform_rows
from stt_codegen.compare.points import random_alpha, random_states, random_times, with_trajectory
from stt_codegen.controller import probe_program
from stt_codegen.designs import MINIMUM_WIDTH, AdaptiveDesign, parameters_of
from stt_codegen.pipeline import EmittedController, render_files
from stt_codegen.program import FORMATS
from stt_codegen.program.analyse import Runner

Array = npt.NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class _AdaptivePoints:
    """Times (P,), steps (P,), alpha (P, 2 n) and states x (P, n) at which a backend is compared."""

    t: Array
    dt: Array
    alpha: Array
    x: Array


@dataclass(frozen=True, kw_only=True)
class _AdaptiveReference:
    """Points; the status (P,) there; how much farther x is from its edges than the arithmetic moves it, (P, n).

    quantities: by name of a row the reference's values and the bounds on the backend's errors."""

    points: _AdaptivePoints
    status: Array
    clearance: Array
    quantities: dict[str, tuple[Array, Array]]


def add_adaptive_rows(rows: RowCollector, design: AdaptiveDesign, compared: ComparedBackend) -> None:
    """Compare all that the backend of an adaptive or literal controller computes."""
    controller, scalar = compared.controller, compared.backend.scalar
    if scalar not in compared.references:
        compared.references[scalar] = _compute_reference(controller, design, compared.points)
    expected: _AdaptiveReference = compared.references[scalar]
    backend = compared.make_backend(controller)
    probe = probe_program(controller.task, design)
    probe_files = render_files(controller.task, design, probe, controller.certificate)
    probe_backend = compared.make_backend(replace(controller, program=probe, files=probe_files))
    t, alpha, x = expected.points.t, expected.points.alpha, expected.points.x
    computed = dict(zip(("sigma", "rho", "beta", "psi", "theta"), probe_backend.call("probe", t), strict=True))
    computed["alpha rate"], computed["jacobian"] = backend.call("alpha_rate", t, alpha)
    (computed["alpha step"],) = backend.call("alpha_step", t, expected.points.dt, alpha)
    lower, upper = backend.tube(t, alpha)
    computed["tube"] = np.hstack([lower, upper])
    computed["tube rate"] = np.hstack(backend.tube_rate(t, alpha))
    status, computed["u"] = backend.control(t, alpha, x)
    computed["margin"] = backend.margin(t, alpha, x)[:, None]
    (computed["margins"],) = backend.call("margins", t, alpha, x)
    for name, (exact, bound) in expected.quantities.items():
        if name == "u":
            add_transform_rows(rows, compared, lower, upper, x)
        rows.add(name, computed[name][:, : exact.shape[1]], exact, bound, float(np.abs(exact).max()))
    rows.add_status(status, expected.status, expected.clearance)


def _compute_reference(controller: EmittedController, design: AdaptiveDesign, count: int) -> _AdaptiveReference:
    """Compute the reference's values and the error analysis' bounds; they are the same for every backend of one scalar type."""
    task, n, scalar = controller.task, design.dimension, controller.program.scalar
    points = _choose_points(controller, design, count)
    t, x = points.t, points.x
    p = parameters_of(design)
    paired_alpha = _paired(points.alpha)
    lines = reference.lines(p, t)
    gamma, gamma_rate = reference.adaptive_tube(p, lines, paired_alpha)
    low, high = gamma[:, :, 0], gamma[:, :, 1]
    rate, jacobian = reference.alpha_rate(p, lines.psi, lines.theta, paired_alpha)
    status, u = reference.control(low, high, x, task.gain, task.e_max, u_max=task.u_max)
    values = {
        "sigma": lines.sigma[:, None],
        "rho": _laid_out_as_alpha(lines.rho),
        "beta": _laid_out_as_alpha(lines.beta),
        "psi": _laid_out_as_alpha(lines.psi),
        "theta": _laid_out_as_alpha(lines.theta),
        "alpha rate": _laid_out_as_alpha(rate),
        "jacobian": _laid_out_as_alpha(jacobian),
        "alpha step": _laid_out_as_alpha(reference.alpha_steps(p, t, points.dt, paired_alpha)),
        "tube": _laid_out_as_alpha(gamma),
        "tube rate": _laid_out_as_alpha(gamma_rate),
        "u": u,
        "margin": reference.margin(low, high, x, float(MINIMUM_WIDTH))[:, None],
        "margins": reference.margins(low, high, x, float(MINIMUM_WIDTH)),
    }
    errors = _error_bounds(controller, design, points)
    mu = float(design.mu)
    clamp_error = 4e-35 * float(design.theta0) * (1 + mu**-2 + 2 * mu**-3)  # y in theta is clamped to 40, where psi + alpha > mu
    quantities = {}
    for name, exact in values.items():
        reference_rounding = 2.0**-60 * float(np.abs(exact).max())
        quantities[name] = (exact, errors[name] + clamp_error + reference_rounding)
    edge_errors = errors["tube"]
    distance = np.minimum(np.abs(x - low), np.abs(high - x)) - np.maximum(edge_errors[:, :n], edge_errors[:, n:])
    clearance = distance - 2 * float(FORMATS[scalar].roundoff) * np.abs(x)
    return _AdaptiveReference(points=points, status=status, clearance=clearance, quantities=quantities)


def _choose_points(controller: EmittedController, design: AdaptiveDesign, count: int) -> _AdaptivePoints:
    """Choose random points, with times at which bumps begin, are highest and end, and with states along a trajectory."""
    task, scalar = controller.task, controller.program.scalar
    bump_times = [float(v) for b in design.bumps for v in (b.middle - b.radius, b.middle, b.middle + b.radius)]
    t = random_times(task, np.array([0.0, float(design.prescribed_time), *bump_times]), count, scalar)
    alpha, dt = random_alpha(design, t, scalar)
    p = parameters_of(design)
    gamma, _ = reference.adaptive_tube(p, reference.lines(p, t), _paired(alpha))
    low, high = gamma[:, :, 0], gamma[:, :, 1]
    x = with_trajectory(task, t, low, high, random_states(task, low, high, scalar))
    return _AdaptivePoints(t=t, dt=dt, alpha=alpha, x=x)


def _error_bounds(controller: EmittedController, design: AdaptiveDesign, points: _AdaptivePoints) -> dict[str, Array]:
    """Bound the error of every quantity, by the name of its row, from an error analysis of the emitted programs.

    The analysis passes no error from one Newton iterate to the next: Newton's map has slope zero at the root, so that error
    enters the next iterate squared."""
    t, with_alpha = {"t": points.t}, {"t": points.t, "alpha": points.alpha}
    with_state = {**with_alpha, "x": points.x}
    probe = Runner(probe_program(controller.task, design)).run("probe", t)
    run = Runner(controller.program, newton_iterates=("low_z", "high_z")).run
    tube = run("tube", with_alpha)
    tube_rate = run("tube_rate", with_alpha)
    update = run("alpha_rate", with_alpha)
    step = run("alpha_step", {**with_alpha, "dt": points.dt})
    return {
        "sigma": probe["profile"].error[:, :1],
        **{name: probe[name].error for name in ("rho", "beta", "psi", "theta")},
        "alpha rate": update["rate"].error,
        "jacobian": update["jacobian"].error,
        "alpha step": step["alpha"].error,
        "tube": np.hstack([tube["lower"].error, tube["upper"].error]),
        "tube rate": np.hstack([tube_rate["lower_rate"].error, tube_rate["upper_rate"].error]),
        "u": run("control", with_state)["u"].error,
        "margin": run("margin", with_state)["return"].error[:, None],
        "margins": run("margins", with_state)["margin"].error,
    }


def _paired(alpha: Array) -> Array:
    """Return alpha (P, 2 n) as pairs (lower, upper) by dimension, (P, n, 2)."""
    n = alpha.shape[1] // 2
    return np.stack([alpha[:, :n], alpha[:, n:]], axis=2)


def _laid_out_as_alpha(pairs: Array) -> Array:
    """Return pairs (P, n, 2) laid out as alpha, (P, 2 n)."""
    return np.hstack([pairs[:, :, 0], pairs[:, :, 1]])
