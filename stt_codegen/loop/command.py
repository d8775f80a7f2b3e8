"""What `stt-codegen simulate` does: one loop, what was proved for it beforehand, its trace and picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from stt_codegen.errors import BadInput
from stt_codegen.files import write_files
from stt_codegen.loop.foretold import describe_proof, drives_of
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import Loop, Run, Scenario, scenario_of_task
from stt_codegen.loop.traces import trace_csv
from stt_codegen.pipeline import EmittedController, build_program, certify, render_files
from stt_codegen.plants import Model, Plant, plant_of
from stt_codegen.report import Analysis
from stt_codegen.sampling import choose_proved_gain
from stt_codegen.task import DriveBounds, Task

BOUNDS = "bounds"  # the name that --plant gives `corner_plants`


@dataclass(frozen=True, kw_only=True)
class Request:
    """The options of `simulate`; None stands for the value of the task or the plant. `Scenario` has the other fields:

    plant: a name, a file, or "bounds" for the worst of the plants at the corners of [plant], with the worst drives. lag: seconds
    of one first-order lag in all components, in place of the task's drives. start: numbers with commas between them.
    gain: a number, or "best". axes: pairs of dimensions to draw in, by name with a comma between them.
    """

    plant: str = "integrator"
    rate: float | None = None
    disturbance: str = "none"
    w_max: float | None = None
    noise: float | None = None
    lost: int = 0
    latency: float | None = None
    lag: float | None = None
    start: str | None = None
    seed: int = 0
    gain: str | None = None
    axes: tuple[str, ...] = ()
    clock: str = "stated"

    def scenario(self, task: Task, plant: Model) -> Scenario:
        """Return the scenario of the run. Raises `BadInput` for an option that is not allowed, or a disturbance of size 0."""
        drives = None if self.lag is None else drives_of(self.lag, task)
        options = {"rate": self.rate, "noise": self.noise, "latency": self.latency, "drives": drives}
        conditions = scenario_of_task(task) | {name: value for name, value in options.items() if value is not None}
        strength = self.w_max if self.w_max is not None else float(plant.w_max or task.disturbance_bound)
        scenario = Scenario(
            disturbance=self.disturbance, strength=strength, seed=self.seed, lost=self.lost, clock=self.clock,
            **conditions,
        )  # fmt: skip
        if self.w_max and self.disturbance == "none":
            raise BadInput(f"--w-max {self.w_max:g}: of which disturbance? give --disturbance, for example nearest")
        if self.disturbance != "none" and strength == 0:
            raise BadInput(
                f"--disturbance {self.disturbance}: of which size? give --w-max, its greatest norm in units per second"
            )
        return replace(scenario, strength=0.0 if self.disturbance == "none" else strength, start=_numbers(self.start))


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """The result of a closed loop, and lines that say what was proved for it beforehand; files: paths of trace and picture."""

    controller: EmittedController
    plant: str
    scenario: Scenario
    run: Run
    proof_lines: tuple[str, ...]
    files: tuple[str, ...]

    @property
    def fulfilled(self) -> bool:
        """Whether the run fulfilled the task."""
        return self.run.good

    @property
    def _omitted_fields(self) -> set[str]:
        """Fields of a run that the document leaves out: the trace, and those that do not apply to the task."""
        omitted = {"trace"} | (set() if self.controller.task.control.outside == "hold" else {"waited"})
        return omitted | (set() if self.controller.task.mission else {"missed"})

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        s = self.scenario
        return {
            "task": self.controller.task.name,
            "design": self.controller.design.kind,
            "plant": self.plant,
            "gain": [float(v) for v in self.controller.task.gain],
            "rate": s.rate,
            "disturbance": s.disturbance,
            "w_max": s.strength,
            "noise": s.noise,
            "lost": s.lost,
            "latency": s.latency,
            **({"drives": [_drive_document(bounds) for bounds in s.drives]} if s.has_drives else {}),
            **({"clock": s.clock} if any(c is not None for c in self.controller.task.courses) else {}),
            "seed": s.seed,
            "fulfilled": self.run.good,
            "kept": self.run.kept,
            **{name: _numbers_or_null(value) for name, value in asdict(self.run).items() if name not in self._omitted_fields},
            "foretold": list(self.proof_lines),
            "files": list(self.files),
        }


def simulate(controller: EmittedController, request: Request, out: Path | None) -> RunReport:
    """Run a closed loop; its trace and picture go to the folder `out`, where one is named.

    Of several plants (--plant bounds) the report is about the run with the worst result.
    """
    task = controller.task
    is_at_bounds = request.plant == BOUNDS
    models = corner_plants(task) if is_at_bounds else [plant_of(request.plant, task.dimension, task.order)]
    scenario = _scenario_of(request, task, models[0])
    plant = None if is_at_bounds else with_disturbance_bound(models[0], scenario.strength)
    if request.gain is not None:
        analysis = Analysis(controller, plant, scenario.noise, scenario.latency)
        controller = with_gain(controller, _gain(request.gain, analysis, scenario.age))
    runs = [
        AttackedRun(model.name, attack, Loop(controller, model).run(attack, trace=out is not None))
        for model in models
        for attack in _attacks(request, scenario)
    ]
    name, scenario, run = min(runs, key=lambda attacked: (attacked.run.good, attacked.run.margin))
    written = () if out is None else tuple(write_run(controller, run, out, request.axes, scenario.clock))
    return RunReport(
        controller=controller,
        plant=name,
        scenario=scenario,
        run=run,
        proof_lines=tuple(describe_proof(controller, plant, scenario)),
        files=written,
    )


class AttackedRun(NamedTuple):
    """A run with the name of its plant and its scenario."""

    plant: str
    scenario: Scenario
    run: Run


def _attacks(request: Request, scenario: Scenario) -> tuple[Scenario, ...]:
    """Return the scenarios that are run: of --plant bounds, the worst drives, pushed outward and along their motion."""
    if request.plant != BOUNDS:
        return (scenario,)
    adverse = replace(scenario, is_adverse=True)
    is_chosen = request.disturbance != "none" or not scenario.has_drives
    return (adverse,) if is_chosen else (replace(adverse, disturbance="outward"), replace(adverse, disturbance="motion"))


def _drive_document(bounds: DriveBounds) -> dict[str, float | None]:
    """Return a drive as JSON data."""
    return {name: None if value is None else float(value) for name, value in asdict(bounds).items()}


def _scenario_of(request: Request, task: Task, model: Model) -> Scenario:
    """Return the scenario of a request; that of --plant bounds has the shares of w of [plant]. Raises `BadInput`."""
    if request.plant == BOUNDS and request.disturbance == "none" and model.w_max:
        request = replace(request, disturbance="outward")
    if request.clock != "stated" and not any(c is not None for c in task.courses):
        raise BadInput(f"--clock {request.clock}: no unsafe set of the task moves or has an active interval; leave it out")
    scenario = request.scenario(task, model)
    if request.plant != BOUNDS:
        return scenario
    forces = [float(b.force) for b in task.plant_bounds]
    if scenario.strength > float(model.w_max):
        raise BadInput(f"--w-max {scenario.strength:g}: is beyond [plant], whose f_max + w_max is {float(model.w_max):g}")
    return replace(scenario, shares=tuple(v / max(*forces, 1e-300) for v in forces))


def _numbers_or_null(value: Any) -> Any:
    """Return the value with null for infinity and NaN, which JSON does not have."""
    if isinstance(value, list | tuple):
        return [_numbers_or_null(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def with_disturbance_bound(plant: Model, strength: float) -> Plant:
    """Return the plant with another bound on |w|."""
    return Plant(
        name=plant.name,
        dimension=plant.dimension,
        drift=plant.f,
        input_matrix=plant.g,
        w_max=Fraction(strength),
        order=plant.order,
        constants=plant.constants,
        mixing=plant.mixing,
    )


def with_gain(controller: EmittedController, gain: Sequence[float]) -> EmittedController:
    """Return the controller of the same tube with other gains by component, rounded to six digits."""
    task = controller.task.with_gain([Fraction(f"{k:.6g}") for k in gain])
    program, certificate = build_program(task, controller.design), controller.certificate
    if task.control.period is not None:  # P9 is about the gain
        certificate = certify(task, controller.design, program)
    files = render_files(task, controller.design, program, certificate)
    return EmittedController(task, controller.design, program, certificate, files)


def _gain(text: str, analysis: Analysis, age: float) -> tuple[float, ...]:
    """Return the gain of --gain by component: a number, or for "best" the gain with the largest proved margin for samples that
    get `age` seconds old; where none is proved for that age, the gain of the longest proved period."""
    task = analysis.controller.task
    if text == "best":
        loop, shortest = analysis.sampled_loop, analysis.shortest
        best = (
            choose_proved_gain(loop, age, shortest, analysis.condition_kinds) or analysis.gains.with_longest_period
            if analysis.controller.certificate.tube_holds
            else None
        )
        if best is None:
            raise BadInput("--gain best: no gain is proved for this tube and plant at any period")
        return tuple((math.copysign(1, task.gain[0]) * best[0]).tolist())
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if value == 0 or not math.isfinite(value):
        raise BadInput(f'--gain {text}: a number that is not 0 is needed, or "best"')
    return (value,) * task.dimension


def _numbers(text: str | None) -> tuple[float, ...] | None:
    """Return the numbers of --start. Raises `BadInput`."""
    if text is None:
        return None
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError:
        raise BadInput(f"--start {text}: numbers with commas between them are needed, for example 0.25,0.25") from None


def write_run(
    controller: EmittedController, run: Run, folder: Path, axes: Sequence[str] = (), clock: str = "stated"
) -> list[str]:
    """Write the trace and a picture of it into a folder, and return their paths."""
    from stt_codegen.loop.picture import draw_run
    from stt_codegen.report.pictures import plane_named

    assert run.trace is not None
    name = f"{controller.task.name}.loop"
    write_files(folder, {f"{name}.csv": trace_csv(run.trace, controller.task, clock)})
    draw_run(controller, run, folder / f"{name}.png", [plane_named(controller.task, text) for text in axes])
    return [str(folder / f"{name}.csv"), str(folder / f"{name}.png")]
