"""Outlines of sets in two dimensions, for every kind of picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stt_codegen.task import Task
from stt_codegen.task.polytopes import around, cut_box
from stt_codegen.task.sets import ConvexSet

Array = npt.NDArray[np.float64]
Plane = tuple[int, int]  # two dimensions, from 0


def outline(convex: ConvexSet, plane: Plane = (0, 1)) -> Array:
    """The corners of a set's shadow on two dimensions, in order around it: (V, 2)."""
    return hull_of(np.array(convex.shadow(*plane)))


def hull_of(points: Array) -> Array:
    """The corners of the hull of points (P, 2), in order around it: (V, 2)."""
    return np.array(around([(float(x), float(y)) for x, y in points]))


def target_outline(task: Task, plane: Plane) -> Array:
    """The corners of the target at t_c, of a ball those of the polytope in it, in order around it: (V, 2)."""
    corners = cut_box(task.target.lower, task.target.upper, task.target_cuts)
    return hull_of(np.array([[float(v.point[i]) for i in plane] for v in corners]))
