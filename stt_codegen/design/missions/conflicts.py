"""Which windows and legs are in conflict, where no order of the visits is in time.

The bounds on times are edges of a graph between events:

    t_j - t_i <= maximum        -(t_j - t_i) <= -minimum        and for each leg -(t_j - t_i) <= -length / speed

Round a cycle the left sides add to 0. Where the right sides add to less, no times satisfy them, and something on the cycle must
give way by that much. The cycle is taken from the order that needs the smallest widening of all windows to be in time.
refusals/unmet_missions.py puts it into a message.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np

from stt_codegen.decimals import above
from stt_codegen.design.arena import Arena
from stt_codegen.design.missions.orders import OrderSearch, Stop
from stt_codegen.design.missions.skeleton import END, SEAM, START, TOLERANCE, Skeleton, TimeBound
from stt_codegen.design.missions.state_constraints import DELAY_FACTOR, Mission
from stt_codegen.design.missions.waypoints import Waypoints

SKELETON_LIMIT = 6  # skeletons that are examined
HALVINGS = 8
UNBOUNDED_SPEED = 1e4  # times the extent of space in t_c: the speed of a leg where nothing bounds it
WIDENING_LIMIT = 1.0  # of t_c by which windows are made wider at most


@dataclass(frozen=True)
class TimeArc:
    """t_last - t_first <= bound, in parts of t_c, with the words for it; is_reported: whether the message mentions it."""

    first: int
    last: int
    bound: float
    description: str
    is_reported: bool = True


class _WidenedOrder(NamedTuple):
    """An order that is in time when all windows are wider by `widening`, in parts of t_c."""

    widening: float
    stops: list[Stop]


def describe_conflict(arena: Arena, waypoints: Waypoints, mission: Mission) -> str | None:
    """Return which bounds are in conflict and how many seconds are missing; None where no such conflict is found."""
    best: _WidenedOrder | None = None
    best_skeleton: Skeleton | None = None
    for skeleton in mission.all_skeletons[:SKELETON_LIMIT]:
        order = _minimally_widened_order(arena, waypoints, skeleton, WIDENING_LIMIT if best is None else best.widening)
        if order is None:
            continue
        if order.widening == 0:  # an order is in time, so that something else is in the way
            return None
        if best is None or order.widening < best.widening:
            best, best_skeleton = order, skeleton
    if best is None or best_skeleton is None:
        return None
    cycle = negative_cycle(best_skeleton.event_count, list(_time_arcs(arena, waypoints, best_skeleton, best.stops)))
    if not cycle:
        return None
    shortfall = above(Fraction(-sum(arc.bound for arc in cycle) * arena.time_unit), 3)
    names = _event_names(best_skeleton)
    order_of_visits = ", ".join(name for name, _ in groupby(names[stop.event] for stop in best.stops[:-1]))
    bounds = ", ".join(arc.description for arc in cycle if arc.is_reported)
    delay = mission.start_delay * arena.time_unit
    kept = f" (start_delay takes {DELAY_FACTOR * delay:.3g} s from either end of every window)" if delay else ""
    return f"the order of visits that comes nearest ({order_of_visits}) is at least {shortfall:g} s too long: {bounds}{kept}"


def _minimally_widened_order(arena: Arena, waypoints: Waypoints, skeleton: Skeleton, limit: float) -> _WidenedOrder | None:
    """Return the order that is in time with the smallest widening of all windows; None where `limit` is not enough.

    The widening is found by HALVINGS halvings. limit: in parts of t_c.
    """
    extent = float((arena.space[1] - arena.space[0]).max())
    speed = arena.max_speed if np.isfinite(arena.max_speed) else UNBOUNDED_SPEED * extent

    def stops_with(widening: float) -> list[Stop] | None:
        bounds = tuple(_widened(bound, widening, skeleton) for bound in skeleton.time_bounds)
        widened = replace(skeleton, time_bounds=bounds)
        return None if widened.zone is None else OrderSearch(waypoints, widened).shortest_stops(speed)

    stops = stops_with(0.0)
    if stops is not None:
        return _WidenedOrder(0.0, stops)
    stops = stops_with(limit)
    if stops is None:
        return None
    low, high = 0.0, limit
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        stops_at_middle = stops_with(middle)
        if stops_at_middle is None:
            low = middle
        else:
            high, stops = middle, stops_at_middle
    return _WidenedOrder(high, stops)


def _widened(bound: TimeBound, widening: float, skeleton: Skeleton) -> TimeBound:
    """Return a time bound made wider; the times of t_c and of the seam are fixed."""
    ends = bound.first, bound.last
    if ends == (START, END) or (skeleton.seam is not None and ends == (START, SEAM)):
        return bound
    minimum = bound.minimum - widening if bound.minimum > 0 else bound.minimum
    return replace(bound, minimum=minimum, maximum=bound.maximum + widening)


def _event_names(skeleton: Skeleton) -> dict[int, str]:
    """Return what to call each event: by the state that begins or ends there."""
    names = {START: "the start", END: "t_c"} | ({SEAM: "the seam"} if skeleton.seam is not None else {})
    for hold in skeleton.holds:
        names.setdefault(hold.first, str(hold.state))
    for hold in skeleton.holds:
        names.setdefault(hold.last, f"the end of {hold.state}")
    return {event: names.get(event, "a moment") for event in range(skeleton.event_count)}


def _time_arcs(arena: Arena, waypoints: Waypoints, skeleton: Skeleton, stops: Sequence[Stop]) -> Iterator[TimeArc]:
    """Yield all bounds on times: those of the skeleton, and the time that each leg takes at full speed."""
    names, unit = _event_names(skeleton), arena.time_unit

    def seconds(value: float) -> str:
        return f"{round(value * unit, 3):g} s"

    for bound in skeleton.time_bounds:
        ends = bound.first, bound.last
        is_reported = skeleton.seam is None or ends != (START, SEAM)  # the search chooses when the cycle begins
        event, since = names[bound.last], "" if bound.first == START else f" after {names[bound.first]}"
        if bound.maximum < 1 - TOLERANCE or ends == (START, END):
            latest = seconds(bound.maximum + bound.inset)
            description = f"{event} at most {latest}{since}" if since else f"{event} by {latest}"
            yield TimeArc(bound.first, bound.last, bound.maximum, description, is_reported)
        if bound.minimum > TOLERANCE:
            earliest = seconds(bound.minimum - bound.inset)
            description = f"{event} {earliest}{since or ' at the earliest'}"
            yield TimeArc(bound.last, bound.first, -bound.minimum, description, is_reported)
    position = waypoints.nodes[0]
    for previous, stop in pairwise([Stop(START, np.empty((0, len(position)))), *stops]):
        points = np.concatenate([position[None], stop.path])
        length = float(np.cumsum([0.0, *arena.distance(points[1:] - points[:-1])])[-1])
        position = points[-1]
        duration = length / arena.max_speed if np.isfinite(arena.max_speed) else 0.0
        description = f"{seconds(duration)} from {names[previous.event]} to {names[stop.event]} at full speed"
        yield TimeArc(stop.event, previous.event, -duration, description, bool(duration))


def negative_cycle(event_count: int, arcs: Sequence[TimeArc]) -> list[TimeArc]:
    """Return a cycle of arcs whose bounds add to less than 0, in the order of time; empty where there is none.

    The cycle begins at the start where the start is on it. This is the algorithm of Bellman and Ford from every event at once.
    """
    bound, arc_to = np.zeros(event_count), dict[int, TimeArc]()
    event: int | None = None
    for _ in range(event_count + 1):
        event = None
        for arc in arcs:
            if bound[arc.first] + arc.bound < bound[arc.last] - TOLERANCE:
                bound[arc.last], arc_to[arc.last], event = bound[arc.first] + arc.bound, arc, arc.last
        if event is None:
            return []
    assert event is not None
    for _ in range(event_count):  # so many steps back lead onto the cycle
        event = arc_to[event].first
    cycle, position = [arc_to[event]], arc_to[event].first
    while position != event:
        cycle.append(arc_to[position])
        position = arc_to[position].first
    # the list runs against the arcs: from the start on a time that must pass leads forward, and a time that may pass leads back
    begin = next((k for k, arc in enumerate(cycle) if arc.last == START), 0)
    return cycle[begin:] + cycle[:begin]
