"""A skeleton: when the events of a mission may happen, and which states hold between them.

The times of any one skeleton carry out the mission; expansion.py makes the skeletons of its formula.

    events       0 is the start and 1 is t_c; all others are moments that the search chooses. Where a tube repeats itself 2 is
                 when the cycle begins that ends at t_c.
    time bounds  minimum <= t_j - t_i <= maximum
    holds        a state holds from event i to event j, or at one moment (i = j)

Times are in parts of t_c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from stt_codegen.decimals import decimal
from stt_codegen.design.half_spaces import Array
from stt_codegen.errors import BadInput
from stt_codegen.task import Task
from stt_codegen.task.mission import InRegion, StateFormula

START, END, SEAM = 0, 1, 2
TOLERANCE = 1e-9  # times and lengths that differ by less are equal
LEAD_INS = (Fraction(1, 4), Fraction(1, 8), Fraction(1, 2))  # of t_c, that are tried beside those for a round of a patrol
CYCLE_OF_ROUND = Fraction(19, 20)  # of a round that a cycle takes
SEAM_KNOTS = 32  # a cycle begins at a knot of so many segments: all numbers of segments that are tried are multiples


@dataclass(frozen=True)
class TimeBound:
    """minimum <= t_last - t_first <= maximum; inset: by how much both bounds are narrower than the mission's."""

    first: int
    last: int
    minimum: float
    maximum: float
    inset: float = 0.0


@dataclass(frozen=True)
class Hold:
    """A state that holds from one event to another; lasts_longer: also for a little longer, as a margin for the clock."""

    state: StateFormula
    first: int
    last: int
    lasts_longer: bool = False

    @property
    def is_momentary(self) -> bool:
        """Return whether the state must hold at one moment alone."""
        return self.first == self.last and not self.lasts_longer


FULL_TIME = TimeBound(START, END, 1.0, 1.0)  # from the start to t_c


@dataclass(frozen=True)
class Skeleton:
    """A number of events, the bounds on their times and the states that hold between them; seam: the time of the event SEAM."""

    event_count: int = 2
    time_bounds: tuple[TimeBound, ...] = (FULL_TIME,)
    holds: tuple[Hold, ...] = ()
    seam: float | None = None

    @classmethod
    def empty(cls, seam: float | None) -> Skeleton:
        """Return a skeleton without events to choose and without holds. seam: when the cycle begins, None without a cycle."""
        if seam is None:
            return cls()
        return cls(3, (FULL_TIME, TimeBound(START, SEAM, seam, seam)), (), seam)

    def with_event(self, first: int, minimum: float, maximum: float, inset: float = 0.0) -> tuple[Skeleton, int]:
        """Return the skeleton with one event more, this long after the event `first`, and the number of the new event."""
        bounds = (*self.time_bounds, TimeBound(first, self.event_count, minimum, maximum, inset))
        return replace(self, event_count=self.event_count + 1, time_bounds=bounds), self.event_count

    def with_time_bound(self, bound: TimeBound) -> Skeleton:
        """Return the skeleton with one time bound more."""
        return replace(self, time_bounds=(*self.time_bounds, bound))

    def with_hold(self, hold: Hold) -> Skeleton:
        """Return the skeleton with one hold more."""
        return replace(self, holds=(*self.holds, hold))

    def with_longer_holds(self, first_hold: int, last: int) -> Skeleton:
        """Return the skeleton in which the holds from index `first_hold` on that end at the event `last` last a little longer."""
        holds = (Hold(h.state, h.first, h.last, True) if h.last == last != END else h for h in self.holds[first_hold:])
        return replace(self, holds=(*self.holds[:first_hold], *holds))

    @cached_property
    def zone(self) -> Array | None:
        """Return the largest t_j - t_i for events i and j that all bounds allow; None where no times satisfy them."""
        return tightest_bounds(self.event_count, self.time_bounds)

    @property
    def contradicts_itself(self) -> bool:
        """Return whether the tube must visit a region at a moment at which it must stay clear of it, whatever the times."""
        zone = self.zone
        assert zone is not None
        regions = [(h.state.inner, h) for h in self.holds if isinstance(h.state.inner, InRegion)]
        for avoided, avoidance in regions:
            for visited, visit in regions if avoided.is_negated else ():
                is_within = zone[visit.first, avoidance.first] <= TOLERANCE and zone[avoidance.last, visit.first] <= TOLERANCE
                if visited.region == avoided.region and not visited.is_negated and is_within:
                    return True
        return False

    @property
    def has_windows(self) -> bool:
        """Return whether the time bounds require more than an order of the events."""
        return any(
            (bound.minimum > TOLERANCE or bound.maximum < 1 - TOLERANCE)
            and math.isfinite(bound.minimum)
            and (bound.first, bound.last) != (START, END)
            for bound in self.time_bounds
        )


def tightest_bounds(event_count: int, time_bounds: tuple[TimeBound, ...]) -> Array | None:
    """Return the closed difference-bound matrix U of the bounds: U[i, j] is the largest t_j - t_i that all of them allow.

    The bounds are edges of a graph whose shortest paths are the entries of U. Returns None where a cycle is negative, so that no
    times satisfy the bounds.
    """
    matrix = np.full((event_count, event_count), np.inf)
    np.fill_diagonal(matrix, 0.0)
    for bound in time_bounds:
        matrix[bound.first, bound.last] = min(matrix[bound.first, bound.last], bound.maximum)
        matrix[bound.last, bound.first] = min(matrix[bound.last, bound.first], -bound.minimum)
    matrix[:, START] = np.minimum(matrix[:, START], 0.0)  # no event is before the start,
    matrix[END] = np.minimum(matrix[END], 0.0)  # nor after t_c
    for k in range(event_count):
        matrix = np.minimum(matrix, matrix[:, k, None] + matrix[None, k])
    return None if (np.diag(matrix) < -TOLERANCE).any() else matrix


def seam_times(task: Task) -> list[float]:
    """Return when the cycle of a task that repeats itself may begin, in parts of t_c, in the order to try them.

    A cycle begins at a knot and lasts whole ticks. Some of the times make it as short as a round of a patrol. Raises `BadInput`
    where there is no such time.
    """
    knots, tick = task.tube.segments or SEAM_KNOTS, task.emit.tick_period
    rounds = {entry.every / task.prescribed_time for entry in task.mission if entry.every is not None and entry.until is None}
    patrol_lead_ins = [1 - Fraction(math.floor(part * knots * CYCLE_OF_ROUND), knots) for part in sorted(rounds)]
    at_knots = (Fraction(min(max(round(part * knots), 1), knots - 3), knots) for part in (*LEAD_INS, *patrol_lead_ins))
    seams = [s for s in at_knots if tick is None or ((1 - s) * task.prescribed_time / tick).denominator == 1]
    if not seams:
        parts = 8 if knots == SEAM_KNOTS else knots  # all lead-ins are multiples of one of these parts
        alternative = ", or leave tube.segments out" if task.tube.segments else ""
        length = float(task.prescribed_time / parts)
        raise BadInput(
            f"emit.tick_period: is {decimal(tick or Fraction(0))} s, and with repeat = true no cycle would last whole ticks; "
            f"use one that divides prescribed_time / {parts} = {length:.9g} s{alternative}"
        )
    return [float(s) for s in dict.fromkeys(seams)]
