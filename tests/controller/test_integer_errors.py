"""The errors of edges and rates of controllers in integers: closed bounds, derived from the kernels that are printed."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from stt_codegen.checker.stt_checker import integers as checked_integers
from stt_codegen.checker.stt_checker.task import Task as CheckedTask
from stt_codegen.checker.stt_checker.tube import Tube
from stt_codegen.controller.integers import certified_constants, integer_errors
from stt_codegen.controller.integers.integer_kernels import (
    HALF_WORD,
    build_integer_segment_kernel,
    build_rate_weights_kernel,
    build_weights_kernel,
    choose_clock,
    choose_rate_scale,
)
from stt_codegen.task.map.map_table import to_toml
from stt_codegen.task.task import document_of
from tests.controller.test_fixed import SHAPES, design_of, limited_controller
from tests.support.integer_kernels import derived_rate_weight_error, derived_weight_error, evaluate_kernel


@pytest.mark.parametrize("name", ["omni_s2", "courier", "crane"])
def test_the_spline_time_of_a_tick_is_within_its_error(name: str) -> None:
    task, design = limited_controller(name).task, design_of(name)
    period = task.emit.tick_period or Fraction(1)
    clock = choose_clock(design, period)
    kernel = build_integer_segment_kernel(clock, design)
    ticks = np.arange(0, clock.end_tick + 3, dtype=np.int64)
    first_entries, shares = evaluate_kernel(kernel, {"tick": ticks})
    bound = integer_errors.segment_position_error(clock)
    for tick, entry, share in zip(ticks.tolist(), first_entries.tolist(), shares.tolist(), strict=True):
        exact_time = min(Fraction(tick) * period * design.segments / design.prescribed_time, Fraction(design.segments))
        assert abs(Fraction(entry, 2 * design.dimension) + Fraction(share, HALF_WORD) - exact_time) <= bound


def test_rates_are_the_slopes_of_the_weights() -> None:
    """The outer weights are (1 - s)^3 and s^3, the middle one is 3 s + 3 s^2 - 2 s^3; rates are in segments a second."""
    design = design_of("crane")
    per_second = Fraction(design.segments) / design.prescribed_time
    rate = choose_rate_scale(design)
    s = np.arange(0, HALF_WORD, 64, dtype=np.int64)
    computed = evaluate_kernel(build_rate_weights_kernel(rate), {"s": s})
    x = s / HALF_WORD
    exact_rates = [3 * (1 - x) ** 2, 3 + 6 * x - 6 * x**2, 3 * x**2]
    bound = float(integer_errors.rate_weight_error(rate, per_second))
    error = sum(
        np.abs(w * 2.0**-rate.weight_bits - exact * float(per_second)) for w, exact in zip(computed, exact_rates, strict=True)
    )
    assert error.max() <= bound  # type: ignore[union-attr]
    w0, w1, w2 = (w.astype(float) for w in evaluate_kernel(build_weights_kernel(), {"s": s}))
    assert np.abs(w0 * 2.0**-15 - (1 - x) ** 3).max() <= 2.0**-15
    assert np.abs(w1 * 2.0**-14 - (3 * x + 3 * x**2 - 2 * x**3)).max() <= 2.0**-14
    assert np.abs(w2 * 2.0**-15 - x**3).max() <= 2.0**-15


def test_the_constant_of_the_weights_of_an_edge_is_derived_from_the_kernel() -> None:
    assert derived_weight_error() == integer_errors.WEIGHT_ERROR == checked_integers.WEIGHT_ERROR
    assert integer_errors.RATE_POWER_ERROR == checked_integers.RATE_POWER_ERROR


@pytest.mark.parametrize("prescribed_time", ["0.2", "1", "3", "7.77", "60", "1024", "86399.5"])
@pytest.mark.parametrize("segments", [5, 32, 1000])
def test_the_bound_of_the_weights_of_a_rate_covers_the_kernels_and_is_not_far_larger(segments: int, prescribed_time: str) -> None:
    table = design_of("crane").table
    design = replace(design_of("crane"), table=(table * 100)[: segments + 3], segments=segments)
    design = replace(design, prescribed_time=Fraction(prescribed_time))
    per_second = Fraction(segments) / design.prescribed_time
    rate_scale = choose_rate_scale(design)
    derived = derived_rate_weight_error(rate_scale, per_second)
    assert derived <= integer_errors.rate_weight_error(rate_scale, per_second) <= 2 * derived
    if per_second * 2**rate_scale.shift != rate_scale.mantissa:  # a mantissa that is another number is seen
        other_scale = replace(rate_scale, mantissa=rate_scale.mantissa - 2)
        assert derived_rate_weight_error(other_scale, per_second) > integer_errors.rate_weight_error(rate_scale, per_second)


@pytest.mark.parametrize("name", SHAPES)
def test_the_checker_computes_the_same_errors(name: str) -> None:
    """Else a claim could be a unit smaller than what the checker computes."""
    controller, design = limited_controller(name), design_of(name)
    task = CheckedTask(to_toml(document_of(controller.task.as_stated)).encode())
    assert controller.program.tick is not None
    constants = certified_constants(controller.task, design)
    target = checked_integers.Integers(controller.files[f"{name}.c"], task, constants)
    entries = [v * design.unit for v in target.tables["coefficients"]]
    tube = Tube(entries, task.n, design.unit, task.t_c, None)
    target.check_clock(tube)
    assert tuple(target.arithmetic_error(tube, 20)) == integer_errors.edge_error(design, controller.program.tick)
    if design.filter:
        assert tuple(target.arithmetic_error(tube, 20, 1)) == integer_errors.rate_error(design, controller.program.tick)
