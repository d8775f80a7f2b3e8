"""What `stt-codegen simulate` does: one loop, what was proved for it beforehand, its trace and picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from stt_codegen.decimals import by_component
from stt_codegen.errors import BadInput
from stt_codegen.loop.simulate import Loop, Run, Scenario, csv, of_task
from stt_codegen.pipeline import EmittedController, build_program, certify, render_files
from stt_codegen.plants import Model, Plant, plant_of
from stt_codegen.record import write_files
from stt_codegen.report import Analysis, round_down, round_up
from stt_codegen.sampling import choose_proved_gain, prove_for_period
from stt_codegen.task import Task

BOUNDS = "bounds"  # the name of the plants within_bounds


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a user asks `simulate` for; None: what the task or the plant says. As in `Scenario`; plant: a name, a file, or
    "bounds" for the worst of the plants at the corners of [plant]; start: numbers with commas between them; gain: a number, or
    "best"; axes: pairs of dimensions to draw in, by name with a comma between them."""

    plant: str = "integrator"
    rate: float | None = None
    disturbance: str = "none"
    w_max: float | None = None
    noise: float | None = None
    lost: int = 0
    latency: float | None = None
    lag: float = 0.0
    start: str | None = None
    seed: int = 0
    gain: str | None = None
    axes: tuple[str, ...] = ()
    clock: str = "stated"

    def scenario(self, task: Task, plant: Model) -> Scenario:
        """What the loop runs under. Raises `BadInput` for what is no number or no name, or a disturbance of no size."""
        given = {"rate": self.rate, "noise": self.noise, "latency": self.latency}
        told = of_task(task) | {name: value for name, value in given.items() if value is not None}
        strength = self.w_max if self.w_max is not None else float(plant.w_max or task.disturbance_bound)
        scenario = Scenario(
            disturbance=self.disturbance, strength=strength, seed=self.seed, lost=self.lost, clock=self.clock,
            lag=self.lag, **told,
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
    """What came of a loop, and what had been proved for it beforehand; files: what was written."""

    controller: EmittedController
    plant: str
    scenario: Scenario
    run: Run
    foretold: tuple[str, ...]
    files: tuple[str, ...]

    @property
    def fulfilled(self) -> bool:
        return self.run.good

    @property
    def _unsaid(self) -> set[str]:
        """What of a run is no data, or not asked for."""
        unsaid = {"trace"} | (set() if self.controller.task.control.outside == "hold" else {"waited"})
        return unsaid | (set() if self.controller.task.mission else {"missed"})

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
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
            **({"lag": s.lag} if s.lag else {}),
            **({"clock": s.clock} if any(c is not None for c in self.controller.task.courses) else {}),
            "seed": s.seed,
            "fulfilled": self.run.good,
            "kept": self.run.kept,
            **{name: _numbers_or_null(value) for name, value in asdict(self.run).items() if name not in self._unsaid},
            "foretold": list(self.foretold),
            "files": list(self.files),
        }


def simulate(controller: EmittedController, request: Request, out: Path | None) -> RunReport:
    """One run; its trace and picture go to the folder `out`, where one is named."""
    task = controller.task
    models = within_bounds(task) if request.plant == BOUNDS else [plant_of(request.plant, task.dimension, task.order)]
    if request.plant == BOUNDS and request.disturbance == "none" and models[0].w_max:
        request = replace(request, disturbance="outward")
    if request.clock != "stated" and not any(c is not None for c in task.courses):
        raise BadInput(f"--clock {request.clock}: no unsafe set of the task moves or has hours; leave it out")
    scenario = request.scenario(task, models[0])
    if request.plant == BOUNDS:
        forces = [float(b.force) for b in task.plant_bounds]
        scenario = replace(scenario, shares=tuple(v / max(*forces, 1e-300) for v in forces))
    if request.plant == BOUNDS and scenario.strength > float(models[0].w_max):
        raise BadInput(f"--w-max {scenario.strength:g}: is beyond [plant], whose f_max + w_max is {float(models[0].w_max):g}")
    windy = None if request.plant == BOUNDS else with_wind(models[0], scenario.strength)
    if request.gain is not None:
        analysis = Analysis(controller, windy, scenario.noise, scenario.latency)
        controller = with_gain(controller, _gain(request.gain, analysis, scenario.age))
    runs = [(model.name, Loop(controller, model).run(scenario, trace=out is not None)) for model in models]
    name, run = min(runs, key=lambda one: (one[1].good, one[1].margin))
    written = () if out is None else tuple(write_run(controller, run, out, request.axes, scenario.clock))
    return RunReport(
        controller=controller,
        plant=name,
        scenario=scenario,
        run=run,
        foretold=tuple(foretold(controller, windy, scenario)),
        files=written,
    )


def _numbers_or_null(value: Any) -> Any:
    """JSON has no infinity and no NaN: null in their place."""
    if isinstance(value, list | tuple):
        return [_numbers_or_null(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def within_bounds(task: Task) -> list[Plant]:
    """Plants at the corners of what P9 is about: every g_ii the weakest or the strongest (of -g for a negative gain), every g_ij
    as large as may be with either sign, and f counted to w, which pushes wherever the disturbance says."""
    sign = 1 if task.gain[0] > 0 else -1
    stated, n = task.plant_bounds, task.dimension
    push = max(b.force for b in stated)
    cross = [b.cross for b in stated]
    if task.scales_input and n > 1:  # there g_min and g_max are about norms: what couples turns, and leaves g_s as it is
        least, most = float(stated[0].g_min), float(stated[0].g_max)
        cross = [min(c, Fraction(math.sqrt(max(most**2 - least**2, 0.0)) / (n - 1)) * Fraction(999, 1000)) for c in cross]

    def plant(words: str, own: list[Fraction], other: int) -> Plant:
        def matrix(*_: Any) -> list[list[float]]:
            def beside(i: int, j: int) -> Fraction:
                return other * cross[i] * (-1 if task.scales_input and j < i else 1)

            return [[float(sign * own[i] if i == j else beside(i, j)) for j in range(n)] for i in range(n)]

        return Plant(
            name=f"[plant], {words}",
            dimension=None,
            drift=lambda x, *_: [0] * x.shape[0],
            input_matrix=matrix,
            w_max=push,
            order=None,
        )

    weakest, strongest = [b.g_min for b in stated], [b.g_max for b in stated]
    gains = [("weakest g", weakest), ("strongest g", strongest)][: 1 + (weakest != strongest)]
    gains = gains[:1] if task.scales_input and task.is_coupled else gains
    signs = [(", coupled", 1), (", coupled the other way", -1)] if task.is_coupled else [("", 0)]
    return [plant(word + way, own, other) for word, own in gains for way, other in signs]


def with_wind(plant: Model, strength: float) -> Plant:
    """The plant with another bound on |w|."""
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
    """The controller made again with other gains by component, short decimals: of the same tube, which no gain changes."""
    task = controller.task.with_gain([Fraction(f"{k:.6g}") for k in gain])
    program, certificate = build_program(task, controller.design), controller.certificate
    if task.control.period is not None:  # P9 is about the gain
        certificate = certify(task, controller.design, program)
    files = render_files(task, controller.design, program, certificate)
    return EmittedController(task, controller.design, program, certificate, files)


def _gain(text: str, analysis: Analysis, age: float) -> tuple[float, ...]:
    """What --gain says: a number for every component, or "best", which leaves the most room when samples get `age` seconds old;
    where none is proved for that, the gain of the longest period."""
    task = analysis.controller.task
    if text == "best":
        setting, shortest = analysis.sampled_loop, analysis.shortest
        best = (
            choose_proved_gain(setting, age, shortest, analysis.condition_kinds) or analysis.gains.longest
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
    if text is None:
        return None
    try:
        return tuple(float(v) for v in text.split(","))
    except ValueError:
        raise BadInput(f"--start {text}: numbers with commas between them are needed, for example 0.25,0.25") from None


def foretold(controller: EmittedController, plant: Model | None, scenario: Scenario) -> list[str]:
    """What `prove TASK` says of this loop before it is run; plant None: the bounds of [plant]."""
    if not controller.certificate.tube_holds:
        return ["the tube is not certified: nothing is proved"]
    if scenario.lag:
        return [f"not proved: u acts through a lag of {scenario.lag:g} s, which no statement here allows for"]
    task, start = (
        controller.task,
        [float(v) for v in (controller.task.initial_state if scenario.start is None else scenario.start)],
    )
    if task.uses_differences and any(start[task.dimension :]):
        return ["not proved: a velocity by differences is 0 at the first sample, so starts are at rest"]
    if task.uses_differences and scenario.rate > (1 + 1e-9) / float(task.shortest_period):
        return [f"not proved: samples are nearer than control.period_min = {float(task.shortest_period):g} s"]
    analysis = Analysis(controller, plant, scenario.noise, scenario.latency, start)
    lines = [f"not shown: {h.statement}" for h in analysis.hypotheses() if not h.holds]
    low, high = analysis.windows.start.T
    places = np.abs((2 * np.array(start[: controller.task.dimension]) - low - high) / (high - low))
    if (places >= analysis.sampled_loop.law.e_max).any():
        i = int(np.argmax(places))
        told = f"the start has |e| = {float(places[i]):.4g} in {controller.task.axis_words[i]}, not below e_max"
        lines.append(f"{told}: sampled, nothing is proved from there")
    age, period = scenario.age, analysis.period
    if period is None:
        return [*lines, f"no sampling period is proved for gain {by_component(controller.task.gain)}, this plant and start"]
    now = prove_for_period("sharp", analysis.sampled_loop, age) or period
    e = f"|e| stays below {', '.join(f'{round_up(v):g}' for v in now.e)}"
    most, here = f"{1e3 * round_down(period.seconds):.4g} ms", f"{1e3 * age:.9g} ms"
    if 1 / scenario.rate < analysis.shortest:
        shortest = f"{1e3 * round_up(analysis.shortest):.4g} ms"
        return [*lines, f"not proved: alpha may not be stepped more often than every {shortest}"]
    if age <= period.seconds:
        return [*lines, f"proved from this start: {e}, with samples up to {here} old; the tube is kept up to {most}"]
    return [*lines, f"not proved: samples get {here} old here, up to {most} are proved from this start"]


def write_run(
    controller: EmittedController, run: Run, folder: Path, axes: Sequence[str] = (), clock: str = "stated"
) -> list[str]:
    """The trace and a picture of it; their paths."""
    from stt_codegen.loop.picture import draw_run
    from stt_codegen.report.pictures import plane_named

    assert run.trace is not None
    name = f"{controller.task.name}.loop"
    write_files(folder, {f"{name}.csv": csv(run.trace, controller.task, clock)})
    draw_run(controller, run, folder / f"{name}.png", [plane_named(controller.task, text) for text in axes])
    return [str(folder / f"{name}.csv"), str(folder / f"{name}.png")]
