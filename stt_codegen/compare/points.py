"""The points at which backends are compared: random ones, every edge of the time scale, and states along a trajectory."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.designs import MINIMUM_WIDTH, AdaptiveDesign, grid_tube, parameters_of
from stt_codegen.task import Task

Array = npt.NDArray[Any]


def _number(scalar: str) -> type:
    return np.float32 if scalar == "float" else np.float64


def random_times(task: Task, special: Array, points: int, scalar: str) -> Array:
    """Times, all numbers of the backend's type: random ones from before 0 to after t_c, each of `special` with its
    neighbours (8 times each, for different states), and times far outside."""
    number = _number(scalar)
    random = np.random.default_rng(20240)
    t_c = float(task.prescribed_time)
    near = [number(v) for v in special]
    edges = [*near, *(np.nextafter(v, number(np.inf)) for v in near), *(np.nextafter(v, number(-np.inf)) for v in near)]
    edges += [number(v) for v in (-1.0, -1e30, 1e-30, 2 * t_c, 1e30, -0.0)]
    t = np.concatenate([np.repeat(np.array(edges, dtype=number), 8), random.uniform(-0.02 * t_c, 1.02 * t_c, points)])
    return np.asarray(t, dtype=number)


def random_states(task: Task, low: Array, high: Array, scalar: str) -> Array:
    """States for tubes with these edges (P, n), numbers of the backend's type: in the tube, on its edges, just inside and
    outside, at the clamp, outside, and very far away (1 in 10 each)."""
    number = _number(scalar)
    random = np.random.default_rng(20241)
    shape = low.shape
    e = random.uniform(-1, 1, shape)
    kind = random.integers(0, 10, shape)
    tail = np.sign(e) * (1 - 10.0 ** -random.uniform(0, 7, shape))
    at_clamp = np.sign(e) * np.array([float(v) for v in task.e_max])
    e = np.select([kind == 0, kind == 1, kind == 2, kind == 3], [np.sign(e), at_clamp, tail, 1.5 * e], e)
    x: Array = np.asarray((high + low + (high - low) * e) / 2, dtype=number)
    far: Array = (random.choice([-1.0, 1.0], shape) * 10.0 ** random.uniform(0, 30, shape)).astype(number)
    return np.where(kind == 4, far, x)


def with_trajectory(task: Task, t: Array, low: Array, high: Array, x: Array) -> Array:
    """The states x (P, n) with every fourth point in time, from 0 to t_c, replaced by those of a closed loop: xdot = u from the
    initial state, u held between these points, at most a quarter of the width a step."""
    order = np.argsort(t, kind="stable")
    inside = order[(t[order] >= 0) & (t[order] <= float(task.prescribed_time))][::4]
    share = np.array([float((1 - v) / 2) for v in task.e_max])
    gain = np.array([abs(float(v)) for v in task.gain])
    state, before, result = np.array([float(v) for v in task.initial_state]), 0.0, x.copy()
    for k in inside:
        width = np.maximum((high[k] - low[k]).astype(float), float(MINIMUM_WIDTH))
        a = np.clip((state - low[k].astype(float)) / width, share, 1 - share)
        u = gain / width * (1 / a + 1 / (1 - a)) * np.log((1 - a) / a)
        state = state + np.clip((float(t[k]) - before) * u, -width / 4, width / 4)
        before = float(t[k])
        result[k] = state
    return result


def random_alpha(design: AdaptiveDesign, t: Array, scalar: str) -> tuple[Array, Array]:
    """alpha (P, 2 n) near what the update equation has at those times, and step lengths up to 20 ms (P,).

    psi + alpha is one implicit step's, changed by up to a tenth, so that it is positive, where (11) is defined.
    """
    number = _number(scalar)
    random = np.random.default_rng(20242)
    p = parameters_of(design)
    times, alpha, _, _ = grid_tube(design, 2000)
    held = np.clip(t.astype(float), 0, float(design.prescribed_time))
    h = float(design.prescribed_time) / 2000
    k = np.clip(np.searchsorted(times, held - h), 0, len(times) - 1)
    stepped = reference.alpha_steps(p, held - h, np.full(len(t), h), alpha[k])
    psi = reference.lines(p, held).psi
    near = np.maximum((psi + stepped) * random.uniform(0.9, 1.1, (len(t), 1, 1)) - psi, 0)
    return np.hstack([near[:, :, 0], near[:, :, 1]]).astype(number), random.uniform(1e-5, 0.02, len(t)).astype(number)
