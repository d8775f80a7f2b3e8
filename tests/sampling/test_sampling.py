"""Sampled control: adversaries do not break what is proved, bounds scale with the units, and what `prove` reports."""

from __future__ import annotations

import itertools
import json
import math
import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx
from typer.testing import CliRunner

from benchmarks.sampled import draw_loop, failure_factor, violations
from stt_codegen.certify.adaptive.enclosure import enclosed_tube, enclosed_windows
from stt_codegen.cli.main import app
from stt_codegen.errors import NotCertified
from stt_codegen.lemmas.book import FAMILIES
from stt_codegen.lemmas.lemma import Verdict
from stt_codegen.pipeline import build
from stt_codegen.plants import PLANTS, plant_of
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling.gains import choose_proved_gain
from stt_codegen.sampling.periods import Period, _inputs_above, holds, longest_proved_period
from stt_codegen.sampling.plant import bounds_of_task
from stt_codegen.sampling.sampled_loop import SampledLoop, first_order_loop, in_balls, law_of, start_bound_of_state
from stt_codegen.sampling.sampling_conditions import SAMPLING_CONDITIONS, input_bound, input_per_gain, q
from stt_codegen.sampling.windows import refined_windows
from tests.support.controllers import ROOT, build_once, controller_of


def loop_of_task(name: str = "omni_s2", gain: float = 0.5, noise: float = 0.0) -> SampledLoop:
    """Return the sampled loop of an example task with this gain and this noise, from its initial_state."""
    controller = controller_of(name)
    windows = refined_windows(controller.design)
    law = replace(
        law_of(controller.task, controller.certificate.edge_error, noise), gain=np.full(controller.task.dimension, gain)
    )
    start = start_bound_of_state(windows, [float(v) for v in controller.task.initial_state])
    return first_order_loop(windows, [bounds_of_task(controller.task)] * len(windows.narrow), law, start)


def in_other_units(loop: SampledLoop, length: float, time: float) -> SampledLoop:
    """Return the same loop in other units: lengths and times are multiplied, and the gain by length^2/time."""
    old, speed = loop.windows, length / time
    windows = replace(
        old,
        times=old.times * time,
        narrow=old.narrow * length,
        wide=old.wide * length,
        speed=old.speed * speed,
        widening=old.widening * speed,
    )
    law = replace(loop.law, gain=loop.law.gain * length**2 / time, shift=loop.law.shift * length)
    return replace(
        loop,
        windows=windows,
        law=law,
        closing_speed=loop.closing_speed * speed,
        narrow=loop.narrow * length,
        closing_speed_norm=loop.closing_speed_norm * speed,
    )


@pytest.mark.parametrize("statement", SAMPLING_CONDITIONS)
@pytest.mark.parametrize("is_coupled", [False, True])
def test_no_adversary_reaches_the_proved_bound(statement: str, is_coupled: bool) -> None:
    draw = random.Random(7)
    proved_count = 0
    for seed in range(8):
        loop, share = draw_loop(draw, is_coupled), draw.uniform(0, 0.9)
        period = longest_proved_period(statement, loop.to_sampled_loop(2 * math.atanh(share) * (1 + 1e-9)))
        if period is not None:
            proved_count += 1
            assert not violations(loop, statement, period, share, seed)
    assert proved_count or (statement == "diagonal" and is_coupled)  # the diagonal statement is only for a diagonal g


def test_the_adversaries_break_a_loop_at_some_longer_period() -> None:
    """Otherwise the test above would show nothing."""
    draw = random.Random(7)
    loop = draw_loop(draw, False)
    period = longest_proved_period("sharp", loop.to_sampled_loop(2 * math.atanh(0.5)))
    assert period is not None
    assert 1 < failure_factor(loop, period, 0.5, 1) < 20


def test_the_adversaries_exceed_a_bound_on_u_that_ignores_noise() -> None:
    """With noise the law may measure x nearer to an edge than it is, so |u| exceeds its bound without noise, and not the proved one."""
    loop = replace(
        draw_loop(random.Random(7), False),
        noise=0.02,
        narrow=0.5,
        wide=0.5,
        edge_speed=0.1,
        plant_bound=0.1,
        latency=0.0,
        u_max=math.inf,
    )
    period = longest_proved_period("sharp", loop.to_sampled_loop(2 * math.atanh(0.9)))
    assert period is not None
    bound_without_noise = (loop.gain * 4 * q(period.eps_bound[0]) / loop.narrow,)
    assert violations(loop, "sharp", replace(period, u=bound_without_noise), 0.9, 1)
    assert not violations(loop, "sharp", period, 0.9, 1)


@pytest.mark.parametrize("statement", SAMPLING_CONDITIONS)
def test_periods_scale_with_the_unit_of_time_and_not_with_that_of_length(statement: str) -> None:
    """Bounds on eps do not change at all, up to the search's 2^-20 and its safety factor."""
    loop = loop_of_task()
    period = longest_proved_period(statement, loop)
    for length, time in ((8.0, 1.0), (1.0, 4.0), (0.25, 16.0)):
        scaled_period = longest_proved_period(statement, in_other_units(loop, length, time))
        assert period is not None
        assert scaled_period is not None
        assert scaled_period.seconds / time == pytest.approx(period.seconds, rel=1e-5)
        assert scaled_period.eps_bound == pytest.approx(period.eps_bound, rel=1e-9)


@pytest.mark.parametrize("statement", SAMPLING_CONDITIONS)
def test_a_bound_that_holds_for_a_period_holds_for_shorter_ones(statement: str) -> None:
    loop = loop_of_task()
    period = longest_proved_period(statement, loop)
    assert period is not None
    for share in (1.0, 0.9, 0.5, 0.1, 0.0):
        assert holds(statement, loop, period.eps_bound, period.seconds * share)
    assert not holds(statement, loop, period.eps_bound, period.seconds * 1.01)


@pytest.mark.parametrize("change", ["push", "noise", "narrower", "faster"])
def test_a_harder_loop_has_no_longer_period(change: str) -> None:
    loop = loop_of_task(noise=0.002 if change == "noise" else 0.0)
    easy, windows = longest_proved_period("sharp", loop_of_task()), loop.windows
    if change == "push":
        loop = replace(loop, closing_speed=loop.closing_speed + 0.3)
    elif change == "narrower":
        loop = replace(loop, narrow=loop.narrow * 0.9, windows=replace(windows, narrow=windows.narrow * 0.9))
    elif change == "faster":
        loop = replace(loop, closing_speed=loop.closing_speed * 1.2)
    hard = longest_proved_period("sharp", loop)
    assert easy is not None
    assert hard is None or hard.seconds < easy.seconds


def test_the_smallest_input_over_a_range_of_widths_is_at_its_ends() -> None:
    """The sharp statement relies on it (lemma sampled.ends); here on a grid."""
    draw = random.Random(3)
    for _ in range(300):
        reach, narrow = draw.uniform(0.1, 4.0), draw.uniform(0.1, 1.0)
        widths = np.linspace(narrow, narrow * draw.uniform(1.0, 5.0), 200)
        shift = draw.uniform(0, 0.5) * narrow * math.tanh(reach / 2)
        far, near = widths / (1 + math.exp(-reach)) - shift, widths / (1 + math.exp(reach)) + shift
        if (far > near).all():
            values = input_per_gain(far, near, np.log, 0.0)
            assert values.min() >= min(values[0], values[-1]) * (1 - 1e-12)


def test_the_input_bound_holds_for_every_smaller_eps() -> None:
    loop = loop_of_task()
    for reach in (0.5, 2.0, 4.0):
        bound = input_bound(loop, reach)
        for eps in np.linspace(-reach, reach, 41):
            assert (loop.law.gain * 4 * abs(q(eps)) / loop.narrow <= bound).all()


def test_windows_contain_the_emitted_tube() -> None:
    """Widths, edges and speeds at many times, of a refined tube and of an adaptive one, whose alpha takes small steps."""
    refined = controller_of("omni_s1")
    module: dict[str, Any] = {}
    exec(refined.files["omni_s1.py"], module)
    windows = refined_windows(refined.design)
    for k in range(len(windows.times) - 1):
        for t in np.linspace(windows.times[k], windows.times[k + 1], 9)[:-1]:
            lower, upper = (np.array(v) for v in module["tube"](t))
            rates = np.array(module["tube_rate"](t))
            rounding = 1e-6  # of the emitted arithmetic
            assert (upper - lower >= windows.narrow[k] - rounding).all()
            assert (upper - lower <= windows.wide[k] + rounding).all()
            assert (lower >= windows.low[k] - rounding).all()
            assert (upper <= windows.high[k] + rounding).all()
            assert (np.abs(rates).max(axis=0) <= windows.speed[k] + rounding).all()
    adaptive = build(ROOT / "tasks" / "omni_s1.toml", "adaptive")
    windows = enclosed_windows(enclosed_tube(adaptive.task, adaptive.design))
    exec(adaptive.files["omni_s1.py"], module)
    alpha, steps = module["alpha_init"](), 9000
    for k in range(steps):
        t = 9.0 * k / steps
        k_of_t = int(np.searchsorted(windows.times, t, side="right")) - 1
        lower, upper = (np.array(v) for v in module["tube"](t, alpha))
        assert (windows.narrow[k_of_t] - 1e-5 <= upper - lower).all()
        assert (upper - lower <= windows.wide[k_of_t] + 1e-5).all()
        alpha = module["alpha_step"](t, 9.0 / steps, alpha)


# ------------------------------------------------------------------------------------- what users see


def test_the_robot_with_heading_has_a_proof_at_a_kilohertz() -> None:
    """From initial_state with the task's gain; from the whole start share with another gain."""
    analysis = Analysis(controller_of("omni_heading"), PLANTS["robot"])
    assert all(h.holds for h in analysis.hypotheses())
    assert analysis.from_initial_state is not None
    assert analysis.from_initial_state.seconds > 0.001
    assert choose_proved_gain(analysis.sampled_loop, 0.001) is not None


def test_a_robot_that_may_turn_past_a_right_angle_fails_assumption_2(tmp_path: Path) -> None:
    text = (ROOT / "tasks" / "omni_heading.toml").read_text().replace("-1.2", "-3.0").replace("1.2]", "3.0]")
    text = text.replace("[0.0, 0.0, -0.1]", "[0.0, 0.0, -2.0]").replace("[0.5, 0.5, 0.1]", "[0.5, 0.5, 2.0]")
    (tmp_path / "task.toml").write_text(text)
    result = CliRunner().invoke(app, ["prove", str(tmp_path / "task.toml"), "--plant", "robot", "--out", str(tmp_path), "--json"])
    assert result.exit_code == 1
    document = json.loads(result.stdout)
    failed = [h["name"] for h in document["hypotheses"] if not h["holds"]]
    assert "Assumption 2" in failed


@pytest.mark.parametrize("design", ["refined", "adaptive"])
def test_prove_writes_bounds_that_a_second_run_confirms(design: str, tmp_path: Path) -> None:
    task = str(ROOT / "tasks" / "omni_s3.toml")
    arguments = ["prove", task, "--out", str(tmp_path), "--design", design]
    assert CliRunner().invoke(app, [*arguments, "--check"]).exit_code == 1  # the file does not exist yet
    assert CliRunner().invoke(app, arguments).exit_code == 0
    assert CliRunner().invoke(app, [*arguments, "--check"]).exit_code == 0
    document = json.loads((tmp_path / "omni_s3.bounds.json").read_text())
    assert document["hypotheses"]
    if design == "refined":
        assert document["sampled"]["sharp"]["period"] > 0
    assert ("update_function" in document) == (design == "adaptive")
    if design == "adaptive":
        numbers = document["update_function"]
        assert numbers["s_star"] > 0
        assert numbers["least_gap"] > numbers["ln4_over_nu"]


@pytest.mark.parametrize("name", ["omni_s1", "omni_board", "omni_heading", "spacecraft", "trolley"])
def test_the_committed_bounds_are_those_of_prove(name: str) -> None:
    folder = ROOT / "generated" / name / "refined" / "float"
    task = str(ROOT / "tasks" / f"{name}.toml")
    result = CliRunner().invoke(app, ["prove", task, "--out", str(folder), "--check", "--json"])
    assert not json.loads(result.stdout)["file_differs"]
    assert result.exit_code == 0, result.output


def test_options_of_a_task_are_refused_without_one() -> None:
    assert CliRunner().invoke(app, ["prove", "--plant", "robot"]).exit_code != 0


def test_for_a_gain_that_is_too_small_another_one_is_proposed(tmp_path: Path) -> None:
    controller = controller_of("omni_s2")
    analysis = Analysis(build_with_gain(controller.task, "0.0001"))
    assert analysis.period is None
    assert not next(h for h in analysis.hypotheses() if h.name == "Theorem 4.1").holds
    assert analysis.gains.with_longest_period is not None
    assert Analysis(build_with_gain(controller.task, str(analysis.gains.with_longest_period.gain[0]))).period is not None


def build_with_gain(task: Any, gain: str) -> Any:
    """Return the task's controller with this gain."""
    return build_once(task.model_copy(update={"control": task.control.model_copy(update={"gain": Fraction(gain)})}))


def test_a_negative_gain_needs_a_negative_plant() -> None:
    controller = build_with_gain(controller_of("omni_s2").task, "-0.5")
    analysis = Analysis(controller, PLANTS["integrator"])
    assert not next(h for h in analysis.hypotheses() if h.name == "Assumption 2").holds
    assert analysis.period is None


def test_a_period_names_the_time_and_component_that_limit_it() -> None:
    period = longest_proved_period("sharp", loop_of_task())
    assert isinstance(period, Period)
    assert 0 <= period.bottleneck[0] <= period.bottleneck[1] <= 9
    assert period.bottleneck[2] in (1, 2)


def test_generate_warns_of_ticks_that_are_too_slow(tmp_path: Path) -> None:
    text = (ROOT / "tasks" / "omni_board.toml").read_text()
    assert "tick_period = 0.001" in text
    for gain, period, is_warned in (("0.5", "0.001", False), ("2.0", "0.001", True), ("0.5", "0.02", True)):
        changed = text.replace("tick_period = 0.001", f"tick_period = {period}").replace("gain = 0.5", f"gain = {gain}")
        (tmp_path / "task.toml").write_text(changed)
        result = CliRunner().invoke(app, ["generate", str(tmp_path / "task.toml"), "--out", str(tmp_path)])
        assert result.exit_code == 0, result.output
        assert ("proved short enough" in result.output) == is_warned


@pytest.mark.parametrize("share", [0.02, 0.1, 0.3, 0.5, 0.98])
def test_eps_at_the_start_is_computed_from_the_tube_at_0(share: float) -> None:
    """It is not that of the first window's hull; outside of the tube it is infinite."""
    module: dict[str, Any] = {}
    exec(controller_of("omni_s2", "double").files["omni_s2.py"], module)
    lower, upper = (np.array(v) for v in module["tube"](0.0))
    x = lower + share * (upper - lower)
    eps = np.abs(np.log((x - lower) / (upper - x)))
    inside, outside = (
        Analysis(controller_of("omni_s2"), start=start.tolist()).sampled_loop.start for start in (x, upper + 0.001)
    )
    assert inside == pytest.approx(eps, rel=1e-6, abs=1e-6)
    assert np.isinf(outside).all()


def test_for_a_start_near_an_edge_nothing_is_proved() -> None:
    task = controller_of("omni_s2").task.model_copy(update={"initial_state": (Fraction("0.498"),) * 2})
    analysis = Analysis(build_once(task))
    assert analysis.from_initial_state is None
    assert Analysis(build_once(task), start=[0.498, 0.498]).period is None


@pytest.mark.parametrize(("noise", "latency"), [(0.6, 1e-5), (10.0, 0.0)])
def test_with_noise_wider_than_the_tube_nothing_is_proved(noise: float, latency: float) -> None:
    loop = loop_of_task(noise=noise)
    loop = replace(loop, law=replace(loop.law, latency=latency))
    for reach in (0.5, 2.0, 5.0):
        assert not any(holds(statement, loop, np.full(2, reach), latency) for statement in SAMPLING_CONDITIONS)


def test_with_latency_a_sample_is_at_most_half_a_window_old() -> None:
    loop = loop_of_task()
    with_latency = replace(loop, law=replace(loop.law, latency=1e-6), closing_speed=loop.closing_speed * 1e-3)
    assert not any(holds("sharp", with_latency, np.full(2, reach), 0.6 * loop.windows.shortest) for reach in (0.7, 1.0, 2.0, 4.0))


@pytest.mark.parametrize("value", ["nan", "inf"])
def test_errors_that_are_no_numbers_are_refused(value: str) -> None:
    task = str(ROOT / "tasks" / "omni_s2.toml")
    for option in ("--noise", "--latency"):
        result = CliRunner().invoke(app, ["prove", task, option, value, "--out", "/nonexistent"])
        assert result.exit_code != 0
        assert option in str(result.exception) or option in result.output


def test_every_condition_names_a_lemma_that_is_proved() -> None:
    """Each statement as it is evaluated has a further lemma that compares it with those."""
    lemmas = {lemma.name: lemma for _, family in FAMILIES.values() for lemma in family}
    loop = Analysis(controller_of("omni_s2")).sampled_loop
    for name, statement in SAMPLING_CONDITIONS.items():
        for condition in statement.conditions(loop, 1.0, 1e-4):
            assert lemmas[condition.lemma].run().verdict is Verdict.PROVED
        assert lemmas[f"sampled.{name}_evaluated"].run().verdict is Verdict.PROVED


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("f", "g"),
    [
        ("[5 + x[0], 1e9]", "[[x[0] - 1, 100], [0, 1e-300]]"),  # the input needed is beyond doubles
        ("[0, 0]", "[[1, 0], [0, -1]]"),
        ("[1e300, 0]", "[[1, 0], [0, 1]]"),
        ("[0, 0]", "[[1e-300, 0], [0, 1e300]]"),
        ("[0, 0]", "[[0, 1], [1, 0]]"),
    ],
)
def test_extreme_plants_cause_no_warning_of_a_library(f: str, g: str, tmp_path: Path) -> None:
    """No gain works for these plants; the gains are extreme too."""
    (tmp_path / "odd.py").write_text(f"def f(x): return {f}\ndef g(x): return {g}\n")
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    for gain in ("0.5", "1e18"):
        path = tmp_path / "task.toml"
        path.write_text(text.replace("gain = 0.5", f"gain = {gain}"))
        analysis = Analysis(build(path), plant_of(str(tmp_path / "odd.py"), 2))
        assert analysis.report().sampling.at_this_gain is None


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("bounds", ["g_min = 1e-9", "f_max = 1e9", "g_cross = 1e9", "g_max = 1e9", "w_max = 1e-9\nnoise = 1e9"])
@pytest.mark.parametrize("command", ["design", "generate"])
def test_a_refusal_comes_without_a_warning_of_a_library(bounds: str, command: str, tmp_path: Path) -> None:
    """For tasks whose period is proved with no gain."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text().replace("gain = 0.5", 'gain = "auto"\nperiod = 0.001\nu_max = 1e-9')
    (tmp_path / "task.toml").write_text(f"{text}\n[plant]\n{bounds}\n")
    options = ["--effort", "1", *(["--out", str(tmp_path)] * (command == "generate"))]
    result = CliRunner().invoke(app, [command, str(tmp_path / "task.toml"), *options])
    assert isinstance(result.exception, NotCertified | SystemExit), repr(result.exception)


# ------------------------------------------------------------------------------------- rounding where a bound is near a limit

STATEMENTS_IN_BALLS = ("diagonal", "general")  # statements of the sampling conditions


def loop_with_large_noise(gain: float) -> SampledLoop:
    """Return a loop of one component whose noise is nearly the smallest distance that its law measures."""
    loop = replace(draw_loop(random.Random(7), False), noise=1e-9, latency=0.0, u_max=math.inf).to_sampled_loop(0.1)
    return loop.with_law(gain=np.full_like(loop.law.gain, gain))


def exact_input_bound(kind: str, loop: SampledLoop, bound: float, bits: int = 300) -> arb:
    """Return the largest bound on |u| at |eps| = bound, in ball arithmetic with this many bits."""
    with ctx.workprec(bits):
        e = arb(bound) if kind == "general" else np.array([arb(bound)] * loop.law.gain.size, dtype=object)
        inputs = np.ravel(np.asarray(SAMPLING_CONDITIONS[kind].inputs(in_balls(loop), e), dtype=object))
        return max((arb(v) for v in inputs), key=float)


@pytest.mark.parametrize("kind", STATEMENTS_IN_BALLS)
def test_a_limit_on_u_between_the_ends_of_a_ball_is_not_proved(kind: str) -> None:
    """A limit just above the middle of the ball of |u| may be below |u|; a limit above its end is proved."""
    refused_count = 0
    for gain, bound in itertools.product((0.05, 0.5, 3.0), np.linspace(0.2, 5.2, 60)):
        loop = loop_with_large_noise(gain)
        middle = math.nextafter(float(exact_input_bound(kind, loop, bound, 53).mid()), math.inf)
        e = arb(bound) if kind == "general" else np.array([arb(bound)] * loop.law.gain.size, dtype=object)
        for limit in (middle, middle * (1 + 1e-6)):
            limited = loop.with_law(u_max=np.full_like(loop.law.u_max, limit))
            saturated = SAMPLING_CONDITIONS[kind].conditions(in_balls(limited), e, arb(1e-7))[1]
            assert saturated.lemma == "sampled.saturated"
            is_below = bool(np.all(saturated.values > 0))
            with ctx.workprec(300):
                assert not is_below or exact_input_bound(kind, loop, bound) < arb(limit)
            refused_count += not is_below
            assert is_below or limit == middle
    assert refused_count


@pytest.mark.parametrize("kind", SAMPLING_CONDITIONS)
def test_the_bound_on_u_of_a_period_is_not_below_the_exact_one(kind: str) -> None:
    """This is so although a measured distance may be a difference of nearly equal numbers, with few digits left."""
    for gain, distance in itertools.product((0.05, 3.0), (15.0, 1.0, 1e-3, 1e-7)):
        loop = loop_with_large_noise(gain)
        # At distance 0 the smallest measured distance is 0.
        bound = math.log(loop.narrow.min() / loop.law.shift.max() - 1) - distance
        above = _inputs_above(kind, loop, np.full_like(loop.law.gain, bound)).max()
        with ctx.workprec(300):
            assert arb(float(above)) >= exact_input_bound(kind, loop, bound)
