"""Concave rooms by outline and holes, from the task file to the checker.

benchmarks/oracles/rooms.py judges them by the corners that the task lists, without the package's partition into convex sets.
"""

from __future__ import annotations

import io
import json
import tomllib
import zipfile
from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from benchmarks import rooms
from benchmarks.oracles.rooms import ListedRoom, contains_box, corners_of, partition_fault, room_from_numbers, times_outside
from stt_codegen.checker import check_files
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build
from stt_codegen.record.check import check
from stt_codegen.record.package import KINDS, package
from stt_codegen.report.notes import task_notes
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.map.floor_plans import partition
from stt_codegen.task.map.polygons import convex_pieces
from stt_codegen.task.task import Task
from tests.support.command_line import run_command
from tests.support.controllers import ROOT, build_once
from tests.task.test_maps import FREE, OCCUPIED, YAML, save_map

CORNERS = "[[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]"
ELL = f"""name = "ell"
prescribed_time = 10
initial_state = [3.6, 0.5]
[state_space]
outline = {CORNERS}
[initial_set]
lower = [3.5, 0.4]
upper = [3.7, 0.6]
[target_set]
lower = [0.4, 3.5]
upper = [0.6, 3.7]
[tube]
clearance = 0.05
[[unsafe]]
name = "box"
lower = [0.5, 0.3]
upper = [2.6, 2.1]
"""
BY_VERTICES = ELL.replace("outline = ", "lower = [0, 0]\nupper = [4, 4]\nvertices = ")
DATA = {
    "name": "ell", "prescribed_time": 10, "initial_state": [3.6, 0.5],
    "state_space": {"outline": json.loads(CORNERS)},
    "initial_set": {"lower": [3.5, 0.4], "upper": [3.7, 0.6]}, "target_set": {"lower": [0.4, 3.5], "upper": [0.6, 3.7]},
    "tube": {"clearance": 0.05}, "unsafe": [{"name": "box", "lower": [0.5, 0.3], "upper": [2.6, 2.1]}],
}  # fmt: skip
SHORT = ELL.partition("[[unsafe]]")[0]
SOLID = SHORT.replace('name = "ell"', 'name = "ell"\naxes = ["x", "heading", "y"]\nbody = [0.1, 0, 0.05]').replace(
    "[3.6, 0.5]", "[0.5, 0, 3.6]"
).replace("[3.5, 0.4]", "[0.4, -0.1, 3.5]").replace("[3.7, 0.6]", "[0.6, 0.1, 3.7]").replace(
    "[0.4, 3.5]", "[3.5, 0.4, 0.4]"
).replace("[0.6, 3.7]", "[3.7, 0.8, 0.6]").replace("outline =", 'axes = ["y", "x"]\nlower = [-1]\nupper = [1]\noutline =')  # fmt: skip


def listed_room_of(text: str) -> ListedRoom:
    """Return the room of a task's text as the oracle takes it: corners of the outline and of the holes."""
    space = tomllib.loads(text)["state_space"]
    return room_from_numbers(space["outline"], space.get("holes", []))


# ------------------------------------------------------------------------------------------- an L, from its file to the checker


@pytest.mark.parametrize("field", ["state_space", "target_set"])
def test_concave_vertices_of_the_state_space_or_target_are_refused(field: str) -> None:
    text = BY_VERTICES
    if field == "target_set":
        text = SHORT.replace(
            "upper = [0.6, 3.7]", "upper = [0.6, 3.7]\nvertices = [[0.4, 3.5], [0.6, 3.5], [0.48, 3.52], [0.4, 3.7]]"
        )
    with pytest.raises(BadInput) as caught:
        parse_task(text)
    index, words = (3, "outline = [..]") if field == "state_space" else (2, "convex part")
    assert f"{field}.vertices[{index}]: lies inside the hull of the others; a set is convex" in str(caught.value)
    assert words in str(caught.value)


@pytest.mark.parametrize("extra_point", ["[2, 0]", "[0, 0]"], ids=["on a side", "closing"])
def test_points_on_the_boundary_of_the_hull_do_no_harm(extra_point: str) -> None:
    convex = BY_VERTICES.replace(", [2, 2], [2, 4]", "")
    task = parse_task(convex.replace("[0, 4]]", f"[0, 4], {extra_point}]"))
    assert sorted(task.space_cuts) == sorted(parse_task(convex).space_cuts)


def test_the_outline_of_an_ell_is_certified_and_checked_and_its_tube_is_in_it(tmp_path: Path) -> None:
    """This is the remedy that the message names: the same corners as an outline, also beside lower and upper."""
    (tmp_path / "ell.toml").write_text(BY_VERTICES.replace("vertices =", "outline ="))
    controller = build(tmp_path / "ell.toml")
    assert controller.certificate.holds
    assert (
        times_outside(
            listed_room_of(ELL), controller.design, (0, 1), (Fraction(0),) * 2, clearance=Fraction("0.05"), times_per_segment=16
        )
        == []
    )
    for name, data in controller.files.items():
        (tmp_path / name).write_bytes(data)
    paths = [str(tmp_path / n) for n in ("ell.task.toml", "ell.c", "ell.certificate.json")]
    assert check_files(paths) == 0
    assert check_files([str(tmp_path / "ell.toml"), *paths[1:]]) == 2  # the checker reads no outlines
    expanded = load_task(tmp_path / "ell.task.toml")
    assert (expanded.digest, expanded.obstacles) == (controller.task.digest, controller.task.obstacles)
    assert [s.name for s in expanded.unsafe] == ["box", "wall1"]
    assert task_notes(controller.task) == (
        "state_space: the outline is a box less 1 convex unsafe set, wall1, an exact partition",
    )
    assert task_notes(expanded) == ()
    assert controller.files == build_once(Task(**DATA)).files


def test_design_and_generate_print_the_number_of_sets_of_an_outline(tmp_path: Path) -> None:
    (tmp_path / "ell.toml").write_text(ELL)
    designed = run_command("design", str(tmp_path / "ell.toml"), "--json")
    assert "less 1 convex unsafe set, wall1" in json.loads(designed.stdout)["notes"][0]
    generated = run_command("generate", str(tmp_path / "ell.toml"), "--record", str(tmp_path / "generated"))
    assert generated.returncode == 0
    assert "less 1 convex unsafe set, wall1" in generated.stderr
    assert check(tmp_path / "generated").differences == ()


def test_python_tables_arrays_and_changed_give_the_same_task() -> None:
    task = Task(**DATA)
    corners = np.array(json.loads(CORNERS))
    assert task == parse_task(ELL) == Task(**{**DATA, "state_space": {"outline": corners}})
    later = task.changed(prescribed_time=12)
    assert later == parse_task(ELL.replace("prescribed_time = 10", "prescribed_time = 12"))
    assert later.changed(state_space={"holes": [[[1, 0.05], [1.2, 0.05], [1.1, 0.2]]]}).unsafe[2].name == "wall2"
    assert Task.model_validate(task).expanded_text == task.expanded_text


def test_a_room_on_two_of_three_axes_with_a_body_is_certified(tmp_path: Path) -> None:
    """The axes of the outline are the third and the first. Walls grow by the body, and the state space shrinks."""
    controller = build_once(parse_task(SOLID))
    assert controller.task.state_space.lower == (0, -1, 0)
    assert controller.certificate.holds
    body = [Fraction("0.1"), Fraction(0), Fraction("0.05")]
    assert times_outside(listed_room_of(SOLID), controller.design, (2, 0), body, clearance=Fraction("0.05")) == []
    for name, data in controller.files.items():
        (tmp_path / name).write_bytes(data)
    assert check_files([str(tmp_path / n) for n in ("ell.task.toml", "ell.c", "ell.certificate.json")]) == 0


def test_a_map_and_an_outline_can_be_combined(tmp_path: Path) -> None:
    """The expanded task has the sets of both."""
    pixels = np.full((90, 90), FREE)
    pixels[20:40, 0:20] = OCCUPIED
    save_map(tmp_path, pixels, YAML.replace("[-1.0, 0.5, 0.0]", "[-0.2, -0.2, 0.0]"))
    (tmp_path / "ell.toml").write_text(SHORT + '[map]\nfile = "hall.yaml"\n')
    controller = build(tmp_path / "ell.toml")
    assert controller.task.expanded_keys == ("map", "outline")
    assert {s.name for s in controller.task.unsafe} == {"map 1", "wall1"}
    for name, data in controller.files.items():
        (tmp_path / name).write_bytes(data)
    assert load_task(tmp_path / "ell.task.toml").digest == controller.task.digest
    assert check_files([str(tmp_path / n) for n in ("ell.task.toml", "ell.c", "ell.certificate.json")]) == 0


def test_a_closing_corner_and_corners_on_a_side_do_no_harm() -> None:
    longer = SHORT.replace("[4, 0], ", "[2, 0], [4, 0], [4, 0], ").replace("[0, 4]]", "[0, 4], [0, 0]]")
    assert parse_task(longer).digest == parse_task(SHORT).digest


def test_names_of_walls_differ_from_those_of_the_task() -> None:
    task = parse_task(ELL.replace('name = "box"', 'name = "wall1"'))
    assert [s.name for s in task.unsafe] == ["wall1", "wall2"]


def test_a_box_beside_the_outline_cuts_the_room_and_drops_walls_beyond_it() -> None:
    task = parse_task(SHORT.replace("outline", "lower = [-9, 0]\nupper = [3.8, 9]\noutline"))
    assert (task.state_space.lower, task.state_space.upper) == ((0, 0), (Fraction("3.8"), 4))
    low_room = (
        SHORT.replace("[0.4, 3.5]", "[0.4, 0.5]")
        .replace("[0.6, 3.7]", "[0.6, 0.7]")
        .replace("outline", "lower = [0, 0]\nupper = [4, 1]\noutline")
    )
    assert parse_task(low_room).unsafe == ()
    assert parse_task(low_room.replace("upper = [4, 1]", "upper = [4, 1.94]")).unsafe == ()
    assert (
        len(parse_task(low_room.replace("upper = [4, 1]", "upper = [4, 1.95]")).unsafe) == 1
    )  # at the distance of the clearance


def test_the_room_of_the_documents_is_certified() -> None:
    text = (ROOT / "docs" / "task.md").read_text()
    example = text.partition("## Concave rooms")[2].split("```")[1].removeprefix("toml\n")
    assert build_once(parse_task(example)).certificate.holds
    assert [s.name for s in parse_task(example).unsafe] == ["wall1", "wall2"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_package_contains_the_expanded_task_for_the_checker(kind: str) -> None:
    files = package(build_once(parse_task(ELL.replace("[tube]", "[emit]\nrust = true\n[tube]"))), kind)
    units = [zipfile.ZipFile(io.BytesIO(data)).namelist() for path, data in files.items() if path.endswith(".fmu")]
    assert all(any(name.endswith("ell.task.toml") for name in names) for names in units or [list(files)])


# ---------------------------------------------------------------------------------------------------------- malformed rooms


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (CORNERS, "[[0, 0], [4, 4], [4, 0], [0, 4]]", ["outline[2]", "from outline[0] to outline[1]", "in order"]),
        (CORNERS, "[[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]]", ["outline", "meets the side", "in order"]),
        (CORNERS, "[[0, 0], [4, 0], [2, 0], [2, 4]]", ["outline[1]", "meets the side", "in order"]),
        (CORNERS, "[[0, 0], [4, 0], [2, 0]]", ["outline", "no area"]),
        (CORNERS, "[[0, 0], [4, 0], [0, 0]]", ["outline", "2 different corners", "three"]),
        (CORNERS, "[[0, 0], [4, 0], [4, 4, 1]]", ["outline[2]", "3 entries", "[x, y]"]),
        (CORNERS, "[]", ["outline", "empty list"]),
        (CORNERS, str([[k % 2 + 0.001 * k, k] for k in range(401)]), ["outline", "401", "400"]),
        (CORNERS, f"{CORNERS}\nholes = [[[1, 1], [3, 1], [3, 3]]]", ["holes[0][1]", "meets", "outline[2] to outline[3]", "[[unsafe]]"]),
        (CORNERS, f"{CORNERS}\nholes = [[[0, 1], [1, 1], [1, 0.5]]]", ["holes[0][0]", "outline[5] to outline[0]", "at the wall"]),
        (CORNERS, f"{CORNERS}\nholes = [[[3, 3], [3.5, 3], [3.5, 3.5]]]", ["holes[0]", "outside of the outline", "inside"]),
        (CORNERS, f"{CORNERS}\nholes = [[[1, 1], [1, 1.9], [1.9, 1]], [[1.2, 1.2], [1.9, 1.2], [1.9, 1.9]]]",
         ["holes[1]", "meets", "holes[0][", "one hole"]),
        (CORNERS, f"{CORNERS}\nholes = [[[1.1, 1.1], [1.2, 1.1], [1.1, 1.2]], [[1, 1], [1, 1.9], [1.9, 1]]]",
         ["holes[0]", "inside holes[1]", "leave it out"]),
        (CORNERS, f"{CORNERS}\nholes = [[[1, 1], [1.5, 1.5], [1.5, 1], [1, 1.5]]]", ["holes[0][2]", "meets the side", "in order"]),
        (CORNERS, f"{CORNERS}\nholes = [[1, 1], [2, 2]]", ["holes[0][0]", "list of numbers"]),
        (CORNERS, f"{CORNERS}\nvertices = [[0, 0], [1, 0], [0, 1]]", ["outline", "beside vertices"]),
        (CORNERS, f'{CORNERS}\naxes = ["x1"]', ["state_space.axes", "two different ones of x1, x2"]),
        (CORNERS, f"{CORNERS}\nlower = [0]\nupper = [1]", ["state_space.lower", "1 entries"]),
        (CORNERS, f"{CORNERS}\nlower = [5, 0]\nupper = [6, 4]", ["outline", "x1", "leave nothing"]),
        (f"outline = {CORNERS}", "holes = [[[0, 0], [1, 0], [0, 1]]]", ["state_space.holes", "outline"]),
        (f"outline = {CORNERS}", "", ["state_space.lower", "missing"]),
        ("[0.4, 3.5]\nupper = [0.6, 3.7]", "[3, 3]\nupper = [3.2, 3.2]", ["target_set", "wall1, which state_space.outline leaves out"]),
    ],
)  # fmt: skip
def test_malformed_rooms_are_refused(old: str, new: str, words: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        parse_task(SHORT.replace(old, new, 1))
    assert all(word in str(caught.value) for word in words), caught.value


def test_a_wall_that_a_design_cannot_take_is_named() -> None:
    slanted = parse_task(SHORT.replace("[2, 2], [2, 4]", "[2, 2.5], [2, 4]"))
    with pytest.raises(BadInput, match="^wall1, which state_space.outline leaves out of its box.*refined"):
        slanted.with_options(design="adaptive")
    assert parse_task(SHORT).with_options(design="adaptive").floor_plan == parse_task(SHORT).floor_plan  # its wall is a box


def test_a_room_in_more_dimensions_names_its_axes() -> None:
    with pytest.raises(BadInput, match="state_space.axes: are missing; .* two of x, heading, y"):
        parse_task(SOLID.replace('axes = ["y", "x"]\n', ""))
    with pytest.raises(BadInput, match="state_space.lower: is missing; give one for heading, or for all of x, heading, y"):
        parse_task(SOLID.replace("lower = [-1]\nupper = [1]\n", ""))


# ---------------------------------------------------------------------------------------------------------- unsafe sets, regions


def test_a_note_says_how_much_the_hull_of_an_unsafe_set_adds() -> None:
    """The L, a quarter of the size, leaves a square of side 0.5, and half of that square is inside the hull."""
    table = f'[[unsafe]]\nname = "O2"\nvertices = {CORNERS.replace("4", "1").replace("2", "0.5")}\n'
    plain = SHORT.replace(f"outline = {CORNERS}", "lower = [-1, -1]\nupper = [9, 9]").replace("[tube]", table + "[tube]")
    plain = plain.replace("[3.6, 0.5]", "[3.6, 2.5]").replace("[3.5, 0.4]", "[3.5, 2.4]").replace("[3.7, 0.6]", "[3.7, 2.6]")
    note = "its hull is 0.125{} larger than its outline; list convex parts if that space is needed"
    assert task_notes(parse_task(plain)) == (f"unsafe O2: {note.format('')}",)
    assert task_notes(parse_task('units = ["m", "m"]\n' + plain)) == (f"unsafe O2: {note.format(' m^2')}",)
    shuffled = plain.replace("[0.5, 0.5], [0.5, 1]", "[0.5, 1], [0.5, 0.5]").replace("[1, 0], [1, 0.5]", "[1, 0.5], [1, 0]")
    assert task_notes(parse_task(shuffled)) == (
        "unsafe O2: its vertices are not all corners of their hull; the hull is what is avoided",
    )


@pytest.mark.parametrize(
    ("entry", "is_refused"),
    [
        ('visit = "bend"', True),
        ('visit = "both"', True),
        ('formula = "not eventually bend"', False),
        ('formula = "not always not bend"', True),
        ('never = "both"', False),
    ],
)
def test_a_concave_region_is_refused_to_be_in_and_noted_to_avoid(entry: str, is_refused: bool) -> None:
    region = '[[region]]\nname = "bend"\nvertices = [[2, 2], [3, 2], [3, 2.2], [2.2, 2.2], [2.2, 3], [2, 3]]\n'
    region += (
        '[[region]]\nname = "spot"\nlower = [1, 3]\nupper = [2, 3.5]\n[[region]]\nname = "both"\nany_of = ["spot", "bend"]\n'
    )
    text = SHORT.replace(f"outline = {CORNERS}", "lower = [0, 0]\nupper = [4, 4]") + f"{region}[[mission]]\n{entry}\n"
    if is_refused:
        with pytest.raises(BadInput, match=r"mission\[0\].*region bend, vertices\[3\]: lies inside .* any_of"):
            parse_task(text)
    else:
        assert "region bend: its hull is 0.32 larger" in task_notes(parse_task(text))[0]


# ------------------------------------------------------------------------------------------------- laws of the partition


@pytest.mark.parametrize("first", range(0, 60, 20))
def test_walls_are_convex_and_fill_exactly_the_box_outside_the_room(first: int) -> None:
    """Rooms are stars and mazes with holes, on two of two or more axes."""
    for seed in range(first, first + 20):
        drawn = rooms.draw_room(seed)
        task = parse_task(rooms.task_text(drawn))
        assert partition_fault(drawn.listed_room, [corners_of(table) for table in task.unsafe]) is None, seed


coordinates = st.integers(-3, 3)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=4, max_size=12, unique=True), st.randoms(use_true_random=False))
@example([(0, 0), (4, 0), (4, 4), (2, 3), (2, 2), (1, 3)], Random(0))  # a cut through a corner
@settings(max_examples=300, deadline=None)
def test_any_simple_polygon_is_partitioned_exactly(points: list[tuple[int, int]], chance) -> None:
    """Corners are on a coarse grid, so that many lie on one line or on the box. A polygon becomes simple by reversing crossing parts."""
    from stt_codegen.task.map.polygons import touching_sides, twice_area, without_straight_corners

    for _ in range(60):
        sides = touching_sides(points)
        if sides is None:
            break
        i, j = sorted(sides)
        points = points[: i + 1] + points[i + 1 : j + 1][::-1] + points[j + 1 :]
    if touching_sides(points) is not None or not twice_area(points):
        return
    listed_room = room_from_numbers(points)
    if chance.random() < 0.5:
        points = points[::-1]
    scaled = [[(Fraction(x), Fraction(y)) for x, y in piece] for piece in partition(points, [])]
    assert partition_fault(listed_room, scaled) is None
    inner = [[(Fraction(x), Fraction(y)) for x, y in piece] for piece in convex_pieces(points)]
    bend_count = len(without_straight_corners(points))
    assert sum(abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(p, p[1:] + p[:1], strict=True))) for p in inner) == abs(
        twice_area(points)
    )
    assert len(inner) <= bend_count - 2 or all(
        a[0] == b[0] or a[1] == b[1] for a, b in zip(points, points[1:] + points[:1], strict=True)
    )


def test_certified_rooms_contain_their_tubes() -> None:
    """These are three of the rooms that benchmarks/rooms.py measures."""
    assert {rooms.judge_room(seed, 2, False).outcome for seed in (6, 9, 11)} == {"certified"}


def test_the_oracle_of_rooms_recognizes_a_box_outside() -> None:
    """Boxes by hand: in the L, across its inner corner, in the corner that the L leaves out, and touching a wall."""
    listed_room = listed_room_of(ELL)

    def inside(*values: float, clearance: float = 0) -> bool:
        a, b, c, d = (Fraction(str(v)) for v in values)
        return contains_box(listed_room, ((a, b), (c, d)), Fraction(str(clearance)))

    assert inside(0, 0, 2, 2)
    assert inside(0, 0, 4, 2)
    assert not inside(1.9, 1.9, 2.1, 2.1)
    assert not inside(3, 3, 3.5, 3.5)
    assert not inside(0, 0, 3, 2, clearance=0.1)
    assert inside(0, 0, 1.8, 4, clearance=0.1)


def test_options_of_the_command_line_stay_where_a_room_is_changed() -> None:
    """A remedy is tried in the scalar that the command line asks for."""
    task = parse_task(ELL).with_options(scalar="double")
    assert task.changed(prescribed_time=2 * task.prescribed_time).emit.scalar == "double"
