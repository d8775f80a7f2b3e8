"""Plans of a mission: what its formulas ask of the tube, in which order its events happen, where and when."""

from stt_codegen.design.missions.conflicts import clash
from stt_codegen.design.missions.orders import Order
from stt_codegen.design.missions.plans import Plan, centre_of, demands_of, knots_of, plan_of, timed_plan
from stt_codegen.design.missions.skeleton import START, TINY, Skeleton
from stt_codegen.design.missions.spacetime_plans import way_with_events
from stt_codegen.design.missions.state_constraints import Mission, mission_of, require_start
from stt_codegen.design.missions.waypoints import Places

__all__ = [
    "START",
    "TINY",
    "Mission",
    "Order",
    "Places",
    "Plan",
    "Skeleton",
    "centre_of",
    "clash",
    "demands_of",
    "knots_of",
    "mission_of",
    "plan_of",
    "require_start",
    "timed_plan",
    "way_with_events",
]
