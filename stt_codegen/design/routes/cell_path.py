"""A path through cells: the boxes into which the faces of the grown unsafe sets cut the state space.

shortest_route.py calls it where corner_search.py finds no route. In space a route may lead through a window between sets that has
no corner of its own, which a search among corners misses. A flood fill of the cells finds a path whenever there is one, if all
sets are boxes. The number of cells grows with the power of the dimension.
"""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from stt_codegen.design.half_spaces import Array, HalfSpaces
from stt_codegen.design.routes.grown_sets import GrownObstacles

CELL_COUNT_LIMIT = 5_000_000  # with more cells the flood is not tried
ROUNDING_TOLERANCE = 1e-12  # of the bounds of half-spaces
GRID_DIVISIONS = {1: 1024, 2: 256, 3: 64}  # equal parts of each dimension, by the number of dimensions; where sets are no boxes

Cell = tuple[int, ...]
Flags = npt.NDArray[np.bool_]


def has_few_cells(unsafe_count: int, dimension: int) -> bool:
    """Return whether so many unsafe sets cut the space into at most CELL_COUNT_LIMIT cells, so that the flood is quick enough."""
    return bool((2 * unsafe_count + 2) ** dimension <= CELL_COUNT_LIMIT)


def find_cell_path(lower: Array, upper: Array, space: Array, goal: Array, start: Array) -> Array | None:
    """Return a polyline, shape (m, n), from `start` into `goal` that meets no open box; None when there is none.

    lower, upper: the boxes, shape (J, n). space, goal: lower and upper corners, shape (2, n); the polyline stays in `space`.
    """
    boundaries = _cell_boundaries(np.concatenate([lower, upper, goal]), space)
    middles = _middles(boundaries)
    free = np.ones([len(m) for m in middles], dtype=bool)
    for low, high in zip(lower, upper, strict=True):
        free[_cells_in_box(middles, low, high)] = False
    return _path_through(boundaries, free, goal, start)


def find_grid_path(obstacles: GrownObstacles, space: Array, goal: Array, start: Array, cuts: HalfSpaces) -> Array | None:
    """Return a polyline as `find_cell_path` does, where some sets are no boxes; None may mean that the cells are too coarse.

    Cells are cut at the faces of the sets' bounding boxes, and also into GRID_DIVISIONS equal parts in each dimension. A cell is
    free of a set if it lies beyond one of the set's half-spaces. cuts: half-spaces that a cell must be in, normal.x >=
    lower_bound.
    """
    n = len(start)
    equal_parts = [np.linspace(space[0, i], space[1, i], GRID_DIVISIONS[n] + 1) for i in range(n)]
    boundaries = _cell_boundaries(np.concatenate([obstacles.lower, obstacles.upper, goal, np.stack(equal_parts, axis=1)]), space)
    middles = _middles(boundaries)
    free = np.ones([len(m) for m in middles], dtype=bool)
    for low, high in zip(obstacles.lower, obstacles.upper, strict=True):
        free[_cells_in_box(middles, low, high)] = False
    all_cells = (slice(None),) * n
    for normal, lower_bound in zip(cuts.normal, cuts.lower_bound, strict=True):
        free &= _lowest_values(normal, boundaries, all_cells) >= lower_bound - ROUNDING_TOLERANCE
    for first_face, end_face in itertools.pairwise([*obstacles.first_faces.tolist(), len(obstacles.offset)]):
        _block_polytope(free, boundaries, obstacles.normal[first_face:end_face], obstacles.offset[first_face:end_face])
    return _path_through(boundaries, free, goal, start)


def _block_polytope(free: Flags, boundaries: list[Array], normals: Array, offsets: Array) -> None:
    """Take from `free` the cells that lie beyond none of the half-spaces normal.x <= offset of a set.

    normals: (N, n), of which the first 2n are -e_1 .. -e_n, +e_1 .. +e_n. offsets: (N,).
    """
    n = len(boundaries)
    near_cells = tuple(
        slice(max(int(np.searchsorted(axis, -offsets[i])) - 1, 0), int(np.searchsorted(axis, offsets[n + i])))
        for i, axis in enumerate(boundaries)
    )
    meets = np.ones(free[near_cells].shape, dtype=bool)
    for normal, offset in zip(normals[2 * n :], offsets[2 * n :], strict=True):
        meets &= _lowest_values(normal, boundaries, near_cells) < offset
    free[near_cells] &= ~meets


def _lowest_values(normal: Array, boundaries: list[Array], part: tuple[slice, ...]) -> Array:
    """Return the smallest normal.x over every cell of a part of the grid."""
    values: Array = np.zeros(())
    for c, axis, section in zip(normal, boundaries, part, strict=True):
        values = values[..., None] + np.minimum(c * axis[:-1], c * axis[1:])[section]
    return values


def _cell_boundaries(points: Array, space: Array) -> list[Array]:
    """Return by dimension the boundaries of the cells: the coordinates of points inside the space, and the ends of the space."""
    boundaries = []
    for i in range(points.shape[1]):
        inside = points[(points[:, i] > space[0, i]) & (points[:, i] < space[1, i]), i]
        boundaries.append(np.unique(np.concatenate([inside, space[:, i]])))
    return boundaries


def _middles(boundaries: list[Array]) -> list[Array]:
    """Return by dimension the middles of the cells."""
    return [(axis[:-1] + axis[1:]) / 2 for axis in boundaries]


def _path_through(boundaries: list[Array], free: Flags, goal: Array, start: Array) -> Array | None:
    """Return a polyline through free cells from `start` into `goal`; None where there is none."""
    n, middles = len(start), _middles(boundaries)
    in_goal = np.zeros(free.shape, dtype=bool)
    in_goal[_cells_in_box(middles, goal[0], goal[1])] = True
    start_cell = tuple(
        int(np.clip(np.searchsorted(axis, v, side="right") - 1, 0, len(axis) - 2))
        for axis, v in zip(boundaries, start, strict=True)
    )
    if not free[start_cell]:
        return None
    steps = _flood(free, start_cell)
    reached = np.argwhere(in_goal & (steps >= 0))
    if not len(reached):
        return None
    cell = tuple(int(v) for v in min(reached, key=lambda c: int(steps[tuple(c)])))
    cells = [cell]
    while cell != start_cell:
        cell = next(c for c in _neighbours(cell, free.shape) if steps[c] == steps[cell] - 1)
        cells.append(cell)
    return np.array([start, *([middles[i][c[i]] for i in range(n)] for c in cells[::-1])])


def _cells_in_box(middles: list[Array], low: Array, high: Array) -> tuple[slice, ...]:
    """Return the cells whose middles lie in a box."""
    return tuple(slice(*np.searchsorted(m, (a, b))) for m, a, b in zip(middles, low, high, strict=True))


def _flood(free: Flags, start_cell: Cell) -> npt.NDArray[np.int64]:
    """Return the number of steps from `start_cell` to every free cell, -1 where no path leads to the cell."""
    padded = np.pad(free, 1)  # a rim that is not free: no neighbour leaves the array
    steps = np.full(padded.size, -1, dtype=np.int64)
    strides = [s // padded.itemsize for s in padded.strides]
    unvisited = padded.ravel().copy()
    front = np.array([sum((c + 1) * s for c, s in zip(start_cell, strides, strict=True))])
    unvisited[front] = False
    count = 0
    while len(front):
        steps[front] = count
        count += 1
        beside = np.concatenate([front + d * s for s in strides for d in (-1, 1)])
        front = np.unique(beside[unvisited[beside]])
        unvisited[front] = False
    return steps.reshape(padded.shape)[(slice(1, -1),) * free.ndim]


def _neighbours(cell: Cell, shape: Cell) -> list[Cell]:
    """Return the cells that share a face with a cell, in an array of this shape."""
    steps = [(*cell[:i], cell[i] + d, *cell[i + 1 :]) for i in range(len(cell)) for d in (-1, 1)]
    return [c for c in steps if all(0 <= v < s for v, s in zip(c, shape, strict=True))]
