"""Lemmas about the update function (11): alpha is not negative, psi + alpha stays away from 0, and the emitted implicit step.

book.py takes LEMMAS as a part of the family `update`; the other part is update_cells.py.
"""

from __future__ import annotations

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive, refute_by_counterexample

psi = sp.Symbol("psi", real=True)
alpha, theta0, kappa, varsigma, h, p_, q, z = sp.symbols("alpha theta0 kappa varsigma h p q z", positive=True)
mu = sp.Symbol("mu", real=True)
THETA = theta0 * (1 - sp.tanh(varsigma * (psi - mu)))


def _prove_jacobian() -> Outcome:
    rate = THETA / (psi + alpha) ** 2 - kappa * alpha
    claimed = -2 * THETA / (psi + alpha) ** 3 - kappa
    y = sp.Symbol("y", real=True)
    return all_of(
        prove_identities({"d alphadot/d alpha - (-2 theta/(psi + alpha)^3 - kappa)": sp.diff(rate, alpha) - claimed}),
        prove_identities(
            {"theta/theta0 - 2/(1 + exp(2 y)), so theta > 0": (1 - sp.tanh(y) - 2 / (1 + sp.exp(2 * y))).rewrite(sp.exp)}
        ),
    )


def _prove_not_negative() -> Outcome:
    rate = (THETA / (psi + alpha) ** 2 - kappa * alpha).subs(alpha, sp.Symbol("a", real=True))
    at_zero = rate.subs(sp.Symbol("a", real=True), 0)
    return prove_identities({"alphadot at alpha = 0 less theta/psi^2, which is above 0": at_zero - THETA / psi**2})


def _prove_away() -> Outcome:
    """Prove that z = psi + alpha rises where z = s < s*.

    There s <= mu, so psi = z - alpha <= mu and theta >= theta0; and alpha = s - psi <= s + Psi.
    """
    s, psi_rate_bound, psi_bound = sp.symbols("s D Psi", positive=True)
    zdot = -psi_rate_bound + theta0 / s**2 - kappa * (s + psi_bound)
    threshold = psi_rate_bound + kappa * (s + psi_bound)
    y = sp.Symbol("y", nonnegative=True)
    return all_of(
        prove_identities({"zdot's bound where theta0/s^2 = D + kappa (s + Psi)": zdot.subs(theta0, s**2 * threshold)}),
        prove_identities({"theta at psi = mu, less theta0": THETA.subs(psi, mu) - theta0}),
        prove_identities(
            {
                "theta at psi = mu - y/varsigma, less theta0 (1 + tanh y)": THETA.subs(psi, mu - y / varsigma)
                - theta0 * (1 + sp.tanh(y))
            }
        ),
        prove_positive({"tanh y, y > 0": sp.tanh(sp.Symbol("y", positive=True))}),
    )


def _prove_cubic() -> Outcome:
    """Prove that backward Euler, alpha' = alpha + h (theta/z^2 - kappa alpha') with z = psi + alpha', is the cubic."""
    theta = sp.Symbol("theta", positive=True)
    next_alpha = z - psi
    residual = (next_alpha - alpha - h * (theta / z**2 - kappa * next_alpha)) * z**2 / (1 + h * kappa)
    cubic = (z - (psi + alpha / (1 + h * kappa))) * z**2 - h * theta / (1 + h * kappa)
    return prove_identities({"backward Euler times z^2/(1 + h kappa) less the cubic": residual - cubic})


def _prove_unique() -> Outcome:
    """Prove that f = (z - p) z^2 - q is -q at 0 and at z = p, and rises where z > max(p, 0), since f' = z (3 z - 2 p)."""
    p = sp.Symbol("p", real=True)
    f = (z - p) * z**2 - q
    y = sp.Symbol("y", positive=True)
    return all_of(
        prove_identities(
            {
                "f' - z (3 z - 2 p)": sp.diff(f, z) - z * (3 * z - 2 * p),
                "f at 0 plus q": f.subs(z, 0) + q,
                "f at p plus q": f.subs(z, p) + q,
            }
        ),
        prove_identities({"3 z - 2 p at z = p + y, p > 0, less p + 3 y": (3 * z - 2 * p_).subs(z, p_ + y) - (p_ + 3 * y)}),
    )


def _prove_newton_start() -> Outcome:
    """Prove that f is not negative at the start and f'' > 0 from there down to the root, to which Newton's iterates then fall."""
    r, m = sp.symbols("r m", positive=True)  # q = r^3, and p = -m where p is negative
    f_at_p_plus_r = ((z - p_) * z**2 - r**3).subs(z, p_ + r)
    f_at_r = ((z + m) * z**2 - r**3).subs(z, r)
    f_at_square_root = ((z + m) * z**2 - q).subs(z, sp.sqrt(q / m))
    return all_of(
        prove_identities({"p >= 0, z = p + r: f less r (p^2 + 2 p r)": f_at_p_plus_r - r * (p_**2 + 2 * p_ * r)}),
        prove_identities(
            {
                "p < 0, z = r: f less m r^2": f_at_r - m * r**2,
                "p < 0, z = sqrt(q/m): f less (q/m)^(3/2)": sp.simplify(f_at_square_root - (q / m) ** sp.Rational(3, 2)),
            }
        ),
        prove_identities({"f'' - (6 z - 2 p)": sp.diff((z - p_) * z**2, z, 2) - (6 * z - 2 * p_)}),
    )


def _refute_inverted_start() -> Outcome:
    """Enclose alphadot for psi = -1/2, kappa = 5, theta <= 2 theta0 = 0.02: it is below 0 at alpha = 0.1, so z stays below
    -0.4."""
    largest_rate = arb("0.02") / (arb("-0.5") + arb("0.1")) ** 2 - 5 * arb("0.1")
    evidence = f"alphadot <= {largest_rate.str(4)} at alpha = 0.1, so alpha stays below it and psi + alpha below -0.4"
    return refute_by_counterexample(
        "psi + alpha becomes positive", "psi = -1/2, kappa = 5, theta0 = 0.01", largest_rate < 0, evidence
    )


def _prove_bounded() -> Outcome:
    """Prove alphadot <= 0 at alpha = 2 theta0/(kappa s^2) where psi + alpha >= s, with theta <= 2 theta0 (update.jacobian)."""
    s, excess = sp.symbols("s m", positive=True)
    alpha_bound = 2 * theta0 / (kappa * s**2)
    rate = 2 * theta0 / (s + excess) ** 2 - kappa * alpha_bound
    return all_of(
        prove_identities({"alphadot's bound there at psi + alpha = s": rate.subs(excess, 0)}),
        prove_identities(
            {
                "at psi + alpha = s + m, plus 2 theta0 (2 s m + m^2)/(s^2 (s + m)^2)": sp.together(
                    rate + 2 * theta0 * (2 * s * excess + excess**2) / (s**2 * (s + excess) ** 2)
                )
            }
        ),
    )


def _refute_printed_lemma() -> Outcome:
    """Enclose the width where two bumps from opposite sides cross, beta_L = 5.2 over beta_U = 5, while both psi are 0.1.

    rho is [4.9, 5.3], alpha is 0 and nu is 100.
    """
    low, high, beta_low, beta_high, nu = arb("4.9"), arb("5.3"), arb("5.2"), arb(5), arb(100)
    psi = (beta_high - low, high - beta_low)
    gaps = [top - bottom for top in (high, beta_high) for bottom in (low, beta_low)]
    width = -sum(((-nu * g).exp() for g in gaps), arb(0)).log() / nu
    evidence = (
        f"psi + alpha is {psi[0].str(2)} and {psi[1].str(2)}, gamma_d = {width.str(4)}; the gap of beta_U and beta_L is in no psi"
    )
    fails = psi[0] > 0 and psi[1] > 0 and width < 0
    return refute_by_counterexample(
        "gamma_d > 0 where psi + alpha > 0", "beta_L = 5.2, beta_U = 5, rho = [4.9, 5.3]", fails, evidence
    )


LEMMAS = (
    Lemma(
        "update.jacobian",
        "The Jacobian is -2 theta/(psi + alpha)^3 - kappa: negative, since theta is positive.",
        r"\frac{\partial\dot\alpha}{\partial\alpha} = -\frac{2\theta}{(\psi+\alpha)^3} - \kappa < 0",
        ("psi + alpha > 0",),
        "(11), ours",
        _prove_jacobian,
    ),
    Lemma(
        "update.not_negative",
        "alpha never becomes negative: at 0 it rises.",
        r"\dot\alpha|_{\alpha=0} = \theta/\psi^2 > 0",
        ("alpha(0) = 0", "psi is not 0 where alpha is 0"),
        "(11), ours",
        _prove_not_negative,
    ),
    Lemma(
        "update.away",
        "psi + alpha >= min(s*, psi(0), mu) with theta0/s*^2 = D + kappa (s* + Psi): where it equals s < s* it rises.",
        r"\psi+\alpha \ge \min(s^*,\psi(0),\mu),\quad \frac{\theta_0}{s^{*2}} = D + \kappa(s^*+\Psi)",
        ("psi(0) > 0", "|psidot| <= D", "|psi| <= Psi", "s* <= mu; theta0/s^2 - kappa s falls with s"),
        "in place of Lemma 3.3, ours",
        _prove_away,
    ),
    Lemma(
        "update.cubic",
        "One implicit Euler step of (11) is the cubic (z - p) z^2 = q.",
        r"(z-p)z^2 = q,\quad p = \psi + \tfrac{\alpha}{1+h\kappa},\ q = \tfrac{h\theta}{1+h\kappa}",
        ("z = psi + alpha' > 0",),
        "ours",
        _prove_cubic,
    ),
    Lemma(
        "update.unique",
        "The cubic has one root with z > max(p, 0).",
        r"f(z) = (z-p)z^2 - q,\quad f' = z(3z-2p) > 0 \text{ for } z > \max(p,0)",
        ("q > 0",),
        "ours",
        _prove_unique,
    ),
    Lemma(
        "update.newton_start",
        "Newton's iterates start at or above the root and fall to it: f >= 0 at the start and f'' > 0 above the root.",
        r"f(z_0) \ge 0,\quad f'' = 6z - 2p > 0",
        ("q > 0", "z > max(p, 0), so 6 z > 2 p"),
        "ours",
        _prove_newton_start,
    ),
    Lemma(
        "update.inverted_start",
        "Whatever psi(0), psi + alpha becomes positive.",
        r"\exists t:\ \psi+\alpha > 0",
        ("kappa = 5, theta0 = 0.01: the case study's",),
        "(11) as printed",
        _refute_inverted_start,
    ),
    Lemma(
        "update.bounded",
        "alpha <= 2 theta0/(kappa s^2) where psi + alpha >= s; so |alphadot| <= 2 theta0/s^2 + kappa alpha is bounded.",
        r"0 \le \alpha \le \frac{2\theta_0}{\kappa s^2}",
        ("psi + alpha >= s (update.away)",),
        "in place of Lemma 3.3, ours",
        _prove_bounded,
    ),
    Lemma(
        "update.printed_lemma",
        "Lemma 3.3: with psi + alpha bounded away from 0 the tube has positive width (smooth.width says what it takes).",
        r"\psi+\alpha > 0 \Rightarrow \gamma_d > 0",
        ("(7)-(11) as printed, sides chosen one by one",),
        "Lemma 3.3 as printed",
        _refute_printed_lemma,
    ),
)
