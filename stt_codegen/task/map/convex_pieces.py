"""Cover the cells of a map that are not free with few convex sets: boxes that are exactly these cells, or polygons around them.

A box joins equal runs of cells in neighbouring rows. A polygon is the hull of touching boxes, joined pair by pair while the hull
takes few free cells. `expand_maps` and the pictures of maps call it; floor plans use it for outlines along the axes.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput
from stt_codegen.task.map.occupancy import Cells, OccupancyMap, PieceKind, Window
from stt_codegen.task.sets import hull_corners

COLUMNS_AT_ONCE = 256  # of a piece, so that a map of 4096 x 4096 cells takes little memory
FREE_SHARE_LIMIT = Fraction(1, 10)  # of a polygon's area that free cells may be
CORNER_COUNT_LIMIT = 16  # of a polygon

Rectangle = tuple[int, int, int, int]  # cells from x0 to x1 and y0 to y1, the ends not among them
Corner = tuple[int, int]


@dataclass(frozen=True)
class Piece:
    """A convex set of cells: its corners counterclockwise, counted in cells from the lower left corner of the map."""

    corners: tuple[Corner, ...]
    is_box: bool

    @property
    def twice_area(self) -> int:
        """Twice the area, in cells."""
        pairs = zip(self.corners, self.corners[1:] + self.corners[:1], strict=True)
        return abs(sum(a * d - b * c for (a, b), (c, d) in pairs))


def cover_cells(unsafe: Cells, kind: PieceKind = "boxes") -> list[Piece]:
    """Return convex sets that together contain these cells and, as boxes, no others."""
    rows, columns = _rectangles(unsafe), [(c, d, a, b) for a, b, c, d in _rectangles(unsafe.T)]
    boxes = rows if len(rows) <= len(columns) else columns
    if kind == "boxes":
        return [_box(r) for r in boxes]
    return _merged(boxes)


def count_free_cells_in(unsafe: Cells, pieces: Sequence[Piece]) -> int:
    """Return the number of free cells whose middle is in some piece."""
    taken = np.zeros_like(unsafe)
    for piece in pieces:
        xs, ys = zip(*piece.corners, strict=True)
        for first in range(min(xs), max(xs), COLUMNS_AT_ONCE):
            last = min(first + COLUMNS_AT_ONCE, max(xs))
            x, y = np.meshgrid(np.arange(first, last) + 0.5, np.arange(min(ys), max(ys)) + 0.5, indexing="ij")
            inside = np.ones(x.shape, dtype=bool)
            for (a, b), (c, d) in zip(piece.corners, piece.corners[1:] + piece.corners[:1], strict=True):
                inside &= (c - a) * (y - b) - (d - b) * (x - a) >= 0
            taken[first:last, min(ys) : max(ys)] |= inside
    return int((taken & ~unsafe).sum())


def unsafe_tables(
    chart: OccupancyMap, pieces: Sequence[Piece], axes: Sequence[str] | None = None, prefix: str = "map "
) -> list[dict[str, Any]]:
    """Return the pieces as tables [[unsafe]] with exact numbers in the map's units, named by the prefix: map 1, map 2, .."""
    tables = []
    for k, piece in enumerate(pieces, 1):
        points = [[o + v * chart.resolution for v, o in zip(c, chart.origin, strict=True)] for c in piece.corners]
        table: dict[str, Any] = {"name": f"{prefix}{k}"} | ({"axes": list(axes)} if axes else {})
        if piece.is_box:
            table |= {"lower": [min(p[i] for p in points) for i in (0, 1)], "upper": [max(p[i] for p in points) for i in (0, 1)]}
        else:
            table["vertices"] = points
        tables.append(table)
    return tables


def require_cover(chart: OccupancyMap, lower: Sequence[Fraction], upper: Sequence[Fraction], names: Sequence[str]) -> None:
    """Raise `BadInput` where a box reaches beyond the map. names: of the two dimensions."""
    for i in (0, 1):
        for side, bound, excess, end in (
            ("lower", "at least", chart.origin[i] - lower[i], chart.origin[i]),
            ("upper", "at most", upper[i] - chart.upper[i], chart.upper[i]),
        ):
            if excess > 0:
                raise BadInput(
                    f"state_space.{side}: reaches beyond the map {chart.path} in {names[i]}, where nothing is known; "
                    f"use {bound} {decimal(end)} there"
                )


def window_near(chart: OccupancyMap, lower: Sequence[Fraction], upper: Sequence[Fraction], reach: Sequence[Fraction]) -> Window:
    """Return the window of cells that are within `reach` of a box, by axis; it may be empty."""
    ranges = []
    for i in (0, 1):
        first = (lower[i] - reach[i] - chart.origin[i]) // chart.resolution
        last = -((chart.origin[i] - upper[i] - reach[i]) // chart.resolution)
        ranges.append(slice(max(int(first) - 1, 0), max(int(last) + 1, 0)))  # a cell that only touches counts too
    return ranges[0], ranges[1]


def unsafe_cells_in(chart: OccupancyMap, window: Window) -> Cells:
    """Return the unsafe cells of a window, as a mask of the map."""
    cells = np.zeros_like(chart.occupied)
    cells[window] = chart.unsafe[window]
    return cells


def _box(r: Rectangle) -> Piece:
    return Piece(((r[0], r[2]), (r[1], r[2]), (r[1], r[3]), (r[0], r[3])), True)


def _rectangles(cells: Cells) -> list[Rectangle]:
    """Return rectangles that are these cells: runs along x, joined over neighbouring y where they are equal."""
    rectangles: list[Rectangle] = []
    first_rows: dict[tuple[int, int], int] = {}  # of the runs in the row before
    padded = np.zeros((cells.shape[0] + 2, cells.shape[1] + 1), dtype=np.int8)
    padded[1:-1, :-1] = cells
    steps = np.diff(padded, axis=0)
    for y in range(padded.shape[1]):
        begins, ends = np.nonzero(steps[:, y] == 1)[0], np.nonzero(steps[:, y] == -1)[0]
        runs = set(zip(begins.tolist(), ends.tolist(), strict=True))
        for run in [r for r in first_rows if r not in runs]:
            rectangles.append((*run, first_rows.pop(run), y))
        for run in runs:
            first_rows.setdefault(run, y)
    return sorted(rectangles, key=lambda r: (r[2], r[0]))


def _merged(boxes: Sequence[Rectangle]) -> list[Piece]:
    """Return hulls of touching boxes, joined pair by pair; the pair with the smallest share of free area is joined first."""
    groups: dict[int, list[Rectangle]] = {k: [box] for k, box in enumerate(boxes)}
    pieces = {k: _box(box) for k, box in enumerate(boxes)}
    neighbours: dict[int, set[int]] = {k: set() for k in groups}
    for a, b in _touching(boxes):
        neighbours[a].add(b)
        neighbours[b].add(a)
    candidates: list[tuple[Fraction, int, int]] = []

    def propose(a: int, b: int) -> None:
        hull = _hull([*groups[a], *groups[b]])
        covered = 2 * sum((x1 - x0) * (y1 - y0) for x0, x1, y0, y1 in (*groups[a], *groups[b]))
        free_share = 1 - Fraction(covered, hull.twice_area)
        if free_share <= FREE_SHARE_LIMIT and len(hull.corners) <= CORNER_COUNT_LIMIT:
            heapq.heappush(candidates, (free_share, a, b))

    for a, touching in neighbours.items():
        for b in touching:
            if a < b:
                propose(a, b)
    new = len(boxes)
    while candidates:
        _, a, b = heapq.heappop(candidates)
        if a not in groups or b not in groups:
            continue
        groups[new] = groups.pop(a) + groups.pop(b)
        pieces[new] = _hull(groups[new])
        del pieces[a], pieces[b]
        neighbours[new] = (neighbours.pop(a) | neighbours.pop(b)) - {a, b}
        for c in sorted(neighbours[new]):
            neighbours[c] -= {a, b}
            neighbours[c].add(new)
            propose(c, new)
        new += 1
    return [pieces[k] for k in sorted(pieces, key=lambda k: min((y, x) for x, y in pieces[k].corners))]


def _touching(boxes: Sequence[Rectangle]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of boxes that touch, also in a corner only, by a sweep along x."""
    reached: list[int] = []
    for k in sorted(range(len(boxes)), key=lambda k: boxes[k][0]):
        x0, _, y0, y1 = boxes[k]
        reached = [m for m in reached if boxes[m][1] >= x0]
        yield from ((m, k) for m in reached if boxes[m][2] <= y1 and y0 <= boxes[m][3])
        reached.append(k)


def _hull(boxes: Sequence[Rectangle]) -> Piece:
    """Return the hull of boxes."""
    return Piece(tuple(hull_corners([(x, y) for a, b, c, d in boxes for x in (a, b) for y in (c, d)])), False)
