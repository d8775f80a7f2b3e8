"""The package of ROS 2: when it drives and when it stops, the C's bits, a package that builds; and with ROS, a plant that arrives."""

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
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.record.files import write_files
from stt_codegen.record.ros2 import message_kinds, ros2_package
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT, built

TASKS = ROOT / "tasks"
INSIDE, OUTSIDE, BAD = 0, 1, 2


def parameters_of(name: str) -> dict[str, Any]:
    return yaml.safe_load(ros2_package(made(name))[f"{name}_ros2/config/{name}.yaml"])[name]["ros__parameters"]


@cache
def made(name: str, outside: str = "return") -> EmittedController:
    task = load_task(TASKS / f"{'base' if name == 'moving' else name}.toml")
    if name == "moving":  # starts that are not at rest alone
        task = task.changed(name="moving", initial_set={"speed": Fraction(1, 50)})
    return built(task if outside == "return" else task.changed(control={"outside": outside}))


@cache
def drive_module(name: str, outside: str = "return") -> ModuleType:
    sys.modules["drive"] = module = ModuleType("drive")  # dataclasses look their module up
    exec(ros2_package(made(name, outside))[f"{name}_ros2/{name}_ros2/drive.py"], module.__dict__)
    return module


class Scripted:
    """A controller that says what it is told to; every start makes another."""

    def __init__(self) -> None:
        self.calls: list[tuple[float, tuple[float, ...]]] = []
        self.says = INSIDE
        self.starts = 0

    def make(self):
        self.starts += 1

        def control(t, x, v):
            self.calls.append((t, x))
            return self.says, (1.0, -1.0), 0.25

        return control


START = (0.5, 0.5)


@pytest.fixture
def scripted() -> Scripted:
    return Scripted()


@pytest.fixture
def drive(scripted: Scripted):
    """The crawler's: a state each 5 ms at most is proved, acted on at once; none for 50 ms is none."""
    return drive_module("crawler").Drive(scripted.make, stale_after=0.05, leap=0.5)


@pytest.fixture
def running(drive):
    drive.measured(0.0, START)
    assert drive.start(0.0) == ""
    assert drive.decide(0.0).u == (1.0, -1.0)
    return drive


def test_nothing_is_sent_before_a_start_and_none_starts_without_a_fresh_state(drive, scripted) -> None:
    assert (drive.watch(1.0).u, drive.watch(1.0).message) == (None, "waits to be started")
    assert drive.start(1.0) == "there is no fresh state to start from"
    assert drive.measured(1.0, START).u is None  # who drives it to the start is not disturbed
    assert drive.start(1.06) == "there is no fresh state to start from"
    assert drive.start(0.9) == "there is no fresh state to start from"  # of a clock that went back
    assert scripted.calls == []
    drive.measured(1.01, START)
    assert drive.start(1.03) == ""
    assert drive.decide(1.03).u == (1.0, -1.0)
    assert scripted.calls == [(0.0, START)]


def test_a_state_is_acted_on_when_it_comes(running, scripted) -> None:
    told = running.measured(0.004, (0.51, 0.5))
    assert (told.u, told.level, told.message) == ((1.0, -1.0), 0, "inside the tube")
    assert scripted.calls[-1] == (0.004, (0.51, 0.5))
    assert running.watch(0.005) is None  # nothing more to send
    assert running.measured(0.0055, START, delay=0.003).u is None  # older than the last
    assert len(scripted.calls) == 2


def test_who_drives_is_not_started_again(running, scripted) -> None:
    running.measured(0.004, START)
    assert running.start(0.004) == "it drives: stop it first"
    running.measured(0.008, START)
    assert scripted.calls[-1][0] == 0.008  # the mission's time goes on
    running.stop("asked to")
    assert running.start(0.009) == ""
    assert scripted.starts == 2


@pytest.mark.parametrize("name", ["crawler", "base", "arm", "drone", "moving"])
def test_it_starts_from_the_proofs_starts_alone(name: str, scripted) -> None:
    """Those of the certificate: the share of gamma(0), at rest; less what a measurement may be wrong by."""
    module, controller = drive_module(name), made(name)
    task = controller.task
    noise, share = float(task.plant.noise or 0), float(task.initial_set.share)
    speeds = [float(v) for v in task.start_speed] if task.order == 2 else []
    middle = [float(a + b) / 2 for a, b in controller.certificate.start]
    for k, (low, high) in enumerate(controller.certificate.start):
        for side in (-1, 1):
            edge = middle[k] + side * (share * float(high - low) / 2 - noise)
            for x, good in ((edge - side * 1e-9, True), (edge + side * 1e-9, False)):
                drive = module.Drive(scripted.make, 1.0, 1.0)
                drive.measured(0.0, [*middle[:k], x, *middle[k + 1 :]], [0.0] * len(speeds))
                assert (drive.start(0.0) == "") == good
                assert good or drive.start(0.0).startswith(f"x[{k}] is ")
    noise_v = float(task.plant.noise_v or 0)
    for k, most in enumerate(speeds):
        shown = most - noise_v if most else noise_v  # a robot that stands may show noise_v; one that moves may hide it
        for size, good in ((shown, True), (shown * 1.0001 + 1e-9, False)):
            drive = module.Drive(scripted.make, 1.0, 1.0)
            drive.measured(0.0, middle, [-size if i == k else 0.0 for i in range(len(speeds))])
            assert (drive.start(0.0) == "") == good
            assert good or drive.start(0.0).startswith(f"v[{k}] is ")
    assert bool(module.ASSUMED) == (not any(speeds))


def test_the_first_state_of_a_robot_that_moves_is_not_older_than_the_latency(scripted) -> None:
    for name, doubtful in (("base", False), ("moving", True)):
        module = drive_module(name)
        drive = module.Drive(scripted.make, 1.0, 1.0)
        drive.measured(0.0, [float(a + b) / 2 for a, b in made(name).certificate.start], [0.0] * 3)
        assert drive.start(0.0) == ""
        drive.decide(module.LATENCY + 0.001)
        assert bool(drive.doubts) == doubtful


def test_a_state_that_is_too_old_stops_it_until_there_is_another(running, scripted) -> None:
    said = [running.watch(0.01 * k) for k in range(1, 9)]
    assert [d and d.u for d in said] == [None] * 5 + [(0.0, 0.0)] * 3
    assert {(d.level, d.message) for d in said[5:]} == {(2, "stopped: there is no fresh state")}
    assert running.measured(0.085, (0.7, 0.4), delay=0.06).u == (0.0, 0.0)  # one that was long on its way is none
    late = running.measured(0.09, (0.7, 0.4))
    assert (late.u, late.level) == ((1.0, -1.0), 1)
    assert late.message.startswith("inside the tube; not proved: states were too far apart")
    assert scripted.calls[-1] == (0.09, (0.7, 0.4))  # mission time went on


def test_what_the_proof_is_not_of_is_said_until_the_next_start(running) -> None:
    module = drive_module("crawler")
    assert running.measured(module.PERIOD, START).level == 0  # as far apart as is proved
    told = running.measured(0.0101, START)
    assert (told.level, told.message) == (1, "inside the tube; not proved: states were too far apart")
    assert running.measured(0.012, START).level == 1
    assert running.apart == pytest.approx(0.0051)
    running.stop("asked to")
    running.start(0.012)
    running.decide(0.012)
    assert running.measured(0.014, START).level == 0
    told = running.measured(0.016, START, delay=0.0001)
    assert told.message == "inside the tube; not proved: a state was old when it was acted on"
    assert running.old == pytest.approx(0.0001)
    assert made("crawler").task.control.latency == module.LATENCY == 0


def test_what_has_no_proved_period_never_says_that_it_is_proved(scripted) -> None:
    module = drive_module("omni_s2")
    assert made("omni_s2").certificate.proved_period is None
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
def test_what_the_controller_says_is_what_is_told(scripted, outside: str) -> None:
    name = "crawler" if outside == "return" else "omni_s2"
    module = drive_module(name, outside)
    drive = module.Drive(scripted.make, 1.0, 1.0)
    x = [sum(ends) / 2 for ends in module.STARTS]
    drive.measured(0.0, x)
    drive.start(0.0)
    scripted.says = BAD
    bad = drive.measured(0.001, x)
    assert (bad.u, bad.level, bad.message) == ((0.0, 0.0), 2, "stopped: a number of the state is not finite")
    scripted.says = OUTSIDE
    told = drive.measured(0.002, x)
    assert (told.level, told.status, told.margin) == (2, 1, 0.25)
    if outside == "return":
        assert (told.u, told.message) == ((1.0, -1.0), "outside the tube: nothing is shown")
    else:
        assert (told.u, told.message) == ((0.0, 0.0), "stopped: it was outside the tube")
    scripted.says = INSIDE
    assert drive.measured(0.003, x).level == 1  # and is proved no more
    drive.stop("asked to")
    assert drive.watch(0.004).message == "stopped: asked to; start anew"


def test_where_u_is_an_acceleration_to_stop_is_to_brake(scripted) -> None:
    """Zeros would let it glide on: against a fresh v within the limits, and for every g of the plant without turning v back."""
    module, task = drive_module("base"), made("base").task
    brake = parameters_of("base")["brake"]
    drive = module.Drive(scripted.make, 0.05, 1.0, brake)
    x = [sum(ends) / 2 for ends in module.STARTS]
    drive.measured(0.0, x, (0.0, 0.0, 0.0))
    drive.start(0.0)
    drive.stop("asked to")
    told = drive.measured(0.01, x, (0.1, -2.0, 0.0))
    assert told.u == pytest.approx((-0.1 * brake, float(task.u_max[1]), 0.0))
    assert drive.watch(0.02).u == told.u
    assert drive.watch(0.2).u == (0.0, 0.0, 0.0)  # nothing is known of v
    assert drive.measured(0.21, x, (float("nan"), 1.0, 0.0)).u == (0.0, 0.0, 0.0)
    g_max, age = float(task.plant.g_max), module.PERIOD + module.LATENCY
    v, held = 0.2, 0.0
    for _ in range(100):  # the worst g, the oldest sample: held by one period and one delay
        before, v = v, v + g_max * age * held
        held = -brake * before
        assert 0 <= v <= 0.2
    assert v < 1e-3


@pytest.mark.parametrize(
    ("angle", "near", "found"), [(3.0, -3.0, 3.0 - 2 * np.pi), (-3.1, 6.0, 2 * np.pi - 3.1), (0.1, 0.0, 0.1)]
)
def test_a_heading_knows_whole_turns(angle: float, near: float, found: float) -> None:
    assert drive_module("crawler").unwrapped(angle, near) == pytest.approx(found, abs=1e-14)


@pytest.mark.parametrize(
    ("name", "outside"),
    [("crawler", "return"), ("base", "return"), ("watchman", "return"), ("omni_s2", "hold"), ("omni_s2", "stop")],
)
def test_the_package_builds_and_calls_the_c(name: str, outside: str, tmp_path, tool) -> None:
    tool("cc")
    controller = made(name, outside)
    write_files(tmp_path, ros2_package(controller))
    package = f"{name}_ros2"
    built = subprocess.run(
        [sys.executable, "setup.py", "-q", "build_ext", "--inplace"],
        cwd=tmp_path / package,
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
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

        own = import_module(f"{package}.controller").Controller()
    finally:
        sys.path.pop(0)
        sys.modules.pop(package, None)
    c, task = CompiledC(controller), controller.task
    n, dice = task.dimension, np.random.default_rng(2)
    for t in np.linspace(0, float(task.prescribed_time), 9)[:-1].astype(np.float32):
        low, high = (a[0] for a in c.tube(t[None]))
        x = (low + dice.uniform(0.3, 0.7, n) * (high - low)).astype(np.float32)
        v = np.zeros(n, np.float32)
        status, u, margin = own(float(t), x.tolist(), v.tolist())
        given = [t[None], x[None], *([v[None]] if task.order == 2 else [])]
        wanted = c.control(*given)
        assert (status, u) == (int(wanted[0][0]), tuple(float(value) for value in wanted[1][0]))
        assert margin == float(c.margin(*given)[0])


def test_what_is_late_is_logged_once_a_mission_with_its_figures(drive) -> None:
    """Time is the clock's, whatever the number of states: after a gap the mission is where the clock is."""
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
        told = (
            "not proved from now on: states were too far apart; states were up to 0.0123 s apart and up to 0 s old when acted on"
        )
        assert line == f"{told}; proved are {module.PERIOD:g} s and {module.LATENCY:g} s"
        assert drive.measured(begin + 0.06, START).t == pytest.approx(0.06)
        assert drive.new_doubts() == []


def test_axes_say_what_is_listened_to() -> None:
    task = load_task(TASKS / "omni_s2.toml")
    assert message_kinds(task)[:2] == ("array", "array")
    assert message_kinds(task.changed(axes=["x", "y"])) == ("odometry", "twist", ["x", "y"])
    assert message_kinds(load_task(TASKS / "base.toml"))[:2] == ("odometry", "accel")
    assert message_kinds(task.changed(axes=["x", "heading"])) == ("odometry", "twist", ["x", "yaw"])
    assert message_kinds(task.changed(axes=["shoulder", "elbow"])) == ("joints", "array", ["shoulder", "elbow"])
    assert message_kinds(task.changed(axes=["yaw", "heading"]))[0] == "joints"  # not the same twice


def test_what_has_no_package_is_refused_and_the_command_writes_the_others(tmp_path) -> None:
    with pytest.raises(BadInput, match="--package ros2: is for refined tubes"):
        ros2_package(built(load_task(TASKS / "omni_s2.toml").with_options("adaptive")))
    result = CliRunner().invoke(app, ["generate", str(TASKS / "crawler.toml"), "--package", "ros2", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    files = {p.relative_to(tmp_path).as_posix(): p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    assert files == ros2_package(made("crawler"))


PYTHON = ROOT / "build" / "ros" / "bin" / "python"  # `make ros`


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rate", "clock"),
    [("crawler", 1000, None), ("base", 60, None), ("base", 60, 4), ("arm", 250, None), ("watchman", 50, None)],
)
def test_the_node_arrives_and_stops_with_ros(name: str, rate: int, clock: int | None, tmp_path) -> None:
    """The real node in a process of its own beside a plant's: arrays, an odometry that turns, joints; our clock or a simulation's."""
    if not PYTHON.exists():
        pytest.skip("ROS 2 is not installed: make ros")
    write_files(tmp_path, ros2_package(made(name)))
    install = [str(PYTHON), "-m", "pip", "install", "-q", "--no-build-isolation", "--no-deps", "--target", str(tmp_path / "site")]
    subprocess.run([*install, str(tmp_path / f"{name}_ros2")], check=True)
    run = [str(PYTHON), str(ROOT / "benchmarks" / "ros.py"), str(tmp_path / "site"), name, str(rate)]
    run += ["--clock", str(clock)] if clock else []
    result = subprocess.run(run, capture_output=True, text=True, check=False, timeout=240)
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout.strip().splitlines()[-1])
    task = made(name).task
    zeros = [0.0] * task.dimension
    assert found["before"]["commands"] == 0  # who drives it to the start is not disturbed
    assert found["refused"].startswith("x[0] is ")
    assert (found["started"], found["again"]) == ("started", "it drives: stop it first")
    assert found["outside"] == 0
    if task.target_set is not None:
        ends = zip(task.target_set.lower, found["arrived"]["x"], task.target_set.upper, strict=True)
        assert all(float(a) <= v <= float(b) for a, v, b in ends)
    assert found["no number"]["message"].startswith("stopped: a number of the state is not finite")
    assert found["no state"]["message"] == "stopped: there is no fresh state"
    assert found["no state"]["u"] == zeros
    for name_ in ("a number", "a state"):  # it goes on, and says that the proof is not of this
        assert (found[name_]["proved"], found[name_]["status"] in ("0", "1")) == ("no", True)
    if clock:
        assert found["leap"]["message"].startswith("stopped: the clock jumped by -")
    else:
        assert (found["stop"], found["stopped"]["message"]) == ("stopped", "stopped: asked to; start anew")
        assert max(map(abs, found["v"])) < 1e-2  # it stands: of order 2 it was braked
    assert found["ended"] == {"u": zeros, "code": 0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("period:=0.05", "period: is 0.05 s; proved is at most 0.02 s"),
        ("period:=true", "period: is True; give a number"),
        ("stale_after:=-1", "stale_after: is -1; give at least the period, 0.02"),
        ("command:=twist", "command: is 'twist'; with u an acceleration it is one of accel, array"),
        ("state:=7", "state: is 7; give a str"),
    ],
)
def test_a_parameter_that_is_none_is_told_in_one_line(given: str, told: str, tmp_path) -> None:
    if not PYTHON.exists():
        pytest.skip("ROS 2 is not installed: make ros")
    write_files(tmp_path, ros2_package(made("base")))
    run = [str(PYTHON), "-c", "from base_ros2.node import main; raise SystemExit(main())", "--ros-args", "-p", given]
    result = subprocess.run(run, cwd=tmp_path / "base_ros2", capture_output=True, text=True, check=False, timeout=60)
    assert (result.returncode, result.stderr) == (2, f"base: {told}\n")
