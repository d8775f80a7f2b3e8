"""What is told where no way is found among sets that move: what closes it and when, and which options would open one.

Ways are asked for, not tubes: a value that is named opens a way, and whether a tube fits along it the next run tells.
"""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stt_codegen.decimals import below, decimal
from stt_codegen.design.arena import Arena, arena_of, normalised, starting_box
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.moving_half_spaces import TimedObstacle
from stt_codegen.design.spacetime import Field, fields, leads
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.properties import Property
from stt_codegen.task import Task

NARROWING = 8  # halvings to find the value of an option: cells are a hundredth of the room
NAMED = 40  # so many sets are asked whether they close the way,
ASKED = 6  # each on so many of the fields that are searched: all where no more than three dimensions move
LONGER = (Fraction(5, 4), Fraction(3, 2), Fraction(2), Fraction(3))  # times prescribed_time


def why_closed(task: Task, arena: Arena, segments: int) -> str:
    """The refusal, in one sentence. segments: of time."""

    def way(trial: Arena) -> bool:
        with suppress(NotCertified):
            return leads(trial, *_least(trial), segments)
        return False

    reason = f"{Property.AVOID.label}: no way was found from the initial set to the target set among the unsafe sets as they move"
    if way(arena):
        return f"{reason}: cells have a way, but no spline tube was found along it; lower tube.min_width or tube.clearance"
    searched = list(itertools.islice(fields(arena, *_least(arena), segments), ASKED))
    closing = [text for obstacle in arena.timed_obstacles[:NAMED] if (text := _closes(arena, obstacle, searched))]
    what = f"{' and '.join(closing)} close{'s' if len(closing) == 1 else ''} it" if closing else _how_far(arena, searched)
    opens = [*_numbers(arena, way), *_options(task, way)]
    nothing = "move a set, or let it be safe earlier or longer"
    return f"{reason}: {what}; " + (f"a way opens at, for example, {', or at '.join(opens)}" if opens else nothing)


def _least(arena: Arena) -> tuple[Array, Array]:
    """The centre of gamma(0), and the least width."""
    box = starting_box(arena)
    return (box[0] + box[1]) / 2, np.full(arena.dimension, arena.min_width)


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
    """Less doubt about the clock, less growth, more time: what alone opens a way, near the value at which it does."""
    if task.start_delay:
        most = _shorter(task.start_delay, lambda v: _opens(task, {"start_delay": v}, way))
        yield from () if most is None else (f"start_delay = {decimal(most)}",)
    for name in ("timing", "spread"):
        sets = [s.name for s in task.as_stated.unsafe if getattr(s, name)]
        if sets:

            def less(share: Fraction, name: str = name) -> dict[str, object]:
                pairs = ((s, getattr(s, name)) for s in task.as_stated.unsafe)
                return {"unsafe": tuple(s.model_copy(update={name: share * v}) if v else s for s, v in pairs)}

            share = _shorter(Fraction(1), lambda v, less=less: _opens(task, less(v), way))  # type: ignore[misc]
            if share is not None:
                values = sorted({share * getattr(s, name) for s in task.unsafe if getattr(s, name)})
                numbers = " and ".join(decimal(v) for v in values)
                yield f"{name} = {numbers} of {' and '.join(sets)}"
    for factor in LONGER:
        if _opens(task, {"prescribed_time": factor * task.prescribed_time}, way):
            before = max([Fraction(1), *(f for f in LONGER if f < factor)])
            best = factor
            for part in (Fraction(1, 8), Fraction(1, 4), Fraction(1, 2)):
                trial = before + part * (factor - before)
                if _opens(task, {"prescribed_time": trial * task.prescribed_time}, way):
                    best = trial
                    break
            yield f"prescribed_time = {decimal(best * task.prescribed_time)}"
            return


def _shorter(given: Fraction, opens: Callable[[Fraction], bool]) -> Fraction | None:
    """A share of what is given, as large as few tries find, with which there is a way; None where there is none without it."""
    return next((v for part in (7, 6, 5, 4, 3, 2, 1, 0) if opens(v := given * Fraction(part, 8))), None)


def _opens(task: Task, change: dict[str, object], way: Callable[[Arena], bool]) -> bool:
    with suppress(BadInput, NotCertified):
        trial = task.changed(**change)
        lattice = lattice_of(trial)
        return way(normalised(arena_of(trial, lattice), lattice.exponent))
    return False


def _closes(arena: Arena, obstacle: TimedObstacle, searched: Sequence[Field]) -> str | None:
    """A set without which there would be a way, and when it is in the way; None for another."""
    for one in searched:
        alone = np.ones_like(one.free)
        one.cells.block(alone, obstacle)
        if alone.all():
            continue
        others = one.cells.free(arena)
        for other in arena.timed_obstacles:
            if other is not obstacle:
                one.cells.block(others, other)
        others[0][one.first] = True
        if not replace(one, free=others).leads():
            continue
        count = len(one.free)

        def safe(begin: int, end: int, one: Field = one, others: npt.NDArray[np.bool_] = others) -> bool:
            """Whether a way leads where the set is safe in these segments."""
            return replace(one, free=np.concatenate([one.free[:begin], others[begin:end], one.free[end:]])).leads()

        begin = bisect_left(range(count), True, key=lambda v: not safe(v, count)) - 1
        end = bisect_left(range(begin + 1, count), True, key=lambda v: safe(begin, v)) + begin + 1
        first, last = (f"{v / count * arena.time_unit:.3g}" for v in (begin, end))
        return f"{obstacle.name} (a way would open if it were safe from {first} s to {last} s)"
    return None


def _border(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """The last place, from a good one towards another, at which it holds."""
    for _ in range(NARROWING):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def _how_far(arena: Arena, searched: Sequence[Field]) -> str:
    """Where no set alone closes the way: until when any place is left to be at."""
    last = 0.0
    for one in searched:
        alive = [bool(here.any()) for here in one.reached()]
        last = max([last, *(k / len(one.free) for k, (a, b) in enumerate(pairwise([*alive, False])) if a and not b)])
    if last < 1:
        return f"the search reached no free place after {last * arena.time_unit:.3g} s"
    return "no moving set alone closes it"
