"""Pictures of sets that move: the arena at several times, and the band of a set over time."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.patches import Rectangle

from stt_codegen.report.drawn import COLOURS, Plane, frame, named, patch
from stt_codegen.rows import Avoidance
from stt_codegen.task import Task
from stt_codegen.task.motion import Moved
from stt_codegen.task.sets import ConvexSet

Array = npt.NDArray[np.float64]
TIMES = 6  # of the arena
FAINT = 5  # places of a set that are drawn where all times are one picture


def moves(task: Task) -> bool:
    """Whether a picture of one moment is not enough."""
    return any(c is not None for c in task.courses)


def places(task: Task, j: int, grown: bool, t: Fraction) -> list[ConvexSet]:
    """Where unsafe set j may be at a time of the controller's, at the corners of the path that it may be on; none while it is
    safe."""
    course, s = task.courses[j], (task.obstacles if grown else task.bare)[j]
    if course is None:
        return [s]
    here = [leg for leg in course.legs if leg.begin <= t <= leg.end]
    return [Moved(s.spread(course.growth(t)), by) for leg in here[:1] for by in dict.fromkeys(leg.at(t))]


def draw_faint(axis: Any, task: Task, j: int, plane: Plane) -> None:
    """A set that moves, at several times."""
    course = task.courses[j]
    assert course is not None
    count = FAINT if course.moves else 1
    for k in range(count):
        leg = course.legs[0] if count == 1 else None
        t = leg.begin if leg is not None else course.t_c * k / (count - 1)
        for place in places(task, j, False, t):
            axis.add_patch(patch(place, COLOURS["unsafe"], plane, alpha=0.12, linewidth=0.8))
            if k == 0:
                named(axis, place, task.bare[j].name, plane, "white", 1)


def draw_times(figure: Any, task: Task, t: Array, low: Array, high: Array, plane: Plane, path: Array | None = None) -> None:
    """The arena at several times: where sets may be, grown by the body lighter, the tube's box then, and the state where there is
    one: path (T, n) at the times t."""
    axes = figure.subplots(1, TIMES, sharex=True, sharey=True)
    for k, axis in enumerate(axes):
        at = k * (len(t) - 1) // (TIMES - 1)
        now = task.prescribed_time * k / (TIMES - 1)
        frame(axis, task, plane)
        for j in range(len(task.unsafe)):
            for grown, alpha in ((True, 0.25), (False, 0.75)):
                if grown and not any(task.half_extents):
                    continue
                for place in places(task, j, grown, now):
                    axis.add_patch(patch(place, COLOURS["unsafe"], plane, alpha=alpha, linewidth=0))
        by = task.target_course.displaced(now)
        end = task.target_course.displaced(task.prescribed_time)
        target = Moved(task.target, tuple(v - w for v, w in zip(by, end, strict=True)))
        axis.add_patch(patch(target, COLOURS["target"], plane, fill=False, linewidth=1.2))
        corner, size = low[at, list(plane)], (high - low)[at, list(plane)]
        axis.add_patch(Rectangle(tuple(corner.tolist()), *size.tolist(), facecolor=COLOURS["tube"], alpha=0.5))
        if path is not None:
            axis.plot(*path[: at + 1, list(plane)].T, color="black", linewidth=0.8)
        axis.set_title(f"t = {float(now):.3g} s", fontsize=8)
        axis.set(xlabel="", ylabel="")


def bounds_over(one: Avoidance, t: Array) -> Array:
    """The bounds of a set's rows over time, without the clearance, (R, T); minus infinity while it is safe."""
    assert one.course is not None
    found = np.full((len(one.rows), len(t)), -np.inf)
    for leg in one.course.legs:
        begin, end = float(leg.begin), float(leg.end)
        here = (t >= begin) & (t <= end)
        first, last = (
            np.array([[float(v - row.keep) for v in told] for row, told in zip(one.rows, one.bounds(leg, at), strict=True)])
            for at in (leg.begin, leg.end)
        )
        share = (t[here] - begin) / (end - begin)
        found[:, here] = np.maximum(found[:, here], (first[..., None] + share * (last - first)[..., None]).max(axis=1))
    return found
