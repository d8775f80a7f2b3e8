"""Helpers of the expression bank, whose tests print every node and operation as a small program and run it (tests/program)."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from stt_codegen.program.build import Block
from stt_codegen.program.convert.from_casadi import lower
from stt_codegen.program.nodes import Function, Kernel, Load, Operand, Param, Program, integer
from stt_codegen.program.targets.c.printer import CPrinter
from stt_codegen.program.targets.c.runner import STRICT
from stt_codegen.program.targets.python.printer import PythonPrinter
from stt_codegen.program.targets.python.runner import load_module


def one_function_program(kernel: Kernel, scalar: str) -> Program:
    """Return a program whose only function `f(x) -> y` calls the kernel on the entries of x."""
    block = Block({"x", "y"})
    args: list[Operand] = [block.let(f"x_{k}", Load("x", integer(k))) for k in range(len(kernel.inputs))]
    results = block.call(kernel, *args, names=[f"y_{k}" for k in range(len(kernel.outputs))])
    for k, result in enumerate(results):
        block.store("y", integer(k), result)
    block.leave()
    f = Function("f", (Param("x", len(kernel.inputs)), Param("y", len(kernel.outputs), True)), tuple(block.statements), False)
    return Program("bank", 1, scalar, (), (kernel,), functions=(f,))


def run_python(program: Program, name: str = "f") -> Callable[..., Any]:
    """Print the program in Python, load it, and return its function of this name."""
    printer = PythonPrinter(program)
    lines = ["import math", "", "def _vector(name, values, length):", "    return [float(v) for v in values]", ""]
    for table in program.tables:
        lines += printer.table(table)
    for kernel in program.kernels:
        lines += printer.kernel(kernel)
    for function in program.functions:
        lines += printer.function(function)
    return getattr(load_module("bank", "\n".join(lines).encode()), name)


def run_c(program: Program, compiler: str, folder: Path) -> Callable[[Sequence[float]], list[float]]:
    """Print the program in C, compile it with the strict flags, and return its function `f` from an array to a list."""
    printer = CPrinter(program)
    n_in, n_out = (program.functions[0].params[k].length or 0 for k in (0, 1))
    lines = [
        "#include <math.h>",
        "#include <stdbool.h>",
        "#include <stdint.h>",
        f"typedef {program.scalar} bank_real;",
        "#define BANK_N 1",
    ]
    for function in program.functions:
        lines += printer.prototype(function)
    for kernel in program.kernels:
        lines += printer.kernel(kernel)
    for function in program.functions:
        lines += printer.function(function)
    source, library = folder / f"bank_{program.scalar}.c", folder / f"bank_{program.scalar}.so"
    source.write_text("\n".join(lines) + "\n")
    subprocess.run([compiler, *STRICT, "-shared", "-fPIC", "-o", str(library), str(source), "-lm"], check=True)
    real: Any = ctypes.c_float if program.scalar == "float" else ctypes.c_double
    call = ctypes.CDLL(str(library)).bank_f

    def f(x: Sequence[float]) -> list[float]:
        inputs, result = (real * n_in)(*x), (real * n_out)()
        call(inputs, result)
        return list(result)

    return f


def kernel_of(name: str, build: Callable[..., ca.SX], count: int) -> tuple[Kernel, ca.Function]:
    """Return `build(x0, x1, ...)`, a CasADi expression of `count` symbols, lowered to a kernel and as a CasADi function."""
    symbols = [ca.SX.sym(f"x{k}") for k in range(count)]
    function = ca.Function(name, symbols, [build(*symbols)], [f"x{k}" for k in range(count)], ["y"])
    return lower(function), function


def unit_in_last_place(value: float, scalar: str) -> float:
    """Return the distance from |value| to the next number of the scalar type."""
    return float(np.spacing(np.float32(abs(value)) if scalar == "float" else np.float64(abs(value))))
