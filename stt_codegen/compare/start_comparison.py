"""`covered` of every backend against the exact bounds of the covered starts. The other files *_comparison.py call this file."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.points import random_states
from stt_codegen.controller import compute_covered_starts
from stt_codegen.designs import RefinedDesign
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.backend import Backend

Array = npt.NDArray[Any]
Intervals = tuple[tuple[Any, Any], ...]  # by component, exact
LARGEST_STATE = 1e6  # in the task's units: states are clamped to it


def compare_covered(
    controller: EmittedController, design: RefinedDesign, backend: Backend, count: int, eps: float
) -> tuple[Array, Array, Array]:
    """Return what a backend's `covered` says (P,), what the exact bounds say, and the allowed differences: zeros.

    Where a state is within a rounding of a bound both answers are right, and the exact one is replaced by the backend's. States
    are chosen about the start box; for order 2 so that v + lambda x is about its own box. Without a certificate no start is
    covered."""
    starts = compute_covered_starts(controller.task, design)
    is_fixed = backend.scalar == "fixed"
    unit = float(design.unit) if is_fixed else 1.0  # of the backend's states
    x = _as_backend_numbers(_states_about(controller, starts.positions, count), backend, unit)
    inputs, values = [x], [(x * unit, starts.positions)]
    if starts.filtered:
        lambda_ = np.array([reference.exact(v) for v in design.filter])
        z = _states_about(controller, starts.filtered, count)
        v = _as_backend_numbers(z - np.asarray(lambda_ * x * unit, dtype=float), backend, unit)
        inputs.append(v)
        values.append((v * unit + lambda_ * (x * unit), starts.filtered))
    is_covered, is_near_bound = np.full(count, controller.certificate.holds), np.full(count, False)
    for value, intervals in values:
        bounds = np.array([[reference.exact(v) for v in pair] for pair in intervals])
        is_covered &= ((bounds[:, 0] < value) & (value < bounds[:, 1])).all(axis=1)
        size = np.abs(bounds).max() + (np.abs(x) * unit * 4 if starts.filtered else 0) + np.abs(value)
        rounding = np.broadcast_to(2.5 * unit if is_fixed else 8 * eps * size, value.shape)
        is_near_bound |= (np.abs(value[:, :, None] - bounds) <= rounding[:, :, None]).any(axis=(1, 2))
    computed = backend.call("covered", *inputs)[0]
    is_either_right = is_near_bound & controller.certificate.holds
    return computed.astype(float), np.where(is_either_right, computed, is_covered).astype(float), np.zeros(count)


def _states_about(controller: EmittedController, intervals: Intervals, count: int) -> Array:
    """Return random states (count, n) in, at and about these intervals."""
    bounds = np.array([[float(v) for v in pair] for pair in intervals])
    low, high = (np.broadcast_to(bounds[:, side], (count, len(bounds))) for side in (0, 1))
    return random_states(controller.task, low, high, "double")


def _as_backend_numbers(values: Array, backend: Backend, unit: float) -> Array:
    """Return states as the backend takes them: numbers of its type, or integers of 32 bits that count `unit`."""
    clipped = np.clip(values, -LARGEST_STATE, LARGEST_STATE)
    if backend.scalar == "fixed":
        return np.asarray(np.clip(np.rint(clipped / unit), -(2**31), 2**31 - 1), dtype=np.int32)
    return np.asarray(clipped, dtype=np.float32 if backend.scalar == "float" else np.float64)
