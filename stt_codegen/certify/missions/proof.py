"""P10: the tube satisfies the mission. Where each state formula holds is found piece by piece in exact integers; from these
intervals the formula follows by algebra (monitor.py).

Segments are cut into PARTS, and next to a knot at which a state holds, but not around it, a thin slice of a segment is tried: so
one knot in a region is enough for a visit, and the clock has a little room. The spatial margin is the largest slack with which
the mission is still satisfied, the temporal one by how much every interval may then shrink.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Finding, MissionProof
from stt_codegen.certify.monitor import Cycle, Span, holds, witnesses
from stt_codegen.certify.moving_slack import cut
from stt_codegen.certify.slack import CHUNK, RowBlock
from stt_codegen.constraints import Avoidance, mission_avoidances
from stt_codegen.decimals import decimal
from stt_codegen.designs import Design, RefinedDesign
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import StateFormula, state_formulas_of

PARTS = 8  # of a segment, in which slack is looked for
SLICES = 1024  # of a segment: how finely the ends of intervals are told
NOWHERE = -(1 << 60)  # the slack of a state that no tube has
WIDE = 1 << 40  # coefficients below this leave room for the halvings in 64 bits
# Of t_c: t, K/t_c and their product, each rounded; of ticks `controller.integers.errors.late`, at most 2.125 2^-16 of a segment,
# of which there are four or more.
CLOCK = {"float": Fraction(4, 1 << 24), "double": Fraction(4, 1 << 53), "fixed": Fraction(9, 1 << 20)}


@dataclass(frozen=True)
class Held:
    """Where a state may hold: stretches of spline time in slices, (S, 2), and the slack on each in whole units, (S,)."""

    stretches: npt.NDArray[np.int64]
    slack: npt.NDArray[Any]

    def spans(self, least: int) -> list[tuple[int, int]]:
        """Where the slack is at least so much, disjoint and in order."""
        begin, end = self.stretches[self.slack >= least].T
        order = np.argsort(begin, kind="stable")
        begin, reach = begin[order], np.maximum.accumulate(end[order])
        first = np.flatnonzero(np.concatenate([[True], begin[1:] > reach[:-1]])) if len(begin) else begin
        last = np.append(first[1:], len(begin)) - 1
        return list(zip(begin[first].tolist(), reach[last].tolist(), strict=True)) if len(begin) else []


def clock_error(task: Task) -> Fraction:
    """Seconds by which the emitted clock may differ from t, and the sets' from it."""
    return task.prescribed_time * CLOCK[task.emit.scalar] + task.start_delay


def certify_mission(task: Task, design: RefinedDesign, unit_error: int) -> tuple[tuple[Finding, ...], MissionProof | None]:
    """P10 in space and in time, and what it shows where it holds. unit_error: what the arithmetic may take, in units."""
    formula = task.formula
    if formula is None:
        return (), None
    held = {state: held_of(design, mission_avoidances(task, state)) for state in state_formulas_of(formula)}
    slice_, last = design.prescribed_time / design.segments / SLICES, design.segments * SLICES
    needed = math.ceil(clock_error(task) / slice_)

    cycle = cycle_of(design)

    def spans_of(least: int) -> dict[StateFormula, list[Span]]:
        return {state: _timed(one.spans(least), last, slice_, cycle) for state, one in held.items()}

    def shown(least: int, slices: int) -> bool:
        return holds(formula, spans_of(least), slices * slice_, cycle)

    told = f"the mission of {len(task.mission)} entr{'y' if len(task.mission) == 1 else 'ies'} is satisfied"
    levels = sorted({int(v) for one in held.values() for v in one.slack.tolist() if v > NOWHERE})
    found = _last(levels, lambda least: shown(least, needed))
    unit = design.unit
    if (found is None or found < unit_error) and shown(unit_error, 0):  # the mission is satisfied, but for the doubt about time
        widest = _last(range(last + 1), lambda slices: shown(unit_error, slices)) or 0
        late = "lower start_delay, or widen the regions or the windows" if task.start_delay else ""
        doubt = f"{told}, whatever the clock is wrong by"
        return (Finding(Property.MISSION, doubt, widest * slice_, clock_error(task), advice=late, in_time=True),), None
    if found is None or found < unit_error:
        return (Finding(Property.MISSION, told, Fraction(-1 if found is None else found) * unit, unit_error * unit),), None
    most = _last(range(needed, last + 1), lambda slices: shown(found, slices))
    assert most is not None
    seconds = spans_of(found)
    if cycle is not None:
        seconds = {state: cycle.endless(cycle.doubled(one)) for state, one in seconds.items()}
    shows = tuple(tuple(dict.fromkeys(witnesses(one, seconds, cycle))) for one in task.formulas)
    spans = {state: tuple(one.spans(found)) for state, one in held.items()}
    proof = MissionProof(formula, spans, found, most, shows, cycle)
    in_time = f"{told}, also with every time wrong by up to {decimal(_few(most * slice_))} s"
    return (
        Finding(Property.MISSION, told, found * unit, unit_error * unit),
        Finding(Property.MISSION, in_time, most * slice_, clock_error(task), in_time=True),
    ), proof


def _few(value: Fraction) -> Fraction:
    """Three digits, rounded down."""
    step = Fraction(10) ** (math.floor(math.log10(value)) - 2)
    return value // step * step


def _last(values: Sequence[int], good: Any) -> int | None:
    """The last of values that are good up to some place and not behind it; None where the first is not."""
    if not values or not good(values[0]):
        return None
    low, high = 0, len(values)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if good(values[middle]) else (low, middle)
    return values[low]


def cycle_of(design: Design) -> Cycle | None:
    """What a tube repeats for ever."""
    return None if design.cycle_begin is None else Cycle(design.cycle_begin, design.prescribed_time)


def _timed(slices: list[tuple[int, int]], last: int, slice_: Fraction, cycle: Cycle | None) -> list[Span]:
    """Intervals in seconds. Before 0 the tube stands, and after t_c, slice number `last`, unless it repeats itself."""
    ever = last if cycle is None else None
    return [(-math.inf if a == 0 else a * slice_, math.inf if b == ever else b * slice_) for a, b in slices]


def held_of(design: RefinedDesign, sets: Sequence[Avoidance]) -> Held:
    """The slack of a state on parts of segments, at their ends, and on slices next to ends that are better than what is beside
    them."""
    count, step, bezier = design.segments * PARTS, SLICES // PARTS, design.bezier()
    kind: Any = np.int64 if design.coefficient_bits < WIDE.bit_length() else object
    ends = np.arange(count + 1) * step
    places = np.concatenate([np.stack([ends[:-1], ends[1:]], axis=1), np.stack([ends, ends], axis=1)])
    if not sets or any(not one.alternatives for one in sets):  # everywhere, or nowhere
        return Held(places, np.full(len(places), NOWHERE if sets else WIDE, dtype=object))
    pieces = _parts(bezier.astype(kind))
    points = np.concatenate([pieces[..., :1], pieces[-1:, ..., 3:]]).repeat(4, axis=-1)
    finer = PARTS**3
    block = RowBlock.choice(sets, design.unit / finer)
    whole, at = (_slack(block, p) // finer for p in (pieces, points))
    slack, thin = [whole, at], _slices(whole, at, step)
    if thin:
        cuts = [_slice(bezier, a, b) for a, b in thin]
        slack.append(np.array([math.floor(v) for v in RowBlock.choice(sets, design.unit).slack(np.stack(cuts))[0]]))
        places = np.concatenate([places, np.array(thin)])
    return Held(places, np.concatenate([one.astype(object) for one in slack]) - 1)  # a reader rounds bounds to whole units


def _parts(bezier: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The coefficients of all segments in PARTS equal parts, times PARTS^3, in whole numbers: (K PARTS, n, 2, 4)."""
    pieces = bezier * PARTS**3
    for _ in range(PARTS.bit_length() - 1):
        c0, c1, c2, c3 = (pieces[..., j] for j in range(4))
        a, b, c = (c0 + c1) // 2, (c1 + c2) // 2, (c2 + c3) // 2  # nothing is lost: there are enough factors of 2
        d, e = (a + b) // 2, (b + c) // 2
        f = (d + e) // 2
        both = np.stack([np.stack([c0, a, d, f], axis=-1), np.stack([f, e, c, c3], axis=-1)], axis=1)
        pieces = both.reshape(-1, *bezier.shape[1:])
    return pieces


def _slice(bezier: npt.NDArray[Any], a: int, b: int) -> npt.NDArray[Any]:
    """The coefficients from slice a to slice b of one segment, in fractions: (n, 2, 4)."""
    first = min(a // SLICES, len(bezier) - 1)
    return cut(bezier[first].astype(object), *(Fraction(v - first * SLICES, SLICES) for v in (a, b)))


def _slack(block: RowBlock, pieces: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The slack of the worst of the sets on each piece, (P,)."""
    each = max(1, CHUNK // (8 * len(block.rows)))
    return np.concatenate([block.slack(pieces[k : k + each])[0] for k in range(0, len(pieces), each)])


def _slices(whole: npt.NDArray[Any], at: npt.NDArray[Any], step: int) -> list[tuple[int, int]]:
    """The slices to either side of ends of parts that have slack where the part beside them has none."""
    found = []
    for k in np.nonzero(at > 0)[0].tolist():
        if k > 0 and whole[k - 1] <= 0:
            found.append((k * step - 1, k * step))
        if k < len(whole) and whole[k] <= 0:
            found.append((k * step, k * step + 1))
    return found


def kept_off(design: RefinedDesign, block: RowBlock, span: tuple[int, int], margin: int) -> list[tuple[Fraction, Fraction, int]]:
    """On a span, in slices, the rows of a set that show the margin: from, to, in segments, and which. Whole segments where one
    row does for them, else its parts and slices."""
    (begin, end), step, bezier = span, SLICES // PARTS, design.bezier()
    found: list[tuple[Fraction, Fraction, int]] = []
    at = begin
    while at < end or (at == end == begin and not found):
        for size in (SLICES, step, 1) if begin < end else (0,):
            if (size and at % size) or at + size > end:
                continue
            piece = _slice(bezier, at, at + size) if at + size else bezier[0, ..., :1].repeat(4, axis=-1)
            slack = block.told(piece[None])[0]
            best = int(np.argmax(slack))
            if slack[best] >= margin or size < step:
                last, until, row = found[-1] if found else (Fraction(0), Fraction(0), -1)
                if size == SLICES and row == best and until.denominator == last.denominator == 1:
                    found[-1] = (last, until + 1, row)
                else:
                    found.append((Fraction(at, SLICES), Fraction(at + size, SLICES), best))
                at += size
                break
    return found
