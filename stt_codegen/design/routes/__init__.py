"""Routes of the tube's centre among unsafe sets that are grown by half a tube, and the side of each set that is passed."""

from stt_codegen.design.routes.grown_sets import Obstacles, obstacles_of
from stt_codegen.design.routes.shortest_route import STRAIGHT, Route, route_nodes, shortest_route, wide_route
from stt_codegen.design.routes.sides import (
    Limits,
    Stay,
    choose_sides,
    limits_along,
    limits_by_stretch,
    limits_in_time,
    limits_of_tube,
)

__all__ = [
    "STRAIGHT",
    "Limits",
    "Obstacles",
    "Route",
    "Stay",
    "choose_sides",
    "limits_along",
    "limits_by_stretch",
    "limits_in_time",
    "limits_of_tube",
    "obstacles_of",
    "route_nodes",
    "shortest_route",
    "wide_route",
]
