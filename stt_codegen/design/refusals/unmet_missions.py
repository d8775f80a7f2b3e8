"""The reason why a mission has no tube: a region that is out of reach, or bounds on times that are in conflict.

reasons.py calls this.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stt_codegen.decimals import by_component
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.mission_search import MissionSearch, search_of
from stt_codegen.design.missions import Mission, Waypoints, describe_conflict, mission_of
from stt_codegen.design.refusals.regions_at_once import excluded_regions, explain_early_visit
from stt_codegen.design.spline_tubes import TubeSearch, segment_counts_of
from stt_codegen.errors import Reason
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import StateFormula, regions_of

HasTube = Callable[[Task], bool]  # whether a tube within its limits is found for a task


def explain_unmet_mission(task: Task, arena: Arena) -> Reason:
    """Return why no tube carries out the mission."""
    if excluded := excluded_regions(task):
        problem, hint = excluded
        problem, entries = f"{Property.MISSION.label}: {problem}", tuple(f"mission[{k}]" for k in range(len(task.mission)))
        return Reason(problem, hint, codes=(Property.MISSION.code,), has_remedy=len(entries) > 1, about=entries)
    mission = mission_of(task, arena)
    assert mission is not None
    search = search_of(arena, starting_box(arena), segment_counts_of(task, arena), mission)
    width = f"a tube of width {by_component(task.min_widths)}"
    state = _unreachable_state(search, mission)
    if state is not None:
        problem = f"no place was found in {state} for {width} that is clear of the unsafe sets"
        return _reason(problem, "widen or move it, or lower tube.min_width")
    problem = "no tube was found"
    if not mission.skeletons:
        problem = "no times were found that satisfy all entries at once"
    elif early := explain_early_visit(task, segment_counts_of(task, arena)[-1]):
        return _reason(*early)
    elif isinstance(search, MissionSearch) and not search.has_route():
        problem = f"no order of the visits was found whose routes between the unsafe sets are in time, for {width}"
    hint = "widen regions or windows, or lower tube.min_width or tube.clearance"
    return _reason(f"{problem}{_conflict(arena, mission, search)}", hint)


def _reason(problem: str, hint: str) -> Reason:
    return Reason(f"{Property.MISSION.label}: {problem}", hint, codes=(Property.MISSION.code,))


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
