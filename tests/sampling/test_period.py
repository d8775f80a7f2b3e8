"""P9, period: what fractions prove, what is refused, remedies that work, closed loops at the proved period, and ranges of gains."""

from __future__ import annotations

import json
import math
import random
import re
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from flint import arb
from typer.testing import CliRunner

import stt_codegen as stt
from benchmarks.suites.remedies import follow_remedies, refusal_of
from stt_codegen.certify.sampled.period import prove_period
from stt_codegen.cli.main import app
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import Loop, Scenario, random_start
from stt_codegen.program.analyse.exact_logarithm import logarithm
from stt_codegen.record.sketch import loop_times
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.bounds import ProvedGains
from stt_codegen.sampling.gains import GAIN_SEARCH_LIMIT, GainRange, Gains
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.sampling.periods import holds, inputs_where_proved, longest_proved_period, prove_for_period
from stt_codegen.sampling.sampled_loop import SampledLoop
from stt_codegen.sampling.sampling_conditions import SAMPLING_CONDITIONS
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, build_once, controller_of

LIMITED = {"u_max": "1.3", "gain": "0.05"}
CASES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "plain": ("omni_s2", {}, {}),
    "limited": ("omni_s2", LIMITED, {"w_max": "0.3"}),
    "late and noisy": ("spacecraft", {"gain": "0.02", "latency": "0.001"}, {"noise": "0.0005", "g_min": "0.8", "g_max": "1.2"}),
    "coupled": ("omni_s1", {"gain": ["0.02", "0.03"]}, {"g_cross": "0.1", "f_max": "0.05"}),
}


def with_period(name: str, control: dict[str, Any], plant: dict[str, Any], period: Fraction | str = "0.001") -> Task:
    """Return an example task with this period and these entries of [control] and [plant]."""
    task = controller_of(name).task
    stated = {"gain": task.gain, **control, "period": period}
    return task.changed(control=stated, plant=plant)


@cache
def loops_of_case(name: str) -> tuple[SampledLoop, SampledLoop, Task]:
    """Return the loop of a case in fractions, the same loop in doubles, and its task."""
    task = with_period(*CASES[name])
    controller = controller_of(CASES[name][0])
    error = edge_error(controller.design, controller.program)
    return exact_loop(task, controller.design, error), loop_of(task, controller.design, error), task


def to_fraction(seconds: float) -> Fraction:
    """Return a number of seconds as the fraction of its 12 digits."""
    return Fraction(f"{seconds:.12g}")


# --------------------------------------------------------------------------------------------- in fractions


def test_logarithms_are_enclosed_closely() -> None:
    draw = random.Random(1)
    values = [Fraction(draw.randint(10**6 + 1, 10**9), 10**6) for _ in range(300)]
    values += [
        1 + Fraction(1, 10**12),
        Fraction(2),
        Fraction(3, 2),
        Fraction(199),
        Fraction(10) ** 30,
        Fraction(2**40 - 1, 2**39),
    ]
    for y in values:
        low, high = logarithm(y)
        exact = (arb(y.numerator) / arb(y.denominator)).log()
        assert arb(low.numerator) / arb(low.denominator) <= exact.upper()
        assert exact.lower() <= arb(high.numerator) / arb(high.denominator)
        # The logarithm adds artanh series, each rounded four times by 2^-64: two for the mantissa and eight for every doubling.
        assert 0 < high - low <= Fraction(8 + 32 * math.ceil(math.log2(y)), 1 << 64)


@pytest.mark.parametrize("name", CASES)
def test_fractions_prove_the_longest_period_of_the_search_and_no_longer_one(name: str) -> None:
    """They prove 0.9999 of it with the search's bound E on |eps|, and 1.001 of it with no E of a few."""
    loop, setting, _ = loops_of_case(name)
    period = longest_proved_period("sharp", setting)
    assert period is not None
    rho = tuple(Fraction(f"{math.exp(v) * (1 + 1e-9):.12g}") for v in period.eps_bound)
    u = inputs_where_proved(loop, rho, to_fraction(0.9999 * period.seconds))
    assert u is not None
    assert all(float(a) == pytest.approx(b, rel=1e-6) for a, b in zip(u, period.u, strict=True))
    for factor in (1, 1 + Fraction(1, 1000), 1 + Fraction(1, 50)):
        assert inputs_where_proved(loop, tuple(v * factor for v in rho), to_fraction(1.001 * period.seconds)) is None


@pytest.mark.parametrize("name", CASES)
def test_fractions_and_balls_agree_for_random_bounds_on_eps(name: str) -> None:
    """Both compute the same inequalities, so they could differ only where a slack is smaller than the rounding."""
    loop, setting, _ = loops_of_case(name)
    period = longest_proved_period("sharp", setting)
    assert period is not None
    draw, counts = random.Random(2), {True: 0, False: 0}
    for _ in range(12):
        seconds = period.seconds * draw.uniform(0.2, 1.2)
        reach = np.array([draw.uniform(2.95, 5.2) for _ in period.eps_bound])
        rho = tuple(Fraction(f"{math.exp(v):.15g}") for v in reach)
        balls_prove = holds("sharp", setting, np.array([math.log(v) for v in rho]), float(to_fraction(seconds)))
        fractions_prove = inputs_where_proved(loop, rho, to_fraction(seconds)) is not None
        assert balls_prove == fractions_prove
        counts[fractions_prove] += 1
    assert all(counts.values()), counts


@pytest.mark.parametrize("name", CASES)
def test_windows_in_fractions_are_those_in_doubles(name: str) -> None:
    """Widths and speeds are over a window and the one before it, in which the sample may have been taken."""
    loop, setting, _ = loops_of_case(name)
    for exact, doubles in ((loop.windows.narrow, setting.windows.narrow), (loop.windows.wide, setting.windows.wide)):
        assert (exact.astype(float) == doubles).all()
    assert (loop.narrow.astype(float) == setting.narrow).all()
    assert loop.closing_speed.astype(float) == pytest.approx(setting.closing_speed, rel=1e-11)  # doubles round it up by 1e-12


@pytest.mark.parametrize("latency", ["0", "0.0002", "0.0005", "0.001"])
def test_latency_shortens_the_longest_age_as_much_in_fractions_as_in_doubles(latency: str) -> None:
    """For one E, by bisection; the gain is so low that the motion before u acts decides."""
    name = "spacecraft"
    task = with_period(name, {"gain": "0.004", "latency": latency}, {"g_min": "0.9", "g_max": "1.1", "w_max": "0.01"})
    controller = controller_of(name)
    error = edge_error(controller.design, controller.program)
    loop, setting = exact_loop(task, controller.design, error), loop_of(task, controller.design, error)
    rho = (Fraction(60),) * task.dimension
    reach = np.full(task.dimension, math.log(60))

    def longest_age(is_proved: Any) -> float:
        low, high = float(latency), setting.longest_age
        for _ in range(20):
            middle = (low + high) / 2
            low, high = (middle, high) if is_proved(middle) else (low, middle)
        return low

    exact = longest_age(lambda seconds: inputs_where_proved(loop, rho, to_fraction(seconds)) is not None)
    doubles = longest_age(
        lambda tau: all((c.values > 0).all() for c in SAMPLING_CONDITIONS["sharp"].conditions(setting, reach, tau))
    )
    assert exact == pytest.approx(doubles, rel=1e-5)
    assert exact > float(latency)


@pytest.mark.parametrize(
    "change",
    [
        {"shift": np.array([Fraction(1, 10)] * 2)},
        {"rounding": Fraction(1, 4)},
    ],
)
def test_errors_of_the_measured_distances_count(change: dict[str, Any]) -> None:
    loop, setting, _ = loops_of_case("plain")
    period = longest_proved_period("sharp", setting)
    assert period is not None
    rho = tuple(Fraction(f"{math.exp(v) * (1 + 1e-9):.12g}") for v in period.eps_bound)
    age = to_fraction(0.9 * period.seconds)
    assert inputs_where_proved(loop, rho, age) is not None
    assert inputs_where_proved(loop.with_law(**change), rho, age) is None


def test_rho_must_be_between_start_share_and_clamp() -> None:
    loop, age = loops_of_case("plain")[0], to_fraction(1e-6)
    rho_at_share, rho_at_clamp = Fraction(19), Fraction(199)  # of |e| = 0.9 and 0.99
    assert inputs_where_proved(loop, (rho_at_share, rho_at_share), age) is None
    assert inputs_where_proved(loop, (rho_at_share * Fraction(1001, 1000),) * 2, age) is not None
    assert inputs_where_proved(loop, (rho_at_clamp, rho_at_clamp), age) is not None
    assert inputs_where_proved(loop, (rho_at_clamp + 1, rho_at_clamp), age) is None


# ------------------------------------------------------------------------------------------- certificates


def test_a_proved_period_is_in_header_certificate_and_sources(tmp_path: Path) -> None:
    task = ROOT / "tasks" / "trolley.toml"
    controller = stt.build(task)
    header = controller.files["trolley.h"].decode()
    assert "#define TROLLEY_PERIOD_PROVED 0.02F" in header
    (finding,) = (f for f in controller.certificate.findings if f.code == "P9")
    assert finding.holds
    assert finding.margin > 0
    document = json.loads(controller.files["trolley.certificate.json"])
    sampled = document["sampled"]
    assert (sampled["period"], sampled["latency"], sampled["share"]) == ("1/50", "1/500", "9/10")
    rho = tuple(Fraction(v) for v in sampled["rho"])
    error = edge_error(controller.design, controller.program)
    u = inputs_where_proved(exact_loop(controller.task, controller.design, error), rho, Fraction("0.022"))
    assert u is not None
    assert all(a <= Fraction(b) for a, b in zip(u, sampled["u"], strict=True))
    for text in (header, controller.files["trolley.py"].decode(), controller.files["trolley.c"].decode()):
        assert "(P9)" in text
        assert "|e(0)| <= 0.9" in text.replace("\n * ", " ").replace("\n# ", " ")
    with_longer_period = build_once(
        controller.task.changed(control={**dict(controller.task.control), "period": Fraction("0.02") + finding.margin})
    )
    assert with_longer_period.certificate.holds  # the margin is how much longer the period may be


def test_the_example_sketch_samples_faster_than_is_proved() -> None:
    """Its longest time between samples is the task's period, or the proved one less the latency, which a sample's age contains.

    It samples a tenth faster, so that a sample may come late."""
    task = controller_of("omni_s2").task
    times = loop_times(build_once(task.changed(control={"gain": "auto", "period": "0.002"})))
    assert (times.longest, times.period) == (Fraction(1, 500), Fraction(9, 5000))
    late = build_once(task.changed(control={"gain": "0.2", "latency": "0.0004"}))
    longest = loop_times(late).longest
    assert longest is not None
    assert loop_times(late).period <= Fraction(9, 10) * longest
    age = longest + Fraction("0.0004")
    setting = loop_of(late.task, late.design, edge_error(late.design, late.program))
    assert prove_for_period("sharp", setting, float(age)) is not None


def test_plant_bounds_without_a_period_change_no_emitted_number() -> None:
    """Plant bounds change only the task's digest; noise changes only the covered starts, too."""
    plain = controller_of("omni_s2")
    bounded = build_once(plain.task.changed(plant={"w_max": "0.1", "g_cross": "0.1"}))
    noisy = build_once(plain.task.changed(plant={"w_max": "0.1", "g_cross": "0.1", "noise": "0.001"}))
    digest = re.compile(r"[0-9a-f]{16}")
    start_bounds = re.compile(r"(start_(?:lower|upper)\b[^={}()]*= [{(])[^})]*", re.IGNORECASE)
    for name in ("omni_s2.c", "omni_s2.h", "omni_s2.py"):
        plain_text, with_bounds, with_noise = (c.files[name].decode() for c in (plain, bounded, noisy))
        assert digest.sub("", plain_text) == digest.sub("", with_bounds)
        without_noise_words = with_noise.replace("(rounding and the noise of [plant])", "(rounding)")
        assert digest.sub("", start_bounds.sub(r"\1", plain_text)) == digest.sub("", start_bounds.sub(r"\1", without_noise_words))
        assert (start_bounds.findall(plain_text) == []) == name.endswith(".h")


def test_a_component_that_nothing_moves_gets_a_gain_too() -> None:
    """The third edges of omni_heading stand still, and xdot = u has no disturbance: any positive gain would do."""
    controller = build_once(controller_of("omni_heading").task.changed(control={"gain": "auto", "period": "0.001"}))
    assert controller.certificate.holds
    assert all(k > 0 for k in controller.task.gain)


def test_a_tight_gain_is_proved_and_no_other_has_a_clearly_smaller_bound_on_eps() -> None:
    task = with_period("omni_s2", {"gain": "tight", "u_max": "1000"}, {"w_max": "0.1"}, "0.005")
    controller = build_once(task)
    assert controller.certificate.holds
    assert controller.task.digest == task.digest
    setting = loop_of(controller.task, controller.design, edge_error(controller.design, controller.program))
    from_the_middle = setting.with_start(np.full(2, 0.01))

    def eps_bound(factor: float, i: int) -> float | None:
        gain = setting.law.gain.copy()
        gain[i] *= factor
        if prove_for_period("sharp", setting.with_law(gain=gain), 0.005) is None:
            return None
        inner = prove_for_period("sharp", from_the_middle.with_law(gain=gain), 0.005)
        return None if inner is None else inner.eps_bound[i]

    for i in range(2):
        chosen = eps_bound(1.0, i)
        assert chosen is not None
        alternatives = [eps_bound(k, i) for k in (0.3, 0.6, 0.8, 1.25, 1.6, 3.0)]
        assert all(bound is None or bound > 0.97 * chosen for bound in alternatives)


@pytest.mark.parametrize(
    ("control", "plant"),
    [
        ({"gain": "0.5", "period": "0.02", "u_max": "1000"}, {"exact": True}),
        ({"period": "0.06", "u_max": "1000"}, {"exact": True}),
        ({"period": "0.02", "u_max": "1000"}, {"w_max": "0.3"}),
        ({"gain": "30", "period": "0.001", "u_max": "1000"}, {"g_cross": "0.05"}),
        ({"period": "0.015", "latency": "0.001", "u_max": "1000"}, {"exact": True}),
        ({"period": "0.02", "u_max": "0.8"}, {"w_max": "0.3"}),
    ],
)
def test_every_remedy_that_a_refusal_names_works(control: dict[str, str], plant: dict[str, Any]) -> None:
    """Every alternative of the message is put into the task."""
    task = controller_of("omni_s2").task.changed(control=control, plant=plant)
    assert refusal_of(task).startswith("period (P9): ")
    assert follow_remedies(task)


def test_the_board_at_a_slower_tick_is_refused_with_a_remedy_that_works() -> None:
    """Gain 0.5 at sixteen times the tick of tasks/omni_board.toml is too high; another gain is proved."""
    task = controller_of("omni_board").task.changed(control={"u_max": "1000"}, plant={"exact": True})
    with pytest.raises(
        stt.NotCertified, match=r'control.period = 0.016 s is too long; 0\.00\d+ s is the longest .*control.gain = "auto"'
    ):
        build_once(task.changed(control={"gain": "0.5", "period": 16 * task.emit.tick_period}))
    assert build_once(task.changed(control={"gain": "auto", "period": 16 * task.emit.tick_period})).certificate.holds
    assert build_once(task.changed(control={"gain": "0.5", "period": task.emit.tick_period})).certificate.holds


def test_an_initial_state_outside_the_share_is_refused() -> None:
    task = controller_of("omni_s2").task.changed(initial_state=("0.499", "0.25"), control={"period": "0.001"})
    with pytest.raises(stt.NotCertified, match=r"initial_state is outside .* in dimension 1 it is 0\.024\d+ beyond"):
        build_once(task)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"initial_set": {"share": "0.99"}, "control": {"period": "0.001"}},
            "initial_set.share: is 0.99, not below control.e_max",
        ),
        ({"initial_set": {"share": "1"}}, "initial_set.share: is 1; it must be less than 1"),
        ({"emit": {"tick_period": "0.002"}, "control": {"period": "0.001"}}, "emit.tick_period: is 0.002, above control.period"),
        ({"control": {"gain": ["0.5", "-0.5"]}}, r"control.gain\[1\]: is -0.5; all gains must have one sign"),
        ({"control": {"gain": "auto"}}, "needs control.period"),
        ({"control": {"noise": "0.1"}}, r"control.noise: stands in \[control\]; move it to \[plant\]"),
        ({"control": {"perod": "0.1"}}, "did you mean 'period'"),
    ],
)
def test_inconsistent_options_of_sampling_are_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(stt.BadInput, match=message):
        controller_of("omni_s2").task.changed(**values)


@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_a_period_is_for_refined_tubes(design: str) -> None:
    with pytest.raises(stt.BadInput, match="control.period"):
        build_once(controller_of("omni_s1").task.changed(tube={"design": design}, control={"period": "0.001"}))


def test_uncertified_files_name_the_failed_period(tmp_path: Path) -> None:
    unlimited = {"gain": "0.5", "period": "0.01", "u_max": "1000"}
    task = controller_of("omni_s2").task.changed(control=unlimited, plant={"exact": True})
    controller = build_once(task, uncertified=True)
    assert not controller.certificate.holds
    assert "PERIOD_PROVED" not in controller.files["omni_s2.h"].decode()
    assert "P9 period" in controller.files["omni_s2.h"].decode()


# ------------------------------------------------------------------------------------------ in closed loop


@pytest.mark.parametrize("period", [None, "longest"])
def test_the_trolley_keeps_the_proved_bounds_with_every_worst_plant(period: str | None, tool: Any) -> None:
    tool("gcc")
    controller = controller_of("trolley")
    if period:
        (finding,) = (f for f in controller.certificate.findings if f.code == "P9")
        longest = controller.task.control.period + finding.margin
        controller = build_once(
            controller.task.changed(control={**dict(controller.task.control), "gain": controller.task.gain, "period": longest})
        )
    sampled = controller.certificate.proved_period
    assert sampled is not None
    e_bounds = [(v - 1) / (v + 1) for v in sampled.rho]
    for model in corner_plants(controller.task):
        loop = Loop(controller, model)
        for seed, kind in enumerate(("outward", "nearest", "constant", "random")):
            start = random_start(controller.certificate.start, float(sampled.share), seed, corner=seed % 2 == 0)
            run = loop.run(
                Scenario(
                    rate=float(1 / sampled.period),
                    disturbance=kind,
                    strength=0.15,
                    seed=seed,
                    noise=0.002,
                    start=start,
                    latency=float(sampled.latency),
                )
            )
            assert run.good
            assert all(value < bound for value, bound in zip(run.e, e_bounds, strict=True))
            assert all(value <= bound for value, bound in zip(run.u, sampled.u, strict=True))


def test_the_worst_plants_have_the_sign_of_the_gain(tool: Any) -> None:
    """A negative gain is for a negative definite g: then [plant] bounds -g. The state stays in the tube."""
    tool("gcc")
    task = controller_of("omni_s2").task.changed(
        control={"gain": "-0.2", "period": "0.001"}, plant={"g_min": "0.9", "g_max": "1.1"}
    )
    controller = build_once(task)
    assert "-g_ii" in next(f.statement for f in controller.certificate.findings if f.code == "P9")
    for model in corner_plants(task):
        assert Loop(controller, model).run(Scenario(rate=1000.0)).kept
        assert model.g(np.zeros(2))[0][0] < 0


def test_a_disturbance_beyond_the_stated_one_is_refused() -> None:
    arguments = [
        "simulate",
        str(ROOT / "tasks" / "trolley.toml"),
        "--plant",
        "bounds",
        "--w-max",
        "5",
        "--disturbance",
        "outward",
    ]
    result = CliRunner().invoke(app, [*arguments, "--json"])
    assert result.exit_code != 0
    assert "beyond [plant]" in str(result.exception or result.output)


def test_simulate_takes_rate_noise_latency_and_the_worst_plant_from_the_task(tool: Any) -> None:
    tool("gcc")
    result = CliRunner().invoke(app, ["simulate", str(ROOT / "tasks" / "trolley.toml"), "--plant", "bounds", "--json"])
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    assert (report["rate"], report["noise"], report["latency"], report["w_max"]) == (50.0, 0.002, 0.002, 0.15)
    assert report["plant"].startswith("[plant], ")
    assert report["foretold"][0].startswith("proved, period (P9): |e| stays below")


# ---------------------------------------------------------------------------------------------- other units


@pytest.mark.parametrize(("length", "time"), [("1000", "1"), ("0.001", "1"), ("1000000", "1"), ("1", "1000"), ("1", "0.001")])
def test_in_other_units_periods_and_gains_are_the_same(length: str, time: str) -> None:
    """Periods scale with time and gains with length^2/time. The tube is designed on a grid of a power of two, so it differs by some
    1e-5 of the space; therefore the tolerance is 1 %."""
    length_factor, time_factor = Fraction(length), Fraction(time)
    task = controller_of("omni_s2").task

    def scaled(box: Any) -> dict[str, Any]:
        return {"lower": [v * length_factor for v in box.lower], "upper": [v * length_factor for v in box.upper]}

    scaled_task = task.changed(
        prescribed_time=task.prescribed_time * time_factor,
        initial_state=[v * length_factor for v in task.initial_state],
        **{name: scaled(getattr(task, name)) for name in ("state_space", "initial_set", "target_set")},
        unsafe=[{"name": u.name, **scaled(u)} for u in task.unsafe],
        tube={"clearance": task.tube.clearance * length_factor, "min_width": task.tube.min_width * length_factor},
        control={"gain": task.gain[0] * length_factor**2 / time_factor},
    )
    analysis, scaled_analysis = (Analysis(build_once(t)) for t in (task, scaled_task))
    assert analysis.period is not None
    assert scaled_analysis.period is not None
    assert analysis.gains.with_longest_period is not None
    assert scaled_analysis.gains.with_longest_period is not None
    assert scaled_analysis.period.seconds == pytest.approx(analysis.period.seconds * float(time_factor), rel=0.01)
    assert scaled_analysis.gains.with_longest_period.period.seconds == pytest.approx(
        analysis.gains.with_longest_period.period.seconds * float(time_factor), rel=0.01
    )
    range_, scaled_range = analysis.gains.proved_range(0.001), scaled_analysis.gains.proved_range(float(time_factor / 1000))
    assert range_ is not None
    assert scaled_range is not None
    for gain, scaled_gain in ((range_.smallest, scaled_range.smallest), (range_.largest, scaled_range.largest)):
        assert gain is not None
        assert scaled_gain == pytest.approx(
            gain * float(length_factor**2 / time_factor), rel=0.03
        )  # 1 % of rounding each, and the search's tolerance


# ------------------------------------------------------------------------------------------------ ranges of gains

RANGES = {**{name: (*CASES[name], "0.001") for name in CASES}, "unlimited": ("trolley", {"u_max": None}, {}, "0.01")}
RANGES |= {
    "trolley": ("trolley", {}, {}, "0.02"),
    "order 2": ("crane", {}, {}, "0.02"),
    "late, order 2": ("drone", {}, {}, "0.025"),
}


class RangeCase(NamedTuple):
    """A task with a period, its design, the errors of its emitted arithmetic, and its range of gains for a report."""

    task: Task
    design: Any
    errors: Any
    gains: GainRange


@cache
def range_case(name: str) -> RangeCase:
    """Return a case of `RANGES`."""
    source, control, plant, period = RANGES[name]
    controller = controller_of(source)
    stated = plant or {k: getattr(controller.task.plant, k) for k in controller.task.plant.model_fields_set}
    limits = {"latency": controller.task.control.latency, "u_max": controller.task.control.u_max}
    task = with_period(source, {**limits, **control}, stated, period)
    errors = (
        edge_error(controller.design, controller.program),
        rate_error(controller.design, controller.program) if task.order == 2 else (),
    )
    setting = loop_of(task, controller.design, *errors)
    seconds = float(task.sampling_period + task.control.latency)
    gains = Gains(setting, setting.law.gain, kinds=("sharp",)).proved_range(seconds)
    assert gains is not None
    return RangeCase(task, controller.design, errors, gains)


def p9_holds(name: str, gain: np.ndarray) -> bool:
    """Return whether P9 is proved in fractions, as a certificate does, for this gain in a case of `RANGES`."""
    task, design, errors, _ = range_case(name)
    return is_certified(task, gain, design, errors)


def is_certified(task: Task, gain: np.ndarray, design: Any, errors: Any) -> bool:
    """Return whether `certify_period` would accept this gain; it leaves out the advice of a refusal, which takes seconds."""
    changed = task.changed(control={"gain": [Fraction(f"{k:.12g}") for k in gain.tolist()]})
    setting = loop_of(changed, design, *errors)
    return (
        prove_period(changed, exact_loop(changed, design, *errors), setting, longest_proved_period("sharp", setting)) is not None
    )


@pytest.mark.parametrize("name", RANGES)
def test_every_gain_of_a_printed_range_is_proved_and_those_beyond_an_end_are_not(name: str) -> None:
    gains, draw = range_case(name).gains, random.Random(name)
    last_gain = gains.largest if gains.largest is not None else gains.smallest * 1e12
    gains_inside = [gains.smallest * (last_gain / gains.smallest) ** draw.random() for _ in range(3)]
    for gain in (
        gains.smallest,
        last_gain,
        *gains_inside,
        *([gains.smallest * 10, gains.smallest * 1e6] * (gains.largest is None)),
    ):
        assert p9_holds(name, gain), gain
    assert gains.fails_below
    assert not p9_holds(name, gains.smallest * 0.97)  # 1 % of rounding, and the search's tolerance
    if gains.largest is not None:
        assert gains.fails_above
        for beyond in (1.03, 1e3):
            assert not p9_holds(name, gains.largest * beyond)


def test_a_range_has_no_end_where_u_is_limited_and_only_there() -> None:
    """Without a limit |u| grows with the gain, and no period is short enough for all of them."""
    endless = {name for name in RANGES if range_case(name).gains.largest is None}
    assert endless == {name for name in RANGES if range_case(name).task.u_max is not None}
    assert len(endless) == 4


def test_with_a_limit_that_is_large_for_the_period_the_range_has_an_end() -> None:
    """With u at its limit the state must not cross the middle of the tube within one period."""
    task, design, errors, _ = range_case("unlimited")
    with_limit = task.changed(control={"u_max": 50})
    setting = loop_of(with_limit, design, *errors)
    gains = Gains(setting, setting.law.gain, kinds=("sharp",)).proved_range(float(task.sampling_period + task.control.latency))
    assert gains is not None
    assert gains.largest is not None
    assert gains.fails_above
    assert is_certified(with_limit, gains.largest, design, errors)
    assert not is_certified(with_limit, gains.largest * 1e3, design, errors)


def test_a_search_that_stops_early_reports_open_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search stops at 1.5 times a proved gain, so it knows no end on either side, and the text says so."""
    _, setting, task = loops_of_case("plain")
    monkeypatch.setattr("stt_codegen.sampling.gains.GAIN_SEARCH_LIMIT", 1.5)
    assert GAIN_SEARCH_LIMIT == 1e6
    gains = Gains(setting, setting.law.gain, kinds=("sharp",)).proved_range(float(task.sampling_period + task.control.latency))
    assert gains is not None
    assert gains.largest is not None
    assert not gains.fails_below
    assert not gains.fails_above
    text = ProvedGains(tuple(gains.smallest.tolist()), tuple(gains.largest.tolist()), gains.fails_below, gains.fails_above).text
    assert re.fullmatch(r"from [\d.]+ or less to at least [\d.]+", text)
