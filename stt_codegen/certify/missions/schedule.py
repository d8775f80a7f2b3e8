"""What is told of a mission: for every entry where and when the tube serves it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.certify.certificate import MissionProof
from stt_codegen.certify.monitor import Witness
from stt_codegen.decimals import above, below
from stt_codegen.task import Task
from stt_codegen.task.mission import Formula, Or, regions_of

SHORT = 0.01  # seconds: a visit that is told as a moment


@dataclass(frozen=True)
class Visit:
    """The tube is in a region, or what else a formula without time says, from `begin` to `end`, seconds; None: for ever, at the
    start also from before it."""

    state: str
    begin: float | None
    end: float | None


@dataclass(frozen=True)
class Served:
    """An entry of the mission, from 1, and what shows that it holds; nothing where it is about what is never done."""

    entry: int
    title: str
    visits: tuple[Visit, ...]


def served(task: Task, shown: MissionProof) -> tuple[Served, ...]:
    """Every entry in the order of the file."""
    pairs = enumerate(zip(task.mission, shown.witnesses, strict=True), 1)
    return tuple(Served(k, entry.title(), tuple(_visits(found))) for k, (entry, found) in pairs)


def reached(witness: Witness) -> bool:
    """Whether a witness is about a region that the tube is in: keeping off is not served at a time."""
    return any(not one.is_negated for one in regions_of(witness.state.inner))


def _visits(found: tuple[Witness, ...]) -> Iterator[Visit]:
    for w in sorted(found, key=lambda w: w.begin):
        if reached(w):
            yield Visit(_plain(w.state.inner), *(None if math.isinf(v) else float(v) for v in (w.begin, w.end)))


def sentence(one: Served) -> str:
    """As a line: "visit dock then exit: dock from 4.1 to 6.4 s; left or right from 12 to 12.05 s"."""
    told = "; ".join(map(told_visit, one.visits))
    return f"{one.title}: {told or 'holds, without a visit'}"


def told_visit(visit: Visit) -> str:
    """Where and when: "dock from 4.1 to 6.4 s"."""
    return f"{visit.state} {_when(visit)}"


def _plain(formula: Formula) -> str:
    """A formula without the brackets around it."""
    return " or ".join(map(str, formula.parts)) if isinstance(formula, Or) else str(formula)


def _when(visit: Visit) -> str:
    if visit.begin is not None and visit.end is not None and visit.end - visit.begin < SHORT:
        return f"at {above(Fraction(visit.begin), 4):g} s"
    begin = "from the start" if visit.begin is None else f"from {above(Fraction(visit.begin), 4):g}"
    return f"{begin} on" if visit.end is None else f"{begin} to {below(Fraction(visit.end), 4):g} s"


def phases(task: Task, shown: MissionProof) -> list[tuple[Fraction, int]]:
    """Until which time which entry, from 1, is being served: the one whose next visit ends first, of several that end together
    the first of the file. Times that are for ever are t_c; a tube that repeats itself is told until then."""
    ends: list[tuple[Fraction, int]] = []
    for k, found in enumerate(shown.witnesses, 1):
        for w in found:
            if reached(w):
                ends.append((task.prescribed_time if math.isinf(w.end) else Fraction(w.end), k))
    cycle, t_c = shown.cycle, task.prescribed_time
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
