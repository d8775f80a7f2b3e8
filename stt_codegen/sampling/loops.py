"""The sampled loop of a task and its tube, as the statements see it: one for the certificate, for the choice of a tube, and for
reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import Design, RefinedDesign, require_refined
from stt_codegen.sampling.numbers import DOUBLES, FRACTIONS, Numbers
from stt_codegen.sampling.order_two import BEYOND, difference_age, extent, inertial_law, inertial_setting, start_reach
from stt_codegen.sampling.plant import Bounds, bounds_of_task
from stt_codegen.sampling.setting import Setting, eps_of_state, law_of, reach_of_starts, setting_of
from stt_codegen.sampling.windows import Windows, refined_windows
from stt_codegen.task import Task


def loop_of(
    task: Task,
    design: Design,
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
        return _inertial_loop(task, require_refined(design), edge_error, rate_error, bounds, noise, latency, start)
    if windows is None:
        windows = refined_windows(require_refined(design))
    plant = bounds or [bounds_of_task(task)] * len(windows.narrow)
    return setting_of(windows, plant, law_of(task, edge_error, noise, latency), eps_of_states(task, design, windows, start))


def exact_loop(task: Task, design: RefinedDesign, edge_error: Sequence[Fraction], rate_error: Sequence[Fraction] = ()) -> Setting:
    """The same loop in fractions, as the task says it, for the period that it states: reaches are rho = e^E."""
    noise, latency = task.plant.noise or Fraction(0), task.control.latency
    if task.order == 2:
        return _inertial_loop(
            task, design, edge_error, rate_error, None, noise, latency, None, more=Fraction(1), numbers=FRACTIONS
        )
    windows = refined_windows(design, FRACTIONS)
    plant = [bounds_of_task(task, FRACTIONS)] * len(windows.narrow)
    starts = reach_of_starts(task.initial_set.share, task.dimension, FRACTIONS)
    return setting_of(windows, plant, law_of(task, edge_error, noise, latency, FRACTIONS), starts)


def _inertial_loop(
    task: Task,
    design: RefinedDesign,
    edge_error: Sequence[Fraction],
    rate_error: Sequence[Fraction],
    bounds: Sequence[Bounds] | None,
    noise: Any,
    latency: Any,
    start: Sequence[float] | None,
    *,
    more: Fraction = BEYOND,
    numbers: Numbers = DOUBLES,
) -> Setting:
    """A loop of order 2. more: samples so many times control.period apart are known, where v is by differences."""
    found, both = extent(design, numbers), (noise, numbers.of(task.plant.noise_v or 0))
    law = inertial_law(task, found, design.filter, (edge_error, rate_error), both, latency, more=more, numbers=numbers)
    plant = bounds or [bounds_of_task(task, numbers)] * (design.segments + 1)
    made = inertial_setting(design, found, plant, law, start_reach(task, design, start, numbers))
    return replace(made, known_to=difference_age(task, latency, more, numbers))


def statements_of(task: Task) -> tuple[str, ...]:
    """Those that may prove a period of such a loop: of order 2 the sharp one, which is not there where u is scaled as a whole."""
    return ("sharp",) if task.order == 2 else ("general",) if task.scales_input else ("sharp", "general")


def eps_of_states(task: Task, design: Design, windows: Windows | None, start: Sequence[float] | None) -> npt.NDArray[Any]:
    """What |eps(0)| is at most, (n,): of the starts in the share, or of one state; of order 2 that of v + lambda x too."""
    if task.order == 2:
        return start_reach(task, require_refined(design), start)
    if start is None:
        return reach_of_starts(task.initial_set.share, task.dimension)
    assert windows is not None
    return np.asarray(eps_of_state(windows, start))
