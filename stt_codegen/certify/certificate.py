"""What a certificate says: the properties P1 to P7, P8 where u is limited and the plant has bounds, P9 where the task has a
period, P10 where it has a mission, each with its margin and the place where the margin is least."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.certify.monitor import Cycle, Witness
from stt_codegen.decimals import decimal
from stt_codegen.task.formula import Formula
from stt_codegen.task.mission import State

TITLES = {
    "P1": "width",
    "P2": "start",
    "P3": "stay",
    "P4": "avoid",
    "P5": "reach",
    "P6": "smooth",
    "P7": "arithmetic",
    "P8": "limits",
    "P9": "period",
    "P10": "mission",
}


ROUNDED = ("P1", "P2", "P3", "P4", "P5", "P10")  # properties that must have room for the arithmetic


@dataclass(frozen=True)
class Finding:
    """One property. It holds when `margin` >= `required` (task's units; seconds for P9 and the second of P10, but a length where
    initial_state is outside the share; units per second for P8); then `margin` is a proved lower bound on the slack, least in the
    time interval `time` (seconds), `dimension` (from 1) and at `obstacle`. When it fails, margin and place are those of one place
    where it fails, not necessarily the worst."""

    code: str
    statement: str
    margin: Fraction
    required: Fraction
    time: tuple[Fraction, Fraction] | None = None
    dimension: int | None = None
    obstacle: str | None = None
    advice: str = ""
    in_time: bool = False  # margin and required are seconds

    @property
    def title(self) -> str:
        return TITLES[self.code]

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
        where, unit = self.place(axes), " s" if self.in_time or (self.code == "P9" and self.time is None) else ""
        return f"{self.code} {self.title}{' at ' + where if where else ''}: fails by {decimal(self.required - self.margin)}{unit}"


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
    """What P10 shows. spans: where each state holds, in slices of a segment (certify/mission.py); margin: in units of the table,
    on all of them; time_margin: in slices; witnesses: by entry of the mission, in seconds; cycle: what is repeated for ever."""

    formula: Formula
    spans: dict[State, tuple[tuple[int, int], ...]]
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
        return self.proves and all(f.holds for f in self.findings if f.code not in ("P8", "P9"))

    @property
    def lacks_rounding(self) -> bool:
        """Whether the exact tube is sound, and only what the arithmetic takes is missing."""
        short = [f for f in self.failures if f.code != "P7"]
        return self.method == "exact" and bool(short) and all(f.margin >= 0 and f.code in ROUNDED for f in short)

    def refusal(self) -> str:
        """All that fails, in one line, and what to change, each advice once, after all that it would mend. P7 is named only where
        the exact tube itself is sound."""
        if self.method == "sampled" and not self.failures:
            return 'P1 to P6 hold at the samples, but this design is not proved between them; use tube.design = "refined"'
        broken = [f for f in self.failures if f.margin < 0 and f.code != "P7"]
        faults: dict[str, list[str]] = {}
        seventh = next((f.advice for f in self.findings if f.code == "P7"), "")
        for f in broken or self.failures:  # what has a margin, but less than the arithmetic takes, no other set would mend
            narrow = f.margin >= 0 and f.code in ROUNDED and not f.in_time
            faults.setdefault(seventh if narrow and seventh else f.advice, []).append(f.fault(self.axes))
        told = "; ".join("; ".join([*found, *([advice] if advice else [])]) for advice, found in faults.items())
        return f"holds at samples but cannot be proved between them: {told}" if self.method == "enclosure" else told

    @property
    def failures(self) -> tuple[Finding, ...]:
        return tuple(f for f in self.findings if not f.holds)
