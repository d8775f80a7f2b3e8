"""Smooth maximum and minimum (section II), and the smooth joining of circumvent functions, in forms that cannot overflow.

Printed: max(a, b) ~ ln(exp(nu a) + exp(nu b)) / nu, which overflows a float32 at nu a = 88. As built, with
h = |a - b| / 2: (a + b)/2 + h + log1p(exp(-2 nu h)) / nu, the same number; the exponent is never positive. Written with the
mean, so that automatic differentiation gives weights of one half each where a = b.

    max(a, b) <= smooth_max(a, b) <= max(a, b) + ln 2 / nu, and the mirror image for the minimum.
"""

from __future__ import annotations

import casadi as ca


def smooth_max(a: ca.SX, b: ca.SX, nu: ca.SX) -> ca.SX:
    """Return a smooth maximum, above the maximum by at most ln 2 / nu."""
    half = ca.fabs(a - b) / 2
    return (a + b) / 2 + half + ca.log1p(ca.exp(-2 * nu * half)) / nu


def smooth_min(a: ca.SX, b: ca.SX, nu: ca.SX) -> ca.SX:
    """Return a smooth minimum, below the minimum by at most ln 2 / nu."""
    half = ca.fabs(a - b) / 2
    return (a + b) / 2 - half - ca.log1p(ca.exp(-2 * nu * half)) / nu


def smooth_join(a: ca.SX, b: ca.SX, nu: ca.SX) -> ca.SX:
    """Join two bumps a, b >= 0: ln(exp(nu a) + exp(nu b) - 1) / nu, in place of the max in (9), which is not C1.

    Equal to the other where one is 0 (no bias at rest), at most max(a, b) + ln 2 / nu, and associative: m bumps joined one
    after the other give ln(1 + sum_j (exp(nu b_j) - 1)) / nu.
    """
    half = ca.fabs(a - b) / 2
    high = (a + b) / 2 + half
    return high + ca.log1p(ca.exp(-2 * nu * half) - ca.exp(-nu * high)) / nu
