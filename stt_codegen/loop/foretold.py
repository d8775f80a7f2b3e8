"""What is proved of a closed loop before it is run, in lines.

A run is proved by P9 of the certificate where its inputs act late as the task states, and otherwise by the sampling conditions,
for its start, its rate and its plant.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from stt_codegen.arrays import entries_of
from stt_codegen.certify import PeriodProof
from stt_codegen.decimals import by_component, decimal
from stt_codegen.loop.simulate import Scenario
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.properties import Property
from stt_codegen.report import Analysis, round_down, round_up
from stt_codegen.sampling import prove_for_period, start_bound_of_task
from stt_codegen.task import DriveBounds, Task

OF_LATE_LOOPS = ("tube", "start", "Assumption 2", "[plant]")  # hypotheses that P9 needs by the worst path
RATE_ROUNDING = 1e-9  # relative, of a rate or a bound in decimals


def describe_proof(controller: EmittedController, plant: Model | None, scenario: Scenario) -> list[str]:
    """Return what `prove TASK` says of this loop before it is run; plant None: the bounds of [plant].

    The last line says whether the loop is proved; a line before it names what the proof does not cover.
    """
    task = controller.task
    start = [float(v) for v in (task.initial_state if scenario.start is None else scenario.start)]
    problem = _problem_outside_theory(controller, scenario, start)
    if problem is not None:
        return [problem]
    analysis = Analysis(controller, plant, scenario.noise, scenario.latency, start)
    proof = controller.certificate.proved_period
    is_late = scenario.has_drives or (proof is not None and len(proof.paths) > 0)
    hypotheses = [h for h in analysis.hypotheses() if not is_late or h.name in OF_LATE_LOOPS]
    lines = [f"not shown: {h.statement}" for h in hypotheses if not h.holds]
    low, high = analysis.windows.start.T
    errors = np.abs((2 * np.array(start[: task.dimension]) - low - high) / (high - low))
    if (errors >= analysis.sampled_loop.law.e_max).any():
        i = int(np.argmax(errors))
        position = f"the start has |e| = {float(errors[i]):.4g} in {task.axis_words[i]}, not below e_max"
        lines.append(f"{position}: sampled, nothing is proved from there")
    if not is_late:
        return [*lines, _period_line(analysis, scenario)]
    if lines:
        return [*lines, f"not proved: {Property.PERIOD.label} needs what is not shown above"]
    return [_late_line(analysis, proof, scenario, start)]


def _problem_outside_theory(controller: EmittedController, scenario: Scenario, start: Sequence[float]) -> str | None:
    """Return why no sampling condition is about this loop at all; None where one may be."""
    task = controller.task
    if not controller.certificate.tube_holds:
        return "the tube is not certified: nothing is proved"
    if scenario.has_drives and not task.has_drive:
        drive = written_drive(scenario.drives)
        return f"not proved: u acts through a drive with {drive}, and the task states none; put it into [plant]"
    if task.uses_differences and any(start[task.dimension :]):
        return "not proved: a velocity by differences is 0 at the first sample, so starts are at rest"
    if task.uses_differences and scenario.rate > (1 + RATE_ROUNDING) / float(task.shortest_period):
        return f"not proved: samples are nearer than control.period_min = {float(task.shortest_period):g} s"
    return None


def _period_line(analysis: Analysis, scenario: Scenario) -> str:
    """Return whether the proved period covers the age that samples get in this scenario."""
    age, period = scenario.age, analysis.period
    if period is None:
        gain = by_component(analysis.controller.task.gain)
        return f"no sampling period is proved for gain {gain}, this plant and start"
    at_this_age = prove_for_period("sharp", analysis.sampled_loop, age) or period
    error_bounds = f"|e| stays below {', '.join(f'{round_up(v):g}' for v in at_this_age.e)}"
    proved_age, scenario_age = f"{1e3 * round_down(period.seconds):.4g} ms", f"{1e3 * age:.9g} ms"
    if 1 / scenario.rate < analysis.shortest:
        shortest = f"{1e3 * round_up(analysis.shortest):.4g} ms"
        return f"not proved: alpha may not be stepped more often than every {shortest}"
    if age <= period.seconds:
        return (
            f"proved from this start: {error_bounds}, with samples up to {scenario_age} old; the tube is kept up to {proved_age}"
        )
    return f"not proved: samples get {scenario_age} old here, up to {proved_age} are proved from this start"


def _late_line(analysis: Analysis, proof: PeriodProof | None, scenario: Scenario, start: Sequence[float]) -> str:
    """Return whether P9, by the worst path, is about this run."""
    if proof is None:
        return f"not proved: {Property.PERIOD.label} does not hold for this gain"
    problem = next(_beyond_period_proof(analysis, scenario, start), None)
    if problem is not None:
        return f"not proved: {problem}"
    errors = ", ".join(f"{round_up(float((v - 1) / (v + 1))):g}" for v in proof.rho)
    drive = f", with {written_drive(scenario.drives)}" if scenario.has_drives else ""
    return f"proved, {Property.PERIOD.label}: |e| stays below {errors}{drive}"


def _beyond_period_proof(analysis: Analysis, scenario: Scenario, start: Sequence[float]) -> Iterator[str]:
    """Yield where a run goes beyond what P9 is about, beside the bounds of its plant."""
    task = analysis.controller.task
    for i, (run, stated) in enumerate(zip(scenario.drives, task.drive_bounds, strict=False)):
        if not _is_within(run, stated):
            axis = f" of {task.axis_words[i]}" if task.dimension > 1 else ""
            yield f"the drive{axis} has {written_drive([run])}, and [plant] states {written_drive([stated])}"
    between = (scenario.lost + 1) / scenario.rate
    if between > float(task.sampling_period) * (1 + RATE_ROUNDING):
        yield f"inputs are {between:g} s apart, and control.period is {decimal(task.sampling_period)}"
    if scenario.latency > float(task.control.latency):
        yield f"u acts {scenario.latency:g} s after its sample, and control.latency is {decimal(task.control.latency)}"
    for key, letter, noise, limits in (
        ("noise", "x", scenario.noise, task.noise),
        ("noise_v", "v", scenario.noise_v, task.noise_v),
    ):
        errors = entries_of(key, noise, task.dimension)
        if any(v > float(limit) for v, limit in zip(errors, limits, strict=True)):
            yield f"{letter} is measured to {by_component(errors)}, and plant.{key} is {by_component(limits)}"
    if analysis.plant is None:
        yield from _beyond_disturbance(task, scenario)
    every_start, this_start = (start_bound_of_task(task, analysis.controller.design, analysis.windows, s) for s in (None, start))
    if (this_start > every_start * (1 + RATE_ROUNDING)).any():
        yield f"the start is outside initial_set.share = {decimal(task.initial_set.share)}"


def _beyond_disturbance(task: Task, scenario: Scenario) -> Iterator[str]:
    """Yield the components in which a run without a plant's equations is pushed by more than [plant] states."""
    for i, share in enumerate(scenario.shares or (1.0,) * task.dimension):
        force = task.plant_bounds[i].force
        if scenario.strength * share > float(force) * (1 + RATE_ROUNDING):
            yield f"{task.axis_words[i]} is pushed by {scenario.strength * share:g}, and f_max + w_max is {decimal(force)}"


def _is_within(run: DriveBounds, stated: DriveBounds) -> bool:
    """Return whether a drive is one of those that the bounds allow."""
    follows_quickly = run.slew is None or (stated.slew is not None and run.slew >= stated.slew)
    return follows_quickly and run.lag <= stated.lag and run.lag2 <= stated.lag2 and run.overshoot <= stated.overshoot


def written_drive(drives: Sequence[DriveBounds]) -> str:
    """Write drives in words: a lag of 0.08 s, slew 3 a second."""
    parts = [
        ("a lag of {} s", [b.lag for b in drives]),
        ("a second lag of {} s", [b.lag2 for b in drives]),
        ("a slew of {} a second", [b.slew or Fraction(0) for b in drives]),
        ("an overshoot of {}", [b.overshoot for b in drives]),
    ]
    return " and ".join(text.format(by_component(values)) for text, values in parts if any(values)) or "no lag"


def drives_of(lag: float, task: Task) -> tuple[DriveBounds, ...]:
    """Return drives with one first-order lag, in seconds, in all components; 0: none."""
    return (DriveBounds(Fraction(f"{lag:.12g}"), Fraction(0), None, Fraction(0)),) * task.dimension
