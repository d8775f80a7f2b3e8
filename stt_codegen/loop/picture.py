"""Pictures of closed loops: a run beside its tube; the paper's figure 3 from several tasks, figure 1 from one adaptive tube."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from stt_codegen.decimals import by_component
from stt_codegen.loop.simulate import Run
from stt_codegen.pipeline import EmittedController
from stt_codegen.report import Plane, outline
from stt_codegen.report.pictures import (
    COLOURS,
    SampledTube,
    draw_arena,
    draw_dimension,
    draw_sets,
    figure_with_times,
    label,
    panels,
    patch,
    planes_of,
    sample_tube,
    save,
)

Array = npt.NDArray[Any]
PATH_COLOUR = "#d35400"
TUBE_COLOURS = ("#d35400", "#8e44ad", "#16a085")
SLICES = 40  # boxes that show a tube in three dimensions


def draw_run(controller: EmittedController, run: Run, path: Path, planes: Sequence[Plane] = ()) -> None:
    """Save one PNG: the arena with the state's path, every dimension over time, and the input. planes: as for `figure_of`."""
    assert run.trace is not None
    task, n = controller.task, controller.task.dimension
    t, x, u = run.trace[:, 0], run.trace[:, 1 : n + 1], run.trace[:, n + 1 : 2 * n + 1]
    tube = sample_tube(controller)
    shown = planes_of(task, planes)
    states = np.stack([np.interp(tube.t, t, x[:, i]) for i in range(n)], axis=1)
    figure, above = figure_with_times(controller, max(5.2, 1.8 * (n + 1)), tube, shown, states)
    arenas, over = panels(above, shown, [*task.axis_names, "u"])
    for axis, plane in zip(arenas, shown, strict=True):
        draw_arena(axis, controller, tube, plane)
        axis.plot(x[:, plane[0]], x[:, plane[1]], color=PATH_COLOUR, linewidth=1.6)
    for i in range(n):
        draw_dimension(over[i], controller, i, tube)
        over[i].plot(t, x[:, i], color=PATH_COLOUR, linewidth=1.2)
    for i in range(n):
        over[-1].plot(t, u[:, i], linewidth=0.8, label=f"$u_{{{i + 1}}}$")
    over[-1].set(xlabel="t [s]", ylabel="$u$")
    over[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7)  # beside the curves, never over them
    verdict = "task fulfilled" if run.good else _reason(run)
    figure.suptitle(f"{task.name}: {controller.design.kind} tube, gain {by_component(task.gain)}, {verdict}")
    save(figure, path)


def _reason(run: Run) -> str:
    """Return why a run missed its task, in words."""
    if run.hit is not None:
        return f"hits {run.hit} at {run.hit_at:.3g} s"
    if run.left_at is not None:
        return f"leaves the state space at {run.left_at:.3g} s"
    return "not in the target at t_c"


def draw_figure3(pairs: Sequence[tuple[EmittedController, Sequence[Run]]], path: Path) -> None:
    """Save the paper's figure 3: the arena with the paths of several runs from every start, then each tube over time."""
    down, across = (len(pairs) + 2) // 2, 2
    figure = Figure(figsize=(10.5, 4.8 * down), layout="constrained")
    axis = figure.add_subplot(down, across, 1)
    first = pairs[0][0]
    draw_sets(axis, first.task)
    for (controller, runs), colour in zip(pairs, TUBE_COLOURS, strict=False):
        axis.add_patch(patch(controller.task.start, colour, fill=False, linewidth=1.6))
        for run in runs:
            assert run.trace is not None
            axis.plot(run.trace[:, 1], run.trace[:, 2], color=colour, linewidth=0.8, alpha=0.8)
    axis.set_title(f"(a) {sum(len(runs) for _, runs in pairs)} runs under disturbance", fontsize=9)
    for k, ((controller, runs), colour) in enumerate(zip(pairs, TUBE_COLOURS, strict=False)):
        solid: Any = figure.add_subplot(down, across, k + 2, projection="3d")
        _tube3(solid, controller, colour)
        for run in runs:
            assert run.trace is not None
            solid.plot(run.trace[:, 1], run.trace[:, 2], run.trace[:, 0], color="black", linewidth=0.7)
        solid.set_title(f"({'bcd'[k]}) {controller.task.name}, certified", fontsize=9)
    save(figure, path)


def pillar(corners: Array, height: float) -> list[list[tuple[float, float, float]]]:
    """Return the sides and the two ends of a pillar over a polygon, each as a list of corners (x, y, t)."""
    base = [(float(x), float(y)) for x, y in corners]
    sides = [[(*a, 0.0), (*b, 0.0), (*b, height), (*a, height)] for a, b in zip(base, base[1:] + base[:1], strict=True)]
    return [*sides, *([(*p, z) for p in base] for z in (0.0, height))]


def _tube3(axis: Any, controller: EmittedController, colour: str) -> None:
    """Draw a planar tube as boxes over time, with the unsafe sets as pillars."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    task = controller.task
    end = float(task.prescribed_time)
    for s in task.unsafe_sets:
        axis.add_collection3d(Poly3DCollection(pillar(outline(s), end), facecolor=COLOURS["unsafe"], alpha=0.12))
    t = np.linspace(0.0, end, SLICES * 8 + 1)
    low, high = controller.design.edges_at(t)
    faces = []
    for k in range(0, len(t), 8):
        (x, y), (a, b) = low[k, :2], high[k, :2]
        faces.append([(x, y, t[k]), (a, y, t[k]), (a, b, t[k]), (x, b, t[k])])
    axis.add_collection3d(Poly3DCollection(faces, facecolor=colour, edgecolor=colour, alpha=0.22, linewidth=0.5))
    space = task.state_space
    axis.set(
        xlim=(float(space.lower[0]), float(space.upper[0])), ylim=(float(space.lower[1]), float(space.upper[1])), zlim=(0, end)
    )
    axis.set(xlabel=label(task, 0), ylabel=label(task, 1), zlabel="t [s]")
    axis.view_init(elev=24, azim=-62)


def draw_figure1(controller: EmittedController, run: Run, path: Path) -> None:
    """Save the paper's figure 1 from one adaptive tube: arena and path, reachability tube, circumvent function, adaptive tube,
    and the tube over time in three dimensions."""
    from stt_codegen import reference
    from stt_codegen.designs import parameters_of, require_adaptive

    assert run.trace is not None
    task, design = controller.task, require_adaptive(controller.design)
    t = np.linspace(0.0, float(task.prescribed_time), 1601)
    lines = reference.lines(parameters_of(design), t)
    tube = SampledTube(t, *controller.design.edges_at(t))
    bump_axes = [b.dimension for b in design.bumps]
    i = max(set(bump_axes), key=bump_axes.count) if bump_axes else 0
    figure = Figure(figsize=(17, 3.9), layout="constrained")
    axes: list[Any] = [figure.add_subplot(1, 5, k + 1) for k in range(4)]
    draw_sets(axes[0], task)
    axes[0].add_patch(patch(task.start, COLOURS["start"], fill=False, linewidth=1.8))
    axes[0].plot(run.trace[:, 1], run.trace[:, 2], color="black", linestyle=":")
    axes[0].set_title("(a) state space and path", fontsize=9)
    rho, beta = lines.rho[:, i].astype(float), lines.beta[:, i].astype(float)
    for axis, name in zip(axes[1:], ("(b) reachability tube", "(c) circumvent functions", "(d) adaptive tube"), strict=True):
        axis.set_title(f"{name}, {label(task, i)}", fontsize=9)
        axis.set(xlabel="t [s]", ylim=(float(task.state_space.lower[i]), float(task.state_space.upper[i])))
    for axis in axes[1:3]:
        axis.fill_between(t, rho[:, 0], rho[:, 1], color=COLOURS["tube"], alpha=0.3, linewidth=0)
    axes[2].plot(t, beta[:, 0], t, beta[:, 1], color=PATH_COLOUR, linewidth=1.2)
    draw_dimension(axes[3], controller, i, tube)
    axes[3].plot(run.trace[:, 0], run.trace[:, 1 + i], color="black", linestyle=":")
    solid: Any = figure.add_subplot(1, 5, 5, projection="3d")
    _tube3(solid, controller, TUBE_COLOURS[0])
    solid.set_title("(e) the tube over time", fontsize=9)
    save(figure, path)
