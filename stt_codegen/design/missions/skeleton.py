"""An order of events: when they may happen and what is held between them. A mission is carried out by the times of any one
skeleton (expansion.py makes them of its formula).

    events       0 is the start, 1 is t_c, all others are moments that may be chosen; where a tube repeats itself 2 is when the
                 cycle begins that ends at t_c
    differences  least <= t_j - t_i <= most
    holds        a state from event i to event j, or at one moment (i = j)

Times are in parts of t_c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stt_codegen.design.half_spaces import Array
from stt_codegen.task.mission import InRegion, State

START, END, SEAM = 0, 1, 2
TINY = 1e-9


@dataclass(frozen=True)
class Difference:
    """least <= t_last - t_first <= most; `inset`: by how much both are narrower than what the mission asks."""

    first: int
    last: int
    least: float
    most: float
    inset: float = 0.0


@dataclass(frozen=True)
class Hold:
    """A state from one event to another; `longer`: and a little longer, so that the clock has room."""

    state: State
    first: int
    last: int
    longer: bool = False

    @property
    def at_once(self) -> bool:
        """Whether it is asked at one moment alone."""
        return self.first == self.last and not self.longer


@dataclass(frozen=True)
class Skeleton:
    """A number of events, and what is asked of them."""

    events: int = 2
    differences: tuple[Difference, ...] = (Difference(START, END, 1.0, 1.0),)
    holds: tuple[Hold, ...] = ()
    seam: float | None = None

    @classmethod
    def begun(cls, seam: float | None) -> Skeleton:
        """One that asks nothing yet. seam: when the cycle begins."""
        if seam is None:
            return cls()
        return cls(3, (Difference(START, END, 1.0, 1.0), Difference(START, SEAM, seam, seam)), (), seam)

    def event(self, first: int, least: float, most: float, inset: float = 0.0) -> tuple[Skeleton, int]:
        """With one event more, so long after another."""
        more = (*self.differences, Difference(first, self.events, least, most, inset))
        return replace(self, events=self.events + 1, differences=more), self.events

    def differing(self, first: int, last: int, least: float, most: float, inset: float = 0.0) -> Skeleton:
        """With one difference more."""
        return replace(self, differences=(*self.differences, Difference(first, last, least, most, inset)))

    def holding(self, hold: Hold) -> Skeleton:
        """With one hold more."""
        return replace(self, holds=(*self.holds, hold))

    def lengthened(self, count: int, last: int) -> Skeleton:
        """With all holds but the first `count` that end at an event a little longer."""
        more = (Hold(h.state, h.first, h.last, True) if h.last == last != END else h for h in self.holds[count:])
        return replace(self, holds=(*self.holds[:count], *more))

    @cached_property
    def zone(self) -> Array | None:
        """The largest t_j - t_i by i and j, all consequences drawn; None where no times satisfy the differences."""
        return closed(self.events, self.differences)

    @property
    def contradicts(self) -> bool:
        """Whether a region is to be kept off at a moment at which it must be visited, whatever the times."""
        zone = self.zone
        assert zone is not None
        regions = [(h.state.inner, h) for h in self.holds if isinstance(h.state.inner, InRegion)]
        for off, kept in regions:
            for on, h in regions if off.is_negated else ():
                within = zone[h.first, kept.first] <= TINY and zone[kept.last, h.first] <= TINY
                if on.region == off.region and not on.is_negated and within:
                    return True
        return False

    @property
    def timed(self) -> bool:
        """Whether anything but the order of events is asked."""
        return any(
            (d.least > TINY or d.most < 1 - TINY) and math.isfinite(d.least) and (d.first, d.last) != (START, END)
            for d in self.differences
        )


def closed(events: int, differences: tuple[Difference, ...]) -> Array | None:
    """A difference-bound matrix: U[i, j] bounds t_j - t_i, shortest paths drawn; None where a cycle is negative."""
    bound = np.full((events, events), np.inf)
    np.fill_diagonal(bound, 0.0)
    for d in differences:
        bound[d.first, d.last] = min(bound[d.first, d.last], d.most)
        bound[d.last, d.first] = min(bound[d.last, d.first], -d.least)
    bound[:, START] = np.minimum(bound[:, START], 0.0)  # nothing is before the start,
    bound[END] = np.minimum(bound[END], 0.0)  # nor after t_c
    for k in range(events):
        bound = np.minimum(bound, bound[:, k, None] + bound[None, k])
    return None if (np.diag(bound) < -TINY).any() else bound
