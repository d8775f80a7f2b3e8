"""MuJoCo's models (MJCF) of the robots of benchmarks/physics.py: a base among shelves, and an arm past a post.

They share no code with the plant files, so that the engine is independent of them. Only the mixing that the board computes comes
from the plant files, because it belongs to the controller.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco

from stt_codegen.task.task import Task

STEP = 0.001  # seconds, of the engine's integrator
MJCF_HEAD = f"""<mujoco><option timestep="{STEP}" gravity="0 0 0" integrator="implicitfast"/>
<visual><global offwidth="960" offheight="720"/><quality shadowsize="4096"/>
<headlight ambient=".45 .45 .45" diffuse=".35 .35 .35" specular="0 0 0"/></visual>
<asset><texture name="sky" type="skybox" builtin="flat" rgb1="1 1 1" rgb2="1 1 1" width="16" height="16"/></asset>
<worldbody><light pos="3 2 8" dir="0 0 -1" diffuse=".35 .35 .35" specular="0 0 0"/>"""


@dataclass(frozen=True)
class EngineRobot:
    """A robot as the engine has it.

    mjcf: makes the model from the task, the largest generalized force of each input, and the lag of the motors in seconds.
    set_constants: puts the plant file's constants, in their order, into the model. view: the point that a camera looks at, its
    distance, both in metres, and its elevation in degrees.
    """

    mjcf: Callable[[Task, Sequence[float], float], str]
    set_constants: Callable[[Any, Sequence[float]], None]
    view: tuple[tuple[float, float, float], float, float]


def motor_xml(attachment: str, limit: float, lag: float, gear: str = "1") -> str:
    """Return a motor of first order on a site or joint. limit: newtons or newton metres. lag: seconds."""
    lag_attributes = f'dyntype="filterexact" dynprm="{lag}"' if lag else ""
    return f'<general {attachment} gear="{gear}" gainprm="1" {lag_attributes} forcelimited="true" forcerange="{-limit} {limit}"/>'


def box_xml(lower: Sequence[Any], upper: Sequence[Any], colour: str) -> str:
    """Return a box on the floor from the first corner to the second, half a metre high."""
    middle = [(float(a) + float(b)) / 2 for a, b in zip(lower, upper, strict=True)]
    half = [(float(b) - float(a)) / 2 for a, b in zip(lower, upper, strict=True)]
    return f'<geom type="box" pos="{middle[0]} {middle[1]} .25" size="{half[0]} {half[1]} .25" rgba="{colour}"/>'


def base_mjcf(task: Task, force: Sequence[float], lag: float) -> str:
    """Return the base: a disc that slides and turns, between walls about the state space and the task's shelves."""
    (x0, y0, _), (x1, y1, _) = ([float(v) for v in ends] for ends in (task.state_space.lower, task.state_space.upper))
    walls = [((x0 - 0.1, y0), (x0, y1)), ((x1, y0), (x1 + 0.1, y1)), ((x0, y0 - 0.1), (x1, y0)), ((x0, y1), (x1, y1 + 0.1))]
    obstacles = [box_xml(a, b, ".85 .85 .85 1") for a, b in walls] + [
        box_xml(s.lower, s.upper, ".75 .45 .3 1") for s in task.unsafe
    ]
    axes = ("1 0 0 0 0 0", "0 1 0 0 0 0", "0 0 0 0 0 1")
    motors = [motor_xml('site="middle"', f, lag, axis) for f, axis in zip(force, axes, strict=True)]
    assert task.body is not None
    return f"""{MJCF_HEAD}{"".join(obstacles)}
    <geom type="plane" size="0 0 1" pos="3 2.25 0" rgba=".97 .97 .97 1" contype="0" conaffinity="0"/>
    <body name="robot" pos="0 0 .15"><joint type="slide" axis="1 0 0" damping="4"/><joint type="slide" axis="0 1 0" damping="4"/>
    <joint type="hinge" axis="0 0 1" damping=".3"/><inertial pos="0 0 0" mass="23" diaginertia="1 1 1.15"/>
    <site name="middle"/><geom name="hull" type="cylinder" size="{float(task.body[0])} .12" rgba=".2 .4 .7 1"/>
    <geom type="box" pos=".2 0 .13" size=".1 .04 .02" rgba="1 1 1 1" contype="0" conaffinity="0"/></body></worldbody>
    <actuator>{"".join(motors)}</actuator></mujoco>"""


def set_base_constants(model: Any, values: Sequence[float]) -> None:
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "robot")
    model.body_mass[body], model.body_inertia[body][2] = values


def arm_mjcf(_task: Task, force: Sequence[float], lag: float) -> str:
    """Return the arm: two rods of 2 kg and 0.5 m, and a post that the second rod touches exactly in the unsafe set."""
    post = (0.5 + 0.5 * math.cos(0.6), 0.5 * math.sin(0.6))
    rod = '<inertial pos=".25 0 0" mass="2" diaginertia="1e-3 {0} {0}"/>'.format(2 * 0.25 / 12)
    link = '<geom type="capsule" fromto="0 0 0 .5 0 0" size=".01" rgba=".2 .4 .7 1" {}/>'
    motors = [motor_xml(f'joint="{name}"', f, lag) for name, f in zip(("shoulder", "elbow"), force, strict=True)]
    return f"""{MJCF_HEAD}<geom type="plane" size="0 0 1" pos=".5 0 -.1" rgba=".97 .97 .97 1" contype="0" conaffinity="0"/>
    <geom name="post" type="cylinder" pos="{post[0]} {post[1]} 0" size=".02 .1" rgba=".75 .45 .3 1"/>
    <body><joint name="shoulder" type="hinge" axis="0 0 1" damping=".1"/>{rod}{link.format('contype="0" conaffinity="0"')}
    <body pos=".5 0 0"><joint name="elbow" type="hinge" axis="0 0 1" damping=".1"/>{rod}{link.format("")}
    <body name="load" pos=".5 0 0"><inertial pos="0 0 0" mass=".1" diaginertia="1e-9 1e-9 1e-9"/>
    <geom type="sphere" size=".02" rgba=".9 .6 .2 1" contype="0" conaffinity="0"/></body></body></body></worldbody>
    <actuator>{"".join(motors)}</actuator></mujoco>"""


def set_arm_constants(model: Any, values: Sequence[float]) -> None:
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "load")
    model.body_mass[body] = max(1e-6, *values)  # kg; the engine refuses a body without mass


ROBOTS = {  # by name of the task and of the plant file
    "base": EngineRobot(base_mjcf, set_base_constants, ((3.0, 2.25, 0.0), 7.6, -60.0)),
    "arm": EngineRobot(arm_mjcf, set_arm_constants, ((0.55, 0.2, 0.0), 2.3, -65.0)),
}
