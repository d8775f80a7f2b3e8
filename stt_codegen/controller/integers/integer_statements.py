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
    build_push_kernel,
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


def write_input_size(block: Block, law: IntegerLaw, i: Var, raw_width: Var, distances: Distances) -> tuple[Var, Var, Var]:
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


def write_margin_of(block: Block, name: str, smallest_width: int, distances: Distances) -> Var:
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
