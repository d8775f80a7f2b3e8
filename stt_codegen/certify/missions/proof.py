"""P10: whether the tube satisfies the mission.

Where each state formula holds is computed piece by piece in exact integers; from these intervals the formula follows by algebra
(monitor.py). Segments are cut into PARTS. Next to an end of a part at which a state holds, but not around it, thinner pieces of a
segment are tested: so one such end in a region is enough for a visit, and the clock may be a little wrong. The spatial margin is
half of the largest slack with which the mission is satisfied. The temporal margin is by how much every interval may then shrink.
docs/missions.md has the mathematics.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Finding, MissionProof
from stt_codegen.certify.monitor import Cycle, Span, holds, witnesses
from stt_codegen.certify.moving_slack import cut
from stt_codegen.certify.slack import BATCH_SIZE, ConstraintBlock
from stt_codegen.constraints import Avoidance, mission_avoidances
from stt_codegen.decimals import decimal
from stt_codegen.designs import Design, RefinedDesign
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import StateFormula, state_formulas_of

PARTS = 8  # of a segment, for which slack is computed
SLICES = 1024  # of a segment: the resolution of the ends of intervals
THIN = (64, 16, 4, 1)  # slices: the pieces that are tested beside an end at which a state holds, where the part does not
NOWHERE = -(1 << 60)  # the slack of a state that no tube has
LARGEST_COEFFICIENT = 1 << 40  # below it the halvings fit into 64 bits
# The clock's error as a share of t_c: of t, K/t_c and their product, each rounded. For ticks `controller.integers.errors.late`,
# at most 2.125 2^-16 of a segment, of which there are four or more.
CLOCK = {"float": Fraction(4, 1 << 24), "double": Fraction(4, 1 << 53), "fixed": Fraction(9, 1 << 20)}


@dataclass(frozen=True)
class StateSlack:
    """The slack of a state on stretches of spline time: stretches (S, 2) in slices, and slack (S,) in whole units."""

    stretches: npt.NDArray[np.int64]
    slack: npt.NDArray[Any]

    def spans(self, smallest: int) -> list[tuple[int, int]]:
        """Return where the slack is at least `smallest`, as disjoint intervals in order."""
        begin, end = self.stretches[self.slack >= smallest].T
        order = np.argsort(begin, kind="stable")
        begin, reach = begin[order], np.maximum.accumulate(end[order])
        first = np.flatnonzero(np.concatenate([[True], begin[1:] > reach[:-1]])) if len(begin) else begin
        last = np.append(first[1:], len(begin)) - 1
        return list(zip(begin[first].tolist(), reach[last].tolist(), strict=True)) if len(begin) else []


class AvoidingPiece(NamedTuple):
    """A piece of spline time, from `begin` to `end` in segments, on which the constraint of this number proves a margin."""

    begin: Fraction
    end: Fraction
    constraint: int


def clock_error(task: Task) -> Fraction:
    """Return a bound in seconds on the error of the emitted clock, and of the sets' clock against it."""
    return task.prescribed_time * CLOCK[task.emit.scalar] + task.start_delay


def certify_mission(task: Task, design: RefinedDesign, unit_error: int) -> tuple[tuple[Finding, ...], MissionProof | None]:
    """Certify P10 in space and in time, and return its proof where it holds.

    unit_error: P7's bound in units of the table, which is required as spatial margin.
    """
    formula = task.formula
    if formula is None:
        return (), None
    evidence = _Evidence(
        task, design, {state: state_slack(design, mission_avoidances(task, state)) for state in state_formulas_of(formula)}
    )
    statement = f"the mission of {len(task.mission)} entr{'y' if len(task.mission) == 1 else 'ies'} is satisfied"
    needed, unit = math.ceil(clock_error(task) / evidence.slice_length), design.unit
    largest = _last(evidence.levels(), lambda slack: evidence.is_satisfied(slack, needed))
    if largest is None or largest < unit_error:
        if evidence.is_satisfied(unit_error, 0):  # only the margin for the clock's error is missing
            return (_clock_finding(task, evidence, statement, unit_error),), None
        return (
            Finding(Property.MISSION, statement, Fraction(-1 if largest is None else largest) * unit, unit_error * unit),
        ), None
    margin = max(largest // 2, unit_error)  # the other half leaves time: a state holds for longer with less slack
    time_margin = _last(range(needed, evidence.slice_count + 1), lambda slices: evidence.is_satisfied(margin, slices))
    assert time_margin is not None
    seconds = time_margin * evidence.slice_length
    in_time = f"{statement}, also with every time wrong by up to {decimal(_three_digits(seconds))} s"
    return (
        Finding(Property.MISSION, statement, margin * unit, unit_error * unit),
        Finding(Property.MISSION, in_time, seconds, clock_error(task), in_time=True),
    ), evidence.proof(margin, time_margin)


@dataclass(frozen=True)
class _Evidence:
    """A task, a design, and the slack of every state of the mission."""

    task: Task
    design: RefinedDesign
    slack_by_state: dict[StateFormula, StateSlack]

    @property
    def slice_count(self) -> int:
        """The number of slices until t_c."""
        return self.design.segments * SLICES

    @property
    def slice_length(self) -> Fraction:
        """The length of a slice, in seconds."""
        return self.design.prescribed_time / self.design.segments / SLICES

    @property
    def cycle(self) -> Cycle | None:
        """The part of the tube that repeats for ever."""
        return cycle_of(self.design)

    def levels(self) -> list[int]:
        """Return every slack that some state has somewhere, rising."""
        return sorted({int(v) for s in self.slack_by_state.values() for v in s.slack.tolist() if v > NOWHERE})

    def spans(self, slack: int) -> dict[StateFormula, list[Span]]:
        """Return where each state has at least this slack, in seconds."""
        return {
            state: _in_seconds(s.spans(slack), self.slice_count, self.slice_length, self.cycle)
            for state, s in self.slack_by_state.items()
        }

    def is_satisfied(self, slack: int, slices: int) -> bool:
        """Return whether the mission holds with this slack, in units, and clock error, in slices."""
        assert self.task.formula is not None
        return holds(self.task.formula, self.spans(slack), slices * self.slice_length, self.cycle)

    def proof(self, margin: int, time_margin: int) -> MissionProof:
        """Return what the certificate states of the mission."""
        seconds, cycle = self.spans(margin), self.cycle
        if cycle is not None:
            seconds = {state: cycle.extend_for_ever(cycle.repeat_once(spans)) for state, spans in seconds.items()}
        by_entry = tuple(tuple(dict.fromkeys(witnesses(entry, seconds, cycle))) for entry in self.task.formulas)
        spans = {state: tuple(s.spans(margin)) for state, s in self.slack_by_state.items()}
        assert self.task.formula is not None
        return MissionProof(
            formula=self.task.formula, spans=spans, margin=margin, time_margin=time_margin, witnesses=by_entry, cycle=cycle
        )


def _clock_finding(task: Task, evidence: _Evidence, statement: str, unit_error: int) -> Finding:
    """Return the finding of a mission that is satisfied but for the clock's error."""
    slices = range(evidence.slice_count + 1)
    largest = _last(slices, lambda slices: evidence.is_satisfied(unit_error, slices)) or 0
    advice = "lower start_delay, or widen the regions or the windows" if task.start_delay else ""
    statement, margin = f"{statement}, whatever the clock is wrong by", largest * evidence.slice_length
    return Finding(Property.MISSION, statement, margin, clock_error(task), advice=advice, in_time=True)


def _three_digits(value: Fraction) -> Fraction:
    """Return three digits of a value, rounded down."""
    step = Fraction(10) ** (math.floor(math.log10(value)) - 2)
    return value // step * step


def _last(values: Sequence[int], is_good: Callable[[int], bool]) -> int | None:
    """Return the last good one of values that are good up to some index and not behind it; None where the first is not."""
    if not values or not is_good(values[0]):
        return None
    low, high = 0, len(values)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_good(values[middle]) else (low, middle)
    return values[low]


def cycle_of(design: Design) -> Cycle | None:
    """Return the part of a tube that repeats for ever, if there is one."""
    return None if design.cycle_begin is None else Cycle(design.cycle_begin, design.prescribed_time)


def _in_seconds(slices: list[tuple[int, int]], slice_count: int, slice_length: Fraction, cycle: Cycle | None) -> list[Span]:
    """Convert intervals to seconds. Before 0 the tube stands still, and after t_c too unless it repeats itself."""
    endless = slice_count if cycle is None else None
    return [(-math.inf if a == 0 else a * slice_length, math.inf if b == endless else b * slice_length) for a, b in slices]


def state_slack(design: RefinedDesign, sets: Sequence[Avoidance]) -> StateSlack:
    """Return the slack of a state on parts of segments, at their ends, and on thinner pieces beside ends with more slack."""
    count, step, bezier = design.segments * PARTS, SLICES // PARTS, design.bezier()
    kind: Any = np.int64 if design.coefficient_bits < LARGEST_COEFFICIENT.bit_length() else object
    ends = np.arange(count + 1) * step
    stretches = np.concatenate([np.stack([ends[:-1], ends[1:]], axis=1), np.stack([ends, ends], axis=1)])
    if not sets or any(not avoidance.alternatives for avoidance in sets):  # everywhere, or nowhere
        slack_value = NOWHERE if sets else LARGEST_COEFFICIENT
        return StateSlack(stretches, np.full(len(stretches), slack_value, dtype=object))
    pieces = _parts(bezier.astype(kind))
    points = np.concatenate([pieces[..., :1], pieces[-1:, ..., 3:]]).repeat(4, axis=-1)
    finer = PARTS**3
    block = ConstraintBlock.choice(sets, design.unit / finer)
    on_parts, at_ends = (_slack(block, p) // finer for p in (pieces, points))
    slack, thin = [on_parts, at_ends], _thin_pieces(on_parts, at_ends, step)
    if thin:
        cuts = [_slice(bezier, a, b) for a, b in thin]
        slack.append(np.array([math.floor(v) for v in ConstraintBlock.choice(sets, design.unit).slack(np.stack(cuts))[0]]))
        stretches = np.concatenate([stretches, np.array(thin)])
    # less one unit, because a checker rounds bounds to whole units
    return StateSlack(stretches, np.concatenate([values.astype(object) for values in slack]) - 1)


def _parts(bezier: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the coefficients of all segments in PARTS equal parts, times PARTS^3, in whole numbers: (K PARTS, n, 2, 4)."""
    pieces = bezier * PARTS**3
    for _ in range(PARTS.bit_length() - 1):
        c0, c1, c2, c3 = (pieces[..., j] for j in range(4))
        a, b, c = (c0 + c1) // 2, (c1 + c2) // 2, (c2 + c3) // 2  # exact, because there are enough factors of 2
        d, e = (a + b) // 2, (b + c) // 2
        f = (d + e) // 2
        both = np.stack([np.stack([c0, a, d, f], axis=-1), np.stack([f, e, c, c3], axis=-1)], axis=1)
        pieces = both.reshape(-1, *bezier.shape[1:])
    return pieces


def _slice(bezier: npt.NDArray[Any], a: int, b: int) -> npt.NDArray[Any]:
    """Return the coefficients from slice a to slice b of one segment, in fractions: (n, 2, 4)."""
    first = min(a // SLICES, len(bezier) - 1)
    return cut(bezier[first].astype(object), *(Fraction(v - first * SLICES, SLICES) for v in (a, b)))


def _slack(block: ConstraintBlock, pieces: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the slack of the worst set on each piece, (P,)."""
    step = max(1, BATCH_SIZE // (8 * len(block.constraints)))
    return np.concatenate([block.slack(pieces[k : k + step])[0] for k in range(0, len(pieces), step)])


def _thin_pieces(on_parts: npt.NDArray[Any], at_ends: npt.NDArray[Any], step: int) -> list[tuple[int, int]]:
    """Return the pieces beside ends of parts that have slack, in slices, on sides where the part has none."""
    pieces = []
    for k in np.nonzero(at_ends > 0)[0].tolist():
        if k > 0 and on_parts[k - 1] <= 0:
            pieces += [(k * step - size, k * step) for size in THIN]
        if k < len(on_parts) and on_parts[k] <= 0:
            pieces += [(k * step, k * step + size) for size in THIN]
    return pieces


def avoiding_pieces(design: RefinedDesign, block: ConstraintBlock, span: tuple[int, int], margin: int) -> list[AvoidingPiece]:
    """Return pieces that cover a span, in slices, each with a constraint of a set that proves the margin on it.

    A piece is as many whole segments as one constraint proves, else a part of a segment or a thinner piece.
    """
    (begin, end), step, bezier = span, SLICES // PARTS, design.bezier()
    pieces: list[AvoidingPiece] = []
    at = begin
    while at < end or (at == end == begin and not pieces):
        for size in (SLICES, step, *THIN) if begin < end else (0,):
            if (size and at % size) or at + size > end:
                continue
            piece = _slice(bezier, at, at + size) if at + size else bezier[0, ..., :1].repeat(4, axis=-1)
            slack = block.slack_by_constraint(piece[None])[0]
            best = int(np.argmax(slack))
            if slack[best] >= margin or size <= 1:
                last = pieces[-1] if pieces else AvoidingPiece(Fraction(0), Fraction(0), -1)
                if size == SLICES and last.constraint == best and last.end.denominator == last.begin.denominator == 1:
                    pieces[-1] = last._replace(end=last.end + 1)
                else:
                    pieces.append(AvoidingPiece(Fraction(at, SLICES), Fraction(at + size, SLICES), best))
                at += size
                break
    return pieces
