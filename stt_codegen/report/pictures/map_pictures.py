"""Report and draw the unsafe sets that an occupancy map becomes, for `stt-codegen map`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from stt_codegen.report.pictures.drawing import COLOURS
from stt_codegen.report.pictures.tube_pictures import save
from stt_codegen.task.map import OccupancyMap, Piece, PieceKind, count_free_cells_in, cover_cells

GREYS = {"free": 1.0, "unknown": 0.75, "occupied": 0.35}
PICTURE_CELLS_LIMIT = 1600  # cells a side; the picture has half as many pixels
OUTLINED_PIECE_LIMIT = 500  # pieces; with more, thick outlines would hide the cells


@dataclass(frozen=True)
class MapReport:
    """A map and the convex pieces that cover its unsafe cells. covered_free_cells: free cells whose middle is in a piece."""

    occupancy_map: OccupancyMap
    kind: PieceKind
    pieces: tuple[Piece, ...]
    covered_free_cells: int

    @property
    def counts(self) -> dict[str, int]:
        """The number of cells of each kind."""
        occupied, unknown = int(self.occupancy_map.occupied.sum()), int(self.occupancy_map.unknown.sum())
        return {"occupied": occupied, "unknown": unknown, "free": self.occupancy_map.occupied.size - occupied - unknown}

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        occupancy_map = self.occupancy_map
        return {
            "cells": list(occupancy_map.occupied.shape),
            "resolution": float(occupancy_map.resolution),
            "lower": [float(v) for v in occupancy_map.origin],
            "upper": [float(v) for v in occupancy_map.upper],
            **self.counts,
            "grey": self.occupancy_map.grey_levels(),
            "notes": [note for note in (self.occupancy_map.grey_note(),) if note],
            "as": self.kind,
            "sets": len(self.pieces),
            "free_cells_taken": self.covered_free_cells,
        }


def map_report(occupancy_map: OccupancyMap, kind: PieceKind) -> MapReport:
    """Cover a map, as a task without a state space does."""
    pieces = tuple(cover_cells(occupancy_map.unsafe, kind))
    return MapReport(occupancy_map, kind, pieces, count_free_cells_in(occupancy_map.unsafe, pieces))


def _fit_for_picture(cells: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return cells of a map in blocks, of which none is lost, with at most `PICTURE_CELLS_LIMIT` a side."""
    block = -(-max(cells.shape) // PICTURE_CELLS_LIMIT)
    if block == 1:
        return cells
    padded = np.pad(cells, [(0, -n % block) for n in cells.shape])
    return np.asarray(padded.reshape(padded.shape[0] // block, block, -1, block).any(axis=(1, 3)), dtype=bool)


def draw_map(report: MapReport, path: Path) -> None:
    """Save a picture of the cells in grey, with the pieces above them."""
    occupancy_map = report.occupancy_map
    unknown, occupied = (_fit_for_picture(cells) for cells in (occupancy_map.unknown, occupancy_map.occupied))
    grey = np.full(occupied.shape, GREYS["free"])
    grey[unknown], grey[occupied] = GREYS["unknown"], GREYS["occupied"]
    (left, bottom), (right, top) = ([float(v) for v in ends] for ends in (occupancy_map.origin, occupancy_map.upper))
    figure = Figure(figsize=(8, 8 * min(max((top - bottom) / (right - left), 0.3), 2)), layout="constrained")
    axis = figure.add_subplot()
    axis.imshow(grey.T, origin="lower", extent=(left, right, bottom, top), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    width = 0.8 if len(report.pieces) <= OUTLINED_PIECE_LIMIT else 0.2
    for piece in report.pieces:
        corners = np.array(piece.corners) * float(occupancy_map.resolution) + [left, bottom]
        axis.add_patch(Polygon(corners, closed=True, facecolor=COLOURS["unsafe"], alpha=0.35, linewidth=0))
        axis.add_patch(Polygon(corners, closed=True, fill=False, edgecolor=COLOURS["unsafe"], linewidth=width))
    axis.set(title=f"{occupancy_map.path.name}: {len(report.pieces)} {report.kind}", xlabel="x", ylabel="y")
    save(figure, path)
