"""A bound that two families need for the slopes of h(a, b) = (1/a + 1/b) ln(a/b), which is |u|/k of the law."""

from __future__ import annotations

import sympy as sp

from stt_codegen.lemmas.lemma import Outcome, all_of, prove_identities, prove_positive

t = sp.Symbol("t", positive=True)


def prove_slope_bound() -> Outcome:
    """Prove that f = 1 + y - ln y is at least 2 for every y > 0.

    f is 2 at y = 1; f' is positive beyond, at y = 1 + t, and negative before, at y = 1/(1 + t).
    """
    y = sp.Symbol("y", positive=True)
    f = 1 + y - sp.log(y)
    slope = sp.diff(f, y)
    return all_of(
        prove_identities({"f(1) - 2": f.subs(y, 1) - 2}),
        prove_positive(
            {"f'(1 + t)": sp.together(slope.subs(y, 1 + t)), "-f'(1/(1 + t))": sp.simplify(-slope.subs(y, 1 / (1 + t)))}
        ),
    )
