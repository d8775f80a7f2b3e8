"""Symbolic control as a peer: a grid over the state space, its transitions, and a fixed point over them: reach, avoid and stay.

A cell q stands for every state in it. Held for `period` seconds, the input u takes all of them, under every wind w with
|w_i| <= w_max, into the box

    c(q) + period u +- (step / 2 + period w_max)

about the cell's middle c(q), for xdot = u + w: the growth bound of this plant, exact. The cells that this box meets are the
successors of (q, u), and a controller for the cells is one for the states (a feedback refinement relation; Reissig, Weber and
Rungger, 2017). The value V is the smallest number of periods until the target, over the worst successor:

    V(q) = 0 where some u stays among such cells for ever, within the target
    V(q) = 1 + min over u of the maximum of V over the successors,    never through a cell that meets an unsafe set

so the table of the best u by cell is a controller with a worst case time. As in the tools of this kind, nothing is required
between two samples, and `simulate_runs` counts the collisions there. With `is_swept` every cell that the hull of both boxes meets
must be free. For the robot of three states, equation (14) of the paper, headings are cells too, and a box grows by what its
uncertain heading turns the way:

    r_1, r_2 + period w_max + |v| (r_3 period + w_max period^2 / 2),    r_3 + period w_max

This file is ours, since SCOTS is no package. It has arrays instead of lists of transitions, since the transitions of these plants
are the same everywhere. `in_arenas`, `in_loops` and `suites/printed.py` call `synthesize`.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from benchmarks.suites.families import BOX, Family
from stt_codegen.program.targets.template_files import template

Array = npt.NDArray[Any]
UNREACHABLE = np.int16(1 << 14)  # periods, more than any t_c has
NO_INPUT = 255  # in a table: no input is known to be safe
Window = tuple[tuple[int, int], ...]  # offsets of cells, first and last, by axis


class TransitionWindows(NamedTuple):
    """For a cell and an input: windows of the successors, and of all cells on the way. The heading is the last axis of the
    successors."""

    successors: Window
    on_the_way: Window


@dataclass(frozen=True)
class Abstraction:
    """A grid with its inputs. cells: along an axis of the state space; period: seconds between inputs, a part of t_c; speeds:
    values of each input; is_swept: whether cells on the way between samples must be free too.

    Of the robot of three states, headings: number of cells of the heading; turns: values of the heading's rate."""

    cells: int
    period: Fraction
    speeds: tuple[Fraction, ...]
    w_max: Fraction = Fraction(3, 10)
    is_swept: bool = False
    headings: int = 1
    turns: tuple[Fraction, ...] = (Fraction(0),)

    def inputs(self, dimension: int) -> list[tuple[Fraction, ...]]:
        """Return every input: by axis, then the heading's rate."""
        return list(itertools.product(*[self.speeds] * dimension, self.turns))


@dataclass(frozen=True)
class GridController:
    """A controller over a grid. table: the number of the input by cell and heading, or NO_INPUT; value: periods until the target
    in the worst case, by cell and heading; seconds: that the synthesis took."""

    abstraction: Abstraction
    family: Family
    table: Array
    value: Array
    seconds: float

    @property
    def is_winning(self) -> bool:
        """Whether every state of the start's box is in the target in time, whatever the wind and the heading."""
        grid = self.abstraction
        first = (
            math.floor(Fraction(BOX) * grid.cells / Fraction(self.family.side)) + 1
        )  # where the edge is on a cell's border, that cell too
        start = self.value[(slice(0, first),) * self.family.dimension]
        return bool(start.max() * grid.period <= Fraction(self.family.prescribed_time))

    def source(self) -> str:
        """Print the controller in C: its table, and `decide`, which finds a state's cell."""
        grid, n = self.abstraction, self.family.dimension
        return template("bench/grid.c.j2").render(
            n=n,
            cells=grid.cells,
            headings=grid.headings,
            scale=f"{float(grid.cells / Fraction(self.family.side))!r}F",
            headings_per_radian=f"{grid.headings / (2 * math.pi)!r}F",
            table=self.table.ravel().tolist(),
            no_input=NO_INPUT,
            inputs=[[f"{float(v)!r}F" for v in u] for u in grid.inputs(n)],
        )


def synthesize(family: Family, boxes: Array, grid: Abstraction) -> GridController:
    """Synthesize the controller of an arena, whose cubes are (count, n, 2): first to stay in the target, then to reach it.

    Raises ValueError where the inputs are too many for a table of bytes."""
    begin = time.perf_counter()
    inputs = grid.inputs(family.dimension)
    if len(inputs) >= NO_INPUT:
        raise ValueError(f"{len(inputs)} inputs: the table has bytes, so {NO_INPUT - 1} at most")
    is_blocked, is_target = _blocked_cells(family, boxes, grid), _target_cells(family, grid)
    moves = [[_transition_windows(family, grid, u, k) for k in range(grid.headings)] for u in inputs]
    has_free_way = [
        np.stack([_has_free_way(is_blocked[..., k], grid, windows[k]) for k in range(grid.headings)], axis=-1)
        for windows in moves
    ]
    table = np.full(is_blocked.shape, NO_INPUT, dtype=np.uint8)
    stays = _largest_staying_set(grid, moves, has_free_way, is_target & ~is_blocked, table)
    value = np.where(stays, np.int16(0), UNREACHABLE)
    for _ in range(math.floor(Fraction(family.prescribed_time) / grid.period)):
        before = value.copy()
        for number, (windows, is_free) in enumerate(zip(moves, has_free_way, strict=True)):
            after = np.int16(1) + _worst_successor(before, windows, grid, UNREACHABLE)
            is_better = is_free & ~is_blocked & (after < value)
            value[is_better], table[is_better] = after[is_better], number
        if (before == value).all():
            break
    return GridController(grid, family, table, value, time.perf_counter() - begin)


def _largest_staying_set(
    grid: Abstraction,
    moves: Sequence[Sequence[TransitionWindows]],
    has_free_way: Sequence[Array],
    stays: Array,
    table: Array,
) -> Array:
    """Return the largest subset of `stays` in which some input keeps the state for ever, and write these inputs into the
    table."""
    while True:
        is_kept = np.zeros_like(stays)
        for number, (windows, is_free) in enumerate(zip(moves, has_free_way, strict=True)):
            leaves = _worst_successor(np.where(stays, np.int16(0), np.int16(1)), windows, grid, 1)
            keeps = is_free & (leaves == 0) & stays
            table[keeps & ~is_kept] = number
            is_kept |= keeps
        table[~is_kept] = NO_INPUT
        if (is_kept == stays).all():
            return stays
        stays = is_kept


@dataclass(frozen=True)
class RunCounts:
    """How many closed loops ran from random states of the start's box, how many of them met an unsafe set at a sample, and only
    between samples, and how many were in the target at t_c."""

    runs: int
    at_samples: int
    between: int
    arrived: int


def simulate_runs(controller: GridController, boxes: Array, runs: int = 1000, seed: int = 1, step: float = 1e-3) -> RunCounts:
    """Simulate closed loops of the plant that the abstraction is of. In every period the wind is at a random corner of its box.
    Collisions are looked for every `step` seconds."""
    grid, n, rng = controller.abstraction, controller.family.dimension, np.random.default_rng(seed)
    period, count = float(grid.period), round(float(grid.period) / step)
    inputs = np.append(np.array(grid.inputs(n), dtype=float), np.zeros((1, n + 1)), axis=0)  # the last one for NO_INPUT
    x = rng.uniform(0, BOX, (runs, n))
    heading = rng.uniform(-math.pi, math.pi, runs)
    is_hit, is_hit_at_sample = np.zeros(runs, dtype=bool), np.zeros(runs, dtype=bool)
    for _ in range(math.floor(Fraction(controller.family.prescribed_time) / grid.period)):
        is_hit_at_sample |= _is_in_a_cube(x, boxes)
        cell = np.clip((x * grid.cells / controller.family.side).astype(int), 0, grid.cells - 1)
        heading_cell = np.floor((heading + math.pi) * grid.headings / (2 * math.pi)).astype(int) % grid.headings
        u = inputs[np.minimum(controller.table[(*cell.T, heading_cell)], len(inputs) - 1)]
        w = float(grid.w_max) * rng.choice([-1.0, 1.0], (runs, n + 1))
        for _ in range(count):
            mean_heading = heading + (u[:, n] + w[:, n]) * period / count / 2
            velocity = u[:, :n] if grid.headings == 1 else _rotate(u[:, :n], mean_heading)
            x = x + (velocity + w[:, :n]) * period / count
            heading = heading if grid.headings == 1 else heading + (u[:, n] + w[:, n]) * period / count
            is_hit |= _is_in_a_cube(x, boxes)
    is_in_target = (x >= controller.family.side - BOX).all(axis=1) & (x <= controller.family.side).all(axis=1)
    return RunCounts(runs, int(is_hit_at_sample.sum()), int((is_hit & ~is_hit_at_sample).sum()), int(is_in_target.sum()))


def _is_in_a_cube(x: Array, boxes: Array) -> Array:
    """Whether states are inside some open cube, (count,)."""
    within: Array = (boxes[:, :, 0] < x[:, None]) & (x[:, None] < boxes[:, :, 1])
    return np.asarray(np.any(np.all(within, axis=2), axis=1))


def _rotate(v: Array, angle: Array) -> Array:
    """Rotate vectors of the plane, (count, 2), each by its angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]], axis=1)


def _cell_edges(family: Family, grid: Abstraction) -> list[Fraction]:
    """Return the coordinates of the cells' borders along an axis."""
    return [Fraction(family.side) * k / grid.cells for k in range(grid.cells + 1)]


def _blocked_cells(family: Family, boxes: Array, grid: Abstraction) -> Array:
    """Return whether a cell meets an unsafe cube, (cells, ..., headings)."""
    edges, is_blocked = _cell_edges(family, grid), np.zeros((grid.cells,) * family.dimension, dtype=bool)
    for box in boxes:
        spans = []
        for low, high in box:
            met = [k for k in range(grid.cells) if edges[k] < Fraction(float(high)) and edges[k + 1] > Fraction(float(low))]
            spans.append(slice(met[0], met[-1] + 1))
        is_blocked[tuple(spans)] = True
    return np.repeat(is_blocked[..., None], grid.headings, axis=-1)


def _target_cells(family: Family, grid: Abstraction) -> Array:
    """Return whether a cell lies in the target, (cells, ..., headings)."""
    on_axis = np.array([edge >= Fraction(family.side) - Fraction(BOX) for edge in _cell_edges(family, grid)[:-1]])
    is_target = on_axis
    for _ in range(family.dimension - 1):
        is_target = is_target[..., None] & on_axis
    return np.repeat(is_target[..., None], grid.headings, axis=-1)


class _Motion(NamedTuple):
    """What one period does to a cell: how far its middle moves, by how much the cell grows by its uncertain heading; and how many
    cells its heading turns, and by how many that is uncertain."""

    way: list[Fraction]
    bend: Fraction
    turn: Fraction
    turn_error: Fraction


def _motion(grid: Abstraction, u: Sequence[Fraction], heading: int, n: int) -> _Motion:
    """Return the motion of a cell of this heading under an input, wind left out but for the heading's."""
    if grid.headings == 1:
        return _Motion([grid.period * v for v in u[:n]], Fraction(0), Fraction(0), Fraction(0))
    rounding = 1e-9  # more than the error of the doubles in this function
    width = 2 * math.pi / grid.headings
    angle, rate, period = (heading + 0.5) * width - math.pi, float(u[-1]), float(grid.period)
    half_turn = rate * period / 2  # the mean heading is angle + half_turn, and turning shortens the way by sin(h) / h
    length = period * (math.sin(half_turn) / half_turn if half_turn else 1.0)
    c, s = math.cos(angle + half_turn) * length, math.sin(angle + half_turn) * length
    way = [Fraction(c * float(u[0]) - s * float(u[1])), Fraction(s * float(u[0]) + c * float(u[1]))]
    speed = math.hypot(float(u[0]), float(u[1]))
    bend = Fraction(speed * (width / 2 * period + float(grid.w_max) * period**2 / 2) + rounding)
    turn_error = Fraction(float(grid.period * grid.w_max) / width + rounding)
    return _Motion(way, bend, Fraction(rate * period / width), turn_error)


def _transition_windows(family: Family, grid: Abstraction, u: Sequence[Fraction], heading: int) -> TransitionWindows:
    """Return the windows of a cell of this heading under an input."""
    n, step = family.dimension, Fraction(family.side) / grid.cells
    motion, growth = _motion(grid, u, heading, n), grid.period * grid.w_max
    successors, on_the_way = [], []
    for way in motion.way:  # cells are [k step, (k + 1) step), the box is closed, its cell's middle at step / 2
        low, high = (way + step / 2 + sign * (step / 2 + growth + motion.bend) for sign in (-1, 1))
        successors.append((math.floor(low / step), math.floor(high / step)))
        on_the_way.append((min(successors[-1][0], 0), max(successors[-1][1], 0)))
    if grid.headings > 1:
        successors.append((math.floor(motion.turn - motion.turn_error), math.floor(motion.turn + 1 + motion.turn_error)))
    return TransitionWindows(tuple(successors), tuple(on_the_way))


def _has_free_way(is_blocked: Array, grid: Abstraction, windows: TransitionWindows) -> Array:
    """Return whether no cell on the way is blocked or outside of the state space; without `is_swept` always."""
    if not grid.is_swept:
        return np.ones(is_blocked.shape, dtype=bool)
    return np.asarray(_largest_in_window(is_blocked.astype(np.int16), windows.on_the_way, 1) == 0)


def _worst_successor(value: Array, windows: Sequence[TransitionWindows], grid: Abstraction, outside: Any) -> Array:
    """Return the largest value over the successors of every cell, for one input. windows: by heading; outside: the value of cells
    beyond the state space."""
    if grid.headings == 1:
        return _largest_in_window(value[..., 0], windows[0].successors, outside)[..., None]
    low, high = windows[0].successors[-1]
    over_headings = np.max([np.roll(value, -d, axis=-1) for d in range(low, high + 1)], axis=0)
    return np.stack(
        [_largest_in_window(over_headings[..., k], windows[k].successors[:-1], outside) for k in range(grid.headings)], axis=-1
    )


def _largest_in_window(value: Array, window: Window, outside: Any) -> Array:
    """Return the largest value over a window about every cell; `outside` beyond the state space."""
    for axis, (low, high) in enumerate(window):
        before, after = max(0, -low), max(0, high)
        pad = [(0, 0)] * value.ndim
        pad[axis] = (before, after)
        padded, size = np.pad(value, pad, constant_values=outside), value.shape[axis]
        shifted = [np.take(padded, range(before + d, before + d + size), axis=axis) for d in range(low, high + 1)]
        value = np.maximum.reduce(shifted)
    return value
