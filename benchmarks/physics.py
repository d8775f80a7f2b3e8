"""Run the emitted C in a physics engine: MuJoCo moves the robots and finds the contacts.

    python -m benchmarks physics [--runs 1000] [--record FILE.md]
    python -m benchmarks physics --picture PNG

The robots are the base (tasks/base.toml) and the arm (tasks/arm.toml) of benchmarks/bodies.py, with mass, inertia, friction and
limited forces. Each run draws the plant file's constants and a start in the start share. It has the sampling period, the input
delay and the noise that are proved. A disturbance of size w_max acts in drawn directions for drawn times or, in every second run,
towards the tube's nearer edges. Shelves, walls and the post are geoms, and MuJoCo decides what is a contact.

The same model measures the plant bounds: f, g and g_cross from accelerations at states of the tube. A fifth as many runs have
motors that follow their command with a lag of MOTOR_LAG, which the proof does not cover.

The exit code is 1 after a contact, a sample outside the tube or a missed target, unless the motors lag. It is also 1 where a
measured bound exceeds [plant], or a configuration outside the unsafe sets touches a geom.
"""

from __future__ import annotations

import argparse
import ctypes
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import mujoco
import numpy as np
import numpy.typing as npt

from benchmarks.bodies import ROBOTS, STEP
from benchmarks.suites.report import command, machine, record, table
from stt_codegen.loop.compiled import load_controller
from stt_codegen.pipeline import build_task
from stt_codegen.plants import plant_of
from stt_codegen.task.load import load_task

ROOT = Path(__file__).resolve().parent.parent
MOTOR_LAG = 0.01  # seconds; the motors are of first order
MEASURED_STATES = 20_000  # at which the plant's bounds are measured
Array = npt.NDArray[Any]


@dataclass(frozen=True)
class SimulatedRun:
    """The result of one mission in the engine.

    contact_steps: steps of the engine with a contact. outside_samples: samples whose status was not "inside". margin: the
    smallest distance of the true state from the nearer edge over the tube's width, of x and of z = v + lambda x, after the first
    quarter of t_c. largest_input: the largest |u_i|, (n,).
    """

    contact_steps: int
    outside_samples: int
    has_arrived: bool
    margin: float
    largest_input: Array

    @property
    def is_successful(self) -> bool:
        return self.has_arrived and self.contact_steps + self.outside_samples == 0


@dataclass(frozen=True)
class MeasuredBounds:
    """What the engine's accelerations are, beside the bounds of [plant].

    By component, (n,): the largest |f_i|, the smallest and largest g_ii, the largest |g_ij|. stated: the same numbers of [plant].
    checked_count: configurations outside the unsafe sets; touching_count: those of them that touch a geom.
    """

    f: Array
    g_min: Array
    g_max: Array
    g_cross: Array
    stated: dict[str, Array]
    touching_count: int
    checked_count: int

    @property
    def are_within_stated(self) -> bool:
        s = self.stated
        are_below = all((getattr(self, name) <= s[name]).all() for name in ("f", "g_max", "g_cross"))
        return are_below and bool((self.g_min >= s["g_min"]).all()) and self.touching_count == 0


class RobotSimulation:
    """One robot, its engine and its controller. lag: seconds, of the motors."""

    def __init__(self, name: str, lag: float = 0.0) -> None:
        self.controller = build_task(load_task(ROOT / "tasks" / f"{name}.toml"))
        assert self.controller.certificate.holds
        self.task, self.robot = self.controller.task, ROBOTS[name]
        self.emitted_code, n = load_controller(self.controller), self.task.dimension
        self.filter = np.array([float(v) for v in self.controller.design.filter])  # lambda, 1/s
        self.plant = plant_of(str(ROOT / "tasks" / f"{name}.py"), n, 2)
        x = ca.SX.sym("x", n)
        assert self.plant.mixing is not None
        self.mixing = ca.Function("mix", [x], [ca.densify(self.plant.mixing(x))])
        self.model = mujoco.MjModel.from_xml_string(self.robot.mjcf(self.task, self.largest_forces(), lag))
        self.data = mujoco.MjData(self.model)
        proof = self.controller.certificate.proved_period
        assert proof is not None
        self.steps_per_sample = engine_steps(proof.period)
        self.latency_steps = engine_steps(proof.latency)
        self.mission_steps = engine_steps(self.task.prescribed_time)

    def largest_forces(self) -> list[float]:
        """Return bounds on the engine's inputs, (n,): |mixing| u_max over a grid of the state space, and 5 % more."""
        lower, upper = self.task.state_space.lower, self.task.state_space.upper
        axes = [np.linspace(float(a), float(b), 9) for a, b in zip(lower, upper, strict=True)]
        u_max = [float(v) for v in self.task.u_max or ()]
        forces = [np.abs(self.mixing(list(x)).full()) @ u_max for x in np.stack(np.meshgrid(*axes), -1).reshape(-1, len(axes))]
        return [1.05 * float(v) for v in np.max(forces, axis=0)]

    def tube_edges(self, t: float) -> Array:
        """Return the edges that the emitted code computes at t, (2, 2, n): lower and upper, of x, then of z = v + lambda x."""
        n = self.task.dimension
        lower, upper = (ctypes.c_double * (2 * n))(), (ctypes.c_double * (2 * n))()
        self.emitted_code.tube(ctypes.c_double(t), lower, upper)
        return np.array([lower[:], upper[:]]).reshape(2, 2, n).swapaxes(0, 1)

    def draw_constants(self, rng: np.random.Generator) -> None:
        """Draw the plant file's constants, and put them into the engine."""
        self.robot.set_constants(self.model, [rng.uniform(a, b) for a, b in self.plant.constants])
        mujoco.mj_setConst(self.model, self.data)
        mujoco.mj_resetData(self.model, self.data)

    def draw_start(self, rng: np.random.Generator) -> None:
        """Put the robot at rest in the start share of the tube."""
        low, high = self.tube_edges(0.0)[0]
        share = float(self.task.initial_set.share) * 0.999
        self.data.qpos[:] = (low + high) / 2 + share * rng.uniform(-1, 1, len(low)) * (high - low) / 2
        mujoco.mj_forward(self.model, self.data)  # `disturb` needs the inertia at this state

    def disturb(self, w: Array) -> None:
        """Apply the forces that accelerate the robot by w, (n,), whatever its inertia is."""
        inertia = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, inertia)
        self.data.qfrc_applied[:] = inertia @ w

    def margin(self, edges: Array) -> float:
        """Return the distance of the present state from the nearer edge, over the tube's width. edges: (2, 2, n)."""
        x = self.data.qpos
        from_middle = np.stack([x, self.data.qvel + self.filter * x]) - edges.mean(axis=1)
        return float(0.5 - np.abs(from_middle / (edges[:, 1] - edges[:, 0])).max())

    def has_arrived(self) -> bool:
        target = self.task.target_set
        assert target is not None
        return all(float(a) <= v <= float(b) for a, v, b in zip(target.lower, self.data.qpos, target.upper, strict=True))

    def run_mission(self, seed: int, on_sample: Callable[[float], None] = lambda _: None) -> SimulatedRun:
        """Simulate one mission, from drawn constants and a drawn start. on_sample: called with the time of each sample."""
        rng, data, n = np.random.default_rng(seed), self.data, self.task.dimension
        self.draw_constants(rng)
        self.draw_start(rng)
        noise, noise_v = (np.array([float(v) for v in values]) for values in (self.task.noise, self.task.noise_v))
        w_max = float(self.task.plant.w_max)  # type: ignore[arg-type]
        measured_state, u = (ctypes.c_double * (2 * n))(), (ctypes.c_double * n)()
        contact_steps = outside_samples = 0
        largest_input, margin, direction, next_draw = np.zeros(n), 0.5, np.zeros(n), 0.0
        for k in range(0, self.mission_steps, self.steps_per_sample):
            t = k * STEP
            on_sample(t)
            edges = self.tube_edges(t)
            if 4 * k > self.mission_steps:  # the margin at the start says how the start was drawn
                margin = min(margin, self.margin(edges))
            x = data.qpos + noise * rng.uniform(-1, 1, n)
            measured_state[:] = [*x, *(data.qvel + noise_v * rng.uniform(-1, 1, n))]
            outside_samples += self.emitted_code.step(ctypes.c_double(t), measured_state, u) != 0
            largest_input = np.maximum(largest_input, np.abs(u[:]))
            if seed % 2:  # towards the nearer edges
                low, high = edges[0]
                direction = (2 * data.qpos - low - high) / (high - low)
            elif t >= next_draw:
                direction, next_draw = rng.normal(size=n), t + rng.uniform(0.05, 2.0)
            self.disturb(w_max * direction / max(float(np.linalg.norm(direction)), 1e-12))
            force = self.mixing(x).full() @ u[:]
            for step in range(min(self.steps_per_sample, self.mission_steps - k)):
                if step >= self.latency_steps or k == 0:  # the first input acts at once
                    data.ctrl[:] = force
                mujoco.mj_step(self.model, data)
                contact_steps += data.ncon > 0
        return SimulatedRun(contact_steps, outside_samples, self.has_arrived(), margin, largest_input)

    def measure_bounds(self, count: int) -> MeasuredBounds:
        """Measure f, g and g_cross in the engine, at `count` states of the tubes with drawn constants.

        Every second state has z at edges of its tube. The board's mixing is of a noisy sample, as old as an input can be while it
        is held.
        """
        rng, n, plant = np.random.default_rng(1), self.task.dimension, self.task.plant
        f, g_cross, g_min, g_max = np.zeros(n), np.zeros(n), np.full(n, np.inf), np.zeros(n)
        for k in range(count):
            self.draw_constants(rng)
            (low, high), (low_z, high_z) = self.tube_edges(rng.uniform(0, self.mission_steps * STEP))
            x = low + rng.uniform(0, 1, n) * (high - low)
            share = rng.uniform(0, 1, n) if k % 2 else rng.integers(0, 2, n)
            v = low_z + share * (high_z - low_z) - self.filter * x
            age = rng.uniform(0, (self.steps_per_sample + self.latency_steps) * STEP)
            mixing = self.mixing(x - age * v + np.array([float(v) for v in self.task.noise]) * rng.uniform(-1, 1, n)).full()
            accelerations = []  # without an input, then with a unit of each
            for u in (np.zeros(n), *np.eye(n)):
                self.data.qpos[:], self.data.qvel[:], self.data.ctrl[:] = x, v, mixing @ u
                mujoco.mj_forward(self.model, self.data)
                accelerations.append(self.data.qacc.copy())
            g = np.array([c - accelerations[0] for c in accelerations[1:]]).T
            f, diagonal = np.maximum(f, np.abs(accelerations[0])), np.diag(g)
            g_min, g_max = np.minimum(g_min, diagonal), np.maximum(g_max, diagonal)
            g_cross = np.maximum(g_cross, np.abs(g - np.diag(diagonal)).max(axis=1))
        bounds = {"f": plant.f_max, "g_min": plant.g_min, "g_max": plant.g_max, "g_cross": plant.g_cross}
        stated = {name: np.broadcast_to(np.array(value, float), (n,)) for name, value in bounds.items()}
        return MeasuredBounds(f, g_min, g_max, g_cross, stated, *self.count_touching(count, rng))

    def count_touching(self, count: int, rng: np.random.Generator) -> tuple[int, int]:
        """Draw configurations, and count those outside the unsafe sets (grown by the body) that touch a geom in the engine.

        Return how many touch, and how many were outside. Both are of `count` drawn configurations in the state space.
        """
        task, touching_count, checked_count = self.task, 0, 0
        lower, upper = (np.array([float(v) for v in ends]) for ends in (task.state_space.lower, task.state_space.upper))
        body = np.array([float(v) for v in task.body or [0] * task.dimension])
        sets = [(len(s.lower), np.array(s.lower, float), np.array(s.upper, float)) for s in task.unsafe]  # of the first m axes
        for _ in range(count):
            x = lower + body + rng.uniform(0, 1, task.dimension) * (upper - lower - 2 * body)
            if any(np.all((low - body[:m] < x[:m]) & (x[:m] < high + body[:m])) for m, low, high in sets):
                continue
            checked_count += 1
            mujoco.mj_resetData(self.model, self.data)
            self.data.qpos[:] = x
            mujoco.mj_forward(self.model, self.data)
            touching_count += self.data.ncon > 0
        return touching_count, checked_count


def engine_steps(seconds: Any) -> int:
    """Return how many steps of the engine a time is; it must be a whole number of them."""
    steps = round(float(seconds) / STEP)
    assert abs(steps * STEP - float(seconds)) < 1e-12
    return steps


def bound_rows(name: str, measured: MeasuredBounds) -> list[list[str]]:
    """Return the table's rows of one robot: measured and stated bounds, and configurations that touch a geom."""
    rows = [[name, key, joined(getattr(measured, key)), joined(value)] for key, value in measured.stated.items()]
    touching = f"{measured.touching_count} of {measured.checked_count:,}"
    return [*rows, [name, "configurations off the sets that touch a geom", touching, "0"]]


def run_row(name: str, lag: float, runs: list[SimulatedRun], u_max: Any, seconds: float) -> list[str]:
    """Return the table's row of one robot's runs. lag: of the motors, seconds. seconds: how long the runs took."""
    counts = [sum(r.contact_steps > 0 for r in runs), sum(r.outside_samples > 0 for r in runs), sum(r.has_arrived for r in runs)]
    margin, largest_input = min(r.margin for r in runs), joined(np.max([r.largest_input for r in runs], axis=0))
    label = name + f", motors {lag:g} s late" * (lag > 0)
    return [label, str(len(runs)), *map(str, counts), f"{margin:.3f}", largest_input, joined(u_max), f"{seconds:.0f}"]


def joined(values: Any) -> str:
    return ", ".join(f"{float(v):.3g}" for v in values)


def draw_missions(file: Path) -> None:
    """Write a picture of a mission of each robot, side by side."""
    from PIL import Image

    Image.fromarray(np.hstack([mission_picture("base", 2.5), mission_picture("arm", 1.4)])).save(file)


def mission_picture(name: str, seconds: float) -> Array:
    """Return a mission from above, with the robot drawn each time so many seconds have passed: (720, 960, 3), 8-bit RGB."""
    simulation = RobotSimulation(name)
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.elevation = simulation.robot.view
    camera.azimuth = 90
    images: list[Array] = []

    def on_sample(t: float) -> None:
        if t >= len(images) * seconds:
            images.append(render())

    def render() -> Array:
        mujoco.mj_forward(simulation.model, simulation.data)
        renderer.update_scene(simulation.data, camera)
        return renderer.render().astype(int)

    with mujoco.Renderer(simulation.model, 720, 960) as renderer:
        simulation.run_mission(1, on_sample)
        images.append(render())
    background = np.median(images, axis=0)  # what does not move is the same in most images
    picture = background.copy()
    for image in images:
        is_robot = np.abs(image - background).max(axis=2) > 6
        picture[is_robot] = image[is_robot]
    return picture.astype(np.uint8)


def main() -> int:
    """Run the benchmark, or draw its missions. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the tables into this file")
    parser.add_argument("--picture", type=Path, metavar="PNG", help="only draw a run of each, side by side")
    options = parser.parse_args()
    if options.picture is not None:
        draw_missions(options.picture)
        return 0
    is_good, bounds, run_rows = True, [], []
    for name in ROBOTS:
        measured = RobotSimulation(name).measure_bounds(MEASURED_STATES)
        bounds += bound_rows(name, measured)
        is_good &= measured.are_within_stated
    for lag, count in ((0.0, options.runs), (MOTOR_LAG, max(1, options.runs // 5))):
        for name in ROBOTS:
            simulation, begin = RobotSimulation(name, lag), time.perf_counter()
            runs = [simulation.run_mission(seed) for seed in range(count)]
            run_rows.append(run_row(name, lag, runs, simulation.task.u_max, time.perf_counter() - begin))
            is_good &= lag > 0 or all(r.is_successful for r in runs)
    text = table(["", f"in {MEASURED_STATES:,} states of the tube", "measured", "[plant]"], bounds)
    head = ["", "runs", "with contacts", "with a sample outside", "in the target", "least margin", "|u|", "u_max", "s"]
    text = f"{text}\n\n{table(head, run_rows)}"
    print(text)
    if options.record:
        title = f"## A physics engine\n\nMade by `{command()}`; MuJoCo {mujoco.__version__}; {machine()}."
        record(options.record, "physics", f"{title}\n\n{text}")
    return int(not is_good)


if __name__ == "__main__":
    raise SystemExit(main())
