"""The refined design: a route, its sides, the least times, then a spline tube by linear programming.

    arena -> route -> sides -> stretch times (one small linear program)
          -> least peak speed, then greatest width at SPEED_ROOM times that speed, then each dimension as slow as its
             width allows (small linear programs, one for each dimension)
          -> sides chosen anew where the tube has more room on another side, repeated while it helps
          -> coefficients rounded to a dyadic grid that a float holds exactly

Nothing here is trusted: the exact certificate is computed from the rounded coefficients alone.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from stt_codegen.decimals import below
from stt_codegen.design.arena import Arena, Array, arena_of, normalised, starting_box
from stt_codegen.design.lattice import STEP_BITS, lattice_of
from stt_codegen.design.route import Route, find_route, shortest_route
from stt_codegen.design.shape import SPEED_ROOM, Shape, find_shape
from stt_codegen.design.sides import choose_sides, limits_by_stretch
from stt_codegen.design.timing import changes_at, least_times, time_plans
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.task import Task

SEGMENTS = (32, 48, 64, 96, 128, *(1 << k for k in range(8, 14)))  # tried in this order when the task names no number,
FEWEST, MOST = 0.5, 8  # between so many times the number of unsafe sets, but always up to PLENTY
PLENTY = 128
WIDE_ROUTES = (1.0, 0.5)  # widths to find a route for before the least width, relative to start and target
DETOUR = 1.1  # how much longer than the shortest such a route may be
NARROWING = 5  # halvings to find the largest value of an option that would do


def refine(task: Task, room: float = SPEED_ROOM) -> RefinedDesign:
    """Design a refined tube. Raises `NotCertified` with the reason when none is found.

    room: the peak speed over the least that was found; at 1 the tube is as slow, and so as narrow, as it gets.
    """
    lattice = lattice_of(task)
    arena = normalised(arena_of(task, lattice), lattice.exponent)
    start = starting_box(arena)
    ladder = (task.tube.segments,) if task.tube.segments else segments_for(len(arena.names))
    *wide, shortest = candidate_routes(arena, start)
    for route in wide:
        with suppress(NotCertified):  # too fast along this one; the shortest may do
            shape = _follow(arena, start, route, ladder[:1], room)
            if shape is not None:
                return round_design(task, shape)
    shape = _follow(arena, start, shortest, ladder, room)
    if shape is not None:
        return round_design(task, shape)
    count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {ladder[-1]} segments"
    raise NotCertified(f"P4 avoid: no spline tube of {count} was found along the shortest route; {_what_binds(task, arena)}")


def _what_binds(task: Task, arena: Arena) -> str:
    """Which options, changed one at a time, would let a tube be found, and how far each must go."""
    size = arena.length_unit

    def found(clearance: float, min_width: float, ladder: tuple[int, ...]) -> Shape | None:
        trial = replace(arena, clearance=clearance, min_width=min_width)
        with suppress(NotCertified):
            begin = starting_box(trial)
            return _follow(trial, begin, shortest_route(trial, begin, min_width), ladder, SPEED_ROOM)
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


def candidate_routes(arena: Arena, start: Array) -> list[Route]:
    """Routes to try: with room for a wide tube where that costs little length, and last the shortest."""
    shortest = shortest_route(arena, start, arena.min_width)
    full = float(np.minimum(start[1] - start[0], arena.target[1] - arena.target[0]).min())
    routes = []
    for share in WIDE_ROUTES:
        if share * full > arena.min_width:
            route = find_route(arena, start, share * full)
            if route is not None and route.length <= DETOUR * shortest.length:
                routes.append(route)
    return [*routes, shortest]


def _follow(arena: Arena, start: Array, route: Route, ladder: tuple[int, ...], room: float) -> Shape | None:
    """A spline tube along the route, with the fewest segments of the ladder that do."""
    sides = choose_sides(arena, route, start)
    timing = least_times(arena, sides, start, route) if sides is not None else None
    if sides is None or timing is None:
        return None
    for segments in ladder:
        for shares in time_plans(timing, segments):
            changes = changes_at(timing, sides, shares, segments)
            if changes is None:
                continue
            limits = limits_by_stretch(arena, sides, changes, segments)
            shape = find_shape(arena, start, limits, segments, timing, room)
            if shape is not None:
                return shape
    return None


def round_design(task: Task, shape: Shape) -> RefinedDesign:
    """Control points over 6 (here in units of the lattice's size, from its origin), rounded to the lattice, so that the scalar
    holds them exactly. Floats and doubles share one tube, and one certificate, unless the task is far from the origin."""
    lattice = lattice_of(task)
    integers = np.rint(np.ldexp(shape.points / 6, STEP_BITS)).astype(np.int64)
    integers += np.array(lattice.offsets, dtype=np.int64)[:, None]
    integers[:, :, -1] = integers[:, :, -3]
    table = tuple(tuple((low, high) for low, high in row) for row in integers.transpose(2, 1, 0).tolist())
    return RefinedDesign(task.prescribed_time, integers.shape[2] - 3, lattice.bits, table)
