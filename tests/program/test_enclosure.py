"""Ball arithmetic over the Program, the curves that bound alpha, and the certificates made of them."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from flint import arb
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from stt_codegen.certify.adaptive.alpha_curves import Curve
from stt_codegen.certify.adaptive.enclosure import (
    certify_enclosed,
    edge_rounding,
    enclose_alpha,
    enclose_edges,
    enclose_lines,
    steps_of,
)
from stt_codegen.certify.adaptive.falsification import falsify
from stt_codegen.certify.adaptive.lines import HIGH, LOW, LineBounds
from stt_codegen.certify.adaptive.slopes import speed_bound, steepest_slope
from stt_codegen.controller.probes import lines_program
from stt_codegen.designs import grid_tube
from stt_codegen.designs.adaptive import AdaptiveDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.analyse.ball_arithmetic import _Span, ball, hull
from stt_codegen.program.analyse.balls import Enclosure
from stt_codegen.program.build import Block
from stt_codegen.program.nodes import Const, Function, Kernel, Load, Param, Program, Status, Var, integer, real
from stt_codegen.program.number import FORMATS
from stt_codegen.program.operations import REAL, STATUS
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task
from tests.program.test_program import BANK, points_of
from tests.support.bank import kernel_of, one_function_program, run_c
from tests.support.controllers import ADAPTABLE, NAMES, ROOT, build_once

RANDOM = np.random.default_rng(4)


@cache
def emitted_controller(name: str, design: str, scalar: str = "float") -> EmittedController:
    return build_once(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design, scalar))


@cache
def enclosed(name: str, scalar: str = "float", division: int = 2000) -> tuple[LineBounds, np.ndarray, np.ndarray]:
    """Return enclosures of lines, alpha and gamma of a task's adaptive tube."""
    controller = emitted_controller(name, "adaptive", scalar)
    task, design = controller.task, controller.design
    assert isinstance(design, AdaptiveDesign)
    program = lines_program(task, design)
    exact = Enclosure(program, rounding=False)
    lines = enclose_lines(design, Enclosure(program, rounding=True), 1.0)
    alpha = enclose_alpha(design, exact, lines, steps_of(design, scalar, division))
    return lines, alpha, enclose_edges(task, design, exact, lines, alpha)[0]


# ------------------------------------------------------------------------------------------ balls


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", BANK)
def test_balls_contain_the_values_of_the_compiled_c(name: str, scalar: str, tool, tmp_path) -> None:
    build_, domain, _ = BANK[name]
    count = build_.__code__.co_argcount
    program = one_function_program(kernel_of(name, build_, count)[0], scalar)
    run, balls = run_c(program, tool("gcc"), tmp_path), Enclosure(program, rounding=True)
    real = np.float32 if scalar == "float" else np.float64
    for point in points_of(domain, count):
        x = [float(real(v)) for v in point]
        (value,) = run(x)
        ball_of_point = balls.run("f", x=[arb(v) for v in x])[0]["y"][0]
        assert ball_of_point.contains(value), (x, value, ball_of_point)
        intervals = [hull(v - abs(v) / 8, v + abs(v) / 16) for v in x]
        wide = balls.run("f", x=intervals)[0]["y"][0]
        assert wide.contains(value) or not wide.is_finite(), (x, value, wide)


@pytest.mark.parametrize("name", ["sin", "exp", "fmax", "if_else", "sign", "tanh", "div", "constpow"])
def test_the_ball_of_a_wider_interval_contains_that_of_a_narrower_one(name: str) -> None:
    build_, domain, _ = BANK[name]
    count = build_.__code__.co_argcount
    balls = Enclosure(one_function_program(kernel_of(name, build_, count)[0], "double"), rounding=False)
    for point in points_of(domain, count):
        (inner,) = balls.run("f", x=[hull(v - 0.01, v + 0.01) for v in point])[0]["y"]
        (outer,) = balls.run("f", x=[hull(v - 0.3, v + 0.2) for v in point])[0]["y"]
        if outer.is_finite():
            assert inner.is_finite()
            assert float(outer.lower()) <= float(inner.lower()) + 1e-12
            assert float(inner.upper()) <= float(outer.upper()) + 1e-12


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", NAMES)
def test_balls_contain_outputs_and_status_of_the_refined_controller(name: str, scalar: str) -> None:
    """The controller has every node: finite tests, early return, truncation, loads from a table, loops with carried values."""
    controller = emitted_controller(name, "refined", scalar)
    c, balls, n = CompiledC(controller), Enclosure(controller.program, rounding=True), controller.design.dimension
    t = RANDOM.uniform(-1, float(controller.task.prescribed_time) * 1.2, 60).astype(c.number)
    x = RANDOM.uniform(-0.5, 5.5, (60, n)).astype(c.number)
    status, u = c.control(t, x)
    low, high = c.tube(t)
    margin = c.margin(t, x)
    for k in range(60):
        for spread in (0.0, 0.2):
            time = hull(float(t[k]) - spread, float(t[k]) + spread)
            out, statuses = balls.run("control", t=time, x=[arb(float(v)) for v in x[k]])
            assert status[k] in {s.value for s in statuses}
            assert all(b.contains(float(v)) or not b.is_finite() for b, v in zip(out["u"], u[k], strict=True))
            _, share = balls.run("margin", t=time, x=[arb(float(v)) for v in x[k]])
            assert share.contains(float(margin[k])) or not share.is_finite()
            edges, _ = balls.run("tube", t=time)
            for name_, values in (("lower", low), ("upper", high)):
                assert all(b.contains(float(v)) for b, v in zip(edges[name_], values[k], strict=True))
    assert all(b.rad() < 1e-4 for b in balls.run("tube", t=arb(float(t[0])))[0]["lower"])


def test_an_undecided_return_joins_the_results_of_both_paths() -> None:
    block = Block({"x", "y"})
    x = block.let("x_0", Load("x", integer(0)))
    with block.leave_when(block.op("small", "lt", x, real(1)), Const(Status.BAD_INPUT, STATUS)):
        block.store("y", integer(0), real(-5))
    block.store("y", integer(0), x)
    block.leave(Const(Status.OK, STATUS))
    f = Function("f", (Param("x", 1), Param("y", 1, True)), tuple(block.statements), True)
    balls = Enclosure(Program("bank", 1, "double", (), (), functions=(f,)), rounding=False)
    for low, high, values, expected in (
        (0.0, 0.5, (-5,), {Status.BAD_INPUT}),
        (1.5, 2.0, (1.5, 2), {Status.OK}),
        (0.0, 2.0, (-5, 2), {Status.OK, Status.BAD_INPUT}),
    ):
        out, statuses = balls.run("f", x=[hull(low, high)])
        assert statuses == expected
        assert all(out["y"][0].contains(v) for v in values)
        assert len(statuses) == 2 or not out["y"][0].contains(-5 if Status.OK in statuses else 1.75)


# -------------------------------------------------------------------------------------- alpha and gamma


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", ["omni_s1", "omni_s2", "omni_s3", "spacecraft"])
def test_alpha_and_tube_of_any_sequence_of_emitted_steps_are_enclosed(name: str, scalar: str) -> None:
    controller, (lines, alpha, gamma) = emitted_controller(name, "adaptive", scalar), enclosed(name, scalar)
    design = controller.design
    assert isinstance(design, AdaptiveDesign)
    c, n, t_c = CompiledC(controller), design.dimension, float(design.prescribed_time)
    steps = steps_of(design, scalar, 2000)
    short, long = float(steps.shortest), float(steps.longest)
    for kind in ("longest", "shortest", "random", "both"):
        t, alpha_now = c.number(0), np.zeros((1, 2 * n), dtype=c.number)
        while t < 1.02 * t_c:
            cell = min(int(np.searchsorted(lines.times, float(t), side="right")) - 1, len(lines.times) - 1)
            bound = alpha[cell].transpose(1, 0, 2).reshape(2 * n, 2)
            assert (bound[:, LOW] <= alpha_now[0]).all(), (kind, t)
            assert (alpha_now[0] <= bound[:, HIGH]).all(), (kind, t)
            low, high = c.tube(np.array([t]), alpha_now)
            assert (gamma[cell, :, 0, LOW] <= low[0]).all(), (kind, t)
            assert (low[0] <= gamma[cell, :, 0, HIGH]).all(), (kind, t)
            assert (gamma[cell, :, 1, LOW] <= high[0]).all(), (kind, t)
            assert (high[0] <= gamma[cell, :, 1, HIGH]).all(), (kind, t)
            h = {"longest": long, "shortest": short, "random": RANDOM.uniform(short, long)}.get(
                kind, RANDOM.choice([short, long])
            )
            dt = min(max(c.number(h), c.number(short)), c.number(long))
            (alpha_now,) = c.call("alpha_step", np.array([t]), np.array([dt]), alpha_now)
            t = c.number(t + dt)
            if kind == "shortest" and t > t_c / 10:
                break


def test_the_enclosures_are_narrow() -> None:
    """A measurement, not a law: gamma is known to a tenth of the start's width, except where alpha does not matter."""
    _, _, gamma = enclosed("omni_s2", division=8000)
    assert np.median(gamma[..., HIGH] - gamma[..., LOW]) < 0.005
    assert (gamma[:, :, 1, LOW] - gamma[:, :, 0, HIGH]).min() > 0.15


@given(p=st.floats(-1e3, 1e3), q=st.floats(1e-30, 1e3), side=st.sampled_from([-1, 1]))
def test_the_root_of_the_implicit_step_is_bounded_on_the_right_side(p: float, q: float, side: int) -> None:
    z, opposite = (Fraction(Curve(v, 0.0, 1.0, 1.0, 1.0).root(p, q)) for v in (side, -side))
    value = (z - Fraction(p)) * z * z - Fraction(q)
    assert value * side >= 0
    assert abs(z - opposite) <= z * Fraction(1, 10**6) or q < 1e-25


@pytest.mark.parametrize("name", ["omni_s1", "omni_s2", "spacecraft"])
def test_the_speed_bound_is_above_the_speed(name: str) -> None:
    controller, (lines, alpha, _) = emitted_controller(name, "adaptive"), enclosed(name)
    task, design = controller.task, controller.design
    assert isinstance(design, AdaptiveDesign)
    exact = Enclosure(lines_program(task, design), rounding=False)
    speed = np.abs(grid_tube(design, 20000)[3]).max(axis=(0, 2))
    assert (speed <= speed_bound(task, design, exact, lines, alpha)).all()
    for bump in design.bumps:
        t = np.linspace(0.0, float(bump.radius) * 0.9999, 5000)
        b, k, r = (float(v) for v in (bump.height, bump.steepness, bump.radius))
        value = b * np.exp(-k * t**2 / (r**2 - t**2))
        slope = np.abs(np.diff(value)).max() / (t[1] - t[0])
        assert slope <= steepest_slope(bump, "float", exact) <= 1.1 * slope


@pytest.mark.parametrize("nu", [20, 300])
def test_the_emitted_edge_is_within_its_rounding_bound(nu: int) -> None:
    """The emitted kernel in balls with roundings is compared with the exact edge for the same rho, alpha and beta."""
    controller = emitted_controller("omni_s2", "adaptive")
    design = controller.design
    assert isinstance(design, AdaptiveDesign)
    design = replace(design, nu=Fraction(nu))
    program = lines_program(controller.task, design)
    printed, exact = Enclosure(program, rounding=True), Enclosure(program, rounding=False)
    error = float(edge_rounding(controller.task, design, exact))
    for rho, alpha, beta in RANDOM.uniform([0, 0, 0], [5, 8, 5], (200, 3)):
        for name in ("lower_edge", "upper_edge"):
            inputs = [arb(v) for v in (rho, alpha, beta)] + [ball(nu)]
            emitted, true = printed.kernel(name, *inputs)[0], exact.kernel(name, *inputs)[0]
            assert float(abs(emitted - true).upper()) <= error


# --------------------------------------------------------------------------------------- certificates


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", ADAPTABLE)
def test_every_example_task_has_a_certified_adaptive_controller(name: str, scalar: str) -> None:
    certificate = emitted_controller(name, "adaptive", scalar).certificate
    assert certificate.holds
    assert certificate.method == "enclosure"
    text = emitted_controller(name, "adaptive", scalar).files[f"{name}.h"].decode()
    assert "NOT CERTIFIED" not in text
    assert f"#define {name.upper()}_DT_LONGEST" in text


def with_one_change(design: AdaptiveDesign, which: int, how: str, amount: Fraction) -> AdaptiveDesign:
    """The design with one number changed."""
    if how in ("theta0", "kappa", "nu", "varsigma"):
        return replace(design, **{how: getattr(design, how) * (1 + amount)})
    if how == "target":
        (a, b), *rest = design.target
        return replace(design, target=((a - amount / 10, b - amount / 10), *rest))
    bumps = list(design.bumps)
    bump = bumps[which % len(bumps)]
    changed = {
        "height": {"height": bump.height * (1 - amount)},
        "middle": {"middle": bump.middle + amount},
        "radius": {"radius": bump.radius * (1 - amount / 2)},
        "steepness": {"steepness": bump.steepness * (1 + 4 * amount)},
    }
    bumps[which % len(bumps)] = replace(bump, **changed[how])
    return replace(design, bumps=tuple(bumps))


CHANGES = ("theta0", "kappa", "nu", "varsigma", "target", "height", "middle", "radius", "steepness")


@pytest.mark.slow
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(
    name=st.sampled_from(["omni_s1", "omni_s2", "omni_s3"]),
    which=st.integers(0, 3),
    how=st.sampled_from(CHANGES),
    amount=st.fractions(0, Fraction(9, 10), max_denominator=64),
)
def test_a_property_that_fails_at_samples_is_never_proved(name: str, which: int, how: str, amount: Fraction) -> None:
    controller = emitted_controller(name, "adaptive")
    assert isinstance(controller.design, AdaptiveDesign)
    design = with_one_change(controller.design, which, how, amount)
    failing = {f.code for f in falsify(controller.task, design).failures}
    assume(failing)
    assert failing <= {f.code for f in certify_enclosed(controller.task, design).failures}


def test_proved_margins_are_below_those_at_samples() -> None:
    for name in ("omni_s1", "omni_s3", "spacecraft"):
        controller = emitted_controller(name, "adaptive")
        task, design = controller.task, controller.design
        assert isinstance(design, AdaptiveDesign)
        at_samples = {(f.code, f.statement[:9]): f.margin for f in falsify(task, design).findings if f.code <= "P5"}
        for f in controller.certificate.findings:
            if f.code <= "P5":
                assert f.margin <= at_samples[f.code, f.statement[:9]] + Fraction(1, 10**6), f


def test_a_clearance_beyond_the_margin_is_refused() -> None:
    """With a clearance larger by less than the margin of P4 the property holds; with a much larger one it does not."""
    controller = emitted_controller("omni_s1", "adaptive")
    task = controller.task
    assert isinstance(controller.design, AdaptiveDesign)
    margin = next(f.margin for f in controller.certificate.findings if f.code == "P4")
    for increase, holds in ((margin * Fraction(99, 100), True), (Fraction(2, 10), False)):
        certificate = certify_enclosed(with_more_clearance(task, increase), controller.design)
        assert all(f.holds for f in certificate.findings if f.code == "P4") == holds


def with_more_clearance(task: Task, increase: Fraction) -> Task:
    return task.model_copy(update={"tube": task.tube.model_copy(update={"clearance": task.tube.clearance + increase})})


def test_a_literal_tube_is_refused_by_failures_at_samples() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml").with_options("literal")
    controller = build_once(task, uncertified=True)
    assert controller.certificate.method == "sampled"
    assert {"P1", "P4", "P5"} <= {f.code for f in controller.certificate.failures}


@pytest.mark.parametrize("offset", [0, 300, 3000])
def test_the_start_in_the_certificate_is_a_box_around_the_initial_state(offset: int) -> None:
    """Its edges are rounded inward by a share of its width, not of the coordinate, so that it works far from the origin."""
    text = (ROOT / "tasks" / "omni_s1.toml").read_text()
    lists = re.sub(r"\[([-\d., ]+)\]", lambda m: str([float(v) + offset for v in m.group(1).split(",")]), text)
    task = parse_task(lists).with_options("adaptive", "double")
    controller = build_once(task)
    document = json.loads(controller.files["omni_s1.certificate.json"])
    for low, x, high, (a, b) in zip(
        document["start"]["lower"], task.initial_state, document["start"]["upper"], controller.certificate.start, strict=True
    ):
        assert a <= Fraction(low) < x < Fraction(high) <= b
        assert Fraction(high) - Fraction(low) >= (b - a) * Fraction(998, 1000)


def test_extreme_parameters_are_refused_or_certified_without_a_defect() -> None:
    text = (ROOT / "tasks" / "omni_s1.toml").read_text()
    for name, value in (
        ("nu", "100000.0"),
        ("varsigma", "1000000.0"),
        ("kappa", "0.001"),
        ("theta0", "1000000.0"),
        ("mu", "0.5"),
    ):
        task = parse_task(f"{text}\n[tube.adaptive]\n{name} = {value}\n").with_options("adaptive")
        try:
            assert build_once(task).certificate.holds
        except NotCertified as error:
            assert re.match(r"\w+ \(P\d+\)|holds at samples", str(error))


@settings(max_examples=200, deadline=None)
@given(st.floats(0.7072, 1e30), st.floats(1.0, 4.0), st.lists(st.floats(0, 1), min_size=20, max_size=20))
def test_balls_of_exponent_and_mantissa_contain_those_of_every_number_inside(
    low: float, factor: float, shares: list[float]
) -> None:
    block = Block({"y"})
    y = Var("y", REAL)
    e, m = block.op("base", "real", block.op("e", "exponent", y)), block.op("m", "mantissa", y)
    kernel = Kernel("split", (y,), tuple(block.statements), (e, m), ("e", "m"))  # type: ignore[arg-type]
    balls = Enclosure(Program("p", 1, "double", (), (kernel,), functions=()), rounding=False)
    exponents, mantissas = balls.kernel("split", hull(low, low * factor))
    for share in shares:
        number = low + (low * factor - low) * share
        fraction, power = math.frexp(number)
        fraction, power = (
            (fraction, power) if fraction >= float(FORMATS["double"].smallest_mantissa) else (2 * fraction, power - 1)
        )
        assert exponents.contains(power)
        assert mantissas.contains(fraction)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 12_000), st.integers(0, 4_000), st.lists(st.floats(0, 1), min_size=20, max_size=20))
def test_the_tick_kernel_over_a_span_contains_every_tick_in_it(first: int, length: int, shares: list[float]) -> None:
    balls = Enclosure(emitted_controller("omni_board", "refined", "double").program, rounding=True)
    rows, segment_positions = balls.kernel("segment_at_tick", _Span(first, first + length) if length else first)
    low, high = (rows, rows) if isinstance(rows, int) else (rows.low, rows.high)
    for share in shares:
        row, segment_position = balls.kernel("segment_at_tick", first + round(share * length))
        assert low <= row <= high
        assert segment_positions.contains(segment_position)
