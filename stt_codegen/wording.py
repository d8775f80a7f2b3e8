"""Numbers and kinds of values in messages."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction


def decimal(value: Fraction) -> str:
    """A fraction as a decimal: exact where that takes at most 15 digits, else nearest with 9."""
    short = f"{float(value):.15g}"
    return short if Fraction(short) == value else f"{float(value):.9g}"


def exact_decimal(value: Fraction) -> str:
    """A fraction that came from a decimal, in all its digits; as `decimal` where it is short."""
    short = f"{float(value):.15g}"
    if Fraction(short) == value:
        return short
    with localcontext() as context:
        context.prec = 400
        digits = Decimal(value.numerator) / Decimal(value.denominator)
    return format(digits.normalize(), "f")


def kind_of(value: object) -> str:
    """What a value of a TOML file is, in words, at most 40 characters of it."""
    if isinstance(value, bool):
        return f"the boolean {str(value).lower()}"
    if isinstance(value, str):
        return f"the text {value!r:.40}"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int) and value.bit_length() > 63:
        return "a very large number"
    if isinstance(value, int | float | Decimal | Fraction):
        return f"the number {value!s:.40}"
    return f"a {type(value).__name__}"
