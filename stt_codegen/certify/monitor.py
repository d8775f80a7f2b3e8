"""Where a tube satisfies a formula: the algebra of Maler and Nickovic (2004) on sets of closed intervals with exact ends.

    S(state)        = where every box of the tube satisfies it, proved outside of this file
    S(f and g)      = S(f) and S(g)                           S(f or g)  = S(f) or S(g)
    S(always[a,b] f)     = { t : [t + a, t + b] in S(f) }     S(eventually[a,b] f) = { t : [t + a, t + b] meets S(f) }
    S(f until[a,b] g)    = { t : some s of [t + a, t + b] is in S(g), and [t, s] in S(f) }

The algebra is sound: a moment at which the tube satisfies a part is one at which each of its trajectories does. It is exact for
states, "and" and "always". For the others each trajectory might have a moment of its own, which is not searched for; the loss is
nothing that has a margin (docs/missions.md). certify/missions/proof.py and loop/mission.py call this file.

Where a tube repeats itself (`Cycle`), a set is stored on [0, end + length] and continues from `end` with that period. An operator
that looks b ahead needs its parts b longer. One that looks ahead for ever needs one whole cycle more, since what does not happen
in a cycle never does.
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


def union(spans: Sequence[Span]) -> list[Span]:
    """Return the union of intervals as disjoint intervals, in order."""
    disjoint: list[Span] = []
    for a, b in sorted(spans):
        if disjoint and a <= disjoint[-1][1]:
            disjoint[-1] = (disjoint[-1][0], max(b, disjoint[-1][1]))
        else:
            disjoint.append((a, b))
    return disjoint


def intersection(first: Sequence[Span], last: Sequence[Span]) -> list[Span]:
    """Return the intersection of two sets of intervals as disjoint intervals, in order."""
    return union([(max(a, c), min(b, d)) for a, b in first for c, d in last if max(a, c) <= min(b, d)])


def _ends(over: Interval) -> tuple[Fraction, Time]:
    return over.begin, math.inf if over.end is None else over.end


def _difference(a: Time, b: Time) -> Time:
    """Return a - b; an infinite a stays infinite, also if b is."""
    return a if math.isinf(a) else a - b


def satisfied(formula: Formula, proved: Proved, cycle: Cycle | None = None) -> list[Span]:
    """Return the times at which the formula holds.

    proved: where each state is known to hold; ends may be infinite. cycle: of a tube that repeats itself; then both `proved` and
    the result are stored until `cycle.known_until`.
    """
    match formula:
        case StateFormula():
            return list(proved[formula])
        case And(parts):
            in_all = satisfied(parts[0], proved, cycle)
            for part in parts[1:]:
                in_all = intersection(in_all, satisfied(part, proved, cycle))
            return in_all
        case Or(parts):
            return union([span for part in parts for span in satisfied(part, proved, cycle)])
        case Always(over, part):
            a, b = _ends(over)
            spans = [(_difference(u, a), _difference(v, b)) for u, v in _ahead(part, proved, cycle, over)]
        case Eventually(over, part):
            a, b = _ends(over)
            spans = [(_difference(u, b), _difference(v, a)) for u, v in _ahead(part, proved, cycle, over)]
        case Until(over, first, last):
            a, b = _ends(over)
            first_spans, last_spans = (_ahead(part, proved, cycle, over) for part in (first, last))
            spans = [
                (max(u, _difference(c, b)), min(v, _difference(d, a)))
                for u, v in first_spans
                for c, d in intersection([(u, v)], last_spans)
            ]
        case _:
            raise TypeError(formula)
    times = union([(u, v) for u, v in spans if u <= v])
    return times if cycle is None else cycle.cut(times, cycle.known_until)


def _ahead(part: Formula, proved: Proved, cycle: Cycle | None, over: Interval) -> list[Span]:
    """Return where a part holds, as far as an operator with this interval looks ahead."""
    spans = satisfied(part, proved, cycle)
    if cycle is None:
        return spans
    until = cycle.horizon(over)
    endless = until if over.end is None else None  # an interval up to there never ends
    return [(u, math.inf if v == endless else v) for u, v in cycle.unroll(spans, until)]


def erode(spans: Sequence[Span], margin: Fraction) -> list[Span]:
    """Return what is left of intervals whose ends may each be wrong by `margin` seconds."""
    return [(a + margin, b - margin) for a, b in spans if a + margin <= b - margin]


def holds(formula: Formula, proved: Proved, margin: Fraction = Fraction(0), cycle: Cycle | None = None) -> bool:
    """Return whether the formula holds at time 0 for every clock error up to `margin` seconds.

    proved: as for `satisfied`, but for a tube that repeats itself until the end of its cycle.
    """
    if cycle is None:
        certain = {state: erode(spans, margin) for state, spans in proved.items()}
    elif margin > cycle.length:  # no set is stored so long that its eroded rest would have this period
        return False
    else:
        until = cycle.known_until + margin
        longer = {state: cycle.unroll(cycle.repeat_once(spans), until) for state, spans in proved.items()}
        certain = {state: cycle.cut(erode(spans, margin), cycle.known_until) for state, spans in longer.items()}
    return any(a <= 0 <= b for a, b in satisfied(formula, certain, cycle))


@dataclass(frozen=True)
class Cycle:
    """The part of a tube from `begin` to `end`, seconds, which repeats for ever."""

    begin: Fraction
    end: Fraction

    @property
    def length(self) -> Fraction:
        """The period, in seconds."""
        return self.end - self.begin

    @property
    def known_until(self) -> Fraction:
        """The time until which sets are stored; a later time is like one a whole number of cycles before."""
        return self.end + self.length

    def horizon(self, over: Interval) -> Fraction:
        """Return the time until which an operator with this interval needs a set."""
        return self.known_until + (over.begin + self.length if over.end is None else over.end)

    def repeat_once(self, spans: Sequence[Span]) -> list[Span]:
        """Return a set that is stored until `end` continued until `known_until`."""
        again = [(max(u, self.begin) + self.length, v + self.length) for u, v in spans if v >= self.begin]
        return union([*spans, *again])

    def extend_for_ever(self, spans: Sequence[Span]) -> list[Span]:
        """Return the set with intervals that fill the last stored cycle made endless."""
        return [(u, math.inf if v == self.known_until and u <= self.end else v) for u, v in spans]

    def unroll(self, spans: Sequence[Span], until: Fraction) -> list[Span]:
        """Return a set that is stored until `known_until` continued until a later time."""
        longer, k = list(spans), 1
        while self.known_until + (k - 1) * self.length < until:
            longer += [(max(u, self.end) + k * self.length, v + k * self.length) for u, v in spans if v >= self.end]
            k += 1
        return self.cut(union(longer), until)

    def cut(self, spans: Sequence[Span], until: Fraction) -> list[Span]:
        """Return the part of a set that is not after a time."""
        return [(u, min(v, until)) for u, v in spans if u <= until]


@dataclass(frozen=True)
class Witness:
    """An interval that satisfies a part of the mission: the state holds from `begin` to `end`, seconds."""

    state: StateFormula
    begin: Time
    end: Time


def witnesses(formula: Formula, proved: Proved, cycle: Cycle | None = None, now: Time = Fraction(0)) -> Iterator[Witness]:
    """Yield intervals that prove the formula at a time at which it holds: for each "eventually" the earliest that is enough.

    proved: as for `satisfied`. now: after the first cycle, the time in it that is like it counts.
    """
    if cycle is not None and now > cycle.end:
        now = cycle.begin + (Fraction(now) - cycle.begin) % cycle.length
    match formula:
        case StateFormula():
            yield Witness(formula, *next((a, b) for a, b in proved[formula] if a <= now <= b))
        case And(parts):
            for part in parts:
                yield from witnesses(part, proved, cycle, now)
        case Or(parts):
            true_part = next(p for p in parts if any(a <= now <= b for a, b in satisfied(p, proved, cycle)))
            yield from witnesses(true_part, proved, cycle, now)
        case Always(over, part):
            if isinstance(part, StateFormula):
                yield from witnesses(part, proved, cycle, now + over.begin)
            else:  # it holds again and again: yield all intervals, of a cycle those of the first one
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
                for c, d in intersection([(u, v)], _ahead(last, proved, cycle, over)):
                    if u <= now <= v and max(c, now + a) <= min(d, now + b):
                        yield from witnesses(last, proved, cycle, max(c, now + a))
                        return
