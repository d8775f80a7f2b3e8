"""The law (13) against the reference, for states in any tube: error transform, u and status in floating point, and bounds for u.

The other files *_comparison.py call this file; the docstring of comparison.py has the bounds. Arrays are (P, n).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.comparison_rows import ComparedBackend, RowCollector, TubeWithErrors
from stt_codegen.controller.kernels import inline_logarithm_error
from stt_codegen.pipeline import EmittedController

Array = npt.NDArray[Any]


def _logarithm_error(controller: EmittedController) -> float:
    """Return the relative error of epsilon by a logarithm that is emitted as arithmetic; 0 with a library's logarithm."""
    is_inline = controller.task.emit.math == "inline"
    return float(inline_logarithm_error(controller.program.scalar)) if is_inline else 0.0


def law_change(low: Array, high: Array, x: Array, edge_error: Array, e_max: Array) -> Array:
    """Bound how far h(a, b) = (1/a + 1/b) ln(a/b), on clamped distances, changes when each edge moves by up to edge_error.

    h rises in a and falls in b, so two corners decide: a larger and b smaller by edge_error, and the other way round; the clamp
    is that of a width changed by twice edge_error. e_max: (n,)."""
    clamp_share = (1 - e_max) / 2

    def clamped(distance: Array, width: Array) -> Array:
        return np.clip(distance, clamp_share * width, (1 - clamp_share) * width)

    def h(a: Array, b: Array) -> Array:
        return np.asarray((1 / a + 1 / b) * np.log(a / b))

    width, a, b = high - low, x - low, high - x
    wide, narrow = width + 2 * edge_error, width - 2 * edge_error
    unmoved = h(clamped(a, width), clamped(b, width))
    largest = h(clamped(a + edge_error, wide), clamped(b - edge_error, narrow))
    smallest = h(clamped(a - edge_error, narrow), clamped(b + edge_error, wide))
    return np.asarray(np.maximum(largest - unmoved, unmoved - smallest))


def add_transform_rows(rows: RowCollector, compared: ComparedBackend, lower: Array, upper: Array, x: Array) -> None:
    """Compare e, epsilon and xi of (13), for states x in boxes (lower, upper)."""
    eps, log_error = rows.eps, _logarithm_error(compared.controller)
    e, epsilon, xi = reference.transform(lower, upper, x, compared.controller.task.e_max)
    computed_e, computed_epsilon, computed_xi = compared.backend.transform(lower, upper, x)
    rows.add("e", computed_e, e, 8 * eps, 1.0)
    epsilon_bound = (8 + 4 * np.abs(epsilon)) * eps + log_error * np.abs(epsilon)
    rows.add("epsilon", computed_epsilon, epsilon, epsilon_bound, np.maximum(1.0, np.abs(epsilon)))
    rows.add("xi", computed_xi, xi, 12 * eps * xi, xi)


def add_law_rows(
    rows: RowCollector,
    controller: EmittedController,
    tube: TubeWithErrors,
    x: Array,
    computed: tuple[Array, ...],
    *,
    label: str = "",
) -> None:
    """Compare (status (P,), u (P, n)) that a backend computed for states x in a tube."""
    task = controller.task
    low, high, edge_error = tube
    computed_status, computed_u = computed
    status, _ = reference.control(low, high, x, task.gain, task.e_max, u_max=task.u_max)
    add_input_row(rows, controller, tube, x, computed_u, label=label)
    clearance = np.minimum(np.abs(x - low), np.abs(high - x)) - edge_error - 2 * rows.eps * np.abs(x)
    rows.add_status(computed_status, status, clearance, label)


def add_input_row(
    rows: RowCollector, controller: EmittedController, tube: TubeWithErrors, x: Array, computed_u: Array, *, label: str = ""
) -> None:
    """Compare u (P, n) for states x in a tube; for order 2 x is v + lambda x, and the tube the filtered one."""
    task, eps = controller.task, rows.eps
    low, high, edge_error = tube
    _, u = reference.control(low, high, x, task.gain, task.e_max, u_max=None if task.scales_input else task.u_max)
    _, epsilon, xi = reference.transform(low, high, x, task.e_max)
    gain = np.array([abs(float(v)) for v in task.gain])
    e_max = np.array([float(v) for v in task.e_max])
    change = law_change(low, high, x, edge_error + 2 * eps * np.maximum(np.abs(low), np.abs(high)), e_max)
    arithmetic = gain * xi * (8 + 4 * np.abs(epsilon)) * eps + (16 * eps + _logarithm_error(controller)) * np.abs(u)
    bound = gain * change + arithmetic
    if task.scales_input:
        u, bound = _scaled(rows, controller, tube, x, (u, bound))
    rows.add("u" + label, computed_u, u, bound, gain * xi * np.maximum(1.0, np.abs(epsilon)))


def _scaled(
    rows: RowCollector, controller: EmittedController, tube: TubeWithErrors, x: Array, unscaled: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Return u after the scaling to u_max, and its bound, from u and its bound before.

    Both u and the factor have errors; the factor has that of the largest component."""
    task, eps = controller.task, rows.eps
    assert task.u_max is not None
    unscaled_u, unscaled_bound = unscaled
    u_max = float(task.u_max[0])
    largest = np.maximum(np.abs(unscaled_u).max(axis=1, keepdims=True), u_max)
    factor_error = unscaled_bound.max(axis=1, keepdims=True) / largest  # relative
    _, u = reference.control(tube.lower, tube.upper, x, task.gain, task.e_max, u_max=task.u_max, scales=True)
    factor = u_max / largest
    first_order = factor * unscaled_bound + np.abs(u) * factor_error
    return u, first_order / np.maximum(1 - factor_error, 1e-6) + 16 * eps * np.abs(u)
