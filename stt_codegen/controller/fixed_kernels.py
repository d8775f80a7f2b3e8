"""The kernels of a controller in integers (fixed.py): straight lines of shifts, sums and products of 16 bits.

    segment      tick -> row of the table, and s in 2^-16 of a segment
    edge         B-spline in Horner's form, by differences of four entries
    parts        room, near, far as m 2^-places with m in [2^30, 2^31), and what of them is to be inverted
    reciprocal   2^31/d for d of 16 bits: a seed from a table, one step of Newton's
    push         |u| by (13), gain room/(near far) ln(far/near), at most u_max

ln(far/near) = k ln 2 + 2 atanh s with s = (p - q)/(p + q), p/q = far/near / 2^k in [3/4, 3/2), and 2 atanh s = s (2 + C s^2).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.designs import RefinedDesign
from stt_codegen.program import INT, TICK, Block, Const, Kernel, Load, Operand, Var, integer

HALF_WORD = 1 << 16
LN2 = round(math.log(2) * 2**27)
# C, in 2^-12. 2 atanh(s)/s is 2 + 2/3 z + 2/5 z^2 + .. with z = s^2 in [0, 1/25]; so 2 + C z is off by as much before the end as
# at it, but for the terms behind.
CUBIC = round((2 / 3 + 4 / 5 / 25 * (math.sqrt(2) - 1)) * 2**12)


@dataclass(frozen=True)
class Clock:
    """Of ticks in segments. scale: a tick, in 2^-(bits + 16) of a segment; last: the first tick that is not before t_c."""

    scale: int
    bits: int
    last: int


@cache
def seeds() -> tuple[int, ...]:
    """By k, (128,): of the middle d of [2^15 + 256 k, 2^15 + 256 (k + 1)), (2^31/d - 2^15)/2^7 in 8 bits."""
    return tuple(min(255, round((2**31 / (2**15 + 256 * k + 127.5) - 2**15) / 128)) for k in range(128))


def _kernel(name: str, inputs: tuple[Var, ...], block: Block, outputs: Mapping[str, Operand], *doc: str) -> Kernel:
    body = tuple(block.statements)
    return Kernel(name, inputs, body, tuple(outputs.values()), tuple(outputs), doc)  # type: ignore[arg-type]


def held_within(b: Block, name: str, value: Operand, low: int, high: int) -> Var:
    """The value, held within low and high."""
    raised = b.select(f"{name}_raised", b.op(f"{name}_below", "ilt", value, integer(low)), integer(low), value)
    return b.select(name, b.op(f"{name}_within", "ilt", raised, integer(high)), raised, integer(high))


def _below_half(b: Block, name: str, value: Operand) -> tuple[Var, Var]:
    """A number of [2^29, 2^31) within [2^29, 2^30), and by how many places it moved down."""
    small = b.op(f"{name}_small", "ilt", value, integer(1 << 30))
    half = b.op(f"{name}_half", "ishr", value, integer(1))
    return b.select(name, small, value, half), b.select(f"{name}_moved", small, integer(0), integer(1))


def segment_kernel(clock: Clock, design: RefinedDesign) -> Kernel:
    tick = Var("tick", TICK)
    b = Block({"tick", "row", "s"})
    last = Const(clock.last, TICK)
    count = b.op("count", "int", b.select("held", b.op("running", "tlt", tick, last), tick, last))
    place = b.op("passed", "upper", integer(clock.scale), b.op("count_low", "low", count))
    if clock.last >= HALF_WORD:
        high = b.op("passed_high", "imul", b.op("count_high", "ishr", count, integer(16)), integer(clock.scale))
        place = b.op("passed_both", "iadd", place, high)
    end = integer((design.segments << clock.bits) - 1)
    place = b.select("place", b.op("early", "ilt", place, end), place, end)
    index = b.op("segment", "ishr", place, integer(clock.bits))
    s = b.op("share", "low", b.op("fine", "ishr", place, integer(clock.bits - 16)))
    row = b.op("first", "imul", index, integer(2 * design.dimension))
    return _kernel("segment", (tick,), b, {"row": row, "s": s}, "Table index of the segment at a tick, and s in 2^-16 of it.")


@cache
def edge_kernel() -> Kernel:
    q0, q1, q2, q3, s = inputs = tuple(Var(name, INT) for name in ("q0", "q1", "q2", "q3", "s"))
    b = Block({v.name for v in inputs} | {"edge"})
    d0, d1, d2 = (b.op(f"d{k}", "isub", v, w) for k, (v, w) in enumerate(((q1, q0), (q2, q1), (q3, q2))))
    bend = b.op("bend", "isub", d1, d0)
    third = b.op("third", "isub", b.op("bend_next", "isub", d2, d1), bend)
    second = b.op("second", "iadd", b.op("bend_3", "imul", bend, integer(3)), b.op("third_s", "upper", third, s))
    slope = b.op("slope", "imul", b.op("rise", "iadd", d0, d1), integer(3))
    first = b.op("first", "iadd", slope, b.op("second_s", "upper", second, s))
    base = b.op("base", "iadd", b.op("q1_6", "imul", q1, integer(6)), bend)
    edge = b.op("value", "iadd", base, b.op("first_s", "upper", first, s))
    return _kernel("edge", inputs, b, {"edge": edge}, "An edge of the tube: ((third s + 3 bend) s + 3 rise) s + 6 q1 + bend.")


def parts_kernel(e_max: Fraction) -> Kernel:
    inputs = tuple(Var(name, INT) for name in ("room", "near", "far"))
    b = Block({"room", "near", "far", "product", "den", "num", "k", "mass", "places"})
    room_up, near_up, far_up = (b.op(f"{v.name}_places", "leading", v) for v in inputs)
    room_m, near_m, far_m = (b.op(f"{v.name}_m", "ishl", v, up) for v, up in zip(inputs, (room_up, near_up, far_up), strict=True))
    whole = b.op("whole", "upper", near_m, b.op("far_high", "ishr", far_m, integer(15)))
    product, moved = _below_half(b, "both", whole)
    # far/near = p/q 2^k
    p, q = b.op("p", "ishr", far_m, integer(1)), b.op("q", "ishr", near_m, integer(1))
    over = b.op("over", "ilt", b.op("q_more", "iadd", q, b.op("q_2", "ishr", q, integer(1))), p)
    under = b.op("under", "ilt", p, b.op("q_less", "isub", q, b.op("q_4", "ishr", q, integer(2))))
    p_near = b.select("p_near", over, b.op("p_half", "ishr", p, integer(1)), p)
    q_near = b.select("q_near", under, b.op("q_half", "ishr", q, integer(1)), q)
    more = b.select("more", over, integer(1), b.select("less", under, integer(-1), integer(0)))
    apart = b.op("k_all", "iadd", b.op("k_m", "isub", near_up, far_up), more)
    k = held_within(b, "k_held", apart, 0, math.ceil(math.log2((1 + e_max) / (1 - e_max))) + 1)
    den, den_moved = _below_half(b, "sum_held", b.op("sum", "iadd", p_near, q_near))
    num = b.op("difference_held", "ishr", b.op("difference", "isub", p_near, q_near), den_moved)
    up = b.op("up", "isub", b.op("up_both", "iadd", near_up, far_up), room_up)
    outputs = {
        "product": b.op("product_high", "ishr", product, integer(14)),
        "den": b.op("den_high", "ishr", den, integer(14)),
        "num": num,
        "k": k,
        "mass": b.op("room_high", "ishr", room_m, integer(15)),
        "places": b.op("up_all", "isub", up, moved),
    }
    return _kernel(
        "parts", inputs, b, outputs,
        "near far and p + q, p - q in 16 and 30 bits, where far/near = p/q 2^k; room in 16 bits; by how many places what is made",
        "of them moves.",
    )  # fmt: skip


@cache
def reciprocal_kernel() -> Kernel:
    d = Var("d", INT)
    b = Block({"d", "r"})
    seed = b.let("seed", Load("seeds", b.op("at", "isub", b.op("d_high", "ishr", d, integer(8)), integer(128)), INT))
    first = b.op("first", "iadd", b.op("seed_high", "imul", seed, integer(128)), integer(1 << 15))
    found = b.op("found", "upper", b.op("d_up", "imul", d, integer(1 << 14)), first)
    wrong = b.op("wrong", "isub", integer(1 << 29), found)
    better = b.op("better", "iadd", first, b.op("step", "ishr", b.op("wrong_r", "upper", wrong, first), integer(13)))
    r = held_within(b, "r_held", better, 1 << 15, HALF_WORD - 1)
    return _kernel("reciprocal", (d,), b, {"r": r}, "2^31/d for d in [2^15, 2^16), by one step of Newton's.")


@cache
def push_kernel() -> Kernel:
    names = ("over_product", "over_den", "num", "k", "mass", "places", "gain", "offset", "most")
    over_product, over_den, num, k, mass, places, gain, offset, most = inputs = tuple(Var(name, INT) for name in names)
    b = Block({*names, "push"})
    s = b.op("s", "upper", num, over_den)  # in 2^-29
    coarse = b.op("s_coarse", "ishr", s, integer(15))
    square = b.op("z", "ishr", b.op("square", "imul", coarse, coarse), integer(11))  # in 2^-17
    bend = b.op("bend", "ishr", b.op("bent", "imul", square, integer(CUBIC)), integer(15))  # in 2^-14
    part = b.op("part", "iadd", b.op("s_2", "ishr", s, integer(1)), b.op("s_bend", "upper", s, bend))
    log = b.op("log", "iadd", b.op("whole", "imul", k, integer(LN2)), part)  # in 2^-27
    log = b.select("log_held", b.op("positive", "ilt", integer(0), log), log, integer(0))
    size = b.op("size", "upper", b.op("of_room", "upper", b.op("over_both", "upper", log, over_product), mass), gain)
    up = held_within(b, "up", b.op("up_all", "isub", places, offset), 0, 30)
    down = held_within(b, "down", b.op("down_all", "isub", offset, places), 0, 31)
    small, limit = b.op("small", "ishr", size, down), b.op("limit", "ishr", most, up)
    fits = b.op("fits", "ilt", small, limit)
    raised = b.op("raised", "ishl", b.select("held", fits, small, limit), up)
    push = b.select("push_held", fits, raised, most)
    return _kernel("push", inputs, b, {"push": push}, "|u|: gain room/(near far) ln(far/near), at most `most`.")
