"""The tables of 1/d and of H(y) = 4 ln((2 - y)/y)/((1 - y) y (2 - y)) of a controller in integers: how far their rows are off."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from .exact import require
from .period import logarithm

Enclosure = tuple[Fraction, Fraction]  # from below and above


class Row(NamedTuple):
    """A piece of a curve: level - (slope - bend z) z/2 for z from 0 to 1."""

    level: int
    slope: int
    bend: int


class Curves(NamedTuple):
    """inverse_error: of 1/d, relative. steep_rows: of every row of H its relative error and its least value, as the table counts.
    base: 2^places of the table stands for 2^(places - base)."""

    inverse_error: Fraction
    steep_rows: list[Enclosure]
    base: int


def inverse(m: Fraction) -> Enclosure:
    return (1 << 46) / m, (1 << 46) / m


@cache
def steep(y: Fraction) -> Enclosure:
    """Return H for 0 < y <= 1."""
    if y == 1:
        return Fraction(8), Fraction(8)
    low, high = logarithm((2 - y) / y)
    return 4 * low / ((1 - y) * y * (2 - y)), 4 * high / ((1 - y) * y * (2 - y))


def fitted(row: Row, f: Callable[[Fraction], Enclosure], begin: Fraction, length: Fraction, scale: Fraction) -> Enclosure:
    """Return the largest relative error of a row of a curve f/scale on its piece, and the least value of f/scale there.

    Let P = level - (slope - bend z) z/2 be the row, z from 0 to 1, and F = f/scale - P. On a quarter of the piece F is the
    quadratic through its values at both ends and in the middle, within its three Bezier coefficients, and its third
    derivative/6 times z (z - 1/2) (z - 1), which is at most 1/20. f is 2^46/m or H. Its third derivative falls in size: for
    1/m plainly; H is 8 atanh(e)/e/(1 - e^2) with e = 1 - y, a power series in e with no negative coefficient. So a third
    difference of values up to the quarter shows no less. What is emitted is less than 1/2 below P and less than 1 above, for
    `bent` and `fall` are rounded down. z is rounded down too, by less than 2^-16, in which P falls by slope/2^17 or rises by
    (2 bend - slope)/2^17 at most."""
    level, slope, bend = row
    require(0 <= bend <= slope < 1 << 15 and slope // 2 < level < 1 << 16, "a row of the curves of the C has values out of range")
    enclosures = {k: f(begin + length * k / 8) for k in (-6, -4, -2, *range(9))}
    uncertainty = 16 * max(high - low for low, high in enclosures.values()) / scale
    value = {k: low / scale for k, (low, _) in enclosures.items()}
    off = [value[k] - level + (slope - Fraction(bend * k, 8)) * Fraction(k, 16) for k in range(9)]
    lowest, highest = Fraction(0), Fraction(0)
    for k in range(0, 8, 2):
        third = abs(value[k] - 3 * value[k - 2] + 3 * value[k - 4] - value[k - 6]) / 120 + uncertainty
        coefficients = off[k], 2 * off[k + 1] - (off[k] + off[k + 2]) / 2, off[k + 2]
        lowest, highest = min(lowest, min(coefficients) - third), max(highest, max(coefficients) + third)
    above = highest + Fraction(1, 2) + Fraction(max(0, 2 * bend - slope), 1 << 17)
    smallest = value[8] - uncertainty
    return max(above, 1 + Fraction(slope, 1 << 17) - lowest) / smallest, smallest


def check_curves(tables: dict[str, list[int]]) -> Curves:
    """Compare every row with its curve: 16 rows of 1/d, by the 4 bits behind the first, then 8 for each octave of y."""
    rows, places = list(map(Row, tables["levels"], tables["slopes"], tables["bends"])), tables["places"]
    lengths = {len(tables[name]) for name in ("levels", "slopes", "bends", "places")}
    require(len(lengths) == 1 and len(places) % 8 == 0 and len(places) > 16, "the curves of the C have tables of unequal lengths")
    inverse_error = max(fitted(rows[k], inverse, Fraction((16 + k) << 26), Fraction(1 << 26), Fraction(1))[0] for k in range(16))
    first = steep(Fraction(1, 2))[0] / max(tables["levels"][16], 1)
    base, steep_rows = places[16] - min(range(-64, 64), key=lambda k: abs(1 - first / Fraction(2) ** k)), []
    for row in range(16, len(places)):
        octave, head = divmod(row - 16, 8)
        length = Fraction(1, 16 << octave)
        steep_rows.append(fitted(rows[row], steep, (8 + head) * length, length, Fraction(2) ** (places[row] - base)))
    return Curves(inverse_error, steep_rows, base)
