"""The two functions that the law in integers looks up, as quadratics by pieces: 1/d and H.

H(y) = 4 ln((2 - y)/y)/((1 - y) y (2 - y)), with y = 1 - |e| and e the normalized error.

integer_kernels.py explains why (13) needs 1/d and H; constants.py makes the tables; integer_errors.py uses the error bounds here.

Both functions are looked up by a number in [2^30, 2^31): the argument, shifted up until its first bit is 1. The bits after the
first select the piece in the table, and the 16 bits behind them are the position t in [0, 1) in the piece. A piece stands for

    2^shift (level - (slope - bend t) t),     slope and bend in 2^-SLOPE_BITS,

and interpolates the function at t = 1/15, 1/2, 14/15, which are close to Chebyshev's nodes. The pieces of 1/d come first in the
tables. Then come those of H, by the number of bits by which y is shifted up; in each octave from its smallest number on.
docs/accuracy.md has the resulting bounds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.program.analyse import logarithm

SLOPE_BITS = 1  # of the fractions of slope and bend: a slope then fits 15 bits
RECIPROCAL_PIECE_BITS, H_PIECE_BITS = 4, 3  # so many bits after the first select the piece
NODES = (Fraction(1, 15), Fraction(1, 2), Fraction(14, 15))  # positions t at which a piece interpolates
LEVEL_LIMIT = 1 << 16  # every level is below it
RECIPROCAL_NUMERATOR = (Fraction(LEVEL_LIMIT) - Fraction(1, 2)) * 2**30  # over d it has 16 bits from d = 2^30 on
Curve = Callable[[Fraction], Fraction]


@dataclass(frozen=True, kw_only=True)
class QuadraticPiece:
    """A quadratic for a curve on [begin, begin + length]: 2^shift (level - (slope - bend t) t), t in [0, 1]."""

    begin: Fraction
    length: Fraction
    level: int
    slope: int  # in 2^-SLOPE_BITS
    bend: int  # in 2^-SLOPE_BITS
    shift: int

    def relative_error(self, curve: Curve) -> Fraction:
        """Bound the relative error of the emitted quadratic: that of interpolation, and roundings."""
        scale = Fraction(2) ** self.shift
        points_before = [self.begin - self.length * k / 16 for k in range(4)]
        # |f'''| falls with the argument, so it is larger before the piece than in it. For 1/d that is plain. H is
        # 8 atanh(e)/e/(1 - e^2), e = 1 - y, a power series in e without negative coefficients.
        third_derivative = abs(
            _divided_difference([(y, curve(y)) for y in points_before])
        )  # |f'''|/6 at a point before the piece
        largest_node_product = max(abs(_node_product(Fraction(k, 512))) for k in range(513)) + Fraction(
            2, 512
        )  # its slope is < 2
        interpolation_error = third_derivative * self.length**3 * largest_node_product / scale
        # `level` is rounded by 1/2. It is lowered by 1/4, which centres the error of two shifts: 3/4 at most, either way. `slope`
        # and `bend` are rounded by half of 2^-SLOPE_BITS each. t is cut to 16 bits; over the rest the quadratic falls so much.
        t_error = Fraction(self.slope, 1 << (16 + SLOPE_BITS))
        rounding_error = Fraction(1, 2) + 2 * Fraction(1, 2 << SLOPE_BITS) + Fraction(3, 4) + t_error
        smallest_value = self.level - (self.slope >> SLOPE_BITS) - 1
        return (interpolation_error + rounding_error) / smallest_value


def _node_product(t: Fraction) -> Fraction:
    return (t - NODES[0]) * (t - NODES[1]) * (t - NODES[2])


def _divided_difference(points: list[tuple[Fraction, Fraction]]) -> Fraction:
    """Return Newton's divided difference of all points (argument, value)."""
    if len(points) == 1:
        return points[0][1]
    return (_divided_difference(points[1:]) - _divided_difference(points[:-1])) / (points[-1][0] - points[0][0])


def scaled_reciprocal(d: Fraction) -> Fraction:
    """Return RECIPROCAL_NUMERATOR/d."""
    return RECIPROCAL_NUMERATOR / d


def curve_h(y: Fraction) -> Fraction:
    """Return a number within 2^-40 of H(y), and not above it, for 0 < y < 1."""
    return 4 * logarithm((2 - y) / y)[0] / ((1 - y) * y * (2 - y))


def _interpolate(curve: Curve, begin: Fraction, length: Fraction) -> QuadraticPiece:
    """Interpolate a falling curve on [begin, begin + length] at NODES, with a level of 16 bits."""
    values = [(t, curve(begin + length * t)) for t in NODES]
    second = _divided_difference(values)
    first = _divided_difference(values[:2]) - second * (NODES[0] + NODES[1])
    start = values[0][1] - first * NODES[0] - second * NODES[0] ** 2
    shift = (start.numerator // start.denominator).bit_length() - 16 if start >= 1 else -64
    while start / Fraction(2) ** shift > LEVEL_LIMIT - Fraction(1, 2):
        shift += 1
    while start / Fraction(2) ** shift < LEVEL_LIMIT / 2 - 1:
        shift -= 1
    unit = Fraction(2) ** shift
    level, slope, bend = round(start / unit - Fraction(1, 4)), -first * 2**SLOPE_BITS / unit, second * 2**SLOPE_BITS / unit
    return QuadraticPiece(begin=begin, length=length, level=level, slope=round(slope), bend=round(bend), shift=shift)


@cache
def reciprocal_pieces() -> tuple[QuadraticPiece, ...]:
    """Return the pieces of `scaled_reciprocal` on [2^30, 2^31), by the RECIPROCAL_PIECE_BITS bits after the first."""
    length = Fraction(2) ** (30 - RECIPROCAL_PIECE_BITS)
    return tuple(_interpolate(scaled_reciprocal, 2**30 + k * length, length) for k in range(1 << RECIPROCAL_PIECE_BITS))


@cache
def h_pieces(octaves: int) -> tuple[QuadraticPiece, ...]:
    """Return the pieces of H for y in [2^-m, 2^(1 - m)), m = 1 .. octaves."""
    pieces = []
    for m in range(1, octaves + 1):
        length = Fraction(1, 1 << (m + H_PIECE_BITS))
        pieces += [_interpolate(curve_h, Fraction(1, 1 << m) + k * length, length) for k in range(1 << H_PIECE_BITS)]
    return tuple(pieces)


@cache
def relative_errors(octaves: int) -> tuple[Fraction, Fraction]:
    """Bound the relative errors of 1/d and of H, as the pieces give them, for y down to 2^-octaves."""
    reciprocal_error = max(piece.relative_error(scaled_reciprocal) for piece in reciprocal_pieces())
    return reciprocal_error, max(piece.relative_error(curve_h) for piece in h_pieces(octaves))
