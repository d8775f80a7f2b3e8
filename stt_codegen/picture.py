"""Pictures of a tube in the manner of the paper's figures 1 and 3: the arena with the tube's boxes over time, and each
dimension's tube over time with the unsafe sets that matter then. Imports matplotlib, so import this late."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.patches import Rectangle

from stt_codegen import reference
from stt_codegen.certify.sampled import sample_tube
from stt_codegen.design.tube import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller
from stt_codegen.task import Box

Array = npt.NDArray[np.float64]
COLOURS = {"unsafe": "#c0392b", "target": "#27ae60", "start": "#2c6fbb", "tube": "#2c6fbb"}
BOXES = 46  # tube boxes drawn over the arena


def draw(controller: Controller, path: Path) -> None:
    """Save one PNG: on the left the arena in the first two dimensions, on the right every dimension over time."""
    task, n = controller.task, controller.task.dimension
    t = np.linspace(0.0, float(task.prescribed_time), 1801)
    low, high = tube_at(controller, t)
    rows: list[Any] = [["arena", f"x{i + 1}"] if n > 1 else ["x1", "x1"] for i in range(n)]
    figure, axes = plt.subplot_mosaic(
        rows,
        figsize=(11, max(4.6, 1.9 * n)),
        width_ratios=[1, 1.25],
        constrained_layout=True,
    )
    if n >= 2:
        draw_arena(axes["arena"], controller, low, high)
    for i in range(n):
        draw_dimension(axes[f"x{i + 1}"], controller, i, t, low, high)
        axes[f"x{i + 1}"].set_xlabel("t [s]" if i == n - 1 else "")
    certified = "certified" if controller.certificate.holds else "NOT CERTIFIED"
    figure.suptitle(f"{task.name}: {controller.design.kind} tube, {certified}")
    save(figure, path)


def draw_beside(controllers: list[Controller], titles: list[str], path: Path) -> None:
    """Save one PNG with the arenas of several controllers beside each other, boxes that meet an unsafe set outlined."""
    figure, axes = plt.subplots(1, len(controllers), figsize=(5.2 * len(controllers), 5), constrained_layout=True)
    for axis, controller, title in zip(np.atleast_1d(axes), controllers, titles, strict=True):
        t = np.linspace(0.0, float(controller.task.prescribed_time), 1801)
        low, high = tube_at(controller, t)
        draw_arena(axis, controller, low, high)
        hits = _collisions(controller, low, high)
        for k in np.nonzero(hits)[0][::12]:
            axis.add_patch(
                Rectangle(tuple(low[k, :2]), *(high[k, :2] - low[k, :2]), fill=False, edgecolor="black", linewidth=0.6)
            )
        axis.set_title(f"{title}: {'collides' if hits.any() else 'keeps clear'}")
    save(figure, path)


def _collisions(controller: Controller, low: Array, high: Array) -> npt.NDArray[np.bool_]:
    """At which samples the tube overlaps an unsafe set."""
    found = np.zeros(len(low), dtype=bool)
    for s in controller.task.grown_unsafe:
        lower, upper = (np.array([float(v) for v in edge]) for edge in (s.lower, s.upper))
        found |= np.asarray(np.all((low < upper) & (high > lower), axis=1))
    return found


def save(figure: Any, path: Path) -> None:
    """Write and close a figure. Raises `BadInput` where it cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=110, metadata={"Software": None})
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror}); choose another folder") from None
    plt.close(figure)


def tube_at(controller: Controller, t: Array) -> tuple[Array, Array]:
    """Edges of the tube at equally spaced times t from 0 to t_c, shape (P, n) each."""
    design = controller.design
    if isinstance(design, RefinedDesign):
        low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
        return low.astype(float), high.astype(float)
    _, _, gamma, _ = sample_tube(design, len(t) - 1)
    return gamma[:, :, 0], gamma[:, :, 1]


def _patch(box: Box, colour: str, **style: Any) -> Rectangle:
    (x, y), (a, b) = (float(v) for v in box.lower[:2]), (float(v) for v in box.upper[:2])
    return Rectangle((x, y), a - x, b - y, color=colour, **style)


def draw_arena(axis: Any, controller: Controller, low: Array, high: Array) -> None:
    """The arena in the first two dimensions: sets, the tube's boxes over time, its centre line."""
    task = controller.task
    space = task.state_space
    axis.set(xlim=(float(space.lower[0]), float(space.upper[0])), ylim=(float(space.lower[1]), float(space.upper[1])))
    axis.set(xlabel="$x_1$", ylabel="$x_2$", aspect="equal")
    if task.dimension > 2:
        axis.set_title("projection: sets may be kept apart in another dimension", fontsize=8)
    for k in np.linspace(0, len(low) - 1, BOXES).astype(int):
        shade = k / (len(low) - 1)
        axis.add_patch(
            Rectangle(
                tuple(low[k, :2]), *(high[k, :2] - low[k, :2]), facecolor=plt.cm.viridis(shade), alpha=0.28, edgecolor="none"
            )
        )
    for s in task.unsafe:
        axis.add_patch(_patch(s, COLOURS["unsafe"], alpha=0.75))
        axis.text(
            *(float(s.lower[i] + s.upper[i]) / 2 for i in (0, 1)),
            s.name,
            ha="center",
            va="center",
            color="white",
            clip_on=True,
            fontsize=8,
        )
    for box, label in ((task.initial_set, "start"), (task.target_set, "target")):
        axis.add_patch(_patch(box, COLOURS[label], fill=False, linewidth=1.8))
        axis.text(*(float(box.lower[i] + box.upper[i]) / 2 for i in (0, 1)), label, ha="center", va="center", fontsize=8)
    axis.plot(*((low + high) / 2).T[:2], color="black", linewidth=0.8, linestyle=":")


def draw_dimension(axis: Any, controller: Controller, i: int, t: Array, low: Array, high: Array) -> None:
    """One dimension over time; an unsafe set is drawn while all other dimensions of the tube overlap it."""
    task, n = controller.task, controller.task.dimension
    axis.fill_between(t, low[:, i], high[:, i], color=COLOURS["tube"], alpha=0.35, linewidth=0)
    axis.plot(t, low[:, i], t, high[:, i], color=COLOURS["tube"], linewidth=1)
    for s in task.grown_unsafe:
        lower, upper = (np.array([float(v) for v in edge]) for edge in (s.lower, s.upper))
        others = [d for d in range(n) if d != i]
        meets = np.all((low[:, others] < upper[others]) & (high[:, others] > lower[others]), axis=1)
        axis.fill_between(t, lower[i], upper[i], where=meets, color=COLOURS["unsafe"], alpha=0.6, linewidth=0)
    end = float(task.prescribed_time)
    axis.vlines(end, float(task.target_set.lower[i]), float(task.target_set.upper[i]), color=COLOURS["target"], linewidth=5)
    axis.vlines(0, float(task.initial_set.lower[i]), float(task.initial_set.upper[i]), color=COLOURS["start"], linewidth=5)
    axis.set(ylabel=f"$x_{i + 1}$", xlim=(-0.01 * end, 1.01 * end))
    axis.set_ylim(float(task.state_space.lower[i]), float(task.state_space.upper[i]))
