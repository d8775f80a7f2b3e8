"""What all pictures are made of: sets, frames and names in two dimensions. Imports matplotlib, so import this late."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from stt_codegen.report.outlines import Plane, hull_of, outline
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet

COLOURS = {"unsafe": "#c0392b", "target": "#27ae60", "start": "#2c6fbb", "tube": "#2c6fbb", "region": "#7d3c98"}
LABEL = "label "  # what the names of labels begin with, then 0 for those that come first


def patch(convex: ConvexSet, colour: str, plane: Plane = (0, 1), **style: Any) -> Polygon:
    """A set as matplotlib draws it."""
    return Polygon(outline(convex, plane), closed=True, color=colour, **style)


def swept(sets: Sequence[ConvexSet], colour: str, plane: Plane = (0, 1), **style: Any) -> Polygon:
    """The hull of several places of a set: what is avoided where it may be at any of them, or between."""
    points = np.array([point for convex in sets for point in convex.projection(*plane)])
    return Polygon(hull_of(points), closed=True, color=colour, **style)


def label(task: Task, i: int) -> str:
    """What an axis of a picture is called: its name and unit, x with its number where it has none."""
    if task.axes is not None:
        return task.axis_labels[i]
    unit = f" [{task.units[i]}]" if task.units is not None and task.units[i] else ""
    return f"$x_{{{i + 1}}}${unit}"


def frame(axis: Any, task: Task, plane: Plane) -> None:
    """Limits and names of the axes of an arena. One scale for both, unless they are of different kinds."""
    (a, b), space = plane, task.state_space
    axis.set(xlim=(float(space.lower[a]), float(space.upper[a])), ylim=(float(space.lower[b]), float(space.upper[b])))
    alike = task.units is None or task.units[a] == task.units[b]
    axis.set(xlabel=label(task, a), ylabel=label(task, b), aspect="equal" if alike else "auto")


def named(axis: Any, convex: ConvexSet, text: str, plane: Plane, colour: str, priority: int) -> None:
    """A label in the middle of a set, put in its place by `place_labels`."""
    x, y = outline(convex, plane).mean(axis=0)
    around = "white" if colour == "black" else "black"
    label = axis.text(x, y, text, ha="center", va="center", color=colour, fontsize=8, clip_on=True)
    label.set_path_effects([withStroke(linewidth=1.2, foreground=around, alpha=0.5)])
    label.set_gid(f"{LABEL}{priority}")
