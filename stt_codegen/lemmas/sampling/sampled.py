"""Lemmas about sampled control: conditions under which |eps| < E stays true while u is held between samples.

`sampling/sampling_conditions.py` evaluates these statements. If some |eps_i| reached E, then at the first such time r = xdot -
(gammadot_s + gammadot_d e)/2 would not point inward (`first_exit.py`). Each statement shows that r does point inward, although u
is that of an older sample, and names the steps of that argument. By symmetry (transform.odd) it is about the upper edge and
k > 0. P bounds |f + w| + |edge rate|; (gammadot_s + gammadot_d e)/2 is a mean of both edges' rates.

book.py takes LEMMAS as a part of the family `sampled`. Long because these lemmas refer to one another.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from flint import arb

from stt_codegen.lemmas.law_slopes import prove_slope_bound
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive, refute_by_counterexample

E = sp.Symbol("E", positive=True)
a, b, d, k, g, P = sp.symbols("a b d k g P", positive=True)
r, width_rate = sp.symbols("r ddot", real=True)
Q = E * sp.cosh(E / 2) ** 2
INPUT_OVER_GAIN = (1 / a + 1 / b) * sp.log(a / b)  # h(a, b) = |u|/k


def _in_exponentials(expression: Any) -> Any:
    """Rewrite hyperbolic functions of E/2 as one quotient of polynomials in y = exp(E/2)."""
    y = sp.Symbol("y", positive=True)
    written = sp.powsimp(sp.expand(expression).rewrite(sp.exp)).subs(E, 2 * sp.log(y))
    return sp.cancel(sp.together(sp.expand_log(sp.simplify(written))))


def _prove_law() -> Outcome:
    """Prove that xi eps is 4 q(eps)/gamma_d and h of the distances, with e = tanh(eps/2) and xi = 4/(gamma_d (1 - e^2))."""
    e = sp.tanh(E / 2)
    far, near = d / (1 + sp.exp(-E)), d / (1 + sp.exp(E))
    return prove_identities(
        {
            "xi eps - 4 q(eps)/gamma_d": _in_exponentials(4 / (d * (1 - e**2)) * E - 4 * Q / d),
            "(1/a + 1/b) gamma_d - 4 cosh(eps/2)^2": _in_exponentials((1 / far + 1 / near) * d - 4 * sp.cosh(E / 2) ** 2),
            "a/b - exp(eps)": sp.simplify(far / near - sp.exp(E)),
        }
    )


def _prove_rate() -> Outcome:
    """Prove the rate of v by the chain rule on 4 q(eps)/gamma_d, with epsdot = (d eps/de) edot and edot = (2/gamma_d) r."""
    epsdot = 2 * sp.cosh(E / 2) ** 2 * (2 / d) * r
    v = 4 * Q / d
    vdot = sp.diff(v, E) * epsdot + sp.diff(v, d) * width_rate
    claimed = 16 * sp.diff(Q, E) * sp.cosh(E / 2) ** 2 / d**2 * r - 4 * Q / d**2 * width_rate
    slope = 2 / (1 - sp.tanh(E / 2) ** 2)
    return prove_identities(
        {
            "d eps/de - 2 cosh(eps/2)^2": _in_exponentials(slope - 2 * sp.cosh(E / 2) ** 2),
            "vdot - (16 q' cosh^2 r/gamma_d^2 - 4 q gammadot_d/gamma_d^2)": sp.expand(vdot - claimed),
        }
    )


def _prove_rises() -> Outcome:
    """Prove q' = cosh^2 (1 + E tanh(E/2)), whose factors rise; so q and q' cosh^2 rise, and bounds at E hold below it."""
    return all_of(
        prove_identities(
            {
                "q' - cosh(E/2)^2 (1 + E tanh(E/2))": _in_exponentials(
                    sp.diff(Q, E) - sp.cosh(E / 2) ** 2 * (1 + E * sp.tanh(E / 2))
                ),
                "d(E tanh(E/2))/dE - tanh(E/2) - E sech(E/2)^2/2": _in_exponentials(
                    sp.diff(E * sp.tanh(E / 2), E) - sp.tanh(E / 2) - E / sp.cosh(E / 2) ** 2 / 2
                ),
            }
        ),
        prove_positive({"tanh(E/2)": sp.tanh(E / 2), "E sech(E/2)^2": E / sp.cosh(E / 2) ** 2}),
    )


def _prove_norm() -> Outcome:
    """Prove that G(y) = y^2 cosh(y/2)^4 is a convex function of s = y^2: dG/ds = cosh^4 + y cosh^3 sinh rises.

    So over |eps| = E the sum of G(eps_i) is smallest at equal components (Jensen), and largest where all but one are 0.
    """
    y, n = sp.symbols("y n", positive=True)
    G = y**2 * sp.cosh(y / 2) ** 4
    slope = sp.cosh(y / 2) ** 4 + y * sp.cosh(y / 2) ** 3 * sp.sinh(y / 2)
    equal = n * G.subs(y, E / sp.sqrt(n)) - (E * sp.cosh(E / (2 * sp.sqrt(n))) ** 2) ** 2
    slope_rate = sp.cosh(y / 2) ** 2 * (
        3 * sp.cosh(y / 2) * sp.sinh(y / 2) + y * (3 * sp.sinh(y / 2) ** 2 + sp.cosh(y / 2) ** 2) / 2
    )
    return all_of(
        prove_identities({"dG/ds - (cosh^4 + y cosh^3 sinh)": _in_exponentials(sp.diff(G, y) / (2 * y) - slope)}),
        prove_identities({"n G(E/sqrt n) - q_n(E)^2": sp.simplify(equal)}),
        prove_identities(
            {"its slope - cosh^2 (3 cosh sinh + y (3 sinh^2 + cosh^2)/2)": _in_exponentials(sp.diff(slope, y) - slope_rate)}
        ),
        prove_positive({"cosh^2 (3 cosh sinh + y (3 sinh^2 + cosh^2)/2)": slope_rate}),
    )


def _prove_general() -> Outcome:
    """Prove that Vdot <= -k g |v|^2 + |v| (P + G R tau) is below 0 where the statement holds with a margin s."""
    v, staleness, margin = sp.symbols("v Delta s", positive=True)  # |v|, G R tau, slack
    rate_bound = -k * g * v**2 + v * (P + staleness)
    return prove_identities(
        {
            "Vdot's bound at k g |v| = P + G R tau + s, plus s |v|": sp.expand(
                rate_bound.subs(P, k * g * v - staleness - margin) + margin * v
            )
        }
    )


def _prove_diagonal() -> Outcome:
    """Prove that r <= P + g u(t_s), with u(t_s) <= -(k v - R tau), is below 0 where the statement holds with a margin s."""
    staleness, margin = sp.symbols("Delta s", positive=True)  # R tau, slack
    v = sp.Symbol("v", positive=True)
    inward = P - g * (k * v - staleness)
    return prove_identities(
        {"r's bound at k v = P/g + R tau + s, plus g s": sp.expand(inward.subs(v, (P / g + staleness + margin) / k) + g * margin)}
    )


def _prove_pull() -> Outcome:
    """Prove that h rises with a and falls with b, by its partial derivatives."""
    y = a / b
    return all_of(
        prove_identities(
            {
                "a^2 dh/da - (1 + a/b - ln(a/b))": sp.simplify(a**2 * sp.diff(INPUT_OVER_GAIN, a) - (1 + y - sp.log(y))),
                "b^2 dh/db + (1 + b/a + ln(a/b))": sp.simplify(b**2 * sp.diff(INPUT_OVER_GAIN, b) + (1 + 1 / y + sp.log(y))),
            }
        ),
        prove_slope_bound(),
    )


def _prove_displacement() -> Outcome:
    """Prove that a rises and b falls no faster than P while g u <= 0, and no faster than P + G U for any u."""
    f, w, u, lower_rate, upper_rate, F, S, coupling = sp.symbols("f w u gammadot_L gammadot_U F S M", real=True)
    return prove_identities(
        {
            "P - adot - [(F - f - w) + (S + gammadot_L) - g u]": (F + S)
            - (f + w + g * u - lower_rate)
            - ((F - f - w) + (S + lower_rate) - g * u),
            "P + G U - adot - [(F - f - w) + (S + gammadot_L) + (G U - g u)]": (F + S + coupling)
            - (f + w + g * u - lower_rate)
            - ((F - f - w) + (S + lower_rate) + (coupling - g * u)),
            "P + bdot - [(F - f - w) + (S + gammadot_U) - g u]": (F + S)
            + (upper_rate - f - w - g * u)
            - ((F - f - w) + (S + upper_rate) - g * u),
        },
        "SymPy: differences of sums whose terms in brackets are not negative",
    )


def _prove_same_side() -> Outcome:
    """Prove how far x is from the middle at |eps| = E, and that it moves relative to the middle no faster than P + G U."""
    f, w, u, lower_rate, upper_rate = sp.symbols("f w u gammadot_L gammadot_U", real=True)
    far, near = d / (1 + sp.exp(-E)), d / (1 + sp.exp(E))
    relative_rate = f + w + g * u - (lower_rate + upper_rate) / 2
    return prove_identities(
        {
            "(a - b)/2 - (gamma_d/2) tanh(E/2)": _in_exponentials((far - near) / 2 - d / 2 * sp.tanh(E / 2)),
            "d(x - middle)/dt less [f + w] + [g u] - [mean of edge rates]": relative_rate
            - (f + w)
            - g * u
            + (lower_rate + upper_rate) / 2,
        }
    )


def _prove_ends() -> Outcome:
    """Prove that h as a function of the width first rises, then falls, so that it is smallest at an end of an interval.

    h gamma_d = phi(e), where phi(e) = 8 atanh(e)/(1 - e^2), e = e0 - 2 c y and y = 1/gamma_d. The slope of y phi(e0 - 2 c y) in
    y is phi' s with s = phi/phi' + e - e0. Since 1/phi is convex, s rises with e and falls with y.
    """
    e, y = sp.Symbol("e", positive=True), sp.Symbol("y", positive=True)
    e0, c = sp.symbols("e0 c", positive=True)
    f = sp.Function("phi")
    value = y * f(e0 - 2 * c * y)
    e_of_y = e0 - 2 * c * y
    slope = sp.diff(value, y).doit()
    claimed = f(e_of_y) + (e_of_y - e0) * sp.diff(f(e), e).subs(e, e_of_y)
    s = f(e) / sp.diff(f(e), e) + e - e0
    convex = sp.diff(1 / f(e), e, 2)
    reduced = sp.Symbol("left", positive=True)  # eps - zeta
    e_slope = 2 * sp.cosh(E / 2) ** 2
    inverse = 1 / (reduced * sp.cosh(E / 2) ** 2)  # 4/phi in eps = 2 atanh e; left moves as eps does

    def slope_of(expression: Any) -> Any:
        return e_slope * (sp.diff(expression, E) + sp.diff(expression, reduced))

    second = slope_of(slope_of(inverse))
    expected = e_slope * 2 / reduced**3 * (2 + reduced * sp.tanh(E / 2) - reduced**2 / (2 * sp.cosh(E / 2) ** 2))
    return all_of(
        prove_identities({"d(y phi)/dy - (phi + (e - e0) phi')": sp.simplify((slope - claimed).doit())}),
        prove_identities(
            {"ds/de - (phi^3/phi'^2) (1/phi)''": sp.simplify(sp.diff(s, e) - f(e) ** 3 / sp.diff(f(e), e) ** 2 * convex)}
        ),
        prove_identities(
            {
                "(4/phi)'' in eps - 2 cosh^2 (2/l^3) (2 + l tanh - l^2 sech^2/2), l = eps - zeta <= eps": _in_exponentials(
                    second - expected
                )
            }
        ),
        _prove_cosh_above_identity(),
    )


def _prove_cosh_above_identity() -> Outcome:
    """Prove cosh v > v: cosh is convex, so above its tangent where sinh is 1. Hence 1 - (v/cosh v)^2 > 0 with v = eps/2."""
    v = sp.Symbol("v", real=True)
    tangent_point = sp.asinh(1)
    return all_of(
        prove_identities({"slope there, less 1": sp.diff(sp.cosh(v), v).subs(v, tangent_point) - 1}),
        prove_positive(
            {"cosh''": sp.diff(sp.cosh(v), v, 2), "the tangent less v": sp.cosh(tangent_point) - sp.log(1 + sp.sqrt(2))}
        ),
        prove_identities({"exp(asinh 1) - (1 + sqrt 2)": sp.simplify(sp.exp(tangent_point.rewrite(sp.log)) - (1 + sp.sqrt(2)))}),
    )


def _prove_sharp() -> Outcome:
    """Prove that r <= P + g u(t_s), with u(t_s) = -k h(a_s, b_s) <= -k h(a - c, b + c), is below 0 by the statement's margin."""
    margin, h = sp.symbols("s h", positive=True)
    return prove_identities(
        {"P - g k h at k g h = P + s, plus s": sp.expand((P - g * k * h).subs(h, (P + margin) / (k * g)) + margin)}
    )


def _prove_coupled() -> Outcome:
    """Prove that component i of g u is g_ii u_i plus terms of the other inputs, at most sum |g_ij| U_j, which are added to P."""
    differences = {}
    for n in (2, 3):
        row = sp.symbols(f"g1:{n + 1}", real=True)
        u = sp.symbols(f"u1:{n + 1}", real=True)
        differences[f"n = {n}: (g u)_1 - g_11 u_1 - sum over j > 1 of g_1j u_j"] = sp.expand(
            sum(x * y for x, y in zip(row, u, strict=True))
            - row[0] * u[0]
            - sum(x * y for x, y in zip(row[1:], u[1:], strict=True))
        )
    return prove_identities(differences)


def _prove_shift() -> Outcome:
    """Prove that h(al d + eta, be d - eta) falls with d, so that its bound is that at d-, by Euler's identity for h of degree -1.

    The law sees a and b with an error of eta; al and be are the shares 1/(1 + exp(-E)) and 1/(1 + exp(E)) of the width.
    """
    alpha, beta, eta = sp.symbols("alpha beta eta", positive=True)
    h_a, h_b = sp.diff(INPUT_OVER_GAIN, a), sp.diff(INPUT_OVER_GAIN, b)
    measured_distances = {a: alpha * d + eta, b: beta * d - eta}
    rate_in_d = sp.diff(INPUT_OVER_GAIN.subs(measured_distances), d) * d + (INPUT_OVER_GAIN + eta * h_a - eta * h_b).subs(
        measured_distances
    )
    return prove_identities(
        {
            "a dh/da + b dh/db + h": sp.simplify(a * h_a + b * h_b + INPUT_OVER_GAIN),
            "d (dh/dd) + h + eta h_a - eta h_b, whose last three terms are positive": sp.simplify(rate_in_d),
        }
    )


def _prove_saturated() -> Outcome:
    """Prove that P - g u_max is below 0 where g u_max is above P, so that a saturated u points inward as well."""
    u_max, margin = sp.symbols("u_max s", positive=True)
    return prove_identities(
        {"P - g u_max at g u_max = P + s, plus s": sp.expand((P - g * u_max).subs(u_max, (P + margin) / g) + margin)}
    )


def _refute_centre_rule() -> Outcome:
    """Simulate the held law in gamma = (-1, 1) at half of that period, k = g = 1: from e = 0.64 it overshoots more each time."""
    x, period = arb("0.64"), arb(1) / 4
    step_count = 0
    while abs(x) < 1 and step_count < 100:
        x = x - period * (1 / (1 + x) + 1 / (1 - x)) * ((1 + x) / (1 - x)).log()
        step_count += 1
    is_outside = abs(x) > 1
    evidence = f"after {step_count} periods x = {x.str(4)}, outside (-1, 1)"
    return refute_by_counterexample(
        "a period below gamma_d^2/(8 k g) keeps the tube", "gamma_d = 2, k = g = 1, e = 0.64", is_outside, evidence
    )


FIRST_EXIT_STEPS = ("sampled.first_exit", "theorem.edot")  # so r is not negative at the upper edge
# A held u differs from the present one by at most: v moves at its rate for the sample's age, and both bounds rise with |eps|.
HELD_INPUT_STEPS = ("sampled.age", "sampled.before", "sampled.law", "sampled.rate", "sampled.rises", "sampled.integral")

LEMMAS = (
    Lemma(
        "sampled.law",
        "|u| = k v with v = 4 q(eps)/gamma_d = h(a, b), where a/b = exp(eps).",
        r"\xi\varepsilon = \frac{4q(\varepsilon)}{\gamma_d} = h(a,b),"
        r"\quad q(E) = E\cosh^2\tfrac E2,\ h(a,b) = \bigl(\tfrac1a+\tfrac1b\bigr)\ln\tfrac ab",
        ("inside the tube",),
        "section IV",
        _prove_law,
    ),
    Lemma(
        "sampled.rate",
        "v moves by 16 q' cosh^2 r/gamma_d^2 - 4 q gammadot_d/gamma_d^2, so |v - v(t_s)| <= R tau/k on the sublevel set.",
        r"\dot v = \frac{16\,q'\cosh^2(\varepsilon/2)}{\gamma_d^2}\,r - \frac{4q\,\dot\gamma_d}{\gamma_d^2}",
        ("r = xdot - (gammadot_s + gammadot_d e)/2, |r| <= F + G U + S",),
        "ours",
        _prove_rate,
    ),
    Lemma(
        "sampled.rises",
        "q and q' cosh^2 rise, so on |eps| <= E they are at most their values at E.",
        r"q' = \cosh^2\tfrac E2\,(1 + E\tanh\tfrac E2)",
        ("E > 0",),
        "ours",
        _prove_rises,
    ),
    Lemma(
        "sampled.norm",
        "Over |eps| = E the norm of (q(eps_i)) is between q_n(E) and q(E).",
        r"q_n(E) = E\cosh^2\tfrac{E}{2\sqrt n} \le \|q(\varepsilon)\| \le q(E)",
        ("convexity in eps_i^2, Jensen's inequality",),
        "ours",
        _prove_norm,
    ),
    Lemma(
        "sampled.general",
        "For any g with g_s >= g_min: if F + S + G R tau < k g_min (4/d+) q_n(E), |eps| < E stays.",
        r"F+S+G R\tau < k g_{\min}\tfrac{4}{d_+}q_n(E) \Rightarrow \dot V < 0 \text{ at } \|\varepsilon\| = E",
        (
            "|eps(0)| < E",
            "samples no older than tau, the first at 0",
        ),
        "ours",
        _prove_general,
        (*FIRST_EXIT_STEPS, "theorem.vdot", "theorem.norms", "theorem.skew", "sampled.norm", *HELD_INPUT_STEPS),
    ),
    Lemma(
        "sampled.diagonal",
        "For diagonal g, by component: if P/g_min + R tau < 4 k q(E)/d+, |eps_i| < E stays.",
        r"\frac{P}{g_{\min}} + R\tau < \frac{4kq(E)}{d_+} \Rightarrow r < 0 \text{ at } \varepsilon_i = E",
        ("|eps_i(0)| < E", "samples no older than tau, the first at 0"),
        "ours",
        _prove_diagonal,
        (*FIRST_EXIT_STEPS, "transform.odd", *HELD_INPUT_STEPS),
    ),
    Lemma(
        "sampled.pull",
        "h rises with a and falls with b (a > b).",
        r"a^2\partial_a h = 1+\tfrac ab-\ln\tfrac ab \ge 2,\quad b^2\partial_b h = -(1+\tfrac ba+\ln\tfrac ab) < 0",
        ("a > b > 0",),
        "ours",
        _prove_pull,
    ),
    Lemma(
        "sampled.displacement",
        "Since a sample taken above the middle a has risen, and b fallen, by at most c = P tau + G U l: P tau, and G U l while "
        "the u before still acted, for the latency l. So a_s >= a - c, b_s <= b + c.",
        r"\dot a \le P,\ \dot b \ge -P \text{ while } g u \le 0;\quad \dot a \le P + GU,\ \dot b \ge -P - GU \text{ always}",
        ("|f + w| <= F, |edge rates| <= S, P = F + S", "|g u| <= G U"),
        "ours",
        _prove_displacement,
    ),
    Lemma(
        "sampled.same_side",
        "If (P + G U) tau < (d-/2) tanh(E/2), the sample was taken above the middle, so its u is not positive.",
        r"\tfrac{a-b}{2} = \tfrac{\gamma_d}{2}\tanh\tfrac E2",
        ("|u| <= U",),
        "ours",
        _prove_same_side,
    ),
    Lemma(
        "sampled.ends",
        "For a = d/(1 + e^-E) - c, b = d/(1 + e^E) + c the least h over d- <= d <= d+ is at d- or d+; also with eps - zeta in "
        "the place of eps = ln(a/b), which is what rounding may leave of it.",
        r"\min_{d_-\le d\le d_+} h = \min\bigl(h|_{d_-}, h|_{d_+}\bigr)",
        ("a > b at both ends", "c >= 0", "0 <= zeta < eps"),
        "ours",
        _prove_ends,
    ),
    Lemma(
        "sampled.sharp",
        "For diagonal g, by component: same side, and k g_min h(a - c, b + c) > P at d- and d+; then |eps_i| < E stays.",
        r"k\,g_{\min}\,h\bigl(\tfrac{d}{1+e^{-E}}-c,\ \tfrac{d}{1+e^{E}}+c\bigr) > P,\ c = P\tau+GUl"
        r" \Rightarrow r < 0 \text{ at } \varepsilon_i = E",
        (
            "|eps_i(0)| < E",
            "samples no older than tau, the first at 0",
        ),
        "ours",
        _prove_sharp,
        (
            *FIRST_EXIT_STEPS,
            "transform.odd",
            "sampled.age",
            "sampled.before",
            "sampled.law",
            "sampled.integral",
            "sampled.same_side",
            "sampled.displacement",
            "sampled.pull",
            "sampled.ends",
        ),
    ),
    Lemma(
        "sampled.coupled",
        "Where g couples, the same holds with P + sum over j != i of |g_ij| U_j in place of P, and g_ii in place of g.",
        r"(gu)_i = g_{ii}u_i + \sum_{j\ne i} g_{ij}u_j",
        ("g_ii > 0", "|u_j| <= U_j"),
        "ours",
        _prove_coupled,
        ("sampled.sharp",),
    ),
    Lemma(
        "sampled.shift",
        "What the law sees of a and b may be wrong by eta (noise; twice P7's bound, which the clamp needs): eta joins c, and "
        "U is k h(a + eta, b - eta) at d-.",
        r"h(\alpha d+\eta,\ \beta d-\eta) \text{ falls with } d",
        ("eta below the nearer distance at |eps| = E", "E <= eps(e_max): what is clamped pulls no less than what is used"),
        "ours",
        _prove_shift,
        ("sampled.pull",),
    ),
    Lemma(
        "sampled.saturated",
        "With u saturated at u_max the sharp statement holds if also g_min u_max > P.",
        r"\min(u_{\max}, k h) > P/g_{\min}",
        ("as sampled.sharp",),
        "ours",
        _prove_saturated,
        ("sampled.sharp",),
    ),
    Lemma(
        "sampled.centre_rule",
        "A period below gamma_d^2/(8 k g), the stability limit at the middle of a resting tube, keeps the state inside.",
        r"\tau < \frac{\gamma_d^2}{8kg}",
        ("gamma constant, f = w = 0",),
        "a rule of thumb",
        _refute_centre_rule,
    ),
)
