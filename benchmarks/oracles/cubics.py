"""Exact signs of cubics on [0, 1], for the oracles of tubes: roots are isolated by Arb, between them signs are taken exactly.

A cubic is its coefficients of 1, s, s^2, s^3. `tubes.py` and `moving_sets.py` ask where several cubics are negative at once, the
mutants where a cubic is smallest. Nothing is shared with `stt_codegen.certify`: no Bezier hull, no halving, no tolerance.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from flint import fmpq, fmpz_poly

END_ROOTS = fmpz_poly([0, 1, -1])  # s (1 - s): 0 and 1 as roots


class Undecided(Exception):
    """Two roots whose enclosures overlap; Arb promises that this does not happen."""


class Minimum(NamedTuple):
    """The smallest of several cubics on [0, 1]: its number among them, where it is smallest, and its value there."""

    cubic: int
    s: Fraction
    value: Fraction


def eightfold_range(a0: Any, a1: Any, a2: Any, a3: Any) -> tuple[Any, Any]:
    """Bound 8 times a0 + a1 s + a2 s^2 + a3 s^3 on [0, 1] from below and above, by its coefficients in y = 2 s - 1."""
    middle, even = 8 * a0 + 4 * a1 + 2 * a2 + a3, 2 * a2 + 3 * a3
    odd = abs(4 * a1 + 4 * a2 + 3 * a3) + abs(a3)
    return middle - odd + (even - abs(even)) // 2, middle + odd + (even + abs(even)) // 2


def less_bound(cubic: Sequence[Any], bound: Fraction) -> fmpz_poly:
    """Return an integer polynomial that has the sign of cubic - bound."""
    return fmpz_poly([int(a) * bound.denominator for a in cubic]) - bound.numerator


def point_where_all_are_negative(cubics: Sequence[fmpz_poly]) -> Fraction | None:
    """Return an s in [0, 1] where all these cubics with integer coefficients are negative; None where there is no such s."""
    product, undecided = END_ROOTS, []
    for p in cubics:
        low, high = eightfold_range(*(int(p[i]) for i in range(4)))
        if low >= 0:
            return None
        if high >= 0:  # a cubic that is negative everywhere excludes no s
            undecided.append(p)
            product *= p
    for s in _points_between_roots(product // product.gcd(product.derivative())):  # makes every root a simple one
        if all(p(s) < 0 for p in undecided):
            return to_fraction(s)
    return None


def _points_between_roots(polynomial: fmpz_poly) -> list[fmpq]:
    """Return a rational point of (0, 1) between each two neighbouring real roots. 0 and 1 must be roots, and all roots simple."""
    ends = sorted((r.mid().fmpq() - r.rad().fmpq(), r.mid().fmpq() + r.rad().fmpq()) for r in _real_roots(polynomial))
    if any(right >= left for (_, right), (left, _) in itertools.pairwise(ends)):
        raise Undecided(str(polynomial))
    points = [(right + left) / 2 for (_, right), (left, _) in itertools.pairwise(ends)]
    return [s for s in points if 0 < s < 1]


def _real_roots(polynomial: fmpz_poly) -> list[Any]:
    """Enclose the real roots in balls. Arb proves them apart, and gives a real root an imaginary part of exactly 0."""
    roots: Any = polynomial.complex_roots()  # with multiplicities, which the library's types leave out
    return [root.real for root, _ in roots if root.imag == 0]


def smallest_value(cubics: Iterable[Any]) -> Minimum:
    """Find the smallest value of several cubics on [0, 1]. It is taken at `s`, and the infimum is less than 2^-40 of the
    coefficients below it."""
    minima = []
    for index, cubic in enumerate(cubics):
        p = fmpz_poly([int(a) for a in cubic])
        stationary = [r.mid().fmpq() for r in _real_roots(p.derivative())] if p.degree() > 1 else []
        s = min((fmpq(0), fmpq(1), *(m for m in stationary if 0 < m < 1)), key=p)
        minima.append((p(s), index, s))
    value, index, s = min(minima)
    return Minimum(index, to_fraction(s), to_fraction(value))


def to_fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))
