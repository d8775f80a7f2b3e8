"""The refined design: a width, a route with room for it, its sides, then a spline tube by linear programming.

    arena -> the widest share of start and target for which a route is short enough (design/widest.py)
          -> sides of the box of that width that moves along the route; where that fails, stays and stretch times
          -> the slowest tube of that width (small linear programs, one for each dimension), sides chosen anew while it helps
          -> a smaller share, until the tube is slow enough; then, of all that slow, the one that bends least
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
from stt_codegen.design.shape import Shape, calmest
from stt_codegen.design.widest import Search
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.sampling import Gains, bounds_of_task, eps_of_share, law_of, refined_windows, setting_of
from stt_codegen.sampling.gains import natural_gain
from stt_codegen.task import Task

SEGMENTS = (32, 48, 64, 96, 128, *(1 << k for k in range(8, 14)))  # tried in this order when the task names no number,
FEWEST, MOST = 0.5, 8  # between so many times the number of unsafe sets, but always up to PLENTY
PLENTY = 128
BENDS = 2.0**20  # times max_acceleration: beyond, it is not what leaves no tube
AS_SLOW = 1.01  # times the slowest tube is as slow, where that is preferred: so much for width
NARROWING = 5  # halvings to find the largest value of an option that would do


def refine(task: Task) -> RefinedDesign:
    """Design a refined tube, the one that tube.prefer asks for. Raises `NotCertified` with the reason when none is found."""
    search = _search(task)
    arena = search.arena
    shape = search.many() if len(arena.names) > PLENTY else search.widest()
    if task.tube.prefer != "balanced":
        shape = _preferred(task, search, ([] if shape is None else [shape]) + _others(search))
    if shape is None:
        count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {search.ladder[-1]} segments"
        raise NotCertified(
            _bends_too_much(task, arena)
            or f"P4 avoid: no spline tube of {count} was found along the shortest route; {_what_binds(task, arena)}"
        )
    if shape.speed > search.most(shape.segments):
        raise NotCertified(_too_fast(task, arena, shape))
    return _finished(task, search, shape)


def family(task: Task) -> list[RefinedDesign]:
    """Tubes of several widths for one task, the widest first; of many unsafe sets the slowest alone."""
    search = _search(task)
    return [_finished(task, search, shape) for shape in _others(search)]


def _others(search: Search) -> list[Shape]:
    if len(search.arena.names) <= PLENTY:
        return list(search.family())
    slow = search.slowest()
    return [] if slow is None or slow.speed > search.most(slow.segments) else [slow]


def _preferred(task: Task, search: Search, shapes: list[Shape]) -> Shape | None:
    """Of several tubes the one that tube.prefer asks for; the first of equals."""
    if not shapes:
        return None
    if task.tube.prefer == "period":
        return max(shapes, key=lambda shape: _longest_period(task, _finished(task, search, shape)))
    if task.tube.prefer == "wide":
        return max(shapes, key=lambda shape: (shape.width.min(), -shape.speed))
    slow = [shape for shape in shapes if shape.speed <= AS_SLOW * min(s.speed for s in shapes)]
    return max(slow, key=lambda shape: shape.width.min())


def _search(task: Task) -> Search:
    lattice = lattice_of(task)
    arena = normalised(arena_of(task, lattice), lattice.exponent)
    return Search(arena, starting_box(arena), _ladder(task, arena))


def _finished(task: Task, search: Search, shape: Shape) -> RefinedDesign:
    return round_design(task, calmest(search.arena, search.start, shape))


def _longest_period(task: Task, design: RefinedDesign) -> float:
    """Seconds between samples that are proved for the plant's bounds and the share of starts: at the task's gain, over all gains
    where that is left open. 0 where there are none."""
    windows = refined_windows(design)
    law = law_of(task, (lattice_of(task).allowance,) * task.dimension, float(task.plant.noise or 0), float(task.control.latency))
    start = eps_of_share(task.initial_set.share, task.dimension)
    setting = setting_of(windows, [bounds_of_task(task)] * len(windows.narrow), law, start)
    if task.control.gain is None or task.gain_chosen:
        best = Gains(setting, natural_gain(setting)).longest
        return 0.0 if best is None else best[1].seconds
    period = Gains(setting, setting.law.gain).at(setting.law.gain)
    return 0.0 if period is None else period.seconds


def _ladder(task: Task, arena: Arena) -> tuple[int, ...]:
    return (task.tube.segments,) if task.tube.segments else segments_for(len(arena.names))


def _too_fast(task: Task, arena: Arena, shape: Shape) -> str:
    needed = (shape.speed + arena.allowance * shape.segments) * 1.00001  # so that the printed digits are enough
    factor = needed / arena.max_speed
    return (
        f"P6 speed: the slowest tube found needs {_raised(task.tube.max_speed, factor)}, above tube.max_speed "
        f"{_raised(task.tube.max_speed, 1.0)}; raise tube.max_speed to that, or prescribed_time to "
        f"{arena.time_unit * factor:.6g} s"
    )


def _raised(given: Fraction | tuple[Fraction, ...] | None, factor: float) -> str:
    """One number, or one for each component, so many times as large."""
    if isinstance(given, tuple):
        return f"[{', '.join(f'{float(v) * factor:.6g}' for v in given)}]"
    return f"{float(given or 0) * factor:.6g}"


def _bends_too_much(task: Task, arena: Arena) -> str | None:
    """The refusal where it is max_acceleration that leaves no tube, with what would do; None where it is not."""
    most = arena.max_acceleration
    if most is None:
        return None

    def possible(factor: float) -> bool:
        trial = replace(arena, max_acceleration=most * factor)
        search = Search(trial, starting_box(trial), _ladder(task, trial))
        shape = search.slowest()
        return shape is not None and shape.speed <= search.most(shape.segments)

    low, high = 1.0, 2.0
    while high < BENDS and not possible(high):
        low, high = high, high * 2
    if high >= BENDS:
        return None
    for _ in range(NARROWING):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if possible(middle) else (middle, high)
    high *= 1.00001  # so that the printed digits are enough
    return (
        "P6 acceleration: no tube within tube.max_acceleration was found along the shortest route; raise it to "
        f"{_raised(task.tube.max_acceleration, high)}, or prescribed_time to {arena.time_unit * high**0.5:.6g} s"
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
