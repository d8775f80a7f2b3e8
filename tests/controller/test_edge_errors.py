"""P7: the bound on the emitted arithmetic holds where it is hardest, and says something."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from stt_codegen.certify.exact import certify_refined
from stt_codegen.certify.slack import units_above
from stt_codegen.controller.edge_errors import edge_error, time_error
from stt_codegen.decimals import above, below
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_program, certify
from stt_codegen.task.load import load_task
from tests.certify.test_certificate import exact_edges
from tests.support.controllers import controller_of


def steep_design(segments: int, t_c: Fraction = Fraction(9)) -> RefinedDesign:
    """A tube as steep as a table of full height allows: control points jump between both ends from point to point."""
    random = np.random.default_rng(segments)
    table = random.integers(-(2**23), 2**23, (segments + 3, 2, 2))
    table[-1] = table[-3]
    return RefinedDesign(t_c, segments, 20, tuple(tuple((int(a), int(b)) for a, b in row) for row in table))


def float32_place(t: np.float32, design: RefinedDesign) -> tuple[int, np.float32, np.float32]:
    """Segment, place s and spline time u, computed as the emitted code does, one float32 operation at a time."""
    rate = np.float32(float(design.segments / design.prescribed_time))
    end = np.nextafter(np.float32(design.segments), np.float32(0))
    u = (t if t > 0 else np.float32(0)) * rate
    u = u if u < end else end
    segment = int(u)
    return segment, u - np.float32(segment), u


def hard_times(design: RefinedDesign) -> list[np.float32]:
    t_c = float(design.prescribed_time)
    near = [np.float32(k * t_c / design.segments) for k in range(design.segments + 1)]
    up, down = ([np.nextafter(v, np.float32(s)) for v in near] for s in (1e9, -1e9))
    return [*near, *up, *down, *np.random.default_rng(1).uniform(0, t_c * 1.0001, 500).astype(np.float32)]


@pytest.mark.parametrize("segments", [4, 32, 1000])
@pytest.mark.parametrize("t_c", [Fraction(9), Fraction("0.7"), Fraction(1, 3)])
def test_the_spline_time_is_within_its_bound_and_uses_a_tenth_of_it(segments: int, t_c: Fraction) -> None:
    design = steep_design(segments, t_c)
    bound = time_error(design, "float")
    worst = Fraction(0)
    for t in hard_times(design):
        true = min(max(Fraction(float(t)), Fraction(0)), t_c) * segments / t_c
        worst = max(worst, abs(Fraction(float(float32_place(t, design)[2])) - true))
    assert bound / 10 <= worst <= bound


@pytest.mark.parametrize("segments", [4, 1000])
def test_the_edge_of_the_steepest_tube_is_within_its_bound_and_says_something(segments: int) -> None:
    """With 1000 segments the time half of the bound is 50 times the other, with 4 the evaluation half counts too."""
    design = steep_design(segments)
    task = load_task_of(design)
    bound = edge_error(design, build_program(task, design))
    worst = [Fraction(0)] * 2
    unit = np.float32(float(design.unit))
    for t in hard_times(design)[-900:]:
        k, s, _ = float32_place(t, design)
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


def load_task_of(design: RefinedDesign):
    from tests.support.controllers import ROOT

    return load_task(ROOT / "tasks" / "omni_s2.toml").model_copy(update={"prescribed_time": design.prescribed_time})


def test_bounds_of_the_task_are_rounded_to_the_safe_side_of_the_grid() -> None:
    unit = Fraction(1, 8)
    for value in (Fraction("0.3"), Fraction("-0.3"), Fraction("0.25")):
        assert value <= units_above(value, unit) * unit < value + unit
    assert units_above(Fraction("0.3"), unit) == 3
    assert units_above(Fraction("-0.3"), unit) == -2


def test_a_state_space_less_than_a_unit_too_small_is_refused() -> None:
    """The upper wall is put exactly where the tube touches it with P7's margin, then half a grid unit lower."""
    controller = controller_of("omni_s1")
    design, error = controller.design, controller.certificate.edge_error
    top = tuple(int(v) * design.unit + max(error) for v in design.bezier()[:, :, 1].max(axis=(0, 2)))
    unit = design.unit
    for shift, holds in ((unit, True), (-unit / 2, False)):
        space = controller.task.state_space.model_copy(update={"upper": tuple(v + shift for v in top)})
        task = controller.task.model_copy(update={"state_space": space})
        finding = next(f for f in certify_refined(task, design, error).findings if f.code == "P3")
        assert finding.holds == holds


def test_the_margin_demanded_is_the_worst_dimensions() -> None:
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
        found = certify_refined(task, controller.design, controller.certificate.edge_error)
        assert next(f for f in found.findings if f.code == "P6").holds == holds


def test_p7_is_the_least_room_above_what_is_required() -> None:
    controller = controller_of("omni_s2", "float")
    *others, p7 = certify(controller.task, controller.design, controller.program).findings
    assert p7.code == "P7"
    assert p7.margin == min(f.margin - f.required for f in others if f.required)


def test_the_whole_start_is_claimed_only_where_it_is_covered() -> None:
    controller = controller_of("omni_s1")
    assert controller.certificate.covers_initial_set
    wider = controller.task.initial_set.model_copy(update={"upper": (Fraction("0.51"), Fraction(5))})
    task = controller.task.model_copy(update={"initial_set": wider})
    assert not certify_refined(task, controller.design, controller.certificate.edge_error).covers_initial_set


@pytest.mark.parametrize(("scalar", "bits"), [("float", 24), ("double", 50)])
def test_a_coefficient_of_more_bits_than_the_scalar_holds_is_not_emitted(scalar: str, bits: int) -> None:
    made = controller_of("omni_s1")
    task = made.task.with_options(scalar=scalar)

    def program(largest: int) -> object:
        return build_program(task, replace(made.design, table=(((0, largest),) * 2, *made.design.table[1:])))

    program((1 << bits) - 1)
    with pytest.raises((BadInput, ValueError), match="bits"):
        program(1 << bits)


@pytest.mark.parametrize("value", [Fraction(1, 3), Fraction("0.000123456789"), Fraction(-2, 3), Fraction(5)])
def test_printed_bounds_are_on_the_safe_side(value: Fraction) -> None:
    for digits in (2, 6):
        assert Fraction(str(below(value, digits))) <= value <= Fraction(str(above(value, digits)))
