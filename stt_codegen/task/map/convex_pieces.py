"""The cells that are not free as few convex sets: boxes that are exactly these cells, or convex polygons that hold them.

Boxes: runs of cells in a row, joined with the same runs of the next. Polygons: touching boxes are joined two by two while their
hull takes little more than they do.
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

GAIN = Fraction(1, 10)  # of a polygon's area may be free cells
MOST_CORNERS = 16  # of a polygon

Rectangle = tuple[int, int, int, int]  # cells from x0 to x1 and y0 to y1, the ends not among them
Corner = tuple[int, int]


@dataclass(frozen=True)
class Piece:
    """A convex set of cells: its corners, by cells from the lower left corner, in order around it."""

    corners: tuple[Corner, ...]
    box: bool

    @property
    def twice_area(self) -> int:
        """In cells."""
        pairs = zip(self.corners, self.corners[1:] + self.corners[:1], strict=True)
        return abs(sum(a * d - b * c for (a, b), (c, d) in pairs))


def cover_cells(unsafe: Cells, kind: PieceKind = "boxes") -> list[Piece]:
    """Sets that together hold every one of these cells."""
    rows, columns = _rectangles(unsafe), [(c, d, a, b) for a, b, c, d in _rectangles(unsafe.T)]
    boxes = rows if len(rows) <= len(columns) else columns
    if kind == "boxes":
        return [_box(r) for r in boxes]
    return _merged(boxes)


def count_free_cells_in(unsafe: Cells, pieces: Sequence[Piece]) -> int:
    """How many free cells have their middle in some piece."""
    taken = np.zeros_like(unsafe)
    for piece in pieces:
        xs, ys = zip(*piece.corners, strict=True)
        part = np.s_[min(xs) : max(xs), min(ys) : max(ys)]
        x, y = np.meshgrid(np.arange(min(xs), max(xs)) + 0.5, np.arange(min(ys), max(ys)) + 0.5, indexing="ij")
        inside = np.ones(x.shape, dtype=bool)
        for (a, b), (c, d) in zip(piece.corners, piece.corners[1:] + piece.corners[:1], strict=True):
            inside &= (c - a) * (y - b) - (d - b) * (x - a) >= 0
        taken[part] |= inside
    return int((taken & ~unsafe).sum())


def unsafe_tables(
    chart: OccupancyMap, pieces: Sequence[Piece], axes: Sequence[str] | None = None, prefix: str = "map "
) -> list[dict[str, Any]]:
    """The pieces as tables of a task, with exact numbers in the map's units: named map 1, map 2, .. by the prefix."""
    tables = []
    for k, piece in enumerate(pieces, 1):
        points = [[o + v * chart.resolution for v, o in zip(c, chart.origin, strict=True)] for c in piece.corners]
        table: dict[str, Any] = {"name": f"{prefix}{k}"} | ({"axes": list(axes)} if axes else {})
        if piece.box:
            table |= {"lower": [min(p[i] for p in points) for i in (0, 1)], "upper": [max(p[i] for p in points) for i in (0, 1)]}
        else:
            table["vertices"] = points
        tables.append(table)
    return tables


def require_cover(chart: OccupancyMap, lower: Sequence[Fraction], upper: Sequence[Fraction], names: Sequence[str]) -> None:
    """Raise `BadInput` where a box reaches beyond the map. names: of the dimensions."""
    for i in (0, 1):
        for side, most, over, end in (
            ("lower", "least", chart.origin[i] - lower[i], chart.origin[i]),
            ("upper", "most", upper[i] - chart.upper[i], chart.upper[i]),
        ):
            if over > 0:
                raise BadInput(
                    f"state_space.{side}: reaches beyond the map {chart.path} in {names[i]}, where nothing is known; "
                    f"use at {most} {decimal(end)} there"
                )


def window_near(chart: OccupancyMap, lower: Sequence[Fraction], upper: Sequence[Fraction], reach: Fraction) -> Window:
    """The cells of which some part is within `reach` of a box, in the largest component; may be empty."""
    parts = []
    for i in (0, 1):
        first = (lower[i] - reach - chart.origin[i]) // chart.resolution
        last = -((chart.origin[i] - upper[i] - reach) // chart.resolution)
        parts.append(slice(max(int(first) - 1, 0), max(int(last) + 1, 0)))  # a cell that only touches counts too
    return parts[0], parts[1]


def within(chart: OccupancyMap, window: Window) -> Cells:
    """The unsafe cells of a window; all others count as free."""
    kept = np.zeros_like(chart.occupied)
    kept[window] = chart.unsafe[window]
    return kept


def _box(r: Rectangle) -> Piece:
    return Piece(((r[0], r[2]), (r[1], r[2]), (r[1], r[3]), (r[0], r[3])), True)


def _rectangles(cells: Cells) -> list[Rectangle]:
    """Runs along x, joined over neighbouring y where they are the same."""
    found: list[Rectangle] = []
    open_: dict[tuple[int, int], int] = {}  # runs of the row before, and where they began
    padded = np.zeros((cells.shape[0] + 2, cells.shape[1] + 1), dtype=np.int8)
    padded[1:-1, :-1] = cells
    steps = np.diff(padded, axis=0)
    for y in range(padded.shape[1]):
        begins, ends = np.nonzero(steps[:, y] == 1)[0], np.nonzero(steps[:, y] == -1)[0]
        runs = set(zip(begins.tolist(), ends.tolist(), strict=True))
        for run in [r for r in open_ if r not in runs]:
            found.append((*run, open_.pop(run), y))
        for run in runs:
            open_.setdefault(run, y)
    return sorted(found, key=lambda r: (r[2], r[0]))


def _merged(boxes: Sequence[Rectangle]) -> list[Piece]:
    """Touching boxes joined two by two, the pair that takes the least free area first, while their hull takes little."""
    groups: dict[int, list[Rectangle]] = {k: [box] for k, box in enumerate(boxes)}
    pieces = {k: _box(box) for k, box in enumerate(boxes)}
    beside: dict[int, set[int]] = {k: set() for k in groups}
    for a, b in _touching(boxes):
        beside[a].add(b)
        beside[b].add(a)
    waiting: list[tuple[Fraction, int, int]] = []

    def ask(a: int, b: int) -> None:
        together = _hull([*groups[a], *groups[b]])
        covered = 2 * sum((x1 - x0) * (y1 - y0) for x0, x1, y0, y1 in (*groups[a], *groups[b]))
        gain = 1 - Fraction(covered, together.twice_area)
        if gain <= GAIN and len(together.corners) <= MOST_CORNERS:
            heapq.heappush(waiting, (gain, a, b))

    for a, others in beside.items():
        for b in others:
            if a < b:
                ask(a, b)
    new = len(boxes)
    while waiting:
        _, a, b = heapq.heappop(waiting)
        if a not in groups or b not in groups:
            continue
        groups[new] = groups.pop(a) + groups.pop(b)
        pieces[new] = _hull(groups[new])
        del pieces[a], pieces[b]
        near = (beside.pop(a) | beside.pop(b)) - {a, b}
        beside[new] = near
        for c in sorted(near):
            beside[c] -= {a, b}
            beside[c].add(new)
            ask(c, new)
        new += 1
    return [pieces[k] for k in sorted(pieces, key=lambda k: min((y, x) for x, y in pieces[k].corners))]


def _touching(boxes: Sequence[Rectangle]) -> Iterator[tuple[int, int]]:
    """Pairs of boxes that touch one another, corners too."""
    live: list[int] = []
    for k in sorted(range(len(boxes)), key=lambda k: boxes[k][0]):
        x0, _, y0, y1 = boxes[k]
        live = [m for m in live if boxes[m][1] >= x0]
        yield from ((m, k) for m in live if boxes[m][2] <= y1 and y0 <= boxes[m][3])
        live.append(k)


def _hull(boxes: Sequence[Rectangle]) -> Piece:
    """The hull of boxes."""
    return Piece(tuple(hull_corners([(x, y) for a, b, c, d in boxes for x in (a, b) for y in (c, d)])), False)
