"""The spline tube along a route: its width, the time of its stretches, its linear programs."""

from stt_codegen.design.spline_tubes.slowest_tube import SplineTube, slowest_tube, smoothest_tube
from stt_codegen.design.spline_tubes.strength import crossing_time, longest_period, strength_of
from stt_codegen.design.spline_tubes.widest import (
    MANY_OBSTACLES,
    ROUTE_DETOUR_LIMIT,
    SEGMENT_TRIALS,
    TubeSearch,
    segment_counts_of,
)

__all__ = [
    "MANY_OBSTACLES",
    "ROUTE_DETOUR_LIMIT",
    "SEGMENT_TRIALS",
    "SplineTube",
    "TubeSearch",
    "crossing_time",
    "longest_period",
    "segment_counts_of",
    "slowest_tube",
    "smoothest_tube",
    "strength_of",
]
