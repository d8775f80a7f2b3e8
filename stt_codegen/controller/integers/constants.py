"""The constants of the control law (13) in integers, for one task and tube, and their tables in the emitted code.

fixed_program.py and frame.py build the controller from them; integer_kernels.py explains the arithmetic that they are for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from stt_codegen.controller.integers.curves import H_PIECE_BITS, h_pieces, reciprocal_pieces
from stt_codegen.controller.integers.integer_kernels import HALF_WORD
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import LOWER, UPPER, RefinedDesign, filtered_edges
from stt_codegen.errors import BadInput
from stt_codegen.program import INT, Table, round_down
from stt_codegen.task import Task

SMALLEST_LAW_WIDTH = 256  # units of x: the law takes a narrower tube to be so wide
WIDTH_ERROR_LIMIT = 64  # units of x: the arithmetic changes the width by at most so much, of a tube whose width matters
FIXED_ONE = 1 << 30  # the number 1 in the units 2^-30 of e and y
# Over |e|: the product that the kernel `input_size` shifts is above it, as H > 0.43 2^16, and r and the gain > 0.49 2^16.
SMALLEST_PRODUCT = FIXED_ONE >> 4
RECIPROCAL_ERROR_LIMIT = Fraction(1, 1 << 13)  # a relative error that 1/width does not reach


@dataclass(frozen=True)
class IntegerLaw:
    """The constants of (13) in integers.

    x counts units of 2^-bits. The width of the tube that the law calculates with is at least `smallest_width` units."""

    gain: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...]
    e_max: Fraction
    bits: int
    smallest_width: int

    @property
    def largest_e(self) -> int:
        """The clamp of |e| in 2^-30: not below e_max, whatever the error of 1/width."""
        return min(FIXED_ONE - 1, math.ceil(self.e_max * (1 + RECIPROCAL_ERROR_LIMIT) * FIXED_ONE))

    @property
    def smallest_y(self) -> int:
        """The lower clamp of y = 1 - |e| in 2^-30: not above 1 - e_max, whatever the error of 1/width."""
        return math.floor((1 - self.e_max) * (1 - RECIPROCAL_ERROR_LIMIT) * FIXED_ONE)

    @property
    def octaves(self) -> int:
        """The number of octaves [2^-m, 2^(1 - m)), from m = 1 on, that y may be in."""
        return 31 - self.smallest_y.bit_length()

    @cached_property
    def h_shifts(self) -> tuple[int, ...]:
        """By piece of H, the number of bits by which u is shifted up for it.

        All are at least 0: a piece near y = 1 has one bit less than the first, which has 1."""
        pieces = h_pieces(self.octaves)
        return tuple(piece.shift - pieces[0].shift + 1 for piece in pieces)

    @cached_property
    def h_shift_base(self) -> int:
        """An entry s of `h_shifts` stands for the factor 2^(s - h_shift_base)."""
        return 1 - h_pieces(self.octaves)[0].shift

    def _split_gain(self, gain: Fraction, u_bits: int) -> tuple[int, int]:
        """Return mantissa of 16 bits and exponent of the gain that takes units of x to units of 2^-u_bits of u."""
        scaled_gain = gain * Fraction(2) ** (self.bits + u_bits)
        exponent = math.frexp(float(scaled_gain))[1] - 16
        mantissa = round(scaled_gain / Fraction(2) ** exponent)
        return (mantissa, exponent) if mantissa < HALF_WORD else (mantissa >> 1, exponent + 1)

    @cached_property
    def u_bits(self) -> int:
        """The largest number of bits of u's fraction with which |u| below u_max is computed without an upward shift.

        The kernel `input_size` only shifts its product down. So a product that would have to be shifted up must be beyond u_max.
        Raises `BadInput` where some u_max then has fewer than 20 bits."""
        width_shift = 31 - self.smallest_width.bit_length()  # of the narrowest tube
        largest_bits = 30 - math.ceil(math.log2(max(self.u_max)))
        for bits in range(largest_bits, largest_bits - 60, -1):
            largest_h_shift = min(self._shift_offset(k, bits) for k in self.gain) - width_shift
            pieces = zip(h_pieces(self.octaves), self.h_shifts, strict=True)
            # |e| at the ends of the pieces that would need an upward shift; the product grows with |e|
            e_values = [1 - piece.begin - piece.length for piece, shift in pieces if shift > largest_h_shift]
            if max(self.u_max) * 2**bits <= min(e_values, default=Fraction(1)) * SMALLEST_PRODUCT:
                break
        if min(self.u_max) * 2**bits < 1 << 19:
            limit_bits = math.floor(min(self.u_max) * Fraction(2) ** bits).bit_length()
            problem = f"the least of u_max, {decimal(min(self.u_max))}, has {limit_bits} bits"
            cause = f"beside gain {by_component(self.gain)} and u_max {by_component(self.u_max)}, and needs 20"
            raise BadInput(
                f"control.u_max: in integers of 32 bits {problem} {cause}; make gains and limits of the components more alike, "
                'lower control.gain, raise the least u_max or tube.min_width, or use emit.scalar = "float"'
            )
        return bits

    @cached_property
    def gain_mantissas(self) -> tuple[int, ...]:
        """By component, the gain's mantissa of 16 bits, which the kernel `input_size` multiplies by."""
        return tuple(self._split_gain(abs(k), self.u_bits)[0] for k in self.gain)

    @property
    def shift_offsets(self) -> tuple[int, ...]:
        """By component, what `_shift_offset` returns for its gain."""
        return tuple(self._shift_offset(k, self.u_bits) for k in self.gain)

    def _shift_offset(self, gain: Fraction, u_bits: int) -> int:
        """Return the offset in the number of bits, offset - n - h_shift, by which |u| is shifted down to units of u.

        It is 30 + h_shift_base + 46 - 48 - exponent of the gain: e is in 2^-30, H = h 2^(h_shift - h_shift_base),
        1/width = r 2^(n - 46) for a width shifted up by n bits, and three products drop 48 bits."""
        return 28 + self.h_shift_base - self._split_gain(abs(gain), u_bits)[1]

    @cached_property
    def u_limits(self) -> tuple[int, ...]:
        """By component, the largest |u| in units of u: u_max rounded down to 20 bits."""
        return tuple(math.floor(round_down(v, "fixed") * Fraction(2) ** self.u_bits) for v in self.u_max)


def build_integer_law(task: Task, design: RefinedDesign) -> IntegerLaw:
    """Build the constants of (13) for this task and tube; for order 2 for the filtered tube."""
    assert task.u_max is not None  # task/checks/field_checks.py
    width = smallest_widths(design)[bool(design.filter)] / design.unit
    return IntegerLaw(task.gain, task.u_max, max(task.e_max), design.bits, law_width(width))


def smallest_widths(design: RefinedDesign) -> tuple[Fraction, Fraction]:
    """Return the smallest width of the tube, in the task's units, and of the tube that the law is about.

    For order 1 both are one tube; for order 2 the latter is the filtered tube, in units per second."""
    table = design.integers()
    width = 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).min()) * design.unit
    if not design.filter:
        return width, width
    pieces = filtered_edges(design)
    return width, int((pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).min()) * pieces.unit


def law_width(smallest_width: Fraction) -> int:
    """Return the width that the law takes a narrower tube to have, for a tube of this smallest width; both in units of x.

    It is a power of two below the width less the error of the arithmetic, and at least SMALLEST_LAW_WIDTH."""
    return max(SMALLEST_LAW_WIDTH, 1 << max(0, math.floor(smallest_width - WIDTH_ERROR_LIMIT).bit_length() - 1))


def integer_table(name: str, values: tuple[int, ...], row_length: int, *doc: str) -> Table:
    """Build a table of integers of the emitted code."""
    return Table(name, tuple(map(Fraction, values)), row_length, doc, INT)


def build_law_tables(law: IntegerLaw) -> tuple[Table, ...]:
    """Build the tables of the law: its quadratics by piece, and its gains and limits by component."""
    reciprocals = reciprocal_pieces()
    pieces = (*reciprocals, *h_pieces(law.octaves))
    doc = (
        f"Quadratics level - (slope - bend t) t, by row: {len(reciprocals)} for 1/d, d in [2^30, 2^31), then",
        f"{1 << H_PIECE_BITS} for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)).",
    )
    n = len(law.gain)
    return (
        integer_table("levels", tuple(piece.level for piece in pieces), 1, *doc),
        integer_table("slopes", tuple(piece.slope for piece in pieces), 1),
        integer_table("bends", tuple(piece.bend for piece in pieces), 1),
        integer_table(
            "h_shifts",
            (*(0 for _ in reciprocals), *law.h_shifts),
            1,
            "By row: H is its quadratic times 2 to this power, and a common one.",
        ),
        integer_table("gains", law.gain_mantissas, n, "By component: the gain, 16 bits of it."),
        integer_table(
            "shift_offsets",
            law.shift_offsets,
            n,
            "The product e H/d times the gain is shifted down by this, less the shifts of d and of H's row.",
        ),
        integer_table("limits", law.u_limits, n, "The largest |u|."),
    )
