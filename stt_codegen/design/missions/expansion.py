"""The skeletons of a formula: each one is enough for the formula to hold.

"always" makes a hold, "eventually" an event, again and again a chain of events. An "or" in time is a choice, so each alternative
makes a skeleton of its own. Every bound is moved in by `margin`, so that the clock has a margin.

Some skeletons are left out: chains with more than EXTRA_WITNESSES witnesses above the smallest number, and those that change
between the alternatives of an "or" over an interval more than once (in a tube that repeats itself, more than there and back).

state_constraints.py calls this. The certificate does not depend on it: it judges the tube (certify/missions/proof.py).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from stt_codegen.design.missions.skeleton import END, SEAM, START, TOLERANCE, Hold, Skeleton, TimeBound
from stt_codegen.task.mission import Always, And, Eventually, Formula, Interval, Or, StateFormula, Until

EXTRA_WITNESSES = 2  # of "again and again" beyond the smallest number that can do
SKELETON_LIMIT = 400  # skeletons that are considered
CYCLIC_SKELETON_LIMIT = 1_200  # of a tube that repeats itself, for each time at which the cycle may begin
FALLBACK_LIMIT = 100  # of those that are tried last, for a tube that repeats itself: each may take some tenths of a second
EVENT_LIMIT = 40
HOLD_EXCESS = 0.05  # of t_c that a hold may be longer than the mission requires
Demand = tuple[Formula, int, int]  # a formula that must hold from one event to another


def expand_formula(formula: Formula, t_c: Fraction, margin: float, start_delay: float = 0.0) -> list[Skeleton]:
    """Return the skeletons whose times can be satisfied, those with the fewest events first.

    Last come those in which a hold of an event that may be chosen goes on for ever, at t_c. margin, start_delay: in parts of t_c;
    start_delay is by how much the clock may be late.
    """
    skeletons: list[Skeleton] = []
    for may_end_open in (False, True):
        expansion = _Expansion(float(t_c), margin, start_delay, may_end_open)
        expanded = _feasible(expansion.require(formula, START, START, Skeleton()))
        skeletons += [skeleton for skeleton in expanded if skeleton not in skeletons]
    return skeletons


def expand_cyclic_formula(
    formula: Formula, t_c: Fraction, margin: float, seams: Sequence[float]
) -> tuple[list[Skeleton], list[Skeleton]]:
    """Return the skeletons of a tube that repeats itself: those to try first, and those to try where no first one does.

    The first ones have no more events than the first skeleton for their lead-in. seams: when the cycle may begin; parts of t_c.
    """
    preferred: list[Skeleton] = []
    fallbacks: list[Skeleton] = []
    for seam in seams:
        expanded = _Expansion(float(t_c), margin, 0.0, False).require(formula, START, START, Skeleton.empty(seam))
        first = next(expanded, None)
        for skeleton in _feasible(itertools.chain([] if first is None else [first], expanded), CYCLIC_SKELETON_LIMIT):
            is_preferred = first is not None and skeleton.event_count <= first.event_count
            (preferred if is_preferred else fallbacks).append(skeleton)
    return preferred, sorted(fallbacks, key=lambda skeleton: skeleton.event_count)[:FALLBACK_LIMIT]


def _feasible(expanded: Iterator[Skeleton], limit: int = SKELETON_LIMIT) -> list[Skeleton]:
    """Return those of the first `limit` skeletons that have times, without repetitions, those with the fewest events first."""
    candidates = itertools.islice(expanded, limit)
    feasible = [skeleton for skeleton in candidates if skeleton.event_count <= EVENT_LIMIT and skeleton.zone is not None]
    consistent = (skeleton for skeleton in dict.fromkeys(feasible) if not skeleton.contradicts_itself)
    return sorted(consistent, key=lambda skeleton: skeleton.event_count)


class _WitnessWindow(NamedTuple):
    """When the first of several witnesses may be, after an event, and the longest time from one to the next; parts of t_c."""

    minimum: float
    maximum: float
    gap: float


@dataclass(frozen=True)
class _Expansion:
    """The expansion of a formula, whose steps extend a skeleton in each way that is enough for a part of the formula.

    margin, start_delay: in parts of t_c. may_end_open: whether holds may go on for ever at t_c, where the tube stands, in place
    of their length.
    """

    t_c: float
    margin: float
    start_delay: float
    may_end_open: bool

    def require(self, formula: Formula, first: int, last: int, skeleton: Skeleton) -> Iterator[Skeleton]:
        """Yield the skeleton with what makes the formula hold at all times from the event `first` to the event `last`."""
        match formula:
            case StateFormula():
                yield skeleton.with_hold(Hold(formula, first, last))
            case And(parts):
                yield from self._require_in_turn([(part, first, last) for part in dict.fromkeys(parts)], skeleton)
            case Or(parts):
                yield from self._require_any(parts, first, last, skeleton)
            case Always(over, part):
                yield from self._require_always(over, part, first, last, skeleton)
            case Eventually(over, part) if over.begin == over.end:  # the interval is one moment: there is no choice
                yield from self._require_always(over, part, first, last, skeleton)
            case Eventually(over, part):
                if first == last:
                    witness, extended = self._add_witness(skeleton, first, over)
                    yield from self.require(part, witness, witness, extended)
                else:
                    for _, extended in self._add_chains(over, part, first, last, skeleton):
                        yield extended
            case Until(over, before, goal):
                for witness, extended in self._reach(over, goal, first, last, skeleton):
                    for complete in self.require(before, first, witness, extended):
                        yield complete.with_longer_holds(len(extended.holds), witness)

    def _require_in_turn(self, demands: Sequence[Demand], skeleton: Skeleton) -> Iterator[Skeleton]:
        """Yield the skeleton with what makes each formula hold from its first to its last event, one demand after the other."""
        if not demands:
            yield skeleton
            return
        formula, first, last = demands[0]
        for extended in self.require(formula, first, last, skeleton):
            yield from self._require_in_turn(demands[1:], extended)

    def _require_any(self, parts: tuple[Formula, ...], first: int, last: int, skeleton: Skeleton) -> Iterator[Skeleton]:
        """Yield a skeleton for each alternative of an "or"; over an interval also for each pair of them, one after the other."""
        if skeleton.zone is None:  # no times satisfy it, so its alternatives are not worth the search
            return
        for part in parts:
            yield from self.require(part, first, last, skeleton)
        if first == last:
            return
        for part, next_part in itertools.permutations(parts, 2):
            divided, change = skeleton.with_event(first, 0.0, np.inf)
            divided = divided.with_time_bound(TimeBound(change, last, 0.0, np.inf))
            yield from self._require_in_turn([(part, first, change), (next_part, change, last)], divided)
            if skeleton.seam is not None:  # a cycle ends as it begins, so the first alternative must hold again
                divided, change_back = divided.with_event(change, 0.0, np.inf)
                divided = divided.with_time_bound(TimeBound(change_back, last, 0.0, np.inf))
                demands = [(part, first, change), (next_part, change, change_back), (part, change_back, last)]
                yield from self._require_in_turn(demands, divided)

    def _require_always(self, over: Interval, part: Formula, first: int, last: int, skeleton: Skeleton) -> Iterator[Skeleton]:
        """Yield a skeleton for each way to hold a part from the interval's begin after `first` to its end after `last`.

        Where that reaches t_c in a tube that repeats itself, the part must hold for the whole cycle too.
        """
        begin, begun = self._begin_hold(skeleton, first, over.begin)
        for end, extended in self._end_hold(begun, last, over.end):
            covers_cycle = skeleton.seam is not None and end == END and begin != START and (over.end is None or last == END)
            demands = [(part, begin, end), *([(part, SEAM, END)] if covers_cycle else [])]
            yield from self._require_in_turn(demands, extended)

    def _reach(self, over: Interval, goal: Formula, first: int, last: int, skeleton: Skeleton) -> Iterator[tuple[int, Skeleton]]:
        """Yield witnesses of the goal of an "until" for all times from `first` to `last`: the last one, and the skeleton."""
        if first != last:
            yield from self._add_chains(over, goal, first, last, skeleton)
            return
        witness, extended = self._add_witness(skeleton, first, over)
        for complete in self.require(goal, witness, witness, extended):
            yield witness, complete

    def _begin_hold(self, skeleton: Skeleton, event: int, after: Fraction) -> tuple[int, Skeleton]:
        """Return the event at which a hold begins, so many seconds after an event or a little before: it may only be longer."""
        offset = float(after) / self.t_c
        if event == START and offset >= 1:
            return END, skeleton
        if event == END or offset <= self.margin:
            return event, skeleton
        earliest = max(offset - self.margin - HOLD_EXCESS, 0.0)
        extended, begin = skeleton.with_event(event, earliest, offset - self.margin, self.margin)
        return begin, extended

    def _end_hold(self, skeleton: Skeleton, event: int, after: Fraction | None) -> Iterator[tuple[int, Skeleton]]:
        """Yield the event at which a hold ends, so many seconds after an event or a little later.

        A hold that ends near t_c or later ends at t_c, for the tube stands from then on.
        """
        offset, margin = math.inf if after is None else float(after) / self.t_c, self.margin
        if event == END or (event == START and offset >= 1 - 2 * margin) or math.isinf(offset):
            yield END, skeleton
            return
        extended, end = skeleton.with_event(event, offset + margin, offset + margin + HOLD_EXCESS, margin)
        yield end, extended
        if self.may_end_open and event != START:
            yield END, skeleton.with_time_bound(TimeBound(event, END, 0.0, offset))

    def _add_witness(self, skeleton: Skeleton, event: int, over: Interval) -> tuple[int, Skeleton]:
        """Return a new event at a moment of the interval after an event, and the skeleton with it."""
        minimum = float(over.begin) / self.t_c
        maximum = math.inf if over.end is None else float(over.end) / self.t_c
        if event == END:
            return event, skeleton
        if event == START and maximum >= 1:  # what holds at t_c holds from then on
            inset = min(self.margin, max(1 - minimum, 0.0))
            maximum = math.inf if not self.start_delay or maximum > 1 + self.start_delay else 1.0 - self.start_delay
        else:
            inset = min(self.margin, (maximum - minimum) / 2)
        extended, witness = skeleton.with_event(event, minimum + inset if minimum else 0.0, maximum - inset, inset)
        return witness, extended

    def _add_chains(
        self, over: Interval, part: Formula, first: int, last: int, skeleton: Skeleton
    ) -> Iterator[tuple[int, Skeleton]]:
        """Yield chains of witnesses w_1, w_2, .. so that each moment from `first` to `last` has one in its interval.

        A witness w serves the moments [w - b, w - a]. Where `last` is t_c, which stands for all times from then on, t_c is the
        last witness. Yields the last witness and the skeleton.
        """
        a, b = float(over.begin) / self.t_c, math.inf if over.end is None else float(over.end) / self.t_c
        gap, zone = b - a - 2 * self.margin, skeleton.zone
        if gap <= 0 or zone is None:
            return
        window = _WitnessWindow(a, b - self.margin, gap)
        if last == END and skeleton.seam is not None:
            yield from self._add_cyclic_chains(part, first, skeleton, window)
            return
        fewest = max(1, math.ceil(-zone[last, first] / gap - TOLERANCE)) - (last == END)
        for count in range(fewest, min(fewest + EXTRA_WITNESSES, EVENT_LIMIT - skeleton.event_count) + 1):
            extended, witnesses = self._chain(skeleton, first, count, window)
            if last == END:
                bound = TimeBound(witnesses[-1] if witnesses else first, END, 0.0, gap if witnesses else b, 2 * self.margin)
                extended = extended.with_time_bound(bound)
                witnesses.append(END)
            else:
                bound = TimeBound(last, witnesses[-1], a + self.margin, np.inf, self.margin)
                extended = extended.with_time_bound(bound)
            for complete in self._require_in_turn([(part, witness, witness) for witness in witnesses], extended):
                yield witnesses[-1], complete

    def _add_cyclic_chains(
        self, part: Formula, first: int, skeleton: Skeleton, window: _WitnessWindow
    ) -> Iterator[tuple[int, Skeleton]]:
        """Yield chains of witnesses for ever: before the cycle and in it, where each cycle repeats the witnesses.

        The first witness of the next cycle comes at most `window.gap` after the last one of this cycle.
        """
        assert skeleton.seam is not None
        assert skeleton.zone is not None
        length, gap = 1 - skeleton.seam, window.gap
        rounds = max(1, math.ceil(length / gap - TOLERANCE))
        fewest_before = usual_before = 0  # without a longest gap one witness in the cycle is enough
        if math.isfinite(gap):
            latest = skeleton.seam + skeleton.zone[first, START] - window.maximum
            fewest_before = max(0, math.ceil(latest / gap - TOLERANCE))
            usual_before = max(fewest_before, round(skeleton.seam / window.maximum))  # so many have time
        alternative = fewest_before if usual_before > fewest_before else usual_before + 1
        for before, count in ((usual_before, rounds), (alternative, rounds), (usual_before, rounds + 1)):
            if skeleton.event_count + before + count > EVENT_LIMIT:
                continue
            extended, witnesses = self._chain(skeleton, first, before + count, window)
            extended = extended.with_time_bound(TimeBound(SEAM, witnesses[before], 0.0, np.inf))
            bound = TimeBound(witnesses[before], witnesses[-1], length - gap, np.inf, 2 * self.margin)
            extended = extended.with_time_bound(bound)
            for complete in self._require_in_turn([(part, witness, witness) for witness in witnesses], extended):
                yield witnesses[-1], complete

    def _chain(self, skeleton: Skeleton, first: int, count: int, window: _WitnessWindow) -> tuple[Skeleton, list[int]]:
        """Return the skeleton with `count` witnesses after the event `first`, in time one after the other, and their events."""
        witnesses: list[int] = []
        for k in range(count):
            if k == 0:
                skeleton, witness = skeleton.with_event(first, window.minimum, window.maximum, self.margin)
            else:
                skeleton, witness = skeleton.with_event(witnesses[-1], 0.0, window.gap, 2 * self.margin)
            witnesses.append(witness)
        return skeleton, witnesses
