"""Pictures of a tube in the manner of the paper's figures 1 and 3: the arena with the tube's boxes over time, and each
dimension's tube over time with the unsafe sets that matter then. Imports matplotlib, so import this late."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from stt_codegen.designs.grid import tube_at
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller
from stt_codegen.report.trade import TradeReport
from stt_codegen.rows import Row, avoid_rows
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet

Array = npt.NDArray[np.float64]
COLOURS = {"unsafe": "#c0392b", "target": "#27ae60", "start": "#2c6fbb", "tube": "#2c6fbb"}
BOXES = 46  # tube boxes drawn over the arena


def draw(controller: Controller, path: Path) -> None:
    """Save one PNG of `figure_of`."""
    save(figure_of(controller), path)


def figure_of(controller: Controller) -> Figure:
    """On the left the arena in the first two dimensions, on the right every dimension over time. The figure belongs to no window
    and changes no backend of the caller's."""
    task, n = controller.task, controller.task.dimension
    t = np.linspace(0.0, float(task.prescribed_time), 1801)
    low, high = tube_at(controller.design, t)
    rows: list[Any] = [["arena", f"x{i + 1}"] if n > 1 else ["x1", "x1"] for i in range(n)]
    figure = Figure(figsize=(11, max(4.6, 1.9 * n)), layout="constrained")
    axes: Any = figure.subplot_mosaic(rows, width_ratios=[1, 1.25])
    if n >= 2:
        draw_arena(axes["arena"], controller, low, high)
    for i in range(n):
        draw_dimension(axes[f"x{i + 1}"], controller, i, t, low, high)
        axes[f"x{i + 1}"].set_xlabel("t [s]" if i == n - 1 else "")
    certified = "certified" if controller.certificate.holds else "NOT CERTIFIED"
    figure.suptitle(f"{task.name}: {controller.design.kind} tube, {certified}")
    return figure


def draw_beside(controllers: list[Controller], titles: list[str], path: Path) -> None:
    """Save one PNG with the arenas of several controllers beside each other, boxes that meet an unsafe set outlined."""
    figure = Figure(figsize=(5.2 * len(controllers), 5), layout="constrained")
    axes = figure.subplots(1, len(controllers))
    for axis, controller, title in zip(np.atleast_1d(axes), controllers, titles, strict=True):
        t = np.linspace(0.0, float(controller.task.prescribed_time), 1801)
        low, high = tube_at(controller.design, t)
        draw_arena(axis, controller, low, high)
        hits = _collisions(controller, low, high)
        for k in np.nonzero(hits)[0][::12]:
            axis.add_patch(
                Rectangle(tuple(low[k, :2]), *(high[k, :2] - low[k, :2]), fill=False, edgecolor="black", linewidth=0.6)
            )
        axis.set_title(f"{title}: {'collides' if hits.any() else 'keeps clear'}")
    save(figure, path)


def draw_trade(report: TradeReport, path: Path) -> None:
    """Save one PNG: least width against peak speed, and against the longest proved period, a mark for every tube."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    wide, periods = [t.least_width for t in report.tubes], [1e3 * (t.period or 0.0) for t in report.tubes]
    shown = (([t.speed for t in report.tubes], "peak speed of an edge"), (periods, "longest proved period [ms]"))
    for axis, (values, label) in zip(figure.subplots(1, 2), shown, strict=True):
        axis.plot(wide, values, "o-", color=COLOURS["tube"], linewidth=1, markersize=5)
        axis.set(xlabel="least width", ylabel=label, ylim=(0, 1.25 * max(values) or 1))
        axis.margins(x=0.15)
        axis.grid(alpha=0.3)
        for t, x, y in zip(report.tubes, wide, values, strict=True):
            if t.preferred:
                axis.annotate("\n".join(t.preferred), (x, y), (-3, 7), textcoords="offset points", ha="right", fontsize=8)
    figure.suptitle(f"{report.task}: what a tube's width costs")
    save(figure, path)


def _collisions(controller: Controller, low: Array, high: Array) -> npt.NDArray[np.bool_]:
    """At which samples the tube overlaps some unsafe set: shape (T,)."""
    found = np.zeros(len(low), dtype=bool)
    for one in avoid_rows(controller.task):
        found |= ~np.any([slack_at(row, low, high) >= 0 for row in one.rows], axis=0)
    return found


def slack_at(row: Row, low: Array, high: Array) -> Array:
    """By how much tubes (P, n) are beyond a set along the normal of its row, the clearance not counted: (P,)."""
    left = sum((float(c) * (high if side else low)[:, i] for i, side, c in row.terms), np.zeros(len(low)))
    return np.asarray(left - float(row.bound))


def save(figure: Any, path: Path) -> None:
    """Write a figure. Raises `BadInput` where it cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=110, metadata={"Software": None})
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror}); choose another folder") from None


def outline(convex: ConvexSet) -> Array:
    """The corners of a set's shadow on the first two dimensions, in order around it: (V, 2)."""
    points = np.unique(np.array([[float(v) for v in p[:2]] for p in convex.vertices]), axis=0)
    hulls: list[list[Array]] = []
    for ordered in (points, points[::-1]):  # Andrew's monotone chain: the lower side, then the upper one
        hull: list[Array] = []
        for p in ordered:
            while len(hull) > 1 and _turn(hull[-2], hull[-1], p) <= 0:
                hull.pop()
            hull.append(p)
        hulls.append(hull[:-1])
    return np.array(hulls[0] + hulls[1])


def _turn(a: Array, b: Array, c: Array) -> float:
    """Above 0 where a, b, c turn to the left."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def patch(convex: ConvexSet, colour: str, **style: Any) -> Polygon:
    """A set as matplotlib draws it."""
    return Polygon(outline(convex), closed=True, color=colour, **style)


def _frame(axis: Any, task: Task) -> None:
    """Limits and names of the axes of an arena."""
    space = task.state_space
    axis.set(xlim=(float(space.lower[0]), float(space.upper[0])), ylim=(float(space.lower[1]), float(space.upper[1])))
    axis.set(xlabel="$x_1$", ylabel="$x_2$", aspect="equal")


def draw_sets(axis: Any, task: Task) -> None:
    """The plane's frame, unsafe sets with their names, and the target."""
    _frame(axis, task)
    for s in task.bare:
        axis.add_patch(patch(s, COLOURS["unsafe"], alpha=0.75))
        x, y = outline(s).mean(axis=0)
        axis.text(x, y, s.name, ha="center", va="center", color="white", clip_on=True, fontsize=8)
    axis.add_patch(patch(task.target, COLOURS["target"], fill=False, linewidth=1.8))


def draw_arena(axis: Any, controller: Controller, low: Array, high: Array) -> None:
    """The arena in the first two dimensions: sets, the tube's boxes over time, its centre line."""
    task = controller.task
    if task.dimension > 2:
        axis.set_title("projection: sets may be kept apart in another dimension", fontsize=8)
    for k in np.linspace(0, len(low) - 1, BOXES).astype(int):
        shade = k / (len(low) - 1)
        axis.add_patch(
            Rectangle(
                tuple(low[k, :2]),
                *(high[k, :2] - low[k, :2]),
                facecolor=mpl.colormaps["viridis"](shade),
                alpha=0.28,
                edgecolor="none",
            )
        )
    draw_sets(axis, task)
    axis.add_patch(patch(task.start, COLOURS["start"], fill=False, linewidth=1.8))
    for box, label in ((task.start, "start"), (task.target, "target")):
        x, y = outline(box).mean(axis=0)
        axis.text(x, y, label, ha="center", va="center", fontsize=8)
    axis.plot(*((low + high) / 2).T[:2], color="black", linewidth=0.8, linestyle=":")


def draw_dimension(axis: Any, controller: Controller, i: int, t: Array, low: Array, high: Array) -> None:
    """One dimension over time; the span of an unsafe set is drawn while nothing but this dimension keeps the tube off it."""
    task = controller.task
    axis.fill_between(t, low[:, i], high[:, i], color=COLOURS["tube"], alpha=0.35, linewidth=0)
    axis.plot(t, low[:, i], t, high[:, i], color=COLOURS["tube"], linewidth=1)
    for one, s in zip(avoid_rows(task), task.obstacles, strict=True):
        others = [row for row in one.rows if any(d != i for d, _, _ in row.terms)]
        meets = ~np.any([slack_at(row, low, high) >= 0 for row in others], axis=0) if others else np.ones(len(t), dtype=bool)
        lower, upper = (float(v) for v in s.span(i))
        axis.fill_between(t, lower, upper, where=meets, color=COLOURS["unsafe"], alpha=0.6, linewidth=0)
    end = float(task.prescribed_time)
    axis.vlines(end, float(task.target_set.lower[i]), float(task.target_set.upper[i]), color=COLOURS["target"], linewidth=5)
    axis.vlines(0, float(task.initial_set.lower[i]), float(task.initial_set.upper[i]), color=COLOURS["start"], linewidth=5)
    axis.set(ylabel=f"$x_{i + 1}$", xlim=(-0.01 * end, 1.01 * end))
    axis.set_ylim(float(task.state_space.lower[i]), float(task.state_space.upper[i]))
