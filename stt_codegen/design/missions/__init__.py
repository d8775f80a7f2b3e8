"""Plans of a mission: what its formulas require of the tube, in which order its events happen, where and when."""

from stt_codegen.design.missions.conflicts import describe_conflict
from stt_codegen.design.missions.orders import OrderSearch
from stt_codegen.design.missions.plans import (
    MOMENT,
    TIME_MARGIN_SPEED,
    Plan,
    centre_along,
    choose_knots,
    mission_obstacles,
    plan_of_stops,
    slowest_plan,
)
from stt_codegen.design.missions.skeleton import START, TOLERANCE, Skeleton
from stt_codegen.design.missions.spacetime_plans import route_with_events
from stt_codegen.design.missions.state_constraints import Mission, mission_of, require_start
from stt_codegen.design.missions.waypoints import Waypoints

__all__ = [
    "MOMENT",
    "START",
    "TIME_MARGIN_SPEED",
    "TOLERANCE",
    "Mission",
    "OrderSearch",
    "Plan",
    "Skeleton",
    "Waypoints",
    "centre_along",
    "choose_knots",
    "describe_conflict",
    "mission_obstacles",
    "mission_of",
    "plan_of_stops",
    "require_start",
    "route_with_events",
    "slowest_plan",
]
