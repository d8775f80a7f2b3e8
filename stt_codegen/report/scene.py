"""What the page draws, as data: the tube at samples, sets and how they move, what the tube keeps off and how far."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.certify.schedule import Served
from stt_codegen.designs import RefinedDesign
from stt_codegen.designs.grid import tube_at
from stt_codegen.pipeline import Controller
from stt_codegen.report.meets import bands, distance, spans
from stt_codegen.report.outlines import Array, Plane, outline, target_outline, walls
from stt_codegen.report.solids import solid
from stt_codegen.rows import avoid_rows
from stt_codegen.sampling import speeds
from stt_codegen.task import Task
from stt_codegen.task.motion import Course
from stt_codegen.task.sets import ConvexSet
from stt_codegen.task.shapes import Unsafe

SAMPLES = 600  # of the tube over time, as it is drawn; between two of them the page goes straight
DIGITS = 6  # of a number that is drawn
SOLID = 3  # dimensions of a view that turns


def scene(controller: Controller, mission: tuple[Served, ...], cycle: tuple[float, float] | None) -> dict[str, Any]:
    """What the page draws. Lengths in the task's units, times in seconds; outlines by pair of axes, "0,1"."""
    task = controller.task
    t = np.linspace(0.0, float(task.prescribed_time), SAMPLES + 1)
    low, high = tube_at(controller.design, t)
    planes = list(itertools.combinations(range(task.dimension), 2))
    grown = any(task.half_extents)
    sets = [
        _set(bare.name, bare, planes, course) | {"faces": _faces(large)} | ({"grown": _outlines(large, planes)} if grown else {})
        for bare, large, course in zip(task.bare, task.obstacles, task.courses, strict=True)
    ]
    regions = [
        _set(name, shape.within(task.state_space, task.own_axes(shape)), planes, None)
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
        "walls": {_key(p): [_rounded(v) for v in walls(task, p)] for p in planes},
        "start": [_numbers(task.start.lower), _numbers(task.start.upper)],
        "body": _numbers(task.half_extents),
        "clearance": float(task.tube.clearance),
        "low": _rounded(low),
        "high": _rounded(high),
        "sets": sets,
        "regions": regions,
        "visits": [[one.entry, v.state, v.begin, v.end] for one in mission for v in one.visits],
        "strips": [_strip(task, i, t, low, high) for i in range(task.dimension)],
        **_target(task, planes),
        **_near(task, t, low, high),
    }
    if task.order == 2 and isinstance(controller.design, RefinedDesign):
        found["filtered"] = _filtered(controller)
    return found


def _target(task: Task, planes: list[Plane]) -> dict[str, Any]:
    if task.target_set is None:
        return {"target": None}
    course, end = task.target_course, task.target_course.displaced(task.prescribed_time)
    knots = [[float(at), *(float(v - e) for v, e in zip(by, end, strict=True))] for at, by in course.knots]
    span = [_numbers(task.target.lower), _numbers(task.target.upper)]
    outlines = {_key(p): _rounded(target_outline(task, p)) for p in planes}
    return {"target": {"outline": outlines, "span": span, **({"knots": knots} if course.moves else {})}}


def _near(task: Task, t: Array, low: Array, high: Array) -> dict[str, Any]:
    """By sample the nearest unsafe set and how far it is; and where the tube meets sets: name, from, to. Left out where lengths
    along different axes cannot be compared."""
    rows = avoid_rows(task)
    if not rows:
        return {"near": None, "meets": []}
    far = np.array([distance(one, t, low, high) for one in rows])
    hit = [
        [one.name, float(t[a]), float(t[b])] for one, own in zip(rows, far, strict=True) for a, b in spans(np.asarray(own < 0))
    ]
    alike = len(set(task.units or ("",))) == 1
    which = far.argmin(axis=0)
    least = far.min(axis=0)
    near = [[int(k), _short(v)] if np.isfinite(v) else None for k, v in zip(which, least, strict=True)] if alike else None
    return {"near": near, "meets": sorted(hit, key=lambda one: one[1])}


def _strip(task: Task, i: int, t: Array, low: Array, high: Array) -> list[dict[str, Any]]:
    """What the tube keeps off in a dimension: outlines over (t, x_i), `kept` where nothing else keeps them apart."""
    found = []
    for band in bands(task, i, t, low, high):
        still = band.lower.min() == band.lower.max() and band.upper.min() == band.upper.max()
        shown = [(True, band.kept), *([] if still and band.may.all() else [(False, band.may)])]
        for kept, where in shown:
            for a, b in spans(where):
                if b > a:
                    some = np.array([a, b]) if still else np.unique(np.linspace(a, b, min(b - a + 1, 60)).astype(int))
                    edge = np.column_stack([t[some], band.upper[some]]), np.column_stack([t[some], band.lower[some]])[::-1]
                    found.append({"name": band.name, "kept": kept, "outline": _rounded(np.vstack(edge))})
    return found


def _filtered(controller: Controller) -> dict[str, Any]:
    """Order 2: lambda, and the tube of v + lambda x at samples, from the emitted Python."""
    from stt_codegen.compare.toolchain import load_module

    task, design = controller.task, controller.design
    assert isinstance(design, RefinedDesign)
    module = load_module(task.name, controller.files[f"{task.name}.py"])
    t = np.linspace(0.0, float(task.prescribed_time), SAMPLES + 1)
    low, high = (np.array(v) for v in zip(*(module.filtered_tube(v) for v in t.tolist()), strict=True))
    slow, fast = speeds(design)
    most = np.maximum(np.abs(slow).max(axis=0), np.abs(fast).max(axis=0))
    return {"lambda": _numbers(design.filter), "low": _rounded(low), "high": _rounded(high), "speed": _rounded(most)}


def _set(name: str, convex: ConvexSet, planes: list[Plane], course: Course | None) -> dict[str, Any]:
    """A set: its outlines, in three dimensions its corners and faces, and how it moves: knots (time and displacement), when it is
    unsafe, by how much its clock may be off, and how it grows."""
    found: dict[str, Any] = {"name": name, "outline": _outlines(convex, planes)}
    if convex.dimension == SOLID:
        corners, faces = solid(np.array([[float(v) for v in p] for p in convex.vertices]))
        found["solid"] = {"corners": _rounded(corners), "faces": faces}
    if course is not None:
        found["knots"] = [[float(at), *_numbers(by)] for at, by in course.knots]
        found["window"] = None if course.window is None else _numbers(course.window)
        found["clock"] = [float(course.early), float(course.late)]
        found["growth"] = [float(course.spread), [int(k in convex.own) for k in range(convex.dimension)], convex.radius > 0]
    return found


def _faces(convex: ConvexSet) -> list[Any]:
    """Half-spaces that hold a set: of a round one, or beyond the plane with a body, they hold a little more."""
    return [[list(normal), _short(offset)] for normal, offset in convex.faces]


def _outlines(convex: ConvexSet, planes: list[Plane]) -> dict[str, Any]:
    return {_key(plane): _rounded(outline(convex, plane)) for plane in planes}


def _key(plane: Plane) -> str:
    return f"{plane[0]},{plane[1]}"


def _numbers(values: tuple[Fraction, ...]) -> list[float]:
    return [float(v) for v in values]


def _short(value: float | Fraction) -> float:
    return float(f"{float(value):.6g}")


def _rounded(values: Array) -> Any:
    """As nested lists, of DIGITS significant digits of the largest."""
    size = float(np.abs(values).max(initial=0.0)) or 1.0
    return np.round(values, max(0, DIGITS - int(np.ceil(np.log10(size))))).tolist()
