"""What a formula asks of an order of events: skeletons, of which each is enough for it.

"always" makes a hold, "eventually" an event, again and again a chain of events, "or" in time a choice: one skeleton for each.
What they do not cover is more witnesses in a chain than MORE above the fewest, and more than one change of mind in an "or" over
an interval, in a tube that repeats itself more than one there and back. Every bound is moved in by `margin`, so that the clock
has room. The certificate knows nothing of all this: it looks at the tube (certify/missions/proof.py).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stt_codegen.design.missions.skeleton import END, SEAM, START, TINY, Hold, Skeleton
from stt_codegen.task.mission import Always, And, Eventually, Formula, Interval, Or, State, Until

MORE = 2  # witnesses of "again and again" beyond the fewest that can do
MOST = 400  # skeletons that are looked at
MOST_CYCLIC = 1_200  # of a tube that repeats itself, for each time at which the cycle may begin
MOST_OTHERS = 100  # of those that are tried last, for a tube that repeats itself: each may take some tenths of a second
MOST_EVENTS = 40
SLACK = 0.05  # of t_c that a hold may be longer than asked


def skeletons(formula: Formula, t_c: Fraction, margin: float, doubt: float = 0.0) -> list[Skeleton]:
    """Those whose times can be satisfied, with the fewest events first; last those in which a hold of an event that may be chosen
    goes on for ever, at t_c. doubt: by how much of t_c the clock may be late."""
    found: list[Skeleton] = []
    for late in (False, True):
        every = _possible(_Expansion(float(t_c), margin, doubt, late).at(formula, START, START, Skeleton()))
        found += [one for one in every if one not in found]
    return found


def cyclic(formula: Formula, t_c: Fraction, margin: float, seams: Sequence[float]) -> tuple[list[Skeleton], list[Skeleton]]:
    """Those of a tube that repeats itself: with no more events than the first one for their lead-in, and the others. seams: when
    the cycle may begin, in parts of t_c."""
    first: list[Skeleton] = []
    others: list[Skeleton] = []
    for seam in seams:
        every = _Expansion(float(t_c), margin, 0.0, False).at(formula, START, START, Skeleton.begun(seam))
        one = next(every, None)
        for other in _possible(itertools.chain([] if one is None else [one], every), MOST_CYCLIC):
            (first if one is not None and other.events <= one.events else others).append(other)
    return first, sorted(others, key=lambda other: other.events)[:MOST_OTHERS]


def _possible(found: Iterator[Skeleton], most: int = MOST) -> list[Skeleton]:
    """Of the first so many those that have times, with the fewest events first; of equals the first."""
    possible = [one for one in itertools.islice(found, most) if one.events <= MOST_EVENTS and one.zone is not None]
    return sorted((one for one in dict.fromkeys(possible) if not one.contradicts), key=lambda one: one.events)


@dataclass(frozen=True)
class _Expansion:
    """late: whether holds may go on for ever at t_c, where the tube stands, in place of their length."""

    t_c: float
    margin: float
    doubt: float
    late: bool

    def at(self, formula: Formula, first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        """`to` with what it takes that the formula holds at all times from one event to another."""
        match formula:
            case State():
                yield to.holding(Hold(formula, first, last))
            case And(parts):
                yield from self._all(tuple(dict.fromkeys(parts)), first, last, to)
            case Or(parts):
                yield from self._or(parts, first, last, to)
            case Always(over, part):
                yield from self._always(over, part, first, last, to)
            case Eventually(over, part) if over.begin == over.end:  # one moment: no choice
                yield from self._always(over, part, first, last, to)
            case Eventually(over, part):
                if first == last:
                    when, here = self._witness(to, first, over)
                    yield from self.at(part, when, when, here)
                else:
                    for _, here in self._chains(over, part, first, last, to):
                        yield here
            case Until(over, held, reached):
                for when, here in self._reached(over, reached, first, last, to):
                    for more in self.at(held, first, when, here):
                        yield more.lengthened(len(here.holds), when)

    def _or(self, parts: tuple[Formula, ...], first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        if to.zone is None:  # no times: not worth a choice
            return
        for part in parts:
            yield from self.at(part, first, last, to)
        if first != last:
            for one, other in itertools.permutations(parts, 2):
                cut, change = to.event(first, 0.0, np.inf)
                cut = cut.differing(change, last, 0.0, np.inf)
                for early in self.at(one, first, change, cut):
                    yield from self.at(other, change, last, early)
                if to.seam is not None:  # what is repeated ends as it begins
                    again, back = cut.event(change, 0.0, np.inf)
                    again = again.differing(back, last, 0.0, np.inf)
                    for early in self.at(one, first, change, again):
                        for late in self.at(other, change, back, early):
                            yield from self.at(one, back, last, late)

    def _always(self, over: Interval, part: Formula, first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        begin, here = self._begun(to, first, over.begin)
        for end, longer in self._ended(here, last, over.end):
            again = to.seam is not None and end == END and begin != START and (over.end is None or last == END)
            for once in self.at(part, begin, end, longer):
                yield from self.at(part, SEAM, END, once) if again else [once]

    def _reached(self, over: Interval, part: Formula, first: int, last: int, to: Skeleton) -> Iterator[tuple[int, Skeleton]]:
        """The last of the witnesses of an "until" at all times from one event to another; until then its first part is held."""
        if first != last:
            yield from self._chains(over, part, first, last, to)
            return
        when, here = self._witness(to, first, over)
        for there in self.at(part, when, when, here):
            yield when, there

    def _all(self, parts: tuple[Formula, ...], first: int, last: int, to: Skeleton) -> Iterator[Skeleton]:
        if not parts:
            yield to
            return
        for here in self.at(parts[0], first, last, to):
            yield from self._all(parts[1:], first, last, here)

    def _begun(self, to: Skeleton, event: int, by: Fraction) -> tuple[int, Skeleton]:
        """The begin of a hold, so many seconds after an event or a little before that: a hold may only be longer."""
        off, room = float(by) / self.t_c, self.margin
        if event == END or off <= room or (event == START and off >= 1):
            return (END if event == START and off >= 1 else event), to
        found, when = to.event(event, max(off - room - SLACK, 0.0), off - room, room)
        return when, found

    def _ended(self, to: Skeleton, event: int, by: Fraction | None) -> Iterator[tuple[int, Skeleton]]:
        """The end of a hold, so many seconds after an event or a little after that. From near t_c on that is t_c, for the tube
        stands from then on."""
        off, room = math.inf if by is None else float(by) / self.t_c, self.margin
        if event == END or (event == START and off >= 1 - 2 * room) or math.isinf(off):
            yield END, to
            return
        found, when = to.event(event, off + room, off + room + SLACK, room)
        yield when, found
        if self.late and event != START:
            yield END, to.differing(event, END, 0.0, off)

    def _witness(self, to: Skeleton, event: int, over: Interval) -> tuple[int, Skeleton]:
        """A moment of the interval after an event."""
        least = float(over.begin) / self.t_c
        most = math.inf if over.end is None else float(over.end) / self.t_c
        if event == END:
            return event, to
        if event == START and most >= 1:  # what holds at t_c holds from then on
            inset = min(self.margin, max(1 - least, 0.0))
            most = math.inf if not self.doubt or most > 1 + self.doubt else 1.0 - self.doubt
        else:
            inset = min(self.margin, (most - least) / 2)
        here, when = to.event(event, least + inset if least else 0.0, most - inset, inset)
        return when, here

    def _chains(self, over: Interval, part: Formula, first: int, last: int, to: Skeleton) -> Iterator[tuple[int, Skeleton]]:
        """Witnesses w_1, w_2, .. of which each moment from first to last has one in its interval: w covers [w - b, w - a]. Where
        last is t_c, which stands for all times from then on, t_c is the last of them. The last one, and the skeleton."""
        a, b = float(over.begin) / self.t_c, math.inf if over.end is None else float(over.end) / self.t_c
        gap, zone = b - a - 2 * self.margin, to.zone
        if gap <= 0 or zone is None:
            return
        if last == END and to.seam is not None:
            yield from self._rounds(part, first, to, (a, b - self.margin, gap))
            return
        fewest = max(1, math.ceil(-zone[last, first] / gap - TINY)) - (last == END)
        for count in range(fewest, min(fewest + MORE, MOST_EVENTS - to.events) + 1):
            here, whens = to, list[int]()
            for k in range(count):
                inset = (2 if k else 1) * self.margin
                here, when = here.event(whens[-1] if k else first, 0.0 if k else a, gap if k else b - self.margin, inset)
                whens.append(when)
            if last == END:
                here = here.differing(whens[-1] if whens else first, END, 0.0, gap if whens else b, 2 * self.margin)
                whens.append(END)
            else:
                here = here.differing(last, whens[-1], a + self.margin, np.inf, self.margin)
            for there in self._each(part, whens, here):
                yield whens[-1], there

    def _rounds(
        self, part: Formula, first: int, to: Skeleton, times: tuple[float, float, float]
    ) -> Iterator[tuple[int, Skeleton]]:
        """The same for ever: witnesses before the cycle and in it, the first of it so much after its last, one cycle later.
        times: of the first witness, from and to, and from one to the next."""
        assert to.seam is not None
        assert to.zone is not None
        (least, most, gap), length = times, 1 - to.seam
        rounds = max(1, math.ceil(length / gap - TINY))
        early = near = 0  # of what need only be there at some time one in the cycle is enough
        if math.isfinite(gap):
            early = max(0, math.ceil((to.seam + to.zone[first, START] - most) / gap - TINY))
            near = max(early, round(to.seam / most))  # so many have time
        for before, count in ((near, rounds), (early if near > early else near + 1, rounds), (near, rounds + 1)):
            if to.events + before + count > MOST_EVENTS:
                continue
            here, whens = to, list[int]()
            for k in range(before + count):
                inset = (2 if k else 1) * self.margin
                here, when = here.event(whens[-1] if k else first, 0.0 if k else least, gap if k else most, inset)
                whens.append(when)
            here = here.differing(SEAM, whens[before], 0.0, np.inf)
            here = here.differing(whens[before], whens[-1], length - gap, np.inf, 2 * self.margin)
            for there in self._each(part, whens, here):
                yield whens[-1], there

    def _each(self, part: Formula, whens: list[int], to: Skeleton) -> Iterator[Skeleton]:
        if not whens:
            yield to
            return
        for here in self.at(part, whens[0], whens[0], to):
            yield from self._each(part, whens[1:], here)
