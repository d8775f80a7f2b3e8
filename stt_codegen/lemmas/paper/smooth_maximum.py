"""Lemmas about smooth maximum and minimum (section II), and how circumvent functions are joined in place of the max of (9).

book.py takes LEMMAS as the family `smooth`.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_above, prove_identities, refute_by_counterexample
from stt_codegen.paper import circumvent, smooth
from stt_codegen.program.convert import lower
from stt_codegen.program.symbolic import branches

a, b = sp.symbols("a b", real=True)
nu = sp.Symbol("nu", positive=True)


def _printed_form(sign: int) -> Any:
    return sign * sp.log(sp.exp(sign * nu * a) + sp.exp(sign * nu * b)) / nu


def _prove_built_form(sign: int) -> Outcome:
    """Prove for a > b, a < b and a = b that the form which is built equals the printed one, so that |a - b| has one sign in
    each."""
    import casadi as ca

    names = [ca.SX.sym(n) for n in ("a", "b", "nu")]
    form = smooth.smooth_max if sign > 0 else smooth.smooth_min
    kernel = lower(ca.Function("form", names, [form(*names)], ["a", "b", "nu"], ["value"]))
    d = sp.Symbol("d", positive=True)
    differences = {}
    for label, x, y in (("a > b", b + d, b), ("a < b", a, a + d), ("a = b", a, a)):
        (branch,) = branches(kernel, {"a": x, "b": y, "nu": nu})
        printed = _printed_form(sign).subs({a: x, b: y}, simultaneous=True)
        # exp is one to one, and exp(nu .) of both forms is rational in exponentials, which SymPy compares.
        differences[label] = sp.simplify(
            sp.expand(sp.exp(sp.expand(nu * sign * branch.outputs[0])) - sp.exp(sp.expand(nu * sign * printed)))
        )
    return prove_identities(differences, "SymPy: exp(nu .) of both forms is the same, by the sign of a - b")


def _prove_bounds(sign: int) -> Outcome:
    """Prove that the excess over the maximum, ln(1 + y)/nu with y = exp(-nu |a - b|), rises from 0 at y = 0 to ln(2)/nu at y =
    1."""
    return all_of(
        prove_above("d ln(1 + y)/dy", lambda y: 1 / (1 + y), [(0.0, 1.0)]),
        prove_identities({"ln(1 + 0)": sp.log(1 + sp.Integer(0)), "ln(1 + 1) - ln 2": sp.log(1 + sp.Integer(1)) - sp.log(2)}),
        prove_identities(
            {
                "the printed form at a = b is a + ln(2)/nu": sp.simplify(
                    _printed_form(sign).subs(b, a) - (a + sign * sp.log(2) / nu)
                )
            }
        ),
    )


def _prove_gradient() -> Outcome:
    gradient = [sp.diff(_printed_form(1), v) for v in (a, b)]
    weight = 1 / (1 + sp.exp(nu * (b - a)))
    return prove_identities(
        {"sum of the weights - 1": sum(gradient) - 1, "weight of a - 1/(1 + exp(nu (b - a)))": gradient[0] - weight},
        "SymPy: weights are logistic, so above 0, and sum to 1",
    )


def _prove_four_gaps() -> Outcome:
    # p = rho_U + alpha_U, q = beta_U, r = rho_L - alpha_L, s = beta_L
    p, q, r, s = sp.symbols("p q r s", real=True)
    upper = sp.exp(-nu * p) + sp.exp(-nu * q)
    lower_edge = sp.exp(nu * r) + sp.exp(nu * s)
    gaps = sum(sp.exp(-nu * (x - y)) for x in (p, q) for y in (r, s))
    return prove_identities(
        {"exp(-nu gamma_U) exp(nu gamma_L) - sum of exp(-nu gap)": sp.expand(upper * lower_edge) - sp.expand(gaps)},
        "SymPy: exp(-nu (gamma_U - gamma_L)) of both sides",
    )


def _prove_join() -> Outcome:
    """Prove the properties of joined bumps in exp(nu b), where joining is u + v - 1."""
    x, y, z = sp.symbols("x y z", positive=True)  # exp(nu b_j), at least 1

    def join(u: Any, v: Any) -> Any:
        return u + v - 1

    return prove_identities(
        {
            "where one is at rest (exp(0) = 1) the other stays": join(x, 1) - x,
            "associative": join(join(x, y), z) - join(x, join(y, z)),
            "of m bumps: 1 + sum(exp(nu b_j) - 1)": join(join(x, y), z) - (1 + (x - 1) + (y - 1) + (z - 1)),
        },
        "SymPy: in exp(nu b)",
    )


def _prove_join_shipped() -> Outcome:
    """Prove for either order of two bumps that the emitted kernel is the formula, by exp(nu .) of both."""
    kernel = lower(circumvent.join())
    d = sp.Symbol("d", positive=True)
    lower_bump = sp.Symbol("b", nonnegative=True)
    differences = {}
    for label, x, y in (
        ("a > b", lower_bump + d, lower_bump),
        ("a < b", lower_bump, lower_bump + d),
        ("a = b", lower_bump, lower_bump),
    ):
        inputs = dict(zip((v.name for v in kernel.inputs), (x, y, nu), strict=True))
        (branch,) = branches(kernel, inputs)
        expected = sp.exp(nu * x) + sp.exp(nu * y) - 1
        differences[label] = sp.simplify(sp.expand(sp.exp(sp.expand(nu * branch.outputs[0])) - expected))
    return prove_identities(differences, "SymPy: exp(nu .) of the emitted kernel, by the sign of a - b")


def _refute_plain_max() -> Outcome:
    """Compute the slopes of max(1 - t, t) on both sides of t = 1/2, where the bumps meet."""
    t = sp.Symbol("t", real=True)
    slope = sp.diff(sp.Max(1 - t, t), t)
    left, right = (sp.limit(slope, t, sp.Rational(1, 2), side) for side in "-+")
    return refute_by_counterexample("max(1 - t, t) has one slope", "t = 1/2", left != right, f"slopes {left} and {right}")


def _refute_printed_float() -> Outcome:
    value = arb(100 * 1.0).exp()
    largest = (2 - 2.0**-23) * 2.0**127
    return refute_by_counterexample("exp(nu a) is a float", "nu = 100, a = 1", value > largest, f"exp(100) = {value.str(5)}")


LEMMAS = (
    Lemma(
        "smooth.form",
        "The built smooth maximum (mean plus half the distance plus log1p) is the printed one, and the minimum too.",
        r"\tfrac{a+b}{2} + \tfrac{|a-b|}{2} + \tfrac1\nu\ln(1+e^{-\nu|a-b|}) = \tfrac1\nu\ln(e^{\nu a}+e^{\nu b})",
        ("nu > 0",),
        "section II",
        lambda: all_of(_prove_built_form(1), _prove_built_form(-1)),
    ),
    Lemma(
        "smooth.bounds",
        "max(a, b) < smooth max <= max(a, b) + ln(2)/nu, with equality at a = b; mirrored for the minimum.",
        r"\max(a,b) < \widetilde{\max}(a,b) \le \max(a,b) + \tfrac{\ln 2}{\nu}",
        ("nu > 0",),
        "section II",
        lambda: all_of(_prove_bounds(1), _prove_bounds(-1)),
    ),
    Lemma(
        "smooth.gradient",
        "The gradient of the smooth maximum is a convex combination, so its rate is between those of a and b.",
        r"\nabla\widetilde{\max} = (w, 1-w),\quad w = \frac1{1+e^{\nu(b-a)}}",
        ("nu > 0",),
        "ours",
        _prove_gradient,
    ),
    Lemma(
        "smooth.four_gaps",
        "gamma_U - gamma_L is the smooth minimum of the four gaps between what makes them.",
        r"e^{-\nu(\gamma_U-\gamma_L)} = \sum_{j=1}^4 e^{-\nu d_j}",
        ("nu > 0",),
        "(10), ours",
        _prove_four_gaps,
    ),
    Lemma(
        "smooth.width",
        "Four gaps above ln(4)/nu make a tube of positive width: exp(-nu width) is their sum, below 4 exp(-ln 4) = 1.",
        r"d_j > \tfrac{\ln 4}{\nu}\ \Rightarrow\ \gamma_U > \gamma_L",
        ("nu > 0",),
        "ours",
        lambda: all_of(_prove_four_gaps(), prove_identities({"4 exp(-ln 4) - 1": 4 * sp.exp(-sp.log(4)) - 1})),
    ),
    Lemma(
        "smooth.join",
        "Joining bumps by ln(1 + sum(exp(nu b) - 1))/nu leaves a bump alone where the others rest, and is associative.",
        r"\tfrac1\nu\ln\Bigl(1+\sum_j(e^{\nu b_j}-1)\Bigr)",
        ("b >= 0", "nu > 0"),
        "in place of (9), ours",
        _prove_join,
    ),
    Lemma(
        "smooth.join_shipped",
        "The emitted kernel `join` is that formula for two bumps, whichever is higher.",
        r"\texttt{join}(a,b) = \tfrac1\nu\ln(e^{\nu a}+e^{\nu b}-1)",
        ("a, b >= 0", "nu > 0"),
        "Program",
        _prove_join_shipped,
    ),
    Lemma(
        "smooth.plain_max",
        "The plain max of (9) is continuously differentiable.",
        r"\max_j b_j \in C^1",
        (),
        "(9) as printed",
        _refute_plain_max,
    ),
    Lemma(
        "smooth.printed_float",
        "The printed form can be evaluated in single precision for nu = 100 on a state space of 1 m.",
        r"e^{\nu a} \le (2-2^{-23})2^{127}",
        ("nu = 100, the case study's",),
        "section II as printed",
        _refute_printed_float,
    ),
)
