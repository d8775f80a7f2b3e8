"""The package of ROS 2: when it drives and when it stops, the C's bits, a package that builds; and with ROS, a plant that arrives."""

from __future__ import annotations

import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from functools import cache
from types import ModuleType

import numpy as np
import pytest
import yaml
from conftest import ROOT
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.compare.backends import CompiledC
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller, build_task
from stt_codegen.record.files import write_files
from stt_codegen.record.ros2 import ros2_package, sources_of
from stt_codegen.task import load_task

TASKS = ROOT / "tasks"
INSIDE, OUTSIDE, BAD = 0, 1, 2


@cache
def made(name: str, outside: str = "return") -> Controller:
    task = load_task(TASKS / f"{name}.toml")
    return build_task(task if outside == "return" else task.changed(control={"outside": outside}))


def drive_module() -> ModuleType:
    sys.modules["drive"] = module = ModuleType("drive")  # dataclasses look their module up
    exec(ros2_package(made("crawler"))["crawler_ros2/crawler_ros2/drive.py"], module.__dict__)
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


@pytest.fixture
def scripted() -> Scripted:
    return Scripted()


@pytest.fixture
def drive(scripted: Scripted):
    return drive_module().Drive(scripted.make, period=0.01, stale_after=0.05, leap=0.5)


def test_nothing_moves_before_a_start_and_none_starts_without_a_fresh_state(drive, scripted) -> None:
    assert (drive.tick(1.0).u, drive.tick(1.0).message) == ((0.0, 0.0), "waits to be started")
    assert not drive.start(1.0)
    drive.measured(1.0, (0.1, 0.2))
    assert not drive.start(1.06)
    assert not drive.start(0.9)  # of a clock that went back
    assert scripted.calls == []
    assert drive.start(1.03)
    assert drive.tick(1.04).u == (1.0, -1.0)
    assert scripted.calls == [(pytest.approx(0.01), (0.1, 0.2))]


def test_a_state_that_is_too_old_stops_it_until_there_is_another(drive, scripted) -> None:
    drive.measured(0.0, (0.1, 0.2))
    drive.start(0.0)
    said = [drive.tick(0.01 * k) for k in range(1, 9)]
    assert [d.u == (0.0, 0.0) for d in said] == [False] * 5 + [True] * 3
    assert said[-1].level == 2
    assert said[-1].message == "stopped: the last state is 0.080 s old"
    drive.measured(0.085, (0.3, 0.4))
    assert drive.tick(0.09).u == (1.0, -1.0)
    assert scripted.calls[-1] == (pytest.approx(0.09), (0.3, 0.4))  # mission time went on


@pytest.mark.parametrize("jump", [-0.001, 0.6, 3600.0])
def test_a_clock_that_jumps_stops_it_until_the_next_start(drive, scripted, jump: float) -> None:
    drive.measured(10.0, (0.1, 0.2))
    drive.start(10.0)
    assert drive.tick(10.01).level == 0
    stopped = drive.tick(10.01 + jump)
    assert (stopped.u, stopped.level) == ((0.0, 0.0), 2)
    assert f"the clock jumped by {jump:.3f} s" in stopped.message
    now = 10.02 + jump
    drive.measured(now, (0.1, 0.2))
    assert drive.tick(now).message == stopped.message
    assert drive.start(now)
    assert scripted.starts == 2
    assert drive.tick(now + 0.01).u == (1.0, -1.0)


def test_what_the_controller_says_is_what_is_told(drive, scripted) -> None:
    drive.measured(0.0, (0.1, 0.2))
    drive.start(0.0)
    scripted.says = BAD
    assert (drive.tick(0.01).u, drive.tick(0.01).level) == ((0.0, 0.0), 2)
    scripted.says = OUTSIDE
    outside = drive.tick(0.02)
    assert (outside.u, outside.level, outside.message) == ((1.0, -1.0), 2, "outside the tube: nothing is shown")
    scripted.says = INSIDE
    assert (drive.tick(0.03).level, drive.late) == (0, 0)
    assert (drive.tick(0.046).level, drive.late) == (1, 1)  # more than half a period late
    drive.stop("asked to")
    assert drive.tick(0.05).message == "stopped: asked to; start anew"


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
    assert all(f'("{key}"' in node for key in parameters)
    state, command, axes = sources_of(controller.task)
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


def test_axes_say_what_is_listened_to() -> None:
    task = load_task(TASKS / "omni_s2.toml")
    assert sources_of(task)[:2] == ("array", "array")
    assert sources_of(task.changed(axes=["x", "y"])) == ("odometry", "twist", ["x", "y"])
    assert sources_of(task.changed(axes=["x", "heading"])) == ("odometry", "twist", ["x", "yaw"])
    assert sources_of(task.changed(axes=["shoulder", "elbow"])) == ("joints", "array", ["shoulder", "elbow"])
    assert sources_of(task.changed(axes=["yaw", "heading"]))[0] == "joints"  # not the same twice


def test_what_has_no_package_is_refused_and_the_command_writes_the_others(tmp_path) -> None:
    with pytest.raises(BadInput, match="--package ros2: is for refined tubes"):
        ros2_package(build_task(load_task(TASKS / "omni_s2.toml").with_options("adaptive")))
    result = CliRunner().invoke(app, ["generate", str(TASKS / "crawler.toml"), "--package", "ros2", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    files = {p.relative_to(tmp_path).as_posix(): p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    assert files == ros2_package(made("crawler"))


PYTHON = ROOT / "build" / "ros" / "bin" / "python"  # `make ros`


@pytest.mark.slow
@pytest.mark.parametrize(("period", "stale_after"), [(0.001, 0.05), (0.005, 0.05)])
def test_the_node_arrives_and_stops_with_ros(period: float, stale_after: float, tmp_path) -> None:
    """The real node in a process of its own beside a plant's: at the target at t_c; zeros once no state comes."""
    if not PYTHON.exists():
        pytest.skip("ROS 2 is not installed: make ros")
    write_files(tmp_path, ros2_package(made("crawler")))
    installed = [
        str(PYTHON),
        "-m",
        "pip",
        "install",
        "-q",
        "--no-build-isolation",
        "--no-deps",
        "--target",
        str(tmp_path / "site"),
    ]
    subprocess.run([*installed, str(tmp_path / "crawler_ros2")], check=True)
    result = subprocess.run(
        [str(PYTHON), str(ROOT / "benchmarks" / "ros.py"), str(tmp_path / "site"), str(period), str(stale_after)],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout.strip().splitlines()[-1])
    task = made("crawler").task
    assert task.target_set is not None
    assert all(
        float(a) <= v <= float(b) for a, v, b in zip(task.target_set.lower, found["x"], task.target_set.upper, strict=True)
    )
    assert found["before"] == [0.0, 0.0]  # nothing moves before the start
    assert found["after"] == [0.0, 0.0]  # nor when the plant is silent
    assert found["outside"] == 0
    assert "the last state is" in found["message"]
