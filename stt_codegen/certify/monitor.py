"""Where a tube satisfies a formula: the algebra of Maler and Nickovic (2004) on sets of closed intervals with exact ends.

    S(state)        = where every box of the tube satisfies it, proved outside of this file
    S(f and g)      = S(f) and S(g)                           S(f or g)  = S(f) or S(g)
    S(always[a,b] f)     = { t : [t + a, t + b] in S(f) }     S(eventually[a,b] f) = { t : [t + a, t + b] meets S(f) }
    S(f until[a,b] g)    = { t : some s of [t + a, t + b] is in S(g), and [t, s] in S(f) }

Sound: a moment at which the tube does something is one at which each of its trajectories does. Exact for states, "and" and
"always"; for the others each trajectory might have a moment of its own, which is not looked for (docs/missions.md says what is
lost: nothing that has room to spare).

Where a tube repeats itself (`Cycle`), a set is told on [0, end + length] and goes on from `end` with that period. An operator
that looks b ahead needs it b longer; one that looks ahead for ever needs one whole cycle more, since what does not happen in a
cycle never does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.task.mission import Always, And, Eventually, Formula, Interval, Or, StateFormula, Until, state_formulas_of

Time = Fraction | float  # seconds, or an infinity
Span = tuple[Time, Time]  # from, to, both included
Proved = Mapping[StateFormula, Sequence[Span]]  # disjoint, in order


def united(spans: Sequence[Span]) -> list[Span]:
    """The union of intervals as disjoint ones, in order."""
    found: list[Span] = []
    for a, b in sorted(spans):
        if found and a <= found[-1][1]:
            found[-1] = (found[-1][0], max(b, found[-1][1]))
        else:
            found.append((a, b))
    return found


def shared(first: Sequence[Span], last: Sequence[Span]) -> list[Span]:
    """What is in both."""
    return united([(max(a, c), min(b, d)) for a, b in first for c, d in last if max(a, c) <= min(b, d)])


def _ends(over: Interval) -> tuple[Fraction, Time]:
    return over.begin, math.inf if over.end is None else over.end


def _less(a: Time, b: Time) -> Time:
    """a - b, where both may be infinite: what is for ever, less anything, is."""
    return a if math.isinf(a) else a - b


def satisfied(formula: Formula, proved: Proved, cycle: Cycle | None = None) -> list[Span]:
    """The times at which the formula holds. proved: where each state is known to hold; ends may be infinite. cycle: of a tube
    that repeats itself, until when these are told, and the answer."""
    match formula:
        case StateFormula():
            return list(proved[formula])
        case And(parts):
            found = satisfied(parts[0], proved, cycle)
            for part in parts[1:]:
                found = shared(found, satisfied(part, proved, cycle))
            return found
        case Or(parts):
            return united([span for part in parts for span in satisfied(part, proved, cycle)])
        case Always(over, part):
            a, b = _ends(over)
            spans = [(_less(u, a), _less(v, b)) for u, v in _ahead(part, proved, cycle, over)]
        case Eventually(over, part):
            a, b = _ends(over)
            spans = [(_less(u, b), _less(v, a)) for u, v in _ahead(part, proved, cycle, over)]
        case Until(over, first, last):
            a, b = _ends(over)
            held, reached = (_ahead(one, proved, cycle, over) for one in (first, last))
            spans = [(max(u, _less(c, b)), min(v, _less(d, a))) for u, v in held for c, d in shared([(u, v)], reached)]
        case _:
            raise TypeError(formula)
    found = united([(u, v) for u, v in spans if u <= v])
    return found if cycle is None else cycle.cut(found, cycle.known_until)


def _ahead(part: Formula, proved: Proved, cycle: Cycle | None, over: Interval) -> list[Span]:
    """Where a part holds, as far as an operator with this interval looks."""
    found = satisfied(part, proved, cycle)
    if cycle is None:
        return found
    until = cycle.looked(over)
    ever = until if over.end is None else None  # what lasts so long never ends
    return [(u, math.inf if v == ever else v) for u, v in cycle.unrolled(found, until)]


def eroded(spans: Sequence[Span], margin: Fraction) -> list[Span]:
    """What is left where every interval may be wrong by `margin` seconds at both ends."""
    return [(a + margin, b - margin) for a, b in spans if a + margin <= b - margin]


def holds(formula: Formula, proved: Proved, margin: Fraction = Fraction(0), cycle: Cycle | None = None) -> bool:
    """Whether the formula holds at time 0 whatever the clock is wrong by, up to `margin` seconds. proved: of a tube that repeats
    itself told until the end of its cycle."""
    if cycle is None:
        left = {state: eroded(spans, margin) for state, spans in proved.items()}
    elif margin > cycle.length:  # no set is told so far that what is left of it would have this period
        return False
    else:
        more = cycle.known_until + margin
        wide = {state: cycle.unrolled(cycle.doubled(spans), more) for state, spans in proved.items()}
        left = {state: cycle.cut(eroded(spans, margin), cycle.known_until) for state, spans in wide.items()}
    return any(a <= 0 <= b for a, b in satisfied(formula, left, cycle))


@dataclass(frozen=True)
class Cycle:
    """From `begin` to `end`, seconds, and then again and again."""

    begin: Fraction
    end: Fraction

    @property
    def length(self) -> Fraction:
        return self.end - self.begin

    @property
    def known_until(self) -> Fraction:
        """Until when sets are told; later times have what was a whole number of cycles before."""
        return self.end + self.length

    def looked(self, over: Interval) -> Fraction:
        """Until when a set must be told for an operator that looks so far ahead."""
        return self.known_until + (over.begin + self.length if over.end is None else over.end)

    def doubled(self, spans: Sequence[Span]) -> list[Span]:
        """From what holds before `end` what holds until `known_until`."""
        again = [(max(u, self.begin) + self.length, v + self.length) for u, v in spans if v >= self.begin]
        return united([*spans, *again])

    def endless(self, spans: Sequence[Span]) -> list[Span]:
        """The same where what lasts the whole of the last cycle that is told is for ever."""
        return [(u, math.inf if v == self.known_until and u <= self.end else v) for u, v in spans]

    def unrolled(self, spans: Sequence[Span], until: Fraction) -> list[Span]:
        """The same set until a time after `known_until`."""
        found, k = list(spans), 1
        while self.known_until + (k - 1) * self.length < until:
            found += [(max(u, self.end) + k * self.length, v + k * self.length) for u, v in spans if v >= self.end]
            k += 1
        return self.cut(united(found), until)

    def cut(self, spans: Sequence[Span], until: Fraction) -> list[Span]:
        """What of it is not after a time."""
        return [(u, min(v, until)) for u, v in spans if u <= until]


@dataclass(frozen=True)
class Witness:
    """A time at which a part of the mission is served: the state holds from `begin` to `end`, seconds."""

    state: StateFormula
    begin: Time
    end: Time


def witnesses(formula: Formula, proved: Proved, cycle: Cycle | None = None, now: Time = Fraction(0)) -> Iterator[Witness]:
    """What shows that the formula holds at a time at which it does: for each "eventually" the earliest moment that will do.
    proved: as for `satisfied`; times after the first cycle are told by those in it."""
    if cycle is not None and now > cycle.end:
        now = cycle.begin + (Fraction(now) - cycle.begin) % cycle.length
    match formula:
        case StateFormula():
            yield Witness(formula, *next((a, b) for a, b in proved[formula] if a <= now <= b))
        case And(parts):
            for part in parts:
                yield from witnesses(part, proved, cycle, now)
        case Or(parts):
            good = next(p for p in parts if any(a <= now <= b for a, b in satisfied(p, proved, cycle)))
            yield from witnesses(good, proved, cycle, now)
        case Always(over, part):
            if isinstance(part, StateFormula):
                yield from witnesses(part, proved, cycle, now + over.begin)
            else:  # again and again: all of them, of a cycle those of the first
                last = math.inf if cycle is None else cycle.end
                for state in state_formulas_of(part):
                    yield from (Witness(state, u, v) for u, v in proved[state] if v >= now + over.begin and u < last)
        case Eventually(over, part):
            a, b = _ends(over)
            for u, v in _ahead(part, proved, cycle, over):
                if u <= now + b and v >= now + a:
                    yield from witnesses(part, proved, cycle, max(u, now + a))
                    return
        case Until(over, first, last):
            a, b = _ends(over)
            for u, v in _ahead(first, proved, cycle, over):
                for c, d in shared([(u, v)], _ahead(last, proved, cycle, over)):
                    if u <= now <= v and max(c, now + a) <= min(d, now + b):
                        yield from witnesses(last, proved, cycle, max(c, now + a))
                        return
