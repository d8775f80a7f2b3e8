"""`math = "inline"`: the inline logarithm keeps its bound for every mantissa, in C and Python, and links no library."""

from __future__ import annotations

import math
import subprocess
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from stt_codegen.controller.kernels.logarithm import C, approximation_error, inline_logarithm_error, with_inline_logarithm
from stt_codegen.errors import BadInput
from stt_codegen.paper import control_law
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.convert.from_casadi import lower
from stt_codegen.program.number import FORMATS
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.task.load import parse_task
from tests.support.controllers import ROOT, build_once

TASK = (ROOT / "tasks" / "omni_s2.toml").read_text()


def inline(scalar: str = "float", more: str = "") -> EmittedController:
    return build_once(parse_task(TASK + f'\n[emit]\nmath = "inline"\nscalar = "{scalar}"\n{more}'))


def emitted_log(y: np.ndarray) -> np.ndarray:
    """Return the logarithm by the emitted statements, one float32 operation at a time."""
    bits = y.view(np.uint32) - np.uint32(0x3F3504F3)
    e = (bits >> np.uint32(23)).astype(np.float32)
    m = ((bits & np.uint32(0x7FFFFF)) + np.uint32(0x3F3504F3)).view(np.float32)
    unity, two = np.float32(1), np.float32(2)
    s = (m - unity) / (m + unity)
    return e * np.float32(math.log(2)) + s * (s * s * np.float32(float(C)) + two)


@pytest.mark.parametrize("exponent", [0, 1, 2, 7])
def test_the_bound_holds_for_every_mantissa_and_is_nearly_reached(exponent: int) -> None:
    """The test takes all 2^23 numbers of an octave. Near 1, where rounding is small, 95 % of the bound is reached."""
    first = np.array([2.0**exponent], np.float32).view(np.uint32)[0]
    y = np.arange(first, first + (1 << 23), dtype=np.uint32).view(np.float32)
    true = np.log(y.astype(np.float64))
    largest_error = np.max(np.abs(emitted_log(y) - true) / np.maximum(true, 1e-300))
    bound = float(inline_logarithm_error("float"))
    assert largest_error <= bound
    assert exponent > 0 or largest_error >= 0.95 * bound


def test_the_bound_holds_just_below_one() -> None:
    y = np.float32(1) - np.arange(1, 64, dtype=np.float32) * np.float32(2**-24)
    true = np.log(y.astype(np.float64))
    assert np.all(np.abs(emitted_log(y) - true) <= float(inline_logarithm_error("float")) * np.abs(true))


def test_balls_confirm_the_approximation_error() -> None:
    """Arb computes atanh by its logarithm, over pieces of s."""
    bound, largest_error = float(approximation_error()), 0.0
    pieces = 4000
    end = float(2**0.5 - 1) / (2**0.5 + 1) * (1 + 1e-9)
    for k in range(1, pieces):
        s = arb(end * (k + 0.5) / pieces, end * 0.5 / pieces)
        z = s * s  # relative error: 1 - s (2 + C z) / (2 atanh s); by its derivative in s, first-order around the middle
        middle = arb(end * (k + 0.5) / pieces)
        error = 1 - middle * (2 + arb(float(C)) * middle * middle) / (((1 + middle) / (1 - middle)).log())
        slope = abs(2 * s * (arb(float(C)) - arb(2) / 3)) + 4 * s * z  # more than the derivative's size on so small s
        largest_error = max(largest_error, float((abs(error) + slope * end / pieces).upper()))
    assert largest_error <= bound * 1.02
    assert largest_error >= bound * 0.95


def test_the_emitted_c_computes_the_statements_tested_here(tool, tmp_path) -> None:
    """epsilon of `transform` equals `emitted_log` bit for bit over two octaves."""
    tool("cc")
    c = CompiledC(inline())
    near = np.linspace(0.2, 0.5, 20_000, dtype=np.float32)
    x = np.stack([near, near], axis=1)
    _, epsilon, _ = c.transform(np.zeros_like(x), np.ones_like(x), x)
    far = np.float32(1) - near
    assert np.array_equal(epsilon[:, 0], -emitted_log(far / near))


def test_mantissas_from_one_half_on_would_break_the_bound() -> None:
    y = np.linspace(1, 200, 10001).astype(np.float32)
    true = np.log(y.astype(np.float64))
    bits = y.view(np.uint32) - np.uint32(0x3F000000)  # mantissas from 1/2 on
    e = (bits >> np.uint32(23)).astype(np.float64)
    m = y / 2.0**e
    s = (m - 1) / (m + 1)
    assert np.max(np.abs(e * math.log(2) + s * (2 + float(C) * s * s) - true)) > 10 * float(inline_logarithm_error("float"))


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_c_and_python_stay_within_the_bound_of_the_library_version(scalar: str) -> None:
    with_inline, with_library = inline(scalar), build_once(parse_task(TASK).with_options(scalar=scalar))
    random = np.random.default_rng(3)
    number = np.float32 if scalar == "float" else np.float64
    t, x = random.uniform(0, 9, 2000).astype(number), random.uniform(0, 5, (2000, 2)).astype(number)
    delta = float(inline_logarithm_error(scalar)) + 16 * float(FORMATS[scalar].roundoff)  # plus twice 8 roundings of the law
    _, expected = CompiledC(with_library).control(t, x)
    for backend in (CompiledC(with_inline), GeneratedPython(with_inline)):
        status, u = backend.control(t, x)
        if isinstance(backend, CompiledC) or scalar == "double":
            assert np.all(np.abs(u.astype(float) - expected) <= delta * np.abs(expected) + 1e-30)
        else:  # Python in double against C in float: the edges differ by roundings too
            inside = status == 0
            assert np.max(np.abs(u - expected)[inside] / np.maximum(1, np.abs(expected[inside]))) < 1e-3
        assert np.array_equal(status, CompiledC(with_library).control(t, x)[0])


def test_no_function_of_the_library_is_called(tool, tmp_path) -> None:
    for name, data in inline().files.items():
        (tmp_path / name).write_bytes(data)
    command = [tool("gcc"), "-std=c99", "-O2", "-c", "omni_s2.c", "-o", "a.o"]
    subprocess.run(command, cwd=tmp_path, check=True)
    undefined = subprocess.run([tool("nm"), "-u", "a.o"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    names = {line.split()[-1] for line in undefined.splitlines()}
    assert names <= {"__stack_chk_fail", "memcpy"}


def test_only_logarithms_are_replaced_by_inline_statements() -> None:
    kernel = lower(control_law.transformed_error())
    inlined = with_inline_logarithm(kernel)
    names = [getattr(a.value, "name", "") for a in inlined.body]
    assert "log" not in names
    assert names.count("exponent") == names.count("mantissa") == 1
    assert [a for a in kernel.body if getattr(a.value, "name", "") != "log"] == [a for a in inlined.body if a in kernel.body]
    assert kernel.outputs == inlined.outputs


@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_designs_that_need_exp_refuse_inline_mathematics(design: str) -> None:
    task = parse_task(TASK + '\n[emit]\nmath = "inline"\n').with_options(design)
    with pytest.raises(BadInput, match=f"emit.math.*{design} ones need exp"):
        build_once(task, uncertified=True)


def test_the_stated_bound_is_the_one_in_the_kernels_comment() -> None:
    assert inline_logarithm_error("float") < Fraction(1, 1 << 14)
    assert "below 2^-14" in " ".join(with_inline_logarithm(lower(control_law.transformed_error())).doc)
