"""When the events of a mission happen: the smallest speed at which a path is in time, and the knots of a spline at the events.

mission_search.py makes a plan for each order of events, and a tube along the plan. What the mission's states require between the
knots comes as obstacles that count only then.
Long because the linear programs of the times are read beside each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import LinearProgram
from stt_codegen.design.missions.orders import OrderSearch, Stop
from stt_codegen.design.missions.skeleton import END, START, TOLERANCE, Hold, Skeleton
from stt_codegen.design.missions.state_constraints import Mission
from stt_codegen.design.missions.waypoints import Waypoints
from stt_codegen.design.moving_half_spaces import TimedObstacle

TRIAL_SPEEDS = (2.0, 8.0, 64.0)  # times the extent of space in t_c: the speeds at which a first order is sought
SLOWDOWN = 0.9  # speed of the search for a slower order, times the speed of the last order
SLOWDOWN_LIMIT = 6  # searches for a slower order
SLOWER_RATIO = 0.999  # largest speed of a slower order, times the speed of the last order
KNOT_TOLERANCE = 1e-9  # of a segment, by which a time may miss a knot
TIME_MARGIN_SPEED = 1.2  # times the smallest speed: what margin in time may cost
WINDOW_MARGIN = 1 / 16  # of t_c, that an event keeps from the ends of its window, or half of a shorter window
SPEED_WEIGHT = 10.0  # of the ratio of the durations to the lengths, beside the share of a margin
MOMENT = 1 / 64  # of a segment: for so long to either side of a knot a state holds that must hold at the knot


@dataclass(frozen=True)
class Plan:
    """A path with stops, and the smallest speed at which all stops are in time.

    origin: (n,), where the path begins. lengths: of the legs to the stops, as `Arena.distance` measures them. speed: in lengths
    per t_c.
    """

    skeleton: Skeleton
    origin: Array
    stops: tuple[Stop, ...]
    lengths: tuple[float, ...]
    speed: float


def slowest_plan(arena: Arena, waypoints: Waypoints, skeleton: Skeleton, best_speed: float = np.inf) -> Plan | None:
    """Return the slowest plan that is found for a skeleton; None where none is found that is well below `best_speed`."""
    search = OrderSearch(waypoints, skeleton)
    if not waypoints.nodes.size or best_speed <= TOLERANCE:  # the start is not free, or no plan can be slower
        return None
    if np.isfinite(arena.max_speed):
        return plan_of_stops(waypoints, skeleton, search.shortest_stops(min(arena.max_speed, SLOWDOWN * best_speed)))
    if not skeleton.has_windows:
        return plan_of_stops(waypoints, skeleton, search.shortest_stops(np.inf))
    extent = float((arena.space[1] - arena.space[0]).max())
    plan = None
    for speed in [SLOWDOWN * best_speed] if np.isfinite(best_speed) else [factor * extent for factor in TRIAL_SPEEDS]:
        plan = plan_of_stops(waypoints, skeleton, search.shortest_stops(speed))
        if plan is not None:
            break
    for _ in range(SLOWDOWN_LIMIT if plan is not None and plan.speed > TOLERANCE else 0):
        assert plan is not None
        slower = plan_of_stops(waypoints, skeleton, search.shortest_stops(SLOWDOWN * plan.speed))
        if slower is None or slower.speed > SLOWER_RATIO * plan.speed:
            break
        plan = slower
    return plan


def plan_of_stops(waypoints: Waypoints, skeleton: Skeleton, stops: Sequence[Stop] | None) -> Plan | None:
    """Return the plan with these stops at the smallest speed at which they are in time; None where there is none.

    With the scaled durations D = speed * duration this is one linear program.
    """
    if stops is None:
        return None
    origin, legs = waypoints.nodes[0], len(stops)
    lengths = _leg_lengths(waypoints.arena, origin, stops)
    program = LinearProgram(legs + 1)
    program.cost[legs] = 1.0
    program.lower[:legs], program.lower[legs] = lengths, 0.0
    for window in _leg_windows(skeleton, stops):
        ones = np.ones(len(window.legs))
        row = [[*window.legs, legs]]
        if np.isfinite(window.minimum):
            program.add_rows(row, np.append(ones, -window.minimum), 0.0, np.inf)
        if np.isfinite(window.maximum):
            program.add_rows(row, np.append(ones, -window.maximum), -np.inf, 0.0)
    solution = program.solve()
    if solution is None:
        return None
    return Plan(skeleton, origin, tuple(stops), tuple(lengths), float(solution[legs]))


def _leg_lengths(arena: Arena, origin: Array, stops: Sequence[Stop]) -> list[float]:
    """Return the length of the leg to each stop."""
    lengths, position = [], origin
    for stop in stops:
        points = np.concatenate([position[None], stop.path])
        lengths.append(float(np.cumsum([0.0, *arena.distance(points[1:] - points[:-1])])[-1]))
        position = points[-1]
    return lengths


class _LegWindow(NamedTuple):
    """The time that consecutive legs may take together, in parts of t_c."""

    legs: list[int]
    minimum: float
    maximum: float


def _leg_windows(skeleton: Skeleton, stops: Sequence[Stop]) -> Iterator[_LegWindow]:
    """Yield every time bound of the skeleton as a window for the legs between its events."""
    stop_index = {START: 0, **{stop.event: k + 1 for k, stop in enumerate(stops)}}
    for bound in skeleton.time_bounds:
        first, last, minimum, maximum = stop_index[bound.first], stop_index[bound.last], bound.minimum, bound.maximum
        if first > last:
            first, last, minimum, maximum = last, first, -maximum, -minimum
        if first < last:
            yield _LegWindow(list(range(first, last)), minimum, maximum)


def choose_knots(
    plan: Plan, segments: int, minimum_segments: int, *, from_rest: bool = False, around: float | None = None
) -> list[int] | None:
    """Return the knot of each stop, the start's first; None where windows are too narrow for so few segments.

    The times are those of the smallest speed, rounded to whole segments within all windows. Each leg with a length takes at least
    `minimum_segments`. from_rest: the times are those of the smallest acceleration instead, at which a leg from rest to rest
    takes 2 sqrt(length / acceleration). around: times with a margin instead, at no more than TIME_MARGIN_SPEED times the smallest
    speed: nearer to the middles of their windows, and with so many segments left to either side of a state that must hold at one
    moment.
    """
    lengths = [math.sqrt(length) if from_rest else length for length in plan.lengths]
    windows = list(_leg_windows(plan.skeleton, plan.stops))
    is_moving = [length > TOLERANCE for length in lengths]
    if minimum_segments * sum(is_moving) > segments:
        return None
    shortest = [minimum_segments / segments if moving else 0.0 for moving in is_moving]
    durations = _even_durations(lengths, shortest, windows)
    if durations is not None and around is not None and durations[-1] > TOLERANCE:
        pauses = _pauses(plan, is_moving) * around / segments
        durations = _durations_with_margin(lengths, shortest, windows, pauses, durations[-1])
    if durations is None:
        return None
    times = np.concatenate([[0.0], np.cumsum(durations[: len(lengths)])]) * segments
    steps = np.array([float(max(minimum_segments, 1)) if moving else 0.0 for moving in is_moving])
    return _round_to_knots(times, steps, windows, segments)


def _pauses(plan: Plan, is_moving: Sequence[bool]) -> Array:
    """Return at how many ends of each leg with a length a state must hold at one moment: (legs,)."""
    momentary = {hold.first for hold in plan.skeleton.holds if hold.is_momentary}
    ends = [False, *(stop.event in momentary for stop in plan.stops)]
    still_legs = [k for k, moving in enumerate(is_moving) if not moving]
    for k in (*still_legs, *reversed(still_legs)):  # stops at one place
        ends[k] = ends[k + 1] = ends[k] or ends[k + 1]
    return np.array([(ends[k] + ends[k + 1]) * moving for k, moving in enumerate(is_moving)], dtype=float)


def _duration_program(
    lengths: Sequence[float], shortest: Sequence[float], windows: Sequence[_LegWindow], extra: int, pauses: Array | None = None
) -> LinearProgram:
    """Return the constraints on the durations of the legs, in parts of t_c: within all windows, and in proportion to the lengths.

    The columns are the durations, the smallest ratio of a duration to its length, and `extra` more. pauses: (legs,), by what each
    duration must be longer than that.
    """
    legs = len(lengths)
    program = LinearProgram(legs + 1 + extra)
    program.lower[:legs], program.lower[legs] = shortest, 0.0
    program.upper[legs] = 1 / TOLERANCE  # bounds the program where no leg has a length
    for k, length in enumerate(lengths):
        if length > TOLERANCE:
            program.add_rows([[k, legs]], [1.0, -length], 0.0 if pauses is None else pauses[k], np.inf)
    for window in windows:
        program.add_rows([window.legs], np.ones(len(window.legs)), window.minimum, window.maximum)
    return program


def _even_durations(lengths: Sequence[float], shortest: Sequence[float], windows: Sequence[_LegWindow]) -> Array | None:
    """Return the durations of the legs whose smallest ratio to the length is largest, and then this ratio: (legs + 1,)."""
    program = _duration_program(lengths, shortest, windows, 0)
    program.cost[-1] = -1.0
    return program.solve()


def _durations_with_margin(
    lengths: Sequence[float], shortest: Sequence[float], windows: Sequence[_LegWindow], pauses: Array, ratio: float
) -> Array | None:
    """Return durations that keep from the ends of the windows, with a ratio of at least `ratio` / TIME_MARGIN_SPEED, or None.

    A window's margin is WINDOW_MARGIN or half of it; each has a share of its margin. The smallest share counts most, then the sum
    of the shares and the speed.
    """
    legs, count = len(lengths), len(windows)
    program, smallest_share = _duration_program(lengths, shortest, windows, 1 + count, pauses), legs + 1
    program.lower[legs], program.cost[legs] = ratio / TIME_MARGIN_SPEED, -SPEED_WEIGHT / ratio
    program.cost[smallest_share], program.cost[smallest_share + 1 :] = -float(count + 1), -1.0
    program.lower[smallest_share:], program.upper[smallest_share:] = 0.0, 1.0
    for k, window in enumerate(windows, smallest_share + 1):
        margin = min(WINDOW_MARGIN, (window.maximum - window.minimum) / 2)
        after = margin if window.minimum > TOLERANCE else 0.0
        before = margin if window.maximum < 1 - TOLERANCE else 0.0
        row, ones = [[*window.legs, k]], np.ones(len(window.legs))
        program.add_rows(row, np.append(ones, -after), window.minimum, np.inf)
        program.add_rows(row, np.append(ones, before), -np.inf, window.maximum)
        program.add_rows([[k, smallest_share]], [1.0, -1.0], 0.0, np.inf)
    return program.solve()


def _round_to_knots(times: Array, steps: Array, windows: Sequence[_LegWindow], segments: int) -> list[int] | None:
    """Return the knots nearest to times in segments, within all windows; None where there are none.

    steps: (legs,), how many segments each leg takes at least. The constraints are differences of two knots, so the vertices of
    the linear program are whole numbers.
    """
    count = len(times)
    program, row = LinearProgram(3 * count), np.arange(count)
    program.cost[count:] = 1.0
    program.lower[:] = 0.0
    program.upper[:count] = segments
    program.upper[0], program.lower[count - 1] = 0.0, segments
    program.add_rows(np.stack([row, row + count, row + 2 * count], axis=1), [1.0, 1.0, -1.0], times, times)
    program.add_rows(np.stack([row[1:], row[:-1]], axis=1), [1.0, -1.0], steps, np.inf)
    for window in windows:
        low = np.ceil(window.minimum * segments - KNOT_TOLERANCE) if np.isfinite(window.minimum) else -np.inf
        high = np.floor(window.maximum * segments + KNOT_TOLERANCE) if np.isfinite(window.maximum) else np.inf
        if low > high:
            return None
        program.add_rows([[window.legs[-1] + 1, window.legs[0]]], [1.0, -1.0], low, high)
    solution = program.solve()
    return None if solution is None else [int(v) for v in np.rint(solution[:count])]


def centre_along(plan: Plan, knots: Sequence[int], segments: int) -> Array:
    """Return the centre at the ends of the segments when every leg is followed at a constant speed: (segments + 1, n)."""
    position = plan.origin
    centre = np.empty((segments + 1, len(position)))
    centre[0] = position
    for stop, begin, end in zip(plan.stops, knots[:-1], knots[1:], strict=True):
        points = np.concatenate([position[None], stop.path])
        steps = np.abs(np.diff(points, axis=0)).max(axis=1) if len(points) > 1 else np.zeros(0)
        distances = np.concatenate([[0.0], np.cumsum(steps)])
        for k in range(begin + 1, end + 1):
            distance = distances[-1] * (k - begin) / (end - begin)
            q = min(int(np.searchsorted(distances, distance, side="right")) - 1, max(len(steps) - 1, 0))
            part = (distance - distances[q]) / steps[q] if len(steps) and steps[q] > 0 else 0.0
            centre[k] = points[q] + (points[q + 1] - points[q]) * min(part, 1.0) if len(steps) else position
        position = points[-1]
        centre[end] = position
    return centre


def mission_obstacles(
    arena: Arena, mission: Mission, plan: Plan, knots: Sequence[int], *, segments: int, around: float = MOMENT
) -> tuple[TimedObstacle, ...]:
    """Return what each state requires, while it must hold, as sets that the tube must stay clear of.

    knots: of the start and of each stop. around: for how many segments to either side a state must hold that must hold at one
    moment.
    """
    event_knots = {START: knots[0], **{stop.event: knot for stop, knot in zip(plan.stops, knots[1:], strict=True)}}
    segments_around = max(math.ceil(mission.start_delay * segments), math.floor(around))
    knot_margin = 2.0 * plan.speed / segments * around
    obstacles: list[TimedObstacle] = []
    for number, hold in enumerate(plan.skeleton.holds):
        first, last = event_knots[hold.first], event_knots[hold.last]
        active, margin = _active_coefficients(
            hold, first, last, segments=segments, around=segments_around, knot_margin=knot_margin
        )
        obstacles += mission.states[hold.state].as_timed_obstacles(arena, f"{number}", active, margin)
    return tuple(obstacles)


def _active_coefficients(
    hold: Hold, first: int, last: int, *, segments: int, around: int, knot_margin: float
) -> tuple[npt.NDArray[np.bool_], Array]:
    """Return at which Bezier coefficients a hold from a knot to a knot must hold, and with which margins: (segments, 4) each.

    around: for how many segments it must hold to either side of its moment. knot_margin: the margin where that is 0.
    """
    active: npt.NDArray[np.bool_] = np.zeros((segments, 4), dtype=bool)
    margin = np.zeros((segments, 4))
    if hold.is_momentary and not around:
        for k, coefficient in ((first - 1, 3), (first, 0)):
            if 0 <= k < segments:
                active[k, coefficient], margin[k, coefficient] = True, knot_margin
    elif hold.first == hold.last:
        active[max(first - around, 0) : last + max(around, int(hold.lasts_longer))] = True
    else:
        active[max(first, 0) : last + max(around, 1) * hold.lasts_longer] = True
    if hold.last == END:
        active[segments - 1, 3] = True
    return active, margin
