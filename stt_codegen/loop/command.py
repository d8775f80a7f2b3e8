"""What `stt-codegen simulate` does: one loop, what was proved for it beforehand, its trace and picture."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput
from stt_codegen.loop.simulate import Loop, Run, Scenario, csv
from stt_codegen.pipeline import Controller, build_program, render_files
from stt_codegen.plants import Model, Plant, plant_of
from stt_codegen.record.files import write_files
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.bounds import above_float, below_float
from stt_codegen.task import Task


@dataclass(frozen=True)
class Request:
    """What a user asks `simulate` for; None: what the task or the plant says. As in `Scenario`; plant: a name or a file; start:
    numbers with commas between them; gain: a number, or "best"."""

    plant: str = "integrator"
    rate: float | None = None
    disturbance: str = "none"
    w_max: float | None = None
    noise: float = 0.0
    lost: int = 0
    latency: float = 0.0
    start: str | None = None
    seed: int = 0
    gain: str | None = None

    def scenario(self, task: Task, plant: Model) -> Scenario:
        """What the loop runs under. Raises `BadInput` for what is no number or no name, or a disturbance of no size."""
        rate = self.rate if self.rate is not None else float(1 / (task.emit.tick_period or Fraction(1, 1000)))
        strength = self.w_max if self.w_max is not None else float(plant.w_max or task.plant.w_max or 0)
        scenario = Scenario(
            rate=rate, disturbance=self.disturbance, strength=strength, seed=self.seed, noise=self.noise, lost=self.lost,
            latency=self.latency,
        )  # fmt: skip
        if self.disturbance != "none" and strength == 0:
            raise BadInput(
                f"--disturbance {self.disturbance}: of which size? give --w-max, its greatest norm in units per second"
            )
        return replace(scenario, strength=0.0 if self.disturbance == "none" else strength, start=_numbers(self.start))


@dataclass(frozen=True)
class RunReport:
    """What came of a loop, and what had been proved for it beforehand; files: what was written."""

    controller: Controller
    plant: str
    scenario: Scenario
    run: Run
    foretold: tuple[str, ...]
    files: tuple[str, ...]

    @property
    def fulfilled(self) -> bool:
        return self.run.good

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
        s = self.scenario
        return {
            "task": self.controller.task.name,
            "design": self.controller.design.kind,
            "plant": self.plant,
            "gain": float(self.controller.task.control.gain),
            "rate": s.rate,
            "disturbance": s.disturbance,
            "w_max": s.strength,
            "noise": s.noise,
            "lost": s.lost,
            "latency": s.latency,
            "seed": s.seed,
            "fulfilled": self.run.good,
            "kept": self.run.kept,
            **{name: _numbers_or_null(value) for name, value in asdict(self.run).items() if name != "trace"},
            "foretold": list(self.foretold),
            "files": list(self.files),
        }


def simulate(controller: Controller, request: Request, out: Path | None) -> RunReport:
    """One run; its trace and picture go to the folder `out`, where one is named."""
    task = controller.task
    plant = plant_of(request.plant, task.dimension)
    scenario = request.scenario(task, plant)
    windy = with_wind(plant, scenario.strength)
    if request.gain is not None:
        controller = with_gain(controller, _gain(request.gain, Analysis(controller, windy, scenario.noise, scenario.latency)))
    run = Loop(controller, plant).run(scenario, trace=out is not None)
    written = () if out is None else tuple(write_run(controller, run, out))
    return RunReport(controller, plant.name, scenario, run, tuple(foretold(controller, windy, scenario)), written)


def _numbers_or_null(value: Any) -> Any:
    """JSON has no infinity and no NaN: null in their place."""
    if isinstance(value, list | tuple):
        return [_numbers_or_null(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def with_wind(plant: Model, strength: float) -> Plant:
    """The plant with another bound on |w|."""
    return Plant(plant.name, "", plant.dimension, plant.f, plant.g, Fraction(strength))


def with_gain(controller: Controller, gain: float) -> Controller:
    """The controller made again with another gain, a short decimal: of the same tube, which no gain changes."""
    control = controller.task.control.model_copy(update={"gain": Fraction(f"{gain:.6g}")})
    task = controller.task.model_copy(update={"control": control})
    program = build_program(task, controller.design)
    files = render_files(task, controller.design, program, controller.certificate)
    return Controller(task, controller.design, program, controller.certificate, files)


def _gain(text: str, analysis: Analysis) -> float:
    controller = analysis.controller
    if text == "best":
        best = analysis.best_gain if controller.certificate.holds else None
        if best is None:
            raise BadInput("--gain best: no gain is proved for this tube and plant at any period")
        return math.copysign(best[0], float(controller.task.control.gain))
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if value == 0 or not math.isfinite(value):
        raise BadInput(f'--gain {text}: a number that is not 0 is needed, or "best"')
    return value


def _numbers(text: str | None) -> tuple[float, ...] | None:
    if text is None:
        return None
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError:
        raise BadInput(f"--start {text}: numbers with commas between them are needed, for example 0.25,0.25") from None


def foretold(controller: Controller, plant: Model, scenario: Scenario) -> list[str]:
    """What `prove TASK` says of this loop before it is run."""
    if not controller.certificate.holds:
        return ["the tube is not certified: nothing is proved"]
    analysis = Analysis(controller, plant, scenario.noise, scenario.latency, scenario.start)
    failed = [h.statement for h in analysis.hypotheses() if not h.holds]
    lines = [f"does not hold: {statement}" for statement in failed]
    age, period = scenario.age, analysis.period
    if period is None:
        return [*lines, f"no sampling period is proved for gain {float(controller.task.control.gain):g} and this plant"]
    e = f"|e| stays below {above_float(period.e):g}"
    most, here = f"{1e3 * below_float(period.seconds):.4g} ms", f"{1e3 * age:.9g} ms"
    if 1 / scenario.rate < analysis.shortest:
        least = f"{1e3 * above_float(analysis.shortest):.4g} ms"
        return [*lines, f"not proved: alpha may not be stepped more often than every {least}"]
    if age <= period.seconds:
        return [*lines, f"proved: {e}, with samples up to {most} old (here {here})"]
    return [*lines, f"not proved: samples get {here} old here, up to {most} are proved"]


def write_run(controller: Controller, run: Run, folder: Path) -> list[str]:
    """The trace and a picture of it; their paths."""
    from stt_codegen.loop.picture import draw_run

    assert run.trace is not None
    name = f"{controller.task.name}.loop"
    write_files(folder, {f"{name}.csv": csv(run.trace, controller.task.dimension)})
    draw_run(controller, run, folder / f"{name}.png")
    return [str(folder / f"{name}.csv"), str(folder / f"{name}.png")]
