"""Lemmas about the reachability tube (4): limits and speed of its profile sigma, and the kernel that is emitted for its edges.

book.py takes LEMMAS as the family `reach`.
"""

from __future__ import annotations

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import (
    Lemma,
    Outcome,
    Verdict,
    all_of,
    prove_above,
    prove_identities,
    prove_positive,
    refute_by_counterexample,
)
from stt_codegen.paper import reach_tube
from stt_codegen.program.convert import lower
from stt_codegen.program.symbolic import formulas

s, t, t_c = sp.symbols("s t t_c", positive=True)
FASTEST = 0.40607  # of t_c: the time at which sigma is steepest


def _prove_rate() -> Outcome:
    by_definition = sp.diff(sp.tanh(t / (t_c - t)), t)
    claimed = ((1 + s) ** 2 / sp.cosh(s) ** 2 / t_c).subs(s, t / (t_c - t))
    return prove_identities({"d sigma/dt - (1 + s)^2 sech(s)^2 / t_c": by_definition - claimed})


def _prove_limits() -> Outcome:
    differences = {
        "sigma at t_c, less 1": sp.limit(sp.tanh(s), s, sp.oo) - 1,
        "rate at t_c": sp.limit(((1 + s) ** 2 * 4 * sp.exp(-2 * s)), s, sp.oo),
        "second derivative at t_c": sp.limit((1 + s) ** 4 * 4 * sp.exp(-2 * s), s, sp.oo),
    }
    return prove_identities(
        differences, "SymPy: limits; sech(s)^2 < 4 exp(-2 s), and each derivative in t brings at most (1 + s)^2"
    )


def _prove_monotone() -> Outcome:
    """Prove that sigmadot t_c = ((1 + s) sech s)^2 is positive for every s >= 0."""
    return prove_positive({"sech(s) (1 + s)": (1 + s) / sp.cosh(s)})


def _prove_steepest() -> Outcome:
    """Enclose the maximum of f = (1 + s) sech s, whose square is sigmadot t_c, and prove that there is only one.

    f' = sech s (1 - (1 + s) tanh s) has one root, since (1 + s) tanh s rises.
    """
    steepest, slope = FASTEST / (1 - FASTEST), sp.tanh(s) + (1 + s) / sp.cosh(s) ** 2

    def bound_less_rate(v: arb) -> arb:
        return arb(1.83489) - ((1 + v) / v.cosh()) ** 2

    return all_of(
        prove_above("1.83489 - sigmadot t_c", bound_less_rate, [(0.0, 6.0)]),
        prove_identities(
            {"d/ds ln((1 + s)^2 exp(-2 s)) + 2 s/(1 + s), so it falls": sp.diff(2 * sp.log(1 + s) - 2 * s, s) + 2 * s / (1 + s)}
        ),
        prove_above(
            "1.83489 - 4 (1 + s)^2 exp(-2 s), above sech's, from 6 on",
            lambda v: arb(1.83489) - 4 * (1 + v) ** 2 * (-2 * v).exp(),
            [(6.0, 7.0)],
        ),
        prove_above(
            "sigmadot t_c - 1.83487 near there",
            lambda v: ((1 + v) / v.cosh()) ** 2 - arb(1.83487),
            [(steepest - 1e-4, steepest + 1e-4)],
        ),
        prove_identities({"d/ds ((1 + s) tanh s) - tanh s - (1 + s) sech(s)^2": sp.diff((1 + s) * sp.tanh(s), s) - slope}),
        prove_positive({"tanh s + (1 + s) sech(s)^2": slope}),
    )


def _prove_hull() -> Outcome:
    start, end, value = sp.symbols("X0 T sigma", real=True)
    (rho,) = formulas(lower(reach_tube.reach_edge()), {"start": start, "end": end, "sigma": value})
    return prove_identities({"reach_edge - ((1 - sigma) X0 + sigma T)": rho - ((1 - value) * start + value * end)})


def _prove_guard() -> Outcome:
    """Prove that exp(-2046) is below every double: with s >= 1023 at the guard, 1 - tanh s is 2 d/(1 + d), d <= exp(-2046)."""
    d = (arb(-2046)).exp()
    smallest_double = 2.0**-1074
    if d < arb(smallest_double):
        return Outcome(Verdict.PROVED, "Arb", (f"exp(-2046) = {d.str(4)} < 2^-1074",))
    return Outcome(Verdict.OPEN, "Arb", (f"exp(-2046) = {d.str(4)}",))


def _refute_printed() -> Outcome:
    argument = t / (t_c - t)
    denominator = sp.denom(sp.together(argument)).subs(t, t_c)
    return refute_by_counterexample(
        "tanh's argument t/(t_c - t) is a number", "t = t_c", denominator == 0, f"its denominator is {denominator}"
    )


LEMMAS = (
    Lemma(
        "reach.rate",
        "The rate of sigma is (1 + s)^2 sech(s)^2 / t_c with s = t/(t_c - t).",
        r"\dot\sigma = \frac{(1+s)^2}{t_c\cosh^2 s}",
        ("0 <= t < t_c",),
        "(4)",
        _prove_rate,
    ),
    Lemma(
        "reach.limits",
        "sigma tends to 1 at t_c, and its first two derivatives to 0, so it goes on as 1 twice differentiably.",
        r"\sigma\to1,\ \dot\sigma\to0,\ \ddot\sigma\to0\quad(t\to t_c)",
        ("t < t_c",),
        "(4)",
        _prove_limits,
    ),
    Lemma("reach.monotone", "sigma rises.", r"\dot\sigma > 0", ("0 <= t < t_c",), "(4)", _prove_monotone),
    Lemma(
        "reach.steepest",
        "sigma moves at most 1.83489/t_c, and 1.83487/t_c at t = 0.40607 t_c, the one maximum.",
        r"\max\dot\sigma = 1.8348\ldots/t_c",
        ("0 <= t < t_c",),
        "(4), ours",
        _prove_steepest,
    ),
    Lemma(
        "reach.hull",
        "The emitted edge is between X0hat and That.",
        r"\rho = (1-\sigma)\hat X_0 + \sigma\hat T",
        ("0 <= sigma <= 1",),
        "Program",
        _prove_hull,
    ),
    Lemma(
        "reach.guard",
        "From there on sigma is 1 to the last bit of a double: what is left of it underflows.",
        r"e^{-2\cdot1023} < 2^{-1074}",
        ("t >= t_c (1 - 1/1024)",),
        "Program",
        _prove_guard,
    ),
    Lemma(
        "reach.printed",
        "tanh(t/(t_c - t)) can be evaluated at t = t_c.",
        r"t_c - t \ne 0",
        (),
        "(4) as printed",
        _refute_printed,
    ),
)
