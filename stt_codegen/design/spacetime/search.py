"""A route in space and time for the centre of a tube, where unsafe sets move or are unsafe only at times.

Space is cut into cells and time into the tube's segments. A cell is free in a segment if the box about its middle avoids every
set all that time. At the end of a segment the centre is in a cell that is free in this segment and in the next. In a segment the
centre waits or moves through at most USUAL_PACE free cells, or through FAST_PACE where that finds no route. Dynamic programming
finds the route with the smallest sum of squared steps, which spreads the motion evenly over time. In more than SLICE_DIMENSIONS
dimensions some of them move through the cells of a slice and the others go straight to the target, early, evenly or late; every
choice is tried until one leads there.

The search finds every route through its cells. Where it finds none, there may still be one between the cells.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import inner_box
from stt_codegen.design.spacetime.free_cells import Cell, Flags, SliceCells

Costs = npt.NDArray[np.int32]

CELL_COUNTS = {1: (256,), 2: (100,), 3: (24, 40)}  # cells along each dimension, by moving dimensions; tried in this order
USUAL_PACE = 3  # cells in one segment's time
FAST_PACE = 12  # cells in one segment's time where USUAL_PACE finds no route; more if twice the even pace is more
SLICE_DIMENSIONS = 3  # dimensions that move through cells
UNREACHABLE = np.int32(1 << 30)  # the cost where no route leads
PROFILES = ("even", "early", "late")  # how the dimensions move that go straight
CHOICE_LIMIT = 60  # pairs of a slice and a profile that are tried; six dimensions have 60
MOVE_DURATION = 0.3  # of an early or late move, in parts of t_c


@dataclass(frozen=True)
class SliceSearch:
    """The search for a route through the cells of a slice over time.

    free: by segment and cell. goal: which cells are in the target. start_cell: the cell of the centre at t = 0.
    """

    cells: SliceCells
    free: Flags
    goal: Flags
    start_cell: Cell

    @property
    def paces(self) -> tuple[int, int]:
        """The numbers of cells in one segment's time that are tried, the smaller first."""
        return USUAL_PACE, max(FAST_PACE, -(-2 * max(self.goal.shape) // len(self.free)))

    def free_after(self, k: int) -> Flags:
        """Return the cells that are free in the segment after k."""
        cells: Flags = self.free[min(k + 1, len(self.free) - 1)]
        return cells

    def reachable_cells(self) -> Iterator[Flags]:
        """Yield by time the cells that any route leads to, at the fastest pace."""
        reachable: Flags = np.zeros(self.goal.shape, dtype=bool)
        reachable[self.start_cell] = self.free[(0, *self.start_cell)]
        yield reachable
        for k, free in enumerate(self.free):
            reachable = reachable & free
            for _ in range(self.paces[-1]):
                wider = _with_neighbours(reachable) & free
                if (wider == reachable).all():
                    break
                reachable = wider
            reachable = reachable & self.free_after(k)
            yield reachable

    def has_route(self) -> bool:
        """Return whether any route leads to the target."""
        in_goal = np.zeros(1, dtype=bool)
        for reachable in self.reachable_cells():
            in_goal = reachable & self.goal
            if not reachable.any():
                break
        return bool(in_goal.any())

    def costs(self, pace: int) -> list[Costs]:
        """Return by time the smallest sum of squared steps to every cell; UNREACHABLE where no route leads."""
        cost = np.full(self.goal.shape, UNREACHABLE, dtype=np.int32)
        if self.free[(0, *self.start_cell)]:
            cost[self.start_cell] = 0
        costs = [cost]
        for k, free in enumerate(self.free):
            cost = self.next_costs(cost, free, self.free_after(k), pace)
            costs.append(cost)
        return costs

    @staticmethod
    def next_costs(cost: Costs, free: Flags, free_after: Flags, pace: int) -> Costs:
        """Return the smallest sums one segment later, given the free cells of the segment and those of the next."""
        best, nearby = cost, np.where(free, cost, UNREACHABLE)
        for step in range(1, pace + 1):
            nearby = np.where(free, _lowest_nearby(nearby), UNREACHABLE)
            best = np.minimum(best, nearby + step * step)
        return np.asarray(np.where(free & free_after, np.minimum(best, UNREACHABLE), UNREACHABLE))

    def find_path(self, pace: int) -> Array | None:
        """Return the centre at every time, (K + 1, n), through at most `pace` cells in a segment; None where no route leads."""
        costs = self.costs(pace)
        last = np.where(self.goal, costs[-1], UNREACHABLE)
        if last.min() >= UNREACHABLE:
            return None
        cells = [tuple(int(v) for v in np.unravel_index(int(last.argmin()), last.shape))]
        for k in range(len(self.free) - 1, -1, -1):
            cells.append(self.predecessor(cells[-1], costs[k], int(costs[k + 1][cells[-1]]), self.free[k], pace))
        return self.cells.path_through(cells[::-1])

    @staticmethod
    def predecessor(cell: Cell, earlier: Costs, cost: int, free: Flags, pace: int) -> Cell:
        """Return the nearest cell at the beginning of a segment from which a route comes to `cell` at this cost.

        earlier: the costs at the beginning of the segment. free: the free cells of the segment.
        """
        part = tuple(slice(max(v - pace, 0), v + pace + 1) for v in cell)
        corner = [p.start for p in part]
        free_part, earlier_part = free[part], earlier[part]
        distance = np.full(free_part.shape, UNREACHABLE, dtype=np.int32)
        distance[tuple(v - c for v, c in zip(cell, corner, strict=True))] = 0
        for step in range(pace + 1):
            candidates = np.argwhere((distance < UNREACHABLE) & (earlier_part + step * step == cost))
            if len(candidates):
                return tuple(int(v) + c for v, c in zip(candidates[0], corner, strict=True))
            distance = np.where(free_part, _lowest_nearby(distance), UNREACHABLE)
        raise AssertionError("a cost comes from somewhere")


def _shifted(axis: int, n: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Return all cells but the first along an axis, and all but the last."""
    but_first, but_last = ([slice(None)] * n for _ in range(2))
    but_first[axis], but_last[axis] = slice(1, None), slice(None, -1)
    return tuple(but_first), tuple(but_last)


def _lowest_nearby(cost: Costs) -> Costs:
    """Return the lowest cost over every cell and its neighbours, one dimension after the other."""
    for axis in range(cost.ndim):
        lowest = cost.copy()
        but_first, but_last = _shifted(axis, cost.ndim)
        np.minimum(lowest[but_last], cost[but_first], out=lowest[but_last])
        np.minimum(lowest[but_first], cost[but_last], out=lowest[but_first])
        cost = lowest
    return cost


def _with_neighbours(cells: Flags) -> Flags:
    """Return the cells and their neighbours, one dimension after the other, as in `_lowest_nearby`."""
    for axis in range(cells.ndim):
        wider = cells.copy()
        but_first, but_last = _shifted(axis, cells.ndim)
        wider[but_last] |= cells[but_first]
        wider[but_first] |= cells[but_last]
        cells = wider
    return cells


def find_timed_route(arena: Arena, centre: Array, width: Array, segments: int, is_coarse: bool = False) -> Array | None:
    """Return the centre of a tube of this width (n,) at the ends of its segments, from `centre`; None where none is found.

    The shape is (segments + 1, n). is_coarse: search among the largest cells alone.
    """
    for search in slice_searches(arena, centre, width, segments, is_coarse):
        usual_pace, fast_pace = search.paces
        path = search.find_path(usual_pace)
        if path is None and search.has_route():
            path = search.find_path(fast_pace)
        if path is not None:
            path[0] = centre
            return path
    return None


def has_timed_route(arena: Arena, centre: Array, width: Array, segments: int) -> bool:
    """Return whether a search finds a route for a tube of this width (n,), whose centre starts at `centre`."""
    return any(search.has_route() for search in slice_searches(arena, centre, width, segments))


def slice_searches(arena: Arena, centre: Array, width: Array, segments: int, is_coarse: bool = False) -> Iterator[SliceSearch]:
    """Yield the searches of all slices, profiles and sizes of cells, one after the other."""
    n, half_width = arena.dimension, width / 2
    space, goal = (np.stack([box[0] + half_width, box[1] - half_width]) for box in (arena.space, arena.target))
    if len(arena.target_cuts.lower_bound) or len(arena.space_cuts.lower_bound):
        inner = inner_box(arena, goal, half_width)
        if inner is None:
            return
        goal = inner
    if (goal[0] > goal[1]).any() or (space[0] >= space[1]).any():
        return
    slices = itertools.combinations(range(n), min(n, SLICE_DIMENSIONS))
    choices = list(itertools.product(slices, PROFILES if n > SLICE_DIMENSIONS else PROFILES[:1]))
    counts = CELL_COUNTS[min(n, SLICE_DIMENSIONS)][: 1 if is_coarse else None]
    for count, (moving, profile) in itertools.product(counts, choices[:CHOICE_LIMIT]):
        ends = np.clip(centre, goal[0], goal[1])
        straight_path = centre + _fractions_of_move(profile, segments)[:, None] * (ends - centre)
        axes = [space[0, i] + (np.arange(count) + 0.5) * ((space[1, i] - space[0, i]) / count) for i in moving]
        cells = SliceCells(moving, axes, straight_path, arena.clearance + half_width)
        start_cell = cells.cell_of(centre)
        free = cells.free_cells(arena)
        for obstacle in arena.timed_obstacles:
            cells.block(free, obstacle)
        free[0][start_cell] = True  # gamma(0) is known to avoid every set; the middle of its cell may be a little elsewhere
        yield SliceSearch(cells, free, cells.cells_in(goal), start_cell)


def _fractions_of_move(profile: str, segments: int) -> Array:
    """Return the fraction of its move that a straight dimension has made at the ends of segments: (segments + 1,)."""
    t = np.arange(segments + 1) / segments
    if profile == "early":
        t = t / MOVE_DURATION
    elif profile == "late":
        t = (t - 1 + MOVE_DURATION) / MOVE_DURATION
    return np.clip(t, 0.0, 1.0)
