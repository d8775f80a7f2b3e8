"""Cells of space over the tube's segments, and which of them the box about a tube's centre may be in.

search.py searches a route through them; missions (missions/spacetime_plans.py) put the cells in layers, one for each event.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.moving_half_spaces import TimedObstacle

Cell = tuple[int, ...]
Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class SliceCells:
    """The cells of a slice of space, over the tube's segments.

    moving: the dimensions that move through the cells. axes: for each of them the middles of its cells. straight_path: the
    coordinates in the other dimensions at the ends of segments, (K + 1, n); entries of `moving` are not read. growth: clearance
    plus half width of the tube, (n,); the box of these half widths about a free cell's middle avoids every set.
    """

    moving: tuple[int, ...]
    axes: list[Array]
    straight_path: Array
    growth: Array
    cached_products: dict[bytes, Array] = field(default_factory=dict, compare=False, repr=False)  # balls share normals

    @property
    def straight(self) -> list[int]:
        """The dimensions that go straight."""
        return [i for i in range(len(self.growth)) if i not in self.moving]

    @property
    def shape(self) -> Cell:
        return tuple(len(a) for a in self.axes)

    def cell_of(self, point: Array) -> Cell:
        """Return the cell of a point (n,), the nearest one where the point is outside."""
        pairs = zip(self.moving, self.axes, strict=True)
        return tuple(int(np.clip((point[i] - a[0]) / (a[1] - a[0]) + 0.5, 0, len(a) - 1)) for i, a in pairs)

    def path_through(self, cells: Sequence[Cell]) -> Array:
        """Return the middles of one cell for every time: (K + 1, n)."""
        path = self.straight_path.copy()
        for q, i in enumerate(self.moving):
            path[:, i] = [self.axes[q][c[q]] for c in cells]
        return path

    def cells_in(self, goal: Array) -> Flags:
        """Return which cells have their middle in a box (2, n); the nearest where it is narrower than a cell."""
        in_goal = np.ones(self.shape, dtype=bool)
        for q, (i, a) in enumerate(zip(self.moving, self.axes, strict=True)):
            near = (a >= goal[0, i]) & (a <= goal[1, i])
            if not near.any():
                near = np.abs(a - (goal[0, i] + goal[1, i]) / 2) <= a[1] - a[0]
            in_goal &= near.reshape([-1 if p == q else 1 for p in range(len(self.moving))])
        return in_goal

    def free_cells(self, arena: Arena) -> Flags:
        """Return which cells avoid the sets that stand still and are within the walls, by segment: (K, cells)."""
        segments = len(self.straight_path) - 1
        free = np.ones((segments, *self.shape), dtype=bool)
        for j in range(len(arena.names)):
            x = arena.oblique_faces.indices_of(j)
            normal = np.concatenate([_axis_normals(arena.dimension), arena.oblique_faces.normal[x]])
            bound = np.concatenate([_axis_bounds(arena.unsafe[j]), arena.oblique_faces.upper_bound[x]])
            products = self._products(arena.oblique_faces.normal[x])
            for k in range(segments) if self.straight else (0,):
                for position in self.straight_path[k : k + 2]:
                    self._block(free[k : k + 1] if self.straight else free, normal, bound, products, position)
        cuts, half = arena.space_cuts.normal, self.growth - arena.clearance
        minima = arena.space_cuts.lower_bound + arena.space_cuts.box_support(half)
        for product, normal, bound in zip(self._products(cuts), cuts, minima, strict=True):
            for k in range(segments):
                for position in self.straight_path[k : k + 2]:
                    free[k] &= product + self._straight_part(normal[None], position) >= bound
        return free

    def block(self, free: Flags, obstacle: TimedObstacle) -> None:
        """Take from `free` (K, cells) the cells that a timed obstacle may meet."""
        oblique = obstacle.normal[2 * len(self.growth) :]
        products, bounds = self._products(oblique), obstacle.bounds(len(free)).max(axis=2)  # bounds: (N, K)
        for k in np.flatnonzero(bounds[0] > -np.inf).tolist():
            for position in self.straight_path[k : k + 2] if self.straight else self.straight_path[k : k + 1]:
                self._block(free[k : k + 1], obstacle.normal, bounds[:, k], products, position)

    def _products(self, normal: Array) -> Array:
        """Return normal.x over the cells in the moving dimensions, for several normals (X, n): (X, cells)."""
        if (name := normal.tobytes()) in self.cached_products:
            return self.cached_products[name]
        total: Array = np.zeros([len(normal)] + [1] * len(self.moving))
        for q, (i, a) in enumerate(zip(self.moving, self.axes, strict=True)):
            shape = [len(a) if p == q else 1 for p in range(len(self.moving))]
            total = total + (normal[:, i, None] * a).reshape(len(normal), *shape)
        self.cached_products[name] = total
        return total

    def _straight_part(self, normal: Array, position: Array) -> Array:
        """Return the part of normal.x in the dimensions that go straight: (X,)."""
        total = np.zeros(len(normal))
        for i in self.straight:
            total = total + normal[:, i] * position[i]
        return total

    def _block(self, free: Flags, normal: Array, bound: Array, products: Array, position: Array) -> None:
        """Take from `free` (T, cells) the cells whose box is beyond none of a set's half-spaces normal.x <= bound.

        normal: (N, n), of which the first 2n are -e_1, +e_1, ..; bound: (N,). products: of the other normals, by `_products`.
        """
        n, growth = normal.shape[1], self.growth
        for i in self.straight:
            if position[i] <= -bound[2 * i] - growth[i] or position[i] >= bound[2 * i + 1] + growth[i]:
                return
        ends = [(a, -bound[2 * i] - growth[i], bound[2 * i + 1] + growth[i]) for i, a in zip(self.moving, self.axes, strict=True)]
        near = tuple(slice(int(np.searchsorted(a, low, side="right")), int(np.searchsorted(a, high))) for a, low, high in ends)
        if any(part.start >= part.stop for part in near):
            return
        if len(normal) == 2 * n:
            free[(slice(None), *near)] = False
            return
        grown_bound = bound[2 * n :] - self._straight_part(normal[2 * n :], position)
        for i, r in enumerate(growth.tolist()):
            grown_bound = grown_bound + np.abs(normal[2 * n :, i]) * r
        meets = (products[(slice(None), *near)] < grown_bound.reshape(-1, *[1] * len(self.moving))).all(axis=0)
        free[(slice(None), *near)] &= ~meets


def _axis_normals(n: int) -> Array:
    """Return -e_1, +e_1, -e_2, .."""
    return np.array([[sign * (i == k) for k in range(n)] for i in range(n) for sign in (-1.0, 1.0)])


def _axis_bounds(span: Array) -> Array:
    """Return the bounds of `_axis_normals` for a box, shape (2, n)."""
    return np.asarray(np.stack([-span[0], span[1]], axis=1).ravel())
