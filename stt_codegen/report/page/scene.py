"""Collect what the page draws as JSON data: the tube at samples, sets and their motion, and distances from them.

templates/report/scene.js reads it; names of keys are those of the scripts.
"""

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
from stt_codegen.report.clearances import ObstacleBand, distance, obstacle_bands, true_stretches
from stt_codegen.report.outlines import Array, Plane, cut_off_outlines, outline, target_outline
from stt_codegen.report.page.solids import convex_solid
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, Course, HalfSpace, Unsafe

Rounding = Callable[[Array], Any]
SAMPLES = 600  # segments of time; the page interpolates between their ends
DIGITS = 6  # of a position, relative to the smallest extent of the state space
SOLID_DIMENSIONS = 3  # of the view that turns


def scene(controller: EmittedController, mission: tuple[ServedEntry, ...], cycle: tuple[float, float] | None) -> dict[str, Any]:
    """Return the data: lengths in the task's units, times in seconds, outlines by pair of axes such as "0,1".

    cycle: from and until when, in seconds, the tube repeats.
    """
    task = controller.task
    t = np.linspace(0.0, float(task.prescribed_time), SAMPLES + 1)
    low, high = controller.design.edges_at(t)
    planes = list(itertools.combinations(range(task.dimension), 2))
    has_body, round_ = any(task.half_extents), position_rounding(task)
    sets = [
        _set(bare.name, bare, planes, course, round_)
        | _half_space_data(grown, has_body)
        | ({"grown": _outlines(grown, planes, round_), "shell": _solid(grown, round_)} if has_body else {})
        for bare, grown, course in zip(task.unsafe_sets, task.obstacles, task.courses, strict=True)
    ]
    regions = [
        _set(name, shape.to_set_in(task.state_space, task.axis_indices(shape)), planes, None, round_)
        for name, shape in task.regions.items()
        if isinstance(shape, Unsafe)
    ]
    data = {
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
        "visits": [[served.entry, v.state, v.begin, v.end] for served in mission for v in served.visits],
        "strips": [_strip([*obstacle_bands(task, i, t, low, high)], t, round_) for i in range(task.dimension)],
        **_target(task, planes, round_),
        **_distances(task, t, low, high),
    }
    if controller.design.filter:
        data["filtered"] = _filtered(controller, round_)
    return data


def _target(task: Task, planes: list[Plane], round_: Rounding) -> dict[str, Any]:
    """Return the target at t_c, its half-spaces, and its displacements from there if it moves."""
    if task.target_set is None:
        return {"target": None}
    course, end = task.target_course, task.target_course.displacement(task.prescribed_time)
    knots = [[float(at), *(float(v - e) for v, e in zip(by, end, strict=True))] for at, by in course.knots]
    span = [_numbers(task.target.lower), _numbers(task.target.upper)]
    outlines = {_key(p): round_(target_outline(task, p)) for p in planes}
    faces = _half_spaces([*task.target.faces, *task.target_cuts])
    return {"target": {"outline": outlines, "span": span, "faces": faces, **({"knots": knots} if course.is_moving else {})}}


def _distances(task: Task, t: Array, low: Array, high: Array) -> dict[str, Any]:
    """Return the nearest unsafe set by sample, with its distance, and when no normal separates the tube from a set.

    near: None where axes have different units. meets: name, from, to, and whether it surely overlaps (boxes) or may.
    """
    sets = avoidances(task)
    if not sets:
        return {"near": None, "meets": []}
    distances = np.array([distance(avoidance, t, low, high) for avoidance in sets])
    is_box = [not s.radius and all(sum(map(bool, n)) == 1 for n in s.normals) for s in task.obstacles]
    overlaps = [
        (avoidance.name, float(t[a]), float(t[b]), is_sure)
        for avoidance, to_set, is_sure in zip(sets, distances, is_box, strict=True)
        for a, b in true_stretches(np.asarray(to_set < 0))
    ]
    near = None
    if len(set(task.units or ("",))) == 1:
        pairs = zip(distances.argmin(axis=0), distances.min(axis=0), strict=True)
        near = [[int(k), _six_digits(v)] if np.isfinite(v) else None for k, v in pairs]
    return {"near": near, "meets": [list(overlap) for overlap in sorted(overlaps, key=lambda overlap: overlap[1])]}


def _strip(bands: Iterable[ObstacleBand], t: Array, round_: Rounding) -> list[dict[str, Any]]:
    """Return outlines over (t, x_i) of unsafe sets in one dimension; `kept`: while only this dimension separates them."""
    outlines = []
    for band in bands:
        is_constant = band.lower.min() == band.lower.max() and band.upper.min() == band.upper.max()
        stretches = [(True, band.separates_alone)]
        if not (is_constant and band.is_active.all()):
            stretches.append((False, band.is_active))
        for separates_alone, flags in stretches:
            for a, b in true_stretches(flags):
                if b > a:
                    samples = np.array([a, b]) if is_constant else np.unique(np.linspace(a, b, min(b - a + 1, 60)).astype(int))
                    upper = np.column_stack([t[samples], band.upper[samples]])
                    lower = np.column_stack([t[samples], band.lower[samples]])
                    outline = round_(np.vstack([upper, lower[::-1]]))
                    outlines.append({"name": band.name, "kept": separates_alone, "outline": outline})
    return outlines


def _filtered(controller: EmittedController, round_: Rounding) -> dict[str, Any]:
    """Return, for order 2, lambda and the tube of v + lambda x at samples, from the emitted Python."""
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
    """Return a set's outlines, in three dimensions its corners and faces, and its course.

    knots: time and displacement; window: active interval; clock: how much it may lag and lead; growth: speed, which axes grow,
    and whether it is round.
    """
    data: dict[str, Any] = {"name": name, "outline": _outlines(convex, planes, round_)}
    data["solid"] = _solid(convex, round_)
    if course is not None:
        data["knots"] = [[float(at), *_numbers(by)] for at, by in course.knots]
        data["window"] = None if course.active_interval is None else _numbers(course.active_interval)
        data["clock"] = [float(course.clock_lag), float(course.clock_lead)]
        data["growth"] = [
            float(course.spread),
            [int(k in convex.bounded_axes) for k in range(convex.dimension)],
            convex.radius > 0,
        ]
    return data


def _solid(convex: ConvexSet, round_: Rounding) -> dict[str, Any] | None:
    """Return corners and faces in three dimensions, else None."""
    if convex.dimension != SOLID_DIMENSIONS:
        return None
    corners, faces = convex_solid(np.array([[float(v) for v in p] for p in convex.vertices]))
    return {"corners": round_(corners), "faces": faces}


def _half_space_data(convex: ConvexSet, has_body: bool) -> dict[str, Any]:
    """Return the half-spaces that contain a set, grown by the body, by which the page decides whether a state is in it.

    round: of a round set, its segment's ends, radius and dimensions. exact: whether a state in all half-spaces is in the set.
    """
    is_along_axes = all(sum(map(bool, normal)) == 1 for normal in convex.normals)
    data: dict[str, Any] = {
        "faces": _half_spaces(convex.faces),
        "exact": bool(convex.radius) or is_along_axes or not has_body or len(convex.bounded_axes) < SOLID_DIMENSIONS,
    }
    if convex.radius:
        data["round"] = [[_numbers(end) for end in convex.segment_ends], float(convex.radius), list(convex.bounded_axes)]
    return data


def _half_spaces(faces: Iterable[HalfSpace]) -> list[Any]:
    return [[[float(c) for c in normal], float(offset)] for normal, offset in faces]


def _outlines(convex: ConvexSet, planes: list[Plane], round_: Rounding) -> dict[str, Any]:
    return {_key(plane): round_(outline(convex, plane)) for plane in planes}


def _key(plane: Plane) -> str:
    return f"{plane[0]},{plane[1]}"


def _numbers(values: tuple[Fraction, ...]) -> list[float]:
    return [float(v) for v in values]


def _six_digits(value: float) -> float:
    return float(f"{value:.6g}")


def position_rounding(task: Task) -> Rounding:
    """Return a function that rounds arrays of positions, as nested lists, to DIGITS digits of the smallest extent."""
    smallest_extent = min(float(b - a) for a, b in zip(task.state_space.lower, task.state_space.upper, strict=True))
    decimals = DIGITS - math.floor(math.log10(smallest_extent))
    return lambda values: np.round(values, decimals).tolist()
