"""Unsafe sets from occupancy maps and from outlines of concave rooms: both are split into convex pieces."""

from stt_codegen.task.map.convex_pieces import Piece, count_free_cells_in, cover_cells
from stt_codegen.task.map.floor_plans import FloorPlan, expand_outline, name_walls
from stt_codegen.task.map.map_table import expand_maps, input_files, require_map_table, to_toml
from stt_codegen.task.map.occupancy import IMAGE_SIZE_LIMIT, OccupancyMap, PieceKind, read_map
from stt_codegen.task.map.polygons import Point, touching_sides, twice_area
from stt_codegen.task.map.upright import write_upright_map

__all__ = [
    "IMAGE_SIZE_LIMIT",
    "FloorPlan",
    "OccupancyMap",
    "Piece",
    "PieceKind",
    "Point",
    "count_free_cells_in",
    "cover_cells",
    "expand_maps",
    "expand_outline",
    "input_files",
    "name_walls",
    "read_map",
    "require_map_table",
    "to_toml",
    "touching_sides",
    "twice_area",
    "write_upright_map",
]
