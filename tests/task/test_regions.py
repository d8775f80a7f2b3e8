"""State spaces and targets that are polytopes: a box cut by half-spaces or by the hull of points, from the task to the checker."""

from __future__ import annotations

import itertools
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from stt_codegen.design.arena import arena_of
from stt_codegen.design.linear_programs.end_box import inner_box
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import build_program, certify
from stt_codegen.plants import PLANTS
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.report.pictures.tube_pictures import draw
from stt_codegen.task.load import parse_task
from stt_codegen.task.sets.polytopes import cut_box
from stt_codegen.task.sets.round_sets import FAN_CORNER_DISTANCES, inscribed
from stt_codegen.task.task import Task
from tests.support.controllers import build_once
from tests.task.test_shapes import checker_exit_code

ROOM_TASK = """name = "room"
prescribed_time = 9
initial_state = [0.45, 0.45]
{body}
[state_space]
lower = [0, 0]
upper = [5, 5]
vertices = [[0, 0.5], [0.5, 0], [5, 1.5], [5, 5], [3.5, 5], [0, 2]]
[initial_set]
lower = [0.35, 0.35]
upper = [0.7, 0.7]
[target_set]
lower = [4, 4]
upper = [4.9, 4.9]
normals = [[-1, -1], [1, 1]]
offsets = [-8.8, 9.5]
[[unsafe]]
name = "pillar"
centre = [2.6, 2.2]
radius = 0.6
"""
SPACE_TASK = """name = "space"
axes = ["x", "y", "z"]
prescribed_time = 9
initial_state = [0.5, 0.5, 0.5]
{body}
[state_space]
lower = [0, 0, 0]
upper = [5, 5, 2]
axes = ["y", "x"]
normals = [[1, -1], [-1, 1], [1, 0]]
offsets = [1.5, 3.5, 4.95]
[initial_set]
lower = [0.4, 0.4, 0.2]
upper = [0.7, 0.7, 0.7]
[target_set]
lower = [4, 4, 0.5]
upper = [4.9, 4.9, 1.5]
vertices = [[4, 4, 0.5], [5, 4, 0.5], [4, 5, 0.5], [5, 5, 0.5], [4.5, 4.5, 1.5]]
"""
BALL_TASK = ROOM_TASK.replace(
    "lower = [4, 4]\nupper = [4.9, 4.9]\nnormals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]",
    "centre = [4.3, 4.2]\nradius = 0.45",
)
PAD_TASK = SPACE_TASK.replace(
    "vertices = [[4, 4, 0.5], [5, 4, 0.5], [4, 5, 0.5], [5, 5, 0.5], [4.5, 4.5, 1.5]]",
    'axes = ["y", "x"]\ncentre = [4.45, 4.4]\nradius = 0.42',
)
SPHERE_TASK = SPACE_TASK.replace(
    "lower = [4, 4, 0.5]\nupper = [4.9, 4.9, 1.5]\nvertices = [[4, 4, 0.5], [5, 4, 0.5], [4, 5, 0.5], [5, 5, 0.5], [4.5, 4.5, 1.5]]",
    "centre = [4.4, 4.3, 1]\nradius = 0.45",
)
TEXTS = {
    "room": ROOM_TASK.format(body=""),
    "room, body": ROOM_TASK.format(body="body = [0.05, 0.1]"),
    "space": SPACE_TASK.format(body=""),
    "space, body": SPACE_TASK.format(body="body = [0.05, 0.05, 0.1]"),
    "ball": BALL_TASK.format(body=""),
    "pad": PAD_TASK.format(body="body = [0.05, 0.05, 0.1]"),
    "sphere": SPHERE_TASK.format(body=""),
}


def distance_outside(task: Task, region, low: np.ndarray, high: np.ndarray, body: bool) -> float:
    """Return the largest distance by which a corner of the boxes (T, n), grown by the body, lies outside a region, in doubles.

    It is negative inside. Vertices become half-spaces by qhull, without code of the package.
    """
    axes = list(task.axis_indices(region))
    if getattr(region, "centre", None) is not None:
        centre = np.array(region.centre, dtype=float)
        farthest = np.maximum(abs(low[:, axes] - centre), abs(high[:, axes] - centre))
        return float((np.sqrt((farthest**2).sum(axis=1)) - float(region.radius)).max())
    half = np.array([float(v) for v in task.half_extents]) if body else np.zeros(task.dimension)
    if region.vertices is not None:
        equations = ConvexHull(np.array(region.vertices, dtype=float)).equations
        normals, offsets = equations[:, :-1], -equations[:, -1]
    else:
        normals, offsets = np.array(region.normals, dtype=float), np.array(region.offsets, dtype=float)
    lower, upper = (low - half)[:, axes], (high + half)[:, axes]
    excess = np.maximum(normals[:, None] * lower, normals[:, None] * upper).sum(axis=2) - offsets[:, None]
    return float((excess / np.abs(normals).sum(axis=1)[:, None]).max())


@pytest.mark.parametrize("name", TEXTS)
def test_a_tube_in_polytopes_is_designed_certified_checked_and_drawn(name: str, tmp_path: Path) -> None:
    task = parse_task(TEXTS[name])
    controller = build_once(task)
    assert controller.certificate.holds
    assert checker_exit_code(TEXTS[name], controller.files, tmp_path) == 0
    low, high = controller.design.edges_at(np.linspace(0, 9, 901))
    assert distance_outside(task, task.state_space, low, high, body=True) <= 1e-12
    assert distance_outside(task, task.target_set, low[-1:], high[-1:], body=False) <= 1e-12
    task_in_box = task.changed(state_space={"vertices": None, "normals": None, "offsets": None, "axes": None})
    assert cost_of(controller.program, "control") == cost_of(build_once(task_in_box).program, "control")
    draw(controller, tmp_path / "drawn.png")


@pytest.mark.parametrize("region", ["state_space", "target_set"])
def test_a_face_moved_inward_is_refused_once_the_tube_is_outside(region: str, tmp_path: Path) -> None:
    controller = build_once(parse_task(TEXTS["room"]))
    low, high = controller.design.edges_at(np.linspace(0, 9, 8 * controller.design.segments + 1))
    verdicts = []
    for k in range(12):
        old = {"state_space": "[3.5, 5], [0, 2]", "target_set": "offsets = [-8.8, 9.5]"}[region]
        new = {
            "state_space": f"[{3.5 + 0.1 * k:.2f}, 5], [0, {2 - 0.1 * k:.2f}]",
            "target_set": f"offsets = [{-8.7 - 0.03 * k:.2f}, 9.5]",
        }
        text = TEXTS["room"].replace(old, new[region])
        try:
            task = parse_task(text)
        except BadInput as refusal:
            assert "initial_set: lies outside the state space" in str(refusal)
            continue
        certificate = certify(task, controller.design, build_program(task, controller.design))
        verdicts.append(certificate.tube_holds)
        assert (
            checker_exit_code(text, render(task, controller.design, controller.program, certificate), tmp_path) == 0
        ) == certificate.holds
        times = slice(-1, None) if region == "target_set" else slice(None)
        distance = distance_outside(task, getattr(task, region), low[times], high[times], body=region == "state_space")
        assert distance <= 1e-12 if certificate.holds else distance > -2 * float(max(controller.certificate.edge_error)) - 1e-3
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


def test_the_polytope_in_a_ball_lies_within_it_and_nearly_fills_it() -> None:
    for d, corner_distance in FAN_CORNER_DISTANCES.items():
        centre, radius = tuple(Fraction(i, 7) for i in range(1, d + 1)), Fraction(3, 5)
        corners = [v.point for v in cut_box(*(tuple(c + s * radius for c in centre) for s in (-1, 1)), inscribed(centre, radius))]
        squared_distance = max(sum((v - c) ** 2 for v, c in zip(p, centre, strict=True)) for p in corners)
        assert squared_distance <= radius**2
        assert squared_distance > (Fraction("0.999") * radius) ** 2  # the factor is rounded up in the fourth place
        assert corner_distance <= Fraction("1.05")


def test_a_shrunk_target_ball_is_refused_once_the_tube_ends_outside(tmp_path: Path) -> None:
    controller = build_once(parse_task(TEXTS["sphere"]))
    low, high = controller.design.edges_at(np.array([9.0]))
    verdicts = []
    for k in range(8):
        text = TEXTS["sphere"].replace("radius = 0.45\n", f"radius = {0.45 - 0.02 * k:.2f}\n")
        task = parse_task(text)
        certificate = certify(task, controller.design, build_program(task, controller.design))
        verdicts.append(certificate.tube_holds)
        assert (
            checker_exit_code(text, render(task, controller.design, controller.program, certificate), tmp_path) == 0
        ) == certificate.holds
        assert not certificate.holds or distance_outside(task, task.target_set, low, high, body=False) <= 0
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


def test_the_loop_judges_by_the_true_room() -> None:
    loop = Loop(build_once(parse_task(TEXTS["room"])), PLANTS["integrator"])
    assert loop.run(Scenario(rate=500.0)).good
    corner = loop.run(Scenario(start=(4.5, 1.2)))  # in the bounding box, behind the slanted wall
    assert corner.left_at == 0
    assert loop.run(Scenario(start=(4.5, 1.45))).left_at != 0
    push = loop.run(Scenario(disturbance="nearest", strength=0.1, start=(4.5, 1.5)), trace=True).trace[0, 9:11]
    assert push == pytest.approx(0.1 * np.array([1.5, -4.5]) / np.hypot(1.5, 4.5), rel=1e-6)


def test_the_end_box_of_a_route_lies_in_the_target_and_is_the_largest_of_its_proportions() -> None:
    arena = arena_of(parse_task(TEXTS["room"]))
    inset = np.array([0.1, 0.1])
    goal = np.stack([arena.target[0] + inset, arena.target[1] - inset])
    box = inner_box(arena, goal, inset)
    assert box is not None
    for cuts in (arena.space_cuts, arena.target_cuts):  # a box of half widths `inset` about any corner satisfies every cut
        for corner in itertools.product(*box.T.tolist()):
            margins = cuts.normal @ np.array(corner) - np.abs(cuts.normal) @ inset - cuts.lower_bound
            assert margins.min() >= -1e-9  # at least ten times the solver's tolerance of a row
    assert (goal[0] - 1e-9 <= box[0]).all()
    assert (box[1] <= goal[1] + 1e-9).all()
    half = (goal[1] - goal[0]) / 2
    rows, ends = [], []
    for normal, bound in zip(
        *(np.concatenate([getattr(c, f) for c in (arena.space_cuts, arena.target_cuts)]) for f in ("normal", "lower_bound")),
        strict=True,
    ):
        rows.append([*-normal, float(np.abs(normal) @ half)])
        ends.append(-bound - float(np.abs(normal) @ inset))
    for i in (0, 1):
        rows += [[*np.eye(2)[i], half[i]], [*-np.eye(2)[i], half[i]]]
        ends += [goal[1, i], -goal[0, i]]
    solution = linprog([0, 0, -1], np.array(rows), ends, bounds=[(None, None)] * 2 + [(0, 1)])
    assert ((box[1] - box[0]) / 2 / half) == pytest.approx([-solution.fun] * 2, rel=1e-6)


def test_a_target_too_narrow_for_a_tube_is_refused() -> None:
    with pytest.raises(NotCertified, match="certified with tube.min_width = 0.02"):
        build_once(parse_task(TEXTS["room"].replace("offsets = [-8.8, 9.5]", "offsets = [-8.8, 8.85]")))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("vertices = [[0, 0.5], [0.5, 0],", "vertices = [[0, 0.5], [0.5],", ["state_space.vertices[1]", "1 entries", "2 are needed"]),
        ("vertices = [[0, 0.5], [0.5, 0], [5, 1.5], [5, 5], [3.5, 5], [0, 2]]", "vertices = [[0, 0], [1, 1]]", ["state_space", "3 points"]),
        ("offsets = [-8.8, 9.5]", "offsets = [-8.8]", ["target_set", "offsets", "1 entries"]),
        ("offsets = [-8.8, 9.5]", "", ["target_set", "offsets", "missing"]),
        ("normals = [[-1, -1], [1, 1]]", "normals = [[0, 0], [1, 1]]", ["target_set", "normals[0]", "is 0"]),
        ("normals = [[-1, -1], [1, 1]]", 'normals = [[-1, -1], [1, 1]]\naxes = ["x1", "y"]', ["target_set.axes", "x1, x2"]),
        ("normals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", 'axes = ["x1"]', ["target_set", "axes", "leave the axes out"]),
        ("[0.5, 0], [5, 1.5]", "[5, 1.5]", ["initial_set", "outside the state space", "<="]),
        ("offsets = [-8.8, 9.5]", "offsets = [-8.8, 9.5]\ncentre = [4, 4]\nradius = 0.3", ["target_set", "stands beside"]),
        ("normals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", "centre = [4.4, 4.4]", ["target_set.radius", "missing"]),
        ("normals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", "centre = [4.4]\nradius = 0.2", ["target_set.centre", "1 entries"]),
        ("normals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", "centre = [4.4, 4.4]\nradius = 0", ["target_set.radius", "greater"]),
        ("lower = [4, 4]\nupper = [4.9, 4.9]\nnormals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", "centre = [4.6, 4.4]\nradius = 0.5", ["target_set: its ball", "5.1", "at most 5"]),
        ("lower = [4, 4]\nupper = [4.9, 4.9]\nnormals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", "upper = [5, 5]", ["target_set.lower", "missing"]),
        ("[target_set]\nlower = [4, 4]\n", "[target_set]\ncentre = [4.4, 4.4]\nradius = 0.2\n#", ["target_set"]),
        ("[4.9, 4.9]\nnormals = [[-1, -1], [1, 1]]\noffsets = [-8.8, 9.5]", "[4.9, 4.9]\ncentre = [9, 9]\nradius = 0.3", ["target_set", "ball about its centre"]),
        ('name = "room"', 'name = "room"\ntube = { design = "adaptive" }', ["state_space", "refined"]),
    ],
)  # fmt: skip
def test_malformed_polytopes_are_refused(old: str, new: str, words: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        parse_task(TEXTS["room"].replace(old, new))
    assert all(word in str(caught.value) for word in words), caught.value


def test_half_spaces_across_one_axis_are_bounds_of_it() -> None:
    """A cut across one axis tightens a bound of the box, and couples no axes."""
    task = parse_task(
        TEXTS["space"].replace(
            "normals = [[1, -1], [-1, 1], [1, 0]]\noffsets = [1.5, 3.5, 4.95]",
            "normals = [[1, 0], [-2, 0]]\noffsets = [4.9, -0.2]",
        )
    )
    arena = arena_of(task)
    assert arena.space_cuts.lower_bound.size == 0
    assert arena.space[:, 1] + float(arena.origin[1]) == pytest.approx([0.1, 4.9], abs=1e-4)
    assert task.space_cuts == (((0, 1, 0), Fraction("4.9")), ((0, -1, 0), Fraction("-0.1")))


def test_half_spaces_that_leave_nothing_are_refused() -> None:
    for region, old, new in (
        ("target_set", "offsets = [-8.8, 9.5]", "offsets = [-8.8, 8]"),
        ("target_set", "offsets = [-8.8, 9.5]", "offsets = [-8.8, 8.8]"),
        ("state_space", "vertices = [[0, 0.5]", "vertices = [[7, 7], [8, 7], [7, 8]]\naxes = ['x1', 'x2']\n#"),
    ):
        with pytest.raises(BadInput, match=f"{region}: its .* leave nothing of the box"):
            parse_task(TEXTS["room"].replace(old, new))
