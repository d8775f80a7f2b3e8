"""A loop of order 2 as the sharp statement sees it: what is held is v + lambda x in the filtered tube, so widths are
W' + lambda W, and what pushes is not the same in the statement's three places. With F = |f + w|, edges L and R, middle c,
W = R - L and Z = W' + lambda W:

    at an edge            P_x = F + max(lambda^2 W - R'', lambda^2 W + L'', R'', -L'')
    while a sample ages   P_d = F + max(lambda Z - L'', lambda^2 W - R'', lambda Z + R'', lambda^2 W + L'', 0)
    from the middle       P_m = F + |c''| + lambda (Z + lambda W)/2
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
from stt_codegen.program import FORMATS, round_down
from stt_codegen.sampling.numbers import DOUBLES, Numbers
from stt_codegen.sampling.plant import Bounds
from stt_codegen.sampling.setting import Law, Setting, back, law_of
from stt_codegen.sampling.windows import OUT, Windows, refined_windows
from stt_codegen.task import Task

Array = npt.NDArray[Any]
ROUNDINGS = (
    8  # of a distance a = (v - L') + lambda (x - L), each of half a unit in the last place of what is at most Z + 2 lambda W
)

BEYOND = Fraction(101, 100)  # times the age that is asked for: so old a sample is known, where its error depends on it


@dataclass(frozen=True, kw_only=True)
class Extent:
    """By window, the last from t_c on, and component (W + 1, n), rounded outwards: least and largest Z, largest W, the largest of
    L'', -L'', R'', -R'' and |c''|, of lambda^2 W + L'' and lambda^2 W - R''; and the largest |L'| and |R'|."""

    narrow: Array
    wide: Array
    width: Array
    bends: Array  # (4, W + 1, n)
    middle: Array
    press: Array  # (2, W + 1, n)
    rate: Array


def extent(design: RefinedDesign, numbers: Numbers = DOUBLES) -> Extent:
    """Exact but for the conversion to doubles, which is rounded outwards."""
    edges, press = filtered_edges(design), demanded_accelerations(design)
    z = edges.coefficients[:, :, UPPER] - edges.coefficients[:, :, LOWER]
    bezier = design.bezier()
    w = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    turn = 6 * np.diff(bezier, n=2, axis=3)
    bend_unit = design.unit * (Fraction(design.segments) / design.prescribed_time) ** 2
    rate_unit = design.unit * Fraction(design.segments) / design.prescribed_time
    up = numbers.multiples_above

    def held(values: Array, last: Array) -> Array:
        return np.concatenate([values, last[None] if design.seam is None else values[design.seam : design.seam + 1]])

    low, high = turn[:, :, LOWER], turn[:, :, UPPER]
    four = [up(v.max(axis=-1), bend_unit) for v in (low, -low, high, -high)]
    lower, upper = press.coefficients[:, :, LOWER], -press.coefficients[:, :, UPPER]
    still = up(0 * w[-1, :, 3], design.unit)
    return Extent(
        narrow=-held(up(-z.min(axis=-1), edges.unit), up(-z[-1, :, 3], edges.unit)),
        wide=held(up(z.max(axis=-1), edges.unit), up(z[-1, :, 3], edges.unit)),
        width=held(up(w.max(axis=-1), design.unit), up(w[-1, :, 3], design.unit)),
        bends=np.stack([held(v, still) for v in four]),
        middle=held(up(np.abs(low + high).max(axis=-1), bend_unit) / 2, still),
        press=np.stack([held(up(v.max(axis=-1), press.unit), up(v[-1, :, 3], press.unit)) for v in (lower, upper)]),
        rate=held(up(3 * np.abs(np.diff(bezier, axis=3)).max(axis=(2, 3)), rate_unit), still),
    )


@dataclass(frozen=True)
class Motion:
    """What the sharp statement takes of a filtered tube, by window and component (W + 1, n). wide: the largest Z of this window;
    seen: the least Z of it and of the one before. at_edge (P_x), aging (P_d), from_middle (P_m): what the tube's motion adds to
    |f + w| in the statement's three places, in this window and the one before."""

    wide: Array
    seen: Array
    at_edge: Array
    aging: Array
    from_middle: Array


def inertial_motion(found: Extent, lambdas: Sequence[Fraction], numbers: Numbers = DOUBLES) -> Motion:
    """The formulas that the docstring of this file has."""
    value = np.array([numbers.of(v) for v in lambdas])
    up_l, down_l, up_r, down_r = found.bends  # largest L'', -L'', R'', -R''
    z, w = value * found.wide, value * value * found.width
    at_edge = np.maximum.reduce([found.press[0], found.press[1], up_r, down_l])
    aging = np.maximum.reduce([z + down_l, w + down_r, z + up_r, w + up_l, 0 * z])
    both = (back(v, np.maximum) for v in (at_edge, aging, found.middle + (z + w) / 2))
    return Motion(found.wide, back(found.narrow, np.minimum), *both)


def inertial_windows(design: RefinedDesign, found: Extent, numbers: Numbers = DOUBLES) -> Windows:
    """The windows of the filtered tube; low, high and start are of x."""
    still = 0 * found.narrow
    return replace(refined_windows(design, numbers), narrow=found.narrow, wide=found.wide, speed=still, widening=still)


def speeds(design: RefinedDesign) -> tuple[Array, Array]:
    """By window and component, between which v is: z between the filtered edges, x between its own, less lambda x."""
    found, windows = extent(design), refined_windows(design)
    value = np.array([float(v) for v in design.filter])
    room = found.rate + value * (windows.high - windows.low)
    return -room * (1 + OUT), room * (1 + OUT)


def difference_error(
    task: Task,
    noise: Fraction,
    fastest: Sequence[Fraction],
    width: Sequence[Fraction],
    filter_: Sequence[Fraction],
    more: Fraction = Fraction(1),
) -> tuple[Fraction, ...]:
    """What a velocity by differences is wrong by at most, by component, noise bounding the error of x, for samples at most `more`
    times control.period apart. Between samples tau apart it is the mean of v, which turns by at most A = F + G u_max + .. a
    second: A tau/2 (the lemma `filtered.differences`). Twice the error of x over the shortest tau, and four roundings of the
    quotient, |v| being at most `fastest` + lambda W, join it."""
    assert task.u_max is not None
    roundoff, found = Fraction(FORMATS[task.emit.scalar].roundoff), []
    size = max(abs(v) for edge in (task.state_space.lower, task.state_space.upper) for v in edge)
    limit = [round_down(v, task.emit.scalar) for v in task.u_max]
    for i, bounds in enumerate(task.plant_bounds):
        turn = bounds.force + bounds.g_max * limit[i] + bounds.cross * (sum(limit, Fraction(0)) - limit[i])
        apart = turn * more * task.sampling_period / 2 + 2 * (noise + roundoff * (size + noise)) / task.shortest_period
        found.append(apart + 4 * roundoff * (fastest[i] + filter_[i] * width[i] + apart))
    return tuple(found)


def difference_age(task: Task, latency: Any, more: Fraction, numbers: Numbers = DOUBLES) -> Any:
    """To which age of a sample a velocity by differences has that error, seconds: samples `more` times the period apart, whose u
    acts `latency` later; without end where v is measured."""
    return numbers.of(task.sampling_period * more) + latency if task.uses_differences else math.inf


def inertial_law(
    task: Task,
    found: Extent,
    lambdas: Sequence[Fraction],
    errors: tuple[Sequence[Fraction], Sequence[Fraction]],
    noise: tuple[Any, Any],
    late: Any = 0.0,
    *,
    more: Fraction = BEYOND,
    numbers: Numbers = DOUBLES,
) -> Law:
    """The law of a task of order 2: what it sees of a and b is wrong by the arithmetic of edges and rates (`errors`), by the
    noise of x and v, by x and v rounded to the scalar, and by the roundings of a and b. more: as in `difference_age`."""
    edge, rate = errors
    roundoff = numbers.of(FORMATS[task.emit.scalar].roundoff)
    value = np.array([numbers.of(v) for v in lambdas])
    wrong = np.array([numbers.of(2 * (r + v * e)) for e, r, v in zip(edge, rate, lambdas, strict=True)])
    size = numbers.of(max(abs(v) for side in (task.state_space.lower, task.state_space.upper) for v in side))
    fastest, width, wide = (v.max(axis=0) for v in (found.rate, found.width, found.wide))
    of_v: Any = noise[1]
    if task.uses_differences:
        fast, far = ([Fraction(v) for v in values.tolist()] for values in (fastest, width))
        error = difference_error(task, Fraction(noise[0]), fast, far, lambdas, more)
        of_v = of_v + numbers.outward(np.array([numbers.of(v) for v in error]), OUT)
    rounded = roundoff * (value * size + (fastest + value * width) + ROUNDINGS * (wide + 2 * value * width))
    shift = wrong + of_v + value * noise[0] + rounded
    return replace(law_of(task, edge, 0, late, numbers), shift=numbers.outward(shift, 1e-9))


def inertial_setting(design: RefinedDesign, found: Extent, plant: Sequence[Bounds], law: Law, start: Array) -> Setting:
    """`plant`: bounds on accelerations for every window, over it and the one before."""
    numbers = law.numbers
    force, motion = np.array([p.push for p in plant]), inertial_motion(found, design.filter, numbers)
    pushes = (motion.at_edge, motion.aging, motion.from_middle)
    at_edge, aging, from_middle = (numbers.outward(force + v, OUT) for v in pushes)
    return Setting(
        windows=inertial_windows(design, found, numbers),
        law=law,
        least=np.array([p.least for p in plant]),
        most=np.array([p.most for p in plant]),
        cross=np.array([p.cross for p in plant]),
        push=at_edge,
        narrow=motion.seen,
        definite=np.array([p.definite for p in plant]),
        norm=np.array([p.norm for p in plant]),
        push_norm=np.full(len(force), np.inf),  # the statement for any g is about order 1
        start=start,
        drift=aging,
        middle=from_middle,
    )


def start_reach(task: Task, design: RefinedDesign, state: Sequence[float] | None = None, numbers: Numbers = DOUBLES) -> Array:
    """What |ln(a/b)| is at most at the start, as a reach, rounded up: for every x in the share of gamma(0), or one state, which
    may have its own speeds behind x, and every speed within initial_set.speed, at rest where there is none; infinite where
    v + lambda x may be outside. The bound on e counts for x at 0 too."""
    found = []
    for i, (low_rate, high_rate) in enumerate(slopes_at_start(design)):
        low, high = (int(v) * design.unit for v in design.bezier()[0, i, :, 0])
        half, middle = task.initial_set.share * (high - low) / 2, (low + high) / 2
        places = [middle - half, middle + half] if state is None else [Fraction(float(state[i]))]
        shares = [abs(2 * x - low - high) / (high - low) for x in places]
        reaches = [numbers.reach_of_share(v) if v < 1 else math.inf for v in shares]
        has_speed = state is not None and len(state) > task.dimension
        speeds_ = [Fraction(float(state[task.dimension + i]))] if has_speed else [task.start_speed[i], -task.start_speed[i]]  # type: ignore[index]
        for x, v in itertools.product(places, speeds_):
            a, b = v - low_rate + design.filter[i] * (x - low), high_rate - v + design.filter[i] * (high - x)
            is_inside = a > 0 and b > 0 and low < x < high
            reaches.append(numbers.reach_of_ratio(a / b) if is_inside else math.inf)
        found.append(numbers.outward(max(reaches), 1e-9))
    return np.array(found)
