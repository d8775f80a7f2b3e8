"""The unsafe sets grown for the tube's centre, as the search for a route asks of them: which points are inside, what is in sight.

The centre of a tube of half width w keeps the clearance c where it is outside the set grown by c + w, by component. Boxes stay
boxes. Of another set every half-space moves outward by the sum of |n_i| (c + w_i). In the plane that is the grown set; in space
it may be larger, where the set needs further faces. Routes and missions search among these sets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array

TOUCH_TOLERANCE = 1e-9  # a line may touch a grown set over this fraction of its length: it passes through the corner
FACE_TOLERANCE = 1e-12  # half-spaces are smaller by it, so that a line along a face, within rounding, is not behind the face


@dataclass(frozen=True, kw_only=True)
class GrownObstacles:
    """The unsafe sets, grown.

    lower, upper: the boxes among them, (B, n). normal (X, n), offset (X,): the half-spaces of the others, those of one set
    together, each set's from `first` on. corners: those of the others, (V, n). spans: lower and upper edges of all grown sets.
    """

    lower: Array
    upper: Array
    normal: Array
    offset: Array
    first: npt.NDArray[np.int64]
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
        if len(self.first):
            behind = self._along_normals(points) < self.offset
            result |= np.logical_and.reduceat(behind, self.first, axis=1).any(axis=1)
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
        return np.asarray(passes_boxes & self._passes_polytopes(a, points) if len(self.first) else passes_boxes)

    def _along_normals(self, points: Array) -> Array:
        """Return n.x for points (P, n): (P, X), summed one dimension after the other."""
        total = np.zeros((len(points), len(self.offset)))
        for i in range(points.shape[1]):
            total = total + points[:, i, None] * self.normal[:, i]
        return total

    def _passes_polytopes(self, a: Array, points: Array) -> npt.NDArray[np.bool_]:
        """Return `visible_from` for the sets that are no boxes: behind each face the line a + t (point - a) has an interval of
        t."""
        at_a, at_points = self._along_normals(a[None]), self._along_normals(points)
        step, margin = at_points - at_a, self.offset - at_a
        with np.errstate(divide="ignore", invalid="ignore"):
            t = margin / step
        enter_half_space = np.where(step < 0, t, np.where((step == 0) & (margin <= 0), np.inf, -np.inf))
        leave_half_space = np.where(step > 0, t, np.inf)
        enter = np.maximum(np.maximum.reduceat(enter_half_space, self.first, axis=1), 0.0)
        leave = np.minimum(np.minimum.reduceat(leave_half_space, self.first, axis=1), 1.0)
        return np.asarray(~np.any(enter < leave - TOUCH_TOLERANCE, axis=1))


def grow_obstacles(arena: Arena, reach: Array) -> GrownObstacles:
    """Return the arena's unsafe sets grown by `reach` (n,), by component."""
    lower, upper = arena.unsafe[:, 0] - reach, arena.unsafe[:, 1] + reach
    n, faces = arena.dimension, arena.oblique_faces
    reach = np.broadcast_to(reach, (n,))
    is_box = np.array([b is None for b in faces.bends], dtype=bool)
    growth = faces.box_support(reach)
    axes = np.concatenate([-np.eye(n), np.eye(n)])
    normals, offsets, first, corners = [], [], [0], [np.empty((0, n))]
    for j in np.nonzero(~is_box)[0]:
        indices, bends = faces.indices_of(int(j)), faces.bends[int(j)]
        assert bends is not None
        normals += [axes, faces.normal[indices]]
        offsets += [-lower[j], upper[j], faces.bound[indices] + growth[indices]]
        first.append(first[-1] + 2 * n + len(indices))
        corners.append(bends[0] + bends[1] * reach)
    return GrownObstacles(
        lower=lower[is_box],
        upper=upper[is_box],
        normal=np.concatenate([np.empty((0, n)), *normals]),
        offset=np.concatenate([np.empty(0), *offsets]) - FACE_TOLERANCE,
        first=np.array(first[:-1], dtype=np.int64),
        corners=np.concatenate(corners),
        spans=(lower, upper),
    )
