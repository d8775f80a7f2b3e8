"""Cells of space over the tube's segments, and which of them the box about a tube's centre may be in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.moving_half_spaces import TimedObstacle

Cell = tuple[int, ...]


@dataclass(frozen=True)
class Cells:
    """Of a slice of space, over the tube's segments. own: the dimensions that move through them; axes: by own dimension the
    middles of its cells; rest: where the others are at the ends of segments, (K + 1, n), entries of `own` not read; reach: half
    widths, clearance included, of the box about a cell's middle that must be off every set, (n,)."""

    own: tuple[int, ...]
    axes: list[Array]
    rest: Array
    reach: Array
    known: dict[bytes, Array] = field(default_factory=dict, compare=False, repr=False)  # of `_across`: balls share normals

    @property
    def others(self) -> list[int]:
        """The dimensions that go straight."""
        return [i for i in range(len(self.reach)) if i not in self.own]

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(a) for a in self.axes)

    def near(self, centre: Array) -> Cell:
        """The cell of a point."""
        pairs = zip(self.own, self.axes, strict=True)
        return tuple(int(np.clip((centre[i] - a[0]) / (a[1] - a[0]) + 0.5, 0, len(a) - 1)) for i, a in pairs)

    def points(self, cells: Sequence[Cell]) -> Array:
        """The middles of one cell for every time: (K + 1, n)."""
        points = self.rest.copy()
        for q, i in enumerate(self.own):
            points[:, i] = [self.axes[q][c[q]] for c in cells]
        return points

    def inside(self, goal: Array) -> npt.NDArray[np.bool_]:
        """Which cells have their middle in a box (2, n); the nearest where it is narrower than a cell."""
        wanted = np.ones(self.shape, dtype=bool)
        for q, (i, a) in enumerate(zip(self.own, self.axes, strict=True)):
            near = (a >= goal[0, i]) & (a <= goal[1, i])
            if not near.any():
                near = np.abs(a - (goal[0, i] + goal[1, i]) / 2) <= a[1] - a[0]
            wanted &= near.reshape([-1 if p == q else 1 for p in range(len(self.own))])
        return wanted

    def free(self, arena: Arena) -> npt.NDArray[np.bool_]:
        """Which are off the sets that stand and within the walls, by segment: (K, cells)."""
        segments = len(self.rest) - 1
        free = np.ones((segments, *self.shape), dtype=bool)
        for j in range(len(arena.names)):
            x = arena.oblique_faces.indices_of(j)
            normal = np.concatenate([_axes(arena.dimension), arena.oblique_faces.normal[x]])
            bound, along = (
                np.concatenate([_ends(arena.unsafe[j]), arena.oblique_faces.bound[x]]),
                self._across(arena.oblique_faces.normal[x]),
            )
            for k in range(segments) if self.others else (0,):
                for place in self.rest[k : k + 2]:
                    self._take(free[k : k + 1] if self.others else free, normal, bound, along, place)
        walls, half = arena.walls.normal, self.reach - arena.clearance
        least = arena.walls.bound + arena.walls.box_support(half)
        for along, normal, bound in zip(self._across(walls), walls, least, strict=True):
            for k in range(segments):
                for place in self.rest[k : k + 2]:
                    free[k] &= along + self._elsewhere(normal[None], place) >= bound
        return free

    def block(self, free: npt.NDArray[np.bool_], obstacle: TimedObstacle) -> None:
        """Takes from `free` (K, cells) those that a moving set may meet."""
        slanted = obstacle.normal[2 * len(self.reach) :]
        along, bounds = self._across(slanted), obstacle.bounds(len(free)).max(axis=2)  # (N, K)
        for k in np.flatnonzero(bounds[0] > -np.inf).tolist():
            for place in self.rest[k : k + 2] if self.others else self.rest[k : k + 1]:
                self._take(free[k : k + 1], obstacle.normal, bounds[:, k], along, place)

    def _across(self, normal: Array) -> Array:
        """normal.x over the cells in the slice's own dimensions, for several normals (X, n): (X, cells)."""
        if (name := normal.tobytes()) in self.known:
            return self.known[name]
        total: Array = np.zeros([len(normal)] + [1] * len(self.own))
        for q, (i, a) in enumerate(zip(self.own, self.axes, strict=True)):
            shape = [len(a) if p == q else 1 for p in range(len(self.own))]
            total = total + (normal[:, i, None] * a).reshape(len(normal), *shape)
        self.known[name] = total
        return total

    def _elsewhere(self, normal: Array, rest: Array) -> Array:
        """The part of normal.x in the other dimensions: (X,)."""
        total = np.zeros(len(normal))
        for i in self.others:
            total = total + normal[:, i] * rest[i]
        return total

    def _take(self, free: npt.NDArray[np.bool_], normal: Array, bound: Array, along: Array, rest: Array) -> None:
        """Takes from `free` (T, cells) those whose box is beyond none of a set's half-spaces; the first 2n are -e_1, +e_1, ..
        along: of the others."""
        n, reach = normal.shape[1], self.reach
        for i in self.others:
            if rest[i] <= -bound[2 * i] - reach[i] or rest[i] >= bound[2 * i + 1] + reach[i]:
                return
        ends = [(a, -bound[2 * i] - reach[i], bound[2 * i + 1] + reach[i]) for i, a in zip(self.own, self.axes, strict=True)]
        near = tuple(slice(int(np.searchsorted(a, low, side="right")), int(np.searchsorted(a, high))) for a, low, high in ends)
        if any(part.start >= part.stop for part in near):
            return
        if len(normal) == 2 * n:
            free[(slice(None), *near)] = False
            return
        further = bound[2 * n :] - self._elsewhere(normal[2 * n :], rest)
        for i, r in enumerate(reach.tolist()):
            further = further + np.abs(normal[2 * n :, i]) * r
        meets = (along[(slice(None), *near)] < further.reshape(-1, *[1] * len(self.own))).all(axis=0)
        free[(slice(None), *near)] &= ~meets


def _axes(n: int) -> Array:
    """-e_1, +e_1, -e_2, .."""
    return np.array([[sign * (i == k) for k in range(n)] for i in range(n) for sign in (-1.0, 1.0)])


def _ends(span: Array) -> Array:
    """The bounds of `_axes` for a box, shape (2, n)."""
    return np.asarray(np.stack([-span[0], span[1]], axis=1).ravel())
