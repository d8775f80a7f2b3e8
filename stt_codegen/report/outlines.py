"""Compute outlines of sets in two dimensions, for pictures and pages."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, cut_box, hull_corners

Array = npt.NDArray[np.float64]
Plane = tuple[int, int]  # two dimensions, from 0


def outline(convex: ConvexSet, plane: Plane = (0, 1)) -> Array:
    """Return the corners of a set's projection on two dimensions, in order around it: (V, 2)."""
    return hull_of(np.array(convex.projection(*plane)))


def hull_of(points: Array) -> Array:
    """Return the corners of the hull of points (P, 2), in order around it: (V, 2)."""
    return np.array(hull_corners([(float(x), float(y)) for x, y in points]))


def target_outline(task: Task, plane: Plane) -> Array:
    """Return the corners of the target at t_c, in order around it: (V, 2). A ball is the polytope inside it."""
    corners = cut_box(task.target.lower, task.target.upper, task.target_cuts)
    return hull_of(np.array([[float(v.point[i]) for i in plane] for v in corners]))


def cut_off_outlines(task: Task, plane: Plane) -> list[Array]:
    """Return the outline of each part of the state space's box that a half-space cuts off.

    A half-space with a normal outside of the plane has no outline there, and is left out.
    """
    space = task.state_space
    ends = [(space.lower[i], space.upper[i]) for i in plane]
    lower, upper = (tuple(e[k] for e in ends) for k in (0, 1))
    outlines = []
    for normal, offset in space.cuts(task.axis_indices(space), task.dimension):
        plane_normal = tuple(normal[i] for i in plane)
        if sum(1 for c in normal if c) != sum(1 for c in plane_normal if c):
            continue
        beyond = cut_box(lower, upper, [(tuple(-c for c in plane_normal), -offset)])
        corners = hull_corners([(float(v.point[0]), float(v.point[1])) for v in beyond])
        if len(corners) > 2:
            outlines.append(np.array(corners))
    return outlines
