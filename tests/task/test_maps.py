"""Occupancy maps: which cells are unsafe, which convex sets replace them, and a task with a map from its file to the checker."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from typer.testing import CliRunner

from stt_codegen.checker import check_files
from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build
from stt_codegen.report.pictures.map_pictures import map_report
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.map.convex_pieces import count_free_cells_in, cover_cells, unsafe_tables
from stt_codegen.task.map.map_table import to_toml
from stt_codegen.task.map.occupancy import read_map
from stt_codegen.task.map.upright import write_upright_map
from stt_codegen.task.sets.convex_sets import minimum_over_box
from tests.support.command_line import run_command

YAML = "image: {image}\nresolution: 0.05\norigin: [-1.0, 0.5, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
TASK = """name = "hall"
prescribed_time = 20
initial_state = [-0.7, 0.8]
state_space = { lower = [-1, 0.5], upper = [2, 2.5] }
initial_set = { lower = [-0.8, 0.7], upper = [-0.6, 0.9] }
target_set = { lower = [1.6, 2.1], upper = [1.8, 2.3] }

[map]
file = "hall.yaml"
"""
FREE, OCCUPIED, UNKNOWN = 254, 0, 205


def save_map(folder: Path, pixels: np.ndarray, text: str = YAML, name: str = "hall") -> Path:
    """Write NAME.png and NAME.yaml into the folder, and return the path of the YAML."""
    Image.fromarray(pixels.astype(np.uint8)).save(folder / f"{name}.png")
    (folder / f"{name}.yaml").write_text(text.format(image=f"{name}.png"))
    return folder / f"{name}.yaml"


def hall_pixels() -> np.ndarray:
    """Return 60 x 40 pixels: a slanted wall with a way around each end, a pillar, an unknown corner."""
    y, x = np.mgrid[:40, :60]
    pixels = np.full((40, 60), FREE)
    pixels[(abs(y - 20 - (x - 30) * 0.5) < 2.5) & (x > 14) & (x < 46)] = OCCUPIED
    pixels[(y - 8) ** 2 + (x - 40) ** 2 < 20] = OCCUPIED
    pixels[30:, 45:] = UNKNOWN
    return pixels


grids = st.tuples(st.integers(1, 9), st.integers(1, 9)).flatmap(
    lambda s: st.lists(st.booleans(), min_size=s[0] * s[1], max_size=s[0] * s[1]).map(lambda v: np.array(v).reshape(s))
)


@given(grids)
@settings(max_examples=300, deadline=None)
def test_boxes_are_exactly_the_cells(cells: np.ndarray) -> None:
    count = np.zeros(cells.shape, dtype=int)
    for piece in cover_cells(cells):
        (a, c), (b, d) = piece.corners[0], piece.corners[2]
        count[a:b, c:d] += 1
    assert (count == cells).all()


@given(grids)
@settings(max_examples=300, deadline=None)
def test_every_occupied_cell_lies_in_one_of_the_polygons(cells: np.ndarray) -> None:
    """All four corners of the cell do, as the polygon is convex. A free cell counts where its middle lies in a polygon."""
    pieces = cover_cells(cells, "polygons")
    is_covered = np.zeros(cells.shape, dtype=bool)  # with all four corners
    middle_is_covered = np.zeros(cells.shape, dtype=bool)
    for piece in pieces:
        pairs = list(zip(piece.corners, piece.corners[1:] + piece.corners[:1], strict=True))

        def inside(x: float, y: float, pairs=pairs) -> bool:
            return all((c - a) * (y - b) - (d - b) * (x - a) >= 0 for (a, b), (c, d) in pairs)

        for i, j in np.ndindex(cells.shape):
            is_covered[i, j] |= all(inside(i + p, j + q) for p in (0, 1) for q in (0, 1))
            middle_is_covered[i, j] |= inside(i + 0.5, j + 0.5)
    assert (is_covered >= cells).all()
    assert count_free_cells_in(cells, pieces) == (middle_is_covered & ~cells).sum()


def test_a_disc_of_cells_is_one_polygon_and_a_corner_of_walls_is_two() -> None:
    x, y = np.mgrid[:30, :30]
    assert len(cover_cells((x - 15) ** 2 + (y - 15) ** 2 < 100, "polygons")) == 1
    assert len(cover_cells((x < 2) | (y < 2), "polygons")) == 2


@pytest.mark.parametrize("free_rule", ["white", "thresholds"])
@pytest.mark.parametrize(("mode", "negate"), [("trinary", "0"), ("Scale", "true"), ("trinary", "1"), ("raw", "false")])
def test_every_grey_counts_by_its_share_of_white(mode: str, negate: str, free_rule: str, tmp_path: Path) -> None:
    """The expected values follow the definition: a free cell that is grey is unknown, unless the thresholds alone decide."""
    text = YAML.replace("negate: 0", f"negate: {negate}\nmode: {mode}")
    chart = read_map(save_map(tmp_path, np.arange(256)[None], text), free_rule)
    for v in range(256):
        p = Fraction(v, 100) if mode == "raw" else Fraction(255 - v if negate == "0" else v, 255)
        free, occupied = p < Fraction("0.196"), 1 >= p > Fraction("0.65")
        grey = free and p >= Fraction("0.02")
        free = free and not (grey and free_rule == "white")
        assert (bool(chart.occupied[v, 0]), bool(chart.unknown[v, 0])) == (occupied, not free and not occupied)
        assert bool(chart.grey[v, 0]) == grey


def test_cells_count_from_the_lower_left_and_transparent_pixels_are_unknown(tmp_path: Path) -> None:
    pixels = np.full((3, 4, 4), 255)
    pixels[0, 2] = [0, 0, 0, 255]
    pixels[2, 1] = [255, 255, 255, 128]
    chart = read_map(save_map(tmp_path, pixels))
    assert np.argwhere(chart.occupied).tolist() == [[2, 2]]
    assert np.argwhere(chart.unknown).tolist() == [[1, 0]]
    (table, second_table) = unsafe_tables(chart, cover_cells(chart.unsafe))
    assert (second_table["lower"], second_table["upper"]) == (
        [Fraction("-0.9"), Fraction("0.6")],
        [Fraction("-0.85"), Fraction("0.65")],
    )
    assert table["name"] == "map 1"


@pytest.mark.parametrize("kind", ["boxes", "polygons"])
def test_a_task_with_a_map_is_certified_and_checked(kind: str, tmp_path: Path) -> None:
    """The tube stays clear of every cell that is not free. The expanded task has the same digest, and the checker verifies it."""
    save_map(tmp_path, hall_pixels())
    (tmp_path / "hall.toml").write_text(TASK + f'as = "{kind}"\n')
    controller = build(tmp_path / "hall.toml")
    assert controller.certificate.holds
    for name, data in controller.files.items():
        (tmp_path / name).write_bytes(data)
    paths = [str(tmp_path / n) for n in ("hall.task.toml", "hall.c", "hall.certificate.json")]
    assert check_files(paths) == 0
    assert check_files([str(tmp_path / "hall.toml"), *paths[1:]]) == 2  # the checker reads no maps
    expanded = load_task(tmp_path / "hall.task.toml")
    assert (expanded.digest, expanded.obstacles) == (controller.task.digest, controller.task.obstacles)
    assert "hall.task.toml" not in build(tmp_path / "hall.task.toml").files
    chart, clearance = read_map(tmp_path / "hall.yaml"), float(controller.task.tube.clearance)
    low, high = controller.design.edges_at(np.linspace(0, 20, 801))
    cells = np.argwhere(chart.unsafe) * float(chart.resolution) + [float(v) for v in chart.origin]
    distances = np.concatenate([cells[None] - high[:, None], low[:, None] - cells[None] - float(chart.resolution)], axis=2)
    assert distances.max(axis=2).min() >= clearance - 1e-9  # doubles of coordinates below 4
    for i, j in np.argwhere(chart.unsafe).tolist():  # every cell lies in some set
        cell = [o + v * chart.resolution for v, o in zip((i, j), chart.origin, strict=True)]
        corners = tuple(cell), tuple(v + chart.resolution for v in cell)
        assert any(
            all(-minimum_over_box(tuple(-c for c in n), *corners) <= h for n, h in s.faces) for s in controller.task.obstacles
        )


def test_only_cells_away_from_the_state_space_are_left_out(tmp_path: Path) -> None:
    """Cells that are within the clearance of the state space are kept."""
    save_map(tmp_path, np.full((40, 60), OCCUPIED))
    text = TASK.replace("[-1, 0.5], upper = [2, 2.5]", "[0, 1], upper = [1, 2]")
    text = text.replace("[-0.7, 0.8]", "[0.1, 1.1]").replace(
        "[-0.8, 0.7], upper = [-0.6, 0.9]", "[0.05, 1.05], upper = [0.2, 1.2]"
    )
    (tmp_path / "hall.toml").write_text(text.replace("[1.6, 2.1], upper = [1.8, 2.3]", "[0.8, 1.8], upper = [0.9, 1.9]"))
    with pytest.raises(BadInput, match="meets"):
        load_task(tmp_path / "hall.toml")
    pixels = np.full((40, 60), OCCUPIED)
    pixels[10:30, 20:40] = FREE  # the state space
    save_map(tmp_path, pixels)
    sets = load_task(tmp_path / "hall.toml").obstacles
    assert {s.span(0)[1] for s in sets if s.span(0)[1] < Fraction("0.5")} == {0}
    assert len(sets) == 4


@given(st.integers(0, 2**31))
@settings(max_examples=20)
def test_written_toml_reads_as_the_same_document(seed: int) -> None:
    document = {
        "name": "a",
        "number": Decimal(seed) / 1000,
        "yes": seed % 2 == 0,
        "tube": {"design": "refined", "adaptive": {"mu": Decimal("1e-7")}, "list": [1, Decimal("2.5")]},
        "unsafe": [{"name": 'q"uote', "vertices": [[1, 2], [3, Decimal("0.1")]]}, {"lower": [1]}],
    }
    assert tomllib.loads(to_toml(document), parse_float=Decimal) == document


WRONG = [
    ("free_thresh: 0.196\n", "", ["free_thresh", "missing"]),
    ("0.05", "0", ["resolution", "greater than 0"]),
    ("0.05", "five", ["resolution", "no number"]),
    ("0.0]", "0.1]", ["rotated by 0.1 rad", "--upright", "hall_upright.yaml"]),
    ("[-1.0, 0.5, 0.0]", "3", ["origin", "lower left"]),
    ("negate: 0", "negate: 7", ["negate", "0 or 1"]),
    ("image: {image}", "image: none.png", ["none.png", "cannot be read"]),
    ("image: {image}", "image: hall.yaml", ["hall.yaml", "is no image"]),
    ("negate: 0", "mode: grey", ["mode", "trinary, scale, raw"]),
    ("negate: 0", "negate: 1\nmode: raw", ["negate", "mode: raw", "use negate: 0"]),
    ("negate: 0", "negate: 0\nnegate: 1", ["negate", "twice"]),
    ("image: {image}", "image: [a, b]", ["image", "path"]),
    ("negate: 0", "a: &b [1]\nc: *b", ["line 5", "alias"]),
    ("negate: 0", "a: [[[[[[]]]]]]", ["line 4", "nested", "4 deep"]),
    ("negate: 0", "a: " + "x" * 16384, ["more than 16,384 bytes"]),
    ("negate: 0", 'a: "\\UFFFFFFFF"', ["is no YAML"]),
    ("image", "- [", ["is no YAML"]),
    ("0.196", "0.7", ["free_thresh", "not above the second"]),
    ("0.65", "1.5", ["occupied_thresh", "0 to 1"]),
]


@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_a_malformed_map_file_is_refused(old: str, new: str, words: list[str], tmp_path: Path) -> None:
    path = save_map(tmp_path, hall_pixels(), YAML.replace(old, new, 1))
    with pytest.raises(BadInput) as caught:
        read_map(path)
    assert all(w in str(caught.value) for w in words), caught.value
    assert "\n" not in str(caught.value)


@given(grids, st.sampled_from(["0.1", "-0.1", "1.5707963", "3", "-2.5", "0.000001"]))
@settings(max_examples=60, deadline=None)
def test_unsafe_cells_stay_unsafe_in_the_upright_map(cells: np.ndarray, yaw: str) -> None:
    """Points all over every unsafe cell, and points beyond the map, are unsafe in the upright map. A free cell stays free where
    the cells within a cell's diagonal of it are free."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        pixels = np.pad(np.where(cells, OCCUPIED, FREE), 4, constant_values=FREE)
        path = save_map(folder, pixels, YAML.replace("0.0]", f"{yaw}]"), "turned")
        write_upright_map(path, folder / "upright.yaml")
        upright = read_map(folder / "upright.yaml")
    unsafe = np.ascontiguousarray((pixels == OCCUPIED)[::-1].T)
    angle, step, corner = float(yaw), 0.05, np.array([-1.0, 0.5])
    share = np.linspace(0.01, 0.99, 5)
    inner = np.stack(np.meshgrid(share, share), axis=-1).reshape(-1, 2)
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def is_unsafe(points: np.ndarray) -> np.ndarray:
        index = np.floor((points - [float(v) for v in upright.origin]) / step).astype(int)
        inside = ((index >= 0) & (index < upright.unsafe.shape)).all(axis=-1)
        index[~inside] = 0
        return ~inside | upright.unsafe[index[..., 0], index[..., 1]]

    for i, j in np.argwhere(unsafe):
        assert is_unsafe(((inner + np.array([i, j])) * step) @ rotation.T + corner).all()
    points_beyond = np.array([[-0.01, 1], [1, -0.01], [unsafe.shape[0] + 0.01, 1], [1, unsafe.shape[1] + 0.01]])
    assert is_unsafe((points_beyond * step) @ rotation.T + corner).all()
    for i, j in np.argwhere(~unsafe):
        if 2 <= i < unsafe.shape[0] - 2 and 2 <= j < unsafe.shape[1] - 2 and not unsafe[i - 2 : i + 3, j - 2 : j + 3].any():
            assert not is_unsafe(((inner + np.array([i, j])) * step) @ rotation.T + corner).any()


def test_a_rotated_map_is_refused_with_a_command_that_works(tmp_path: Path) -> None:
    (tmp_path / "a folder").mkdir()
    path = save_map(tmp_path / "a folder", hall_pixels(), YAML.replace("0.0]", "0.3]"))
    with pytest.raises(BadInput) as caught:
        read_map(path)
    command = shlex.split(re.findall(r"`stt-codegen ([^`]+)`", str(caught.value))[0])
    assert CliRunner().invoke(app, command).exit_code == 0
    upright = read_map(path.with_name("hall_upright.yaml"))
    assert (~upright.unsafe).any()
    result = CliRunner().invoke(app, ["map", str(path.with_name("hall_upright.yaml")), "--upright", str(tmp_path / "more.yaml")])
    assert isinstance(result.exception, BadInput)
    assert "is not rotated" in str(result.exception)
    assert not (tmp_path / "more.yaml").exists()


def test_a_map_that_is_too_large_or_missing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="4097 x 1 cells"):
        read_map(save_map(tmp_path, np.zeros((1, 4097))))
    with pytest.raises(BadInput, match="cannot be read"):
        read_map(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("", ["map.file", "missing"]),
        ("file = 3", ["map.file", "path"]),
        ('file = "hall.yaml"\ncolour = 1', ["map.colour", "unknown key"]),
        ('file = "hall.yaml"\nas = "discs"', ["map.as", "boxes, polygons"]),
        ('file = "hall.yaml"\naxes = ["x1"]', ["map.axes", "two dimensions"]),
        ('file = "hall.yaml"\naxes = ["x1", "z"]', ["map.axes", "x1, x2"]),
        ('file = "none.yaml"', ["none.yaml", "cannot be read"]),
        ("file = []", ["map.file", "lists 0 maps"]),
        ('file = ["hall.yaml", 3]', ["map.file", "in its list", "path"]),
        ('file = ["hall.yaml", "none.yaml"]', ["none.yaml", "cannot be read"]),
        ('file = "hall.yaml"\nfree = "grey"', ["map.free", "white, thresholds"]),
    ],
)
def test_a_malformed_map_table_is_refused(lines: str, words: list[str], tmp_path: Path) -> None:
    save_map(tmp_path, hall_pixels())
    (tmp_path / "hall.toml").write_text(TASK.replace('file = "hall.yaml"\n', lines + "\n"))
    with pytest.raises(BadInput) as caught:
        load_task(tmp_path / "hall.toml")
    assert all(w in str(caught.value) for w in (*words, "hall.toml")), caught.value


def save_unexplored_hall(folder: Path, free_thresh: str = "0.25", grey: int = UNKNOWN) -> Path:
    """Save the hall as map savers write it: unknown cells have a grey that a free_thresh of 0.25 makes free."""
    pixels = hall_pixels()
    pixels[pixels == UNKNOWN] = grey
    return save_map(folder, pixels, YAML.replace("0.196", free_thresh))


INTO_UNEXPLORED = TASK.replace("[1.6, 2.1], upper = [1.8, 2.3]", "[1.6, 0.6], upper = [1.8, 0.8]")


def test_grey_that_only_the_thresholds_make_free_is_unknown(tmp_path: Path) -> None:
    """A target there is refused; the message counts the cells, names their grey and two remedies, and both work."""
    save_unexplored_hall(tmp_path)
    with pytest.raises(BadInput, match="target_set: .*150 cells of grey 205 .*free_thresh: 0.196 .*thresholds") as caught:
        parse_task(INTO_UNEXPLORED, folder=tmp_path)
    assert str(caught.value).count("note:") == 1
    floor = parse_task(INTO_UNEXPLORED + 'free = "thresholds"\n', folder=tmp_path)
    assert "150 cells of grey 205 count as free" in floor.map_notes[0]
    by_default = parse_task(TASK, folder=tmp_path)
    assert len(by_default.map_notes) == 1
    save_unexplored_hall(tmp_path, "0.196")
    edited = parse_task(TASK, folder=tmp_path)
    assert (edited.digest, edited.map_notes) == (by_default.digest, ())
    assert parse_task(TASK + 'free = "thresholds"\n', folder=tmp_path).digest == edited.digest


def test_cells_far_from_the_state_space_are_not_noted(tmp_path: Path) -> None:
    save_unexplored_hall(tmp_path)
    task = parse_task(
        TASK.replace("upper = [2, 2.5] }", "upper = [1, 2.5] }").replace(
            "[1.6, 2.1], upper = [1.8, 2.3]", "[0.6, 2.1], upper = [0.8, 2.3]"
        ),
        folder=tmp_path,
    )
    assert task.map_notes == ()


@given(
    st.lists(st.integers(0, 255), min_size=1, max_size=30),
    st.sampled_from(["trinary", "raw"]),
    st.booleans(),
    st.integers(1, 900),
)
@settings(max_examples=100, deadline=None)
def test_the_threshold_that_a_note_names_gives_the_same_cells(
    levels: list[int], mode: str, negate: bool, thousandths: int
) -> None:
    negate &= mode != "raw"
    text = YAML.replace("negate: 0", f"negate: {int(negate)}\nmode: {mode}").replace("0.65", "0.9")
    with TemporaryDirectory() as name:
        path = save_map(Path(name), np.array([levels]), text.replace("0.196", str(thousandths / 1000)))
        chart = read_map(path)
        note = chart.grey_note()
        assert (note is None) == (not chart.grey.any())
        if note is not None:
            limit = re.findall(r"free_thresh: ([0-9.]+) there", note)[0]
            edited = read_map(save_map(Path(name), np.array([levels]), text.replace("0.196", limit)))
            assert (edited.unknown == chart.unknown).all()
            assert edited.grey_note() is None


def test_commands_show_the_note(tmp_path: Path) -> None:
    path = save_unexplored_hall(tmp_path)
    (tmp_path / "hall.toml").write_text(TASK)
    words = "150 cells of grey 205 count as unknown"

    def run(*arguments: str) -> str:
        result = CliRunner().invoke(app, list(arguments))
        assert result.exit_code == 0, result.output
        return " ".join(result.output.split())

    assert words in run("design", str(tmp_path / "hall.toml"))
    assert words in map_report(read_map(path), "boxes").document()["notes"][0]
    assert words in run("generate", str(tmp_path / "hall.toml"), "--out", str(tmp_path / "out"))
    counts = map_report(read_map(path, "thresholds"), "boxes").document()
    assert (counts["unknown"], counts["grey"]) == (0, {205: 150})


def test_a_cell_is_free_only_if_every_map_server_takes_it_as_free(tmp_path: Path) -> None:
    """Yellow is free by its luminance only, violet by the mean only, a tie of both by one of them. A negated map with transparency
    is free by its colours only."""
    pixels = np.full((1, 3, 3), 255)
    pixels[0, 1], pixels[0, 2] = [255, 255, 100], [255, 180, 255]
    chart = read_map(save_map(tmp_path, pixels), "thresholds")
    assert chart.unsafe[:, 0].tolist() == [False, True, True]
    tie = read_map(save_map(tmp_path, np.array([[204, 205]]), YAML.replace("0.196", "0.2")), "thresholds")
    assert tie.unsafe[:, 0].tolist() == [True, False]
    black = np.zeros((1, 2, 4))
    black[..., 3] = 255
    path = save_map(tmp_path, black, YAML.replace("negate: 0", "negate: true"))
    with pytest.raises(BadInput, match=r"hall.png: has transparency.*mode: scale"):
        read_map(path)
    path.write_text(path.read_text() + "mode: scale\n")
    assert not read_map(path).unsafe.any()


def test_yaml_aliases_that_would_grow_without_bound_are_refused(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 30)]
    path = save_map(tmp_path, hall_pixels(), "\n".join(lines) + "\n" + YAML)
    with pytest.raises(BadInput, match=r"hall.yaml: line 2: has an alias \(\*a0\)"):
        read_map(path)


MASK_YAML = YAML.replace("0.05", "0.1").replace("[-1.0, 0.5, 0.0]", "[0.21, 1.73, 0.0]")


def test_a_mask_adds_only_its_own_cells(tmp_path: Path) -> None:
    """The mask has a resolution and an origin of its own. It covers a part of the floor's map and reaches beyond it."""
    save_map(tmp_path, hall_pixels())
    mask = np.full((20, 40), FREE)
    mask[15, 3] = OCCUPIED
    mask[2, 30] = UNKNOWN
    save_map(tmp_path, mask, MASK_YAML, "mask")
    save_map(tmp_path, np.full((200, 200), OCCUPIED), YAML.replace("-1.0", "2.5"), "far")
    save_map(tmp_path, np.full((3, 3), OCCUPIED), YAML.replace("-1.0", "-7.0"), "near")
    task_without_masks = parse_task(TASK, folder=tmp_path)
    text = TASK.replace('"hall.yaml"', '["hall.yaml", "mask.yaml", "far.yaml", "near.yaml"]')
    task = parse_task(text, folder=tmp_path)
    spans = [(tuple(u.lower), tuple(u.upper)) for u in task.unsafe]
    assert spans[: len(task_without_masks.unsafe)] == [(tuple(u.lower), tuple(u.upper)) for u in task_without_masks.unsafe]
    low = [Fraction("0.21") + Fraction(3, 10), Fraction("1.73") + Fraction(4, 10)]
    assert spans[len(task_without_masks.unsafe) :] == [(tuple(low), tuple(v + Fraction(1, 10) for v in low))]
    assert len({u.name for u in task.unsafe}) == len(task.unsafe)
    with pytest.raises(BadInput, match=r"reaches beyond the map .*mask.yaml"):
        parse_task(TASK.replace('"hall.yaml"', '["mask.yaml", "hall.yaml"]'), folder=tmp_path)


def test_the_target_in_a_mask_is_refused(tmp_path: Path) -> None:
    save_map(tmp_path, hall_pixels())
    save_map(tmp_path, np.full((5, 5), OCCUPIED), YAML.replace("-1.0, 0.5", "1.55, 2.05").replace("0.05", "0.1"), "mask")
    with pytest.raises(BadInput, match=r"target_set: .*map 2\.1"):
        parse_task(TASK.replace('"hall.yaml"', '["hall.yaml", "mask.yaml"]'), folder=tmp_path)


def test_space_beyond_the_map_is_not_free(tmp_path: Path) -> None:
    save_map(tmp_path, hall_pixels())
    with pytest.raises(BadInput, match=r"state_space.upper: reaches beyond the map .* in x2.* at most 2.5 there"):
        parse_task(TASK.replace("upper = [2, 2.5]", "upper = [2, 2.6]"), folder=tmp_path)
    with pytest.raises(BadInput, match="initial_set: meets unsafe"):
        parse_task(TASK.replace("[-0.8, 0.7], upper = [-0.6, 0.9]", "[-0.8, 0.7], upper = [1, 2]"), folder=tmp_path)


def test_a_map_in_two_of_three_dimensions(tmp_path: Path) -> None:
    save_map(tmp_path, hall_pixels())
    text = TASK.replace('name = "hall"\n', 'name = "hall"\naxes = ["y", "h", "x"]\n')
    for old, new in (
        ("[-0.7, 0.8]", "[0.8, 0, -0.7]"),
        ("[-1, 0.5], upper = [2, 2.5]", "[0.5, -1, -1], upper = [2.5, 1, 2]"),
        ("[-0.8, 0.7], upper = [-0.6, 0.9]", "[0.7, -0.2, -0.8], upper = [0.9, 0.2, -0.6]"),
        ("[1.6, 2.1], upper = [1.8, 2.3]", "[2.1, -0.2, 1.6], upper = [2.3, 0.2, 1.8]"),
    ):
        text = text.replace(old, new)
    task = parse_task(text + 'axes = ["x", "y"]\n', folder=tmp_path)
    flat = parse_task(TASK, folder=tmp_path)
    for solid, plane in zip(task.unsafe_sets, flat.unsafe_sets, strict=True):
        assert [solid.span(2), solid.span(0)] == [plane.span(0), plane.span(1)]
        assert solid.span(1) == (-1, 1)


def test_no_command_overwrites_the_files_that_a_task_is_read_from(tmp_path: Path) -> None:
    save_map(tmp_path, hall_pixels())
    task_path = tmp_path / "hall.task.toml"
    task_path.write_text(TASK.replace('name = "', 'name = "hall" # "', 1))
    (tmp_path / "hall.py").write_text("# a plant\n")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    for arguments in (
        ("design", str(task_path), "--picture", str(tmp_path)),
        ("generate", str(task_path), "--out", str(tmp_path)),
    ):
        refused = run_command(*arguments)
        assert refused.returncode == 2, refused.stderr
    task_path = task_path.rename(tmp_path / "hall.toml")
    assert "is no emitted controller" in run_command("generate", str(task_path), "--out", str(tmp_path)).stderr
    (tmp_path / "hall.py").unlink()
    for _ in range(2):  # a second run replaces the files of the first
        assert run_command("generate", str(task_path), "--out", str(tmp_path)).returncode == 0
    for path, data in before.items():
        assert path.name in ("hall.py", "hall.task.toml") or path.read_bytes() == data


def test_the_command_map_prints_counts_and_draws(tmp_path: Path) -> None:
    path = save_map(tmp_path, hall_pixels())
    result = run_command("map", str(path), "--as", "polygons", "--picture", str(tmp_path / "drawn.png"))
    assert result.returncode == 0
    assert "60 x 40 cells of 0.05" in result.stdout
    assert (tmp_path / "drawn.png").read_bytes().startswith(b"\x89PNG")
    document = json.loads(run_command("map", str(path), "--picture", str(tmp_path), "--json").stdout)
    pixels = hall_pixels()
    assert (document["occupied"], document["unknown"]) == ((pixels == OCCUPIED).sum(), (pixels == UNKNOWN).sum())
    assert document["sets"] == len(cover_cells(read_map(path).unsafe))
    assert document["free_cells_taken"] == 0
    image = (tmp_path / "hall.png").read_bytes()
    assert run_command("map", str(path), "--picture", str(tmp_path / "hall.png")).returncode == 2  # this is the image of the map
    assert (tmp_path / "hall.png").read_bytes() == image
    assert (tmp_path / "hall_map.png").exists()
    refused = run_command("map", str(tmp_path / "none.yaml"))
    assert (refused.returncode, refused.stdout) == (2, "")
