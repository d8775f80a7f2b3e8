"""What is told where no way is found among sets that move: what closes it and when, and which options would open one.

Ways are asked for, not tubes: a value that is named opens a way, and whether a tube fits along it the next run tells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np

from stt_codegen.decimals import below, decimal
from stt_codegen.design.arena import Arena, arena_of, normalised, starting_box
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.spacetime import FAR, fields, way_in_time
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.task import Task

NARROWING = 12  # halvings to find the value of an option, or a time
NAMED = 40  # up to so many sets, those are named that close the way
LONGER = (Fraction(5, 4), Fraction(3, 2), Fraction(2), Fraction(3))  # times prescribed_time


def why_closed(task: Task, arena: Arena, segments: int) -> str:
    """The refusal, in one sentence. segments: of time."""

    def way(trial: Arena) -> bool:
        with suppress(NotCertified):
            box = starting_box(trial)
            width = np.full(trial.dimension, trial.min_width)
            return way_in_time(trial, (box[0] + box[1]) / 2, width, segments) is not None
        return False

    told = "P4 avoid: no way was found from the initial set to the target set among the unsafe sets as they move"
    if way(arena):
        return f"{told}: cells have a way, but no spline tube was found along it; lower tube.min_width or tube.clearance"
    few = len(arena.movers) <= NAMED
    closing = [text for j in range(len(arena.movers)) if few and (text := _closes(arena, j, way))]
    what = f"{' and '.join(closing)} close{'s' if len(closing) == 1 else ''} it" if closing else _how_far(arena, segments)
    opens = [*_numbers(arena, way), *_options(task, way)]
    return f"{told}: {what}; " + (f"a way opens at {', or at '.join(opens)}" if opens else "move a set, or make more room")


def _numbers(arena: Arena, way: Callable[[Arena], bool]) -> Iterator[str]:
    """The largest clearance, and width, at which there is a way."""
    none, narrow = arena.allowance, 2 * arena.allowance
    tries: tuple[tuple[str, float, float, Callable[[float], Arena]], ...] = (
        ("clearance", none, arena.clearance, lambda v: replace(arena, clearance=v)),
        ("min_width", narrow, arena.min_width, lambda v: replace(arena, min_width=v)),
    )
    for name, least, asked, changed in tries:
        if way(changed(least)):
            value = _border(lambda v, c=changed: way(c(v)), least, asked)  # type: ignore[misc]
            yield f"tube.{name} = {below(Fraction(max((value - least) * arena.length_unit, 0.0)), 3):g}"


def _options(task: Task, way: Callable[[Arena], bool]) -> Iterator[str]:
    """Less doubt about the clock, no growth, more time: what alone opens a way."""
    tries: list[tuple[str, dict[str, object]]] = []
    if task.start_delay:
        tries.append(("start_delay = 0", {"start_delay": Fraction(0)}))
    for field in ("timing", "spread"):
        sets = [s.name for s in task.unsafe if getattr(s, field)]
        if sets:
            less = tuple(s.model_copy(update={field: Fraction(0)}) if getattr(s, field) else s for s in task.unsafe)
            tries.append((f"{field} = 0 of {' and '.join(sets)}", {"unsafe": less}))
    for name, change in tries:
        if _opens(task, change, way):
            yield name
    for factor in LONGER:
        if _opens(task, {"prescribed_time": factor * task.prescribed_time}, way):
            yield f"prescribed_time = {decimal(factor * task.prescribed_time)}"
            return


def _opens(task: Task, change: dict[str, object], way: Callable[[Arena], bool]) -> bool:
    with suppress(BadInput, NotCertified):
        trial = task.changed(**change)
        lattice = lattice_of(trial)
        return way(normalised(arena_of(trial, lattice), lattice.exponent))
    return False


def _closes(arena: Arena, j: int, way: Callable[[Arena], bool]) -> str | None:
    """A set without which there would be a way, and when it is in the way; None for another."""

    def without(begin: float, end: float) -> Arena:
        return replace(arena, movers=tuple(m.without(begin, end) if k == j else m for k, m in enumerate(arena.movers)))

    if not way(without(0.0, 1.0)):
        return None
    latest = _border(lambda v: way(without(v, 1.0)), 0.0, 1.0)
    earliest = _border(lambda v: way(without(latest, v)), 1.0, latest)
    begin, end = (f"{v * arena.time_unit:.3g}" for v in (latest, earliest))
    return f"{arena.movers[j].name} (from {begin} s to {end} s)"


def _border(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """The last place, from a good one towards another, at which it holds."""
    for _ in range(NARROWING):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def _how_far(arena: Arena, segments: int) -> str:
    """Where no set alone closes the way: until when any place is left to be at."""
    width, start = np.full(arena.dimension, arena.min_width), starting_box(arena)
    last = 0.0
    for field in fields(arena, (start[0] + start[1]) / 2, width, segments):
        alive = [bool((cost < FAR).any()) for cost in field.reached(field.paces[-1])]
        last = max([last, *(k / segments for k, (a, b) in enumerate(pairwise([*alive, False])) if a and not b)])
    if last < 1:
        return f"the search reached no free place after {last * arena.time_unit:.3g} s"
    return "no moving set alone closes it"
