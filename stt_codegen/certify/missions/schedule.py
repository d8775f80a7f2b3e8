"""The schedule of a mission for reports and emitted files: for every entry where and when the tube satisfies it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.certify.certificate import MissionProof
from stt_codegen.certify.monitor import Witness
from stt_codegen.decimals import above, below
from stt_codegen.task import Task
from stt_codegen.task.mission import Always, And, Eventually, Formula, Or, StateFormula, Until, regions_of

SHORT_VISIT = 0.01  # seconds; a shorter visit is described as a moment


@dataclass(frozen=True)
class Visit:
    """An interval in which the tube is in a region, or satisfies another formula without time.

    begin, end: seconds; None for one that has no begin (since before the start) or no end.
    """

    state: str
    begin: float | None
    end: float | None


@dataclass(frozen=True)
class ServedEntry:
    """An entry of the mission, by number from 1, with the visits that prove it; none for an entry that forbids."""

    entry: int
    title: str
    visits: tuple[Visit, ...]


def served_entries(task: Task, proof: MissionProof) -> tuple[ServedEntry, ...]:
    """Return every entry of the mission with its visits, in the order of the file."""
    pairs = enumerate(zip(task.mission, proof.witnesses, strict=True), 1)
    return tuple(ServedEntry(k, entry.title(), tuple(_visits(proofs))) for k, (entry, proofs) in pairs)


def is_visit(witness: Witness) -> bool:
    """Return whether a witness is about a region that the tube is in; avoiding a region happens at no particular time."""
    return any(not region.is_negated for region in regions_of(witness.state.inner))


def has_momentary_visit(formula: Formula) -> bool:
    """Return whether a formula asks somewhere for a region at one moment, as a visit without a stay does."""
    match formula:
        case Eventually(_, part) | Until(_, _, part):
            at_once = part.parts if isinstance(part, And) else (part,)
            is_visit = any(isinstance(p, StateFormula) and any(not r.is_negated for r in regions_of(p.inner)) for p in at_once)
            return is_visit or any(has_momentary_visit(p) for p in at_once)
        case Always(_, part):
            return has_momentary_visit(part)
        case And(parts) | Or(parts):
            return any(has_momentary_visit(part) for part in parts)
    return False


def _visits(proofs: tuple[Witness, ...]) -> Iterator[Visit]:
    for w in sorted(proofs, key=lambda w: w.begin):
        if is_visit(w):
            yield Visit(_plain(w.state.inner), *(None if math.isinf(v) else float(v) for v in (w.begin, w.end)))


def describe_entry(entry: ServedEntry) -> str:
    """Return an entry as a line: "visit dock then exit: dock from 4.1 to 6.4 s; left or right from 12 to 12.05 s"."""
    visits = "; ".join(map(describe_visit, entry.visits))
    return f"{entry.title}: {visits or 'holds, without a visit'}"


def describe_visit(visit: Visit) -> str:
    """Return where and when: "dock from 4.1 to 6.4 s"."""
    return f"{visit.state} {_when(visit)}"


def _plain(formula: Formula) -> str:
    """Return a formula without brackets around it."""
    return " or ".join(map(str, formula.parts)) if isinstance(formula, Or) else str(formula)


def _when(visit: Visit) -> str:
    if visit.begin is not None and visit.end is not None and visit.end - visit.begin < SHORT_VISIT:
        return f"at {above(Fraction(visit.begin), 4):g} s"
    begin = "from the start" if visit.begin is None else f"from {above(Fraction(visit.begin), 4):g}"
    return f"{begin} on" if visit.end is None else f"{begin} to {below(Fraction(visit.end), 4):g} s"


def phases(task: Task, proof: MissionProof) -> list[tuple[Fraction, int]]:
    """Return which entry, by number from 1, is being served until which time: the one whose next visit ends first.

    Of several that end together it is the first of the file. Endless visits end at t_c, and so does the schedule of a tube that
    repeats itself.
    """
    ends: list[tuple[Fraction, int]] = []
    for k, proofs in enumerate(proof.witnesses, 1):
        for w in proofs:
            if is_visit(w):
                ends.append((task.prescribed_time if math.isinf(w.end) else Fraction(w.end), k))
    cycle, t_c = proof.cycle, task.prescribed_time
    if cycle is not None and ends:  # after the last of a cycle comes the first of the next one
        _, first = min(((end, k) for end, k in ends if end > cycle.begin), default=(t_c, 0))
        ends = [*((min(end, t_c), k) for end, k in ends), (t_c, first)]
    result: list[tuple[Fraction, int]] = []
    for end, k in sorted(ends):
        if result and result[-1][1] == k:
            result[-1] = (end, k)
        elif not result or end > result[-1][0]:
            result.append((end, k))
    return result
