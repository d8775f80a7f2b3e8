"""Notes for `design` and `generate`: on sets that differ from what the listed points may suggest, the tube taken, visits."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import lcm

import numpy as np

from stt_codegen.certify.missions import has_momentary_visit
from stt_codegen.constraints import avoidances
from stt_codegen.decimals import by_component, decimal
from stt_codegen.design import lattice_of
from stt_codegen.pipeline import EmittedController
from stt_codegen.report.clearances import component_distance
from stt_codegen.report.closed_axis_notes import turn_notes
from stt_codegen.task import Task
from stt_codegen.task.map import Point, touching_sides, twice_area
from stt_codegen.task.sets import PLANE, Unsafe, UnsafePolytope, Vector, hull_corners

ROUNDING_ROOM = 4  # times the lattice's allowance: more than a search leaves for rounding at an edge of gamma(0)
NAMED_SETS_LIMIT = 3
VISIT_NOTE = (
    "a visit without stay may last for a moment only; stay = 2 beside visit asks for 2 s, a formula with always[0, 2] does so "
    "elsewhere; start_delay = 1 asks for a margin of 1 s in every time"
)


def controller_notes(controller: EmittedController) -> Iterator[str]:
    """Yield the notes on the task, on a tube that was taken in place of the preferred one, and on the visits of a mission."""
    yield from task_notes(controller.task)
    if controller.replaces:
        yield controller.replaces
    if any(has_momentary_visit(formula) for formula in controller.task.formulas):
        yield VISIT_NOTE


def start_rim_cause(controller: EmittedController) -> str:
    """Say why gamma(0) leaves out a rim of the initial set: unsafe sets nearer than the clearance, or room for rounding."""
    task, certificate = controller.task, controller.certificate
    box = task.start
    gaps = [max(low - a, b - high) for (low, high), a, b in zip(certificate.start, box.lower, box.upper, strict=True)]
    corners = (np.array([float(v) for v in edges]) for edges in (box.lower, box.upper))
    lower, upper = corners
    rounding = ROUNDING_ROOM * lattice_of(task).allowance
    near = {
        avoidance.name: component_distance(avoidance, lower, upper)
        for avoidance in avoidances(task)
        if component_distance(avoidance, lower, upper, beyond_clearance=True) < rounding
    }
    clearance = by_component(task.clearances)
    causes = [f"{name} is {max(v, 0.0):.3g} from it, the clearance {clearance}" for name, v in near.items()]
    if len(causes) > NAMED_SETS_LIMIT:
        causes = [*causes[:NAMED_SETS_LIMIT], f"{len(causes) - NAMED_SETS_LIMIT} more sets are as near"]
    if not causes and max(gaps) > rounding:
        return "the tube begins so"
    scalar, largest = task.emit.scalar, decimal(task.largest_coordinate)
    return "; ".join(causes) or f"room for the rounding of {scalar}, with coordinates up to {largest}"


def task_notes(task: Task) -> tuple[str, ...]:
    """Return a sentence on each map, outline and polytope that needs a note, and on which way round closed axes go."""
    return (*task.map_notes, *_set_notes(task), *turn_notes(task))


def _set_notes(task: Task) -> Iterator[str]:
    plan = task.floor_plan
    if plan is not None:
        yield "state_space: the outline is a box" + (
            f" less {_counted_walls(plan.walls)}, an exact partition" if plan.walls else ""
        )
    regions = (("region", region) for region in task.as_stated.region if isinstance(region, Unsafe))
    for kind, table in (*(("unsafe", table) for table in task.as_stated.unsafe), *regions):
        if isinstance(table, UnsafePolytope) and table.has_inner_points:
            yield f"{kind} {table.name}: {_hull_note(task, table)}"


def _counted_walls(names: tuple[str, ...]) -> str:
    if len(names) == 1:
        return f"1 convex unsafe set, {names[0]}"
    return f"{len(names)} convex unsafe sets, {names[0]} to {names[-1]}"


def _hull_note(task: Task, table: UnsafePolytope) -> str:
    """Say how much larger the avoided hull is than the polygon that the listed points form, where they form one."""
    added = added_area(table.vertices)
    if added is None:
        return "its vertices are not all corners of their hull; the hull is what is avoided"
    units = {(task.units or ("",) * task.dimension)[i] for i in task.axis_indices(table)}
    unit = f" {units.pop()}^2" if len(units) == 1 and units != {""} else ""
    return f"its hull is {float(added):.3g}{unit} larger than its outline; list convex parts if that space is needed"


def added_area(points: tuple[Vector, ...]) -> Fraction | None:
    """Return the area of the hull of points in the plane, less that of the polygon that they form in their order.

    None where they form no simple polygon, or are not in the plane.
    """
    if len(points[0]) != PLANE:
        return None
    scale = lcm(*(v.denominator for p in points for v in p))
    scaled = [(int(x * scale), int(y * scale)) for x, y in points]
    polygon: list[Point] = [p for p, q in zip(scaled, [*scaled[1:], scaled[0]], strict=True) if p != q]
    if touching_sides(polygon) is not None:
        return None
    return Fraction(twice_area(hull_corners(polygon)) - abs(twice_area(polygon)), 2 * scale**2)
