"""Half-spaces in floating point, as arrays: the oblique faces of unsafe sets, and the walls behind which a tube must stay.

The arena (arena.py) holds them for all searches. Every normal n is divided by |n|_1, so the distance to a half-space says by how
much a box may grow towards it. Sums run over the dimensions one after the other, so they are the same on every machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
ROUNDING_TOLERANCE = 1e-12  # a point may lie so far outside of a half-space, for its coordinates are rounded


@dataclass(frozen=True)
class ObliqueFaces:
    """The faces of unsafe sets that are not perpendicular to an axis: normal.x <= upper_bound on the set.

    normal: (X, n), each over its |n|_1. upper_bound: (X,), the support h(n) of the set. set_index: (X,), rising, the index of the
    set. bends: for each set with such faces, points and signs (2, V, n): where a shortest way around the grown set may bend
    (`ConvexSet.route_corners`); None for a box. is_complete: whether these are all faces of all sets; a round set has more.
    """

    normal: Array
    upper_bound: Array
    set_index: npt.NDArray[np.int64]
    bends: tuple[Array | None, ...]
    is_complete: bool

    def of_sets(self, sets: Sequence[int]) -> ObliqueFaces:
        """Return the faces of the sets with these indices; the sets are numbered from 0 again, in this order."""
        kept = np.isin(self.set_index, sets)
        set_index = np.array([sets.index(j) for j in self.set_index[kept]], dtype=np.int64)
        return ObliqueFaces(
            self.normal[kept], self.upper_bound[kept], set_index, tuple(self.bends[j] for j in sets), self.is_complete
        )

    def scaled(self, unit: float) -> ObliqueFaces:
        """Return the same faces with lengths measured in `unit`."""
        bends = tuple(None if b is None else np.stack([b[0] / unit, b[1]]) for b in self.bends)
        return replace(self, upper_bound=self.upper_bound / unit, bends=bends)

    def indices_of(self, j: int) -> range:
        """Return the indices of the faces of the set with index j."""
        return range(int(np.searchsorted(self.set_index, j)), int(np.searchsorted(self.set_index, j, side="right")))

    def box_support(self, half_widths: Array) -> Array:
        """Return how much a box of these half widths (n,) adds to each h(n), the sum of |n_i| half_widths_i: (X,)."""
        return _box_support(self.normal, half_widths)

    def distances_beyond(self, edges: Array, first_face: int = 0, end_face: int | None = None) -> Array:
        """Return how far boxes are beyond each of the faces from `first_face` to before `end_face`: (X, ...).

        Distances are in the largest component.

        edges: (2, n, ...), lower and upper. A negative distance says that a part of the box is on the side of the set.
        """
        normal, upper_bound = self.normal[first_face:end_face], self.upper_bound[first_face:end_face]
        return distances_beyond(normal, upper_bound.reshape(-1, *(1 for _ in edges.shape[2:])), edges)


@dataclass(frozen=True)
class HalfSpaces:
    """Half-spaces that the tube must be in, normal.x >= lower_bound: normal (M, n), each over its |n|_1; lower_bound (M,).

    The inequality points the other way than that of `ObliqueFaces`, which a tube must be outside of.
    """

    normal: Array
    lower_bound: Array

    def scaled(self, unit: float) -> HalfSpaces:
        """Return the same half-spaces with lengths measured in `unit`."""
        return HalfSpaces(self.normal, self.lower_bound / unit)

    def box_support(self, half_widths: Array) -> Array:
        """Return by how much each bound rises for the centre of a box of these half widths (n,): (M,)."""
        return _box_support(self.normal, half_widths)

    def contain_boxes(self, centres: Array, half_widths: Array) -> npt.NDArray[np.bool_]:
        """Return which boxes of these half widths (n,) about centres (P, n) lie in all of the half-spaces: (P,)."""
        margins = np.tile(-self.lower_bound - self.box_support(half_widths), (len(centres), 1))
        for i in range(centres.shape[1]):
            margins = margins + centres[:, i, None] * self.normal[:, i]
        return np.asarray((margins >= -ROUNDING_TOLERANCE).all(axis=1))


def _box_support(normal: Array, half_widths: Array) -> Array:
    """Return the support of a box in the directions of the normals (X, n): (X,)."""
    total = np.zeros(len(normal))
    for i, half_width in enumerate(half_widths.tolist()):
        total = total + np.abs(normal[:, i]) * half_width
    return total


def distances_beyond(normal: Array, bounds: Array, edges: Array) -> Array:
    """Return how far boxes are beyond half-spaces, in the largest component: (N, ...).

    normal: (N, n). bounds: (N, ...), or of a shape that broadcasts to it. edges: (2, n, ...), lower and upper.
    """
    total = -bounds
    for i in range(normal.shape[1]):
        c = normal[:, i].reshape(-1, *(1 for _ in edges.shape[2:]))
        total = total + np.maximum(c, 0.0) * edges[0, i] + np.minimum(c, 0.0) * edges[1, i]
    return np.asarray(total)
