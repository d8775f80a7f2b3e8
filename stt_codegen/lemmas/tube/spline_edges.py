"""Lemmas about the refined tube: its weights, its smoothness, the Bezier form that the certificate reads, and its hull.

book.py takes LEMMAS as the family `refined`.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.certify import slack
from stt_codegen.controller import edge_errors
from stt_codegen.designs import RefinedDesign
from stt_codegen.lemmas.lemma import (
    Lemma,
    Outcome,
    Verdict,
    all_of,
    outcome_of_cases,
    prove_above,
    prove_identities,
    prove_positive,
)
from stt_codegen.paper import refined_tube
from stt_codegen.program import FORMATS
from stt_codegen.program.convert import lower
from stt_codegen.program.symbolic import formulas

s = sp.Symbol("s", real=True)
q = sp.symbols("q0:4", real=True)
WEIGHTS: tuple[Any, ...] = (
    lambda v: (1 - v) ** 3,
    lambda v: 3 * v**3 - 6 * v**2 + 4,
    lambda v: -3 * v**3 + 3 * v**2 + 3 * v + 1,
    lambda v: v**3,
)


def _emitted_weights() -> tuple[sp.Expr, ...]:
    return formulas(lower(refined_tube.basis()), {"s": s})


def _prove_weights_shipped() -> Outcome:
    differences = {
        f"w{j} less 6 times the cubic B-spline": w - f(s)
        for j, (w, f) in enumerate(zip(_emitted_weights(), WEIGHTS, strict=True))
    }
    return prove_identities(differences | {"sum - 6": sum(_emitted_weights()) - 6})


def _prove_rates_shipped() -> Outcome:
    rates = formulas(lower(refined_tube.basis_rate()), {"s": s})
    return prove_identities(
        {f"dw{j} - d w{j}/ds": r - sp.diff(w, s) for j, (w, r) in enumerate(zip(_emitted_weights(), rates, strict=True))}
    )


def _prove_convex() -> Outcome:
    """Prove that the middle two weights are above 0.99 on [0, 1] and that the outer two are cubes of 1 - s and s."""
    return all_of(
        prove_above("w1", WEIGHTS[1], [(0.0, 1.0)], 0.99),
        prove_above("w2", WEIGHTS[2], [(0.0, 1.0)], 0.99),
        prove_identities({"w0 - (1 - s)^3": _emitted_weights()[0] - (1 - s) ** 3, "w3 - s^3": _emitted_weights()[3] - s**3}),
    )


def _prove_smooth() -> Outcome:
    differences: dict[str, sp.Expr] = {}
    for order in range(3):
        end = [sp.diff(w, s, order).subs(s, 1) for w in _emitted_weights()]
        start = [sp.diff(w, s, order).subs(s, 0) for w in _emitted_weights()]
        differences |= {f"derivative {order}: w{j + 1}(1) - w{j}(0)": end[j + 1] - start[j] for j in range(3)}
        differences |= {f"derivative {order}: w0(1)": end[0], f"derivative {order}: w3(0)": start[3]}
    return prove_identities(differences)


def _prove_bezier() -> Outcome:
    """Prove that the weighted sum of control points is the cubic with the Bezier coefficients that the certificate computes."""
    points = (q[0] + 4 * q[1] + q[2], 4 * q[1] + 2 * q[2], 2 * q[1] + 4 * q[2], q[1] + 4 * q[2] + q[3])
    bernstein = [sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) for j in range(4)]
    curve = sum(w * v for w, v in zip(_emitted_weights(), q, strict=True))
    return prove_identities({"curve - Bezier form": curve - sum(c * f for c, f in zip(points, bernstein, strict=True))})


def _prove_hull() -> Outcome:
    """Prove that the Bernstein polynomials sum to 1, are positive inside (0, 1) and not negative at its ends."""
    z = sp.Symbol("z", positive=True)
    inside = z / (1 + z)  # any number from 0 to 1
    bernstein = [sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) for j in range(4)]
    return all_of(
        prove_identities({"sum of the Bernstein polynomials - 1": sum(bernstein) - 1}),
        prove_identities(
            {
                f"s^{j} (1 - s)^{3 - j} at 0 and 1, but for the 1": (s**j * (1 - s) ** (3 - j)).subs(s, e)
                for j in (1, 2)
                for e in (0, 1)
            }
        ),
        *(
            prove_positive({f"s^{j} (1 - s)^{3 - j} at s = z/(1 + z)": sp.together((s**j * (1 - s) ** (3 - j)).subs(s, inside))})
            for j in range(4)
        ),
    )


def _prove_blend_shipped() -> Outcome:
    kernel = lower(refined_tube.blend())
    w = sp.symbols("w0:4", real=True)
    (edge,) = formulas(kernel, dict(zip((v.name for v in kernel.inputs), (*w, *q), strict=True)))
    return prove_identities({"blend - sum of w_j q_j": edge - sum(a * b for a, b in zip(w, q, strict=True))})


def _prove_bezier_shipped() -> Outcome:
    """Compare `RefinedDesign.bezier` with the weights on tables with a single 1; the map is linear, so these are enough."""
    bernstein = [sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) for j in range(4)]
    differences = {}
    for k in range(4):
        table = tuple((((1 if j == k else 0), 0),) for j in range(4))
        coefficients = RefinedDesign(Fraction(1), 1, 0, table).bezier()[0, 0, 0]
        differences[f"table entry {k}"] = _emitted_weights()[k] - sum(
            int(c) * f for c, f in zip(coefficients, bernstein, strict=True)
        )
    return prove_identities(differences, "SymPy: the certificate's own map, by linearity")


def _prove_halves() -> Outcome:
    """Run `slack.halves` on symbols and prove that each half, at s, is the curve at s/2 or (1 + s)/2."""
    piece = np.array(q, dtype=object)
    curves = [
        sum(sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) * c for j, c in enumerate(p)) for p in (piece, *slack.halves(piece))
    ]
    curve, early_half, late_half = curves
    return prove_identities(
        {
            "early half less the curve at s/2": early_half - curve.subs(s, s / 2),
            "late half less that at (1 + s)/2": late_half - curve.subs(s, (1 + s) / 2),
        },
        "SymPy: the certificate's own code run on symbols",
    )


def _prove_integers() -> Outcome:
    """Run `units_above` on bounds v = (m + r) units with integers m and n over a range and r on a grid of [0, 1).

    n >= v must be n >= m + 1 where r > 0, and n >= m where r = 0.
    """
    failures, comparison_count = [], 0
    for m, r, unit in product(range(-3, 4), [Fraction(k, 7) for k in range(7)], (Fraction(1), Fraction(1, 1 << 18), Fraction(4))):
        value = (m + r) * unit
        for n in range(-5, 6):
            comparison_count += 1
            if (n >= slack.units_above(value, unit)) != (n * unit >= value):
                failures.append((m, r, unit, n))
    verdict = Verdict.OPEN if failures else Verdict.PROVED
    method = "by cases: sign, whole part and rest of the bound; the certificate's own function, in exact numbers"
    result = f"{comparison_count} comparisons of integers agree with those of numbers, {len(failures)} do not"
    return Outcome(verdict, method, (result, *map(str, failures[:2])))


def _prove_late() -> Outcome:
    """Prove that `late` bounds the error of the emitted spline time u = (K/t_c) t (1 + a)(1 + b)(1 + c).

    The relative errors are a of the constant K/t_c, b of the product, c of a t that was rounded itself, each at most eps < 1;
    and t K/t_c <= K. At the end u is the last number below K, at most 2 eps K below it.
    """
    a, b, c = sp.symbols("a b c", real=True)
    k, z = sp.symbols("K z", positive=True)
    eps = z / (1 + z)  # any number from 0 to 1
    bound = edge_errors.rounded_time_error(k, eps)
    formats = [(scalar, FORMATS[scalar], segments) for scalar in ("float", "double") for segments in (1, 48, 8192)]
    failures = []
    for scalar, number_format, segments in formats:
        design: Any = SimpleNamespace(segments=segments)
        if (
            edge_errors.spline_time_error(design, scalar)
            != edge_errors.rounded_time_error(Fraction(segments), number_format.roundoff) + number_format.tiny
        ):
            failures.append(f"{scalar}, {segments} segments")
    return all_of(
        prove_identities(
            {
                "(1 + a)(1 + b) - 1 - (a + b + a b)": (1 + a) * (1 + b) - 1 - (a + b + a * b),
                "(1 + a)(1 + b)(1 + c) - 1 less its seven terms": (1 + a) * (1 + b) * (1 + c)
                - 1
                - (a + b + c + a * b + a * c + b * c + a * b * c),
                "given - 2 K (2 eps + eps^2) - 2 K eps^2": bound - 2 * k * (2 * eps + eps**2) - 2 * k * eps**2,
            }
        ),
        prove_positive(
            {
                "given - K (3 eps + 3 eps^2 + eps^3)": sp.factor(sp.together(bound - k * (3 * eps + 3 * eps**2 + eps**3))),
                "given - 2 eps K": sp.factor(sp.together(bound - 2 * eps * k)),
            }
        ),
        outcome_of_cases(len(formats), failures, "what P7 takes is this bound and the least subnormal"),
    )


LEMMAS = (
    Lemma(
        "refined.weights_shipped",
        "The emitted weights are 6 times the uniform cubic B-spline basis, and sum to 6.",
        r"\sum_j w_j = 6",
        ("0 <= s <= 1",),
        "Program",
        _prove_weights_shipped,
    ),
    Lemma(
        "refined.rates_shipped",
        "The emitted weight rates are the derivatives of the emitted weights.",
        r"w_j' = dw_j/ds",
        ("0 <= s <= 1",),
        "Program",
        _prove_rates_shipped,
    ),
    Lemma(
        "refined.blend_shipped",
        "The emitted edge is the weighted sum of four table entries.",
        r"\gamma = \sum_j w_j q_j",
        (),
        "Program",
        _prove_blend_shipped,
    ),
    Lemma(
        "refined.convex",
        "The weights are not negative, so an edge is a mean of its control points: widths of control points bound the width.",
        r"w_j \ge 0",
        ("0 <= s <= 1",),
        "ours",
        _prove_convex,
    ),
    Lemma(
        "refined.smooth",
        "Neighbouring segments agree in value, slope and curvature: the tube is C2.",
        r"\gamma \in C^2",
        (),
        "ours",
        _prove_smooth,
    ),
    Lemma(
        "refined.bezier",
        "Each segment is the Bezier cubic that the certificate computes from the table.",
        r"\sum_j w_j q_j = \sum_j \beta_j B_j^3",
        ("0 <= s <= 1",),
        "ours",
        _prove_bezier,
    ),
    Lemma(
        "refined.hull",
        "Bernstein polynomials are not negative and sum to 1, so a segment stays between its least and greatest coefficient.",
        r"\min\beta_j \le \gamma \le \max\beta_j",
        ("0 <= s <= 1",),
        "ours",
        _prove_hull,
    ),
    Lemma(
        "refined.bezier_shipped",
        "The map from the table that the certificate's code uses is that form.",
        r"\beta = (q_0+4q_1+q_2,\ 4q_1+2q_2,\ 2q_1+4q_2,\ q_1+4q_2+q_3)",
        (),
        "certificate",
        _prove_bezier_shipped,
    ),
    Lemma(
        "refined.halves",
        "Where a hull is too coarse the certificate's code halves the segment, and both halves are the curve itself.",
        r"\beta \mapsto (\beta^{\text{early}}, \beta^{\text{late}})",
        ("0 <= s <= 1",),
        "certificate, de Casteljau",
        _prove_halves,
    ),
    Lemma(
        "refined.late",
        "The emitted spline time is nearer to K t/t_c than the bound that P7 takes: by half where t is exact, and still where t "
        "was rounded once.",
        r"|u - Kt/t_c| \le K(3\epsilon + 3\epsilon^2 + \epsilon^3) < K(4\epsilon + 4\epsilon^2)",
        ("one rounding of at most eps, relative, for the constant, the product, and t", "K is exact in the scalar"),
        "the evaluated code",
        _prove_late,
    ),
    Lemma(
        "refined.integers",
        "Comparing integers with the bound's ceiling is comparing the numbers: the certificate rounds nothing. (Over a "
        "grid of whole parts and rests; n >= v is n >= ceil(v) for every whole n.)",
        r"n \ge \lceil v/\text{unit}\rceil \iff n\,\text{unit} \ge v",
        ("n whole",),
        "certificate",
        _prove_integers,
    ),
)
