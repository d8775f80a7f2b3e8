"""Section III-C: the adaptive tube (10) and its update function (11), for one dimension and one side at a time.

controller/kernels/adaptive_kernels.py lowers these functions; the lemmas `kernels.*` and `update.*` are about them.

gamma_L = smooth max(rho_L - alpha_L, beta_L),  gamma_U = smooth min(rho_U + alpha_U, beta_U)
psi_L = beta_U - rho_L,  psi_U = rho_U - beta_L
alphadot = theta / (psi + alpha)^2 - kappa alpha,  alpha(0) = 0,  theta = theta0 (1 - tanh(varsigma (psi - mu)))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi as ca

from stt_codegen.paper.smooth import smooth_max, smooth_min

NAMES = ["theta0", "kappa", "mu", "varsigma"]
EXPONENT_LIMIT = 40.0  # of y in theta: exp(80) is finite in binary32
NEWTON = 7  # iterations; 6 reach the root up to rounding (a test searches for the worst p and q)
MINIMUM_ROOT = 2.0**-60  # a floor of z in the implicit step, where q underflows
MINIMUM_GAP = 2.0**-30  # a floor of psi + alpha in divisions, which is never reached where psi(0) > 0


def trigger(psi: ca.SX, theta0: ca.SX, mu: ca.SX, varsigma: ca.SX) -> ca.SX:
    """Return theta of (11), the sign function smoothed by tanh: 2 theta0 in conflict, 0 away from it.

    1 - tanh(y) = 2 / (1 + exp(2 y)), which is accurate where it is small. y is limited to 40, where this is below 4e-35.
    """
    y = ca.fmin(varsigma * (psi - mu), EXPONENT_LIMIT)
    return 2 * theta0 / (1 + ca.exp(2 * y))


def theta() -> ca.Function:
    """psi, theta0, mu, varsigma -> theta of (11)."""
    psi, theta0, mu, varsigma = symbols = [ca.SX.sym(n) for n in ("psi", "theta0", "mu", "varsigma")]
    return ca.Function("theta", symbols, [trigger(psi, theta0, mu, varsigma)], ["psi", "theta0", "mu", "varsigma"], ["theta"])


def equation(psi: ca.SX, alpha: ca.SX, parameters: Sequence[ca.SX]) -> ca.SX:
    """Return alphadot of (11); parameters: those of NAMES."""
    theta0, kappa, mu, varsigma = parameters
    z = ca.fmax(psi + alpha, MINIMUM_GAP)
    return trigger(psi, theta0, mu, varsigma) / z / z - kappa * alpha  # not z * z: its derivative would have z^4


def update_rate() -> ca.Function:
    """psi, alpha, parameters -> alphadot (11) and d alphadot / d alpha, by differentiation."""
    names = ["psi", "alpha", *NAMES]
    psi, alpha, *parameters = symbols = [ca.SX.sym(n) for n in names]
    rate = equation(psi, alpha, parameters)
    return ca.Function("update_rate", symbols, [rate, ca.jacobian(rate, symbols[1])], names, ["alpha_rate", "jacobian"])


def update_time_jacobian() -> ca.Function:
    """psi, psi_rate, alpha, parameters -> d alphadot / d t = (d alphadot / d psi) psidot, by differentiation."""
    names = ["psi", "psi_rate", "alpha", *NAMES]
    psi, psi_rate, alpha, *parameters = symbols = [ca.SX.sym(n) for n in names]
    in_time = ca.jacobian(equation(psi, alpha, parameters), psi) * psi_rate
    return ca.Function("update_time_jacobian", symbols, [in_time], names, ["time_jacobian"])


def implicit_start() -> ca.Function:
    """psi and theta's parameters at t + h, alpha at t, h -> p, q, rest and the first iterate z of the implicit step.

    Backward Euler alpha' = alpha + h (theta / (psi + alpha')^2 - kappa alpha') is, with z = psi + alpha', rest = alpha / (1 + h
    kappa), p = psi + rest and q = h theta / (1 + h kappa), the cubic (z - p) z^2 = q. It has one root with z > 0, z > p; Newton's
    iterates fall to it from above. For p >= 0 they start at p + q^(1/3). For p < 0 they start at the smaller of q^(1/3) and
    sqrt(q / -p), both above the root; from elsewhere they would only halve in each step while |p|^3 >> q.
    """
    psi, alpha, h = (ca.SX.sym(n) for n in ("psi", "alpha", "h"))
    theta0, kappa, mu, varsigma = (ca.SX.sym(n) for n in NAMES)
    damping = 1 + h * kappa
    rest = alpha / damping
    p = psi + rest
    q = h * trigger(psi, theta0, mu, varsigma) / damping
    cubic, square = ca.power(q, 1 / 3), ca.sqrt(q / ca.fmax(-p, MINIMUM_ROOT))
    z = ca.fmax(ca.if_else(p < 0, ca.fmin(cubic, square), p + cubic), MINIMUM_ROOT)
    inputs = [psi, alpha, h, theta0, kappa, mu, varsigma]
    return ca.Function("implicit_start", inputs, [p, q, rest, z], ["psi", "alpha", "h", *NAMES], ["p", "q", "rest", "z"])


def newton() -> ca.Function:
    """p, q, z -> the next Newton iterate for (z - p) z^2 = q, with the exact derivative."""
    p, q, z = (ca.SX.sym(n) for n in ("p", "q", "z"))
    residual = (z - p) * z * z - q
    return ca.Function(
        "newton", [p, q, z], [ca.fmax(z - residual / ca.jacobian(residual, z), MINIMUM_ROOT)], ["p", "q", "z"], ["next"]
    )


def implicit_end() -> ca.Function:
    """q, rest, z -> alpha at t + h, as rest + q / z^2: no cancellation, and never negative."""
    q, rest, z = (ca.SX.sym(n) for n in ("q", "rest", "z"))
    return ca.Function("implicit_end", [q, rest, z], [rest + q / (z * z)], ["q", "rest", "z"], ["alpha"])


def lower_edge(rate: bool = False) -> ca.Function:
    """rho_L, alpha_L, beta_L, nu -> gamma_L (10); with `rate`, their rates too -> its total rate, by differentiation."""
    return _edge("lower_edge", lambda rho, alpha, beta, nu: smooth_max(rho - alpha, beta, nu), rate)


def upper_edge(rate: bool = False) -> ca.Function:
    """rho_U, alpha_U, beta_U, nu -> gamma_U (10); with `rate`, their rates too -> its total rate, by differentiation."""
    return _edge("upper_edge", lambda rho, alpha, beta, nu: smooth_min(rho + alpha, beta, nu), rate)


def _edge(name: str, expression: Callable[..., ca.SX], rate: bool) -> ca.Function:
    """Return gamma from rho, alpha, beta and nu as a function of that name; with `rate`, its total rate too."""
    names = ["rho", "alpha", "beta", "nu"]
    rho, alpha, beta, _ = symbols = [ca.SX.sym(n) for n in names]
    gamma = expression(*symbols)
    if not rate:
        return ca.Function(name, symbols, [gamma], names, ["gamma"])
    rates = [ca.SX.sym(n) for n in ("rho_rate", "alpha_rate", "beta_rate")]
    total = ca.jtimes(gamma, ca.vertcat(rho, alpha, beta), ca.vertcat(*rates))
    inputs, labels = [*symbols, *rates], [*names, "rho_rate", "alpha_rate", "beta_rate"]
    return ca.Function(f"{name}_rate", inputs, [gamma, total], labels, ["gamma", "gamma_rate"])


def implicit_step(psi: ca.SX, alpha: ca.SX, h: ca.SX, parameters: Sequence[ca.SX]) -> ca.SX:
    """Return alpha at t + h by the implicit step as one expression, as the emitted loop computes it; for use in CasADi.

    psi: at t + h; alpha: at t; parameters: those of NAMES.
    """
    p, q, rest, z = implicit_start()(psi, alpha, h, *parameters)
    for _ in range(NEWTON):
        z = newton()(p, q, z)
    return implicit_end()(q, rest, z)


def implicit_step_function() -> ca.Function:
    """alpha at t, psi at t + h, h, parameters -> alpha at t + h; alpha first, so that it can be accumulated over steps."""
    names = ["alpha", "psi", "h", *NAMES]
    alpha, psi, h, *parameters = symbols = [ca.SX.sym(n) for n in names]
    return ca.Function("implicit_step", symbols, [implicit_step(psi, alpha, h, parameters)], names, ["after"])


def edge_jacobian() -> ca.Function:
    """rho_L, alpha_L, beta_L, nu -> gamma_L (10) and d gamma_L / d alpha_L in [-1, 0], by differentiation. The upper edge's
    is its mirror image; gamma depends on its own alpha alone, so the Jacobian of all edges is diagonal."""
    rho, alpha, beta, nu = symbols = [ca.SX.sym(n) for n in ("rho", "alpha", "beta", "nu")]
    gamma = smooth_max(rho - alpha, beta, nu)
    return ca.Function(
        "edge_jacobian", symbols, [gamma, ca.jacobian(gamma, alpha)], ["rho", "alpha", "beta", "nu"], ["gamma", "gamma_alpha"]
    )
