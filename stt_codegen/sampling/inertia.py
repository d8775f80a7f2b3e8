"""A loop of order 2 as the sharp statement sees it: what is held is v + lambda x in the filtered tube, so widths are
W' + lambda W, and what pushes is not the same in the statement's three places. With F = |f + w|, edges L and R, middle c,
W = R - L and Z = W' + lambda W:

    at an edge            P_x = F + max(lambda^2 W - R'', lambda^2 W + L'', R'', -L'')
    while a sample ages   P_d = F + max(lambda Z - L'', lambda^2 W - R'', lambda Z + R'', lambda^2 W + L'', 0)
    from the middle       P_m = F + |c''| + lambda (Z + lambda W)/2
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import LOWER, UPPER, RefinedDesign
from stt_codegen.designs.filtered import filtered, pressed, slopes_at_start
from stt_codegen.program.number import FORMATS, round_down
from stt_codegen.sampling.plant import Bounds
from stt_codegen.sampling.setting import Law, Setting, back, law_of
from stt_codegen.sampling.windows import OUT, Windows, refined_windows
from stt_codegen.task import Task

Array = npt.NDArray[Any]
ROUNDINGS = (
    8  # of a distance a = (v - L') + lambda (x - L), each of half a unit in the last place of what is at most Z + 2 lambda W
)

BEYOND = Fraction(101, 100)  # times the age that is asked for: so old a sample is known, where its error depends on it


@dataclass(frozen=True)
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


def extent(design: RefinedDesign) -> Extent:
    """Exact but for the conversion to doubles, which is rounded outwards."""
    edges, press = filtered(design), pressed(design)
    z = edges.coefficients[:, :, UPPER] - edges.coefficients[:, :, LOWER]
    bezier = design.bezier()
    w = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    turn = 6 * np.diff(bezier, n=2, axis=3)
    bend_unit = design.unit * (Fraction(design.segments) / design.prescribed_time) ** 2
    rate_unit = design.unit * Fraction(design.segments) / design.prescribed_time

    def up(values: Array, unit: Fraction) -> Array:
        found = np.vectorize(lambda v: math.nextafter(float(int(v) * unit), math.inf), otypes=[float])(values)
        return np.asarray(found)

    def held(values: Array, last: Array) -> Array:
        return np.concatenate([values, last[None] if design.seam is None else values[design.seam : design.seam + 1]])

    low, high = turn[:, :, LOWER], turn[:, :, UPPER]
    four = [up(np.maximum(v.max(axis=-1), 0), bend_unit) for v in (low, -low, high, -high)]
    still = np.zeros(design.dimension)
    lower, upper = press.coefficients[:, :, LOWER], -press.coefficients[:, :, UPPER]
    return Extent(
        -held(up(-z.min(axis=-1), edges.unit), up(-z[-1, :, 3], edges.unit)),
        held(up(z.max(axis=-1), edges.unit), up(z[-1, :, 3], edges.unit)),
        held(up(w.max(axis=-1), design.unit), up(w[-1, :, 3], design.unit)),
        np.stack([held(v, still) for v in four]),
        held(up(np.abs(low + high).max(axis=-1), bend_unit) / 2, still),
        np.stack([held(up(v.max(axis=-1), press.unit), up(v[-1, :, 3], press.unit)) for v in (lower, upper)]),
        held(up(3 * np.abs(np.diff(bezier, axis=3)).max(axis=(2, 3)), rate_unit), still),
    )


def inertial_windows(design: RefinedDesign, found: Extent) -> Windows:
    """The windows of the filtered tube; low, high and start are of x."""
    still = np.zeros_like(found.narrow)
    return replace(refined_windows(design), narrow=found.narrow, wide=found.wide, speed=still, widening=still)


def speeds(design: RefinedDesign) -> tuple[Array, Array]:
    """By window and component, between which v is: z between the filtered edges, x between its own, less lambda x."""
    found, windows = extent(design), refined_windows(design)
    value = np.array([float(v) for v in design.filter])
    room = found.rate + value * (windows.high - windows.low)
    return -room * OUT, room * OUT


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


def difference_age(task: Task, latency: float) -> float:
    """To which age of a sample a velocity by differences has that error, seconds: samples BEYOND times the period apart, whose u
    acts `latency` later; without end where v is measured."""
    return float(task.sampling_period * BEYOND) + latency if task.differs else math.inf


def inertial_law(
    task: Task,
    design: RefinedDesign,
    edge: Sequence[Fraction],
    rate: Sequence[Fraction],
    noise: tuple[float, float],
    late: float = 0.0,
) -> Law:
    """The law of a task of order 2: what it sees of a and b is wrong by the arithmetic of edges and rates, by the noise of x and
    v, by x and v rounded to the scalar, and by the roundings of a and b themselves."""
    found, roundoff = extent(design), float(FORMATS[task.emit.scalar].roundoff)
    value = np.array([float(v) for v in design.filter])
    wrong = np.array([float(2 * (r + v * e)) for e, r, v in zip(edge, rate, design.filter, strict=True)])
    size = float(max(abs(v) for side in (task.state_space.lower, task.state_space.upper) for v in side))
    fastest = (found.rate + value * found.width).max(axis=0)
    apart = (found.wide + 2 * value * found.width).max(axis=0)
    of_v: Any = noise[1]
    if task.differs:
        fast, far = ([Fraction(v) for v in values.max(axis=0).tolist()] for values in (found.rate, found.width))
        of_v = np.array([float(v) for v in difference_error(task, Fraction(noise[0]), fast, far, design.filter, BEYOND)]) * OUT
    shift = wrong + of_v + value * noise[0] + roundoff * (value * size + fastest + ROUNDINGS * apart)
    return replace(law_of(task, edge, 0.0, late), shift=shift * (1 + 1e-9))


def inertial_setting(design: RefinedDesign, plant: Sequence[Bounds], law: Law, start: Array) -> Setting:
    """`plant`: bounds on accelerations for every window, over it and the one before."""
    found, value = extent(design), np.array([float(v) for v in design.filter])
    force = np.array([p.push for p in plant])
    up_l, down_l, up_r, down_r = found.bends  # largest L'', -L'', R'', -R''
    z, w = value * found.wide, value * value * found.width
    exit_ = np.maximum.reduce([found.press[0], found.press[1], up_r, down_l])
    drift = np.maximum.reduce([z + down_l, w + down_r, z + up_r, w + up_l])
    middle = found.middle + (z + w) / 2
    pushes = [(force + back(v, np.maximum)) * OUT for v in (exit_, drift, middle)]
    nothing = np.full(len(force), np.inf)
    return Setting(
        inertial_windows(design, found),
        law,
        np.array([p.least for p in plant]),
        np.array([p.most for p in plant]),
        np.array([p.cross for p in plant]),
        pushes[0],
        back(found.narrow, np.minimum),
        np.array([p.definite for p in plant]),
        np.array([p.norm for p in plant]),
        nothing,  # the statement for any g is about order 1
        start,
        pushes[1],
        pushes[2],
    )


def eps_of_starts(task: Task, design: RefinedDesign, state: Sequence[float] | None = None) -> Array:
    """What |ln(a/b)| is at most at the start, rounded up: for every x in the share of gamma(0), or one state, which may have its
    own speeds behind x, and every speed within initial_set.speed, at rest where there is none; infinite where v + lambda x may be
    outside."""
    found = []
    for i, (low_rate, high_rate) in enumerate(slopes_at_start(design)):
        low, high = (int(v) * design.unit for v in design.bezier()[0, i, :, 0])
        half, middle = task.initial_set.share * (high - low) / 2, (low + high) / 2
        places = [middle - half, middle + half] if state is None else [Fraction(float(state[i]))]
        shares = [abs(2 * x - low - high) / (high - low) for x in places]
        most = max(2 * math.atanh(float(v)) * (1 + 1e-9) if v < 1 else math.inf for v in shares)  # e(0) of x counts too
        for x in places:
            own = state is not None and len(state) > task.dimension
            for v in {Fraction(float(state[task.dimension + i]))} if own else {task.start_speed[i], -task.start_speed[i]}:  # type: ignore[index]
                a, b = v - low_rate + design.filter[i] * (x - low), high_rate - v + design.filter[i] * (high - x)
                inside = a > 0 and b > 0 and low < x < high
                most = max(most, abs(math.log(a / b)) * (1 + 1e-9) if inside else math.inf)
        found.append(most)
    return np.array(found)
