"""Pictures of sets, maps and tubes. They import matplotlib."""

from stt_codegen.report.pictures.drawing import COLOURS, label, patch
from stt_codegen.report.pictures.map_pictures import draw_map, map_report
from stt_codegen.report.pictures.tube_pictures import (
    draw,
    draw_arena,
    draw_dimension,
    draw_sets,
    draw_trade,
    figure_of,
    panels,
    picture_path,
    plane_named,
    planes_of,
    save,
    sheet,
)

__all__ = [
    "COLOURS",
    "draw",
    "draw_arena",
    "draw_dimension",
    "draw_map",
    "draw_sets",
    "draw_trade",
    "figure_of",
    "label",
    "map_report",
    "panels",
    "patch",
    "picture_path",
    "plane_named",
    "planes_of",
    "save",
    "sheet",
]
