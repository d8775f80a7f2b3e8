"""Lemmas about the error transform of section IV and the law (13): the emitted kernels, the clamp, and the outer product.

book.py takes LEMMAS as the family `transform`. Long because it is one family of the book.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from flint import arb

from stt_codegen.controller.kernels import logarithm
from stt_codegen.lemmas.lemma import (
    Lemma,
    Outcome,
    all_of,
    prove_above,
    prove_identities,
    prove_positive,
    refute_by_counterexample,
)
from stt_codegen.paper import control_law
from stt_codegen.program.convert import lower
from stt_codegen.program.symbolic import formulas

x = sp.Symbol("x", real=True)
low = sp.Symbol("gamma_L", real=True)
a, b, k = sp.symbols("a b k", positive=True)
e = (a - b) / (a + b)  # with a = x - gamma_L, b = gamma_U - x: (2x - gamma_s)/gamma_d


def _prove_e() -> Outcome:
    upper = x + b
    printed = (2 * x - (upper + low)) / (upper - low)
    return prove_identities({"(a - b)/(a + b) - (2x - gamma_s)/gamma_d": e.subs(a, x - low) - printed})


def _prove_e_shipped() -> Outcome:
    (value,) = formulas(lower(control_law.normalized_error()), {"a": a, "b": b, "width": a + b})
    return prove_identities({"emitted e less (a - b)/(a + b)": value - e})


def _prove_epsilon_shipped() -> Outcome:
    epsilon, _ = formulas(lower(control_law.transformed_error()), {"a": a, "b": b})
    return prove_identities(
        {"exp(emitted epsilon) - (1 + e)/(1 - e)": sp.exp(epsilon) - (1 + e) / (1 - e)}, "SymPy: exp of both sides"
    )


def _prove_xi_shipped() -> Outcome:
    _, xi = formulas(lower(control_law.transformed_error()), {"a": a, "b": b})
    upper = sp.Symbol("gamma_U", real=True)
    slope = sp.diff(sp.log((x - low) / (upper - x)), x).subs(upper, x + b).subs(low, x - a)
    return prove_identities(
        {"emitted xi - d epsilon/dx": xi - slope, "emitted xi - 4/(gamma_d (1 - e^2))": xi - 4 / ((a + b) * (1 - e**2))}
    )


def _prove_inverse() -> Outcome:
    z = sp.Symbol("z", real=True)
    return prove_identities(
        {
            "e = tanh(epsilon/2), put back into (1 + e)/(1 - e), less exp(epsilon)": (
                (1 + sp.tanh(z / 2)) / (1 - sp.tanh(z / 2)) - sp.exp(z)
            ).rewrite(sp.exp)
        }
    )


def _prove_monotone() -> Outcome:
    v, z = sp.symbols("e z", real=True)
    derivative = sp.diff(sp.log((1 + v) / (1 - v)), v)
    return all_of(
        prove_identities({"d epsilon/de - 2/(1 - e^2)": derivative - 2 / (1 - v**2)}),
        prove_identities(
            {"2/(1 - e^2) - 2 cosh(z)^2 for e = tanh z": sp.simplify(2 / (1 - sp.tanh(z) ** 2) - 2 * sp.cosh(z) ** 2)}
        ),
        prove_positive({"2 cosh(z)^2": 2 * sp.cosh(z) ** 2}),
    )


def _prove_odd() -> Outcome:
    """Prove what allows the emitted law to measure from the nearer edge: with a, b exchanged and -k the input u is the same."""
    mirrored = formulas(lower(control_law.transformed_error()), {"a": b, "b": a})
    transformed = formulas(lower(control_law.transformed_error()), {"a": a, "b": b})
    inputs_from_lower = {"k": k, "xi": transformed[1], "epsilon": transformed[0]}
    inputs_from_upper = {"k": -k, "xi": mirrored[1], "epsilon": mirrored[0]}
    law = lower(control_law.law())
    return prove_identities(
        {
            "epsilon changes its sign": sp.expand_log(transformed[0] + mirrored[0]),
            "xi stays": transformed[1] - mirrored[1],
            "u with -k from the other edge is u": sp.expand_log(
                formulas(law, inputs_from_lower)[0] - formulas(law, inputs_from_upper)[0]
            ),
        }
    )


def _prove_law_shipped() -> Outcome:
    xi, epsilon = sp.symbols("xi epsilon", real=True)
    (u,) = formulas(lower(control_law.law()), {"k": k, "xi": xi, "epsilon": epsilon})
    return prove_identities({"u + k xi epsilon": u + k * xi * epsilon})


def _prove_clamp() -> Outcome:
    """Prove that a >= c (a + b) with c = (1 - e_max)/2 is e >= -e_max, and its mirror image."""
    e_max = sp.Symbol("e_max", positive=True)
    c = (1 - e_max) / 2
    return prove_identities(
        {
            "(a - c w)/w - (e + e_max)/2": (a - c * (a + b)) / (a + b) - (e + e_max) / 2,
            "((1 - c) w - a)/w - (e_max - e)/2": ((1 - c) * (a + b) - a) / (a + b) - (e_max - e) / 2,
        },
        "SymPy: both differences have one sign, w > 0",
    )


def _outer_product() -> tuple[Any, Any]:
    """Return e of two components as symbols, and I - e e^T as printed."""
    vector = sp.Matrix(sp.symbols("e1 e2", real=True))
    return vector, sp.eye(2) - vector * vector.T


def _refute_outer_product() -> Outcome:
    """Evaluate the determinant 1 - |e|^2 on the unit circle, which runs through the square |e_i| < 1: it is 0."""
    vector, matrix = _outer_product()
    determinant = matrix.det().subs(dict(zip(vector, (sp.Rational(4, 5), sp.Rational(3, 5)), strict=True)))
    return refute_by_counterexample(
        "I - e e^T is invertible", "e = (4/5, 3/5)", determinant == 0, f"its determinant is {determinant}"
    )


def _refute_outer_jacobian() -> Outcome:
    """Compare xi_12 with the slope of epsilon_1 in x_2, which is 0; the inverse of I - e e^T is a full matrix."""
    vector, matrix = _outer_product()
    half = dict.fromkeys(vector, sp.Rational(1, 2))
    xi = matrix.inv()[0, 1].subs(half)
    slope = sp.diff(sp.log((1 + vector[0]) / (1 - vector[0])), vector[1]).subs(half)
    return refute_by_counterexample(
        "xi_12 is d epsilon_1/dx_2", "e = (1/2, 1/2)", xi != slope, f"{xi} times 4/gamma_d, and {slope}"
    )


def _refute_outer_loop() -> Outcome:
    """Compute u by the outer product for xdot = u, k = 1 in the resting tube (-1, 1)^2: it points outward in both components."""
    vector, matrix = _outer_product()
    point = dict.fromkeys(vector, sp.Rational(3, 4))
    epsilon = sp.Matrix([sp.log((1 + v) / (1 - v)) for v in vector])
    u = (-2 * matrix.inv() * epsilon).subs(point)  # 4/gamma_d = 2
    points_outward = all(bool(v > 0) for v in u)
    evidence = f"xdot = ({sp.N(u[0], 4)}, {sp.N(u[1], 4)}), away from the middle"
    return refute_by_counterexample("the loop is driven inward", "gamma = (-1, 1)^2, x = (3/4, 3/4)", points_outward, evidence)


def _refute_outer_three() -> Outcome:
    """Evaluate the determinant in three dimensions on the unit sphere, where it is 0 as on the circle."""
    e = sp.Matrix([sp.Rational(2, 3), sp.Rational(2, 3), sp.Rational(1, 3)])
    determinant = (sp.eye(3) - e * e.T).det()
    return refute_by_counterexample(
        "I - e e^T is invertible", "e = (2/3, 2/3, 1/3)", determinant == 0, f"its determinant is {determinant}"
    )


def _prove_clamp_cost() -> Outcome:
    """Prove that |u| at the clamp is the law's at e = e_max, which is 4 k eps(e_max)/(gamma_d (1 - e_max^2))."""
    ratio, width = sp.symbols("rho w", positive=True)
    e_max = ratio / (1 + ratio)  # any number from 0 to 1
    near, far = (1 - e_max) / 2 * width, (1 + e_max) / 2 * width
    at_clamp = (1 / near + 1 / far) * sp.log(far / near)
    printed = 4 / (width * (1 - e_max**2)) * sp.log((1 + e_max) / (1 - e_max))
    return prove_identities(
        {
            "k h at the clamp, less 4 k ln((1 + e_max)/(1 - e_max))/(gamma_d (1 - e_max^2))": sp.simplify(
                sp.expand_log(sp.simplify(at_clamp - printed))
            ),
            "tanh(eps(e_max)/2) - e_max": sp.simplify(sp.tanh(sp.log((1 + e_max) / (1 - e_max)) / 2).rewrite(sp.exp) - e_max),
        }
    )


def _prove_logarithm() -> Outcome:
    """Prove that the kernel computes e ln 2 + s (2 + C s^2), and that its polynomial is within 2^-14.9 of 2 atanh(s)/s.

    For y = m 2^e and s = (m - 1)/(m + 1) the logarithm ln y is e ln 2 + 2 atanh s; |s| is at most (sqrt 2 - 1)^2.
    """
    mantissa, exponent = sp.Symbol("m", positive=True), sp.Symbol("e", integer=True)
    kernel = logarithm.with_inline_logarithm(lower(control_law.transformed_error()))
    epsilon, _ = formulas(kernel, {"a": a, "b": b})
    ratio = b / a
    parts = {sp.Function("exponent")(ratio): exponent, sp.Function("mantissa")(ratio): mantissa}
    s = (mantissa - 1) / (mantissa + 1)
    polynomial = sp.Rational(logarithm.C.numerator, logarithm.C.denominator) * s**2 + 2
    ln2 = sp.Rational(logarithm.LN2.numerator, logarithm.LN2.denominator)
    s_limit = float(logarithm.LARGEST_Z) ** 0.5 * (1 + 2.0**-40)
    bound, c = 2.0**-14.9, arb(float(logarithm.C))

    def bound_less_error(v: Any, direction: int) -> Any:
        """Enclose bound 2 s + direction D around the middle of the ball; D = s (2 + C s^2) - 2 atanh s, and 2 s <= 2 atanh s."""
        middle = arb(v.mid())
        difference = middle * (2 + c * middle**2) - 2 * middle.atanh()
        slope = 2 + 3 * c * v**2 - 2 / (1 - v**2)
        return 2 * bound * middle + direction * difference + (2 * bound + direction * slope) * (v - middle)

    small = 2.0**-7  # below it 2 atanh(s) - 2 s is at most 0.67 s^3, and C is at most 0.68
    ln2_error = abs(arb(ln2.p) / ln2.q - arb(2).log())
    return all_of(
        prove_identities(
            {"emitted -epsilon less e ln2 + s (2 + C s^2)": sp.expand(-epsilon.subs(parts) - (exponent * ln2 + s * polynomial))}
        ),
        prove_identities({"(1 + s)/(1 - s) - m": sp.simplify((1 + s) / (1 - s) - mantissa)}),
        prove_above("2^-14.9 2 s + D", lambda v: bound_less_error(v, 1), [(small, s_limit)]),
        prove_above("2^-14.9 2 s - D", lambda v: bound_less_error(v, -1), [(small, s_limit)]),
        prove_above("2^-14.9 - 0.68 s^2/2 below s = 2^-7", lambda v: arb(bound) - arb("0.34") * v**2, [(0.0, small)]),
        prove_identities(
            {"whether |ln 2 of the Program - ln 2| is above 2^-50": sp.Integer(0 if ln2_error < arb(2) ** -50 else 1)}
        ),
    )


LEMMAS = (
    Lemma(
        "transform.e",
        "e = (2x - gamma_s)/gamma_d is (a - b)/(a + b) in the distances to the edges.",
        r"\frac{2x-\gamma_s}{\gamma_d} = \frac{a-b}{a+b}",
        ("a, b > 0",),
        "section IV",
        _prove_e,
    ),
    Lemma(
        "transform.e_shipped",
        "The emitted `normalized_error` is e.",
        r"\texttt{normalized\_error}(a,b,a+b) = e",
        ("a, b > 0",),
        "Program",
        _prove_e_shipped,
    ),
    Lemma(
        "transform.epsilon_shipped",
        "The emitted epsilon is ln((1 + e)/(1 - e)).",
        r"\ln\frac{1+e}{1-e} = \ln\frac ab",
        ("a, b > 0",),
        "Program",
        _prove_epsilon_shipped,
    ),
    Lemma(
        "transform.xi_shipped",
        "The emitted xi is d epsilon/dx, which is 4/(gamma_d (1 - e^2)).",
        r"\xi = \frac{\partial\varepsilon}{\partial x} = \frac{4}{\gamma_d(1-e^2)}",
        ("a, b > 0",),
        "Program",
        _prove_xi_shipped,
    ),
    Lemma(
        "transform.inverse",
        "e = tanh(epsilon/2), so epsilon takes every real value just once.",
        r"e = \tanh(\varepsilon/2)",
        ("|e| < 1",),
        "section IV",
        _prove_inverse,
    ),
    Lemma(
        "transform.monotone",
        "epsilon rises with e, with slope at least 2.",
        r"\frac{d\varepsilon}{de} = \frac{2}{1-e^2} \ge 2",
        ("|e| < 1",),
        "section IV",
        _prove_monotone,
    ),
    Lemma(
        "transform.odd",
        "Measured from the other edge epsilon and k change sign and u stays: the emitted law measures from the nearer one.",
        r"u(a,b;k) = u(b,a;-k)",
        ("a, b > 0",),
        "Program",
        _prove_odd,
    ),
    Lemma(
        "transform.law_shipped",
        "The emitted `law` is u = -k xi epsilon.",
        r"u = -k\,\xi\,\varepsilon",
        (),
        "(13), Program",
        _prove_law_shipped,
    ),
    Lemma(
        "transform.clamp",
        "Holding a and b within [c, 1 - c] of the width is holding e within [-e_max, e_max], c = (1 - e_max)/2.",
        r"a \ge c\,\gamma_d \iff e \ge -e_{\max}",
        ("a + b = gamma_d > 0",),
        "ours",
        _prove_clamp,
    ),
    Lemma(
        "transform.outer_product",
        "I - e e^T, read as an outer product, is invertible wherever |e_i| < 1.",
        r"\det(I-ee^\top) \ne 0",
        ("n = 2",),
        "section IV as printed",
        _refute_outer_product,
    ),
    Lemma(
        "transform.outer_jacobian",
        "With it xi would be the Jacobian of epsilon.",
        r"\xi = \partial\varepsilon/\partial x",
        ("n = 2",),
        "section IV as printed",
        _refute_outer_jacobian,
    ),
    Lemma(
        "transform.outer_loop",
        "With it the closed loop xdot = u, k > 0, is driven toward the middle of the tube.",
        r"\dot x = -k\,\tfrac{4}{\gamma_d}(I-ee^\top)^{-1}\varepsilon \text{ points inward}",
        ("n = 2",),
        "section IV as printed",
        _refute_outer_loop,
    ),
    Lemma(
        "transform.outer_three",
        "In three dimensions it is invertible wherever |e_i| < 1.",
        r"\det(I-ee^\top) \ne 0",
        ("n = 3",),
        "section IV as printed",
        _refute_outer_three,
    ),
    Lemma(
        "transform.clamp_cost",
        "The clamp bounds |u| by its value at e_max and changes nothing while |eps| <= eps(e_max): Theorem 4.1 stands if eps* is "
        "below that.",
        r"|u| \le \frac{4k}{\gamma_d(1-e_{\max}^2)}\ln\frac{1+e_{\max}}{1-e_{\max}}",
        ("gamma_d > 0",),
        "ours",
        _prove_clamp_cost,
    ),
    Lemma(
        "transform.logarithm",
        "The inline logarithm is e ln 2 + s (2 + C s^2), within 2^-14.9 of ln y, relatively: component i has a gain within 2^-14 "
        "of k.",
        r"\ln y = e\ln 2 + 2\operatorname{artanh} s,\quad s = \tfrac{m-1}{m+1}",
        ("y = m 2^e, m in [1/sqrt 2, sqrt 2)", "rounding: `controller/kernels/logarithm.py`"),
        "ours, Program",
        _prove_logarithm,
    ),
)
