"""A package of ROS 2 (ament_python) about the emitted C: a node, its parameters, a launch file."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from stt_codegen.certify.missions import cycle_of
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.emit import Files, design_hash, driven_sources, file_names, spelled_name
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import Task

ODOMETRY = {"x": "x", "y": "y", "z": "z", "yaw": "yaw", "heading": "yaw", "theta": "yaw"}  # axes that a base has
PERIOD = Fraction(1, 50)  # seconds, where the task says nothing
MODULES = ("controller", "drive", "node")


def sources_of(task: Task) -> tuple[str, str, list[str]]:
    """What the node listens to and sends unless its parameters say otherwise, and the axes by the messages' names: a base by its
    odometry, joints by their names, else arrays. u of order 2 is an acceleration, and no twist."""
    if task.axes is None:
        return "array", "array", list(task.axis_names)
    known = [ODOMETRY.get(axis) for axis in task.axes]
    if None not in known and len(set(known)) == len(known):
        return "odometry", "twist" if task.order == 1 else "accel", [str(axis) for axis in known]
    return "joints", "array", list(task.axes)


def interface_of(task: Task) -> str:
    """The same in words, for who reads what was written."""
    state, command, axes = sources_of(task)
    heard = {"odometry": "nav_msgs/Odometry on odom", "joints": f"sensor_msgs/JointState on joint_states ({', '.join(axes)})"}
    sent = {"twist": "geometry_msgs/Twist on cmd_vel", "accel": "geometry_msgs/Accel on cmd_accel, an acceleration"}
    array = "std_msgs/Float64MultiArray on {}"
    told = f"listens to {heard.get(state, array.format('state'))}; sends {sent.get(command, array.format('command'))}"
    if not task.control.latency:
        told += "; a message takes time: state control.latency, or nothing is proved of it"
    return told


def ros2_package(controller: EmittedController) -> Files:
    """The package's files, in a folder <p>_ros2/. Raises `BadInput` for what has an alpha or takes a velocity by differences."""
    task = controller.task
    design = controller.design
    if not design.capabilities.runs_in_ros2_and_fmu:
        kinds = kinds_offering("runs_in_ros2_and_fmu")
        raise BadInput(f"--package ros2: is for {kinds} tubes; the {design.kind} one has steps of its own")
    if task.uses_differences:
        raise BadInput("--package ros2: a velocity by differences needs samples at even times; measure v")
    proved, cycle = controller.certificate.proved_period, cycle_of(design)
    period, latency = task.control.period or task.emit.tick_period or PERIOD, task.control.latency or Fraction(0)
    noise, noise_v = task.plant.noise or Fraction(0), task.plant.noise_v or Fraction(0)
    share = task.initial_set.share
    starts = [((a + b) / 2, share * (b - a) / 2 - noise) for a, b in controller.certificate.start]
    most = task.u_max or (proved.u if proved else None)
    g_max = float(max(b.g_max for b in task.plant_bounds)) if proved else 1.0
    state, command, axes = sources_of(task)
    package = f"{task.name.lower()}_ros2"
    header, _, module, proof = file_names(task.name)
    sources = [header, *driven_sources(task)]
    words: dict[str, Any] = {
        "prefix": task.name,
        "package": package,
        "kind": design.kind,
        "verdict": "certified" if controller.certificate.holds else "NOT CERTIFIED",
        "hash": design_hash(task, design),
        "n": task.dimension,
        "order": task.order,
        "scalar": task.emit.scalar,
        "outside": task.control.outside,
        "repeats": task.repeat,
        "t_c": decimal(task.prescribed_time),
        "cycle": None if cycle is None else decimal(cycle.length),
        "proved": proved is not None and controller.certificate.holds,
        "period": repr(float(period)),
        "latency": repr(float(latency)),
        "stale_after": repr(float(2 * period + latency)),
        "starts": repr([(float(middle - half), float(middle + half)) for middle, half in starts]),
        # A measured v may hide noise_v more. That a robot stands, no noisy measurement shows: this is assumed (ASSUMED).
        "speeds": repr(
            [float(max(Fraction(0), v - noise_v) if v else noise_v) for v in task.start_speed] if task.order == 2 else []
        ),
        "stands": not any(task.start_speed),
        "most": [float(v) for v in most] if most else f"[math.inf] * {task.dimension}",
        # So weak that u = -brake v, held for a period and late by the latency, does not turn v back whatever g is.
        "brake": f"{0.25 / (g_max * float(period + latency)):.3g}",
        "state": state,
        "command": command,
        "axes": repr(axes),
        "turns": {axis.index: float(axis.period) for axis in task.closed_axes},
        "turn": command in ("twist", "accel"),
        "sources": ", ".join(f'"src/{name}"' for name in sources if name.endswith(".c")),
    }
    named = {"package.xml": "package.xml", "setup.py": "setup.py", f"config/{task.name}.yaml": "params.yaml"}
    named |= {f"{package}/{name}.py": f"{name}.py" for name in MODULES} | {f"launch/{task.name}.launch.py": "launch"}
    files = {path: template(f"ros2/{name}.j2").render(**words).encode() for path, name in named.items()}
    files |= {f"{package}/__init__.py": b"", f"resource/{package}": b""}
    files["setup.cfg"] = f"[develop]\nscript_dir=$base/lib/{package}\n[install]\ninstall_scripts=$base/lib/{package}\n".encode()
    files |= {f"src/{name}": controller.files[name] for name in sources}
    files |= {
        f"extras/{name}": controller.files[name] for name in (module, proof, spelled_name(task.name)) if name in controller.files
    }
    return {f"{package}/{path}": data for path, data in files.items()}
