"""`covered` of every backend against the exact bounds of the starts that are covered."""

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
FAR = 1e6  # times the start box: farther states are as far


def covered_row(
    controller: EmittedController, design: RefinedDesign, backend: Backend, count: int, eps: float
) -> tuple[Array, Array, Array]:
    """What a backend says (P,), what the exact bounds say, and by how much it may differ: not at all. Where a state is within a
    rounding of a bound either is right, and what the backend says is taken. States stand about the start box; of order 2 so does
    v + lambda x about its own."""
    task = controller.task
    starts, n = compute_covered_starts(task, design), task.dimension
    places = np.array([[float(v) for v in pair] for pair in starts.positions])
    low, high = (np.broadcast_to(places[:, k], (count, n)) for k in (0, 1))
    is_fixed = backend.scalar == "fixed"
    scale = float(design.unit) if is_fixed else 1.0
    x = _numbers(random_states(task, low, high, "double"), backend, scale)
    rooms, inputs = [(x * scale, starts.positions)], [x]
    if starts.filtered:
        sums = np.array([[float(v) for v in pair] for pair in starts.filtered])
        value = np.array([reference.exact(v) for v in design.filter])
        low, high = (np.broadcast_to(sums[:, k], (count, n)) for k in (0, 1))
        filtered = random_states(task, low, high, "double")
        v = _numbers(filtered - np.asarray(value * x * scale, dtype=float), backend, scale)
        inputs.append(v)
        rooms.append((v * scale + value * (x * scale), starts.filtered))
    want, near = np.full(count, True), np.full(count, False)
    for state, bounds in rooms:
        ends = np.array([[reference.exact(v) for v in pair] for pair in bounds])
        want &= ((ends[:, 0] < state) & (state < ends[:, 1])).all(axis=1)
        size = np.abs(ends).max() + (np.abs(inputs[0]) * scale * 4 if len(rooms) > 1 else 0) + np.abs(state)
        error = 2.5 * scale if is_fixed else 8 * eps * size
        near |= (np.abs(state[:, :, None] - ends) <= np.broadcast_to(error, state.shape)[:, :, None]).any(axis=(1, 2))
    if not controller.certificate.holds:  # then nothing is covered
        want, near = np.full(count, False), np.full(count, False)
    got = backend.call("covered", *inputs)[0]
    want = np.where(near, got, want)
    return got.astype(float), want.astype(float), np.zeros(count)


def _numbers(values: Array, backend: Backend, scale: float) -> Array:
    """States as the backend takes them: numbers of its type, or integers of 32 bits."""
    clipped = np.clip(values, -FAR, FAR)
    if backend.scalar == "fixed":
        return np.asarray(np.clip(np.rint(clipped / scale), -(2**31), 2**31 - 1), dtype=np.int32)
    return np.asarray(clipped, dtype=np.float32 if backend.scalar == "float" else np.float64)
