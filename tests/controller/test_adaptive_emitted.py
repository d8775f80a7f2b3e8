"""Emitted controllers of adaptive and literal designs: strict compilers, every function's behaviour, and the comparison of
backends with the reference."""

from __future__ import annotations

import json
import math
import subprocess
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.compare.comparison import compare
from stt_codegen.controller.adaptive_frame import adaptive_program
from stt_codegen.design.paper_tubes.adaptive_search import design_adaptive
from stt_codegen.designs import grid_tube
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import EmittedController, build
from stt_codegen.program.targets.c.printer import CPrinter
from stt_codegen.program.targets.c.runner import STRICT, CompiledC
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.task.load import load_task, parse_task
from tests.emit.test_emitted import BITS, CORTEX_M4F, symbols
from tests.support.controllers import ADAPTABLE, ROOT, build_once

OK, OUTSIDE, BAD = 0, 1, 2
KINDS = ["adaptive", "literal"]
SLOW = "omni_heading"  # slow in both kinds; other tasks are slow with a literal design, except those of the case study (omni_s..)


@cache
def controller_of_kind(name: str, kind: str, scalar: str = "float") -> EmittedController:
    """Return the controller of an example task with an adaptive or a literal design; a literal one is never certified."""
    return build(ROOT / "tasks" / f"{name}.toml", kind, scalar, uncertified=True)


@cache
def backends(kind: str) -> tuple:
    """Return the controller of omni_s2 in C with float, in C with double, and in Python."""
    return (
        CompiledC(controller_of_kind("omni_s2", kind)),
        CompiledC(controller_of_kind("omni_s2", kind, "double")),
        GeneratedPython(controller_of_kind("omni_s2", kind, "double")),
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_compilers_with_strict_flags_accept_the_emitted_c(kind: str, scalar: str, compiler: str, tool, tmp_path) -> None:
    for name in ("omni_s1", "spacecraft"):
        controller = controller_of_kind(name, kind, scalar)
        for file, data in controller.files.items():
            (tmp_path / file).write_bytes(data)
        source = tmp_path / f"{name}.c"
        subprocess.run([tool(compiler), *STRICT, "-c", str(source), "-o", str(tmp_path / "o.o")], check=True)


@pytest.mark.parametrize("kind", KINDS)
def test_a_float_file_has_no_double_arithmetic_on_a_cortex_m4f(kind: str, tool, tmp_path) -> None:
    for file, data in controller_of_kind("omni_s2", kind).files.items():
        (tmp_path / file).write_bytes(data)
    target = tmp_path / "o.o"
    command = [tool("arm-none-eabi-gcc"), *CORTEX_M4F, *STRICT, "-c", str(tmp_path / "omni_s2.c"), "-o", str(target)]
    subprocess.run(command, check=True)
    symbol_kinds = symbols(tool("arm-none-eabi-nm"), target)
    assert {n for n, k in symbol_kinds.items() if k == "U"} <= {"logf", "expf", "powf", "log1pf", "sqrtf", "memset"}
    assert not [n for n, k in symbol_kinds.items() if k in "dDbBC"]


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        pytest.param(n, k, marks=() if n != SLOW and (k == "adaptive" or n.startswith("omni_s")) else pytest.mark.slow)
        for n in ADAPTABLE
        for k in KINDS
    ],
)
def test_every_example_task_is_within_its_bounds(name: str, kind: str) -> None:
    assert not [r for r in compare(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design=kind), 500) if not r.holds]


@pytest.mark.parametrize("t_c", ["0.000001", "0.001", "900000000"])
@pytest.mark.parametrize("kind", KINDS)
def test_emitted_code_is_finite_for_every_prescribed_time(kind: str, t_c: str) -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text().replace("prescribed_time = 9.0", f"prescribed_time = {t_c}")
    controller = build_once(parse_task(text).with_options(design=kind), uncertified=True)
    random = np.random.default_rng(3)
    t = np.concatenate([random.uniform(-0.1, 1.1, 300), [0, 1]]) * float(t_c)
    alpha, x = np.abs(random.normal(0, 1, (302, 4))), random.uniform(0, 5, (302, 2))
    for backend in (CompiledC(controller), GeneratedPython(controller)):
        for function in ("tube", "tube_rate", "alpha_rate"):
            assert np.all(np.isfinite(np.stack(backend.call(function, t, alpha))))
        assert np.all(np.isfinite(backend.control(t, alpha, x)[1]))
        assert np.all(np.isfinite(backend.call("alpha_step", t, np.full(302, 1e-3 * float(t_c)), alpha)[0]))


def test_the_clamped_denominator_does_not_change_a_steep_circumvent_function() -> None:
    """The steepness is 1000; the emitted code keeps a denominator away from 0, which must not change the function."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text() + "\n[tube.adaptive]\nbump_steepness = 1000.0\n"
    assert not [r for r in compare(parse_task(text).with_options(design="literal"), 1000) if not r.holds]


@pytest.mark.parametrize("kind", ["adaptive", pytest.param("literal", marks=pytest.mark.slow)])
def test_every_backend_is_within_its_bounds(kind: str) -> None:
    rows = compare(load_task(ROOT / "tasks" / "omni_s1.toml").with_options(design=kind), 10_000)
    names = ["sigma", "rho", "beta", "psi", "theta", "alpha rate", "jacobian", "alpha step", "tube", "tube rate"]
    assert [r.quantity for r in rows] == [*names, "e", "epsilon", "xi", "u", "margin", "margins", "status"] * 4
    assert min(r.points for r in rows) >= 10_000
    assert not [r for r in rows if not r.holds]
    assert all(r.quantity == "status" or r.share > 0.05 for r in rows)


def test_joined_circumvent_functions_are_within_their_bounds_too() -> None:
    """Two bumps on one side of one dimension: the only case in which the joining kernel is emitted."""
    task = load_task(ROOT / "tasks" / "omni_s1.toml").with_options(design="literal")
    unsafe_sets = [
        unsafe.model_copy(update={"lower": lower, "upper": upper})
        for unsafe, (lower, upper) in zip(
            task.unsafe, [((1, 4), (2, 5)), ((2, 4), (3, 5)), ((1, 0), (2, 1)), ((4, 1), (5, 2))], strict=True
        )
    ]
    unsafe_sets = [
        unsafe.model_copy(update={e: tuple(Fraction(v) for v in getattr(unsafe, e)) for e in ("lower", "upper")})
        for unsafe in unsafe_sets
    ]
    task = task.model_copy(update={"unsafe": tuple(unsafe_sets)})
    assert max(build_once(task, uncertified=True).design.slots) >= 2
    assert not [r for r in compare(task, 3000) if not r.holds]


@pytest.mark.parametrize("non_finite", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("kind", KINDS)
def test_non_finite_numbers_are_bad_input_nan_or_no_step(kind: str, non_finite: float) -> None:
    for backend in backends(kind):
        good_t, good_alpha, good_x = np.array([1.0]), np.full((1, 4), 0.125), np.array([[0.5, 0.5]])
        bad_alpha = good_alpha.copy()
        bad_alpha[0, 3] = non_finite
        for t, a, x in (
            (np.array([non_finite]), good_alpha, good_x),
            (good_t, bad_alpha, good_x),
            (good_t, good_alpha, np.array([[0.5, non_finite]])),
        ):
            status, u = backend.control(t, a, x)
            assert status[0] == BAD
            assert np.all(u == 0)
        for t, a in ((np.array([non_finite]), good_alpha), (good_t, bad_alpha)):
            for function in ("tube", "tube_rate", "alpha_rate"):
                assert np.all(np.isnan(np.stack(backend.call(function, t, a))))
        for t, dt, a in (
            (np.array([non_finite]), np.array([0.1]), good_alpha),
            (good_t, np.array([non_finite]), good_alpha),
            (good_t, np.array([0.1]), bad_alpha),
        ):
            (after,) = backend.call("alpha_step", t, dt, a)
            assert np.array_equal(after, a.astype(after.dtype), equal_nan=True)


@pytest.mark.parametrize("kind", KINDS)
def test_alpha_starts_at_zero_and_takes_no_step_back_in_time(kind: str) -> None:
    for backend in backends(kind):
        alpha = np.full((1, 4), 0.25)
        for dt in (0.0, -0.0, -1.0, -1e30):
            (after,) = backend.call("alpha_step", np.array([1.0]), np.array([dt]), alpha)
            assert np.array_equal(after, alpha)
    module = GeneratedPython(controller_of_kind("omni_s2", kind)).module
    assert module.alpha_init() == (0.0, 0.0, 0.0, 0.0)
    start = (0.25,) * 4
    assert module.alpha_step(1.0, 0.01, start) != start
    assert start == (0.25,) * 4


@pytest.mark.parametrize("kind", KINDS)
def test_the_target_is_held_after_the_prescribed_time(kind: str) -> None:
    for backend in backends(kind):
        alpha = np.full((1, 4), 0.01)
        last = np.stack(backend.tube(np.array([9.0]), alpha))
        first = np.stack(backend.tube(np.array([0.0]), alpha))
        for t in (9.0001, 100.0, 1e30):
            assert np.array_equal(np.stack(backend.tube(np.array([t]), alpha)), last)
        for t in (-0.0001, -1e30):
            assert np.array_equal(np.stack(backend.tube(np.array([t]), alpha)), first)


@settings(max_examples=400, deadline=None)
@given(st.lists(BITS, min_size=8, max_size=8), st.sampled_from(KINDS))
def test_u_is_finite_and_alpha_steps_are_finite_for_every_bit_pattern(values: list[float], kind: str) -> None:
    t, dt, *state = values
    backend = backends(kind)[0]
    alpha, x = np.array([state[:4]], dtype=np.float32), np.array([state[4:]], dtype=np.float32)
    status, u = backend.control(np.array([t], dtype=np.float32), alpha, x)
    assert np.all(np.isfinite(u))
    assert (status[0] == BAD) == (not all(map(math.isfinite, [t, *state])))
    (after,) = backend.call("alpha_step", np.array([t], dtype=np.float32), np.array([dt], dtype=np.float32), alpha)
    if np.all(np.isfinite(alpha)):
        assert np.all(np.isfinite(after))


def test_the_emitted_python_follows_the_sampled_tube() -> None:
    """The emitted code steps alpha over the whole mission by the rule and the step with which the tube was checked."""
    controller = controller_of_kind("omni_s1", "adaptive", "double")
    module = GeneratedPython(controller).module
    t, _, gamma, _ = grid_tube(controller.design, 1800)
    alpha = module.alpha_init()
    worst = 0.0
    for k in range(1800):
        alpha = module.alpha_step(t[k], t[k + 1] - t[k], alpha)
        low, high = module.tube(t[k + 1], alpha)
        worst = max(worst, np.abs(np.array([low, high]).T - gamma[k + 1]).max())
    # t[k] + dt is t[k + 1] up to a rounding, which a bump of 50 units/s turns into 1e-13; kappa damps it afterwards.
    assert worst < 1e-11


def test_a_literal_tube_needs_uncertified_and_its_files_say_not_certified() -> None:
    with pytest.raises(NotCertified, match=r"not shown: .* \(.* is missing\)"):
        build(ROOT / "tasks" / "omni_s2.toml", "literal")
    files = controller_of_kind("omni_s2", "literal").files
    assert all(b"NOT CERTIFIED" in files[f"omni_s2.{e}"] for e in ("h", "c", "py"))
    document = json.loads(files["omni_s2.certificate.json"])
    assert document["certified"] is False
    assert document["method"] == "sampled"
    assert "seed" in document["parameters"]


def test_an_adaptive_tube_has_a_certificate_and_names_the_steps_that_it_is_proved_for() -> None:
    files = build(ROOT / "tasks" / "omni_s2.toml", "adaptive").files
    document = json.loads(files["omni_s2.certificate.json"])
    assert document["certified"] is True
    assert document["method"] == "enclosure"
    shortest, longest = document["alpha_steps"]
    assert f"#define OMNI_S2_DT_SHORTEST {shortest}F" in files["omni_s2.h"].decode()
    assert f"every dt from {shortest} to {longest} s" in files["omni_s2.py"].decode()
    assert all(p["holds"] and p["margin"] >= p["required"] for p in document["claims"])


def test_the_refusal_of_a_literal_tube_names_its_violations() -> None:
    with pytest.raises(NotCertified) as refusal:
        build(ROOT / "tasks" / "omni_s2.toml", "literal")
    for word in ("width (P1) at t =", "avoid (P4) at t in", "unsafe set O3", "reach (P5)"):
        assert word in str(refusal.value)


def test_a_thousand_circumvent_functions_lengthen_a_table_and_no_code() -> None:
    task = load_task(ROOT / "tasks" / "omni_s1.toml").with_options(design="adaptive")
    design = design_adaptive(task)
    line_counts = []
    for count in (2, 1000):
        design_with_bumps = replace(design, bumps=design.bumps[:1] * count)
        program = adaptive_program(task, design_with_bumps)
        printer = CPrinter(program)
        line_counts.append(
            sum(len(printer.function(f)) for f in program.functions) + sum(len(printer.kernel(k)) for k in program.kernels)
        )
        assert len(program.table("bumps").values) == 2 * count * 4  # all bumps are on one side; the other side has no rows
    assert line_counts[0] == line_counts[1]


@pytest.mark.parametrize("width", [1e-9, 1e-7, 9e-7, 2e-6, 1e-3])
def test_e_has_the_sign_of_the_side_however_narrow_the_tube(width: float) -> None:
    for backend in backends("adaptive"):
        for share in (-1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 2.0, 50.0):
            x = np.array([[share * width, share * width]])
            e, epsilon, _ = backend.transform(np.zeros((1, 2)), np.full((1, 2), width), x)
            side = np.sign(share - 0.5)
            assert (np.sign(e) * side >= 0).all()
            assert (np.sign(epsilon) * side >= 0).all()
            assert share != 0.5 or (np.abs(e) < 1e-3).all()
