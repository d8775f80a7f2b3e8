"""State the bounds of a plant with equations as the table [plant] of a task, or say why no table can; and compare a plant with
it.

report/loop_analysis.py calls this with bounds over the windows of a tube.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.arrays import one_if_equal
from stt_codegen.decimals import above, below, by_component
from stt_codegen.sampling import Bounds, bounds_of_task
from stt_codegen.task import Task

SMALLEST, LARGEST = Fraction(1, 10**9), Fraction(10**9)  # of numbers in a task, apart from 0
OneOrEach = float | tuple[float, ...] | None


@dataclass(frozen=True, kw_only=True)
class ProposedBounds:
    """Values of [plant] that bound the plant over the tube: one number, or one for each component.

    w_max: None where the equations have no disturbance. reason: why no table can state this plant; empty if one can. lines: the
    lines of the table in a task file.
    """

    f_max: OneOrEach = None
    w_max: OneOrEach = None
    g_min: OneOrEach = None
    g_max: OneOrEach = None
    g_cross: OneOrEach = None
    reason: str = ""
    lines: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """Return the values as JSON data."""
        names = ("f_max", "w_max", "g_min", "g_max", "g_cross", "reason")
        return {**{name: getattr(self, name) for name in names}, "toml": "\n".join(self.lines)}


@dataclass(frozen=True)
class Extremes:
    """Bounds over all windows: on |f + w|, on g from below and above, and on |g_ij|. By component (n,), or norms in one entry."""

    disturbance: list[float]
    g_lower: list[float]
    g_upper: list[float]
    g_cross: list[float]


def component_extremes(bounds: Sequence[Bounds]) -> Extremes:
    """Return the largest |f_i + w_i| and |g_ij|, and the smallest and largest g_ii, over the windows."""
    disturbance, g_upper = (np.array([getattr(b, name) for b in bounds]).max(axis=0) for name in ("disturbance", "diagonal_max"))
    g_lower = np.array([b.diagonal_min for b in bounds]).min(axis=0)
    g_cross = np.array([b.cross for b in bounds]).max(axis=(0, 2))
    return Extremes(disturbance.tolist(), g_lower.tolist(), g_upper.tolist(), g_cross.tolist())


def norm_extremes(bounds: Sequence[Bounds]) -> Extremes:
    """Return the largest |f + w| and |g|, and the smallest eigenvalue of g_s, over the windows; |g| includes |g_ij|."""
    disturbance, g_lower, g_upper = (
        max(b.disturbance_norm for b in bounds),
        min(b.eigenvalue_min for b in bounds),
        max(b.norm for b in bounds),
    )
    return Extremes([disturbance], [g_lower], [g_upper], [0.0])


def uncovered_bounds(task: Task, bounds: Sequence[Bounds], w_bound: Fraction = Fraction(0)) -> list[str]:
    """Return where a plant exceeds the task's table [plant], with its number, the stated one and what covers it; or nothing.

    Compared in norms where u is scaled as a whole, else by component. w_bound: bound on the plant's |w|, a part of |f + w|. What
    is named for one component covers all that exceed the same number.
    """
    extremes = norm_extremes if task.scales_input else component_extremes
    worst, stated = extremes(bounds), extremes([bounds_of_task(task)])
    g = "g" if task.gain[0] > 0 else "-g"
    names = ("|f + w|", f"{g}_ii", f"{g}_ii", "|g_ij|")
    if task.scales_input:
        names = ("|f + w|", f"least eigenvalue of {g}_s", "|g|", "")
    lines: list[str] = []
    for name, kind in zip(names, ("disturbance", "g_lower", "g_upper", "g_cross"), strict=True):
        values, limits = getattr(worst, kind), getattr(stated, kind)
        is_lower = kind == "g_lower"
        uncovered = {
            i: v for i, (v, limit) in enumerate(zip(values, limits, strict=True)) if (v < limit if is_lower else v > limit)
        }
        remedy = _sufficient_bounds(task, kind, uncovered, w_bound)
        for i, value in uncovered.items():
            label = f" of {task.axis_words[i]}" if len(values) > 1 else ""
            reached = f"falls to {_digits(value, below)}" if is_lower else f"reaches {_digits(value, above)}"
            line = f"{name}{label} {reached}, {limits[i]:.9g} is stated"
            lines.append(f"{line}, {remedy}" if remedy else line)
    return lines


def _sufficient_bounds(task: Task, kind: str, uncovered: Mapping[int, float], w_bound: Fraction) -> str:
    """Say what in [plant] covers these components; empty where a task takes no such number.

    Of a list the other entries stay. Where w alone is larger than stated, w_max is named, and f_max besides where f is too.
    """
    if not uncovered or not all(map(math.isfinite, uncovered.values())):
        return ""
    if kind != "disturbance":
        name = {"g_lower": "g_min", "g_upper": "g_max", "g_cross": "g_cross"}[kind]
        return _changes(task, {name: {i: Fraction(v) for i, v in uncovered.items()}})
    w_max = {i: max(w_bound, _stated_entry(task, "w_max", i)) for i in uncovered}
    larger_w_max = {i: v for i, v in w_max.items() if v > _stated_entry(task, "w_max", i)}
    f_max = {i: Fraction(v) - w_max[i] for i, v in uncovered.items()}
    larger_f_max = {i: v for i, v in f_max.items() if v > _stated_entry(task, "f_max", i)}
    return _changes(task, {"w_max": larger_w_max, "f_max": larger_f_max})


def _stated_entry(task: Task, name: str, i: int) -> Fraction:
    """Return the stated number of component i, 0 where the task states none."""
    stated = getattr(task.plant, name) or Fraction(0)
    return Fraction(stated[i] if isinstance(stated, tuple) else stated)


def _changes(task: Task, needed: Mapping[str, Mapping[int, Fraction]]) -> str:
    """Say what to state for the needed numbers by name and component; empty where a task takes no such number."""
    texts: list[str] = []
    for name, numbers in needed.items():
        if not numbers:
            continue
        rounded = {i: below(v, 4) if name == "g_min" else _stated_above(v) for i, v in numbers.items()}
        if not all(map(_is_in_range, rounded.values())):
            return ""
        stated = getattr(task.plant, name)
        if isinstance(stated, tuple):
            values = [rounded.get(i, v) for i, v in enumerate(stated)]
        else:
            values = [min(rounded.values()) if name == "g_min" else max(rounded.values())]
        texts.append(f"plant.{name} = {by_component(values)}")
    return " and ".join(texts) + (" covers it" if len(texts) == 1 else " cover it")


def _digits(value: float, rounding: Callable[[Fraction, int], float]) -> str:
    """Return the value with nine digits, which tell it from a stated bound."""
    return f"{rounding(Fraction(value), 9):.9g}" if math.isfinite(value) else "no known bound"


def propose_bounds(
    task: Task,
    bounds: Sequence[Bounds],
    w_bound: Fraction,
    bounds_of_minus_g: Callable[[], Sequence[Bounds]],
    times: Sequence[float],
) -> ProposedBounds:
    """Propose the table [plant] for a plant with these bounds by window.

    w_bound: bound on |w|, which the bounds on |f + w| include. bounds_of_minus_g: returns the bounds of the plant with -g for g,
    which say whether a gain of the other sign would do. times: where the windows begin, in seconds.
    """
    if unknown := _unknown_bound(task, bounds, times):
        return ProposedBounds(reason=unknown)
    worst = component_extremes(bounds)
    if task.order == 1:  # one number each, which holds for components and for norms
        norms = norm_extremes(bounds)
        disturbance, g_lower = max(norms.disturbance + worst.disturbance), min(norms.g_lower + worst.g_lower)
        worst = Extremes([disturbance], [g_lower], [max(norms.g_upper + worst.g_upper)], [max(worst.g_cross)])
    reason = _reason(task, worst, bounds_of_minus_g)
    if reason:
        return ProposedBounds(reason=reason)
    if not all(map(math.isfinite, (*worst.disturbance, *worst.g_lower, *worst.g_upper, *worst.g_cross))):
        return ProposedBounds(reason="a bound is beyond what a double holds")
    table = {
        "f_max": [_stated_above(Fraction(v) - w_bound) for v in worst.disturbance],
        "w_max": [_stated_above(w_bound)] if w_bound else [],
        "g_min": [below(Fraction(v), 4) for v in worst.g_lower],
        "g_max": [_stated_above(Fraction(v)) for v in worst.g_upper],
        "g_cross": [_stated_above(Fraction(v)) for v in worst.g_cross],
    }
    outside = next((f"{k} would be {v:.4g}" for k, values in table.items() for v in values if v and not _is_in_range(v)), None)
    if outside is not None:
        return ProposedBounds(reason=f"{outside}, and a task takes 0 or numbers from 1e-9 to 1e9; rescale the units")
    f_max, w_max, g_min, g_max, g_cross = (one_if_equal(values) if values else None for values in table.values())
    return ProposedBounds(f_max=f_max, w_max=w_max, g_min=g_min, g_max=g_max, g_cross=g_cross, lines=tuple(_lines(task, table)))


def _stated_above(value: Fraction) -> float:
    """Return the value with four digits, rounded up to a number that a task may have; 0 stays."""
    return above(max(value, SMALLEST), 4) if value > 0 else 0.0


def _is_in_range(value: float) -> bool:
    return SMALLEST <= Fraction(f"{value:.9g}") <= LARGEST


def _lines(task: Task, table: dict[str, list[float]]) -> Iterator[str]:
    """Yield the lines of the table [plant]; values that the equations do not have are those of the task."""
    yield "[plant]"
    if task.order == 2:
        yield "order = 2"
    for name, values in table.items():
        if values:
            yield f"{name} = {by_component(values)}"
        elif (stated := getattr(task.plant, name)) is not None:
            yield f"{name} = {by_component(stated if isinstance(stated, tuple) else (stated,))}"
    for name in ("noise", "noise_v"):
        if (error := getattr(task.plant, name)) is not None:
            yield f"{name} = {by_component(error if isinstance(error, tuple) else (error,))}"


def _unknown_bound(task: Task, bounds: Sequence[Bounds], times: Sequence[float]) -> str:
    """Say of which component no bound is known, and when; empty where all are known."""
    for k, b in enumerate(bounds):
        for name, values in (("f", b.disturbance), ("g", b.diagonal_min), ("g", b.diagonal_max), ("g", b.cross.max(axis=1))):
            i = next((i for i, v in enumerate(values.tolist()) if not math.isfinite(v)), None)
            if i is not None:
                problem = f"no bound on {name} of {task.axis_words[i]} is known over the tube at t = {times[k]:.4g} s"
                return f"{problem}: a divisor may be 0 there, or a root or logarithm of what may be negative"
    return ""


def _reason(task: Task, worst: Extremes, bounds_of_minus_g: Callable[[], Sequence[Bounds]]) -> str:
    """Return why no table [plant] can state these bounds; empty where one can."""
    if min(worst.g_lower) > 0:
        return ""
    positive = task.gain[0] > 0
    g, sign = ("g", "negative") if positive else ("-g", "positive")
    if task.order == 1:
        quantity, lowest_of_minus_g = f"the least eigenvalue of {g}_s", min(b.eigenvalue_min for b in bounds_of_minus_g())
    else:
        i = worst.g_lower.index(min(worst.g_lower))
        quantity, lowest_of_minus_g = (
            f"{g}_ii of {task.axis_words[i]}",
            min(float(b.diagonal_min.min()) for b in bounds_of_minus_g()),
        )
    lowest = f"{below(Fraction(min(worst.g_lower)), 4):g}"
    problem = f"{quantity} is only known to be at least {lowest}, and plant.g_min is greater than 0"
    if lowest_of_minus_g > 0:
        return f"{problem}; use a {sign} control.gain, with which [plant] bounds {'-g' if positive else 'g'}"
    return problem
