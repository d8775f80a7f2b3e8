"""The logarithm of a rational number, from below and from above, in exact fractions."""

from __future__ import annotations

import math
from fractions import Fraction

BITS = 64  # of a logarithm's argument and of its series
TERMS = 15  # 2 artanh z, |z| <= 1/5: what is left out is below 5^-31


def logarithm(y: Fraction) -> tuple[Fraction, Fraction]:
    """Return bounds on ln y for y > 1, from below and from above.

    ln 2^k m = k ln 2 + 2 artanh((m - 1)/(m + 1)) with m from 2^-1/2 to 2^1/2.
    """
    k = math.floor(math.log2(float(y)) + 0.5)
    m = y / Fraction(2) ** k
    low, high = _artanh((m - 1) / (m + 1))
    # ln 2 = 3 ln (5/4) + ln (128/125), each logarithm twice an artanh
    half_log_two = [3 * a + b for a, b in zip(_artanh(Fraction(1, 9)), _artanh(Fraction(3, 253)), strict=True)]
    return 2 * (low + k * half_log_two[0]), 2 * (high + k * half_log_two[1])


def _artanh(z: Fraction) -> tuple[Fraction, Fraction]:
    """Return bounds on artanh z, |z| < 1/4: of z rounded outwards to BITS bits, by the series with its remainder."""
    scale = 1 << BITS
    ends = Fraction(math.floor(z * scale), scale), Fraction(math.ceil(z * scale), scale)
    low, high = (sum((v ** (2 * j + 1) / (2 * j + 1) for j in range(TERMS)), Fraction(0)) for v in ends)
    remainder = max(abs(v) for v in ends) ** (2 * TERMS + 1)  # the remainder is below z^(2N+1)/((2N+1)(1 - z^2))
    return (
        Fraction(math.floor((low - remainder) * scale), scale),
        Fraction(math.ceil((high + remainder) * scale), scale),
    )
