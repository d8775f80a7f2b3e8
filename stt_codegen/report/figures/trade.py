"""Compare the tubes of a task by width, speed and proved period, so that a user can choose tube.prefer (`design --pareto`)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from stt_codegen.design import family
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.designs import Design
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task, preferred_tube
from stt_codegen.properties import Property
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling import GainChoice
from stt_codegen.task import Task

PREFERENCES = ("balanced", "slow", "wide", "period")


@dataclass(frozen=True, kw_only=True)
class TubeTradeOff:
    """One certified tube. Widths and speeds are in the task's units.

    smallest_width: over time and dimensions; speed: the largest of any edge. period: the longest proved, in seconds, with
    `gain` by component: the task's gain, or, if the task leaves it open, the one with the longest period; with the task's drive,
    where it states one, and then for the gain that is chosen at the task's period. None where none is proved. preferred: the
    values of tube.prefer that give this tube.
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
    """The tubes of one task that no tube dominates, and those that a preference gives, the widest first.

    has_drive: whether periods are those of the task's drive.
    """

    task: str
    prescribed_time: float
    tubes: tuple[TubeTradeOff, ...]
    has_drive: bool = False
    picture: str | None = None

    def with_picture(self, path: Path) -> TradeReport:
        """Return the report with the path of its picture."""
        return replace(self, picture=str(path))

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        data = asdict(self) | {"tubes": [tube.document() for tube in self.tubes]}
        return {k: v for k, v in data.items() if not ((k == "picture" and v is None) or (k == "has_drive" and not v))}


class LongestPeriod(NamedTuple):
    """A period in seconds, and the gain by component with which it is proved."""

    seconds: float
    gain: tuple[float, ...]


def trade_report(task: Task) -> TradeReport:
    """Design tubes of several widths, certify them, and keep those that no tube dominates or that a preference gives.

    Raises `BadInput` for designs that have no widths to choose from, `NotCertified` where no tube is certified.
    """
    if not task.tube.capabilities.offers_widths:
        kinds = kinds_offering("offers_widths")
        raise BadInput(f"--pareto: is for {kinds} tubes; the {task.tube.design} design has no widths to choose from")
    preferences_by_design: dict[Design, list[str]] = {}
    for preference in PREFERENCES:
        design = preferred_tube(task.changed(tube={"prefer": preference}))
        preferences_by_design.setdefault(design, []).append(preference)
    for design in family(task):
        preferences_by_design.setdefault(design, [])
    compared_task = task if task.has_drive else _without_period(task)
    controllers = [
        (build_task(compared_task, uncertified=True, tube=design), tuple(preferred))
        for design, preferred in preferences_by_design.items()
    ]
    tubes = [_trade_off(controller, preferred) for controller, preferred in controllers if _holds_but_for_its_period(controller)]
    if not tubes:
        raise NotCertified("--pareto: of the tubes that were found none is certified; see `stt-codegen design`")
    undominated = [t for t in tubes if t.preferred or not any(alternative.dominates(t) for alternative in tubes)]
    widest_first = tuple(sorted(undominated, key=lambda t: (-t.smallest_width, t.speed)))
    return TradeReport(task.name, float(task.prescribed_time), widest_first, task.has_drive)


def _without_period(task: Task) -> Task:
    """Return the task without a period, for P9 would refuse tubes whose longest one is shorter, and without what is for one."""
    gain = None if task.has_automatic_gain else task.control.gain
    u_max = None if task.has_automatic_limit else task.control.u_max
    return task.changed(control={"gain": gain, "u_max": u_max, "rest": None, "reserve": None, "period": None})


def _holds_but_for_its_period(controller: EmittedController) -> bool:
    """Whether all that is certified holds, but for the task's period."""
    certificate = controller.certificate
    return certificate.proves and all(f.subject is Property.PERIOD for f in certificate.failures)


def _trade_off(controller: EmittedController, preferred: tuple[str, ...]) -> TubeTradeOff:
    """Return the width and speed of a certified tube, and its longest proved period with the gain."""
    certificate = controller.certificate
    period = _longest_period_with_drive(controller) if controller.task.has_drive else _longest_period(controller)
    return TubeTradeOff(
        segments=controller.design.parts,
        smallest_width=float(certificate.minimum_width),
        speed=float(max(certificate.speed)),
        period=None if period is None else period.seconds,
        gain=None if period is None else period.gain,
        preferred=preferred,
    )


def _longest_period(controller: EmittedController) -> LongestPeriod | None:
    """Return the longest proved period of a task without a drive, in seconds, and its gain by component."""
    analysis = Analysis(controller)
    if controller.task.control.gain is None:
        choice = analysis.gains.with_longest_period
    else:
        choice = None if analysis.period is None else GainChoice(analysis.sampled_loop.law.gain, analysis.period)
    return None if choice is None else LongestPeriod(choice.period.seconds, tuple(choice.gain.tolist()))


def _longest_period_with_drive(controller: EmittedController) -> LongestPeriod | None:
    """Return the longest period that P9 proves with the task's drive, at the task's gain: P9's margin is beside the period."""
    task = controller.task
    finding = next(f for f in controller.certificate.findings if f.subject is Property.PERIOD)
    seconds = float(task.sampling_period + finding.margin) if finding.is_in_seconds else 0.0
    return LongestPeriod(seconds, tuple(float(abs(v)) for v in task.gain)) if seconds > 0 else None
