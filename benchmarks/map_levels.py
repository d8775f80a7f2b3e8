"""Design tubes on random occupancy maps: no state of a certified tube may lie on a cell that is not free.

    python -m benchmarks map_levels [--count 200] [--seed 0] [--record FILE.md]

Each map has white floor, dark walls, and unexplored cells of one grey, which runs through all levels, or of colours. Mode,
negate, transparency, thresholds and file format vary. A third of the maps has a mask of another resolution. This file decides
by itself whether a cell is free. It uses the two definitions that nav2_map_server has had (the mean of the colours, with alpha
as a fourth in mode trinary; their luminance), and what was painted. The exit code is 1 on a violation, or where a start or
target is refused that is free in every colour.
"""

from __future__ import annotations

import argparse
import random
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from benchmarks.suites.report import command, machine, record, table
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import build

FLOOR_CELLS, MASK_CELLS = 24, 10  # cells of a side, of the map and of the mask
MODES = ("trinary", "trinary", "scale", "raw")
NEGATED = {False: ("0", "false", "no", "False"), True: ("1", "true", "yes", "ON")}
THRESHOLDS = ("0.196", "0.25", "0.1", "0.2", "0.4", "0.6", "0.8", "0.003")  # 0.2, 0.4, 0.6, 0.8 are exactly p of some grey
WHITE_LEVELS = {"trinary": 6, "scale": 6, "raw": 2}  # that floor is painted with; unexplored cells are not
WEIGHTS = (("1/3", "1/3", "1/3"), ("0.2126", "0.7152", "0.0722"), ("0.299", "0.587", "0.114"))  # mean, and two luminances
COLOURS = (("1", "0", "0"), ("0", "1", "0"), ("0", "0", "1"))
CELL = Fraction(1, 4)
CERTIFIED, UNJUSTIFIED = "certified", "refused without a reason"
NOT_FREE = ("refused: the start meets a cell that is not free", "refused: the target lies in cells that are not free")
REFUSALS = {
    "meets unsafe": NOT_FREE[0],
    "lies inside unsafe": NOT_FREE[1],
    "negate: is": "refused: mode raw, negated",
    "has transparency": "refused: mode trinary, negated, with transparency",
}
START_HALF_WIDTH, CLEAR_HALF_WIDTH = 0.1, 0.1301  # of the start; with the clearance of 0.03 and a small margin for rounding
TIMES = 1601
OPAQUE = 255

Pixels = npt.NDArray[np.uint8]
Cells = npt.NDArray[np.bool_]
Edges = npt.NDArray[np.float64]
Weights = Sequence[tuple[str, str, str]]


@dataclass(frozen=True)
class PaintedMap:
    """A map as it is painted and saved.

    pixels: RGBA, rows from the top. floor: cells that were painted white. layout: of the saved image, L, LA, RGB or RGBA.
    free_below: the key free_thresh, as text.
    """

    pixels: Pixels
    floor: Cells
    layout: str
    mode: str
    negate: bool
    free_below: str
    resolution: Fraction
    origin: tuple[Fraction, Fraction]

    def free_cells(self, free_rule: str, weights: Weights = WEIGHTS) -> Cells:
        """Return the cells that are free by every definition and, unless the rule is "thresholds", were painted as floor.

        Rows are from the top. weights: of the colours, a row for each definition.
        """
        is_free = {}
        for pixel in {tuple(int(v) for v in p) for p in self.pixels.reshape(-1, 4)}:
            is_free[pixel] = self._is_free(pixel, weights)
        free_cells = np.array([[is_free[tuple(int(v) for v in p)] for p in row] for row in self.pixels])
        return free_cells if free_rule == "thresholds" else free_cells & self.floor

    def _is_free(self, pixel: tuple[int, ...], weights: Weights) -> bool:
        *colours, alpha = pixel
        shades = [sum((Fraction(w) * c for w, c in zip(row, colours, strict=True)), Fraction(0)) for row in weights]
        if self.mode == "trinary" and self.layout in ("LA", "RGBA"):
            shades.append(Fraction(sum(pixel), 4))
        if self.mode == "raw":
            return alpha == OPAQUE and all(v <= 100 and v / 100 < Fraction(self.free_below) for v in shades)
        shares = [v / 255 if self.negate else 1 - v / 255 for v in shades]
        return alpha == OPAQUE and all(p < Fraction(self.free_below) for p in shares)

    def save(self, folder: Path, name: str, rng: random.Random) -> None:
        """Write the image and its YAML file."""
        suffix = {"L": ("png", "pgm", "bmp"), "RGB": ("png", "ppm"), "LA": ("png",), "RGBA": ("png",)}[self.layout]
        image = f"{name}.{rng.choice(suffix)}"
        Image.fromarray(self.pixels, "RGBA").convert(self.layout).save(folder / image)
        origin = ", ".join(str(float(v)) for v in self.origin)
        lines = [f"image: {image}", f"resolution: {float(self.resolution)}", f"origin: [{origin}, 0.0]", f"mode: {self.mode}"]
        lines += [f"negate: {rng.choice(NEGATED[self.negate])}", f"free_thresh: {self.free_below}", "occupied_thresh: 0.9"]
        (folder / f"{name}.yaml").write_text("\n".join(lines) + "\n")


def paint_map(rng: random.Random, level: int, side: int, resolution: Fraction, origin: tuple[Fraction, Fraction]) -> PaintedMap:
    """Paint a floor with blocks of walls and of unexplored cells. level: grey of the unexplored cells. side: cells of a side."""
    mode, negate = rng.choice(MODES), rng.random() < 0.4
    negate &= mode != "raw" or rng.random() < 0.2  # a negated map of mode raw is refused
    layout = rng.choice(("L", "L", "RGB", "LA", "RGBA"))
    dark_is_free = negate or mode == "raw"

    def shade(v: int) -> int:
        return v if dark_is_free else 255 - v

    white = WHITE_LEVELS[mode]
    pixels, floor = np.full((side, side, 4), OPAQUE, np.uint8), np.ones((side, side), bool)
    pixels[..., :3] = np.array([[shade(rng.randrange(white)) for _ in range(side)] for _ in range(side)])[..., None]
    free_below = rng.choice(THRESHOLDS)
    tie_level = Fraction(free_below) * (100 if mode == "raw" else 255)
    if tie_level.denominator == 1 and rng.random() < 0.5:  # a tie
        level = shade(int(tie_level))
    if (level if dark_is_free else 255 - level) < white:
        level = shade(rng.randrange(white, 256))
    for _ in range(rng.randint(3, 9)):
        x, y, wide, high = rng.randrange(side), rng.randrange(side), rng.randint(1, side // 3), rng.randint(1, side // 3)
        block = np.s_[y : y + high, x : x + wide]
        colour = [shade(rng.randint(230, 255) if mode != "raw" else rng.randint(90, 100))] * 3
        kind = rng.choice(("wall", "grey", "grey", "coloured", "transparent"))
        if kind == "grey":
            colour = [level] * 3
        elif kind == "coloured" and layout in ("RGB", "RGBA"):
            colour = [shade(rng.randrange(256)) for _ in range(3)]
            colour[rng.randrange(3)] = shade(rng.randrange(white, 256))
        pixels[block][..., :3] = colour
        if kind == "transparent" and layout in ("LA", "RGBA"):
            pixels[block][..., :3], pixels[block][..., 3] = shade(0), rng.randrange(OPAQUE)
        floor[block] = False
    return PaintedMap(pixels, floor, layout, mode, negate, free_below, resolution, origin)


def count_meetings(maps: Sequence[PaintedMap], free_cells: Sequence[Cells], low: Edges, high: Edges) -> int:
    """Count the pairs of a time and a cell that is not free such that a state of the tube is in the cell.

    low, high: edges of the tube, (times, 2). free_cells: by map.
    """
    count = 0
    for grid_map, cells in zip(maps, free_cells, strict=True):
        rows, columns = np.nonzero(~cells)
        corner = np.stack([columns, cells.shape[0] - 1 - rows], axis=1) * float(grid_map.resolution)
        corner = corner + [float(v) for v in grid_map.origin]
        meets = (low[:, None] < corner[None] + float(grid_map.resolution)) & (corner[None] < high[:, None])
        count += int(meets.all(axis=2).sum())
    return count


def draw_end(rng: random.Random, floor: Cells) -> list[float]:
    """Draw the middle of a cell for the start or the target; with a probability of 85 % it is on the painted floor."""
    is_on_floor = rng.random() < 0.85
    for _ in range(50):
        row, column = rng.randrange(FLOOR_CELLS), rng.randrange(FLOOR_CELLS)
        if floor[row, column] == is_on_floor:
            break
    return [float(CELL * column - 3 + CELL / 2), float(CELL * (FLOOR_CELLS - 1 - row) - 3 + CELL / 2)]


def try_map(seed: int) -> tuple[str, int]:
    """Design a task on the maps of a seed. Return the outcome, and the number of violations."""
    rng = random.Random(seed)
    maps = [paint_map(rng, seed % 256, FLOOR_CELLS, CELL, (Fraction(-3), Fraction(-3)))]
    if rng.random() < 1 / 3:
        origin = Fraction(rng.randint(-50, 20), 10), Fraction(rng.randint(-50, 20), 10)
        maps.append(paint_map(rng, (seed + 128) % 256, MASK_CELLS, Fraction(2, 5), origin))
    free_rule, kind = rng.choice(("white", "thresholds")), rng.choice(("boxes", "polygons"))
    ends = [draw_end(rng, maps[0].floor) for _ in range(2)]
    boxes = [f"{{ lower = {[v - START_HALF_WIDTH for v in e]}, upper = {[v + START_HALF_WIDTH for v in e]} }}" for e in ends]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for k, grid_map in enumerate(maps):
            grid_map.save(folder, f"m{k}", rng)
        files = "".join(f'"m{k}.yaml", ' for k in range(len(maps)))
        (folder / "task.toml").write_text(
            f'name = "level"\nprescribed_time = 20\ninitial_state = {ends[0]}\n'
            f"state_space = {{ lower = [-3, -3], upper = [3, 3] }}\ninitial_set = {boxes[0]}\ntarget_set = {boxes[1]}\n"
            f'[map]\nfile = [{files}]\nas = "{kind}"\nfree = "{free_rule}"\n'
        )
        try:
            controller = build(folder / "task.toml")
        except BadInput as error:
            outcome = next((text for words, text in REFUSALS.items() if words in str(error)), f"{UNJUSTIFIED}: {error}")
            if outcome in NOT_FREE and kind == "boxes":
                free_cells = [grid_map.free_cells(free_rule, (*WEIGHTS, *COLOURS)) for grid_map in maps]
                middles = np.array(ends)
                outcome = (
                    outcome
                    if count_meetings(maps, free_cells, middles - CLEAR_HALF_WIDTH, middles + CLEAR_HALF_WIDTH)
                    else f"{UNJUSTIFIED}: {error}"
                )
            return outcome, 0
        except NotCertified:
            return "refused: no tube was found", 0
    low, high = controller.design.edges_at(np.linspace(0, 20, TIMES))  # type: ignore[arg-type]
    return CERTIFIED, count_meetings(maps, [grid_map.free_cells(free_rule) for grid_map in maps], low, high)


def main() -> int:
    """Try all maps, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    outcomes, wrong_seeds = Counter[str](), []
    for seed in range(options.seed, options.seed + options.count):
        outcome, violations = try_map(seed)
        outcomes[outcome] += 1
        if outcome.startswith(UNJUSTIFIED):
            wrong_seeds.append(seed)
        if violations:
            wrong_seeds.append(seed)
            print(f"seed {seed}: {violations} pairs of a time and a cell that is not free")
    text = table(["maps made at random", "count"], [[name, str(count)] for name, count in outcomes.most_common()])
    summary = (
        f"{outcomes[CERTIFIED]} of {options.count} certified; {len(wrong_seeds)} wrong: a state on a cell that is not free, "
    )
    summary += "or a refusal of free cells."
    print(f"{text}\n\n{summary}")
    if options.record:
        title = f"## Grey levels of maps\n\nMade by `{command()}`; {machine()}."
        record(options.record, "map_levels", f"{title}\n\n{text}\n\n{summary}")
    return int(bool(wrong_seeds))


if __name__ == "__main__":
    raise SystemExit(main())
