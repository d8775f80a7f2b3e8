"""control.velocity = "differences": v from two measured x and the time between them, and proofs that include its error."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stt_codegen.checker import check_files
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.foretold import describe_proof
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import Loop, Scenario, random_start, scenario_of_task
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import build_once

ROOT = Path(__file__).parents[2]
BY_DIFFERENCES = {"velocity": "differences"}


def drone_task(noise: float = 0.0001, **control: Any) -> Task:
    drone = load_task(ROOT / "tasks" / "drone.toml")
    return drone.changed(control={**BY_DIFFERENCES, **control}, plant={"noise": noise, "noise_v": None})


@cache
def drone_controller(**control: Any) -> EmittedController:
    return build_once(drone_task(**control))


@pytest.mark.parametrize("period_min", [None, 0.005, 0.025])
def test_loops_keep_both_tubes_at_every_period_that_is_allowed(period_min: float | None) -> None:
    """Plants are at the bounds of [plant], starts at rest in corners of the start share, samples at the longest and the shortest period."""
    controller = drone_controller(period_min=period_min)
    loop_task, proved = controller.task, controller.certificate.proved_period
    assert proved is not None
    for plant in corner_plants(loop_task):
        loop = Loop(controller, plant)
        for seed, (period, wind) in enumerate(
            (p, w) for p in (loop_task.shortest_period, proved.period) for w in ("outward", "random")
        ):
            start = random_start(controller.certificate.start, 0.99 * float(proved.share), seed, corner=True)
            options = {**scenario_of_task(loop_task), "rate": 1 / float(period)}
            run = loop.run(Scenario(disturbance=wind, strength=float(plant.w_max), seed=seed, start=start, **options))
            assert run.good
            assert run.kept
            assert (np.array(run.e) < [float((r - 1) / (r + 1)) for r in proved.rho]).all()


def exact_shift(differences_task: Task, design: RefinedDesign) -> list[Fraction]:
    """Return by how much the law of P9 may measure wrong, for edges without rounding."""
    no_error = (Fraction(0),) * differences_task.dimension
    shift: list[Fraction] = exact_loop(differences_task, design, no_error, no_error).law.shift.tolist()
    return shift


def test_the_error_of_a_difference_is_within_the_claimed_bound() -> None:
    """Motions are random, with |v'| at its bound and x measured wrong by the noise. The error is between v and the v of the C."""
    controller = drone_controller()
    loop_task, design = controller.task, controller.design
    assert isinstance(design, RefinedDesign)
    module = load_module(loop_task.name, controller.files[f"{loop_task.name}.py"])
    bounds, limit = loop_task.plant_bounds, loop_task.u_max
    assert limit is not None
    measured = loop_task.changed(control={"velocity": None, "period_min": None})
    allowed = [float(a - b) for a, b in zip(exact_shift(loop_task, design), exact_shift(measured, design), strict=True)]
    largest_acceleration = [float(b.force + b.g_max * u) for b, u in zip(bounds, limit, strict=True)]
    draw, noise, largest_share = np.random.default_rng(1), float(loop_task.plant.noise or 0), 0.0
    for _ in range(2000):
        period = draw.choice([float(loop_task.shortest_period), float(loop_task.sampling_period)])
        acceleration = np.array(largest_acceleration) * draw.choice([-1, 1], size=loop_task.dimension)
        x, v = draw.uniform(-1, 1, size=loop_task.dimension), draw.uniform(-1, 1, size=loop_task.dimension)
        after = x + v * period + acceleration * period**2 / 2
        measured_points = [p + noise * draw.choice([-1, 1], size=loop_task.dimension) for p in (x, after)]
        velocity = np.array(module.velocity(period, measured_points[1], measured_points[0]))
        share = np.abs(velocity - (v + acceleration * period)) / allowed
        largest_share = max(largest_share, float(share.max()))
    assert 0.7 < largest_share <= 1


def test_a_time_that_is_not_positive_gives_no_velocity() -> None:
    module = load_module("drone", drone_controller().files["drone.py"])
    for dt in (0.0, -0.01, math.nan):
        v = module.velocity(dt, (1, 2, 3), (0, 0, 0))
        assert all(math.isnan(c) for c in v)
        status, u = module.control(0.0, (0.6, 0.6, 1.0), v)
        assert (status, u) == (module.BAD_INPUT, (0.0, 0.0, 0.0))
    assert module.velocity(0.5, (1, 2, 3), (0, 1, 5)) == (2.0, 2.0, -4.0)


def test_the_shift_in_doubles_is_at_least_the_exact_one() -> None:
    controller = drone_controller()
    loop_task, design = controller.task, controller.design
    assert isinstance(design, RefinedDesign)
    errors = edge_error(design, controller.program), rate_error(design, controller.program)
    exact, double = exact_loop(loop_task, design, *errors).law.shift, loop_of(loop_task, design, *errors)
    assert (double.law.shift >= [float(v) for v in exact]).all()
    assert (double.law.shift <= [1.02 * float(v) for v in exact]).all()  # for a period that is longer by a hundredth
    assert double.longest_age >= float(loop_task.sampling_period + loop_task.control.latency)


def test_the_shift_grows_with_noise_and_shorter_periods_until_a_refusal() -> None:
    design = drone_controller().design
    assert isinstance(design, RefinedDesign)
    shifts = [
        exact_shift(drone_task(noise, period_min=shortest), design)[0]
        for noise, shortest in ((0.0001, 0.025), (0.0001, 0.005), (0.001, 0.005))
    ]
    assert shifts == sorted(shifts)
    with pytest.raises(NotCertified, match="velocity by differences"):
        build_once(drone_task(0.01, period_min=0.001))


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"control": {"period": None, **BY_DIFFERENCES}}, "control.period"),
        ({"control": {"period_min": 0.03, **BY_DIFFERENCES}}, "control.period_min"),
        ({"control": {"period_min": 0.01}}, "control.period_min"),
        ({"control": BY_DIFFERENCES, "plant": {"noise_v": 0.1}}, "plant.noise_v"),
        ({"control": BY_DIFFERENCES, "plant": {"noise_v": None}, "initial_set": {"speed": 0.1}}, "initial_set.speed"),
        ({"control": {"velocity": "guessed"}}, "control.velocity"),
    ],
)
def test_a_field_that_differences_need_or_exclude_is_refused_by_name(changes: dict[str, Any], field: str) -> None:
    drone = load_task(ROOT / "tasks" / "drone.toml")
    changes = {"plant": {"noise_v": None}, **changes} if field != "plant.noise_v" else changes
    with pytest.raises(BadInput, match=field.replace(".", r"\.")):
        drone.changed(**changes)


def test_order_1_refuses_a_source_of_velocity() -> None:
    with pytest.raises(BadInput, match=r"control\.velocity"):
        load_task(ROOT / "tasks" / "omni_s2.toml").changed(control=BY_DIFFERENCES)


def test_the_checker_verifies_differences_and_refuses_changed_claims_and_code(tmp_path: Path, capsys: Any) -> None:
    text = (ROOT / "tasks" / "drone.toml").read_text()
    text = text.replace("noise_v = 0.02", "").replace("[control]\n", '[control]\nvelocity = "differences"\nperiod_min = 0.01\n')
    text = text.replace("noise = 0.005", "noise = 0.0001")
    (tmp_path / "task.toml").write_text(text)
    files = build_once(load_task(tmp_path / "task.toml")).files
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    arguments = [str(tmp_path / f) for f in ("task.toml", "drone.c", "drone.certificate.json")]
    assert check_files(arguments) == 0
    proof = json.loads(files["drone.certificate.json"])
    assert proof["sampled"]["period_min"] == "1/100"
    for claim in ({"period_min": "1/200"}, {"shift": [str(Fraction(v) * Fraction(9, 10)) for v in proof["sampled"]["shift"]]}):
        (tmp_path / "drone.certificate.json").write_text(json.dumps({**proof, "sampled": {**proof["sampled"], **claim}}))
        assert check_files(arguments) == 1
    capsys.readouterr()
    (tmp_path / "drone.certificate.json").write_bytes(files["drone.certificate.json"])
    (tmp_path / "drone.c").write_bytes(
        files["drone.c"].replace(b"const drone_real mean = moved / step;", b"const drone_real mean = moved * step;")
    )
    assert check_files(arguments) == 1


def description_of(**scenario: Any) -> str:
    loop_task = drone_controller().task
    return " ".join(describe_proof(drone_controller(), None, Scenario(**{**scenario_of_task(loop_task), **scenario})))


def test_runs_outside_the_assumptions_of_differences_are_not_described_as_proved() -> None:
    """These are a start with a speed, samples closer than period_min, and samples farther apart than the period, without or with delay."""
    loop_task = drone_controller().task
    start = tuple(float(v) for v in loop_task.initial_state)
    assert description_of().startswith("proved, period (P9)")
    assert "not proved" in description_of(start=(*start, 0.1, 0.0, 0.0))
    assert "not proved" in description_of(rate=1.01 / float(loop_task.shortest_period))
    assert "not proved" in description_of(rate=1 / (1.02 * float(loop_task.sampling_period)), latency=0.0)
    assert "not proved" in description_of(lost=1)
