"""Robots of tasks/ with a plant file: what [plant] says is true of the file all over the tube, and their loops stay in it."""

from __future__ import annotations

import math
import runpy
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.loop.command import Request, simulate, with_disturbance_bound
from stt_codegen.loop.simulate import Loop, Scenario, random_start, scenario_of_task
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model, Plant, model, plant_of
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling.order_two import velocity_bounds
from stt_codegen.sampling.plant import PlantEnclosure
from stt_codegen.task.load import load_task
from tests.support.controllers import built

ROOT = Path(__file__).parents[2]
ROBOTS = ("arm", "attitude", "base", "drone", "rover")


@cache
def robot(name: str) -> tuple[EmittedController, Model]:
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    return built(task), plant_of(str(ROOT / "tasks" / f"{name}.py"), task.dimension, task.order)


@cache
def analysis(name: str) -> Analysis:
    return Analysis(*robot(name))


@pytest.mark.parametrize("name", ROBOTS)
def test_what_the_task_says_of_its_plant_is_proved_of_the_file(name: str) -> None:
    report = analysis(name).report()
    assert [h.name for h in report.hypotheses if not h.holds] == []
    assert "[plant]" in [h.name for h in report.hypotheses]


@pytest.mark.parametrize("name", ROBOTS)
def test_a_plant_that_pushes_more_is_not_covered(name: str) -> None:
    controller, plant = robot(name)
    assert not Analysis(controller, with_disturbance_bound(plant, 10 * float(plant.w_max))).is_covered


@pytest.mark.parametrize("name", ROBOTS)
def test_bounds_hold_of_states_constants_and_samples(name: str) -> None:
    """At random states of random windows, random constants, and samples as far away as they may be."""
    controller, plant = robot(name)
    found, n, order = analysis(name), controller.task.dimension, controller.task.order
    evaluate, draw = model(plant, n, order), np.random.default_rng(5)
    enclosure = PlantEnclosure(plant, n, 1, order)
    for _ in range(4):
        low = draw.uniform(-0.5, 0.4, size=n * order)
        high = low + draw.uniform(0.01, 0.2, size=n * order)
        drift = draw.uniform(0, 0.02, size=n)
        bounds = enclosure.over(list(zip(low.tolist(), high.tolist(), strict=True)), drift.tolist())
        for _ in range(200):
            state = draw.uniform(low, high)
            constants = [draw.choice([a, b, draw.uniform(a, b)]) for a, b in plant.constants]
            sample = state[:n] + drift * draw.choice([-1, 1], size=n) if plant.mixing else []
            f, g = (np.array(v) for v in evaluate(np.concatenate([state, constants, sample])))
            assert (np.abs(f.ravel()) + float(plant.w_max) <= bounds.disturbance * (1 + 1e-12)).all()
            assert (bounds.diagonal_min <= np.diag(g)).all()
            assert (np.diag(g) <= bounds.diagonal_max).all()
            assert (np.abs(g - np.diag(np.diag(g))) <= bounds.cross + 1e-15).all()
    assert found.mixed_age == (math.inf if plant.mixing is None else pytest.approx(float(found.wanted + found.latency) * 1.01))


@pytest.mark.parametrize("name", ["arm", "attitude", "base"])
def test_bounds_of_a_window_hold_for_the_oldest_sample(name: str) -> None:
    """x in the window, v as fast as it may be, x of the sample a period, its latency and the noise away from it."""
    controller, plant = robot(name)
    found, n, draw = analysis(name), controller.task.dimension, np.random.default_rng(7)
    design = controller.design
    assert isinstance(design, RefinedDesign)
    evaluate, (slow, fast) = model(plant, n, 2), velocity_bounds(design)
    age, worst = found.wanted + found.latency, 0.0
    for k in range(0, len(found.bounds), 3):
        for _ in range(60):
            x, v = draw.uniform(found.windows.low[k], found.windows.high[k]), draw.choice([-1, 1], size=n) * fast[k]
            assert (slow[k] == -fast[k]).all()
            sample = x - v * age + draw.choice([-1, 1], size=n) * found.noise
            g = np.array(evaluate(np.concatenate([x, v, [draw.choice(ends) for ends in plant.constants], sample]))[1])
            aside = np.abs(g - np.diag(np.diag(g)))
            assert (aside <= found.bounds[k].cross + 1e-15).all()
            assert (found.bounds[k].diagonal_min <= np.diag(g)).all()
            assert (np.diag(g) <= found.bounds[k].diagonal_max).all()
            worst = max(worst, float((aside / np.maximum(found.bounds[k].cross, 1e-300)).max()))
    assert worst > 0.5  # a bound that no sample comes near says nothing of samples


@pytest.mark.parametrize("name", ROBOTS)
def test_loops_keep_the_tube_with_every_payload_and_wind(name: str) -> None:
    """At the proved period, from corners of the share, with constants at their ends (even seeds) and between."""
    controller, plant = robot(name)
    task, loop = controller.task, Loop(controller, plant)
    edges = controller.certificate.start
    for seed, wind in enumerate(("outward", "nearest", "constant", "random", "sinusoidal", "none")):
        start = random_start(edges, 0.99 * float(task.initial_set.share), seed, corner=True)
        run = loop.run(Scenario(disturbance=wind, strength=float(plant.w_max), seed=seed, start=start, **scenario_of_task(task)))
        assert run.good
        assert run.kept
        proved = controller.certificate.proved_period
        assert proved is not None
        assert (np.array(run.u) <= [float(v) for v in proved.u]).all()


def test_u_is_mixed_at_the_sample_and_held_with_it() -> None:
    """xdot = M(x of the sample) u with M = 1 + x: between samples x moves at a constant speed, that of the sample's M."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    controller = built(task)
    import casadi as ca

    own = Plant(
        name="mixed",
        dimension=2,
        drift=lambda x: [0, 0],
        input_matrix=lambda x: [[1, 0], [0, 1]],
        mixing=lambda x: ca.diag(1 + x),
    )
    for latency in (0.0, 0.03):
        run = Loop(controller, own).run(Scenario(rate=50.0, latency=latency), trace=True)
        assert run.trace is not None
        x, u = run.trace[:, 1:3], run.trace[:, 3:5]
        moved, behind = (1 + x) * u, 2 if latency else 0
        late = (
            0.01 * moved[: -1 - behind] + 0.01 * moved[1 : len(moved) - behind]
        )  # 1.5 periods: half of one is of the one before
        wanted = late if latency else 0.02 * moved[:-1]
        assert np.allclose(np.diff(x, axis=0)[behind:], wanted, atol=1e-12)


def test_constants_are_drawn_from_their_ranges_and_stay_for_a_run() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    controller = built(task)
    drifting = Plant(
        name="p", dimension=2, drift=lambda x, p: [p[0], 0], input_matrix=lambda x, p: [[1, 0], [0, 1]], constants=((0.01, 0.03),)
    )
    seen = []
    for seed in range(24):
        run = Loop(controller, drifting).run(Scenario(rate=50.0, seed=seed), trace=True)
        assert run.trace is not None
        x, u = run.trace[:, 1:3], run.trace[:, 3:5]
        drift = np.diff(x[:, 0]) / 0.02 - u[:-1, 0]
        assert np.allclose(drift, drift[0], atol=1e-10)
        seen.append(drift[0])
    assert min(seen) > 0.01 - 1e-9
    assert max(seen) < 0.03 + 1e-9
    assert {round(v, 9) for v in seen} >= {0.01, 0.03}


def test_the_rovers_point_is_kept_by_the_rover_itself() -> None:
    """The true kinematics, heading and all, driven by the emitted law as rover.py says: the point stays in the tube, the disc
    about the axle off every unsafe set, and the heading turns by no more than p between a sample and its end."""
    from stt_codegen.program.targets.python.runner import load_module

    controller, plant = robot("rover")
    task, (low, high) = controller.task, plant.constants[0]
    law = load_module(task.name, controller.files["rover.py"])
    ahead, radius, period, latency = 0.25, 0.2, float(task.sampling_period), float(task.control.latency)
    assert [float(v) for v in task.half_extents] == [ahead + radius] * 2
    said = runpy.run_path(str(ROOT / "tasks" / "rover.py"))
    assert said["U_MAX"] == float(max(task.u_max or ()))
    assert said["AGE"] == pytest.approx(period + latency, abs=1e-15)
    draw = np.random.default_rng(2)
    for first in (0.0, 2.0, math.pi, -1.5):
        heading = first
        point = np.array([float(v) for v in task.initial_state])
        held = np.zeros(2)
        pending: np.ndarray | None = None
        steps = 11  # of 2 ms in a period and its latency
        for k in range(round(float(task.prescribed_time) / period)):
            seen = point + draw.uniform(-1, 1, size=2) * float(task.plant.noise or 0)
            _, u = law.control(k * period, tuple(seen))
            c, s = math.cos(heading), math.sin(heading)
            made = np.array([c * u[0] + s * u[1], (-s * u[0] + c * u[1]) / ahead])
            sampled = heading
            held, pending = (made, None) if k == 0 else (held, made)
            for step in range(steps - 1):
                if pending is not None and step * 0.002 >= latency - 1e-12:
                    held, pending = pending, None
                slip = 0.99 * float(plant.w_max) * np.array([math.cos(k), math.sin(k)])
                for _ in range(4):
                    h = 0.0005
                    middle = heading + h / 2 * held[1]
                    rate = np.array([math.cos(middle), math.sin(middle)]) * held[0]
                    rate += ahead * held[1] * np.array([-math.sin(middle), math.cos(middle)])
                    point, heading = point + h * (rate + slip), heading + h * held[1]
                assert low <= heading - sampled <= high
            lower, upper = (np.array(v) for v in law.tube((k + 1) * period))
            assert (lower < point).all()
            assert (point < upper).all()
            axle = point - ahead * np.array([math.cos(heading), math.sin(heading)])
            for unsafe in task.unsafe:
                assert _distance(unsafe, axle) > radius
        assert all(float(a) <= x <= float(b) for a, x, b in zip(task.target.lower, point, task.target.upper, strict=True))


def _distance(unsafe: object, axle: np.ndarray) -> float:
    """To the rock by its centre, to the crater by its edges."""
    centre = getattr(unsafe, "centre", None)
    if centre is not None:
        return float(np.hypot(*(axle - np.array([float(v) for v in centre])))) - float(unsafe.radius)  # type: ignore[attr-defined]
    corners = [np.array([float(v) for v in p]) for p in unsafe.vertices]  # type: ignore[attr-defined]
    found = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        share = np.clip((axle - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        found.append(float(np.hypot(*(axle - a - share * (b - a)))))
    return min(found)


def test_bounds_by_component_say_what_one_number_says_where_they_agree() -> None:
    task = load_task(ROOT / "tasks" / "trolley.toml")
    given = {k: v for k, v in task.plant.bounds.items() if v is not None and k != "noise"}
    listed = task.changed(plant={k: [v] * task.dimension for k, v in given.items()})
    assert listed.plant_bounds == task.plant_bounds
    one, other = built(task).certificate.proved_period, built(listed).certificate.proved_period
    assert one is not None
    assert one == other
    weaker = task.changed(plant={"g_min": [given.get("g_min", Fraction(1)), Fraction(1, 10)]})
    assert weaker.plant_bounds[1].g_min == Fraction(1, 10)


def test_plant_covers_only_what_p9_is_about() -> None:
    """A plant that mixes is asked of with the task's own latency and noise, or the line says that it was not."""
    controller, plant = robot("base")
    assert next(h for h in Analysis(controller, plant).hypotheses() if h.name == "[plant]").holds
    for changes in ({"latency": 0.0}, {"noise": 0.0}):
        found = next(h for h in Analysis(controller, plant, **changes).hypotheses() if h.name == "[plant]")
        assert not found.holds
        assert "less noise or latency" in found.statement


def test_the_worst_plants_push_every_component_as_far_as_it_is_stated() -> None:
    """[plant] by component: the elbow is pushed by its own bound, not by the shoulder's."""
    controller, _ = robot("arm")
    report = simulate(controller, Request(plant="bounds"), None)
    forces = [float(b.force) for b in controller.task.plant_bounds]
    assert [report.scenario.strength * v for v in report.scenario.shares] == pytest.approx(forces)
    assert report.run.kept
    traced = Loop(controller, plant_of("integrator", 2, 2)).run(
        replace(report.scenario, disturbance="constant", seed=3), trace=True
    )
    assert traced.trace is not None
    w = np.abs(traced.trace[:, 9:11])
    assert (w <= np.array(forces) + 1e-12).all()
    assert w[:, 1].max() > forces[0]
