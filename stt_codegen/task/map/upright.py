"""Turn a rotated occupancy map into an upright one with cells of the same size, in which no unsafe point becomes free.

An upright cell is free where every rotated cell that it may touch is free and on the map. So walls grow by up to a cell's
diagonal, and no thin wall is lost, as it would be if each pixel took the value of the nearest one. The command `map` calls it.
"""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput, about
from stt_codegen.files import locked, write_files
from stt_codegen.task.map.map_yaml import read_header
from stt_codegen.task.map.occupancy import SIDE_CELLS_LIMIT, Cells, FreeRule, cells_of

ROUNDING = 1e-6  # cells; the error of doubles is below 1e-9 cells for the at most 3 * 4096 cells a side
FULL_TURN = 7  # radians, more than 2 pi
FREE, UNKNOWN = 254, 205  # the greys of savers


def write_upright_map(path: Path, target: Path, free_rule: FreeRule = "white") -> dict[str, int]:
    """Write the upright map to `target` (.yaml) and the .png beside it; return the numbers of free cells after and before.

    Raises `BadInput` where the map is not rotated, the upright map is too large, or a file of that name exists."""
    from PIL import Image

    header, image = read_header(path), target.with_suffix(".png")
    if not header.yaw:
        raise BadInput(f"{path}: origin: is not rotated; use it as it is")
    if abs(header.yaw) > FULL_TURN:
        raise BadInput(
            f"{path}: origin: is rotated by {decimal(header.yaw)} rad, more than a full turn; give the angle in radians"
        )
    if target.suffix not in (".yaml", ".yml"):
        raise BadInput(f"--upright: {target} does not end in .yaml; give the path of the upright map's .yaml")
    _require_absent(target, image)
    chart = cells_of(header, free_rule)
    first, unsafe = rotate_cells(chart.unsafe, float(header.yaw))
    pixels = np.where(unsafe, UNKNOWN, FREE).astype(np.uint8)
    origin = ", ".join(decimal(o + k * header.resolution) for o, k in zip(header.origin, first, strict=True))
    lines = [f"image: {image.name}", f"resolution: {decimal(header.resolution)}", f"origin: [{origin}, 0.0]", "negate: 0"]
    lines += ["mode: trinary", "occupied_thresh: 0.65", "free_thresh: 0.196"]
    png = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels.T[::-1])).save(png, "PNG")
    with about("--upright"), locked([target.parent]):
        _require_absent(target, image)
        write_files(target.parent, {image.name: png.getvalue(), target.name: ("\n".join(lines) + "\n").encode()})
    return {"free": int((~unsafe).sum()), "free_before": int((~chart.unsafe).sum())}


def _require_absent(*files: Path) -> None:
    """Raise `BadInput` where a file exists."""
    for file in files:
        if file.exists() or file.is_symlink():
            raise BadInput(f"--upright: {file} exists; give another name")


def rotate_cells(unsafe: Cells, yaw: float) -> tuple[tuple[int, int], Cells]:
    """Return the lower left cell of the upright map, counted from the corner of the rotated map, and its unsafe cells.

    yaw: the rotation of the map, in radians. Raises `BadInput` where the upright map is too large."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    corners = np.array([[x, y] for x in (0, unsafe.shape[0]) for y in (0, unsafe.shape[1])])
    ends = corners @ np.array([[cos, sin], [-sin, cos]])
    first, last = np.floor(ends.min(axis=0)).astype(int), np.ceil(ends.max(axis=0)).astype(int)
    if (last - first).max() > SIDE_CELLS_LIMIT:
        width, height = last - first
        raise BadInput(
            f"--upright: the upright map has {width} x {height} cells; at most {SIDE_CELLS_LIMIT} a side are taken, cut it"
        )
    padded = np.pad(unsafe, 1, constant_values=True)  # beyond the map no cell is known to be free
    sums = np.pad(padded.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    half = (abs(cos) + abs(sin)) / 2 + ROUNDING  # half width of the box about an upright cell, in the frame of the rotated map
    upright = np.ones((last[0] - first[0], last[1] - first[1]), dtype=bool)
    y = np.arange(first[1], last[1]) + 0.5
    for column in range(upright.shape[0]):
        x = first[0] + column + 0.5
        middle = (cos * x + sin * y, cos * y - sin * x)
        low, high = zip(*(_cells_between(m - half, m + half, n) for m, n in zip(middle, unsafe.shape, strict=True)), strict=True)
        touched = sums[high[0], high[1]] - sums[low[0], high[1]] - sums[high[0], low[1]] + sums[low[0], low[1]]
        upright[column] = touched > 0
    return (int(first[0]), int(first[1])), upright


def _cells_between(low: np.ndarray, high: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and last index into the sums over padded cells of an interval of cells. count: the cells of the map."""
    first = np.clip(np.floor(low).astype(int), -1, count) + 1
    return first, np.clip(np.floor(high).astype(int), -1, count) + 2
