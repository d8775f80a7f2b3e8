"""control.velocity = "differences": v of two measured x and the time between them, and what is proved with its error."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stt_codegen.certify import checker
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import describe_proof
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import Loop, Scenario, random_start, scenario_of_task
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import built

ROOT = Path(__file__).parents[2]
OWN = {"velocity": "differences"}


def task(noise: float = 0.0001, **control: Any) -> Task:
    drone = load_task(ROOT / "tasks" / "drone.toml")
    return drone.changed(control={**OWN, **control}, plant={"noise": noise, "noise_v": None})


@cache
def made(**control: Any) -> EmittedController:
    return built(task(**control))


@pytest.mark.parametrize("period_min", [None, 0.005, 0.025])
def test_loops_keep_both_tubes_at_every_period_that_is_allowed(period_min: float | None) -> None:
    """Worst plants of [plant], from corners of the share at rest, sampled at the longest and the shortest period."""
    controller = made(period_min=period_min)
    own, proved = controller.task, controller.certificate.proved_period
    assert proved is not None
    for plant in corner_plants(own):
        loop = Loop(controller, plant)
        for seed, (period, wind) in enumerate(
            (p, w) for p in (own.shortest_period, proved.period) for w in ("outward", "random")
        ):
            at = random_start(controller.certificate.start, 0.99 * float(proved.share), seed, corner=True)
            told = {**scenario_of_task(own), "rate": 1 / float(period)}
            run = loop.run(Scenario(disturbance=wind, strength=float(plant.w_max), seed=seed, start=at, **told))
            assert run.good
            assert run.kept
            assert (np.array(run.e) < [float((r - 1) / (r + 1)) for r in proved.rho]).all()


def exact_shift(given: Task, design: RefinedDesign) -> list[Fraction]:
    """What P9's law sees wrong where the arithmetic moves no edge."""
    none = (Fraction(0),) * given.dimension
    shift: list[Fraction] = exact_loop(given, design, none, none).law.shift.tolist()
    return shift


def test_a_difference_is_wrong_by_no_more_than_is_claimed() -> None:
    """Random motions with |vdot| at its bound now and then, x measured wrong by the noise: |v - what the C computes|."""
    controller = made()
    own, design = controller.task, controller.design
    assert isinstance(design, RefinedDesign)
    module = load_module(own.name, controller.files[f"{own.name}.py"])
    bounds, limit = own.plant_bounds, own.u_max
    assert limit is not None
    measured = own.changed(control={"velocity": None, "period_min": None})
    allowed = [float(a - b) for a, b in zip(exact_shift(own, design), exact_shift(measured, design), strict=True)]
    most = [float(b.force + b.g_max * u) for b, u in zip(bounds, limit, strict=True)]
    draw, noise, worst = np.random.default_rng(1), float(own.plant.noise or 0), 0.0
    for _ in range(2000):
        period = draw.choice([float(own.shortest_period), float(own.sampling_period)])
        turn = np.array(most) * draw.choice([-1, 1], size=own.dimension)
        x, v = draw.uniform(-1, 1, size=own.dimension), draw.uniform(-1, 1, size=own.dimension)
        after = x + v * period + turn * period**2 / 2
        seen = [p + noise * draw.choice([-1, 1], size=own.dimension) for p in (x, after)]
        found = np.array(module.velocity(period, seen[1], seen[0]))
        share = np.abs(found - (v + turn * period)) / allowed
        worst = max(worst, float(share.max()))
    assert 0.7 < worst <= 1


def test_what_is_no_time_between_samples_gives_no_velocity() -> None:
    module = load_module("drone", made().files["drone.py"])
    for dt in (0.0, -0.01, math.nan):
        v = module.velocity(dt, (1, 2, 3), (0, 0, 0))
        assert all(math.isnan(c) for c in v)
        status, u = module.control(0.0, (0.6, 0.6, 1.0), v)
        assert (status, u) == (module.BAD_INPUT, (0.0, 0.0, 0.0))
    assert module.velocity(0.5, (1, 2, 3), (0, 1, 5)) == (2.0, 2.0, -4.0)


def test_the_doubles_allow_for_no_less_than_the_fractions() -> None:
    controller = made()
    own, design = controller.task, controller.design
    assert isinstance(design, RefinedDesign)
    errors = edge_error(design, controller.program), rate_error(design, controller.program)
    exact, double = exact_loop(own, design, *errors).law.shift, loop_of(own, design, *errors)
    assert (double.law.shift >= [float(v) for v in exact]).all()
    assert (double.law.shift <= [1.02 * float(v) for v in exact]).all()  # by a hundredth of the period more
    assert double.longest_age >= float(own.sampling_period + own.control.latency)


def test_more_noise_and_shorter_periods_cost_and_are_refused_in_the_end() -> None:
    design = made().design
    assert isinstance(design, RefinedDesign)
    shifts = [
        exact_shift(task(noise, period_min=shortest), design)[0]
        for noise, shortest in ((0.0001, 0.025), (0.0001, 0.005), (0.001, 0.005))
    ]
    assert shifts == sorted(shifts)
    with pytest.raises(NotCertified, match="velocity by differences"):
        built(task(0.01, period_min=0.001))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"control": {"u_max": None, **OWN}}, "control.u_max"),
        ({"control": {"period": None, **OWN}}, "control.period"),
        ({"control": {"period_min": 0.03, **OWN}}, "control.period_min"),
        ({"control": {"period_min": 0.01}}, "control.period_min"),
        ({"control": OWN, "plant": {"noise_v": 0.1}}, "plant.noise_v"),
        ({"control": OWN, "plant": {"noise_v": None}, "initial_set": {"speed": 0.1}}, "initial_set.speed"),
        ({"control": {"velocity": "guessed"}}, "control.velocity"),
    ],
)
def test_what_a_difference_needs_is_asked_for(changes: dict[str, Any], told: str) -> None:
    drone = load_task(ROOT / "tasks" / "drone.toml")
    changes = {"plant": {"noise_v": None}, **changes} if told != "plant.noise_v" else changes
    with pytest.raises(BadInput, match=told.replace(".", r"\.")):
        drone.changed(**changes)


def test_order_1_has_no_velocity() -> None:
    with pytest.raises(BadInput, match=r"control\.velocity"):
        load_task(ROOT / "tasks" / "omni_s2.toml").changed(control=OWN)


def test_the_checker_proves_it_and_finds_another_shortest_period(tmp_path: Path, capsys: Any) -> None:
    text = (ROOT / "tasks" / "drone.toml").read_text()
    text = text.replace("noise_v = 0.02", "").replace("[control]\n", '[control]\nvelocity = "differences"\nperiod_min = 0.01\n')
    text = text.replace("noise = 0.005", "noise = 0.0001")
    (tmp_path / "task.toml").write_text(text)
    files = built(load_task(tmp_path / "task.toml")).files
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    arguments = [str(tmp_path / f) for f in ("task.toml", "drone.c", "drone.certificate.json")]
    assert checker.main(arguments) == 0
    proof = json.loads(files["drone.certificate.json"])
    assert proof["sampled"]["period_min"] == "1/100"
    for claim in ({"period_min": "1/200"}, {"shift": [str(Fraction(v) * Fraction(9, 10)) for v in proof["sampled"]["shift"]]}):
        (tmp_path / "drone.certificate.json").write_text(json.dumps({**proof, "sampled": {**proof["sampled"], **claim}}))
        assert checker.main(arguments) == 1
    capsys.readouterr()
    (tmp_path / "drone.certificate.json").write_bytes(files["drone.certificate.json"])
    (tmp_path / "drone.c").write_bytes(
        files["drone.c"].replace(b"const drone_real mean = moved / step;", b"const drone_real mean = moved * step;")
    )
    assert checker.main(arguments) == 1


def foretold_of(**scenario: Any) -> str:
    own = made().task
    return " ".join(describe_proof(made(), None, Scenario(**{**scenario_of_task(own), **scenario})))


def test_nothing_is_foretold_of_what_a_difference_does_not_know() -> None:
    """A start with a speed, samples nearer than period_min, and samples farther apart than the period, however late u acts."""
    own = made().task
    start = tuple(float(v) for v in own.initial_state)
    assert "proved from this start" in foretold_of()
    assert "not proved" in foretold_of(start=(*start, 0.1, 0.0, 0.0))
    assert "not proved" in foretold_of(rate=1.01 / float(own.shortest_period))
    assert "not proved" in foretold_of(rate=1 / (1.02 * float(own.sampling_period)), latency=0.0)
    assert "not proved" in foretold_of(lost=1)
