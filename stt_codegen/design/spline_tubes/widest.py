"""Which width a tube gets: the widest share of start and target whose tube is no faster than the limit.

The limit is ROOM times the shortest route over t_c, or SLOWEST times the slowest tube found where that is more. Routes are found
first, for they are quicker than tubes: the widest share with a route within the limit; then tubes, from there down.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import Solvers
from stt_codegen.design.missions import Mission
from stt_codegen.design.routes import Route, choose_sides, limits_along, limits_by_stretch, shortest_route, wide_route
from stt_codegen.design.spline_tubes.shape import CLOSE, Shape, slowest_shape
from stt_codegen.design.spline_tubes.stretch_times import changes_at, least_times, time_plans
from stt_codegen.task import Task

SEGMENTS = (32, 48, 64, 96, 128, *(1 << k for k in range(8, 14)))  # tried in this order when the task names no number,
TIMED = (64, 96, 128, 192, 256)  # where sets move: segments are the steps of time too
FEWEST, MOST = 0.5, 8  # between so many times the number of unsafe sets, but always up to PLENTY
PLENTY = 128
QUICK = 2  # numbers of segments that are tried for every width
ROUNDED = 0.25  # of the allowance for differences, which is 32 steps
# By order: how much longer than the shortest a route may be, and how much faster than its length over t_c a tube, for width. With
# inertia width is worth more than pace: what pushes at an edge goes with 1/width (of 24 arenas the proved period in the median is
# 61 ms at 1.4, 95 ms at 2, 93 ms at 3).
ROOM = {1: 1.4, 2: 2.0}
SLOWEST = 1.25  # times the slowest tube found is room enough, where that is more
FAMILY = (1.0, 0.9, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1)  # of the widest share with a route: the tubes that are compared
FIRST = (1.0, 0.95)  # of the widest share: a spline loses a segment at each end of a tight passage
TRIES = 3  # shares between the least width and one that is too fast, where the speed between them would meet the limit,
LEAST_STEP, MOST_STEP = 0.35, 0.9  # but so much of the way at least, and at most
TIGHT = 0.02  # to this part of start and target the widest share is found
HOLDS = ((0.0, 0.0), (1.0, 0.0))  # segments of standing at every corner of a route; the share of the time to get up to speed
RAMPS = ((0.0, 0.5), (0.0, 0.25), (1.0, 0.25))  # the same for order 2
NEAR = 1.12  # a tube this much faster than the limit is not mended by more segments
GOOD, FAIR = 1.08, 1.1  # times its route over t_c a tube is slow enough to try no rests at corners, no stays
FEWER = 0.97  # more segments count where the tube is slower by that
WIDE_ROUTES = (1.0, 0.5)  # of many unsafe sets: the shares that are tried before the least width,
DETOUR = 1.1  # where the route is at most so much longer than the shortest


@dataclass(frozen=True)
class Search:
    """What is designed: an arena (t_c the unit of time), gamma(0), the numbers of segments that may be tried, and the mission.

    A width is told as a share of the narrower of start and target in every dimension, and is never less than min_width.
    """

    arena: Arena
    start: Array
    ladder: tuple[int, ...]
    solvers: Solvers = field(default_factory=Solvers)
    mission: Mission | None = None

    def width(self, share: float) -> Array:
        """(n,)"""
        full = np.minimum(self.start[1] - self.start[0], self.arena.target[1] - self.arena.target[0])
        return np.asarray(np.maximum(share * full, self.arena.min_width))

    def route(self, share: float, longest: float = np.inf) -> Route | None:
        return wide_route(self.arena, self.start, self.width(share), longest)

    def most(self, segments: int) -> float:
        """The largest peak speed that max_speed allows, less what rounding the control points may add: 6 steps to a difference
        of two, a fifth of the allowance. For order 2 the programs know all limits."""
        if self.arena.order == 2:
            return np.inf
        return self.arena.max_speed - ROUNDED * self.arena.difference_allowance * segments

    def keeps(self, shape: Shape) -> bool:
        """Whether every dimension keeps to its own bound on speed."""
        if self.arena.order == 2:
            return True
        speeds = shape.paces * self.arena.swiftness * shape.segments
        return bool((speeds <= self.arena.max_speeds - ROUNDED * self.arena.difference_allowance * shape.segments).all())

    @property
    def straight(self) -> float:
        """How far the centre must go at least, in the largest component: no tube is slower."""
        half, centre, target = self.arena.min_width / 2, (self.start[0] + self.start[1]) / 2, self.arena.target
        apart = np.maximum(np.maximum(target[0] + half - centre, centre - target[1] + half), 0)
        return float(self.arena.distance(apart[None])[0])

    def widest(self) -> Shape | None:
        """The widest tube that is found along a route of at most ROOM times the shortest, no faster than its time allows; else
        the slowest of all that were found."""
        whole, room = self.route(1.0), ROOM[self.arena.order]
        first: Shape | None = None
        if whole is not None and whole.length <= room * self.straight:
            first = self.along(1.0, whole, room * self.straight)
            if first is not None and self.within(first, room * self.straight):
                return first
        shortest = shortest_route(self.arena, self.start, self.width(0.0))
        limit = room * shortest.length
        if first is not None and self.within(first, limit):
            return first
        share, route = self.widest_route(whole, shortest, limit)
        found = [] if first is None else [first]
        for part in FIRST:
            if part * share == 1.0 and first is not None:
                continue
            here = route if part == 1.0 else self.route(part * share)
            shape = None if here is None else self.along(part * share, here, limit)
            if shape is not None and self.within(shape, limit):
                return shape
            found += [] if shape is None else [shape]
        # not wide at once: how slow is a tube at all?
        slow = self.along(0.0, shortest, NEAR * shortest.length, self.ladder[:1], stays=True)
        if slow is not None:
            found.append(slow)
            limit = max(limit, SLOWEST * slow.speed)
            if first is not None and self.within(first, limit):
                return first
            best = self.between(slow, share * FIRST[-1], found[-2].speed if len(found) > 1 else np.inf, limit)
            if best is not None:
                return best
        last = self.slowest(shortest)
        return min([*found, *([] if last is None else [last])], key=lambda s: s.speed, default=None)

    def family(self) -> Iterator[Shape]:
        """Tubes of several widths, the widest first, each the slowest that is found along a route of its own; at last one of the
        least width with any number of segments."""
        shortest = shortest_route(self.arena, self.start, self.width(0.0))
        share, _ = self.widest_route(self.route(1.0), shortest, np.inf)
        for part in (*FAMILY, 0.0):
            route = self.route(part * share) if part else shortest
            if not part:
                shape = self.slowest(shortest)
            else:
                shape = None if route is None else self.along(part * share, route, CLOSE * route.length)
            if shape is not None and self.keeps(shape):
                yield shape

    def between(self, slow: Shape, share: float, speed: float, limit: float) -> Shape | None:
        """The widest tube within the limit between the least width, of which `slow` is, and a share that is too fast."""
        best = slow if self.within(slow, limit) else None
        low, low_speed = 0.0, slow.speed
        for _ in range(TRIES):
            if best is None:
                break
            line = (limit - low_speed) / (speed - low_speed) if low_speed < limit < speed < np.inf else 0.5
            middle = low + (share - low) * min(max(line, LEAST_STEP), MOST_STEP)
            route = self.route(middle)
            shape = None if route is None else self.along(middle, route, limit)
            if shape is not None and self.within(shape, limit):
                best, low, low_speed = shape, middle, shape.speed
            else:
                share, speed = middle, np.inf if shape is None else shape.speed
        return best

    def within(self, shape: Shape, limit: float) -> bool:
        return shape.speed <= min(limit, self.most(shape.segments))

    def widest_route(self, whole: Route | None, shortest: Route, limit: float) -> tuple[float, Route]:
        """The largest share whose route is not longer than the limit, to TIGHT, and that route."""
        if whole is not None and whole.length <= limit:
            return 1.0, whole
        low, high, best = 0.0, 1.0, shortest
        while high - low > TIGHT:
            middle = (low + high) / 2
            route = self.route(middle, limit)
            if route is not None:
                low, best = middle, route
            else:
                high = middle
        return low, best

    def slowest(self, route: Route | None = None) -> Shape | None:
        """A tube of the least width along the shortest route, with any number of segments that may be tried."""
        route = route or shortest_route(self.arena, self.start, self.width(0.0))
        return self.along(0.0, route, CLOSE * route.length, self.ladder, stays=True)

    def many(self) -> Shape | None:
        """With many unsafe sets sides and times come from the linear program of stretches alone, for a few widths."""
        shortest = shortest_route(self.arena, self.start, self.width(0.0))
        found: list[Shape] = []
        for share in (*WIDE_ROUTES, 0.0):
            route = self.route(share) if share else shortest
            if route is None or route.length > DETOUR * shortest.length:
                continue
            for segments in self.ladder[:1] if share else self.ladder:
                shape = self.stretched(self.width(share), route, segments)
                if shape is not None and shape.speed <= self.most(segments):
                    return shape
                found += [] if shape is None else [shape]
        return min(found, key=lambda s: s.speed, default=None)

    def along(self, share: float, route: Route, limit: float, ladder: Sequence[int] = (), stays: bool = False) -> Shape | None:
        """A tube of that share along the route, with the fewest segments that keep it within the limit, else the slowest one."""
        best: Shape | None = None
        width = self.width(share)
        for segments in ladder or self.ladder[:QUICK]:
            shape = self.moved(width, route, segments, limit)
            if stays and (shape is None or shape.speed > min(limit, FAIR * route.length)):
                other = self.stretched(width, route, segments)
                shape = other if shape is None or (other is not None and other.pace < shape.pace) else shape
            if shape is None:
                continue
            if best is None or shape.speed < FEWER * best.speed:
                best = shape
            if self.within(shape, limit) or (not ladder and shape.speed > NEAR * limit):
                break
        return best

    def moved(self, width: Array, route: Route, segments: int, limit: float) -> Shape | None:
        """Sides of the box that moves along the route at one speed, with or without a rest at its corners."""
        best: Shape | None = None
        for hold, ramp in HOLDS if self.arena.order == 1 else RAMPS:
            limits = limits_along(self.arena, self.start, route, width, segments, hold, ramp)
            shape = slowest_shape(self.arena, self.start, limits, width, route.length, self.solvers)
            if shape is not None and (best is None or shape.pace < best.pace):
                best = shape
            if best is not None and best.speed <= max(limit, GOOD * route.length):
                break
        return best

    def stretched(self, width: Array, route: Route, segments: int) -> Shape | None:
        """Stays on the sides that last longest, and the least times of the stretches between."""
        arena = self.arena
        sides = choose_sides(arena, route, self.start)
        timing = least_times(arena, sides, self.start, route, width) if sides is not None else None
        if sides is None or timing is None:
            return None
        for shares in time_plans(timing, segments):
            changes = changes_at(timing, sides, shares, segments)
            if changes is None:
                continue
            limits = limits_by_stretch(arena, sides, changes, segments)
            shape = slowest_shape(arena, self.start, limits, width, timing.length, self.solvers)
            if shape is not None:
                return shape
        return None


def segments_tried(task: Task, arena: Arena) -> tuple[int, ...]:
    """The numbers of segments to try for a task."""
    if task.tube.segments:
        return (task.tube.segments,)
    return TIMED if arena.timed_obstacles or task.mission else segments_for(len(arena.names))


def segments_for(unsafe: int) -> tuple[int, ...]:
    """The numbers of segments to try for so many unsafe sets."""
    return tuple(k for k in SEGMENTS if FEWEST * unsafe <= k <= max(PLENTY, MOST * unsafe))
