"""Sentences on what was chosen or assumed for a task with a period, and on what u may reach in one without."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

from stt_codegen.controller import rate_error
from stt_codegen.decimals import above, by_component, decimal
from stt_codegen.designs import require_refined
from stt_codegen.pipeline import EmittedController
from stt_codegen.sampling import exact_loop, loop_of, needed_input, path_loop_of
from stt_codegen.sampling.path import (
    PROVED_FACTORS,
    PathLoop,
    proved_disturbance_factor,
    proved_drive_factor,
    proved_period_factor,
    resting_gain,
)
from stt_codegen.task import Task

LIMIT_ROUNDING = 1.01  # a limit that is chosen is rounded up to three digits
REFERENCE_ERROR = Fraction(1, 2)  # |e| at which the resting gain is computed once


def choice_lines(controller: EmittedController) -> Iterator[str]:
    """Yield what was chosen for the tube: the limit of u, and the gain with its reserves and its answer to noise."""
    task, certificate = controller.task, controller.certificate
    if certificate.holds and task.control.u_norm is not None and task.u_max is not None:
        limits = by_component(task.u_max)
        yield f"|u|, the Euclidean norm, is at most {decimal(task.control.u_norm)}: u_max {limits} by component keeps it"
    if certificate.proved_period is None:
        return
    design = require_refined(controller.design)
    errors = certificate.edge_error, rate_error(design, controller.program) if design.filter else ()
    if task.has_chosen_limit and task.u_max is not None:
        yield from _limit_line(task, task.u_max, needed_input(loop_of(task, design, *errors)).tolist())
    if task.has_tight_gain:
        yield f"gain {by_component([abs(k) for k in task.gain])} was chosen: of those that are tried it keeps |e| smallest"
    if task.has_gentle_gain:
        yield _gain_line(task, path_loop_of(task, design, exact_loop(task, design, *errors)))


def _limit_line(task: Task, limits: Sequence[Fraction], needed: Sequence[float]) -> Iterator[str]:
    """Yield which limits of u were chosen, and how many times what they balance; none for limits that the task states."""
    stated = task.stated_u_max or (None,) * len(limits)
    chosen = [i for i, (u, cap) in enumerate(zip(limits, stated, strict=True)) if u != cap]
    factors = [float(limits[i]) / needed[i] for i in chosen if needed[i]]
    if not chosen:
        return
    is_all = len(chosen) == len(limits)
    axes = "" if is_all else f" of {', '.join(task.axis_words[i] for i in chosen)}"
    values = by_component(limits) if is_all else ", ".join(decimal(limits[i]) for i in chosen)
    line = f"u_max {values}{axes} was chosen"
    if factors:
        at_least = "at least " if max(factors) > min(factors) * LIMIT_ROUNDING else ""
        line += f": {at_least}{min(factors):.3g} times what balances disturbances and edges"
    yield line


def _gain_line(task: Task, loop: PathLoop) -> str:
    """Say where the state rests at the chosen gain, for how much more it is proved, and what noise does to u."""
    gain = [law.gain for law in loop.laws]
    resting_error = max(_resting_error(loop, i, k) for i, k in enumerate(gain))
    forces = [bounds.force for bounds in task.plant_bounds]
    factors = [(proved_disturbance_factor(loop, forces), "disturbance")] if any(forces) else []
    if not task.uses_differences:  # for a longer period the error of v is not known
        factors.append((proved_period_factor(loop, task.sampling_period), "period"))
    if task.has_drive:
        factors.append((proved_drive_factor(loop), "delay of the drive"))
    is_proved = all(factor for factor, _ in factors)  # by the worst path; else by the sharp conditions, with no reserve known
    *first_parts, last_part = [f"{_factor(factor)} times the {word}" for factor, word in factors if factor != 1] or [""]
    larger = f"{', '.join(first_parts)} or {last_part}" if first_parts else last_part
    line = f"gain {by_component(gain)}: a steady disturbance leaves the state within |e| {above(Fraction(resting_error), 2):g}"
    line += f"; proved also with {larger}" if is_proved and larger else ""
    if not task.has_noise:
        return line
    at_middle, at_rest = (_answer_to_noise(loop, e) for e in (0.0, resting_error))
    measured = f"noise of {by_component(task.noise)}"
    measured += f" (of v {by_component(task.noise_v)})" if any(task.noise_v) else ""
    return f"{line}; {measured} moves u by about {_rounded(at_middle)} in the middle of the tube, {_rounded(at_rest)} at that |e|"


def _factor(value: Fraction) -> str:
    """Write a factor; where the last that is looked for is proved, as "10 or more"."""
    return "10 or more" if value == PROVED_FACTORS[-1] else decimal(value)


def _resting_error(loop: PathLoop, i: int, gain: Fraction) -> float:
    """Return |e| at which component i rests under a steady disturbance, by bisection: there 4 q(E) = P W/(g_min k)."""

    def four_q(e: float) -> float:
        return 4 * math.log((1 + e) / (1 - e)) / (1 - e * e)

    reference = float(REFERENCE_ERROR)
    wanted = float(resting_gain(loop, i, REFERENCE_ERROR) / gain) * four_q(reference)
    low, high = 0.0, 1 - 1e-9
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if four_q(middle) < wanted else (low, middle)
    return high


def _answer_to_noise(loop: PathLoop, e: float) -> list[float]:
    """Return by component what the error of a measured distance moves u by at |e|, where the tube is narrowest."""
    slope = (1 + 2 * e * math.atanh(e)) / (1 - e * e) ** 2
    widths = [float(min(window.narrow for window in windows)) for windows in loop.windows]
    return [16 * float(law.gain) / w**2 * slope * float(law.shift) for law, w in zip(loop.laws, widths, strict=True)]


def _rounded(values: Sequence[float]) -> str:
    return by_component([above(Fraction(v), 2) for v in values])


def control_notes(task: Task, largest_u: float | None) -> Iterator[str]:
    """Yield what a user may not expect of plant and input. largest_u: |u| at the clamp, None where it is not known."""
    if task.control.period is None:
        if task.u_max is None and largest_u is not None:
            reached = f"{above(Fraction(largest_u), 3):g}{_input_unit(task)}"
            yield (
                f"nothing limits u: near an edge it may reach {reached}; state control.u_max, or control.period, for which a "
                "limit is chosen and proved"
            )
        return
    if task.assumes_plant:
        yield (
            f"assumed, as [plant] states no bounds: {assumed_words(task)}, no lag, no coupling, exact measurement; "
            "state your own, or plant.exact = true for x' = u"
        )
        return
    for names, words in (("f_max or w_max", "f = w = 0"), ("g_min or g_max", "g = 1")):
        if all(getattr(task.plant, name) is None for name in names.split(" or ")) and not task.plant.exact:
            yield f"[plant] states no {names}: the proof is for {words} alone"
    if not (task.as_stated.has_noise or task.has_late_input):
        yield "[plant] has neither noise nor lag; no sensor is exact, and no drive is immediate"


def assumed_words(task: Task) -> str:
    """Return the bounds of a plant that is assumed, in words."""
    low, high = task.plant_bounds[0].g_min, task.plant_bounds[0].g_max
    forces = by_component([bounds.force for bounds in task.plant_bounds])
    return f"g from {decimal(low)} to {decimal(high)}, disturbances up to {forces}"


def _input_unit(task: Task) -> str:
    """Return the unit of u where all axes have the same, else nothing."""
    units = set(task.units or ("",))
    unit = units.pop() if len(units) == 1 else ""
    return f" {unit}/s{'^2' if task.order == 2 else ''}" if unit else ""
