"""Which windows and ways are in conflict, where no order of the visits is in time: the cycle of bounds on times whose sum is
negative, in the order of those looked at that needs all windows wider by the least.

    t_j - t_i <= most        -(t_j - t_i) <= -least        and for each leg -(t_j - t_i) <= -length / speed

Round a cycle the left sides add to 0. Where the right sides add to less, no times satisfy them, and by so much something on the
cycle must give way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import groupby, pairwise

import numpy as np

from stt_codegen.decimals import above
from stt_codegen.design.arena import Arena
from stt_codegen.design.missions.orders import Order, Stop
from stt_codegen.design.missions.skeleton import END, SEAM, START, TINY, Difference, Skeleton
from stt_codegen.design.missions.state_constraints import Mission
from stt_codegen.design.missions.waypoints import Places

LOOKED = 6  # skeletons that are looked at
HALVINGS = 8
AT_ONCE = 1e4  # times the extent of space in t_c, where nothing bounds the speed
WIDEST = 1.0  # of t_c by which windows are made wider at most


@dataclass(frozen=True)
class _Arc:
    """t_last - t_first <= bound, in parts of t_c, and what says so. asked: it is worth telling."""

    first: int
    last: int
    bound: float
    told: str
    asked: bool = True


def clash(arena: Arena, places: Places, mission: Mission) -> str | None:
    """What lacks how many seconds; None where nothing of that kind is found."""
    best: tuple[float, Skeleton, list[Stop]] | None = None
    for skeleton in mission.all_skeletons[:LOOKED]:
        found = _nearest(arena, places, skeleton, WIDEST if best is None else best[0])
        if found is not None and not found[0]:  # an order is in time: it is something else that is in the way
            return None
        best = best if found is None or (best is not None and found[0] >= best[0]) else (found[0], skeleton, found[1])
    if best is None:
        return None
    _, skeleton, stops = best
    cycle = _negative(skeleton.events, list(_arcs(arena, places, skeleton, stops)))
    if not cycle:
        return None
    told = [arc.told for arc in cycle if arc.asked]
    lack = above(Fraction(-sum(arc.bound for arc in cycle) * arena.time_unit), 3)
    names = _names(skeleton)
    order = ", ".join(name for name, _ in groupby(names[stop.event] for stop in stops[:-1]))
    return f"of the orders looked at the nearest ({order}) lacks at least {lack:g} s: {', '.join(told)}"


def _nearest(arena: Arena, places: Places, skeleton: Skeleton, most: float) -> tuple[float, list[Stop]] | None:
    """By how much, in parts of t_c, all windows must be wider for an order to be in time, and that order; None where `most` is
    not enough."""

    extent = float((arena.space[1] - arena.space[0]).max())
    speed = arena.max_speed if np.isfinite(arena.max_speed) else AT_ONCE * extent

    def stops(by: float) -> list[Stop] | None:
        wider = replace(skeleton, differences=tuple(_wider(d, by, skeleton) for d in skeleton.differences))
        return None if wider.zone is None else Order(places, wider).shortest(speed)

    in_time = stops(0.0)
    if in_time is not None:
        return 0.0, in_time
    found = stops(most)
    if found is None:
        return None
    low, high = 0.0, most
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        other = stops(middle)
        low, high, found = (low, middle, other) if other is not None else (middle, high, found)
    return high, found


def _wider(d: Difference, by: float, skeleton: Skeleton) -> Difference:
    if (d.first, d.last) == (START, END) or (skeleton.seam is not None and (d.first, d.last) == (START, SEAM)):
        return d
    return replace(d, least=d.least - by if d.least > 0 else d.least, most=d.most + by)


def _names(skeleton: Skeleton) -> dict[int, str]:
    """What events are called: by what holds there."""
    found = {START: "the start", END: "t_c"} | ({SEAM: "the seam"} if skeleton.seam is not None else {})
    for hold in skeleton.holds:
        found.setdefault(hold.first, str(hold.state))
    for hold in skeleton.holds:
        found.setdefault(hold.last, f"the end of {hold.state}")
    return {k: found.get(k, "a moment") for k in range(skeleton.events)}


def _arcs(arena: Arena, places: Places, skeleton: Skeleton, stops: list[Stop]) -> Iterator[_Arc]:
    """All bounds on times, those of the legs too."""
    names, unit = _names(skeleton), arena.time_unit

    def seconds(value: float) -> str:
        return f"{round(value * unit, 3):g} s"

    for d in skeleton.differences:
        asked = skeleton.seam is None or (d.first, d.last) != (START, SEAM)  # when the cycle begins is chosen here
        here, since = names[d.last], "" if d.first == START else f" after {names[d.first]}"
        if d.most < 1 - TINY or (d.first, d.last) == (START, END):
            most = seconds(d.most + d.inset)
            yield _Arc(d.first, d.last, d.most, f"{here} at most {most}{since}" if since else f"{here} by {most}", asked)
        if d.least > TINY:
            least = seconds(d.least - d.inset)
            yield _Arc(d.last, d.first, -d.least, f"{here} {least}{since or ' at the earliest'}", asked)
    at = places.nodes[0]
    for before, stop in pairwise([Stop(START, np.empty((0, len(at)))), *stops]):
        points = np.concatenate([at[None], stop.way])
        steps = arena.distance(points[1:] - points[:-1])
        length = float(np.cumsum([0.0, *steps])[-1])
        at = points[-1]
        took = length / arena.max_speed if np.isfinite(arena.max_speed) else 0.0
        told = f"{seconds(took)} from {names[before.event]} to {names[stop.event]} at full speed"
        yield _Arc(stop.event, before.event, -took, told, bool(took))


def _negative(events: int, arcs: list[_Arc]) -> list[_Arc]:
    """A cycle with a sum below 0, in the order of time from the start on where that is on it; empty where there is none. Bellman
    and Ford, from everywhere at once."""
    bound, came = np.zeros(events), dict[int, _Arc]()
    last: int | None = None
    for _ in range(events + 1):
        last = None
        for arc in arcs:
            if bound[arc.first] + arc.bound < bound[arc.last] - TINY:
                bound[arc.last], came[arc.last], last = bound[arc.first] + arc.bound, arc, arc.last
        if last is None:
            return []
    assert last is not None
    for _ in range(events):
        last = came[last].first
    cycle, at = [came[last]], came[last].first
    while at != last:
        cycle.append(came[at])
        at = came[at].first
    # what came before stands behind: so from the start on time that must pass leads forward, and time that may leads back
    begin = next((k for k, arc in enumerate(cycle) if arc.last == START), 0)
    return cycle[begin:] + cycle[:begin]
