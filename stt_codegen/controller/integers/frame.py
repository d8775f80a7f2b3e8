"""The functions of a refined controller in integers, at a tick, for plants of order 1.

The state x and the tube's edges count units of 2^-bits, those of the table; time counts ticks; u counts units of 2^-u_bits. Every
value is an integer of 32 bits. Operations are exact but for what `ishr` and `high_product` drop, which round down; so results are
the same on every board. `program.analyse.ranges` proves that no value leaves 32 bits.

fixed_program.py calls `IntegerController.functions`. Functions named `write_..` append statements to a block of a Program and
return the variables that hold the results. Strings that they pass are names in emitted code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stt_codegen.controller.comments import axes_doc, inward_doc
from stt_codegen.controller.covered_starts import BOUND_TABLES, covered_doc, write_is_between_bounds
from stt_codegen.controller.integers.constants import IntegerLaw
from stt_codegen.controller.integers.integer_kernels import (
    build_edge_kernel,
    build_weights_kernel,
)
from stt_codegen.controller.integers.integer_statements import (
    HALF_MARGIN,
    LARGEST_STATE,
    MARGIN_BITS,
    StateDistances,
    write_clamped_component,
    write_distances_of,
    write_input_size,
    write_margin_of,
    write_width,
)
from stt_codegen.controller.kernels import write_edge_indices
from stt_codegen.decimals import by_component, decimal
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
TICK_PARAM = Param("tick", None, type=TICK)


def _integers(name: str, n: int, *, output: bool = False) -> Param:
    """Return a parameter: an array of n integers."""
    return Param(name, n, output, type=INT)


def edge_params(n: int) -> tuple[Param, ...]:
    """Return the parameters of a function that computes both edges (n,) at a tick."""
    return TICK_PARAM, _integers("lower", n, output=True), _integers("upper", n, output=True)


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
        """The kernel of an edge, from a table index and all weights."""
        return build_edge_kernel(self.n)

    def functions(self, task: Task) -> tuple[Function, ...]:
        """Build all functions that are emitted."""
        return self.build_tube(), self.build_control(task), self.build_margin(), self.build_margins(), self.build_covered(task)

    def state_params(self) -> tuple[Param, ...]:
        """Return the parameters of the state, in the order of `state_names`."""
        return tuple(_integers(name, self.n) for name in self.state_names)

    def write_weights(self, block: Block) -> tuple[Var, tuple[Var, ...]]:
        """Write statements for the table index of the segment's first row, and for all weights."""
        segment, *weight_kernels = self.time_kernels
        row, s = block.call(segment, Var("tick", TICK))
        return row, tuple(weight for kernel in weight_kernels for weight in block.call(kernel, s))

    def write_edges(self, block: Block, row: Operand, i: Var, weights: tuple[Var, ...]) -> tuple[tuple[Var, ...], ...]:
        """Write statements for the outputs of the edge kernel for component i: of the lower edge, then of the upper one.

        Each is (edge,), or (edge, rate) for order 2."""
        names = [tuple(f"{side}_{output}" for output in self.edge_kernel.output_names) for side in ("lower", "upper")]
        indices_and_names = zip(write_edge_indices(block, row, i), names, strict=True)
        return tuple(block.call(self.edge_kernel, index, *weights, names=outputs) for index, outputs in indices_and_names)

    def write_distances(self, block: Block, i: Var, edges: tuple[tuple[Var, ...], ...]) -> StateDistances:
        """Write statements for the distances of component i to these edges, as `write_edges` returns them."""
        (lower,), (upper,) = edges
        x = write_clamped_component(block, "x", i, LARGEST_STATE)
        distances = write_distances_of(block, "", x, (lower, upper))
        return StateDistances(distances, distances)

    def write_is_inside(self, block: Block, offset: Var, width: Var, _distances: StateDistances) -> Var:
        """Write statements for whether the state is inside. offset: |e| times the width, before any clamp."""
        return block.op("inside", "ilt", offset, width)

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
            width = write_width(block, "width", distances.of_law)
            size, is_upper_nearer, offset = write_input_size(block, self.law, i, width, distances.of_law)
            negative_size = block.op("size_minus", "ineg", size)
            u_at_upper, u_at_lower = (negative_size, size) if is_gain_positive else (size, negative_size)
            block.store("u", i, block.select("u_i", is_upper_nearer, u_at_upper, u_at_lower))
            is_inside = self.write_is_inside(block, offset, width, distances)
            loop.update(is_outside, block.select("outside_next", is_inside, is_outside, TRUE))
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
        if distances.of_x == distances.of_law:
            return write_margin_of(block, "x", self.law.smallest_width, distances.of_law)
        z_margin = write_margin_of(block, "z", self.law.smallest_width, distances.of_law)
        x_margin = write_margin_of(block, "x", self.smallest_width, distances.of_x)
        return block.select("smaller", block.op("z_smaller", "ilt", z_margin, x_margin), z_margin, x_margin)

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
