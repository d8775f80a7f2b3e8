"""The search for a tube where unsafe sets move, or are unsafe only at times: its route is in space and time.

Width is weighed as in `widest.py`, but routes cannot be compared by length: time is given, and waiting is a move. So shares are
tried from the widest down, and a tube counts by its speed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np

from stt_codegen.decimals import below
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.faces import Array
from stt_codegen.design.shape import Shape, slowest_shape
from stt_codegen.design.sides import limits_in_time
from stt_codegen.design.spacetime import FAR, fields, way_in_time
from stt_codegen.design.widest import ROOM, Search
from stt_codegen.errors import NotCertified

SHARES = (1.0, 0.8, 0.6, 0.4, 0.2)  # of the narrower of start and target: the widths that are tried, then the least
NARROWING = 12  # halvings to find the value of an option, or a time
NAMED = 40  # up to so many sets, those are named that close the way


class TimedSearch(Search):
    """A search whose arena has movers."""

    def widest(self) -> Shape | None:
        """The widest tube that is found no faster than ROOM times the least speed; else the slowest of all that were found."""
        found: list[Shape] = []
        slowest: Shape | None = None
        for share in SHARES:
            shape = self.of_share(share)
            if shape is None:
                continue
            if self.within(shape, ROOM * self.straight):
                return shape
            if slowest is None:
                slowest = self.slowest()
                found += [] if slowest is None else [slowest]
            found.append(shape)
            if self.within(shape, ROOM * min(s.speed for s in found)):
                return shape
        last = self.slowest() if slowest is None else slowest
        found += [] if last is None else [last]
        if not found:
            raise NotCertified(why_closed(self.arena, self.start, self.ladder))
        return min(found, key=lambda s: s.speed)

    def family(self) -> Iterator[Shape]:
        for share in (*SHARES, 0.0):
            shape = self.of_share(share)
            if shape is not None and self.keeps(shape):
                yield shape

    def slowest(self, route: object = None) -> Shape | None:
        return self.of_share(0.0)

    def many(self) -> Shape | None:
        return self.widest()

    def of_share(self, share: float) -> Shape | None:
        """A tube of that share, with the fewest segments that find one."""
        width = self.width(share)
        for segments in self.ladder:
            way = way_in_time(self.arena, (self.start[0] + self.start[1]) / 2, width, segments)
            if way is None:
                continue
            limits = limits_in_time(self.arena, self.start, way, width)
            shape = slowest_shape(self.arena, self.start, limits, width, self.straight / segments, self.solvers)
            if shape is not None:
                return shape
        return None


def search_of(arena: Arena, start: Array, ladder: tuple[int, ...]) -> Search:
    """The search for an arena."""
    return (TimedSearch if arena.movers else Search)(arena, start, ladder)


def why_closed(arena: Arena, start: Array, ladder: tuple[int, ...]) -> str:
    """The refusal where no way is found: what closes it and when, and which options, each by itself, would open one."""

    def way(trial: Arena) -> bool:
        try:
            box = starting_box(trial)
        except NotCertified:
            return False
        centre, width = (box[0] + box[1]) / 2, np.full(trial.dimension, trial.min_width)
        return way_in_time(trial, centre, width, ladder[0]) is not None

    def shown(value: float) -> str:
        return f"{below(Fraction(max(value, 0.0)), 3):g}"

    told = "P4 avoid: no way was found from the initial set to the target set among the unsafe sets as they move"
    if way(arena):
        return (
            f"{told}: there is a route, but no spline tube along it; lower tube.min_width or tube.clearance, or give it more time"
        )
    size, none, narrow, opens = arena.length_unit, arena.allowance, 2 * arena.allowance, []
    if way(replace(arena, clearance=none)):
        value = _border(lambda c: way(replace(arena, clearance=c)), none, arena.clearance)
        opens.append(f"tube.clearance = {shown((value - none) * size)}")
    if way(replace(arena, min_width=narrow)):
        value = _border(lambda w: way(replace(arena, min_width=w)), narrow, arena.min_width)
        opens.append(f"tube.min_width = {shown((value - narrow) * size)}")
    closing = [] if len(arena.movers) > NAMED else [text for j in range(len(arena.movers)) if (text := _closes(arena, j, way))]
    parts = [told]
    if closing:
        parts.append(f"{' and '.join(closing)} close{'s' if len(closing) == 1 else ''} it")
    else:
        parts.append(_how_far(arena, start, ladder))
    return f"{parts[0]}: {parts[1]}" + (f"; a way opens at {', or at '.join(opens)}" if opens else "; give it more time or room")


def _closes(arena: Arena, j: int, way: Callable[[Arena], bool]) -> str | None:
    """A set without which there would be a way, and when it is in the way; None for another."""

    def without(begin: float, end: float) -> Arena:
        return replace(arena, movers=tuple(m.without(begin, end) if k == j else m for k, m in enumerate(arena.movers)))

    if not way(without(0.0, 1.0)):
        return None
    latest = _border(lambda v: way(without(v, 1.0)), 0.0, 1.0)
    earliest = _border(lambda v: way(without(latest, v)), 1.0, latest)
    begin, end = (f"{v * arena.time_unit:.3g}" for v in (latest, earliest))
    return f"{arena.movers[j].name} (from {begin} s to {end} s)"


def _border(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """The last place, from a good one towards another, at which it holds."""
    for _ in range(NARROWING):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def _how_far(arena: Arena, start: Array, ladder: tuple[int, ...]) -> str:
    """Where no set alone closes the way: until when any place is left to be at."""
    width = np.full(arena.dimension, arena.min_width)
    last = 0.0
    for field in fields(arena, (start[0] + start[1]) / 2, width, ladder[0]):
        alive = [bool((cost < FAR).any()) for cost in field.reached()]
        last = max([last, *(k / ladder[0] for k, (a, b) in enumerate(pairwise([*alive, False])) if a and not b)])
    if last < 1:
        return f"after {last * arena.time_unit:.3g} s no place that can be reached is safe"
    return "no set alone closes it"
