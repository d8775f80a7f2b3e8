"""A refined controller in integers alone, for boards without a floating-point unit.

The state x and the tube's edges count units of 2^-bits, those of the table; time counts ticks; u counts units of 2^-u_bits. Every
value is an integer of 32 bits. Operations are exact but for what `ishr` and `upper` cut off, which round down; so the meaning is
the same on every board. That nothing leaves 32 bits is not said here but proved, by `program.ranges`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from stt_codegen.controller.curves import OVER_BITS, RISE_BITS, over_rows, rise_rows
from stt_codegen.controller.fixed_kernels import (
    HALF_WORD,
    Clock,
    at_least,
    at_most,
    curve_kernel,
    edge_kernel,
    push_kernel,
    row_and_place,
    segment_kernel,
    weights_kernel,
)
from stt_codegen.controller.spline import entry
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
STEP_BITS = 15  # a step from one control point to the next is within so many bits
NARROW = 256  # units: a narrower tube counts as so wide
FARTHEST = 1 << 28  # units: a state that is farther out counts as so far
ONE = 1 << 30
LOOSE = Fraction(1, 1 << 13)  # above what 1/width is wrong by, relative


@dataclass(frozen=True)
class FixedLaw:
    """Constants of (13) in integers, for units of 2^-bits of x and a tube whose width is at least `narrow` units."""

    gain: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...]
    e_max: Fraction
    bits: int
    narrow: int

    @property
    def top(self) -> int:
        """|e| is held within this, in 2^-30: not below e_max, whatever 1/width is wrong by."""
        return min(ONE - 1, math.ceil(self.e_max * (1 + LOOSE) * ONE))

    @property
    def lowest(self) -> int:
        """y = 1 - |e| is held from there on, in 2^-30: not above 1 - e_max, whatever 1/width is wrong by."""
        return math.floor((1 - self.e_max) * (1 - LOOSE) * ONE)

    @property
    def octaves(self) -> int:
        """How many times y may be halved below 1."""
        return 31 - self.lowest.bit_length()

    @cached_property
    def places(self) -> tuple[int, ...]:
        """By row of the curve H, by how many places u moves up; at least 0."""
        rows = rise_rows(self.octaves)
        return tuple(r.places - rows[0].places + 1 for r in rows)

    @cached_property
    def base(self) -> int:
        """places stand for 2^(places - base)."""
        return 1 - rise_rows(self.octaves)[0].places

    @cached_property
    def most_up(self) -> int:
        """By how many places u moves up at most: for the narrowest tube and the least y."""
        return 31 - self.narrow.bit_length() + max(self.places)

    def _split(self, gain: Fraction, u_bits: int) -> tuple[int, int]:
        """Mantissa of 16 bits and exponent of the gain for units of x and u."""
        whole = gain * Fraction(2) ** (self.bits + u_bits)
        exponent = math.frexp(float(whole))[1] - 16
        mantissa = round(whole / Fraction(2) ** exponent)
        return (mantissa, exponent) if mantissa < HALF_WORD else (mantissa >> 1, exponent + 1)

    @cached_property
    def u_bits(self) -> int:
        """So many bits of u's fraction that u is moved down alone, and u_max has 31 bits at most."""
        largest = max(abs(v) for v in self.gain)
        _, exponent = self._split(largest, 0)
        # u is size 2^(n + places - moved - u_bits ..), see `offsets`
        free = 28 + self.base - exponent - self.most_up
        return min(free, 30 - math.ceil(math.log2(max(self.u_max))))

    @cached_property
    def mantissas(self) -> tuple[int, ...]:
        return tuple(self._split(abs(k), self.u_bits)[0] for k in self.gain)

    @cached_property
    def offsets(self) -> tuple[int, ...]:
        """u is size moved down by offset - n - places: e in 2^-30, H = h 2^(places - base), 1/width = r 2^(n - 46), the gain's
        exponent, and 2^48 that the three products of `push` cut off: 30 + base + 46 - 48 - exponent."""
        return tuple(28 + self.base - self._split(abs(k), self.u_bits)[1] for k in self.gain)

    @cached_property
    def limits(self) -> tuple[int, ...]:
        """The largest |u|, in its units."""
        return tuple(math.floor(v * Fraction(2) ** self.u_bits) for v in self.u_max)


def clock_of(design: RefinedDesign, period: Fraction) -> Clock:
    """With the 16 bits that s has where the length of a tick is then right enough: a half word is no shift. Raises `BadInput` where
    32 bits do not hold the time of a mission."""
    step, last = period * design.segments / design.prescribed_time, math.ceil(design.prescribed_time / period)
    for bits in (16, *range(30 - design.segments.bit_length(), 16, -1)):
        scale = step * 2 ** (bits + 16)
        fits = last < 2**31 and scale < 2**31 and scale * (last / HALF_WORD + 1) < 2**31
        if fits and last < 2 ** (bits - 2):
            return Clock(round(scale), bits, last)
    took = f"{float(period):g} s over {float(design.prescribed_time):g} s and {design.segments} segments"
    raise BadInput(f"emit.tick_period: {took} makes integers beyond 31 bits; use another")


def law_of(task: Task, design: RefinedDesign) -> FixedLaw:
    """Raises `BadInput` without u_max."""
    if task.u_max is None:
        raise BadInput("control.u_max: a controller in integers counts u by parts of it; state it")
    table = design.integers()
    narrowest = 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).min())
    narrow = 1 << max((narrowest - 64).bit_length() - 1, NARROW.bit_length() - 1) if narrowest > 64 else NARROW
    return FixedLaw(task.gain, task.u_max, max(task.e_max), design.bits, narrow)


def fixed_program(task: Task, design: RefinedDesign) -> Program:
    """`tube` and `control` at a tick. Raises `BadInput` for what has no such program."""
    n, period = design.dimension, task.emit.tick_period
    if design.filter or period is None:
        raise BadInput("a controller in integers is of order 1, and needs emit.tick_period")
    steps = int(abs(design.integers()[1:] - design.integers()[:-1]).max())
    if steps >= 1 << STEP_BITS:
        raise BadInput(f"tube.segments: a step of {steps} units is beyond {STEP_BITS} bits, which integers have; use more segments")
    law = law_of(task, design)
    segment = segment_kernel(clock_of(design, period), design)
    return Program(
        task.name, n, "fixed", (*_tube_tables(design), *_law_tables(law)),
        (segment, weights_kernel(), edge_kernel(n), curve_kernel(), push_kernel()),
        (_tube(n, segment), _control(n, segment, law, task.gain[0] > 0)),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------ tables


def _table(name: str, values: tuple[int, ...], row: int, *doc: str) -> Table:
    return Table(name, tuple(map(Fraction, values)), row, doc, INT)


def _tube_tables(design: RefinedDesign) -> tuple[Table, ...]:
    entries = tuple(v for row in design.table for pair in row for v in pair)
    doc = f"B-spline control points divided by 6, in 2^-{design.bits}, a row for each of {design.segments} + 3 points."
    return (_table("coefficients", entries, 2 * design.dimension, doc),)


def _law_tables(law: FixedLaw) -> tuple[Table, ...]:
    rows = (*over_rows(), *rise_rows(law.octaves))
    doc = (
        f"Quadratics level - (slope - bend t) t, by row: {len(over_rows())} for 1/d, d in [2^30, 2^31), then {1 << RISE_BITS} for each",
        "octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)), whose values also move up by so many places:",
    )
    return (
        _table("levels", tuple(r.level for r in rows), 1, *doc),
        _table("slopes", tuple(r.slope for r in rows), 1),
        _table("bends", tuple(r.bend for r in rows), 1),
        _table("places", (*(0 for _ in over_rows()), *law.places), 1),
        _table("gains", law.mantissas, len(law.gain), "By component: the gain, 16 bits of it."),
        _table("offsets", law.offsets, len(law.gain), "By how many places less u moves up."),
        _table("limits", law.limits, len(law.gain), "The largest |u|."),
    )


# ------------------------------------------------------------------------------------------------ functions


def _edges(block: Block, row: Operand, i: Var, weights: tuple[Var, ...], n: int) -> tuple[Var, Var]:
    at = entry(block, row, i)
    lower, upper = (
        block.call(edge_kernel(n), where, *weights, names=(f"{name}_edge",))
        for name, where in (("lower", at), ("upper", block.op("at_upper", "iadd", at, integer(UPPER))))
    )
    return lower[0], upper[0]


def _begun(block: Block, segment: Kernel) -> tuple[Var, tuple[Var, ...]]:
    row, s = block.call(segment, Var("tick", TICK))
    return row, block.call(weights_kernel(), s)


def _tube(n: int, segment: Kernel) -> Function:
    block = Block({"tick", "lower", "upper"})
    row, weights = _begun(block, segment)
    with block.loop("i", n) as loop:
        for name, edge in zip(("lower", "upper"), _edges(block, row, loop.index, weights, n), strict=True):
            block.store(name, loop.index, edge)
    block.leave()
    params = (Param("tick", None, type=TICK), Param("lower", n, True, type=INT), Param("upper", n, True, type=INT))
    return Function("tube", params, tuple(block.statements), False, ("Edges of the tube at a tick; after t_c those at t_c.",))


def _control(n: int, segment: Kernel, law: FixedLaw, positive: bool) -> Function:
    """positive: the sign of the gain."""
    block = Block({"tick", "x", "u"})
    row, weights = _begun(block, segment)
    with block.loop("i", n) as loop:
        i, outside = loop.index, loop.carry("outside", FALSE)
        lower, upper = _edges(block, row, i, weights, n)
        x = at_most(block, "x_i", at_least(block, "x_near", block.let("x_all", Load("x", i, INT)), -FARTHEST), integer(FARTHEST))
        to_lower, to_upper = block.op("to_lower", "isub", x, lower), block.op("to_upper", "isub", upper, x)
        room = block.op("room", "isub", upper, lower)
        push, upper_nearer, off = _pushed(block, law, i, room, block.op("apart", "isub", to_lower, to_upper))
        back = block.op("back", "isub", integer(0), push)
        down, up = (back, push) if positive else (push, back)
        block.store("u", i, block.select("u_i", upper_nearer, down, up))
        loop.update(outside, block.select("outside_any", block.op("within", "ilt", off, room), outside, TRUE))
    block.leave(Select(outside, OUTSIDE, OK))
    params = (Param("tick", None, type=TICK), Param("x", n, type=INT), Param("u", n, True, type=INT))
    doc = (
        "The law (13) at a tick, for a state on the grid of the table's units.",
        "OK: x strictly inside the tube; else OUTSIDE_TUBE, and u points inward.",
    )
    return Function("control", params, tuple(block.statements), True, doc)


def _pushed(block: Block, law: FixedLaw, i: Var, room: Var, apart: Var) -> tuple[Var, Var, Var]:
    """Statements for |u| of component i, whether the upper edge is nearer, and |apart|. apart: by how much the lower edge is
    farther than the upper one, which is e times the width."""
    width = at_least(block, "width", room, law.narrow)
    upper_nearer = block.op("upper_nearer", "ilt", integer(0), apart)
    off = block.select("off", upper_nearer, apart, block.op("minus", "isub", integer(0), apart))
    held = at_most(block, "off_held", off, width)
    n = block.op("n", "leading", width)
    width_up, off_up = block.op("width_up", "ishl", width, n), block.op("off_up", "ishl", held, n)
    over_at = row_and_place(block, "over", width_up, OVER_BITS, integer(-(1 << OVER_BITS)))
    (over,) = block.call(curve_kernel(), *over_at, names=("over",))
    e = at_most(block, "e", block.op("e_all", "upper", off_up, over), integer(law.top))
    y_all = block.op("y_all", "upper", block.op("rest", "isub", width_up, off_up), over)
    y = at_most(block, "y", at_least(block, "y_near", y_all, law.lowest), integer(ONE - 1))
    m = block.op("m", "leading", y)
    octave = block.op("octave", "imul", m, integer(1 << RISE_BITS))  # the rows of 1/d are as many as two octaves'
    row, t = row_and_place(block, "rise", block.op("y_up", "ishl", y, m), RISE_BITS, octave)
    (rise,) = block.call(curve_kernel(), row, t, names=("rise",))
    up = block.let("rise_places", Load("places", row, INT))
    gain, offset, limit = (block.let(name, Load(f"{name}s", i, INT)) for name in ("gain", "offset", "limit"))
    down = block.op("down", "isub", block.op("down_n", "isub", offset, n), up)
    (push,) = block.call(push_kernel(), e, rise, over, gain, down, limit)
    return push, upper_nearer, off
