"""A refined controller in floating point against the reference: tube, rates, transform, covered starts, margins, u and status.

comparison.py calls `add_refined_rows`; its docstring has the bounds. eps is half a unit in the last place of 1 in the backend's
scalar. Arrays are (P, n): P points, n dimensions.

For order 2, z is v + lambda x. Its distance to an edge, (v - L') + lambda (x - L), has the error of both edges, and 8 roundings
of its terms; L is the edge of the tube and L' its rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.comparison_rows import ComparedBackend, RowCollector, TubeWithErrors
from stt_codegen.compare.law_comparison import add_input_row, add_law_rows, add_transform_rows
from stt_codegen.compare.points import random_states, random_times, with_trajectory
from stt_codegen.compare.start_comparison import compare_covered
from stt_codegen.controller import edge_error, rate_error, tick_constants
from stt_codegen.designs import MINIMUM_WIDTH, RefinedDesign

Array = npt.NDArray[Any]
LARGEST_STATE = 100.0  # of x and z for order 2: for larger ones the rounding of their sum hides every other error


def add_refined_rows(rows: RowCollector, design: RefinedDesign, compared: ComparedBackend) -> None:
    """Compare all that the backend of a refined controller computes."""
    controller, backend = compared.controller, compared.backend
    task = controller.task
    edge_errors = np.array([float(v) for v in edge_error(design, controller.program)])
    rate_errors = np.array([float(v) for v in rate_error(design, controller.program)])
    knots = np.linspace(0, float(design.prescribed_time), design.segments + 1)
    t = random_times(task, knots, compared.points, backend.scalar)
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
    x = with_trajectory(task, t, low, high, random_states(task, low, high, backend.scalar))
    tube = TubeWithErrors(low, high, edge_errors)

    lower, upper = backend.tube(t)
    largest_edge = max(float(np.abs(low).max()), float(np.abs(high).max()))
    rows.add("tube", np.stack([lower, upper]), np.stack([low, high]), edge_errors[None, None], largest_edge)
    rates = reference.tube_rate(design.integers(), design.unit, design.prescribed_time, t)
    largest_rate = max(float(np.abs(rates[0]).max()), float(np.abs(rates[1]).max()), 1e-30)
    rows.add("tube rate", np.stack(backend.tube_rate(t)), np.stack(rates), rate_errors[None, None], largest_rate)
    add_transform_rows(rows, compared, lower, upper, x)
    if design.capabilities.emits_covered_starts:
        rows.add("covered", *compare_covered(controller, design, backend, compared.points, rows.eps), 1.0)
    if task.order == 2:
        _add_inertial_rows(rows, design, compared, t, (edge_errors, rate_errors))
        return
    _add_margin_rows(rows, compared, tube, t, x)
    add_law_rows(rows, controller, tube, x, backend.control(t, x))
    if task.emit.tick_period is not None:
        _add_tick_rows(rows, design, compared, t, x)


def _add_margin_rows(rows: RowCollector, compared: ComparedBackend, tube: TubeWithErrors, t: Array, x: Array) -> None:
    """Compare `margin` and `margins`."""
    low, high, edge_errors = tube
    width = np.maximum(high - low, float(MINIMUM_WIDTH))
    edge_rounding = 2 * rows.eps * np.maximum(np.abs(low), np.abs(high))
    relative_error = (edge_errors + edge_rounding) / (width - 2 * edge_errors)  # of an edge, over the width
    # An error of an edge counts once in the distance, and twice in the width, which the margin is divided by.
    weight = 1 + 2 * np.abs(np.clip(np.minimum(x - low, high - x) / width, -1, 0.5))
    margin = reference.margin(low, high, x, float(MINIMUM_WIDTH))
    margin_bound = (relative_error * weight).max(axis=1) + 8 * rows.eps
    rows.add("margin", compared.backend.margin(t, x), margin, margin_bound, 1.0)
    margins = reference.margins(low, high, x, float(MINIMUM_WIDTH))
    computed = compared.backend.call("margins", t, x)[0]
    rows.add("margins", computed, margins, relative_error * weight + 8 * rows.eps, 1.0)


def _add_tick_rows(rows: RowCollector, design: RefinedDesign, compared: ComparedBackend, t: Array, x: Array) -> None:
    """Compare `control_tick` at the ticks nearest to times t, and at the first, the last and the largest ticks."""
    controller = compared.controller
    period = controller.task.emit.tick_period
    assert period is not None
    end_tick = tick_constants(design, period).end_tick
    special_ticks = np.array([0, 1, *(end_tick + k for k in (-2, -1, 0, 1)), 2**32 - 1])
    ticks = np.clip(np.rint(t.astype(float) / float(period)), 0, 2**32 - 1).astype(np.int64)
    ticks[: len(special_ticks)] = np.maximum(special_ticks, 0)
    seconds = ticks.astype(np.longdouble) * reference.exact(period)
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, seconds)
    edge_errors = np.array([float(v) for v in edge_error(design, controller.program)])
    computed = compared.backend.call("control_tick", ticks, x)
    add_law_rows(rows, controller, TubeWithErrors(low, high, edge_errors), x, computed, label=" at a tick")


@dataclass(frozen=True, kw_only=True)
class _InertialPoints:
    """Times (P,), states x and v as the backend takes them, and the exact z; the tubes that x and z must be in."""

    t: Array
    x: Array
    v: Array
    z: Array
    tube: TubeWithErrors
    filtered_tube: TubeWithErrors


def _add_inertial_rows(
    rows: RowCollector, design: RefinedDesign, compared: ComparedBackend, t: Array, errors: tuple[Array, Array]
) -> None:
    """Compare what is emitted for order 2 only. errors: bounds on the errors of edges and of their rates, (n,) each."""
    backend = compared.backend
    points = _choose_inertial_points(design, compared, t, errors, rows.eps)
    filtered = points.filtered_tube
    largest_edge = float(max(np.abs(edge).max() for edge in (filtered.lower, filtered.upper)))
    edges = np.stack([filtered.lower, filtered.upper])
    rows.add("filtered tube", np.stack(backend.call("filtered_tube", t)), edges, filtered.error[None], largest_edge)
    _add_inertial_margin_rows(rows, compared, points)
    if compared.controller.task.uses_differences:
        _add_velocity_row(rows, compared, points)
    status, u = backend.call("control", t, points.x, points.v)
    add_input_row(rows, compared.controller, filtered, points.z, u)
    values_and_tubes = ((points.z, filtered), (points.x, points.tube))
    is_inside = np.all([(tube.lower < value) & (value < tube.upper) for value, tube in values_and_tubes], axis=(0, 2))
    clearances = [
        np.minimum(np.abs(value - tube.lower), np.abs(tube.upper - value)) - tube.error for value, tube in values_and_tubes
    ]
    rows.add_status(status, np.where(is_inside, 0, 1), np.minimum(*clearances))


def _choose_inertial_points(
    design: RefinedDesign, compared: ComparedBackend, t: Array, errors: tuple[Array, Array], eps: float
) -> _InertialPoints:
    """Choose states with x about the tube and z about the filtered tube, and compute both tubes."""
    task, scalar = compared.controller.task, compared.backend.scalar
    table, unit, t_c = design.integers(), design.unit, design.prescribed_time
    low, high = reference.tube(table, unit, t_c, t)
    low_rate, high_rate = reference.tube_rate(table, unit, t_c, t)
    lambda_ = np.array([reference.exact(v) for v in design.filter])
    filtered_low, filtered_high = low_rate + lambda_ * low, high_rate + lambda_ * high
    x = np.clip(random_states(task, low, high, scalar), -LARGEST_STATE, LARGEST_STATE)
    intended_z = np.clip(random_states(task, filtered_low, filtered_high, scalar), -LARGEST_STATE, LARGEST_STATE)
    v = np.asarray(intended_z - lambda_ * x, dtype=x.dtype)
    z = v.astype(np.longdouble) + lambda_ * x
    edge_error = np.array([float(r + k * e) for e, r, k in zip(*errors, lambda_, strict=True)])
    rates_and_edges = ((low_rate, low), (high_rate, high))
    term_sizes = np.abs(v) + lambda_ * np.abs(x) + sum(np.abs(r) + lambda_ * np.abs(e) for r, e in rates_and_edges)
    distance_error = edge_error + 8 * eps * term_sizes
    # An error of lambda x by `distance_error` is one of x by that over lambda.
    tube = TubeWithErrors(low, high, distance_error / lambda_)
    filtered_tube = TubeWithErrors(filtered_low, filtered_high, distance_error)
    return _InertialPoints(t=t, x=x, v=v, z=z, tube=tube, filtered_tube=filtered_tube)


def _add_inertial_margin_rows(rows: RowCollector, compared: ComparedBackend, points: _InertialPoints) -> None:
    """Compare `margins` and `margin`: by component the smaller one of the margins of z and of x."""
    margins, bounds = [], []
    for value, tube in ((points.z, points.filtered_tube), (points.x, points.tube)):
        width = tube.upper - tube.lower
        margin = np.clip(np.minimum(value - tube.lower, tube.upper - value) / width, -1, 0.5)
        margins.append(margin)
        bounds.append((1 + 2 * np.abs(margin)) * tube.error / (width - 2 * tube.error))
    exact = np.minimum(*margins)
    arguments = (points.t, points.x, points.v)
    rows.add("margins", compared.backend.call("margins", *arguments)[0], exact, np.maximum(*bounds) + 8 * rows.eps, 1.0)
    bound = np.maximum(*(b.max(axis=1) for b in bounds)) + 8 * rows.eps
    rows.add("margin", compared.backend.call("margin", *arguments)[0], exact.min(axis=1), bound, 1.0)


def _add_velocity_row(rows: RowCollector, compared: ComparedBackend, points: _InertialPoints) -> None:
    """Compare `velocity`; every 16th dt is 0 or -1, for which NaN is right.

    Where the reference is NaN the row compares 0 with 0 for a NaN of the backend, and 1 with 0 for a number."""
    x, v = points.x, points.v
    shortest_period = np.asarray(float(compared.controller.task.shortest_period), dtype=x.dtype)
    dt = np.abs(v[:, 0]) % np.asarray(2, dtype=x.dtype) + shortest_period
    dt[::16] = np.array([0, -1], dtype=x.dtype)[np.arange(len(dt[::16])) % 2]
    x_before = np.asarray(x + dt[:, None] * np.clip(v, -1, 1), dtype=x.dtype)
    with np.errstate(all="ignore"):
        velocity = np.where(dt[:, None] > 0, (x.astype(np.longdouble) - x_before) / dt[:, None], np.nan)
    computed = compared.backend.call("velocity", dt, x, x_before)[0]
    is_nan = np.isnan(velocity)
    exact = np.where(is_nan, 0, velocity)
    is_number = np.where(np.isnan(computed), 0, 1)
    rows.add("velocity", np.where(is_nan, is_number, computed), exact, 4 * rows.eps * np.abs(exact), 1.0)
