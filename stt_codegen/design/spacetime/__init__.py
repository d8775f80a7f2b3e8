"""Routes in space and time, where unsafe sets move or are unsafe only at times."""

from stt_codegen.design.spacetime.free_cells import Cell
from stt_codegen.design.spacetime.search import UNREACHABLE, SliceSearch, find_timed_route, has_timed_route, slice_searches

__all__ = ["UNREACHABLE", "Cell", "SliceSearch", "find_timed_route", "has_timed_route", "slice_searches"]
