"""Pictures of a tube in the manner of the paper's figures 1 and 3: the arena with the tube's boxes over time, and each
dimension's tube over time with the unsafe sets that matter then. Imports matplotlib, so import this late."""

from __future__ import annotations

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
from stt_codegen.pipeline import EmittedController
from stt_codegen.report.clearances import distance, obstacle_bands
from stt_codegen.report.figures import TradeReport
from stt_codegen.report.outlines import Plane, cut_off_outlines, hull_of, target_outline
from stt_codegen.report.pictures.drawing import COLOURS, LABEL, frame, label, named, patch
from stt_codegen.report.pictures.motion_pictures import draw_faint, draw_times, moves
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet, Unsafe

Array = npt.NDArray[np.float64]
BOXES = 46  # tube boxes drawn over the arena
NAMED = 40  # up to so many unsafe sets have their names in the picture
FEW = 3  # up to so many dimensions the arena is drawn in two of them alone
OTHERS = (".bmp", ".eps", ".gif", ".jpeg", ".jpg", ".tif", ".tiff", ".webp")
ROOM = 3  # pixels between a label and the frame


def draw(controller: EmittedController, path: Path, planes: Sequence[Plane] = ()) -> None:
    """Save `figure_of`."""
    save(figure_of(controller, planes), path)


def picture_path(where: Path, name: str) -> Path:
    """`where` itself when it ends in png, svg or pdf, else <name>.png in that folder. Raises `BadInput` for another kind of
    picture."""
    if where.suffix.lower() in OTHERS:
        raise BadInput(f"{where}: pictures are made as .png, .svg or .pdf; end the name so, or give a folder")
    return where if where.suffix in (".png", ".svg", ".pdf") else where / f"{name}.png"


def planes_of(task: Task, asked: Sequence[Plane] = ()) -> list[Plane]:
    """Which dimensions the arena is drawn in: as asked, else the first two; above three dimensions the others two by two too."""
    n = task.dimension
    if asked or n < 2:
        return list(asked) if n > 1 else []
    return [(0, 1)] if n <= FEW else [(min(i, n - 2), min(i, n - 2) + 1) for i in range(0, n, 2)]


def plane_named(task: Task, text: str) -> Plane:
    """Two dimensions by their names, with a comma between them. Raises `BadInput`."""
    names = [part.strip() for part in text.split(",")]
    known = {**{f"x{i + 1}": i for i in range(task.dimension)}, **{name: i for i, name in enumerate(task.axis_names)}}
    if len(names) != 2 or names[0] == names[1] or not all(name in known for name in names):
        raise BadInput(f"--axes {text}: two different ones of {', '.join(task.axis_names)} are needed, with a comma between them")
    return known[names[0]], known[names[1]]


def panels(figure: Figure, planes: Sequence[Plane], beside: Sequence[str]) -> tuple[list[Any], list[Any]]:
    """Axes for the planes, one above the other on the left, and for what is drawn over time beside them, all on one time axis."""
    if not planes:
        over = figure.subplots(len(beside), 1, sharex=True, squeeze=False)[:, 0]
        return [], list(over)
    rows, down = figure.add_gridspec(1, 2, width_ratios=[1, 1.25]), len(beside)
    left = rows[0, 0].subgridspec(len(planes), 1).subplots(squeeze=False)[:, 0]
    over = rows[0, 1].subgridspec(down, 1).subplots(sharex=True, squeeze=False)[:, 0]
    return list(left), list(over)


def figure_of(controller: EmittedController, planes: Sequence[Plane] = ()) -> Figure:
    """On the left the arena in two dimensions, or in several pairs of them, on the right every dimension over time. The figure
    belongs to no window and changes no backend of the caller's."""
    task, n = controller.task, controller.task.dimension
    t = np.linspace(0.0, float(task.prescribed_time), 1801)
    low, high = controller.design.edges_at(t)
    shown = planes_of(task, planes)
    figure, above = sheet(controller, max(4.6, 1.9 * n), t, low, high, shown)
    arenas, over = panels(above, shown, task.axis_names)
    for axis, plane in zip(arenas, shown, strict=True):
        draw_arena(axis, controller, low, high, plane)
    for i in range(n):
        draw_dimension(over[i], controller, i, t, low, high)
    shown_of = controller.certificate.mission
    cycle = None if shown_of is None else shown_of.cycle
    if cycle is not None:
        for axis in over:
            axis.axvline(float(cycle.begin), color="0.35", linestyle=":", linewidth=1.1)
    over[-1].set_xlabel("t [s]" if cycle is None else f"t [s], from {float(cycle.begin):g} s on again and again")
    certified = "certified" if controller.certificate.holds else "NOT CERTIFIED"
    figure.suptitle(f"{task.name}: {controller.design.kind} tube, {certified}")
    place_labels(figure)
    return figure


def sheet(
    controller: EmittedController,
    height: float,
    t: Array,
    low: Array,
    high: Array,
    shown: Sequence[Plane],
    path: Array | None = None,
) -> tuple[Figure, Any]:
    """A figure and the part of it for the panels; where sets move, the arena at several times is below."""
    if not moves(controller.task) or not shown:
        figure = Figure(figsize=(11, height), layout="constrained")
        return figure, figure
    figure = Figure(figsize=(11, height + 2.2), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=[height, 2.2])
    above, below = parts
    draw_times(below, controller.task, t, low, high, shown[0], path)
    return figure, above


def draw_beside(controllers: list[EmittedController], titles: list[str], path: Path) -> None:
    """Save one picture with the arenas of several controllers beside each other, boxes that meet an unsafe set outlined."""
    figure = Figure(figsize=(5.2 * len(controllers), 5), layout="constrained")
    axes = figure.subplots(1, len(controllers))
    for axis, controller, title in zip(np.atleast_1d(axes), controllers, titles, strict=True):
        t = np.linspace(0.0, float(controller.task.prescribed_time), 1801)
        low, high = controller.design.edges_at(t)
        draw_arena(axis, controller, low, high)
        hits = _collisions(controller, low, high)
        for k in np.nonzero(hits)[0][::12]:
            axis.add_patch(
                Rectangle(tuple(low[k, :2]), *(high[k, :2] - low[k, :2]), fill=False, edgecolor="black", linewidth=0.6)
            )
        axis.set_title(f"{title}: {'collides' if hits.any() else 'keeps clear'}")
    save(figure, path)


def draw_trade(report: TradeReport, path: Path) -> None:
    """Save one picture: least width against peak speed, and against the longest proved period, a mark for every tube."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    wide, periods = [t.smallest_width for t in report.tubes], [1e3 * (t.period or 0.0) for t in report.tubes]
    shown = (([t.speed for t in report.tubes], "peak speed of an edge"), (periods, "longest proved period [ms]"))
    for axis, (values, told) in zip(figure.subplots(1, 2), shown, strict=True):
        axis.plot(wide, values, "o-", color=COLOURS["tube"], linewidth=1, markersize=5)
        axis.set(xlabel="least width", ylabel=told, ylim=(0, 1.25 * max(values) or 1))
        axis.margins(x=0.15)
        axis.grid(alpha=0.3)
        for t, x, y in zip(report.tubes, wide, values, strict=True):
            if t.preferred:
                axis.annotate("\n".join(t.preferred), (x, y), (-3, 7), textcoords="offset points", ha="right", fontsize=8)
    figure.suptitle(f"{report.task}: what a tube's width costs")
    save(figure, path)


def _collisions(controller: EmittedController, low: Array, high: Array) -> npt.NDArray[np.bool_]:
    """At which samples the tube overlaps some unsafe set: shape (T,)."""
    t = np.linspace(0.0, float(controller.task.prescribed_time), len(low))
    found = np.zeros(len(t), dtype=bool)
    for one in avoidances(controller.task):
        found |= distance(one, t, low, high) < 0
    return found


def save(figure: Any, path: Path) -> None:
    """Write a figure as its name ends: png, svg or pdf, without a date. Raises `BadInput` where it cannot be written."""
    dated = {".svg": "Date", ".pdf": "CreationDate"}.get(path.suffix, "Software")
    place_labels(figure)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with mpl.rc_context({"svg.hashsalt": "stt"}):
            figure.savefig(path, dpi=110, metadata={dated: None})
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror}); choose another folder") from None


def place_labels(figure: Figure) -> None:
    """Every label of a set inside its axes, and none over another: of two the later one goes. Asks for the layout, so it comes
    last before a figure is saved."""
    found = [(axis, [t for t in axis.texts if (t.get_gid() or "").startswith(LABEL)]) for axis in figure.axes]
    if not any(texts for _, texts in found):
        return
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # what is measured stays where it is
    for axis, texts in found:
        frame, kept = axis.get_window_extent(), list[Any]()
        for text in sorted(texts, key=lambda t: str(t.get_gid())):
            box = text.get_window_extent()
            x = max(frame.x0 + ROOM - box.x0, 0) + min(frame.x1 - ROOM - box.x1, 0)
            y = max(frame.y0 + ROOM - box.y0, 0) + min(frame.y1 - ROOM - box.y1, 0)
            box = box.translated(x, y)
            if any(box.overlaps(other) for other in kept):
                text.remove()
                continue
            kept.append(box)
            if x or y:
                (a, b) = axis.transData.transform(text.get_position())
                text.set_position(tuple(axis.transData.inverted().transform((a + x, b + y))))


def _bounded(task: Task, convex: ConvexSet, i: int) -> bool:
    """Whether a set leaves something of the state space in this dimension."""
    lower, upper = convex.span(i)
    return lower > task.state_space.lower[i] or upper < task.state_space.upper[i]


def draw_sets(axis: Any, task: Task, plane: Plane = (0, 1)) -> None:
    """The plane's frame, unsafe sets with their names where they are not too many, hatched what the body adds, and the target.
    Lighter are sets that one may pass in another dimension."""
    frame(axis, task, plane)
    told, others = len(task.unsafe_sets) <= NAMED, [i for i in range(task.dimension) if i not in plane]
    for s, grown, course in zip(task.unsafe_sets, task.obstacles, task.courses, strict=True):
        if not any(_bounded(task, s, i) for i in plane):
            continue  # it is everywhere in this plane, and says something in another
        if course is not None:
            draw_faint(axis, s, course, plane, told)
            continue
        alpha = 0.4 if any(_bounded(task, s, i) for i in others) else 0.75
        if any(task.half_extents[i] for i in plane):
            axis.add_patch(patch(grown, COLOURS["unsafe"], plane, fill=False, hatch="////", alpha=0.35, linewidth=0))
        axis.add_patch(patch(s, COLOURS["unsafe"], plane, alpha=alpha))
        if told:
            named(axis, s, s.name, plane, "white", 1)
    if task.target_set is not None:
        axis.add_patch(Polygon(target_outline(task, plane), closed=True, color=COLOURS["target"], fill=False, linewidth=1.8))
    for name, region in task.regions.items():
        if isinstance(region, Unsafe):
            shape = region.to_set_in(task.state_space, task.axis_indices(region))
            axis.add_patch(patch(shape, COLOURS["region"], plane, fill=False, linewidth=1.2, linestyle="--"))
            if len(task.regions) <= NAMED:
                named(axis, shape, name, plane, "black", 2)
    _walls(axis, task, plane)


def _visits(axis: Any, controller: EmittedController, low: Array, high: Array, plane: Plane) -> None:
    """The numbers of the mission's entries where the tube serves them, first where it comes first."""
    shown, t_c = controller.certificate.mission, float(controller.task.prescribed_time)
    numbers: dict[float, list[int]] = {}
    for one in () if shown is None else served_entries(controller.task, shown):
        for visit in one.visits:
            entries = numbers.setdefault(visit.begin or 0.0, [])
            entries += [] if one.entry in entries else [one.entry]
    for begin, entries in sorted(numbers.items())[:NAMED]:
        k = round((len(low) - 1) * begin / t_c)
        x, y = ((low[k, i] + high[k, i]) / 2 for i in plane)
        style = {"boxstyle": "circle,pad=0.2", "facecolor": COLOURS["region"], "edgecolor": "none"}
        told = ",".join(map(str, entries))
        axis.text(x, y, told, color="white", fontsize=7, ha="center", va="center", bbox=style, zorder=5, clip_on=True)


def _walls(axis: Any, task: Task, plane: Plane) -> None:
    """What cuts the state space, grey beyond it."""
    for corners in cut_off_outlines(task, plane):
        axis.add_patch(Polygon(corners, closed=True, color="0.8", linewidth=0))


def draw_arena(axis: Any, controller: EmittedController, low: Array, high: Array, plane: Plane = (0, 1)) -> None:
    """The arena in two dimensions: sets, the tube's boxes over time, its centre line."""
    task, (a, b) = controller.task, plane
    if task.dimension > 2:
        axis.set_title("projection: sets may be kept apart in another dimension", fontsize=8)
    corners = np.stack([np.stack([x[:, a], y[:, b]], axis=1) for x in (low, high) for y in (low, high)], axis=1)  # (T, 4, 2)
    steps = np.linspace(0, len(low) - 1, BOXES).astype(int)
    for k, after in itertools.pairwise(steps.tolist()):
        swept = hull_of(np.concatenate([corners[k], corners[after]]))  # what a box covers on its way to the next: no gaps
        colour = mpl.colormaps["viridis"](k / (len(low) - 1))
        axis.add_patch(Polygon(swept, closed=True, facecolor=colour, alpha=0.28, edgecolor="none"))
    draw_sets(axis, task, plane)
    axis.add_patch(patch(task.start, COLOURS["start"], plane, fill=False, linewidth=1.8))
    ends = [(task.start, "start"), *([] if task.target_set is None else [(task.target, "target")])]
    for box, name in ends:
        named(axis, box, name, plane, "black", 0)
    middle = (low + high) / 2
    axis.plot(middle[:, a], middle[:, b], color="black", linewidth=0.8, linestyle=":")
    _visits(axis, controller, low, high, plane)


def draw_dimension(axis: Any, controller: EmittedController, i: int, t: Array, low: Array, high: Array) -> None:
    """One dimension over time; the span of an unsafe set is drawn while nothing but this dimension keeps the tube off it."""
    task = controller.task
    axis.fill_between(t, low[:, i], high[:, i], color=COLOURS["tube"], alpha=0.35, linewidth=0)
    axis.plot(t, low[:, i], t, high[:, i], color=COLOURS["tube"], linewidth=1)
    for band in obstacle_bands(task, i, t, low, high):
        moving = band.lower.min() < band.lower.max() or not band.is_active.all()
        for alpha, where in ((0.12, band.is_active & moving), (0.6, band.is_separated_here)):
            axis.fill_between(t, band.lower, band.upper, where=where, color=COLOURS["unsafe"], alpha=alpha, linewidth=0)
    end = float(task.prescribed_time)
    if task.target_set is not None:
        axis.vlines(end, float(task.target.lower[i]), float(task.target.upper[i]), color=COLOURS["target"], linewidth=5)
    axis.vlines(0, float(task.initial_set.lower[i]), float(task.initial_set.upper[i]), color=COLOURS["start"], linewidth=5)
    axis.set(ylabel=label(task, i), xlim=(-0.01 * end, 1.01 * end))
    axis.set_ylim(float(task.state_space.lower[i]), float(task.state_space.upper[i]))
