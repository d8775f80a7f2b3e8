"""The two curves of the law in integers, by quadratics: 1/d, and H(y) = 4 ln((2 - y)/y)/((1 - y) y (2 - y)).

Both take a number in [2^30, 2^31), a value moved up until it begins with a 1. The bits after the first say which row of the table
has its piece, the 16 bits behind them its place t in the piece. A row stands for

    2^places (level - (slope - bend t) t),     slope and bend in 2^-SLOPE_BITS,

and interpolates the curve at t = 1/15, 1/2, 14/15, which are next to Chebyshev's nodes. Rows of 1/d come first, then those of H:
by how many places y moves up, and in every octave from its least number on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.program.analyse import logarithm

SLOPE_BITS = 1  # a slope then fits 15 bits
OVER_BITS, RISE_BITS = 4, 3  # so many bits after the first say the piece
NODES = (Fraction(1, 15), Fraction(1, 2), Fraction(14, 15))
LEVEL = 1 << 16  # no level reaches it
OVER = (Fraction(LEVEL) - Fraction(1, 2)) * 2**30  # 1/d is this over the number: then it has 16 bits from 2^30 on
Curve = Callable[[Fraction], Fraction]


@dataclass(frozen=True, kw_only=True)
class Row:
    """One piece: of a curve from `begin` on, `length` long; value = 2^places (level - (slope - bend t) t)."""

    begin: Fraction
    length: Fraction
    level: int
    slope: int
    bend: int
    places: int

    def error(self, curve: Curve) -> Fraction:
        """A bound on what the emitted quadratic is wrong by, relative: the interpolation's, and the roundings."""
        scale = Fraction(2) ** self.places
        steps = [self.begin - self.length * k / 16 for k in range(4)]
        # |f'''| falls, so it is larger before the piece: 1/m's plainly; H is 8 atanh(e)/e/(1 - e^2), e = 1 - y, a power series in
        # e with no negative coefficient.
        third = abs(_divided([(y, curve(y)) for y in steps]))  # |f'''|/6 somewhere there
        between = max(abs(_nodal(Fraction(k, 512))) for k in range(513)) + Fraction(2, 512)  # its slope is below 2
        missed = third * self.length**3 * between / scale
        # `level` is rounded by 1/2, and has 1/4 less, which centres what two shifts take: 3/4 at most, either way. `slope` and
        # `bend` are rounded by half of 2^-SLOPE_BITS each. t is cut to 16 bits, in which the row falls by so much.
        rounded = (
            Fraction(1, 2) + 2 * Fraction(1, 2 << SLOPE_BITS) + Fraction(3, 4) + Fraction(self.slope, 1 << (16 + SLOPE_BITS))
        )
        least = self.level - (self.slope >> SLOPE_BITS) - 1
        return (missed + rounded) / least


def _nodal(t: Fraction) -> Fraction:
    return (t - NODES[0]) * (t - NODES[1]) * (t - NODES[2])


def _divided(points: list[tuple[Fraction, Fraction]]) -> Fraction:
    """The divided difference of all points."""
    if len(points) == 1:
        return points[0][1]
    return (_divided(points[1:]) - _divided(points[:-1])) / (points[-1][0] - points[0][0])


def over(m: Fraction) -> Fraction:
    """OVER/m."""
    return OVER / m


def rise(y: Fraction) -> Fraction:
    """H for 0 < y < 1, from below: within 2^-40 of itself."""
    return 4 * logarithm((2 - y) / y)[0] / ((1 - y) * y * (2 - y))


def _row(curve: Curve, begin: Fraction, length: Fraction) -> Row:
    values = [(t, curve(begin + length * t)) for t in NODES]
    second = _divided(values)
    first = _divided(values[:2]) - second * (NODES[0] + NODES[1])
    start = values[0][1] - first * NODES[0] - second * NODES[0] ** 2
    places = (start.numerator // start.denominator).bit_length() - 16 if start >= 1 else -64
    while start / Fraction(2) ** places > LEVEL - Fraction(1, 2):
        places += 1
    while start / Fraction(2) ** places < LEVEL / 2 - 1:
        places -= 1
    unit = Fraction(2) ** places
    level, slope, bend = round(start / unit - Fraction(1, 4)), -first * 2**SLOPE_BITS / unit, second * 2**SLOPE_BITS / unit
    return Row(begin=begin, length=length, level=level, slope=round(slope), bend=round(bend), places=places)


@cache
def over_rows() -> tuple[Row, ...]:
    """Of 1/d, by the OVER_BITS bits after the first."""
    length = Fraction(2) ** (30 - OVER_BITS)
    return tuple(_row(over, 2**30 + k * length, length) for k in range(1 << OVER_BITS))


@cache
def rise_rows(octaves: int) -> tuple[Row, ...]:
    """Of H at y in [2^-m, 2^(1 - m)), m = 1 .. octaves."""
    found = []
    for m in range(1, octaves + 1):
        length = Fraction(1, 1 << (m + RISE_BITS))
        found += [_row(rise, Fraction(1, 1 << m) + k * length, length) for k in range(1 << RISE_BITS)]
    return tuple(found)


@cache
def relative_error(octaves: int) -> tuple[Fraction, Fraction]:
    """Of 1/d and of H as the rows give them."""
    return max(r.error(over) for r in over_rows()), max(r.error(rise) for r in rise_rows(octaves))
