"""What is told of a mission for which no tube is found: which entry, left out, opens a plan, and which time, made longer, does.
All that is named was tried."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

from stt_codegen.decimals import above, decimal
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.asked import Mission, mission_of
from stt_codegen.design.places import Places
from stt_codegen.design.visits import MissionSearch, search_of
from stt_codegen.design.widest import segments_tried
from stt_codegen.task import Task
from stt_codegen.task.formula import regions_of
from stt_codegen.task.mission import Entry

HALVINGS = 4  # to find a time that would do
IsFound = Callable[[Task], bool]


def why_unmet(task: Task, arena: Arena, is_found: IsFound) -> str:
    """One sentence."""
    mission = mission_of(task, arena)
    assert mission is not None
    start, told = starting_box(arena), "P10 mission: no tube was found"
    search = search_of(arena, start, segments_tried(task, arena), mission)
    places = Places(arena, Mission((), mission.states), start, search.width(0.0))  # whatever else is asked at all times
    width = f"a tube of width {decimal(task.tube.min_width)}"
    always = [{h.state for h in one.holds} for one in mission.every]
    for state, at in places.allowed.items() if len(places.nodes) else ():
        needed = any(not one.kept for one in regions_of(state.inner)) and all(state in held for held in always)
        if needed and not at.any() and mission.states[state].pieces:
            told = f"P10 mission: no place was found in {state} for {width}, off the unsafe sets"
            return f"{told}; widen or move it, or lower tube.min_width"
    if not mission.skeletons:
        told = "P10 mission: no times were found that satisfy all entries at once"
    elif isinstance(search, MissionSearch) and not search.leads():
        told = f"P10 mission: no order of the visits was found whose ways lead between the unsafe sets in time, for {width}"
    opens = [f"mission[{k}] ({task.mission[k].title()})" for k in range(len(task.mission)) if _without(task, k, is_found)]
    longer = list(_longer(task, is_found))
    would = [*(f"without {one}" for one in opens), *(f"with {one}" for one in longer)]
    if would:
        return f"{told}; {', or '.join(would)} one is found"
    alone = len(task.mission) == 1 and task.target_set is None  # without its entry nothing would be asked
    none = "" if alone else ", and none without one of its entries"
    return f"{told}{none}; widen regions or windows, or lower tube.min_width or tube.clearance"


def _without(task: Task, k: int, is_found: IsFound) -> bool:
    """Whether there is a tube for the task without an entry."""
    rest = [_given(entry) for j, entry in enumerate(task.mission) if j != k]
    if not rest:
        return task.target_set is not None and is_found(task.changed(mission=None, region=None))
    return is_found(task.changed(mission=rest))


def _given(entry: Entry) -> dict[str, Any]:
    return {name: getattr(entry, name) for name in entry.model_fields_set}


def _longer(task: Task, is_found: IsFound) -> Iterator[str]:
    """Times that would do alone, each near the least one."""
    t_c = task.prescribed_time
    for k, entry in enumerate(task.mission):
        ends = {"between": entry.between[1] if entry.between else None, "within": entry.within, "every": entry.every}
        for name, end in ends.items():
            if end is None or end >= t_c:
                continue

            def changed(to: Fraction, k: int = k, entry: Entry = entry, name: str = name) -> Task:
                value = (entry.between[0], to) if name == "between" and entry.between else to
                entries = [_given(e) | ({name: value} if j == k else {}) for j, e in enumerate(task.mission)]
                return task.changed(mission=entries)

            low, high = end, min(t_c, entry.until or t_c)
            if high <= low or not is_found(changed(high)):
                continue
            for _ in range(HALVINGS):
                middle = Fraction(str(above((low + high) / 2, 3)))
                if not low < middle < high:
                    break
                low, high = (low, middle) if is_found(changed(middle)) else (middle, high)
            shown = f"[{decimal(entry.between[0])}, {decimal(high)}]" if name == "between" and entry.between else decimal(high)
            yield f"mission[{k}].{name} = {shown}"
