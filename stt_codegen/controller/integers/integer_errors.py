"""Exact bounds on the errors of a controller in integers: of its edges (P7), and of its law against (13).

*Edges.* The position of a tick is wrong by the roundings of the length of a tick and of its multiple, and by the bits that s
lacks. The kernel of the weights is the same in every controller, and s has 2^16 values; so the error of the weights is constant:
WEIGHT_ERROR. A step times its weight is exact, and two sums of these products are rounded down. The checker computes the same
bounds (checker/stt_checker/integers.py), because no claim may be a unit smaller than its bound. Tests derive WEIGHT_ERROR and the
bound of `rate_weight_error` from the kernels, for every s.

*Rates.* The powers of s that rates need are cut to 2^-28, and the number of segments in a second to a mantissa of 16 bits; each
product of both is rounded down, and then to the nearest unit of a weight.

*Law.* |u| = k/d |e| H(1 - |e|). Let the computed 1/d be (1 + a)/d with |a| <= A, and the computed H be (1 + b) H with |b| <= B
(curves.py). Then e and y have the factor 1 + a too, and are rounded down to 2^-30. 0 <= -y H'/H <= 3/2, for H = 8
(atanh(e)/e)/(1 - e^2): (1 - e) times the slope of the logarithm of 1/(1 - e^2) is 2 e/(1 + e) <= 1, and of atanh(e)/e it is at
most e/(1 + e) <= 1/2. So the total power of 1 + a is from 1/2 to 2. The gain's mantissa has 16 bits. The three products of
`input_size` are rounded down, each by less than a unit of a product that is at least |e| 2^26; that is less than 64 units of
2^-30 of e. The last shift rounds down by less than a unit of u.

fixed_program.py refuses a law that is not accurate enough by `require_accurate_law`; ../edge_errors.py returns the bounds of
edges.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from stt_codegen.controller.integers import curves
from stt_codegen.controller.integers.constants import (
    RECIPROCAL_ERROR_LIMIT,
    IntegerLaw,
    build_integer_law,
    law_width,
    smallest_widths,
)
from stt_codegen.controller.integers.integer_kernels import (
    HALF_WORD,
    RateScale,
    TickClock,
    choose_clock,
    choose_rate_scale,
)
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import LOWER, UPPER, RefinedDesign, filtered_edges
from stt_codegen.errors import BadInput
from stt_codegen.program.analyse import logarithm
from stt_codegen.sampling import ROUNDING
from stt_codegen.task import Task

WEIGHT_ERROR = Fraction(17178254800, 1 << 48)  # largest sum for any s: of the outer two weights of an edge, plus the middle one's
RATE_POWER_ERROR = Fraction(27, 1 << 30)  # 3 times 9/4 of 2^-28: of the powers of s in the weights of a rate, all three together
SMALLEST_Y_LIMIT = 1 << 14  # units of 2^-30: `smallest_y` is not below, so that y, rounded down by a unit, keeps its accuracy


def segment_position_error(clock: TickClock) -> Fraction:
    """Bound the error of a tick's position, in segments.

    The length of a tick is rounded, its multiple is cut off, the end is held a unit before t_c, and s is cut off."""
    unit = Fraction(1, 1 << clock.bits)
    s_error = Fraction(1, HALF_WORD) if clock.bits > 16 else 0
    return unit * clock.end_tick / HALF_WORD / 2 + 2 * unit + s_error


def edge_error(design: RefinedDesign, period: Fraction) -> tuple[Fraction, ...]:
    """Bound |edge at a tick - gamma(t)| by dimension, in the task's units, for a tick of `period` seconds."""
    largest_steps = np.abs(np.diff(design.integers(), axis=0)).max(axis=(0, 2))
    steepest_slopes = 3 * design.largest_steps().max(axis=0)  # per segment
    position_error = segment_position_error(choose_clock(design, period))
    slopes_and_steps = zip(steepest_slopes, largest_steps, strict=True)
    # 2 more units: two sums of products are rounded down
    return tuple((int(slope) * position_error + int(step) * WEIGHT_ERROR + 2) * design.unit for slope, step in slopes_and_steps)


def rate_weight_error(rate_scale: RateScale, segments_per_second: Fraction) -> Fraction:
    """Bound the sum of the errors of the three weights of a rate, in steps a second.

    The exact weights are 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2, with the sum 6, times `segments_per_second`. s^2 is cut by at
    most 9/16 of 2^-28, which makes the three powers wrong by 9/4 of 2^-28 in all."""
    emitted = rate_scale.mantissa / Fraction(2) ** rate_scale.shift
    rounding = (Fraction(1, 2) + Fraction(1, 1 << rate_scale.product_shift)) / (1 << rate_scale.weight_bits)
    return 6 * abs(emitted - segments_per_second) + RATE_POWER_ERROR * emitted + 3 * rounding


def rate_error(design: RefinedDesign, period: Fraction) -> tuple[Fraction, ...]:
    """Bound |rate at a tick - gammadot(t)| by dimension, in units per second, for a tick of `period` seconds.

    The bound has two units more: for a v that is rounded to its units, and a product with lambda that is rounded down."""
    segments_per_second = Fraction(design.segments) / design.prescribed_time
    largest_steps = np.abs(np.diff(design.integers(), axis=0)).max(axis=(0, 2))
    largest_bends = 6 * np.abs(np.diff(design.bezier(), n=2, axis=3)).max(axis=(0, 2, 3))  # per segment squared
    weight_error = rate_weight_error(choose_rate_scale(design), segments_per_second)
    position_error = segment_position_error(choose_clock(design, period)) * segments_per_second
    bends_and_steps = zip(largest_bends, largest_steps, strict=True)
    return tuple((int(bend) * position_error + int(step) * weight_error + 4) * design.unit for bend, step in bends_and_steps)


def largest_law_width(task: Task, design: RefinedDesign) -> Fraction:
    """Bound the width of the emitted tube that the law is about, in the task's units.

    For order 2 that is the filtered tube, in units per second."""
    if not design.filter:
        table = design.integers()
        return 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).max()) * design.unit + width_errors(task, design)[0]
    pieces = filtered_edges(design)
    largest = int((pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).max()) * pieces.unit
    return largest + width_errors(task, design)[1]


def width_errors(task: Task, design: RefinedDesign) -> tuple[Fraction, Fraction]:
    """Bound how far the arithmetic changes the width of the tube, in the task's units, and of the tube that the law is about.

    For order 2 the latter is the filtered tube, in units per second."""
    assert task.emit.tick_period is not None  # task/checks/field_checks.py
    errors = [2 * v for v in edge_error(design, task.emit.tick_period)]
    if not design.filter:
        return max(errors), max(errors)
    rate_errors = [2 * v for v in rate_error(design, task.emit.tick_period)]
    return max(errors), max(r + lambda_ * e for r, lambda_, e in zip(rate_errors, design.filter, errors, strict=True))


def require_accurate_law(task: Task, design: RefinedDesign) -> None:
    """Raise `BadInput` where the law's error is larger than the sampling conditions allow for.

    The same where the emitted tube may be narrower than the law calculates with."""
    law = build_integer_law(task, design)
    if law.smallest_y < SMALLEST_Y_LIMIT:
        raise BadInput("control.e_max: is so near 1 that integers of 32 bits do not hold 1 - e_max; lower it")
    for assumed, emitted in assumed_and_emitted_widths(task, design, law):
        if assumed > emitted:
            width, needed = decimal(max(emitted, Fraction(0)) * design.unit), decimal(assumed * design.unit)
            problem = f"the tube is {width} wide as it is emitted, and a law in integers needs {needed} here"
            raise BadInput(f'tube.min_width: {problem}; raise it, move the origin near the task, or use emit.scalar = "float"')
    allowed = Fraction(ROUNDING["fixed", "libm"])
    relative_error, epsilon_error = law_error(law, largest_law_width(task, design))
    # The clamps of e and y act beyond e_max, by the error of 1/width.
    clamp_error = (1 + RECIPROCAL_ERROR_LIMIT) / (1 - Fraction(3, 2) * RECIPROCAL_ERROR_LIMIT) - 1
    if (1 + relative_error) * (1 + clamp_error) - 1 > allowed or epsilon_error > allowed:
        raise BadInput(
            f"control.gain: {by_component(law.gain)} is so small beside u_max {by_component(law.u_max)} that integers of 32 bits "
            'lose u in the middle of the tube; raise it, lower u_max, or use emit.scalar = "float"'
        )


def assumed_and_emitted_widths(task: Task, design: RefinedDesign, law: IntegerLaw) -> list[tuple[int, Fraction]]:
    """Return pairs of the width that a function assumes at least, and the smallest width of the emitted tube, in units of x.

    For order 1 the pair of the law; for order 2 that of `margin` for x, then that of the law for v + lambda x."""
    widths = zip(smallest_widths(design), width_errors(task, design), strict=True)
    emitted = [(width - error) / design.unit for width, error in widths]
    if not design.filter:
        return [(law.smallest_width, emitted[0])]
    return [(law_width(smallest_widths(design)[0] / design.unit), emitted[0]), (law.smallest_width, emitted[1])]


def law_error(law: IntegerLaw, largest_width: Fraction) -> tuple[Fraction, Fraction]:
    """Bound the error of |u| against (13) on the emitted edges, where |u| is below u_max and |e| below e_max.

    The first bound is relative, the second one is an error of epsilon. largest_width: of the tube, in the task's units."""
    reciprocal_error, h_error = curves.relative_errors(law.octaves)
    a = reciprocal_error + Fraction(1, 1 << 17)  # RECIPROCAL_NUMERATOR is less than 2^46 by so much
    assert a <= RECIPROCAL_ERROR_LIMIT  # the clamps of e and y are placed for this limit
    # y is rounded down by less than a unit, which raises H by at most the power 3/2 of the ratio
    y_rounding = (1 + Fraction(1, law.smallest_y - 1)) ** 2
    relative_error = (1 + a) ** 2 * (1 + h_error) * (1 + Fraction(1, 1 << 16)) * y_rounding - 1
    u_unit = Fraction(1, 1 << law.u_bits) if law.u_bits >= 0 else Fraction(1 << -law.u_bits)
    shift_error = u_unit * largest_width / (4 * min(abs(k) for k in law.gain))  # xi is at least 4/d
    steepest = logarithm((1 + law.e_max) / (1 - law.e_max))[1] / law.e_max  # epsilon/e, which rises with e
    return relative_error, shift_error + 65 * steepest / 2**30
