"""Section IV: normalized error e, transformed error eps, its Jacobian xi, and the control law (13), by component.

Everything is written in the distances to the edges, a = x - gamma_L and b = gamma_U - x, which keeps it well conditioned
where x nears an edge:

    e   = (2 x - gamma_s) / gamma_d          = (a - b) / gamma_d
    eps = ln((1 + e) / (1 - e))              = ln(a / b)
    xi  = 4 / (gamma_d (1 - e^2))            = 1/a + 1/b          = d eps / d x

The printed xi has I - e e^T; read as an outer product it is singular inside the domain and not the Jacobian of eps.
"""

from __future__ import annotations

import casadi as ca


def normalized_error() -> ca.Function:
    """a, b, width = gamma_d -> e, in (-1, 1) inside the tube."""
    a, b, width = ca.SX.sym("a"), ca.SX.sym("b"), ca.SX.sym("width")
    return ca.Function("normalized_error", [a, b, width], [(a - b) / width], ["a", "b", "width"], ["e"])


def transformed_error() -> ca.Function:
    """a, b > 0 -> eps = ln(a/b) = -ln(b/a) and xi = 1/a + 1/b = (1 + b/a) / b.

    xi in this form costs one division; `xi_by_differentiation` is the same number from eps itself (a test shows it). It is
    called with a <= b, measured from the nearer edge, so that the logarithm is of a number that is not below 1.
    (With q = 1/(a b) for both, b b q and (a + b) q, one division would do. It costs 2 instructions a component on a Cortex-M4F,
    for 13 cycles of its FPU, and on boards without one two more products cost what the division does.)
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
    """x, gamma_L, gamma_U, their rates, k -> u (13), du/dx, and du/dt at fixed x, by differentiation; by component, so the
    Jacobian du/dx of the whole law is diagonal."""
    names = ["x", "lower", "upper", "lower_rate", "upper_rate", "k"]
    x, lower, upper, lower_rate, upper_rate, k = symbols = [ca.SX.sym(n) for n in names]
    a, b = x - lower, upper - x
    ratio = a / b
    u = -(k * ((1 + ratio) / a) * ca.log(ratio))
    in_time = ca.jtimes(u, ca.vertcat(lower, upper), ca.vertcat(lower_rate, upper_rate))
    return ca.Function("law_jacobian", symbols, [u, ca.jacobian(u, x), in_time], names, ["u", "u_x", "u_t"])
