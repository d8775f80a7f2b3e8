"""What a task's tubes trade: width against speed against the proved period, so that one can be preferred (tube.prefer)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from stt_codegen.design import family
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.designs import Design
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task, design_tube
from stt_codegen.report.analysis import Analysis
from stt_codegen.task import Task

PREFERENCES = ("balanced", "slow", "wide", "period")


@dataclass(frozen=True, kw_only=True)
class Trade:
    """One tube, certified. Width (least over time and dimensions) and speed (most of an edge) in the task's units; period:
    seconds between samples that are proved for the plant and the share of starts, with the gain (by component): the task's, or
    where it leaves that open the one that makes it longest. None where none is proved. preferred: the values of tube.prefer
    that give this tube."""

    segments: int | None
    least_width: float
    speed: float
    period: float | None
    gain: tuple[float, ...] | None
    preferred: tuple[str, ...]

    def beats(self, other: Trade) -> bool:
        """No worse in width, speed and period, and better in one."""
        mine, others = ((t.least_width, -t.speed, t.period or 0.0) for t in (self, other))
        return mine != others and all(a >= b for a, b in zip(mine, others, strict=True))


@dataclass(frozen=True)
class TradeReport:
    """The tubes of one task that none other beats, and those that a preference gives, the widest first."""

    task: str
    prescribed_time: float
    tubes: tuple[Trade, ...]
    picture: str | None = None

    def drawn(self, path: Path) -> TradeReport:
        """The same report, naming the picture that was drawn."""
        return replace(self, picture=str(path))

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
        data = asdict(self)
        return data if self.picture is not None else {k: v for k, v in data.items() if k != "picture"}


def trade_report(task: Task) -> TradeReport:
    """Raises `BadInput` for designs that have no widths to choose from, `NotCertified` where there is no tube."""
    if not task.tube.capabilities.offers_widths:
        kinds = kinds_offering("offers_widths")
        raise BadInput(f"--pareto: is for {kinds} tubes; the {task.tube.design} design has no widths to choose from")
    found: dict[Design, list[str]] = {}
    for prefer in PREFERENCES:
        design = design_tube(task.changed(tube={"prefer": prefer}))
        found.setdefault(design, []).append(prefer)
    for design in family(task):
        found.setdefault(design, [])
    gain = None if task.has_automatic_gain else task.control.gain
    free = task.changed(control={"gain": gain, "period": None})  # P9 would refuse tubes whose period is shorter
    pairs = [(build_task(free, uncertified=True, tube=design), tuple(named)) for design, named in found.items()]
    tubes = [_trade(controller, named) for controller, named in pairs if controller.certificate.holds]
    if not tubes:
        raise NotCertified("--pareto: of the tubes that were found none is certified; see `stt-codegen design`")
    kept = [t for t in tubes if t.preferred or not any(other.beats(t) for other in tubes)]
    return TradeReport(task.name, float(task.prescribed_time), tuple(sorted(kept, key=lambda t: (-t.least_width, t.speed))))


def _trade(controller: EmittedController, preferred: tuple[str, ...]) -> Trade:
    certificate = controller.certificate
    analysis = Analysis(controller)
    if controller.task.control.gain is None:
        best = analysis.gains.longest
    else:
        best = None if analysis.period is None else (analysis.setting.law.gain, analysis.period)
    return Trade(
        segments=controller.design.parts,
        least_width=float(certificate.minimum_width),
        speed=float(max(certificate.speed)),
        period=None if best is None else best[1].seconds,
        gain=None if best is None else tuple(best[0].tolist()),
        preferred=preferred,
    )
