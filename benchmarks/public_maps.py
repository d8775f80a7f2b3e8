"""What occupancy maps of other people are taken as: a table of all maps in a folder.

    python -m benchmarks public_maps FOLDER [--record FILE.md]

FOLDER holds .yaml files of map servers, at any depth, with their images beside them; none is part of this repository. A file
SOURCES.md there is recorded below the table. The table has for each map its cells, what the thresholds make free by grey, its
sets, the seconds of a small task's design, and what came of it; a map with a <name>_keepout.yaml beside it has a row for both.
The task goes at most 60 cells far, from beside grey cells where there are any, else from beside others that are not free. Whether
the tube stays on white cells is decided from the image's own pixels. Exit code 1 where it does not.
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

WIDEST, BESIDE = 3, 3  # cells of free surroundings; from there to cells that are not free
FARTHEST, AROUND = 60, 15  # cells between start and target; of state space about both
WHITE = 250
HEAD = [
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
    """The cells of which the square of so many cells about them is free."""
    sums = np.pad(np.pad(~free, reach, constant_values=True).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    side = 2 * reach + 1
    return np.asarray(sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side] == 0)


def two_cells(free: Cells, wanted: Cells) -> tuple[tuple[int, int], tuple[int, int], int] | None:
    """A start, a target that a way of free cells leads to, and the free cells about all of it; None where there is no room.
    wanted: cells to start beside, if possible."""
    for reach in range(WIDEST, 0, -1):
        room = free_about(free, reach)
        if not room.any():
            continue
        beside = room & ~free_about(~wanted, reach + BESIDE)
        starts = np.argwhere(beside if beside.any() else room)
        start = tuple(starts[len(starts) // 2].tolist())
        steps, waiting, last = {start: 0}, deque([start]), start
        while waiting:
            last = x, y = waiting.popleft()
            if steps[last] >= FARTHEST:
                break
            for cell in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
                if 0 <= cell[0] < room.shape[0] and 0 <= cell[1] < room.shape[1] and room[cell] and cell not in steps:
                    steps[cell] = steps[last] + 1
                    waiting.append(cell)
        if steps[last] > 2 * reach:
            return start, last, reach
    return None


def task_text(charts: Sequence[OccupancyMap], cells: tuple[tuple[int, int], tuple[int, int], int]) -> str:
    """A task from the one cell to the other, clear of cells by a third of one."""
    *ends, reach = cells
    chart = charts[0]
    step, half = chart.resolution, chart.resolution * Fraction(reach, 2)
    middles = [[o + (k + Fraction(1, 2)) * step for o, k in zip(chart.origin, end, strict=True)] for end in ends]
    low = [max(min(m[i] for m in middles) - AROUND * step, chart.origin[i]) for i in (0, 1)]
    high = [min(max(m[i] for m in middles) + AROUND * step, chart.upper[i]) for i in (0, 1)]

    def listed(values: Sequence[Fraction]) -> str:
        return f"[{', '.join(decimal(Fraction(f'{float(v):.9f}')) for v in values)}]"

    def box(lower: Sequence[Fraction], upper: Sequence[Fraction]) -> str:
        return f"{{ lower = {listed(lower)}, upper = {listed(upper)} }}"

    start, target = (box([v - half for v in m], [v + half for v in m]) for m in middles)
    lines = ['name = "crossing"', "prescribed_time = 20", f"initial_state = {listed(middles[0])}", f"initial_set = {start}"]
    lines += [f"state_space = {box(low, high)}", f"target_set = {target}", '[emit]\nscalar = "double"']
    lines += [f"[tube]\nclearance = {float(step) / 3:.6f}\nmin_width = {float(step) / 2:.6f}"]
    return "\n".join([*lines, f"[map]\nfile = {json.dumps([str(c.path.resolve()) for c in charts])}\n"])


def cells_of_pixels(chart: OccupancyMap) -> tuple[Cells, Cells]:
    """Cells [x, y] that are not opaque white, and those of them that the threshold makes free, by the image's pixels."""
    pixels = np.array(Image.open(chart.image).convert("RGBA"))
    dark = pixels[..., :3].max(axis=-1) if chart.header.negate else 255 - pixels[..., :3].min(axis=-1)
    not_white = (dark > 255 - WHITE) | (pixels[..., 3] < 255)
    grey = not_white & (dark < 255 * float(chart.header.free_below))
    return np.asarray(not_white[::-1].T), np.asarray(grey[::-1].T)


def crossing(charts: Sequence[OccupancyMap]) -> tuple[str, str, bool]:
    """Seconds of the design, what came of it, and whether its tube stays on white cells. Maps of one size and origin."""
    unsafe = np.logical_or.reduce([chart.unsafe for chart in charts])
    grey = np.logical_or.reduce([cells_of_pixels(chart)[1] for chart in charts])
    cells = two_cells(~unsafe, grey if grey.any() else unsafe)
    if cells is None:
        return "", "no free way of some cells", True
    with tempfile.TemporaryDirectory() as name:
        task = Path(name) / "crossing.toml"
        task.write_text(task_text(charts, cells))
        begin = time.perf_counter()
        try:
            controller = build(task)
        except (BadInput, NotCertified) as error:
            return f"{time.perf_counter() - begin:.1f}", f"refused: {str(error).partition(': ')[2]:.90}", True
    seconds = time.perf_counter() - begin
    low, high = controller.design.edges_at(np.linspace(0, 20, 2001))  # type: ignore[arg-type]
    good = True
    for chart in charts:
        corner = np.argwhere(cells_of_pixels(chart)[0]) * float(chart.resolution) + [float(v) for v in chart.origin]
        near = ((corner > low.min(0) - 1) & (corner < high.max(0) + 1)).all(axis=1)
        meets = (low[:, None] < corner[near] + float(chart.resolution)) & (corner[near] < high[:, None])
        good &= not meets.all(axis=2).any()
    return (
        f"{seconds:.1f}",
        f"certified, {len(controller.task.unsafe)} sets near" + ("" if good else ", LEAVES WHITE CELLS"),
        good,
    )


def row_of(name: str, source: OccupancyMap, charts: Sequence[OccupancyMap]) -> tuple[list[str], bool]:
    """A map's row, and whether the tube stays on white cells. source: the map; charts: those of the task."""
    greys, white = source.grey_levels(), Counter(source.shade[~source.unsafe].tolist())
    grey = "none" if not greys else f"{sum(greys.values()):,}: {min(greys)}"
    grey += f" to {max(greys)}" if len(greys) > 1 else ""
    shades = f"{sum(white.values()):,}" + (f": {min(white)} to {max(white)}" if len(white) > 1 else "")
    seconds, outcome, good = crossing(charts)
    width, height = source.unsafe.shape
    threshold = decimal(source.header.free_below) + (", negated" if source.header.negate else "")
    sets = sum(len(cover_cells(chart.unsafe)) for chart in charts)
    row = [name, f"{width} x {height}", threshold, shades, grey, f"{int(source.unsafe.sum()):,}", f"{sets:,}", seconds, outcome]
    return row, good


def rows_of(path: Path, name: str) -> Iterator[tuple[list[str], bool]]:
    """The row of a map, turned upright where it is rotated, and of it with its mask."""
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
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    rows, all_good = [], True
    for path in sorted([*options.folder.rglob("*.yaml"), *options.folder.rglob("*.yml")]):
        name = str(path.relative_to(options.folder))
        try:
            results = list(rows_of(path, name))
        except BadInput as error:
            results = [([name, *[""] * 7, f"refused: {str(error).partition(': ')[2]:.90}"], True)]
        for row, good in results:
            rows.append(row)
            all_good &= good
            print(" | ".join(row), flush=True)
    text = table(HEAD, rows)
    certified = sum(row[-1].startswith("certified") for row in rows)
    grey = sum(row[4] not in ("none", "") for row in rows)
    verdict = f"{len(rows)} rows; {grey} with cells that only the thresholds make free; {certified} small tasks certified; "
    verdict += "every tube stays on white cells." if all_good else "NOT EVERY TUBE STAYS ON WHITE CELLS."
    print(verdict)
    if options.record:
        title = f"## Public maps\n\nMade by `{command()}`; {machine()}."
        sources = options.folder / "SOURCES.md"
        origins = f"\n\n{sources.read_text(encoding='utf-8')}" if sources.exists() else ""
        record(options.record, "public_maps", f"{title}\n\n{text}\n\n{verdict}{origins}")
    return int(not all_good)


if __name__ == "__main__":
    raise SystemExit(main())
