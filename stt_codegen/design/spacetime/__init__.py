"""Routes in space and time, where unsafe sets move or are unsafe only at times."""

from stt_codegen.design.spacetime.free_cells import Cell
from stt_codegen.design.spacetime.search import FAR, Field, fields, leads, way_in_time

__all__ = ["FAR", "Cell", "Field", "fields", "leads", "way_in_time"]
