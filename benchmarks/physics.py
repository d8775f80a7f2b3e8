"""The emitted C against a physics engine that is not ours: MuJoCo moves the bodies and finds the contacts.

    python -m benchmarks physics [--runs 1000] [--record FILE.md]
    python -m benchmarks physics --picture PNG

The base (tasks/base.toml) and the arm (tasks/arm.toml) of benchmarks/bodies.py, with mass, inertia, friction and limits of force.
Each run draws the plant file's constants and a start among the proved ones, samples at the proved period with the proved noise,
lets inputs act the proved latency later, and is pushed with w_max: in drawn directions for drawn times, or, every second run,
towards the tube's nearer edges. Shelves, walls and the post are geoms; a contact is MuJoCo's. What the plant's bounds are is
measured in the same model: f, g and g_cross from qacc at states of the tube. A fifth as many runs again have motors that follow
LAG late, which is beyond the proof.

The command ends with 1 after a contact, a sample outside or a target missed, unless motors are late; and where a measured bound
is beyond [plant], or a configuration off the unsafe sets touches a geom.
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

from benchmarks.bodies import BODIES, STEP
from benchmarks.suites.report import command, machine, record, table
from stt_codegen.loop.compiled import own
from stt_codegen.pipeline import build_task
from stt_codegen.plants import plant_of
from stt_codegen.task.load import load_task

ROOT = Path(__file__).resolve().parent.parent
LAG = 0.01  # seconds, of motors of first order
STATES = 20_000  # at which the plant's bounds are measured
Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Mission:
    """contacts: steps of the engine with one. outside: samples with another status than inside. margin: the least, from a quarter
    of t_c on, when the start is forgotten, of the true state's distance to the nearer edge over the width, of x and of
    z = v + lambda x. push: the largest |u_i|, (n,)."""

    contacts: int
    outside: int
    arrived: bool
    margin: float
    push: Array

    @property
    def good(self) -> bool:
        return self.arrived and self.contacts + self.outside == 0


@dataclass(frozen=True)
class Measured:
    """By component, (n,): the largest |f_i|, the least and largest g_ii, the largest |g_ij|. stated: the same of [plant].
    touching, looked_at: of configurations off the unsafe sets, how many touch a geom, of how many."""

    f: Array
    g_min: Array
    g_max: Array
    g_cross: Array
    stated: dict[str, Array]
    touching: int
    looked_at: int

    @property
    def holds(self) -> bool:
        s = self.stated
        below = all((getattr(self, name) <= s[name]).all() for name in ("f", "g_max", "g_cross"))
        return below and bool((self.g_min >= s["g_min"]).all()) and self.touching == 0


class Bench:
    """One robot, its engine and its controller. lag: seconds, of the motors."""

    def __init__(self, name: str, lag: float = 0.0) -> None:
        self.controller = build_task(load_task(ROOT / "tasks" / f"{name}.toml"))
        assert self.controller.certificate.holds
        self.task, self.body = self.controller.task, BODIES[name]
        self.own, n = own(self.controller), self.task.dimension
        self.filter = np.array([float(v) for v in self.controller.design.filter])  # lambda, 1/s
        self.plant = plant_of(str(ROOT / "tasks" / f"{name}.py"), n, 2)
        x = ca.SX.sym("x", n)
        assert self.plant.mixing is not None
        self.mix = ca.Function("mix", [x], [ca.densify(self.plant.mixing(x))])
        self.model = mujoco.MjModel.from_xml_string(self.body.mjcf(self.task, self.largest_forces(), lag))
        self.data = mujoco.MjData(self.model)
        proved = self.controller.certificate.proved_period
        assert proved is not None
        self.held, self.late, self.last = (self.steps(v) for v in (proved.period, proved.latency, self.task.prescribed_time))

    def steps(self, seconds: Any) -> int:
        """How many steps of the engine a time is, exactly."""
        steps = round(float(seconds) / STEP)
        assert abs(steps * STEP - float(seconds)) < 1e-12
        return steps

    def largest_forces(self) -> list[float]:
        """By input of the engine, more than the board can ask for anywhere: |mix| u_max over a grid of the state space."""
        lower, upper = self.task.state_space.lower, self.task.state_space.upper
        axes = [np.linspace(float(a), float(b), 9) for a, b in zip(lower, upper, strict=True)]
        most = [float(v) for v in self.task.u_max or ()]
        asked = [np.abs(self.mix(list(x)).full()) @ most for x in np.stack(np.meshgrid(*axes), -1).reshape(-1, len(axes))]
        return [1.05 * float(v) for v in np.max(asked, axis=0)]

    def edges(self, t: float) -> Array:
        """Of the emitted tubes at t: (2, 2, n), lower and upper edges of x, then of z = v + lambda x."""
        n = self.task.dimension
        lower, upper = (ctypes.c_double * (2 * n))(), (ctypes.c_double * (2 * n))()
        self.own.tube(ctypes.c_double(t), lower, upper)
        return np.array([lower[:], upper[:]]).reshape(2, 2, n).swapaxes(0, 1)

    def set_constants(self, dice: np.random.Generator) -> None:
        self.body.constants(self.model, [dice.uniform(a, b) for a, b in self.plant.constants])
        mujoco.mj_setConst(self.model, self.data)
        mujoco.mj_resetData(self.model, self.data)

    def set_start(self, dice: np.random.Generator) -> None:
        """In the share of the tube, at rest."""
        low, high = self.edges(0.0)[0]
        share = float(self.task.initial_set.share) * 0.999
        self.data.qpos[:] = (low + high) / 2 + share * dice.uniform(-1, 1, len(low)) * (high - low) / 2
        mujoco.mj_forward(self.model, self.data)  # of which `push` takes the inertia

    def push(self, w: Array) -> None:
        """Forces that accelerate by w, (n,), whatever the inertia is."""
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        self.data.qfrc_applied[:] = full @ w

    def margin(self, edges: Array) -> float:
        """Of the state as it is now. edges: as of `edges`."""
        x = self.data.qpos
        off = np.stack([x, self.data.qvel + self.filter * x]) - edges.mean(axis=1)
        return float(0.5 - np.abs(off / (edges[:, 1] - edges[:, 0])).max())

    def run(self, seed: int, seen: Callable[[float], None] = lambda _: None) -> Mission:
        """One mission. seen: called at every sample with its time."""
        dice, task, data, n = np.random.default_rng(seed), self.task, self.data, self.task.dimension
        self.set_constants(dice)
        self.set_start(dice)
        noise, noise_v = (float(v or 0) for v in (task.plant.noise, task.plant.noise_v))
        w_max = float(task.plant.w_max)  # type: ignore[arg-type]
        state, u = (ctypes.c_double * (2 * n))(), (ctypes.c_double * n)()
        contacts = outside = 0
        most, margin, w, until = np.zeros(n), 0.5, np.zeros(n), 0.0
        for k in range(0, self.last, self.held):
            t = k * STEP
            seen(t)
            state[:] = [*data.qpos, *data.qvel]
            edges = self.edges(t)
            if 4 * k > self.last:
                margin = min(margin, self.margin(edges))
            x = data.qpos + noise * dice.uniform(-1, 1, n)
            state[:] = [*x, *(data.qvel + noise_v * dice.uniform(-1, 1, n))]
            outside += self.own.step(ctypes.c_double(t), state, u) != 0
            most = np.maximum(most, np.abs(u[:]))
            if seed % 2:
                low, high = edges[0]
                w = (2 * data.qpos - low - high) / (high - low)
            elif t >= until:
                w, until = dice.normal(size=n), t + dice.uniform(0.05, 2.0)
            self.push(w_max * w / max(float(np.linalg.norm(w)), 1e-12))
            force = self.mix(x).full() @ u[:]
            for step in range(min(self.held, self.last - k)):
                if step >= self.late or k == 0:  # the first acts at once
                    data.ctrl[:] = force
                mujoco.mj_step(self.model, data)
                contacts += data.ncon > 0
        assert task.target_set is not None
        ends = zip(task.target_set.lower, data.qpos, task.target_set.upper, strict=True)
        return Mission(contacts, outside, all(float(a) <= v <= float(b) for a, v, b in ends), margin, most)

    def measure(self, count: int) -> Measured:
        """Of the engine's accelerations at states of the tubes, every second one with z at edges, constants drawn; with the
        board's mixing of a sample that is noisy, and as old as one gets while its input is held."""
        dice, n, plant = np.random.default_rng(1), self.task.dimension, self.task.plant
        f, cross, least, most = np.zeros(n), np.zeros(n), np.full(n, np.inf), np.zeros(n)
        for k in range(count):
            self.set_constants(dice)
            (low, high), (low_z, high_z) = self.edges(dice.uniform(0, self.last * STEP))
            x = low + dice.uniform(0, 1, n) * (high - low)
            share = dice.uniform(0, 1, n) if k % 2 else dice.integers(0, 2, n)
            v = low_z + share * (high_z - low_z) - self.filter * x
            age = dice.uniform(0, (self.held + self.late) * STEP)
            mix = self.mix(x - age * v + float(plant.noise or 0) * dice.uniform(-1, 1, n)).full()
            columns = []
            for u in (np.zeros(n), *np.eye(n)):
                self.data.qpos[:], self.data.qvel[:], self.data.ctrl[:] = x, v, mix @ u
                mujoco.mj_forward(self.model, self.data)
                columns.append(self.data.qacc.copy())
            g = np.array([c - columns[0] for c in columns[1:]]).T
            f, diagonal = np.maximum(f, np.abs(columns[0])), np.diag(g)
            least, most = np.minimum(least, diagonal), np.maximum(most, diagonal)
            cross = np.maximum(cross, np.abs(g - np.diag(diagonal)).max(axis=1))
        given = {"f": plant.f_max, "g_min": plant.g_min, "g_max": plant.g_max, "g_cross": plant.g_cross}
        stated = {name: np.broadcast_to(np.array(value, float), (n,)) for name, value in given.items()}
        return Measured(f, least, most, cross, stated, *self.touching(count, dice))

    def touching(self, count: int, dice: np.random.Generator) -> tuple[int, int]:
        """Of drawn configurations in the state space off the unsafe sets, grown by the body: how many touch a geom, of how
        many."""
        task, touched, looked_at = self.task, 0, 0
        lower, upper = (np.array([float(v) for v in ends]) for ends in (task.state_space.lower, task.state_space.upper))
        body = np.array([float(v) for v in task.body or [0] * task.dimension])
        sets = [(len(s.lower), np.array(s.lower, float), np.array(s.upper, float)) for s in task.unsafe]  # of the first m axes
        for _ in range(count):
            x = lower + body + dice.uniform(0, 1, task.dimension) * (upper - lower - 2 * body)
            if any(np.all((low - body[:m] < x[:m]) & (x[:m] < high + body[:m])) for m, low, high in sets):
                continue
            looked_at += 1
            mujoco.mj_resetData(self.model, self.data)
            self.data.qpos[:] = x
            mujoco.mj_forward(self.model, self.data)
            touched += self.data.ncon > 0
        return touched, looked_at


def rows_of_bounds(name: str, found: Measured) -> list[list[str]]:
    rows = [[name, key, shown(getattr(found, key)), shown(value)] for key, value in found.stated.items()]
    return [*rows, [name, "configurations off the sets that touch a geom", f"{found.touching} of {found.looked_at:,}", "0"]]


def row_of_runs(name: str, lag: float, found: list[Mission], u_max: Any, seconds: float) -> list[str]:
    counts = [sum(one.contacts > 0 for one in found), sum(one.outside > 0 for one in found), sum(one.arrived for one in found)]
    least, push = min(one.margin for one in found), shown(np.max([one.push for one in found], axis=0))
    label = name + f", motors {lag:g} s late" * (lag > 0)
    return [label, str(len(found)), *map(str, counts), f"{least:.3f}", push, shown(u_max), f"{seconds:.0f}"]


def shown(values: Any) -> str:
    return ", ".join(f"{float(v):.3g}" for v in values)


def pictures(file: Path) -> None:
    """A run of each from above, its robot every so many seconds, side by side."""
    from PIL import Image

    Image.fromarray(np.hstack([picture("base", 2.5), picture("arm", 1.4)])).save(file)


def picture(name: str, seconds: float) -> Array:
    """As the engine draws it: (720, 960, 3), 8-bit RGB."""
    bench = Bench(name)
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.elevation = bench.body.view
    camera.azimuth = 90
    shots: list[Array] = []

    def seen(t: float) -> None:
        if t >= len(shots) * seconds:
            shots.append(shot())

    def shot() -> Array:
        mujoco.mj_forward(bench.model, bench.data)
        renderer.update_scene(bench.data, camera)
        return renderer.render().astype(int)

    with mujoco.Renderer(bench.model, 720, 960) as renderer:
        bench.run(1, seen)
        shots.append(shot())
    calm = np.median(shots, axis=0)  # what stands still
    made = calm.copy()
    for one in shots:
        moved = np.abs(one - calm).max(axis=2) > 6
        made[moved] = one[moved]
    return made.astype(np.uint8)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the tables into this file")
    parser.add_argument("--picture", type=Path, metavar="PNG", help="only draw a run of each, side by side")
    asked = parser.parse_args()
    if asked.picture is not None:
        pictures(asked.picture)
        return 0
    good, bounds, runs = True, [], []
    for name in BODIES:
        measured = Bench(name).measure(STATES)
        bounds += rows_of_bounds(name, measured)
        good &= measured.holds
    for lag, count in ((0.0, asked.runs), (LAG, max(1, asked.runs // 5))):
        for name in BODIES:
            bench, began = Bench(name, lag), time.perf_counter()
            found = [bench.run(seed) for seed in range(count)]
            runs.append(row_of_runs(name, lag, found, bench.task.u_max, time.perf_counter() - began))
            good &= lag > 0 or all(one.good for one in found)
    text = table(["", f"in {STATES:,} states of the tube", "measured", "[plant]"], bounds)
    head = ["", "runs", "with contacts", "with a sample outside", "in the target", "least margin", "|u|", "u_max", "s"]
    text = f"{text}\n\n{table(head, runs)}"
    print(text)
    if asked.record:
        title = f"## A physics engine\n\nMade by `{command()}`; MuJoCo {mujoco.__version__}; {machine()}."
        record(asked.record, "physics", f"{title}\n\n{text}")
    return int(not good)


if __name__ == "__main__":
    raise SystemExit(main())
