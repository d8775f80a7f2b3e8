"""What an occupancy map is taken as: how many sets, what they cover, and a picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from stt_codegen.report.pictures.drawing import COLOURS
from stt_codegen.report.pictures.tube_pictures import save
from stt_codegen.task.map import OccupancyMap, Piece, PieceKind, count_free_cells_in, cover_cells

GREYS = {"free": 1.0, "unknown": 0.75, "occupied": 0.35}
TOO_MANY = 500  # sets whose edges would hide what is drawn


@dataclass(frozen=True)
class MapReport:
    """A map and the pieces that it is taken as. gained: free cells with their middle in a piece."""

    found: OccupancyMap
    kind: PieceKind
    pieces: tuple[Piece, ...]
    gained: int

    @property
    def counts(self) -> dict[str, int]:
        """Cells of each kind."""
        occupied, unknown = int(self.found.occupied.sum()), int(self.found.unknown.sum())
        return {"occupied": occupied, "unknown": unknown, "free": self.found.occupied.size - occupied - unknown}

    def document(self) -> dict[str, Any]:
        """As JSON."""
        found = self.found
        return {
            "cells": list(found.occupied.shape),
            "resolution": float(found.resolution),
            "lower": [float(v) for v in found.origin],
            "upper": [float(v) for v in found.upper],
            **self.counts,
            "grey": self.found.grey_levels(),
            "notes": [note for note in (self.found.grey_note(),) if note],
            "as": self.kind,
            "sets": len(self.pieces),
            "free_cells_taken": self.gained,
        }


def map_report(found: OccupancyMap, kind: PieceKind) -> MapReport:
    """The whole map, as a task without a state space would take it."""
    pieces = tuple(cover_cells(found.unsafe, kind))
    return MapReport(found, kind, pieces, count_free_cells_in(found.unsafe, pieces))


def draw_map(report: MapReport, path: Path) -> None:
    """The cells in grey, and the sets above them."""
    found = report.found
    grey = np.full(found.occupied.shape, GREYS["free"])
    grey[found.unknown], grey[found.occupied] = GREYS["unknown"], GREYS["occupied"]
    (left, bottom), (right, top) = ([float(v) for v in ends] for ends in (found.origin, found.upper))
    figure = Figure(figsize=(8, 8 * min(max((top - bottom) / (right - left), 0.3), 2)), layout="constrained")
    axis = figure.add_subplot()
    axis.imshow(grey.T, origin="lower", extent=(left, right, bottom, top), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    width = 0.8 if len(report.pieces) <= TOO_MANY else 0.2
    for piece in report.pieces:
        corners = np.array(piece.corners) * float(found.resolution) + [left, bottom]
        axis.add_patch(Polygon(corners, closed=True, facecolor=COLOURS["unsafe"], alpha=0.35, linewidth=0))
        axis.add_patch(Polygon(corners, closed=True, fill=False, edgecolor=COLOURS["unsafe"], linewidth=width))
    axis.set(title=f"{found.path.name}: {len(report.pieces)} {report.kind}", xlabel="x", ylabel="y")
    save(figure, path)
