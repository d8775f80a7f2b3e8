"""The table of operations: one row is enough for CasADi's reader, the printers, balls, error bounds, SymPy and the cost of an operation,
and without the row it is refused."""

from __future__ import annotations

import math
import struct
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from stt_codegen.program.analyse.ball_arithmetic import ball, hull
from stt_codegen.program.analyse.balls import Enclosure
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.program.analyse.rounding import Inexact, rounding_error
from stt_codegen.program.analyse.running import Runner
from stt_codegen.program.convert.from_casadi import UnknownOpcode
from stt_codegen.program.nodes import Kernel, Op
from stt_codegen.program.operations import LIBRARY_ULPS, OPERATIONS, REAL, Operation
from stt_codegen.program.symbolic.symbols import formulas
from tests.support.bank import kernel_of, one_function_program, run_c, run_python

# An operation that the table does not have, as a contributor would add it, and one that it has.
ASINH = Operation(
    (REAL,), REAL, "math", math.asinh, call="asinh", casadi=("OP_ASINH",), ball="{0}.asinh()", ulps=LIBRARY_ULPS,
    formula=lambda sp, a: sp.asinh(a), change=("arcsinh", -math.inf),
)  # fmt: skip
CASES = {"asinh": (ca.asinh, ASINH, math.asinh), "sqrt": (ca.sqrt, OPERATIONS["sqrt"], math.sqrt)}
ARGUMENTS = (1e-3, 0.3, 1.0, 2.5, 40.0)


@pytest.fixture(params=CASES)
def case(request, monkeypatch):
    """Put the row of an operation into the table, and return its name, its function in CasADi and its true value."""
    build, row, truth = CASES[request.param]
    monkeypatch.setitem(OPERATIONS, request.param, row)
    return request.param, build, truth


def kernel_with(name: str, build) -> Kernel:
    """Return the kernel y = f(1 + x^2) - x."""
    kernel, _ = kernel_of("shifted", lambda x: build(1 + x * x) - x, 1)
    assert name in {a.value.name for a in kernel.body if isinstance(a.value, Op)}
    return kernel


@pytest.mark.parametrize("name", CASES)
def test_without_its_row_an_operation_is_refused(name: str, monkeypatch) -> None:
    monkeypatch.delitem(OPERATIONS, name, raising=False)
    with pytest.raises(UnknownOpcode, match=f"OP_{name.upper()}"):
        kernel_of("shifted", CASES[name][0], 1)


def test_with_its_row_an_operation_is_printed_compiled_and_counted(case, tool, tmp_path) -> None:
    name, build, truth = case
    kernel = kernel_with(name, build)
    for scalar, ulps in (("double", 2.0**-52), ("float", 2.0**-23)):
        program = one_function_program(kernel, scalar)
        for reader in (run_c(program, tool("gcc"), tmp_path), run_python(one_function_program(kernel, "double"))):
            for x in ARGUMENTS:
                argument = struct.unpack("f", struct.pack("f", x))[0]
                expected, value = truth(1 + argument**2) - argument, reader([argument])[0]
                value = value[0] if isinstance(value, tuple) else value
                assert abs(value - expected) <= 4 * ulps * (truth(1 + argument**2) + argument)
        assert cost_of(program, "f")["math"] == 1


def test_with_its_row_an_operation_is_enclosed_and_bounded(case) -> None:
    """Balls with and without roundings contain the true value, and the runner's bound covers the error of a float."""
    name, build, truth = case
    program = one_function_program(kernel_with(name, build), "float")
    printed, exact = Enclosure(program, rounding=True), Enclosure(program, rounding=False)
    for x in ARGUMENTS:
        (value,) = exact.kernel("shifted", ball(Fraction(x)))
        expected = getattr(1 + ball(Fraction(x)) ** 2, name)() - ball(Fraction(x))
        assert value.overlaps(expected)
        (wide,) = printed.kernel("shifted", hull(x, x * 1.001))
        assert wide.contains(expected)
        (rounded,) = printed.kernel("shifted", ball(Fraction(x)))
        assert float(rounded.rad()) > float(value.rad())
        argument = np.float32(x)
        float_value = np.float32(np.float32(truth(float(np.float32(1) + argument * argument))) - argument)
        assert printed.kernel("shifted", arb(float(argument)))[0].contains(arb(float(float_value)))
    points = np.array(ARGUMENTS, dtype=np.float32)
    estimate = Runner(program).run("f", {"x": points[:, None].astype(np.longdouble)})["y"]
    true = np.array([truth(1 + float(v) ** 2) - float(v) for v in points])
    assert np.all(np.abs(estimate.value[:, 0].astype(float) - true) <= 1e-15 * (1 + points.astype(float)) ** 2)
    assert np.all(estimate.error[:, 0] > 0)


def test_with_its_row_an_operation_is_a_formula(case) -> None:
    name, build, _ = case
    x = sp.Symbol("x")
    (formula,) = formulas(kernel_with(name, build), {"x0": x})
    assert sp.simplify(formula - (getattr(sp, name)(1 + x**2) - x)) == 0


@given(
    st.fractions(min_value=Fraction(1, 100), max_value=100),
    st.fractions(min_value=0, max_value=10),
    st.fractions(min_value=0, max_value=1),
)
def test_the_error_bound_of_sqrt_holds(low: Fraction, width: Fraction, share: Fraction) -> None:
    """For every argument in the range with the largest allowed error, the root of the wrong argument is within the bound."""
    kernel, _ = kernel_of("root", ca.sqrt, 1)
    error = low / 7
    (bound,) = rounding_error(kernel, {"x0": Inexact(low, low + width, error)}, "double")
    argument = low + share * width
    for wrong in (argument - error, argument + error):
        a, b = (ball(v).sqrt() for v in (argument, wrong))
        assert abs(a - b) <= ball(bound.error)
    assert bound.low**2 <= argument <= bound.high**2


def test_a_rounding_bound_that_is_not_known_is_refused() -> None:
    kernel, _ = kernel_of("root", ca.sqrt, 1)
    with pytest.raises(NotImplementedError, match="sqrt"):
        rounding_error(kernel, {"x0": Inexact(Fraction(0), Fraction(1), Fraction(1))}, "float")


def test_every_row_is_complete() -> None:
    """A row with a real result has a rounding bound, no row has both an infix sign and a call, and each has a ball."""
    for name, row in OPERATIONS.items():
        assert (row.ulps is not None) == (row.result is REAL and name != "real"), name
        assert not (row.infix and row.call), name
        assert row.ball, name
