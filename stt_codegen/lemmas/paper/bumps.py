"""Lemmas about the circumvent function (7), (8): smoothness at its edges, its range, and how wide it must be.

book.py takes LEMMAS as the family `bumps`.
"""

from __future__ import annotations

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive, refute_by_counterexample

t, m = sp.symbols("t m", real=True)
height, k, r = sp.symbols("B k r", positive=True)
v = sp.Symbol("v", positive=True)  # 1/(r^2 - (t - m)^2), which grows without bound towards an edge
BUMP = height * sp.exp(-k * (t - m) ** 2 / (r**2 - (t - m) ** 2))


def _prove_edges() -> Outcome:
    """Prove limits at the edges: every derivative is exp(-k (t-m)^2 v) times a polynomial in t and v; the exponent is k - k r^2
    v."""
    powers = {f"limit of v^{j} exp(-k r^2 v)": sp.limit(v**j * sp.exp(-v), v, sp.oo) for j in range(8)}
    x = sp.Symbol("x", real=True)
    inner = -k * x**2 / (r**2 - x**2)
    return all_of(
        prove_identities(powers, "SymPy: limits, with k r^2 v for v"),
        prove_identities({"exponent - (k - k r^2/(r^2 - x^2))": inner - (k - k * r**2 / (r**2 - x**2))}),
        prove_identities(
            {
                "d exponent/dx + 2 k r^2 x v^2: each derivative adds a polynomial in x and v": sp.diff(inner, x)
                + 2 * k * r**2 * x / (r**2 - x**2) ** 2
            }
        ),
    )


def _prove_between() -> Outcome:
    """Prove that the exponent is negative off the middle and falls with (t - m)^2; BUMP itself is evaluated at the middle."""
    x, w = sp.Symbol("x", real=True), sp.Symbol("w", positive=True)
    complement = 2 * sp.exp(-w / 2) * sp.sinh(w / 2)
    return all_of(
        prove_identities({"at the middle, less B": BUMP.subs(t, m) - height}),
        prove_identities({"1 - exp(-w) - 2 exp(-w/2) sinh(w/2)": sp.simplify((1 - sp.exp(-w) - complement).rewrite(sp.exp))}),
        prove_positive({"exp(-w), the exponent being -w": sp.exp(-w), "2 exp(-w/2) sinh(w/2)": complement}),
        prove_identities(
            {"slope in x^2 of the exponent + k r^2/(r^2 - x^2)^2": sp.diff(-k * x / (r**2 - x), x) + k * r**2 / (r**2 - x) ** 2}
        ),
    )


def _prove_widening() -> Outcome:
    """Prove that the bump of the widened radius is B - (dB - delta) at |t - m| = q."""
    q, reach, delta = sp.symbols("q D delta", positive=True)
    c = -sp.log(1 - (reach - delta) / height)
    value_at_q = height * sp.exp(-k * q**2 / (q**2 * (1 + k / c) - q**2))
    return prove_identities(
        {
            "bump at |t - m| = q with r^2 = q^2 (1 + k/c), less B - (dB - delta)": sp.simplify(
                value_at_q - (height - (reach - delta))
            )
        }
    )


def _refute_printed_window() -> Outcome:
    """Evaluate the printed bump at 99 % of the half width: it is below B - dB there, although the set is still in the way."""
    x = arb("0.99")
    value = arb("3.7") * (-arb("0.01") * x**2 / (1 - x**2)).exp()
    point = "k = 0.01, B = 3.7, dB = 0.2, |t - m| = 0.99 r, r the conflict's half width"
    return refute_by_counterexample("the bump is at least B - dB = 3.5", point, value < arb("3.5"), f"it is {value.str(5)}")


LEMMAS = (
    Lemma(
        "bumps.edges",
        "All derivatives tend to 0 at m - r and m + r, so the function is smooth with 0 outside.",
        r"\lim_{|t-m|\to r} b^{(j)}(t) = 0",
        ("by induction: the j-th derivative is the exponential times a polynomial in x and v",),
        "(7), (8)",
        _prove_edges,
    ),
    Lemma(
        "bumps.between",
        "0 < bump <= B inside, B just in the middle, falling to both sides.",
        r"0 < b \le B",
        ("|t - m| < r",),
        "(7), (8)",
        _prove_between,
    ),
    Lemma(
        "bumps.widening",
        "With r^2 = q^2 (1 + k/c), c = -ln(1 - (dB - delta)/B), the bump keeps delta of clearance over the half width q.",
        r"b(m\pm q) = B - (\delta B - \delta)",
        ("0 <= delta < dB < B",),
        "ours",
        _prove_widening,
    ),
    Lemma(
        "bumps.printed_window",
        "A bump over exactly the conflict window is above the unsafe set during the conflict.",
        r"b(t) \ge B - \delta B",
        ("r is the conflict's half width",),
        "(7) as printed",
        _refute_printed_window,
    ),
)
