"""When the events of a mission happen: the least speed at which a way is in time, the knots of a spline, and what every state
asks from knot to knot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import LinearProgram
from stt_codegen.design.missions.orders import Order, Stop
from stt_codegen.design.missions.skeleton import END, START, TINY, Skeleton
from stt_codegen.design.missions.state_constraints import Mission
from stt_codegen.design.missions.waypoints import Places
from stt_codegen.design.moving_half_spaces import TimedObstacle

FASTEST = (2.0, 8.0, 64.0)  # times the extent of space in t_c: the speeds at which an order is looked for
SLOWER = 0.9  # of the speed that an order needs another one is looked for,
TRIES = 6  # so often at most
ROUNDED = 1e-9
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


def plan_of(arena: Arena, places: Places, skeleton: Skeleton, below: float = np.inf) -> Plan | None:
    """The way of a skeleton that needs the least speed, of those that are found; None where none is, or none that is well below
    a speed."""
    order = Order(places, skeleton)
    if not places.nodes.size or below <= TINY:  # nowhere to be, or nothing to gain
        return None
    if np.isfinite(arena.max_speed):
        return timed_plan(places, skeleton, order.shortest(min(arena.max_speed, SLOWER * below)))
    if not skeleton.timed:
        return timed_plan(places, skeleton, order.shortest(np.inf))
    extent = float((arena.space[1] - arena.space[0]).max())
    found = None
    for speed in [SLOWER * below] if np.isfinite(below) else [times * extent for times in FASTEST]:
        found = timed_plan(places, skeleton, order.shortest(speed))
        if found is not None:
            break
    for _ in range(TRIES if found is not None and found.speed > TINY else 0):
        assert found is not None
        other = timed_plan(places, skeleton, order.shortest(SLOWER * found.speed))
        if other is None or other.speed > 0.999 * found.speed:
            break
        found = other
    return found


def timed_plan(places: Places, skeleton: Skeleton, stops: list[Stop] | None) -> Plan | None:
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


def knots_of(plan: Plan, segments: int, calm: int, bent: bool = False) -> list[int] | None:
    """The knot of each stop, the start's first: times at the least speed rounded to whole segments within all windows, each leg
    that goes anywhere at least `calm` long; None where windows are too narrow for so few segments. bent: at the least
    acceleration instead, for which a leg from rest to rest takes 2 sqrt(length / acceleration)."""
    legs, lengths = len(plan.stops), [math.sqrt(length) if bent else length for length in plan.lengths]
    windows = list(_windows(plan.skeleton, plan.stops))
    moving = [length > TINY for length in lengths]
    if calm * sum(moving) > segments:
        return None
    # times that leave every leg as much of its time as the slowest has: durations over lengths, the least of them largest
    program = LinearProgram(legs + 1)
    program.cost[legs] = -1.0
    program.lower[:legs], program.lower[legs] = [calm / segments if m else 0.0 for m in moving], 0.0
    program.upper[legs] = 1 / TINY  # where nothing moves
    for k, length in enumerate(lengths):
        if moving[k]:
            program.rows([[k, legs]], [1.0, -length], 0.0, np.inf)
    for columns, least, most in windows:
        program.rows([columns], np.ones(len(columns)), least, most)
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


def demands_of(
    arena: Arena, mission: Mission, plan: Plan, knots: list[int], segments: int, lasting: bool = False
) -> tuple[TimedObstacle, ...]:
    """What each state asks, where it is asked, as sets that are avoided. lasting: what is asked for a moment alone for a segment
    to either side of it."""
    when = {START: knots[0], **{stop.event: knot for stop, knot in zip(plan.stops, knots[1:], strict=True)}}
    demands: list[TimedObstacle] = []
    for number, hold in enumerate(plan.skeleton.holds):
        wanted: npt.NDArray[np.bool_] = np.zeros((segments, 4), dtype=bool)
        room = np.zeros((segments, 4))
        a, b = when[hold.first], when[hold.last]
        around = max(int(np.ceil(mission.doubt * segments)), int(lasting))  # segments that it lasts to either side of its moment
        if hold.at_once and not around:
            room_here = 2.0 * plan.speed / segments * AT_A_KNOT
            for k, c in ((a - 1, 3), (a, 0)):
                if 0 <= k < segments:
                    wanted[k, c], room[k, c] = True, room_here
        else:
            first, last = (a - around, b + around) if hold.first == hold.last else (a, b + max(around, 1) * hold.longer)
            wanted[max(first, 0) : last] = True
        if hold.last == END:
            wanted[segments - 1, 3] = True
        demands += mission.states[hold.state].demands(arena, f"{number}", wanted, room)
    return tuple(demands)
