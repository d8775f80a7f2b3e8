"""The loop of a plant of order 2, as the sharp sampling conditions see it.

The law (13) controls v + lambda x in the filtered tube, so widths are W' + lambda W. The closing speed differs in the three
places of the sharp conditions. With F = |f + w|, edges L and R, middle c, W = R - L and Z = W' + lambda W:

    at an edge            P_x = F + max(lambda^2 W - R'', lambda^2 W + L'', R'', -L'')
    while a sample ages   P_d = F + max(lambda Z - L'', lambda^2 W - R'', lambda Z + R'', lambda^2 W + L'', 0)
    from the middle       P_m = F + |c''| + lambda (Z + lambda W)/2

The lemmas `filtered.*` prove this. sampling/loops.py builds the loops.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import LOWER, UPPER, RefinedDesign, demanded_accelerations, filtered_edges, slopes_at_start
from stt_codegen.program import FORMATS
from stt_codegen.sampling.numbers import DOUBLES, Numbers
from stt_codegen.sampling.plant import Bounds
from stt_codegen.sampling.sampled_loop import SampledLaw, SampledLoop, law_of, worst_with_previous_window
from stt_codegen.sampling.windows import OUTWARD_MARGIN, Windows, refined_windows
from stt_codegen.task import Task

Array = npt.NDArray[Any]
# Of a distance a = (v - L') + lambda (x - L), each of half a unit in the last place of at most Z + 2 lambda W.
ROUNDINGS = 8
# The error of a velocity by differences is known for samples that are older than the stated age by this factor.
KNOWN_AGE_FACTOR = Fraction(101, 100)


@dataclass(frozen=True, kw_only=True)
class FilteredExtremes:
    """Extremes of a filtered tube by window, the last from t_c on, and component, (W + 1, n), rounded outward.

    narrow, wide: the smallest and the largest Z. width: the largest W. bends (4, W + 1, n): the largest L'', -L'', R'' and -R''.
    middle: the largest |c''|. press (2, W + 1, n): the largest lambda^2 W + L'' and lambda^2 W - R''. rate: the largest |L'| and
    |R'|.
    """

    narrow: Array
    wide: Array
    width: Array
    bends: Array
    middle: Array
    press: Array
    rate: Array


def filtered_extremes(design: RefinedDesign, numbers: Numbers = DOUBLES) -> FilteredExtremes:
    """Return the extremes of a design; they are exact but for the conversion to doubles, which is rounded outward."""
    edges, press = filtered_edges(design), demanded_accelerations(design)
    z = edges.coefficients[:, :, UPPER] - edges.coefficients[:, :, LOWER]
    bezier = design.bezier()
    w = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    second_difference = 6 * np.diff(bezier, n=2, axis=3)
    bend_unit = design.unit * (Fraction(design.segments) / design.prescribed_time) ** 2
    up = numbers.multiples_above

    def with_last_window(values: Array, last: Array) -> Array:
        """Append the window from t_c on: the tube stands, or repeats itself from its seam."""
        return np.concatenate([values, last[None] if design.seam is None else values[design.seam : design.seam + 1]])

    low, high = second_difference[:, :, LOWER], second_difference[:, :, UPPER]
    bends = [up(v.max(axis=-1), bend_unit) for v in (low, -low, high, -high)]
    lower, upper = press.coefficients[:, :, LOWER], -press.coefficients[:, :, UPPER]
    zero = up(0 * w[-1, :, 3], design.unit)
    return FilteredExtremes(
        narrow=-with_last_window(up(-z.min(axis=-1), edges.unit), up(-z[-1, :, 3], edges.unit)),
        wide=with_last_window(up(z.max(axis=-1), edges.unit), up(z[-1, :, 3], edges.unit)),
        width=with_last_window(up(w.max(axis=-1), design.unit), up(w[-1, :, 3], design.unit)),
        bends=np.stack([with_last_window(v, zero) for v in bends]),
        middle=with_last_window(up(np.abs(low + high).max(axis=-1), bend_unit) / 2, zero),
        press=np.stack([with_last_window(up(v.max(axis=-1), press.unit), up(v[-1, :, 3], press.unit)) for v in (lower, upper)]),
        rate=up(design.largest_steps(), design.speed_per_step),
    )


@dataclass(frozen=True)
class Motion:
    """The motion of a filtered tube, as the sharp conditions need it, by window and component (W + 1, n).

    wide: the largest Z of the window. narrow: the smallest Z of it and of the one before. at_edge (P_x), aging (P_d), from_middle
    (P_m): what the motion adds to |f + w| in the three places of the conditions, in this window and the one before.
    """

    wide: Array
    narrow: Array
    at_edge: Array
    aging: Array
    from_middle: Array


def inertial_motion(extremes: FilteredExtremes, filter_rates: Sequence[Fraction], numbers: Numbers = DOUBLES) -> Motion:
    """Return the motion, by the formulas in the docstring of this file; filter_rates: lambda by component."""
    rate = np.array([numbers.of(v) for v in filter_rates])
    up_l, down_l, up_r, down_r = extremes.bends  # the largest L'', -L'', R'', -R''
    z, w = rate * extremes.wide, rate * rate * extremes.width
    at_edge = np.maximum.reduce([extremes.press[0], extremes.press[1], up_r, down_l])
    aging = np.maximum.reduce([z + down_l, w + down_r, z + up_r, w + up_l, 0 * z])
    speeds = (worst_with_previous_window(v, np.maximum) for v in (at_edge, aging, extremes.middle + (z + w) / 2))
    return Motion(extremes.wide, worst_with_previous_window(extremes.narrow, np.minimum), *speeds)


def inertial_windows(design: RefinedDesign, extremes: FilteredExtremes, numbers: Numbers = DOUBLES) -> Windows:
    """Return the windows of the filtered tube; `low`, `high` and `start` are those of x."""
    zero = 0 * extremes.narrow
    return replace(refined_windows(design, numbers), narrow=extremes.narrow, wide=extremes.wide, speed=zero, widening=zero)


def velocity_bounds(design: RefinedDesign) -> tuple[Array, Array]:
    """Return the bounds on v by window and component: v + lambda x is in the filtered tube, and x in its own."""
    extremes, windows = filtered_extremes(design), refined_windows(design)
    rate = np.array([float(v) for v in design.filter])
    largest = extremes.rate + rate * (windows.high - windows.low)
    return -largest * (1 + OUTWARD_MARGIN), largest * (1 + OUTWARD_MARGIN)


def difference_error(
    task: Task,
    noise: Sequence[Fraction],
    extremes: tuple[Sequence[Fraction], Sequence[Fraction]],
    filter_rates: Sequence[Fraction],
    age_factor: Fraction = Fraction(1),
) -> tuple[Fraction, ...]:
    """Return a bound on the error of a velocity by differences, by component.

    noise: bounds the error of each x_i. extremes: the largest edge speed and the largest W, by component. Samples are at most
    age_factor times control.period apart. Between samples tau apart the quotient is the mean of v, which changes by at most A =
    F + G u_max + .. a second: this gives A tau/2 (the lemma `filtered.differences`). To this the function adds twice the error of
    x over the shortest tau, and bends roundings of the quotient, whose size is at most the edge speed + lambda W.
    """
    limits = task.emitted_u_max
    assert limits is not None
    roundoff, errors = Fraction(FORMATS[task.emit.scalar].roundoff), []
    for i, acceleration in enumerate(task.largest_derivative(limits)):
        lag = acceleration * age_factor * task.sampling_period / 2
        error = lag + 2 * (noise[i] + roundoff * (task.largest_coordinate + noise[i])) / task.shortest_period
        speed, width = (values[i] for values in extremes)
        errors.append(error + 4 * roundoff * (speed + filter_rates[i] * width + error))
    return tuple(errors)


def difference_age(task: Task, latency: Any, age_factor: Fraction, numbers: Numbers = DOUBLES) -> Any:
    """Return up to which age of a sample, in seconds, `difference_error` holds; infinite where v is measured.

    Samples are age_factor times the period apart, and their input acts `latency` later.
    """
    return numbers.of(task.sampling_period * age_factor) + latency if task.uses_differences else math.inf


def inertial_law(
    task: Task,
    extremes: FilteredExtremes,
    filter_rates: Sequence[Fraction],
    errors: tuple[Sequence[Fraction], Sequence[Fraction]],
    noise: tuple[Array, Array],
    *,
    latency: Any = 0.0,
    age_factor: Fraction = KNOWN_AGE_FACTOR,
    numbers: Numbers = DOUBLES,
) -> SampledLaw:
    """Return the law of a task of order 2.

    Its `shift` sums up the errors of a and b: of the arithmetic of edges and rates (`errors`), of the noise of x and v, of x and
    v rounded to the scalar, and of the roundings of a and b. noise: of x and of v, (n,) each. age_factor: as in `difference_age`.
    """
    edge, rate = errors
    roundoff = numbers.of(FORMATS[task.emit.scalar].roundoff)
    filter_rate = np.array([numbers.of(v) for v in filter_rates])
    arithmetic = np.array([numbers.of(2 * (r + v * e)) for e, r, v in zip(edge, rate, filter_rates, strict=True)])
    size = numbers.of(task.largest_coordinate)
    fastest, width, wide = (v.max(axis=0) for v in (extremes.rate, extremes.width, extremes.wide))
    of_v: Any = noise[1]
    if task.uses_differences:
        exact = ([Fraction(v) for v in fastest.tolist()], [Fraction(v) for v in width.tolist()])
        error = difference_error(task, [Fraction(v) for v in noise[0].tolist()], exact, filter_rates, age_factor)
        of_v = of_v + numbers.outward(np.array([numbers.of(v) for v in error]), OUTWARD_MARGIN)
    in_state = filter_rate * size + (fastest + filter_rate * width)
    rounded = roundoff * (in_state + ROUNDINGS * (wide + 2 * filter_rate * width))
    shift = arithmetic + of_v + filter_rate * noise[0] + rounded
    return replace(law_of(task, edge, 0, latency, numbers), shift=numbers.outward(shift, 1e-9))


def inertial_loop(
    design: RefinedDesign, extremes: FilteredExtremes, plant: Sequence[Bounds], law: SampledLaw, start: Array
) -> SampledLoop:
    """Return the loop of a plant of order 2.

    plant: bounds on accelerations for every window, each over it and the one before. start (n): a bound on |eps(0)|.
    """
    numbers = law.numbers
    force, motion = np.array([p.disturbance for p in plant]), inertial_motion(extremes, design.filter, numbers)
    speeds = (motion.at_edge, motion.aging, motion.from_middle)
    at_edge, aging, from_middle = (numbers.outward(force + v, OUTWARD_MARGIN) for v in speeds)
    return SampledLoop(
        windows=inertial_windows(design, extremes, numbers),
        law=law,
        diagonal_min=np.array([p.diagonal_min for p in plant]),
        diagonal_max=np.array([p.diagonal_max for p in plant]),
        cross=np.array([p.cross for p in plant]),
        closing_speed=at_edge,
        narrow=motion.narrow,
        eigenvalue_min=np.array([p.eigenvalue_min for p in plant]),
        norm=np.array([p.norm for p in plant]),
        closing_speed_norm=np.full(len(force), np.inf),  # the general conditions are about order 1
        start=start,
        closing_speed_aging=aging,
        closing_speed_middle=from_middle,
    )


def inertial_start_bound(
    task: Task, design: RefinedDesign, state: Sequence[float] | None = None, numbers: Numbers = DOUBLES
) -> Array:
    """Return a bound on |ln(a/b)| at the start, by component, rounded up.

    It is for every x in the share of gamma(0), or for one state, with every speed within initial_set.speed (at rest where there
    is none), or with the state's own speeds behind x. The bound on |e(0)| of x counts too. Infinite where v + lambda x may be
    outside.
    """
    bounds = []
    for i, (low_rate, high_rate) in enumerate(slopes_at_start(design)):
        low, high = (int(v) * design.unit for v in design.bezier()[0, i, :, 0])
        half, middle = task.initial_set.share * (high - low) / 2, (low + high) / 2
        positions = [middle - half, middle + half] if state is None else [Fraction(float(state[i]))]
        shares = [abs(2 * x - low - high) / (high - low) for x in positions]
        eps_bounds = [numbers.eps_of_share(v) if v < 1 else math.inf for v in shares]
        if state is not None and len(state) > task.dimension:
            velocities = [Fraction(float(state[task.dimension + i]))]
        else:
            velocities = [task.start_speed[i], -task.start_speed[i]]
        for x, v in itertools.product(positions, velocities):
            a, b = v - low_rate + design.filter[i] * (x - low), high_rate - v + design.filter[i] * (high - x)
            is_inside = a > 0 and b > 0 and low < x < high
            eps_bounds.append(numbers.eps_of_ratio(a / b) if is_inside else math.inf)
        bounds.append(numbers.outward(max(eps_bounds), 1e-9))
    return np.array(bounds)
