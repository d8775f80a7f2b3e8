"""The error transform of section IV and the law (13): the emitted forms are the printed ones; the clamp; the outer product."""

from __future__ import annotations

from typing import Any

import sympy as sp

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, counterexample, identity, positive
from stt_codegen.paper import control_law
from stt_codegen.program.lower import lower
from stt_codegen.program.symbols import formulas

x = sp.Symbol("x", real=True)
low = sp.Symbol("gamma_L", real=True)
a, b, k = sp.symbols("a b k", positive=True)
e = (a - b) / (a + b)  # with a = x - gamma_L, b = gamma_U - x: (2x - gamma_s)/gamma_d


def _e() -> Outcome:
    upper = x + b
    printed = (2 * x - (upper + low)) / (upper - low)
    return identity({"(a - b)/(a + b) - (2x - gamma_s)/gamma_d": e.subs(a, x - low) - printed})


def _normalized() -> Outcome:
    (value,) = formulas(lower(control_law.normalized_error()), {"a": a, "b": b, "width": a + b})
    return identity({"emitted e less (a - b)/(a + b)": value - e})


def _epsilon() -> Outcome:
    epsilon, _ = formulas(lower(control_law.transformed_error()), {"a": a, "b": b})
    return identity({"exp(emitted epsilon) - (1 + e)/(1 - e)": sp.exp(epsilon) - (1 + e) / (1 - e)}, "SymPy: exp of both sides")


def _xi() -> Outcome:
    _, xi = formulas(lower(control_law.transformed_error()), {"a": a, "b": b})
    upper = sp.Symbol("gamma_U", real=True)
    slope = sp.diff(sp.log((x - low) / (upper - x)), x).subs(upper, x + b).subs(low, x - a)
    return identity(
        {"emitted xi - d epsilon/dx": xi - slope, "emitted xi - 4/(gamma_d (1 - e^2))": xi - 4 / ((a + b) * (1 - e**2))}
    )


def _inverse() -> Outcome:
    z = sp.Symbol("z", real=True)
    return identity(
        {
            "e = tanh(epsilon/2), put back into (1 + e)/(1 - e), less exp(epsilon)": (
                (1 + sp.tanh(z / 2)) / (1 - sp.tanh(z / 2)) - sp.exp(z)
            ).rewrite(sp.exp)
        }
    )


def _monotone() -> Outcome:
    v = sp.Symbol("e", real=True)
    derivative = sp.diff(sp.log((1 + v) / (1 - v)), v)
    return all_of(
        identity({"d epsilon/de - 2/(1 - e^2)": derivative - 2 / (1 - v**2)}),
        positive("2/(1 - e^2)", lambda w: 2 / (1 - w**2), [(-1 + 2.0**-20, 1 - 2.0**-20)], least=1.99),
    )


def _odd() -> Outcome:
    """What lets the emitted law measure from the nearer edge."""
    mirrored = formulas(lower(control_law.transformed_error()), {"a": b, "b": a})
    plain = formulas(lower(control_law.transformed_error()), {"a": a, "b": b})
    given = {"k": k, "xi": plain[1], "epsilon": plain[0]}
    other = {"k": -k, "xi": mirrored[1], "epsilon": mirrored[0]}
    law = lower(control_law.law())
    return identity(
        {
            "epsilon changes its sign": sp.expand_log(plain[0] + mirrored[0], force=True),
            "xi stays": plain[1] - mirrored[1],
            "u with -k from the other edge is u": sp.expand_log(formulas(law, given)[0] - formulas(law, other)[0], force=True),
        }
    )


def _law() -> Outcome:
    xi, epsilon = sp.symbols("xi epsilon", real=True)
    (u,) = formulas(lower(control_law.law()), {"k": k, "xi": xi, "epsilon": epsilon})
    return identity({"u + k xi epsilon": u + k * xi * epsilon})


def _clamp() -> Outcome:
    """a >= c (a + b), c = (1 - e_max)/2, is e >= -e_max; and its mirror image."""
    e_max = sp.Symbol("e_max", positive=True)
    c = (1 - e_max) / 2
    return identity(
        {
            "(a - c w)/w - (e + e_max)/2": (a - c * (a + b)) / (a + b) - (e + e_max) / 2,
            "((1 - c) w - a)/w - (e_max - e)/2": ((1 - c) * (a + b) - a) / (a + b) - (e_max - e) / 2,
        },
        "SymPy: both differences have one sign, w > 0",
    )


def _outer_product() -> tuple[Any, Any]:
    """e of two components, and I - e e^T as printed."""
    vector = sp.Matrix(sp.symbols("e1 e2", real=True))
    return vector, sp.eye(2) - vector * vector.T


def _outer() -> Outcome:
    """On the unit circle, which runs through the square |e_i| < 1, the determinant 1 - |e|^2 is 0."""
    vector, matrix = _outer_product()
    determinant = matrix.det().subs(dict(zip(vector, (sp.Rational(4, 5), sp.Rational(3, 5)), strict=True)))
    return counterexample("I - e e^T is invertible", "e = (4/5, 3/5)", determinant == 0, f"its determinant is {determinant}")


def _outer_jacobian() -> Outcome:
    """epsilon_1 does not depend on x_2, but the inverse of I - e e^T is full."""
    vector, matrix = _outer_product()
    half = dict.fromkeys(vector, sp.Rational(1, 2))
    xi = matrix.inv()[0, 1].subs(half)
    slope = sp.diff(sp.log((1 + vector[0]) / (1 - vector[0])), vector[1]).subs(half)
    return counterexample("xi_12 is d epsilon_1/dx_2", "e = (1/2, 1/2)", xi != slope, f"{xi} times 4/gamma_d, and {slope}")


LEMMAS = (
    Lemma(
        "transform.e",
        "e = (2x - gamma_s)/gamma_d is (a - b)/(a + b) in the distances to the edges.",
        r"\frac{2x-\gamma_s}{\gamma_d} = \frac{a-b}{a+b}",
        ("a, b > 0",),
        "section IV",
        _e,
    ),
    Lemma(
        "transform.e_shipped",
        "The emitted `normalized_error` is e.",
        r"\texttt{normalized\_error}(a,b,a+b) = e",
        ("a, b > 0",),
        "Program",
        _normalized,
    ),
    Lemma(
        "transform.epsilon_shipped",
        "The emitted epsilon is ln((1 + e)/(1 - e)).",
        r"\ln\frac{1+e}{1-e} = \ln\frac ab",
        ("a, b > 0",),
        "Program",
        _epsilon,
    ),
    Lemma(
        "transform.xi_shipped",
        "The emitted xi is d epsilon/dx, which is 4/(gamma_d (1 - e^2)).",
        r"\xi = \frac{\partial\varepsilon}{\partial x} = \frac{4}{\gamma_d(1-e^2)}",
        ("a, b > 0",),
        "Program",
        _xi,
    ),
    Lemma(
        "transform.inverse",
        "e = tanh(epsilon/2), so epsilon takes every real value just once.",
        r"e = \tanh(\varepsilon/2)",
        ("|e| < 1",),
        "section IV",
        _inverse,
    ),
    Lemma(
        "transform.monotone",
        "epsilon rises with e, with slope at least 2.",
        r"\frac{d\varepsilon}{de} = \frac{2}{1-e^2} \ge 2",
        ("|e| < 1",),
        "section IV",
        _monotone,
    ),
    Lemma(
        "transform.odd",
        "Measured from the other edge epsilon and k change sign and u stays: the emitted law measures from the nearer one.",
        r"u(a,b;k) = u(b,a;-k)",
        ("a, b > 0",),
        "Program",
        _odd,
    ),
    Lemma(
        "transform.law_shipped", "The emitted `law` is u = -k xi epsilon.", r"u = -k\,\xi\,\varepsilon", (), "(13), Program", _law
    ),
    Lemma(
        "transform.clamp",
        "Holding a and b within [c, 1 - c] of the width is holding e within [-e_max, e_max], c = (1 - e_max)/2.",
        r"a \ge c\,\gamma_d \iff e \ge -e_{\max}",
        ("a + b = gamma_d > 0",),
        "ours",
        _clamp,
    ),
    Lemma(
        "transform.outer_product",
        "I - e e^T, read as an outer product, is invertible wherever |e_i| < 1.",
        r"\det(I-ee^\top) \ne 0",
        ("n = 2",),
        "section IV as printed",
        _outer,
    ),
    Lemma(
        "transform.outer_jacobian",
        "With it xi would be the Jacobian of epsilon.",
        r"\xi = \partial\varepsilon/\partial x",
        ("n = 2",),
        "section IV as printed",
        _outer_jacobian,
    ),
)
