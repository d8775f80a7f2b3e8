"""Drives in the closed loop follow u as their bounds say, adverse ones keep what P9 proves, and a slower one leaves the tube."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.linalg import expm

from stt_codegen.loop.command import Request, simulate
from stt_codegen.loop.foretold import describe_proof, drives_of
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import Loop, Run, Scenario, random_start, scenario_of_task
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import PLANTS
from stt_codegen.task.schema import DriveBounds
from stt_codegen.task.task import Task
from tests.certify.test_late_inputs import task_of
from tests.support.controllers import build_once

Array = npt.NDArray[np.float64]
ZERO = Fraction(0)


@cache
def loops(name: str) -> tuple[EmittedController, list[Loop]]:
    """Return a task's controller, and its loops with the plants at the corners of [plant]."""
    controller = build_once(task_of(name))
    return controller, [Loop(controller, plant) for plant in corner_plants(controller.task)]


def slower(task: Task, factor: Fraction) -> tuple[DriveBounds, ...]:
    """Return the task's drives, slower by a factor."""
    return tuple(
        replace(b, lag=b.lag * factor, lag2=b.lag2 * factor, slew=None if b.slew is None else b.slew / factor)
        for b in task.drive_bounds
    )


def adverse(task: Task, kind: str, **changes: Any) -> Scenario:
    """Return the scenario of --plant bounds, pushed in this way."""
    forces = [float(b.force) for b in task.plant_bounds]
    shares = tuple(v / max(forces) for v in forces)
    conditions = {**scenario_of_task(task), "strength": max(forces), "shares": shares, **changes}
    return Scenario(disturbance=kind, is_adverse=True, **conditions)


def attacked(name: str, factor: Fraction, seeds: range) -> list[Run]:
    """Run every corner of a task's [plant] from corners of its starts, with drives that are slower by a factor."""
    controller, corners = loops(name)
    task, share = controller.task, 0.999 * float(controller.task.initial_set.share)
    return [
        loop.run(adverse(task, kind, drives=slower(task, factor), seed=seed, start=start))
        for loop in corners
        for kind in ("outward", "motion")
        for seed in seeds
        for start in [random_start(controller.certificate.start, share, seed, corner=True)]
    ]


@pytest.mark.parametrize("name", ["cart", "two lags, slew and overshoot", "latency", "order 2", "integers"])
def test_adverse_drives_keep_what_is_proved(name: str) -> None:
    controller, _ = loops(name)
    proof = controller.certificate.proved_period
    assert proof is not None
    for run in attacked(name, Fraction(1), range(2)):
        assert run.good
        assert run.kept
        if controller.task.order == 1:
            assert all(e < (rho - 1) / (rho + 1) for e, rho in zip(run.e, proof.rho, strict=True))
        assert all(u <= bound for u, bound in zip(run.u, proof.u, strict=True))


@pytest.mark.parametrize(("name", "factor"), [("cart", 4), ("two lags, slew and overshoot", 2), ("latency", 4)])
def test_a_drive_that_is_slower_by_a_factor_leaves_the_tube(name: str, factor: int) -> None:
    assert not all(run.kept for run in attacked(name, Fraction(factor), range(1)))


def answer(bounds: DriveBounds, commands: Array, h: float) -> Array:
    """Return the integral over each sample of what a drive of the integrator makes of held commands; by formulas."""
    if bounds.slew is not None:
        ramp, moved = 0.0, []
        for u in commands:
            duration = min(abs(u - ramp) / float(bounds.slew), h)
            end = ramp + math.copysign(duration * float(bounds.slew), u - ramp)
            moved.append((ramp + end) / 2 * duration + end * (h - duration))
            ramp = end
        return np.array(moved)
    rates = [1 / float(lag) for lag in (bounds.lag, bounds.lag2) if lag]
    matrix = np.zeros((len(rates) + 2, len(rates) + 2))  # u, stages, x
    for k, rate in enumerate(rates, 1):
        matrix[k, k - 1], matrix[k, k] = rate, -rate
    matrix[-1, -2] = 1
    step, state, moved = expm(matrix * h), np.zeros(len(rates) + 2), []
    for u in commands:
        state[0], state[-1] = u, 0.0
        state = step @ state
        moved.append(state[-1])
    return np.array(moved)


@pytest.mark.parametrize(
    "bounds",
    [
        DriveBounds(Fraction(1, 20), ZERO, None, ZERO),
        DriveBounds(Fraction(1, 20), Fraction(1, 50), None, ZERO),
        DriveBounds(ZERO, Fraction(1, 50), None, ZERO),
        DriveBounds(ZERO, ZERO, Fraction(3), ZERO),
    ],
)
def test_a_drive_follows_held_commands_as_its_formula_says(bounds: DriveBounds) -> None:
    controller = build_once(task_of("cart"))
    run = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=50.0, drives=(bounds,) * 2), trace=True)
    assert run.trace is not None
    x, u = run.trace[:, 1:3], run.trace[:-1, 3:5]
    assert np.abs(u).max() > 0.3
    for i in range(2):
        assert np.abs(np.diff(x[:, i]) - answer(bounds, u[:, i], 0.02)).max() < 1e-7


def test_an_adverse_drives_first_input_is_late_too() -> None:
    controller, (loop, *_) = loops("latency")
    scenario = replace(adverse(controller.task, "none", latency=0.05), strength=0.0)
    late, prompt = (loop.run(s, trace=True) for s in (scenario, replace(scenario, is_adverse=False)))
    for run, is_late in ((late, True), (prompt, False)):
        assert run.trace is not None
        assert (np.abs(run.trace[1:3, 1:3] - run.trace[0, 1:3]).max() == 0) == is_late


def test_simulate_takes_the_tasks_drive_and_lag_replaces_it() -> None:
    controller = build_once(task_of("two lags, slew and overshoot"))
    report = simulate(controller, Request(), None)
    assert report.scenario.drives == controller.task.drive_bounds
    (line,) = report.proof_lines
    assert line.startswith("proved, period (P9): |e| stays below 0.9")
    document = report.document()["drives"]
    assert document[0] == {"lag": 0.05, "lag2": 0.01, "slew": 40.0, "overshoot": 0.05}
    replaced = simulate(controller, Request(lag=0.02), None)
    assert replaced.scenario.drives == (DriveBounds(Fraction(1, 50), ZERO, None, ZERO),) * 2
    assert not simulate(controller, Request(lag=0.0), None).scenario.has_drives


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"drives": (DriveBounds(Fraction(9, 100), ZERO, None, ZERO),) * 2}, "the drive of dimension 1 has a lag of 0.09 s, and"),
        ({"rate": 40.0}, "inputs are 0.025 s apart, and control.period is 0.02"),
        ({"lost": 1}, "inputs are 0.04 s apart"),
        ({"latency": 0.001}, "u acts 0.001 s after its sample, and control.latency is 0"),
        ({"start": (1.26, 1.2)}, "the start is outside initial_set.share = 0.8"),
        ({"noise": 0.05}, "x is measured to 0.05, and plant.noise is 0.003"),
        ({"strength": 0.2}, "dimension 1 is pushed by 0.2, and f_max + w_max is 0.1"),
    ],
)
def test_a_run_beyond_the_proof_is_foretold_as_not_proved(changes: dict[str, Any], problem: str) -> None:
    controller = build_once(task_of("cart"))
    *_, line = describe_proof(controller, None, adverse(controller.task, "outward", **changes))
    assert line.startswith(f"not proved: {problem}")


def test_the_lag_that_the_task_states_is_within_the_proof_as_an_option_too() -> None:
    controller = build_once(task_of("cart"))
    for lag, verdict in ((0.08, "proved, period (P9)"), (0.0, "proved, period (P9)"), (0.0801, "not proved: the drive")):
        scenario = adverse(controller.task, "outward", drives=drives_of(lag, controller.task))
        assert describe_proof(controller, None, scenario)[-1].startswith(verdict)


def test_a_drive_that_the_task_does_not_state_is_foretold_as_not_proved() -> None:
    task = task_of("cart").changed(plant={"lag": None})
    (line,) = simulate(build_once(task), Request(lag=0.01), None).proof_lines
    assert line == "not proved: u acts through a drive with a lag of 0.01 s, and the task states none; put it into [plant]"


@pytest.mark.parametrize("lag", [0.16, 0.2, 0.25])
def test_a_velocity_loop_that_is_driven_by_its_velocity_is_a_plant_of_order_two(lag: float) -> None:
    """docs/drive.md: u_cmd = v + T u makes v' = (T/lag) u, but for the error and the age of the v in u_cmd."""
    draw, step, nominal, age, error = np.random.default_rng(1), 1e-4, 0.2, 0.005, 0.01
    v, largest, difference = [0.0], 0.0, 0.0
    for k in range(20_000):
        if k % 200 == 0:
            u = draw.uniform(-0.7, 0.7)
        if k % round(age / step) == 0:
            measured = v[-1] + draw.uniform(-error, error)
        acceleration = (measured + nominal * u - v[-1]) / lag
        largest = max(largest, abs(acceleration))
        difference = max(difference, abs(acceleration - nominal / lag * u))
        v.append(v[-1] + step * acceleration)
    bound = (error + largest * age) / lag
    assert 0.5 * bound < difference <= bound
