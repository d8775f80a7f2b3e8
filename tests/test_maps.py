"""Occupancy maps: what is unsafe, as what it is taken, and a task with one from its file to the checker."""

from __future__ import annotations

import json
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from test_cli import run as run_cli

from stt_codegen.certify import checker
from stt_codegen.designs.grid import tube_at
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build
from stt_codegen.task import load_task, parse_task
from stt_codegen.task.maps import written
from stt_codegen.task.occupancy import read_map
from stt_codegen.task.pieces import gained, pieces_of, unsafe_tables
from stt_codegen.task.sets import low_of

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


def saved(folder: Path, pixels: np.ndarray, text: str = YAML, name: str = "hall") -> Path:
    Image.fromarray(pixels.astype(np.uint8)).save(folder / f"{name}.png")
    (folder / f"{name}.yaml").write_text(text.format(image=f"{name}.png"))
    return folder / f"{name}.yaml"


def hall() -> np.ndarray:
    """60 x 40 cells: a slanted wall with a way around each end, a pillar, an unknown corner."""
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
    for piece in pieces_of(cells):
        (a, c), (b, d) = piece.corners[0], piece.corners[2]
        count[a:b, c:d] += 1
    assert (count == cells).all()


@given(grids)
@settings(max_examples=300, deadline=None)
def test_every_cell_lies_in_one_of_the_polygons(cells: np.ndarray) -> None:
    """All four corners of it: the polygon is convex. And no free cell is counted that is in none."""
    pieces = pieces_of(cells, "polygons")
    held = np.zeros(cells.shape, dtype=bool)
    middle = np.zeros(cells.shape, dtype=bool)
    for piece in pieces:
        pairs = list(zip(piece.corners, piece.corners[1:] + piece.corners[:1], strict=True))

        def inside(x: float, y: float, pairs=pairs) -> bool:
            return all((c - a) * (y - b) - (d - b) * (x - a) >= 0 for (a, b), (c, d) in pairs)

        for i, j in np.ndindex(cells.shape):
            held[i, j] |= all(inside(i + p, j + q) for p in (0, 1) for q in (0, 1))
            middle[i, j] |= inside(i + 0.5, j + 0.5)
    assert (held >= cells).all()
    assert gained(cells, pieces) == (middle & ~cells).sum()


def test_a_disc_of_cells_is_one_polygon_and_a_corner_of_walls_is_none() -> None:
    x, y = np.mgrid[:30, :30]
    assert len(pieces_of((x - 15) ** 2 + (y - 15) ** 2 < 100, "polygons")) == 1
    assert len(pieces_of((x < 2) | (y < 2), "polygons")) == 2


@pytest.mark.parametrize("negate", [0, 1])
def test_every_grey_is_what_its_share_of_white_says(negate: int, tmp_path: Path) -> None:
    found = read_map(saved(tmp_path, np.arange(256)[None], YAML.replace("negate: 0", f"negate: {negate}")))
    for v in range(256):
        p = Fraction(v if negate else 255 - v, 255)
        free, occupied = p < Fraction("0.196"), p > Fraction("0.65")
        assert (bool(found.occupied[v, 0]), bool(found.unknown[v, 0])) == (occupied, not free and not occupied)


def test_cells_count_from_the_lower_left_and_what_is_transparent_is_unknown(tmp_path: Path) -> None:
    pixels = np.full((3, 4, 4), 255)
    pixels[0, 2] = [0, 0, 0, 255]
    pixels[2, 1] = [255, 255, 255, 128]
    found = read_map(saved(tmp_path, pixels))
    assert np.argwhere(found.occupied).tolist() == [[2, 2]]
    assert np.argwhere(found.unknown).tolist() == [[1, 0]]
    (table, other) = unsafe_tables(found, pieces_of(found.unsafe))
    assert (other["lower"], other["upper"]) == ([Fraction("-0.9"), Fraction("0.6")], [Fraction("-0.85"), Fraction("0.65")])
    assert table["name"] == "map 1"


@pytest.mark.parametrize("kind", ["boxes", "polygons"])
def test_a_task_with_a_map_goes_to_the_checker(kind: str, tmp_path: Path) -> None:
    """The tube keeps off every cell that is not free, by cells; the spelled-out task has the digest, and the checker says yes to it."""
    saved(tmp_path, hall())
    (tmp_path / "hall.toml").write_text(TASK + f'as = "{kind}"\n')
    made = build(tmp_path / "hall.toml")
    assert made.certificate.holds
    for name, data in made.files.items():
        (tmp_path / name).write_bytes(data)
    asked = [str(tmp_path / n) for n in ("hall.task.toml", "hall.c", "hall.certificate.json")]
    assert checker.main(asked) == 0
    assert checker.main([str(tmp_path / "hall.toml"), *asked[1:]]) == 2
    spelled = load_task(tmp_path / "hall.task.toml")
    assert (spelled.digest, spelled.obstacles) == (made.task.digest, made.task.obstacles)
    assert "hall.task.toml" not in build(tmp_path / "hall.task.toml").files
    found, keep = read_map(tmp_path / "hall.yaml"), float(made.task.tube.clearance)
    low, high = tube_at(made.design, np.linspace(0, 20, 801))
    cells = np.argwhere(found.unsafe) * float(found.resolution) + [float(v) for v in found.origin]
    beyond = np.concatenate([cells[None] - high[:, None], low[:, None] - cells[None] - float(found.resolution)], axis=2)
    assert beyond.max(axis=2).min() >= keep - 1e-9  # doubles of coordinates below 4
    for i, j in np.argwhere(found.unsafe).tolist():  # every cell lies in some set
        cell = [o + v * found.resolution for v, o in zip((i, j), found.origin, strict=True)]
        corners = tuple(cell), tuple(v + found.resolution for v in cell)
        assert any(all(-low_of(tuple(-c for c in n), *corners) <= h for n, h in s.faces) for s in made.task.obstacles)


def test_where_cells_may_be_left_out_is_outside_of_the_state_space(tmp_path: Path) -> None:
    """Cells that a tube in the state space might come within the clearance of are kept."""
    saved(tmp_path, np.full((40, 60), OCCUPIED))
    head = TASK.replace("[-1, 0.5], upper = [2, 2.5]", "[0, 1], upper = [1, 2]")
    head = head.replace("[-0.7, 0.8]", "[0.1, 1.1]").replace(
        "[-0.8, 0.7], upper = [-0.6, 0.9]", "[0.05, 1.05], upper = [0.2, 1.2]"
    )
    (tmp_path / "hall.toml").write_text(head.replace("[1.6, 2.1], upper = [1.8, 2.3]", "[0.8, 1.8], upper = [0.9, 1.9]"))
    with pytest.raises(BadInput, match="meets"):
        load_task(tmp_path / "hall.toml")
    pixels = np.full((40, 60), OCCUPIED)
    pixels[10:30, 20:40] = FREE  # the state space
    saved(tmp_path, pixels)
    sets = load_task(tmp_path / "hall.toml").obstacles
    assert {s.span(0)[1] for s in sets if s.span(0)[1] < Fraction("0.5")} == {0}
    assert len(sets) == 4


@given(st.integers(0, 2**31))
@settings(max_examples=20)
def test_what_is_written_reads_as_the_same(seed: int) -> None:
    document = {
        "name": "a",
        "number": Decimal(seed) / 1000,
        "yes": seed % 2 == 0,
        "tube": {"design": "refined", "adaptive": {"mu": Decimal("1e-7")}, "list": [1, Decimal("2.5")]},
        "unsafe": [{"name": 'q"uote', "vertices": [[1, 2], [3, Decimal("0.1")]]}, {"lower": [1]}],
    }
    assert tomllib.loads(written(document), parse_float=Decimal) == document


WRONG = [
    ("free_thresh: 0.196\n", "", ["free_thresh", "missing"]),
    ("0.05", "0", ["resolution", "greater than 0"]),
    ("0.05", "five", ["resolution", "no number"]),
    ("0.0]", "0.1]", ["rotated", "yaw 0"]),
    ("[-1.0, 0.5, 0.0]", "3", ["origin", "lower left"]),
    ("negate: 0", "negate: 7", ["negate", "0 or 1"]),
    ("image: {image}", "image: none.png", ["none.png", "cannot be read"]),
    ("image: {image}", "image: hall.yaml", ["hall.yaml", "is no image"]),
    ("negate: 0", "negate: 0\nmode: raw", ["mode", "trinary"]),
    ("image", "- [", ["is no YAML"]),
    ("0.196", "0.7", ["free_thresh", "not above the second"]),
    ("0.65", "1.5", ["occupied_thresh", "0 to 1"]),
]


@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_a_file_that_is_no_map_is_refused(old: str, new: str, words: list[str], tmp_path: Path) -> None:
    path = saved(tmp_path, hall(), YAML.replace(old, new, 1))
    with pytest.raises(BadInput) as caught:
        read_map(path)
    assert all(w in str(caught.value) for w in words), caught.value
    assert "\n" not in str(caught.value)


def test_a_map_that_is_too_large_or_missing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="4097 x 1 cells"):
        read_map(saved(tmp_path, np.zeros((1, 4097))))
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
    ],
)
def test_a_table_that_says_no_map_is_refused(lines: str, words: list[str], tmp_path: Path) -> None:
    saved(tmp_path, hall())
    (tmp_path / "hall.toml").write_text(TASK.replace('file = "hall.yaml"\n', lines + "\n"))
    with pytest.raises(BadInput) as caught:
        load_task(tmp_path / "hall.toml")
    assert all(w in str(caught.value) for w in (*words, "hall.toml")), caught.value


def test_what_lies_beyond_the_map_is_not_free(tmp_path: Path) -> None:
    saved(tmp_path, hall())
    with pytest.raises(BadInput, match=r"state_space.upper: reaches beyond the map .* in x2.* at most 2.5 there"):
        parse_task(TASK.replace("upper = [2, 2.5]", "upper = [2, 2.6]"), folder=tmp_path)
    with pytest.raises(BadInput, match="initial_set: meets unsafe"):
        parse_task(TASK.replace("[-0.8, 0.7], upper = [-0.6, 0.9]", "[-0.8, 0.7], upper = [1, 2]"), folder=tmp_path)


def test_a_map_in_two_of_three_dimensions(tmp_path: Path) -> None:
    saved(tmp_path, hall())
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
    for solid, plane in zip(task.bare, flat.bare, strict=True):
        assert [solid.span(2), solid.span(0)] == [plane.span(0), plane.span(1)]
        assert solid.span(1) == (-1, 1)


def test_the_command_tells_and_draws(tmp_path: Path) -> None:
    path = saved(tmp_path, hall())
    told = run_cli("map", str(path), "--as", "polygons", "--picture", str(tmp_path / "drawn.png"))
    assert told.returncode == 0
    assert "60 x 40 cells of 0.05" in told.stdout
    assert (tmp_path / "drawn.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads(run_cli("map", str(path), "--picture", str(tmp_path), "--json").stdout)
    pixels = hall()
    assert (found["occupied"], found["unknown"]) == ((pixels == OCCUPIED).sum(), (pixels == UNKNOWN).sum())
    assert found["sets"] == len(pieces_of(read_map(path).unsafe))
    assert found["free_cells_taken"] == 0
    image = (tmp_path / "hall.png").read_bytes()
    assert run_cli("map", str(path), "--picture", str(tmp_path / "hall.png")).returncode == 2  # the map itself
    assert (tmp_path / "hall.png").read_bytes() == image
    assert (tmp_path / "hall_map.png").exists()
    refused = run_cli("map", str(tmp_path / "none.yaml"))
    assert (refused.returncode, refused.stdout) == (2, "")
