"""The search for a tube where unsafe sets move, or are unsafe only at times: its route is in space and time.

Width is weighed as in `widest.py`, but routes cannot be compared by length: time is given, and waiting is a move. So shares are
tried from the widest down, and a tube counts by its speed.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.routes import limits_in_time
from stt_codegen.design.spacetime import leads, way_in_time
from stt_codegen.design.spline_tubes import ROOM, Search, Shape, slowest_shape

SHARES = (1.0, 0.8, 0.6, 0.4, 0.2)  # of the narrower of start and target: the widths that are tried, then the least


class TimedSearch(Search):
    """A search whose arena has timed obstacles."""

    @property
    def centre(self) -> Array:
        """Of gamma(0)."""
        return np.asarray((self.start[0] + self.start[1]) / 2)

    @property
    def shares(self) -> tuple[float, ...]:
        """Those that are wider than the least width."""
        least = self.width(0.0)
        return tuple(share for share in SHARES if (self.width(share) > least).any())

    def widest(self) -> Shape | None:
        """The widest tube that is found no faster than ROOM times the least speed; else the slowest of all that were found."""
        found: list[Shape] = []
        slowest: Shape | None = None
        for share in self.shares:
            shape = self.of_share(share)
            if shape is None:
                if not found and not self.leads():
                    return None
                continue
            if self.within(shape, ROOM[self.arena.order] * self.straight):
                return shape
            if slowest is None:
                slowest = self.slowest()
                found += [] if slowest is None else [slowest]
            found.append(shape)
            if self.within(shape, ROOM[self.arena.order] * min(s.speed for s in found)):
                return shape
        last = self.slowest() if slowest is None else slowest
        found += [] if last is None else [last]
        return min(found, key=lambda s: s.speed, default=None)

    def leads(self) -> bool:
        """Whether there is a way for the least width, with any number of segments: where there is none, none is wider."""
        return any(leads(self.arena, self.centre, self.width(0.0), segments) for segments in self.ladder)

    def family(self) -> Iterator[Shape]:
        for share in (*self.shares, 0.0):
            shape = self.of_share(share)
            if shape is not None and self.keeps(shape):
                yield shape

    def slowest(self, _route: object = None) -> Shape | None:
        return self.of_share(0.0)

    def many(self) -> Shape | None:
        return self.widest()

    def of_share(self, share: float) -> Shape | None:
        """A tube of that share, with the fewest segments that find one."""
        width = self.width(share)
        for segments in self.ladder:
            way = way_in_time(self.arena, self.centre, width, segments)
            if way is None:
                continue
            limits = limits_in_time(self.arena, self.start, way, width)
            shape = slowest_shape(self.arena, self.start, limits, width, self.straight, self.solvers)
            if shape is not None:
                return shape
        return None
