"""Draw a tube as in the paper's figures 1 and 3: its boxes in the state space, and each dimension over time with unsafe sets.

Imports matplotlib, so import this late. `design --picture`, the Python interface and loop/picture.py call this.
Long because both views draw the same sets, with the same colours and labels.
"""

from __future__ import annotations

import io
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from stt_codegen.certify.missions import served_entries
from stt_codegen.constraints import avoidances
from stt_codegen.errors import BadInput
from stt_codegen.files import write_files
from stt_codegen.pipeline import EmittedController
from stt_codegen.report.clearances import distance, obstacle_bands
from stt_codegen.report.figures import TradeReport
from stt_codegen.report.outlines import Plane, cut_off_outlines, hull_of, target_outline
from stt_codegen.report.pictures.drawing import COLOURS, LABEL_PREFIX, SampledTube, add_label, frame, label, patch, sample_tube
from stt_codegen.report.pictures.motion_pictures import draw_faint, draw_times, has_changing_sets
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, Unsafe

Array = npt.NDArray[np.float64]
BOX_COUNT = 46  # boxes of the tube in the state space
LABEL_LIMIT = 40  # unsafe sets; a picture of more has no names
SINGLE_PLANE_DIMENSIONS = 3  # a state space of more dimensions is drawn in several planes
OTHER_PICTURE_SUFFIXES = (".bmp", ".eps", ".gif", ".jpeg", ".jpg", ".tif", ".tiff", ".webp")
LABEL_MARGIN = 3  # pixels, between a label and the frame


def draw(controller: EmittedController, path: Path, planes: Sequence[Plane] = ()) -> None:
    """Save the picture of a tube. planes: as for `figure_of`."""
    save(figure_of(controller, planes), path)


def picture_path(destination: Path, name: str) -> Path:
    """Return the destination if it ends in .png, .svg or .pdf, else <name>.png in that folder.

    Raises `BadInput` for another kind of picture.
    """
    if destination.suffix.lower() in OTHER_PICTURE_SUFFIXES:
        raise BadInput(f"{destination}: pictures are made as .png, .svg or .pdf; end the name so, or give a folder")
    return destination if destination.suffix in (".png", ".svg", ".pdf") else destination / f"{name}.png"


def planes_of(task: Task, chosen: Sequence[Plane] = ()) -> list[Plane]:
    """Return the planes to draw: the chosen ones, else the first two dimensions; above three dimensions, all in pairs."""
    n = task.dimension
    if chosen or n < 2:
        return list(chosen) if n > 1 else []
    return [(0, 1)] if n <= SINGLE_PLANE_DIMENSIONS else [(min(i, n - 2), min(i, n - 2) + 1) for i in range(0, n, 2)]


def plane_named(task: Task, text: str) -> Plane:
    """Return the two dimensions that the text names, such as "x,y". Raises `BadInput`."""
    names = [part.strip() for part in text.split(",")]
    known = {**{f"x{i + 1}": i for i in range(task.dimension)}, **{name: i for i, name in enumerate(task.axis_names)}}
    if len(names) != 2 or names[0] == names[1] or not all(name in known for name in names):
        raise BadInput(f"--axes {text}: two different ones of {', '.join(task.axis_names)} are needed, with a comma between them")
    return known[names[0]], known[names[1]]


def panels(figure: Figure, planes: Sequence[Plane], over_time: Sequence[str]) -> tuple[list[Any], list[Any]]:
    """Return axes for the planes, on the left, and for each quantity over time, on the right with one time axis."""
    if not planes:
        over = figure.subplots(len(over_time), 1, sharex=True, squeeze=False)[:, 0]
        return [], list(over)
    grid = figure.add_gridspec(1, 2, width_ratios=[1, 1.25])
    left = grid[0, 0].subgridspec(len(planes), 1).subplots(squeeze=False)[:, 0]
    over = grid[0, 1].subgridspec(len(over_time), 1).subplots(sharex=True, squeeze=False)[:, 0]
    return list(left), list(over)


def figure_of(controller: EmittedController, planes: Sequence[Plane] = ()) -> Figure:
    """Return a figure with the state space on the left, in one plane or several, and every dimension over time on the right.

    planes: pairs of dimensions, chosen by `planes_of` where empty. The figure belongs to no window and changes no backend.
    """
    task, n = controller.task, controller.task.dimension
    tube, drawn_planes = sample_tube(controller), planes_of(task, planes)
    figure, above = figure_with_times(controller, max(4.6, 1.9 * n), tube, drawn_planes)
    arenas, over = panels(above, drawn_planes, task.axis_names)
    for axis, plane in zip(arenas, drawn_planes, strict=True):
        draw_arena(axis, controller, tube, plane)
    for i in range(n):
        draw_dimension(over[i], controller, i, tube)
    mission = controller.certificate.mission
    cycle = None if mission is None else mission.cycle
    if cycle is not None:
        for axis in over:
            axis.axvline(float(cycle.begin), color="0.35", linestyle=":", linewidth=1.1)
    over[-1].set_xlabel("t [s]" if cycle is None else f"t [s], from {float(cycle.begin):g} s on again and again")
    certified = "certified" if controller.certificate.holds else "NOT CERTIFIED"
    figure.suptitle(f"{task.name}: {controller.design.kind} tube, {certified}")
    place_labels(figure)
    return figure


def figure_with_times(
    controller: EmittedController,
    height: float,
    tube: SampledTube,
    planes: Sequence[Plane],
    path: Array | None = None,
) -> tuple[Figure, Any]:
    """Return a figure, and its part for the panels, of `height` inches. Below are the times of sets that move.

    path: states (T, n) at the times of the tube.
    """
    if not has_changing_sets(controller.task) or not planes:
        figure = Figure(figsize=(11, height), layout="constrained")
        return figure, figure
    figure = Figure(figsize=(11, height + 2.2), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=[height, 2.2])
    above, below = parts
    draw_times(below, controller.task, tube, planes[0], path)
    return figure, above


def draw_beside(controllers: list[EmittedController], titles: list[str], path: Path) -> None:
    """Save one picture of the state spaces of several controllers. Boxes that overlap an unsafe set have an outline."""
    figure = Figure(figsize=(5.2 * len(controllers), 5), layout="constrained")
    axes = figure.subplots(1, len(controllers))
    for axis, controller, title in zip(np.atleast_1d(axes), controllers, titles, strict=True):
        tube = sample_tube(controller)
        draw_arena(axis, controller, tube)
        hits = _collisions(controller, tube)
        for k in np.nonzero(hits)[0][::12]:
            corner, size = tube.low[k, :2], tube.high[k, :2] - tube.low[k, :2]
            axis.add_patch(Rectangle(tuple(corner), *size, fill=False, edgecolor="black", linewidth=0.6))
        axis.set_title(f"{title}: {'collides' if hits.any() else 'keeps clear'}")
    save(figure, path)


def draw_trade(report: TradeReport, path: Path) -> None:
    """Save one picture of the smallest width against the peak speed, and against the longest proved period, of each tube."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    widths, periods = [t.smallest_width for t in report.tubes], [1e3 * (t.period or 0.0) for t in report.tubes]
    curves = (([t.speed for t in report.tubes], "peak speed of an edge"), (periods, "longest proved period [ms]"))
    for axis, (values, ylabel) in zip(figure.subplots(1, 2), curves, strict=True):
        axis.plot(widths, values, "o-", color=COLOURS["tube"], linewidth=1, markersize=5)
        axis.set(xlabel="least width", ylabel=ylabel, ylim=(0, 1.25 * max(values) or 1))
        axis.margins(x=0.15)
        axis.grid(alpha=0.3)
        for t, x, y in zip(report.tubes, widths, values, strict=True):
            if t.preferred:
                axis.annotate("\n".join(t.preferred), (x, y), (-3, 7), textcoords="offset points", ha="right", fontsize=8)
    figure.suptitle(f"{report.task}: what a tube's width costs")
    save(figure, path)


def _collisions(controller: EmittedController, tube: SampledTube) -> npt.NDArray[np.bool_]:
    """Return whether the tube overlaps some unsafe set, at each sample: (T,)."""
    collides = np.zeros(len(tube.t), dtype=bool)
    for avoidance in avoidances(controller.task):
        collides |= distance(avoidance, tube.t, tube.low, tube.high) < 0
    return collides


def save(figure: Any, path: Path) -> None:
    """Write a figure as png, svg or pdf, by the end of its name, without a date. Raises `BadInput` where it cannot be written."""
    date_key = {".svg": "Date", ".pdf": "CreationDate"}.get(path.suffix, "Software")
    place_labels(figure)
    data = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "stt"}):
        figure.savefig(data, format=path.suffix.removeprefix("."), dpi=110, metadata={date_key: None})
    write_files(path.parent, {path.name: data.getvalue()})


def place_labels(figure: Figure) -> None:
    """Move the labels of sets into their axes, and remove a label that would cover an earlier one.

    It computes the layout, so call it last before a figure is saved.
    """
    labels = [(axis, [t for t in axis.texts if (t.get_gid() or "").startswith(LABEL_PREFIX)]) for axis in figure.axes]
    if not any(texts for _, texts in labels):
        return
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # so that the measured positions stay
    for axis, texts in labels:
        frame, placed = axis.get_window_extent(), list[Any]()
        for text in sorted(texts, key=lambda t: str(t.get_gid())):
            box = text.get_window_extent()
            x = max(frame.x0 + LABEL_MARGIN - box.x0, 0) + min(frame.x1 - LABEL_MARGIN - box.x1, 0)
            y = max(frame.y0 + LABEL_MARGIN - box.y0, 0) + min(frame.y1 - LABEL_MARGIN - box.y1, 0)
            box = box.translated(x, y)
            if any(box.overlaps(earlier) for earlier in placed):
                text.remove()
                continue
            placed.append(box)
            if x or y:
                (a, b) = axis.transData.transform(text.get_position())
                text.set_position(tuple(axis.transData.inverted().transform((a + x, b + y))))


def _is_bounded(task: Task, convex: ConvexSet, i: int) -> bool:
    """Return whether a set is smaller than the state space in this dimension."""
    lower, upper = convex.span(i)
    return lower > task.state_space.lower[i] or upper < task.state_space.upper[i]


def draw_sets(axis: Any, task: Task, plane: Plane = (0, 1)) -> None:
    """Draw the frame, unsafe sets, regions, target and parts of the state space that are cut off.

    What the body adds to a set is hatched. Sets that the tube may pass in another dimension are lighter.
    """
    frame(axis, task, plane)
    has_labels, outside = len(task.unsafe_sets) <= LABEL_LIMIT, [i for i in range(task.dimension) if i not in plane]
    for s, grown, course in zip(task.unsafe_sets, task.obstacles, task.courses, strict=True):
        if not any(_is_bounded(task, s, i) for i in plane):
            continue  # it fills this plane, and is drawn in another one
        if course is not None:
            draw_faint(axis, s, course, plane, has_labels)
            continue
        alpha = 0.4 if any(_is_bounded(task, s, i) for i in outside) else 0.75
        if any(task.half_extents[i] for i in plane):
            axis.add_patch(patch(grown, COLOURS["unsafe"], plane, fill=False, hatch="////", alpha=0.35, linewidth=0))
        axis.add_patch(patch(s, COLOURS["unsafe"], plane, alpha=alpha))
        if has_labels:
            add_label(axis, s, s.name, plane=plane, colour="white", priority=1)
    if task.target_set is not None:
        axis.add_patch(Polygon(target_outline(task, plane), closed=True, color=COLOURS["target"], fill=False, linewidth=1.8))
    for name, region in task.regions.items():
        if isinstance(region, Unsafe):
            shape = region.to_set_in(task.state_space, task.axis_indices(region))
            axis.add_patch(patch(shape, COLOURS["region"], plane, fill=False, linewidth=1.2, linestyle="--"))
            if len(task.regions) <= LABEL_LIMIT:
                add_label(axis, shape, name, plane=plane, colour="black", priority=2)
    _draw_cut_off_parts(axis, task, plane)


def _draw_visits(axis: Any, controller: EmittedController, tube: SampledTube, plane: Plane) -> None:
    """Draw the numbers of the mission's entries where the tube serves them."""
    mission, t_c = controller.certificate.mission, float(controller.task.prescribed_time)
    numbers: dict[float, list[int]] = {}
    for served in () if mission is None else served_entries(controller.task, mission):
        for visit in served.visits:
            entries = numbers.setdefault(visit.begin or 0.0, [])
            entries += [] if served.entry in entries else [served.entry]
    for begin, entries in sorted(numbers.items())[:LABEL_LIMIT]:
        k = round((len(tube.t) - 1) * begin / t_c)
        x, y = ((tube.low[k, i] + tube.high[k, i]) / 2 for i in plane)
        style = {"boxstyle": "circle,pad=0.2", "facecolor": COLOURS["region"], "edgecolor": "none"}
        axis.text(
            x,
            y,
            ",".join(map(str, entries)),
            color="white",
            fontsize=7,
            ha="center",
            va="center",
            bbox=style,
            zorder=5,
            clip_on=True,
        )


def _draw_cut_off_parts(axis: Any, task: Task, plane: Plane) -> None:
    """Draw the parts of the state space's box that half-spaces cut off, in grey."""
    for corners in cut_off_outlines(task, plane):
        axis.add_patch(Polygon(corners, closed=True, color="0.8", linewidth=0))


def draw_arena(axis: Any, controller: EmittedController, tube: SampledTube, plane: Plane = (0, 1)) -> None:
    """Draw the state space in a plane: sets, the tube's boxes over time, its centre line."""
    task, (a, b), (_, low, high) = controller.task, plane, tube
    if task.dimension > 2:
        axis.set_title("projection: sets may be kept apart in another dimension", fontsize=8)
    corners = np.stack([np.stack([x[:, a], y[:, b]], axis=1) for x in (low, high) for y in (low, high)], axis=1)  # (T, 4, 2)
    steps = np.linspace(0, len(low) - 1, BOX_COUNT).astype(int)
    for k, following in itertools.pairwise(steps.tolist()):
        swept = hull_of(np.concatenate([corners[k], corners[following]]))  # covers a box on its way to the next, without gaps
        colour = mpl.colormaps["viridis"](k / (len(low) - 1))
        axis.add_patch(Polygon(swept, closed=True, facecolor=colour, alpha=0.28, edgecolor="none"))
    draw_sets(axis, task, plane)
    axis.add_patch(patch(task.start, COLOURS["start"], plane, fill=False, linewidth=1.8))
    ends = [(task.start, "start"), *([] if task.target_set is None else [(task.target, "target")])]
    for box, name in ends:
        add_label(axis, box, name, plane=plane, colour="black", priority=0)
    middle = (low + high) / 2
    axis.plot(middle[:, a], middle[:, b], color="black", linewidth=0.8, linestyle=":")
    _draw_visits(axis, controller, tube, plane)


def draw_dimension(axis: Any, controller: EmittedController, i: int, tube: SampledTube) -> None:
    """Draw dimension i over time. An unsafe set is drawn while only this dimension separates the tube from it."""
    task, (t, low, high) = controller.task, tube
    axis.fill_between(t, low[:, i], high[:, i], color=COLOURS["tube"], alpha=0.35, linewidth=0)
    axis.plot(t, low[:, i], t, high[:, i], color=COLOURS["tube"], linewidth=1)
    for band in obstacle_bands(task, i, t, low, high):
        is_changing = band.lower.min() < band.lower.max() or not band.is_active.all()
        for alpha, where in ((0.12, band.is_active & is_changing), (0.6, band.separates_alone)):
            axis.fill_between(t, band.lower, band.upper, where=where, color=COLOURS["unsafe"], alpha=alpha, linewidth=0)
    end = float(task.prescribed_time)
    if task.target_set is not None:
        axis.vlines(end, float(task.target.lower[i]), float(task.target.upper[i]), color=COLOURS["target"], linewidth=5)
    axis.vlines(0, float(task.initial_set.lower[i]), float(task.initial_set.upper[i]), color=COLOURS["start"], linewidth=5)
    axis.set(ylabel=label(task, i), xlim=(-0.01 * end, 1.01 * end))
    axis.set_ylim(float(task.state_space.lower[i]), float(task.state_space.upper[i]))
