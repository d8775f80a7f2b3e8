"""Smooth maximum and minimum (section II), and the smooth joining of circumvent functions, in forms that cannot overflow.

nu > 0 is the sharpness, in 1 over the unit of a and b. The paper prints max(a, b) ~ ln(exp(nu a) + exp(nu b)) / nu, which
overflows a float32 at nu a = 88. The functions here compute the same number as (a + b)/2 + h + log1p(exp(-2 nu h)) / nu, with h =
|a - b| / 2. Its exponent is never positive. The mean (a + b)/2 is there so that automatic differentiation gives both a and b the
weight 1/2 where they are equal.

    max(a, b) <= smooth_max(a, b) <= max(a, b) + ln 2 / nu
    min(a, b) - ln 2 / nu <= smooth_min(a, b) <= min(a, b)
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
    """Return two joined circumvent functions (bumps) a, b >= 0: ln(exp(nu a) + exp(nu b) - 1) / nu.

    It replaces the max of the paper's equation (9), which has no continuous derivative. Where b = 0 the result is a, and where
    a = 0 it is b. It is at most max(a, b) + ln 2 / nu. Joining is associative: m bumps b_j joined one after the other give
    ln(1 + sum_j (exp(nu b_j) - 1)) / nu.
    """
    half = ca.fabs(a - b) / 2
    high = (a + b) / 2 + half
    return high + ca.log1p(ca.exp(-2 * nu * half) - ca.exp(-nu * high)) / nu
