"""The functions of a refined controller in integers, at a tick, for plants of order 1.

The state x and the tube's edges count units of 2^-bits, those of the table; time counts ticks; u counts units of 2^-u_bits. Every
value is an integer of 32 bits. Operations are exact but for what `ishr` and `upper` drop, which round down; so results are
the same on every board. `program.analyse.ranges` proves that no value leaves 32 bits.

fixed_program.py calls `IntegerController.functions`. Functions named `write_..` append statements to a block of a Program and
return the variables that hold the results. Strings that they pass are names in emitted code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from stt_codegen.controller.comments import axes_doc, inward_doc
from stt_codegen.controller.covered_starts import BOUND_TABLES, covered_doc, write_is_between_bounds
from stt_codegen.controller.integers.constants import FIXED_ONE, IntegerLaw
from stt_codegen.controller.integers.curves import H_PIECE_BITS, RECIPROCAL_PIECE_BITS
from stt_codegen.controller.integers.integer_kernels import (
    build_curve_kernel,
    build_edge_kernel,
    build_push_kernel,
    build_weights_kernel,
    write_at_least,
    write_at_most,
    write_curve_position,
)
from stt_codegen.controller.kernels import write_first_index
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
LARGEST_STATE = 1 << 28  # units; a state that is farther out counts as so far
MARGIN_BITS = 16  # of the fraction of a margin
# The pieces of y in [2^-m, 2^(1 - m)), m from 1 on, stand in the rows from 2^H_PIECE_BITS (m + RECIPROCAL_OCTAVES) on.
RECIPROCAL_OCTAVES = (1 << (RECIPROCAL_PIECE_BITS - H_PIECE_BITS)) - 1
HALF_MARGIN = 1 << (MARGIN_BITS - 1)  # 1/2 in 2^-MARGIN_BITS
TICK_PARAM = Param("tick", None, type=TICK)


def _integers(name: str, n: int, *, output: bool = False) -> Param:
    """Return a parameter: an array of n integers."""
    return Param(name, n, output, type=INT)


def edge_params(n: int) -> tuple[Param, ...]:
    """Return the parameters of a function that computes both edges (n,) at a tick."""
    return TICK_PARAM, _integers("lower", n, output=True), _integers("upper", n, output=True)


class Distances(NamedTuple):
    """How far a value is from the lower and from the upper edge; negative beyond it."""

    to_lower: Var
    to_upper: Var


class StateDistances(NamedTuple):
    """The distances of one component: of the value that the law is about (x, or v + lambda x for order 2), and of x."""

    of_law: Distances
    of_x: Distances


@dataclass(frozen=True)
class IntegerController:
    """Builds the functions of a controller in integers, for order 1.

    `segment` is the kernel of a tick. `smallest_width`: units of x; `margin` takes a narrower tube to be so wide."""

    n: int
    segment: Kernel
    law: IntegerLaw
    smallest_width: int

    state_names: ClassVar[tuple[str, ...]] = ("x",)  # the arrays that `control` takes
    tables: ClassVar[tuple[Table, ...]] = ()

    @property
    def time_kernels(self) -> tuple[Kernel, ...]:
        """The kernel of the segment at a tick, then those of the weights at the position in it."""
        return self.segment, build_weights_kernel()

    @property
    def edge_kernel(self) -> Kernel:
        return build_edge_kernel(self.n)

    def functions(self, task: Task) -> tuple[Function, ...]:
        """Build all functions that are emitted."""
        return self.build_tube(), self.build_control(task), self.build_margin(), self.build_margins(), self.build_covered(task)

    def state_params(self) -> tuple[Param, ...]:
        return tuple(_integers(name, self.n) for name in self.state_names)

    def write_weights(self, block: Block) -> tuple[Var, tuple[Var, ...]]:
        """Write statements for the table index of the segment's first row, and for all weights."""
        segment, *weight_kernels = self.time_kernels
        row, s = block.call(segment, Var("tick", TICK))
        return row, tuple(weight for kernel in weight_kernels for weight in block.call(kernel, s))

    def write_edges(self, block: Block, row: Operand, i: Var, weights: tuple[Var, ...]) -> tuple[tuple[Var, ...], ...]:
        """Write statements for the outputs of the edge kernel for component i: of the lower edge, then of the upper one.

        Each is (edge,), or (edge, rate) for order 2."""
        lower_index = write_first_index(block, row, i)
        upper_index = block.op("at_upper", "iadd", lower_index, integer(UPPER))
        names = [tuple(f"{side}_{output}" for output in self.edge_kernel.output_names) for side in ("lower", "upper")]
        indices_and_names = zip((lower_index, upper_index), names, strict=True)
        return tuple(block.call(self.edge_kernel, index, *weights, names=outputs) for index, outputs in indices_and_names)

    def write_distances(self, block: Block, i: Var, edges: tuple[tuple[Var, ...], ...]) -> StateDistances:
        """Write statements for the distances of component i to these edges, as `write_edges` returns them."""
        (lower,), (upper,) = edges
        distances = write_distances_of(block, "x", i, (lower, upper), LARGEST_STATE)
        return StateDistances(distances, distances)

    def write_is_inside(self, block: Block, offset: Var, width: Var, _distances: StateDistances) -> Var:
        """Write statements for whether the state is inside. offset: |e| times the width, before any clamp."""
        return block.op("within", "ilt", offset, width)

    def build_tube(self) -> Function:
        """Build `tube`: the edges gamma (n,) at a tick."""
        block = Block({"tick", "lower", "upper"})
        row, weights = self.write_weights(block)
        with block.loop("i", self.n) as loop:
            for name, edge in zip(("lower", "upper"), self.write_edges(block, row, loop.index, weights), strict=True):
                block.store(name, loop.index, edge[0])
        block.leave()
        doc = ("Edges of the tube gamma at a tick, in the units of x.", "From the tick of t_c on those at t_c.")
        return Function("tube", edge_params(self.n), tuple(block.statements), returns_status=False, doc=doc)

    def build_control(self, task: Task) -> Function:
        """Build `control`: u (n,) by (13) and the status."""
        is_gain_positive = task.gain[0] > 0
        block = Block({"tick", *self.state_names, "u"})
        row, weights = self.write_weights(block)
        with block.loop("i", self.n) as loop:
            i, is_outside = loop.index, loop.carry("outside", FALSE)
            distances = self.write_distances(block, i, self.write_edges(block, row, i, weights))
            width = write_width(block, "room", distances.of_law)
            size, is_upper_nearer, offset = _write_input_size(block, self.law, i, width, distances.of_law)
            negative_size = block.op("back", "ineg", size)
            u_at_upper, u_at_lower = (negative_size, size) if is_gain_positive else (size, negative_size)
            block.store("u", i, block.select("u_i", is_upper_nearer, u_at_upper, u_at_lower))
            is_inside = self.write_is_inside(block, offset, width, distances)
            loop.update(is_outside, block.select("outside_any", is_inside, is_outside, TRUE))
        block.leave(Select(is_outside, OUTSIDE, OK))
        params = (TICK_PARAM, *self.state_params(), _integers("u", self.n, output=True))
        return Function("control", params, tuple(block.statements), returns_status=True, doc=self.control_doc(task))

    def control_doc(self, task: Task) -> tuple[str, ...]:
        """Return the comment of `control`, in lines."""
        e_max = decimal(self.law.e_max)
        return (
            f"Control law (13), u = -k xi epsilon, k = {by_component(task.gain)}, e clamped to [-{e_max}, {e_max}], u saturated.",
            f"{tick_doc(task)} x: state; u: input.",
            *axes_doc(task),
            "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law and points inward"
            + inward_doc(task)
            + ".",
            "Every value of x is a state: there is no bad input. u may be the array x itself.",
        )

    def build_margin(self) -> Function:
        """Build `margin`: the smallest margin over the components, in 2^-MARGIN_BITS."""
        block = Block({"tick", *self.state_names})
        row, weights = self.write_weights(block)
        with block.loop("i", self.n) as loop:
            smallest = loop.carry("margin", integer(HALF_MARGIN))
            margin = self.write_margin(block, loop.index, row, weights)
            is_smaller = block.op("less", "ilt", margin, smallest)
            loop.update(smallest, block.select("margin_next", is_smaller, margin, smallest))
        block.leave(smallest)
        params = (TICK_PARAM, *self.state_params())
        body = tuple(block.statements)
        return Function("margin", params, body, returns_status=False, doc=self.margin_doc, returns_real=True)

    def write_margin(self, block: Block, i: Var, row: Operand, weights: tuple[Var, ...]) -> Var:
        """Write statements for the margin of component i; for order 2 the smaller one of x and of v + lambda x."""
        distances = self.write_distances(block, i, self.write_edges(block, row, i, weights))
        law_margin = _write_margin_of(block, "share", self.law.smallest_width, distances.of_law)
        if distances.of_x == distances.of_law:
            return law_margin
        x_margin = _write_margin_of(block, "place", self.smallest_width, distances.of_x)
        return block.select("lesser", block.op("filtered_less", "ilt", law_margin, x_margin), law_margin, x_margin)

    def build_margins(self) -> Function:
        """Build `margins`: the margin by component (n,), in 2^-MARGIN_BITS."""
        block = Block({"tick", *self.state_names, "margin"})
        row, weights = self.write_weights(block)
        with block.loop("i", self.n) as loop:
            block.store("margin", loop.index, self.write_margin(block, loop.index, row, weights))
        block.leave()
        params = (TICK_PARAM, *self.state_params(), _integers("margin", self.n, output=True))
        doc = ("The margin of each component, in the same units: which axis is near its edge.",)
        return Function("margins", params, tuple(block.statements), returns_status=False, doc=doc)

    def build_covered(self, task: Task) -> Function:
        """Build `covered`: whether every component of a measured state is that of a covered start."""
        block = Block(set(self.state_names))
        with block.loop("i", self.n) as loop:
            is_covered = loop.carry("covered", TRUE)
            is_inside = self.write_is_covered(block, loop.index)
            loop.update(is_covered, block.select("covered_next", is_inside, is_covered, FALSE))
        block.leave(is_covered)
        body = tuple(block.statements)
        return Function("covered", self.state_params(), body, returns_status=False, doc=covered_doc(task), returns_bool=True)

    def write_is_covered(self, block: Block, i: Var) -> Var:
        """Write statements for whether component i is that of a covered start."""
        return write_is_between_bounds(block, block.let("x_i", Load("x", i, INT)), i, BOUND_TABLES[:2])

    @property
    def margin_doc(self) -> tuple[str, ...]:
        """The comment of `margin`, in lines."""
        return (
            f"How far x is from leaving the tube, in 2^-{MARGIN_BITS}: the distance to the nearest edge over the width there,",
            f"least over the components. {HALF_MARGIN} in the middle, 0 or more inside, else {-2 * HALF_MARGIN} to -1.",
            "Watch it: act while there is margin, not when the tube is left.",
        )


def tick_doc(task: Task) -> str:
    """Return the part of the comment of `control` that explains the tick."""
    assert task.emit.tick_period is not None
    return f"tick: periods of {decimal(task.emit.tick_period)} s since the start (it must not wrap to 0: stop counting at t_c);"


def write_distances_of(block: Block, name: str, i: Var, edges: tuple[Var, Var], largest: int) -> Distances:
    """Write statements for the distances of component i of an array, clamped to [-largest, largest], to two edges."""
    lower, upper = edges
    value = write_clamped_component(block, name, i, largest)
    to_lower = block.op(f"{name}_lower", "isub", value, lower)
    return Distances(to_lower, block.op(f"{name}_upper", "isub", upper, value))


def write_clamped_component(block: Block, name: str, i: Var, largest: int) -> Var:
    """Write statements for component i of an array, clamped to [-largest, largest]."""
    value = block.let(f"{name}_all", Load(name, i, INT))
    return write_at_most(block, f"{name}_i", write_at_least(block, f"{name}_near", value, -largest), integer(largest))


def write_width(block: Block, name: str, distances: Distances) -> Var:
    """Write statements for the width: the sum of both distances."""
    return block.op(name, "iadd", distances.to_lower, distances.to_upper)


class ReciprocalWidth(NamedTuple):
    """A width, at least the smallest that counts; `shifted_width`, the same shifted up by `shift` until its first bit is 1.

    `reciprocal` r has 16 bits: 1/width is r 2^(shift - 46)."""

    width: Var
    shifted_width: Var
    shift: Var
    reciprocal: Var


def _write_reciprocal_width(block: Block, name: str, raw_width: Var, smallest_width: int) -> ReciprocalWidth:
    """Write statements for the reciprocal of a width."""
    width = write_at_least(block, f"{name}_width", raw_width, smallest_width)
    shift = block.op(f"{name}_n", "leading", width)
    shifted_width = block.op(f"{name}_width_up", "ishl", width, shift)
    row_and_t = write_curve_position(block, f"{name}_over", shifted_width, RECIPROCAL_PIECE_BITS, integer(0))
    (reciprocal,) = block.call(build_curve_kernel(), *row_and_t, names=(f"{name}_over",))
    return ReciprocalWidth(width, shifted_width, shift, reciprocal)


def _write_input_size(block: Block, law: IntegerLaw, i: Var, raw_width: Var, distances: Distances) -> tuple[Var, Var, Var]:
    """Write statements for |u| of component i, whether the upper edge is nearer, and |to_lower - to_upper|.

    The last one is |e| times the width."""
    difference = block.op("apart", "isub", *distances)
    over_width = _write_reciprocal_width(block, "e", raw_width, law.smallest_width)
    is_upper_nearer = block.op("upper_nearer", "ilt", integer(0), difference)
    offset = block.select("off", is_upper_nearer, difference, block.op("minus", "ineg", difference))
    clamped_offset = write_at_most(block, "off_held", offset, over_width.width)
    shifted_offset = block.op("off_up", "ishl", clamped_offset, over_width.shift)
    unclamped_e = block.op("e_all", "upper", shifted_offset, over_width.reciprocal)
    e = write_at_most(block, "e", unclamped_e, integer(law.largest_e))
    remainder = block.op("rest", "isub", over_width.shifted_width, shifted_offset)
    unclamped_y = block.op("y_all", "upper", remainder, over_width.reciprocal)
    y = write_at_most(block, "y", write_at_least(block, "y_near", unclamped_y, law.smallest_y), integer(FIXED_ONE - 1))
    row, h = _write_h(block, y)
    h_shift = block.let("rise_places", Load("places", row, INT))
    gain, offset_of_shift, limit = (block.let(name, Load(f"{name}s", i, INT)) for name in ("gain", "offset", "limit"))
    unclamped_shift = block.op("down_all", "isub", block.op("down_n", "isub", offset_of_shift, over_width.shift), h_shift)
    shift = write_at_least(block, "down", unclamped_shift, 0)
    (size,) = block.call(build_push_kernel(), e, h, over_width.reciprocal, gain, shift, limit)
    return size, is_upper_nearer, offset


def _write_h(block: Block, y: Var) -> tuple[Var, Var]:
    """Write statements for the table row of H at y, in 2^-30, and for H, which has 16 bits."""
    shift = block.op("m", "leading", y)
    octave_rows = block.op("octaves", "imul", shift, integer(1 << H_PIECE_BITS))
    first_row = block.op("octave", "iadd", octave_rows, integer(RECIPROCAL_OCTAVES << H_PIECE_BITS))
    row, t = write_curve_position(block, "rise", block.op("y_up", "ishl", y, shift), H_PIECE_BITS, first_row)
    (h,) = block.call(build_curve_kernel(), row, t, names=("rise",))
    return row, h


def _write_margin_of(block: Block, name: str, smallest_width: int, distances: Distances) -> Var:
    """Write statements for the distance to the nearer edge over the width, in 2^-MARGIN_BITS.

    It is at least 0 inside, and from -1 to -2^-MARGIN_BITS outside."""
    to_lower, to_upper = distances
    over_width = _write_reciprocal_width(block, name, write_width(block, f"{name}_room", distances), smallest_width)
    nearest = block.select(f"{name}_nearest", block.op(f"{name}_high", "ilt", to_upper, to_lower), to_upper, to_lower)
    is_inside = block.op(f"{name}_inside", "ilt", integer(0), nearest)
    size = block.select(f"{name}_size", is_inside, nearest, block.op(f"{name}_beyond", "ineg", nearest))
    clamped_size = write_at_most(block, f"{name}_held", size, over_width.width)
    shifted_size = block.op(f"{name}_up", "ishl", clamped_size, over_width.shift)
    quotient = block.op(f"{name}_quotient", "upper", shifted_size, over_width.reciprocal)  # in 2^-30
    unclamped = block.op(f"{name}_part", "ishr", quotient, integer(30 - MARGIN_BITS))
    share = write_at_most(block, f"{name}_most", unclamped, integer(2 * HALF_MARGIN - 1))
    return block.select(name, is_inside, share, block.op(f"{name}_minus", "isub", integer(-1), share))
