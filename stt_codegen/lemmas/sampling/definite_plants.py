"""Lemmas about Assumption 2, that g_s is definite, for the built-in plants: as an exact condition or as a bound over a box.

Plants are read from the kernels with which `prove TASK` evaluates its bounds. book.py takes LEMMAS as the family `plant`.
"""

from __future__ import annotations

import math
from typing import Any

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, prove_identities, prove_positive, refute_by_counterexample
from stt_codegen.plants import PLANTS, model
from stt_codegen.program.convert import lower
from stt_codegen.program.symbolic import formulas
from stt_codegen.sampling import PlantEnclosure, minimum_eigenvalue

HEADING_LIMIT = 1.2  # rad: |x3| in the state space of the example task with heading
ROBOT, SPACECRAFT, ARM = PLANTS["robot"], PLANTS["spacecraft"], PLANTS["arm"]


def matrices(plant: Any, n: int) -> tuple[Any, Any, Any]:
    """Return x as symbols and f and g of a plant as SymPy matrices, from its kernel."""
    kernel = lower(model(plant, n))
    x = sp.symbols(f"x1:{n + 1}", real=True)
    values = formulas(kernel, dict(zip((v.name for v in kernel.inputs), x, strict=True)))
    return x, sp.Matrix(values[:n]), sp.Matrix(n, n, lambda i, j: values[n + i + j * n])


def _symmetric(g: Any) -> Any:
    return (g + g.T) / 2


def _prove_robot() -> Outcome:
    x, _, g = matrices(ROBOT, 3)
    expected = sp.diag(sp.cos(x[2]), sp.cos(x[2]), 1)
    return prove_identities(
        {f"g_s - diag(cos x3, cos x3, 1), entry {i}{j}": (_symmetric(g) - expected)[i, j] for i in range(3) for j in range(3)}
    )


def _prove_robot_condition() -> Outcome:
    """Prove that the smallest eigenvalue, min(cos x3, 1) = cos x3, is positive inside (-pi/2, pi/2) and 0 at its ends."""
    x, z = sp.symbols("x3 z", real=True)
    return all_of(
        prove_positive({"cos x3, x3 = arctan z": sp.cos(sp.atan(z))}),
        prove_identities(
            {
                "cos(pi/2)": sp.cos(sp.pi / 2),
                "cos(-pi/2)": sp.cos(-sp.pi / 2),
                "d cos/dx3 + sin x3": sp.diff(sp.cos(x), x) + sp.sin(x),
            }
        ),
    )


def _prove_robot_norm() -> Outcome:
    _, _, g = matrices(ROBOT, 3)
    return prove_identities(
        {f"g' g - I, entry {i}{j}": sp.simplify((g.T * g - sp.eye(3))[i, j]) for i in range(3) for j in range(3)}
    )


def _refute_robot_anywhere() -> Outcome:
    _, _, g = matrices(ROBOT, 3)
    smallest = min(_symmetric(g.subs(sp.Symbol("x3", real=True), 2)).eigenvals(), key=float)
    return refute_by_counterexample(
        "g_s is positive definite", "x3 = 2", bool(smallest < 0), f"its least eigenvalue is {sp.N(smallest, 4)}"
    )


def _prove_eigenvalue_bound(name: str, plant: Any, box: list[tuple[float, float]], bound: float) -> Outcome:
    """Prove that the smallest eigenvalue of g_s, enclosed over the box, is above the bound."""
    smallest = PlantEnclosure(plant, len(box), 1).over(box).eigenvalue_min
    verdict = Verdict.PROVED if smallest > bound else Verdict.OPEN
    return Outcome(
        verdict, "Arb: enclosures and Weyl's inequality", (f"{name}: eigenvalues of g_s >= {smallest:.6g} over {box}",)
    )


def _prove_robot_task() -> Outcome:
    return _prove_eigenvalue_bound(
        "robot", ROBOT, [(0.0, 5.0), (0.0, 5.0), (-HEADING_LIMIT, HEADING_LIMIT)], 0.9 * math.cos(HEADING_LIMIT)
    )


def _prove_robot_coupled() -> Outcome:
    """Prove when g_ii > |g_ij|, which sampled.coupled needs at equal widths: cos x3 > |sin x3| is |x3| < pi/4."""
    x, _, g = matrices(ROBOT, 3)
    return all_of(
        prove_identities({"g_11^2 - g_12^2 - cos(2 x3)": sp.simplify(g[0, 0] ** 2 - g[0, 1] ** 2 - sp.cos(2 * x[2]))}),
        prove_positive({"cos(2 x3), 2 x3 = arctan z": sp.cos(sp.atan(sp.Symbol("z", real=True)))}),
    )


def _prove_spacecraft() -> Outcome:
    """Prove that the drift does no work on the kinetic energy, and enclose the smallest eigenvalue of the constant g."""
    x, f, g = matrices(SPACECRAFT, 3)
    inertia = [1 / g[i, i] for i in range(3)]
    work = sp.Poly(sum(inertia[i] * x[i] * f[i] for i in range(3)), *x)
    largest_coefficient = max((abs(float(c)) for c in work.coeffs()), default=0.0)
    verdict = (
        Verdict.PROVED if largest_coefficient < 1e-15 else Verdict.OPEN
    )  # the inertias are doubles, so their quotients are rounded
    energy = Outcome(
        verdict, "SymPy: coefficients, up to those roundings", (f"x' J f = {largest_coefficient:.0e} x1 x2 x3 or less",)
    )
    return all_of(energy, _prove_eigenvalue_bound("spacecraft", SPACECRAFT, [(-100.0, 100.0)] * 3, 0.83))


def _prove_arm() -> Outcome:
    return _prove_eigenvalue_bound("arm", ARM, [(-math.pi, math.pi)] * 2, 0.6)


def _prove_weyl() -> Outcome:
    """Prove v'(A + D)v >= v'Av - |D| for |v| = 1 with the Frobenius norm (Cauchy, Schwarz), for 2 by 2 as a sum of squares."""
    p, q, s, c, t = sp.symbols("p q s c t", real=True)  # D = ((p, q), (q, s)), v = (c, t)
    vector, matrix = sp.Matrix([c, t]), sp.Matrix([[p, q], [q, s]])
    form = (vector.T * matrix * vector)[0]
    square = (p**2 + 2 * q**2 + s**2) * (c**2 + t**2) ** 2 - form**2
    squares = 2 * (p * c * t - q * c**2) ** 2 + (p * t**2 - s * c**2) ** 2 + 2 * (q * t**2 - s * c * t) ** 2
    computed_bound = minimum_eigenvalue([[arb(2), arb(1)], [arb(1), arb(2)]])
    return all_of(
        prove_identities({"|D|^2 |v|^4 - (v'Dv)^2 - a sum of squares": sp.expand(square - squares)}),
        prove_identities(
            {"v'(A + D)v - v'Av - v'Dv": sp.expand((vector.T * (sp.eye(2) * 2 + matrix) * vector)[0] - 2 * (c**2 + t**2) - form)}
        ),
        Outcome(
            Verdict.PROVED if 1 - 1e-9 < computed_bound <= 1 else Verdict.OPEN,
            "Arb",
            (f"the built bound for ((2, 1), (1, 2)), whose is 1: {computed_bound:.12g}",),
        ),
    )


LEMMAS = (
    Lemma(
        "plant.robot",
        "For the robot (14) g_s = diag(cos x3, cos x3, 1).",
        r"g_s = \operatorname{diag}(\cos x_3, \cos x_3, 1)",
        (),
        "(14)",
        _prove_robot,
    ),
    Lemma(
        "plant.robot_condition",
        "So Assumption 2 holds for it on a set of states exactly if |x3| is bounded below pi/2 there; g_min is its cosine.",
        r"g_s > 0 \iff |x_3| < \tfrac\pi2",
        ("x3 taken in (-pi, pi]",),
        "Assumption 2, (14)",
        _prove_robot_condition,
    ),
    Lemma(
        "plant.robot_anywhere",
        "The robot (14) fulfils Assumption 2 (no set is given for x3).",
        r"\forall x:\ g_s(x) > 0",
        (),
        "section V as printed",
        _refute_robot_anywhere,
    ),
    Lemma(
        "plant.robot_task",
        "Over the example task with heading, |x3| <= 1.2, it holds with g_min above 0.9 cos 1.2.",
        r"\lambda_{\min}(g_s) > 0.9\cos 1.2",
        ("|x3| <= 1.2",),
        "Assumption 2",
        _prove_robot_task,
    ),
    Lemma("plant.robot_norm", "Its g is a rotation: |g| = 1.", r"g^\top g = I", (), "(14)", _prove_robot_norm),
    Lemma(
        "plant.robot_coupled",
        "Its own input outweighs the other one in the plane (what sampled.coupled needs at equal widths) exactly if |x3| < pi/4.",
        r"\cos x_3 > |\sin x_3| \iff |x_3| < \tfrac\pi4",
        ("|x3| < pi/2",),
        "ours",
        _prove_robot_coupled,
    ),
    Lemma(
        "plant.spacecraft",
        "For attitude rates g is constant and definite, and the drift does no work, up to the rounding of the inertias.",
        r"x^\top J f(x) = 0,\quad g = J^{-1}",
        (),
        "Euler's equations",
        _prove_spacecraft,
    ),
    Lemma(
        "plant.arm", "For the two-link arm with unknown gains g_s >= 0.6 at all angles.", r"g_s \ge 0.6", (), "ours", _prove_arm
    ),
    Lemma(
        "plant.weyl",
        "The eigenvalue bound over a box: that of the middle matrix less the norm of what the balls leave (for 2 "
        "by 2 checked here; for n by n Weyl's inequality).",
        r"\lambda_{\min}(A+D) \ge \lambda_{\min}(A) - \|D\|_F",
        ("A, D symmetric",),
        "Weyl",
        _prove_weyl,
    ),
)
