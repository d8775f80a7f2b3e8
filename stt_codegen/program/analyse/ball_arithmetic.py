"""Functions that the source printed by balls.py calls: arithmetic on integers known to a span, comparisons that balls may leave
undecided, and unions. `ranges` applies those on integers too, by the name that stands in a row of operations.py."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, fmpq

from stt_codegen.program.number import exponent_of

Ball = Any  # flint.arb has no types


def ball(value: Fraction | float | int) -> Ball:
    """Return the number as a ball; exact where it is dyadic and short."""
    exact = Fraction(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def hull(low: float, high: float) -> Ball:
    """Return a ball that holds [low, high]."""
    return arb(low).union(arb(high))


class Undecided(Exception):
    """A comparison in a kernel that the balls leave undecided; `pair` names its operands."""

    def __init__(self, pair: str) -> None:
        self.pair = pair


@dataclass(frozen=True)
class _Span:
    """An integer known only to lie in low..high."""

    low: int
    high: int


_Int = int | _Span
_Truth = bool | None  # None: may be either


def ends(value: _Int) -> tuple[int, int]:
    """Return the smallest and the largest number that it may be."""
    return (value, value) if isinstance(value, int) else (value.low, value.high)


def span(values: Iterable[int]) -> _Int:
    """Return the span from the smallest to the largest of these; one number where they are equal."""
    low, high = min(numbers := list(values)), max(numbers)
    return low if low == high else _Span(low, high)


def _compare(assumed: dict[str, int], pair: str, a: Ball, b: Ball) -> int:
    """Return -1, 0 or 1 where a is less than, equal to or greater than b, or what is assumed of a pair that is undecided.

    Raises `Undecided` where nothing is assumed.
    """
    if a < b:
        return -1
    if a > b:
        return 1
    if pair in assumed:
        return assumed[pair]
    raise Undecided(pair)


def _is_less(a: Ball, b: Ball, or_equal: bool) -> _Truth:
    if a < b or (or_equal and a <= b):
        return True
    return False if a > b or (not or_equal and a >= b) else None


def _is_equal(a: Ball, b: Ball) -> _Truth:
    if a == b:
        return True
    return False if a != b else None


def _and(a: _Truth, b: _Truth) -> _Truth:
    if a is False or b is False:
        return False
    return True if a and b else None


def _not(a: _Truth) -> _Truth:
    return None if a is None else not a


def _union(a: Any, b: Any) -> Any:
    """Return a value that holds both: of balls, integers, truth values or sets of statuses."""
    if isinstance(a, frozenset):
        return a | b
    if isinstance(a, bool) or a is None:
        return a if a is b else None
    if isinstance(a, int | _Span):
        return span((*ends(a), *ends(b)))
    return a.union(b)


def _select(condition: _Truth, then: Any, otherwise: Any) -> Any:
    if condition is None:
        return _union(then, otherwise)
    return then if condition else otherwise


def _is_finite(a: Ball) -> _Truth:
    return True if a.is_finite() else None


def _truncate(a: Ball, limit: int | None) -> _Int:
    """Return the whole part. limit: the largest that it can be, where that is known; the ball's end may be a little above it."""
    truncated = int(float(a.lower())), int(float(a.upper()))
    return span(truncated if limit is None else (min(end, limit) for end in truncated))


def _add(a: _Int, b: _Int) -> _Int:
    return span(x + y for x, y in zip(ends(a), ends(b), strict=True))


def _multiply(a: _Int, b: _Int) -> _Int:
    return span(x * y for x in ends(a) for y in ends(b))


def _negate(a: _Int) -> _Int:
    return span(-x for x in ends(a))


def _subtract(a: _Int, b: _Int) -> _Int:
    (a_low, a_high), (b_low, b_high) = ends(a), ends(b)
    return span((a_low - b_high, a_high - b_low))


def _divide(a: _Int, b: _Int) -> _Int:
    return span(x // y for x in ends(a) for y in ends(b))


def _shift_right(a: _Int, b: _Int) -> _Int:
    return span(x >> y for x in ends(a) for y in ends(b))


def _shift_left(a: _Int, b: _Int) -> _Int:
    return span(x << y for x in ends(a) for y in ends(b))


def _high_product(a: _Int, b: _Int) -> _Int:
    return span(x * y >> 16 for x in ends(a) for y in ends(b))


def _mask(a: _Int, mask: _Int) -> _Int:
    (low, high), (_, bits) = ends(a), ends(mask)
    return span((low & bits, high & bits) if low // (bits + 1) == high // (bits + 1) else (0, bits))


def _leading_places(a: _Int) -> _Int:
    return span(31 - x.bit_length() for x in ends(a))


def _unchanged(a: _Int) -> _Int:
    return a


def _is_less_integer(a: _Int, b: _Int) -> _Truth:
    (a_low, a_high), (b_low, b_high) = ends(a), ends(b)
    return True if a_high < b_low else False if a_low >= b_high else None


def _integer_ball(a: _Int) -> Ball:
    return hull(*map(float, ends(a)))


def _load(array: list[Ball], index: _Int) -> Ball:
    low, high = ends(index)
    if not 0 <= low <= high < len(array):
        raise IndexError(f"index {low}..{high} of {len(array)}")
    union = array[low]
    for k in range(low + 1, high + 1):
        union = union.union(array[k])
    return union


def _store(array: list[Ball], index: _Int, value: Ball) -> None:
    low, high = ends(index)
    for k in range(low, high + 1):
        array[k] = value if low == high else array[k].union(value)


def _join_exits(exits: list[tuple[Any, list[list[Ball]]]]) -> tuple[list[list[Ball]], Any]:
    """Return the outputs, and what is returned, over all ways out of a function."""
    (result, outputs), *later_exits = exits
    for exit_result, exit_outputs in later_exits:
        result = _union(result, exit_result)
        outputs = [[x.union(y) for x, y in zip(a, b, strict=True)] for a, b in zip(outputs, exit_outputs, strict=True)]
    return outputs, result


def _exponent(y: Ball, smallest_mantissa: Fraction) -> _Int:
    """Return e of y = m 2^e, smallest_mantissa <= m < 2 smallest_mantissa (1/sqrt 2, rounded to the scalar)."""
    low, high = float(y.lower()), float(y.upper())
    if not (math.isfinite(low) and math.isfinite(high)):  # a loose ball; the number is from 1/sqrt 2 to a double's largest
        return _Span(0, 1024)
    return span(max(0, exponent_of(max(Fraction(end), smallest_mantissa) / smallest_mantissa)) for end in (low, high))


def _mantissa(y: Ball, smallest_mantissa: Fraction) -> Ball:
    """Return m of y = m 2^e."""
    e = _exponent(y, smallest_mantissa)
    return y / 2**e if isinstance(e, int) else hull(float(smallest_mantissa), float(2 * smallest_mantissa))


HELPERS = (
    _compare, _is_less, _is_equal, _and, _not, _union, _select, _is_finite, _truncate, _add, _multiply, _negate, _subtract,
    _divide, _unchanged, _shift_right, _shift_left, _high_product, _mask, _leading_places, _is_less_integer, _integer_ball,
    _load, _store, _join_exits, _exponent, _mantissa,
)  # fmt: skip
