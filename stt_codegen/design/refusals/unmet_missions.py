"""The message for a mission without a tube: which bounds are in conflict, which entry to leave out, and which time to change.

Everything that the message proposes was tried. advice.py calls this.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.decimals import above, below, decimal
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.mission_search import MissionSearch, search_of
from stt_codegen.design.missions import Mission, Waypoints, describe_conflict, mission_of
from stt_codegen.design.spline_tubes import TubeSearch, segment_counts_of
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import MissionEntry, StateFormula, regions_of

HALVINGS = 4  # to find a time that would do
HasTube = Callable[[Task], bool]  # whether a tube within its limits is found for a task
TimeValue = Fraction | tuple[Fraction, Fraction]


def explain_unmet_mission(task: Task, arena: Arena, has_tube: HasTube) -> str:
    """Return in one sentence why no tube carries out the mission, and what would do."""
    mission = mission_of(task, arena)
    assert mission is not None
    search = search_of(arena, starting_box(arena), segment_counts_of(task, arena), mission)
    width = f"a tube of width {decimal(task.tube.min_width)}"
    state = _unreachable_state(search, mission)
    if state is not None:
        problem = f"no place was found in {state} for {width} that is clear of the unsafe sets"
        return f"{Property.MISSION.label}: {problem}; widen or move it, or lower tube.min_width"
    problem = "no tube was found"
    if not mission.skeletons:
        problem = "no times were found that satisfy all entries at once"
    elif isinstance(search, MissionSearch) and not search.has_route():
        problem = f"no order of the visits was found whose routes between the unsafe sets are in time, for {width}"
    refusal = f"{Property.MISSION.label}: {problem}{_conflict(arena, mission, search)}"
    needless = [
        f"mission[{k}] ({task.mission[k].title()})" for k in range(len(task.mission)) if _has_tube_without(task, k, has_tube)
    ]
    remedies = [*(f"without {entry}" for entry in needless), *(f"with {time}" for time in sufficient_times(task, has_tube))]
    if remedies:
        return f"{refusal}; {', or '.join(remedies)} one is found"
    is_only_entry = len(task.mission) == 1 and task.target_set is None  # without it nothing would be left to do
    tried = "" if is_only_entry else ", and none without one of its entries"
    return f"{refusal}{tried}; widen regions or windows, or lower tube.min_width or tube.clearance"


def _unreachable_state(search: TubeSearch, mission: Mission) -> StateFormula | None:
    """Return a state that every skeleton needs, that is in a region, and that holds at no waypoint; None where there is none."""
    anytime = Mission((), mission.states)  # without skeletons, so that no permanent state excludes waypoints
    waypoints = Waypoints(arena=search.arena, mission=anytime, start=search.start, width=search.width(0.0))
    needed = [{hold.state for hold in skeleton.holds} for skeleton in mission.all_skeletons]
    for state, holds_at in waypoints.nodes_in_state.items() if len(waypoints.nodes) else ():
        is_visit = any(not region.is_negated for region in regions_of(state.inner))
        if is_visit and all(state in states for states in needed) and not holds_at.any() and mission.states[state].pieces:
            return state
    return None


def _conflict(arena: Arena, mission: Mission, search: TubeSearch) -> str:
    """Return which bounds on times are in conflict, as a part of a sentence; empty where no such conflict is found."""
    waypoints = Waypoints(arena=arena, mission=mission, start=search.start, width=search.width(0.0))
    conflict = describe_conflict(arena, waypoints, mission) if len(waypoints.nodes) else None
    return "" if conflict is None else f"; {conflict}"


def explain_conflict(task: Task, arena: Arena) -> str:
    """Return the conflict of a mission for which a bound on speed leaves no time, as a part of a sentence, or nothing."""
    mission = mission_of(task, arena)
    if mission is None or not np.isfinite(arena.max_speed):
        return ""
    return _conflict(arena, mission, search_of(arena, starting_box(arena), segment_counts_of(task, arena), mission))


def _has_tube_without(task: Task, k: int, has_tube: HasTube) -> bool:
    """Return whether there is a tube for the task without entry k of its mission."""
    entries = [_fields_of(entry) for j, entry in enumerate(task.mission) if j != k]
    if not entries:
        return task.target_set is not None and has_tube(task.changed(mission=None, region=None))
    return has_tube(task.changed(mission=entries))


def _fields_of(entry: MissionEntry) -> dict[str, Any]:
    """Return the fields of an entry that the task file sets."""
    return {name: getattr(entry, name) for name in entry.model_fields_set}


@dataclass(frozen=True)
class _AdjustableTime:
    """A time of a mission's entry that might change.

    field: its key. current: the number now. loosest: the number that demands least. to_value: the field's value for a number.
    """

    field: str
    current: Fraction
    loosest: Fraction
    to_value: Callable[[Fraction], TimeValue]

    def round(self, value: Fraction) -> Fraction:
        """Return a number rounded to three digits towards the loosest one."""
        return Fraction(str((above if self.loosest > self.current else below)(value, 3)))


def sufficient_times(task: Task, has_tube: HasTube) -> Iterator[str]:
    """Yield times that suffice when they alone change, each near the current one.

    Windows may end later or begin earlier, a stay may be shorter and a round longer.
    """
    for k, entry in enumerate(task.mission):
        for time in _adjustable_times(entry, task.prescribed_time):
            number = _nearest_sufficient(task, k, time, has_tube)
            if number is not None:
                value = time.to_value(number)
                text = f"[{', '.join(map(decimal, value))}]" if isinstance(value, tuple) else decimal(value)
                yield f"mission[{k}].{time.field} = {text}"


def _nearest_sufficient(task: Task, k: int, time: _AdjustableTime, has_tube: HasTube) -> Fraction | None:
    """Return a number for a time of entry k with which there is a tube, near the current one; None where there is none."""

    def suffices(number: Fraction) -> bool:
        change = {time.field: time.to_value(number)}
        return has_tube(task.changed(mission=[_fields_of(e) | (change if j == k else {}) for j, e in enumerate(task.mission)]))

    bad, good = time.current, time.loosest
    if good == bad or not suffices(good):
        return None
    for _ in range(HALVINGS):
        middle = time.round((bad + good) / 2)
        if not min(bad, good) < middle < max(bad, good):
            break
        bad, good = (bad, middle) if suffices(middle) else (middle, good)
    return good


def _adjustable_times(entry: MissionEntry, t_c: Fraction) -> Iterator[_AdjustableTime]:
    """Yield the times of an entry that might change."""

    def itself(value: Fraction) -> Fraction:
        return value

    if entry.between is not None:
        first, last = entry.between
        yield _AdjustableTime("between", last, max(last, t_c - (entry.stay or 0)), lambda v: (first, v))
        yield _AdjustableTime("between", first, Fraction(0), lambda v: (v, last))
    if entry.stay:
        yield _AdjustableTime("stay", entry.stay, Fraction(0), itself)
    if entry.within is not None:
        yield _AdjustableTime("within", entry.within, max(entry.within, t_c), itself)
    if entry.every is not None:
        yield _AdjustableTime("every", entry.every, max(entry.every, entry.until or t_c), itself)
