"""Exact numbers as decimals: for messages, for emitted text, and rounded to a safe side for statements."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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


def nine_digits(value: Fraction) -> float:
    """The nearest number of nine digits."""
    return float(f"{float(value):.9g}")


def below(value: Fraction, digits: int = 6) -> float:
    """The largest decimal of so many digits that is not above `value`."""
    return _toward(value, digits, math.floor)


def above(value: Fraction, digits: int = 6) -> float:
    """The smallest decimal of so many digits that is not below `value`."""
    return _toward(value, digits, math.ceil)


def _toward(value: Fraction, digits: int, direction: Callable[[Fraction], int]) -> float:
    if value == 0:
        return 0.0
    power = digits - 1 - math.floor(math.log10(abs(value)))
    return float(Fraction(direction(value * Fraction(10) ** power)) / Fraction(10) ** power)


def by_component(values: Sequence[Fraction | float]) -> str:
    """Numbers for people, as in a task file: one where all agree, else [0.5, 0.25]."""
    shown = [decimal(v) if isinstance(v, Fraction) else f"{v:g}" for v in values]
    return shown[0] if len(set(shown)) == 1 else f"[{', '.join(shown)}]"
