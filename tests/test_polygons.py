"""Unsafe polygons from a task file to the checker: in the plane, and as prisms in the plane of two named axes."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_sets import PLAIN, Points, clipped, hull

from stt_codegen.certify import checker
from stt_codegen.designs.grid import tube_at
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, SttError
from stt_codegen.pipeline import build_program, build_task, certify
from stt_codegen.program.cost import cost_of
from stt_codegen.report.picture import draw
from stt_codegen.task import parse_task
from stt_codegen.task.sets import BoxSet, Prism, hull_of_points

# Two triangles with a slanted corridor between them; their bounding boxes overlap and close it.
CORRIDOR = """
[[unsafe]]
name = "right"
vertices = [[1.2, 0], [5, 0], [5, 3.8]]

[[unsafe]]
name = "left"
vertices = [[0, 1.2], [3.8, 5], [0, 5]]
"""
SOLID = """name = "ramp"
axes = ["x", "height", "y"]
prescribed_time = 9
initial_state = [0.25, 0.5, 0.25]
body = [0.05, 0.1, 0.05]
state_space = { lower = [-0.1, 0, -0.1], upper = [5.1, 2, 5.1] }
initial_set = { lower = [0, 0.3, 0], upper = [0.5, 0.8, 0.5] }
target_set = { lower = [4.5, 0.3, 4.5], upper = [5, 0.8, 5] }

[[unsafe]]
name = "right"
vertices = [[1.5, 0], [5, 0], [5, 3.5]]
axes = ["x", "y"]

[[unsafe]]
name = "left"
vertices = [[1.5, 0], [5, 3.5], [5, 0]]
axes = ["y", "x"]
"""


def checked(text: str, files: dict[str, bytes], folder: Path) -> int:
    name = next(n for n in files if n.endswith(".c"))[:-2]
    for file, data in {**files, "task.toml": text.encode()}.items():
        (folder / file).write_bytes(data)
    return checker.main([str(folder / n) for n in ("task.toml", f"{name}.c", f"{name}.certificate.json")])


@pytest.mark.parametrize("text", [PLAIN + CORRIDOR, SOLID])
def test_a_corridor_between_slanted_sets_is_found_proved_and_checked(text: str, tmp_path: Path) -> None:
    task = parse_task(text)
    made = build_task(task)
    assert made.certificate.holds
    assert checked(text, made.files, tmp_path) == 0
    keep, rounding = task.tube.clearance, Fraction(1, 1 << 40)
    low, high = tube_at(made.design, np.linspace(0, 9, 1501))
    for one in task.unsafe:
        i, j = task.plane_of(one)
        reach = [keep + task.half_extents[k] - rounding for k in (i, j)]
        for a, b in zip(low.tolist(), high.tolist(), strict=True):
            box = BoxSet(tuple(Fraction(a[k]) - r for k, r in zip((i, j), reach, strict=True)),
                         tuple(Fraction(b[k]) + r for k, r in zip((i, j), reach, strict=True)))  # fmt: skip
            assert not clipped(list(one.corners), box)
    bare = parse_task(text.split("\n[[unsafe]]", maxsplit=1)[0])
    assert cost_of(made.program, "control") == cost_of(build_task(bare).program, "control")
    draw(made, tmp_path / "drawn.png")
    assert (tmp_path / "drawn.png").stat().st_size > 5000


@pytest.mark.parametrize("text", [PLAIN + CORRIDOR, SOLID])
def test_a_set_pushed_into_the_tube_is_refused_by_certificate_and_checker_at_the_same_place(text: str, tmp_path: Path) -> None:
    """The first set's points are moved along a diagonal; the truth is a hull clipped by boxes at dense times, an oracle apart."""
    task = parse_task(text)
    made = build_task(task)
    error = made.certificate.edge_error
    low, high = tube_at(made.design, np.linspace(0, 9, 8 * made.design.segments + 1))
    verdicts = []
    for k in range(0, 100, 8):
        moved = [[f"{float(x) - 0.01 * k:.4f}", f"{float(y) + 0.01 * k:.4f}"] for x, y in task.unsafe[0].vertices]
        old = text.split("vertices = ")[1].split("\n", maxsplit=1)[0]
        other = text.replace(old, "[" + ", ".join(f"[{x}, {y}]" for x, y in moved) + "]", 1)
        try:
            changed = parse_task(other)
        except BadInput:
            continue  # it has come to the start
        found = certify(changed, made.design, build_program(changed, made.design))
        verdicts.append(found.tube_holds)
        files = render(changed, made.design, made.program, found)
        assert (checked(other, files, tmp_path) == 0) == found.holds
        one = changed.unsafe[0]
        plane = changed.plane_of(one)
        spare = Fraction(-1, 1 << 40) if found.holds else max(error) + Fraction(1, 100)
        reach = [changed.tube.clearance + changed.half_extents[i] + spare for i in plane]
        meets = any(
            clipped(list(one.corners), BoxSet(tuple(Fraction(a[i]) - r for i, r in zip(plane, reach, strict=True)),
                                              tuple(Fraction(b[i]) + r for i, r in zip(plane, reach, strict=True))))
            for a, b in zip(low.tolist(), high.tolist(), strict=True)
        )  # fmt: skip
        assert meets != found.holds
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


def test_arenas_of_polygons_are_certified_and_the_checker_agrees(tmp_path: Path) -> None:
    """What is certified keeps off every polygon, by the oracle; what is refused has a reason."""
    dice, certified = Random(7), 0
    for _ in range(12):
        sets = []
        for j in range(6):
            x, y = dice.uniform(0.8, 4.2), dice.uniform(0.8, 4.2)
            points = [(round(x + dice.uniform(-0.6, 0.6), 3), round(y + dice.uniform(-0.6, 0.6), 3)) for _ in range(5)]
            sets.append(f'\n[[unsafe]]\nname = "P{j}"\nvertices = {[list(p) for p in points]}\n')
        text = PLAIN + "".join(sets)
        try:
            made = build_task(parse_task(text))
        except SttError as refusal:
            assert str(refusal)
            continue
        certified += 1
        assert checked(text, made.files, tmp_path) == 0
        low, high = tube_at(made.design, np.linspace(0, 9, 301))
        for one in made.task.unsafe:
            keep = made.task.tube.clearance - Fraction(1, 1 << 40)
            for a, b in zip(low.tolist(), high.tolist(), strict=True):
                assert not clipped(
                    list(one.corners), BoxSet(tuple(Fraction(v) - keep for v in a), tuple(Fraction(v) + keep for v in b))
                )
    assert certified >= 8


numbers = st.fractions(min_value=-4, max_value=4, max_denominator=8)


@given(st.lists(st.tuples(numbers, numbers), min_size=3, max_size=9, unique=True), st.tuples(*[st.integers(-5, 5)] * 3))
@settings(max_examples=200)
def test_the_support_of_a_prism_is_the_greatest_over_its_vertices(given_points: Points, normal: tuple[int, int, int]) -> None:
    corners = hull_of_points(given_points)
    assert list(corners) == hull(given_points)
    if len(corners) < 3:
        return
    prism = Prism(corners, (2, 0), (Fraction(0), Fraction(-1), Fraction(0)), (Fraction(0), Fraction(3), Fraction(0)))
    assert prism.support(normal) == max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in prism.vertices)
    assert len(prism.vertices) == 2 * len(corners)
    # every face holds all points, and two corners lie on it
    for n, offset in prism.faces[6:]:
        values = [n[2] * x + n[0] * y for x, y in corners]
        assert max(values) == offset
        assert values.count(offset) == 2


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("vertices = [[1, 1], [2, 2]]", ["unsafe[0]", "vertices", "three points"]),
        ("vertices = [[1, 1], [2, 2], [3, 3]]", ["vertices", "one line"]),
        ("vertices = [[1, 1], [2, 2], [3, 3, 3]]", ["vertices[2]", "3 entries"]),
        ("vertices = []", ["vertices", "list of points"]),
        ("vertices = 3", ["vertices", "list of points"]),
        ("vertices = [[1, 1], [2, 'a'], [3, 3]]", ["vertices[1][1]", "number"]),
        ('vertices = [[1, 1], [2, 1], [2, 2]]\naxes = ["x1"]', ["axes", "two different"]),
        ('vertices = [[1, 1], [2, 1], [2, 2]]\naxes = ["x1", "x3"]', ["axes", "x1, x2"]),
        ("vertices = [[1, 1], [2, 1], [2, 2]]\nlower = [1, 1]", ["lower"]),
        ("vertices = [[0, 0], [2, 1], [2, 2]]", ["initial_set", "meets unsafe[0]"]),
        ("vertices = [[4, 4], [6, 4], [6, 6], [4, 6]]", ["target_set", "inside unsafe[0]"]),
    ],
)
def test_points_that_are_no_polygon_are_refused(table: str, words: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        parse_task(PLAIN + f"\n[[unsafe]]\n{table}\n")
    assert all(word in str(caught.value) for word in words), caught.value


def test_a_polygon_in_space_names_its_axes() -> None:
    with pytest.raises(BadInput, match="name two of x, height, y"):
        parse_task(SOLID.replace('axes = ["x", "y"]\n', "", 1))


def test_points_inside_the_hull_change_nothing_but_a_note() -> None:
    more = CORRIDOR.replace("[5, 3.8]]", "[5, 3.8], [4, 1]]")
    plain, other = (parse_task(PLAIN + text) for text in (CORRIDOR, more))
    assert plain.obstacles == other.obstacles
    assert (plain.hulls, other.hulls) == ((), ("right",))
