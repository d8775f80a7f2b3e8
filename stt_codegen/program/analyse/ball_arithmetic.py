"""What the source that balls.py prints calls: comparisons that balls may leave open, integers known to a span, joins."""

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
    """The number as a ball; exact where it is dyadic and short."""
    exact = Fraction(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def hull(low: float, high: float) -> Ball:
    """A ball that holds [low, high]."""
    return arb(low).union(arb(high))


class Undecided(Exception):
    """A comparison in a kernel that the balls leave open; `pair` names its operands."""

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
    """The least and the largest that it may be."""
    return (value, value) if isinstance(value, int) else (value.low, value.high)


def span(values: Iterable[int]) -> _Int:
    """From the least to the largest of these."""
    found = list(values)
    return found[0] if min(found) == max(found) else _Span(min(found), max(found))


def _compared(assumed: dict[str, int], pair: str, a: Ball, b: Ball) -> int:
    if a < b:
        return -1
    if a > b:
        return 1
    if pair in assumed:
        return assumed[pair]
    raise Undecided(pair)


def _less(a: Ball, b: Ball, or_equal: bool) -> _Truth:
    if a < b or (or_equal and a <= b):
        return True
    return False if a > b or (not or_equal and a >= b) else None


def _equal(a: Ball, b: Ball) -> _Truth:
    if a == b:
        return True
    return False if a != b else None


def _both(a: _Truth, b: _Truth) -> _Truth:
    if a is False or b is False:
        return False
    return True if a and b else None


def _not(a: _Truth) -> _Truth:
    return None if a is None else not a


def _hull(a: Any, b: Any) -> Any:
    """What may be either: of balls, integers, truth values or sets of statuses."""
    if isinstance(a, frozenset):
        return a | b
    if isinstance(a, bool) or a is None:
        return a if a is b else None
    if isinstance(a, int | _Span):
        return span((*ends(a), *ends(b)))
    return a.union(b)


def _choose(condition: _Truth, then: Any, other: Any) -> Any:
    if condition is None:
        return _hull(then, other)
    return then if condition else other


def _finite(a: Ball) -> _Truth:
    return True if a.is_finite() else None


def _trunc(a: Ball, most: int | None) -> _Int:
    """`most`: the largest that it can be, where that is known; a ball's own end may be a little above it."""
    ends = int(float(a.lower())), int(float(a.upper()))
    return span(ends if most is None else (min(end, most) for end in ends))


def _added(a: _Int, b: _Int) -> _Int:
    return span(x + y for x, y in zip(ends(a), ends(b), strict=True))


def _times(a: _Int, b: _Int) -> _Int:
    return span(x * y for x in ends(a) for y in ends(b))


def _negated(a: _Int) -> _Int:
    return span(-x for x in ends(a))


def _less_by(a: _Int, b: _Int) -> _Int:
    (a_low, a_high), (b_low, b_high) = ends(a), ends(b)
    return span((a_low - b_high, a_high - b_low))


def _quotient(a: _Int, b: _Int) -> _Int:
    return span(x // y for x in ends(a) for y in ends(b))


def _lowered(a: _Int, b: _Int) -> _Int:
    return span(x >> y for x in ends(a) for y in ends(b))


def _raised(a: _Int, b: _Int) -> _Int:
    return span(x << y for x in ends(a) for y in ends(b))


def _upper(a: _Int, b: _Int) -> _Int:
    return span(x * y >> 16 for x in ends(a) for y in ends(b))


def _low(a: _Int, mask: _Int) -> _Int:
    (low, high), (_, most) = ends(a), ends(mask)
    return span((low & most, high & most) if low // (most + 1) == high // (most + 1) else (0, most))


def _leading(a: _Int) -> _Int:
    return span(31 - x.bit_length() for x in ends(a))


def _same(a: _Int) -> _Int:
    return a


def _before(a: _Int, b: _Int) -> _Truth:
    (a_low, a_high), (b_low, b_high) = ends(a), ends(b)
    return True if a_high < b_low else False if a_low >= b_high else None


def _number(a: _Int) -> Ball:
    return hull(*map(float, ends(a)))


def _load(array: list[Ball], index: _Int) -> Ball:
    low, high = ends(index)
    if not 0 <= low <= high < len(array):
        raise IndexError(f"index {low}..{high} of {len(array)}")
    found = array[low]
    for k in range(low + 1, high + 1):
        found = found.union(array[k])
    return found


def _put(array: list[Ball], index: _Int, value: Ball) -> None:
    low, high = ends(index)
    for k in range(low, high + 1):
        array[k] = value if low == high else array[k].union(value)


def _joined(exits: list[tuple[Any, list[list[Ball]]]]) -> tuple[list[list[Ball]], Any]:
    """The outputs and what is returned, over all ways out of a function."""
    (statuses, outputs), *others = exits
    for other_statuses, other in others:
        statuses = _hull(statuses, other_statuses)
        outputs = [[x.union(y) for x, y in zip(a, b, strict=True)] for a, b in zip(outputs, other, strict=True)]
    return outputs, statuses


def _exponent(y: Ball, least: Fraction) -> _Int:
    low, high = float(y.lower()), float(y.upper())
    if not (math.isfinite(low) and math.isfinite(high)):  # a loose ball; the number is from 1/sqrt 2 to a double's largest
        return _Span(0, 1024)
    return span(max(0, exponent_of(max(Fraction(end), least) / least)) for end in (low, high))


def _mantissa(y: Ball, least: Fraction) -> Ball:
    e = _exponent(y, least)
    return y / 2**e if isinstance(e, int) else hull(float(least), float(2 * least))


HELPERS = (
    _compared, _less, _equal, _both, _not, _hull, _choose, _finite, _trunc, _added, _times, _negated, _less_by, _quotient, _same,
    _lowered, _raised, _upper, _low, _leading,
    _before, _number, _load, _put,
    _joined, _exponent, _mantissa,
)  # fmt: skip
