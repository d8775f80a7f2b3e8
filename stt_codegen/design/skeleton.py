"""What a formula asks of an order of events: skeletons, of which each is enough for it.

    events       0 is the start, 1 is t_c, all others are moments that may be chosen
    differences  least <= t_j - t_i <= most
    holds        a state from event i to event j, or at one moment (i = j)

"always" makes a hold, "eventually" an event, again and again a chain of events, "or" in time a choice: one skeleton for each.
What they do not cover is more witnesses in a chain than MORE above the fewest, and more than one change of mind in an "or" over
an interval. Times are in parts of t_c; every bound is moved in by `margin`, so that the clock has room. The certificate knows
nothing of all this: it looks at the tube (certify/mission.py).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from stt_codegen.design.faces import Array
from stt_codegen.task.formula import Always, And, Eventually, Formula, Interval, Or, Until
from stt_codegen.task.mission import State

START, END = 0, 1
MORE = 2  # witnesses of "again and again" beyond the fewest that can do
MOST = 400  # skeletons that are looked at
MOST_EVENTS = 40
SLACK = 0.05  # of t_c that a hold may be longer than asked
TINY = 1e-9


@dataclass(frozen=True)
class Difference:
    """least <= t_last - t_first <= most."""

    first: int
    last: int
    least: float
    most: float


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

    def event(self, first: int, least: float, most: float) -> tuple[Skeleton, int]:
        """With one event more, so long after another."""
        more = (*self.differences, Difference(first, self.events, least, most))
        return Skeleton(self.events + 1, more, self.holds), self.events

    def differing(self, first: int, last: int, least: float, most: float) -> Skeleton:
        """With one difference more."""
        return Skeleton(self.events, (*self.differences, Difference(first, last, least, most)), self.holds)

    def holding(self, hold: Hold) -> Skeleton:
        """With one hold more."""
        return Skeleton(self.events, self.differences, (*self.holds, hold))

    def lengthened(self, count: int, last: int) -> Skeleton:
        """With all holds but the first `count` that end at an event a little longer."""
        more = (Hold(h.state, h.first, h.last, True) if h.last == last != END else h for h in self.holds[count:])
        return Skeleton(self.events, self.differences, (*self.holds[:count], *more))

    @cached_property
    def zone(self) -> Array | None:
        """The largest t_j - t_i by i and j, all consequences drawn; None where no times satisfy the differences."""
        return closed(self.events, self.differences)

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


def skeletons(formula: Formula, t_c: Fraction, margin: float) -> list[Skeleton]:
    """Those whose times can be satisfied, with the fewest events first."""
    found = itertools.islice(_Expansion(float(t_c), margin).at(formula, START, START, Skeleton()), MOST)
    possible = [one for one in found if one.events <= MOST_EVENTS and one.zone is not None]
    return sorted(possible, key=lambda one: one.events)  # stable: of equals the first


@dataclass(frozen=True)
class _Expansion:
    t_c: float
    margin: float

    def at(self, formula: Formula, first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        """`to` with what it takes that the formula holds at all times from one event to another."""
        match formula:
            case State():
                yield to.holding(Hold(formula, first, last))
            case And(parts):
                yield from self._all(parts, first, last, to)
            case Or(parts):
                for part in parts:
                    yield from self.at(part, first, last, to)
                if first != last:
                    for one, other in itertools.permutations(parts, 2):
                        cut, change = to.event(first, 0.0, np.inf)
                        cut = cut.differing(change, last, 0.0, np.inf)
                        for early in self.at(one, first, change, cut):
                            yield from self.at(other, change, last, early)
            case Always(over, part):
                begin, here = self._moved(to, first, over.begin, -1)
                end, here = self._moved(here, last, over.end, 1)
                yield from self.at(part, begin, end, here)
            case Eventually(over, part):
                if first == last:
                    for when, here in self._witness(to, first, over):
                        yield from self.at(part, when, when, here)
                else:
                    yield from self._chains(over, part, first, last, to)
            case Until(over, held, reached):
                if first != last:  # enough: `held` from first to the last witness
                    for here in self._chains(over, reached, first, last, to):
                        for more in self.at(held, first, here.events - 1, here):
                            yield more.lengthened(len(here.holds), here.events - 1)
                    return
                for when, here in self._witness(to, first, over):
                    for there in self.at(reached, when, when, here):
                        for more in self.at(held, first, when, there):
                            yield more.lengthened(len(there.holds), when)

    def _all(self, parts: tuple[Formula, ...], first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        if not parts:
            yield to
            return
        for here in self.at(parts[0], first, last, to):
            yield from self._all(parts[1:], first, last, here)

    def _moved(self, to: Skeleton, event: int, by: Fraction | None, sign: int) -> tuple[int, Skeleton]:
        """An event so many seconds after another: a little before that (sign -1) or after it, as the end of a hold that may only
        be longer. From near t_c on that is t_c, for the tube stands from then on."""
        off, room = math.inf if by is None else float(by) / self.t_c, self.margin
        if event == END or (event == START and off >= 1 - 2 * room) or math.isinf(off):
            return END, to
        if not off and sign < 0:
            return event, to
        least, most = (max(off - SLACK, 0.0), off - room) if sign < 0 else (off + room, off + SLACK)
        found, when = to.event(event, least, max(least, most))
        return when, found

    def _witness(self, to: Skeleton, event: int, over: Interval) -> Iterator[tuple[int, Skeleton]]:
        """A moment of the interval after an event."""
        least = float(over.begin) / self.t_c
        most = math.inf if over.end is None else float(over.end) / self.t_c
        if most <= TINY or event == END:
            yield event, to
            return
        if event == START and most >= 1:
            most = math.inf  # what holds at t_c holds from then on
        inset = min(self.margin, (most - least) / 2)
        here, when = to.event(event, least + inset if least else 0.0, most - inset)
        yield when, here

    def _chains(self, over: Interval, part: Formula, first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        """Witnesses w_1, w_2, .. of which each moment from first to last has one in its interval: w covers [w - b, w - a]. Where
        last is t_c, which stands for all times from then on, t_c is the last of them."""
        a, b = float(over.begin) / self.t_c, math.inf if over.end is None else float(over.end) / self.t_c
        gap, zone = b - a - 2 * self.margin, to.zone
        if gap <= 0 or zone is None:
            return
        fewest = max(1, math.ceil(-zone[last, first] / gap - TINY)) - (last == END)
        for count in range(fewest, fewest + MORE + 1):
            here, whens = to, list[int]()
            for k in range(count):
                here, when = here.event(whens[-1] if k else first, 0.0 if k else a, gap if k else b - self.margin)
                whens.append(when)
            if last == END:
                here = here.differing(whens[-1] if whens else first, END, 0.0, gap if whens else b)
                whens.append(END)
            else:
                here = here.differing(last, whens[-1], a + self.margin, np.inf)
            yield from self._each(part, whens, here)

    def _each(self, part: Formula, whens: list[int], to: Skeleton) -> Iterator[Skeleton]:
        if not whens:
            yield to
            return
        for here in self.at(part, whens[0], whens[0], to):
            yield from self._each(part, whens[1:], here)
