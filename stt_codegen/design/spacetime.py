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
from stt_codegen.design.faces import Array
from stt_codegen.design.inner import inner_box

CELLS = {1: (256,), 2: (100,), 3: (24, 40)}  # of every dimension; where the first are too coarse, the next
QUICKEST, HASTE = 3, 12  # cells in one segment's time; where that finds no way so many, or what twice the even pace takes
SLICE = 3  # dimensions that move through cells
FAR = np.int32(1 << 30)  # the cost where no way leads
PROFILES = ("even", "early", "late")  # how the dimensions move that are not in the slice
PART = 0.3  # of the time that an early or late move takes

Cell = tuple[int, ...]


@dataclass(frozen=True)
class Field:
    """The cells of a slice over time. own: the dimensions that move through them; axes: by own dimension the middles of its
    cells; rest: where the others are, (K + 1, n), entries of `own` not read; free: by segment and cell."""

    own: tuple[int, ...]
    axes: list[Array]
    rest: Array
    free: npt.NDArray[np.bool_]
    goal: npt.NDArray[np.bool_]
    first: Cell

    @property
    def paces(self) -> tuple[int, int]:
        """How many cells in one segment's time are tried."""
        return QUICKEST, max(HASTE, -(-2 * max(self.goal.shape) // (len(self.rest) - 1)))

    def reached(self, quickest: int) -> list[npt.NDArray[np.int32]]:
        """The least sum of squared steps to every cell, by time; FAR where none leads."""
        cost = np.full(self.goal.shape, FAR, dtype=np.int32)
        if self.free[(0, *self.first)]:
            cost[self.first] = 0
        found = [cost]
        for k, free in enumerate(self.free):
            best, wider = cost, np.where(free, cost, FAR)
            for step in range(1, quickest + 1):
                wider = np.where(free, _spread(wider), FAR)
                best = np.minimum(best, wider + step * step)
            after = self.free[min(k + 1, len(self.free) - 1)]
            cost = np.where(free & after, np.minimum(best, FAR), FAR)
            found.append(cost)
        return found

    def way(self, quickest: int) -> Array | None:
        """The centre at every time, (K + 1, n), through at most so many cells in one segment's time; None where no way leads."""
        costs = self.reached(quickest)
        last = np.where(self.goal, costs[-1], FAR)
        if last.min() >= FAR:
            return None
        cells = [tuple(int(v) for v in np.unravel_index(int(last.argmin()), last.shape))]
        for k in range(len(self.free) - 1, -1, -1):
            cells.append(self._before(cells[-1], costs[k], costs[k + 1], k, quickest))
        points = self.rest.copy()
        for q, i in enumerate(self.own):
            points[:, i] = [self.axes[q][c[q]] for c in cells[::-1]]
        return points

    def _before(self, cell: Cell, earlier: npt.NDArray[np.int32], cost: npt.NDArray[np.int32], k: int, quickest: int) -> Cell:
        """Where the centre was at the begin of segment k: the nearest cell from which it comes here at the cell's cost."""
        part = tuple(slice(max(v - quickest, 0), v + quickest + 1) for v in cell)
        corner = [p.start for p in part]
        free, wanted = self.free[k][part], earlier[part]
        away = np.full(free.shape, FAR, dtype=np.int32)
        away[tuple(v - c for v, c in zip(cell, corner, strict=True))] = 0
        for step in range(quickest + 1):
            there = np.argwhere((away < FAR) & (wanted + step * step == cost[cell]))
            if len(there):
                return tuple(int(v) + c for v, c in zip(there[0], corner, strict=True))
            away = np.where(free, _spread(away), FAR)
        raise AssertionError("a cost comes from somewhere")


def _spread(cost: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The least over every cell and its neighbours, one dimension after the other."""
    for axis in range(cost.ndim):
        wide = cost.copy()
        ahead, behind = ([slice(None)] * cost.ndim for _ in range(2))
        ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
        there, here = tuple(ahead), tuple(behind)
        np.minimum(wide[here], cost[there], out=wide[here])
        np.minimum(wide[there], cost[here], out=wide[there])
        cost = wide
    return cost


def way_in_time(arena: Arena, centre: Array, width: Array, segments: int) -> Array | None:
    """The centre of a tube of this width (n,) at the ends of its segments, (segments + 1, n), from `centre`; None where none is
    found."""
    for field in fields(arena, centre, width, segments):
        for quickest in field.paces:
            way = field.way(quickest)
            if way is not None:
                way[0] = centre
                return way
    return None


def fields(arena: Arena, centre: Array, width: Array, segments: int) -> Iterator[Field]:
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
    own_sets = [tuple(range(n))] if n <= SLICE else list(itertools.combinations(range(n), SLICE))
    for count in CELLS[min(n, SLICE)]:
        for own, profile in itertools.product(own_sets, PROFILES if n > SLICE else PROFILES[:1]):
            ends = np.clip(centre, goal[0], goal[1])
            share = _share(profile, segments)
            rest = centre + share[:, None] * (ends - centre)
            yield _field(arena, own, rest, space, goal, width / 2, count, centre)


def _share(profile: str, segments: int) -> Array:
    t = np.arange(segments + 1) / segments
    if profile == "early":
        t = t / PART
    elif profile == "late":
        t = (t - 1 + PART) / PART
    return np.clip(t, 0.0, 1.0)


def _field(
    arena: Arena, own: tuple[int, ...], rest: Array, space: Array, goal: Array, half: Array, count: int, centre: Array
) -> Field:
    segments, others = len(rest) - 1, [i for i in range(arena.dimension) if i not in own]
    axes = []
    for i in own:
        size = (space[1, i] - space[0, i]) / count
        axes.append(space[0, i] + (np.arange(count) + 0.5) * size)
    shape = tuple(len(a) for a in axes)
    grid = _Grid(own, others, axes, arena.clearance + half)
    free = np.ones((segments, *shape), dtype=bool)
    times = range(segments)
    ends = [(rest[k], rest[k + 1]) for k in times]  # where the other dimensions are in a segment
    for j in range(len(arena.names)):
        x = arena.faces.of(j)
        normal = np.concatenate([_axes(arena.dimension), arena.faces.normal[x]])
        bound, along = np.concatenate([_ends(arena.unsafe[j]), arena.faces.bound[x]]), grid.along(arena.faces.normal[x])
        for k in times if others else (0,):
            for place in ends[k]:
                grid.block(free[k : k + 1] if others else free, normal, bound, along, place)
    walls, least = arena.walls.normal, arena.walls.bound + arena.walls.length(half)
    for along, normal, bound in zip(grid.along(walls), walls, least, strict=True):
        for k in times:
            for place in ends[k]:
                free[k] &= along + grid.elsewhere(normal[None], place) >= bound
    known, along = b"", np.empty(0)
    for mover in arena.movers:
        slanted = mover.normal[2 * arena.dimension :]
        if slanted.tobytes() != known:  # balls have their normals in common
            known, along = slanted.tobytes(), grid.along(slanted)
        bounds = mover.bounds(segments).max(axis=2)  # (N, K)
        for k in times:
            if bounds[0, k] > -np.inf:
                for place in ends[k] if others else ends[k][:1]:
                    grid.block(free[k : k + 1], mover.normal, bounds[:, k], along, place)
    wanted = np.ones(shape, dtype=bool)
    for q, (i, a) in enumerate(zip(own, axes, strict=True)):
        size = a[1] - a[0]
        near = (a >= goal[0, i]) & (a <= goal[1, i])
        if not near.any():  # the target is narrower than a cell
            near = np.abs(a - (goal[0, i] + goal[1, i]) / 2) <= size
        wanted &= near.reshape([-1 if p == q else 1 for p in range(len(own))])
    first = tuple(int(np.clip((centre[i] - a[0]) / (a[1] - a[0]) + 0.5, 0, len(a) - 1)) for i, a in zip(own, axes, strict=True))
    free[0][first] = True  # gamma(0) is known to keep off every set; the middle of its cell may be a little elsewhere
    return Field(own, axes, rest, free, wanted, first)


def _axes(n: int) -> Array:
    """-e_1, +e_1, -e_2, .."""
    return np.array([[sign * (i == k) for k in range(n)] for i in range(n) for sign in (-1.0, 1.0)])


def _ends(span: Array) -> Array:
    """The bounds of `_axes` for a box, shape (2, n)."""
    return np.asarray(np.stack([-span[0], span[1]], axis=1).ravel())


@dataclass(frozen=True)
class _Grid:
    """The cells of a slice, and normals of sets over them. reach: half widths of the box about a cell's middle, (n,)."""

    own: tuple[int, ...]
    others: list[int]
    axes: list[Array]
    reach: Array

    def along(self, normal: Array) -> Array:
        """normal.x over the cells in the slice's own dimensions, for several normals (X, n): (X, cells)."""
        total: Array = np.zeros([len(normal)] + [1] * len(self.own))
        for q, (i, a) in enumerate(zip(self.own, self.axes, strict=True)):
            shape = [len(a) if p == q else 1 for p in range(len(self.own))]
            total = total + (normal[:, i, None] * a).reshape(len(normal), *shape)
        return total

    def elsewhere(self, normal: Array, rest: Array) -> Array:
        """The part of normal.x in the other dimensions: (X,)."""
        total = np.zeros(len(normal))
        for i in self.others:
            total = total + normal[:, i] * rest[i]
        return total

    def block(self, free: npt.NDArray[np.bool_], normal: Array, bound: Array, along: Array, rest: Array) -> None:
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
        further = bound[2 * n :] - self.elsewhere(normal[2 * n :], rest)
        for i, r in enumerate(reach.tolist()):
            further = further + np.abs(normal[2 * n :, i]) * r
        meets = (along[(slice(None), *near)] < further.reshape(-1, *[1] * len(self.own))).all(axis=0)
        free[(slice(None), *near)] &= ~meets
