"""The unsafe sets grown for the tube's centre, as routes need them: which points are inside, and which are in sight.

The centre of a tube of half width w keeps the clearance c from a set if it is outside the set grown by c + w, by component. Boxes
stay boxes. The half-spaces of any other set move outward, each by the sum of |n_i| (c + w_i). In the plane the result is the
grown set. In space it may be larger, because the grown set has further faces there. Routes and missions search among these sets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array

TOUCH_TOLERANCE = 1e-9  # a line may touch a grown set over this fraction of its length: it passes through the corner
FACE_TOLERANCE = 1e-12  # half-spaces are smaller by it, so a rounded line along a face does not pass behind the face


@dataclass(frozen=True, kw_only=True)
class GrownObstacles:
    """The unsafe sets, grown.

    lower, upper: the boxes, (B, n). normal (X, n), offset (X,): the half-spaces normal.x <= offset of all other sets, set by set.
    first_faces: the index of the first half-space of each of these sets. corners: of these sets, (V, n). spans: the bounding
    boxes of all sets, boxes too, as lower and upper corners (J, n).
    """

    lower: Array
    upper: Array
    normal: Array
    offset: Array
    first_faces: npt.NDArray[np.int64]
    corners: Array
    spans: tuple[Array, Array]

    def without_distant_boxes(self, low: Array, high: Array) -> GrownObstacles:
        """Return the sets without the boxes that do not meet the box [low, high]."""
        meets = np.all((self.lower < high) & (self.upper > low), axis=1)
        return replace(self, lower=self.lower[meets], upper=self.upper[meets])

    def contain(self, points: Array) -> npt.NDArray[np.bool_]:
        """Return which points (shape (P, n)) lie in the interior of some set."""
        in_box = np.ones((len(points), len(self.lower)), dtype=bool)
        for i in range(points.shape[1]):  # NumPy reduces over a short last axis slowly
            in_box &= (points[:, i, None] > self.lower[:, i]) & (points[:, i, None] < self.upper[:, i])
        result = in_box.any(axis=1)
        if len(self.first_faces):
            behind = self._along_normals(points) < self.offset
            result |= np.logical_and.reduceat(behind, self.first_faces, axis=1).any(axis=1)
        return np.asarray(result)

    def visible_from(self, a: Array, points: Array) -> npt.NDArray[np.bool_]:
        """Return which of `points` can be seen from `a`: the straight line meets no set's interior."""
        enter, leave = np.zeros((len(points), len(self.lower))), np.ones((len(points), len(self.lower)))
        for i in range(len(a)):
            step = (points[:, i] - a[i])[:, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                t_low, t_high = (self.lower[:, i] - a[i]) / step, (self.upper[:, i] - a[i]) / step
            enter_slab, leave_slab = np.minimum(t_low, t_high), np.maximum(t_low, t_high)
            parallel = step[:, 0] == 0
            if parallel.any():
                between = (a[i] > self.lower[:, i]) & (a[i] < self.upper[:, i])
                enter_slab[parallel] = np.where(between, -np.inf, np.inf)
                leave_slab[parallel] = np.where(between, np.inf, -np.inf)
            np.maximum(enter, enter_slab, out=enter)
            np.minimum(leave, leave_slab, out=leave)
        passes_boxes = ~np.any(enter < leave - TOUCH_TOLERANCE, axis=1)
        return np.asarray(passes_boxes & self._passes_polytopes(a, points) if len(self.first_faces) else passes_boxes)

    def _along_normals(self, points: Array) -> Array:
        """Return n.x for points (P, n): (P, X), summed one dimension after the other."""
        total = np.zeros((len(points), len(self.offset)))
        for i in range(points.shape[1]):
            total = total + points[:, i, None] * self.normal[:, i]
        return total

    def _passes_polytopes(self, a: Array, points: Array) -> npt.NDArray[np.bool_]:
        """Return `visible_from` for the sets that are no boxes.

        The line a + t (point - a) is behind each face for an interval of t, and in the set where these intervals meet.
        """
        at_a, at_points = self._along_normals(a[None]), self._along_normals(points)
        step, margin = at_points - at_a, self.offset - at_a
        with np.errstate(divide="ignore", invalid="ignore"):
            t = margin / step
        enter_half_space = np.where(step < 0, t, np.where((step == 0) & (margin <= 0), np.inf, -np.inf))
        leave_half_space = np.where(step > 0, t, np.inf)
        enter = np.maximum(np.maximum.reduceat(enter_half_space, self.first_faces, axis=1), 0.0)
        leave = np.minimum(np.minimum.reduceat(leave_half_space, self.first_faces, axis=1), 1.0)
        return np.asarray(~np.any(enter < leave - TOUCH_TOLERANCE, axis=1))


def grow_obstacles(arena: Arena, growth: Array) -> GrownObstacles:
    """Return the arena's unsafe sets grown by `growth` (n,), by component."""
    lower, upper = arena.unsafe[:, 0] - growth, arena.unsafe[:, 1] + growth
    n, faces = arena.dimension, arena.oblique_faces
    growth = np.broadcast_to(growth, (n,))
    is_box = np.array([b is None for b in faces.bends], dtype=bool)
    face_growth = faces.box_support(growth)
    axes = np.concatenate([-np.eye(n), np.eye(n)])
    normals, offsets, first_faces, corners = [], [], [0], [np.empty((0, n))]
    for j in np.nonzero(~is_box)[0]:
        indices, bends = faces.indices_of(int(j)), faces.bends[int(j)]
        assert bends is not None
        normals += [axes, faces.normal[indices]]
        offsets += [-lower[j], upper[j], faces.upper_bound[indices] + face_growth[indices]]
        first_faces.append(first_faces[-1] + 2 * n + len(indices))
        corners.append(bends[0] + bends[1] * growth)
    return GrownObstacles(
        lower=lower[is_box],
        upper=upper[is_box],
        normal=np.concatenate([np.empty((0, n)), *normals]),
        offset=np.concatenate([np.empty(0), *offsets]) - FACE_TOLERANCE,
        first_faces=np.array(first_faces[:-1], dtype=np.int64),
        corners=np.concatenate(corners),
        spans=(lower, upper),
    )
