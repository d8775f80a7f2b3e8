"""The search for a tube that carries out a mission: an order of its events and a way, their times, then the tube.

    skeletons -> order and way (orders.py) -> times of the events, at the least speed (a linear program) -> knots of the spline
              -> what each state asks, from knot to knot, like sets that move -> the slowest tube (shape.py)

Times are chosen before the tube, so a share that is not found may be there all the same; what is found is certified.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions import (
    START,
    TINY,
    Mission,
    Order,
    Places,
    Plan,
    Skeleton,
    centre_of,
    demands_of,
    knots_of,
    plan_of,
    timed_plan,
    way_with_events,
)
from stt_codegen.design.moving_search import TimedSearch
from stt_codegen.design.routes import limits_in_time
from stt_codegen.design.spacetime import way_in_time
from stt_codegen.design.spline_tubes import QUICK, Search, Shape, slowest_shape

SHARES = (1.0, 0.6, 0.3)  # of the narrower of start and target, before the least width
ORDERS = 4  # skeletons whose way is made a tube
CLOSE_TO_PLAN = 1.3  # times the speed of its plan a tube is slow enough to try no others
DEAR = 1.03  # times the speed is not too much for visits that last
UNHURRIED = 1.15  # times its way in t_c is a speed that more events would hardly lower
CALM = (0, 1, 2, 4)  # segments that every leg gets at least


@dataclass(frozen=True)
class MissionSearch(TimedSearch):
    """A search whose arena has a mission."""

    plans: dict[float, list[Plan]] = field(default_factory=dict)
    bounds: dict[Skeleton, float] = field(default_factory=dict)

    @property
    def straight(self) -> float:
        """What the least width takes, in the order of events that a wider tube has where there is one: no tube is known to be
        slower."""
        wider = next((found[0] for share, found in self.plans.items() if share and found), None)
        if wider is None or 0.0 in self.plans:
            plans = self.planned(0.0)
            return plans[0].speed if plans else np.inf
        if wider.skeleton not in self.bounds:
            assert self.mission is not None
            places = Places(arena=self.arena, mission=self.mission, start=self.start, width=self.width(0.0))
            order = Order(places, wider.skeleton, (START, *(stop.event for stop in wider.stops)))
            least = timed_plan(places, wider.skeleton, order.shortest(max(wider.speed, TINY)))
            self.bounds[wider.skeleton] = wider.speed if least is None else min(wider.speed, least.speed)
        return self.bounds[wider.skeleton]

    @property
    def shares(self) -> tuple[float, ...]:
        least = self.width(0.0)
        return tuple(share for share in SHARES if (self.width(share) > least).any())

    def leads(self) -> bool:
        return bool(self.planned(0.0))

    def planned(self, share: float) -> list[Plan]:
        """The plans for a width, the slowest first."""
        if share not in self.plans:
            assert self.mission is not None
            places = Places(
                arena=self.arena, mission=self.mission, start=self.start, width=self.width(share), left=self.mission.effort
            )
            found: list[Plan] = []
            for skeleton in self.mission.all_skeletons:
                if skeleton.seam is not None and any(
                    plan.skeleton.seam == skeleton.seam and plan.skeleton.events < skeleton.events for plan in found
                ):
                    continue
                if (found and skeleton in self.mission.others) or places.left <= 0:
                    break
                most = max((plan.skeleton.events for plan in found), default=skeleton.events)
                if skeleton.events > most and any(plan.speed <= UNHURRIED * float(np.cumsum(plan.lengths)[-1]) for plan in found):
                    break
                plan = plan_of(self.arena, places, skeleton, min((plan.speed for plan in found), default=np.inf))
                found += [] if plan is None else [plan]
            self.plans[share] = sorted(found, key=lambda plan: plan.speed)
        return self.plans[share]

    def of_share(self, share: float) -> Shape | None:
        width, most = self.width(share), self.arena.max_speed
        best: Shape | None = None
        for plan in self.planned(share)[:ORDERS]:
            if self.arena.order == 1 and plan.speed > most:
                continue
            few = 1 if self.arena.timed_obstacles and share else QUICK if best is not None else len(self.ladder)
            for segments in self.ladder[:few]:
                for number, (knots, way) in enumerate(self.timings(plan, segments, width)):
                    shape = self.within_plan(plan, knots, segments, width, way)
                    if shape is None or (self.arena.order == 1 and shape.speed > self.most(segments)):
                        continue
                    lasting = self.within_plan(plan, knots, segments, width, shape.way, True)
                    cheap = lasting is not None and lasting.speed <= min(DEAR * shape.speed, self.most(segments))
                    shape = lasting if cheap else shape
                    best = shape if best is None or (shape is not None and shape.speed < best.speed) else best
                    near = best is not None and best.speed <= CLOSE_TO_PLAN * plan.speed
                    enough = self.arena.order == 2 and number > 0
                    if near or enough or self.arena.timed_obstacles:  # a plan knows nothing of what moves
                        return best
        return best

    def timings(self, plan: Plan, segments: int, width: Array) -> Iterator[tuple[list[int], Array | None]]:
        """Knots to try, each once: with more and more time for every leg; where sets move then those of a way that is searched
        for in space and time, with it; where accelerations count first at the least of them, as if every leg began and ended
        at rest."""
        tried: set[tuple[int, ...]] = set()
        early = [(0, True)] if self.arena.order == 2 or self.arena.max_acceleration is not None else []
        later = [(calm, False) for calm in (CALM[:1] if self.arena.timed_obstacles else CALM)]
        for calm, at_rest in (*early, *later):
            knots = knots_of(plan, segments, calm, at_rest)
            if knots is not None and tuple(knots) not in tried:
                tried.add(tuple(knots))
                yield knots, None
        if self.arena.timed_obstacles:
            assert self.mission is not None
            found = way_with_events(self.arena, self.mission, plan, self.centre, width, segments)
            if found is not None:
                yield found

    def within_plan(
        self, plan: Plan, knots: list[int], segments: int, width: Array, way: Array | None = None, lasting: bool = False
    ) -> Shape | None:
        """The slowest tube whose events are at these knots. way: of the centre, where one is known; lasting: what is asked for a
        moment must hold for a segment to either side of it too."""
        assert self.mission is not None
        demands = demands_of(self.arena, self.mission, plan, knots, segments, lasting)
        seam = None if plan.skeleton.seam is None else round(plan.skeleton.seam * segments)
        arena = replace(self.arena, timed_obstacles=(*self.arena.timed_obstacles, *demands), seam=seam)
        if way is None and self.arena.timed_obstacles:  # the plan knows nothing of them
            wide = bool((width > self.width(0.0)).any())  # of a wide tube the first try is enough
            way = way_in_time(arena, self.centre, width, segments, wide)
            if way is None:
                return None
        if way is None:
            way = centre_of(plan, knots, segments)
        limits = limits_in_time(arena, self.start, way, width)
        shape = slowest_shape(arena, self.start, limits, width, plan.speed, self.solvers)
        return None if shape is None else replace(shape, demands=demands, way=way)

    def family(self) -> Iterator[Shape]:
        for share in (*self.shares, 0.0):
            shape = self.of_share(share)
            if shape is not None and self.keeps(shape):
                yield shape


def search_of(arena: Arena, start: Array, ladder: tuple[int, ...], mission: Mission | None = None) -> Search:
    """The search for an arena, and a mission in it."""
    kind = MissionSearch if mission is not None else TimedSearch if arena.timed_obstacles else Search
    return kind(arena, start, ladder, mission=mission)


def anew(search: Search) -> Search:
    """The same search, of which nothing is solved yet."""
    return search_of(search.arena, search.start, search.ladder, search.mission)
