"""The tables of 1/d and of H(y) = 4 ln((2 - y)/y)/((1 - y) y (2 - y)) in a controller in integers: how wrong their rows are."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from .exact import logarithm, require

Enclosure = tuple[Fraction, Fraction]  # from below and above


class Row(NamedTuple):
    """A piece of a curve: level - (slope - bend z) z/2 for z from 0 to 1."""

    level: int
    slope: int
    bend: int


class Curves(NamedTuple):
    """reciprocal_error: the relative error of 1/d. h_rows: by row of H its relative error, and its smallest value in the table's
    units. base: a row with the entry k in the table h_shifts stands for its quadratic times 2^(k - base)."""

    reciprocal_error: Fraction
    h_rows: list[tuple[Fraction, Fraction]]
    base: int


def scaled_reciprocal(m: Fraction) -> Enclosure:
    return (1 << 46) / m, (1 << 46) / m


@cache
def h_of(y: Fraction) -> Enclosure:
    """Return H for 0 < y <= 1."""
    if y == 1:
        return Fraction(8), Fraction(8)
    low, high = logarithm((2 - y) / y)
    return 4 * low / ((1 - y) * y * (2 - y)), 4 * high / ((1 - y) * y * (2 - y))


def row_error(
    row: Row, curve: Callable[[Fraction], Enclosure], begin: Fraction, length: Fraction, scale: Fraction
) -> tuple[Fraction, Fraction]:
    """Return the largest relative error of a row for curve/scale on its piece, and the smallest value of curve/scale there.

    Let P = level - (slope - bend z) z/2 be the row, z from 0 to 1, and F = curve/scale - P. On a quarter of the piece F is the
    quadratic through its values at both ends and in the middle, plus its third derivative/6 times z (z - 1/2) (z - 1), which is
    at most 1/20; the quadratic is within its three Bezier coefficients. The curve is 2^46/m or H. The size of its third
    derivative falls: for 1/m plainly; H is 8 atanh(e)/e/(1 - e^2) with e = 1 - y, a power series in e without negative
    coefficients. So a third difference of values up to the quarter is at least as large. What the C computes is less than 1/2
    below P and less than 1 above, for `bend_part` and `fall` are rounded down. z is rounded down by less than 2^-16, in which P
    falls by at most slope/2^17, or rises by at most (2 bend - slope)/2^17."""
    level, slope, bend = row
    require(0 <= bend <= slope < 1 << 15 and slope // 2 < level < 1 << 16, "a row of the curves of the C is out of range")
    enclosures = {k: curve(begin + length * k / 8) for k in (-6, -4, -2, *range(9))}
    uncertainty = 16 * max(high - low for low, high in enclosures.values()) / scale
    value = {k: low / scale for k, (low, _) in enclosures.items()}
    difference = [value[k] - level + (slope - Fraction(bend * k, 8)) * Fraction(k, 16) for k in range(9)]
    lowest, highest = Fraction(0), Fraction(0)
    for k in range(0, 8, 2):
        start, middle, end = difference[k : k + 3]
        third = abs(value[k] - 3 * value[k - 2] + 3 * value[k - 4] - value[k - 6]) / 120 + uncertainty
        coefficients = start, 2 * middle - (start + end) / 2, end
        lowest, highest = min(lowest, min(coefficients) - third), max(highest, max(coefficients) + third)
    above = highest + Fraction(1, 2) + Fraction(max(0, 2 * bend - slope), 1 << 17)
    smallest = value[8] - uncertainty
    return max(above, 1 + Fraction(slope, 1 << 17) - lowest) / smallest, smallest


def check_curves(tables: dict[str, list[int]]) -> Curves:
    """Compare each row with its curve: 16 rows of 1/d, by the 4 bits after the first one, then 8 for each octave of y."""
    rows, shifts = list(map(Row, tables["levels"], tables["slopes"], tables["bends"])), tables["h_shifts"]
    lengths = {len(tables[name]) for name in ("levels", "slopes", "bends", "h_shifts")}
    require(len(lengths) == 1 and len(shifts) % 8 == 0 and len(shifts) > 16, "the curves of the C have tables of unequal lengths")
    piece = Fraction(1 << 26)
    reciprocal_error = max(row_error(rows[k], scaled_reciprocal, (16 + k) * piece, piece, Fraction(1))[0] for k in range(16))
    first = h_of(Fraction(1, 2))[0] / max(tables["levels"][16], 1)
    base, h_rows = shifts[16] - min(range(-64, 64), key=lambda k: abs(1 - first / Fraction(2) ** k)), []
    for row in range(16, len(shifts)):
        octave, number = divmod(row - 16, 8)
        length = Fraction(1, 16 << octave)
        h_rows.append(row_error(rows[row], h_of, (8 + number) * length, length, Fraction(2) ** (shifts[row] - base)))
    return Curves(reciprocal_error, h_rows, base)
