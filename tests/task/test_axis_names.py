"""Names of axes and units appear in messages, comments, reports and pictures, and change no number (docs/task.md)."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from typer.testing import CliRunner

from stt_codegen.checker import check_files
from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.report.pictures.tube_pictures import figure_of, plane_named, planes_of
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, build_once

HEADING = ROOT / "tasks" / "omni_heading.toml"
NAMES = {"axes": ["x", "y", "heading"], "units": ["m", "m", "rad"]}


@pytest.fixture(scope="module")
def named_controller() -> EmittedController:
    return build_once(load_task(HEADING).changed(**NAMES))


def test_names_change_comments_and_the_digest_alone(named_controller: EmittedController, tmp_path: Path) -> None:
    plain_controller = build_once(load_task(HEADING))
    assert named_controller.design == plain_controller.design
    for name in ("omni_heading.h", "omni_heading.c"):
        named_lines, plain_lines = (c.files[name].decode().splitlines() for c in (named_controller, plain_controller))
        changed = [line for line in named_lines if line not in plain_lines]
        assert all(line.startswith(" *") or "DESIGN_HASH" in line for line in changed), changed
    assert " * x by component: x [m], y [m], heading [rad]." in named_controller.files["omni_heading.h"].decode().splitlines()
    text_with_axes = HEADING.read_text().replace(
        'name = "omni_heading"', 'name = "omni_heading"\naxes = ["x", "y", "heading"]', 1
    )
    text = text_with_axes.replace("prescribed_time", 'units = ["m", "m", "rad"]\nprescribed_time', 1)
    for name, data in {**named_controller.files, "task.toml": text.encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert check_files([str(tmp_path / n) for n in ("task.toml", "omni_heading.c", "omni_heading.certificate.json")]) == 0


def test_messages_name_the_axis(named_controller: EmittedController) -> None:
    table = named_controller.design.table
    tube_with_jump = replace(named_controller.design, table=(*table[:9], ((9_000_000, 9_100_000), *table[9][1:]), *table[10:]))
    with pytest.raises(NotCertified, match="axis x, |axis x:|axis x;"):
        build_task(named_controller.task, tube=tube_with_jump)
    with pytest.raises(NotCertified, match="wide in axis heading"):
        build_once(named_controller.task.changed(initial_set={"lower": [0, 0, -0.02], "upper": [0.5, 0.5, 0.02]}))


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
def test_malformed_labels_are_refused(line: str, words: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        parse_task(HEADING.read_text().replace("prescribed_time", f"{line}\nprescribed_time", 1))
    assert all(word in str(caught.value) for word in words), caught.value


def joint_space_task(n: int) -> Task:
    """Return a task in joint space of n angles, with two unsafe boxes."""
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


def labels_with_plots(figure: Figure) -> list[tuple[object, object]]:
    """Return every label drawn inside a plot of the figure, as (plot, label)."""
    return [(plot, text) for plot in figure.axes for text in plot.texts if text.get_text()]


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_every_dimension_is_in_a_plane_and_on_an_axis(n: int) -> None:
    task = joint_space_task(n)
    planes = planes_of(task)
    assert {i for plane in planes for i in plane} == (set(range(n)) if n > 3 else {0, 1})
    assert all(a != b for a, b in planes)
    figure = figure_of(build_once(task))
    labels = [plot.get_xlabel() for plot in figure.axes] + [plot.get_ylabel() for plot in figure.axes]
    assert {f"joint {i + 1} [rad]" for i in range(n)} <= set(labels)
    plots_over_time = figure.axes[len(planes) :]
    assert len({plot.get_xlim() for plot in plots_over_time}) == 1  # they share one time axis


@pytest.mark.parametrize("n", [2, 6])
def test_labels_are_inside_their_plot_and_do_not_overlap(n: int) -> None:
    figure = figure_of(build_once(joint_space_task(n)))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    boxes = [(plot, text.get_window_extent(renderer)) for plot, text in labels_with_plots(figure)]
    for plot, box in boxes:
        frame = plot.get_window_extent(renderer)
        assert frame.x0 - 1 <= box.x0  # to a pixel
        assert box.x1 <= frame.x1 + 1
    for (plot, box), (second_plot, second_box) in itertools.combinations(boxes, 2):
        assert plot is not second_plot or not box.overlaps(second_box)


def test_many_sets_are_drawn_without_names() -> None:
    unsafe = [{"lower": [0.02 * k, 4.5], "upper": [0.02 * k + 0.01, 4.6]} for k in range(200)]
    figure = figure_of(build_once(load_task(ROOT / "tasks" / "empty.toml").changed(unsafe=unsafe)))
    assert {text.get_text() for _, text in labels_with_plots(figure)} == {"start", "target"}


def test_the_tube_in_the_plane_has_no_gaps() -> None:
    """The tube moves fast: each patch of the tube still shares a box with the next one."""
    figure = figure_of(build_once(load_task(ROOT / "tasks" / "empty.toml")))
    patches = [p.get_xy() for p in figure.axes[0].patches if p.get_alpha() == 0.28]  # the opacity of the tube
    assert len(patches) > 40
    for patch, next_patch in itertools.pairwise(patches):
        shared = {tuple(np.round(p, 9)) for p in patch} & {tuple(np.round(p, 9)) for p in next_patch}
        assert len(shared) >= 1


def test_axes_are_chosen_by_name_and_files_by_their_ending(tmp_path: Path) -> None:
    task = load_task(HEADING).changed(**NAMES)
    assert plane_named(task, "y, heading") == (1, 2) == plane_named(task, "x2,x3")
    for wrong in ("x", "x,x", "x,z", "x,y,heading"):
        with pytest.raises(BadInput, match="--axes"):
            plane_named(task, wrong)
    for suffix in ("svg", "pdf", "png"):
        pictures = [tmp_path / f"{k}.{suffix}" for k in (1, 2)]
        for path in pictures:
            result = CliRunner().invoke(app, ["design", str(HEADING), "--axes", "x1,x3", "--picture", str(path)])
            assert result.exit_code == 0, result.output
        assert pictures[0].read_bytes() == pictures[1].read_bytes()
