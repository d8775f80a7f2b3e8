"""Robots of tasks/ with a plant file: the bounds of [plant] hold for the file all over the tube, and their loops stay in the tube."""

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
from tests.support.controllers import build_once

ROOT = Path(__file__).parents[2]
ROBOTS = ("arm", "attitude", "base", "drone", "rover")


@cache
def robot(name: str) -> tuple[EmittedController, Model]:
    """Return the controller of a robot's task, and the plant of its file."""
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    return build_once(task), plant_of(str(ROOT / "tasks" / f"{name}.py"), task.dimension, task.order)


@cache
def analysis(name: str) -> Analysis:
    return Analysis(*robot(name))


@pytest.mark.parametrize("name", ROBOTS)
def test_the_bounds_of_a_task_are_proved_for_its_plant_file(name: str) -> None:
    report = analysis(name).report()
    assert [h.name for h in report.hypotheses if not h.holds] == []
    assert "[plant]" in [h.name for h in report.hypotheses]


@pytest.mark.parametrize("name", ROBOTS)
def test_a_plant_with_a_stronger_disturbance_is_not_covered(name: str) -> None:
    controller, plant = robot(name)
    assert not Analysis(controller, with_disturbance_bound(plant, 10 * float(plant.w_max))).is_covered


@pytest.mark.parametrize("name", ROBOTS)
def test_bounds_hold_for_random_states_constants_and_samples(name: str) -> None:
    """States are in random windows, constants in their ranges, and samples as far away as they may be."""
    controller, plant = robot(name)
    analysed, n, order = analysis(name), controller.task.dimension, controller.task.order
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
    assert analysed.known_mixing_age == (
        math.inf if plant.mixing is None else pytest.approx(float(analysed.wanted_period + analysed.latency) * 1.01)
    )


@pytest.mark.parametrize("name", ["arm", "attitude", "base"])
def test_bounds_of_a_window_hold_for_the_oldest_sample(name: str) -> None:
    """x is in the window and v as fast as it may be; the sample of x is a period, the latency and the noise away."""
    controller, plant = robot(name)
    analysed, n, draw = analysis(name), controller.task.dimension, np.random.default_rng(7)
    design = controller.design
    assert isinstance(design, RefinedDesign)
    evaluate, (slow, fast) = model(plant, n, 2), velocity_bounds(design)
    age, largest_share = analysed.wanted_period + analysed.latency, 0.0
    for k in range(0, len(analysed.bounds), 3):
        for _ in range(60):
            x, v = draw.uniform(analysed.windows.low[k], analysed.windows.high[k]), draw.choice([-1, 1], size=n) * fast[k]
            assert (slow[k] == -fast[k]).all()
            sample = x - v * age + draw.choice([-1, 1], size=n) * analysed.noise
            g = np.array(evaluate(np.concatenate([x, v, [draw.choice(ends) for ends in plant.constants], sample]))[1])
            cross = np.abs(g - np.diag(np.diag(g)))
            assert (cross <= analysed.bounds[k].cross + 1e-15).all()
            assert (analysed.bounds[k].diagonal_min <= np.diag(g)).all()
            assert (np.diag(g) <= analysed.bounds[k].diagonal_max).all()
            largest_share = max(largest_share, float((cross / np.maximum(analysed.bounds[k].cross, 1e-300)).max()))
    assert largest_share > 0.5  # some sample comes near its bound, so that the test can fail


@pytest.mark.parametrize("name", ROBOTS)
def test_loops_keep_the_tube_with_any_constants_and_disturbance(name: str) -> None:
    """Loops run at the proved period from corners of the start share, with constants at the ends of their ranges (even seeds) and within."""
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


def test_u_is_mixed_with_the_state_of_its_sample() -> None:
    """x' = M(x of the sample) u with M = 1 + x: between samples x has the constant speed of the sample's M."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    controller = build_once(task)
    import casadi as ca

    mixing_plant = Plant(
        name="mixed",
        dimension=2,
        drift=lambda x: [0, 0],
        input_matrix=lambda x: [[1, 0], [0, 1]],
        mixing=lambda x: ca.diag(1 + x),
    )
    for latency in (0.0, 0.03):
        run = Loop(controller, mixing_plant).run(Scenario(rate=50.0, latency=latency), trace=True)
        assert run.trace is not None
        x, u = run.trace[:, 1:3], run.trace[:, 3:5]
        speed, delay = (1 + x) * u, 2 if latency else 0  # samples
        # A latency of 1.5 periods: half of a period has the input of one sample, half that of the next.
        delayed = 0.01 * speed[: -1 - delay] + 0.01 * speed[1 : len(speed) - delay]
        expected = delayed if latency else 0.02 * speed[:-1]
        assert np.allclose(np.diff(x, axis=0)[delay:], expected, atol=1e-12)


def test_constants_are_drawn_from_their_ranges_once_a_run() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    controller = build_once(task)
    drifting = Plant(
        name="p", dimension=2, drift=lambda x, p: [p[0], 0], input_matrix=lambda x, p: [[1, 0], [0, 1]], constants=((0.01, 0.03),)
    )
    drifts = []
    for seed in range(24):
        run = Loop(controller, drifting).run(Scenario(rate=50.0, seed=seed), trace=True)
        assert run.trace is not None
        x, u = run.trace[:, 1:3], run.trace[:, 3:5]
        drift = np.diff(x[:, 0]) / 0.02 - u[:-1, 0]
        assert np.allclose(drift, drift[0], atol=1e-10)
        drifts.append(drift[0])
    assert min(drifts) > 0.01 - 1e-9
    assert max(drifts) < 0.03 + 1e-9
    assert {round(v, 9) for v in drifts} >= {0.01, 0.03}


def test_the_true_rover_keeps_its_point_in_the_tube_and_its_disc_clear() -> None:
    """The emitted law drives the true kinematics with the heading, as rover.py describes. The point stays in the tube, the disc about
    the axle clear of unsafe sets, and the heading turns by no more than p while an input is held."""
    from stt_codegen.program.targets.python.runner import load_module

    controller, plant = robot("rover")
    task, (low, high) = controller.task, plant.constants[0]
    law = load_module(task.name, controller.files["rover.py"])
    ahead, radius = 0.25, 0.2  # metres from the axle to the point, and of the disc
    period, latency = float(task.sampling_period), float(task.control.latency)
    assert [float(v) for v in task.half_extents] == [ahead + radius] * 2
    plant_file = runpy.run_path(str(ROOT / "tasks" / "rover.py"))
    assert plant_file["U_MAX"] == float(max(task.u_max or ()))
    assert plant_file["AGE"] == pytest.approx(period + latency, abs=1e-15)
    draw = np.random.default_rng(2)
    for initial_heading in (0.0, 2.0, math.pi, -1.5):
        heading = initial_heading
        point = np.array([float(v) for v in task.initial_state])
        held_input = np.zeros(2)
        pending: np.ndarray | None = None
        steps = 11  # of 2 ms, in a period and its latency
        for k in range(round(float(task.prescribed_time) / period)):
            measured = point + draw.uniform(-1, 1, size=2) * float(task.plant.noise or 0)
            _, u = law.control(k * period, tuple(measured))
            c, s = math.cos(heading), math.sin(heading)
            speed_and_turn = np.array([c * u[0] + s * u[1], (-s * u[0] + c * u[1]) / ahead])
            sampled_heading = heading
            held_input, pending = (speed_and_turn, None) if k == 0 else (held_input, speed_and_turn)
            for step in range(steps - 1):
                if pending is not None and step * 0.002 >= latency - 1e-12:
                    held_input, pending = pending, None
                slip = 0.99 * float(plant.w_max) * np.array([math.cos(k), math.sin(k)])
                for _ in range(4):
                    h = 0.0005
                    middle = heading + h / 2 * held_input[1]
                    rate = np.array([math.cos(middle), math.sin(middle)]) * held_input[0]
                    rate += ahead * held_input[1] * np.array([-math.sin(middle), math.cos(middle)])
                    point, heading = point + h * (rate + slip), heading + h * held_input[1]
                assert low <= heading - sampled_heading <= high
            lower, upper = (np.array(v) for v in law.tube((k + 1) * period))
            assert (lower < point).all()
            assert (point < upper).all()
            axle = point - ahead * np.array([math.cos(heading), math.sin(heading)])
            for unsafe in task.unsafe:
                assert distance_to(unsafe, axle) > radius
        assert all(float(a) <= x <= float(b) for a, x, b in zip(task.target.lower, point, task.target.upper, strict=True))


def distance_to(unsafe: object, axle: np.ndarray) -> float:
    """Return the distance from the axle to the rock, which is a disc, or to the crater, which is a polygon."""
    centre = getattr(unsafe, "centre", None)
    if centre is not None:
        return float(np.hypot(*(axle - np.array([float(v) for v in centre])))) - float(unsafe.radius)  # type: ignore[attr-defined]
    corners = [np.array([float(v) for v in p]) for p in unsafe.vertices]  # type: ignore[attr-defined]
    distances = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        share = np.clip((axle - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        distances.append(float(np.hypot(*(axle - a - share * (b - a)))))
    return min(distances)


def test_equal_bounds_by_component_equal_one_bound_for_all() -> None:
    task = load_task(ROOT / "tasks" / "trolley.toml")
    bounds = {k: v for k, v in task.plant.bounds.items() if v is not None and k != "noise"}
    listed = task.changed(plant={k: [v] * task.dimension for k, v in bounds.items()})
    assert listed.plant_bounds == task.plant_bounds
    proved, proved_by_component = build_once(task).certificate.proved_period, build_once(listed).certificate.proved_period
    assert proved is not None
    assert proved == proved_by_component
    weaker = task.changed(plant={"g_min": [bounds.get("g_min", Fraction(1)), Fraction(1, 10)]})
    assert weaker.plant_bounds[1].g_min == Fraction(1, 10)


def test_a_mixing_plant_is_covered_only_with_the_latency_and_noise_of_its_task() -> None:
    """With less latency or noise than the task states, the hypothesis does not hold and its statement says so."""
    controller, plant = robot("base")
    assert next(h for h in Analysis(controller, plant).hypotheses() if h.name == "[plant]").holds
    for changes in ({"latency": 0.0}, {"noise": 0.0}):
        hypothesis = next(h for h in Analysis(controller, plant, **changes).hypotheses() if h.name == "[plant]")
        assert not hypothesis.holds
        assert "less noise or latency" in hypothesis.statement


def test_the_plants_at_the_bounds_disturb_every_component_by_its_own_bound() -> None:
    """The elbow has another bound than the shoulder."""
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
