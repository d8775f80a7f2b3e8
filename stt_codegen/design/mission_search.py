"""The search for a tube that carries out a mission: an order of its events and a path, their times, then the tube.

    skeletons -> order and path (missions/orders.py) -> times of the events, at the smallest speed (a linear program)
              -> knots of the spline -> what each state requires between the knots, as sets that move
              -> the slowest tube (spline_tubes/slowest_tube.py)

Times are chosen before the tube, so a tube may exist although none is found; a tube that is found is certified later. refine.py
and the refusals call `search_of`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions import (
    MOMENT,
    START,
    TIME_MARGIN_SPEED,
    TOLERANCE,
    Mission,
    OrderSearch,
    Plan,
    Skeleton,
    Waypoints,
    centre_along,
    choose_knots,
    mission_obstacles,
    plan_of_stops,
    route_with_events,
    slowest_plan,
)
from stt_codegen.design.moving_search import TimedSearch
from stt_codegen.design.routes import bounds_along_timed_route
from stt_codegen.design.spacetime import find_timed_route
from stt_codegen.design.spline_tubes import SEGMENT_TRIALS, SplineTube, TubeSearch, slowest_tube

WIDTH_SHARES = (1.0, 0.6, 0.3)  # of the narrower of start and target: the widths that are tried before the minimum width
PLAN_LIMIT = 4  # plans that are made a tube
CLOSE_TO_PLAN = 1.3  # a tube at most so many times as fast as its plan is slow enough to try no other
STANDING_SHARE = 0.1  # of t_c, for which the tube may wait at all states together that must hold at one moment
AROUND = (1, 1 / 4, 1 / 8, 1 / 16, MOMENT)  # segments, for which a state that must hold at one moment holds to either side of it
UNHURRIED_SPEED = 1.15  # times its length in t_c is a speed that more events would hardly lower
MINIMUM_SEGMENTS = (0, 1, 2, 4)  # that every leg gets, in this order


@dataclass(frozen=True)
class Timing:
    """The knots of a plan's events, the start's first, and the route of the centre (K + 1, n) where one is known.

    minimum_segments, from_rest: with which choose_knots chose them.
    """

    knots: list[int]
    route: Array | None = None
    minimum_segments: int = 0
    from_rest: bool = False


class _Candidate(NamedTuple):
    """A tube, and the plan and the timing that it carries out."""

    plan: Plan
    timing: Timing
    tube: SplineTube


@dataclass(frozen=True)
class MissionSearch(TimedSearch):
    """A search whose arena has a mission. It keeps the plans for each width share, and the speed bound of each skeleton."""

    _plans: dict[float, list[Plan]] = field(default_factory=dict)
    _speed_bounds: dict[Skeleton, float] = field(default_factory=dict)

    @property
    def shortest_distance(self) -> float:
        """Return the speed of the plan for the minimum width: no tube is known to be slower.

        The events are in the order of a wider tube's plan, where there is one.
        """
        wider = next((plans[0] for share, plans in self._plans.items() if share and plans), None)
        if wider is None or 0.0 in self._plans:
            plans = self.plans_for(0.0)
            return plans[0].speed if plans else np.inf
        if wider.skeleton not in self._speed_bounds:
            waypoints = self._waypoints_for(0.0)
            order = OrderSearch(waypoints, wider.skeleton, (START, *(stop.event for stop in wider.stops)))
            narrow = plan_of_stops(waypoints, wider.skeleton, order.shortest_stops(max(wider.speed, TOLERANCE)))
            self._speed_bounds[wider.skeleton] = wider.speed if narrow is None else min(wider.speed, narrow.speed)
        return self._speed_bounds[wider.skeleton]

    @property
    def width_shares(self) -> tuple[float, ...]:
        return self.wider_shares(WIDTH_SHARES)

    def has_route(self) -> bool:
        """Return whether some order of the events is in time for the minimum width."""
        return bool(self.plans_for(0.0))

    def _waypoints_for(self, share: float) -> Waypoints:
        assert self.mission is not None
        return Waypoints(arena=self.arena, mission=self.mission, start=self.start, width=self.width(share))

    def plans_for(self, share: float) -> list[Plan]:
        """Return the plans for a width share, the slowest first."""
        if share not in self._plans:
            assert self.mission is not None
            waypoints = self._waypoints_for(share)
            waypoints.labels_left = self.mission.label_limit
            plans: list[Plan] = []
            for skeleton in self.mission.all_skeletons:
                if _has_shorter_plan(skeleton, plans):
                    continue
                if waypoints.labels_left <= 0 or self._needs_no_more_plans(skeleton, plans):
                    break
                best_speed = min((plan.speed for plan in plans), default=np.inf)
                plan = slowest_plan(self.arena, waypoints, skeleton, best_speed)
                plans += [] if plan is None else [plan]
            self._plans[share] = sorted(plans, key=lambda plan: plan.speed)
        return self._plans[share]

    def _needs_no_more_plans(self, skeleton: Skeleton, plans: list[Plan]) -> bool:
        """Return whether the next skeleton is a fallback that is not needed, or has more events than an unhurried plan."""
        assert self.mission is not None
        if not plans:
            return False
        if skeleton in self.mission.fallbacks:
            return True
        has_more_events = skeleton.event_count > max(plan.skeleton.event_count for plan in plans)
        return has_more_events and any(plan.speed <= UNHURRIED_SPEED * float(np.cumsum(plan.lengths)[-1]) for plan in plans)

    def design_width(self, share: float) -> SplineTube | None:
        """Return the slowest tube whose width is this share, among the first plans; None where none is found."""
        width = self.width(share)
        best: _Candidate | None = None
        for candidate in self._candidates(self.plans_for(share)[:PLAN_LIMIT], width, share):
            best = candidate if best is None or candidate.tube.speed < best.tube.speed else best
        return None if best is None else self._with_time_margin(best, width)

    def _candidates(self, plans: list[Plan], width: Array, share: float) -> Iterator[_Candidate]:
        """Yield tubes for plans, until one is so slow that there is no need to try others."""
        slowest = np.inf
        for plan in plans:
            if self.arena.order == 1 and plan.speed > self.arena.max_speed:
                continue
            count_limit = SEGMENT_TRIALS if slowest < np.inf else len(self.segment_counts)
            for segments in self.segment_counts[: 1 if self.arena.timed_obstacles and share else count_limit]:
                for number, timing in enumerate(self.timings(plan, segments, width)):
                    tube = self._design_timing(plan, timing, segments, width)
                    if tube is None:
                        continue
                    yield _Candidate(plan, timing, tube)
                    slowest = min(slowest, tube.speed)
                    is_close = slowest <= CLOSE_TO_PLAN * plan.speed
                    is_second_try = self.arena.order == 2 and number > 0
                    # where sets move the speed of a plan says nothing, for a plan ignores them
                    if is_close or is_second_try or self.arena.timed_obstacles:
                        return

    def generate_other_plans(self) -> Iterator[SplineTube]:
        """Yield a tube for each plan, without margins in time: other orders and times of the events, the widest first."""
        segments = self.segment_counts[0]
        for share in (*self.width_shares, 0.0):
            width = self.width(share)
            for plan in self.plans_for(share)[:PLAN_LIMIT]:
                tubes = (self._design_timing(plan, timing, segments, width) for timing in self.timings(plan, segments, width))
                yield from itertools.islice((tube for tube in tubes if tube is not None), 1)

    def _design_timing(self, plan: Plan, timing: Timing, segments: int, width: Array) -> SplineTube | None:
        """Return a tube whose events are at these knots; None where none is found within the bounds on speed."""
        tube = self.design_plan(plan, timing, segments, width)
        return None if tube is None or (self.arena.order == 1 and tube.speed > self.peak_speed_limit(segments)) else tube

    def _with_time_margin(self, candidate: _Candidate, width: Array) -> SplineTube:
        """Return a tube of the same plan with as large a margin in time as costs little speed.

        Its events are nearer to the middles of their windows, and states that must hold at one moment hold for longer.
        """
        assert self.mission is not None
        plan, timing, tube = candidate
        segments = tube.segments
        moments = sum(hold.is_momentary for hold in plan.skeleton.holds)
        longest = max(int(STANDING_SHARE * segments / (2 * max(moments, 1))), 1)
        delayed = math.ceil(self.mission.start_delay * segments)
        for around in dict.fromkeys(max(around, delayed) for around in (longest, *AROUND)):
            timings = [Timing(timing.knots, tube.centre_route)] if around != MOMENT else []
            knots = choose_knots(plan, segments, timing.minimum_segments, from_rest=timing.from_rest, around=around)
            if knots is not None and knots != timing.knots and not self.arena.timed_obstacles:
                timings.insert(0, Timing(knots))
            for trial in timings:
                safer = self.design_plan(plan, trial, segments, width, around=around)
                if safer is not None and safer.speed <= min(TIME_MARGIN_SPEED * tube.speed, self.peak_speed_limit(segments)):
                    return safer
        return tube

    def timings(self, plan: Plan, segments: int, width: Array) -> Iterator[Timing]:
        """Yield timings to try, without repetition, with more and more time for every leg.

        Where accelerations count the first timing is that of the smallest acceleration, as if every leg began and ended at rest.
        Where sets move the last timing is that of a route in space and time, with the route.
        """
        tried: set[tuple[int, ...]] = set()
        resting = [(0, True)] if self.arena.order == 2 or self.arena.max_acceleration is not None else []
        minimum_segments = MINIMUM_SEGMENTS[:1] if self.arena.timed_obstacles else MINIMUM_SEGMENTS
        for minimum, from_rest in (*resting, *((minimum, False) for minimum in minimum_segments)):
            knots = choose_knots(plan, segments, minimum, from_rest=from_rest)
            if knots is not None and tuple(knots) not in tried:
                tried.add(tuple(knots))
                yield Timing(knots, None, minimum, from_rest)
        if self.arena.timed_obstacles:
            assert self.mission is not None
            route = route_with_events(self.arena, self.mission, plan, centre=self.centre, width=width, segments=segments)
            if route is not None:
                yield Timing(route.knots, route.centre)

    def design_plan(
        self, plan: Plan, timing: Timing, segments: int, width: Array, *, around: float = MOMENT
    ) -> SplineTube | None:
        """Return the slowest tube whose events are at these knots; None where none is found.

        around: for how many segments to either side of it a state must hold that must hold at one moment.
        """
        assert self.mission is not None
        obstacles = mission_obstacles(self.arena, self.mission, plan, timing.knots, segments=segments, around=around)
        seam = None if plan.skeleton.seam is None else round(plan.skeleton.seam * segments)
        arena = replace(self.arena, timed_obstacles=(*self.arena.timed_obstacles, *obstacles), seam=seam)
        route = timing.route
        if route is None and self.arena.timed_obstacles:  # a plan ignores sets that move
            is_wide = bool((width > self.width(0.0)).any())  # the coarsest cells are enough for a wide tube
            route = find_timed_route(arena, self.centre, width, segments, is_wide)
            if route is None:
                return None
        if route is None:
            route = centre_along(plan, timing.knots, segments)
        bounds = bounds_along_timed_route(arena, self.start, route, width)
        tube = slowest_tube(arena, self.start, bounds, width, route_length=plan.speed, solver_cache=self.solver_cache)
        return None if tube is None else replace(tube, mission_obstacles=obstacles, centre_route=route)


def _has_shorter_plan(skeleton: Skeleton, plans: list[Plan]) -> bool:
    """Return whether a plan with the same seam has fewer events than the skeleton."""
    return skeleton.seam is not None and any(
        plan.skeleton.seam == skeleton.seam and plan.skeleton.event_count < skeleton.event_count for plan in plans
    )


def search_of(arena: Arena, start: Array, segment_counts: tuple[int, ...], mission: Mission | None = None) -> TubeSearch:
    """Return the search for an arena, and a mission in it."""
    kind = MissionSearch if mission is not None else TimedSearch if arena.timed_obstacles else TubeSearch
    return kind(arena, start, segment_counts, mission=mission)


def without_solver_cache(search: TubeSearch) -> TubeSearch:
    """Return the same search without anything that it has solved before."""
    return search_of(search.arena, search.start, search.segment_counts, search.mission)
