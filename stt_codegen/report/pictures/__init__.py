"""Draw sets, maps and tubes. Imports matplotlib."""

from stt_codegen.report.pictures.drawing import COLOURS, SampledTube, label, patch, sample_tube
from stt_codegen.report.pictures.map_pictures import draw_map, map_report
from stt_codegen.report.pictures.tube_pictures import (
    draw,
    draw_arena,
    draw_dimension,
    draw_sets,
    draw_trade,
    figure_of,
    figure_with_times,
    panels,
    picture_path,
    plane_named,
    planes_of,
    save,
)

__all__ = [
    "COLOURS",
    "SampledTube",
    "draw",
    "draw_arena",
    "draw_dimension",
    "draw_map",
    "draw_sets",
    "draw_trade",
    "figure_of",
    "figure_with_times",
    "label",
    "map_report",
    "panels",
    "patch",
    "picture_path",
    "plane_named",
    "planes_of",
    "sample_tube",
    "save",
]
