"""What the functions of a controller of order 2 are built from, in floating point: lambda, and distances to the filtered tube.

v + lambda x is kept in the filtered tube (designs/filtered.py) by the law of order 1. Its distances to the edges are sums that
lose no digits where both edges are near; L and R are the edges of the tube, L' and R' their rates:

    a = (v - L') + lambda (x - L),    b = (R' - v) + lambda (R - x),    a + b = (R' - L') + lambda (R - L)

../inertial_frame.py builds the functions. Functions named `write_..` append statements to a block of a Program and return the
variables that hold the results. Strings that they pass are names in emitted code.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from stt_codegen.controller.kernels.edge_distances import ValueBetweenEdges
from stt_codegen.controller.kernels.spline import SplineKernels, write_edge, write_edge_indices, write_edges
from stt_codegen.decimals import by_component
from stt_codegen.designs import RefinedDesign
from stt_codegen.program import Block, Load, Operand, Table, Var, real


@dataclass(frozen=True)
class LambdaFilter:
    """lambda of v + lambda x by component, in 1/s; and the number of the tube's segments per second."""

    values: tuple[Fraction, ...]
    segments_per_second: Fraction

    @classmethod
    def of(cls, design: RefinedDesign) -> LambdaFilter:
        """Take lambda and the speed of spline time from a design of order 2."""
        return cls(design.filter, Fraction(design.segments) / design.prescribed_time)

    def __str__(self) -> str:
        """The values as comments of emitted code print them."""
        return by_component(self.values)

    @property
    def tables(self) -> list[Table]:
        """The table of lambda where it differs by component; else none."""
        doc = ("lambda of v + lambda x, by component.",)
        return [Table("filter", self.values, len(self.values), doc)] if len(set(self.values)) > 1 else []

    def write_component(self, block: Block, i: Operand) -> Operand:
        """Write statements for lambda of component i."""
        return real(self.values[0]) if len(set(self.values)) == 1 else block.let("filter_i", Load("filter", i))


@dataclass(frozen=True)
class ComputedDistances:
    """The distance between two edges, and the distances of a value to both, in variables that have been computed."""

    raw_width: Var
    to_edges: tuple[Var, Var]

    @classmethod
    def of(cls, block: Block, value: ValueBetweenEdges) -> ComputedDistances:
        """Write the statements that compute them."""
        return cls(value.write_raw_width(block), value.write_distances(block))

    def write_raw_width(self, _block: Block) -> Var:
        """Return the width; it needs no statement."""
        return self.raw_width

    def write_distances(self, _block: Block) -> tuple[Var, Var]:
        """Return the distances; they need no statement."""
        return self.to_edges


@dataclass(frozen=True)
class FilteredDistances:
    """The distances of v + lambda x to the filtered tube's edges, from those of x to the edges and of v to their rates."""

    of_x: ComputedDistances
    of_v: ComputedDistances
    lambda_: Operand

    def write_raw_width(self, block: Block) -> Var:
        """Write statements for the width of the filtered tube."""
        return self._write_sum(block, "width", self.of_v.raw_width, self.of_x.raw_width)

    def write_distances(self, block: Block) -> tuple[Var, Var]:
        """Write statements for the distances of v + lambda x to both edges."""
        (v_to_lower, v_to_upper), (x_to_lower, x_to_upper) = self.of_v.to_edges, self.of_x.to_edges
        to_lower = self._write_sum(block, "to_lower", v_to_lower, x_to_lower)
        return to_lower, self._write_sum(block, "to_upper", v_to_upper, x_to_upper)

    def _write_sum(self, block: Block, name: str, v_distance: Var, x_distance: Var) -> Var:
        """Write statements for v_distance + lambda x_distance."""
        part = block.op(f"{name.removeprefix('to_')}_part", "mul", x_distance, self.lambda_)
        return block.op(f"z_{name}", "add", v_distance, part)


class SplinePosition(NamedTuple):
    """Where a time is on the spline: table index of the segment's first row, and the weights of edges and of their slopes."""

    row: Var
    weights: tuple[Var, ...]
    slope_weights: tuple[Var, ...]


class EdgesAndRates(NamedTuple):
    """Lower and upper edge of one component, and their rates in units per second."""

    lower: Var
    upper: Var
    lower_rate: Var
    upper_rate: Var


@dataclass(frozen=True)
class InertialParts:
    """What the functions of a controller of order 2 are built from: kernels, lambda, and the number n of dimensions."""

    spline: SplineKernels
    filter: LambdaFilter
    n: int

    def write_position(self, block: Block, time: Var) -> SplinePosition:
        """Write statements for the position of a time on the spline: seconds, or a tick where the segment kernel takes it."""
        row, s = block.call(self.spline.segment, time)
        return SplinePosition(row, block.call(self.spline.basis, s), block.call(self.spline.basis_rate, s))

    def write_edges(self, block: Block, position: SplinePosition, i: Operand) -> EdgesAndRates:
        """Write statements for L, R, L', R' of component i."""
        indices = write_edge_indices(block, position.row, i)
        edges = write_edges(block, self.spline, indices, position.weights)
        rates: list[Var] = []
        for index, name in zip(indices, ("lower", "upper"), strict=True):
            slope = write_edge(block, self.spline, index, position.slope_weights, f"{name}_slope")
            rates.append(block.op(f"{name}_rate", "mul", slope, real(self.filter.segments_per_second)))
        return EdgesAndRates(*edges, *rates)

    def write_filtered_distances(self, block: Block, position: SplinePosition, i: Operand) -> FilteredDistances:
        """Write statements for the distances of component i of v + lambda x, and of x, to their edges."""
        edges = self.write_edges(block, position, i)
        x, v = (block.let(f"{name}_i", Load(name, i)) for name in ("x", "v"))
        of_x = ComputedDistances.of(block, ValueBetweenEdges(edges.lower, edges.upper, x))
        of_v = ComputedDistances.of(block, ValueBetweenEdges(edges.lower_rate, edges.upper_rate, v, "v_"))
        return FilteredDistances(of_x, of_v, self.filter.write_component(block, i))
