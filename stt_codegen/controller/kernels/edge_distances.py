"""The distances of one component of the state to its edges, as the law and the margin use them, for every kind of tube.

law.py and the files *_frame.py of controller/ call this file. Functions named `write_..` append statements to a block of a
Program and return the variables that hold the results. Strings that they pass are names in emitted code.

Clamping e to [-e_max, e_max] is the same as keeping both distances a = x - gamma_L and b = gamma_U - x within
[c, 1 - c] times the width, c = (1 - e_max) / 2. Only the lesser of them can be below c, and the other one is the rest of the
width: so one comparison clamps, nothing overflows and no division is by zero, whatever x is. The lemma `transform.clamp` proves
the first sentence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

from stt_codegen.designs import MINIMUM_WIDTH
from stt_codegen.program import Block, Load, Operand, Var, real


class EdgeDistances(Protocol):
    """What the law needs of one component: the distance between its two edges, and its distances to both."""

    def write_raw_width(self, block: Block) -> Var:
        """Write statements for the distance from the lower to the upper edge, which may be negative."""

    def write_distances(self, block: Block) -> tuple[Var, Var]:
        """Write statements for the distances to the lower and to the upper edge, negative beyond them."""


@dataclass(frozen=True)
class ValueBetweenEdges:
    """A number x and its two edges; x may also lie outside of them. label: what names of variables begin with, "v_" for v."""

    lower: Operand
    upper: Operand
    x: Operand
    label: str = ""

    def write_raw_width(self, block: Block) -> Var:
        """Write statements for upper - lower, which is negative or 0 where the tube is empty."""
        return block.op(f"{self.label}width", "sub", self.upper, self.lower)

    def write_distances(self, block: Block) -> tuple[Var, Var]:
        """Write statements for x - lower and upper - x."""
        to_lower = block.op(f"{self.label}to_lower", "sub", self.x, self.lower)
        return to_lower, block.op(f"{self.label}to_upper", "sub", self.upper, self.x)


@dataclass(frozen=True, kw_only=True)
class ClampedDistances:
    """The distances of a component to its edges as the law uses them.

    `nearest` is the distance to the nearer edge, negative outside. `gain` is k, or -k where the upper edge is nearer.
    `clamped_near` and `clamped_far` are the distances to the nearer and the farther edge after the clamp of e; they add up to
    `width`, which is `raw_width` = upper - lower, but at least MINIMUM_WIDTH. `is_empty` says whether the raw width is at most
    0; it is None where the caller has proved that it never is."""

    nearest: Var
    is_upper_nearer: Var
    gain: Var
    clamped_near: Var
    clamped_far: Var
    width: Var
    raw_width: Var
    is_empty: Var | None


def _write_nearest_distance(block: Block, distances: EdgeDistances, names: tuple[str, str]) -> tuple[Var, Var]:
    """Write statements for the distance to the nearer edge, and for whether that is the upper one.

    names: of the two variables, in the order of their statements: the truth value, the distance. Between two edges the distance
    is above 0 exactly where lower < x < upper: a difference of two numbers has the sign of their comparison, gradual underflow
    included."""
    to_lower, to_upper = distances.write_distances(block)
    is_upper_nearer = block.op(names[0], "lt", to_upper, to_lower)
    return block.select(names[1], is_upper_nearer, to_upper, to_lower), is_upper_nearer


def _write_guarded_width(block: Block, raw_width: Var) -> Var:
    """Write statements for the width, MINIMUM_WIDTH where it is less."""
    is_wide = block.op("wide", "lt", real(MINIMUM_WIDTH), raw_width)
    return block.select("safe_width", is_wide, raw_width, real(MINIMUM_WIDTH))


def write_clamped_distances(
    block: Block,
    clamp_share: Operand,
    distances: EdgeDistances,
    signed_gain: tuple[Operand, Operand],
    *,
    is_width_guarded: bool = True,
    gain_name: str = "gain",
) -> ClampedDistances:
    """Write statements for the clamped distances of one component.

    With c = `clamp_share`, the near one is within [c, 1/2] and the far one within [1/2, 1 - c] of the width, roundings apart.
    A NaN counts as outside. signed_gain: k and -k. is_width_guarded=False: the caller has proved that the edges are more than
    MINIMUM_WIDTH apart."""
    raw_width = distances.write_raw_width(block)
    is_filled = block.op("filled", "lt", real(0), raw_width) if is_width_guarded else None
    is_empty = block.op("empty", "not", is_filled) if is_filled is not None else None
    width = _write_guarded_width(block, raw_width) if is_width_guarded else raw_width
    nearest, is_upper_nearer = _write_nearest_distance(block, distances, ("upper_nearer", "distance"))
    gain = block.select(gain_name, is_upper_nearer, signed_gain[1], signed_gain[0])
    smallest_distance = block.op("smallest", "mul", width, clamp_share)
    if is_filled is None:
        is_clear = block.op("clear", "lt", smallest_distance, nearest)
        clamped_near = block.select("to_nearer", is_clear, nearest, smallest_distance)
    else:  # a narrower tube counts as widened about its middle; in an empty one, or where a number is NaN, e is at its clamp
        added_width = block.op("widened", "sub", width, raw_width)
        distance = block.op("safe_distance", "add", nearest, block.op("half", "mul", added_width, real(Fraction(1, 2))))
        is_clear = block.op("clear", "and", is_filled, block.op("farther", "lt", smallest_distance, distance))
        clamped_near = block.select("to_nearer", is_clear, distance, smallest_distance)
    return ClampedDistances(
        nearest=nearest,
        is_upper_nearer=is_upper_nearer,
        gain=gain,
        clamped_near=clamped_near,
        clamped_far=block.op("to_farther", "sub", width, clamped_near),
        width=width,
        raw_width=raw_width,
        is_empty=is_empty,
    )


def write_is_inside(block: Block, distances: ClampedDistances, name: str = "inside") -> Var:
    """Write statements for lower < x < upper, false in an empty tube."""
    return block.op(name, "lt", real(0), distances.nearest)


def write_margin(block: Block, distances: EdgeDistances, *, label: str = "x", is_width_guarded: bool = True) -> Var:
    """Write statements for the distance to the nearer edge over the width, at least -1.

    label: of what is between the edges, "z" for v + lambda x. is_width_guarded: as in `write_clamped_distances`."""
    raw_width = distances.write_raw_width(block)
    width = _write_guarded_width(block, raw_width) if is_width_guarded else raw_width
    nearest, _ = _write_nearest_distance(block, distances, (f"{label}_nearer", f"{label}_distance"))
    share = block.op(f"{label}_share", "div", nearest, width)
    is_far_outside = block.op(f"{label}_beyond", "lt", share, real(-1))
    return block.select(f"margin_{label}", is_far_outside, real(-1), share)


MARGIN_DOC = (
    "How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the",
    "components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.",
    "Watch it: act while there is margin, not when the tube is left.",
)


MARGINS_DOC = (
    "The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all",
    "components where another argument is not finite.",
)


def write_has_non_finite(block: Block, scalars: Sequence[Var], arrays: Sequence[tuple[str, int]]) -> Var:
    """Write statements for whether any of these numbers is a NaN or an infinity. `arrays`: names and lengths of one or two.

    0 times such a number is NaN, and so is the sum of all these products, which else is 0: one comparison tests them all."""
    total: Operand = real(0)
    for k, scalar in enumerate(scalars):
        term = block.op(f"{scalar.name}_zero", "mul", scalar, real(0))
        total = block.op("both_zero", "add", total, term) if k else term
    for k, (array, length) in enumerate(arrays):
        index, carried, next_name = ("k", f"{array}_zeros", f"{array}_sum") if k else ("j", "zero", "zeros")
        with block.loop(index, length) as loop:
            partial_sum = loop.carry(carried, total)
            term = block.op(f"{array}_zero", "mul", block.let(f"{array}_{index}", Load(array, loop.index)), real(0))
            loop.update(partial_sum, block.op(next_name, "add", partial_sum, term))
        total = partial_sum
    return block.op("bad", "not", block.op("finite", "le", total, real(0)))
