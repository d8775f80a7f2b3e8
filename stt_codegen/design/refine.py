"""The refined design: a width, a route with room for it, its sides, then a spline tube by linear programming.

    arena -> the widest share of start and target for which a route is at most ROOM times the shortest
          -> sides of the box of that width that moves along the route; where that fails, stays and stretch times
          -> the slowest tube of that width (small linear programs, one for each dimension), sides chosen anew while it helps
          -> a smaller share, until the tube is no faster than ROOM times the shortest route
          -> coefficients rounded to a dyadic grid that a float holds exactly

So the width is in every bound from the start. Nothing here is trusted: the exact certificate is computed from the rounded
coefficients alone.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from stt_codegen.decimals import below
from stt_codegen.design.arena import Arena, arena_of, normalised, starting_box
from stt_codegen.design.lattice import STEP_BITS, lattice_of
from stt_codegen.design.shape import Shape
from stt_codegen.design.widest import ROOM, Search
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.task import Task

SEGMENTS = (32, 48, 64, 96, 128, *(1 << k for k in range(8, 14)))  # tried in this order when the task names no number,
FEWEST, MOST = 0.5, 8  # between so many times the number of unsafe sets, but always up to PLENTY
PLENTY = 128
NARROWING = 5  # halvings to find the largest value of an option that would do


def refine(task: Task, room: float = ROOM) -> RefinedDesign:
    """Design a refined tube. Raises `NotCertified` with the reason when none is found.

    room: the peak speed over the shortest route's length and t_c; at 1 the tube is as slow, and so as narrow, as it gets.
    """
    lattice = lattice_of(task)
    arena = normalised(arena_of(task, lattice), lattice.exponent)
    search = Search(arena, starting_box(arena), _ladder(task, arena))
    shape = search.slowest() if room <= 1 else search.many() if len(arena.names) > PLENTY else search.widest(room)
    if shape is None:
        count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {search.ladder[-1]} segments"
        raise NotCertified(f"P4 avoid: no spline tube of {count} was found along the shortest route; {_what_binds(task, arena)}")
    if shape.speed > search.most(shape.segments):
        raise NotCertified(_too_fast(arena, shape))
    return round_design(task, shape)


def _ladder(task: Task, arena: Arena) -> tuple[int, ...]:
    return (task.tube.segments,) if task.tube.segments else segments_for(len(arena.names))


def _too_fast(arena: Arena, shape: Shape) -> str:
    needed = (shape.speed + arena.allowance * shape.segments) * 1.00001  # so that the printed digits are enough
    speed = arena.length_unit / arena.time_unit
    return (
        f"P6 speed: the slowest tube found needs {needed * speed:.6g}, above tube.max_speed {arena.max_speed * speed:.6g}; "
        f"raise tube.max_speed to that, or prescribed_time to {arena.time_unit * needed / arena.max_speed:.6g} s"
    )


def _what_binds(task: Task, arena: Arena) -> str:
    """Which options, changed one at a time, would let a tube be found, and how far each must go."""
    size = arena.length_unit

    def found(clearance: float, min_width: float, ladder: tuple[int, ...]) -> Shape | None:
        trial = replace(arena, clearance=clearance, min_width=min_width)
        with suppress(NotCertified):
            search = Search(trial, starting_box(trial), ladder)
            shape = search.slowest()
            return shape if shape is not None and shape.speed <= search.most(shape.segments) else None
        return None

    def largest(holds: Callable[[float], bool], least: float, most: float) -> float | None:
        if not holds(least):
            return None
        for _ in range(NARROWING):
            middle = (least + most) / 2
            least, most = (middle, most) if holds(middle) else (least, middle)
        return least

    usual = segments_for(len(arena.names))
    ladder = (task.tube.segments,) if task.tube.segments else usual
    would_do = []
    if task.tube.segments:
        more = (*range(task.tube.segments + 1, SEGMENTS[0]), *usual)
        shape = found(arena.clearance, arena.min_width, tuple(k for k in more if k > task.tube.segments))
        if shape is not None:
            would_do.append(f"tube.segments = {shape.points.shape[2] - 3} (or leave it out)")
    spare = arena.allowance
    clearance = largest(lambda c: found(c, arena.min_width, ladder) is not None, spare, arena.clearance)
    if clearance is not None:
        would_do.append(f"tube.clearance = {below(Fraction((clearance - spare) * size), 3):g}")
    width = largest(lambda w: found(arena.clearance, w, ladder) is not None, 2 * spare, arena.min_width)
    if width is not None:
        would_do.append(f"tube.min_width = {below(Fraction((width - 2 * spare) * size), 3):g}")
    if not would_do and arena.max_speed < np.inf:
        return "without tube.max_speed, " + _what_binds(task, replace(arena, max_speed=np.inf))
    if not would_do:
        return "no single option of [tube] would change that: lower tube.clearance and tube.min_width, or make more room"
    return ", or ".join(would_do) + " would do"


def segments_for(unsafe: int) -> tuple[int, ...]:
    """The numbers of segments to try for so many unsafe sets."""
    return tuple(k for k in SEGMENTS if FEWEST * unsafe <= k <= max(PLENTY, MOST * unsafe))


def round_design(task: Task, shape: Shape) -> RefinedDesign:
    """Control points over 6 (here in units of the lattice's size, from its origin), rounded to the lattice, so that the scalar
    holds them exactly. Floats and doubles share one tube, and one certificate, unless the task is far from the origin."""
    lattice = lattice_of(task)
    integers = np.rint(np.ldexp(shape.points / 6, STEP_BITS)).astype(np.int64)
    integers += np.array(lattice.offsets, dtype=np.int64)[:, None]
    integers[:, :, -1] = integers[:, :, -3]
    table = tuple(tuple((low, high) for low, high in row) for row in integers.transpose(2, 1, 0).tolist())
    return RefinedDesign(task.prescribed_time, integers.shape[2] - 3, lattice.bits, table)
