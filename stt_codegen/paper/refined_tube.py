"""The refined tube: uniform cubic B-splines. Not in the paper; Theorem 4.1 holds for any bounded Lipschitz tube of
positive width with x(0) inside, and this one is C2.

With spline time u = K t / t_c, segment k = floor(u) and s = u - k in [0, 1], an edge of the tube is

    gamma = sum_{j=0..3} q[k + j] w_j(s),      gammadot = (K / t_c) sum_{j=0..3} q[k + j] w_j'(s)

where q are the control points divided by 6 and w the B-spline weights times 6.
"""

from __future__ import annotations

import casadi as ca


def weights(s: ca.SX) -> ca.SX:
    """6 times the uniform cubic B-spline basis on one segment, w_j(s) for j = 0..3; they are >= 0 and sum to 6.

    Written without cancellation: with r = 1 - s, w1 = 4 - 6 s^2 + 3 s^3 = 1 + 3 r (1 + r s), and w2 mirrors it.
    """
    r = 1 - s
    h = 3 * (1 + r * s)
    return ca.vertcat(r * r * r, 1 + r * h, 1 + s * h, s * s * s)


def basis() -> ca.Function:
    """s -> w (4)."""
    s = ca.SX.sym("s")
    return ca.Function("basis", [s], [weights(s)], ["s"], ["w"])


def basis_rate() -> ca.Function:
    """s -> dw/ds (4), by differentiation of the weights."""
    s = ca.SX.sym("s")
    return ca.Function("basis_rate", [s], [ca.jacobian(weights(s), s)], ["s"], ["dw"])


def blend() -> ca.Function:
    """w (4), q (4) -> sum of w_j q_j: an edge of the tube, or with dw its slope in spline time."""
    w, q = ca.SX.sym("w", 4), ca.SX.sym("q", 4)
    value = (w[0] * q[0] + w[1] * q[1]) + (w[2] * q[2] + w[3] * q[3])
    return ca.Function("blend", [w, q], [value], ["w", "q"], ["edge"])
