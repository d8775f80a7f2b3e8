"""The kinds of number that the sampling conditions are computed in: doubles, or exact fractions.

The code for doubles also runs on balls (Arb) and on symbols, and so proves and states what it computes.

The formulas of this room are written once. What they need beyond +, -, *, /, comparisons, maxima and minima is here: conversions
with their rounding, and functions of a bound E on |eps| = |ln(a/b)|. These need only e^E and tanh(E/2). So fractions use the
rational rho = e^E in place of E: 1/(1 + e^-E) = rho/(1 + rho) and tanh(E/2) = (rho - 1)/(rho + 1). What remains are logarithms of
rationals, which are enclosed (the lemmas `sampled.fractions` and `sampled.logarithm`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import numpy as np

from stt_codegen.program.analyse import logarithm


class Numbers(Protocol):
    """What a kind of number can do. Every method takes and returns single numbers or arrays."""

    def of(self, value: Any) -> Any:
        """Return the number nearest to a fraction."""

    def toward(self, value: Fraction, end: float) -> Any:
        """Return a fraction as a number, rounded toward `end` if it must be rounded."""

    def outward(self, value: Any, share: float) -> Any:
        """Return a rounded value enlarged by this share of it; an exact value as it is."""

    def multiples_above(self, counts: Any, unit: Fraction) -> Any:
        """Return counts (whole numbers) times the unit, rounded up."""

    def root_above(self, value: Any) -> Any:
        """Return an upper bound on the square root."""

    def evenly(self, end: Fraction, parts: int) -> Any:
        """Return the times that cut [0, end] into equal parts: (parts + 1)."""

    def eps_of_share(self, share: Any) -> Any:
        """Return E at |e| = share: ln((1 + share)/(1 - share))."""

    def eps_of_ratio(self, ratio: Fraction) -> Any:
        """Return E at a/b = ratio: |ln ratio|."""

    def far_divisor(self, eps_bound: Any) -> Any:
        """Return 1 + e^-E: the width over the distance to the farther edge at |eps| = E."""

    def near_divisor(self, eps_bound: Any) -> Any:
        """Return 1 + e^E: the width over the distance to the nearer edge at |eps| = E."""

    def share_of_eps(self, eps_bound: Any) -> Any:
        """Return |e| at |eps| = E: tanh(E/2)."""

    def log_below(self, value: Any) -> Any:
        """Return a logarithm or a lower bound on it; for numbers above 1."""

    def log_above(self, value: Any) -> Any:
        """Return a logarithm or an upper bound on it."""

    def lesser(self, value: Any, limit: Any) -> Any:
        """Return the smaller of both, or the limit where they are nearly equal; `limit` may be infinite."""


class Doubles:
    """Doubles, rounded outward on conversion, and arrays of balls or of symbols; a bound on |eps| is E itself."""

    def of(self, value: Any) -> Any:
        return float(value)

    def toward(self, value: Fraction, end: float) -> Any:
        double = float(value)
        return double if Fraction(double) == value else math.nextafter(double, end)

    def outward(self, value: Any, share: float) -> Any:
        return value * (1 + share)

    def multiples_above(self, counts: Any, unit: Fraction) -> Any:
        return np.vectorize(lambda v: math.nextafter(float(int(v) * unit), math.inf), otypes=[float])(counts)

    def root_above(self, value: Any) -> Any:
        return np.sqrt(value) * (1 + 1e-12)

    def evenly(self, end: Fraction, parts: int) -> Any:
        return np.linspace(0.0, float(end), parts + 1)

    def eps_of_share(self, share: Any) -> Any:
        return 2 * (math.atanh(share) if isinstance(share, Fraction) else np.arctanh(share))

    def eps_of_ratio(self, ratio: Fraction) -> Any:
        return abs(math.log(ratio))

    def far_divisor(self, eps_bound: Any) -> Any:
        return 1 + np.exp(-eps_bound)

    def near_divisor(self, eps_bound: Any) -> Any:
        return 1 + np.exp(eps_bound)

    def share_of_eps(self, eps_bound: Any) -> Any:
        return np.tanh(eps_bound / 2)

    def log_below(self, value: Any) -> Any:
        return np.log(value)

    def log_above(self, value: Any) -> Any:
        return np.log(value)

    def lesser(self, value: Any, limit: Any) -> Any:
        is_clear = np.asarray(value, dtype=float) < limit * (1 - 1e-9)
        return np.where(is_clear, value, np.minimum(limit, 1e300))


@dataclass(frozen=True)
class Fractions:
    """Exact fractions, in arrays of objects; a bound on |eps| is rho = e^E.

    enclosed: a function that returns both ends of an enclosed logarithm.
    """

    enclosed: Callable[[Any], tuple[Any, Any]] = logarithm

    def of(self, value: Any) -> Any:
        return Fraction(value)

    def toward(self, value: Fraction, _end: float) -> Any:
        return value

    def outward(self, value: Any, _share: float) -> Any:
        return value

    def multiples_above(self, counts: Any, unit: Fraction) -> Any:
        return counts.astype(object) * unit

    def root_above(self, value: Any) -> Any:
        scale = 1 << 64
        return np.frompyfunc(lambda v: Fraction(math.isqrt(math.floor(v * scale**2)) + 1, scale), 1, 1)(value)

    def evenly(self, end: Fraction, parts: int) -> Any:
        return np.array([end * k / parts for k in range(parts + 1)], dtype=object)

    def eps_of_share(self, share: Any) -> Any:
        return (1 + share) / (1 - share)

    def eps_of_ratio(self, ratio: Fraction) -> Any:
        return max(ratio, 1 / ratio)

    def far_divisor(self, eps_bound: Any) -> Any:
        return 1 + 1 / eps_bound

    def near_divisor(self, eps_bound: Any) -> Any:
        return 1 + eps_bound

    def share_of_eps(self, eps_bound: Any) -> Any:
        return (eps_bound - 1) / (eps_bound + 1)

    def log_below(self, value: Any) -> Any:
        return np.frompyfunc(lambda v: self.enclosed(v)[0], 1, 1)(value)

    def log_above(self, value: Any) -> Any:
        return np.frompyfunc(lambda v: self.enclosed(v)[1], 1, 1)(value)

    def lesser(self, value: Any, limit: Any) -> Any:
        return np.minimum(value, limit)


DOUBLES, FRACTIONS = Doubles(), Fractions()
