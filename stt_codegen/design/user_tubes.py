"""A tube that the user brings, as the numbers of a refined design: from control points, or fitted to samples of its edges.

Rounding goes inwards, lower edges up and upper edges down. B-splines are monotone in their control points, so the rounded tube
lies within the given one, except for the rounding of a double. The API (api.py) calls this; the certificate then says what holds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.arrays import as_floats
from stt_codegen.design.filter_rate import with_filter
from stt_codegen.design.lattice import lattice_of
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.task import Task

Array = npt.NDArray[np.float64]
DEFAULT_SEGMENTS = 32


def spline_tube(task: Task, points: Any) -> RefinedDesign:
    """Return the tube of uniform cubic B-splines with these control points.

    points: (K + 3, n, 2) for K segments over [0, t_c], lower and upper edge last. Raises `BadInput` for another shape; where the
    edges are not at rest at t_c, after which the tube is constant; and, where the task repeats itself, if a cycle cannot begin
    with the last three points.
    """
    control_points = as_floats("control points", points)
    if control_points.ndim != 3 or control_points.shape[0] < 4 or control_points.shape[1:] != (task.dimension, 2):
        shape = control_points.shape
        raise BadInput(f"control points: have the shape {shape}; (K + 3, {task.dimension}, 2) is needed, for K segments")
    seam = _seam_of(task, control_points) if task.repeat else None
    if seam is None and (control_points[-task.order :] != control_points[-3]).any():
        remedy = "make the last equal to the last but two" if task.order == 1 else "for order 2 make the last three equal"
        raise BadInput(f"control points: the tube moves at t_c, where it must rest; {remedy}")
    lattice = lattice_of(task)
    scaled = np.ldexp(control_points / 6, lattice.bits)
    if (np.abs(scaled) >= 1 << lattice.significant_bits).any():
        raise BadInput("control points: one is further out than the state space is large; nothing there can be certified")
    table = np.stack([np.ceil(scaled[..., 0]), np.floor(scaled[..., 1])], axis=-1).astype(np.int64)
    rows = tuple(tuple((low, high) for low, high in row) for row in table.tolist())
    return with_filter(task, RefinedDesign(task.prescribed_time, len(rows) - 3, lattice.bits, rows, seam=seam))


def _seam_of(task: Task, points: Array) -> int:
    """Return the first segment whose control points equal the last three, so that a cycle from there to t_c closes.

    The cycle must last a whole number of ticks. Raises `BadInput` where no segment does.
    """
    segments, tick = len(points) - 3, task.emit.tick_period
    for k in range(1, segments):
        cycle = task.prescribed_time * (segments - k) / segments
        if (points[k : k + 3] == points[-3:]).all() and (tick is None or (cycle / tick).denominator == 1):
            return k
    ticks = " a whole number of ticks before t_c" if tick is not None else ""
    raise BadInput(f"control points: with repeat = true make the last three equal to three with which a cycle begins{ticks}")


def fitted_tube(task: Task, t: Any, lower: Any, upper: Any) -> RefinedDesign:
    """Return the spline tube that is nearest to samples of its edges, by least squares, and at rest at t_c.

    t: (M,), rising from 0 to t_c; lower, upper: (M, n). The tube has tube.segments segments; without that 32, or as many as M
    samples determine. Raises `BadInput` for other shapes or times, and where the samples do not determine the tube.
    """
    times, low, high = (as_floats(f"samples: {name}", v) for name, v in (("t", t), ("lower", lower), ("upper", upper)))
    _require_samples(task, times, low, high)
    segments = task.tube.segments or min(DEFAULT_SEGMENTS, len(times) - 3)
    matrix = spline_basis(times / float(task.prescribed_time), segments)
    # the last control points repeat the last but two, so that the tube is at rest at t_c; their weights are added to its own
    free = segments + 3 - task.order
    matrix[:, segments] += matrix[:, free:].sum(axis=1)
    samples = np.stack([low, high], axis=-1).reshape(len(times), -1)
    solved, _, rank, _ = np.linalg.lstsq(matrix[:, :free], samples, rcond=None)
    if rank < free:
        raise BadInput(f"samples: {segments} segments are not determined; give more of them, evenly, or set tube.segments")
    resting = np.repeat(solved[segments : segments + 1], task.order, axis=0)
    return spline_tube(task, np.concatenate([solved, resting]).reshape(segments + 3, task.dimension, 2))


def _require_samples(task: Task, times: Array, low: Array, high: Array) -> None:
    """Raise `BadInput` where samples have other shapes than (M,) and (M, n), or times that do not rise from 0 to t_c."""
    t_c, n = float(task.prescribed_time), task.dimension
    if task.repeat:
        raise BadInput("samples: are fitted by a tube that ends; with repeat = true give control points")
    if times.ndim != 1 or low.shape != (len(times), n) or high.shape != low.shape:
        shapes = f"{times.shape}, {low.shape} and {high.shape}"
        raise BadInput(f"samples: t, lower and upper have the shapes {shapes}; (M,), (M, {n}) and (M, {n}) are needed")
    if len(times) < 4 or times[0] != 0 or times[-1] != t_c or (np.diff(times) <= 0).any():
        raise BadInput(f"samples: t must rise from 0 to t_c = {t_c:g}, at four times or more")


def spline_basis(progress: Array, segments: int) -> Array:
    """Return the weight of each control point at these fractions (M,) of t_c: (M, K + 3), each row of sum 1."""
    u = progress * segments
    k = np.minimum(u.astype(int), segments - 1)
    s = u - k
    weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    matrix = np.zeros((len(u), segments + 3))
    for j, weight in enumerate(weights):
        matrix[np.arange(len(u)), k + j] = weight / 6
    return matrix
