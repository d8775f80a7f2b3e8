"""A closed loop for the sampling conditions: a tube in time windows, bounds on a plant in each, and the law with its errors.

sampling/loops.py builds one for a task. The lemmas `sampled.windows`, `sampled.exact_windows` and `sampled.setting` show that its
numbers are on the safe side.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.program import FORMATS
from stt_codegen.sampling.numbers import DOUBLES, Numbers
from stt_codegen.sampling.plant import Bounds
from stt_codegen.sampling.windows import Windows
from stt_codegen.task import Task

Array = npt.NDArray[Any]
# The error of the emitted law against (13) on the numbers that it measures: relative, and in eps = ln(a/b). Float: less than 32
# roundings of 2^-24, the library's logarithm within 4 units; inline adds its 2^-14.9 of eps. Fixed: `integer_errors.law_error`,
# and its clamp, which acts up to 2^-13 later; neither kind of logarithm is used.
ROUNDING = {
    ("fixed", "libm"): 2.0**-10,
    ("fixed", "inline"): 2.0**-10,
    ("float", "libm"): 2.0**-19,
    ("float", "inline"): 2.0**-14,
    ("double", "libm"): 2.0**-46,
    ("double", "inline"): 2.0**-14,
}


@dataclass(frozen=True, kw_only=True)
class SampledLaw:
    """The control law (13) as it is emitted and sampled, by component, (n,).

    gain: |k|. e_max: the clamp of |e|. shift: a bound on the error of the measured distances to the edges, in the task's units.
    u_max: infinite where u is not limited. rounding: relative, and in eps. latency: seconds from a sample to the input computed
    from it. gain_high: where it is not None, conditions are about every |k| from `gain` to `gain_high`; infinite for all from
    `gain` on. numbers: the kind of number of the law and of its whole loop.
    """

    gain: Array
    e_max: Array
    shift: Array
    u_max: Array
    rounding: Any
    latency: Any = 0.0
    gain_high: Array | None = None
    numbers: Numbers = DOUBLES

    @property
    def largest_gain(self) -> Array:
        """The largest |k| in question, by component; |u| is largest for it."""
        return self.gain if self.gain_high is None else self.gain_high

    @property
    def eps_at_clamp(self) -> Array:
        """|eps| at |e| = e_max, by component: in doubles ln((1 + e_max)/(1 - e_max)), in fractions its exponential."""
        return np.asarray(self.numbers.eps_of_share(self.e_max))


@dataclass(frozen=True, kw_only=True)
class SampledLoop:
    """A tube, a plant over it, and a law.

    Arrays are (W + 1, n), by window and component, unless stated otherwise. A value is the worst over its window and the one
    before, because a sample may stem from there.

    diagonal_min, diagonal_max, cross (W + 1, n, n), eigenvalue_min and norm (both (W + 1)): of g, as in `plant.Bounds`.
    closing_speed: P = |f + w| + the edges' speed, a bound on the speed at which x and an edge approach each other while u = 0.
    closing_speed_norm (W + 1): the same as a norm. narrow: the tube's width. start (n): a bound on |eps(0)|, for the starts in
    question. closing_speed_aging, closing_speed_middle: for order 2, P in the two other places of the sharp conditions.
    largest_known_age: seconds; for older samples neither g of a plant that mixes nor the error of a velocity by differences is
    known.
    """

    windows: Windows
    law: SampledLaw
    diagonal_min: Array
    diagonal_max: Array
    cross: Array
    closing_speed: Array
    narrow: Array
    eigenvalue_min: Array
    norm: Array
    closing_speed_norm: Array
    start: Array
    closing_speed_aging: Array | None = None
    closing_speed_middle: Array | None = None
    largest_known_age: Any = math.inf

    @property
    def numbers(self) -> Numbers:
        """The kind of number of all values."""
        return self.law.numbers

    @property
    def longest_age(self) -> Any:
        """The largest age at which a sample, and the input before it, stem from the present window or the one before; seconds."""
        return min(self.largest_known_age, self.windows.shortest / (2 if self.law.latency else 1))

    @property
    def order_two_fields(self) -> tuple[str, ...]:
        """The names of the fields that are arrays for order 2 only."""
        return () if self.closing_speed_aging is None else ("closing_speed_aging", "closing_speed_middle")

    def with_law(self, **changes: Any) -> SampledLoop:
        """Return the same loop with other numbers of the law."""
        return replace(self, law=replace(self.law, **changes))

    def component(self, i: int) -> SampledLoop:
        """Return the loop of component i alone, for a plant whose inputs are not coupled."""
        column = slice(i, i + 1)

        def columns(part: Any, names: Sequence[str]) -> dict[str, Array]:
            return {name: getattr(part, name)[:, column] for name in names}

        w, law = self.windows, self.law
        windows = replace(w, start=w.start[column], **columns(w, ("narrow", "wide", "speed", "widening", "low", "high")))
        by_component = ("gain", "e_max", "shift", "u_max", *(("gain_high",) if law.gain_high is not None else ()))
        law = replace(law, **{name: getattr(law, name)[column] for name in by_component})
        bounds = columns(self, ("diagonal_min", "diagonal_max", "closing_speed", "narrow", *self.order_two_fields))
        return replace(self, windows=windows, law=law, cross=self.cross[:, column, column], start=self.start[column], **bounds)

    def window(self, k: int) -> SampledLoop:
        """Return the loop in window k alone, for the sharp conditions; the window before still counts."""
        row = slice(k, k + 1)
        windows = replace(self.windows, narrow=self.windows.narrow[row], wide=self.windows.wide[row])
        names = ("diagonal_min", "diagonal_max", "cross", "closing_speed", "narrow", *self.order_two_fields)
        return replace(self, windows=windows, **{name: getattr(self, name)[row] for name in names})

    def with_start(self, start: Array) -> SampledLoop:
        """Return the same loop for other starts: `start` bounds |eps(0)|, (n,)."""
        return replace(self, start=start)


def law_of(
    task: Task, edge_error: Sequence[Fraction], noise: Any = 0.0, latency: Any = 0.0, numbers: Numbers = DOUBLES
) -> SampledLaw:
    """Return the law of a task.

    edge_error: P7's bound, (n,). noise: a bound on the error of a measured x, in the task's units, one or (n,). latency:
    seconds.
    """
    n, scalar, limits = task.dimension, task.emit.scalar, task.emitted_u_max
    rounded = numbers.outward(numbers.of(FORMATS[scalar].roundoff * task.largest_coordinate), 1e-12)
    return SampledLaw(
        gain=np.array([numbers.of(abs(v)) for v in task.gain]),
        e_max=np.array([numbers.of(v) for v in task.e_max]),
        shift=np.array(
            [
                numbers.outward(numbers.of(2 * e), 1e-12) + rounded + error
                for e, error in zip(edge_error, np.broadcast_to(np.asarray(noise), n), strict=True)
            ]
        ),
        u_max=np.full(n, np.inf) if limits is None else np.array([numbers.of(v) for v in limits]),
        rounding=numbers.of(ROUNDING[scalar, task.emit.math]),
        latency=latency,
        numbers=numbers,
    )


def start_bound_of_share(share: Fraction, n: int, numbers: Numbers = DOUBLES) -> Array:
    """Return the bound on |eps(0)| for all starts with |e(0)| <= share, (n,); rounded up."""
    return np.full(n, numbers.outward(numbers.eps_of_share(share), 1e-9))


def start_bound_of_state(windows: Windows, x0: Sequence[float]) -> Array:
    """Return |eps(0)| of a state by component, rounded up; infinite where it is not strictly inside gamma(0)."""
    x = np.array(x0)
    a, b = x - windows.start[:, 0], windows.start[:, 1] - x
    a, b = a - 1e-15 * np.abs(x), b - 1e-15 * np.abs(x)  # this covers the rounding of the differences
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((a > 0) & (b > 0), np.abs(np.log(a / b)) * (1 + 1e-9), np.inf)


def first_order_loop(windows: Windows, plant: Sequence[Bounds], law: SampledLaw, start: Array) -> SampledLoop:
    """Return the loop of a plant of order 1.

    plant: bounds for every window, each over it and the one before. start (n): a bound on |eps(0)|.
    """
    numbers, speed = law.numbers, worst_with_previous_window(windows.speed, np.maximum)
    speed_norm = numbers.root_above((speed**2).sum(axis=1))
    return SampledLoop(
        windows=windows,
        law=law,
        diagonal_min=np.array([p.diagonal_min for p in plant]),
        diagonal_max=np.array([p.diagonal_max for p in plant]),
        cross=np.array([p.cross for p in plant]),
        closing_speed=numbers.outward(np.array([p.disturbance for p in plant]) + speed, 1e-12),
        narrow=worst_with_previous_window(windows.narrow, np.minimum),
        eigenvalue_min=np.array([p.eigenvalue_min for p in plant]),
        norm=np.array([p.norm for p in plant]),
        closing_speed_norm=numbers.outward(np.array([p.disturbance_norm for p in plant]) + speed_norm, 1e-12),
        start=start,
    )


def worst_with_previous_window(values: Array, worse: Callable[[Array, Array], Array]) -> Array:
    """Return by window the worse of its value and that of the window before; worse: np.minimum or np.maximum."""
    return worse(values, np.concatenate([values[:1], values[:-1]]))


def in_doubles(loop: SampledLoop) -> SampledLoop:
    """Return a loop in fractions with the nearest doubles in their place; bounds on |eps| stay what they are for fractions."""

    def nearest(value: Any) -> Any:
        return float(value) if isinstance(value, Fraction) else value.astype(float) if isinstance(value, np.ndarray) else value

    def converted(part: Any) -> dict[str, Any]:
        return {field.name: nearest(getattr(part, field.name)) for field in fields(part)}

    parts = {"windows": replace(loop.windows, **converted(loop.windows)), "law": replace(loop.law, **converted(loop.law))}
    return replace(loop, **converted(loop) | parts)


def in_balls(loop: SampledLoop) -> SampledLoop:
    """Return the same loop with balls in place of the doubles that formulas calculate with."""
    convert = np.vectorize(arb, otypes=[object])

    def converted(part: Any, names: Sequence[str]) -> dict[str, Array]:
        return {name: convert(getattr(part, name)) for name in names}

    windows = replace(loop.windows, **converted(loop.windows, ("narrow", "wide", "speed", "widening")))
    names = ("diagonal_min", "diagonal_max", "cross", "closing_speed", "narrow", "eigenvalue_min", "norm", "closing_speed_norm")
    high = loop.law.gain_high
    law = replace(loop.law, gain=convert(loop.law.gain), gain_high=None if high is None else convert(high))
    return replace(loop, windows=windows, law=law, **converted(loop, (*names, *loop.order_two_fields)))
