"""The sampled loop of a task and its tube: in doubles for design and reports, in fractions for the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import Design, RefinedDesign, require_refined
from stt_codegen.sampling.numbers import DOUBLES, FRACTIONS, Numbers
from stt_codegen.sampling.order_two import (
    KNOWN_AGE_FACTOR,
    difference_age,
    filtered_extremes,
    inertial_law,
    inertial_loop,
    inertial_start_bound,
)
from stt_codegen.sampling.path import Drive, PathLoop
from stt_codegen.sampling.plant import Bounds, bounds_of_task
from stt_codegen.sampling.sampled_loop import (
    SampledLoop,
    first_order_loop,
    law_of,
    start_bound_of_share,
    start_bound_of_state,
)
from stt_codegen.sampling.windows import Windows, refined_windows
from stt_codegen.task import Task

DIFFERENCE_ROUNDING = Fraction(1025, 1024)  # of the error of a velocity by differences, beside what it grows with


def loop_of(
    task: Task,
    design: Design,
    edge_error: Sequence[Fraction],
    rate_error: Sequence[Fraction] = (),
    *,
    windows: Windows | None = None,
    bounds: Sequence[Bounds] | None = None,
    noise: Sequence[float] | None = None,
    latency: float | None = None,
    start: Sequence[float] | None = None,
) -> SampledLoop:
    """Return the loop of a task and its tube, in doubles.

    edge_error, rate_error: bounds on the arithmetic's error of an edge (units) and, for order 2, of its rate (units per second),
    (n,). windows: of an adaptive tube. bounds: on a plant, by window; None for those of [plant]. noise: bounds on the errors of a
    measured x, (n,), in units; latency: seconds; None for the task's. start: one state, with or without its speeds behind it;
    None for all starts in the task's share.
    """
    noise = [float(v) for v in task.noise] if noise is None else noise
    latency = float(task.control.latency) if latency is None else latency
    if task.order == 2:
        return _inertial_loop_of(
            task,
            require_refined(design),
            (edge_error, rate_error),
            noise=noise,
            latency=latency,
            age_factor=KNOWN_AGE_FACTOR,
            numbers=DOUBLES,
            bounds=bounds,
            start=start,
        )
    if windows is None:
        windows = refined_windows(require_refined(design))
    plant = bounds or [bounds_of_task(task)] * len(windows.narrow)
    start_bound = start_bound_of_task(task, design, windows, start)
    return first_order_loop(windows, plant, law_of(task, edge_error, noise, latency), start_bound)


def loop_without_limits(
    task: Task, design: Design, edge_error: Sequence[Fraction], rate_error: Sequence[Fraction] = ()
) -> SampledLoop:
    """Return the loop, in doubles, of a task whose limits of u are not chosen yet. Its u_max has no meaning.

    It has one at all because a velocity by differences cannot be read without one.
    """
    limits = ((task.control.u_norm or Fraction(task.dimension)) / task.dimension,) * task.dimension
    return loop_of(task.with_choices(u_max=limits), design, edge_error, rate_error)


def exact_loop(
    task: Task, design: RefinedDesign, edge_error: Sequence[Fraction], rate_error: Sequence[Fraction] = ()
) -> SampledLoop:
    """Return the loop of a task and its tube in fractions, for the sampling period that the task states.

    Bounds on |eps| are rho = e^E. edge_error, rate_error: as for `loop_of`.
    """
    noise, latency = task.noise, task.control.latency
    if task.order == 2:
        errors, age_factor = (edge_error, rate_error), Fraction(1)
        return _inertial_loop_of(task, design, errors, noise=noise, latency=latency, age_factor=age_factor, numbers=FRACTIONS)
    windows = refined_windows(design, FRACTIONS)
    plant = [bounds_of_task(task, FRACTIONS)] * len(windows.narrow)
    start_bound = start_bound_of_share(task.initial_set.share, task.dimension, FRACTIONS)
    return first_order_loop(windows, plant, law_of(task, edge_error, noise, latency, FRACTIONS), start_bound)


def path_loop_of(task: Task, design: RefinedDesign, loop: SampledLoop) -> PathLoop:
    """Return the loop as the worst path reads it, with the task's period and drives; loop: from `exact_loop`."""
    drives, filter_rates = [Drive.of(bounds) for bounds in task.drive_bounds], design.filter if task.order == 2 else ()
    path_loop = PathLoop.of(loop, drives, task.sampling_period, filter_rates, design.seam)
    if not task.uses_differences:
        return path_loop
    return replace(path_loop, shift_time=task.sampling_period / 2 * DIFFERENCE_ROUNDING)


def _inertial_loop_of(
    task: Task,
    design: RefinedDesign,
    errors: tuple[Sequence[Fraction], Sequence[Fraction]],
    *,
    noise: Sequence[Any],
    latency: Any,
    age_factor: Fraction,
    numbers: Numbers,
    bounds: Sequence[Bounds] | None = None,
    start: Sequence[float] | None = None,
) -> SampledLoop:
    """Return a loop of order 2.

    errors: of edges and of their rates. age_factor: where v is computed by differences, samples may be this many times
    control.period apart; beyond that its error is not known.
    """
    extremes, both = filtered_extremes(design, numbers), (np.array(noise), np.array([numbers.of(v) for v in task.noise_v]))
    law = inertial_law(task, extremes, design.filter, errors, both, latency=latency, age_factor=age_factor, numbers=numbers)
    plant = bounds or [bounds_of_task(task, numbers)] * (design.segments + 1)
    loop = inertial_loop(design, extremes, plant, law, inertial_start_bound(task, design, start, numbers))
    return replace(loop, largest_known_age=difference_age(task, latency, age_factor, numbers))


def condition_kinds_of(task: Task) -> tuple[str, ...]:
    """Return the kinds of sampling conditions that may prove a period of a task's loop.

    For order 2 these are the sharp ones; the task's checks refuse to scale u as a vector there.
    """
    return ("sharp",) if task.order == 2 else ("general",) if task.scales_input else ("sharp", "general")


def start_bound_of_task(task: Task, design: Design, windows: Windows | None, start: Sequence[float] | None) -> npt.NDArray[Any]:
    """Return a bound on |eps(0)|, (n,), of all starts in the share or of one state; for order 2 it bounds v + lambda x too."""
    if task.order == 2:
        return inertial_start_bound(task, require_refined(design), start)
    if start is None:
        return start_bound_of_share(task.initial_set.share, task.dimension)
    assert windows is not None
    return np.asarray(start_bound_of_state(windows, start))
