"""Unsafe sets of every shape, from a task file to the checker: hulls of points, half-spaces, balls, capsules and boxes, each also on
some of the axes only. Oracles are linear programs and distances by numerical search, without code of the package."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, product
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from stt_codegen.checker import check_files
from stt_codegen.checker.stt_checker.exact import Unusable
from stt_codegen.checker.stt_checker.keys import refuse_unknown_keys
from stt_codegen.checker.stt_checker.sets import FORMS, Inside
from stt_codegen.checker.stt_checker.task import Task as CheckedTask
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, SttError
from stt_codegen.loop.compiled import LoopResult, LoopSetting, driver
from stt_codegen.loop.judged_sets import JudgedSets, enlarged_sets
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import build_program, certify
from stt_codegen.plants import PLANTS
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.report.notes import task_notes
from stt_codegen.report.outlines import outline
from stt_codegen.report.pictures.tube_pictures import draw
from stt_codegen.task.load import parse_task
from stt_codegen.task.sets.convex_sets import BoxSet, Prism, minimum_over_box
from stt_codegen.task.sets.polytopes import Hull, Polytope, affine_dimension, cut_box, route_corners_of
from stt_codegen.task.sets.round_sets import RoundSet, fan, size
from stt_codegen.task.sets.shapes import Unsafe, UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet
from stt_codegen.task.task import Task
from tests.support.controllers import build_once
from tests.task.test_sets import PLAIN, Points, clipped, hull

SPACE = """name = "space"
axes = ["x", "y", "z"]
prescribed_time = 9
initial_state = [0.25, 0.25, 0.25]
state_space = { lower = [-0.2, -0.2, -0.2], upper = [5.2, 5.2, 5.2] }
initial_set = { lower = [0, 0, 0], upper = [0.5, 0.5, 0.5] }
target_set = { lower = [4.5, 4.5, 4.5], upper = [5, 5, 5] }
"""
FLAT = PLAIN.replace("lower = [0, 0], upper = [5, 5]", "lower = [-0.2, -0.2], upper = [5.2, 5.2]")
BODY = {2: "body = [0.1, 0.05]\n", 3: "body = [0.1, 0.05, 0.1]\n"}
# Two triangles with a slanted corridor between them; their bounding boxes overlap and close it.
CORRIDOR = ("vertices = [[1.2, 0], [5, 0], [5, 3.8]]", "vertices = [[0, 1.2], [3.8, 5], [0, 5]]")
SHAPES: dict[str, tuple[str, tuple[str, ...]]] = {
    "triangles": (FLAT, CORRIDOR),
    "quadrangle": (FLAT, ("vertices = [[1, 2], [3, 1], [3.5, 3], [2, 2], [2.1, 3.4]]",)),
    "disc": (FLAT, ("centre = [2.5, 2.4]\nradius = 1.2",)),
    "capsule": (FLAT, ("segment = [[1, 3], [3, 1]]\nradius = 0.3",)),
    "half-spaces": (FLAT, ("normals = [[1, 1], [-1, 0.25], [0, -1]]\noffsets = [4.5, -1.2, -1]",)),
    "wall with an end": (FLAT, ("normals = [[0, 1], [0, -1], [1, 0.5]]\noffsets = [3, -2, 4.5]",)),
    "ball": (SPACE, ("centre = [2.5, 2.5, 2.4]\nradius = 1.5",)),
    "cylinder": (SPACE, ('centre = [2.5, 2.5]\nradius = 1\naxes = ["x", "z"]',)),
    "slanted rod": (SPACE, ("segment = [[1, 3, 1], [3, 1, 4]]\nradius = 0.4",)),
    "fin": (SPACE, ('segment = [[1, 3], [3, 1]]\nradius = 0.2\naxes = ["x", "y"]',)),
    "tetrahedron": (SPACE, ("vertices = [[1, 1, 1], [4, 1, 1], [1, 4, 1], [2, 2, 4]]",)),
    "corner": (SPACE, ("normals = [[1, 1, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]\noffsets = [7, -1, -1, -1]",)),
    "prisms": (SPACE, tuple(f'{text}\naxes = ["{a}", "{b}"]' for text, (a, b) in zip(CORRIDOR, ("xy", "xy"), strict=True))),
    "pillars": (SPACE, ('lower = [1, 1]\nupper = [2, 3]\naxes = ["x", "z"]', 'centre = [3, 3]\nradius = 0.5\naxes = ["y", "x"]')),
}
SHAPES["one axis"] = (FLAT, ('lower = [1.2]\nupper = [3]\naxes = ["x2"]\nname = "strip"',))
WITHOUT_WAY = {"one axis"}  # a strip across the plane leaves no way, so that the task is refused


def text_of(name: str, body: bool = False) -> str:
    """Return the text of a task of `SHAPES`, with a body or without."""
    head, tables = SHAPES[name]
    return head + (BODY[3 if head is SPACE else 2] if body else "") + "".join(f"\n[[unsafe]]\n{t}\n" for t in tables)


def checker_exit_code(text: str, files: dict[str, bytes], folder: Path) -> int:
    """Write the emitted files and the text of the task into the folder, and return the exit code of the stand-alone checker."""
    name = next(n for n in files if n.endswith(".c")).removesuffix(".c")
    for file, data in {**files, "task.toml": text.encode()}.items():
        (folder / file).write_bytes(data)
    return check_files([str(folder / n) for n in ("task.toml", f"{name}.c", f"{name}.certificate.json")])


# ------------------------------------------------------------------------------------------------------------- the oracle


def smallest_gap(task: Task, unsafe: Unsafe, low: np.ndarray, high: np.ndarray) -> float:
    """Return the smallest `gap` of boxes with edges low, high (T, n), grown by the body."""
    axes, body = list(task.axis_indices(unsafe)), np.array([float(v) for v in task.half_extents])
    lower, upper = (low - body)[:, axes], (high + body)[:, axes]
    if not isinstance(unsafe, UnsafeBall | UnsafeCapsule):
        return min(gap(task, unsafe, a, b) for a, b in zip(lower, upper, strict=True))
    ends = np.array((unsafe.segment if isinstance(unsafe, UnsafeCapsule) else (unsafe.centre,) * 2), dtype=float)
    apart_at, touching_at = np.full(len(lower), -1.0), np.full(len(lower), 10.0)
    for _ in range(50):
        middle = (apart_at + touching_at) / 2
        is_apart = distance_to_boxes(ends, lower - middle[:, None], upper + middle[:, None]) > float(unsafe.radius)
        apart_at, touching_at = np.where(is_apart, middle, apart_at), np.where(is_apart, touching_at, middle)
    return float(apart_at.min())


def distance_to_boxes(ends: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the distances (T,) from a segment to boxes (T, n), by ternary search along the segment."""

    def distance_at(s: np.ndarray) -> np.ndarray:
        p = ends[0] + s[:, None] * (ends[1] - ends[0])
        return np.linalg.norm(np.maximum(np.maximum(lower - p, p - upper), 0), axis=1)

    a, b = np.zeros(len(lower)), np.ones(len(lower))
    for _ in range(0 if (ends[0] == ends[1]).all() else 70):
        c, d = a + (b - a) / 3, b - (b - a) / 3
        is_left_nearer = distance_at(c) < distance_at(d)
        a, b = np.where(is_left_nearer, a, c), np.where(is_left_nearer, d, b)
    at_ends = np.minimum(distance_at(np.zeros_like(a)), distance_at(np.ones_like(a)))
    return np.minimum(distance_at((a + b) / 2), at_ends)


def gap(task: Task, unsafe: Unsafe, lower: np.ndarray, upper: np.ndarray) -> float:
    """Return by how much a box may grow, in the largest component, until it meets an unsafe set; negative where they overlap.

    The box is on the axes of the set. A linear program finds the value from the fields of the set's table.
    """
    axes, d = task.axis_indices(unsafe), len(lower)
    if isinstance(unsafe, UnsafePolytope):  # a point of the hull is the sum of weights times points
        points = np.array(unsafe.vertices, dtype=float)
        count = len(points)
        weights_sum_to_one = (np.ones((1, count + 1)), [1.0])
        weights_sum_to_one[0][0, -1] = 0.0
        rows = [*(np.append(points[:, i], -1.0) for i in range(d)), *(np.append(-points[:, i], -1.0) for i in range(d))]
        weight_bounds = [(0, None)] * count + [(None, None)]
        solution = linprog([0.0] * count + [1.0], np.array(rows), [*upper, *-lower], *weights_sum_to_one, bounds=weight_bounds)
    else:
        if isinstance(unsafe, UnsafeHalfSpaces):
            normals, offsets = np.array(unsafe.normals, dtype=float), [float(v) for v in unsafe.offsets]
            space = [(float(task.state_space.lower[i]), float(task.state_space.upper[i])) for i in axes]
        else:
            assert isinstance(unsafe, UnsafeSet)
            normals, offsets = np.empty((0, d)), []
            space = [(float(a), float(b)) for a, b in zip(unsafe.lower, unsafe.upper, strict=True)]
        rows = [*(np.append(n, 0.0) for n in normals)]
        rows += [np.append(s * np.eye(d)[i], -1.0) for s in (1, -1) for i in range(d)]
        solution = linprog([0.0] * d + [1.0], np.array(rows), [*offsets, *upper, *-lower], bounds=[*space, (None, None)])
    assert solution.status == 0
    return float(solution.fun)


# ------------------------------------------------------------------------------------------------------------- end to end


@pytest.mark.parametrize("body", [False, True], ids=["point", "body"])
@pytest.mark.parametrize("name", [n for n in SHAPES if n not in WITHOUT_WAY])
def test_every_shape_is_avoided_proved_checked_and_drawn(name: str, body: bool, tmp_path: Path) -> None:
    text = text_of(name, body)
    task = parse_task(text)
    controller = build_once(task)
    assert controller.certificate.holds
    assert checker_exit_code(text, controller.files, tmp_path) == 0
    clearance = float(task.tube.clearance)
    low, high = controller.design.edges_at(np.linspace(0, 9, 301))
    assert min(smallest_gap(task, s, low, high) for s in task.unsafe) > clearance - 1e-7  # the tolerance of the oracle's solver
    task_without_sets = parse_task(text.split("\n[[unsafe]]", maxsplit=1)[0])
    assert cost_of(controller.program, "control") == cost_of(build_once(task_without_sets).program, "control")
    draw(controller, tmp_path / "drawn.png")
    assert (tmp_path / "drawn.png").stat().st_size > 5000


def test_a_strip_from_wall_to_wall_closes_the_way() -> None:
    with pytest.raises(SttError, match="strip"):
        build_once(parse_task(text_of("one axis")))


MOVES = {
    "triangles": lambda s, by: {"vertices": [[x - by, y + by] for x, y in s["vertices"]]},
    "disc": lambda s, by: {"radius": s["radius"] + by},
    "capsule": lambda s, by: {"radius": s["radius"] + by},
    "half-spaces": lambda s, by: {"offsets": [v + by for v in s["offsets"]]},
    "tetrahedron": lambda s, by: {"vertices": [[round(v + by * (v - 2), 4) for v in p] for p in s["vertices"]]},
    "slanted rod": lambda s, by: {"segment": [[x, y + by, z] for x, y, z in s["segment"]]},
    "cylinder": lambda s, by: {"radius": s["radius"] + by},
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n == "slanted rod" else n for n in MOVES])
def test_certificate_and_checker_refuse_a_set_moved_nearer_where_the_oracle_does(name: str, tmp_path: Path) -> None:
    """For one tube the first set is moved step by step. Certificate and checker agree, the verdict changes once, and it is the oracle's,
    except for an allowance for rounding and for normals that are not tried."""
    head, tables = SHAPES[name]
    controller = build_once(parse_task(text_of(name)))
    low, high = controller.design.edges_at(np.linspace(0, 9, 8 * controller.design.segments + 1))
    fields = {k: v for line in tables[0].splitlines() for k, v in [line.split(" = ", 1)]}
    values = {k: eval(v) for k, v in fields.items()}  # lists and numbers that this file states
    allowance = {"disc": 0.01, "capsule": 0.01, "slanted rod": 0.03, "cylinder": 0.01}.get(name, 1e-4)
    verdicts = []
    for k in range(-2, 24, 4):
        moved_values = {**values, **MOVES[name](values, 0.04 * k)}
        table = "\n".join(f"{key} = {value!r}".replace("'", '"') for key, value in moved_values.items())
        text = head + "".join(f"\n[[unsafe]]\n{t}\n" for t in (table, *tables[1:]))
        try:
            task = parse_task(text)
        except BadInput:
            continue  # the set meets the start
        certificate = certify(task, controller.design, build_program(task, controller.design))
        verdicts.append(certificate.tube_holds)
        assert (
            checker_exit_code(text, render(task, controller.design, controller.program, certificate), tmp_path) == 0
        ) == certificate.holds
        oracle_gap = smallest_gap(task, task.unsafe[0], low, high)
        clearance = float(task.tube.clearance)
        assert oracle_gap > clearance - 1e-7 if certificate.holds else oracle_gap < clearance + allowance
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


# Regions of a mission by the checker's form: first a region that contains the whole tube, then one that the tube never meets. A capsule
# has no half-spaces, so that no mission can demand to be in it.
REGIONS = {
    "lower upper": ("lower = [-2, -2]\nupper = [7, 7]", "lower = [4, 0]\nupper = [5, 1]"),
    "vertices": ("vertices = [[-9, -9], [20, -9], [-9, 20]]", "vertices = [[4, 0], [5, 0], [5, 1]]"),
    "normals offsets": ("normals = [[1, 1], [-1, 0]]\noffsets = [20, 5]", "normals = [[1, -1], [0, -1]]\noffsets = [-4.5, -4.5]"),
    "centre radius": ("centre = [2.5, 2.5]\nradius = 9", "centre = [4.5, 0.5]\nradius = 0.4"),
}
UNVISITED = {"segment radius": ("segment = [[2, 3], [3, 3]]\nradius = 9", "segment = [[4, 0.5], [5, 0.5]]\nradius = 0.4")}


def mission_in(region: str) -> str:
    return f'{FLAT}\n[[region]]\nname = "dock"\n{region}\n[[mission]]\nvisit = "dock"\n'


def test_the_checker_refuses_a_region_of_any_form_that_the_tube_never_meets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The files are of a tube that visits a box, and the task has another region. The digest agrees, so that it cannot be the reason."""
    assert {frozenset(form.split()) for form in (*REGIONS, *UNVISITED)} == set(map(frozenset, FORMS))
    controller = build_once(parse_task(mission_in("lower = [2, 2]\nupper = [3, 3]")))
    load = CheckedTask.__init__

    def load_with_digest(task: CheckedTask, data: bytes) -> None:
        load(task, data)
        task.digest = controller.task.digest

    monkeypatch.setattr(CheckedTask, "__init__", load_with_digest)
    verdicts = {
        form: tuple(checker_exit_code(mission_in(region), controller.files, tmp_path) for region in regions)
        for form, regions in {**REGIONS, **UNVISITED}.items()
    }
    assert verdicts == {**dict.fromkeys(REGIONS, (0, 1)), **dict.fromkeys(UNVISITED, (2, 2))}


def test_the_checker_refuses_a_region_with_fields_that_it_does_not_read() -> None:
    """Otherwise its list of half-spaces would be empty, and every point would satisfy it: a set without any is refused, too."""
    region = {"name": "dock", "corner": [2, 3]}
    with pytest.raises(Unusable, match="'corner'"):
        refuse_unknown_keys({"region": [region]})
    with pytest.raises(Unusable, match="without a half-space"):
        Inside(region, ["x", "y"], [Fraction(0)] * 2)


@pytest.mark.slow
def test_arenas_of_polygons_discs_and_capsules_are_certified_and_the_checker_agrees(tmp_path: Path) -> None:
    dice, certified = Random(7), 0
    for _ in range(10):
        sets = []
        for _ in range(6):
            x, y = dice.uniform(0.9, 4.1), dice.uniform(0.9, 4.1)
            near = [[round(x + dice.uniform(-0.6, 0.6), 3), round(y + dice.uniform(-0.6, 0.6), 3)] for _ in range(5)]
            radius = round(dice.uniform(0.1, 0.5), 3)
            sets.append(
                dice.choice(
                    (
                        f"vertices = {near}",
                        f"centre = {near[0]}\nradius = {radius}",
                        f"segment = {near[:2]}\nradius = {radius / 2}",
                    )
                )
            )
        text = FLAT + "".join(f"\n[[unsafe]]\n{t}\n" for t in sets)
        try:
            controller = build_once(parse_task(text))
        except SttError as refusal:
            assert str(refusal)
            continue
        certified += 1
        assert checker_exit_code(text, controller.files, tmp_path) == 0
        low, high = controller.design.edges_at(np.linspace(0, 9, 121))
        assert min(smallest_gap(controller.task, s, low, high) for s in controller.task.unsafe) > 0.03 - 1e-7
    assert certified >= 7


def test_the_loop_judges_by_the_true_shape() -> None:
    """Points are in the ball, in its growth by the body, and just outside of both but within every tangent plane that is tried."""
    controller = build_once(parse_task(text_of("disc", body=True)))
    loop = Loop(controller, PLANTS["integrator"])
    corner = np.array([2.5 + 0.1, 2.4 + 0.05])  # of the body's box about the centre; the grown disc has its arc about it
    angle = math.radians(67.5 / 4)  # between two normals of the fan
    for scale, is_hit in ((0.999, True), (1.001, False)):
        start = corner + 1.2 * scale * np.array([math.cos(angle), math.sin(angle)])
        assert starts_in_collision(loop, start) == is_hit
    rod_loop = Loop(build_once(parse_task(text_of("slanted rod"))), PLANTS["integrator"])
    middle = np.array([2, 2, 2.5])
    across = np.cross([2, -2, 3], [0.0, 0, 1])
    for scale, is_hit in ((0.999, True), (1.001, False)):
        start = middle + 0.4 * scale * across / np.linalg.norm(across)
        assert starts_in_collision(rod_loop, start) == is_hit


def starts_in_collision(loop: Loop, start: np.ndarray) -> bool:
    run = loop.run(Scenario(start=tuple(start.tolist())))
    return run.hit is not None and run.hit_at == 0


def test_disturbance_toward_a_ball_is_toward_its_centre() -> None:
    run = Loop(build_once(parse_task(text_of("ball"))), PLANTS["integrator"]).run(
        Scenario(disturbance="nearest", strength=0.1, start=(0.9, 1.3, 1.1)), trace=True
    )
    direction = np.array([2.5, 2.5, 2.4]) - [0.9, 1.3, 1.1]
    assert run.trace[0, 13:16] == pytest.approx(0.1 * direction / np.linalg.norm(direction), rel=1e-6)


# ------------------------------------------------------------------------------------------------------------- the shapes

numbers = st.integers(-32, 32).map(lambda k: Fraction(k, 8))  # decimals, so that a task may hold them


def vectors(n: int) -> st.SearchStrategy[tuple[Fraction, ...]]:
    return st.tuples(*[numbers] * n)


def boxes(n: int) -> st.SearchStrategy[BoxSet]:
    sizes = st.fractions(min_value=Fraction(1, 8), max_value=3, max_denominator=8)
    return st.tuples(vectors(n), st.tuples(*[sizes] * n)).map(
        lambda p: BoxSet(p[0], tuple(a + s for a, s in zip(*p, strict=True)))
    )


def clouds(n: int) -> st.SearchStrategy[list[tuple[Fraction, ...]]]:
    return st.lists(vectors(n), min_size=n + 1, max_size=n + 6, unique=True)


@given(clouds(2))
@settings(max_examples=200)
def test_a_hull_in_the_plane_has_the_corners_of_left_turns(points: Points) -> None:
    corners = hull(points)
    assert (affine_dimension(points) == 2) == (len(corners) > 2)
    assume(len(corners) > 2)
    hull_of_points = Hull.of(tuple(points))
    assert {v.point for v in hull_of_points.corners} == set(corners)
    assert len(hull_of_points.faces) == len(corners)


@pytest.mark.parametrize("n", [1, 3, 4])
@given(data=st.data())
@settings(max_examples=60, deadline=None)
def test_corners_and_faces_of_a_hull_agree(n: int, data: st.DataObject) -> None:
    points = data.draw(clouds(n))
    assume(affine_dimension(points) == n)
    hull_of_points = Hull.of(tuple(points))
    for normal, offset in hull_of_points.faces:
        values = [sum(c * v for c, v in zip(normal, p, strict=True)) for p in points]
        assert max(values) == offset
        assert math.gcd(*normal) == 1
        assert (
            affine_dimension([p for p, v in zip(points, values, strict=True) if v == offset]) == n - 1
        )  # the points on a face span it
    space = (Fraction(-5),) * n, (Fraction(5),) * n
    assert {v.point for v in cut_box(*space, hull_of_points.faces)} == {v.point for v in hull_of_points.corners}
    for v in hull_of_points.corners:  # no corner is in the hull of the others
        rest = [p for p in points if p != v.point]
        weights = linprog(
            [0.0] * len(rest),
            A_eq=[*np.array(rest, dtype=float).T.tolist(), [1.0] * len(rest)],
            b_eq=[*map(float, v.point), 1.0],
            bounds=(0, None),
        )
        assert weights.status == 2


@pytest.mark.parametrize("n", [2, 3, 4])
@given(data=st.data())
@settings(max_examples=80, deadline=None)
def test_a_polytope_is_apart_from_a_box_exactly_if_they_share_no_point(n: int, data: st.DataObject) -> None:
    points, box = data.draw(clouds(n)), data.draw(boxes(n))
    assume(affine_dimension(points) == n)
    task = parse_task(PLAIN).model_copy(update={"axes": tuple("abcd"[:n])})
    table = UnsafePolytope(vertices=points, axes=list("abcd"[:n]))
    oracle_gap = gap(task.model_copy(update={"state_space": box_table(n)}), table, *as_floats(box))
    assume(abs(oracle_gap) > 1e-7)
    polytope = Polytope(points)
    assert polytope.is_apart_from(box.lower, box.upper) == (oracle_gap > 0)
    if n <= 3:  # then one of the normals separates them
        assert any(minimum_over_box(m, box.lower, box.upper) > h for m, h in polytope.faces) == (oracle_gap > 0)
    half = tuple(Fraction(k + 1, 8) for k in range(n))
    grown_box = (
        tuple(a - h for a, h in zip(box.lower, half, strict=True)),
        tuple(b + h for b, h in zip(box.upper, half, strict=True)),
    )
    assert polytope.grown(half).is_apart_from(box.lower, box.upper) == polytope.is_apart_from(*grown_box)
    contains_corners = all(polytope.is_apart_from(c, c) is False for c in product(*zip(box.lower, box.upper, strict=True)))
    assert polytope.covers(box.lower, box.upper) == contains_corners


def box_table(n: int):
    """Return the table of the state space from -9 to 9 on n axes."""
    return parse_task(PLAIN).state_space.model_copy(update={"lower": (Fraction(-9),) * n, "upper": (Fraction(9),) * n})


def as_floats(box: BoxSet) -> tuple[np.ndarray, np.ndarray]:
    return np.array(box.lower, dtype=float), np.array(box.upper, dtype=float)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
@given(data=st.data())
@settings(max_examples=80, deadline=None)
def test_a_round_set_is_apart_exactly_if_the_distance_exceeds_its_radius(n: int, data: st.DataObject) -> None:
    ends, box = data.draw(st.lists(vectors(n), min_size=1, max_size=2, unique=True)), data.draw(boxes(n))
    radius = data.draw(st.fractions(min_value=Fraction(1, 8), max_value=3, max_denominator=8))
    round_set = RoundSet(tuple(ends), radius)
    line, (lower, upper) = np.array([ends[0], ends[-1]], dtype=float), as_floats(box)
    distance = float(distance_to_boxes(line, lower[None], upper[None])[0])
    assert float(round_set.core.squared_distance_to(box.lower, box.upper)) == pytest.approx(distance**2, abs=1e-9)
    assume(abs(distance - float(radius)) > 1e-6)
    assert round_set.is_apart_from(box.lower, box.upper) == (distance > radius)
    corners = np.array(list(product(*zip(box.lower, box.upper, strict=True))), dtype=float)
    farthest = float(distance_to_boxes(line, corners, corners).max())
    assume(abs(farthest - float(radius)) > 1e-6)
    assert round_set.covers(box.lower, box.upper) == (farthest <= radius)


@pytest.mark.parametrize("n", [2, 3, 4])
@given(data=st.data())
@settings(max_examples=60)
def test_the_support_of_a_round_set_is_rounded_up_by_at_most_2_to_the_minus_32(n: int, data: st.DataObject) -> None:
    ends = data.draw(st.lists(vectors(n), min_size=1, max_size=2, unique=True))
    normal = data.draw(st.tuples(*[st.integers(-9, 9)] * n).filter(any))
    round_set, square = RoundSet(tuple(ends), Fraction(3, 2)), sum(c * c for c in normal)
    assert square <= size(normal) ** 2 < (Fraction(1, 1 << 32) + math.isqrt(square) + 1) ** 2
    assert (size(normal) - Fraction(1, 1 << 32)) ** 2 < square
    core_support = max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in ends)
    assert round_set.support(normal) == core_support + Fraction(3, 2) * size(normal)


@pytest.mark.parametrize(("n", "excess"), [(2, 0.006), (3, 0.05)])
def test_the_tangent_planes_of_a_fan_enlarge_a_ball_by_little(n: int, excess: float) -> None:
    """About the unit ball the farthest corner of the polytope within all tangent planes is at 1 + excess at most."""
    corner = (Fraction(2),) * n
    corners = cut_box(tuple(-c for c in corner), corner, [(m, size(m)) for m in fan(n)])
    assert max(math.sqrt(sum(float(v) ** 2 for v in p.point)) for p in corners) < 1 + excess


@pytest.mark.parametrize("direction", [(7, 3, 0), (0, 2, 9), (1, 2, 7), (1, 1, 1), (1, 0, 0), (-5, 11, 13)])
def test_the_tangent_planes_of_the_fans_enlarge_a_long_capsule_by_little(direction: tuple[int, int, int]) -> None:
    """In a plane across the segment, the farthest point within all tangent planes that are parallel to the segment is below 1.006."""
    capsule = RoundSet(((Fraction(0),) * 3, tuple(Fraction(100 * v) for v in direction)), Fraction(1))
    across = [
        np.array(n) / np.linalg.norm(n) for n in capsule.normals if sum(a * b for a, b in zip(n, direction, strict=True)) == 0
    ]
    first_axis = across[0]
    second_axis = np.cross(np.array(direction) / np.linalg.norm(direction), first_axis)
    angles = sorted(math.atan2(float(n @ second_axis), float(n @ first_axis)) for n in across)
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + 2 * math.pi], strict=True)]
    assert 1 / math.cos(max(gaps) / 2) < 1.006


@given(clouds(2), vectors(2).map(lambda v: tuple(map(abs, v))))
@settings(max_examples=100)
def test_the_bends_in_the_plane_are_the_corners_of_the_grown_set(points: Points, half: tuple[Fraction, ...]) -> None:
    assume(affine_dimension(points) == 2)
    grown = [
        tuple(v + s * h for v, s, h in zip(p, signs, half, strict=True)) for p in points for signs in product((-1, 1), repeat=2)
    ]
    bends = [tuple(v + s * h for v, s, h in zip(p, signs, half, strict=True)) for p, signs in route_corners_of(Polytope(points))]
    assert set(hull(grown)) <= set(bends) <= set(grown)


@given(clouds(2), st.tuples(*[st.integers(-5, 5)] * 3))
@settings(max_examples=100)
def test_the_support_of_a_prism_is_the_greatest_over_its_vertices(points: Points, normal: tuple[int, int, int]) -> None:
    assume(affine_dimension(points) == 2)
    prism = Prism(Polytope(points), (2, 0), (Fraction(0), Fraction(-1), Fraction(0)), (Fraction(0), Fraction(3), Fraction(0)))
    assert prism.support(normal) == max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in prism.vertices)
    for n, offset in prism.faces:
        assert max(sum(c * v for c, v in zip(n, p, strict=True)) for p in prism.vertices) == offset
    for a, b in combinations(range(3), 2):
        shadow = {tuple(p) for p in outline(prism, (a, b)).tolist()}
        assert shadow <= {(float(p[a]), float(p[b])) for p in prism.vertices}


# ------------------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("vertices = [[1, 1], [2, 2]]", ["unsafe[0]", "vertices", "3 points"]),
        ("vertices = [[1, 1], [2, 2], [3, 3]]", ["vertices", "one line"]),
        ("vertices = [[1, 1], [2, 2], [3, 3, 3]]", ["vertices[2]", "3 entries"]),
        ("vertices = []", ["vertices", "list of points"]),
        ("vertices = 3", ["vertices", "list of points"]),
        ("vertices = [[1, 1], [2, 'a'], [3, 3]]", ["vertices[1][1]", "number"]),
        (f"vertices = {[[k, k * k] for k in range(65)]}", ["vertices", "65 points", "64"]),
        ('vertices = [[1, 1], [2, 1], [2, 2]]\naxes = ["x1"]', ["vertices[0]", "2 entries", "x1"]),
        ('vertices = [[1, 1], [2, 1], [2, 2]]\naxes = ["x1", "x3"]', ["axes", "x1, x2"]),
        ('vertices = [[1, 1], [2, 1], [2, 2]]\naxes = ["x1", "x1"]', ["axes", "different"]),
        ("centre = [1, 1]\nradius = 1\naxes = []", ["axes", "none"]),
        ("vertices = [[1, 1], [2, 1], [2, 2]]\nlower = [1, 1]", ["lower"]),
        ("vertices = [[0, 0], [2, 1], [2, 2]]", ["initial_set", "meets unsafe[0]"]),
        ("vertices = [[4, 4], [6, 4], [6, 6], [4, 6]]", ["target_set", "inside unsafe[0]"]),
        ("centre = [2, 2]", ["unsafe[0].radius", "missing"]),
        ("radius = 2", ["unsafe[0].centre", "missing"]),
        ("centre = [2, 2]\nradius = 0", ["unsafe[0].radius", "greater than 0"]),
        ("centre = [2, 2]\nradius = -1", ["unsafe[0].radius", "greater than 0"]),
        ("centre = [2]\nradius = 1", ["unsafe[0].centre", "1 entries", "axes"]),
        ("centre = [1, 1]\nradius = 0.8", ["initial_set", "meets unsafe[0]"]),
        ("centre = [4.75, 4.75]\nradius = 0.5", ["target_set", "inside unsafe[0]"]),
        ("segment = [[1, 1], [2, 2], [3, 3]]\nradius = 1", ["segment", "two are needed"]),
        ("segment = [[1, 1], [1, 1]]\nradius = 1", ["segment", "use centre"]),
        ("segment = [[1, 1], [2, 2]]", ["radius", "missing"]),
        ("normals = [[1, 1]]\noffsets = [1, 2]", ["offsets", "2 entries", "normals has 1"]),
        ("normals = [[0, 0]]\noffsets = [1]", ["normals[0]", "is 0"]),
        ("normals = [[1, 0], [-1, 0]]\noffsets = [1, -2]", ["normals", "nothing of the state space"]),
        ("normals = [[1, 0], [-1, 0]]\noffsets = [2, -2]", ["normals", "no interior"]),
        ("normals = [[1, 1]]", ["offsets", "missing"]),
        ("normals = [[1, 1]]\noffsets = [3]", ["initial_set", "meets unsafe[0]"]),
        ("centre = [2, 2]\nradius = 1\ncolour = 3", ["colour", "unknown key"]),
    ],
)
def test_malformed_unsafe_sets_are_refused(table: str, words: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        parse_task(PLAIN + f"\n[[unsafe]]\n{table}\n")
    assert all(word in str(caught.value) for word in words), caught.value


def test_a_disc_of_which_only_the_bounding_box_meets_the_start_is_accepted() -> None:
    assert parse_task(PLAIN + "\n[[unsafe]]\ncentre = [1, 1]\nradius = 0.7\n").dimension == 2


@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_the_papers_designs_refuse_sets_that_are_no_boxes(design: str) -> None:
    with pytest.raises(BadInput, match=r"unsafe\[0\].*refined"):
        parse_task(PLAIN + f'\n[[unsafe]]\ncentre = [2, 2]\nradius = 0.4\n[tube]\ndesign = "{design}"\n')


def test_a_set_of_fewer_numbers_names_its_axes() -> None:
    with pytest.raises(BadInput, match="unless axes names those of x, y, z"):
        parse_task(text_of("cylinder").replace('axes = ["x", "z"]\n', ""))


def test_points_inside_the_hull_add_only_a_note() -> None:
    corridor_with_inner_point = (CORRIDOR[0].replace("[5, 3.8]]", "[5, 3.8], [4, 1]]"), CORRIDOR[1])
    plain, with_inner_point = (
        parse_task(PLAIN + "".join(f"\n[[unsafe]]\n{t}\n" for t in sets)) for sets in (CORRIDOR, corridor_with_inner_point)
    )
    assert plain.obstacles == with_inner_point.obstacles
    assert task_notes(plain) == ()
    note = "its hull is 3.42 larger than its outline; list convex parts if that space is needed"
    assert task_notes(with_inner_point) == (f"unsafe U1: {note}",)


def test_a_box_that_names_all_axes_equals_the_box_without_axes() -> None:
    plain, named = (
        parse_task(PLAIN + f"\n[[unsafe]]\nlower = [2, 2]\nupper = [3, 3]\n{more}") for more in ("", 'axes = ["x1", "x2"]\n')
    )
    turned = parse_task(PLAIN + '\n[[unsafe]]\nlower = [2, 1]\nupper = [3, 4]\naxes = ["x2", "x1"]\n')
    assert plain.obstacles == named.obstacles
    assert [turned.obstacles[0].span(i) for i in (0, 1)] == [(1, 4), (2, 3)]
    assert not clipped(list(outline(turned.obstacles[0]).tolist()), BoxSet((Fraction(5),) * 2, (Fraction(6),) * 2))


# ----------------------------------------------------------------------------------------------- attacks of the past


def is_collision(task: Task, point: Sequence[float]) -> bool:
    """Return whether the loop's judge calls a point a collision, by a run of no samples that starts there."""
    field, n, x = JudgedSets(task), task.dimension, np.array(point, dtype=float)
    box = np.array([[s * float(i == k) for k in range(n)] + [1e6] for i in range(n) for s in (-1, 1)])
    setting = LoopSetting(
        n=n, sets=len(field.names), order=1, samples=0, integration_steps=1, period=1.0, end=1.0, start=x.ctypes.data,
        space_face_count=2 * n, target_face_count=2 * n,
        space_faces=box.ctypes.data, target_faces=box.ctypes.data, face_range_starts=field.face_range_starts.ctypes.data, faces=field.faces.ctypes.data,
        radius=field.radius.ctypes.data, segments=field.segments.ctypes.data,
    )  # fmt: skip
    verdict = LoopResult()
    driver(PLANTS["integrator"], n)(ctypes.byref(setting), None, None, None, ctypes.byref(verdict), None)
    return bool(verdict.hit >= 0)


def task_with_one_set(n: int, table: str, body: str = "") -> Task:
    """Return a task in n dimensions with one unsafe set far from start and target."""

    def box(low: float, high: float) -> str:
        return f"{{ lower = {[low] * n}, upper = {[high] * n} }}"

    names = [f"a{i}" for i in range(n)]
    return parse_task(
        f'name = "room"\naxes = {names}\nprescribed_time = 4\ninitial_state = {[-8.0] * n}\n{body}\n'
        f"state_space = {box(-9, 9)}\ninitial_set = {box(-8.2, -7.8)}\ntarget_set = {box(7.8, 8.2)}\n[[unsafe]]\n{table}\n"
    )


@pytest.mark.parametrize("n", [2, 3, 5])
def test_the_judge_of_round_sets_is_exact_to_rounding(n: int) -> None:
    """Points are within 1e-12 of the radius on both sides. Segments may be short and oblique, where projections converge slowly."""
    dice = Random(n)
    for _ in range(60):
        a = [Fraction(dice.randint(-200, 200), 100) for _ in range(n)]
        reach = dice.choice((1, 100, 10000))
        b = [v + Fraction(dice.randint(-200, 200), 100 * reach) for v in a]
        half = [Fraction(dice.randint(0, 50), 100) for _ in range(n)]
        if a == b:
            continue
        segment = RoundSet((tuple(a), tuple(b)), Fraction(1)).core
        x = [Fraction(dice.randint(-500, 500), 100) for _ in range(n)]
        box = tuple(v - h for v, h in zip(x, half, strict=True)), tuple(v + h for v, h in zip(x, half, strict=True))
        distance = math.sqrt(segment.squared_distance_to(*box))
        if not 0.01 < distance < 5:
            continue
        texts = [[f"{float(v):.8f}" for v in end] for end in (a, b)]
        ends = ", ".join(f"[{', '.join(e)}]" for e in texts)
        body = f"body = [{', '.join(f'{float(h):.2f}' for h in half)}]"
        for excess, is_hit in ((1e-12, True), (-1e-12, False)):
            task = task_with_one_set(n, f"segment = [{ends}]\nradius = {distance + excess * 8:.15f}", body)
            assert is_collision(task, [float(v) for v in x]) == is_hit


def test_the_judge_decides_polytopes_with_many_digits() -> None:
    dice = Random(1)
    digits = ", ".join(f"[{', '.join(f'{1 + (k == i)}.{dice.randrange(10**39):039d}' for k in range(5))}]" for i in range(6))
    task = task_with_one_set(5, f"vertices = [{digits}]")
    corners = np.array([[float(v) for v in p] for p in task.unsafe[0].vertices])
    assert is_collision(task, corners.mean(axis=0).tolist())
    assert not is_collision(task, (corners[0] + 1).tolist())


def test_sets_that_the_judge_cannot_decide_exactly_are_named() -> None:
    simplex = "vertices = [" + ", ".join(str([float(k == i) for k in range(4)]) for i in range(5)) + "]"
    assert enlarged_sets(task_with_one_set(4, simplex)) == []
    assert enlarged_sets(task_with_one_set(4, simplex, "body = [0.1, 0.1, 0.1, 0.1]")) == ["U1"]
    assert enlarged_sets(task_with_one_set(4, "centre = [0, 0, 0, 0]\nradius = 1", "body = [0.1, 0.1, 0.1, 0.1]")) == []
    assert (
        enlarged_sets(
            task_with_one_set(4, 'vertices = [[0, 0], [1, 0], [0, 1]]\naxes = ["a0", "a2"]', "body = [0.1, 0.1, 0.1, 0.1]")
        )
        == []
    )


def test_a_set_on_some_axes_is_unbounded_on_the_others() -> None:
    for table in ("lower = [1]\nupper = [2]", "centre = [1.5]\nradius = 0.5"):
        assert is_collision(task_with_one_set(2, f'{table}\naxes = ["a0"]'), (1.5, 20.0))


def test_a_refusal_between_round_sets_says_only_that_no_way_was_found() -> None:
    """A fan of tangent planes may close a gap that the balls leave."""
    gap = 0.02
    normal = [math.cos(math.radians(95.65)), math.sin(math.radians(95.65))]
    sets = "".join(
        f"\n[[unsafe]]\ncentre = [{2.5 + s * (2 + gap / 2) * normal[0]:.6f}, {2.5 + s * (2 + gap / 2) * normal[1]:.6f}]\nradius = 2\n"
        for s in (1, -1)
    )
    walls = "".join(f"\n[[unsafe]]\nlower = [2.4, {a}]\nupper = [2.6, {b}]\n" for a, b in ((-0.2, 0.6), (4.4, 5.2)))
    text = FLAT.replace("[0.25, 0.25]", "[0.1, 2.5]").replace(
        "lower = [0, 0], upper = [0.5, 0.5]", "lower = [0, 2.4], upper = [0.2, 2.6]"
    )
    text = text.replace("lower = [4.5, 4.5], upper = [5, 5]", "lower = [4.8, 2.4], upper = [5, 2.6]")
    with pytest.raises(SttError, match="no way was found"):
        build_once(parse_task(text + sets + walls))


def test_a_corner_near_a_grown_ball_is_judged_by_the_ball() -> None:
    """A point may be outside a ball grown by the body, but within all of its tangent planes."""
    task = task_with_one_set(2, "centre = [0, 0]\nradius = 2", "body = [0.05, 0.05]")
    (grown,) = task.obstacles
    angle = math.radians(5.65)
    for distance, is_inside in ((2.001, False), (1.999, True)):
        corner = tuple(Fraction(str(round(distance * v + 0.05, 6))) for v in (math.cos(angle), math.sin(angle)))
        assert grown.covers(corner, corner) == is_inside


@pytest.mark.parametrize("n", [9, 12, 64])
def test_balls_in_many_dimensions_are_read_within_20_seconds(n: int) -> None:
    begin = time.process_time()
    task = task_with_one_set(n, f"centre = {[0] * n}\nradius = 1", f"body = {[0.1] * n}")
    assert len(task.obstacles[0].route_corners) == 2 * n
    assert len(task.obstacles[0].normals) <= 2 * n * n
    assert time.process_time() - begin < 20  # listing all corners took hours


def test_polytopes_in_more_than_six_dimensions_are_refused() -> None:
    points = [[float(k == i) for k in range(8)] for i in range(9)]
    with pytest.raises(BadInput, match="at most 6 are taken, name them in axes"):
        task_with_one_set(8, f"vertices = {points}")


def test_sets_without_a_name_are_numbered_in_their_order() -> None:
    task = parse_task(PLAIN + "\n[[unsafe]]\ncentre = [2, 2]\nradius = 0.3\n\n[[unsafe]]\nlower = [3, 1]\nupper = [4, 2]\n")
    last = task.changed(unsafe=task.unsafe[1:])
    plain = parse_task(PLAIN + "\n[[unsafe]]\nlower = [3, 1]\nupper = [4, 2]\n")
    assert (last.digest, [s.name for s in last.unsafe]) == (plain.digest, ["U1"])
    assert [s.name for s in task.changed(unsafe=task.unsafe[::-1]).unsafe] == ["U1", "U2"]
    more = task.changed(unsafe=(task.unsafe[1], {"centre": [2.5, 4], "radius": 0.1}))
    assert [s.name for s in more.unsafe] == ["U1", "U2"]


@pytest.mark.parametrize(("radius", "words"), [(-1, "greater than 0"), ("a", "number")])
def test_a_set_that_was_copied_with_other_values_is_checked_again(radius: object, words: str) -> None:
    task = parse_task(PLAIN + "\n[[unsafe]]\ncentre = [2, 2]\nradius = 0.3\n")
    with pytest.raises(BadInput, match=words):
        task.changed(unsafe=[task.unsafe[0].model_copy(update={"radius": radius})])
    copied = task.changed(unsafe=[task.unsafe[0].model_copy(update={"radius": 0.25})])
    assert copied.digest == parse_task(PLAIN + "\n[[unsafe]]\ncentre = [2, 2]\nradius = 0.25\n").digest
