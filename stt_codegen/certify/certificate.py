"""What a certificate states: a finding for each property, with its margin and the place where the margin is smallest.

The properties are P1 to P7, P8 where u is limited and the plant has bounds, P9 where the task has a period, and P10 where it has
a mission. The files beside this one compute the findings; reports and refusals read them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from fractions import Fraction
from typing import NamedTuple

from stt_codegen.certify.monitor import Cycle, Witness
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.errors import Reason
from stt_codegen.properties import OF_THE_EDGES, OF_THE_INPUT, SECONDS, Property
from stt_codegen.task.mission import Formula, StateFormula


@dataclass(frozen=True)
class Finding:
    """What is known of one property. It holds when `margin` >= `required`.

    Both are in the task's units. They are in seconds for P9 and the second finding of P10, but P9's is a length where
    initial_state is outside the share. P8's are in units per second. Where the property holds, `margin` is a proved lower bound
    on the slack, which is smallest in the time interval `time` (seconds), in `dimension` (from 1) and at `obstacle`. Where it
    fails, margin and place are those of one failure, not necessarily the worst. advice: what may help; empty for the property's
    own. problem: what is wrong, with the value found and the value allowed; empty for the statement with what is missing.
    sufficient: keys of the task with values with which it would hold. about: keys that the problem is about.
    """

    subject: Property
    statement: str
    margin: Fraction
    required: Fraction
    time: tuple[Fraction, Fraction] | None = None
    _: KW_ONLY
    dimension: int | None = None
    obstacle: str | None = None
    advice: str = ""
    problem: str = ""
    sufficient: tuple[tuple[str, Fraction], ...] = ()
    about: tuple[str, ...] = ()
    in_time: bool = False  # margin and required are seconds

    @property
    def code(self) -> str:
        """The property's code in certificates: "P1" to "P10"."""
        return self.subject.code

    @property
    def remedy(self) -> str:
        """The change to the task that would remove a failure."""
        return self.advice or self.subject.advice

    @property
    def is_in_seconds(self) -> bool:
        """Whether margin and required are seconds."""
        return self.in_time or (self.subject.unit == SECONDS and self.time is None)

    @property
    def holds(self) -> bool:
        """Whether the margin is large enough."""
        return self.margin >= self.required

    def location(self, axes: Sequence[str] = ()) -> str:
        """Return time, axis and unsafe set in words; axes: the names of the dimensions."""
        parts = []
        if self.time is not None:
            a, b = self.time
            parts.append(f"t = {decimal(a)} s" if a == b else f"t in [{decimal(a)}, {decimal(b)}] s")
        if self.dimension is not None:
            parts.append(axes[self.dimension - 1] if axes else f"dimension {self.dimension}")
        if self.obstacle is not None:
            parts.append(f"unsafe set {self.obstacle}")
        return ", ".join(parts)

    def fault(self, axes: Sequence[str] = ()) -> str:
        """Return what fails, where and by how much; axes as for `location`."""
        if self.problem:
            return f"{self.subject.label}: {self.problem}"
        location, unit = self.location(axes), " s" if self.is_in_seconds else ""
        at = f" at {location}" if location else ""
        missing = f"{decimal(self.required - self.margin)}{unit} is missing"
        return f"{self.subject.label}{at}: not shown: {self.statement} ({missing})"


class PathClaim(NamedTuple):
    """What the worst path of a component shows (docs/sampling-path.md).

    nearest: Q_pk, to which no run comes nearer, in the task's units. history: A in seconds, over which bounds are enough; None
    where one path has the bounds of the whole time.
    """

    nearest: Fraction
    history: Fraction | None


@dataclass(frozen=True, kw_only=True)
class PeriodProof:
    """The numbers that P9 proves, by component unless stated otherwise.

    period, latency: seconds. share: starts have |e_i(0)| <= share. rho: e^E; |e_i| < (rho - 1)/(rho + 1) throughout. u: a bound
    on |u_i|. shift: a bound on the error of the measured distances to the edges, from arithmetic and noise. paths: the worst
    paths that prove it; empty where the sharp conditions do.
    """

    period: Fraction
    latency: Fraction
    share: Fraction
    rho: tuple[Fraction, ...]
    u: tuple[Fraction, ...]
    shift: tuple[Fraction, ...]
    paths: tuple[PathClaim, ...] = ()


@dataclass(frozen=True, kw_only=True)
class MissionProof:
    """The numbers that P10 proves.

    spans: where each state holds, in slices of a segment (certify/missions/proof.py). margin: on all of them, in units of the
    table. time_margin: in slices. witnesses: by entry of the mission, in seconds. cycle: the part that repeats for ever.
    """

    formula: Formula
    spans: dict[StateFormula, tuple[tuple[int, int], ...]]
    margin: int
    time_margin: int
    witnesses: tuple[tuple[Witness, ...], ...]
    cycle: Cycle | None = None


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """The findings for one tube, and the numbers that belong to them.

    edge_error: P7's bound on the distance between the emitted edge and the exact one, by dimension; rate_error: the same for
    their rates, for order 2. speed: a bound on |gammadot| by dimension (P6). minimum_width: over all t and dimensions; a proved
    lower bound where P1 holds. start: gamma(0) as (lower, upper) by dimension. covers_initial_set: whether gamma(0) is the
    initial set but for a thousandth of its width at each edge. method: "exact" and "enclosure" are proofs; "sampled" finds faults
    and proves nothing. steps: the shortest and the longest step of alpha (seconds) for which an adaptive or literal tube is
    proved. proved_period: what P9 proves, where the task has a period and P9 holds; mission: what P10 proves, likewise. axes: the
    names of the dimensions in sentences. is_law_defined: whether the tube is so wide that the emitted law, which divides by its
    width, has a value everywhere; else it is not written, whatever a user asks for.
    """

    findings: tuple[Finding, ...]
    edge_error: tuple[Fraction, ...]
    speed: tuple[Fraction, ...]
    minimum_width: Fraction
    start: tuple[tuple[Fraction, Fraction], ...]
    covers_initial_set: bool
    method: str = "exact"
    steps: tuple[Fraction, Fraction] | None = None
    proved_period: PeriodProof | None = None
    mission: MissionProof | None = None
    rate_error: tuple[Fraction, ...] = ()
    axes: tuple[str, ...] = ()
    is_law_defined: bool = True

    @property
    def proves(self) -> bool:
        """Whether the findings are proofs."""
        return self.method != "sampled"

    @property
    def holds(self) -> bool:
        """Whether all properties are proved."""
        return self.proves and all(f.holds for f in self.findings)

    @property
    def tube_holds(self) -> bool:
        """Whether P1 to P7 and P10 are proved, with or without P8 and P9."""
        return self.proves and all(f.holds for f in self.findings if f.subject not in OF_THE_INPUT)

    @property
    def lacks_rounding(self) -> bool:
        """Whether the exact tube is sound, and only the margin for its arithmetic is too small."""
        short = [f for f in self.failures if f.subject is not Property.ARITHMETIC]
        return self.method == "exact" and bool(short) and all(f.margin >= 0 and f.subject in OF_THE_EDGES for f in short)

    def refusal(self) -> str:
        """Return all failures in one line, and then what may help."""
        reason = self.reason
        return "; ".join(part for part in (reason.problem, reason.hint) if part)

    @property
    def reason(self) -> Reason:
        """All failures, and what may help against each. P7 is named only where the exact tube itself is sound."""
        if self.method == "sampled" and not self.failures:
            at_samples = f"{Property.WIDTH.label} to {Property.SMOOTH.label} hold at the samples"
            kinds = kinds_offering("has_exact_claims", quoted=True)
            return Reason(f"{at_samples}, but this design is not proved between them", f"use tube.design = {kinds}")
        failures = [f for f in self.failures if f.margin < 0 and f.subject is not Property.ARITHMETIC] or list(self.failures)
        for_arithmetic = next((f.remedy for f in self.findings if f.subject is Property.ARITHMETIC), "")
        hints: dict[str, None] = {}
        for f in failures:  # where only the margin for the arithmetic is too small, the property's remedy is no help
            lacks_rounding = f.margin >= 0 and f.subject in OF_THE_EDGES and not f.in_time
            hints[for_arithmetic if lacks_rounding and for_arithmetic else f.remedy] = None
        problem = "; ".join(f.fault(self.axes) for f in failures)
        if self.method == "enclosure":
            problem = f"holds at samples but cannot be proved between them: {problem}"
        axis = next((f.dimension - 1 for f in failures if f.dimension), None)
        codes, sufficient = tuple(dict.fromkeys(f.code for f in failures)), tuple(v for f in failures for v in f.sufficient)
        about = tuple(key for f in failures for key in f.about)
        return Reason(problem, ", or ".join(filter(None, hints)), codes=codes, axis=axis, sufficient=sufficient, about=about)

    @property
    def failures(self) -> tuple[Finding, ...]:
        """The findings that do not hold."""
        return tuple(f for f in self.findings if not f.holds)
