"""Read the occupancy maps in a folder, design a small task on each, and check that its tube stays on white cells.

    python -m benchmarks public_maps FOLDER [--record FILE.md]

FOLDER holds .yaml files of map servers, at any depth, with their images beside them; none is part of this repository. A file
SOURCES.md there is recorded below the table. The table has for each map its cells, the grey cells that the thresholds make
free, its unsafe sets, the seconds of a small task's design, and the result. A map with a <name>_keepout.yaml beside it has a
row for both. The task is at most 60 cells long. It starts next to grey cells if there are any, else next to other cells that
are not free. The pixels of the image decide whether the tube stays on white cells. The exit code is 1 where it does not.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from benchmarks.suites.report import command, machine, record, table
from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import build
from stt_codegen.task.map.convex_pieces import cover_cells
from stt_codegen.task.map.map_yaml import read_header
from stt_codegen.task.map.occupancy import OccupancyMap, cells_of, read_map
from stt_codegen.task.map.upright import write_upright_map

LARGEST_REACH = 3  # cells: how far the surroundings of start and target are free, at most
START_DISTANCE = 3  # cells from these surroundings to cells that are not free
LONGEST_PATH = 60  # cells from start to target
STATE_SPACE_MARGIN = 15  # cells about start and target
WHITE = 250  # grey level from which a cell is white
HEADINGS = [
    "map",
    "cells",
    "free_thresh",
    "white cells: greys",
    "free by thresholds alone",
    "not free",
    "sets",
    "design s",
    "small task",
]

Cells = npt.NDArray[np.bool_]


def free_about(free: Cells, reach: int) -> Cells:
    """Return the cells whose surroundings are free: the square of `reach` cells to each side."""
    sums = np.pad(np.pad(~free, reach, constant_values=True).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    side = 2 * reach + 1
    return np.asarray(sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side] == 0)


def find_path(free: Cells, wanted: Cells) -> tuple[tuple[int, int], tuple[int, int], int] | None:
    """Return a start, a target that a path of free cells leads to, and how many cells about the path are free.

    wanted: cells next to which the start lies, if possible. None where no path exists.
    """
    for reach in range(LARGEST_REACH, 0, -1):
        allowed = free_about(free, reach)
        if not allowed.any():
            continue
        preferred = allowed & ~free_about(~wanted, reach + START_DISTANCE)
        starts = np.argwhere(preferred if preferred.any() else allowed)
        start = tuple(starts[len(starts) // 2].tolist())
        steps, waiting, last = {start: 0}, deque([start]), start
        while waiting:
            last = x, y = waiting.popleft()
            if steps[last] >= LONGEST_PATH:
                break
            for cell in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
                if 0 <= cell[0] < allowed.shape[0] and 0 <= cell[1] < allowed.shape[1] and allowed[cell] and cell not in steps:
                    steps[cell] = steps[last] + 1
                    waiting.append(cell)
        if steps[last] > 2 * reach:
            return start, last, reach
    return None


def task_text(maps: Sequence[OccupancyMap], cells: tuple[tuple[int, int], tuple[int, int], int]) -> str:
    """Return the text of a task from cell to cell; the clearance is a third of a cell. cells: start, target, free reach."""
    *ends, reach = cells
    grid_map = maps[0]
    step, half = grid_map.resolution, grid_map.resolution * Fraction(reach, 2)
    middles = [[o + (k + Fraction(1, 2)) * step for o, k in zip(grid_map.origin, end, strict=True)] for end in ends]
    low = [max(min(m[i] for m in middles) - STATE_SPACE_MARGIN * step, grid_map.origin[i]) for i in (0, 1)]
    high = [min(max(m[i] for m in middles) + STATE_SPACE_MARGIN * step, grid_map.upper[i]) for i in (0, 1)]

    def vector(values: Sequence[Fraction]) -> str:
        return f"[{', '.join(decimal(Fraction(f'{float(v):.9f}')) for v in values)}]"

    def box(lower: Sequence[Fraction], upper: Sequence[Fraction]) -> str:
        return f"{{ lower = {vector(lower)}, upper = {vector(upper)} }}"

    start, target = (box([v - half for v in m], [v + half for v in m]) for m in middles)
    lines = ['name = "crossing"', "prescribed_time = 20", f"initial_state = {vector(middles[0])}", f"initial_set = {start}"]
    lines += [f"state_space = {box(low, high)}", f"target_set = {target}", '[emit]\nscalar = "double"']
    lines += [f"[tube]\nclearance = {float(step) / 3:.6f}\nmin_width = {float(step) / 2:.6f}"]
    return "\n".join([*lines, f"[map]\nfile = {json.dumps([str(c.path.resolve()) for c in maps])}\n"])


def cells_of_pixels(grid_map: OccupancyMap) -> tuple[Cells, Cells]:
    """Return, by the image's pixels, which cells [x, y] are not opaque white, and which of them the threshold makes free."""
    pixels = np.array(Image.open(grid_map.image).convert("RGBA"))
    dark = pixels[..., :3].max(axis=-1) if grid_map.header.negate else 255 - pixels[..., :3].min(axis=-1)
    not_white = (dark > 255 - WHITE) | (pixels[..., 3] < 255)
    grey = not_white & (dark < 255 * float(grid_map.header.free_below))
    return np.asarray(not_white[::-1].T), np.asarray(grey[::-1].T)


def design_small_task(maps: Sequence[OccupancyMap]) -> tuple[str, str, bool]:
    """Design a small task. Return the seconds, the result, and whether the tube stays on white cells.

    maps: of one size and origin.
    """
    unsafe = np.logical_or.reduce([grid_map.unsafe for grid_map in maps])
    grey = np.logical_or.reduce([cells_of_pixels(grid_map)[1] for grid_map in maps])
    cells = find_path(~unsafe, grey if grey.any() else unsafe)
    if cells is None:
        return "", "no free way of some cells", True
    with tempfile.TemporaryDirectory() as name:
        task = Path(name) / "crossing.toml"
        task.write_text(task_text(maps, cells))
        begin = time.perf_counter()
        try:
            controller = build(task)
        except (BadInput, NotCertified) as error:
            return f"{time.perf_counter() - begin:.1f}", f"refused: {str(error).partition(': ')[2]:.90}", True
    seconds = time.perf_counter() - begin
    low, high = controller.design.edges_at(np.linspace(0, 20, 2001))  # type: ignore[arg-type]
    stays_on_white = True
    for grid_map in maps:
        corner = np.argwhere(cells_of_pixels(grid_map)[0]) * float(grid_map.resolution) + [float(v) for v in grid_map.origin]
        near = ((corner > low.min(0) - 1) & (corner < high.max(0) + 1)).all(axis=1)
        meets = (low[:, None] < corner[near] + float(grid_map.resolution)) & (corner[near] < high[:, None])
        stays_on_white &= not meets.all(axis=2).any()
    return (
        f"{seconds:.1f}",
        f"certified, {len(controller.task.unsafe)} sets near" + ("" if stays_on_white else ", LEAVES WHITE CELLS"),
        stays_on_white,
    )


def row_of(name: str, source: OccupancyMap, maps: Sequence[OccupancyMap]) -> tuple[list[str], bool]:
    """Return a map's row, and whether the tube stays on white cells. source: the map. maps: those of the task."""
    greys, white = source.grey_levels(), Counter(source.shade[~source.unsafe].tolist())
    grey = "none" if not greys else f"{sum(greys.values()):,}: {min(greys)}"
    grey += f" to {max(greys)}" if len(greys) > 1 else ""
    shades = f"{sum(white.values()):,}" + (f": {min(white)} to {max(white)}" if len(white) > 1 else "")
    seconds, outcome, stays_on_white = design_small_task(maps)
    width, height = source.unsafe.shape
    threshold = decimal(source.header.free_below) + (", negated" if source.header.negate else "")
    sets = sum(len(cover_cells(grid_map.unsafe)) for grid_map in maps)
    row = [name, f"{width} x {height}", threshold, shades, grey, f"{int(source.unsafe.sum()):,}", f"{sets:,}", seconds, outcome]
    return row, stays_on_white


def rows_of(path: Path, name: str) -> Iterator[tuple[list[str], bool]]:
    """Yield the row of a map, which is turned upright where it is rotated, and the row of the map with its mask."""
    header = read_header(path)
    source = cells_of(header)
    if header.yaw:
        with tempfile.TemporaryDirectory() as folder:
            upright = Path(folder) / "upright.yaml"
            write_upright_map(path, upright)
            yield row_of(f"{name}, by {decimal(header.yaw)} rad: upright", source, [read_map(upright)])
        return
    yield row_of(name, source, [source])
    mask = path.with_name(f"{path.stem}_keepout{path.suffix}")
    if mask.exists():
        yield row_of(f"{name} with {mask.name}", source, [source, read_map(mask)])


def main() -> int:
    """Try all maps of the folder, and print the rows. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    rows, all_stay = [], True
    for path in sorted([*options.folder.rglob("*.yaml"), *options.folder.rglob("*.yml")]):
        name = str(path.relative_to(options.folder))
        try:
            results = list(rows_of(path, name))
        except BadInput as error:
            results = [([name, *[""] * 7, f"refused: {str(error).partition(': ')[2]:.90}"], True)]
        for row, stays_on_white in results:
            rows.append(row)
            all_stay &= stays_on_white
            print(" | ".join(row), flush=True)
    text = table(HEADINGS, rows)
    certified = sum(row[-1].startswith("certified") for row in rows)
    grey = sum(row[4] not in ("none", "") for row in rows)
    summary = f"{len(rows)} rows; {grey} with cells that only the thresholds make free; {certified} small tasks certified; "
    summary += "every tube stays on white cells." if all_stay else "NOT EVERY TUBE STAYS ON WHITE CELLS."
    print(summary)
    if options.record:
        title = f"## Public maps\n\nMade by `{command()}`; {machine()}."
        sources = options.folder / "SOURCES.md"
        origins = f"\n\n{sources.read_text(encoding='utf-8')}" if sources.exists() else ""
        record(options.record, "public_maps", f"{title}\n\n{text}\n\n{summary}{origins}")
    return int(not all_stay)


if __name__ == "__main__":
    raise SystemExit(main())
