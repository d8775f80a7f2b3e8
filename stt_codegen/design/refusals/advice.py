"""The message where no tube is found: which option would have to change, and how far. Every value in it was tried.

refine.py calls `explain_refusal`. Sets that move and missions have messages of their own (closed_routes.py, unmet_missions.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from stt_codegen.decimals import above, below
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.mission_search import search_of
from stt_codegen.design.refusals.closed_routes import explain_closed_routes
from stt_codegen.design.refusals.unmet_missions import HasTube, explain_conflict, explain_unmet_mission, sufficient_times
from stt_codegen.design.routes import shortest_route
from stt_codegen.design.spline_tubes import ROUNDING_SHARE, SEGMENT_COUNTS, SplineTube, segment_counts_for, segment_counts_of
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.properties import Property
from stt_codegen.task import Task

HALVINGS = 5  # to find the value of an option that would do
DIGITS = 6  # of a value that is proposed, rounded up
FACTOR_LIMIT = 1e18  # a task's numbers are between 1e-9 and 1e9
OptionValue = Fraction | tuple[Fraction, ...]


def explain_refusal(task: Task, arena: Arena, has_tube: HasTube) -> str:
    """Return in one sentence why there is no tube for the task, whose arena this is, and what would do."""
    limits = {f"tube.{name}": getattr(task.tube, name) for name in ("max_speed", "max_acceleration")}
    limits["control.u_max"] = task.control.u_max if task.requires_input_limits else None
    limits = {name: value for name, value in limits.items() if value is not None}
    if limits and has_tube(_with_values(_in_floats(task), dict.fromkeys(limits))):
        return _explain_limits(task, arena, limits, has_tube)
    if task.mission:
        return explain_unmet_mission(task, arena, has_tube)
    if arena.timed_obstacles:
        resting = replace(arena, timed_obstacles=())
        # the sets that do not move may close every route by themselves: this raises then
        shortest_route(resting, starting_box(arena), np.full(arena.dimension, arena.min_width))
        return explain_closed_routes(task, arena, segment_counts_of(task, arena)[0])
    unlimited = replace(arena, max_speed=np.inf, max_speeds=np.full(arena.dimension, np.inf), max_acceleration=None)
    segment_counts = segment_counts_of(task, arena)
    count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {segment_counts[-1]} segments"
    remedy = _tube_options_that_do(task, unlimited, segment_counts)
    return f"{Property.AVOID.label}: no spline tube of {count} was found along the shortest route; {remedy}"


def _in_floats(task: Task) -> Task:
    """Return the same task in a scalar that needs no limit of u."""
    return task.changed(emit={"scalar": "float"}) if task.emit.scalar == "fixed" else task


def _with_values(task: Task, values: Mapping[str, OptionValue | None]) -> Task:
    """Return the task with other values for fields of its tables, such as "tube.max_speed"."""
    tables: dict[str, dict[str, OptionValue | None]] = {}
    for name, value in values.items():
        table, field = name.split(".")
        tables.setdefault(table, {})[field] = value
        if name == "control.u_max" and value is None:  # the option how u is limited has no meaning without a limit
            tables[table]["saturate"] = None
    return task.changed(**tables)


def _excess_of_speed(task: Task, arena: Arena) -> float:
    """Return how many times its bounds on speed the slowest tube takes, as a first guess for a factor."""
    search = search_of(replace(arena, max_speed=np.inf), starting_box(arena), segment_counts_of(task, arena))
    tube = search.find_slowest()
    if tube is None or not (np.isfinite(arena.max_speeds) & (arena.max_speeds > 0)).all():
        return 1.0
    speeds = (tube.paces + ROUNDING_SHARE * arena.difference_allowance) * tube.segments
    return float((speeds / arena.max_speeds).max())


def _explain_limits(task: Task, arena: Arena, limits: dict[str, OptionValue], has_tube: HasTube) -> str:
    """Return the message where the limits leave no tube. Every value in it was tried, as it is printed."""
    remedies = list(_remedies(task, arena, limits, has_tube))
    bounds = " and ".join(f"{name} {_shown(value)}" for name, value in limits.items())
    remedy = ", or ".join(remedies) or f"no multiple of one of them alone would do; try without {' and '.join(limits)}"
    is_period_open = bool(remedies) and task.control.period is not None
    period = "; whether control.period is proved then shows in the next run" if is_period_open else ""
    rates = [word for name, word in (("tube.max_speed", "speed"), ("tube.max_acceleration", "acceleration")) if name in limits]
    properties = [Property.SMOOTH.label_of(" and ".join(rates))] if rates else []
    properties += [Property.LIMITS.label] if "control.u_max" in limits else []
    conflict = explain_conflict(task, arena)
    return f"{' and '.join(properties)}: no tube was found within {bounds}{conflict}; {remedy}{period}"


def _remedies(task: Task, arena: Arena, limits: dict[str, OptionValue], has_tube: HasTube) -> Iterator[str]:
    """Yield the changes of one option, or of the plant's bounds, with any of which a tube is found."""
    guess = _excess_of_speed(task, arena)

    def scaled(values: Mapping[str, OptionValue], factor: float) -> Task:
        return _with_values(task, {name: _times(value, factor) for name, value in values.items()})

    for name, value in limits.items():
        factor = _smallest_factor(lambda f, limit={name: value}: has_tube(scaled(limit, f)), guess)  # type: ignore[misc]
        if factor is not None:
            yield f"raise {name} to {_shown(_times(value, factor))}"
    longer = _smallest_factor(lambda f: has_tube(task.changed(prescribed_time=_times(task.prescribed_time, f))), guess)
    if longer is not None:
        yield f"raise prescribed_time to {_shown(_times(task.prescribed_time, longer))} s"
    plant_bounds = {f"plant.{k}": v for k in ("f_max", "w_max") if (v := getattr(task.plant, k)) and any(_as_tuple(v))}
    if "control.u_max" in limits and plant_bounds:
        divisor = _smallest_factor(lambda f: has_tube(scaled(plant_bounds, 1 / f)), 1.0)
        if divisor is not None:
            yield f"lower {' and '.join(f'{k} to {_shown(_times(v, 1 / divisor))}' for k, v in plant_bounds.items())}"
    yield from (f"set {times}" for times in sufficient_times(task, has_tube))


def _smallest_factor(would_do: Callable[[float], bool], guess: float) -> float | None:
    """Return a factor above 1 that would do, near the smallest one; None where no factor up to FACTOR_LIMIT would."""

    def is_valid(factor: float) -> bool:
        with suppress(BadInput):
            return would_do(factor)
        return False

    if guess > 1 and is_valid(guess):
        return guess
    low, high = 1.0, 1.5
    while not is_valid(high):
        low, high = high, high * high
        if high > FACTOR_LIMIT:
            return None
    for _ in range(HALVINGS):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if is_valid(middle) else (middle, high)
    return high


def _as_tuple(value: OptionValue) -> tuple[Fraction, ...]:
    return value if isinstance(value, tuple) else (value,)


def _times(value: OptionValue, factor: float) -> OptionValue:
    """Return a value times a factor, with DIGITS digits, rounded up."""
    products = tuple(Fraction(f"{above(v * Fraction(factor), DIGITS):g}") for v in _as_tuple(value))
    return products if isinstance(value, tuple) else products[0]


def _shown(value: OptionValue) -> str:
    return f"[{', '.join(f'{float(v):g}' for v in value)}]" if isinstance(value, tuple) else f"{float(value):g}"


def _tube_options_that_do(task: Task, arena: Arena, segment_counts: tuple[int, ...]) -> str:
    """Return which options of [tube], changed one at a time, would let a tube be found, and how far each must go."""

    def slowest(clearance: float, min_width: float, segment_counts: tuple[int, ...]) -> SplineTube | None:
        trial = replace(arena, clearance=clearance, min_width=min_width)
        with suppress(NotCertified):
            return search_of(trial, starting_box(trial), segment_counts).find_slowest()
        return None

    options = []
    if task.tube.segments:
        counts = (*range(task.tube.segments + 1, SEGMENT_COUNTS[0]), *segment_counts_for(len(arena.names)))
        tube = slowest(arena.clearance, arena.min_width, tuple(k for k in counts if k > task.tube.segments))
        if tube is not None:
            options.append(f"tube.segments = {tube.points.shape[2] - 3} (or leave it out)")
    zero = arena.allowance  # the arena's value for a clearance of 0; a width has an allowance at both edges
    clearance = _largest(lambda c: slowest(c, arena.min_width, segment_counts) is not None, zero, arena.clearance)
    if clearance is not None:
        options.append(f"tube.clearance = {below(Fraction((clearance - zero) * arena.length_unit), 3):g}")
    width = _largest(lambda w: slowest(arena.clearance, w, segment_counts) is not None, 2 * zero, arena.min_width)
    if width is not None:
        options.append(f"tube.min_width = {below(Fraction((width - 2 * zero) * arena.length_unit), 3):g}")
    if not options:
        return "no single option of [tube] would change that: lower tube.clearance and tube.min_width, or make more room"
    return ", or ".join(options) + " would do"


def _largest(would_do: Callable[[float], bool], low: float, high: float) -> float | None:
    """Return a value that would do, near the largest one between `low` and `high`; None where `low` would not."""
    if not would_do(low):
        return None
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if would_do(middle) else (low, middle)
    return low
