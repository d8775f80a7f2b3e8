"""The unsafe sets grown for the tube's centre, as the search for a route asks of them: which points are inside, what is in sight.

The centre of a tube of half width w keeps the clearance c where it is outside the set grown by c + w, by component. Boxes
stay boxes; of another set every half-space moves outward by the sum of |n_i| (c + w_i), which is the grown set in the plane and
may be more of space where a face is missing elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array

TOUCH = 1e-9  # a line may touch a grown set over this fraction of its length: it passes through the corner
GRAZES = (
    1e-12  # what a half-space is less by, so that a line along its face, as near as rounding lets it be, is no line behind it
)


@dataclass(frozen=True, kw_only=True)
class Obstacles:
    """lower, upper: the boxes among the grown sets, (B, n). normal (X, n), offset (X,): the half-spaces of the others, those of
    one set together, each set's from `first` on. corners: theirs, (V, n). spans: lower and upper edges of all grown sets."""

    lower: Array
    upper: Array
    normal: Array
    offset: Array
    first: npt.NDArray[np.int64]
    corners: Array
    spans: tuple[Array, Array]

    def near(self, low: Array, high: Array) -> Obstacles:
        """Without the boxes that do not meet the box [low, high]."""
        between = np.all((self.lower < high) & (self.upper > low), axis=1)
        return replace(self, lower=self.lower[between], upper=self.upper[between])

    def inside(self, points: Array) -> npt.NDArray[np.bool_]:
        """Which points (shape (P, n)) lie in the interior of some set."""
        within = np.ones((len(points), len(self.lower)), dtype=bool)
        for i in range(points.shape[1]):  # NumPy reduces over a short last axis slowly
            within &= (points[:, i, None] > self.lower[:, i]) & (points[:, i, None] < self.upper[:, i])
        found = within.any(axis=1)
        if len(self.first):
            behind = self._along(points) < self.offset
            found |= np.logical_and.reduceat(behind, self.first, axis=1).any(axis=1)
        return np.asarray(found)

    def visible(self, a: Array, points: Array) -> npt.NDArray[np.bool_]:
        """Which of `points` can be seen from `a`: the straight line meets no set's interior."""
        first, final = np.zeros((len(points), len(self.lower))), np.ones((len(points), len(self.lower)))
        for i in range(len(a)):
            step = (points[:, i] - a[i])[:, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                t_low, t_high = (self.lower[:, i] - a[i]) / step, (self.upper[:, i] - a[i]) / step
            enter, leave = np.minimum(t_low, t_high), np.maximum(t_low, t_high)
            parallel = step[:, 0] == 0
            if parallel.any():
                between = (a[i] > self.lower[:, i]) & (a[i] < self.upper[:, i])
                enter[parallel] = np.where(between, -np.inf, np.inf)
                leave[parallel] = np.where(between, np.inf, -np.inf)
            np.maximum(first, enter, out=first)
            np.minimum(final, leave, out=final)
        free = ~np.any(first < final - TOUCH, axis=1)
        return np.asarray(free & self._past_faces(a, points) if len(self.first) else free)

    def _along(self, points: Array) -> Array:
        """n.x for points (P, n): (P, X), summed one dimension after the other."""
        total = np.zeros((len(points), len(self.offset)))
        for i in range(points.shape[1]):
            total = total + points[:, i, None] * self.normal[:, i]
        return total

    def _past_faces(self, a: Array, points: Array) -> npt.NDArray[np.bool_]:
        """`visible` for the sets that are no boxes: the line is behind the face where a + t (point - a) is, an interval of t."""
        here, there = self._along(a[None]), self._along(points)
        step, room = there - here, self.offset - here
        with np.errstate(divide="ignore", invalid="ignore"):
            t = room / step
        enter = np.where(step < 0, t, np.where((step == 0) & (room <= 0), np.inf, -np.inf))
        leave = np.where(step > 0, t, np.inf)
        first = np.maximum(np.maximum.reduceat(enter, self.first, axis=1), 0.0)
        final = np.minimum(np.minimum.reduceat(leave, self.first, axis=1), 1.0)
        return np.asarray(~np.any(first < final - TOUCH, axis=1))


def obstacles_of(arena: Arena, reach: Array) -> Obstacles:
    """The arena's unsafe sets grown by `reach` (n,), by component."""
    lower, upper = arena.unsafe[:, 0] - reach, arena.unsafe[:, 1] + reach
    n, faces = arena.dimension, arena.oblique_faces
    reach = np.broadcast_to(reach, (n,))
    box = np.array([b is None for b in faces.bends], dtype=bool)
    further = faces.box_support(reach)
    axes = np.concatenate([-np.eye(n), np.eye(n)])
    normals, offsets, first, corners = [], [], [0], [np.empty((0, n))]
    for j in np.nonzero(~box)[0]:
        own, bends = faces.indices_of(int(j)), faces.bends[int(j)]
        assert bends is not None
        normals += [axes, faces.normal[own]]
        offsets += [-lower[j], upper[j], faces.bound[own] + further[own]]
        first.append(first[-1] + 2 * n + len(own))
        corners.append(bends[0] + bends[1] * reach)
    return Obstacles(
        lower=lower[box],
        upper=upper[box],
        normal=np.concatenate([np.empty((0, n)), *normals]),
        offset=np.concatenate([np.empty(0), *offsets]) - GRAZES,
        first=np.array(first[:-1], dtype=np.int64),
        corners=np.concatenate(corners),
        spans=(lower, upper),
    )
