"""The sets of a task as the loop's C judges them: arrays of doubles, in the layout of templates/loop/loop.h."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.errors import BadInput
from stt_codegen.task import Task
from stt_codegen.task.sets import SOLID, ConvexSet, Course, HalfSpace

Array = npt.NDArray[Any]
MAX_FACES = 1024  # of an unsafe set, as in loop.h


class JudgedSets:
    """State space, target and unsafe sets of a task; unsafe sets are grown and the state space is shrunk by the body.

    A half-space normal.x <= offset is a row of its unit normal and its offset, n + 1 numbers; F half-spaces are (F, n + 1).

    space_faces, target_faces: half-spaces of the state space and of the target.
    names: names of the unsafe sets, in order.
    faces: half-spaces of all polytopes. Those of set j are the rows from face_range_starts[j] to before face_range_starts[j + 1].
    radius, segments: of round sets, see `_segment_and_box`; the radius is 0 for a polytope.
    knots: rows (time, displacement) of all motions. Those of set j are the rows from knot_range_starts[j] to before
    knot_range_starts[j + 1].
    activity_and_clock: a row of five numbers for each set, see `_activity_and_clock`.
    """

    def __init__(self, task: Task) -> None:
        # Where two walls are equally near, the disturbance "nearest" acts towards the first of this list.
        walls = sorted(task.free_space.faces, key=lambda face: [-abs(c) for c in face[0]] + [-sum(face[0])])
        self.space_faces = _unit_half_spaces([*walls, *task.space_cuts], task.dimension)
        self.target_faces = _unit_half_spaces([*task.target.faces, *task.target_cuts], task.dimension)
        sets = task.obstacles
        self.names = [s.name or f"U{j + 1}" for j, s in enumerate(sets)]
        faces_of_sets = [_half_spaces_of_polytope(s) for s in sets]
        self.radius = np.array([float(s.radius) for s in sets])
        self.segments = np.array([_segment_and_box(s, task) for s in sets]).reshape(-1, 3, task.dimension)
        self.faces = _unit_half_spaces([face for faces in faces_of_sets for face in faces], task.dimension)
        for s, faces in zip(sets, faces_of_sets, strict=True):
            if len(faces) > MAX_FACES:
                raise BadInput(f"unsafe set {s.name}: has {len(faces)} faces; a loop takes at most {MAX_FACES}")
        self.face_range_starts = np.cumsum([0, *map(len, faces_of_sets)]).astype(np.int32)
        knots_of_sets = [() if c is None else c.knots for c in task.courses]
        self.knot_range_starts = np.cumsum([0, *map(len, knots_of_sets)]).astype(np.int32)
        rows = [[float(time), *map(float, displacement)] for knots in knots_of_sets for time, displacement in knots]
        self.knots = np.array(rows).reshape(-1, task.dimension + 1)
        self.activity_and_clock = np.array([_activity_and_clock(c) for c in task.courses]).reshape(-1, 5)


def _activity_and_clock(course: Course | None) -> list[float]:
    """Return begin and end of the active interval, growth a second, and how far the set's clock may lag and lead, in seconds."""
    if course is None:
        return [-math.inf, math.inf, 0.0, 0.0, 0.0]
    begin, stated_end = course.active_interval or (-math.inf, math.inf)
    end = (
        float(stated_end) if stated_end != course.t_c else math.inf
    )  # an interval that ends at t_c does not end for a loop that goes on
    return [float(begin), end, float(course.spread), float(course.clock_lag), float(course.clock_lead)]


def enlarged_sets(task: Task) -> list[str]:
    """Return the unsafe sets that the loop judges by larger sets: polytopes that are grown, by a body or in time.

    In four and more dimensions the faces of such a sum are not known here. So the loop may report a collision that does not
    happen.
    """
    has_body = any(task.half_extents)
    grown = [s for s, table in zip(task.obstacles, task.unsafe, strict=True) if (has_body or table.spread) and not s.radius]
    return [s.name for s in grown if len(s.bounded_axes) > SOLID and any(sum(map(bool, normal)) > 1 for normal in s.normals)]


def _half_spaces_of_polytope(convex: ConvexSet) -> list[HalfSpace]:
    """Return the half-spaces of a polytope in the dimensions that it bounds; none of a round set."""
    if convex.radius:
        return []
    free_axes = [i for i in range(convex.dimension) if i not in convex.bounded_axes]
    return [(normal, offset) for normal, offset in convex.faces if not any(normal[i] for i in free_axes)]


def _segment_and_box(convex: ConvexSet, task: Task) -> Array:
    """Return both ends of a round set's segment, and half the box about each of its points, (3, n); the box is infinite in
    dimensions that the set does not bound."""
    ends, half = np.zeros((2, task.dimension)), np.full(task.dimension, np.inf)
    if convex.radius:
        for i in convex.bounded_axes:
            ends[:, i] = [float(end[i]) for end in convex.segment_ends]
            half[i] = float(task.half_extents[i])
    return np.vstack([ends, half])


def _unit_half_spaces(half_spaces: Sequence[HalfSpace], n: int) -> Array:
    """Return half-spaces with unit normals, (F, n + 1). Their integers may have any number of digits."""
    rows = []
    for normal, offset in half_spaces:
        largest = max(map(abs, normal))
        rows.append([*(float(Fraction(c, largest)) for c in normal), float(offset / largest)])
    scaled = np.array(rows).reshape(-1, n + 1)
    return np.asarray(scaled / np.sqrt((scaled[:, :-1] ** 2).sum(axis=1, keepdims=True)))
