"""What is told where no tube is found: which option would have to change, and how far. Every limit that is named was tried."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from stt_codegen.decimals import above, below
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.mission_search import search_of
from stt_codegen.design.refusals.closed_ways import why_closed
from stt_codegen.design.refusals.unmet_missions import times_that_do, why_late, why_unmet
from stt_codegen.design.routes import shortest_route
from stt_codegen.design.spline_tubes import ROUNDED, SEGMENTS, Shape, segments_for, segments_tried
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.properties import Property
from stt_codegen.task import Task

NARROWING = 5  # halvings to find the value of an option that would do
DIGITS = 6  # of a value that is proposed, rounded up
LARGEST = 1e18  # of a factor: a task's numbers are between 1e-9 and 1e9
IsFound = Callable[[Task], bool]  # whether a tube within its limits is found for a task
Given = Fraction | tuple[Fraction, ...]


def refusal(task: Task, arena: Arena, is_found: IsFound) -> str:
    """Why there is no tube for the task, whose arena this is, in one sentence, and what would do."""
    limits = {f"tube.{name}": getattr(task.tube, name) for name in ("max_speed", "max_acceleration")}
    limits["control.u_max"] = task.control.u_max if task.requires_input_limits else None
    limits = {name: given for name, given in limits.items() if given is not None}
    if limits and is_found(_with(_in_floats(task), dict.fromkeys(limits))):
        return _limits_bind(task, arena, limits, is_found)
    if task.mission:
        return why_unmet(task, arena, is_found)
    if arena.timed_obstacles:
        still = replace(arena, timed_obstacles=())
        shortest_route(still, starting_box(arena), np.full(arena.dimension, arena.min_width))  # raises where these shut the way
        return why_closed(task, arena, segments_tried(task, arena)[0])
    free = replace(arena, max_speed=np.inf, max_speeds=np.full(arena.dimension, np.inf), max_acceleration=None)
    ladder = segments_tried(task, arena)
    count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {ladder[-1]} segments"
    return (
        f"{Property.AVOID.label}: no spline tube of {count} was found along the shortest route; {_what_binds(task, free, ladder)}"
    )


def _in_floats(task: Task) -> Task:
    """The same task in a scalar that needs no limit of u."""
    return task.changed(emit={"scalar": "float"}) if task.emit.scalar == "fixed" else task


def _with(task: Task, values: Mapping[str, Given | None]) -> Task:
    """The task with other values for fields of its tables, such as "tube.max_speed"."""
    tables: dict[str, dict[str, Given | None]] = {}
    for name, value in values.items():
        table, field = name.split(".")
        tables.setdefault(table, {})[field] = value
        if name == "control.u_max" and value is None:  # what says how it limits goes with it
            tables[table]["saturate"] = None
    return task.changed(**tables)


def _needed(task: Task, arena: Arena) -> float:
    """How many times its bounds on speed the slowest tube takes: what is tried first."""
    free = search_of(replace(arena, max_speed=np.inf), starting_box(arena), segments_tried(task, arena))
    shape = free.slowest()
    if shape is None or not (np.isfinite(arena.max_speeds) & (arena.max_speeds > 0)).all():
        return 1.0
    speeds = (shape.paces + ROUNDED * arena.difference_allowance) * shape.segments
    return float((speeds / arena.max_speeds).max())


def _limits_bind(task: Task, arena: Arena, limits: dict[str, Given], is_found: IsFound) -> str:
    """The refusal where it is the limits that leave no tube. Every value that is named was tried, as it is printed."""
    told, guess = [], _needed(task, arena)
    for name, given in limits.items():
        factor = _least(lambda f, name=name, given=given: is_found(_with(task, {name: _times(given, f)})), guess)  # type: ignore[misc]
        if factor is not None:
            told.append(f"raise {name} to {_shown(_times(given, factor))}")
    longer = _least(lambda f: is_found(task.changed(prescribed_time=_times(task.prescribed_time, f))), guess)
    if longer is not None:
        told.append(f"raise prescribed_time to {_shown(_times(task.prescribed_time, longer))} s")
    pushes = {
        f"plant.{k}": v for k in ("f_max", "w_max") if (v := getattr(task.plant, k)) and any(v if isinstance(v, tuple) else (v,))
    }
    if "control.u_max" in limits and pushes:
        less = _least(lambda f: is_found(_with(task, {k: _times(v, 1 / f) for k, v in pushes.items()})), 1.0)
        if less is not None:
            told.append(f"lower {' and '.join(f'{k} to {_shown(_times(v, 1 / less))}' for k, v in pushes.items())}")
    bounds = " and ".join(f"{name} {_shown(value)}" for name, value in limits.items())
    told += [f"set {one}" for one in times_that_do(task, is_found)]
    found = ", or ".join(told) or "no value of one alone would do; leave both out"
    more = "; whether control.period is proved then shows in the next run" if told and task.control.period is not None else ""
    rates = [word for name, word in (("tube.max_speed", "speed"), ("tube.max_acceleration", "acceleration")) if name in limits]
    what = [Property.SMOOTH.label_of(" and ".join(rates))] if rates else []
    what += [Property.LIMITS.label] if "control.u_max" in limits else []
    late = why_late(task, arena)
    return f"{' and '.join(what)}: no tube was found within {bounds}{late}; {found}{more}"


def _least(holds: Callable[[float], bool], guess: float) -> float | None:
    """A factor above 1 that holds, near the least one; None where none does that leaves numbers as large as a task may have."""

    def good(factor: float) -> bool:
        with suppress(BadInput):
            return holds(factor)
        return False

    if guess > 1 and good(guess):
        return guess
    low, high = 1.0, 1.5
    while not good(high):
        low, high = high, high * high
        if high > LARGEST:
            return None
    for _ in range(NARROWING):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if good(middle) else (middle, high)
    return high


def _times(given: Given, factor: float) -> Given:
    """So many times as large, of DIGITS digits, rounded up."""
    if isinstance(given, tuple):
        return tuple(Fraction(f"{above(v * Fraction(factor), DIGITS):g}") for v in given)
    return Fraction(f"{above(given * Fraction(factor), DIGITS):g}")


def _shown(given: Given) -> str:
    return f"[{', '.join(f'{float(v):g}' for v in given)}]" if isinstance(given, tuple) else f"{float(given):g}"


def _what_binds(task: Task, arena: Arena, ladder: tuple[int, ...]) -> str:
    """Which options, changed one at a time, would let a tube be found, and how far each must go."""
    size = arena.length_unit

    def found(clearance: float, min_width: float, ladder: tuple[int, ...]) -> Shape | None:
        trial = replace(arena, clearance=clearance, min_width=min_width)
        with suppress(NotCertified):
            return search_of(trial, starting_box(trial), ladder).slowest()
        return None

    def largest(holds: Callable[[float], bool], least: float, most: float) -> float | None:
        if not holds(least):
            return None
        for _ in range(NARROWING):
            middle = (least + most) / 2
            least, most = (middle, most) if holds(middle) else (least, middle)
        return least

    usual, would_do = segments_for(len(arena.names)), []
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
    if not would_do:
        return "no single option of [tube] would change that: lower tube.clearance and tube.min_width, or make more room"
    return ", or ".join(would_do) + " would do"
