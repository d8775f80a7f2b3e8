"""Conflict windows (5) by repaired arithmetic: when the reachability tube meets an unsafe set in one dimension.

As printed, (5) divides by That - X0hat and takes atanh outside (-1, 1). Here the set of sigma in [0, 1] with
rho_U >= lower(U) and rho_L <= upper(U) is the solution of two linear inequalities, an interval, exactly; it is mapped to
time by t = t_c a / (1 + a), a = atanh(sigma). sigma = 1 maps to t_c, and the window then never closes. The literal design uses
the windows; the lemmas `windows.*` prove them.
"""

from __future__ import annotations

import math
from fractions import Fraction

from stt_codegen.designs import Edge

Interval = tuple[Fraction, Fraction]


def conflict_in_sigma(start: Edge, target: Edge, unsafe: Edge) -> Interval | None:
    """Return the sigma in [0, 1] for which the tube overlaps (or touches) the unsafe set in this dimension; None when none."""
    above = _where_at_least(start[1], target[1], unsafe[0])
    below = _where_at_least(-start[0], -target[0], -unsafe[1])
    if above is None or below is None:
        return None
    low, high = max(above[0], below[0]), min(above[1], below[1])
    return (low, high) if low <= high else None


def _where_at_least(start: Fraction, end: Fraction, bound: Fraction) -> Interval | None:
    """Return the sigma in [0, 1] with start + (end - start) sigma >= bound."""
    slope = end - start
    if slope == 0:
        return (Fraction(0), Fraction(1)) if start >= bound else None
    crossing = (bound - start) / slope
    low, high = (max(crossing, Fraction(0)), Fraction(1)) if slope > 0 else (Fraction(0), min(crossing, Fraction(1)))
    return (low, high) if low <= high else None


def time_of_sigma(sigma: Fraction, t_c: Fraction) -> float:
    """Return the time at which the profile of (4) reaches sigma in [0, 1], in seconds."""
    if sigma >= 1:
        return float(t_c)
    a = math.atanh(float(sigma))
    return float(t_c) * a / (1 + a)
