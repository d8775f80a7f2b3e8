"""The equations in CasADi: identities proved symbolically, for the kernels that are emitted."""

from __future__ import annotations

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from stt_codegen.paper import control_law, refined_tube
from stt_codegen.program.convert.from_casadi import lower
from stt_codegen.program.nodes import Kernel
from stt_codegen.program.symbolic.symbols import formulas


def symbolic(kernel: Kernel) -> tuple[dict[str, sp.Symbol], list[sp.Expr]]:
    """Return the symbols of a kernel's inputs, which are positive, and its outputs as SymPy expressions of them."""
    symbols = {v.name: sp.Symbol(v.name, positive=True) for v in kernel.inputs}
    return symbols, list(formulas(kernel, symbols))


def test_the_weights_are_six_times_the_cubic_b_spline_basis() -> None:
    symbols, weights = symbolic(lower(refined_tube.basis()))
    s = symbols["s"]
    textbook = [(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]
    for got, want in zip(weights, textbook, strict=True):
        assert sp.expand(got - want) == 0
    assert sp.expand(sum(weights)) == 6


def test_the_emitted_weight_rates_are_the_derivatives_of_the_emitted_weights() -> None:
    symbols, weights = symbolic(lower(refined_tube.basis()))
    _, rates = symbolic(lower(refined_tube.basis_rate()))
    for w, dw in zip(weights, rates, strict=True):
        assert sp.expand(sp.diff(w, symbols["s"]) - dw) == 0


def test_neighbouring_segments_agree_in_value_slope_and_curvature() -> None:
    """Weight j at the end of a segment is weight j - 1 at the start of the next, and so are two derivatives."""
    symbols, weights = symbolic(lower(refined_tube.basis()))
    s = symbols["s"]
    for order in range(3):
        end = [sp.diff(w, s, order).subs(s, 1) for w in weights]
        start = [sp.diff(w, s, order).subs(s, 0) for w in weights]
        assert end[1:] == start[:3]
        assert end[0] == start[3] == 0


def test_xi_is_the_derivative_of_epsilon_and_all_forms_are_the_printed_one() -> None:
    """Forms: by automatic differentiation, as emitted, as 1/a + 1/b, and as printed: 4 / (gamma_d (1 - e^2)), I - e e^T diagonal."""
    x, low, high = sp.symbols("x lower upper", positive=True)
    symbols, (_, xi) = symbolic(lower(control_law.transformed_error()))
    emitted = xi.subs({symbols["a"]: x - low, symbols["b"]: high - x}, simultaneous=True)
    ad_symbols, (by_ad,) = symbolic(lower(control_law.xi_by_differentiation()))
    names = [v.name for v in lower(control_law.xi_by_differentiation()).inputs]
    by_ad = by_ad.subs(dict(zip((ad_symbols[n] for n in names), (x, low, high), strict=True)), simultaneous=True)
    e = (2 * x - (high + low)) / (high - low)
    printed = 4 / ((high - low) * (1 - e**2))
    assert sp.simplify(emitted - by_ad) == 0
    assert sp.simplify(emitted - printed) == 0
    assert sp.simplify(emitted - sp.diff(sp.log((x - low) / (high - x)), x)) == 0


def test_e_and_epsilon_in_the_distances_are_the_printed_ones() -> None:
    x, low, high = sp.symbols("x lower upper", positive=True)
    s, (e,) = symbolic(lower(control_law.normalized_error()))
    e = e.subs({s["a"]: x - low, s["b"]: high - x, s["width"]: high - low}, simultaneous=True)
    assert sp.simplify(e - (2 * x - (high + low)) / (high - low)) == 0
    s, (epsilon, _) = symbolic(lower(control_law.transformed_error()))
    epsilon = epsilon.subs({s["a"]: x - low, s["b"]: high - x}, simultaneous=True)
    assert sp.simplify(sp.exp(epsilon) - (1 + e) / (1 - e)) == 0


def test_the_law_is_minus_k_xi_epsilon() -> None:
    s, (u,) = symbolic(lower(control_law.law()))
    assert sp.expand(u + s["k"] * s["xi"] * s["epsilon"]) == 0


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@given(data=st.data())
def test_xi_by_ad_equals_the_emitted_xi_in_numbers(scale: float, data) -> None:
    """They differ by at most 12 roundings, the bound of `compare`, and 12 more of the automatic differentiation."""
    low = data.draw(st.floats(-5, 5)) * scale
    width = data.draw(st.floats(0.05, 5)) * scale
    share = data.draw(st.floats(0.01, 0.99))
    high = low + width
    x = low + share * width
    a, b = x - low, high - x
    emitted = float(control_law.transformed_error()(a, b)[1])
    by_ad = float(control_law.xi_by_differentiation()(x, low, high))
    assert abs(emitted - by_ad) <= 24 * 2.0**-53 * emitted


def test_the_law_is_exactly_zero_on_the_centre_line() -> None:
    epsilon, xi = (float(v) for v in control_law.transformed_error()(0.125, 0.125))
    assert (epsilon, xi) == (0.0, 16.0)
    assert float(control_law.law()(0.5, xi, epsilon)) == 0.0
