"""Package the emitted C for ROS 2 (ament_python): a node, its parameters, a launch file. record/package.py calls this."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from stt_codegen.certify.missions import cycle_of
from stt_codegen.certify.sampled import drive_words
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.emit import Files, design_hash, driven_sources, extra_files, file_names
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import Task

# Names of a task's axes that a mobile base reports, and what the node calls them.
ODOMETRY_AXES = {"x": "x", "y": "y", "z": "z", "yaw": "yaw", "heading": "yaw", "theta": "yaw"}
DEFAULT_PERIOD = Fraction(1, 50)  # seconds, where the task states none
MODULES = ("controller", "drive", "node")  # Python of the package, templates of the same names


class MessageKinds(NamedTuple):
    """Kinds of messages that the node receives and sends, and the names of the axes in them.

    state: odometry, joints or array. command: twist, accel or array.
    """

    state: str
    command: str
    axes: list[str]


def message_kinds(task: Task) -> MessageKinds:
    """Choose messages by the names of the task's axes; parameters of the node can change them.

    A mobile base has odometry, all other named axes are joints, axes without names are arrays.
    """
    if task.axes is None:
        return MessageKinds("array", "array", list(task.axis_names))
    base_axes = [ODOMETRY_AXES.get(axis) for axis in task.axes]
    if None not in base_axes and len(set(base_axes)) == len(base_axes):
        command = "twist" if task.order == 1 else "accel"  # u of order 2 is an acceleration
        return MessageKinds("odometry", command, [str(axis) for axis in base_axes])
    return MessageKinds("joints", "array", list(task.axes))


def interface_of(task: Task) -> str:
    """Describe the messages of the node in a sentence, which `generate` prints."""
    state, command, axes = message_kinds(task)
    received = {"odometry": "nav_msgs/Odometry on odom", "joints": f"sensor_msgs/JointState on joint_states ({', '.join(axes)})"}
    sent = {"twist": "geometry_msgs/Twist on cmd_vel", "accel": "geometry_msgs/Accel on cmd_accel, an acceleration"}
    array = "std_msgs/Float64MultiArray on {}"
    description = f"listens to {received.get(state, array.format('state'))}; sends {sent.get(command, array.format('command'))}"
    if not task.control.latency:
        description += "; a message takes time: state control.latency, or nothing is proved of it"
    return description


def ros2_package(controller: EmittedController) -> Files:
    """Return the package's files, in a folder <p>_ros2/. Raises `BadInput` where the node cannot drive the controller."""
    task = controller.task
    _require_external_time(controller)
    package = f"{task.name.lower()}_ros2"
    common = file_names(task.name)
    sources = [common.header, *driven_sources(task)]
    words = {
        **_names_for_templates(controller, package, sources),
        **_times_for_templates(controller),
        **_limits_for_templates(controller),
        **_messages_for_templates(task),
    }
    template_names = {"package.xml": "package.xml", "setup.py": "setup.py", f"config/{task.name}.yaml": "params.yaml"}
    template_names |= {f"{package}/{name}.py": f"{name}.py" for name in MODULES}
    template_names[f"launch/{task.name}.launch.py"] = "launch"
    files = {path: template(f"ros2/{name}.j2").render(**words).encode() for path, name in template_names.items()}
    files |= {f"{package}/__init__.py": b"", f"resource/{package}": b""}
    files["setup.cfg"] = f"[develop]\nscript_dir=$base/lib/{package}\n[install]\ninstall_scripts=$base/lib/{package}\n".encode()
    files |= {f"src/{name}": controller.files[name] for name in sources}
    files |= {f"extras/{name}": data for name, data in extra_files(task.name, controller.design, controller.files).items()}
    return {f"{package}/{path}": data for path, data in files.items()}


def _require_external_time(controller: EmittedController) -> None:
    """Raise `BadInput` for a controller that has an alpha or takes a velocity by differences: messages come at uneven times."""
    if not controller.design.capabilities.runs_in_ros2_and_fmu:
        kinds = kinds_offering("runs_in_ros2_and_fmu")
        raise BadInput(f"--package ros2: is for {kinds} tubes; the {controller.design.kind} one has steps of its own")
    if controller.task.uses_differences:
        raise BadInput("--package ros2: a velocity by differences needs samples at even times; measure v")


def _names_for_templates(controller: EmittedController, package: str, sources: Sequence[str]) -> dict[str, Any]:
    """Return names and kinds of the controller."""
    task, design = controller.task, controller.design
    return {
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
        "sources": ", ".join(f'"src/{name}"' for name in sources if name.endswith(".c")),
    }


def _times_for_templates(controller: EmittedController) -> dict[str, Any]:
    """Return the times in seconds, as literals of Python."""
    task, cycle = controller.task, cycle_of(controller.design)
    period, latency = _period_and_latency(task)
    return {
        "t_c": decimal(task.prescribed_time),
        "cycle": None if cycle is None else decimal(cycle.length),
        "proved": controller.certificate.proved_period is not None and controller.certificate.holds,
        "period": repr(float(period)),
        "latency": repr(float(latency)),
        "stale_after": repr(float(2 * period + latency)),
    }


def _period_and_latency(task: Task) -> tuple[Fraction, Fraction]:
    return task.control.period or task.emit.tick_period or DEFAULT_PERIOD, task.control.latency or Fraction(0)


def _drive_delay(task: Task, u_max: tuple[Fraction, ...] | None) -> float:
    """Return the delay of the slowest drive in seconds; of one with a limited rate, the time from -u_max to u_max."""
    limits = u_max or (Fraction(0),) * task.dimension
    delays = (b.lag + b.lag2 + (2 * u / b.slew if b.slew else 0) for b, u in zip(task.drive_bounds, limits, strict=True))
    return float(max(delays))


def _limits_for_templates(controller: EmittedController) -> dict[str, Any]:
    """Return where the robot may start, at which speed, and the limits of u, as literals of Python."""
    task, proved = controller.task, controller.certificate.proved_period
    share = task.initial_set.share
    edges_and_noise = zip(controller.certificate.start, task.noise, strict=True)
    starts = [((a + b) / 2, share * (b - a) / 2 - noise) for (a, b), noise in edges_and_noise]
    # A measured v may hide noise_v more. That a robot stands, no noisy measurement shows: this is assumed (ASSUMED).
    both = zip(task.start_speed, task.noise_v, strict=True)
    speeds = [float(max(Fraction(0), v - noise_v) if v else noise_v) for v, noise_v in both] if task.order == 2 else []
    u_max = task.u_max or (proved.u if proved else None)
    g_max = float(max(b.g_max for b in task.plant_bounds)) if proved else 1.0
    amplification = float(max(b.amplification for b in task.drive_bounds))
    return {
        "starts": repr([(float(middle - half), float(middle + half)) for middle, half in starts]),
        "speeds": repr(speeds),
        "stands": not any(task.start_speed),
        "drives": "; ".join(drive_words(task)) if task.has_drive else "",
        "most": [float(v) for v in u_max] if u_max else f"[math.inf] * {task.dimension}",
        # So weak that u = -brake v, held for a period and delayed by latency and drive, does not reverse v whatever g is.
        "brake": f"{0.25 / (g_max * amplification * (float(sum(_period_and_latency(task))) + _drive_delay(task, u_max))):.3g}",
    }


def _messages_for_templates(task: Task) -> dict[str, Any]:
    """Return the kinds of messages, and the axes by their names there."""
    state, command, axes = message_kinds(task)
    return {
        "state": state,
        "command": command,
        "axes": repr(axes),
        "turns": {axis.index: float(axis.period) for axis in task.closed_axes},
        "turn": command in ("twist", "accel"),
    }
