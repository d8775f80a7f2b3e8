"""Axes that close, such as an angle: the turn of the target, the images of unsafe sets at every turn, and the C that counts turns."""

from __future__ import annotations

import ctypes
import dataclasses
import hashlib
import io
import json
import math
import pickle
import re
import subprocess
import sys
import types
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stt_codegen as stt
from stt_codegen.certify.sampled.lost_turns import lost_turn
from stt_codegen.certify.sampled.period import certify_period
from stt_codegen.checker import check_files
from stt_codegen.checker.stt_checker import turns as checked_turns
from stt_codegen.cli.show import show_design
from stt_codegen.errors import BadInput
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.plants import plant_of
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.record.package import package
from stt_codegen.report.closed_axis_notes import turn_notes
from stt_codegen.report.figures.design_figures import design_report
from stt_codegen.task import closed_axes as turns
from stt_codegen.task import task as task_module
from stt_codegen.task.closed_axes import TWO_PI, drift_of
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task
from stt_codegen.theorem.text import theorem_text
from tests.support.command_line import run_command
from tests.support.controllers import ROOT, build_once

TURN = "6.283185307179586"
TURNER = """name = "turner"
axes = ["x", "yaw"]
units = ["m", "rad"]
periodic = { yaw = 6.283 }
prescribed_time = 10
initial_state = [0.5, 15.5]

[state_space]
lower = [0, -3.1416]
upper = [5, 3.2584]

[initial_set]
lower = [0.3, 15.3]
upper = [0.7, 15.7]

[target_set]
lower = [4.0, -2.9]
upper = [4.7, -2.4]

[[unsafe]]
name = "wall"
lower = [1.0, 2.6]
upper = [2.0, 3.4]

[[unsafe]]
name = "disc"
centre = [3.0, -2.0]
radius = 0.3

[control]
period = 0.01

[plant]
noise = 0.001
w_max = 0.1
"""
SLOPES = TURNER + '\n[[unsafe]]\nname = "slope"\nnormals = [[1, 1], [-1, 0], [0, -1], [0, 1]]\noffsets = [2.0, -1.5, 1.0, 0.0]\n'


def with_period(text: str, value: str) -> str:
    return text.replace("yaw = 6.283 }", f"yaw = {value} }}")


@cache
def turner_controller(text: str = TURNER) -> EmittedController:
    return build_once(parse_task(text))


def checker_exit_code(controller: EmittedController, text: str, folder: Path) -> int:
    """Return the exit code of the stand-alone checker for the text of a task with turns, which the checker expands by itself."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    (folder / "task.toml").write_text(text)
    p = controller.task.name
    return check_files([str(folder / "task.toml"), str(folder / f"{p}.c"), str(folder / f"{p}.certificate.json")])


def box_task(**changes: Any) -> dict[str, Any]:
    """Return the fields of a task in the plane of x and an angle; a change to None leaves a field out."""
    fields: dict[str, Any] = {
        "name": "arm",
        "axes": ["x", "yaw"],
        "periodic": {"yaw": 2 * math.pi},
        "prescribed_time": 6,
        "initial_state": [0.5, 3.0],
        "state_space": {"lower": [0, -3.2], "upper": [5, 3.2]},
        "initial_set": {"lower": [0.3, 2.9], "upper": [0.7, 3.1]},
        "target_set": {"lower": [4.0, -3.1], "upper": [4.4, -2.9]},
    }
    return {name: value for name, value in {**fields, **changes}.items() if value is not None}


# --------------------------------------------------------------------------------------------------- the turn of the target


@pytest.mark.parametrize(
    ("start", "target", "turns"), [(3.0, -3.0, 1), (-3.0, 3.0, -1), (0.0, 3.0, 0), (12.0, 0.0, 2), (-9.0, 3.0, -2)]
)
def test_the_target_is_the_image_that_is_nearest_to_the_start(start: float, target: float, turns: int) -> None:
    """The turn is compared with the best of a hundred. The state space leaves half a turn on both sides of start and target."""
    task = Task(
        **box_task(
            initial_state=[0.5, start],
            initial_set={"lower": [0.3, f"{start - 0.1:.6f}"], "upper": [0.7, f"{start + 0.1:.6f}"]},
            target_set={"lower": [4.0, target], "upper": [4.4, target + 0.2]},
        )
    )
    (axis,) = task.closed_axes
    period = Fraction(str(2 * math.pi))
    middle = Fraction(str(target)) + Fraction(1, 10)
    assert axis.target_turns == min(range(-50, 51), key=lambda k: abs(middle + k * period - Fraction(str(start)))) == turns
    inset = abs(turns) * axis.drift  # the target is shrunk by what the period may be wrong
    assert task.target.lower[1] == Fraction(str(target)) + turns * period + inset
    assert task.target.upper[1] == Fraction(str(target)) + Fraction(1, 5) + turns * period - inset
    ends = (*(task.target.lower[1] - inset, task.target.upper[1] + inset), task.start.lower[1], task.start.upper[1])
    assert task.state_space.lower[1] == min(ends) - period / 2
    assert task.state_space.upper[1] == max(ends) + period / 2


def test_only_images_within_a_limited_state_space_count() -> None:
    limited = box_task(state_space={"lower": [0, -3.14], "upper": [5, 3.14]})
    task = Task(**limited)
    assert (task.closed_axes[0].target_turns, task.closed_axes[0].nearest_turns) == (0, 1)
    assert task.state_space.upper[1] == Fraction("3.14")
    (note,) = turn_notes(task)
    assert "as it stands" in note
    assert "3.28319, is not in the state space" in note
    wide = Task(**box_task(state_space={"lower": [0, 2], "upper": [5, 4]}))
    assert (wide.closed_axes[0].target_turns, wide.state_space.lower[1], wide.state_space.upper[1]) == (1, 2, 4)
    with pytest.raises(BadInput, match=r"target_set: none of its images in yaw, every 6.28318531, lies in the state space"):
        Task(**box_task(state_space={"lower": [0, 2], "upper": [5, 3.2]}))


def test_a_task_in_python_equals_that_of_a_file_and_stays_as_it_was_stated() -> None:
    """Digest, images, pickling, a second validation and `changed` all start from the stated task, not from the expanded one."""
    task = parse_task(TURNER)
    task_in_python = Task(
        name="turner", axes=["x", "yaw"], units=["m", "rad"], periodic={"yaw": 6.283}, prescribed_time=10, initial_state=[0.5, 15.5],
        state_space={"lower": [0, -3.1416], "upper": [5, 3.2584]}, initial_set={"lower": [0.3, 15.3], "upper": [0.7, 15.7]},
        target_set={"lower": [4.0, -2.9], "upper": [4.7, -2.4]}, control={"period": 0.01}, plant={"noise": 0.001, "w_max": 0.1},
        unsafe=[
            {"name": "wall", "lower": [1.0, 2.6], "upper": [2.0, 3.4]}, {"name": "disc", "centre": [3.0, -2.0], "radius": 0.3}
        ],
    )  # fmt: skip
    assert task_in_python == task
    assert task_in_python.digest == task.digest
    assert [s.name for s in task.unsafe] == ["wall", "disc", "wall+2", "disc+3"]
    assert [s.name for s in task.as_stated.unsafe] == ["wall", "disc"]
    for copy in (task.changed(), Task.model_validate(task), pickle.loads(pickle.dumps(task)), task.with_options()):
        assert copy == task
    assert (
        task.changed(periodic=None, initial_state=[0.5, 1], initial_set={"lower": [0.3, 0.9], "upper": [0.7, 1.1]}).closed_axes
        == ()
    )
    assert hash(task.periodic) == hash(task_in_python.periodic)
    double = task.with_options(scalar="double")
    assert double.digest == task.digest
    assert double.plant.noise < task.plant.noise  # unwrapping rounds less


@pytest.mark.parametrize("m", range(1, 13))
def test_package_and_checker_bound_how_far_a_period_is_from_a_part_of_two_pi(m: int) -> None:
    """The package's constant and the checker's series agree; exact periods, such as 360, have no difference."""
    low, high = checked_turns.two_pi()
    assert low < TWO_PI + Fraction(1, 10**49) and TWO_PI < high < low + Fraction(1, 10**50)  # noqa: PT018
    for text in (f"{2 * math.pi / m:.15f}", f"{2 * math.pi / m:.5f}", f"{2 * math.pi / m * 1.0009:.6f}"):
        period = Fraction(text)
        drift = drift_of(period)
        assert drift == checked_turns.drift(period)
        assert abs(period - low / m) <= drift <= abs(period - low / m) + Fraction(1, 10**17)
    for text in ("360", "1", "6.4", "3.2", f"{2 * math.pi / m * 1.002:.9f}"):
        assert drift_of(Fraction(text)) == checked_turns.drift(Fraction(text)) == 0


REFUSED = {
    "no axis": ({"periodic": {"yow": 6.28}}, r"periodic\.yow: is no axis; use one of x, yaw"),
    "no table": ({"periodic": 6.28}, r"periodic: is the number 6\.28; a table of periods by axis is needed"),
    "empty": ({"periodic": {}}, r"periodic: is an empty table; a table of periods"),
    "negative": ({"periodic": {"yaw": -6.28}}, r"periodic\.yaw: is -6\.28; it must be greater than 0"),
    "text": ({"periodic": {"yaw": "two pi"}}, r"periodic\.yaw: is the text 'two pi'; a number is needed"),
    "integers": (
        {"emit": {"scalar": "fixed", "tick_period": 0.01}, "control": {"u_max": 1}},
        r"periodic: is for floating point",
    ),
    "start": (
        {"initial_set": {"lower": [0.3, -0.5], "upper": [0.7, 3.1]}, "initial_state": [0.5, 3.0]},
        r"initial_set: reaches half a turn from initial_state in yaw",
    ),
    "noise": ({"plant": {"noise": 1.6}}, r"plant\.noise: is 1\.6, and then turns of yaw cannot be distinguished"),
    "far": (
        {"initial_state": [0.5, 1000], "initial_set": {"lower": [0.3, 999.9], "upper": [0.7, 1000.1]}},
        r"initial_set: more than 100 turns would be counted in yaw",
    ),
    "half-space": (
        {"unsafe": [{"normals": [[0, 1]], "offsets": [-2]}]},
        r"unsafe\[0\]\.normals: leave the set open in yaw, which closes",
    ),
    "mixed half-space": (
        {"unsafe": [{"normals": [[1, 1], [-1, 0]], "offsets": [2, -1]}]},
        r"unsafe\[0\]\.normals: leave the set open in yaw, which closes",
    ),
    "long set": (
        {"unsafe": [{"name": "all", "lower": [1, -500], "upper": [2, 500]}]},
        r"unsafe\[0\] \(all\): has \d+ images in the state space, as it is many turns long in yaw",
    ),
    "cut space": (
        {"state_space": {"lower": [0, -3.2], "upper": [5, 3.2], "normals": [[1, 1]], "offsets": [6]}},
        r"state_space\.normals: cut yaw, which closes",
    ),
    "region": (
        {"region": [{"name": "dock", "lower": [4, 1], "upper": [5, 2]}], "mission": [{"visit": "dock"}]},
        r"region\[0\]: is in yaw, which closes, and missions know no turns; give it axes = \['x'\]",
    ),
    "name of an image": (
        {"unsafe": [{"name": "a", "lower": [1, -2.6], "upper": [2, -2.5]}, {"name": "a+1", "lower": [1, 0], "upper": [2, 0.1]}]},
        r"unsafe\[1\]\.name: 'a\+1' is what an image of a is called",
    ),
    "image at the start": (
        {"unsafe": [{"name": "a", "lower": [0, -3.3], "upper": [2, -3.1]}]},
        r"initial_set: meets unsafe\[0\] \(a\+1\); move or shrink one of them",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_fields_without_meaning_on_a_closed_axis_are_refused_by_name(case: str) -> None:
    changes, message = REFUSED[case]
    with pytest.raises(BadInput, match=message):
        Task(**box_task(**changes))


@pytest.mark.parametrize("remedy", ["half-space", "mixed half-space", "long set", "cut space", "region"])
def test_the_remedy_that_such_a_refusal_names_is_accepted(remedy: str) -> None:
    changes = {
        "half-space": {"unsafe": [{"normals": [[0, 1], [0, -1]], "offsets": [-2, 2.5]}]},
        "mixed half-space": {"unsafe": [{"normals": [[1, 1], [-1, 0], [0, -1]], "offsets": [2, -1, 1]}]},
        "long set": {"unsafe": [{"name": "all", "axes": ["x"], "lower": [1], "upper": [2]}]},
        "cut space": {"state_space": {"lower": [0, -3.2], "upper": [5, 3.0], "normals": [[1, 1]], "offsets": [6]},
                      "initial_state": [0.5, 2.8], "initial_set": {"lower": [0.3, 2.7], "upper": [0.7, 2.9]}},
        "region": {"region": [{"name": "dock", "axes": ["x"], "lower": [4], "upper": [5]}], "mission": [{"visit": "dock"}]},
    }[remedy]  # fmt: skip
    assert Task(**box_task(**changes)).closed_axes


def test_a_map_on_a_closed_axis_is_refused(tmp_path: Path) -> None:
    (tmp_path / "task.toml").write_text(TURNER + '\n[map]\nfile = "hall.yaml"\naxes = ["x", "yaw"]\n')
    with pytest.raises(BadInput, match=r"map\.axes: are x, yaw, and yaw closes"):
        stt.load(tmp_path / "task.toml")


# --------------------------------------------------------------------------------------------------- the tube at every turn


def which_are_unsafe(x: np.ndarray, yaw: np.ndarray, t: float, clearance: float, sets: Sequence[dict[str, Any]]) -> np.ndarray:
    """Return which of the wrapped states (N) are nearer than `clearance`, in the largest component, to a set of the task at t.

    Whether an angle is in a set is decided by the arc from its lower edge, so that no turn is counted.
    """
    is_unsafe = np.zeros(len(x), dtype=bool)
    for unsafe in sets:
        moved = np.zeros(2)
        if "motion" in unsafe:
            (a, b) = unsafe["motion"]
            share = min(max((t - a["at"]) / (b["at"] - a["at"]), 0.0), 1.0)
            moved = np.array(a["by"]) + share * (np.array(b["by"]) - np.array(a["by"]))
        low, high = np.array(unsafe["lower"]) + moved - clearance, np.array(unsafe["upper"]) + moved + clearance
        arc = np.mod(yaw - low[1], 2 * math.pi)
        is_unsafe |= (low[0] < x) & (x < high[0]) & (arc < high[1] - low[1]) & (arc > 0)
    return is_unsafe


def random_task_fields(seed: int, digits: int) -> dict[str, Any]:
    """Return a random task: start, target and sets at any turn, a period of `digits` decimals, and one set that moves in yaw."""
    dice = np.random.default_rng(seed)
    start, target = dice.uniform(-8, 8, 2).round(3)
    sets = [
        {"name": f"set {k}", "lower": [x, y], "upper": [x + 0.4, y + w]}
        for k, (x, y, w) in enumerate(
            zip((1.2, 2.2, 3.2), dice.uniform(-7, 7, 3).round(3), dice.uniform(0.5, 2.5, 3).round(3), strict=True)
        )
    ]
    sets[1]["motion"] = [{"at": 0.0, "by": [0.0, 0.0]}, {"at": 8.0, "by": [0.0, round(dice.uniform(-3, 3), 3)]}]
    return box_task(
        periodic={"yaw": round(2 * math.pi, digits)},
        prescribed_time=8,
        initial_state=[0.5, start],
        initial_set={"lower": [0.3, f"{start - 0.2:.6f}"], "upper": [0.7, f"{start + 0.2:.6f}"]},
        target_set={"lower": [4.0, target], "upper": [4.6, f"{target + 0.5:.6f}"]},
        unsafe=sets,
    )


@pytest.mark.parametrize(("seed", "digits"), [(1, 3), (2, 3), (3, 15)])
def test_wrapped_states_of_the_tube_avoid_all_sets_and_end_in_the_target(seed: int, digits: int) -> None:
    """States all over the certified tube, wrapped by the true 2 pi. 1e-9: doubles of angles below 30 and their remainders."""
    fields = random_task_fields(seed, digits)
    controller = build_once(Task(**fields))
    assert controller.certificate.holds
    t, dice = np.linspace(0, 8, 400), np.random.default_rng(seed)
    low, high = controller.design.edges_at(t)
    clearance = 0.03 - 1e-9
    for k, time in enumerate(t):
        shares = np.vstack([[[0, 0], [0, 1], [1, 0], [1, 1]], dice.uniform(0, 1, (40, 2))])
        x, yaw = (low[k] + shares * (high[k] - low[k])).T
        wrapped = np.mod(yaw + math.pi, 2 * math.pi) - math.pi
        assert not which_are_unsafe(x, wrapped, time, clearance, fields["unsafe"]).any()
    box = fields["target_set"]
    first, width = float(box["lower"][1]), float(box["upper"][1]) - float(box["lower"][1])
    assert np.mod(low[-1, 1] - first + 1e-9, 2 * math.pi) <= np.mod(high[-1, 1] - first + 1e-9, 2 * math.pi) <= width + 2e-9
    assert float(abs(high[:, 1] - low[0, 1]).max()) < 4 * math.pi  # never a second time around


def test_the_clearance_grows_by_the_error_of_the_period_at_every_turn() -> None:
    """The demanded clearance exceeds the stated one by the error of the farthest image. Every image is its set moved by whole
    periods, exactly. With a period that is no part of 2 pi nothing is added."""
    task = parse_task(TURNER)
    (axis,) = task.closed_axes
    assert axis.image_turns == 3
    assert task.tube.clearance - Fraction("0.03") >= 3 * abs(axis.period - TWO_PI) - Fraction(1, 10**40)
    for image in task.unsafe[2:]:
        k = int(image.name[-2:])
        source = next(s for s in task.as_stated.unsafe if image.name.startswith(s.name))
        (a, b), (c, d) = (s.to_convex_set(*((Fraction(0),) * 2,) * 2).span(1) for s in (source, image))
        assert (c - a, d - b) == (k * axis.period,) * 2
    exact = parse_task(with_period(TURNER, "6.4"))
    assert exact.closed_axes[0].drift == 0
    assert exact.tube.clearance == Fraction("0.03")


def test_half_spaces_and_points_are_moved_exactly() -> None:
    """Every point between the half-spaces of a slope has its image, also where normals mix the closed axis with x."""
    task = parse_task(SLOPES)
    faces = [((1, 1), Fraction(2)), ((-1, 0), Fraction("-1.5")), ((0, -1), Fraction(1)), ((0, 1), Fraction(0))]
    images = [s for s in task.unsafe if s.name.startswith("slope")]
    assert [s.name for s in images] == ["slope", "slope+2", "slope+3"]
    for image in images:
        k = int(image.name.removeprefix("slope") or 0)
        for normal, offset in faces:
            moved = offset + k * normal[1] * Fraction("6.283")
            assert max(sum(n * v for n, v in zip(normal, p, strict=True)) for p in image.vertices) == moved  # type: ignore[union-attr]


@pytest.mark.parametrize("kind", ["vertices", "normals", "ball"])
@pytest.mark.parametrize("period", [TURN, "6.283", "6.4"])
def test_package_and_checker_move_a_target_of_any_shape_to_its_turn(kind: str, period: str, tmp_path: Path) -> None:
    shapes = {
        "vertices": "lower = [4.0, -2.9]\nupper = [4.8, -2.2]\nvertices = [[3.9, -3.0], [4.9, -2.6], [4.2, -2.0]]",
        "normals": "lower = [4.0, -2.9]\nupper = [4.7, -2.4]\nnormals = [[1, 1]]\noffsets = [2.1]",
        "ball": "centre = [4.3, -2.6]\nradius = 0.35",
    }
    text = with_period(TURNER, period).replace("lower = [4.0, -2.9]\nupper = [4.7, -2.4]", shapes[kind]).partition("[control]")[0]
    controller = build_once(parse_task(text))
    turns_up = controller.task.closed_axes[0].target_turns
    assert turns_up == 3
    assert checker_exit_code(controller, text, tmp_path) == 0
    stated = controller.task.as_stated
    drift, distance = controller.task.closed_axes[0].drift, turns_up * Fraction(period)
    expected = [(n, h + n[1] * distance - abs(n[1]) * turns_up * drift) for n, h in stated.target_cuts]
    assert sorted(controller.task.target_cuts) == sorted(expected)


PATROL = """name = "turner"
axes = ["x", "yaw"]
periodic = { yaw = 6.283185307179586 }
prescribed_time = 16
repeat = true
initial_state = [0.5, 3.0]
state_space = { lower = [0, -3.2], upper = [5, 3.2] }
initial_set = { lower = [0.2, 2.7], upper = [0.8, 3.3] }

[[unsafe]]
lower = [2.0, -3.1]
upper = [3.0, -2.7]

[[region]]
name = "far"
axes = ["x"]
lower = [3.8]
upper = [5]

[[region]]
name = "near"
axes = ["x"]
lower = [0]
upper = [1.2]

[[mission]]
patrol = ["near", "far"]
every = 15

"""
INERTIA = """name = "turner"
axes = ["x", "yaw"]
periodic = { yaw = 6.283185307179586 }
prescribed_time = 10
initial_state = [0.5, 3.0]
state_space = { lower = [0, -3.2], upper = [5, 3.2] }
initial_set = { lower = [0.2, 2.7], upper = [0.8, 3.3] }
target_set = { lower = [4, -3.1], upper = [4.8, -2.4] }

[control]
period = 0.01

[plant]
order = 2
noise = 0.0001
"""


@pytest.mark.parametrize(
    ("text", "code", "file"), [(PATROL, "P10", "wrap"), (INERTIA, "P9", "unwrap")], ids=["patrol", "inertia"]
)
def test_patrols_and_order_two_take_closed_axes(text: str, code: str, file: str, tmp_path: Path) -> None:
    """A patrol for ever with regions on the axis x, and a plant of order 2: certificate and checker verify both."""
    controller = turner_controller(text)
    assert [s.name for s in controller.task.unsafe] == (["U1", "U1+1"] if code == "P10" else [])
    assert code in {f.code for f in controller.certificate.findings}
    assert {f"turner_{file}.c", "turner_unwrap.c"} <= set(controller.files)
    assert checker_exit_code(controller, text, tmp_path) == 0


@pytest.mark.parametrize("design", ["adaptive"])
def test_a_paper_tube_takes_closed_axes(design: str) -> None:
    controller = build_once(Task(**box_task(tube={"design": design}, unsafe=[{"lower": [1, -3.1], "upper": [1.5, -2.7]}])))
    assert controller.certificate.holds
    assert controller.task.closed_axes[0].target_turns == 1
    assert "arm_unwrap.c" in controller.files


# --------------------------------------------------------------------------------------------------- the C


FLAGS = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wfloat-equal -Wshadow -Werror -ffp-contract=off".split()


def compiled(controller: EmittedController, folder: Path) -> Any:
    """Compile the emitted C and return its functions `unwrap(x_before, x)` and `control(t, x)` for Python."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    p, n = controller.task.name, controller.task.dimension
    sources = [str(folder / f"{p}{end}.c") for end in ("", "_unwrap")]
    library_path = folder / f"{controller.program.scalar}.so"
    subprocess.run(["gcc", *FLAGS, "-shared", "-fPIC", *sources, "-o", str(library_path), "-lm"], check=True)
    library, real = ctypes.CDLL(str(library_path)), ctypes.c_float if controller.program.scalar == "float" else ctypes.c_double
    vector = real * n

    def unwrap(before: Sequence[float], x: Sequence[float]) -> list[float]:
        state = vector(*x)
        library[f"{p}_unwrap"](vector(*before), state)
        return list(state)

    def control(t: float, x: Sequence[float]) -> tuple[int, list[float]]:
        u = vector()
        return library[f"{p}_control"](real(t), vector(*x), u), list(u)

    return unwrap, control


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("value", [TURN, "6.283", "3.1416"])
def test_unwrapping_is_exact_to_the_error_that_the_noise_includes(scalar: str, value: str, tmp_path: Path, tool: Any) -> None:
    """The true state is on a line; the sensor knows 2 pi/m and measures the angle anywhere within a period of 0; the state before is
    anywhere within the largest step. Unwrapping returns the true state to within `unwrap_error`."""
    tool("gcc")
    task = parse_task(with_period(TURNER, value)).with_options(scalar=scalar)
    controller = build_once(task)
    unwrap, _ = compiled(controller, tmp_path)
    python = load_module("turner", controller.files["turner.py"])
    (axis,) = controller.task.closed_axes
    period, step = float(axis.period), float(axis.largest_step)
    true_turn = 2 * math.pi / round(2 * math.pi / period)
    low, high = (float(edge[1]) for edge in (controller.task.state_space.lower, controller.task.state_space.upper))
    dice, largest_error = np.random.default_rng(5), 0.0
    for _ in range(4000):
        x = dice.uniform(low, high)
        k = dice.choice([k for k in range(-20, 20) if abs(x - k * true_turn) <= period])
        y, before = x - k * true_turn, min(max(x + dice.uniform(-1, 1) * step, low), high)
        unchanged, yaw = unwrap([0.25, before], [0.5, y])
        assert unchanged == 0.5
        assert abs(yaw - x) <= float(axis.unwrap_error) + 1e-12  # 1e-12: doubles of this test's own angles below 40
        largest_error = max(largest_error, abs(yaw - x))
        assert abs(python.unwrap([0.25, before], [0.5, y])[1] - x) <= float(axis.unwrap_error) + 1e-12
    assert largest_error > float(axis.unwrap_error) / 100 - 1e-13  # the bound is about this error, and not far too wide


def test_unwrapping_returns_nan_infinities_and_huge_values_unchanged(tmp_path: Path, tool: Any) -> None:
    tool("gcc")
    controller = turner_controller()
    unwrap, control = compiled(controller, tmp_path)
    python = load_module("turner", controller.files["turner.py"])
    for x in (math.nan, math.inf, -math.inf, 1e30):
        for before in (0.0, math.nan, 1e30):
            expected = np.float32(x)
            for unwrapped in (unwrap([0.0, before], [0.5, x])[1], python.unwrap([0.0, before], [0.5, x])[1]):
                assert (np.isnan(unwrapped) and np.isnan(expected)) or np.float32(unwrapped) == expected
    assert control(1.0, unwrap([0.5, 15.5], [0.5, math.nan]))[0] == 2


def test_a_loop_with_wrapped_measurements_follows_the_loop_with_true_states(tmp_path: Path, tool: Any) -> None:
    """One loop of the emitted C measures the state, another an angle in [-pi, pi) that the C unwraps. Both stay in the tube and end in
    the target. Their distance stays below a hundred unwrapping errors, as the law contracts."""
    tool("gcc")
    controller = turner_controller()
    unwrap, control = compiled(controller, tmp_path)
    (axis,) = controller.task.closed_axes
    state = true_state = np.array([0.5, 15.5])
    before, tau = [0.5, 15.5], 0.01
    for k in range(1000):
        wrapped = [state[0], (state[1] + math.pi) % (2 * math.pi) - math.pi]
        before = unwrap(before, wrapped)
        (status, u), (true_status, v) = control(k * tau, before), control(k * tau, true_state)
        assert (status, true_status) == (0, 0)
        state, true_state = state + tau * np.array(u), true_state + tau * np.array(v)
        assert np.abs(state - true_state).max() <= 100 * float(axis.unwrap_error)
    low, high = (np.array(v, dtype=float) for v in (controller.task.target.lower, controller.task.target.upper))
    assert ((low < state) & (state < high)).all()
    assert 0 <= (state[1] - -2.9) % (2 * math.pi) <= 0.5  # in the target as the task file states it


def test_the_rust_unwraps_as_the_python_does(tmp_path: Path, tool: Any) -> None:
    rustc = tool("rustc")
    controller = build_once(parse_task(TURNER).with_options(scalar="double", language="rust"))
    python = load_module("turner", controller.files["turner.py"])
    (tmp_path / "turner.rs").write_bytes(controller.files["turner.rs"])
    pairs = [(15.5 + 0.37 * k, -6.0 + 0.3 * k) for k in range(40)] + [(0.0, 1e30)]
    calls = "\n".join(f'print!("{{:?}} ", turner::unwrap(&[0.0, {a!r}], &[0.5, {b!r}])[1]);' for a, b in pairs)
    (tmp_path / "main.rs").write_text(f"fn main() {{\n{calls}\n}}\n")
    base = [rustc, "--edition", "2021", "-O"]
    subprocess.run(
        [*base, "--crate-type", "rlib", "--cfg", 'feature="std"', "turner.rs"], cwd=tmp_path, check=True, capture_output=True
    )
    subprocess.run([*base, "--extern", "turner=libturner.rlib", "main.rs"], cwd=tmp_path, check=True, capture_output=True)
    output = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout.split()
    assert [float(word) for word in output] == [python.unwrap([0.0, a], [0.5, b])[1] for a, b in pairs]


def test_the_ros_node_counts_turns_from_the_start() -> None:
    """Wrapped states begin a mission at 15.5, more than two turns up, and pass the end of the circle."""
    sys.modules["drive"] = module = types.ModuleType("drive")
    exec(package(turner_controller(), "ros2")["turner_ros2/turner_ros2/drive.py"], module.__dict__)
    unwrapped: list[float] = []

    def control(t: float, x: Sequence[float], v: Sequence[float]) -> tuple[int, tuple[float, ...], float]:
        unwrapped.append(x[1])
        return 0, (0.0, 0.0), 0.5

    drive = module.Drive(lambda: control, 0.02, 1.0)
    true_yaw = [15.5 + 0.05 * k for k in range(100)]
    for k, yaw in enumerate(true_yaw):
        measured = (0.5, (yaw + math.pi) % (2 * math.pi) - math.pi)
        if k == 30:
            drive.measured(0.01 * k - 0.005, (0.5, math.nan))  # a glitch does not lose the turn
            assert math.isnan(unwrapped.pop())
        drive.measured(0.01 * k, measured)
        if k == 0:
            assert drive.start(0.0) == ""
            drive.decide(0.0)
    (axis,) = turner_controller().task.closed_axes
    assert unwrapped == pytest.approx(true_yaw, abs=float(axis.unwrap_error))


# --------------------------------------------------------------------------------------------------- the checker


@pytest.mark.parametrize("text", [TURNER, SLOPES, with_period(TURNER, TURN)], ids=["rough", "slope", "fine"])
def test_the_checker_verifies_the_task_as_it_is_stated(text: str, tmp_path: Path, capsys: Any) -> None:
    assert checker_exit_code(turner_controller(text), text, tmp_path) == 0
    assert "P1 to P7 and P9 hold" in capsys.readouterr().out


def checker_exit_code_after(change: Callable[[dict[str, Any], dict[str, str]], None], tmp_path: Path) -> int:
    """Return the checker's exit code after a change of the certificate and the files; the certificate has the new hashes."""
    controller = turner_controller()
    texts = {name: data.decode() for name, data in controller.files.items()}
    document = json.loads(texts.pop("turner.certificate.json"))
    change(document, texts)
    files = {name: text.encode() for name, text in texts.items()}
    document["sha256"] |= {name: hashlib.sha256(data).hexdigest() for name, data in files.items()}
    files["turner.certificate.json"] = json.dumps(document).encode()
    return checker_exit_code(dataclasses.replace(controller, files=files), TURNER, tmp_path)


UNWRAP_MUTANTS = [
    ("x_before[1] - x[1]", "x[1] - x_before[1]"),
    ("/ TURNER_TURN_2", "* TURNER_TURN_2"),
    ("turns > -1000.0F", "turns > -1.0F"),
    ("turns < 1000.0F", "turns < 1.0F"),
    ("(int)(turns", "(int)(2.0F * turns"),
    ("? -0.5F : 0.5F", "? 0.5F : 0.5F"),
    ("x[1] += ", "x[0] += "),
    ("x[1] += ", "x[1] = "),
    ("TURNER_TURN_2 * (turner_real)", "6.0F * (turner_real)"),
]


@pytest.mark.parametrize(("old", "new"), UNWRAP_MUTANTS)
def test_the_checker_refuses_c_that_unwraps_differently(old: str, new: str, tmp_path: Path, capsys: Any) -> None:
    def change(document: dict[str, Any], texts: dict[str, str]) -> None:
        assert old in texts["turner_unwrap.c"]
        texts["turner_unwrap.c"] = texts["turner_unwrap.c"].replace(old, new)

    assert checker_exit_code_after(change, tmp_path) == 1
    assert "turner_unwrap.c has" in capsys.readouterr().out


ATTACKS: dict[str, tuple[Callable[[dict[str, Any], dict[str, str]], None], str]] = {
    "an image without a claim": (
        lambda document, _: document["claims"].remove(next(c for c in document["claims"] if c.get("set") == "wall+2")),
        "P4",
    ),
    "the claim of an image about another": (
        lambda document, _: next(c for c in document["claims"] if c.get("set") == "wall+2").update(set="wall+3"),
        "P4",
    ),
    "another period in the header": (
        lambda _, texts: texts.update({"turner.h": texts["turner.h"].replace("TURN_2 6.283F", "TURN_2 6.284F")}),
        "turner.h has '6.284F' in line",
    ),
    "no period in the header": (
        lambda _, texts: texts.update({"turner.h": re.sub(r"#define TURNER_TURN_2 .*\n", "", texts["turner.h"])}),
        "turner.h has",
    ),
    "no unwrapping": (lambda document, _: document["sha256"].pop("turner_unwrap.c"), "lacks a hash"),
    "less noise": (lambda document, _: document["sampled"]["plant"].update(noise="1/1000"), "sampled plant is not the task's"),
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_the_checker_refuses_files_that_leave_a_turn_out(attack: str, tmp_path: Path, capsys: Any) -> None:
    change, message = ATTACKS[attack]

    def apply_attack(document: dict[str, Any], texts: dict[str, str]) -> None:
        if attack == "no unwrapping":
            texts.pop("turner_unwrap.c")
        change(document, texts)

    assert checker_exit_code_after(apply_attack, tmp_path) == 1
    assert message in capsys.readouterr().out


def test_the_checker_refuses_another_period_in_the_task(tmp_path: Path, capsys: Any) -> None:
    assert checker_exit_code(turner_controller(), with_period(TURNER, "6.2831"), tmp_path) == 1
    assert "sampled plant is not the task's" in capsys.readouterr().out  # the noise of unwrapping is another one


@pytest.mark.parametrize("fault", ["no drift", "no images", "another turn"])
def test_the_checker_refuses_what_a_faulty_tool_certifies(fault: str, tmp_path: Path, capsys: Any, monkeypatch: Any) -> None:
    """Certificate and hashes agree, as the faulty tool writes both; the checker refuses by its own reading of the task."""
    if fault == "no drift":
        monkeypatch.setattr(turns, "drift_of", lambda period: Fraction(0))
    if fault == "no images":
        monkeypatch.setattr(turns._TurnExpansion, "images", lambda *_: iter(()))
    if fault == "another turn":
        expand_turns = turns.expand_turns

        def expand_to_moved_target(task: Any) -> Any:
            changes, *rest = expand_turns(task)
            target = changes["target_set"]
            moved_box = {"lower": (target.lower[0], target.lower[1] + 1), "upper": (target.upper[0], target.upper[1] + 1)}
            return ({**changes, "target_set": target.model_copy(update=moved_box)}, *rest)

        monkeypatch.setattr(task_module, "expand_turns", expand_to_moved_target)
    controller = build_task(parse_task(TURNER))
    assert controller.certificate.holds
    assert checker_exit_code(controller, TURNER, tmp_path) == 1
    assert "refused" in capsys.readouterr().out


def test_a_sampling_period_in_which_a_turn_may_be_lost_is_refused(monkeypatch: Any, tmp_path: Path, capsys: Any) -> None:
    """The bound on the motion of yaw between samples holds in a loop with disturbance and input delay. Where less motion is allowed,
    package and checker refuse."""
    controller = turner_controller()
    task, proof, design = controller.task, controller.certificate.proved_period, controller.design
    (axis,) = task.closed_axes
    task = task.with_gain(task.gain)
    task._closed_axes = (dataclasses.replace(axis, largest_step=Fraction(1, 1000)),)
    lost = lost_turn(task, design, proof)  # type: ignore[arg-type]
    assert lost is not None
    run = Loop(controller, plant_of("integrator", 2)).run(Scenario(rate=100.0, disturbance="nearest", strength=0.1), trace=True)
    assert run.trace is not None
    yaw = run.trace[:, 2]
    assert 0 < np.abs(np.diff(yaw)).max() <= float(lost.motion)
    assert lost_turn(controller.task, design, proof) is None  # type: ignore[arg-type]
    finding, proved_period = certify_period(task, design, controller.certificate.edge_error)  # type: ignore[arg-type]
    assert proved_period is None
    assert not finding.holds
    assert finding.problem.startswith("axis yaw may move by ")
    assert "only less than" in finding.problem
    task._closed_axes = (dataclasses.replace(axis, largest_step=lost.motion + Fraction(1, 10**9)),)
    assert lost_turn(task, design, proof) is None  # type: ignore[arg-type]
    add_noise = checked_turns.Turns.add_noise

    def add_noise_and_shorten_step(self: checked_turns.Turns, bits: int) -> None:
        add_noise(self, bits)
        self.steps = {1: lost.motion - Fraction(1, 10**9)}

    monkeypatch.setattr(checked_turns.Turns, "add_noise", add_noise_and_shorten_step)
    assert checker_exit_code(controller, TURNER, tmp_path) == 1
    assert "between two samples yaw may move by" in capsys.readouterr().out


# --------------------------------------------------------------------------------------------------- notes and packages


def test_design_and_generate_say_on_which_turn_the_target_is(tmp_path: Path) -> None:
    (tmp_path / "turner.toml").write_text(TURNER.partition("[control]")[0])
    note = "axis yaw closes at 6.283 rad: the target is taken at 16.199 (3 turns up)"
    report = design_report(build_once(stt.load(tmp_path / "turner.toml")), 0.0)
    assert any(note in line for line in report.document()["notes"])
    with redirect_stdout(io.StringIO()) as output:
        show_design(report)
    assert note in " ".join(output.getvalue().split())
    generated = run_command("generate", str(tmp_path / "turner.toml"), "--out", str(tmp_path))
    assert note in generated.stderr
    assert "lies outside the state space" not in generated.stderr  # the wall does, but its image lies within
    header = (tmp_path / "turner.h").read_text()
    assert "Axes that close: yaw after 6.283." in header
    assert "moves by less than 3.1" in header


@pytest.mark.parametrize(
    ("units", "target", "has_note"),
    [
        (["m", "rad"], -3.0, True),
        (["m", "deg"], -3.0, False),
        (["m", "deg"], 190.0, True),
        (["m", ""], -3.0, False),
        (["m", "rad"], 0.0, False),
    ],
)
def test_a_tube_that_takes_the_long_way_round_of_an_angle_gets_a_note(units: list[str], target: float, has_note: bool) -> None:
    """The task lacks `periodic`. The remedy in the note, used as written, takes the short way."""
    fields = box_task(
        periodic=None, units=units, state_space={"lower": [0, -200], "upper": [5, 200]},
        target_set={"lower": [4.0, target - 0.1], "upper": [4.4, target + 0.1]},
    )  # fmt: skip
    notes = turn_notes(Task(**fields))
    assert bool(notes) is has_note
    for note in notes:
        period = float(note.split("yaw = ")[1].split(" ")[0])
        short = Task(**{**fields, "periodic": {"yaw": period}})
        middle = (short.target.lower[1] + short.target.upper[1]) / 2
        assert abs(middle - 3) <= Fraction(str(period)) / 2


def test_packages_contain_the_unwrapping_or_are_refused() -> None:
    for kind in ("cmake", "arduino", "platformio"):
        files = package(turner_controller(), kind)
        assert "turner/src/turner_unwrap.c" in files
    assert b"src/turner_unwrap.c" in package(turner_controller(), "cmake")["turner/CMakeLists.txt"]
    assert (
        b"turner_unwrap(x_before, x);" in package(turner_controller(), "arduino")["turner/examples/turner_loop/turner_loop.ino"]
    )
    with pytest.raises(BadInput, match="--package fmu: a unit does not count turns"):
        package(turner_controller(), "fmu")


def test_a_theorem_about_closed_axes_is_refused_with_the_reason() -> None:
    files = turner_controller().files
    with pytest.raises(BadInput, match=r"theorem: not yet about axes that close \(periodic\)"):
        theorem_text(TURNER.encode(), *(files[f"turner{end}"] for end in (".h", ".c", ".certificate.json")))


def test_turns_are_counted_from_python_too() -> None:
    controller = stt.build(parse_task(TURNER))
    unwrapped = controller.unwrap([0.0, 3.0], [0.5, 3.2 - 6.283])
    assert np.allclose(unwrapped, [0.5, 3.2], rtol=0, atol=6.283 * 2.0**-24)  # the C's period is a float
    with pytest.raises(stt.BadInput, match=r"x: has shape \(3,\)"):
        controller.unwrap([0.0, 3.0], [0.5, 3.0, 1.0])
    with pytest.raises(stt.BadInput, match="no axis closes"):
        stt.build(load_task(ROOT / "tasks" / "omni_s2.toml")).unwrap([0, 0], [0, 0])
