"""The Program and its readers: every node and opcode, lowered and printed, gives the number of CasADi."""

from __future__ import annotations

import math
import shutil
import struct
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stt_codegen.emit.naming import check_names
from stt_codegen.program.analyse.ball_arithmetic import ball
from stt_codegen.program.analyse.balls import Enclosure
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.program.analyse.rounding import Inexact, rounding_error
from stt_codegen.program.analyse.running import Runner
from stt_codegen.program.build import Block
from stt_codegen.program.convert.from_casadi import UnknownOpcode, direct_opcodes, lower, opcode_names
from stt_codegen.program.nodes import (
    Assign,
    Const,
    Function,
    IsFinite,
    Kernel,
    Load,
    Op,
    Param,
    Program,
    Select,
    Table,
    Trunc,
    Var,
    integer,
    real,
)
from stt_codegen.program.number import FORMATS, round_to, shortest, ulp_exponent
from stt_codegen.program.operations import OPERATIONS, REAL
from stt_codegen.program.targets import TARGETS
from stt_codegen.program.targets.c.printer import CPrinter
from tests.support.bank import kernel_of, one_function_program, run_c, run_python, unit_in_last_place

POINTS = [-2.5, -1.0, -0.75, -0.0, 0.0, 1e-3, 0.3, 0.5, 0.99, 1.0, 2.0, 7.25]
POSITIVE = [1e-3, 0.3, 0.5, 0.99, 1.0, 2.0, 7.25]
INSIDE = [-0.99, -0.5, 0.0, 1e-3, 0.7]

# name: (expression, domain, allowed difference from CasADi in double, in units in the last place: 0 where IEEE arithmetic is exact, 1 for
# math functions, whose library may be another one than CasADi's)
BANK = {
    "add": (lambda a, b: a + b, POINTS, 0),
    "sub": (lambda a, b: a - b, POINTS, 0),
    "mul": (lambda a, b: a * b, POINTS, 0),
    "div": (lambda a, b: a / (b * b + 1), POINTS, 0),
    "neg": (lambda a: -a, POINTS, 0),
    "twice": (lambda a: a + a, POINTS, 0),
    "sq": (lambda a: a * a - 1, POINTS, 0),
    "inv": (lambda a: 1 / (a + 10), POINTS, 0),
    "fabs": (lambda a: ca.fabs(a), POINTS, 0),
    "sqrt": (lambda a: ca.sqrt(a), POSITIVE, 0),
    "exp": (lambda a: ca.exp(a), POINTS, 1),
    "expm1": (lambda a: ca.expm1(a), POINTS, 1),
    "log": (lambda a: ca.log(a), POSITIVE, 1),
    "log1p": (lambda a: ca.log1p(a), INSIDE, 1),
    "sinh": (lambda a: ca.sinh(a), POINTS, 1),
    "cosh": (lambda a: ca.cosh(a), POINTS, 1),
    "tanh": (lambda a: ca.tanh(a), POINTS, 1),
    "atanh": (lambda a: ca.atanh(a), INSIDE, 1),
    "sin": (lambda a: ca.sin(a), POINTS, 1),
    "cos": (lambda a: ca.cos(a), POINTS, 1),
    "tan": (lambda a: ca.tan(a), INSIDE, 1),
    "floor": (lambda a: ca.floor(a), POINTS, 0),
    "ceil": (lambda a: ca.ceil(a), POINTS, 0),
    "fmin": (lambda a, b: ca.fmin(a, b), POINTS, 0),
    "fmax": (lambda a, b: ca.fmax(a, b), POINTS, 0),
    "pow": (lambda a, b: ca.power(a, b), POSITIVE, 1),
    "constpow": (lambda a: a**1.7, POSITIVE, 1),
    "sign": (lambda a: ca.sign(a), POINTS, 0),
    "lt": (lambda a, b: a < b, POINTS, 0),
    "le": (lambda a, b: a <= b, POINTS, 0),
    "eq": (lambda a, b: a == b, POINTS, 0),
    "ne": (lambda a, b: a != b, POINTS, 0),
    "and": (lambda a, b: ca.logic_and(a < b, b < 1), POINTS, 0),
    "or": (lambda a, b: ca.logic_or(a < b, b < 1), POINTS, 0),
    "not": (lambda a, b: ca.logic_not(a < b), POINTS, 0),
    "if_else": (lambda a, b: ca.if_else(a < b, a + 1, b * 3), POINTS, 0),
    "if_else_zero": (lambda a: ca.if_else(a, a + 2, 0), POINTS, 0),
    "constants": (lambda a: 0.1 + a * 1e-30 - a * math.pi, POINTS, 0),
}  # fmt: skip


@pytest.fixture(params=["gcc", "clang"])
def compiler(request, tool) -> str:
    return tool(request.param)


def points_of(domain: list[float], count: int) -> list[tuple[float, ...]]:
    return [(a,) for a in domain] if count == 1 else [(a, b) for a in domain for b in domain]


@pytest.mark.parametrize("name", BANK)
def test_every_opcode_in_python_and_c_in_double_equals_casadi(name: str, tool, tmp_path) -> None:
    build, domain, ulps = BANK[name]
    count = build.__code__.co_argcount
    kernel, function = kernel_of(name, build, count)
    program = one_function_program(kernel, "double")
    readers = {"python": run_python(program), "c": run_c(program, tool("gcc"), tmp_path)}
    for x in points_of(domain, count):
        expected = float(function(*x))
        for reader, f in readers.items():
            value = f(x)[0]
            value = value[0] if isinstance(value, tuple) else value
            assert abs(value - expected) <= ulps * unit_in_last_place(expected, "double"), (reader, x)


@pytest.mark.parametrize("name", BANK)
def test_every_opcode_in_c_in_float_is_rounded_once_an_operation(name: str, compiler, tmp_path) -> None:
    """The difference from double is at most one unit in the last place of its terms for each operation of the kernel."""
    build, domain, _ = BANK[name]
    count = build.__code__.co_argcount
    kernel, function = kernel_of(name, build, count)
    f = run_c(one_function_program(kernel, "float"), compiler, tmp_path)
    exact = [p for p in points_of(domain, count) if all(float(np.float32(v)) == v for v in p)]
    assert len(exact) >= 2
    for x in exact:
        expected = float(function(*x))
        terms = max(1.0, abs(expected), *(abs(v) for v in x)) if name in ("sub", "constants", "sq") else abs(expected)
        assert abs(f(x)[0] - expected) <= (len(kernel.body) + 1) * unit_in_last_place(terms, "float"), x


@pytest.mark.parametrize("name", BANK)
def test_every_opcode_is_enclosed_and_its_error_is_bounded(name: str) -> None:
    """Balls contain the double of CasADi. Where every operation has an error bound, the bound covers the error of a float."""
    build, domain, _ = BANK[name]
    count = build.__code__.co_argcount
    kernel, function = kernel_of(name, build, count)
    if kernel.outputs[0].type is not REAL:
        return
    points = points_of([float(np.float32(v)) for v in domain], count)
    enclosure = Enclosure(one_function_program(kernel, "double"), rounding=True)
    for x in points:
        (enclosed,) = enclosure.kernel(name, *(ball(Fraction(v)) for v in x))
        assert enclosed.contains(ball(Fraction(float(function(*x))))), x
    rows = [OPERATIONS[a.value.name] for a in kernel.body if isinstance(a.value, Op)]
    single = one_function_program(kernel, "float")
    if any(row.result is REAL and row.change is None and row.spread is None for row in rows):
        with pytest.raises(NotImplementedError, match="no error bound"):
            Runner(single).run("f", {"x": np.array(points, dtype=np.longdouble)})
        return
    estimate = Runner(single).run("f", {"x": np.array(points, dtype=np.longdouble)})["y"]
    expected = np.array([float(function(*x)) for x in points])
    assert np.all(
        np.abs(estimate.value[:, 0].astype(float) - expected) <= 1e-6 * (1 + np.abs(expected))
    )  # constants are rounded to floats
    assert np.all(np.isfinite(estimate.error))


def test_the_bank_covers_every_opcode_and_operation() -> None:
    used: set[str] = set()
    opcodes: set[str] = set()
    for name, (build, _, _) in BANK.items():
        kernel, function = kernel_of(name, build, build.__code__.co_argcount)
        used |= {a.value.name for a in kernel.body if isinstance(a.value, Op)}
        opcodes |= {opcode_names()[function.instruction_id(k)] for k in range(function.n_instructions())}
    in_frames = {"iadd", "imul", "ilt", "real"}  # driven by the frame test below
    in_other_tests = {
        "exponent",
        "mantissa",
        "isub",
        "idiv",
        "int",
        "tlt",
    }  # tests/program/test_logarithm.py, tests/controller/test_ticks.py
    in_other_tests |= {
        "ishr",
        "ishl",
        "high_product",
        "low_bits",
        "leading",
        "product",
        "short",
        "ineg",
    }  # tests/controller/test_fixed.py
    assert used | in_frames | in_other_tests == set(OPERATIONS)
    assert set(direct_opcodes()) <= opcodes | {"OP_CONSTPOW"}
    assert {"OP_TWICE", "OP_SQ", "OP_INV", "OP_SIGN", "OP_FMIN", "OP_FMAX", "OP_IF_ELSE_ZERO"} <= opcodes


def frame_program(scalar: str) -> Program:
    """Return a program with every node of a frame: y sums table entries from trunc(x) on in a loop, and NaN returns early."""
    table = Table("steps", tuple(Fraction(v) for v in (1, 2, 4, 8)), 2)
    block = Block({"x", "y"})
    x = block.let("x_0", Load("x", integer(0)))
    finite = block.let("finite", IsFinite(x))
    with block.leave_when(block.op("bad", "not", finite)):
        block.store("y", integer(0), real(-1))
    truncated = block.let("whole", Trunc(x))
    small = block.op("is_small", "ilt", truncated, integer(2))
    start = block.let("start", Select(small, truncated, integer(2)))
    with block.loop("i", 2) as loop:
        total = loop.carry("total", real(0))
        index = block.op("index", "iadd", start, block.op("scaled", "imul", loop.index, integer(1)))
        entry = block.let("entry", Load("steps", index))
        weighted = block.op("weighted", "mul", entry, block.op("place", "real", index))
        loop.update(total, block.op("sum", "add", total, weighted))
    block.store("y", integer(0), total)
    block.leave()
    f = Function("f", (Param("x", 1), Param("y", 1, True)), tuple(block.statements), False)
    return Program("bank", 1, scalar, (table,), (), functions=(f,))


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_every_frame_node_through_python_and_c(scalar: str, compiler, tmp_path) -> None:
    program = frame_program(scalar)
    check_names(program)
    printer = CPrinter(program)
    import ctypes
    import subprocess

    from stt_codegen.program.targets.c.runner import STRICT

    text = [
        "#include <math.h>",
        "#include <stdbool.h>",
        "#include <stdint.h>",
        f"typedef {scalar} bank_real;",
        "#define BANK_N 1",
    ]
    text += [*printer.table(program.tables[0]), *printer.prototype(program.functions[0]), *printer.function(program.functions[0])]
    (tmp_path / "b.c").write_text("\n".join(text) + "\n")
    subprocess.run(
        [compiler, *STRICT, "-shared", "-fPIC", "-o", str(tmp_path / "b.so"), str(tmp_path / "b.c"), "-lm"], check=True
    )
    number = ctypes.c_float if scalar == "float" else ctypes.c_double
    call = ctypes.CDLL(str(tmp_path / "b.so")).bank_f
    python = run_python(program)
    values = [1.0, 2.0, 4.0, 8.0]
    for x in (0.0, 0.9, 1.5, 2.0, 3.7, 100.0, math.nan, math.inf):
        argument, result = (number * 1)(x), (number * 1)()
        call(argument, result)
        if math.isfinite(x):
            start = min(int(x), 2)
            expected = sum(values[start + i] * (start + i) for i in range(2))
        else:
            expected = -1.0
        assert result[0] == expected
        assert python([x])[0] == expected


def test_an_unknown_opcode_is_named() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(UnknownOpcode, match="OP_ERF"):
        lower(ca.Function("f", [x], [ca.erf(x)]))


def test_common_expressions_are_computed_once_and_unused_ones_are_dropped() -> None:
    x = ca.SX.sym("x")
    y = ca.SX.sym("y")
    unused = ca.exp(y)
    function = ca.Function("f", [x, y], [ca.sin(x * y) + ca.sin(y * x), unused], ["x", "y"], ["a", "b"])
    kernel = lower(function)
    names = [a.value.name for a in kernel.body if isinstance(a.value, Op)]
    assert names.count("sin") == 1
    assert names.count("mul") == 1
    without_exp = lower(ca.Function("f", [x, y], [ca.sin(x * y) + 0 * unused], ["x", "y"], ["a"]))
    assert "exp" not in [a.value.name for a in without_exp.body if isinstance(a.value, Op)]


def test_inputs_are_never_overwritten_although_casadi_reuses_slots() -> None:
    x = ca.SX.sym("x", 3)
    f = ca.Function("f", [x], [ca.vertcat(x[1] * x[2], x[0] + x[2], x[0] * x[1] - x[2])], ["x"], ["y"])
    kernel = lower(f)
    assigned = [a.var.name for a in kernel.body]
    assert len(assigned) == len(set(assigned))
    assert not set(assigned) & {v.name for v in kernel.inputs}


def test_constants_of_casadi_stay_exact() -> None:
    x = ca.SX.sym("x")
    value = 0.1 + 2**-40
    kernel = lower(ca.Function("f", [x], [x * value]))
    constants = [a for k in kernel.body if isinstance(k.value, Op) for a in k.value.args if isinstance(a, Const)]
    assert [c.value for c in constants] == [Fraction(value)]


def test_every_operation_is_printed_by_every_printer_and_counted() -> None:
    for name, row in OPERATIONS.items():
        args = tuple(Var(f"a{k}", t) for k, t in enumerate(row.args))
        op = Op(name, args)
        for scalar in FORMATS:
            program = Program("p", 1, scalar, (), (), functions=())
            assert all(target.printer(program).expression(op) for target in TARGETS if target.integers)
        var = Var("v", row.result)
        f = Function("f", (), (Assign(var, op),), False)
        assert sum(cost_of(Program("p", 1, "float", (), (), functions=(f,)), "f").values()) == 1


def test_the_cost_of_a_loop_is_its_count_times_its_body_without_early_returns() -> None:
    cost = cost_of(frame_program("float"), "f")
    assert cost["load"] == 1 + 2
    assert cost["mul"] == 2
    assert cost["integer"] == 1 + 2 * 3


def test_ill_typed_operations_are_refused() -> None:
    with pytest.raises(TypeError):
        Op("add", (real(1), integer(1)))
    with pytest.raises(ValueError, match="unknown operation"):
        Op("sinc", (real(1),))
    with pytest.raises(TypeError):
        Select(real(1), real(1), real(2))


# ------------------------------------------------------------------------------------------------ numbers

finite_doubles = st.floats(allow_nan=False, allow_infinity=False)


def as_float32(value: float) -> float:
    return struct.unpack("<f", struct.pack("<f", value))[0]


@given(finite_doubles)
def test_rounding_to_float_equals_that_of_the_hardware(value: float) -> None:
    try:
        expected = as_float32(value)
    except OverflowError:
        with pytest.raises(OverflowError):
            round_to(Fraction(value), "float")
        return
    assert float(round_to(Fraction(value), "float")) == expected


@given(finite_doubles)
def test_rounding_a_double_to_double_changes_nothing(value: float) -> None:
    assert round_to(Fraction(value), "double") == Fraction(value)


@given(st.fractions(min_value=-1000, max_value=1000), st.sampled_from(["float", "double"]))
def test_literals_read_back_exactly_and_are_shortest(value: Fraction, scalar: str) -> None:
    rounded = round_to(value, scalar)
    text = shortest(rounded, scalar)
    assert round_to(Fraction(text), scalar) == rounded
    mantissa = text.partition("e")[0]
    digits = len(mantissa.replace(".", "").lstrip("-0").rstrip("0"))
    if digits > 1:
        fewer = Fraction(f"{float(rounded):.{digits - 1}g}")
        assert round_to(fewer, scalar) != rounded


@given(finite_doubles.filter(lambda v: 1e-30 < abs(v) < 1e30))
def test_a_unit_in_the_last_place_equals_the_spacing_of_numpy(value: float) -> None:
    assert 2.0 ** ulp_exponent(Fraction(value), "double") == np.spacing(abs(value))
    single = np.float32(value)
    assert 2.0 ** ulp_exponent(Fraction(float(single)), "float") == np.spacing(abs(single))


# ------------------------------------------------------------------------------------------- rounding bound


def exact_and_float(kernel: Kernel, inputs: dict[str, float]) -> tuple[list[Fraction], list[float]]:
    """Return the outputs of a kernel in fractions, and in the float32 arithmetic of a target."""
    true = {k: Fraction(v) for k, v in inputs.items()}
    single = {k: np.float32(v) for k, v in inputs.items()}
    apply = {"add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "neg": lambda a: -a}

    def value(operand, known, number):
        return known[operand.name] if isinstance(operand, Var) else number(operand.value)

    for a in kernel.body:
        assert isinstance(a.value, Op)
        true[a.var.name] = apply[a.value.name](*(value(x, true, Fraction) for x in a.value.args))
        single[a.var.name] = apply[a.value.name](*(value(x, single, lambda v: np.float32(float(v))) for x in a.value.args))
    return [value(o, true, Fraction) for o in kernel.outputs], [float(value(o, single, np.float32)) for o in kernel.outputs]


@given(st.floats(0, 1, width=32))
def test_the_rounding_bound_holds_for_the_weights(s: float) -> None:
    from stt_codegen.paper import refined_tube

    for function in (refined_tube.basis(), refined_tube.basis_rate()):
        kernel = lower(function)
        bounds = rounding_error(kernel, {"s": Inexact(Fraction(0), Fraction(1))}, "float")
        true, single = exact_and_float(kernel, {"s": s})
        for t, c, b in zip(true, single, bounds, strict=True):
            assert b.low <= t <= b.high
            assert abs(Fraction(c) - t) <= b.error
            assert b.error < Fraction(1, 2**18)  # 64 units in the last place of 1, so that the bound is not far too wide


def test_rounding_error_refuses_an_operation_without_a_bound() -> None:
    kernel = Kernel("k", (Var("x", REAL),), (Assign(Var("v0", REAL), Op("exp", (Var("x", REAL),))),), (Var("v0", REAL),), ("y",))
    with pytest.raises(NotImplementedError, match="exp"):
        rounding_error(kernel, {"x": Inexact(Fraction(0), Fraction(1))}, "float")


def test_gcc_and_clang_are_both_installed_in_ci(tool) -> None:
    assert shutil.which(tool("gcc"))
    assert shutil.which(tool("clang"))
