"""The kernels of a controller in integers: straight lines of shifts, sums and products of 16 bits.

    segment      tick -> row of the table, and the position s in the segment, in 2^-16 of it
    weights      of a cubic B-spline at s, for the steps between its control points
    rates        weights of the same steps for the rate of an edge, for order 2
    edge_at      an edge of the tube: a control point and the weighted steps about it; for order 2 with its rate
    curve        1/d or H at a number whose first bit is shifted to 2^30, by a table of quadratics
    input_size   |u| by (13)

With e the normalized error, clamped to e_max, and d the width, (13) is

    |u| = k/d |e| H,    H = 8 atanh(e)/(e (1 - e^2)) = 4 ln((2 - y)/y)/((1 - y) y (2 - y)),    y = 1 - |e|.

H is smooth and at least 8. So u has a relative error only, in the middle of the tube too, where a logarithm of a quotient has an
absolute error. 1/d and H come from quadratics (curves.py).

frame.py calls these kernels; integer_errors.py bounds their errors. A number "in 2^-k" is an integer that counts units of 2^-k.
Functions named `write_..` append statements to a block and return the variables that hold the results; strings that they pass
are names in emitted code. Of the operations (program/operations.py), `high_product` is a product over 2^16, rounded down;
`product` is one of 16 by 16 bits; `ishl` and `ishr` shift up and down, the latter rounding down; `low_bits` masks bits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise

from stt_codegen.controller.integers.curves import SLOPE_BITS
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import INT, TICK, Block, Const, Kernel, Load, Operand, Var, integer

HALF_WORD = 1 << 16  # numbers of 16 bits are below it
OUTER_WEIGHT_BITS, MIDDLE_WEIGHT_BITS = 15, 14  # of the fractions of weights: the outer two are at most 1, the middle one 4
POWER_BITS = 28  # of the fractions of powers of s, before they are rounded to weights


@dataclass(frozen=True)
class TickClock:
    """How ticks become segments: `scale` is a tick in 2^-(bits + 16) of a segment.

    bits: of the fraction of time in segments. end_tick: the first tick that is not before t_c."""

    scale: int
    bits: int
    end_tick: int


def choose_clock(design: RefinedDesign, period: Fraction) -> TickClock:
    """Choose the number of bits for ticks of `period` seconds: 16 where the length of a tick is then accurate enough.

    s has 16 bits, and a shift by half a word costs nothing. Raises `BadInput` where 32 bits do not hold the time of a mission."""
    tick_length = period * design.segments / design.prescribed_time  # segments
    end_tick = math.ceil(design.prescribed_time / period)
    for bits in (16, *range(30 - design.segments.bit_length(), 16, -1)):
        scale = tick_length * 2 ** (bits + 16)
        fits = end_tick < 2**31 and scale < 2**31 and scale * (end_tick / HALF_WORD + 1) < 2**31
        is_accurate = end_tick < 2 ** (bits - 2)
        if fits and is_accurate:
            return TickClock(round(scale), bits, end_tick)
    if tick_length >= Fraction(1, 2):
        half = design.prescribed_time / design.segments / 2
        raise BadInput(
            f"emit.tick_period: {float(period):g} s is not below half a segment of the tube, {float(half):g} s; use less"
        )
    cause = f"{float(period):g} s over {float(design.prescribed_time):g} s and {design.segments} segments"
    raise BadInput(f"emit.tick_period: {cause} makes integers beyond 31 bits; use a longer one")


def _kernel(name: str, inputs: tuple[Var, ...], block: Block, outputs: Mapping[str, Operand], *doc: str) -> Kernel:
    """Build a kernel of the block's statements; outputs by name."""
    body = tuple(block.statements)
    return Kernel(name, inputs, body, tuple(outputs.values()), tuple(outputs), doc=doc)  # type: ignore[arg-type]


def _integer_variables(*names: str) -> tuple[Var, ...]:
    return tuple(Var(name, INT) for name in names)


def write_at_least(block: Block, label: str, name: str, value: Operand, low: int) -> Var:
    """Write statements for the larger one of the value and `low`, called `name`; the comparison is called <label>_over."""
    return block.select(name, block.op(f"{label}_over", "ilt", integer(low), value), value, integer(low))


def write_at_most(block: Block, label: str, name: str, value: Operand, high: Operand) -> Var:
    """Write statements for the smaller one of the value and `high`, called `name`; the comparison is called <label>_under."""
    return block.select(name, block.op(f"{label}_under", "ilt", value, high), value, high)


def _write_rounded_shift(block: Block, label: str, name: str, value: Operand, bits: int) -> Var:
    """Write statements for the value over 2^bits, rounded to the nearest integer, called `name`; the sum is <label>_and_half."""
    return block.op(name, "ishr", block.op(f"{label}_and_half", "iadd", value, integer(1 << (bits - 1))), integer(bits))


def build_integer_segment_kernel(clock: TickClock, design: RefinedDesign) -> Kernel:
    """Build the kernel from a tick to (table index of the segment's first row, s in 2^-16)."""
    tick = Var("tick", TICK)
    b = Block({"tick", "row", "s"})
    end_tick = Const(clock.end_tick, TICK)
    count = b.op("count", "int", b.select("held", b.op("running", "tlt", tick, end_tick), tick, end_tick))
    count_low = b.op("count_low", "low_bits", count, integer(HALF_WORD - 1))
    if clock.end_tick < HALF_WORD:
        passed = b.op("passed", "high_product", integer(clock.scale), count_low)
    else:
        passed_low = b.op("passed_low", "high_product", integer(clock.scale), count_low)
        passed_high = b.op("passed_high", "imul", b.op("count_high", "ishr", count, integer(16)), integer(clock.scale))
        passed = b.op("passed", "iadd", passed_low, passed_high)
    end = integer((design.segments << clock.bits) - 1)
    spline_time = b.select("place", b.op("early", "ilt", passed, end), passed, end)  # in 2^-bits of a segment
    segment_index = b.op("segment", "ishr", spline_time, integer(clock.bits))
    in_16_bits = b.op("fine", "ishr", spline_time, integer(clock.bits - 16)) if clock.bits > 16 else spline_time
    s = b.op("share", "low_bits", in_16_bits, integer(HALF_WORD - 1))
    row = b.op("first", "imul", segment_index, integer(2 * design.dimension))
    return _kernel("segment", (tick,), b, {"row": row, "s": s}, "Table index of the segment at a tick, and s in 2^-16 of it.")


@cache
def build_weights_kernel() -> Kernel:
    """Build the kernel from s to the weights of the three steps: (1 - s)^3, 3 s + 3 s^2 - 2 s^3 and s^3.

    Each clamp takes away the rounding of its argument, which is never below 0 in exact arithmetic."""
    (s,) = _integer_variables("s")
    b = Block({"s", "w0", "w1", "w2"})
    s_fine = b.op("s_fine", "ishl", s, integer(POWER_BITS - 16))
    square = b.op("square", "high_product", s_fine, s)
    cube = b.op("cube", "high_product", square, s)
    three_sums = b.op("three_sums", "imul", b.op("sum", "iadd", s_fine, square), integer(3))
    middle = b.op("middle", "isub", three_sums, b.op("two_cubes", "imul", cube, integer(2)))
    difference = write_at_least(b, "difference", "difference_raised", b.op("difference", "isub", s_fine, square), 0)
    three_differences = b.op("three_differences", "imul", difference, integer(3))
    # (1 - s)^3 = 1 - 3 (s - s^2) - s^3
    first = b.op("first", "isub", b.op("first_and_cube", "isub", integer(1 << POWER_BITS), three_differences), cube)
    middle_raised = write_at_least(b, "middle", "middle_raised", middle, 0)
    middle_rounded = _write_rounded_shift(b, "middle", "middle_rounded", middle_raised, POWER_BITS - MIDDLE_WEIGHT_BITS)
    first_raised, outer_shift = write_at_least(b, "first", "first_raised", first, 0), POWER_BITS - OUTER_WEIGHT_BITS
    outputs = {
        "w0": _write_rounded_shift(b, "first", "first_weight", first_raised, outer_shift),
        "w1": write_at_most(b, "middle", "middle_weight", middle_rounded, integer(HALF_WORD - 1)),
        "w2": _write_rounded_shift(b, "last", "last_weight", cube, outer_shift),
    }
    doc = f"At s: (1 - s)^3 and s^3 in 2^-{OUTER_WEIGHT_BITS}, 3 s + 3 s^2 - 2 s^3 in 2^-{MIDDLE_WEIGHT_BITS}."
    return _kernel("weights", (s,), b, outputs, doc)


@dataclass(frozen=True)
class RateScale:
    """How weights of steps become rates of edges.

    weight_bits: of the fraction of the weights, which are per second. mantissa 2^-shift: the number of segments per second."""

    weight_bits: int
    mantissa: int
    shift: int

    @property
    def product_shift(self) -> int:
        """The shift of a power's high product with the mantissa down to units of a weight."""
        return POWER_BITS - 16 + self.shift - self.weight_bits


def choose_rate_scale(design: RefinedDesign) -> RateScale:
    """Choose as many bits for the weights as 16-bit numbers hold: the outer two are at most 3 segments per second each.

    Raises `BadInput` for a tube that is too fast for that."""
    segments_per_second = Fraction(design.segments) / design.prescribed_time
    weight_bits = math.floor(math.log2((HALF_WORD - 2) / (6 * segments_per_second)))
    if weight_bits < 0:
        raise BadInput("prescribed_time: is so short that integers of 16 bits do not hold the tube's rates; raise it")
    shift = 16 - math.frexp(float(segments_per_second))[1]
    mantissa = math.floor(segments_per_second * Fraction(2) ** shift)
    return RateScale(weight_bits, min(mantissa, HALF_WORD - 1), shift)


def build_rate_weights_kernel(rate_scale: RateScale) -> Kernel:
    """Build the kernel from s to the weights of the three steps for the rate of an edge, all at least 0."""
    (s,) = _integer_variables("s")
    b = Block({"s", "r0", "r1", "r2"})
    fixed_one = integer(1 << POWER_BITS)
    s_fine = b.op("s_fine", "ishl", s, integer(POWER_BITS - 16))
    square = b.op("square", "high_product", s_fine, s)
    nonnegative = write_at_least(b, "difference", "difference_raised", b.op("difference", "isub", s_fine, square), 0)
    quarter = integer(1 << (POWER_BITS - 2))
    difference = write_at_most(b, "difference", "difference_limited", nonnegative, quarter)  # s - s^2, at most 1/4
    complement = b.op("complement", "isub", fixed_one, s_fine)
    first = b.op("first", "isub", complement, difference)  # (1 - s)^2 = 1 - s - (s - s^2)
    first_raised = write_at_least(b, "first", "first_raised", first, 0)
    middle = b.op("middle", "iadd", fixed_one, b.op("two_differences", "imul", difference, integer(2)))

    def write_weight(label: str, value: Operand) -> Var:
        """Write statements for 3 times the value times the segments per second, in 2^-weight_bits."""
        tripled = b.op(f"{label}_tripled", "imul", value, integer(3))
        per_second = b.op(f"{label}_per_second", "high_product", tripled, integer(rate_scale.mantissa))
        return _write_rounded_shift(b, label, f"{label}_weight", per_second, rate_scale.product_shift)

    outputs = {
        "r0": write_weight("first", first_raised),
        "r1": write_weight("middle", middle),
        "r2": write_weight("last", square),
    }
    doc = f"At s, in 2^-{rate_scale.weight_bits} a second: 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2 times the segments in a second."
    return _kernel("rates", (s,), b, outputs, doc)


def _write_steps(b: Block, n: int, first_index: Var) -> tuple[Var, tuple[Var, ...]]:
    """Write statements for the second of an edge's four control points, and for the three steps between them.

    first_index: table index of the first control point, for n dimensions."""
    control_points = []
    for j in range(4):
        index = b.op(f"at_{j}", "iadd", first_index, integer(2 * n * j)) if j else first_index
        control_points.append(b.let(f"q{j}", Load("coefficients", index, INT)))
    differences = [b.op(f"difference_{k}", "isub", after, before) for k, (before, after) in enumerate(pairwise(control_points))]
    return control_points[1], tuple(b.op(f"d{k}", "short", v) for k, v in enumerate(differences))


def _write_edge(b: Block, second_point: Var, steps: tuple[Var, ...], weights: tuple[Var, ...]) -> Var:
    """Write statements for 6 q1 + d1 + w1 d1 + w2 d2 - w0 d0: an edge from the second control point q1 and the steps d."""
    (d0, d1, d2), (w0, w1, w2) = steps, weights
    base = b.op("base", "iadd", b.op("six_q1", "imul", second_point, integer(6)), d1)
    middle = b.op("middle_part", "ishr", b.op("d1_weighted", "product", d1, w1), integer(MIDDLE_WEIGHT_BITS))
    outer = b.op("outer", "isub", b.op("d2_weighted", "product", d2, w2), b.op("d0_weighted", "product", d0, w0))
    outer_part = b.op("outer_part", "ishr", outer, integer(OUTER_WEIGHT_BITS))
    return b.op("value", "iadd", b.op("base_and_middle", "iadd", base, middle), outer_part)


@cache
def build_edge_kernel(n: int) -> Kernel:
    """Build the kernel of an edge of order 1, for n dimensions; `at` is the table index of its first control point."""
    at, *weights = inputs = _integer_variables("at", "w0", "w1", "w2")
    b = Block({v.name for v in inputs})
    edge = _write_edge(b, *_write_steps(b, n, at), tuple(weights))
    doc = "An edge of the tube: a control point, and the steps about it by their weights."
    return _kernel("edge_at", inputs, b, {"edge": edge}, doc)


def build_edge_and_rate_kernel(n: int, rate_scale: RateScale) -> Kernel:
    """Build the kernel of an edge and its rate, for order 2 and n dimensions."""
    at, w0, w1, w2, r0, r1, r2 = inputs = _integer_variables("at", "w0", "w1", "w2", "r0", "r1", "r2")
    b = Block({v.name for v in inputs} | {"edge", "rate"})
    second_point, steps = _write_steps(b, n, at)
    edge = _write_edge(b, second_point, steps, (w0, w1, w2))
    weight_bits = integer(rate_scale.weight_bits)
    middle = b.op("middle_rate", "ishr", b.op("d1_per_second", "product", steps[1], r1), weight_bits)
    outer = b.op(
        "outer_sum", "iadd", b.op("d0_per_second", "product", steps[0], r0), b.op("d2_per_second", "product", steps[2], r2)
    )
    rate = b.op("value_rate", "iadd", middle, b.op("outer_rate", "ishr", outer, weight_bits))
    doc = "An edge of the tube, and its rate in units a second, by the steps about it."
    return _kernel("edge_at", inputs, b, {"edge": edge, "rate": rate}, doc)


@cache
def build_curve_kernel() -> Kernel:
    """Build the kernel of the quadratic of one table row at t, in 2^-16 of the row's piece (curves.py)."""
    row, t = _integer_variables("row", "t")
    b = Block({"row", "t"})
    level, slope, bend = (b.let(name, Load(f"{name}s", row, INT)) for name in ("level", "slope", "bend"))
    bend_part = b.op("bend_part", "ishr", b.op("bend_t", "product", bend, t), integer(16))
    mean_slope = b.op("mean_slope", "isub", slope, bend_part)
    fall = b.op("fall", "ishr", b.op("slope_t", "product", mean_slope, t), integer(16 + SLOPE_BITS))
    # The mask changes no value: it tells the ranges that the value has 16 bits.
    value = b.op("value", "low_bits", b.op("difference", "isub", level, fall), integer(HALF_WORD - 1))
    doc = "The quadratic of a row, level - (slope - bend t) t, at t in 2^-16."
    return _kernel("curve", (row, t), b, {"value": value}, doc)


def write_curve_position(block: Block, label: str, value: Operand, piece_bits: int, first_row: Operand) -> tuple[Var, Var]:
    """Write statements for the row of the curves' tables of a value in [2^30, 2^31), and for its position in the piece, in 2^-16.

    piece_bits: so many bits after the first select the piece. first_row: the row of the value 2^30."""
    bits = block.op(f"{label}_bits", "ishr", value, integer(30 - piece_bits))
    mask = integer((1 << piece_bits) - 1)
    if first_row == integer(0):
        row = block.op(f"{label}_row", "low_bits", bits, mask)
    else:
        row = block.op(f"{label}_row", "iadd", block.op(f"{label}_piece", "low_bits", bits, mask), first_row)
    tail = block.op(f"{label}_tail", "ishr", value, integer(14 - piece_bits))
    return row, block.op(f"{label}_t", "low_bits", tail, integer(HALF_WORD - 1))


@cache
def build_input_size_kernel() -> Kernel:
    """Build the kernel of |u|: |e| times H, 1/d and the gain's mantissa, shifted down to units of u, at most `limit`."""
    names = ("e", "h", "reciprocal", "gain", "shift", "limit")
    e, h, reciprocal, gain, shift, limit = inputs = _integer_variables(*names)
    b = Block({*names})
    over_width = b.op("over_width", "high_product", b.op("e_times_h", "high_product", e, h), reciprocal)
    unlimited = b.op("unlimited", "ishr", b.op("unshifted", "high_product", over_width, gain), shift)
    size = write_at_most(b, "limit", "size", unlimited, limit)
    return _kernel("input_size", inputs, b, {"size": size}, "|u|: gain e H/d, at most `limit`.")
