"""The emitted C against a physics engine that is not ours: MuJoCo moves the bodies and finds the contacts.

    python benchmarks/physics.py [--runs 1000] [--record FILE.md]
    python benchmarks/physics.py --picture PNG

A base (tasks/base.toml) and an arm (tasks/arm.toml) with mass, inertia, friction and limits of force. Each run draws mass or
payload and a start among the proved ones, samples at the proved period with the proved noise, lets inputs act the proved latency
later, and is pushed with w_max: in drawn directions for drawn times, or, every second run, towards the tube's nearer edges.
Shelves, walls and the post are geoms; a contact is MuJoCo's. What the plant's bounds are is measured in the same model: f, g and
g_cross from qacc at states of the tube. A fifth as many runs again have motors that follow LAG late, which is beyond the proof.
A contact, a sample outside or a target missed ends the command with 1, unless motors are late.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from stt_codegen.bench.report import command, machine, record, table
from stt_codegen.designs.grid import tube_at
from stt_codegen.loop.compiled import own
from stt_codegen.pipeline import Controller, build_task
from stt_codegen.task import Task, load_task

ROOT = Path(__file__).resolve().parent.parent
STEP = 0.001  # seconds of the engine
LOAD = 0.12  # kg in the arm's hand, as its board has it
MASS, INERTIA = 23.0, 1.15  # of the base, as its board has it
LAG = 0.01  # seconds, of motors of first order

HEAD = f"""<mujoco><option timestep="{STEP}" gravity="0 0 0" integrator="implicitfast"/>
<visual><global offwidth="960" offheight="720"/><quality shadowsize="4096"/>
<headlight ambient=".45 .45 .45" diffuse=".35 .35 .35" specular="0 0 0"/></visual>
<asset><texture name="sky" type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="16" height="16"/></asset>
<worldbody><light pos="3 2 8" dir="0 0 -1" diffuse=".35 .35 .35" specular="0 0 0"/>"""


def motor(site_or_joint: str, limit: float, lag: float, gear: str = "1") -> str:
    slow = f'dyntype="filterexact" dynprm="{lag}"' if lag else ""
    return f'<general {site_or_joint} gear="{gear}" gainprm="1" {slow} forcelimited="true" forcerange="{-limit} {limit}"/>'


def box(lower: Any, upper: Any, kind: str) -> str:
    """A box on the floor from the first corner to the second, half a metre high."""
    middle = [(float(a) + float(b)) / 2 for a, b in zip(lower, upper, strict=True)]
    half = [(float(b) - float(a)) / 2 for a, b in zip(lower, upper, strict=True)]
    colour = ".75 .45 .3 1" if kind == "shelf" else ".85 .85 .85 1"
    return f'<geom type="box" pos="{middle[0]} {middle[1]} .25" size="{half[0]} {half[1]} .25" rgba="{colour}"/>'


def base_model(task: Task, lag: float) -> str:
    (x0, y0, _), (x1, y1, _) = ([float(v) for v in ends] for ends in (task.state_space.lower, task.state_space.upper))
    walls = [((x0 - 0.1, y0), (x0, y1)), ((x1, y0), (x1 + 0.1, y1)), ((x0, y0 - 0.1), (x1, y0)), ((x0, y1), (x1, y1 + 0.1))]
    shelves = [(unsafe.lower, unsafe.upper) for unsafe in task.unsafe]
    assert task.body is not None
    assert task.u_max is not None
    force = MASS * math.hypot(*map(float, task.u_max[:2]))
    motors = [motor('site="middle"', force, lag, "1 0 0 0 0 0"), motor('site="middle"', force, lag, "0 1 0 0 0 0")]
    motors += [motor('site="middle"', INERTIA * float(task.u_max[2]), lag, "0 0 0 0 0 1")]
    return f"""{HEAD}<geom type="plane" size="0 0 1" pos="3 2.25 0" rgba=".97 .97 .97 1" contype="0" conaffinity="0"/>
    {"".join(box(*ends, "shelf") for ends in shelves)}{"".join(box(*ends, "wall") for ends in walls)}
    <body name="robot" pos="0 0 .15"><joint type="slide" axis="1 0 0" damping="4"/><joint type="slide" axis="0 1 0" damping="4"/>
    <joint type="hinge" axis="0 0 1" damping=".3"/><inertial pos="0 0 0" mass="{MASS}" diaginertia="1 1 {INERTIA}"/>
    <site name="middle"/><geom name="hull" type="cylinder" size="{float(task.body[0])} .12" rgba=".2 .4 .7 1"/>
    <geom type="box" pos=".2 0 .13" size=".1 .04 .02" rgba="1 1 1 1" contype="0" conaffinity="0"/></body></worldbody>
    <actuator>{"".join(motors)}</actuator></mujoco>"""


def arm_model(task: Task, lag: float) -> str:
    """The post stands where the second link is across it at joints within the unsafe set, and at no others."""
    assert task.u_max is not None
    post = (0.5 + 0.5 * math.cos(0.6), 0.5 * math.sin(0.6))
    most = np.array(mixed_arm(0.3)) @ [float(v) for v in task.u_max]
    motors = [motor(f'joint="{name}"', float(limit), lag) for name, limit in zip(("shoulder", "elbow"), most, strict=True)]
    rod = '<inertial pos=".25 0 0" mass="2" diaginertia="1e-3 {0} {0}"/>'.format(2 * 0.25 / 12)
    link = '<geom type="capsule" fromto="0 0 0 .5 0 0" size=".01" rgba=".2 .4 .7 1" {}/>'
    return f"""{HEAD}<geom type="plane" size="0 0 1" pos=".5 0 -.1" rgba=".97 .97 .97 1" contype="0" conaffinity="0"/>
    <geom name="post" type="cylinder" pos="{post[0]} {post[1]} 0" size=".02 .1" rgba=".75 .45 .3 1"/>
    <body><joint name="shoulder" type="hinge" axis="0 0 1" damping=".1"/>{rod}{link.format('contype="0" conaffinity="0"')}
    <body pos=".5 0 0"><joint name="elbow" type="hinge" axis="0 0 1" damping=".1"/>{rod}{link.format("")}
    <body name="load" pos=".5 0 0"><inertial pos="0 0 0" mass="{LOAD}" diaginertia="1e-9 1e-9 1e-9"/>
    <geom type="sphere" size=".02" rgba=".9 .6 .2 1" contype="0" conaffinity="0"/></body></body></body></worldbody>
    <actuator>{"".join(motors)}</actuator></mujoco>"""


def mixed_base(x: Any) -> list[list[float]]:
    """Forces in the base's frame of accelerations in the world's, by the heading that was seen."""
    c, s = math.cos(x[2]), math.sin(x[2])
    return [[MASS * c, MASS * s, 0.0], [-MASS * s, MASS * c, 0.0], [0.0, 0.0, INERTIA]]


def mixed_arm(elbow: float) -> list[list[float]]:
    """The inertia of an arm with LOAD in its hand."""
    first, b, d = 2 * 0.25 * (1 / 3 + 1) + LOAD * 0.25, (1 + LOAD) * 0.25 * math.cos(elbow), (2 / 3 + LOAD) * 0.25
    return [[first + d + 2 * b, d + b], [d + b, d]]


def base_drawn(model: Any, dice: Any) -> None:
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "robot")
    model.body_mass[body] = dice.uniform(20, 26)
    model.body_inertia[body][2] = dice.uniform(1.0, 1.3)


def arm_drawn(model: Any, dice: Any) -> None:
    model.body_mass[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "load")] = max(1e-6, dice.uniform(0, 0.3))


VIEWS = {"base": ((3.0, 2.25, 0.0), 7.6, -60.0, 90.0), "arm": ((0.55, 0.2, 0.0), 2.3, -65.0, 90.0)}


@dataclass(frozen=True)
class Robot:
    """mix: torques of u at the joints of a sample. drawn: mass or payload of one run."""

    model: Callable[[Task, float], str]
    mix: Callable[[Any], list[list[float]]]
    drawn: Callable[[Any, Any], None]


ROBOTS = {
    "base": Robot(base_model, mixed_base, base_drawn),
    "arm": Robot(arm_model, lambda x: mixed_arm(x[1]), arm_drawn),
}


class Bench:
    """One robot, its engine and its controller."""

    def __init__(self, name: str, lag: float = 0.0) -> None:
        self.robot, self.controller = ROBOTS[name], _controller(name)
        self.task, self.own = self.controller.task, own(self.controller)
        self.model = mujoco.MjModel.from_xml_string(self.robot.model(self.task, lag))
        self.data = mujoco.MjData(self.model)
        proved = self.controller.certificate.proved_period
        assert proved is not None
        self.held, self.late = round(float(proved.period) / STEP), round(float(proved.latency) / STEP)
        assert self.held * STEP == float(proved.period)
        assert self.late * STEP == float(proved.latency)
        self.grid = np.linspace(0, float(self.task.prescribed_time), 2001)
        self.low, self.high = tube_at(self.controller.design, self.grid)

    def edges(self, t: float) -> tuple[Any, Any]:
        k = min(int(t / self.grid[1]), len(self.grid) - 1)
        return self.low[k], self.high[k]

    def draw(self, dice: Any) -> None:
        """A mass or payload, and a start: in the share, at rest."""
        self.robot.drawn(self.model, dice)
        mujoco.mj_setConst(self.model, self.data)
        mujoco.mj_resetData(self.model, self.data)
        low, high = self.edges(0.0)
        share = float(self.task.initial_set.share) * 0.999
        self.data.qpos[:] = (low + high) / 2 + share * dice.uniform(-1, 1, len(low)) * (high - low) / 2

    def pushed(self, w: Any) -> None:
        """Forces that accelerate by w, whatever the inertia."""
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        self.data.qfrc_applied[:] = full @ w

    def run(self, seed: int, seen: Callable[[float], None] = lambda t: None) -> dict[str, Any]:
        """One mission: contacts, samples outside, whether it is in the target, the least margin, the largest |u|. seen: called at
        every sample."""
        dice, task, data, n = np.random.default_rng(seed), self.task, self.data, self.task.dimension
        self.draw(dice)
        noise, noise_v, w_max = (float(v or 0) for v in (task.plant.noise, task.plant.noise_v, least(task.plant.w_max)))
        state, u = (ctypes.c_double * (2 * n))(), (ctypes.c_double * n)()
        found = {"contacts": 0, "outside": 0, "u": np.zeros(n), "near": 1.0}
        w, until, outward = np.zeros(n), 0.0, seed % 2 == 1
        for k in range(math.ceil(float(task.prescribed_time) / (self.held * STEP))):
            t = k * self.held * STEP
            seen(t)
            x, v = data.qpos + noise * dice.uniform(-1, 1, n), data.qvel + noise_v * dice.uniform(-1, 1, n)
            state[:] = [*x, *v]
            found["outside"] += self.own.step(ctypes.c_double(t), state, u) != 0
            found["u"] = np.maximum(found["u"], np.abs(u[:]))
            low, high = self.edges(t)
            off = (2 * data.qpos - low - high) / (high - low)
            found["near"] = min(found["near"], float(1 - np.abs(off).max()) / 2)
            if outward:
                w = off
            elif t >= until:
                w, until = dice.normal(size=n), t + dice.uniform(0.05, 2.0)
            self.pushed(w_max * w / max(float(np.linalg.norm(w)), 1e-12))
            torque = np.array(self.robot.mix(x)) @ u[:]
            late = self.late if k else 0  # the first acts at once
            for steps, act in ((late, False), (self.held - late, True)):
                if act:
                    data.ctrl[:] = torque
                for _ in range(steps):
                    mujoco.mj_step(self.model, data)
                    found["contacts"] += data.ncon
        assert task.target_set is not None
        ends = zip(task.target_set.lower, data.qpos, task.target_set.upper, strict=True)
        return {**found, "arrived": all(float(a) <= v <= float(b) for a, v, b in ends)}

    def bounds(self, count: int, dice: Any) -> dict[str, Any]:
        """The largest |f_i|, the least and largest g_ii, the largest |g_ij|, of the engine's accelerations at states of the tube
        with v + lambda x in the filtered one, of drawn masses; with the board's mixing."""
        n, design = self.task.dimension, self.controller.design
        f, cross = np.zeros(n), np.zeros(n)
        g_min, g_max = np.full(n, np.inf), np.zeros(n)
        rate = [np.gradient(edge, self.grid, axis=0) for edge in (self.low, self.high)]
        for _ in range(count):
            self.robot.drawn(self.model, dice)
            mujoco.mj_setConst(self.model, self.data)
            mujoco.mj_resetData(self.model, self.data)
            k = dice.integers(len(self.grid))
            low, high = self.low[k], self.high[k]
            x = low + dice.uniform(0, 1, n) * (high - low)
            filtered = np.array([float(v) for v in design.filter])
            z = [rate[side][k] + filtered * edge[k] for side, edge in enumerate((self.low, self.high))]
            v = z[0] + dice.uniform(0, 1, n) * (z[1] - z[0]) - filtered * x
            mix = np.array(self.robot.mix(x + float(self.task.plant.noise or 0) * dice.uniform(-1, 1, n)))
            columns = []
            for u in (np.zeros(n), *np.eye(n)):
                self.data.qpos[:], self.data.qvel[:], self.data.ctrl[:] = x, v, 0
                self.data.qfrc_applied[:] = 0
                self.data.ctrl[:] = mix @ u
                mujoco.mj_forward(self.model, self.data)
                columns.append(self.data.qacc.copy())
            g = np.array([c - columns[0] for c in columns[1:]]).T
            f, diagonal = np.maximum(f, np.abs(columns[0])), np.diag(g)
            g_min, g_max = np.minimum(g_min, diagonal), np.maximum(g_max, diagonal)
            cross = np.maximum(cross, np.abs(g - np.diag(diagonal)).max(axis=1))
        return {"f": f, "g_min": g_min, "g_max": g_max, "g_cross": cross}

    def geoms_within(self, count: int, dice: Any) -> int:
        """Of drawn configurations outside the unsafe sets, grown by the body, in the state space: how many touch a geom."""
        task, touched = self.task, 0
        lower, upper = (np.array([float(v) for v in ends]) for ends in (task.state_space.lower, task.state_space.upper))
        body = np.array([float(v) for v in task.body]) if task.body else np.zeros(task.dimension)
        for _ in range(count):
            x = lower + body + dice.uniform(0, 1, task.dimension) * (upper - lower - 2 * body)
            if any(self._inside(unsafe, x, body) for unsafe in task.unsafe):
                continue
            mujoco.mj_resetData(self.model, self.data)
            self.data.qpos[:] = x
            mujoco.mj_forward(self.model, self.data)
            touched += self.data.ncon > 0
        return touched

    def _inside(self, unsafe: Any, x: Any, body: Any) -> bool:
        axes = range(len(unsafe.lower))
        return all(float(unsafe.lower[i]) - body[i] < x[i] < float(unsafe.upper[i]) + body[i] for i in axes)


def least(value: Any) -> Any:
    return min(value) if isinstance(value, tuple) else value


def _controller(name: str) -> Controller:
    made = build_task(load_task(ROOT / "tasks" / f"{name}.toml"))
    assert made.certificate.holds
    return made


def told(name: str, runs: int, lag: float = 0.0) -> tuple[list[str], bool]:
    """A row of the table of runs, and whether a run was not as it is proved."""
    bench, began = Bench(name, lag), time.perf_counter()
    found = [bench.run(seed) for seed in range(runs)]
    seconds = time.perf_counter() - began
    contacts, outside, arrived = (sum(one[key] > 0 for one in found) for key in ("contacts", "outside", "arrived"))
    most, near = np.max([one["u"] for one in found], axis=0), min(one["near"] for one in found)
    row = [name + f", motors {lag:g} s late" * (lag > 0), runs, contacts, outside, arrived, f"{near:.3f}", shown(most)]
    return [*map(str, row), shown(bench.task.u_max), f"{seconds:.0f}"], contacts + outside > 0 or arrived < runs


def measured(name: str, count: int = 20_000) -> list[list[str]]:
    """Rows of the table of bounds."""
    bench, dice = Bench(name), np.random.default_rng(1)
    within, plant = bench.bounds(count, dice), bench.task.plant
    stated = {"f": plant.f_max, "g_min": plant.g_min, "g_max": plant.g_max, "g_cross": plant.g_cross}
    rows = [[name, key, shown(within[key]), shown(value)] for key, value in stated.items()]
    return [*rows, [name, "configurations off the sets that touch a geom", f"{bench.geoms_within(count, dice)} of {count}", "0"]]


def shown(values: Any) -> str:
    return ", ".join(f"{float(v):.3g}" for v in (values if hasattr(values, "__len__") else [values]))


def pictures(file: Path) -> None:
    from PIL import Image

    drawn = [picture("base", 2.5), picture("arm", 1.4)]
    Image.fromarray(np.hstack(drawn)).save(file)


def picture(name: str, seconds: float) -> Any:
    """A run from above, its robot every so many seconds, each as the engine draws it: an array of 8-bit RGB."""
    bench = Bench(name)
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance, camera.elevation, camera.azimuth = VIEWS[name]
    shots: list[Any] = []

    def seen(t: float) -> None:
        if t >= len(shots) * seconds:
            shots.append(shot())

    def shot() -> Any:
        mujoco.mj_forward(bench.model, bench.data)
        drawn.update_scene(bench.data, camera)
        return drawn.render().astype(int)

    with mujoco.Renderer(bench.model, 720, 960) as drawn:
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
    bounds = table(
        ["", "in 20,000 states of the tube", "measured", "[plant]"], [row for name in ROBOTS for row in measured(name)]
    )
    proved = [told(name, asked.runs) for name in ROBOTS]
    late = [told(name, max(1, asked.runs // 5), LAG) for name in ROBOTS]
    runs = table(
        ["", "runs", "with contacts", "with a sample outside", "in the target", "least margin", "|u|", "u_max", "s"],
        [row for row, _ in (*proved, *late)],
    )
    print(f"{bounds}\n\n{runs}")
    if asked.record:
        title = f"## A physics engine\n\nMade by `{command()}`; MuJoCo {mujoco.__version__}; {machine()}."
        record(asked.record, "physics", f"{title}\n\n{bounds}\n\n{runs}")
    return int(any(wrong for _, wrong in proved))


if __name__ == "__main__":
    raise SystemExit(main())
