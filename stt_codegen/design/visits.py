"""The search for a tube that carries out a mission: an order of its events and a way, their times, then the tube.

    skeletons -> order and way (orders.py) -> times of the events, at the least speed (a linear program) -> knots of the spline
              -> what each state asks, from knot to knot, like sets that move -> the slowest tube (shape.py)

Times are chosen before the tube, so a share that is not found may be there all the same; what is found is certified.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.asked import Mission
from stt_codegen.design.faces import Array
from stt_codegen.design.movers import Mover
from stt_codegen.design.orders import Order, Stop
from stt_codegen.design.places import Places
from stt_codegen.design.shape import Shape, slowest_shape
from stt_codegen.design.sides import limits_in_time
from stt_codegen.design.skeleton import END, START, TINY, Skeleton
from stt_codegen.design.solver import LinearProgram
from stt_codegen.design.spacetime import way_in_time
from stt_codegen.design.timed import TimedSearch
from stt_codegen.design.widest import QUICK, Search

SHARES = (1.0, 0.6, 0.3)  # of the narrower of start and target, before the least width
FASTEST = (2.0, 8.0, 64.0)  # times the extent of space in t_c: the speeds at which an order is looked for
SLOWER = 0.9  # of the speed that an order needs another one is looked for,
TRIES = 6  # so often at most
ORDERS = 4  # skeletons whose way is made a tube
UNHURRIED = 1.5  # times its way in t_c is a speed that more events would hardly lower
CALM = (0, 1, 2, 4)  # segments that every leg gets at least
ROUNDED = 1e-9
HURRY = 0.5  # of the time that every leg has at an even pace is enough where events are to be early or late
AT_A_KNOT = 1 / 64  # of a segment: around a knot at which a state is asked for it must hold so long


@dataclass(frozen=True)
class Plan:
    """From where, and the stops in order; lengths: of the legs to them, as far as time goes; speed: the least at which all are in
    time, lengths per t_c."""

    skeleton: Skeleton
    origin: Array
    stops: tuple[Stop, ...]
    lengths: tuple[float, ...]
    speed: float


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
            places = Places(self.arena, self.mission, self.start, self.width(0.0))
            order = Order(places, wider.skeleton, (START, *(stop.event for stop in wider.stops)))
            least = _timed(places, wider.skeleton, order.shortest(wider.speed))
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
            places = Places(self.arena, self.mission, self.start, self.width(share))
            found: list[Plan] = []
            for skeleton in self.mission.skeletons:
                most = max((plan.skeleton.events for plan in found), default=skeleton.events)
                if skeleton.events > most and any(plan.speed <= UNHURRIED * sum(plan.lengths) for plan in found):
                    break
                plan = plan_of(self.arena, places, skeleton)
                found += [] if plan is None else [plan]
            self.plans[share] = sorted(found, key=lambda plan: plan.speed)
        return self.plans[share]

    def of_share(self, share: float) -> Shape | None:
        width, most = self.width(share), self.arena.max_speed
        for plan in self.planned(share)[:ORDERS]:
            if self.arena.order == 1 and plan.speed > most:
                continue
            for segments in self.ladder[:QUICK] if self.arena.movers and share else self.ladder:
                for knots in self.timings(plan, segments):
                    shape = self.within_plan(plan, knots, segments, width)
                    if shape is not None and (self.arena.order == 2 or shape.speed <= self.most(segments)):
                        return shape
        return None

    def timings(self, plan: Plan, segments: int) -> Iterator[list[int]]:
        """Knots to try, each once: with more and more time for every leg; where sets move with all events early or late too."""
        tried: set[tuple[int, ...]] = set()
        for calm, lean in ((0, 0), (0, 1), (0, -1), (2, 0)) if self.arena.movers else ((calm, 0) for calm in CALM):
            knots = knots_of(plan, segments, calm, lean)
            if knots is not None and tuple(knots) not in tried:
                tried.add(tuple(knots))
                yield knots

    def within_plan(self, plan: Plan, knots: list[int], segments: int, width: Array) -> Shape | None:
        """The slowest tube whose events are at these knots."""
        assert self.mission is not None
        demands = demands_of(self.arena, self.mission, plan, knots, segments)
        arena = replace(self.arena, movers=(*self.arena.movers, *demands))
        centre = centre_of(plan, knots, segments)
        if self.arena.movers:  # the plan knows nothing of them
            way = way_in_time(arena, self.centre, width, segments)
            if way is None:
                return None
            centre = way
        limits = limits_in_time(arena, self.start, centre, width)
        shape = slowest_shape(arena, self.start, limits, width, plan.speed, self.solvers)
        return None if shape is None else replace(shape, demands=demands)

    def family(self) -> Iterator[Shape]:
        for share in (*self.shares, 0.0):
            shape = self.of_share(share)
            if shape is not None and self.keeps(shape):
                yield shape


def plan_of(arena: Arena, places: Places, skeleton: Skeleton) -> Plan | None:
    """The way of a skeleton that needs the least speed, of those that are found; None where none is."""
    order = Order(places, skeleton)
    if np.isfinite(arena.max_speed):
        return _timed(places, skeleton, order.shortest(arena.max_speed))
    if not skeleton.timed:
        return _timed(places, skeleton, order.shortest(np.inf))
    extent = float((arena.space[1] - arena.space[0]).max())
    found = None
    for times in FASTEST:
        found = _timed(places, skeleton, order.shortest(times * extent))
        if found is not None:
            break
    for _ in range(TRIES if found else 0):
        assert found is not None
        other = _timed(places, skeleton, order.shortest(SLOWER * found.speed))
        if other is None or other.speed > 0.999 * found.speed:
            break
        found = other
    return found


def _timed(places: Places, skeleton: Skeleton, stops: list[Stop] | None) -> Plan | None:
    """With the least speed at which its legs are in time: scaled durations D = speed * duration make it one linear program."""
    if stops is None:
        return None
    origin, legs = places.nodes[0], len(stops)
    lengths = _lengths(places.arena, origin, stops)
    program = LinearProgram(legs + 1)
    program.cost[legs] = 1.0
    program.lower[:legs], program.lower[legs] = lengths, 0.0
    for columns, least, most in _windows(skeleton, stops):
        ones = np.ones(len(columns))
        row = [[*columns, legs]]
        if np.isfinite(least):
            program.rows(row, np.append(ones, -least), 0.0, np.inf)
        if np.isfinite(most):
            program.rows(row, np.append(ones, -most), -np.inf, 0.0)
    found = program.solve()
    if found is None:
        return None
    return Plan(skeleton, origin, tuple(stops), tuple(lengths), float(found[legs]))


def _lengths(arena: Arena, origin: Array, stops: list[Stop]) -> list[float]:
    """Of the legs."""
    found, here = [], origin
    for stop in stops:
        points = np.concatenate([here[None], stop.way])
        found.append(float(np.cumsum([0.0, *arena.distance(points[1:] - points[:-1])])[-1]))
        here = points[-1]
    return found


def _windows(skeleton: Skeleton, stops: list[Stop] | tuple[Stop, ...]) -> Iterator[tuple[list[int], float, float]]:
    """Every difference as the legs between its events, and what they take together."""
    place = {START: 0, **{stop.event: k + 1 for k, stop in enumerate(stops)}}
    for d in skeleton.differences:
        a, b, least, most = place[d.first], place[d.last], d.least, d.most
        if a > b:
            a, b, least, most = b, a, -most, -least
        if a < b:
            yield list(range(a, b)), least, most


def knots_of(plan: Plan, segments: int, calm: int, lean: int = 0) -> list[int] | None:
    """The knot of each stop, the start's first: times at the least speed rounded to whole segments within all windows, each leg
    that goes anywhere at least `calm` long; None where windows are too narrow for so few segments. lean: 1 for events as early
    as half of that pace allows, -1 for as late."""
    legs, lengths = len(plan.stops), plan.lengths
    windows = list(_windows(plan.skeleton, plan.stops))
    moving = [length > TINY for length in lengths]
    if calm * sum(moving) > segments:
        return None
    # times that leave every leg as much of its time as the slowest has: durations over lengths, the least of them largest
    program = LinearProgram(legs + 1)
    program.cost[legs] = -1.0
    program.lower[:legs], program.lower[legs] = [calm / segments if m else 0.0 for m in moving], 0.0
    for k, length in enumerate(lengths):
        if moving[k]:
            program.rows([[k, legs]], [1.0, -length], 0.0, np.inf)
    for columns, least, most in windows:
        program.rows([columns], np.ones(len(columns)), max(least, -np.inf), most)
    found = program.solve()
    if found is not None and lean:
        program.lower[legs] = found[legs] * HURRY
        program.cost[:legs], program.cost[legs] = lean * np.arange(legs, 0, -1.0), 0.0
        found = program.solve()
    if found is None:
        return None
    times = np.concatenate([[0.0], np.cumsum(found[:legs])]) * segments
    # whole numbers nearest to them under the same differences: a program whose vertices are whole
    count = legs + 1
    program, row = LinearProgram(3 * count), np.arange(count)
    program.cost[count:] = 1.0
    program.lower[:] = 0.0
    program.upper[:count] = segments
    program.upper[0], program.lower[legs] = 0.0, segments
    program.rows(np.stack([row, row + count, row + 2 * count], axis=1), [1.0, 1.0, -1.0], times, times)
    step = np.array([float(max(calm, 1)) if m else 0.0 for m in moving])
    program.rows(np.stack([row[1:], row[:-1]], axis=1), [1.0, -1.0], step, np.inf)
    for columns, least, most in windows:
        low = np.ceil(least * segments - ROUNDED) if np.isfinite(least) else -np.inf
        high = np.floor(most * segments + ROUNDED) if np.isfinite(most) else np.inf
        if low > high:
            return None
        program.rows([[columns[-1] + 1, columns[0]]], [1.0, -1.0], low, high)
    found = program.solve()
    return None if found is None else [int(v) for v in np.rint(found[:count])]


def centre_of(plan: Plan, knots: list[int], segments: int) -> Array:
    """Where the centre is at the end of each segment when every leg is gone at one speed: (segments + 1, n)."""
    here = plan.origin
    found = np.empty((segments + 1, len(here)))
    found[0] = here
    for stop, a, b in zip(plan.stops, knots[:-1], knots[1:], strict=True):
        points = np.concatenate([here[None], stop.way])
        steps = np.abs(np.diff(points, axis=0)).max(axis=1) if len(points) > 1 else np.zeros(0)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        for k in range(a + 1, b + 1):
            at = way[-1] * (k - a) / (b - a)
            q = min(int(np.searchsorted(way, at, side="right")) - 1, max(len(steps) - 1, 0))
            part = (at - way[q]) / steps[q] if len(steps) and steps[q] > 0 else 0.0
            found[k] = points[q] + (points[q + 1] - points[q]) * min(part, 1.0) if len(steps) else here
        here = points[-1]
        found[b] = here
    return found


def demands_of(arena: Arena, mission: Mission, plan: Plan, knots: list[int], segments: int) -> tuple[Mover, ...]:
    """What each state asks, where it is asked, as sets that are avoided."""
    when = {START: knots[0], **{stop.event: knot for stop, knot in zip(plan.stops, knots[1:], strict=True)}}
    demands: list[Mover] = []
    for number, hold in enumerate(plan.skeleton.holds):
        wanted: npt.NDArray[np.bool_] = np.zeros((segments, 4), dtype=bool)
        room = np.zeros((segments, 4))
        a, b = when[hold.first], when[hold.last]
        if hold.at_once:
            room_here = 2.0 * plan.speed / segments * AT_A_KNOT
            for k, c in ((a - 1, 3), (a, 0)):
                if 0 <= k < segments:
                    wanted[k, c], room[k, c] = True, room_here
        else:
            wanted[a : b + hold.longer] = True
        if hold.last == END:
            wanted[segments - 1, 3] = True
        demands += mission.states[hold.state].demands(arena, f"{number}", wanted, room)
    return tuple(demands)


def search_of(arena: Arena, start: Array, ladder: tuple[int, ...], mission: Mission | None = None) -> Search:
    """The search for an arena, and a mission in it."""
    kind = MissionSearch if mission is not None else TimedSearch if arena.movers else Search
    return kind(arena, start, ladder, mission=mission)


def anew(search: Search) -> Search:
    """The same search, of which nothing is solved yet."""
    return search_of(search.arena, search.start, search.ladder, search.mission)
