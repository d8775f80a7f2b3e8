"""The spline tube along a route: its width, the time of its stretches, its linear programs."""

from stt_codegen.design.spline_tubes.shape import Shape, calmest, slowest_shape
from stt_codegen.design.spline_tubes.widest import PLENTY, QUICK, ROOM, ROUNDED, SEGMENTS, Search, segments_for, segments_tried

__all__ = [
    "PLENTY",
    "QUICK",
    "ROOM",
    "ROUNDED",
    "SEGMENTS",
    "Search",
    "Shape",
    "calmest",
    "segments_for",
    "segments_tried",
    "slowest_shape",
]
