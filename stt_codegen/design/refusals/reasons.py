"""The reason why no tube is found: which limits, which sets, or which entries of the mission exclude one.

refine.py calls `explain_refusal`. Sets that move and missions have reasons of their own (closed_routes.py,
unmet_missions.py). What would help is tried later, to the end: remedies/ does that.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from stt_codegen.decimals import by_component
from stt_codegen.design.arena import Arena, starting_box
from stt_codegen.design.refusals.closed_routes import explain_closed_routes
from stt_codegen.design.refusals.unmet_missions import HasTube, explain_conflict, explain_unmet_mission
from stt_codegen.design.routes import shortest_route
from stt_codegen.design.spline_tubes import segment_counts_of
from stt_codegen.errors import Reason
from stt_codegen.properties import Property
from stt_codegen.task import Task

LimitValue = Fraction | tuple[Fraction, ...]


def explain_refusal(task: Task, arena: Arena, has_tube: HasTube) -> Reason:
    """Return why there is no tube for the task, whose arena this is."""
    limits = {f"tube.{name}": getattr(task.tube, name) for name in ("max_speed", "max_acceleration")}
    limits["control.u_max"] = task.u_max if task.requires_input_limits else None
    limits = {name: value for name, value in limits.items() if value is not None}
    if limits and has_tube(_without_limits(task)):
        return _explain_limits(task, arena, limits)
    if task.mission:
        return explain_unmet_mission(task, arena)
    if arena.timed_obstacles:
        resting = replace(arena, timed_obstacles=())
        # the sets that do not move may close every route by themselves: this raises then
        shortest_route(resting, starting_box(arena), arena.min_widths)
        return explain_closed_routes(arena, segment_counts_of(task, arena)[0])
    segment_counts = segment_counts_of(task, arena)
    count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {segment_counts[-1]} segments"
    problem = f"{Property.AVOID.label}: no spline tube of {count} was found along the shortest route"
    return Reason(problem, Property.AVOID.advice, codes=(Property.AVOID.code,))


def _without_limits(task: Task) -> Task:
    """Return the task without bounds on speed, acceleration and u, in a scalar that needs none of u.

    Its period stays: a lag, a latency and a velocity by differences need one, and no tube is searched for by it.
    """
    in_floats = {"emit": {"scalar": "float"}} if task.emit.scalar == "fixed" else {}
    return task.changed(
        tube={"max_speed": None, "max_acceleration": None}, control={"u_max": None, "u_norm": None, "saturate": None}, **in_floats
    )


def _explain_limits(task: Task, arena: Arena, limits: dict[str, LimitValue]) -> Reason:
    """Return the reason where the limits leave no tube."""
    bounds = " and ".join(f"{name} = {_written(value)}" for name, value in limits.items())
    rates = [word for name, word in (("tube.max_speed", "speed"), ("tube.max_acceleration", "acceleration")) if name in limits]
    subjects = {Property.SMOOTH: Property.SMOOTH.label_of(" and ".join(rates))} if rates else {}
    subjects |= {Property.LIMITS: Property.LIMITS.label} if "control.u_max" in limits else {}
    problem = f"{' and '.join(subjects.values())}: no tube was found within {bounds}{explain_conflict(task, arena)}"
    return Reason(problem, f"try without {' and '.join(limits)}", codes=tuple(p.code for p in subjects))


def _written(value: LimitValue) -> str:
    return by_component(value if isinstance(value, tuple) else (value,))
