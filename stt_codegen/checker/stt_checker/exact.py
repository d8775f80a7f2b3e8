"""What every file of the checker uses: the two ways to say no, the numbers of a task, and rounding to a scalar."""

import math
import re
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

Numbers = list[Fraction]
DIGIT_LIMIT, LARGEST = 200, 10**400  # of numbers in the task
SMALLEST = Fraction(1, 1 << 100)  # a number of a controller is 0, or between this and its inverse: none over- or underflows


class Refused(Exception):
    """A property, a claim, a hash or a token is wrong: the answer is no."""


class Unusable(Exception):
    """A file cannot be read, or is about something that is unknown here: there is no answer."""


def require(holds: bool, problem: str) -> None:
    """Raise `Refused` with the problem where a condition does not hold."""
    if not holds:
        raise Refused(problem)


def rounded(value: Fraction, bits: int, toward: Callable[[Fraction], int] = round) -> Fraction:
    """Return the nearest number with so many significant bits, ties to even; with `math.floor` the largest that is not above."""
    if value == 0:
        return value
    exponent = value.numerator.bit_length() - value.denominator.bit_length() - bits
    exponent += abs(value) >= Fraction(2) ** (exponent + bits)
    return toward(value / Fraction(2) ** exponent) * Fraction(2) ** exponent


def require_in_range(*values: Fraction) -> None:
    """Require that numbers of the controller, or products that it computes, are not near the ends of a scalar's range."""
    is_in_range = all(v == 0 or SMALLEST <= abs(v) <= 1 / SMALLEST for v in values)
    require(is_in_range, "a number or a product of the controller is near the ends of its scalar's range")


def units_above(value: Fraction, unit: Fraction) -> int:
    """Return the smallest whole number of units that is not below the value."""
    return math.ceil(value / unit)


def decimal(text: str) -> Decimal:
    """Read a decimal of the task file without rounding it."""
    value = Decimal(text)
    if not (value.is_finite() and abs(value.adjusted()) < 400 and len(value.as_tuple().digits) <= DIGIT_LIMIT):
        raise Unusable(f"the task has {text:.40}, which is out of range or has too many digits")
    return value


def number(value: Any) -> Fraction:
    """Return a number of the task file."""
    if not isinstance(value, int | Decimal) or isinstance(value, bool) or abs(Fraction(value)) > LARGEST:
        raise Unusable(f"the task has {value!s:.80} where a number is needed")
    return Fraction(value)


def numbers(value: Any, n: int) -> Numbers:
    """Return n numbers of the task file: a list of n, or one that is meant for all components."""
    return vector(value if isinstance(value, list) else [value] * n, n)


def vector(values: Any, n: int) -> Numbers:
    """Return a list of n numbers of the task file."""
    if not isinstance(values, list) or len(values) != n:
        raise Unusable(f"the task has {values!r:.80} where a list of {n} numbers is needed")
    return [number(v) for v in values]


def fractions(values: Any, n: int) -> Numbers:
    """Return n fractions of the certificate, written as "p/q"."""
    is_list = isinstance(values, list) and len(values) == n and all(isinstance(v, str) for v in values)
    require(is_list and all(re.fullmatch(r"-?\d+(/[1-9]\d*)?", v, re.ASCII) for v in values), "a claim has no list of fractions")
    return [Fraction(v) for v in values]


def integers(values: Any, n: int) -> list[int]:
    """Return n whole numbers of the certificate."""
    require(isinstance(values, list) and [type(v) for v in values] == [int] * n, "a claim has no list of whole numbers")
    return values


def logarithm(y: Fraction) -> tuple[Fraction, Fraction]:
    """Return ln y for y >= 1 from below and above: k ln 2 + 2 artanh((z - 1)/(z + 1)) with z = y/2^k below 3/2."""
    k = max(0, y.numerator.bit_length() - y.denominator.bit_length() - 1)
    k += y / 2**k >= Fraction(3, 2)
    z, third = y / 2**k, artanh(Fraction(1, 3))
    low, high = artanh((z - 1) / (z + 1))
    return 2 * (low + k * third[0]), 2 * (high + k * third[1])


def artanh(z: Fraction) -> tuple[Fraction, Fraction]:
    """Return z + z^3/3 + .. for 0 <= z <= 1/3 from below and above: 26 terms in multiples of 2^-80. A power is too small by less
    than 1.5 of these, a quotient by one more, and what is left out is below 2^-84: less than 32 in all."""
    unit, total = 1 << 80, 0
    power = first = z.numerator * unit // z.denominator
    for j in range(26):
        total += power // (2 * j + 1)
        power = power * first * first >> 160
    return Fraction(total, unit), Fraction(total + 32, unit)
