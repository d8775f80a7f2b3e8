"""Controllers in integers alone: nothing leaves 32 bits, C and Python compute the same, edges and law are what they stand for."""

from __future__ import annotations

import ctypes
import math
import subprocess
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import pytest
from conftest import ROOT
from fixed import c_files, limited, points, python_module
from stt_codegen.controller.fixed import clock_of, fixed_program, law_of
from stt_codegen.controller.fixed_kernels import LN2, reciprocal_kernel

from stt_codegen.compare.toolchain import STRICT
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_task
from stt_codegen.program import Assign, Kernel, Op, Program, integer
from stt_codegen.program.ranges import OutOfRange, Span, ranges
from stt_codegen.task import Task, load_task

SHAPES = ("omni_s2", "trolley", "courier", "crawler")


@cache
def made(name: str) -> tuple[Task, RefinedDesign, Program]:
    task = limited(name)
    design = build_task(load_task(ROOT / "tasks" / f"{name}.toml")).design
    assert isinstance(design, RefinedDesign)
    return task, design, fixed_program(task, design)


def points_of(name: str, count: int, seed: int = 1) -> list[tuple[int, list[int]]]:
    task, design, program = made(name)
    return points(task, design, python_module(program), count, seed)


def c_of(program: Program, compiler: str, folder: Path) -> ctypes.CDLL:
    """With the strict flags, and every undefined behaviour an end."""
    for name, data in c_files(program).items():
        (folder / name).write_bytes(data)
    source, library = folder / f"{program.prefix}.c", folder / "fixed.so"
    checks = ("-fsanitize=undefined", "-fno-sanitize-recover=all")
    subprocess.run([compiler, *STRICT, *checks, "-shared", "-fPIC", "-O2", "-o", library, source], check=True)
    return ctypes.CDLL(str(library))


@pytest.mark.parametrize("name", SHAPES)
def test_nothing_leaves_32_bits_for_any_input(name: str) -> None:
    task, _, program = made(name)
    laws, _ = law_of(task, 20)
    assert set(ranges(program, "tube")) >= {"lower", "upper"}
    most = max(law.most for law in laws)
    assert ranges(program, "control")["u"] == Span(-most, most)


def changed(kernel: Kernel, name: str, **to: int) -> Kernel:
    """The kernel with the constants of one assignment changed."""
    body = [
        Assign(a.var, Op(a.value.name, (a.value.args[0], integer(to["by"])))) if a.var.name == name else a  # type: ignore[union-attr]
        for a in kernel.body
    ]
    assert body != list(kernel.body)
    return replace(kernel, body=tuple(body))


@pytest.mark.parametrize(
    ("kernel", "name", "by", "told"),
    [
        ("edge", "q1_6", 6000, "q1_6 may be"),  # beyond 32 bits
        ("parts", "far_high", 14, "not within 16 bits"),  # a factor of 17 bits
        ("parts", "product_high", 13, r"seeds\[.*\] of 128"),  # beyond its table
        ("push", "whole", 100 * LN2, "whole may be"),
        ("segment", "segment", 21, r"coefficients\[.*\] of"),
    ],
)
def test_what_may_leave_them_is_found(kernel: str, name: str, by: int, told: str) -> None:
    program = made("omni_s2")[2]
    kernels = tuple(changed(k, name, by=by) if k.name == kernel else k for k in program.kernels)
    with pytest.raises(OutOfRange, match=told):
        ranges(replace(program, kernels=kernels), "control")


@pytest.mark.parametrize("name", SHAPES)
def test_c_and_python_are_the_same_to_the_bit(name: str, tool, tmp_path) -> None:
    task, _, program = made(name)
    library, python, array = c_of(program, tool("gcc"), tmp_path), python_module(program), ctypes.c_int32 * task.dimension
    control, tube = (getattr(library, f"{program.prefix}_{f}") for f in ("control", "tube"))
    for tick, x in points_of(name, 2000):
        lower, upper, u = array(), array(), array()
        tube(ctypes.c_uint32(tick), lower, upper)
        status = control(ctypes.c_uint32(tick), array(*x), u)
        assert (list(lower), list(upper)) == tuple(map(list, python.tube(tick)))
        assert (status, tuple(u)) == python.control(tick, x)


def exact_edges(design: RefinedDesign, t: Fraction) -> list[list[Fraction]]:
    """Lower and upper edges in the table's units."""
    place = min(max(t, Fraction(0)), design.prescribed_time) * design.segments / design.prescribed_time
    k = min(int(place), design.segments - 1)
    s = place - k
    weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    table = design.integers()
    sides = range(table.shape[2])
    return [[sum(w * int(table[k + j, i, side]) for j, w in enumerate(weights)) for i in range(table.shape[1])] for side in sides]


@pytest.mark.parametrize("name", SHAPES)
def test_edges_and_law_are_what_they_stand_for(name: str) -> None:
    """Edges: the place is late by the rounding of a tick's length, of the count's product, of the end and of s, and moves an edge by
    no more than 6 times the largest step of the table a segment; three products are rounded down. The law, of the edges as they
    are: within 2^-12.4, and 2^-17.5 of xi about the middle, which is as measured and not derived."""
    task, design, program = made(name)
    python, period = python_module(program), task.emit.tick_period or Fraction(1)
    _, u_bits = law_of(task, design.bits)
    table = design.integers()
    clock = clock_of(design, period)
    late = Fraction(clock.last, 2 ** (clock.bits + 17)) + Fraction(2, 2**clock.bits) + Fraction(1, 2**16)  # segments
    most = 6 * int(abs(table[1:] - table[:-1]).max()) * late + 3  # units
    for tick, x in points_of(name, 1500, seed=2):
        low, high = python.tube(tick)
        for mine, true in zip((low, high), exact_edges(design, min(tick, 2**31) * period), strict=True):
            assert all(abs(a - b) <= most for a, b in zip(mine, true, strict=True))
        status, u = python.control(tick, x)
        assert status == (not all(a < v < b for a, v, b in zip(low, x, high, strict=True)))
        for i, (a, b) in enumerate((v - lo, hi - v) for v, lo, hi in zip(x, low, high, strict=True)):
            near, room, unit = min(a, b), a + b, 2.0**-u_bits
            if near <= 0.0051 * room:
                assert u[i] * (1 if a < b else -1) >= 0  # outside it points inward
                continue
            xi = float(abs(task.gain[i])) * 2.0**design.bits * room / (a * b)
            true = min(xi * abs(math.log(a / b)), float((task.u_max or ())[i]))
            assert abs(abs(u[i]) * unit - true) <= 2**-12.4 * true + 2**-17.5 * xi + 2 * unit
            assert u[i] * (b - a) >= 0


def test_a_reciprocal_of_16_bits_is_right_for_each() -> None:
    r = python_module(made("omni_s2")[2])._reciprocal
    assert reciprocal_kernel() in made("omni_s2")[2].kernels
    assert max(abs(r(d) * d - 2**31) for d in range(2**15, 2**16)) <= 2**31 * 2**-14.5


def test_what_has_no_such_program_is_refused() -> None:
    task, design, _ = made("omni_s2")
    with pytest.raises(BadInput, match=r"control\.u_max: a controller in integers counts u"):
        fixed_program(task.model_copy(update={"control": task.control.model_copy(update={"u_max": None})}), design)
    with pytest.raises(BadInput, match=r"needs emit\.tick_period"):
        fixed_program(task.model_copy(update={"emit": task.emit.model_copy(update={"tick_period": None})}), design)
    with pytest.raises(BadInput, match="beyond 31 bits"):
        clock_of(design, Fraction(1, 10**9))
