"""Sets that a task takes from files and outlines: occupancy maps and concave rooms, as convex pieces."""

from stt_codegen.task.map.convex_pieces import Piece, gained, pieces_of
from stt_codegen.task.map.map_table import expanded, files_behind, written
from stt_codegen.task.map.occupancy import Kind, OccupancyMap, read_map
from stt_codegen.task.map.polygons import Point, self_meeting, twice_area
from stt_codegen.task.map.rooms import Room, in_words_of_outline, without_outline
from stt_codegen.task.map.upright import upright_map

__all__ = [
    "Kind",
    "OccupancyMap",
    "Piece",
    "Point",
    "Room",
    "expanded",
    "files_behind",
    "gained",
    "in_words_of_outline",
    "pieces_of",
    "read_map",
    "self_meeting",
    "twice_area",
    "upright_map",
    "without_outline",
    "written",
]
