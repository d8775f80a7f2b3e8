"""A tube of the user's own as the numbers of a refined design: from control points, or fitted to samples of its edges.

Rounding goes inwards, lower edges up and upper edges down. B-splines are monotone in their control points, so the rounded tube
lies within the one that was given, but for the rounding of a double. What it is worth, the certificate says.
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
USUAL_SEGMENTS = 32


def spline_tube(task: Task, points: Any) -> RefinedDesign:
    """The tube of uniform cubic B-splines with these control points, (K + 3, n, 2) for K segments over [0, t_c]: (lower, upper).

    Raises `BadInput` for another shape, and where the edges do not come to rest at t_c, after which the tube is constant, or,
    where the task repeats itself, the last three points are none with which a cycle could begin.
    """
    c = as_floats("control points", points)
    if c.ndim != 3 or c.shape[0] < 4 or c.shape[1:] != (task.dimension, 2):
        raise BadInput(f"control points: have the shape {c.shape}; (K + 3, {task.dimension}, 2) is needed, for K segments")
    seam = _seam(task, c) if task.repeat else None
    if seam is None and (c[-task.order :] != c[-3]).any():
        told = "make the last equal to the last but two" if task.order == 1 else "for order 2 make the last three equal"
        raise BadInput(f"control points: the tube moves at t_c, where it must rest; {told}")
    lattice = lattice_of(task)
    scaled = np.ldexp(c / 6, lattice.bits)
    if (np.abs(scaled) >= 1 << lattice.significant).any():
        raise BadInput("control points: one is further out than the state space is large; nothing there can be certified")
    table = np.stack([np.ceil(scaled[..., 0]), np.floor(scaled[..., 1])], axis=-1).astype(np.int64)
    rows = tuple(tuple((low, high) for low, high in row) for row in table.tolist())
    return with_filter(task, RefinedDesign(task.prescribed_time, len(rows) - 3, lattice.bits, rows, seam=seam))


def _seam(task: Task, points: Array) -> int:
    """The first segment with whose control points the last three agree, if from there to t_c are whole ticks."""
    segments, tick = len(points) - 3, task.emit.tick_period
    for k in range(1, segments):
        cycle = task.prescribed_time * (segments - k) / segments
        if (points[k : k + 3] == points[-3:]).all() and (tick is None or (cycle / tick).denominator == 1):
            return k
    ticks = " a whole number of ticks before t_c" if tick is not None else ""
    raise BadInput(f"control points: with repeat = true make the last three equal to three with which a cycle begins{ticks}")


def fitted_tube(task: Task, t: Any, lower: Any, upper: Any) -> RefinedDesign:
    """The spline tube nearest to samples of its edges, by least squares, at rest at t_c.

    t: (M,), rising from 0 to t_c; lower, upper: (M, n). It has tube.segments segments, or 32, or as many as M samples determine.
    """
    times, low, high = (as_floats(f"samples: {name}", v) for name, v in (("t", t), ("lower", lower), ("upper", upper)))
    t_c, n = float(task.prescribed_time), task.dimension
    if task.repeat:
        raise BadInput("samples: are fitted by a tube that ends; with repeat = true give control points")
    if times.ndim != 1 or low.shape != (len(times), n) or high.shape != low.shape:
        shapes = f"{times.shape}, {low.shape} and {high.shape}"
        raise BadInput(f"samples: t, lower and upper have the shapes {shapes}; (M,), (M, {n}) and (M, {n}) are needed")
    if len(times) < 4 or times[0] != 0 or times[-1] != t_c or (np.diff(times) <= 0).any():
        raise BadInput(f"samples: t must rise from 0 to t_c = {t_c:g}, at four times or more")
    segments = task.tube.segments or min(USUAL_SEGMENTS, len(times) - 3)
    matrix = spline_basis(times / t_c, segments)
    free = segments + 3 - task.order  # the last control points are the last but two, so that it rests
    matrix[:, segments] += matrix[:, free:].sum(axis=1)
    solved, _, rank, _ = np.linalg.lstsq(matrix[:, :free], np.stack([low, high], axis=-1).reshape(len(times), -1), rcond=None)
    if rank < free:
        raise BadInput(f"samples: {segments} segments are not determined; give more of them, evenly, or set tube.segments")
    last = np.repeat(solved[segments : segments + 1], task.order, axis=0)
    return spline_tube(task, np.concatenate([solved, last]).reshape(segments + 3, n, 2))


def spline_basis(share: Array, segments: int) -> Array:
    """What every control point is worth at these shares of t_c: (M, K + 3), rows of sum 1."""
    u = share * segments
    k = np.minimum(u.astype(int), segments - 1)
    s = u - k
    weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    matrix = np.zeros((len(u), segments + 3))
    for j, weight in enumerate(weights):
        matrix[np.arange(len(u)), k + j] = weight / 6
    return matrix
