"""The kernels of a controller in integers: straight lines of shifts, sums and products of 16 bits.

    segment   tick -> row of the table, and the place s in the segment, in 2^-16 of it
    weights   of a cubic B-spline at s, for the steps of its control points; rates, of its rate of change, for order 2
    edge      of the tube: a control point, and the steps about it by their weights; for order 2 with its rate
    curve     a function of a number that begins with a 1, by a table of quadratics
    push      |u| by (13)

With e the normalized error, held within e_max, and d the width, (13) is

    |u| = k/d |e| H,    H = 8 atanh(e)/(e (1 - e^2)) = 4 ln((2 - y)/y)/((1 - y) y (2 - y)),    y = 1 - |e|.

H is smooth and at least 8; so u has a relative error alone, about the middle too, where a logarithm of a quotient has an absolute
one. 1/d and H come from quadratics (curves.py) by the bits after the first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise

from stt_codegen.controller.integers.curves import SLOPE_BITS
from stt_codegen.controller.kernels import loaded
from stt_codegen.designs import LOWER, RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import INT, TICK, Block, Const, Kernel, Load, Operand, Var, integer

HALF_WORD = 1 << 16
WEIGHT_BITS, BEND_BITS = 15, 14  # of the weights of the outer steps, at most 1, and of the middle one, less 1 and at most 4
FINE = 28  # bits of powers of s, before they are rounded to weights


@dataclass(frozen=True)
class Clock:
    """Of ticks in segments. scale: a tick, in 2^-(bits + 16) of a segment; last: the first tick that is not before t_c."""

    scale: int
    bits: int
    last: int


def clock_of(design: RefinedDesign, period: Fraction) -> Clock:
    """With the 16 bits that s has where the length of a tick is then right enough: a half word is no shift. Raises `BadInput`
    where 32 bits do not hold the time of a mission."""
    step, last = period * design.segments / design.prescribed_time, math.ceil(design.prescribed_time / period)
    for bits in (16, *range(30 - design.segments.bit_length(), 16, -1)):
        scale = step * 2 ** (bits + 16)
        fits = last < 2**31 and scale < 2**31 and scale * (last / HALF_WORD + 1) < 2**31
        if fits and last < 2 ** (bits - 2):
            return Clock(round(scale), bits, last)
    if step >= Fraction(1, 2):
        half = design.prescribed_time / design.segments / 2
        raise BadInput(
            f"emit.tick_period: {float(period):g} s is not below half a segment of the tube, {float(half):g} s; use less"
        )
    took = f"{float(period):g} s over {float(design.prescribed_time):g} s and {design.segments} segments"
    raise BadInput(f"emit.tick_period: {took} makes integers beyond 31 bits; use a longer one")


def _kernel(name: str, inputs: tuple[Var, ...], block: Block, outputs: Mapping[str, Operand], *doc: str) -> Kernel:
    body = tuple(block.statements)
    return Kernel(name, inputs, body, tuple(outputs.values()), tuple(outputs), doc=doc)  # type: ignore[arg-type]


def _ints(*names: str) -> tuple[Var, ...]:
    return tuple(Var(name, INT) for name in names)


def at_least(b: Block, name: str, value: Operand, low: int) -> Var:
    """The value, or `low` where it is less."""
    return b.select(name, b.op(f"{name}_over", "ilt", integer(low), value), value, integer(low))


def at_most(b: Block, name: str, value: Operand, high: Operand) -> Var:
    """The value, or `high` where it is more."""
    return b.select(name, b.op(f"{name}_under", "ilt", value, high), value, high)


def segment_kernel(clock: Clock, design: RefinedDesign) -> Kernel:
    tick = Var("tick", TICK)
    b = Block({"tick", "row", "s"})
    last = Const(clock.last, TICK)
    count = b.op("count", "int", b.select("held", b.op("running", "tlt", tick, last), tick, last))
    passed = b.op("passed", "upper", integer(clock.scale), b.op("count_low", "low", count, integer(HALF_WORD - 1)))
    if clock.last >= HALF_WORD:
        high = b.op("passed_high", "imul", b.op("count_high", "ishr", count, integer(16)), integer(clock.scale))
        passed = b.op("passed_both", "iadd", passed, high)
    place = at_most(b, "place", passed, integer((design.segments << clock.bits) - 1))
    index = b.op("segment", "ishr", place, integer(clock.bits))
    fine = b.op("fine", "ishr", place, integer(clock.bits - 16)) if clock.bits > 16 else place
    s = b.op("share", "low", fine, integer(HALF_WORD - 1))
    row = b.op("first", "imul", index, integer(2 * design.dimension))
    return _kernel("segment", (tick,), b, {"row": row, "s": s}, "Table index of the segment at a tick, and s in 2^-16 of it.")


def _rounded(b: Block, name: str, value: Operand, places: int) -> Var:
    """The value over 2^places, to the nearest."""
    return b.op(name, "ishr", b.op(f"{name}_half", "iadd", value, integer(1 << (places - 1))), integer(places))


@cache
def weights_kernel() -> Kernel:
    (s,) = _ints("s")
    b = Block({"s", "w0", "w1", "w2"})
    first = b.op("s_up", "ishl", s, integer(FINE - 16))
    square = b.op("square", "upper", first, s)
    cube = b.op("cube", "upper", square, s)
    sum_3 = b.op("sum_3", "imul", b.op("sum", "iadd", first, square), integer(3))
    bend = b.op("bend", "isub", sum_3, b.op("cube_2", "imul", cube, integer(2)))
    less_3 = b.op("less_3", "imul", at_least(b, "less_held", b.op("less", "isub", first, square), 0), integer(3))
    left = b.op("left", "isub", b.op("left_square", "isub", integer(1 << FINE), less_3), cube)
    near = _rounded(b, "bend_near", at_least(b, "bend_held", bend, 0), FINE - BEND_BITS)
    outputs = {
        "w0": _rounded(b, "before", at_least(b, "left_held", left, 0), FINE - WEIGHT_BITS),
        "w1": at_most(b, "middle", near, integer(HALF_WORD - 1)),
        "w2": _rounded(b, "after", cube, FINE - WEIGHT_BITS),
    }
    told = f"At s: (1 - s)^3 and s^3 in 2^-{WEIGHT_BITS}, 3 s + 3 s^2 - 2 s^3 in 2^-{BEND_BITS}."
    return _kernel("weights", (s,), b, outputs, told)


@dataclass(frozen=True)
class Rate:
    """Of weights for an edge's rate. places: of their fraction, in steps a second; mantissa 2^-shift: segments a second."""

    places: int
    mantissa: int
    shift: int


def rate_of(design: RefinedDesign) -> Rate:
    """Of the two outer weights, at most 3 segments a second each, none has more than 15 bits. Raises `BadInput` for a tube that
    is too fast for that."""
    per_second = Fraction(design.segments) / design.prescribed_time
    places = math.floor(math.log2((HALF_WORD - 2) / (6 * per_second)))
    if places < 0:
        raise BadInput("prescribed_time: is so short that integers of 16 bits do not hold the tube's rates; raise it")
    shift = 16 - math.frexp(float(per_second))[1]
    mantissa = math.floor(per_second * Fraction(2) ** shift)
    return Rate(places, min(mantissa, HALF_WORD - 1), shift)


def rates_kernel(rate: Rate) -> Kernel:
    """Weights of the steps for an edge's rate, all at least 0."""
    (s,) = _ints("s")
    b = Block({"s", "r0", "r1", "r2"})
    first = b.op("s_up", "ishl", s, integer(FINE - 16))
    square = b.op("square", "upper", first, s)
    less = at_most(b, "less_most", at_least(b, "less_held", b.op("less", "isub", first, square), 0), integer(1 << (FINE - 2)))
    one = b.op("one_less", "isub", integer(1 << FINE), first)
    left = at_least(b, "left_held", b.op("left", "isub", one, less), 0)  # (1 - s)^2 = 1 - s - (s - s^2)
    middle = b.op("middle", "iadd", integer(1 << FINE), b.op("less_2", "imul", less, integer(2)))

    def scaled(name: str, value: Operand) -> Var:
        """3 times the value, in segments a second, to the places of the weights."""
        a_second = b.op(f"{name}_second", "upper", b.op(f"{name}_3", "imul", value, integer(3)), integer(rate.mantissa))
        return _rounded(b, name, a_second, FINE - 16 + rate.shift - rate.places)

    outputs = {"r0": scaled("before", left), "r1": scaled("between", middle), "r2": scaled("after", square)}
    told = f"At s, in 2^-{rate.places} a second: 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2 times the segments in a second."
    return _kernel("rates", (s,), b, outputs, told)


def _steps(b: Block, n: int, at: Var) -> tuple[Var, tuple[Var, ...]]:
    """The second of four entries of an edge, from `at` on, and the steps between them."""
    q = loaded(b, n, at, LOWER, "at", INT)
    apart = [b.op(f"apart_{k}", "isub", after, before) for k, (before, after) in enumerate(pairwise(q))]
    return q[1], tuple(b.op(f"d{k}", "short", v) for k, v in enumerate(apart))


def _edge(b: Block, q1: Var, steps: tuple[Var, ...], weights: tuple[Var, ...]) -> Var:
    (d0, d1, d2), (w0, w1, w2) = steps, weights
    base = b.op("base", "iadd", b.op("q1_6", "imul", q1, integer(6)), d1)
    middle = b.op("middle", "ishr", b.op("d1_w1", "product", d1, w1), integer(BEND_BITS))
    outer = b.op("outer", "isub", b.op("d2_w2", "product", d2, w2), b.op("d0_w0", "product", d0, w0))
    ends = b.op("ends", "ishr", outer, integer(WEIGHT_BITS))
    return b.op("value", "iadd", b.op("bent", "iadd", base, middle), ends)


@cache
def edge_kernel(n: int) -> Kernel:
    """An edge from its first entry in the table, at `at`, on, for n dimensions."""
    at, *weights = inputs = _ints("at", "w0", "w1", "w2")
    b = Block({v.name for v in inputs} | {"edge"})
    edge = _edge(b, *_steps(b, n, at), tuple(weights))
    told = "An edge of the tube: a control point, and the steps about it by their weights."
    return _kernel("edge", inputs, b, {"edge": edge}, told)


def moving_edge_kernel(n: int, rate: Rate) -> Kernel:
    """An edge and its rate."""
    at, w0, w1, w2, r0, r1, r2 = inputs = _ints("at", "w0", "w1", "w2", "r0", "r1", "r2")
    b = Block({v.name for v in inputs} | {"edge", "rate"})
    q1, steps = _steps(b, n, at)
    edge = _edge(b, q1, steps, (w0, w1, w2))
    between = b.op("between", "ishr", b.op("d1_r1", "product", steps[1], r1), integer(rate.places))
    about = b.op("about", "iadd", b.op("d0_r0", "product", steps[0], r0), b.op("d2_r2", "product", steps[2], r2))
    slope = b.op("slope", "iadd", between, b.op("around", "ishr", about, integer(rate.places)))
    told = "An edge of the tube, and its rate in units a second, by the steps about it."
    return _kernel("edge", inputs, b, {"edge": edge, "rate": slope}, told)


@cache
def curve_kernel() -> Kernel:
    """The quadratic of one row at t, in 2^-16 of the row's piece."""
    row, t = _ints("row", "t")
    b = Block({"row", "t", "value"})
    level, slope, bend = (b.let(name, Load(f"{name}s", row, INT)) for name in ("level", "slope", "bend"))
    down = b.op("down", "isub", slope, b.op("bent", "ishr", b.op("bend_t", "product", bend, t), integer(16)))
    fall = b.op("fall", "ishr", b.op("down_t", "product", down, t), integer(16 + SLOPE_BITS))
    value = b.op("found", "low", b.op("left", "isub", level, fall), integer(HALF_WORD - 1))  # which is all of it
    told = "The quadratic of a row, level - (slope - bend t) t, at t in 2^-16."
    return _kernel("curve", (row, t), b, {"value": value}, told)


def row_and_place(b: Block, name: str, value: Operand, bits: int, first: Operand) -> tuple[Var, Var]:
    """Of a number in [2^30, 2^31): its row of the curves by the `bits` bits after the first, and its place in that row's piece,
    in 2^-16. first: the row of 2^30."""
    head = b.op(f"{name}_head", "low", b.op(f"{name}_bits", "ishr", value, integer(30 - bits)), integer((1 << bits) - 1))
    row = head if first == integer(0) else b.op(f"{name}_row", "iadd", head, first)
    return row, b.op(f"{name}_t", "low", b.op(f"{name}_tail", "ishr", value, integer(14 - bits)), integer(HALF_WORD - 1))


@cache
def push_kernel() -> Kernel:
    names = ("e", "rise", "over", "gain", "places", "limit")
    e, rise, over, gain, places, limit = inputs = _ints(*names)
    b = Block({*names, "push"})
    size = b.op("size", "upper", b.op("over_width", "upper", b.op("steep", "upper", e, rise), over), gain)
    push = at_most(b, "push_held", b.op("moved", "ishr", size, places), limit)
    return _kernel("push", inputs, b, {"push": push}, "|u|: gain e H/d, at most `limit`.")
