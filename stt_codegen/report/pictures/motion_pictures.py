"""Draw sets that move: faint at several times in one picture, or the state space at several times beside each other."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from matplotlib.patches import Polygon, Rectangle

from stt_codegen.report.outlines import Array, Plane, target_outline
from stt_codegen.report.pictures.drawing import COLOURS, SampledTube, add_label, frame, swept
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, Course, possible_sets

SNAPSHOT_COUNT = 6  # times at which the state space is drawn beside each other
FAINT_COUNT = 5  # positions of a moving set that one picture shows


def has_changing_sets(task: Task) -> bool:
    """Return whether some set moves, grows or is not always active, so that one picture is not enough."""
    return any(c is not None for c in task.courses)


def draw_faint(axis: Any, convex: ConvexSet, course: Course, plane: Plane, has_label: bool) -> None:
    """Draw a set that moves at several times, with its name where `has_label`."""
    first, last = course.legs[0].begin, course.legs[-1].end
    count = FAINT_COUNT if course.is_moving or course.spread else 1
    positions = [possible_sets(convex, course, first + (last - first) * k / max(count - 1, 1)) for k in range(count)]
    for sets in positions:
        axis.add_patch(swept(sets, COLOURS["unsafe"], plane, alpha=0.12, linewidth=0.8))
    if has_label:
        add_label(axis, positions[0][0], convex.name, plane=plane, colour="white", priority=1)


def draw_times(figure: Any, task: Task, tube: SampledTube, plane: Plane, path: Array | None = None) -> None:
    """Draw the state space at several times: where sets may be, lighter where grown by the body, and the box of the tube.

    path: states (T, n) at the times of the tube, drawn up to each time.
    """
    axes = figure.subplots(1, SNAPSHOT_COUNT, sharex=True, sharey=True)
    layers = [(task.obstacles, 0.25)] if any(task.half_extents) else []
    layers.append((task.unsafe_sets, 0.75))
    for k, axis in enumerate(axes):
        sample = k * (len(tube.t) - 1) // (SNAPSHOT_COUNT - 1)
        time = task.prescribed_time * k / (SNAPSHOT_COUNT - 1)
        frame(axis, task, plane)
        for sets, alpha in layers:
            for convex, course in zip(sets, task.courses, strict=True):
                if possible := possible_sets(convex, course, time):
                    axis.add_patch(swept(possible, COLOURS["unsafe"], plane, alpha=alpha, linewidth=0))
        _draw_target_at(axis, task, time, plane)
        corner, size = tube.low[sample, list(plane)], (tube.high - tube.low)[sample, list(plane)]
        axis.add_patch(Rectangle(tuple(corner.tolist()), *size.tolist(), facecolor=COLOURS["tube"], alpha=0.5))
        if path is not None:
            axis.plot(*path[: sample + 1, list(plane)].T, color="black", linewidth=0.8)
        axis.set_title(f"t = {float(time):.3g} s", fontsize=8)
        axis.set(xlabel="", ylabel="")


def _draw_target_at(axis: Any, task: Task, time: Fraction, plane: Plane) -> None:
    """Draw the target where it is at a time; its outline is stated for the prescribed time."""
    now, end = (task.target_course.displacement(t) for t in (time, task.prescribed_time))
    shift = np.array([float(now[i] - end[i]) for i in plane])
    outline = target_outline(task, plane) + shift
    axis.add_patch(Polygon(outline, closed=True, color=COLOURS["target"], fill=False, linewidth=1.2))
