"""`emit.tick_period`: integer time is exact over the whole mission, agrees with seconds, and a period that does not fit is refused."""

from __future__ import annotations

import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen import reference
from stt_codegen.controller.ticks import INTEGER_LIMIT, tick_constants
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.task.load import parse_task
from tests.support.controllers import ROOT, build_once

TASK = (ROOT / "tasks" / "omni_s2.toml").read_text()
DAY = TASK.replace("prescribed_time = 9.0", "prescribed_time = 86400.0")


def controller_with_ticks(text: str, period: str, more: str = "") -> EmittedController:
    """Return the controller of a task file's text with this tick period in seconds, and more lines of [emit]."""
    return build_once(parse_task(f"{text}\n[emit]\ntick_period = {period}\n{more}"))


def small_design(segments: int, t_c: Fraction) -> RefinedDesign:
    """Return a constant tube of this many segments and this prescribed time."""
    return RefinedDesign(t_c, segments, 20, (((0, 1), (0, 1)),) * (segments + 3))


@settings(max_examples=300)
@given(
    st.integers(4, 1024),
    st.fractions(Fraction(1, 100), 100_000, max_denominator=1000),
    st.fractions(Fraction(1, 100_000), 10, max_denominator=100_000),
    st.integers(0, 2**32 - 1),
)
def test_segment_and_rest_are_the_exact_spline_time_of_every_tick(
    segments: int, t_c: Fraction, period: Fraction, tick: int
) -> None:
    """The test computes like the kernel: no product exceeds 31 bits, and segment + rest/denominator is the spline time."""
    try:
        ticks = tick_constants(small_design(segments, t_c), period)
    except BadInput:
        return
    assert (ticks.end_tick - 1) * period < t_c <= ticks.end_tick * period
    for count in {tick, tick % (ticks.end_tick + 2), 0, ticks.end_tick - 1, ticks.end_tick}:
        passed = min(count, ticks.end_tick) * ticks.numerator
        assert passed < INTEGER_LIMIT
        position = min(passed, segments * ticks.denominator)
        segment = min(position // ticks.denominator, segments - 1)
        rest = position - segment * ticks.denominator
        assert 0 <= rest <= ticks.denominator
        assert segment + Fraction(rest, ticks.denominator) == min(count * period, t_c) * segments / t_c


@pytest.mark.parametrize("period", ["0.7", "0.001", "13"])
def test_the_spline_time_stays_at_its_end_where_the_period_does_not_divide_t_c(period: str) -> None:
    """The last tick is after t_c, for example with 0.7 s and 9 s."""
    controller = controller_with_ticks(TASK, period)
    kernel = GeneratedPython(controller).module._segment_at_tick
    assert isinstance(controller.design, RefinedDesign)
    last = tick_constants(controller.design, Fraction(period)).end_tick
    for tick in (0, 1, last - 1, last, last + 1, 2**32 - 1):
        row, s = kernel(tick)
        spline_time = min(tick * Fraction(period), controller.design.prescribed_time) * controller.design.segments
        spline_time /= controller.design.prescribed_time
        assert 0 <= s <= 1
        assert abs(row // 4 + Fraction(s) - spline_time) <= Fraction(1, 1 << 40)


def test_ticks_and_seconds_agree_where_both_are_exact() -> None:
    """With a period of 2^-10 s float seconds are exact; then both times agree up to the rounding of segments/t_c."""
    controller = controller_with_ticks(TASK, "0.0009765625")
    ticks = np.random.default_rng(0).integers(0, 10_000, 3000)
    t = (ticks * 2.0**-10).astype(np.float32)
    c = CompiledC(controller)
    edges = c.tube(t)
    share = np.random.default_rng(1).uniform(-0.25, 1.25, (3000, 2))
    x = (edges[0] + share * (edges[1] - edges[0])).astype(np.float32)
    status, u = c.call("control", t, x)
    status_tick, u_tick = c.call("control_tick", ticks, x)
    low, high = c.tube(t)
    is_off_the_edges = (np.minimum(np.abs(x - low), np.abs(high - x)) > 1e-5).all(axis=1)
    assert np.array_equal(status[is_off_the_edges], status_tick[is_off_the_edges])
    inside = status == 0
    assert np.max(np.abs(u - u_tick)[inside] / np.maximum(np.abs(u[inside]), 1.0)) < 1e-2
    assert 300 < inside.sum() < 2700


def test_after_a_day_every_tick_still_changes_u_and_float_seconds_do_not() -> None:
    """One millisecond at the end of 86,400 s is below half a unit in the last place of a float."""
    controller = controller_with_ticks(DAY, "0.001")
    c, design = CompiledC(controller), controller.design
    assert isinstance(design, RefinedDesign)
    ticks = 60_000_000 + np.arange(16)
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, ticks * np.longdouble("0.001"))
    x = np.tile((0.8 * low + 0.2 * high).mean(axis=0), (16, 1)).astype(np.float32)
    _, by_tick = c.call("control_tick", ticks, x)
    _, by_second = c.call("control", (ticks * 0.001).astype(np.float32), x)
    _, exact_u = reference.control(low, high, x, controller.task.gain, controller.task.e_max)
    assert len({tuple(u) for u in by_second.tolist()}) < len({tuple(u) for u in by_tick.tolist()})
    assert np.max(np.abs(by_tick - exact_u) / np.abs(exact_u)) < 1e-4


def test_after_the_last_tick_the_tube_stays_as_it_is() -> None:
    controller = controller_with_ticks(TASK, "0.007")
    c = CompiledC(controller)
    last = tick_constants(controller.design, Fraction("0.007")).end_tick  # type: ignore[arg-type]
    x = np.full((4, 2), 4.75, np.float32)
    status, u = c.call("control_tick", np.array([last, last + 1, 2**31, 2**32 - 1]), x)
    assert (u == u[0]).all()
    assert (status == 0).all()


def test_python_takes_whole_numbers_and_refuses_others() -> None:
    module = GeneratedPython(controller_with_ticks(TASK, "0.001")).module
    assert module.control_tick(9000, (4.75, 4.75))[0] == module.OK
    assert pytest.approx(0.001) == module.TICK_PERIOD
    for wrong in (-1, 0.5, 2**32):
        with pytest.raises(ValueError, match="tick is"):
            module.control_tick(wrong, (4.75, 4.75))


@pytest.mark.parametrize(
    ("t_c", "period"), [("9.0", "1e-9"), ("9.0", "0.00033333333"), ("86400.0", "0.0000099999"), ("86400.0", "0.00099999")]
)
def test_a_period_that_does_not_fit_names_one_that_does(t_c: str, period: str) -> None:
    design = small_design(32, Fraction(t_c))
    with pytest.raises(BadInput, match=r"emit\.tick_period") as refusal:
        tick_constants(design, Fraction(period))
    remedy = re.search(r"; (\S+) s makes smaller ones", str(refusal.value))
    assert remedy
    assert tick_constants(design, Fraction(remedy.group(1)))


@pytest.mark.parametrize(("t_c", "period"), [("86400.000001", "0.001"), ("9.87654321", "0.00123456789")])
def test_where_no_round_period_fits_the_refusal_asks_for_another_time(t_c: str, period: str) -> None:
    with pytest.raises(BadInput, match="make prescribed_time a number of fewer digits"):
        tick_constants(small_design(1024, Fraction(t_c)), Fraction(period))


@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_a_tick_period_is_refused_for_designs_in_seconds(design: str) -> None:
    with pytest.raises(BadInput, match="emit.tick_period"):
        build_once(parse_task(TASK + "\n[emit]\ntick_period = 0.001\n").with_options(design), uncertified=True)
