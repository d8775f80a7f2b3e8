"""Outlines of sets in two dimensions, for every kind of picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, cut_box, hull_corners

Array = npt.NDArray[np.float64]
Plane = tuple[int, int]  # two dimensions, from 0


def outline(convex: ConvexSet, plane: Plane = (0, 1)) -> Array:
    """The corners of a set's shadow on two dimensions, in order around it: (V, 2)."""
    return hull_of(np.array(convex.projection(*plane)))


def hull_of(points: Array) -> Array:
    """The corners of the hull of points (P, 2), in order around it: (V, 2)."""
    return np.array(hull_corners([(float(x), float(y)) for x, y in points]))


def target_outline(task: Task, plane: Plane) -> Array:
    """The corners of the target at t_c, of a ball those of the polytope in it, in order around it: (V, 2)."""
    corners = cut_box(task.target.lower, task.target.upper, task.target_cuts)
    return hull_of(np.array([[float(v.point[i]) for i in plane] for v in corners]))


def walls(task: Task, plane: Plane) -> list[Array]:
    """What is beyond each cut of the state space in its box; of a cut in other dimensions nothing is seen."""
    space = task.state_space
    ends = [(space.lower[i], space.upper[i]) for i in plane]
    lower, upper = (tuple(e[k] for e in ends) for k in (0, 1))
    found = []
    for normal, offset in space.cuts(task.axis_indices(space), task.dimension):
        own = tuple(normal[i] for i in plane)
        if sum(1 for c in normal if c) != sum(1 for c in own if c):
            continue
        beyond = cut_box(lower, upper, [(tuple(-c for c in own), -offset)])
        corners = hull_corners([(float(v.point[0]), float(v.point[1])) for v in beyond])
        if len(corners) > 2:
            found.append(np.array(corners))
    return found
