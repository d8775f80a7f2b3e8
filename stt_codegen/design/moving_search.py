"""The search for a tube where unsafe sets move, or are unsafe only at times: its route is in space and time.

The widest tube is sought as in spline_tubes/widest.py. But routes cannot be compared by length here, for the time is fixed and a
route may wait. So widths are tried from the widest down, and tubes are compared by their speed. `search_of` (mission_search.py)
chooses this search for an arena with timed obstacles.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.routes import limits_in_time
from stt_codegen.design.spacetime import leads, way_in_time
from stt_codegen.design.spline_tubes import ROOM, Search, Shape, slowest_shape

WIDTH_SHARES = (
    1.0,
    0.8,
    0.6,
    0.4,
    0.2,
)  # of the narrower of start and target: the widths that are tried before the minimum width


class TimedSearch(Search):
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

    def widest(self) -> Shape | None:
        """Return the widest tube that is at most ROOM times as fast as the slowest possible one; else the slowest of all."""
        candidates: list[Shape] = []
        slowest: Shape | None = None
        for share in self.width_shares:
            shape = self.design_width(share)
            if shape is None:
                if not candidates and not self.has_route():
                    return None
                continue
            if self.within(shape, ROOM[self.arena.order] * self.straight):
                return shape
            if slowest is None:
                slowest = self.slowest()
                candidates += [] if slowest is None else [slowest]
            candidates.append(shape)
            if self.within(shape, ROOM[self.arena.order] * min(s.speed for s in candidates)):
                return shape
        last = self.slowest() if slowest is None else slowest
        candidates += [] if last is None else [last]
        return min(candidates, key=lambda s: s.speed, default=None)

    def has_route(self) -> bool:
        """Return whether some number of segments has a route of the minimum width; without one no wider tube has a route."""
        return any(leads(self.arena, self.centre, self.width(0.0), segments) for segments in self.ladder)

    def family(self) -> Iterator[Shape]:
        for share in (*self.width_shares, 0.0):
            shape = self.design_width(share)
            if shape is not None and self.keeps(shape):
                yield shape

    def slowest(self, _route: object = None) -> Shape | None:
        return self.design_width(0.0)

    def many(self) -> Shape | None:
        return self.widest()

    def design_width(self, share: float) -> Shape | None:
        """Return a tube whose width is this share, with the fewest segments for which one exists; None where none is found."""
        width = self.width(share)
        for segments in self.ladder:
            route = way_in_time(self.arena, self.centre, width, segments)
            if route is None:
                continue
            limits = limits_in_time(self.arena, self.start, route, width)
            shape = slowest_shape(self.arena, self.start, limits, width, self.straight, self.solvers)
            if shape is not None:
                return shape
        return None
