"""What `stt-codegen simulate` does: one loop, what was proved for it beforehand, its trace and picture."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from stt_codegen.bounds import Analysis, above_float
from stt_codegen.emit.manifest import write_files
from stt_codegen.errors import BadInput
from stt_codegen.loop.simulate import Loop, Run, Scenario, csv
from stt_codegen.pipeline import Controller, build_program, build_task, render_files, require_supported
from stt_codegen.plants import Model, Plant, plant_of
from stt_codegen.task import load_task


def simulate_task(
    path: Path,
    design: str | None,
    scalar: str | None,
    uncertified: bool,
    out: Path | None,
    plant_name: str,
    rate: float | None,
    disturbance: str,
    w_max: float | None,
    noise: float,
    lost: int,
    latency: float,
    start: str | None,
    seed: int,
    gain: str | None,
) -> dict[str, Any]:
    """The report of one run as JSON data."""
    task = load_task(path).with_options(design, scalar)
    require_supported(task)
    controller = build_task(task, uncertified)
    plant = plant_of(plant_name, task.dimension)
    rate = rate if rate is not None else float(1 / (task.emit.tick_period or Fraction(1, 1000)))
    strength = w_max if w_max is not None else float(plant.w_max or task.plant.w_max or 0)
    Scenario(rate, disturbance, strength, seed, noise, lost, None, latency)  # refuses what is no number or no name
    if disturbance != "none" and strength == 0:
        raise BadInput(f"--disturbance {disturbance}: of which size? give --w-max, its greatest norm in units per second")
    strength = 0.0 if disturbance == "none" else strength
    windy = with_wind(plant, strength)
    if gain is not None:
        controller = with_gain(controller, _gain(gain, Analysis(controller, windy, noise, latency)))
    scenario = Scenario(rate, disturbance, strength, seed, noise, lost, _numbers(start), latency)
    run = Loop(controller, plant).run(scenario, trace=out is not None)
    report = {
        "task": task.name,
        "design": controller.design.kind,
        "plant": plant.name,
        "gain": float(controller.task.control.gain),
        "rate": rate,
        "disturbance": disturbance,
        "w_max": strength,
        "noise": noise,
        "lost": lost,
        "latency": latency,
        "seed": seed,
        "fulfilled": run.good,
        "kept": run.kept,
        **{name: _numbers_or_null(value) for name, value in asdict(run).items() if name != "trace"},
        "foretold": foretold(controller, windy, scenario),
        "files": [],
    }
    if out is not None:
        report["files"] = write_run(controller, run, out)
    return report


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
    analysis = Analysis(controller, plant, scenario.noise, scenario.latency)
    if scenario.start is not None:
        analysis.setting = replace(analysis.setting, start=analysis.start_at(scenario.start))
    failed = [h.statement for h in analysis.hypotheses() if not h.holds]
    lines = [f"does not hold: {statement}" for statement in failed]
    age, period = scenario.age, analysis.period
    if period is None:
        return [*lines, f"no sampling period is proved for gain {float(controller.task.control.gain):g} and this plant"]
    most, here, e = f"{1e3 * period.seconds:.4g} ms", f"{1e3 * age:.4g} ms", f"|e| stays below {above_float(period.e):g}"
    if 1 / scenario.rate < analysis.shortest:
        return [*lines, f"not proved: alpha may not be stepped more often than every {1e3 * analysis.shortest:.4g} ms"]
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
