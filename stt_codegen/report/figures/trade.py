"""Compare the tubes of a task by width, speed and proved period, so that a user can choose tube.prefer (`design --pareto`)."""

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
from stt_codegen.sampling import GainChoice
from stt_codegen.task import Task

PREFERENCES = ("balanced", "slow", "wide", "period")


@dataclass(frozen=True, kw_only=True)
class TubeTradeOff:
    """One certified tube. Widths and speeds are in the task's units.

    smallest_width: over time and dimensions; speed: the largest of any edge. period: the longest proved, in seconds, with
    `gain` by component: the task's gain, or, if the task leaves it open, the one with the longest period; None where none is
    proved. preferred: the values of tube.prefer that give this tube.
    """

    segments: int | None
    smallest_width: float
    speed: float
    period: float | None
    gain: tuple[float, ...] | None
    preferred: tuple[str, ...]

    def dominates(self, alternative: TubeTradeOff) -> bool:
        """Return whether this tube is no worse in width, speed and period, and better in one."""
        qualities, alternatives = ((t.smallest_width, -t.speed, t.period or 0.0) for t in (self, alternative))
        return qualities != alternatives and all(a >= b for a, b in zip(qualities, alternatives, strict=True))

    def document(self) -> dict[str, Any]:
        """Return the tube as JSON data."""
        return {"least_width" if key == "smallest_width" else key: value for key, value in asdict(self).items()}


@dataclass(frozen=True)
class TradeReport:
    """The tubes of one task that no tube dominates, and those that a preference gives, the widest first."""

    task: str
    prescribed_time: float
    tubes: tuple[TubeTradeOff, ...]
    picture: str | None = None

    def with_picture(self, path: Path) -> TradeReport:
        """Return the report with the path of its picture."""
        return replace(self, picture=str(path))

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        data = asdict(self) | {"tubes": [tube.document() for tube in self.tubes]}
        return data if self.picture is not None else {k: v for k, v in data.items() if k != "picture"}


def trade_report(task: Task) -> TradeReport:
    """Design tubes of several widths, certify them, and keep those that no tube dominates or that a preference gives.

    Raises `BadInput` for designs that have no widths to choose from, `NotCertified` where no tube is certified.
    """
    if not task.tube.capabilities.offers_widths:
        kinds = kinds_offering("offers_widths")
        raise BadInput(f"--pareto: is for {kinds} tubes; the {task.tube.design} design has no widths to choose from")
    preferences_by_design: dict[Design, list[str]] = {}
    for preference in PREFERENCES:
        design = design_tube(task.changed(tube={"prefer": preference}))
        preferences_by_design.setdefault(design, []).append(preference)
    for design in family(task):
        preferences_by_design.setdefault(design, [])
    gain = None if task.has_automatic_gain else task.control.gain
    u_max = None if task.has_automatic_limit else task.control.u_max
    options = {"gain": gain, "u_max": u_max, "rest": None, "reserve": None, "period": None}
    without_period = task.changed(control=options)  # P9 would refuse tubes whose period is shorter
    controllers = [
        (build_task(without_period, uncertified=True, tube=design), tuple(preferred))
        for design, preferred in preferences_by_design.items()
    ]
    tubes = [_trade_off(controller, preferred) for controller, preferred in controllers if controller.certificate.holds]
    if not tubes:
        raise NotCertified("--pareto: of the tubes that were found none is certified; see `stt-codegen design`")
    undominated = [t for t in tubes if t.preferred or not any(alternative.dominates(t) for alternative in tubes)]
    widest_first = tuple(sorted(undominated, key=lambda t: (-t.smallest_width, t.speed)))
    return TradeReport(task.name, float(task.prescribed_time), widest_first)


def _trade_off(controller: EmittedController, preferred: tuple[str, ...]) -> TubeTradeOff:
    """Return the width and speed of a certified tube, and its longest proved period with the gain."""
    certificate, analysis = controller.certificate, Analysis(controller)
    if controller.task.control.gain is None:
        choice = analysis.gains.with_longest_period
    else:
        choice = None if analysis.period is None else GainChoice(analysis.sampled_loop.law.gain, analysis.period)
    return TubeTradeOff(
        segments=controller.design.parts,
        smallest_width=float(certificate.minimum_width),
        speed=float(max(certificate.speed)),
        period=None if choice is None else choice.period.seconds,
        gain=None if choice is None else tuple(choice.gain.tolist()),
        preferred=preferred,
    )
