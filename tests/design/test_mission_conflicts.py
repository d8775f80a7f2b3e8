"""What is told of a mission that has no time: the bounds in conflict, and times that would do."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.suites.scenarios import moving_mission
from stt_codegen.design.arena import starting_box
from stt_codegen.design.mission_search import MissionSearch, search_of
from stt_codegen.design.missions.conflicts import TimeArc, negative_cycle
from stt_codegen.design.missions.orders import Stop
from stt_codegen.design.missions.plans import Plan, choose_knots
from stt_codegen.design.missions.skeleton import END, START, Skeleton, TimeBound, tightest_bounds
from stt_codegen.design.missions.spacetime_plans import route_with_events
from stt_codegen.design.missions.state_constraints import mission_of
from stt_codegen.design.refine import _normalised_arena
from stt_codegen.design.spacetime.search import USUAL_PACE
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import design_tube
from stt_codegen.task.load import parse_task

TASK = """
name = "late"
prescribed_time = 24
initial_state = [0.5, 0.5]
state_space = { lower = [0, 0], upper = [8, 6] }
initial_set = { lower = [0.1, 0.1], upper = [0.9, 0.9] }
unsafe = [{ name = "shelf", lower = [3, 1], upper = [4, 4] }]
region = [
  { name = "dock", lower = [1, 4.5], upper = [2.2, 5.7] },
  { name = "left", lower = [6.5, 0.3], upper = [7.5, 1.3] },
]
"""
SLOW = 'mission = [\n  { visit = "dock", between = [4, 9], stay = 6, then = "left", within = 5 },\n  { visit = "left", between = [0, 14] },\n]\n[tube]\nmax_speed = 1.0\n'
TWICE = 'mission = [\n  { visit = "dock", between = [9, 9], stay = 6 },\n  { visit = "left", between = [10, 14] },\n]\n'
ROUND = 'repeat = true\nmission = [{ patrol = ["dock", "left"], every = 6 }]\n[tube]\nmax_speed = 1.5\n'


def refused(text: str) -> str:
    with pytest.raises(NotCertified) as error:
        design_tube(parse_task(text))
    return str(error.value)


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4), st.integers(-3, 3), st.integers(-3, 6)), max_size=8))
@settings(max_examples=200, deadline=None)
def test_a_cycle_is_found_exactly_where_no_times_satisfy_the_bounds(drawn: list[tuple[int, int, int, int]]) -> None:
    """It closes, its bounds add to less than 0, and the closure of all bounds says so too."""
    bounds = [TimeBound(a, b, low / 8, max(low, high) / 8) for a, b, low, high in drawn if a != b]
    arcs = [TimeArc(d.first, d.last, d.maximum, "at most", False) for d in bounds]
    arcs += [TimeArc(d.last, d.first, -d.minimum, "at least", True) for d in bounds]
    arcs += [TimeArc(k, START, 0.0, "after the start", False) for k in range(5)] + [
        TimeArc(END, k, 0.0, "by t_c", False) for k in range(5)
    ]
    cycle = negative_cycle(5, arcs)
    zone = tightest_bounds(5, tuple(bounds))
    assert bool(cycle) == (zone is None)
    if cycle:
        assert sum(arc.bound for arc in cycle) < 0
        heads, tails = sorted(arc.last for arc in cycle), sorted(arc.first for arc in cycle)
        assert heads == tails


@pytest.mark.parametrize(
    "text", [TASK + SLOW, TASK + TWICE, ROUND.replace("mission", TASK + "mission", 1)], ids=["slow", "twice", "round"]
)
def test_every_time_that_is_named_does(text: str) -> None:
    """A refusal tells the bounds in conflict, and for each time that it names a tube is found when it is put in alone."""
    told = refused(text)
    assert re.search(r"the order of visits that comes nearest \(.*\) is at least [\d.e+-]+ s too long: ", told), told
    named = re.findall(r"mission\[(\d)\]\.(\w+) = (\[[^]]*\]|[\d.]+)", told)
    assert named, told
    for k, field, value in named:
        document = tomllib.loads(text)
        task = parse_task(text)
        entries: list[dict[str, Any]] = document["mission"]
        entries[int(k)][field] = tomllib.loads(f"v = {value}")["v"]
        design_tube(task.changed(mission=entries))  # raises where there is none


def test_the_lack_is_what_the_ways_take_more_than_the_window_leaves() -> None:
    """Start to dock, six seconds there, dock to left by 14 s, at 1 m/s: summed by hand from the places that are told."""
    told = refused(TASK + SLOW)
    lack = float(re.search(r"is at least ([\d.]+) s too long", told)[1])  # type: ignore[index]
    legs = [float(v) for v in re.findall(r"([\d.]+) s from", told)]
    assert len(legs) == 2
    assert lack == pytest.approx(sum(legs) + 6 - 14, abs=0.03)  # windows are moved in by 0.0005 t_c at either end
    assert np.isclose(legs[0], 4.0, atol=0.05)  # from (0.5, 0.5) to the lower edge of the dock, less half the least width


def test_times_are_shared_for_speed_or_for_acceleration() -> None:
    """Two legs of lengths 1 and 9: at one speed they take times as 1 to 9; at one acceleration, from rest to rest, as 1 to 3."""
    skeleton, event = Skeleton().with_event(START, 0.0, np.inf)
    far = np.array([[1.0, 0.0]]), np.array([[10.0, 0.0]])
    plan = Plan(skeleton, np.zeros(2), (Stop(event, far[0]), Stop(END, far[1])), (1.0, 9.0), 10.0)
    assert choose_knots(plan, 40, 0) == [0, 4, 40]
    assert choose_knots(plan, 40, 0, from_rest=True) == [0, 10, 40]


def test_a_way_among_sets_that_move_has_its_events_in_order_place_and_time() -> None:
    """Whole cells from one time to the next, no more of them than the pace; every event in its window, where its state holds."""
    assert sum(map(judged_way, range(6))) >= 3


def judged_way(seed: int) -> bool:
    """Whether a way is found for a random mission; then all that must hold of it does."""
    task = parse_task(moving_mission(seed, 2, 8))
    arena = _normalised_arena(task)
    mission = mission_of(task, arena)
    search = search_of(arena, starting_box(arena), (64,), mission)
    assert isinstance(search, MissionSearch)
    assert mission is not None
    plan, width = search.plans_for(0.0)[0], search.width(0.0)
    found = route_with_events(arena, mission, plan, centre=search.centre, width=width, segments=64)
    if found is None:
        return False
    knots, way = found
    assert knots == sorted(knots)
    assert (knots[0], knots[-1]) == (0, 64)
    cell = (arena.space[1] - arena.space[0] - width) / 100
    assert (np.abs(np.diff(way[1:], axis=0)) <= (USUAL_PACE + 1e-6) * cell).all()
    at = {START: 0, **{stop.event: knot for stop, knot in zip(plan.stops, knots[1:], strict=True)}}
    for d in plan.skeleton.time_bounds:
        assert d.minimum * 64 - 1e-6 <= at[d.last] - at[d.first] <= d.maximum * 64 + 1e-6
    for hold in plan.skeleton.holds:
        for k in range(max(at[hold.first], 1), at[hold.last] + 1):
            assert mission.states[hold.state].holds_about(way[k : k + 1], width / 2, arena.clearance + width / 2).all()
    return True
