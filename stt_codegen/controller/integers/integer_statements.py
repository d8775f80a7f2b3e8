"""Statements of a controller in integers: distances to the edges, |u| by (13), and the margin, for one component.

frame.py and inertial_integer_frame.py build their functions from these; integer_kernels.py has the kernels and explains the law.
A number "in 2^-k" is an integer that counts units of 2^-k. Functions named `write_..` append statements to a block of a Program
and return the variables that hold the results. Strings that they pass are names in emitted code.
"""

from __future__ import annotations

from typing import NamedTuple

from stt_codegen.controller.integers.constants import FIXED_ONE, IntegerLaw
from stt_codegen.controller.integers.curves import H_PIECE_BITS, RECIPROCAL_PIECE_BITS
from stt_codegen.controller.integers.integer_kernels import (
    build_curve_kernel,
    build_input_size_kernel,
    write_at_least,
    write_at_most,
    write_curve_position,
)
from stt_codegen.program import INT, Block, Load, Var, integer

LARGEST_STATE = 1 << 28  # units; a state that is farther out counts as so far
MARGIN_BITS = 16  # of the fraction of a margin
# The pieces of y in [2^-m, 2^(1 - m)), m from 1 on, stand in the rows from 2^H_PIECE_BITS (m + RECIPROCAL_OCTAVES) on.
RECIPROCAL_OCTAVES = (1 << (RECIPROCAL_PIECE_BITS - H_PIECE_BITS)) - 1
HALF_MARGIN = 1 << (MARGIN_BITS - 1)  # 1/2 in 2^-MARGIN_BITS


class Distances(NamedTuple):
    """How far a value is from the lower and from the upper edge; negative beyond it."""

    to_lower: Var
    to_upper: Var


class StateDistances(NamedTuple):
    """The distances of one component: of the value that the law is about (x, or v + lambda x for order 2), and of x."""

    of_law: Distances
    of_x: Distances


def write_distances_of(block: Block, label: str, value: Var, edges: tuple[Var, Var]) -> Distances:
    """Write statements for the distances of a value to two edges. label: what their names begin with, "v_" for v."""
    lower, upper = edges
    to_lower = block.op(f"{label}to_lower", "isub", value, lower)
    return Distances(to_lower, block.op(f"{label}to_upper", "isub", upper, value))


def write_clamped_component(block: Block, name: str, i: Var, largest: int) -> Var:
    """Write statements for component i of an array, clamped to [-largest, largest]."""
    value = block.let(f"{name}_any", Load(name, i, INT))
    raised = write_at_least(block, name, f"{name}_raised", value, -largest)
    return write_at_most(block, name, f"{name}_i", raised, integer(largest))


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


def _write_reciprocal_width(block: Block, label: str, raw_width: Var, smallest_width: int) -> ReciprocalWidth:
    """Write statements for the reciprocal of a width. label: what names of variables begin with, "x_" for the margin of x."""
    is_wide = block.op(f"{label}wide", "ilt", integer(smallest_width), raw_width)
    width = block.select(f"{label}safe_width", is_wide, raw_width, integer(smallest_width))
    shift = block.op(f"{label}width_shift", "leading", width)
    shifted_width = block.op(f"{label}width_shifted", "ishl", width, shift)
    row_and_t = write_curve_position(block, f"{label}width", shifted_width, RECIPROCAL_PIECE_BITS, integer(0))
    (reciprocal,) = block.call(build_curve_kernel(), *row_and_t, names=(f"{label}reciprocal",))
    return ReciprocalWidth(width, shifted_width, shift, reciprocal)


def write_input_size(block: Block, law: IntegerLaw, i: Var, raw_width: Var, distances: Distances) -> tuple[Var, Var, Var]:
    """Write statements for |u| of component i, whether the upper edge is nearer, and |to_lower - to_upper|.

    The last one is |e| times the width."""
    difference = block.op("difference", "isub", *distances)
    over_width = _write_reciprocal_width(block, "", raw_width, law.smallest_width)
    is_upper_nearer = block.op("upper_nearer", "ilt", integer(0), difference)
    minus = block.op("difference_minus", "ineg", difference)
    offset = block.select("offset", is_upper_nearer, difference, minus)
    clamped_offset = write_at_most(block, "offset", "offset_limited", offset, over_width.width)
    shifted_offset = block.op("offset_shifted", "ishl", clamped_offset, over_width.shift)
    unclamped_e = block.op("e_any", "high_product", shifted_offset, over_width.reciprocal)
    e = write_at_most(block, "e", "e_limited", unclamped_e, integer(law.largest_e))
    remainder = block.op("remainder", "isub", over_width.shifted_width, shifted_offset)
    unclamped_y = block.op("y_any", "high_product", remainder, over_width.reciprocal)
    y_raised = write_at_least(block, "y", "y_raised", unclamped_y, law.smallest_y)
    row, h = _write_h(block, write_at_most(block, "y", "y_limited", y_raised, integer(FIXED_ONE - 1)))
    h_shift = block.let("h_shift", Load("h_shifts", row, INT))
    gain, shift_offset, limit = (block.let(name, Load(f"{name}s", i, INT)) for name in ("gain", "shift_offset", "limit"))
    without_width = block.op("less_width_shift", "isub", shift_offset, over_width.shift)
    shift = write_at_least(block, "shift", "shift", block.op("shift_any", "isub", without_width, h_shift), 0)
    (size,) = block.call(build_input_size_kernel(), e, h, over_width.reciprocal, gain, shift, limit)
    return size, is_upper_nearer, offset


def _write_h(block: Block, y: Var) -> tuple[Var, Var]:
    """Write statements for the table row of H at y, in 2^-30, and for H, which has 16 bits."""
    shift = block.op("y_shift", "leading", y)
    octave_rows = block.op("octave_rows", "imul", shift, integer(1 << H_PIECE_BITS))
    first_row = block.op("first_row", "iadd", octave_rows, integer(RECIPROCAL_OCTAVES << H_PIECE_BITS))
    row, t = write_curve_position(block, "y", block.op("y_shifted", "ishl", y, shift), H_PIECE_BITS, first_row)
    (h,) = block.call(build_curve_kernel(), row, t, names=("h",))
    return row, h


def write_margin_of(block: Block, label: str, smallest_width: int, distances: Distances) -> Var:
    """Write statements for the distance to the nearer edge over the width, in 2^-MARGIN_BITS.

    It is at least 0 inside, and from -1 to -2^-MARGIN_BITS outside. label: of what is between the edges, "z" for v + lambda x."""
    to_lower, to_upper = distances
    width = write_width(block, f"{label}_width", distances)
    over_width = _write_reciprocal_width(block, f"{label}_", width, smallest_width)
    nearest = block.select(f"{label}_distance", block.op(f"{label}_nearer", "ilt", to_upper, to_lower), to_upper, to_lower)
    is_inside = block.op(f"{label}_inside", "ilt", integer(0), nearest)
    size = block.select(f"{label}_size", is_inside, nearest, block.op(f"{label}_distance_minus", "ineg", nearest))
    clamped_size = write_at_most(block, f"{label}_size", f"{label}_size_limited", size, over_width.width)
    shifted_size = block.op(f"{label}_size_shifted", "ishl", clamped_size, over_width.shift)
    quotient = block.op(f"{label}_quotient", "high_product", shifted_size, over_width.reciprocal)  # in 2^-30
    unclamped = block.op(f"{label}_share_any", "ishr", quotient, integer(30 - MARGIN_BITS))
    share = write_at_most(block, f"{label}_share", f"{label}_share", unclamped, integer(2 * HALF_MARGIN - 1))
    minus = block.op(f"{label}_share_minus", "isub", integer(-1), share)
    return block.select(f"margin_{label}", is_inside, share, minus)
