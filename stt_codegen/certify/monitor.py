"""Where a tube satisfies a formula: the algebra of Maler and Nickovic (2004) on sets of closed intervals with exact ends.

    S(state)        = where every box of the tube satisfies it, proved outside of this file
    S(f and g)      = S(f) and S(g)                           S(f or g)  = S(f) or S(g)
    S(always[a,b] f)     = { t : [t + a, t + b] in S(f) }     S(eventually[a,b] f) = { t : [t + a, t + b] meets S(f) }
    S(f until[a,b] g)    = { t : some s of [t + a, t + b] is in S(g), and [t, s] in S(f) }

Sound: a moment at which the tube does something is one at which each of its trajectories does. Exact for states, "and" and
"always"; for the others each trajectory might have a moment of its own, which is not looked for (docs/missions.md says what is
lost: nothing that has room to spare).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.task.formula import Always, And, Eventually, Formula, Interval, Or, Until
from stt_codegen.task.mission import State, states_of

Time = Fraction | float  # seconds, or an infinity
Span = tuple[Time, Time]  # from, to, both included
Proved = Mapping[State, Sequence[Span]]  # disjoint, in order


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


def satisfied(formula: Formula, proved: Proved) -> list[Span]:
    """The times at which the formula holds. proved: where each state is known to hold; ends may be infinite."""
    match formula:
        case State():
            return list(proved[formula])
        case And(parts):
            found = satisfied(parts[0], proved)
            for part in parts[1:]:
                found = shared(found, satisfied(part, proved))
            return found
        case Or(parts):
            return united([span for part in parts for span in satisfied(part, proved)])
        case Always(over, part):
            a, b = _ends(over)
            spans = [(_less(u, a), _less(v, b)) for u, v in satisfied(part, proved)]
            return united([(u, v) for u, v in spans if u <= v])
        case Eventually(over, part):
            a, b = _ends(over)
            return united([(_less(u, b), _less(v, a)) for u, v in satisfied(part, proved)])
        case Until(over, first, last):
            a, b = _ends(over)
            held, reached = satisfied(first, proved), satisfied(last, proved)
            spans = [(max(u, _less(c, b)), min(v, _less(d, a))) for u, v in held for c, d in shared([(u, v)], reached)]
            return united([(u, v) for u, v in spans if u <= v])
    raise TypeError(formula)


def eroded(spans: Sequence[Span], margin: Fraction) -> list[Span]:
    """What is left where every interval may be wrong by `margin` seconds at both ends."""
    return [(a + margin, b - margin) for a, b in spans if a + margin <= b - margin]


def holds(formula: Formula, proved: Proved, margin: Fraction = Fraction(0)) -> bool:
    """Whether the formula holds at time 0 whatever the clock is wrong by, up to `margin` seconds."""
    return any(a <= 0 <= b for a, b in satisfied(formula, {state: eroded(spans, margin) for state, spans in proved.items()}))


@dataclass(frozen=True)
class Witness:
    """A time at which a part of the mission is served: the state holds from `begin` to `end`, seconds."""

    state: State
    begin: Time
    end: Time


def witnesses(formula: Formula, proved: Proved, now: Time = Fraction(0)) -> Iterator[Witness]:
    """What shows that the formula holds at a time at which it does: for each "eventually" the earliest moment that will do."""
    match formula:
        case State():
            yield Witness(formula, *next((a, b) for a, b in proved[formula] if a <= now <= b))
        case And(parts):
            for part in parts:
                yield from witnesses(part, proved, now)
        case Or(parts):
            good = next(p for p in parts if any(a <= now <= b for a, b in satisfied(p, proved)))
            yield from witnesses(good, proved, now)
        case Always(over, part):
            if isinstance(part, State):
                yield from witnesses(part, proved, now + over.begin)
            else:  # again and again: all of them
                for state in states_of(part):
                    yield from (Witness(state, u, v) for u, v in proved[state] if v >= now + over.begin)
        case Eventually(over, part):
            a, b = _ends(over)
            for u, v in satisfied(part, proved):
                if u <= now + b and v >= now + a:
                    yield from witnesses(part, proved, max(u, now + a))
                    return
        case Until(over, first, last):
            a, b = _ends(over)
            for u, v in satisfied(first, proved):
                for c, d in shared([(u, v)], satisfied(last, proved)):
                    if u <= now <= v and max(c, now + a) <= min(d, now + b):
                        yield from witnesses(last, proved, max(c, now + a))
                        return
