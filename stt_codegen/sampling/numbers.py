"""The numbers that the sampling conditions are computed in: doubles, from which balls and symbols follow, or exact fractions.

The formulas of this room are written once. What they need besides +, -, *, /, comparisons, maxima and minima is here: conversions
with their rounding, and what is done with a bound E on |eps| = |ln(a/b)|. Of E only e^E and tanh(E/2) are asked for. So fractions
have the rational rho = e^E in the place of E, 1/(1 + e^-E) = rho/(1 + rho) and tanh(E/2) = (rho - 1)/(rho + 1); what is left are
logarithms of rationals, which are enclosed.
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
    """What a kind of number does. Every method takes and gives single numbers or arrays."""

    def of(self, value: Any) -> Any:
        """The number nearest to a fraction."""

    def toward(self, value: Fraction, end: float) -> Any:
        """A fraction as a number, rounded toward `end` where it is none."""

    def outward(self, value: Any, share: float) -> Any:
        """What was rounded, larger by that share of it: by nothing where nothing was rounded."""

    def multiples_above(self, counts: Any, unit: Fraction) -> Any:
        """So many units, integers (..), rounded up."""

    def root_above(self, value: Any) -> Any:
        """A bound on the square root."""

    def evenly(self, end: Fraction, parts: int) -> Any:
        """The times that cut [0, end] into equal parts: (parts + 1)."""

    def reach_of_share(self, share: Any) -> Any:
        """E at |e| = share: ln((1 + share)/(1 - share))."""

    def reach_of_ratio(self, ratio: Fraction) -> Any:
        """E at a/b = ratio: |ln ratio|."""

    def far_divisor(self, reach: Any) -> Any:
        """1 + e^-E: a width over the distance to the farther edge at |eps| = E."""

    def near_divisor(self, reach: Any) -> Any:
        """1 + e^E: a width over the distance to the nearer edge."""

    def share_of_reach(self, reach: Any) -> Any:
        """|e| at |eps| = E: tanh(E/2)."""

    def log_below(self, value: Any) -> Any:
        """A logarithm, or what is no larger; of numbers above 1."""

    def log_above(self, value: Any) -> Any:
        """A logarithm, or what is no less."""

    def lesser(self, value: Any, limit: Any) -> Any:
        """The lesser of both, or the limit where they are nearly equal; `limit` may be infinite."""


class Doubles:
    """Doubles that are rounded outwards where they are made, arrays of balls, and arrays of symbols; reaches are E."""

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

    def reach_of_share(self, share: Any) -> Any:
        return 2 * (math.atanh(share) if isinstance(share, Fraction) else np.arctanh(share))

    def reach_of_ratio(self, ratio: Fraction) -> Any:
        return abs(math.log(ratio))

    def far_divisor(self, reach: Any) -> Any:
        return 1 + np.exp(-reach)

    def near_divisor(self, reach: Any) -> Any:
        return 1 + np.exp(reach)

    def share_of_reach(self, reach: Any) -> Any:
        return np.tanh(reach / 2)

    def log_below(self, value: Any) -> Any:
        return np.log(value)

    def log_above(self, value: Any) -> Any:
        return np.log(value)

    def lesser(self, value: Any, limit: Any) -> Any:
        is_clear = np.asarray(value, dtype=float) < limit * (1 - 1e-9)
        return np.where(is_clear, value, np.minimum(limit, 1e300))


@dataclass(frozen=True)
class Fractions:
    """Exact fractions, in arrays of objects; reaches are rho = e^E. enclosed: the two ends of a logarithm."""

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

    def reach_of_share(self, share: Any) -> Any:
        return (1 + share) / (1 - share)

    def reach_of_ratio(self, ratio: Fraction) -> Any:
        return max(ratio, 1 / ratio)

    def far_divisor(self, reach: Any) -> Any:
        return 1 + 1 / reach

    def near_divisor(self, reach: Any) -> Any:
        return 1 + reach

    def share_of_reach(self, reach: Any) -> Any:
        return (reach - 1) / (reach + 1)

    def log_below(self, value: Any) -> Any:
        return np.frompyfunc(lambda v: self.enclosed(v)[0], 1, 1)(value)

    def log_above(self, value: Any) -> Any:
        return np.frompyfunc(lambda v: self.enclosed(v)[1], 1, 1)(value)

    def lesser(self, value: Any, limit: Any) -> Any:
        return np.minimum(value, limit)


DOUBLES, FRACTIONS = Doubles(), Fractions()
