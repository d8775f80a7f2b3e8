"""Maps made at random, each designed: no state of a certified tube may lie on a cell that is not free.

    python -m benchmarks map_levels [--count 200] [--seed 0] [--record FILE.md]

Every map is painted with white floor, dark walls, and unexplored cells of one grey, which runs through all levels, or of colours.
Mode, negate, transparency, thresholds and file format vary; a third of the maps has a mask of another resolution. Whether a cell
is free is decided here by the two definitions that nav2_map_server has had (the mean of the colours, with alpha as a fourth in
mode trinary; their luminance) and by what was painted, from the numbers that were written. Exit code 1 on a violation, or where a
start or target that is free in every colour is refused.
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

FLOOR, MASK = 24, 10  # cells of a side
MODES = ("trinary", "trinary", "scale", "raw")
NEGATED = {False: ("0", "false", "no", "False"), True: ("1", "true", "yes", "ON")}
THRESHOLDS = ("0.196", "0.25", "0.1", "0.2", "0.4", "0.6", "0.8", "0.003")  # 0.2, 0.4, 0.6, 0.8 are exactly p of some grey
WHITE_LEVELS = {"trinary": 6, "scale": 6, "raw": 2}  # that floor is painted with; unexplored cells are not
WEIGHTS = (("1/3", "1/3", "1/3"), ("0.2126", "0.7152", "0.0722"), ("0.299", "0.587", "0.114"))  # mean, and two luminances
COLOURS = (("1", "0", "0"), ("0", "1", "0"), ("0", "0", "1"))
CELL = Fraction(1, 4)
CERTIFIED, UNFOUNDED = "certified", "refused without a reason"
NOT_FREE = ("refused: the start meets a cell that is not free", "refused: the target lies in cells that are not free")
REFUSALS = {
    "meets unsafe": NOT_FREE[0],
    "lies inside unsafe": NOT_FREE[1],
    "negate: is": "refused: mode raw, negated",
    "has transparency": "refused: mode trinary, negated, with transparency",
}
HALF, REACH = 0.1, 0.1301  # half a side of the start; with the clearance of 0.03, and less than a cell of doubt
TIMES = 1601
OPAQUE = 255

Pixels = npt.NDArray[np.uint8]
Cells = npt.NDArray[np.bool_]
Edges = npt.NDArray[np.float64]
Weights = Sequence[tuple[str, str, str]]


@dataclass(frozen=True)
class PaintedMap:
    """pixels: RGBA, rows from the top; floor: cells that were painted white, whatever the thresholds say; layout: as saved."""

    pixels: Pixels
    floor: Cells
    layout: str
    mode: str
    negate: bool
    free_below: str
    resolution: Fraction
    origin: tuple[Fraction, Fraction]

    def free(self, free_rule: str, weights: Weights = WEIGHTS) -> Cells:
        """Where every server publishes a free cell, and, but for "thresholds", floor was painted; rows from the top."""
        verdicts = {}
        for pixel in {tuple(int(v) for v in p) for p in self.pixels.reshape(-1, 4)}:
            verdicts[pixel] = self._is_free(pixel, weights)
        free = np.array([[verdicts[tuple(int(v) for v in p)] for p in row] for row in self.pixels])
        return free if free_rule == "thresholds" else free & self.floor

    def _is_free(self, pixel: tuple[int, ...], weights: Weights) -> bool:
        *colours, alpha = pixel
        shades = [sum((Fraction(w) * c for w, c in zip(row, colours, strict=True)), Fraction(0)) for row in weights]
        if self.mode == "trinary" and self.layout in ("LA", "RGBA"):
            shades.append(Fraction(sum(pixel), 4))
        if self.mode == "raw":
            return alpha == OPAQUE and all(v <= 100 and v / 100 < Fraction(self.free_below) for v in shades)
        shares = [v / 255 if self.negate else 1 - v / 255 for v in shades]
        return alpha == OPAQUE and all(p < Fraction(self.free_below) for p in shares)

    def save(self, folder: Path, name: str, draw: random.Random) -> None:
        """The image and its YAML file."""
        suffix = {"L": ("png", "pgm", "bmp"), "RGB": ("png", "ppm"), "LA": ("png",), "RGBA": ("png",)}[self.layout]
        image = f"{name}.{draw.choice(suffix)}"
        Image.fromarray(self.pixels, "RGBA").convert(self.layout).save(folder / image)
        origin = ", ".join(str(float(v)) for v in self.origin)
        lines = [f"image: {image}", f"resolution: {float(self.resolution)}", f"origin: [{origin}, 0.0]", f"mode: {self.mode}"]
        lines += [f"negate: {draw.choice(NEGATED[self.negate])}", f"free_thresh: {self.free_below}", "occupied_thresh: 0.9"]
        (folder / f"{name}.yaml").write_text("\n".join(lines) + "\n")


def painted(draw: random.Random, level: int, side: int, resolution: Fraction, origin: tuple[Fraction, Fraction]) -> PaintedMap:
    """A map of a floor with blocks of walls and of unexplored cells. level: the unexplored cells' grey."""
    mode, negate = draw.choice(MODES), draw.random() < 0.4
    negate &= mode != "raw" or draw.random() < 0.2  # refused there
    layout = draw.choice(("L", "L", "RGB", "LA", "RGBA"))
    dark_is_free = negate or mode == "raw"

    def shade(v: int) -> int:
        return v if dark_is_free else 255 - v

    white = WHITE_LEVELS[mode]
    pixels, floor = np.full((side, side, 4), OPAQUE, np.uint8), np.ones((side, side), bool)
    pixels[..., :3] = np.array([[shade(draw.randrange(white)) for _ in range(side)] for _ in range(side)])[..., None]
    free_below = draw.choice(THRESHOLDS)
    full = Fraction(free_below) * (100 if mode == "raw" else 255)
    if full.denominator == 1 and draw.random() < 0.5:  # a tie
        level = shade(int(full))
    if (level if dark_is_free else 255 - level) < white:
        level = shade(draw.randrange(white, 256))
    for _ in range(draw.randint(3, 9)):
        x, y, wide, high = draw.randrange(side), draw.randrange(side), draw.randint(1, side // 3), draw.randint(1, side // 3)
        block = np.s_[y : y + high, x : x + wide]
        colour = [shade(draw.randint(230, 255) if mode != "raw" else draw.randint(90, 100))] * 3
        kind = draw.choice(("wall", "grey", "grey", "coloured", "transparent"))
        if kind == "grey":
            colour = [level] * 3
        elif kind == "coloured" and layout in ("RGB", "RGBA"):
            colour = [shade(draw.randrange(256)) for _ in range(3)]
            colour[draw.randrange(3)] = shade(draw.randrange(white, 256))
        pixels[block][..., :3] = colour
        if kind == "transparent" and layout in ("LA", "RGBA"):
            pixels[block][..., :3], pixels[block][..., 3] = shade(0), draw.randrange(OPAQUE)
        floor[block] = False
    return PaintedMap(pixels, floor, layout, mode, negate, free_below, resolution, origin)


def states_off_the_floor(maps: Sequence[PaintedMap], free: Sequence[Cells], low: Edges, high: Edges) -> int:
    """How many pairs of a time and a cell that is not free have a state of the tube in common."""
    count = 0
    for chart, cells in zip(maps, free, strict=True):
        rows, columns = np.nonzero(~cells)
        corner = np.stack([columns, cells.shape[0] - 1 - rows], axis=1) * float(chart.resolution)
        corner = corner + [float(v) for v in chart.origin]
        meets = (low[:, None] < corner[None] + float(chart.resolution)) & (corner[None] < high[:, None])
        count += int(meets.all(axis=2).sum())
    return count


def end_of(draw: random.Random, floor: Cells) -> list[float]:
    """The middle of a cell for the start or the target, on the painted floor in 85 of 100."""
    wanted = draw.random() < 0.85
    for _ in range(50):
        row, column = draw.randrange(FLOOR), draw.randrange(FLOOR)
        if floor[row, column] == wanted:
            break
    return [float(CELL * column - 3 + CELL / 2), float(CELL * (FLOOR - 1 - row) - 3 + CELL / 2)]


def tried(seed: int) -> tuple[str, int]:
    """What came of one task, and its violations."""
    draw = random.Random(seed)
    maps = [painted(draw, seed % 256, FLOOR, CELL, (Fraction(-3), Fraction(-3)))]
    if draw.random() < 1 / 3:
        origin = Fraction(draw.randint(-50, 20), 10), Fraction(draw.randint(-50, 20), 10)
        maps.append(painted(draw, (seed + 128) % 256, MASK, Fraction(2, 5), origin))
    free_rule, kind = draw.choice(("white", "thresholds")), draw.choice(("boxes", "polygons"))
    ends = [end_of(draw, maps[0].floor) for _ in range(2)]
    boxes = [f"{{ lower = {[v - HALF for v in e]}, upper = {[v + HALF for v in e]} }}" for e in ends]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for k, chart in enumerate(maps):
            chart.save(folder, f"m{k}", draw)
        files = "".join(f'"m{k}.yaml", ' for k in range(len(maps)))
        (folder / "task.toml").write_text(
            f'name = "level"\nprescribed_time = 20\ninitial_state = {ends[0]}\n'
            f"state_space = {{ lower = [-3, -3], upper = [3, 3] }}\ninitial_set = {boxes[0]}\ntarget_set = {boxes[1]}\n"
            f'[map]\nfile = [{files}]\nas = "{kind}"\nfree = "{free_rule}"\n'
        )
        try:
            controller = build(folder / "task.toml")
        except BadInput as error:
            outcome = next((text for words, text in REFUSALS.items() if words in str(error)), f"{UNFOUNDED}: {error}")
            if outcome in NOT_FREE and kind == "boxes":
                free = [chart.free(free_rule, (*WEIGHTS, *COLOURS)) for chart in maps]
                at = np.array(ends)
                outcome = outcome if states_off_the_floor(maps, free, at - REACH, at + REACH) else f"{UNFOUNDED}: {error}"
            return outcome, 0
        except NotCertified:
            return "refused: no tube was found", 0
    low, high = controller.design.edges_at(np.linspace(0, 20, TIMES))  # type: ignore[arg-type]
    return CERTIFIED, states_off_the_floor(maps, [chart.free(free_rule) for chart in maps], low, high)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    outcomes, wrong = Counter[str](), []
    for seed in range(options.seed, options.seed + options.count):
        outcome, violations = tried(seed)
        outcomes[outcome] += 1
        if outcome.startswith(UNFOUNDED):
            wrong.append(seed)
        if violations:
            wrong.append(seed)
            print(f"seed {seed}: {violations} pairs of a time and a cell that is not free")
    text = table(["maps made at random", "count"], [[name, str(count)] for name, count in outcomes.most_common()])
    verdict = f"{outcomes[CERTIFIED]} of {options.count} certified; {len(wrong)} wrong: a state on a cell that is not free, "
    verdict += "or a refusal of free cells."
    print(f"{text}\n\n{verdict}")
    if options.record:
        title = f"## Grey levels of maps\n\nMade by `{command()}`; {machine()}."
        record(options.record, "map_levels", f"{title}\n\n{text}\n\n{verdict}")
    return int(bool(wrong))


if __name__ == "__main__":
    raise SystemExit(main())
