"""Pictures of sets that move: the arena at several times, and the band of a set over time."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.patches import Polygon, Rectangle

from stt_codegen.report.outlines import Plane, target_outline
from stt_codegen.report.pictures.drawing import COLOURS, frame, named, swept
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, Course, possible_sets

Array = npt.NDArray[np.float64]
TIMES = 6  # of the arena
FAINT = 5  # places of a set that are drawn where all times are one picture


def moves(task: Task) -> bool:
    """Whether a picture of one moment is not enough."""
    return any(c is not None for c in task.courses)


def draw_faint(axis: Any, convex: ConvexSet, course: Course, plane: Plane, told: bool) -> None:
    """A set that moves, at several times; with its name where that is `told`."""
    first, last = course.legs[0].begin, course.legs[-1].end
    count = FAINT if course.is_moving or course.spread else 1
    shown = [possible_sets(convex, course, first + (last - first) * k / max(count - 1, 1)) for k in range(count)]
    for here in shown:
        axis.add_patch(swept(here, COLOURS["unsafe"], plane, alpha=0.12, linewidth=0.8))
    if told:
        named(axis, shown[0][0], convex.name, plane, "white", 1)


def draw_times(figure: Any, task: Task, t: Array, low: Array, high: Array, plane: Plane, path: Array | None = None) -> None:
    """The arena at several times: where sets may be, grown by the body lighter, the tube's box then, and the state where there is
    one: path (T, n) at the times t."""
    axes = figure.subplots(1, TIMES, sharex=True, sharey=True)
    layers = [(task.obstacles, 0.25)] if any(task.half_extents) else []
    sets = [
        (s, c, alpha) for group, alpha in [*layers, (task.unsafe_sets, 0.75)] for s, c in zip(group, task.courses, strict=True)
    ]
    end = task.target_course.displacement(task.prescribed_time)
    for k, axis in enumerate(axes):
        at = k * (len(t) - 1) // (TIMES - 1)
        now = task.prescribed_time * k / (TIMES - 1)
        frame(axis, task, plane)
        for convex, course, alpha in sets:
            if here := possible_sets(convex, course, now):
                axis.add_patch(swept(here, COLOURS["unsafe"], plane, alpha=alpha, linewidth=0))
        by = task.target_course.displacement(now)
        shift = np.array([float(by[i] - end[i]) for i in plane])
        axis.add_patch(
            Polygon(target_outline(task, plane) + shift, closed=True, color=COLOURS["target"], fill=False, linewidth=1.2)
        )
        corner, size = low[at, list(plane)], (high - low)[at, list(plane)]
        axis.add_patch(Rectangle(tuple(corner.tolist()), *size.tolist(), facecolor=COLOURS["tube"], alpha=0.5))
        if path is not None:
            axis.plot(*path[: at + 1, list(plane)].T, color="black", linewidth=0.8)
        axis.set_title(f"t = {float(now):.3g} s", fontsize=8)
        axis.set(xlabel="", ylabel="")
