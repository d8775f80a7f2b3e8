"""The functions of a controller in integers for plants of order 2: v + lambda x is kept in the filtered tube.

The distances are those of ../inertial_frame.py. v counts the units of x a second. fixed_program.py calls
`InertialIntegerController.functions`. Functions named `write_..` append statements to a block of a Program and return the
variables that hold the results. Strings that they pass are names in emitted code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from stt_codegen.controller.comments import axes_doc, inward_doc
from stt_codegen.controller.covered_starts import BOUND_TABLES, write_is_between_bounds
from stt_codegen.controller.integers.constants import integer_table
from stt_codegen.controller.integers.frame import IntegerController, edge_params, tick_doc
from stt_codegen.controller.integers.integer_kernels import RateScale, build_edge_and_rate_kernel, build_rate_weights_kernel
from stt_codegen.controller.integers.integer_statements import (
    HALF_MARGIN,
    LARGEST_STATE,
    MARGIN_BITS,
    Distances,
    StateDistances,
    write_clamped_component,
    write_distances_of,
)
from stt_codegen.decimals import by_component
from stt_codegen.errors import BadInput
from stt_codegen.program import INT, Block, Function, Kernel, Load, Operand, Table, Var, integer
from stt_codegen.task import Task

LARGEST_POSITION = LARGEST_STATE >> 2  # units: lambda, below 4, times it is then at most LARGEST_STATE


@dataclass(frozen=True)
class IntegerLambdaFilter:
    """lambda of v + lambda x by component, in 1/s: multiples of 2^-bits, which are numbers of 16 bits."""

    values: tuple[Fraction, ...]
    bits: int

    @classmethod
    def of(cls, values: tuple[Fraction, ...]) -> IntegerLambdaFilter:
        """Choose the bits. Raises `BadInput` for a lambda that is not exact in 16 bits, or is 4 or more."""
        bits = 16 - max(0, *(math.frexp(float(v))[1] for v in values))
        if bits < 14 or any((v * 2**bits).denominator > 1 for v in values):
            raise BadInput(f"tube.filter: is {by_component(values)}; in integers it must be below 4, and of 16 bits")
        return cls(values, bits)

    @property
    def table(self) -> Table:
        """The values in 2^-bits."""
        multiples = tuple(int(v * 2**self.bits) for v in self.values)
        return integer_table("filters", multiples, len(multiples), f"lambda by component, in 2^-{self.bits}.")

    def write_component(self, block: Block, i: Operand) -> Var:
        """Write statements for lambda of component i, in 2^-bits."""
        return block.let("filter_i", Load("filters", i, INT))

    def write_product(self, block: Block, label: str, value: Var, lambda_: Operand) -> Var:
        """Write statements for lambda times a value, rounded down, called <label>_part; lambda in 2^-bits."""
        shifted = value if self.bits == 16 else block.op(f"{label}_scaled", "imul", value, integer(1 << (16 - self.bits)))
        return block.op(f"{label}_part", "high_product", shifted, lambda_)


@dataclass(frozen=True)
class InertialIntegerController(IntegerController):
    """Builds the functions of a controller in integers, for order 2: the law is about v + lambda x in the filtered tube.

    What it overrides is described in IntegerController."""

    rate_scale: RateScale
    filter: IntegerLambdaFilter

    state_names: ClassVar[tuple[str, ...]] = ("x", "v")

    @property
    def tables(self) -> tuple[Table, ...]:  # type: ignore[override]
        """The table of lambda."""
        return (self.filter.table,)

    @property
    def time_kernels(self) -> tuple[Kernel, ...]:
        """Those of order 1, then the kernel of the weights for rates."""
        return (*super().time_kernels, build_rate_weights_kernel(self.rate_scale))

    @property
    def edge_kernel(self) -> Kernel:
        """The kernel of an edge and its rate."""
        return build_edge_and_rate_kernel(self.n, self.rate_scale)

    def functions(self, task: Task) -> tuple[Function, ...]:
        """Build all functions that are emitted: those of order 1, and `filtered_tube` behind `tube`."""
        tube, *later_functions = super().functions(task)
        return (tube, self.build_filtered_tube(), *later_functions)

    def write_distances(self, block: Block, i: Var, edges: tuple[tuple[Var, ...], ...]) -> StateDistances:
        """Write statements for the distances of v + lambda x to the filtered edges, and of x to its edges."""
        (lower, lower_rate), (upper, upper_rate) = edges
        x = write_clamped_component(block, "x", i, LARGEST_POSITION)
        of_x = write_distances_of(block, "", x, (lower, upper))
        v = write_clamped_component(block, "v", i, LARGEST_STATE)
        of_v = write_distances_of(block, "v_", v, (lower_rate, upper_rate))
        lambda_ = self.filter.write_component(block, i)
        to_lower, to_upper = (
            block.op(f"z_to_{side}", "iadd", to_rate, self.filter.write_product(block, side, to_edge, lambda_))
            for side, to_rate, to_edge in zip(("lower", "upper"), of_v, of_x, strict=True)
        )
        return StateDistances(Distances(to_lower, to_upper), of_x)

    def write_is_covered(self, block: Block, i: Var) -> Var:
        """Write statements for whether component i of x and of v + lambda x are those of a covered start."""
        x = write_clamped_component(block, "x", i, LARGEST_POSITION)
        v = write_clamped_component(block, "v", i, LARGEST_STATE)
        z = block.op("z_i", "iadd", v, self.filter.write_product(block, "x", x, self.filter.write_component(block, i)))
        is_x_covered = write_is_between_bounds(block, x, i, BOUND_TABLES[:2])
        is_z_covered = write_is_between_bounds(block, z, i, BOUND_TABLES[2:])
        return block.op("inside", "and", is_x_covered, is_z_covered)

    def write_is_inside(self, block: Block, offset: Var, width: Var, distances: StateDistances) -> Var:
        """Write statements for whether v + lambda x and x are inside their tubes. offset, width: of v + lambda x."""
        is_z_inside = block.op("z_inside", "ilt", offset, width)
        is_above = block.op("x_above", "ilt", integer(0), distances.of_x.to_lower)
        is_below = block.op("x_below", "ilt", integer(0), distances.of_x.to_upper)
        return block.op("inside", "and", is_z_inside, block.op("x_inside", "and", is_above, is_below))

    def build_filtered_tube(self) -> Function:
        """Build `filtered_tube`: the edges of the filtered tube (n,) at a tick, in units of x per second."""
        block = Block({"tick", "lower", "upper"})
        row, weights = self.write_weights(block)
        with block.loop("i", self.n) as loop:
            lambda_ = self.filter.write_component(block, loop.index)
            edges_and_rates = self.write_edges(block, row, loop.index, weights)
            for name, (edge, rate) in zip(("lower", "upper"), edges_and_rates, strict=True):
                product = self.filter.write_product(block, name, edge, lambda_)
                block.store(name, loop.index, block.op(f"z_{name}", "iadd", rate, product))
        block.leave()
        doc = (
            "Edges of the filtered tube at a tick, in units a second: of v + lambda x,",
            f"lambda = {by_component(self.filter.values)}.",
            "While v + lambda x is between them, x stays in the tube.",
        )
        return Function("filtered_tube", edge_params(self.n), tuple(block.statements), returns_status=False, doc=doc)

    def control_doc(self, task: Task) -> tuple[str, ...]:
        """Return the comment of `control`, in lines."""
        law_line = super().control_doc(task)[0]
        return (
            law_line.removesuffix(".") + ",",
            f"for v + lambda x in its tube, lambda = {by_component(self.filter.values)}.",
            tick_doc(task),
            "x: state; v: its rate; u: input.",
            *axes_doc(task),
            "OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law and",
            f"points inward{inward_doc(task)}. Every value of x and v is a state: there is no bad input.",
            "u may be the array x or v itself.",
        )

    @property
    def margin_doc(self) -> tuple[str, ...]:
        """The comment of `margin`, in lines."""
        return (
            f"How far x is from leaving the tube, and v + lambda x from leaving its own, in 2^-{MARGIN_BITS}: the distance to",
            "the nearest edge over the width there, the lesser of both, least over the components.",
            f"{HALF_MARGIN} in the middle, 0 or more inside, negative outside, at least {-2 * HALF_MARGIN}.",
            "Watch it: act while there is margin, not when the tube is left.",
        )
