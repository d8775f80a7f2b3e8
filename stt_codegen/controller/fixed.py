"""A refined controller of order 1 in integers alone, for boards without a floating-point unit.

The state x and the tube's edges count units of 2^-bits, those of the table; time counts ticks; u counts units of 2^-u_bits. Every
value is an integer of 32 bits. Operations are exact but for what `ishr` and `upper` cut off, which round down; so the meaning is
the same on every board. That nothing leaves 32 bits is not said here but proved, by `program.ranges`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.controller.fixed_kernels import (
    HALF_WORD,
    Clock,
    edge_kernel,
    held_within,
    parts_kernel,
    push_kernel,
    reciprocal_kernel,
    seeds,
    segment_kernel,
)
from stt_codegen.controller.spline import entry, loaded
from stt_codegen.designs import LOWER, UPPER, RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import (
    FALSE,
    INT,
    STATUS,
    TICK,
    TRUE,
    Block,
    Const,
    Function,
    Kernel,
    Load,
    Operand,
    Param,
    Program,
    Select,
    Status,
    Table,
    Var,
    integer,
)
from stt_codegen.task import Task

OK, OUTSIDE = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE))
NARROW = 256  # units: a narrower tube counts as so wide, that a 200th of it is not 0
FARTHEST = 1 << 30  # units: a state that is farther out counts as so far


@dataclass(frozen=True)
class Component:
    """Of the law. The gain, for units of x and u, is mantissa 2^(40 - offset); most: the largest |u|, in its units."""

    mantissa: int
    offset: int
    most: int


def clock_of(design: RefinedDesign, period: Fraction) -> Clock:
    """Raises `BadInput` where 32 bits do not hold the time of a mission."""
    step, last = period * design.segments / design.prescribed_time, math.ceil(design.prescribed_time / period)
    for bits in range(30 - design.segments.bit_length(), 15, -1):
        scale = step * 2 ** (bits + 16)
        if last < 2**31 and scale < 2**31 and scale * (last / HALF_WORD + 1) < 2**31:
            return Clock(round(scale), bits, last)
    took = f"{float(period):g} s over {float(design.prescribed_time):g} s and {design.segments} segments"
    raise BadInput(f"emit.tick_period: {took} makes integers beyond 31 bits; use another")


def law_of(task: Task, bits: int) -> tuple[tuple[Component, ...], int]:
    """The components, and the bits of u's fraction. Raises `BadInput` without u_max."""
    if task.u_max is None:
        raise BadInput("control.u_max: a controller in integers counts u by parts of it; state it")
    u_bits, found = 30 - math.ceil(math.log2(max(task.u_max))), []
    for gain, limit in zip(task.gain, task.u_max, strict=True):
        whole = abs(gain) * Fraction(2) ** (bits + u_bits)
        places = 16 - math.frexp(float(whole))[1]
        mantissa = min(HALF_WORD - 1, round(whole * Fraction(2) ** places))
        found.append(Component(mantissa, places + 40, math.floor(limit * Fraction(2) ** u_bits)))
    return tuple(found), u_bits


def fixed_program(task: Task, design: RefinedDesign) -> Program:
    """`tube` and `control` at a tick. Raises `BadInput` for what has no such program."""
    n, period, e_max = design.dimension, task.emit.tick_period, max(task.e_max)
    if design.filter or period is None:
        raise BadInput("a controller in integers is of order 1, and needs emit.tick_period")
    if design.significant > 24:
        raise BadInput(f"the tube needs {design.significant} bits; a controller in integers has room for 24")
    laws, _ = law_of(task, design.bits)
    segment, parts = segment_kernel(clock_of(design, period), design), parts_kernel(e_max)
    share = math.ceil((1 - e_max) / 2 * HALF_WORD)
    return Program(
        task.name, n, "fixed", (*_tube_tables(design), *_law_tables(laws)),
        (segment, edge_kernel(), parts, reciprocal_kernel(), push_kernel()),
        (_tube(n, segment), _control(n, segment, parts, share, task.gain[0] > 0)),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------ tables


def _tube_tables(design: RefinedDesign) -> tuple[Table, ...]:
    entries = tuple(Fraction(int(v)) for row in design.table for pair in row for v in pair)
    doc = f"B-spline control points divided by 6, in 2^-{design.bits}, a row for each of {design.segments} + 3 points."
    told = "Reciprocals r of d in [2^15, 2^16) by the 7 bits after the first: (r - 2^15)/2^7."
    return (
        Table("coefficients", entries, 2 * design.dimension, (doc,), INT),
        Table("seeds", tuple(map(Fraction, seeds())), 16, (told,), INT),
    )


def _law_tables(laws: tuple[Component, ...]) -> tuple[Table, ...]:
    told = {
        "gains": ("mantissa", "By component: the gain, 16 bits of it."),
        "offsets": ("offset", "By how many places less u is moved up."),
        "limits": ("most", "The largest |u|."),
    }
    return tuple(
        Table(name, tuple(Fraction(getattr(law, field)) for law in laws), len(laws), (doc,), INT)
        for name, (field, doc) in told.items()
    )


# ------------------------------------------------------------------------------------------------ functions


def _edges(block: Block, row: Operand, i: Var, s: Operand, n: int) -> tuple[Var, Var]:
    at = entry(block, row, i)
    found: list[Var] = []
    for side, name in ((LOWER, "lower"), (UPPER, "upper")):
        entries = loaded(block, n, at, side, name, INT)
        found += block.call(edge_kernel(), *entries, s, names=(f"{name}_edge",))
    return found[0], found[1]


def _tube(n: int, segment: Kernel) -> Function:
    block = Block({"tick", "lower", "upper"})
    row, s = block.call(segment, Var("tick", TICK))
    with block.loop("i", n) as loop:
        for name, edge in zip(("lower", "upper"), _edges(block, row, loop.index, s, n), strict=True):
            block.store(name, loop.index, edge)
    block.leave()
    params = (Param("tick", None, type=TICK), Param("lower", n, True, type=INT), Param("upper", n, True, type=INT))
    return Function("tube", params, tuple(block.statements), False, ("Edges of the tube at a tick; after t_c those at t_c.",))


def _control(n: int, segment: Kernel, parts: Kernel, share: int, positive: bool) -> Function:
    """share: the least part of the width, in 2^-16, that x counts as being off an edge. positive: the sign of the gain."""
    block = Block({"tick", "x", "u"})
    row, s = block.call(segment, Var("tick", TICK))
    with block.loop("i", n) as loop:
        i, outside = loop.index, loop.carry("outside", FALSE)
        lower, upper = _edges(block, row, i, s, n)
        x = held_within(block, "x_i", block.let("x_all", Load("x", i, INT)), -FARTHEST, FARTHEST)
        width = block.op("width", "isub", upper, lower)
        room = block.select("room", block.op("wide", "ilt", integer(NARROW), width), width, integer(NARROW))
        to_lower, to_upper = block.op("to_lower", "isub", x, lower), block.op("to_upper", "isub", upper, x)
        upper_nearer = block.op("upper_nearer", "ilt", to_upper, to_lower)
        nearest = block.select("nearest", upper_nearer, to_upper, to_lower)
        least = block.op("least", "upper", room, integer(share))
        near = block.select("near", block.op("clear", "ilt", least, nearest), nearest, least)
        rest = block.op("rest", "isub", room, near)
        far = block.select("far", block.op("some", "ilt", integer(1), rest), rest, integer(1))
        product, den, num, k, mass, places = block.call(parts, room, near, far)
        (over_product,) = block.call(reciprocal_kernel(), product, names=("over_product",))
        (over_den,) = block.call(reciprocal_kernel(), den, names=("over_den",))
        gain, offset, most = (block.let(name, Load(f"{name}s", i, INT)) for name in ("gain", "offset", "limit"))
        (push,) = block.call(push_kernel(), over_product, over_den, num, k, mass, places, gain, offset, most)
        back = block.op("back", "isub", integer(0), push)
        down, up = (back, push) if positive else (push, back)
        block.store("u", i, block.select("u_i", upper_nearer, down, up))
        inside = block.op("within", "ilt", integer(0), nearest)
        loop.update(outside, block.select("outside_any", inside, outside, TRUE))
    block.leave(Select(outside, OUTSIDE, OK))
    params = (Param("tick", None, type=TICK), Param("x", n, type=INT), Param("u", n, True, type=INT))
    doc = (
        "The law (13) at a tick, for a state on the grid of the table's units.",
        "OK: x strictly inside the tube; else OUTSIDE_TUBE, and u points inward.",
    )
    return Function("control", params, tuple(block.statements), True, doc)
