"""What a refusal says of a mission that needs more time than it has: the bounds in conflict, and times that work."""

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


def refusal_of(text: str) -> str:
    """Return the message with which the design refuses the task."""
    with pytest.raises(NotCertified) as error:
        design_tube(parse_task(text))
    return str(error.value)


@given(st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4), st.integers(-3, 3), st.integers(-3, 6)), max_size=8))
@settings(max_examples=200, deadline=None)
def test_a_negative_cycle_exists_exactly_where_no_times_satisfy_the_bounds(drawn: list[tuple[int, int, int, int]]) -> None:
    """The cycle closes, its bounds add to less than 0, and `tightest_bounds` has no result in the same cases."""
    bounds = [TimeBound(a, b, low / 8, max(low, high) / 8) for a, b, low, high in drawn if a != b]
    arcs = [TimeArc(bound.first, bound.last, bound.maximum, "at most", False) for bound in bounds]
    arcs += [TimeArc(bound.last, bound.first, -bound.minimum, "at least", True) for bound in bounds]
    arcs += [TimeArc(k, START, 0.0, "after the start", False) for k in range(5)] + [
        TimeArc(END, k, 0.0, "by t_c", False) for k in range(5)
    ]
    cycle = negative_cycle(5, arcs)
    closure = tightest_bounds(5, tuple(bounds))
    assert bool(cycle) == (closure is None)
    if cycle:
        assert sum(arc.bound for arc in cycle) < 0
        heads, tails = sorted(arc.last for arc in cycle), sorted(arc.first for arc in cycle)
        assert heads == tails


@pytest.mark.parametrize(
    "text", [TASK + SLOW, TASK + TWICE, ROUND.replace("mission", TASK + "mission", 1)], ids=["slow", "twice", "round"]
)
def test_every_time_that_a_refusal_names_works(text: str) -> None:
    """A refusal names the bounds in conflict; each time that it names, put into the task alone, makes a tube possible."""
    refusal = refusal_of(text)
    assert re.search(r"the order of visits that comes nearest \(.*\) is at least [\d.e+-]+ s too long: ", refusal), refusal
    advised = re.findall(r"mission\[(\d)\]\.(\w+) = (\[[^]]*\]|[\d.]+)", refusal)
    assert advised, refusal
    for k, field, value in advised:
        document = tomllib.loads(text)
        task = parse_task(text)
        entries: list[dict[str, Any]] = document["mission"]
        entries[int(k)][field] = tomllib.loads(f"v = {value}")["v"]
        design_tube(task.changed(mission=entries))  # raises NotCertified without a tube


def test_the_missing_time_is_that_of_the_legs_beyond_the_window() -> None:
    """From the start to the dock, six seconds there, then to left by 14 s, at 1 m/s: the test adds the times that the refusal names."""
    refusal = refusal_of(TASK + SLOW)
    missing_time = float(re.search(r"is at least ([\d.]+) s too long", refusal)[1])  # type: ignore[index]
    leg_times = [float(v) for v in re.findall(r"([\d.]+) s from", refusal)]
    assert len(leg_times) == 2
    assert missing_time == pytest.approx(sum(leg_times) + 6 - 14, abs=0.03)  # windows are shortened by 0.0005 t_c at both ends
    assert np.isclose(leg_times[0], 4.0, atol=0.05)  # from (0.5, 0.5) to the dock's lower edge, less half the smallest width


def test_legs_get_times_for_equal_speed_or_for_equal_acceleration() -> None:
    """Two legs have lengths 1 and 9. At the same speed their times are as 1 to 9; at the same acceleration, from rest to rest, as 1 to 3."""
    skeleton, event = Skeleton().with_event(START, 0.0, np.inf)
    positions = np.array([[1.0, 0.0]]), np.array([[10.0, 0.0]])
    plan = Plan(skeleton, np.zeros(2), (Stop(event, positions[0]), Stop(END, positions[1])), (1.0, 9.0), 10.0)
    assert choose_knots(plan, 40, 0) == [0, 4, 40]
    assert choose_knots(plan, 40, 0, from_rest=True) == [0, 10, 40]


def test_a_route_among_moving_sets_has_its_events_in_order_in_place_and_in_time() -> None:
    """Of six random missions at least three have a route; `has_valid_route` asserts what must hold of it."""
    assert sum(map(has_valid_route, range(6))) >= 3


def has_valid_route(seed: int) -> bool:
    """Return whether a random mission has a route, and assert its laws.

    From one time to the next it moves by at most the pace; every event is in its window, and a state holds while it must."""
    task = parse_task(moving_mission(seed, 2, 8))
    arena = _normalised_arena(task)
    mission = mission_of(task, arena)
    search = search_of(arena, starting_box(arena), (64,), mission)
    assert isinstance(search, MissionSearch)
    assert mission is not None
    plan, width = search.plans_for(0.0)[0], search.width(0.0)
    result = route_with_events(arena, mission, plan, centre=search.centre, width=width, segments=64)
    if result is None:
        return False
    knots, route = result
    assert knots == sorted(knots)
    assert (knots[0], knots[-1]) == (0, 64)
    cell = (arena.space[1] - arena.space[0] - width) / 100
    assert (np.abs(np.diff(route[1:], axis=0)) <= (USUAL_PACE + 1e-6) * cell).all()
    knot_of = {START: 0, **{stop.event: knot for stop, knot in zip(plan.stops, knots[1:], strict=True)}}
    for bound in plan.skeleton.time_bounds:
        assert bound.minimum * 64 - 1e-6 <= knot_of[bound.last] - knot_of[bound.first] <= bound.maximum * 64 + 1e-6
    for interval in plan.skeleton.holds:
        for k in range(max(knot_of[interval.first], 1), knot_of[interval.last] + 1):
            assert mission.states[interval.state].holds_about(route[k : k + 1], width / 2, arena.clearance + width / 2).all()
    return True
