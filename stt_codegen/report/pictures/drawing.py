"""Draw sets, frames and labels in two dimensions, for all pictures. Imports matplotlib, so import this late."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from stt_codegen.pipeline import EmittedController
from stt_codegen.report.outlines import Array, Plane, hull_of, outline
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet

COLOURS = {"unsafe": "#c0392b", "target": "#27ae60", "start": "#2c6fbb", "tube": "#2c6fbb", "region": "#7d3c98"}
LABEL_PREFIX = "label "  # of a label's gid, before its priority; 0 is placed first


class SampledTube(NamedTuple):
    """A tube at samples: times (T,) in seconds, and lower and upper edges (T, n)."""

    t: Array
    low: Array
    high: Array


def sample_tube(controller: EmittedController, count: int = 1801) -> SampledTube:
    """Return the tube at `count` times from 0 to the prescribed time."""
    t = np.linspace(0.0, float(controller.task.prescribed_time), count)
    return SampledTube(t, *controller.design.edges_at(t))


def patch(convex: ConvexSet, colour: str, plane: Plane = (0, 1), **style: Any) -> Polygon:
    """Return a set's outline for matplotlib. style: keyword arguments of `Polygon`."""
    return Polygon(outline(convex, plane), closed=True, color=colour, **style)


def swept(sets: Sequence[ConvexSet], colour: str, plane: Plane = (0, 1), **style: Any) -> Polygon:
    """Return the hull of several positions of a set, which is avoided where the set may be at any of them, or between."""
    points = np.array([point for convex in sets for point in convex.projection(*plane)])
    return Polygon(hull_of(points), closed=True, color=colour, **style)


def label(task: Task, i: int) -> str:
    """Return the label of an axis: its name and unit, or x with its number where it has no name."""
    if task.axes is not None:
        return task.axis_labels[i]
    unit = f" [{task.units[i]}]" if task.units is not None and task.units[i] else ""
    return f"$x_{{{i + 1}}}${unit}"


def frame(axis: Any, task: Task, plane: Plane) -> None:
    """Set limits and labels of a picture of the state space. Axes of one unit have one scale."""
    (a, b), space = plane, task.state_space
    axis.set(xlim=(float(space.lower[a]), float(space.upper[a])), ylim=(float(space.lower[b]), float(space.upper[b])))
    has_one_unit = task.units is None or task.units[a] == task.units[b]
    axis.set(xlabel=label(task, a), ylabel=label(task, b), aspect="equal" if has_one_unit else "auto")


def add_label(axis: Any, convex: ConvexSet, text: str, *, plane: Plane, colour: str, priority: int) -> None:
    """Add a label in the middle of a set; `place_labels` moves it later, smaller priorities first."""
    x, y = outline(convex, plane).mean(axis=0)
    edge_colour = "white" if colour == "black" else "black"
    label = axis.text(x, y, text, ha="center", va="center", color=colour, fontsize=8, clip_on=True)
    label.set_path_effects([withStroke(linewidth=1.2, foreground=edge_colour, alpha=0.5)])
    label.set_gid(f"{LABEL_PREFIX}{priority}")
