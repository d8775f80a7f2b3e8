"""Section IV: normalized error e, transformed error eps, its Jacobian xi, and the control law (13), by component.

gamma_L and gamma_U are the lower and upper edge, gamma_s = gamma_L + gamma_U and gamma_d = gamma_U - gamma_L. All functions take
the distances to the edges, a = x - gamma_L and b = gamma_U - x. So no digits are lost where x is near an edge:

    e   = (2 x - gamma_s) / gamma_d          = (a - b) / gamma_d
    eps = ln((1 + e) / (1 - e))              = ln(a / b)
    xi  = 4 / (gamma_d (1 - e^2))            = 1/a + 1/b          = d eps / d x

The paper prints xi with I - e e^T. Read as an outer product, that matrix is singular for some e in the domain, and it is not the
Jacobian of eps. So e e^T stands for the diagonal matrix of e_i^2.
"""

from __future__ import annotations

import casadi as ca


def normalized_error() -> ca.Function:
    """a, b, width = gamma_d -> e, in (-1, 1) inside the tube."""
    a, b, width = ca.SX.sym("a"), ca.SX.sym("b"), ca.SX.sym("width")
    return ca.Function("normalized_error", [a, b, width], [(a - b) / width], ["a", "b", "width"], ["e"])


def transformed_error() -> ca.Function:
    """a, b > 0 -> eps = ln(a/b) = -ln(b/a) and xi = 1/a + 1/b = (1 + b/a) / b.

    The emitted code calls it with a <= b: `a` is the distance to the nearer edge there, and the sign of the gain says which edge
    that is. So ln(b/a) is the logarithm of a number that is at least 1. A test compares xi with `xi_by_differentiation`. Two
    divisions are needed, b/a and the one in xi. One division, 1/(a b), would do with more products, but it is no faster on boards
    without an FPU.
    """
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    ratio = b / a
    return ca.Function("transformed_error", [a, b], [-ca.log(ratio), (1 + ratio) / b], ["a", "b"], ["epsilon", "xi"])


def xi_by_differentiation() -> ca.Function:
    """x, gamma_L, gamma_U -> d eps / d x, by automatic differentiation of eps = ln((x - gamma_L) / (gamma_U - x))."""
    x, lower, upper = ca.SX.sym("x"), ca.SX.sym("lower"), ca.SX.sym("upper")
    epsilon = ca.log((x - lower) / (upper - x))
    return ca.Function("xi_by_differentiation", [x, lower, upper], [ca.jacobian(epsilon, x)])


def law() -> ca.Function:
    """k, xi, eps -> u = -k xi eps (13)."""
    k, xi, epsilon = ca.SX.sym("k"), ca.SX.sym("xi"), ca.SX.sym("epsilon")
    return ca.Function("law", [k, xi, epsilon], [-(k * xi * epsilon)], ["k", "xi", "epsilon"], ["u"])


def law_jacobian() -> ca.Function:
    """x, gamma_L, gamma_U, their rates, k -> u (13), du/dx, and du/dt at fixed x, by differentiation.

    Every component of u depends on its own x alone, so the Jacobian du/dx of the whole law is diagonal.
    """
    names = ["x", "lower", "upper", "lower_rate", "upper_rate", "k"]
    x, lower, upper, lower_rate, upper_rate, k = symbols = [ca.SX.sym(n) for n in names]
    a, b = x - lower, upper - x
    ratio = a / b
    u = -(k * ((1 + ratio) / a) * ca.log(ratio))
    in_time = ca.jtimes(u, ca.vertcat(lower, upper), ca.vertcat(lower_rate, upper_rate))
    return ca.Function("law_jacobian", symbols, [u, ca.jacobian(u, x), in_time], names, ["u", "u_x", "u_t"])
