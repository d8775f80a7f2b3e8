"""The package of ROS 2: when its node drives and stops, that it builds and calls the C, and with ROS that a plant arrives."""

from __future__ import annotations

import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from fractions import Fraction
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.files import write_files
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.record.ros2 import message_kinds, ros2_package
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT, build_once

TASKS = ROOT / "tasks"
INSIDE, OUTSIDE, BAD = 0, 1, 2


def parameters_of(name: str) -> dict[str, Any]:
    """Return the parameters in the configuration file of the node."""
    return yaml.safe_load(ros2_package(ros_task_controller(name))[f"{name}_ros2/config/{name}.yaml"])[name]["ros__parameters"]


@cache
def ros_task_controller(name: str, outside: str = "return") -> EmittedController:
    task = load_task(TASKS / f"{'base' if name == 'moving' else name}.toml")
    if name == "moving":  # a robot that may move at the start
        task = task.changed(name="moving", initial_set={"speed": Fraction(1, 50)})
    return build_once(task if outside == "return" else task.changed(control={"outside": outside}))


@cache
def drive_module(name: str, outside: str = "return") -> ModuleType:
    sys.modules["drive"] = module = ModuleType("drive")  # dataclasses look up their module by its name
    exec(ros2_package(ros_task_controller(name, outside))[f"{name}_ros2/{name}_ros2/drive.py"], module.__dict__)
    return module


class ScriptedController:
    """A stub controller that returns the status in `status` and counts its instances, of which every start makes one."""

    def __init__(self) -> None:
        self.calls: list[tuple[float, tuple[float, ...]]] = []
        self.status = INSIDE
        self.starts = 0

    def make(self):
        self.starts += 1

        def control(t, x, v):
            self.calls.append((t, x))
            return self.status, (1.0, -1.0), 0.25

        return control


START = (0.5, 0.5)


@pytest.fixture
def scripted() -> ScriptedController:
    return ScriptedController()


@pytest.fixture
def drive(scripted: ScriptedController):
    """Return the drive of the crawler: proved for a state every 5 ms that is used at once; a state over 50 ms old is stale."""
    return drive_module("crawler").Drive(scripted.make, stale_after=0.05, leap=0.5)


@pytest.fixture
def running(drive):
    drive.measured(0.0, START)
    assert drive.start(0.0) == ""
    assert drive.decide(0.0).u == (1.0, -1.0)
    return drive


def test_nothing_is_sent_before_a_start_which_needs_a_fresh_state(drive, scripted) -> None:
    assert (drive.watch(1.0).u, drive.watch(1.0).message) == (None, "waits to be started")
    assert drive.start(1.0) == "there is no fresh state to start from"
    assert drive.measured(1.0, START).u is None  # whoever drives it to the start is not disturbed
    assert drive.start(1.06) == "there is no fresh state to start from"
    assert drive.start(0.9) == "there is no fresh state to start from"  # the clock went back
    assert scripted.calls == []
    drive.measured(1.01, START)
    assert drive.start(1.03) == ""
    assert drive.decide(1.03).u == (1.0, -1.0)
    assert scripted.calls == [(0.0, START)]


def test_a_new_state_gives_a_new_input_at_once(running, scripted) -> None:
    decision = running.measured(0.004, (0.51, 0.5))
    assert (decision.u, decision.level, decision.message) == ((1.0, -1.0), 0, "inside the tube")
    assert scripted.calls[-1] == (0.004, (0.51, 0.5))
    assert running.watch(0.005) is None  # nothing more to send
    assert running.measured(0.0055, START, delay=0.003).u is None  # older than the last
    assert len(scripted.calls) == 2


def test_a_node_that_drives_cannot_be_started_again(running, scripted) -> None:
    running.measured(0.004, START)
    assert running.start(0.004) == "it drives: stop it first"
    running.measured(0.008, START)
    assert scripted.calls[-1][0] == 0.008  # the mission's time goes on
    running.stop("asked to")
    assert running.start(0.009) == ""
    assert scripted.starts == 2


@pytest.mark.parametrize("name", ["crawler", "base", "arm", "drone", "moving"])
def test_it_starts_only_from_states_that_the_proof_covers(name: str, scripted) -> None:
    """The certificate covers the start share of the tube at 0, at rest; the bound on noise is subtracted from it."""
    module, controller = drive_module(name), ros_task_controller(name)
    task = controller.task
    noise, share = float(task.plant.noise or 0), float(task.initial_set.share)
    speeds = [float(v) for v in task.start_speed] if task.order == 2 else []
    middle = [float(a + b) / 2 for a, b in controller.certificate.start]
    for k, (low, high) in enumerate(controller.certificate.start):
        for side in (-1, 1):
            edge = middle[k] + side * (share * float(high - low) / 2 - noise)
            for x, may_start in ((edge - side * 1e-9, True), (edge + side * 1e-9, False)):
                drive = module.Drive(scripted.make, 1.0, 1.0)
                drive.measured(0.0, [*middle[:k], x, *middle[k + 1 :]], [0.0] * len(speeds))
                assert (drive.start(0.0) == "") == may_start
                assert may_start or drive.start(0.0).startswith(f"x[{k}] is ")
    noise_v = float(task.plant.noise_v or 0)
    for k, speed in enumerate(speeds):
        # Noise may add to the measured speed of a robot at rest, and hide a part of the speed of one that moves.
        largest_measured = speed - noise_v if speed else noise_v
        for size, may_start in ((largest_measured, True), (largest_measured * 1.0001 + 1e-9, False)):
            drive = module.Drive(scripted.make, 1.0, 1.0)
            drive.measured(0.0, middle, [-size if i == k else 0.0 for i in range(len(speeds))])
            assert (drive.start(0.0) == "") == may_start
            assert may_start or drive.start(0.0).startswith(f"v[{k}] is ")
    assert bool(module.ASSUMED) == (not any(speeds))


def test_a_robot_that_moves_at_the_start_needs_a_first_state_within_the_latency(scripted) -> None:
    for name, has_doubts in (("base", False), ("moving", True)):
        module = drive_module(name)
        drive = module.Drive(scripted.make, 1.0, 1.0)
        drive.measured(0.0, [float(a + b) / 2 for a, b in ros_task_controller(name).certificate.start], [0.0] * 3)
        assert drive.start(0.0) == ""
        drive.decide(module.LATENCY + 0.001)
        assert bool(drive.doubts) == has_doubts


def test_a_state_that_is_too_old_stops_it_until_there_is_another(running, scripted) -> None:
    decisions = [running.watch(0.01 * k) for k in range(1, 9)]
    assert [d and d.u for d in decisions] == [None] * 5 + [(0.0, 0.0)] * 3
    assert {(d.level, d.message) for d in decisions[5:]} == {(2, "stopped: there is no fresh state")}
    assert running.measured(0.085, (0.7, 0.4), delay=0.06).u == (0.0, 0.0)  # a state that took 60 ms to arrive is stale
    late = running.measured(0.09, (0.7, 0.4))
    assert (late.u, late.level) == ((1.0, -1.0), 1)
    assert late.message.startswith("inside the tube; not proved: states were too far apart")
    assert scripted.calls[-1] == (0.09, (0.7, 0.4))  # mission time went on


def test_leaving_the_conditions_of_the_proof_is_reported_until_the_next_start(running) -> None:
    module = drive_module("crawler")
    assert running.measured(module.PERIOD, START).level == 0  # exactly the proved period
    decision = running.measured(0.0101, START)
    assert (decision.level, decision.message) == (1, "inside the tube; not proved: states were too far apart")
    assert running.measured(0.012, START).level == 1
    assert running.apart == pytest.approx(0.0051)
    running.stop("asked to")
    running.start(0.012)
    running.decide(0.012)
    assert running.measured(0.014, START).level == 0
    decision = running.measured(0.016, START, delay=0.0001)
    assert decision.message == "inside the tube; not proved: a state was old when it was acted on"
    assert running.old == pytest.approx(0.0001)
    assert ros_task_controller("crawler").task.control.latency == module.LATENCY == 0


def test_a_node_without_a_proved_period_never_reports_a_proof(scripted) -> None:
    module = drive_module("omni_s2")
    assert ros_task_controller("omni_s2").certificate.proved_period is None
    drive = module.Drive(scripted.make, 1.0, 1.0)
    drive.measured(0.0, [sum(ends) / 2 for ends in module.STARTS])
    assert drive.start(0.0) == ""
    assert drive.decide(0.0).message == "inside the tube; not proved: no sampling period is proved of this tube"


@pytest.mark.parametrize("jump", [-0.001, 0.6, 3600.0])
def test_a_clock_that_jumps_stops_it_until_the_next_start(running, scripted, jump: float) -> None:
    assert running.measured(0.004, START).level == 0
    stopped = running.watch(0.004 + jump)
    assert (stopped.u, stopped.level) == ((0.0, 0.0), 2)
    assert f"the clock jumped by {jump:.3f} s" in stopped.message
    now = 0.004 + jump
    assert running.measured(now, START).message == stopped.message
    assert running.start(now) == ""
    assert scripted.starts == 2
    assert running.decide(now).u == (1.0, -1.0)


@pytest.mark.parametrize("outside", ["return", "stop"])
def test_the_node_reports_the_status_of_its_controller(scripted, outside: str) -> None:
    name = "crawler" if outside == "return" else "omni_s2"
    module = drive_module(name, outside)
    drive = module.Drive(scripted.make, 1.0, 1.0)
    x = [sum(ends) / 2 for ends in module.STARTS]
    drive.measured(0.0, x)
    drive.start(0.0)
    scripted.status = BAD
    bad = drive.measured(0.001, x)
    assert (bad.u, bad.level, bad.message) == ((0.0, 0.0), 2, "stopped: a number of the state is not finite")
    scripted.status = OUTSIDE
    decision = drive.measured(0.002, x)
    assert (decision.level, decision.status, decision.margin) == (2, 1, 0.25)
    if outside == "return":
        assert (decision.u, decision.message) == ((1.0, -1.0), "outside the tube: nothing is shown")
    else:
        assert (decision.u, decision.message) == ((0.0, 0.0), "stopped: it was outside the tube")
    scripted.status = INSIDE
    assert drive.measured(0.003, x).level == 1  # the proof no longer covers it
    drive.stop("asked to")
    assert drive.watch(0.004).message.startswith("stopped: asked to; start ")


def test_with_u_an_acceleration_a_stop_is_a_brake(scripted) -> None:
    """With zeros it would glide on. The brake acts against a fresh v within the limits, and never reverses v, for every g of the plant."""
    module, task = drive_module("base"), ros_task_controller("base").task
    brake = parameters_of("base")["brake"]
    drive = module.Drive(scripted.make, 0.05, 1.0, brake)
    x = [sum(ends) / 2 for ends in module.STARTS]
    drive.measured(0.0, x, (0.0, 0.0, 0.0))
    drive.start(0.0)
    drive.stop("asked to")
    decision = drive.measured(0.01, x, (0.1, -2.0, 0.0))
    assert decision.u == pytest.approx((-0.1 * brake, float(task.u_max[1]), 0.0))
    assert drive.watch(0.02).u == decision.u
    assert drive.watch(0.2).u == (0.0, 0.0, 0.0)  # v is not known
    assert drive.measured(0.21, x, (float("nan"), 1.0, 0.0)).u == (0.0, 0.0, 0.0)
    g_max, age = float(task.plant.g_max), module.PERIOD + module.LATENCY
    v, held_input = 0.2, 0.0
    for _ in range(100):  # the largest g and the oldest sample: an input holds for one period and one delay
        before, v = v, v + g_max * age * held_input
        held_input = -brake * before
        assert 0 <= v <= 0.2
    assert v < 1e-3


@pytest.mark.parametrize(
    ("angle", "near", "unwrapped"), [(3.0, -3.0, 3.0 - 2 * np.pi), (-3.1, 6.0, 2 * np.pi - 3.1), (0.1, 0.0, 0.1)]
)
def test_a_heading_is_unwrapped_to_the_turn_nearest_to_the_last_one(angle: float, near: float, unwrapped: float) -> None:
    assert drive_module("crawler").unwrapped(angle, near) == pytest.approx(unwrapped, abs=1e-14)


@pytest.mark.parametrize(
    ("name", "outside"),
    [("crawler", "return"), ("base", "return"), ("watchman", "return"), ("omni_s2", "hold"), ("omni_s2", "stop")],
)
def test_the_package_builds_and_calls_the_c(name: str, outside: str, tmp_path, tool) -> None:
    tool("cc")
    controller = ros_task_controller(name, outside)
    write_files(tmp_path, ros2_package(controller))
    package = f"{name}_ros2"
    build_result = subprocess.run(
        [sys.executable, "setup.py", "-q", "build_ext", "--inplace"],
        cwd=tmp_path / package,
        capture_output=True,
        text=True,
        check=False,
    )
    assert build_result.returncode == 0, build_result.stderr
    for text in (tmp_path / package / package).glob("*.py"):
        compile(text.read_text(), text.name, "exec")
    compile((tmp_path / package / "launch" / f"{name}.launch.py").read_text(), "launch", "exec")
    assert ET.parse(tmp_path / package / "package.xml").findtext("name") == package
    parameters = yaml.safe_load((tmp_path / package / "config" / f"{name}.yaml").read_text())[name]["ros__parameters"]
    node = (tmp_path / package / package / "node.py").read_text()
    assert all(f'"{key}": ' in node for key in parameters)
    state, command, axes = message_kinds(controller.task)
    assert (parameters["state"], parameters["command"]) == (state, command)
    assert len(axes) == controller.task.dimension
    sys.path.insert(0, str(tmp_path / package))
    try:
        from importlib import import_module

        ros_controller = import_module(f"{package}.controller").Controller()
    finally:
        sys.path.pop(0)
        sys.modules.pop(package, None)
    c, task = CompiledC(controller), controller.task
    n, dice = task.dimension, np.random.default_rng(2)
    for t in np.linspace(0, float(task.prescribed_time), 9)[:-1].astype(np.float32):
        low, high = (a[0] for a in c.tube(t[None]))
        x = (low + dice.uniform(0.3, 0.7, n) * (high - low)).astype(np.float32)
        v = np.zeros(n, np.float32)
        status, u, margin = ros_controller(float(t), x.tolist(), v.tolist())
        arguments = [t[None], x[None], *([v[None]] if task.order == 2 else [])]
        expected = c.control(*arguments)
        assert (status, u) == (int(expected[0][0]), tuple(float(value) for value in expected[1][0]))
        assert margin == float(c.margin(*arguments)[0])


def test_lateness_is_logged_once_a_mission_with_its_figures(drive) -> None:
    """Mission time follows the clock, not the number of states: after a gap it continues at the time of the clock."""
    module = drive_module("crawler")
    assert drive.new_doubts() == []
    for _ in range(2):
        drive.stop("asked to")
        drive.measured(drive.seen or 0.0, START)
        begin = drive.seen
        assert drive.start(begin) == ""
        drive.decide(begin)
        drive.measured(begin + 0.99 * module.PERIOD, START)
        assert drive.new_doubts() == []
        assert drive.measured(begin + 0.99 * module.PERIOD + 0.0123, START).t == pytest.approx(0.99 * module.PERIOD + 0.0123)
        (line,) = drive.new_doubts()
        message = (
            "not proved from now on: states were too far apart; states were up to 0.0123 s apart and up to 0 s old when acted on"
        )
        assert line == f"{message}; proved are {module.PERIOD:g} s and {module.LATENCY:g} s"
        assert drive.measured(begin + 0.06, START).t == pytest.approx(0.06)
        assert drive.new_doubts() == []


def test_names_of_axes_choose_the_topics() -> None:
    task = load_task(TASKS / "omni_s2.toml")
    assert message_kinds(task)[:2] == ("array", "array")
    assert message_kinds(task.changed(axes=["x", "y"])) == ("odometry", "twist", ["x", "y"])
    assert message_kinds(load_task(TASKS / "base.toml"))[:2] == ("odometry", "accel")
    assert message_kinds(task.changed(axes=["x", "heading"])) == ("odometry", "twist", ["x", "yaw"])
    assert message_kinds(task.changed(axes=["shoulder", "elbow"])) == ("joints", "array", ["shoulder", "elbow"])
    assert message_kinds(task.changed(axes=["yaw", "heading"]))[0] == "joints"  # both would be the yaw of the odometry


def test_a_package_of_an_adaptive_tube_is_refused_and_the_command_writes_a_refined_one(tmp_path) -> None:
    with pytest.raises(BadInput, match="--package ros2: is for refined tubes"):
        ros2_package(build_once(load_task(TASKS / "omni_s2.toml").with_options("adaptive")))
    result = CliRunner().invoke(app, ["generate", str(TASKS / "crawler.toml"), "--package", "ros2", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    files = {p.relative_to(tmp_path).as_posix(): p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    assert files == ros2_package(ros_task_controller("crawler"))


PYTHON = ROOT / "build" / "ros" / "bin" / "python"  # `make ros`


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rate", "clock"),
    [("crawler", 1000, None), ("base", 60, None), ("base", 60, 4), ("arm", 250, None), ("watchman", 50, None)],
)
def test_the_node_arrives_and_stops_with_ros(name: str, rate: int, clock: int | None, tmp_path) -> None:
    """The node runs in one process and a plant in another, with arrays, an odometry that turns and joints, by the system's clock or a simulated one."""
    if not PYTHON.exists():
        pytest.skip("ROS 2 is not installed: make ros")
    write_files(tmp_path, ros2_package(ros_task_controller(name)))
    install = [str(PYTHON), "-m", "pip", "install", "-q", "--no-build-isolation", "--no-deps", "--target", str(tmp_path / "site")]
    subprocess.run([*install, str(tmp_path / f"{name}_ros2")], check=True)
    run = [str(PYTHON), str(ROOT / "benchmarks" / "ros.py"), str(tmp_path / "site"), name, str(rate)]
    run += ["--clock", str(clock)] if clock else []
    result = subprocess.run(run, capture_output=True, text=True, check=False, timeout=240)
    assert result.returncode == 0, result.stderr
    report = json.loads(result.stdout.strip().splitlines()[-1])
    task = ros_task_controller(name).task
    zeros = [0.0] * task.dimension
    assert report["before"]["commands"] == 0  # whoever drives it to the start is not disturbed
    assert report["refused"].startswith("x[0] is ")
    assert (report["started"], report["again"]) == ("started", "it drives: stop it first")
    assert report["outside"] == 0
    if task.target_set is not None:
        ends = zip(task.target_set.lower, report["arrived"]["x"], task.target_set.upper, strict=True)
        assert all(float(a) <= v <= float(b) for a, v, b in ends)
    assert report["no number"]["message"].startswith("stopped: a number of the state is not finite")
    assert report["no state"]["message"] == "stopped: there is no fresh state"
    assert report["no state"]["u"] == zeros
    for name_ in ("a number", "a state"):  # it continues, and reports that this is not proved
        assert (report[name_]["proved"], report[name_]["status"] in ("0", "1")) == ("no", True)
    if clock:
        assert report["leap"]["message"].startswith("stopped: the clock jumped by -")
    else:
        assert report["stop"] == "stopped"
        assert report["stopped"]["message"].startswith("stopped: asked to; start ")
        assert max(map(abs, report["v"])) < 1e-2  # it is at rest: a plant of order 2 was braked
    assert report["ended"] == {"u": zeros, "code": 0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parameter", "message"),
    [
        ("period:=0.05", "period: is 0.05 s; proved is at most 0.02 s"),
        ("period:=true", "period: is True; give a number"),
        ("stale_after:=-1", "stale_after: is -1; give at least the period, 0.02"),
        ("command:=twist", "command: is 'twist'; with u an acceleration it is one of accel, array"),
        ("state:=7", "state: is 7; give a str"),
    ],
)
def test_an_invalid_parameter_is_refused_in_one_line(parameter: str, message: str, tmp_path) -> None:
    if not PYTHON.exists():
        pytest.skip("ROS 2 is not installed: make ros")
    write_files(tmp_path, ros2_package(ros_task_controller("base")))
    run = [str(PYTHON), "-c", "from base_ros2.node import main; raise SystemExit(main())", "--ros-args", "-p", parameter]
    result = subprocess.run(run, cwd=tmp_path / "base_ros2", capture_output=True, text=True, check=False, timeout=60)
    assert (result.returncode, result.stderr) == (2, f"base: {message}\n")
