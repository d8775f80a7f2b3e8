"""What the page draws, as data: the tube at samples, sets and how they move, what the tube keeps off and how far."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.certify.missions import ServedEntry
from stt_codegen.constraints import avoidances
from stt_codegen.pipeline import EmittedController
from stt_codegen.report.clearances import distance, obstacle_bands, true_stretches
from stt_codegen.report.outlines import Array, Plane, cut_off_outlines, outline, target_outline
from stt_codegen.report.page.solids import solid
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, Course, HalfSpace, Unsafe

Rounding = Callable[[Array], Any]
SAMPLES = 600  # of the tube over time, as it is drawn; between two of them the page goes straight
DIGITS = 6  # to which a place is told, of the least extent of the state space
SOLID = 3  # dimensions of a view that turns


def scene(controller: EmittedController, mission: tuple[ServedEntry, ...], cycle: tuple[float, float] | None) -> dict[str, Any]:
    """What the page draws. Lengths in the task's units, times in seconds; outlines by pair of axes, "0,1"."""
    task = controller.task
    t = np.linspace(0.0, float(task.prescribed_time), SAMPLES + 1)
    low, high = controller.design.edges_at(t)
    planes = list(itertools.combinations(range(task.dimension), 2))
    grown, round_ = any(task.half_extents), rounding(task)
    sets = [
        _set(bare.name, bare, planes, course, round_)
        | _judged(large, grown)
        | ({"grown": _outlines(large, planes, round_), "shell": _solid(large, round_)} if grown else {})
        for bare, large, course in zip(task.unsafe_sets, task.obstacles, task.courses, strict=True)
    ]
    regions = [
        _set(name, shape.to_set_in(task.state_space, task.axis_indices(shape)), planes, None, round_)
        for name, shape in task.regions.items()
        if isinstance(shape, Unsafe)
    ]
    found = {
        "t_c": float(task.prescribed_time),
        "cycle": cycle,
        "axes": list(task.axis_labels),
        "units": list(task.units or ("",) * task.dimension),
        "planes": [list(p) for p in planes],
        "space": [_numbers(task.state_space.lower), _numbers(task.state_space.upper)],
        "walls": {_key(p): [round_(v) for v in cut_off_outlines(task, p)] for p in planes},
        "room": _half_spaces([*task.free_space.faces, *task.space_cuts]),
        "start": [_numbers(task.start.lower), _numbers(task.start.upper)],
        "body": _numbers(task.half_extents),
        "low": round_(low),
        "high": round_(high),
        "sets": sets,
        "regions": regions,
        "visits": [[one.entry, v.state, v.begin, v.end] for one in mission for v in one.visits],
        "strips": [_strip(task, i, t, low, high, round_) for i in range(task.dimension)],
        **_target(task, planes, round_),
        **_near(task, t, low, high),
    }
    if controller.design.filter:
        found["filtered"] = _filtered(controller, round_)
    return found


def _target(task: Task, planes: list[Plane], round_: Rounding) -> dict[str, Any]:
    if task.target_set is None:
        return {"target": None}
    course, end = task.target_course, task.target_course.displacement(task.prescribed_time)
    knots = [[float(at), *(float(v - e) for v, e in zip(by, end, strict=True))] for at, by in course.knots]
    span = [_numbers(task.target.lower), _numbers(task.target.upper)]
    outlines = {_key(p): round_(target_outline(task, p)) for p in planes}
    faces = _half_spaces([*task.target.faces, *task.target_cuts])
    return {"target": {"outline": outlines, "span": span, "faces": faces, **({"knots": knots} if course.is_moving else {})}}


def _near(task: Task, t: Array, low: Array, high: Array) -> dict[str, Any]:
    """By sample the nearest unsafe set and how far it is at least, left out where lengths along different axes cannot be
    compared; and where no normal keeps the tube off a set: name, from, to, and whether it meets it then (boxes) or may."""
    rows = avoidances(task)
    if not rows:
        return {"near": None, "meets": []}
    far = np.array([distance(one, t, low, high) for one in rows])
    boxes = [not s.radius and all(sum(map(bool, n)) == 1 for n in s.normals) for s in task.obstacles]
    hit = [
        [one.name, float(t[a]), float(t[b]), sure]
        for one, own, sure in zip(rows, far, boxes, strict=True)
        for a, b in true_stretches(np.asarray(own < 0))
    ]
    alike = len(set(task.units or ("",))) == 1
    which = far.argmin(axis=0)
    least = far.min(axis=0)
    near = [[int(k), _short(v)] if np.isfinite(v) else None for k, v in zip(which, least, strict=True)] if alike else None
    return {"near": near, "meets": sorted(hit, key=lambda one: one[1])}


def _strip(task: Task, i: int, t: Array, low: Array, high: Array, round_: Rounding) -> list[dict[str, Any]]:
    """What the tube keeps off in a dimension: outlines over (t, x_i), `kept` where nothing else keeps them apart."""
    found = []
    for band in obstacle_bands(task, i, t, low, high):
        still = band.lower.min() == band.lower.max() and band.upper.min() == band.upper.max()
        shown = [(True, band.is_separated_here), *([] if still and band.is_active.all() else [(False, band.is_active)])]
        for kept, where in shown:
            for a, b in true_stretches(where):
                if b > a:
                    some = np.array([a, b]) if still else np.unique(np.linspace(a, b, min(b - a + 1, 60)).astype(int))
                    edge = np.column_stack([t[some], band.upper[some]]), np.column_stack([t[some], band.lower[some]])[::-1]
                    found.append({"name": band.name, "kept": kept, "outline": round_(np.vstack(edge))})
    return found


def _filtered(controller: EmittedController, round_: Rounding) -> dict[str, Any]:
    """Order 2: lambda, and the tube of v + lambda x at samples, from the emitted Python."""
    from stt_codegen.program.targets.python.runner import load_module

    task, design = controller.task, controller.design
    module = load_module(task.name, controller.files[f"{task.name}.py"])
    t = np.linspace(0.0, float(task.prescribed_time), SAMPLES + 1)
    tick, scale = controller.program.tick, 1.0
    if tick is not None:  # in integers
        t, scale = np.rint(t / float(tick)).astype(int), math.ldexp(1.0, -module.X_BITS)
    low, high = (np.array(v) * scale for v in zip(*(module.filtered_tube(v) for v in t.tolist()), strict=True))
    return {"lambda": _numbers(design.filter), "low": round_(low), "high": round_(high)}


def _set(name: str, convex: ConvexSet, planes: list[Plane], course: Course | None, round_: Rounding) -> dict[str, Any]:
    """A set: its outlines, in three dimensions its corners and faces, and how it moves: knots (time and displacement), when it is
    unsafe, by how much its clock may be off, and how it grows."""
    found: dict[str, Any] = {"name": name, "outline": _outlines(convex, planes, round_)}
    found["solid"] = _solid(convex, round_)
    if course is not None:
        found["knots"] = [[float(at), *_numbers(by)] for at, by in course.knots]
        found["window"] = None if course.active_interval is None else _numbers(course.active_interval)
        found["clock"] = [float(course.clock_lag), float(course.clock_lead)]
        found["growth"] = [
            float(course.spread),
            [int(k in convex.bounded_axes) for k in range(convex.dimension)],
            convex.radius > 0,
        ]
    return found


def _solid(convex: ConvexSet, round_: Rounding) -> dict[str, Any] | None:
    """Corners and faces, in three dimensions."""
    if convex.dimension != SOLID:
        return None
    corners, faces = solid(np.array([[float(v) for v in p] for p in convex.vertices]))
    return {"corners": round_(corners), "faces": faces}


def _judged(convex: ConvexSet, grown: bool) -> dict[str, Any]:
    """Half-spaces that hold a set, grown by the body; round: what a round one is about, [ends, radius, its own dimensions];
    exact: whether a point in all of that is in the set, and not only near it."""
    flat = all(sum(map(bool, normal)) == 1 for normal in convex.normals)
    found = {
        "faces": _half_spaces(convex.faces),
        "exact": bool(convex.radius) or flat or not grown or len(convex.bounded_axes) < SOLID,
    }
    if convex.radius:
        found["round"] = [[_numbers(end) for end in convex.segment_ends], float(convex.radius), list(convex.bounded_axes)]
    return found


def _half_spaces(faces: Iterable[HalfSpace]) -> list[Any]:
    return [[[float(c) for c in normal], float(offset)] for normal, offset in faces]


def _outlines(convex: ConvexSet, planes: list[Plane], round_: Rounding) -> dict[str, Any]:
    return {_key(plane): round_(outline(convex, plane)) for plane in planes}


def _key(plane: Plane) -> str:
    return f"{plane[0]},{plane[1]}"


def _numbers(values: tuple[Fraction, ...]) -> list[float]:
    return [float(v) for v in values]


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def rounding(task: Task) -> Rounding:
    """How places are told: as nested lists, to DIGITS digits of the least extent of the state space, wherever its origin is."""
    least = min(float(b - a) for a, b in zip(task.state_space.lower, task.state_space.upper, strict=True))
    decimals = DIGITS - math.floor(math.log10(least))
    return lambda values: np.round(values, decimals).tolist()
