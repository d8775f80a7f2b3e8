"""Names of axes and units: in messages, comments, reports and pictures, and in nothing else."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from typer.testing import CliRunner

from stt_codegen.certify import checker
from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.report.pictures.tube_pictures import figure_of, plane_named, planes_of
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, built

HEADING = ROOT / "tasks" / "omni_heading.toml"
NAMES = {"axes": ["x", "y", "heading"], "units": ["m", "m", "rad"]}


@pytest.fixture(scope="module")
def named() -> EmittedController:
    return built(load_task(HEADING).changed(**NAMES))


def test_names_change_comments_and_the_digest_alone(named: EmittedController, tmp_path: Path) -> None:
    plain = built(load_task(HEADING))
    assert named.design == plain.design
    for name in ("omni_heading.h", "omni_heading.c"):
        ours, theirs = (c.files[name].decode().splitlines() for c in (named, plain))
        more = [line for line in ours if line not in theirs]
        assert all(line.startswith(" *") or "DESIGN_HASH" in line for line in more), more
    assert " * x by component: x [m], y [m], heading [rad]." in named.files["omni_heading.h"].decode().splitlines()
    lines = HEADING.read_text().replace('name = "omni_heading"', 'name = "omni_heading"\naxes = ["x", "y", "heading"]', 1)
    text = lines.replace("prescribed_time", 'units = ["m", "m", "rad"]\nprescribed_time', 1)
    for name, data in {**named.files, "task.toml": text.encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert checker.main([str(tmp_path / n) for n in ("task.toml", "omni_heading.c", "omni_heading.certificate.json")]) == 0


def test_messages_speak_of_the_axis(named: EmittedController) -> None:
    table = named.design.table
    bent = replace(named.design, table=(*table[:9], ((9_000_000, 9_100_000), *table[9][1:]), *table[10:]))
    with pytest.raises(NotCertified, match="axis x, |axis x:|axis x;"):
        build_task(named.task, tube=bent)
    with pytest.raises(NotCertified, match="wide in axis heading"):
        built(named.task.changed(initial_set={"lower": [0, 0, -0.02], "upper": [0.5, 0.5, 0.02]}))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('axes = ["x", "y"]', ["axes", "2 entries"]),
        ('axes = ["x", "y", "x"]', ["axes[2]", "axis 1", "differ"]),
        ('axes = ["x", "", "z"]', ["axes[1]", "name"]),
        ('axes = ["x", "y", "z*/"]', ["axes", "no label"]),
        ('units = ["m", 2, "rad"]', ["units", "texts"]),
        ('units = "m"', ["units", "list"]),
    ],
)
def test_labels_that_are_none_are_refused(line: str, words: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        parse_task(HEADING.read_text().replace("prescribed_time", f"{line}\nprescribed_time", 1))
    assert all(word in str(caught.value) for word in words), caught.value


def joints(n: int) -> Task:
    """A mission in joint space."""
    return Task(
        name="joints",
        axes=[f"joint {i + 1}" for i in range(n)],
        units=["rad"] * n,
        prescribed_time=6,
        initial_state=[0.1] * n,
        state_space={"lower": [-3] * n, "upper": [3] * n},
        initial_set={"lower": [-0.2] * n, "upper": [0.3] * n},
        target_set={"lower": [1.5] * n, "upper": [2.1] * n},
        unsafe=[
            {"name": "table", "lower": [0.5, 0.6, *[-3] * (n - 2)], "upper": [1.2, 1.1, *[3] * (n - 2)]},
            {"name": "far", "lower": [2.6, 2.6, *[-3] * (n - 2)], "upper": [4, 4, *[4] * (n - 2)]},
        ],
    )


def texts(figure: Figure) -> list[tuple[object, object]]:
    """Every label drawn inside a pair of axes, with the axes."""
    return [(axis, text) for axis in figure.axes for text in axis.texts if text.get_text()]


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_every_dimension_is_in_a_plane_and_on_an_axis(n: int) -> None:
    task = joints(n)
    planes = planes_of(task)
    assert {i for plane in planes for i in plane} == (set(range(n)) if n > 3 else {0, 1})
    assert all(a != b for a, b in planes)
    figure = figure_of(built(task))
    labels = [axis.get_xlabel() for axis in figure.axes] + [axis.get_ylabel() for axis in figure.axes]
    assert {f"joint {i + 1} [rad]" for i in range(n)} <= set(labels)
    over = figure.axes[len(planes) :]
    assert len({axis.get_xlim() for axis in over}) == 1  # one time axis


@pytest.mark.parametrize("n", [2, 6])
def test_labels_are_inside_the_axes_and_not_over_one_another(n: int) -> None:
    figure = figure_of(built(joints(n)))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    boxes = [(axis, text.get_window_extent(renderer)) for axis, text in texts(figure)]
    for axis, box in boxes:
        frame = axis.get_window_extent(renderer)
        assert frame.x0 - 1 <= box.x0  # to a pixel
        assert box.x1 <= frame.x1 + 1
    for (one, a), (other, b) in itertools.combinations(boxes, 2):
        assert one is not other or not a.overlaps(b)


def test_many_sets_are_drawn_without_names() -> None:
    unsafe = [{"lower": [0.02 * k, 4.5], "upper": [0.02 * k + 0.01, 4.6]} for k in range(200)]
    figure = figure_of(built(load_task(ROOT / "tasks" / "empty.toml").changed(unsafe=unsafe)))
    assert {text.get_text() for _, text in texts(figure)} == {"start", "target"}


def test_the_tube_in_the_plane_has_no_gaps() -> None:
    """A quick passage: each patch of the tube shares a box with the next one."""
    figure = figure_of(built(load_task(ROOT / "tasks" / "empty.toml")))
    swept = [p.get_xy() for p in figure.axes[0].patches if p.get_alpha() == 0.28]
    assert len(swept) > 40
    for one, after in itertools.pairwise(swept):
        shared = {tuple(np.round(p, 9)) for p in one} & {tuple(np.round(p, 9)) for p in after}
        assert len(shared) >= 1


def test_axes_are_chosen_by_name_and_files_by_their_ending(tmp_path: Path) -> None:
    task = load_task(HEADING).changed(**NAMES)
    assert plane_named(task, "y, heading") == (1, 2) == plane_named(task, "x2,x3")
    for wrong in ("x", "x,x", "x,z", "x,y,heading"):
        with pytest.raises(BadInput, match="--axes"):
            plane_named(task, wrong)
    for end in ("svg", "pdf", "png"):
        made = [tmp_path / f"{k}.{end}" for k in (1, 2)]
        for path in made:
            ran = CliRunner().invoke(app, ["design", str(HEADING), "--axes", "x1,x3", "--picture", str(path)])
            assert ran.exit_code == 0, ran.output
        assert made[0].read_bytes() == made[1].read_bytes()
