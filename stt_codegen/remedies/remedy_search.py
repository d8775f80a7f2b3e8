"""The search for changes with which a refused task is certified: each is tried to the end, as the next run would.

One option alone first, the cheapest first; where no option alone is enough, several together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from stt_codegen.effort import EffortSpent, proof_time, require_effort, require_effort_for_proof
from stt_codegen.errors import BadInput, Reason
from stt_codegen.remedies.adjustments import Adjustment, adjustments_of
from stt_codegen.remedies.changes import Change
from stt_codegen.task import Task

REMEDY_LIMIT = 4  # that a refusal names
HALVINGS = 4  # to find how little of a change is enough
TaskTest = Callable[[Task], bool]


@dataclass(frozen=True)
class CertificationTests:
    """Two tests of a changed task. may_be_certified: quick, and nearly always right. is_certified: as the next run would."""

    may_be_certified: TaskTest
    is_certified: TaskTest

    def admits(self, task: Task, change: Change) -> bool:
        """Return whether the quick test admits a change."""
        return _holds_with(self.may_be_certified, task, change)

    def verifies(self, task: Task, change: Change) -> bool:
        """Return whether the task is certified with a change."""
        return _holds_with(self.is_certified, task, change)


@dataclass
class Remedies:
    """Changes with which the task was certified, and the keys that were tried without success.

    unproved: the change whose proof was not finished when the time was over. is_complete: whether every option was tried; False
    where the time was over or the user stopped the search.
    """

    changes: list[Change] = field(default_factory=list)
    without_success: list[str] = field(default_factory=list)
    unproved: Change | None = None
    is_complete: bool = False

    def sentence(self, hint: str, longer: str) -> str:
        """Return the end of a refusal.

        hint: what may help, for the case that nothing was tried. longer: how to ask for a longer search; empty where one cannot.
        """
        stopped = "" if self.is_complete else "the time was over before every option was tried"
        stopped += f" ({longer})" if stopped and longer else ""
        if self.changes:
            first, *more = (change.text for change in self.changes)
            smaller = "smaller changes may do" if stopped else ""
            return "; ".join(filter(None, (", or ".join((f"certified {first}", *more)), smaller, stopped)))
        if self.unproved is not None:
            return f"{self.unproved.text} it may be certified, for which the time for a proof was too short; {stopped}"
        keys = list(dict.fromkeys(self.without_success))
        tried = f"no change that was tried was enough, of {', '.join(keys)}" if keys else ""
        return "; ".join(filter(None, (tried, stopped, "" if tried else hint)))


class ProofUnfinished(EffortSpent):
    """The seconds were over during the proof of a change that the quick test admits."""

    def __init__(self, change: Change) -> None:
        super().__init__()
        self.change = change


def find_remedies(
    task: Task, reason: Reason, trials: CertificationTests, ends: tuple[type[BaseException], ...] = (EffortSpent,)
) -> Remedies:
    """Return changes with which the task is certified, each verified as the reader will run it.

    The time that is left is `require_effort`'s, which the trials call somewhere. ends: at which exceptions the search ends with
    what is known.
    """
    remedies = Remedies()
    with suppress(*ends):
        adjustments = list(adjustments_of(task, reason))
        for adjustment in adjustments:
            try:
                change = smallest_change(task, adjustment, trials, remedies.changes)
            except ProofUnfinished as end:
                remedies.unproved = end.change
                raise
            if change is None:
                remedies.without_success += adjustment.keys
            else:
                remedies.changes.append(change)
            if len(remedies.changes) == REMEDY_LIMIT:
                break
        if not remedies.changes:
            remedies.changes += _joint_changes(task, [a for a in adjustments if not a.leaves_out_an_entry], trials)
        remedies.is_complete = True
    return remedies


def smallest_change(
    task: Task, adjustment: Adjustment, trials: CertificationTests, named: Sequence[Change] = ()
) -> Change | None:
    """Return the mildest change of one option with which the task is certified, near the smallest one; None where none is.

    named: changes that are certified already; one that makes all edits of such a change, and none by less, is not proved. Where
    the time is over, the mildest one that is known by then. Raises `ProofUnfinished` where not even that is proved in time.
    """
    admitted: list[Change] = []
    try:
        for change in _admitted_changes(task, adjustment, trials):
            admitted.append(change)
            require_effort_for_proof()
    except EffortSpent:
        if not admitted:
            raise
    with proof_time():
        for change in admitted[::-1]:
            if any(milder.is_part_of(change, task) for milder in named):
                return None
            try:
                if trials.verifies(task, change):
                    return change
            except EffortSpent:
                raise ProofUnfinished(change) from None
    return None


def _admitted_changes(task: Task, adjustment: Adjustment, trials: CertificationTests) -> Iterator[Change]:
    """Yield milder and milder changes that the quick test admits.

    The strongest step is tried first, for where it fails most milder ones do; then the mildest. Between what fails and what is
    admitted the steps, and then the numbers, are halved.
    """
    factors = adjustment.factors
    ends = sorted({len(factors) - 1, 0}, reverse=True)
    high = next((k for k in ends if trials.admits(task, adjustment.change(factors[k]))), None)
    if high is None:
        return
    yield adjustment.change(factors[high])
    low = -1
    while high - low > 1:
        middle = (low + high) // 2
        if trials.admits(task, adjustment.change(factors[middle])):
            high = middle
            yield adjustment.change(factors[middle])
        else:
            low = middle
    too_little, enough = adjustment.unchanged if low < 0 else factors[low], factors[high]
    for _ in range(0 if adjustment.is_choice else HALVINGS):
        between = (too_little + enough) / 2
        change = adjustment.change(between)
        if change in (adjustment.change(too_little), adjustment.change(enough)):  # as they are printed
            return
        if trials.admits(task, change):
            enough = between
            yield change
        else:
            too_little = between


def _joint_changes(task: Task, adjustments: Sequence[Adjustment], trials: CertificationTests) -> Iterator[Change]:
    """Yield one change of several options: all by the same step, then without those that are not needed, the dearest first."""
    distinct = [a for k, a in enumerate(adjustments) if a.keys not in [b.keys for b in adjustments[:k]]]
    for step in range(max((len(a.factors) for a in distinct), default=0)):
        parts = [a.change(a.factors[min(step, len(a.factors) - 1)]) for a in distinct]
        if len(parts) < 2 or not trials.verifies(task, _joined(parts)):
            continue
        for part in parts[::-1]:
            fewer = [p for p in parts if p is not part]
            if fewer and trials.verifies(task, _joined(fewer)):
                parts = fewer
        yield _joined(parts)
        return


def _joined(parts: Sequence[Change]) -> Change:
    joined, *rest = parts
    for part in rest:
        joined = joined.and_also(part)
    return joined


def _holds_with(test: TaskTest, task: Task, change: Change) -> bool:
    require_effort()
    with suppress(BadInput):
        return test(change.of(task))
    return False
