"""What is told of a mission for which no tube is found: which entry, left out, opens a plan, and which time, made longer, does.
All that is named was tried."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.decimals import above, below, decimal
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.mission_search import MissionSearch, search_of
from stt_codegen.design.missions import Mission, Places, clash, mission_of
from stt_codegen.design.spline_tubes import Search, segments_tried
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import MissionEntry, regions_of

HALVINGS = 4  # to find a time that would do
IsFound = Callable[[Task], bool]
Told = Callable[[Fraction], Fraction | tuple[Fraction, Fraction]]


def why_unmet(task: Task, arena: Arena, is_found: IsFound) -> str:
    """One sentence."""
    mission = mission_of(task, arena)
    assert mission is not None
    start, refusal = starting_box(arena), f"{Property.MISSION.label}: no tube was found"
    search = search_of(arena, start, segments_tried(task, arena), mission)
    places = Places(
        arena=arena, mission=Mission((), mission.states), start=start, width=search.width(0.0)
    )  # whatever else is asked at all times
    width = f"a tube of width {decimal(task.tube.min_width)}"
    always = [{h.state for h in one.holds} for one in mission.all_skeletons]
    for state, at in places.allowed.items() if len(places.nodes) else ():
        needed = any(not one.is_negated for one in regions_of(state.inner)) and all(state in held for held in always)
        if needed and not at.any() and mission.states[state].pieces:
            refusal = f"{Property.MISSION.label}: no place was found in {state} for {width}, off the unsafe sets"
            return f"{refusal}; widen or move it, or lower tube.min_width"
    if not mission.skeletons:
        refusal = f"{Property.MISSION.label}: no times were found that satisfy all entries at once"
    elif isinstance(search, MissionSearch) and not search.leads():
        order = "no order of the visits was found whose ways lead between the unsafe sets in time"
        refusal = f"{Property.MISSION.label}: {order}, for {width}"
    refusal += _clash(arena, mission, search)
    opens = [f"mission[{k}] ({task.mission[k].title()})" for k in range(len(task.mission)) if _without(task, k, is_found)]
    longer = list(times_that_do(task, is_found))
    would = [*(f"without {one}" for one in opens), *(f"with {one}" for one in longer)]
    if would:
        return f"{refusal}; {', or '.join(would)} one is found"
    alone = len(task.mission) == 1 and task.target_set is None  # without its entry nothing would be asked
    none = "" if alone else ", and none without one of its entries"
    return f"{refusal}{none}; widen regions or windows, or lower tube.min_width or tube.clearance"


def _clash(arena: Arena, mission: Mission, search: Search) -> str:
    """What is in conflict in time, as a part of a sentence; empty where nothing is found."""
    places = Places(arena=arena, mission=mission, start=search.start, width=search.width(0.0))
    found = clash(arena, places, mission) if len(places.nodes) else None
    return "" if found is None else f"; {found}"


def why_late(task: Task, arena: Arena) -> str:
    """The same for a mission that a bound on speed leaves no time for."""
    mission = mission_of(task, arena)
    if mission is None or not np.isfinite(arena.max_speed):
        return ""
    return _clash(arena, mission, search_of(arena, starting_box(arena), segments_tried(task, arena), mission))


def _without(task: Task, k: int, is_found: IsFound) -> bool:
    """Whether there is a tube for the task without an entry."""
    rest = [_given(entry) for j, entry in enumerate(task.mission) if j != k]
    if not rest:
        return task.target_set is not None and is_found(task.changed(mission=None, region=None))
    return is_found(task.changed(mission=rest))


def _given(entry: MissionEntry) -> dict[str, Any]:
    return {name: getattr(entry, name) for name in entry.model_fields_set}


def times_that_do(task: Task, is_found: IsFound) -> Iterator[str]:
    """Times that do alone, as far as `is_found` looks, each near the one that is: windows that end later or begin earlier, a
    shorter stay, longer rounds."""
    for k, entry in enumerate(task.mission):
        for name, given, most, told in _times(entry, task.prescribed_time):

            def changed(to: Fraction, k: int = k, name: str = name, told: Told = told) -> Task:
                entries = [_given(e) | ({name: told(to)} if j == k else {}) for j, e in enumerate(task.mission)]
                return task.changed(mission=entries)

            bad, good, rounded = given, most, above if most > given else below
            if good == bad or not is_found(changed(good)):
                continue
            for _ in range(HALVINGS):
                middle = Fraction(str(rounded((bad + good) / 2, 3)))
                if not min(bad, good) < middle < max(bad, good):
                    break
                bad, good = (bad, middle) if is_found(changed(middle)) else (middle, good)
            value = told(good)
            shown = f"[{', '.join(map(decimal, value))}]" if isinstance(value, tuple) else decimal(value)
            yield f"mission[{k}].{name} = {shown}"


def _times(entry: MissionEntry, t_c: Fraction) -> Iterator[tuple[str, Fraction, Fraction, Told]]:
    """The times of an entry that might give way: the field, its value, the one that asks for least, and the field for a value."""

    def plain(value: Fraction) -> Fraction:
        return value

    if entry.between is not None:
        first, last = entry.between
        yield "between", last, max(last, t_c - (entry.stay or 0)), lambda v: (first, v)
        yield "between", first, Fraction(0), lambda v: (v, last)
    if entry.stay:
        yield "stay", entry.stay, Fraction(0), plain
    if entry.within is not None:
        yield "within", entry.within, max(entry.within, t_c), plain
    if entry.every is not None:
        yield "every", entry.every, max(entry.every, entry.until or t_c), plain
