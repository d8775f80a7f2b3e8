"""Exact numbers as decimals: for messages, for emitted text, and rounded up or down for what is claimed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction


def decimal(value: Fraction) -> str:
    """Write a fraction as a decimal: exact where that needs at most 15 digits, else the nearest with 9."""
    short = f"{float(value):.15g}"
    return short if Fraction(short) == value else f"{float(value):.9g}"


def exact_decimal(value: Fraction) -> str:
    """Write a fraction that was read from a decimal with all its digits."""
    short = f"{float(value):.15g}"
    if Fraction(short) == value:
        return short
    with localcontext() as context:
        context.prec = 400
        digits = Decimal(value.numerator) / Decimal(value.denominator)
    return format(digits.normalize(), "f")


def nine_digits(value: Fraction) -> float:
    """Return the nearest number of nine digits."""
    return float(f"{float(value):.9g}")


def below(value: Fraction, digits: int = 6) -> float:
    """Return the largest decimal of so many digits that is not above `value`."""
    return _toward(value, digits, math.floor)


def above(value: Fraction, digits: int = 6) -> float:
    """Return the smallest decimal of so many digits that is not below `value`."""
    return _toward(value, digits, math.ceil)


def _toward(value: Fraction, digits: int, direction: Callable[[Fraction], int]) -> float:
    if value == 0:
        return 0.0
    power = digits - 1 - math.floor(math.log10(abs(value)))
    return float(Fraction(direction(value * Fraction(10) ** power)) / Fraction(10) ** power)


def by_component(values: Sequence[Fraction | float]) -> str:
    """Write numbers as a task file does: a single number where all agree, else [0.5, 0.25]."""
    shown = [decimal(v) if isinstance(v, Fraction) else f"{v:g}" for v in values]
    return shown[0] if len(set(shown)) == 1 else f"[{', '.join(shown)}]"


def by_dimension(values: Sequence[Fraction | float]) -> str:
    """Write numbers as `by_component` does, for a sentence: a single number, else [0.5, 0.25] (by dimension)."""
    text = by_component(values)
    return f"{text} (by dimension)" if text.startswith("[") else text
