"""A way in space and time for the centre of a tube, where unsafe sets move or are unsafe only at times.

Space is cut into cells and time into the tube's segments. A cell is free in a segment where the box about its middle keeps off
every set all that time; the centre is at the end of a segment in a cell that is free in it and in the next. In a segment it goes
through free cells, at most QUICKEST of them one after the other, or HASTE where that finds no way; or it waits. Of all ways the
one with the least sum of squared steps is taken, by dynamic programming: it is even in time. In more than SLICE dimensions some
of them move through the cells of a slice and the others go straight to the target, early, evenly or late; every choice is tried
until one leads.

The search is complete on its cells. That it finds none does not say that there is none.
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
from stt_codegen.design.spacetime.free_cells import Cell, Cells

CELLS = {1: (256,), 2: (100,), 3: (24, 40)}  # of every dimension; where the first are too coarse, the next
QUICKEST, HASTE = 3, 12  # cells in one segment's time; where that finds no way so many, or what twice the even pace takes
SLICE = 3  # dimensions that move through cells
FAR = np.int32(1 << 30)  # the cost where no way leads
PROFILES = ("even", "early", "late")  # how the dimensions move that are not in the slice
CHOICES = 60  # of slices and profiles, all that six dimensions have; of more dimensions the first
PART = 0.3  # of the time that an early or late move takes


@dataclass(frozen=True)
class Field:
    """The cells of a slice over time. free: by segment and cell; goal: cells of the target; first: the cell of gamma(0)."""

    cells: Cells
    free: npt.NDArray[np.bool_]
    goal: npt.NDArray[np.bool_]
    first: Cell

    @property
    def paces(self) -> tuple[int, int]:
        """How many cells in one segment's time are tried."""
        return QUICKEST, max(HASTE, -(-2 * max(self.goal.shape) // len(self.free)))

    def after(self, k: int) -> npt.NDArray[np.bool_]:
        """The cells that are free in the segment after k."""
        found: npt.NDArray[np.bool_] = self.free[min(k + 1, len(self.free) - 1)]
        return found

    def reached(self) -> Iterator[npt.NDArray[np.bool_]]:
        """The cells that any way leads to, by time, at the quickest pace."""
        here: npt.NDArray[np.bool_] = np.zeros(self.goal.shape, dtype=bool)
        here[self.first] = self.free[(0, *self.first)]
        yield here
        for k, free in enumerate(self.free):
            here = here & free
            for _ in range(self.paces[-1]):
                wider = _neighbours(here) & free
                if (wider == here).all():
                    break
                here = wider
            here = here & self.after(k)
            yield here

    def leads(self) -> bool:
        """Whether any way leads to the target."""
        last = np.zeros(1, dtype=bool)
        for here in self.reached():
            last = here & self.goal
            if not here.any():
                break
        return bool(last.any())

    def costs(self, quickest: int) -> list[npt.NDArray[np.int32]]:
        """The least sum of squared steps to every cell, by time; FAR where none leads."""
        cost = np.full(self.goal.shape, FAR, dtype=np.int32)
        if self.free[(0, *self.first)]:
            cost[self.first] = 0
        found = [cost]
        for k, free in enumerate(self.free):
            cost = self.stepped(cost, free, self.after(k), quickest)
            found.append(cost)
        return found

    @staticmethod
    def stepped(
        cost: npt.NDArray[np.int32], free: npt.NDArray[np.bool_], after: npt.NDArray[np.bool_], quickest: int
    ) -> npt.NDArray[np.int32]:
        """The least sums one segment later, whose free cells these are, and those of the next."""
        best, wider = cost, np.where(free, cost, FAR)
        for step in range(1, quickest + 1):
            wider = np.where(free, _spread(wider), FAR)
            best = np.minimum(best, wider + step * step)
        return np.asarray(np.where(free & after, np.minimum(best, FAR), FAR))

    def way(self, quickest: int) -> Array | None:
        """The centre at every time, (K + 1, n), through at most so many cells in one segment's time; None where no way leads."""
        costs = self.costs(quickest)
        last = np.where(self.goal, costs[-1], FAR)
        if last.min() >= FAR:
            return None
        cells = [tuple(int(v) for v in np.unravel_index(int(last.argmin()), last.shape))]
        for k in range(len(self.free) - 1, -1, -1):
            cells.append(self.before(cells[-1], costs[k], int(costs[k + 1][cells[-1]]), self.free[k], quickest))
        return self.cells.points(cells[::-1])

    @staticmethod
    def before(cell: Cell, earlier: npt.NDArray[np.int32], cost: int, free_: npt.NDArray[np.bool_], quickest: int) -> Cell:
        """Where the centre was at the begin of a segment with these free cells: the nearest from which it comes here so."""
        part = tuple(slice(max(v - quickest, 0), v + quickest + 1) for v in cell)
        corner = [p.start for p in part]
        free, wanted = free_[part], earlier[part]
        away = np.full(free.shape, FAR, dtype=np.int32)
        away[tuple(v - c for v, c in zip(cell, corner, strict=True))] = 0
        for step in range(quickest + 1):
            there = np.argwhere((away < FAR) & (wanted + step * step == cost))
            if len(there):
                return tuple(int(v) + c for v, c in zip(there[0], corner, strict=True))
            away = np.where(free, _spread(away), FAR)
        raise AssertionError("a cost comes from somewhere")


def _along(axis: int, n: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """All cells but the first along an axis, and all but the last."""
    ahead, behind = ([slice(None)] * n for _ in range(2))
    ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
    return tuple(ahead), tuple(behind)


def _spread(cost: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The least over every cell and its neighbours, one dimension after the other."""
    for axis in range(cost.ndim):
        wide = cost.copy()
        there, here = _along(axis, cost.ndim)
        np.minimum(wide[here], cost[there], out=wide[here])
        np.minimum(wide[there], cost[here], out=wide[there])
        cost = wide
    return cost


def _neighbours(here: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The cells and their neighbours, one dimension after the other, as in `_spread`."""
    for axis in range(here.ndim):
        wide = here.copy()
        ahead, behind = _along(axis, here.ndim)
        wide[behind] |= here[ahead]
        wide[ahead] |= here[behind]
        here = wide
    return here


def way_in_time(arena: Arena, centre: Array, width: Array, segments: int, coarsely: bool = False) -> Array | None:
    """The centre of a tube of this width (n,) at the ends of its segments, (segments + 1, n), from `centre`; None where none is
    found. coarsely: among the largest cells alone."""
    for one in fields(arena, centre, width, segments, coarsely):
        quick, haste = one.paces
        way = one.way(quick)
        if way is None and one.leads():
            way = one.way(haste)
        if way is not None:
            way[0] = centre
            return way
    return None


def leads(arena: Arena, centre: Array, width: Array, segments: int) -> bool:
    """Whether there is a way."""
    return any(one.leads() for one in fields(arena, centre, width, segments))


def fields(arena: Arena, centre: Array, width: Array, segments: int, coarsely: bool = False) -> Iterator[Field]:
    """What is searched, one after the other."""
    n, inset = arena.dimension, width / 2
    space, goal = (np.stack([box[0] + inset, box[1] - inset]) for box in (arena.space, arena.target))
    if len(arena.goals.bound) or len(arena.walls.bound):
        inner = inner_box(arena, goal, inset)
        if inner is None:
            return
        goal = inner
    if (goal[0] > goal[1]).any() or (space[0] >= space[1]).any():
        return
    choices = list(itertools.product(itertools.combinations(range(n), min(n, SLICE)), PROFILES if n > SLICE else PROFILES[:1]))
    counts = CELLS[min(n, SLICE)][: 1 if coarsely else None]
    for count, (own, profile) in itertools.product(counts, choices[:CHOICES]):
        ends = np.clip(centre, goal[0], goal[1])
        rest = centre + _share(profile, segments)[:, None] * (ends - centre)
        axes = [space[0, i] + (np.arange(count) + 0.5) * ((space[1, i] - space[0, i]) / count) for i in own]
        cells = Cells(own, axes, rest, arena.clearance + inset)
        first = cells.near(centre)
        free = cells.free(arena)
        for obstacle in arena.timed_obstacles:
            cells.block(free, obstacle)
        free[0][first] = True  # gamma(0) is known to keep off every set; the middle of its cell may be a little elsewhere
        yield Field(cells, free, cells.inside(goal), first)


def _share(profile: str, segments: int) -> Array:
    t = np.arange(segments + 1) / segments
    if profile == "early":
        t = t / PART
    elif profile == "late":
        t = (t - 1 + PART) / PART
    return np.clip(t, 0.0, 1.0)
