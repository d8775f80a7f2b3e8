"""Half-spaces in floating point, as arrays: beyond which faces of unsafe sets a tube may be, and behind which walls it must stay.

Everything is over |n|_1, so that what is left of an inequality is by how much the tube's box may grow. Sums go one dimension
after the other, the same on every machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
TIGHT = 1e-12  # what a point may lack of a half-space for its rounding


@dataclass(frozen=True)
class Faces:
    """The normals of unsafe sets that are no axes, each over its |n|_1: normal (X, n), bound h(n) (X,), owner (X,) the set's
    number, one set's together. bends: of every set that has such a normal the points and signs of its bends, (2, V, n); None for
    a box."""

    normal: Array
    bound: Array
    owner: npt.NDArray[np.int64]
    bends: tuple[Array | None, ...]
    exact: bool  # whether they are all faces of all sets: a round one has more

    def only(self, keep: Sequence[int]) -> Faces:
        """The faces of the sets whose numbers are in `keep`, numbered anew."""
        kept = np.isin(self.owner, keep)
        owner = np.array([keep.index(j) for j in self.owner[kept]], dtype=np.int64)
        return Faces(self.normal[kept], self.bound[kept], owner, tuple(self.bends[j] for j in keep), self.exact)

    def scaled(self, unit: float) -> Faces:
        """The same faces with lengths measured in `unit`."""
        bends = tuple(None if b is None else np.stack([b[0] / unit, b[1]]) for b in self.bends)
        return replace(self, bound=self.bound / unit, bends=bends)

    def of(self, j: int) -> range:
        """The faces of set j."""
        return range(int(np.searchsorted(self.owner, j)), int(np.searchsorted(self.owner, j, side="right")))

    def length(self, reach: Array) -> Array:
        """How much a box of these half widths (n,) adds to every h(n): the sum of |n_i| reach_i, one dimension after the other,
        the same on every machine. (X,)"""
        total = np.zeros(len(self.bound))
        for i, r in enumerate(reach.tolist()):
            total = total + np.abs(self.normal[:, i]) * r
        return total

    def beyond(self, edges: Array, first: int = 0, end: int | None = None) -> Array:
        """How far boxes, edges of shape (2, n, ...), are beyond each of the faces from `first` to `end`, in the largest
        component: (X, ...)."""
        normal, bound = self.normal[first:end], self.bound[first:end]
        shape = (len(bound), *(1 for _ in edges.shape[2:]))
        total = -bound.reshape(shape)
        for i in range(normal.shape[1]):
            c = normal[:, i].reshape(shape)
            total = total + np.maximum(c, 0.0) * edges[0, i] + np.minimum(c, 0.0) * edges[1, i]
        return np.asarray(total)


@dataclass(frozen=True)
class Cuts:
    """Half-spaces that the tube must be in, normal.x >= bound: normal (M, n) over its |n|_1, bound (M,)."""

    normal: Array
    bound: Array

    def scaled(self, unit: float) -> Cuts:
        """The same with lengths measured in `unit`."""
        return Cuts(self.normal, self.bound / unit)

    def length(self, inset: Array) -> Array:
        """What a box of these half widths (n,) takes of every bound: (M,)."""
        total = np.zeros(len(self.bound))
        for i, r in enumerate(inset.tolist()):
            total = total + np.abs(self.normal[:, i]) * r
        return total

    def hold(self, points: Array, inset: Array) -> npt.NDArray[np.bool_]:
        """Whether boxes of these half widths (n,) about points (P, n) lie in all of them."""
        room = np.tile(-self.bound - self.length(inset), (len(points), 1))
        for i in range(points.shape[1]):
            room = room + points[:, i, None] * self.normal[:, i]
        return np.asarray((room >= -TIGHT).all(axis=1))
