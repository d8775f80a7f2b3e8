"""The points at which backends are compared: random ones, special times with their neighbours, and states along a trajectory.

The files *_comparison.py of this folder choose their points here. P is the number of points, n that of dimensions. Every function
draws from a generator of its own with a fixed seed, so results repeat.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.designs import ALPHA_STEPS, MINIMUM_WIDTH, AdaptiveDesign, grid_tube, parameters_of
from stt_codegen.task import Task

Array = npt.NDArray[Any]


def _number_type(scalar: str) -> type:
    """Return NumPy's type for a scalar "float" or "double"."""
    return np.float32 if scalar == "float" else np.float64


def random_times(task: Task, special_times: Array, count: int, scalar: str) -> Array:
    """Choose times, numbers of the scalar's type: so many random ones from before 0 to after t_c, special ones, and extreme ones.

    Each special time comes with its two neighbours among the numbers of that type, and 8 times, for different states."""
    number_type = _number_type(scalar)
    random = np.random.default_rng(20240)
    t_c = float(task.prescribed_time)
    special = [number_type(v) for v in special_times]
    times = [*special, *(np.nextafter(v, number_type(np.inf)) for v in special)]
    times += [np.nextafter(v, number_type(-np.inf)) for v in special]
    times += [number_type(v) for v in (-1.0, -1e30, 1e-30, 2 * t_c, 1e30, -0.0)]
    repeated: Array = np.repeat(np.array(times, dtype=number_type), 8)
    return np.asarray(np.concatenate([repeated, random.uniform(-0.02 * t_c, 1.02 * t_c, count)]), dtype=number_type)


def random_states(task: Task, low: Array, high: Array, scalar: str) -> Array:
    """Choose states (P, n), numbers of the scalar's type, for tubes with these edges (P, n).

    One in ten is on an edge, at the clamp, close to an edge inside, outside or within 3/4 of the half width, and very far away
    each; the others are anywhere in the tube."""
    number_type = _number_type(scalar)
    random = np.random.default_rng(20241)
    shape = low.shape
    e = random.uniform(-1, 1, shape)
    kind = random.integers(0, 10, shape)
    close_to_edge = np.sign(e) * (1 - 10.0 ** -random.uniform(0, 7, shape))
    at_clamp = np.sign(e) * np.array([float(v) for v in task.e_max])
    e = np.select([kind == 0, kind == 1, kind == 2, kind == 3], [np.sign(e), at_clamp, close_to_edge, 1.5 * e], e)
    states: Array = np.asarray((high + low + (high - low) * e) / 2, dtype=number_type)
    far: Array = (random.choice([-1.0, 1.0], shape) * 10.0 ** random.uniform(0, 30, shape)).astype(number_type)
    return np.where(kind == 4, far, states)


def with_trajectory(task: Task, t: Array, low: Array, high: Array, x: Array) -> Array:
    """Return the states x (P, n) with every fourth one, in the order of time from 0 to t_c, replaced by that of a closed loop.

    The loop is xdot = u from the initial state, with u held between these times, and steps of at most a quarter of the width."""
    order = np.argsort(t, kind="stable")
    indices = order[(t[order] >= 0) & (t[order] <= float(task.prescribed_time))][::4]
    clamp_share = np.array([float((1 - v) / 2) for v in task.e_max])
    gain = np.array([abs(float(v)) for v in task.gain])
    state, time, states = np.array([float(v) for v in task.initial_state]), 0.0, x.copy()
    for k in indices:
        width = np.maximum((high[k] - low[k]).astype(float), float(MINIMUM_WIDTH))
        a = np.clip((state - low[k].astype(float)) / width, clamp_share, 1 - clamp_share)
        u = gain / width * (1 / a + 1 / (1 - a)) * np.log((1 - a) / a)
        state = state + np.clip((float(t[k]) - time) * u, -width / 4, width / 4)
        time = float(t[k])
        states[k] = state
    return states


def random_alpha(design: AdaptiveDesign, t: Array, scalar: str) -> tuple[Array, Array]:
    """Choose alpha (P, 2 n) near the solution of the update equation at times t, and step lengths (P,) up to 20 ms.

    psi + alpha is that of one implicit step, changed by up to a tenth: so it is positive, where (11) is defined."""
    number_type = _number_type(scalar)
    random = np.random.default_rng(20242)
    p = parameters_of(design)
    grid_times, grid_alpha, _, _ = grid_tube(design, ALPHA_STEPS)
    clamped_t = np.clip(t.astype(float), 0, float(design.prescribed_time))
    grid_step = float(design.prescribed_time) / ALPHA_STEPS
    k = np.clip(np.searchsorted(grid_times, clamped_t - grid_step), 0, len(grid_times) - 1)
    alpha = reference.alpha_steps(p, clamped_t - grid_step, np.full(len(t), grid_step), grid_alpha[k])
    psi = reference.lines(p, clamped_t).psi
    changed_alpha = np.maximum((psi + alpha) * random.uniform(0.9, 1.1, (len(t), 1, 1)) - psi, 0)
    alpha_by_side = np.hstack([changed_alpha[:, :, 0], changed_alpha[:, :, 1]])
    return alpha_by_side.astype(number_type), random.uniform(1e-5, 0.02, len(t)).astype(number_type)
