"""How far the statements of a listing may be off by rounding, derived from the statements themselves.

The kernels are run on ranges: a value between two numbers, and how far it may be off. The inputs are those of the call sites, which
machine.py compares: `basis` and `basis_rate` get the place in the segment, `edge_at` gets their results and four entries of the table.
eps is half a unit in the last place of 1; tiny is half the least subnormal number.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from tests.support.listings.reader import Expression, Listing, Statement, UnknownMeaning, require


class RoundedRange(NamedTuple):
    """A value between two exact numbers; error: how far the computed value is from the exact one, at most."""

    low: Fraction
    high: Fraction
    error: Fraction = Fraction(0)

    @property
    def size(self) -> Fraction:
        return max(abs(self.low), abs(self.high))


UNIT = RoundedRange(Fraction(0), Fraction(1))  # the place in a segment


@dataclass(frozen=True)
class Rounding:
    """The arithmetic of a scalar, as operations on ranges."""

    eps: Fraction
    tiny: Fraction

    def rounded(self, low: Fraction, high: Fraction, error: Fraction) -> RoundedRange:
        size = max(abs(low), abs(high)) + error
        return RoundedRange(low, high, error + size * self.eps + self.tiny)

    def operation(self, sign: str, a: RoundedRange, b: RoundedRange) -> RoundedRange:
        if sign == "*":
            ends = [v * w for v, w in itertools.product(a[:2], b[:2])]
            low = max(min(ends), Fraction(0)) if a is b else min(ends)  # a square is not negative
            return self.rounded(low, max(ends), a.size * b.error + b.size * a.error + a.error * b.error)
        if sign == "-":
            b = RoundedRange(-b.high, -b.low, b.error)
        require(sign in "+-", f"the rounding of {sign} is not derived here")
        return self.rounded(a.low + b.low, a.high + b.high, a.error + b.error)


FLOAT = Rounding(Fraction(1, 1 << 24), Fraction(1, 1 << 150))
DOUBLE = Rounding(Fraction(1, 1 << 53), Fraction(1, 1 << 1075))


class RangeRun:
    """Runs a kernel on ranges. words: the ranges of the words that fill holes; entries: the range of the table's entries."""

    def __init__(
        self, listing: Listing, rounding: Rounding, words: dict[str, RoundedRange], entries: RoundedRange | None = None
    ) -> None:
        self.listing, self.rounding, self.words, self.entries = listing, rounding, words, entries

    def results(self, name: str, inputs: list[RoundedRange]) -> list[RoundedRange]:
        """Return the ranges of a kernel's real outputs, or of what it returns. inputs: of its real parameters."""
        function, outputs = self.listing.functions[name], []
        parameters = [p.name for p in function.parameters if p.passing == "value" and p.value_type == "real"]
        ranges = self.words | dict(zip(parameters, inputs, strict=True))
        of_output = {p.name: p.value_type for p in function.parameters if p.passing == "output"}
        for item in function.body:
            require(isinstance(item, Statement), f"{name} has a block")
            assert isinstance(item, Statement)
            if item.value_type in ("int", "bool"):
                continue  # an index, or a choice that `_range` allows for
            value = item.value
            assert value is not None
            if item.kind == "define":
                ranges[item.target] = self._range(value, ranges)
            elif item.kind == "return" or of_output[item.target] == "real":
                outputs.append(self._range(value, ranges))
        return outputs

    def _range(self, expression: Expression, ranges: dict[str, RoundedRange]) -> RoundedRange:
        """Return the range of an expression whose result is real."""

        def operand(text: str) -> RoundedRange:
            return ranges[text] if text in ranges else RoundedRange(Fraction(text), Fraction(text))

        match expression:
            case Expression("operand", (text,)):
                return operand(text)
            case Expression("negation", (text,)):
                value = operand(text)
                return RoundedRange(-value.high, -value.low, value.error)
            case Expression("load", _) if self.entries is not None:
                return self.entries
            case Expression("operation", (first, sign, second)):
                return self.rounding.operation(sign, operand(first), operand(second))
        raise UnknownMeaning(f"the rounding of this is not derived here: {expression}")


def edge_error(listing: Listing, rounding: Rounding, largest: Fraction, order: int = 0) -> Fraction:
    """Return how far an edge (order 1: its rate by the place in the segment) is off at an exact place, the table's entries being at
    most `largest`. The entries are numbers of the scalar."""
    run = RangeRun(listing, rounding, {}, RoundedRange(-largest, largest))
    (value,) = run.results("edge_at", run.results(("basis", "basis_rate")[order], [UNIT]))
    return value.error


def largest_value(listing: Listing, rounding: Rounding, largest: Fraction) -> Fraction:
    """Return a bound on all values of the spline's kernels, for their overflow."""
    run = RangeRun(listing, rounding, {}, RoundedRange(-largest, largest))
    weights = [run.results(name, [UNIT]) for name in ("basis", "basis_rate")]
    values = itertools.chain(*weights, *(run.results("edge_at", w) for w in weights))
    return max(v.size + v.error for v in values) * 4  # a sum's operands and products are no larger


def speed_error(rounding: Rounding, slope: RoundedRange, per_second: Fraction) -> Fraction:
    """Return how far a rate a second is off: the product of a slope with K/t_c, which is rounded too."""
    scale = RoundedRange(per_second, per_second, per_second * rounding.eps)
    return rounding.operation("*", slope, scale).error


def spline_time_error(rounding: Rounding, segments: int, t_c: Fraction) -> Fraction:
    """Return how far spline time is off by the operations of `Specification.segment`, where t was rounded to the scalar.

    It is t K/t_c, the quotient and the product being rounded, and then the lesser of this and the last number below K. The place in
    the segment is u - floor(u). This difference is exact: both are multiples of one unit, and it is smaller than u.
    """
    t = RoundedRange(Fraction(0), t_c, t_c * rounding.eps)
    per_second = RoundedRange(segments / t_c, segments / t_c, segments / t_c * rounding.eps)
    scaled = rounding.operation("*", t, per_second)
    below_end = segments * rounding.eps  # K less the last number below it is at most this
    return max(scaled.error, below_end)
