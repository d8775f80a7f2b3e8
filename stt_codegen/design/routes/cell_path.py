"""A way through the cells between the edges of the grown unsafe sets: complete, where the corners of `shortest_route.py` are not.

`shortest_route.py` looks among near corners first, and in space a way may pass a window between sets that has no corner of its
own. Flood fill over the cells finds every way there is, in time that grows with the power of the dimension.
"""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.routes.grown_sets import Obstacles

LARGEST = 5_000_000  # cells; above, the flood is not tried
ROUNDING = 1e-12
FINE = {1: 1024, 2: 256, 3: 64}  # equal parts of every dimension, where sets are no boxes


def decides(unsafe: int, dimension: int) -> bool:
    """Whether the flood can be tried for so many unsafe sets, so that its answer is final."""
    return bool((2 * unsafe + 2) ** dimension <= LARGEST)


def way_through_cells(lower: Array, upper: Array, space: Array, goal: Array, start: Array) -> Array | None:
    """A polyline, shape (m, n), from `start` into `goal` that meets no open box [lower, upper] (shape (J, n)) and stays in
    `space`; None when there is none. space, goal: shape (2, n)."""
    edges = _edges(np.concatenate([lower, upper, goal]), space)
    middles = _middles(edges)
    free = np.ones([len(m) for m in middles], dtype=bool)
    for low, high in zip(lower, upper, strict=True):
        free[_between(middles, low, high)] = False
    return _way(edges, free, goal, start)


def way_through_grid(obstacles: Obstacles, space: Array, goal: Array, start: Array, within: tuple[Array, Array]) -> Array | None:
    """The same where some sets are no boxes: every dimension is cut into FINE equal parts too, and a cell is free of a set that
    one of its half-spaces shows to be apart. within: half-spaces normal.x >= bound that a cell must be in, (M, n) and (M,). None
    may mean that the cells are too coarse."""
    n = len(start)
    even = [np.linspace(space[0, i], space[1, i], FINE[n] + 1) for i in range(n)]
    edges = _edges(np.concatenate([obstacles.lower, obstacles.upper, goal, np.stack(even, axis=1)]), space)
    middles = _middles(edges)
    free = np.ones([len(m) for m in middles], dtype=bool)
    for low, high in zip(obstacles.lower, obstacles.upper, strict=True):
        free[_between(middles, low, high)] = False
    everywhere = (slice(None),) * n
    for normal, bound in zip(*within, strict=True):
        free &= _least(normal, edges, everywhere) >= bound - ROUNDING
    ends = [*obstacles.first.tolist(), len(obstacles.offset)]
    for first, end in itertools.pairwise(ends):
        normals, offsets = obstacles.normal[first:end], obstacles.offset[first:end]  # the first 2n are -+e_i
        near = tuple(
            slice(max(int(np.searchsorted(axis, -offsets[i])) - 1, 0), int(np.searchsorted(axis, offsets[n + i])))
            for i, axis in enumerate(edges)
        )
        meets = np.ones([len(m[part]) for m, part in zip(middles, near, strict=True)], dtype=bool)
        for normal, offset in zip(normals[2 * n :], offsets[2 * n :], strict=True):
            meets &= _least(normal, edges, near) < offset
        free[near] &= ~meets
    return _way(edges, free, goal, start)


def _least(normal: Array, edges: list[Array], near: tuple[slice, ...]) -> Array:
    """The least of normal.x over every cell of a part of the grid."""
    least: Array = np.zeros(())
    for c, axis, part in zip(normal, edges, near, strict=True):
        least = least[..., None] + np.minimum(c * axis[:-1], c * axis[1:])[part]
    return least


def _edges(inner: Array, space: Array) -> list[Array]:
    """By dimension the edges of the cells: those given that lie inside the space, and its own."""
    found = []
    for i in range(inner.shape[1]):
        inside = inner[(inner[:, i] > space[0, i]) & (inner[:, i] < space[1, i]), i]
        found.append(np.unique(np.concatenate([inside, space[:, i]])))
    return found


def _middles(edges: list[Array]) -> list[Array]:
    return [(axis[:-1] + axis[1:]) / 2 for axis in edges]


def _way(edges: list[Array], free: npt.NDArray[np.bool_], goal: Array, start: Array) -> Array | None:
    """A polyline through free cells from `start` into `goal`."""
    n, middles = len(start), _middles(edges)
    wanted = np.zeros(free.shape, dtype=bool)
    wanted[_between(middles, goal[0], goal[1])] = True
    first = tuple(
        int(np.clip(np.searchsorted(axis, v, side="right") - 1, 0, len(axis) - 2)) for axis, v in zip(edges, start, strict=True)
    )
    if not free[first]:
        return None
    reached = _flood(free, first)
    found = np.argwhere(wanted & (reached >= 0))
    if not len(found):
        return None
    cell = tuple(int(v) for v in min(found, key=lambda c: int(reached[tuple(c)])))
    cells = [cell]
    while cell != first:
        cell = next(c for c in _neighbours(cell, free.shape) if reached[c] == reached[cell] - 1)
        cells.append(cell)
    return np.array([start, *([middles[i][c[i]] for i in range(n)] for c in cells[::-1])])


def _between(middles: list[Array], low: Array, high: Array) -> tuple[slice, ...]:
    """The cells whose middles lie in a box."""
    return tuple(slice(*np.searchsorted(m, (a, b))) for m, a, b in zip(middles, low, high, strict=True))


def _flood(free: npt.NDArray[np.bool_], first: tuple[int, ...]) -> npt.NDArray[np.int64]:
    """Steps from `first` to every free cell, -1 where there is no way."""
    room = np.pad(free, 1)  # a rim that is not free: no neighbour leaves the array
    reached = np.full(room.size, -1, dtype=np.int64)
    strides = [s // room.itemsize for s in room.strides]
    open_ = room.ravel().copy()
    front = np.array([sum((c + 1) * s for c, s in zip(first, strides, strict=True))])
    open_[front] = False
    steps = 0
    while len(front):
        reached[front] = steps
        steps += 1
        beside = np.concatenate([front + d * s for s in strides for d in (-1, 1)])
        front = np.unique(beside[open_[beside]])
        open_[front] = False
    return reached.reshape(room.shape)[(slice(1, -1),) * free.ndim]


def _neighbours(cell: tuple[int, ...], shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    steps = [(*cell[:i], cell[i] + d, *cell[i + 1 :]) for i in range(len(cell)) for d in (-1, 1)]
    return [c for c in steps if all(0 <= v < s for v, s in zip(c, shape, strict=True))]
