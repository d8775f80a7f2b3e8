"""Lemmas about Theorem 4.1: error dynamics and Lyapunov step as identities, the repaired inequality, and the printed one.

book.py takes LEMMAS as the family `theorem`. docs/paper.md has the theorem in words.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from stt_codegen.lemmas.law_slopes import prove_slope_bound
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive, refute_by_counterexample

x, xdot, lower, upper, lower_rate, upper_rate = sp.symbols("x xdot gamma_L gamma_U gammadot_L gammadot_U", real=True)
S, D, S_RATE, D_RATE = upper + lower, upper - lower, upper_rate + lower_rate, upper_rate - lower_rate
E = (2 * x - S) / D


def _rate(expression: Any) -> Any:
    """Return the time derivative of an expression along the motion of x, gamma_L and gamma_U."""
    return sum(sp.diff(expression, v) * rate for v, rate in ((x, xdot), (lower, lower_rate), (upper, upper_rate)))


def _prove_edot() -> Outcome:
    return prove_identities(
        {"edot - (2/gamma_d)(xdot - (gammadot_s + gammadot_d e)/2)": _rate(E) - 2 / D * (xdot - (S_RATE + D_RATE * E) / 2)}
    )


def _prove_vdot() -> Outcome:
    e = sp.Symbol("e", real=True)
    epsilon = sp.log((1 + e) / (1 - e))
    edot = sp.Symbol("edot", real=True)
    d = sp.Symbol("gamma_d", positive=True)
    motion = sp.Symbol("r", real=True)  # xdot - (gammadot_s + gammadot_d e)/2
    vdot = (sp.diff(epsilon**2 / 2, e) * edot).subs(edot, 2 / d * motion)
    return prove_identities(
        {"d(eps^2/2)/dt - eps xi (xdot - (gammadot_s + gammadot_d e)/2)": vdot - epsilon * 4 / (d * (1 - e**2)) * motion}
    )


def _prove_norms() -> Outcome:
    """Prove for n = 1, 2, 3 that Vdot of n components is the sum of theirs, so it is v' r; the argument is the same for every
    n."""
    differences = {}
    for n in (1, 2, 3):
        e = sp.symbols(f"e1:{n + 1}", real=True)
        rates = sp.symbols(f"edot1:{n + 1}", real=True)
        v = sum(sp.log((1 + c) / (1 - c)) ** 2 for c in e) / 2
        rate_of_sum = sum(sp.diff(v, c) * rate for c, rate in zip(e, rates, strict=True))
        sum_of_rates = sum(sp.log((1 + c) / (1 - c)) * 2 / (1 - c**2) * rate for c, rate in zip(e, rates, strict=True))
        differences[f"n = {n}: Vdot - sum of eps_i (d eps_i/d e_i) edot_i"] = sp.simplify(rate_of_sum - sum_of_rates)
    return prove_identities(differences)


def _prove_component() -> Outcome:
    """Prove that r <= P - g k v at the upper edge is below 0 once g k v = 4 k g q(eps)/gamma_d is above P."""
    p, g, k, v, s = sp.symbols("P g k v s", positive=True)
    return prove_identities({"P - g k v at g k v = P + s, plus s": sp.expand((p - g * k * v).subs(v, (p + s) / (g * k)) + s)})


def _prove_effort() -> Outcome:
    """Prove that |u| = k h(a, b) falls where k g h > P: there adot < 0 and bdot > 0, and h rises with a and falls with b."""
    a, b, g, p, s = sp.symbols("a b g P s", positive=True)
    h = (1 / a + 1 / b) * sp.log(a / b)
    drift, low, high = sp.symbols("f gammadot_L gammadot_U", real=True)
    law = (p + s) / g  # k h
    y = a / b
    return all_of(
        prove_identities(
            {
                "adot = f - g k h - gammadot_L, at k h = (P + s)/g: less (f - gammadot_L - P) - s": sp.expand(
                    drift - g * law - low - ((drift - low - p) - s)
                ),
                "bdot = gammadot_U - f + g k h: less (gammadot_U - f + P) + s": sp.expand(
                    high - drift + g * law - ((high - drift + p) + s)
                ),
                "a^2 dh/da - (1 + a/b - ln(a/b))": sp.simplify(a**2 * sp.diff(h, a) - (1 + y - sp.log(y))),
                "b^2 dh/db + (1 + b/a + ln(a/b))": sp.simplify(b**2 * sp.diff(h, b) + (1 + 1 / y + sp.log(y))),
            }
        ),
        prove_slope_bound(),
    )


def _prove_skew() -> Outcome:
    """Prove v' g v = v' g_s v for n = 1, 2, 3: the antisymmetric part of g does no work."""
    differences = {}
    for n in (1, 2, 3):
        v = sp.Matrix(sp.symbols(f"v1:{n + 1}", real=True))
        g = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"g{i}{j}", real=True))
        differences[f"n = {n}: v' g v - v' (g + g')/2 v"] = sp.expand((v.T * g * v)[0] - (v.T * ((g + g.T) / 2) * v)[0])
    return prove_identities(differences)


def _prove_decrease() -> Outcome:
    """Prove -k g_min |v|^2 + |v| P < 0 for |v| > P/(k g_min), and Young's form of the same."""
    v_norm, gain, disturbance, excess = sp.symbols("w c P s", positive=True)
    bound = -gain * v_norm**2 + v_norm * disturbance
    return all_of(
        prove_identities(
            {
                "at |v| = P/c + s: less -(P + c s) s": sp.expand(
                    bound.subs(v_norm, disturbance / gain + excess) + (disturbance + gain * excess) * excess
                )
            }
        ),
        prove_identities(
            {
                "bound - (P^2/(4 c) - c (|v| - P/(2 c))^2)": sp.expand(
                    bound - (disturbance**2 / (4 * gain) - gain * (v_norm - disturbance / (2 * gain)) ** 2)
                )
            }
        ),
    )


def _prove_gain() -> Outcome:
    """Prove 1/(1 - e^2) >= 1, so that xi_i = 4/(gamma_d,i (1 - e_i^2)) >= 4/max gamma_d and |v| >= (4/max gamma_d) |eps|."""
    e, z = sp.symbols("e z", real=True)
    return all_of(
        prove_identities({"1/(1 - e^2) - 1 - e^2/(1 - e^2)": 1 / (1 - e**2) - 1 - e**2 / (1 - e**2)}),
        prove_identities({"1/(1 - e^2) - cosh(z)^2 for e = tanh z": sp.simplify(1 / (1 - sp.tanh(z) ** 2) - sp.cosh(z) ** 2)}),
        prove_positive({"cosh(z)^2": sp.cosh(z) ** 2}),
    )


def _refute_rayleigh() -> Outcome:
    """Compare both sides for g = I: |eps|^2 |xi|^2, where |xi| is the largest entry, and eps' xi xi eps."""
    eps = sp.log(3)
    xi = (sp.Integer(4), 4 / (100 * (1 - sp.Rational(1, 4))))
    claimed, true_value = max(xi) ** 2 * eps**2, xi[1] ** 2 * eps**2
    evidence = f"it says {sp.N(claimed, 5)} <= {sp.N(true_value, 3)}"
    return refute_by_counterexample(
        "the printed step", "gamma_d = diag(1, 100), e = (0, 1/2)", (claimed - true_value).is_positive, evidence
    )


def _prove_negative() -> Outcome:
    """Prove Remark 4.2: with -g in place of g and -k in place of k the closed loop is the same."""
    g, k, v = sp.symbols("g k v", real=True)
    work = g * (-k * v)
    return prove_identities({"g (-k v), less the same with -g and -k": work - work.subs({g: -g, k: -k}, simultaneous=True)})


LEMMAS = (
    Lemma(
        "theorem.edot",
        "The normalized error moves by edot = (2/gamma_d)(xdot - (gammadot_s + gammadot_d e)/2), by component.",
        r"\dot e = \tfrac{2}{\gamma_d}\bigl(\dot x - \tfrac12(\dot\gamma_s + \dot\gamma_d e)\bigr)",
        ("gamma_d > 0",),
        "Theorem 4.1",
        _prove_edot,
    ),
    Lemma(
        "theorem.vdot",
        "With V = eps^2/2 summed over components, Vdot is the sum of v_i (xdot_i - (gammadot_s + gammadot_d e)_i/2), v = xi eps.",
        r"\dot V = v^\top\bigl(\dot x - \tfrac12(\dot\gamma_s+\dot\gamma_d e)\bigr)",
        ("|e| < 1",),
        "Theorem 4.1",
        _prove_vdot,
    ),
    Lemma(
        "theorem.norms",
        "V = |eps|^2/2 and Vdot add up over the components, for every n.",
        r"\dot V = \sum_i v_i r_i",
        ("|e_i| < 1",),
        "Theorem 4.1",
        _prove_norms,
    ),
    Lemma(
        "theorem.skew",
        "v' g v depends on the symmetric part of g alone; so Vdot <= -k g_min |v|^2 + |v| |Phi|.",
        r"v^\top g v = v^\top g_s v",
        ("g_s >= g_min > 0", "Phi = f + w - (gammadot_s + gammadot_d e)/2"),
        "Theorem 4.1",
        _prove_skew,
    ),
    Lemma(
        "theorem.gain",
        "|v| >= (4/max gamma_d) |eps|.",
        r"\|v\| \ge \frac{4}{\max\gamma_d}\|\varepsilon\|",
        ("|e_i| < 1",),
        "ours",
        _prove_gain,
    ),
    Lemma(
        "theorem.decrease",
        "V falls while |v| > Phi/(k g_min), so |eps| <= max(|eps(0)|, max gamma_d Phi/(4 k g_min)) for ever.",
        r"\|\varepsilon\| \le \max\Bigl(\|\varepsilon(0)\|,\ \frac{\max\gamma_d\,\Phi}{4kg_{\min}}\Bigr)",
        ("|Phi| <= Phi over tube and disturbance",),
        "in place of the printed step, ours",
        _prove_decrease,
    ),
    Lemma(
        "theorem.component",
        "For diagonal g, by component: |eps_i| <= max(|eps_i(0)|, E) for every E with 4 k g_min q(E) > P max gamma_d, "
        "q(E) = E cosh(E/2)^2.",
        r"4kg_{\min}\,q(E) > P\max\gamma_d \Rightarrow r < 0 \text{ at } \varepsilon_i = E",
        ("g diagonal, f may couple", "P >= |f + w| + |edge rate|", "sampled.law, sampled.rises"),
        "ours",
        _prove_component,
    ),
    Lemma(
        "theorem.effort",
        "For diagonal g, by component: |u_i| <= max(|u_i(0)|, P_i/g_min).",
        r"|u_i| \le \max\Bigl(|u_i(0)|,\ \frac{P_i}{g_{\min}}\Bigr)",
        ("g diagonal, f may couple", "P_i >= |f_i + w_i - gammadot_edge,i| at both edges", "continuous control"),
        "ours",
        _prove_effort,
    ),
    Lemma(
        "theorem.negative",
        "For negative definite g_s a negative gain gives the same closed loop (Remark 4.2).",
        r"g\,(-kv) = (-g)(-(-k)v)",
        (),
        "Remark 4.2",
        _prove_negative,
    ),
    Lemma(
        "theorem.rayleigh",
        "g_min |eps|^2 |xi|^2 <= eps' xi g xi eps.",
        r"\underline g\,\|\varepsilon\|^2\|\xi\|^2 \le \varepsilon^\top\xi g\xi\varepsilon",
        ("|xi| is the spectral norm; g = I",),
        "Theorem 4.1 as printed",
        _refute_rayleigh,
    ),
)
