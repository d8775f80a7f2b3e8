"""The search for a tube where unsafe sets move, or are unsafe only at times: its route is in space and time.

The widest tube is sought as in spline_tubes/widest.py. But routes cannot be compared by length here, for the time is fixed and a
route may wait. So widths are tried from the widest down, and tubes are compared by their speed. `search_of` (mission_search.py)
chooses this search for an arena with timed obstacles.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.routes import bounds_along_timed_route
from stt_codegen.design.spacetime import find_timed_route, has_timed_route
from stt_codegen.design.spline_tubes import ROUTE_DETOUR_LIMIT, SplineTube, TubeSearch, slowest_tube

WIDTH_SHARES = (
    1.0,
    0.8,
    0.6,
    0.4,
    0.2,
)  # of the narrower of start and target: the widths that are tried before the minimum width


class TimedSearch(TubeSearch):
    """A search whose arena has timed obstacles."""

    @property
    def centre(self) -> Array:
        """Return the centre of gamma(0), (n,)."""
        return np.asarray((self.start[0] + self.start[1]) / 2)

    @property
    def width_shares(self) -> tuple[float, ...]:
        """Return the shares to try that are wider than the minimum width, the widest first."""
        return self.wider_shares(WIDTH_SHARES)

    def wider_shares(self, shares: tuple[float, ...]) -> tuple[float, ...]:
        """Return those of the shares whose width is larger than the minimum width on some axis."""
        minimum = self.width(0.0)
        return tuple(share for share in shares if (self.width(share) > minimum).any())

    def find_widest(self) -> SplineTube | None:
        """Return the widest tube at most ROUTE_DETOUR_LIMIT times as fast as the slowest possible; else the slowest of all."""
        candidates: list[SplineTube] = []
        slowest: SplineTube | None = None
        for share in self.width_shares:
            tube = self.design_width(share)
            if tube is None:
                if not candidates and not self.has_route():
                    return None
                continue
            if self.is_within(tube, ROUTE_DETOUR_LIMIT[self.arena.order] * self.shortest_distance):
                return tube
            if slowest is None:
                slowest = self.find_slowest()
                candidates += [] if slowest is None else [slowest]
            candidates.append(tube)
            if self.is_within(tube, ROUTE_DETOUR_LIMIT[self.arena.order] * min(s.speed for s in candidates)):
                return tube
        last = self.find_slowest() if slowest is None else slowest
        candidates += [] if last is None else [last]
        return min(candidates, key=lambda s: s.speed, default=None)

    def has_route(self) -> bool:
        """Return whether some number of segments has a route of the minimum width; without one no wider tube has a route."""
        return any(has_timed_route(self.arena, self.centre, self.width(0.0), segments) for segments in self.segment_counts)

    def generate_family(self) -> Iterator[SplineTube]:
        for share in (*self.width_shares, 0.0):
            tube = self.design_width(share)
            if tube is not None and self.meets_speed_limits(tube):
                yield tube

    def find_slowest(self, _route: object = None) -> SplineTube | None:
        return self.design_width(0.0)

    def find_among_many_obstacles(self) -> SplineTube | None:
        return self.find_widest()

    def design_width(self, share: float) -> SplineTube | None:
        """Return a tube whose width is this share, with the fewest segments for which one exists; None where none is found."""
        width = self.width(share)
        for segments in self.segment_counts:
            route = find_timed_route(self.arena, self.centre, width, segments)
            if route is None:
                continue
            bounds = bounds_along_timed_route(self.arena, self.start, route, width)
            tube = slowest_tube(
                self.arena, self.start, bounds, width, route_length=self.shortest_distance, solver_cache=self.solver_cache
            )
            if tube is not None:
                return tube
        return None
