"""Exact rounding to IEEE-754 binary32 and binary64, and the shortest literals that read back exactly.

Everything is done on fractions, so it depends on no library's formatting and is the same everywhere.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property


@dataclass(frozen=True)
class FloatFormat:
    """A binary floating-point format: `precision` bits of significand, exponents of the unit bit from `lowest_exponent` to
    `highest_exponent`."""

    precision: int
    lowest_exponent: int
    highest_exponent: int

    @cached_property
    def roundoff(self) -> Fraction:
        """Half a unit in the last place of 1: the relative error of one rounding."""
        return Fraction(1, 1 << self.precision)

    @cached_property
    def tiny(self) -> Fraction:
        """Half the smallest subnormal: the absolute error of one rounding near zero."""
        return Fraction(2) ** (self.lowest_exponent - self.precision)

    @cached_property
    def smallest_mantissa(self) -> Fraction:
        """The lower end of what the operation `mantissa` returns: 1/sqrt 2, rounded."""
        return round_to(Fraction("0.70710678118654752440"), "float" if self.precision == 24 else "double")

    @cached_property
    def largest(self) -> Fraction:
        """The largest finite number."""
        return (2 - Fraction(2) ** (1 - self.precision)) * Fraction(2) ** self.highest_exponent


# "fixed" is a controller in integers: its arguments and results are known to 20 bits, whatever units they count. So is a state,
# whose unit is at most 2^-20 of the largest coordinate (design/lattice.py).
FORMATS = {"float": FloatFormat(24, -126, 127), "double": FloatFormat(53, -1022, 1023), "fixed": FloatFormat(20, -1022, 1023)}


def exponent_of(value: Fraction) -> int:
    """Return the e with 2**e <= |value| < 2**(e+1); value is not 0."""
    size = abs(value)
    e = size.numerator.bit_length() - size.denominator.bit_length()
    return e if Fraction(2) ** e <= size else e - 1


def ulp_exponent(value: Fraction, scalar: str) -> int:
    """Return the exponent of the unit in the last place of `value` in this format."""
    form = FORMATS[scalar]
    e = exponent_of(value) if value else form.lowest_exponent
    return max(e, form.lowest_exponent) - form.precision + 1


def round_to(value: Fraction, scalar: str) -> Fraction:
    """Return the nearest number of the format, ties to even. Raises OverflowError beyond the largest."""
    if value == 0:
        return Fraction(0)
    unit = Fraction(2) ** ulp_exponent(value, scalar)
    rounded = round(value / unit) * unit  # Fraction rounds half to even
    if abs(rounded) > FORMATS[scalar].largest:
        raise OverflowError(f"{float(value):.9g} is too large for a {scalar}")
    return rounded


def round_down(value: Fraction, scalar: str) -> Fraction:
    """Return the largest number of the format that is not above a positive value."""
    nearest = round_to(value, scalar)
    return nearest if nearest <= value else round_to(value - Fraction(2) ** ulp_exponent(value, scalar) / 2, scalar)


def round_up(value: Fraction, scalar: str) -> Fraction:
    """Return the smallest number of the format that is not below a positive value."""
    nearest = round_to(value, scalar)
    return nearest if nearest >= value else nearest + Fraction(2) ** ulp_exponent(nearest, scalar)


def round_toward(value: Fraction, scalar: str, up: bool) -> Fraction:
    """Return the nearest number of the format that is not below a value of either sign (`up`), or not above it."""
    if value < 0:
        return -round_toward(-value, scalar, not up)
    return round_up(value, scalar) if up else round_down(value, scalar)


def largest_below(value: Fraction, scalar: str) -> Fraction:
    """Return the largest number of the format below a positive value."""
    rounded = round_down(value, scalar)
    return rounded if rounded < value else round_down(rounded - Fraction(2) ** (ulp_exponent(rounded, scalar) - 2), scalar)


def _clamped(value: float, scalar: str) -> float:
    """Return the value clamped to the format's largest number: the few digits of a literal may exceed it."""
    largest = float(FORMATS[scalar].largest)
    return max(-largest, min(largest, value))


def shortest(value: Fraction, scalar: str) -> str:
    """Return the literal of fewest significant digits that reads back as `value`, a number of the format.

    It always has a point or an exponent: 1.0, 2.5e-9.
    """
    if value == 0:
        return "0.0"
    exact = round_to(value, scalar)
    as_double = exact.numerator / exact.denominator  # exact: both formats fit a double
    kind = "f" if scalar == "float" else "d"
    for digits in range(1, 18):
        text = f"{as_double:.{digits}g}"
        # A quick test first, then an exact one: through a double the decimal may be rounded twice.
        if (
            struct.unpack(kind, struct.pack(kind, _clamped(float(text), scalar)))[0] == as_double
            and round_to(Fraction(text), scalar) == exact
        ):
            break
    plain = Decimal(text)
    if -6 < plain.adjusted() < 8:
        text = f"{plain:f}"
        return text if "." in text else text + ".0"
    mantissa, _, exponent = f"{plain:e}".partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}e{int(exponent)}"
