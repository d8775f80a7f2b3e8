"""The frames of a refined controller in integers alone: `tube`, `control` and `margin` at a tick, for order 1.

The state x and the tube's edges count units of 2^-bits, those of the table; time counts ticks; u counts units of 2^-u_bits. Every
value is an integer of 32 bits. Operations are exact but for what `ishr` and `upper` cut off, which round down; so the meaning is
the same on every board. That nothing leaves 32 bits is not said here but proved, by `program.analyse.ranges`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stt_codegen.controller.comments import axes_doc, inward_doc
from stt_codegen.controller.covered_starts import NAMES, between_bounds, covered_doc
from stt_codegen.controller.integers.constants import ONE, FixedLaw
from stt_codegen.controller.integers.curves import OVER_BITS, RISE_BITS
from stt_codegen.controller.integers.integer_kernels import (
    at_least,
    at_most,
    curve_kernel,
    edge_kernel,
    push_kernel,
    row_and_place,
    weights_kernel,
)
from stt_codegen.controller.kernels import entry
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import UPPER
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
    Select,
    Status,
    Table,
    Var,
    integer,
)
from stt_codegen.task import Task

OK, OUTSIDE = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE))
FARTHEST = 1 << 28  # units: a state that is farther out counts as so far
MARGIN_BITS = 16  # of the fraction of a margin
OCTAVES_BEFORE = (1 << (OVER_BITS - RISE_BITS)) - 1  # octave m of y, from 1 on, begins at row 2^RISE_BITS (m + OCTAVES_BEFORE)
HALF_MARGIN = 1 << (MARGIN_BITS - 1)


def _integers(name: str, n: int, output: bool = False) -> Param:
    return Param(name, n, output, type=INT)


TICK_PARAM = Param("tick", None, type=TICK)
State = tuple[Var, Var]  # how far the state is from the lower and from the upper edge


@dataclass(frozen=True)
class Frame:
    """What the functions have in common. narrow: units; a narrower tube counts as so wide."""

    n: int
    segment: Kernel
    law: FixedLaw
    narrow: int

    vectors: ClassVar[tuple[str, ...]] = ("x",)  # of which `control` is told
    tables: ClassVar[tuple[Table, ...]] = ()

    @property
    def of_time(self) -> tuple[Kernel, ...]:
        """The kernels of a tick: the segment, then weights of its place."""
        return self.segment, weights_kernel()

    @property
    def edge(self) -> Kernel:
        return edge_kernel(self.n)

    def functions(self, task: Task) -> tuple[Function, ...]:
        return self.tube(), self.control(task), self.margin(), self.margins(), self.covered(task)

    def begun(self, block: Block) -> tuple[Var, tuple[Var, ...]]:
        """Statements for the table's row, and all weights."""
        segment, *others = self.of_time
        row, s = block.call(segment, Var("tick", TICK))
        return row, tuple(w for kernel in others for w in block.call(kernel, s))

    def edges(self, block: Block, row: Operand, i: Var, weights: tuple[Var, ...]) -> tuple[tuple[Var, ...], ...]:
        """Statements for what is known of the lower edge and of the upper one."""
        at = entry(block, row, i)
        after = block.op("at_upper", "iadd", at, integer(UPPER))
        names = [tuple(f"{side}_{what}" for what in self.edge.output_names) for side in ("lower", "upper")]
        return tuple(block.call(self.edge, where, *weights, names=told) for where, told in zip((at, after), names, strict=True))

    def apart(self, block: Block, i: Var, edges: tuple[tuple[Var, ...], ...]) -> tuple[State, State]:
        """Statements for where the state is that the law goes by, and where x is."""
        found = between(block, "x", i, edges[0][0], edges[1][0], FARTHEST)
        return found, found

    def inside(self, block: Block, off: Var, room: Var, _states: tuple[State, State]) -> Var:
        """Statements for whether the state is inside; off: by how much it is farther from one edge than from the other."""
        return block.op("within", "ilt", off, room)

    def tube(self) -> Function:
        block = Block({"tick", "lower", "upper"})
        row, weights = self.begun(block)
        with block.loop("i", self.n) as loop:
            for name, edge in zip(("lower", "upper"), self.edges(block, row, loop.index, weights), strict=True):
                block.store(name, loop.index, edge[0])
        block.leave()
        doc = ("Edges of the tube gamma at a tick, in the units of x.", "From the tick of t_c on those at t_c.")
        return Function("tube", sides(self.n), tuple(block.statements), False, doc)

    def control(self, task: Task) -> Function:
        positive = task.gain[0] > 0
        block = Block({"tick", *self.vectors, "u"})
        row, weights = self.begun(block)
        with block.loop("i", self.n) as loop:
            i, outside = loop.index, loop.carry("outside", FALSE)
            states = self.apart(block, i, self.edges(block, row, i, weights))
            room = room_of(block, "room", states[0])
            push, upper_nearer, off = _pushed(block, self.law, i, room, block.op("apart", "isub", *states[0]))
            back = block.op("back", "ineg", push)
            down, up = (back, push) if positive else (push, back)
            block.store("u", i, block.select("u_i", upper_nearer, down, up))
            loop.update(outside, block.select("outside_any", self.inside(block, off, room, states), outside, TRUE))
        block.leave(Select(outside, OUTSIDE, OK))
        params = (TICK_PARAM, *(_integers(name, self.n) for name in self.vectors), _integers("u", self.n, True))
        return Function("control", params, tuple(block.statements), True, self.control_doc(task))

    def control_doc(self, task: Task) -> tuple[str, ...]:
        e_max = decimal(self.law.e_max)
        return (
            f"Control law (13), u = -k xi epsilon, k = {by_component(task.gain)}, e clamped to [-{e_max}, {e_max}], u saturated.",
            f"{ticks_doc(task)} x: state; u: input.",
            *axes_doc(task),
            "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law and points inward"
            + inward_doc(task)
            + ".",
            "Every value of x is a state: there is no bad input. u may be the array x itself.",
        )

    def margin(self) -> Function:
        block = Block({"tick", *self.vectors})
        row, weights = self.begun(block)
        with block.loop("i", self.n) as loop:
            least = loop.carry("margin", integer(HALF_MARGIN))
            share = self.margin_component(block, loop.index, row, weights)
            loop.update(least, block.select("margin_next", block.op("less", "ilt", share, least), share, least))
        block.leave(least)
        params = (TICK_PARAM, *(_integers(name, self.n) for name in self.vectors))
        return Function("margin", params, tuple(block.statements), False, self.margin_doc, returns_real=True)

    def margin_component(self, block: Block, i: Var, row: Operand, weights: tuple[Var, ...]) -> Var:
        """Statements for the margin of one component."""
        states = self.apart(block, i, self.edges(block, row, i, weights))
        share = _share(block, "share", self.law.narrow, *states[0])
        if states[1] == states[0]:
            return share
        position = _share(block, "place", self.narrow, *states[1])
        return block.select("lesser", block.op("filtered_less", "ilt", share, position), share, position)

    def margins(self) -> Function:
        """The public `margins`: the margin by component."""
        block = Block({"tick", *self.vectors, "margin"})
        row, weights = self.begun(block)
        with block.loop("i", self.n) as loop:
            block.store("margin", loop.index, self.margin_component(block, loop.index, row, weights))
        block.leave()
        params = (TICK_PARAM, *(_integers(name, self.n) for name in self.vectors), _integers("margin", self.n, True))
        doc = ("The margin of each component, in the same units: which axis is near its edge.",)
        return Function("margins", params, tuple(block.statements), False, doc)

    def covered(self, task: Task) -> Function:
        """The public `covered`: whether every component is that of a covered start."""
        block = Block(set(self.vectors))
        with block.loop("i", self.n) as loop:
            covered = loop.carry("covered", TRUE)
            inside = self.covered_component(block, loop.index)
            loop.update(covered, block.select("covered_next", inside, covered, FALSE))
        block.leave(covered)
        params = tuple(_integers(name, self.n) for name in self.vectors)
        return Function("covered", params, tuple(block.statements), False, covered_doc(task), returns_bool=True)

    def covered_component(self, block: Block, i: Var) -> Var:
        """Statements for whether x is that of a start that is covered."""
        return between_bounds(block, block.let("x_i", Load("x", i, INT)), i, NAMES[:2])

    @property
    def margin_doc(self) -> tuple[str, ...]:
        return (
            f"How far x is from leaving the tube, in 2^-{MARGIN_BITS}: the distance to the nearest edge over the width there,",
            f"least over the components. {HALF_MARGIN} in the middle, 0 or more inside, else {-2 * HALF_MARGIN} to -1.",
            "Watch it: act while there is margin, not when the tube is left.",
        )


def ticks_doc(task: Task) -> str:
    assert task.emit.tick_period is not None
    return f"tick: periods of {decimal(task.emit.tick_period)} s since the start (it must not wrap to 0: stop counting at t_c);"


def sides(n: int) -> tuple[Param, ...]:
    return TICK_PARAM, _integers("lower", n, True), _integers("upper", n, True)


def between(block: Block, name: str, i: Var, lower: Var, upper: Var, farthest: int) -> State:
    """Statements for how far component i of an array is from two edges."""
    value = held_within(block, name, i, farthest)
    return block.op(f"{name}_lower", "isub", value, lower), block.op(f"{name}_upper", "isub", upper, value)


def held_within(block: Block, name: str, i: Var, farthest: int) -> Var:
    """Statements for component i of an array, held within -farthest and farthest."""
    value = block.let(f"{name}_all", Load(name, i, INT))
    return at_most(block, f"{name}_i", at_least(block, f"{name}_near", value, -farthest), integer(farthest))


def room_of(block: Block, name: str, state: State) -> Var:
    """Statements for the width between the edges."""
    return block.op(name, "iadd", *state)


def _over(block: Block, name: str, room: Var, narrow: int) -> tuple[Var, Var, Var, Var]:
    """Statements for the width, its 1/d, the width moved up until it begins with a 1, and by how many places."""
    width = at_least(block, f"{name}_width", room, narrow)
    n = block.op(f"{name}_n", "leading", width)
    width_up = block.op(f"{name}_width_up", "ishl", width, n)
    at = row_and_place(block, f"{name}_over", width_up, OVER_BITS, integer(0))
    (over,) = block.call(curve_kernel(), *at, names=(f"{name}_over",))
    return width, over, width_up, n


def _pushed(block: Block, law: FixedLaw, i: Var, room: Var, apart: Var) -> tuple[Var, Var, Var]:
    """Statements for |u| of component i, whether the upper edge is nearer, and |apart|. apart: by how much the lower edge is
    farther than the upper one, which is e times the width."""
    width, over, width_up, n = _over(block, "e", room, law.narrow)
    upper_nearer = block.op("upper_nearer", "ilt", integer(0), apart)
    off = block.select("off", upper_nearer, apart, block.op("minus", "ineg", apart))
    off_up = block.op("off_up", "ishl", at_most(block, "off_held", off, width), n)
    e = at_most(block, "e", block.op("e_all", "upper", off_up, over), integer(law.top))
    y_all = block.op("y_all", "upper", block.op("rest", "isub", width_up, off_up), over)
    y = at_most(block, "y", at_least(block, "y_near", y_all, law.lowest), integer(ONE - 1))
    m = block.op("m", "leading", y)
    octave = block.op(
        "octave", "iadd", block.op("octaves", "imul", m, integer(1 << RISE_BITS)), integer(OCTAVES_BEFORE << RISE_BITS)
    )
    row, t = row_and_place(block, "rise", block.op("y_up", "ishl", y, m), RISE_BITS, octave)
    (rise,) = block.call(curve_kernel(), row, t, names=("rise",))
    up = block.let("rise_places", Load("places", row, INT))
    gain, offset, limit = (block.let(name, Load(f"{name}s", i, INT)) for name in ("gain", "offset", "limit"))
    down = at_least(block, "down", block.op("down_all", "isub", block.op("down_n", "isub", offset, n), up), 0)
    (push,) = block.call(push_kernel(), e, rise, over, gain, down, limit)
    return push, upper_nearer, off


def _share(block: Block, name: str, narrow: int, to_lower: Var, to_upper: Var) -> Var:
    """Statements for the distance to the nearer edge over the width, in 2^-MARGIN_BITS: at least -1, below 0 unless inside."""
    width, over, _, n = _over(block, name, room_of(block, f"{name}_room", (to_lower, to_upper)), narrow)
    nearest = block.select(f"{name}_nearest", block.op(f"{name}_high", "ilt", to_upper, to_lower), to_upper, to_lower)
    inside = block.op(f"{name}_inside", "ilt", integer(0), nearest)
    size = block.select(f"{name}_size", inside, nearest, block.op(f"{name}_beyond", "ineg", nearest))
    up = block.op(f"{name}_up", "ishl", at_most(block, f"{name}_held", size, width), n)
    part = block.op(f"{name}_part", "ishr", block.op(f"{name}_quotient", "upper", up, over), integer(30 - MARGIN_BITS))
    most = at_most(block, f"{name}_most", part, integer(2 * HALF_MARGIN - 1))
    return block.select(name, inside, most, block.op(f"{name}_minus", "isub", integer(-1), most))
