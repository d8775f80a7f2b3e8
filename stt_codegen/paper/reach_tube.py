"""Section III-A: the reachability tube (4), rho = X0hat + (That - X0hat) sigma(t), edge by edge.

sigma(t) = tanh(t / (t_c - t)) before t_c and 1 from then on. With s = t / (t_c - t) and d = exp(-2 s): sigma = (1 - d) / (1 + d).
The denominator has the floor t_c / 1024, where d has underflowed to 0 long before. So sigma is exactly 1 there and its derivative
exactly 0, although s is no longer the printed one. No t in [0, t_c] divides by zero or overflows.
"""

from __future__ import annotations

import casadi as ca

MINIMUM_REST = 2.0**-10  # a floor of the time left, in parts of t_c: d = exp(-2 * 1023) is 0 in double and float


def sigma(t: ca.SX, t_c: ca.SX) -> ca.SX:
    """Return the time profile of (4) for t in [0, t_c]."""
    s = t / ca.fmax(t_c - t, MINIMUM_REST * t_c)
    d = ca.exp(-2 * s)
    return (1 - d) / (1 + d)


def profile(rate: bool = False) -> ca.Function:
    """t (held within [0, t_c]), t_c -> sigma; with `rate` also its derivative (1 + s)^2 sech(s)^2 / t_c, by differentiation."""
    t, t_c = ca.SX.sym("t"), ca.SX.sym("t_c")
    value = sigma(t, t_c)
    if not rate:
        return ca.Function("profile", [t, t_c], [value], ["t", "t_c"], ["sigma"])
    outputs = [value, ca.jacobian(value, t)]
    return ca.Function("profile_rate", [t, t_c], outputs, ["t", "t_c"], ["sigma", "sigma_rate"])


def reach_edge() -> ca.Function:
    """start, end, sigma -> rho, one edge of the reachability tube (4)."""
    start, end, value = ca.SX.sym("start"), ca.SX.sym("end"), ca.SX.sym("sigma")
    return ca.Function("reach_edge", [start, end, value], [start + (end - start) * value], ["start", "end", "sigma"], ["rho"])


def reach_rate() -> ca.Function:
    """start, end, sigma_rate -> the rate of rho."""
    start, end, rate = ca.SX.sym("start"), ca.SX.sym("end"), ca.SX.sym("sigma_rate")
    return ca.Function("reach_rate", [start, end, rate], [(end - start) * rate], ["start", "end", "sigma_rate"], ["rho_rate"])
