"""Routes of the tube's centre among unsafe sets that are grown by half a tube, and the side of each set that is passed."""

from stt_codegen.design.routes.corner_search import COMPONENT_SUM_WEIGHT, Route, route_nodes
from stt_codegen.design.routes.grown_sets import GrownObstacles, grow_obstacles
from stt_codegen.design.routes.segment_bounds import (
    SegmentBounds,
    bounds_along_route,
    bounds_along_timed_route,
    bounds_around_tube,
)
from stt_codegen.design.routes.shortest_route import find_route, shortest_route
from stt_codegen.design.routes.sides import Sides, bounds_by_stretch, choose_sides

__all__ = [
    "COMPONENT_SUM_WEIGHT",
    "GrownObstacles",
    "Route",
    "SegmentBounds",
    "Sides",
    "bounds_along_route",
    "bounds_along_timed_route",
    "bounds_around_tube",
    "bounds_by_stretch",
    "choose_sides",
    "find_route",
    "grow_obstacles",
    "route_nodes",
    "shortest_route",
]
