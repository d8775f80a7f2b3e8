"""The sampled loop of a task and its tube, as the statements see it: one for the certificate, for the choice of a tube, and for
reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import AdaptiveDesign, RefinedDesign
from stt_codegen.sampling.inertia import difference_age, eps_of_starts, inertial_law, inertial_setting
from stt_codegen.sampling.plant import Bounds, bounds_of_task
from stt_codegen.sampling.setting import Setting, eps_of_share, eps_of_state, law_of, setting_of
from stt_codegen.sampling.windows import Windows, refined_windows
from stt_codegen.task import Task


def loop_of(
    task: Task,
    design: RefinedDesign | AdaptiveDesign,
    edge_error: Sequence[Fraction],
    rate_error: Sequence[Fraction] = (),
    windows: Windows | None = None,
    bounds: Sequence[Bounds] | None = None,
    noise: float | None = None,
    latency: float | None = None,
    start: Sequence[float] | None = None,
) -> Setting:
    """edge_error, rate_error: what the arithmetic moves an edge (units) and, for order 2, its rate (units per second) by, (n,).
    windows: of an adaptive tube. bounds: on a plant, by window; None: those of [plant]. noise: of a measured x, in units;
    latency: seconds; None: as the task says. start: one state, its speeds behind it or not, in place of all in the share."""
    noise = float(task.plant.noise or 0) if noise is None else noise
    latency = float(task.control.latency) if latency is None else latency
    if task.order == 2:
        assert isinstance(design, RefinedDesign)
        law = inertial_law(task, design, edge_error, rate_error, (noise, float(task.plant.noise_v or 0)), latency)
        plant = bounds or [bounds_of_task(task)] * (design.segments + 1)
        made = inertial_setting(design, plant, law, eps_of_states(task, design, None, start))
        return replace(made, known_to=difference_age(task, latency))
    if windows is None:
        assert isinstance(design, RefinedDesign)
        windows = refined_windows(design)
    plant = bounds or [bounds_of_task(task)] * len(windows.narrow)
    return setting_of(windows, plant, law_of(task, edge_error, noise, latency), eps_of_states(task, design, windows, start))


def statements_of(task: Task) -> tuple[str, ...]:
    """Those that may prove a period of such a loop: of order 2 the sharp one, which is not there where u is scaled as a whole."""
    return ("sharp",) if task.order == 2 else ("general",) if task.scales else ("sharp", "general")


def eps_of_states(
    task: Task, design: RefinedDesign | AdaptiveDesign, windows: Windows | None, start: Sequence[float] | None
) -> npt.NDArray[Any]:
    """What |eps(0)| is at most, (n,): of the starts in the share, or of one state; of order 2 that of v + lambda x too."""
    if task.order == 2:
        assert isinstance(design, RefinedDesign)
        return eps_of_starts(task, design, start)
    if start is None:
        return eps_of_share(task.initial_set.share, task.dimension)
    assert windows is not None
    return np.asarray(eps_of_state(windows, start))
