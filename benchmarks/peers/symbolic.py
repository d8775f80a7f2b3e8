"""Symbolic control as a peer: a grid, its transitions, and the fixed point of reach-avoid-stay over them.

A cell q stands for every state in it. Held for `period` seconds, the input u takes all of them, under every wind w with
|w_i| <= w_max, into the box

    c(q) + period u +- (step / 2 + period w_max)

about the cell's middle c(q), for xdot = u + w: the growth bound of this plant, exact. The cells that this box meets are the
successors of (q, u), and a controller for the cells is one for the states (a feedback refinement relation; Reissig, Weber and
Rungger, 2017). Least number of periods until the target, over the worst successor:

    V(q) = 0 where some u stays among such cells for ever, within the target
    V(q) = 1 + min over u of the maximum of V over the successors,    never through a cell that meets an unsafe set

so the table of the best u by cell is a controller with a worst case time. What is between two samples is not looked at, as in
the tools of this kind, and `tried` counts what comes of it; `swept` looks at every cell that the hull of both boxes meets. Of the
robot of three states, equation (14) of the paper, headings are cells too, and a box grows by what its uncertain heading turns the
way:

    r_1, r_2 + period w_max + |v| (r_3 period + w_max period^2 / 2),    r_3 + period w_max

Ours to write, since SCOTS is no package: arrays instead of lists of transitions, which these plants are the same for everywhere.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.families import BOX, Family
from stt_codegen.program.targets.template_files import template

Array = npt.NDArray[Any]
NEVER = np.int16(1 << 14)  # periods, more than any t_c has
NONE = 255  # in a table: no input is known to be safe
Window = tuple[tuple[int, int], ...]  # offsets of cells, first and last, by axis


@dataclass(frozen=True)
class Abstraction:
    """cells: along an axis of the room. period: seconds an input is held, a part of t_c. speeds: values of each input.
    turns: of the heading's rate, headings: cells of it, of the robot of three states; none of xdot = u + w."""

    cells: int
    period: Fraction
    speeds: tuple[Fraction, ...]
    w_max: Fraction = Fraction(3, 10)
    swept: bool = False
    headings: int = 1
    turns: tuple[Fraction, ...] = (Fraction(0),)

    def inputs(self, dimension: int) -> list[tuple[Fraction, ...]]:
        """Every input: by axis, then the heading's rate."""
        return list(itertools.product(*[self.speeds] * dimension, self.turns))


@dataclass(frozen=True)
class GridController:
    """table: the number of the input by cell (and heading), NONE where there is none; value: periods in the worst case. seconds:
    that it took."""

    abstraction: Abstraction
    family: Family
    table: Array
    value: Array
    seconds: float

    @property
    def wins(self) -> bool:
        """Whether every state of the start's box is in the target in time, whatever the wind and the heading."""
        a = self.abstraction
        first = math.floor(Fraction(BOX) * a.cells / Fraction(self.family.side)) + 1  # of an edge that is a cell's, that cell too
        start = self.value[(slice(0, first),) * self.family.dimension]
        return bool(start.max() * a.period <= Fraction(self.family.prescribed_time))

    def source(self) -> str:
        """The controller in C: its table, and `decide`, which finds a state's cell."""
        a, n = self.abstraction, self.family.dimension
        return template("bench/grid.c.j2").render(
            n=n,
            cells=a.cells,
            headings=a.headings,
            scale=f"{float(a.cells / Fraction(self.family.side))!r}F",
            turn=f"{a.headings / (2 * math.pi)!r}F",
            table=self.table.ravel().tolist(),
            nothing=NONE,
            inputs=[[f"{float(v)!r}F" for v in u] for u in a.inputs(n)],
        )


def synthesize(family: Family, boxes: Array, a: Abstraction) -> GridController:
    """The controller of an arena, cubes (count, n, 2)."""
    begin = time.perf_counter()
    n = family.dimension
    blocked, goal = _meets(family, boxes, a), _target(family, a)
    inputs = a.inputs(n)
    if len(inputs) >= NONE:
        raise ValueError(f"{len(inputs)} inputs: the table has bytes, so {NONE - 1} at most")
    moves = [[_windows(family, a, u, k) for k in range(a.headings)] for u in inputs]
    allowed = [np.stack([_swept(blocked[..., k], a, w[k]) for k in range(a.headings)], axis=-1) for w in moves]
    table = np.full(blocked.shape, NONE, dtype=np.uint8)
    stays = goal & ~blocked
    while True:  # the largest set within the target that some input keeps the state in
        kept = np.zeros_like(stays)
        for number, (windows, ok) in enumerate(zip(moves, allowed, strict=True)):
            good = ok & (_worst(np.where(stays, np.int16(0), np.int16(1)), windows, a, 1) == 0) & stays
            table[good & ~kept] = number
            kept |= good
        if (kept == stays).all():
            break
        stays = kept
    table[~stays] = NONE
    value = np.where(stays, np.int16(0), NEVER)
    for _ in range(math.floor(Fraction(family.prescribed_time) / a.period)):
        before = value.copy()
        for number, (windows, ok) in enumerate(zip(moves, allowed, strict=True)):
            after = np.int16(1) + _worst(before, windows, a, NEVER)
            better = ok & ~blocked & (after < value)
            value[better], table[better] = after[better], number
        if (before == value).all():
            break
    return GridController(a, family, table, value, time.perf_counter() - begin)


@dataclass(frozen=True)
class Tried:
    """Of so many closed loops from random states of the start's box: how many met an unsafe set, at a sample or between two;
    how many were in the target at t_c."""

    runs: int
    at_samples: int
    between: int
    arrived: int


def tried(controller: GridController, boxes: Array, runs: int = 1000, seed: int = 1, step: float = 1e-3) -> Tried:
    """Closed loops of the very plant that the abstraction is of. The wind is at a random corner of its box in every period, and
    states are looked at every `step` seconds."""
    a, n, random = controller.abstraction, controller.family.dimension, np.random.default_rng(seed)
    period, count = float(a.period), round(float(a.period) / step)
    inputs = np.append(np.array(a.inputs(n), dtype=float), np.zeros((1, n + 1)), axis=0)  # the last where there is none
    x = random.uniform(0, BOX, (runs, n))
    heading = random.uniform(-math.pi, math.pi, runs)
    hit, sampled = np.zeros(runs, dtype=bool), np.zeros(runs, dtype=bool)
    for _ in range(math.floor(Fraction(controller.family.prescribed_time) / a.period)):
        sampled |= _inside(x, boxes)
        cell = np.clip((x * a.cells / controller.family.side).astype(int), 0, a.cells - 1)
        at = np.floor((heading + math.pi) * a.headings / (2 * math.pi)).astype(int) % a.headings
        u = inputs[np.minimum(controller.table[(*cell.T, at)], len(inputs) - 1)]
        w = float(a.w_max) * random.choice([-1.0, 1.0], (runs, n + 1))
        for _ in range(count):
            middle = heading + (u[:, n] + w[:, n]) * period / count / 2
            way = u[:, :n] if a.headings == 1 else _turned(u[:, :n], middle)
            x = x + (way + w[:, :n]) * period / count
            heading = heading if a.headings == 1 else heading + (u[:, n] + w[:, n]) * period / count
            hit |= _inside(x, boxes)
    there = (x >= controller.family.side - BOX).all(axis=1) & (x <= controller.family.side).all(axis=1)
    return Tried(runs, int(sampled.sum()), int((hit & ~sampled).sum()), int(there.sum()))


def _inside(x: Array, boxes: Array) -> Array:
    """Whether a state is inside some open cube."""
    within: Array = (boxes[:, :, 0] < x[:, None]) & (x[:, None] < boxes[:, :, 1])
    return np.asarray(np.any(np.all(within, axis=2), axis=1))


def _turned(v: Array, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]], axis=1)


def _edges(family: Family, a: Abstraction) -> list[Fraction]:
    return [Fraction(family.side) * k / a.cells for k in range(a.cells + 1)]


def _meets(family: Family, boxes: Array, a: Abstraction) -> Array:
    """Whether a cell meets an unsafe cube, (cells, ..., headings)."""
    edges, found = _edges(family, a), np.zeros((a.cells,) * family.dimension, dtype=bool)
    for box in boxes:
        spans = []
        for low, high in box:
            inside = [k for k in range(a.cells) if edges[k] < Fraction(float(high)) and edges[k + 1] > Fraction(float(low))]
            spans.append(slice(inside[0], inside[-1] + 1))
        found[tuple(spans)] = True
    return np.repeat(found[..., None], a.headings, axis=-1)


def _target(family: Family, a: Abstraction) -> Array:
    """Whether a cell lies in the target."""
    inside = np.array([edge >= Fraction(family.side) - Fraction(BOX) for edge in _edges(family, a)[:-1]])
    found = inside
    for _ in range(family.dimension - 1):
        found = found[..., None] & inside
    return np.repeat(found[..., None], a.headings, axis=-1)


def _windows(family: Family, a: Abstraction, u: Sequence[Fraction], heading: int) -> tuple[Window, Window]:
    """Offsets of the successors of a cell of that heading, and of all that is on the way, the heading's own last."""
    n, step = family.dimension, Fraction(family.side) / a.cells
    spread = a.period * a.w_max
    if a.headings == 1:
        moved = [a.period * v for v in u[:n]]
        turned, doubt, bend = Fraction(0), Fraction(0), Fraction(0)
    else:
        width = 2 * math.pi / a.headings
        angle, rate, period = (heading + 0.5) * width - math.pi, float(u[-1]), float(a.period)
        # The mean heading of the middle is angle + rate period / 2, and turning shortens the way by sin(h) / h.
        half = rate * period / 2
        way = period * (math.sin(half) / half if half else 1.0)
        c, s = math.cos(angle + half) * way, math.sin(angle + half) * way
        moved = [Fraction(c * float(u[0]) - s * float(u[1])), Fraction(s * float(u[0]) + c * float(u[1]))]
        size = math.hypot(float(u[0]), float(u[1]))
        bend = Fraction(size * (width / 2 * period + float(a.w_max) * period**2 / 2) + 1e-9)  # 1e-9: for the doubles here
        turned, doubt = Fraction(rate * period / width), Fraction(float(spread) / width + 1e-9)
    successors, swept = [], []
    for way_ in moved:  # cells are [k step, (k + 1) step), the box is closed, its cell's middle at step / 2
        low, high = (way_ + step / 2 + sign * (step / 2 + spread + bend) for sign in (-1, 1))
        successors.append((math.floor(low / step), math.floor(high / step)))
        swept.append((min(successors[-1][0], 0), max(successors[-1][1], 0)))
    if a.headings > 1:
        low, high = turned + Fraction(1, 2) - Fraction(1, 2) - doubt, turned + 1 + doubt
        successors.append((math.floor(low), math.floor(high)))
    return tuple(successors), tuple(swept)


def _swept(blocked: Array, a: Abstraction, windows: tuple[Window, Window]) -> Array:
    """Whether no cell on the way is blocked or out of the room, where that is looked at."""
    if not a.swept:
        return np.ones(blocked.shape, dtype=bool)
    return np.asarray(_most(blocked.astype(np.int16), windows[1], 1) == 0)


def _worst(value: Array, windows: Sequence[tuple[Window, Window]], a: Abstraction, outside: Any) -> Array:
    """The largest value over the successors of every cell, for one input."""
    if a.headings == 1:
        return _most(value[..., 0], windows[0][0], outside)[..., None]
    low, high = windows[0][0][-1]
    around = np.max([np.roll(value, -d, axis=-1) for d in range(low, high + 1)], axis=0)
    return np.stack([_most(around[..., k], windows[k][0][:-1], outside) for k in range(a.headings)], axis=-1)


def _most(value: Array, window: Window, outside: Any) -> Array:
    """The largest value over a window about every cell; `outside` beyond the room."""
    for axis, (low, high) in enumerate(window):
        before, after = max(0, -low), max(0, high)
        pad = [(0, 0)] * value.ndim
        pad[axis] = (before, after)
        wide, size = np.pad(value, pad, constant_values=outside), value.shape[axis]
        parts = [np.take(wide, range(before + d, before + d + size), axis=axis) for d in range(low, high + 1)]
        value = np.maximum.reduce(parts)
    return value
