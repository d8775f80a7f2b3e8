"""The frames of order 2 in integers: v + lambda x is held in the filtered tube, from the distances of ../inertial_frame.py.
v counts the units of x a second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from stt_codegen.controller.comments import axes_doc, inward_doc
from stt_codegen.controller.covered_starts import NAMES, between_bounds
from stt_codegen.controller.integers.constants import table
from stt_codegen.controller.integers.frame import (
    FARTHEST,
    HALF_MARGIN,
    MARGIN_BITS,
    Frame,
    State,
    between,
    held_within,
    sides,
    ticks_doc,
)
from stt_codegen.controller.integers.integer_kernels import Rate, moving_edge_kernel, rates_kernel
from stt_codegen.decimals import by_component
from stt_codegen.errors import BadInput
from stt_codegen.program import INT, Block, Function, Kernel, Load, Operand, Table, Var, integer
from stt_codegen.task import Task


@dataclass(frozen=True)
class Filter:
    """lambda by component: whole numbers of 2^-bits; all below 2^16."""

    values: tuple[Fraction, ...]
    bits: int

    @classmethod
    def of(cls, values: tuple[Fraction, ...]) -> Filter:
        """Raises `BadInput` for a lambda that is not exact in 16 bits, or is too large."""
        bits = 16 - max(0, *(math.frexp(float(v))[1] for v in values))
        if bits < 14 or any((v * 2**bits).denominator > 1 for v in values):
            raise BadInput(f"tube.filter: is {by_component(values)}; in integers it must be below 4, and of 16 bits")
        return cls(values, bits)

    @property
    def whole(self) -> tuple[int, ...]:
        return tuple(int(v * 2**self.bits) for v in self.values)

    @property
    def table(self) -> Table:
        return table("filters", self.whole, len(self.values), f"lambda by component, in 2^-{self.bits}.")

    def times(self, block: Block, name: str, value: Var, whole: Operand) -> Var:
        """Statements for lambda times a distance, rounded down."""
        moved = value if self.bits == 16 else block.op(f"{name}_more", "imul", value, integer(1 << (16 - self.bits)))
        return block.op(name, "upper", moved, whole)


@dataclass(frozen=True)
class InertialFrame(Frame):
    """For a plant of order 2: the law goes by v + lambda x in the filtered tube, as in controller/inertial_frame.py."""

    rate: Rate
    filter: Filter

    vectors: ClassVar[tuple[str, ...]] = ("x", "v")

    @property
    def tables(self) -> tuple[Table, ...]:  # type: ignore[override]
        return (self.filter.table,)

    @property
    def of_time(self) -> tuple[Kernel, ...]:
        return (*super().of_time, rates_kernel(self.rate))

    @property
    def edge(self) -> Kernel:
        return moving_edge_kernel(self.n, self.rate)

    def functions(self, task: Task) -> tuple[Function, ...]:
        return self.tube(), self.filtered_tube(), self.control(task), self.margin(), self.margins(), self.covered(task)

    def apart(self, block: Block, i: Var, edges: tuple[tuple[Var, ...], ...]) -> tuple[State, State]:
        (lower, lower_rate), (upper, upper_rate) = edges
        place = between(block, "x", i, lower, upper, FARTHEST >> 2)
        speed = between(block, "v", i, lower_rate, upper_rate, FARTHEST)
        whole = block.let("filter_i", Load("filters", i, INT))
        to_lower, to_upper = (
            block.op(f"to_{side}", "iadd", v, self.filter.times(block, f"{side}_filtered", x, whole))
            for side, v, x in zip(("lower", "upper"), speed, place, strict=True)
        )
        return (to_lower, to_upper), place

    def covered_component(self, block: Block, i: Var) -> Var:
        x, v = (held_within(block, name, i, farthest) for name, farthest in (("x", FARTHEST >> 2), ("v", FARTHEST)))
        filtered = self.filter.times(block, "filtered", x, block.let("filter_i", Load("filters", i, INT)))
        z = block.op("z", "iadd", v, filtered)
        places, sums = (between_bounds(block, value, i, names) for value, names in ((x, NAMES[:2]), (z, NAMES[2:])))
        return block.op("inside", "and", places, sums)

    def inside(self, block: Block, off: Var, room: Var, states: tuple[State, State]) -> Var:
        x_lower, x_upper = states[1]
        own = super().inside(block, off, room, states)
        over, under = (block.op(name, "ilt", integer(0), v) for name, v in (("over", x_lower), ("under", x_upper)))
        return block.op("inside", "and", own, block.op("between", "and", over, under))

    def filtered_tube(self) -> Function:
        block = Block({"tick", "lower", "upper"})
        row, weights = self.begun(block)
        with block.loop("i", self.n) as loop:
            whole = block.let("filter_i", Load("filters", loop.index, INT))
            edges = self.edges(block, row, loop.index, weights)
            for name, (place, rate) in zip(("lower", "upper"), edges, strict=True):
                held = self.filter.times(block, f"{name}_filtered", place, whole)
                block.store(name, loop.index, block.op(f"{name}_z", "iadd", rate, held))
        block.leave()
        doc = (
            "Edges of the filtered tube at a tick, in units a second: of v + lambda x,",
            f"lambda = {by_component(self.filter.values)}.",
            "While v + lambda x is between them, x stays in the tube.",
        )
        return Function("filtered_tube", sides(self.n), tuple(block.statements), False, doc)

    def control_doc(self, task: Task) -> tuple[str, ...]:
        first = super().control_doc(task)[0]
        return (
            first.removesuffix(".") + ",",
            f"for v + lambda x in its tube, lambda = {by_component(self.filter.values)}.",
            ticks_doc(task),
            "x: state; v: its rate; u: input.",
            *axes_doc(task),
            "OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law and",
            f"points inward{inward_doc(task)}. Every value of x and v is a state: there is no bad input.",
            "u may be the array x or v itself.",
        )

    @property
    def margin_doc(self) -> tuple[str, ...]:
        return (
            f"How far x is from leaving the tube, and v + lambda x from leaving its own, in 2^-{MARGIN_BITS}: the distance to",
            "the nearest edge over the width there, the lesser of both, least over the components.",
            f"{HALF_MARGIN} in the middle, 0 or more inside, negative outside, at least {-2 * HALF_MARGIN}.",
            "Watch it: act while there is margin, not when the tube is left.",
        )
