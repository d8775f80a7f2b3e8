"""What a certificate says: the properties P1 to P7, P8 where u is limited and the plant has bounds, P9 where the task has a
period, P10 where it has a mission, each with its margin and the place where the margin is least."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.certify.monitor import Cycle, Witness
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.properties import OF_THE_EDGES, SECONDS, Property
from stt_codegen.task.mission import Formula, StateFormula


@dataclass(frozen=True)
class Finding:
    """One property. It holds when `margin` >= `required` (task's units; seconds for P9 and the second of P10, but a length where
    initial_state is outside the share; units per second for P8); then `margin` is a proved lower bound on the slack, least in the
    time interval `time` (seconds), `dimension` (from 1) and at `obstacle`. When it fails, margin and place are those of one place
    where it fails, not necessarily the worst. advice: what would mend it; empty: what the property advises."""

    subject: Property
    statement: str
    margin: Fraction
    required: Fraction
    time: tuple[Fraction, Fraction] | None = None
    dimension: int | None = None
    obstacle: str | None = None
    advice: str = ""
    in_time: bool = False  # margin and required are seconds

    @property
    def code(self) -> str:
        """The property as certificates spell it: "P1" to "P10"."""
        return self.subject.code

    @property
    def remedy(self) -> str:
        """What would mend it."""
        return self.advice or self.subject.advice

    @property
    def is_in_seconds(self) -> bool:
        """Whether margin and required are seconds."""
        return self.in_time or (self.subject.unit == SECONDS and self.time is None)

    @property
    def holds(self) -> bool:
        return self.margin >= self.required

    def place(self, axes: Sequence[str] = ()) -> str:
        """When and where; axes: what a sentence calls the dimensions."""
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
        """What fails, where and by how much; axes as for `place`."""
        where, unit = self.place(axes), " s" if self.is_in_seconds else ""
        return f"{self.subject.label}{' at ' + where if where else ''}: fails by {decimal(self.required - self.margin)}{unit}"


@dataclass(frozen=True)
class PeriodProof:
    """What P9 is about. Starts: |e_i(0)| <= share. rho: e^E by component, |e_i| < (rho - 1)/(rho + 1) throughout; u: |u_i| is
    below. shift: what the law sees of x and the edges is wrong by at most that: arithmetic and noise."""

    period: Fraction
    latency: Fraction
    share: Fraction
    rho: tuple[Fraction, ...]
    u: tuple[Fraction, ...]
    shift: tuple[Fraction, ...]


@dataclass(frozen=True)
class MissionProof:
    """What P10 shows. spans: where each state holds, in slices of a segment (certify/missions/proof.py); margin: in units of the
    table, on all of them; time_margin: in slices; witnesses: by entry of the mission, in seconds; cycle: what is repeated for
    ever."""

    formula: Formula
    spans: dict[StateFormula, tuple[tuple[int, int], ...]]
    margin: int
    time_margin: int
    witnesses: tuple[tuple[Witness, ...], ...]
    cycle: Cycle | None = None


@dataclass(frozen=True)
class Certificate:
    """The findings for one tube, and the numbers that go with them.

    edge_error: P7's bound on the distance between the emitted edge and the exact one, by dimension; rate_error: of their rates,
    for order 2.
    method: "exact" and "enclosure" are proofs; "sampled" finds faults and proves nothing.
    steps: the shortest and longest step of alpha (seconds) for which an adaptive or literal tube is proved.
    speed: bound on |gammadot| by dimension (P6). least_width: over all t and dimensions (a proved lower bound where P1 holds).
    start: gamma(0) as (lower, upper) by dimension. whole_start: gamma(0) is all of the initial set but for
    a thousandth of its width at each edge. proved_period: what P9 proves, where the task has a period and it holds; mission: what
    P10 shows, likewise.
    """

    findings: tuple[Finding, ...]
    edge_error: tuple[Fraction, ...]
    speed: tuple[Fraction, ...]
    least_width: Fraction
    start: tuple[tuple[Fraction, Fraction], ...]
    whole_start: bool
    method: str = "exact"
    steps: tuple[Fraction, Fraction] | None = None
    proved_period: PeriodProof | None = None
    mission: MissionProof | None = None
    rate_error: tuple[Fraction, ...] = ()
    axes: tuple[str, ...] = ()  # what sentences call the dimensions

    @property
    def proves(self) -> bool:
        return self.method != "sampled"

    @property
    def holds(self) -> bool:
        return self.proves and all(f.holds for f in self.findings)

    @property
    def tube_holds(self) -> bool:
        """Whether P1 to P7 and P10 do, whatever becomes of P8 and P9."""
        return self.proves and all(f.holds for f in self.findings if f.subject not in (Property.LIMITS, Property.PERIOD))

    @property
    def lacks_rounding(self) -> bool:
        """Whether the exact tube is sound, and only what the arithmetic takes is missing."""
        short = [f for f in self.failures if f.subject is not Property.ARITHMETIC]
        return self.method == "exact" and bool(short) and all(f.margin >= 0 and f.subject in OF_THE_EDGES for f in short)

    def refusal(self) -> str:
        """All that fails, in one line, and what to change, each advice once, after all that it would mend. P7 is named only where
        the exact tube itself is sound."""
        if self.method == "sampled" and not self.failures:
            at_samples = f"{Property.WIDTH.label} to {Property.SMOOTH.label} hold at the samples"
            kinds = kinds_offering("has_exact_claims", quoted=True)
            return f"{at_samples}, but this design is not proved between them; use tube.design = {kinds}"
        broken = [f for f in self.failures if f.margin < 0 and f.subject is not Property.ARITHMETIC]
        faults: dict[str, list[str]] = {}
        more_room = next((f.remedy for f in self.findings if f.subject is Property.ARITHMETIC), "")
        for f in broken or self.failures:  # what has a margin, but less than the arithmetic takes, no other set would mend
            narrow = f.margin >= 0 and f.subject in OF_THE_EDGES and not f.in_time
            faults.setdefault(more_room if narrow and more_room else f.remedy, []).append(f.fault(self.axes))
        told = "; ".join("; ".join([*found, *([advice] if advice else [])]) for advice, found in faults.items())
        return f"holds at samples but cannot be proved between them: {told}" if self.method == "enclosure" else told

    @property
    def failures(self) -> tuple[Finding, ...]:
        return tuple(f for f in self.findings if not f.holds)
