"""Which width a tube gets: the widest share of start and target whose tube is no faster than the limit.

The limit is ROUTE_DETOUR_LIMIT times the shortest route over t_c, or SPEED_FACTOR_LIMIT times the slowest tube that is found
where that is more. Routes are searched first, for they are quicker than tubes: the widest share with a route within the limit;
then tubes, from there down. design/refine.py calls this; moving_search.py and mission_search.py override it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import SolverCache
from stt_codegen.design.missions import Mission
from stt_codegen.design.routes import Route, bounds_along_route, bounds_by_stretch, choose_sides, find_route, shortest_route
from stt_codegen.design.spline_tubes.slowest_tube import CLOSE_TO_BOUND, SplineTube, slowest_tube
from stt_codegen.design.spline_tubes.stretch_times import changes_at, minimum_times, time_plans
from stt_codegen.task import Task

SEGMENT_COUNTS = (32, 48, 64, 96, 128, *(1 << k for k in range(8, 14)))  # tried in this order when the task names no number
TIMED_SEGMENT_COUNTS = (64, 96, 128, 192, 256)  # where sets move: segments are the steps of time too
SEGMENTS_PER_SET = (0.5, 8)  # between so many times the number of unsafe sets, but always up to MANY_OBSTACLES
MANY_OBSTACLES = 128  # unsafe sets; above, sides come from the stretches alone
SEGMENT_TRIALS = 2  # numbers of segments that are tried for every width
ROUNDING_SHARE = 0.25  # of the allowance for differences, which is 32 steps
# By order: how much longer than the shortest a route may be, and how much faster than its length over t_c a tube, for width. With
# inertia width is worth more than pace: what the plant bounds take at an edge goes with 1/width (of 24 arenas the proved period
# in the median is 61 ms at 1.4, 95 ms at 2, 93 ms at 3).
ROUTE_DETOUR_LIMIT = {1: 1.4, 2: 2.0}
SPEED_FACTOR_LIMIT = 1.25  # a tube may be so many times as fast as the slowest that is found, where that is more
FAMILY_SHARES = (1.0, 0.9, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1)  # of the widest share with a route: the tubes that are compared
FIRST_SHARES = (1.0, 0.95)  # of the widest share: a spline loses a segment at each end of a tight passage
# Shares that are tried between the minimum width and one that is too fast: where the speed between them would meet the limit, but
# at least and at most so much of the difference.
INTERPOLATION_COUNT = 3
INTERPOLATION_RANGE = (0.35, 0.9)
SHARE_TOLERANCE = 0.02  # of start and target, to which the widest share is found
PACES = ((0.0, 0.0), (1.0, 0.0))  # segments of rest at every corner of a route; the share of the time to get up to speed
INERTIAL_PACES = ((0.0, 0.5), (0.0, 0.25), (1.0, 0.25))  # the same for order 2
HOPELESS_SPEED_FACTOR = 1.12  # more segments do not mend a tube this much faster than the limit
# A tube this many times as fast as its route over t_c is slow enough to try no rests at corners, and no longest sides.
REST_SPEED_FACTOR, SIDE_SPEED_FACTOR = 1.08, 1.1
MORE_SEGMENTS_GAIN = 0.97  # more segments count where the tube is slower by that
MANY_OBSTACLES_SHARES = (1.0, 0.5)  # of many unsafe sets: the shares that are tried before the minimum width,
MANY_OBSTACLES_DETOUR = 1.1  # where the route is at most so much longer than the shortest


@dataclass(frozen=True)
class TubeSearch:
    """The search for a tube: an arena (t_c the unit of time), gamma(0), the numbers of segments to try, and the mission.

    A width is a share of the narrower of start and target in every dimension, and is never less than min_width.
    """

    arena: Arena
    start: Array
    segment_counts: tuple[int, ...]
    solver_cache: SolverCache = field(default_factory=SolverCache)
    mission: Mission | None = None

    def width(self, share: float) -> Array:
        """Return the width of a share, (n,)."""
        full = np.minimum(self.start[1] - self.start[0], self.arena.target[1] - self.arena.target[0])
        return np.asarray(np.maximum(share * full, self.arena.min_widths))

    def peak_speed_limit(self, segments: int) -> float:
        """Return the largest peak speed that max_speed allows, less what rounding the control points may add.

        That is 6 steps to a difference of two, a fifth of the allowance. For order 2 the programs know all limits.
        """
        if self.arena.order == 2:
            return np.inf
        return self.arena.max_speed - ROUNDING_SHARE * self.arena.difference_allowance * segments

    def meets_speed_limits(self, tube: SplineTube) -> bool:
        """Return whether every dimension keeps to its own bound on speed."""
        if self.arena.order == 2:
            return True
        speeds = tube.paces * self.arena.relative_speeds * tube.segments
        allowance = ROUNDING_SHARE * self.arena.difference_allowance * tube.segments
        return bool((speeds <= self.arena.max_speeds - allowance).all())

    def is_within(self, tube: SplineTube, speed_limit: float) -> bool:
        return tube.speed <= min(speed_limit, self.peak_speed_limit(tube.segments))

    @property
    def shortest_distance(self) -> float:
        """How far the centre must go at least, in the largest component: no tube is slower."""
        half, centre, target = self.arena.min_widths / 2, (self.start[0] + self.start[1]) / 2, self.arena.target
        apart = np.maximum(np.maximum(target[0] + half - centre, centre - target[1] + half), 0)
        return float(self.arena.distance(apart[None])[0])

    def find_widest(self) -> SplineTube | None:
        """Return the widest tube along a route of at most ROUTE_DETOUR_LIMIT times the shortest, no faster than its time allows.

        Where no tube is within the limit, return the slowest of all that were found.
        """
        full_route, detour = self._route(1.0), ROUTE_DETOUR_LIMIT[self.arena.order]
        full: SplineTube | None = None
        if full_route is not None and full_route.length <= detour * self.shortest_distance:
            full = self._find_along(1.0, full_route, detour * self.shortest_distance)
            if full is not None and self.is_within(full, detour * self.shortest_distance):
                return full
        shortest = shortest_route(self.arena, self.start, self.width(0.0))
        limit = detour * shortest.length
        if full is not None and self.is_within(full, limit):
            return full
        share, route = self._widest_route(full_route, shortest, limit)
        candidates = [] if full is None else [full]
        for part in FIRST_SHARES:
            if part * share == 1.0 and full is not None:
                continue
            part_route = route if part == 1.0 else self._route(part * share)
            tube = None if part_route is None else self._find_along(part * share, part_route, limit)
            if tube is not None and self.is_within(tube, limit):
                return tube
            candidates += [] if tube is None else [tube]
        # no tube is wide at once: how slow is a tube at all?
        slow = self._find_along(0.0, shortest, HOPELESS_SPEED_FACTOR * shortest.length, self.segment_counts[:1], tries_sides=True)
        if slow is not None:
            limit = max(limit, SPEED_FACTOR_LIMIT * slow.speed)
            if full is not None and self.is_within(full, limit):
                return full
            fast_speed = candidates[-1].speed if candidates else np.inf
            widened = self._widen(slow, share * FIRST_SHARES[-1], fast_speed, limit)
            if widened is not None:
                return widened
            candidates.append(slow)
        last = self.find_slowest(shortest)
        candidates += [] if last is None else [last]
        return min(candidates, key=lambda tube: tube.speed, default=None)

    def generate_family(self) -> Iterator[SplineTube]:
        """Yield tubes of several widths, the widest first, each the slowest that is found along a route of its own.

        The last one has the minimum width and any number of segments.
        """
        shortest = shortest_route(self.arena, self.start, self.width(0.0))
        share, _ = self._widest_route(self._route(1.0), shortest, np.inf)
        for part in (*FAMILY_SHARES, 0.0):
            route = self._route(part * share) if part else shortest
            if not part:
                tube = self.find_slowest(shortest)
            else:
                tube = None if route is None else self._find_along(part * share, route, CLOSE_TO_BOUND * route.length)
            if tube is not None and self.meets_speed_limits(tube):
                yield tube

    def find_slowest(self, route: Route | None = None) -> SplineTube | None:
        """Return a tube of the minimum width along the shortest route, with any number of segments that may be tried."""
        route = route or shortest_route(self.arena, self.start, self.width(0.0))
        return self._find_along(0.0, route, CLOSE_TO_BOUND * route.length, self.segment_counts, tries_sides=True)

    def find_among_many_obstacles(self) -> SplineTube | None:
        """Return a tube whose sides and times come from the linear program of stretches alone, for a few widths."""
        shortest = shortest_route(self.arena, self.start, self.width(0.0))
        candidates: list[SplineTube] = []
        for share in (*MANY_OBSTACLES_SHARES, 0.0):
            route = self._route(share) if share else shortest
            if route is None or route.length > MANY_OBSTACLES_DETOUR * shortest.length:
                continue
            for segments in self.segment_counts[:1] if share else self.segment_counts:
                tube = self._tube_on_longest_sides(self.width(share), route, segments)
                if tube is not None and tube.speed <= self.peak_speed_limit(segments):
                    return tube
                candidates += [] if tube is None else [tube]
        return min(candidates, key=lambda tube: tube.speed, default=None)

    def _route(self, share: float, longest: float = np.inf) -> Route | None:
        return find_route(self.arena, self.start, self.width(share), longest)

    def _widest_route(self, full_route: Route | None, shortest: Route, limit: float) -> tuple[float, Route]:
        """Return the largest share whose route is not longer than the limit, to SHARE_TOLERANCE, and that route."""
        if full_route is not None and full_route.length <= limit:
            return 1.0, full_route
        low, high, best = 0.0, 1.0, shortest
        while high - low > SHARE_TOLERANCE:
            middle = (low + high) / 2
            route = self._route(middle, limit)
            if route is not None:
                low, best = middle, route
            else:
                high = middle
        return low, best

    def _widen(self, slow: SplineTube, share: float, speed: float, limit: float) -> SplineTube | None:
        """Return the widest tube within the limit between the minimum width, which `slow` has, and a share that is too fast."""
        best = slow if self.is_within(slow, limit) else None
        low, low_speed = 0.0, slow.speed
        for _ in range(INTERPOLATION_COUNT):
            if best is None:
                break
            part = (limit - low_speed) / (speed - low_speed) if low_speed < limit < speed < np.inf else 0.5
            middle = low + (share - low) * min(max(part, INTERPOLATION_RANGE[0]), INTERPOLATION_RANGE[1])
            route = self._route(middle)
            tube = None if route is None else self._find_along(middle, route, limit)
            if tube is not None and self.is_within(tube, limit):
                best, low, low_speed = tube, middle, tube.speed
            else:
                share, speed = middle, np.inf if tube is None else tube.speed
        return best

    def _find_along(
        self, share: float, route: Route, limit: float, segment_counts: Sequence[int] = (), *, tries_sides: bool = False
    ) -> SplineTube | None:
        """Return a tube of that share along the route, with the fewest segments that keep it within the limit, else the slowest.

        tries_sides: whether to try the sides that last longest too, where the tube is not slow enough.
        """
        best: SplineTube | None = None
        width = self.width(share)
        for segments in segment_counts or self.segment_counts[:SEGMENT_TRIALS]:
            tube = self._tube_following(width, route, segments, limit)
            if tries_sides and (tube is None or tube.speed > min(limit, SIDE_SPEED_FACTOR * route.length)):
                sides_tube = self._tube_on_longest_sides(width, route, segments)
                tube = sides_tube if tube is None or (sides_tube is not None and sides_tube.pace < tube.pace) else tube
            if tube is None:
                continue
            if best is None or tube.speed < MORE_SEGMENTS_GAIN * best.speed:
                best = tube
            if self.is_within(tube, limit) or (not segment_counts and tube.speed > HOPELESS_SPEED_FACTOR * limit):
                break
        return best

    def _tube_following(self, width: Array, route: Route, segments: int, limit: float) -> SplineTube | None:
        """Return a tube on the sides of the box that moves along the route at one speed, with or without a rest at corners."""
        best: SplineTube | None = None
        for rest, ramp in PACES if self.arena.order == 1 else INERTIAL_PACES:
            bounds = bounds_along_route(self.arena, self.start, route, width, segments=segments, corner_rest=rest, ramp=ramp)
            tube = slowest_tube(self.arena, self.start, bounds, width, route_length=route.length, solver_cache=self.solver_cache)
            if tube is not None and (best is None or tube.pace < best.pace):
                best = tube
            if best is not None and best.speed <= max(limit, REST_SPEED_FACTOR * route.length):
                break
        return best

    def _tube_on_longest_sides(self, width: Array, route: Route, segments: int) -> SplineTube | None:
        """Return a tube on the sides that last longest, with the least times of the stretches between their changes."""
        arena = self.arena
        sides = choose_sides(arena, route, self.start)
        timing = minimum_times(arena, sides, self.start, route, width) if sides is not None else None
        if sides is None or timing is None:
            return None
        for shares in time_plans(timing, segments):
            changes = changes_at(timing, sides, shares, segments)
            if changes is None:
                continue
            bounds = bounds_by_stretch(arena, sides, changes, segments)
            tube = slowest_tube(arena, self.start, bounds, width, route_length=timing.length, solver_cache=self.solver_cache)
            if tube is not None:
                return tube
        return None


def segment_counts_of(task: Task, arena: Arena) -> tuple[int, ...]:
    """Return the numbers of segments to try for a task."""
    if task.tube.segments:
        return (task.tube.segments,)
    return TIMED_SEGMENT_COUNTS if arena.timed_obstacles or task.mission else segment_counts_for(len(arena.names))


def segment_counts_for(set_count: int) -> tuple[int, ...]:
    """Return the numbers of segments to try for so many unsafe sets."""
    fewest, largest = SEGMENTS_PER_SET
    return tuple(k for k in SEGMENT_COUNTS if fewest * set_count <= k <= max(MANY_OBSTACLES, largest * set_count))
