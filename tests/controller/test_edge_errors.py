"""P7, arithmetic: the bound on rounding in the emitted code holds where rounding is worst, and is not far above it."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from stt_codegen.certify.exact import certify_refined
from stt_codegen.certify.slack import units_above
from stt_codegen.controller.edge_errors import edge_error, spline_time_error
from stt_codegen.decimals import above, below
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_program, certify
from stt_codegen.task.load import load_task
from tests.certify.test_certificate import exact_edges
from tests.support.controllers import ROOT, controller_of


def steep_design(segments: int, t_c: Fraction = Fraction(9)) -> RefinedDesign:
    """Return a design that is as steep as its table can be: neighbouring control points jump by its full height."""
    random = np.random.default_rng(segments)
    table = random.integers(-(2**23), 2**23, (segments + 3, 2, 2))
    table[-1] = table[-3]
    return RefinedDesign(t_c, segments, 20, tuple(tuple((int(a), int(b)) for a, b in row) for row in table))


def float32_segment(t: np.float32, design: RefinedDesign) -> tuple[int, np.float32, np.float32]:
    """Return segment, local time s and spline time u, computed like the emitted code, one float32 operation at a time."""
    rate = np.float32(float(design.segments / design.prescribed_time))
    end = np.nextafter(np.float32(design.segments), np.float32(0))
    u = (t if t > 0 else np.float32(0)) * rate
    u = u if u < end else end
    segment = int(u)
    return segment, u - np.float32(segment), u


def hard_times(design: RefinedDesign) -> list[np.float32]:
    """Return times at, just below and just above the ends of all segments, and 500 random ones."""
    t_c = float(design.prescribed_time)
    ends_of_segments = [np.float32(k * t_c / design.segments) for k in range(design.segments + 1)]
    just_above, just_below = ([np.nextafter(v, np.float32(s)) for v in ends_of_segments] for s in (1e9, -1e9))
    return [
        *ends_of_segments,
        *just_above,
        *just_below,
        *np.random.default_rng(1).uniform(0, t_c * 1.0001, 500).astype(np.float32),
    ]


@pytest.mark.parametrize("segments", [4, 32, 1000])
@pytest.mark.parametrize("t_c", [Fraction(9), Fraction("0.7"), Fraction(1, 3)])
def test_the_error_of_the_spline_time_is_between_a_tenth_of_its_bound_and_the_bound(segments: int, t_c: Fraction) -> None:
    design = steep_design(segments, t_c)
    bound = spline_time_error(design, "float")
    worst = Fraction(0)
    for t in hard_times(design):
        true = min(max(Fraction(float(t)), Fraction(0)), t_c) * segments / t_c
        worst = max(worst, abs(Fraction(float(float32_segment(t, design)[2])) - true))
    assert bound / 10 <= worst <= bound


@pytest.mark.parametrize("segments", [4, 1000])
def test_the_error_of_the_steepest_edge_is_between_a_fortieth_of_its_bound_and_the_bound(segments: int) -> None:
    """With 1000 segments the bound is mostly about the time; with 4 segments the rounding of the evaluation counts too."""
    design = steep_design(segments)
    task = task_for(design)
    bound = edge_error(design, build_program(task, design))
    worst = [Fraction(0)] * 2
    unit = np.float32(float(design.unit))
    for t in hard_times(design)[-900:]:
        k, s, _ = float32_segment(t, design)
        r = np.float32(1) - s
        h = np.float32(3) * (np.float32(1) + r * s)
        w = [r * r * r, np.float32(1) + r * h, np.float32(1) + s * h, s * s * s]
        u = min(max(Fraction(float(t)), Fraction(0)), design.prescribed_time) * segments / design.prescribed_time
        cell = min(math.floor(u), segments - 1)
        true = exact_edges(design, cell, u - cell)
        for i in range(2):
            for side in (0, 1):
                q = [np.float32(design.table[k + j][i][side]) * unit for j in range(4)]
                got = (w[0] * q[0] + w[1] * q[1]) + (w[2] * q[2] + w[3] * q[3])
                worst[i] = max(worst[i], abs(Fraction(float(got)) - true[i][side]))
    for i in range(2):
        assert bound[i] / 40 <= worst[i] <= bound[i]


def task_for(design: RefinedDesign):
    """Return the task omni_s2 with the design's prescribed time."""
    return load_task(ROOT / "tasks" / "omni_s2.toml").model_copy(update={"prescribed_time": design.prescribed_time})


def test_bounds_of_the_task_are_rounded_to_the_safe_side_of_the_grid() -> None:
    unit = Fraction(1, 8)
    for value in (Fraction("0.3"), Fraction("-0.3"), Fraction("0.25")):
        assert value <= units_above(value, unit) * unit < value + unit
    assert units_above(Fraction("0.3"), unit) == 3
    assert units_above(Fraction("-0.3"), unit) == -2


def test_a_state_space_less_than_a_unit_too_small_is_refused() -> None:
    """The upper wall is one unit above the tube and its rounding error, which holds, then half a unit below that limit."""
    controller = controller_of("omni_s1")
    design, error = controller.design, controller.certificate.edge_error
    highest = tuple(int(v) * design.unit + max(error) for v in design.bezier()[:, :, 1].max(axis=(0, 2)))
    unit = design.unit
    for shift, holds in ((unit, True), (-unit / 2, False)):
        space = controller.task.state_space.model_copy(update={"upper": tuple(v + shift for v in highest)})
        task = controller.task.model_copy(update={"state_space": space})
        finding = next(f for f in certify_refined(task, design, error).findings if f.code == "P3")
        assert finding.holds == holds


def test_the_required_margin_is_that_of_the_dimension_with_the_largest_error() -> None:
    controller = controller_of("omni_s1")
    unit = controller.design.unit  # errors count in whole units of the table
    small, large = Fraction(1, 10**9), math.ceil(Fraction(1, 100) / unit) * unit
    for error in ((small, large), (large, small)):
        certificate = certify_refined(controller.task, controller.design, error)
        assert all(f.required in (large, 2 * large) for f in certificate.findings if f.required)
        assert not certificate.holds


def test_the_fastest_dimension_decides_about_max_speed() -> None:
    controller = controller_of("spacecraft")
    low, high = min(controller.certificate.speed), max(controller.certificate.speed)
    for limit, holds in (((low + high) / 2, False), (high, True)):
        tube = controller.task.tube.model_copy(update={"max_speed": limit})
        task = controller.task.model_copy(update={"tube": tube})
        certificate = certify_refined(task, controller.design, controller.certificate.edge_error)
        assert next(f for f in certificate.findings if f.code == "P6").holds == holds


def test_p7_is_the_smallest_difference_of_margin_and_required_margin() -> None:
    controller = controller_of("omni_s2", "float")
    *findings, p7 = certify(controller.task, controller.design, controller.program).findings
    assert p7.code == "P7"
    assert p7.margin == min(f.margin - f.required for f in findings if f.required)


def test_the_start_box_is_claimed_as_covered_only_where_the_tube_contains_it() -> None:
    controller = controller_of("omni_s1")
    assert controller.certificate.covers_initial_set
    wider = controller.task.initial_set.model_copy(update={"upper": (Fraction("0.51"), Fraction(5))})
    task = controller.task.model_copy(update={"initial_set": wider})
    assert not certify_refined(task, controller.design, controller.certificate.edge_error).covers_initial_set


@pytest.mark.parametrize(("scalar", "bits"), [("float", 24), ("double", 50)])
def test_a_coefficient_of_more_bits_than_the_scalar_holds_is_not_emitted(scalar: str, bits: int) -> None:
    controller = controller_of("omni_s1")
    task = controller.task.with_options(scalar=scalar)

    def build_with(largest: int) -> object:
        return build_program(task, replace(controller.design, table=(((0, largest),) * 2, *controller.design.table[1:])))

    build_with((1 << bits) - 1)
    with pytest.raises((BadInput, ValueError), match="bits"):
        build_with(1 << bits)


@pytest.mark.parametrize("value", [Fraction(1, 3), Fraction("0.000123456789"), Fraction(-2, 3), Fraction(5)])
def test_printed_bounds_are_on_the_safe_side(value: Fraction) -> None:
    for digits in (2, 6):
        assert Fraction(str(below(value, digits))) <= value <= Fraction(str(above(value, digits)))
