"""The emitted adaptive and literal controllers: strict compilers, behaviour of every function, and the comparison."""

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
from tests.support.controllers import ADAPTABLE, ROOT, built

OK, OUTSIDE, BAD = 0, 1, 2
KINDS = ["adaptive", "literal"]
SLOW = "omni_heading"  # in both kinds; of the others the literal one, but for the case study


@cache
def made(name: str, kind: str, scalar: str = "float") -> EmittedController:
    return build(ROOT / "tasks" / f"{name}.toml", kind, scalar, uncertified=True)


@cache
def backends(kind: str) -> tuple:
    return (
        CompiledC(made("omni_s2", kind)),
        CompiledC(made("omni_s2", kind, "double")),
        GeneratedPython(made("omni_s2", kind, "double")),
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_strict_flags_find_nothing(kind: str, scalar: str, compiler: str, tool, tmp_path) -> None:
    for name in ("omni_s1", "spacecraft"):
        controller = made(name, kind, scalar)
        for file, data in controller.files.items():
            (tmp_path / file).write_bytes(data)
        source = tmp_path / f"{name}.c"
        subprocess.run([tool(compiler), *STRICT, "-c", str(source), "-o", str(tmp_path / "o.o")], check=True)


@pytest.mark.parametrize("kind", KINDS)
def test_a_float_file_has_no_double_arithmetic_on_a_cortex_m4f(kind: str, tool, tmp_path) -> None:
    for file, data in made("omni_s2", kind).files.items():
        (tmp_path / file).write_bytes(data)
    target = tmp_path / "o.o"
    command = [tool("arm-none-eabi-gcc"), *CORTEX_M4F, *STRICT, "-c", str(tmp_path / "omni_s2.c"), "-o", str(target)]
    subprocess.run(command, check=True)
    found = symbols(tool("arm-none-eabi-nm"), target)
    assert {n for n, k in found.items() if k == "U"} <= {"logf", "expf", "powf", "log1pf", "sqrtf", "memset"}
    assert not [n for n, k in found.items() if k in "dDbBC"]


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
    controller = built(parse_task(text).with_options(design=kind), uncertified=True)
    random = np.random.default_rng(3)
    t = np.concatenate([random.uniform(-0.1, 1.1, 300), [0, 1]]) * float(t_c)
    alpha, x = np.abs(random.normal(0, 1, (302, 4))), random.uniform(0, 5, (302, 2))
    for backend in (CompiledC(controller), GeneratedPython(controller)):
        for function in ("tube", "tube_rate", "alpha_rate"):
            assert np.all(np.isfinite(np.stack(backend.call(function, t, alpha))))
        assert np.all(np.isfinite(backend.control(t, alpha, x)[1]))
        assert np.all(np.isfinite(backend.call("alpha_step", t, np.full(302, 1e-3 * float(t_c)), alpha)[0]))


def test_a_steep_circumvent_function_is_emitted_as_it_is() -> None:
    """k = 1000: the hold of the denominator must not change the function."""
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
    sets = [
        s.model_copy(update={"lower": lower, "upper": upper})
        for s, (lower, upper) in zip(
            task.unsafe, [((1, 4), (2, 5)), ((2, 4), (3, 5)), ((1, 0), (2, 1)), ((4, 1), (5, 2))], strict=True
        )
    ]
    sets = [s.model_copy(update={e: tuple(Fraction(v) for v in getattr(s, e)) for e in ("lower", "upper")}) for s in sets]
    task = task.model_copy(update={"unsafe": tuple(sets)})
    assert max(built(task, uncertified=True).design.slots) >= 2
    assert not [r for r in compare(task, 3000) if not r.holds]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("kind", KINDS)
def test_non_finite_numbers_are_bad_input_nan_or_no_step(kind: str, bad: float) -> None:
    for backend in backends(kind):
        good_t, good_a, good_x = np.array([1.0]), np.full((1, 4), 0.125), np.array([[0.5, 0.5]])
        spoiled = good_a.copy()
        spoiled[0, 3] = bad
        for t, a, x in ((np.array([bad]), good_a, good_x), (good_t, spoiled, good_x), (good_t, good_a, np.array([[0.5, bad]]))):
            status, u = backend.control(t, a, x)
            assert status[0] == BAD
            assert np.all(u == 0)
        for t, a in ((np.array([bad]), good_a), (good_t, spoiled)):
            for function in ("tube", "tube_rate", "alpha_rate"):
                assert np.all(np.isnan(np.stack(backend.call(function, t, a))))
        for t, dt, a in (
            (np.array([bad]), np.array([0.1]), good_a),
            (good_t, np.array([bad]), good_a),
            (good_t, np.array([0.1]), spoiled),
        ):
            (after,) = backend.call("alpha_step", t, dt, a)
            assert np.array_equal(after, a.astype(after.dtype), equal_nan=True)


@pytest.mark.parametrize("kind", KINDS)
def test_alpha_starts_at_zero_and_no_step_is_made_backward(kind: str) -> None:
    for backend in backends(kind):
        alpha = np.full((1, 4), 0.25)
        for dt in (0.0, -0.0, -1.0, -1e30):
            (after,) = backend.call("alpha_step", np.array([1.0]), np.array([dt]), alpha)
            assert np.array_equal(after, alpha)
    module = GeneratedPython(made("omni_s2", kind)).module
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
    t, dt, *alpha_x = values
    backend = backends(kind)[0]
    alpha, x = np.array([alpha_x[:4]], dtype=np.float32), np.array([alpha_x[4:]], dtype=np.float32)
    status, u = backend.control(np.array([t], dtype=np.float32), alpha, x)
    assert np.all(np.isfinite(u))
    assert (status[0] == BAD) == (not all(map(math.isfinite, [t, *alpha_x])))
    (after,) = backend.call("alpha_step", np.array([t], dtype=np.float32), np.array([dt], dtype=np.float32), alpha)
    if np.all(np.isfinite(alpha)):
        assert np.all(np.isfinite(after))


def test_the_emitted_python_follows_the_sampled_tube() -> None:
    """alpha stepped on the target's side, over the whole mission, gives the tube that was checked: same rule, same step."""
    controller = made("omni_s1", "adaptive", "double")
    module = GeneratedPython(controller).module
    t, _, gamma, _ = grid_tube(controller.design, 1800)
    now = module.alpha_init()
    worst = 0.0
    for k in range(1800):
        now = module.alpha_step(t[k], t[k + 1] - t[k], now)
        low, high = module.tube(t[k + 1], now)
        worst = max(worst, np.abs(np.array([low, high]).T - gamma[k + 1]).max())
    # t[k] + dt is t[k + 1] to a rounding, which a bump of 50 units/s turns into 1e-13, damped by kappa afterwards
    assert worst < 1e-11


def test_a_literal_tube_is_refused_without_uncertified_and_bannered_with_it() -> None:
    with pytest.raises(NotCertified, match="--uncertified"):
        build(ROOT / "tasks" / "omni_s2.toml", "literal")
    files = made("omni_s2", "literal").files
    assert all(b"NOT CERTIFIED" in files[f"omni_s2.{e}"] for e in ("h", "c", "py"))
    document = json.loads(files["omni_s2.certificate.json"])
    assert document["certified"] is False
    assert document["method"] == "sampled"
    assert "seed" in document["parameters"]


def test_an_adaptive_tube_is_written_with_its_certificate_and_the_steps_it_holds_for() -> None:
    files = build(ROOT / "tasks" / "omni_s2.toml", "adaptive").files
    document = json.loads(files["omni_s2.certificate.json"])
    assert document["certified"] is True
    assert document["method"] == "enclosure"
    shortest, longest = document["alpha_steps"]
    assert f"#define OMNI_S2_DT_SHORTEST {shortest}F" in files["omni_s2.h"].decode()
    assert f"every dt from {shortest} to {longest} s" in files["omni_s2.py"].decode()
    assert all(p["holds"] and p["margin"] >= p["required"] for p in document["claims"])


def test_the_refusal_of_a_literal_tube_says_what_it_does() -> None:
    with pytest.raises(NotCertified) as caught:
        build(ROOT / "tasks" / "omni_s2.toml", "literal")
    for word in ("width (P1) at t =", "avoid (P4) at t in", "unsafe set O3", "reach (P5)"):
        assert word in str(caught.value)


def test_a_thousand_circumvent_functions_add_rows_and_no_code() -> None:
    task = load_task(ROOT / "tasks" / "omni_s1.toml").with_options(design="adaptive")
    design = design_adaptive(task)
    lines = []
    for count in (2, 1000):
        many = replace(design, bumps=design.bumps[:1] * count)
        program = adaptive_program(task, many)
        printer = CPrinter(program)
        lines.append(
            sum(len(printer.function(f)) for f in program.functions) + sum(len(printer.kernel(k)) for k in program.kernels)
        )
        assert len(program.table("bumps").values) == 2 * count * 4  # one side only: the other has no rows and costs nothing
    assert lines[0] == lines[1]


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
