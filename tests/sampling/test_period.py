"""P9: a task with a period. What is proved in fractions, what is refused, and whether what a refusal advises is true."""

from __future__ import annotations

import json
import math
import random
import re
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import arb
from typer.testing import CliRunner

import stt_codegen as stt
from stt_codegen.certify.sampled.period import prove_period
from stt_codegen.cli.main import app
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.loop.command import within_bounds
from stt_codegen.loop.simulate import Loop, Scenario, starts
from stt_codegen.program.analyse.exact_logarithm import logarithm
from stt_codegen.record.sketch import loop_times
from stt_codegen.sampling.gains import GAIN_SEARCH_LIMIT, GainRange, Gains
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.sampling.periods import holds, inputs_where_proved, longest_proved_period, prove_for_period
from stt_codegen.sampling.sampled_loop import SampledLoop
from stt_codegen.sampling.sampling_conditions import SAMPLING_CONDITIONS
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, built, controller_of

LIMITED = {"u_max": "1.3", "gain": "0.05"}
CASES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "plain": ("omni_s2", {}, {}),
    "limited": ("omni_s2", LIMITED, {"w_max": "0.3"}),
    "late and noisy": ("spacecraft", {"gain": "0.02", "latency": "0.001"}, {"noise": "0.0005", "g_min": "0.8", "g_max": "1.2"}),
    "coupled": ("omni_s1", {"gain": ["0.02", "0.03"]}, {"g_cross": "0.1", "f_max": "0.05"}),
}


def with_period(name: str, control: dict[str, Any], plant: dict[str, Any], period: Fraction | str = "0.001") -> Task:
    task = controller_of(name).task
    given = {"gain": task.gain, **control, "period": period}
    return task.changed(control=given, plant=plant)


@cache
def case(name: str) -> tuple[SampledLoop, SampledLoop, Task]:
    """The loop in fractions and in doubles."""
    task = with_period(*CASES[name])
    made = controller_of(CASES[name][0])
    error = edge_error(made.design, made.program)
    return exact_loop(task, made.design, error), loop_of(task, made.design, error), task


def age(seconds: float) -> Fraction:
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
        # an artanh is rounded four times by 2^-64; ln m takes two of them, every doubling eight
        assert 0 < high - low <= Fraction(8 + 32 * math.ceil(math.log2(y)), 1 << 64)


@pytest.mark.parametrize("name", CASES)
def test_fractions_prove_what_balls_prove_and_no_more(name: str) -> None:
    """At 0.9999 of the longest period that balls prove, with the same E; and not at 1.001 of it with any."""
    loop, setting, _ = case(name)
    period = longest_proved_period("sharp", setting)
    assert period is not None
    rho = tuple(Fraction(f"{math.exp(v) * (1 + 1e-9):.12g}") for v in period.eps_bound)
    u = inputs_where_proved(loop, rho, age(0.9999 * period.seconds))
    assert u is not None
    assert all(float(a) == pytest.approx(b, rel=1e-6) for a, b in zip(u, period.u, strict=True))
    for more in (1, 1 + Fraction(1, 1000), 1 + Fraction(1, 50)):
        assert inputs_where_proved(loop, tuple(v * more for v in rho), age(1.001 * period.seconds)) is None


@pytest.mark.parametrize("name", CASES)
def test_fractions_and_balls_agree_on_any_e(name: str) -> None:
    """Both are the same inequalities: they differ only where a slack is below what either rounds by."""
    loop, setting, _ = case(name)
    period = longest_proved_period("sharp", setting)
    assert period is not None
    draw, agreed = random.Random(2), {True: 0, False: 0}
    for _ in range(12):
        seconds = period.seconds * draw.uniform(0.2, 1.2)
        reach = np.array([draw.uniform(2.95, 5.2) for _ in period.eps_bound])
        rho = tuple(Fraction(f"{math.exp(v):.15g}") for v in reach)
        balls = holds("sharp", setting, np.array([math.log(v) for v in rho]), float(age(seconds)))
        exact = inputs_where_proved(loop, rho, age(seconds)) is not None
        assert balls == exact
        agreed[exact] += 1
    assert all(agreed.values()), agreed


@pytest.mark.parametrize("name", CASES)
def test_windows_are_those_of_the_statement(name: str) -> None:
    """Width and speed of a window and of the one before, where a sample may stem from: as the doubles have them."""
    loop, setting, _ = case(name)
    for exact, doubles in ((loop.windows.narrow, setting.windows.narrow), (loop.windows.wide, setting.windows.wide)):
        assert (exact.astype(float) == doubles).all()
    assert (loop.narrow.astype(float) == setting.narrow).all()
    assert loop.closing_speed.astype(float) == pytest.approx(setting.closing_speed, rel=1e-11)  # which is rounded up by 1e-12


@pytest.mark.parametrize("latency", ["0", "0.0002", "0.0005", "0.001"])
def test_latency_counts_as_in_the_statement(latency: str) -> None:
    """For one E the longest age by halving, in fractions and in doubles; at a gain so low that what moves before u acts binds."""
    name = "spacecraft"
    task = with_period(name, {"gain": "0.004", "latency": latency}, {"g_min": "0.9", "g_max": "1.1", "w_max": "0.01"})
    made = controller_of(name)
    error = edge_error(made.design, made.program)
    loop, setting = exact_loop(task, made.design, error), loop_of(task, made.design, error)
    rho = (Fraction(60),) * task.dimension
    reach = np.full(task.dimension, math.log(60))

    def last(good: Any) -> float:
        low, high = float(latency), setting.longest_age
        for _ in range(20):
            middle = (low + high) / 2
            low, high = (middle, high) if good(middle) else (low, middle)
        return low

    exact = last(lambda seconds: inputs_where_proved(loop, rho, age(seconds)) is not None)
    doubles = last(lambda tau: all((c.values > 0).all() for c in SAMPLING_CONDITIONS["sharp"].conditions(setting, reach, tau)))
    assert exact == pytest.approx(doubles, rel=1e-5)
    assert exact > float(latency)


@pytest.mark.parametrize(
    "change",
    [
        {"shift": np.array([Fraction(1, 10)] * 2)},
        {"rounding": Fraction(1, 4)},
    ],
)
def test_what_the_law_sees_wrong_counts(change: dict[str, Any]) -> None:
    loop, setting, _ = case("plain")
    period = longest_proved_period("sharp", setting)
    assert period is not None
    rho = tuple(Fraction(f"{math.exp(v) * (1 + 1e-9):.12g}") for v in period.eps_bound)
    early = age(0.9 * period.seconds)
    assert inputs_where_proved(loop, rho, early) is not None
    assert inputs_where_proved(loop.with_law(**change), rho, early) is None


def test_rho_is_held_between_share_and_clamp() -> None:
    loop, early = case("plain")[0], age(1e-6)
    least_rho, most = Fraction(19), Fraction(199)  # of |e| = 0.9 and 0.99
    assert inputs_where_proved(loop, (least_rho, least_rho), early) is None
    assert inputs_where_proved(loop, (least_rho * Fraction(1001, 1000),) * 2, early) is not None
    assert inputs_where_proved(loop, (most, most), early) is not None
    assert inputs_where_proved(loop, (most + 1, most), early) is None


# ------------------------------------------------------------------------------------------- certificates


def test_a_period_is_in_header_certificate_and_report(tmp_path: Path) -> None:
    task = ROOT / "tasks" / "trolley.toml"
    made = stt.build(task)
    header = made.files["trolley.h"].decode()
    assert "#define TROLLEY_PERIOD_PROVED 0.02F" in header
    (ninth,) = (f for f in made.certificate.findings if f.code == "P9")
    assert ninth.holds
    assert ninth.margin > 0
    document = json.loads(made.files["trolley.certificate.json"])
    sampled = document["sampled"]
    assert (sampled["period"], sampled["latency"], sampled["share"]) == ("1/50", "1/500", "9/10")
    rho = tuple(Fraction(v) for v in sampled["rho"])
    error = edge_error(made.design, made.program)
    u = inputs_where_proved(exact_loop(made.task, made.design, error), rho, Fraction("0.022"))
    assert u is not None
    assert all(a <= Fraction(b) for a, b in zip(u, sampled["u"], strict=True))
    for text in (header, made.files["trolley.py"].decode(), made.files["trolley.c"].decode()):
        assert "(P9)" in text
        assert "|e(0)| <= 0.9" in text.replace("\n * ", " ").replace("\n# ", " ")
    longer = built(made.task.changed(control={**dict(made.task.control), "period": Fraction("0.02") + ninth.margin}))
    assert longer.certificate.holds  # as the margin says


def test_the_example_sketch_keeps_to_what_is_proved() -> None:
    """The longest gap that it takes for proved is the task's period where it has one; else the proved one, less the latency that is
    in a sample's age. It samples a tenth faster, so that a sample may come late."""
    task = controller_of("omni_s2").task
    times = loop_times(built(task.changed(control={"gain": "auto", "period": "0.002"})))
    assert (times.longest, times.period) == (Fraction(1, 500), Fraction(9, 5000))
    late = built(task.changed(control={"gain": "0.2", "latency": "0.0004"}))
    longest = loop_times(late).longest
    assert longest is not None
    assert loop_times(late).period <= Fraction(9, 10) * longest
    age = longest + Fraction("0.0004")
    setting = loop_of(late.task, late.design, edge_error(late.design, late.program))
    assert prove_for_period("sharp", setting, float(age)) is not None


def test_bytes_are_the_same_without_a_period() -> None:
    """[plant] alone, and what it says of the bounds, changes nothing but the task's digest; noise moves covered starts alone."""
    plain = controller_of("omni_s2")
    bounded = built(plain.task.changed(plant={"w_max": "0.1", "g_cross": "0.1"}))
    noisy = built(plain.task.changed(plant={"w_max": "0.1", "g_cross": "0.1", "noise": "0.001"}))
    digest = re.compile(r"[0-9a-f]{16}")
    start_bounds = re.compile(r"(start_(?:lower|upper)\b[^={}()]*= [{(])[^})]*", re.IGNORECASE)
    for name in ("omni_s2.c", "omni_s2.h", "omni_s2.py"):
        emitted, with_bounds, with_noise = (c.files[name].decode() for c in (plain, bounded, noisy))
        assert digest.sub("", emitted) == digest.sub("", with_bounds)
        quiet = with_noise.replace("(rounding and the noise of [plant])", "(rounding)")
        assert digest.sub("", start_bounds.sub(r"\1", emitted)) == digest.sub("", start_bounds.sub(r"\1", quiet))
        assert (start_bounds.findall(emitted) == []) == name.endswith(".h")


def test_a_component_that_nothing_pushes_gets_a_gain_too() -> None:
    """omni_heading's third edge stands still, and xdot = u has no wind: any gain does there, but it must be one."""
    made = built(controller_of("omni_heading").task.changed(control={"gain": "auto", "period": "0.001"}))
    assert made.certificate.holds
    assert all(k > 0 for k in made.task.gain)


def test_a_chosen_gain_is_proved_and_no_other_leaves_clearly_more_room() -> None:
    task = with_period("omni_s2", {"gain": "auto"}, {"w_max": "0.1"}, "0.005")
    made = built(task)
    assert made.certificate.holds
    assert made.task.digest == task.digest
    setting = loop_of(made.task, made.design, edge_error(made.design, made.program))
    middle = setting.with_start(np.full(2, 0.01))

    def room(factor: float, i: int) -> float | None:
        gain = setting.law.gain.copy()
        gain[i] *= factor
        if prove_for_period("sharp", setting.with_law(gain=gain), 0.005) is None:
            return None
        inner = prove_for_period("sharp", middle.with_law(gain=gain), 0.005)
        return None if inner is None else inner.eps_bound[i]

    for i in range(2):
        own = room(1.0, i)
        assert own is not None
        others = [room(k, i) for k in (0.3, 0.6, 0.8, 1.25, 1.6, 3.0)]
        assert all(o is None or o > 0.97 * own for o in others)


@pytest.mark.parametrize(
    ("control", "plant"),
    [
        ({"gain": "0.5", "period": "0.005"}, {}),
        ({"period": "0.04"}, {}),
        ({"period": "0.02"}, {"w_max": "0.3"}),
        ({"gain": "30", "period": "0.001"}, {"g_cross": "0.05"}),
        ({"period": "0.015", "latency": "0.001"}, {}),
        ({"period": "0.02", "u_max": "0.8"}, {"w_max": "0.3"}),
    ],
)
def test_what_a_refusal_advises_does(control: dict[str, str], plant: dict[str, str]) -> None:
    """Every alternative that the message names is tried as it stands."""
    task = controller_of("omni_s2").task.changed(control=control, plant=plant)
    with pytest.raises(stt.NotCertified, match=r"period \(P9\)") as refused:
        built(task)
    told = str(refused.value).partition("use ")[2].partition(" (or --uncertified")[0]
    tried = 0
    for option in told.split(", or "):
        if "auto" in option:
            changed = {**control, "gain": "auto"}
        else:
            found = dict(re.findall(r"control\.(\w+) = (\[[^\]]*\]|[\d.e+-]+)", option))
            found["gain"] = re.findall(r"gain (\[[^\]]*\]|[\d.e+-]+)", option)[0]
            changed = {**control, **{k: v.strip("[]").split(", ") if "[" in v else v for k, v in found.items()}}
        assert built(task.changed(control=changed)).certificate.holds, option
        tried += 1
    assert tried


def test_the_board_at_a_slower_tick_is_refused_with_what_would_do() -> None:
    """Gain 0.5 at four times the tick of tasks/omni_board.toml holds from initial_state, not from all of the share."""
    task = controller_of("omni_board").task
    with pytest.raises(stt.NotCertified, match=r'fails by 0\.000.*use control.gain = "auto"'):
        built(task.changed(control={"gain": "0.5", "period": 4 * task.emit.tick_period}))
    assert built(task.changed(control={"gain": "auto", "period": 4 * task.emit.tick_period})).certificate.holds
    assert built(task.changed(control={"gain": "0.5", "period": task.emit.tick_period})).certificate.holds


def test_an_initial_state_outside_the_share_is_refused() -> None:
    task = controller_of("omni_s2").task.changed(initial_state=("0.499", "0.25"), control={"period": "0.001"})
    with pytest.raises(stt.NotCertified, match=r"period \(P9\) at t = 0 s, dimension 1: fails by 0\.024"):
        built(task)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (
            {"initial_set": {"share": "0.99"}, "control": {"period": "0.001"}},
            "initial_set.share: is 0.99, not below control.e_max",
        ),
        ({"initial_set": {"share": "1"}}, "initial_set.share: is 1; it must be less than 1"),
        ({"emit": {"tick_period": "0.002"}, "control": {"period": "0.001"}}, "emit.tick_period: is 0.002, above control.period"),
        ({"control": {"gain": ["0.5", "-0.5"]}}, r"control.gain\[1\]: is -0.5; all gains must have one sign"),
        ({"control": {"gain": "auto"}}, "needs control.period"),
        ({"control": {"noise": "0.1"}}, r"control.noise: unknown key; it belongs to \[plant\]"),
        ({"control": {"perod": "0.1"}}, "did you mean 'period'"),
    ],
)
def test_what_does_not_go_together_is_refused(values: dict[str, Any], told: str) -> None:
    with pytest.raises(stt.BadInput, match=told):
        controller_of("omni_s2").task.changed(**values)


@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_a_period_is_for_refined_tubes(design: str) -> None:
    with pytest.raises(stt.BadInput, match="control.period"):
        built(controller_of("omni_s1").task.changed(tube={"design": design}, control={"period": "0.001"}))


def test_uncertified_files_name_p9(tmp_path: Path) -> None:
    made = built(controller_of("omni_s2").task.changed(control={"gain": "0.5", "period": "0.01"}), uncertified=True)
    assert not made.certificate.holds
    assert "PERIOD_PROVED" not in made.files["omni_s2.h"].decode()
    assert "P9 period" in made.files["omni_s2.h"].decode()


# ------------------------------------------------------------------------------------------ in closed loop


@pytest.mark.parametrize("period", [None, "longest"])
def test_the_trolley_keeps_its_bounds_under_every_corner_of_its_plant(period: str | None, tool: Any) -> None:
    tool("gcc")
    made = controller_of("trolley")
    if period:
        (ninth,) = (f for f in made.certificate.findings if f.code == "P9")
        more = made.task.control.period + ninth.margin
        made = built(made.task.changed(control={**dict(made.task.control), "gain": made.task.gain, "period": more}))
    sampled = made.certificate.proved_period
    assert sampled is not None
    e = [(v - 1) / (v + 1) for v in sampled.rho]
    for model in within_bounds(made.task):
        loop = Loop(made, model)
        for seed, kind in enumerate(("outward", "nearest", "constant", "random")):
            begin = starts(made.certificate.start, float(sampled.share), seed, corner=seed % 2 == 0)
            run = loop.run(
                Scenario(
                    rate=float(1 / sampled.period),
                    disturbance=kind,
                    strength=0.15,
                    seed=seed,
                    noise=0.002,
                    start=begin,
                    latency=float(sampled.latency),
                )
            )
            assert run.good
            assert all(a < b for a, b in zip(run.e, e, strict=True))
            assert all(a <= b for a, b in zip(run.u, sampled.u, strict=True))


def test_the_worst_plants_have_the_sign_of_the_gain(tool: Any) -> None:
    """A negative gain is for a negative definite g: within [plant] -g is what is bounded, and the tube is kept."""
    tool("gcc")
    task = controller_of("omni_s2").task.changed(
        control={"gain": "-0.2", "period": "0.001"}, plant={"g_min": "0.9", "g_max": "1.1"}
    )
    made = built(task)
    assert "-g_ii" in next(f.statement for f in made.certificate.findings if f.code == "P9")
    for model in within_bounds(task):
        assert Loop(made, model).run(Scenario(rate=1000.0)).kept
        assert model.g(np.zeros(2))[0][0] < 0


def test_wind_beyond_what_the_plant_states_is_refused() -> None:
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
    told = json.loads(result.stdout)
    assert (told["rate"], told["noise"], told["latency"], told["w_max"]) == (50.0, 0.002, 0.002, 0.15)
    assert told["plant"].startswith("[plant], ")
    assert "proved from this start" in told["foretold"][0]


# ---------------------------------------------------------------------------------------------- other units


@pytest.mark.parametrize(("length", "time"), [("1000", "1"), ("0.001", "1"), ("1000000", "1"), ("1", "1000"), ("1", "0.001")])
def test_other_units_get_the_same_answers(length: str, time: str) -> None:
    """Periods scale with time, gains with length^2/time, |u| with length/time. The tube itself is found on a grid of a power of two,
    so it is another one by a few 1e-5 of the space, and the share of it by a few times that: 1 %."""
    size, slow = Fraction(length), Fraction(time)
    task = controller_of("omni_s2").task

    def scaled(box: Any) -> dict[str, Any]:
        return {"lower": [v * size for v in box.lower], "upper": [v * size for v in box.upper]}

    other = task.changed(
        prescribed_time=task.prescribed_time * slow,
        initial_state=[v * size for v in task.initial_state],
        **{name: scaled(getattr(task, name)) for name in ("state_space", "initial_set", "target_set")},
        unsafe=[{"name": u.name, **scaled(u)} for u in task.unsafe],
        tube={"clearance": task.tube.clearance * size, "min_width": task.tube.min_width * size},
        control={"gain": task.gain[0] * size**2 / slow},
    )
    from stt_codegen.report.analysis import Analysis

    one, two = (Analysis(built(t)) for t in (task, other))
    assert one.period is not None
    assert two.period is not None
    assert one.gains.longest is not None
    assert two.gains.longest is not None
    assert two.period.seconds == pytest.approx(one.period.seconds * float(slow), rel=0.01)
    assert two.gains.longest[1].seconds == pytest.approx(one.gains.longest[1].seconds * float(slow), rel=0.01)
    ends, scaled_ends = one.gains.range(0.001), two.gains.range(float(slow / 1000))
    assert ends is not None
    assert scaled_ends is not None
    for mine, theirs in ((ends.first, scaled_ends.first), (ends.last, scaled_ends.last)):
        assert mine is not None
        assert theirs == pytest.approx(mine * float(size**2 / slow), rel=0.03)  # 1 % of rounding each, and what the search leaves


# ------------------------------------------------------------------------------------------------ ranges of gains

RANGES = {**{name: (*CASES[name], "0.001") for name in CASES}, "unlimited": ("trolley", {"u_max": None}, {}, "0.01")}
RANGES |= {
    "trolley": ("trolley", {}, {}, "0.02"),
    "order 2": ("crane", {}, {}, "0.02"),
    "late, order 2": ("drone", {}, {}, "0.025"),
}


@cache
def gain_range(name: str) -> tuple[Task, Any, Any, GainRange]:
    """A task with a period, its design, errors of its arithmetic, and the range that reports print."""
    source, control, plant, period = RANGES[name]
    made = controller_of(source)
    stated = plant or {k: getattr(made.task.plant, k) for k in made.task.plant.model_fields_set}
    limits = {"latency": made.task.control.latency, "u_max": made.task.control.u_max}
    task = with_period(source, {**limits, **control}, stated, period)
    errors = (edge_error(made.design, made.program), rate_error(made.design, made.program) if task.order == 2 else ())
    setting = loop_of(task, made.design, *errors)
    age = float(task.sampling_period + task.control.latency)
    found = Gains(setting, setting.law.gain, kinds=("sharp",)).range(age)
    assert found is not None
    return task, made.design, errors, found


def p9_holds(name: str, gain: np.ndarray) -> bool:
    """Whether the certificate's own P9, in fractions, is shown for that gain."""
    task, design, errors, _ = gain_range(name)
    return is_certified(task, gain, design, errors)


def is_certified(task: Task, gain: np.ndarray, design: Any, errors: Any) -> bool:
    """As `certify_period` decides, without the advice of its refusals, which takes seconds."""
    changed = task.changed(control={"gain": [Fraction(f"{k:.12g}") for k in gain.tolist()]})
    setting = loop_of(changed, design, *errors)
    return (
        prove_period(changed, exact_loop(changed, design, *errors), setting, longest_proved_period("sharp", setting)) is not None
    )


@pytest.mark.parametrize("name", RANGES)
def test_every_gain_of_a_printed_range_is_proved_and_those_beyond_an_end_are_not(name: str) -> None:
    found, draw = gain_range(name)[3], random.Random(name)
    last = found.last if found.last is not None else found.first * 1e12
    inside = [found.first * (last / found.first) ** draw.random() for _ in range(3)]
    for gain in (found.first, last, *inside, *([found.first * 10, found.first * 1e6] * (found.last is None))):
        assert p9_holds(name, gain), gain
    assert found.first_is_end
    assert not p9_holds(name, found.first * 0.97)  # 1 % of rounding, and what the search leaves
    if found.last is not None:
        assert found.last_is_end
        for beyond in (1.03, 1e3):
            assert not p9_holds(name, found.last * beyond)


def test_a_range_has_no_end_where_u_is_limited_and_only_there() -> None:
    """Without a limit |u| grows with the gain, and no period is short enough for all of them."""
    endless = {name for name in RANGES if gain_range(name)[3].last is None}
    assert endless == {name for name in RANGES if gain_range(name)[0].u_max is not None}
    assert len(endless) == 4


def test_a_limit_that_is_too_large_for_the_period_leaves_an_end() -> None:
    """A limit alone is not enough: at the limit the state must not cross the middle within a sample."""
    task, design, errors, _ = gain_range("unlimited")
    high = task.changed(control={"u_max": 50})
    setting = loop_of(high, design, *errors)
    found = Gains(setting, setting.law.gain, kinds=("sharp",)).range(float(task.sampling_period + task.control.latency))
    assert found is not None
    assert found.last is not None
    assert found.last_is_end
    assert is_certified(high, found.last, design, errors)
    assert not is_certified(high, found.last * 1e3, design, errors)


def test_a_search_that_was_cut_is_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a search that gives up at 1.5 times a proved gain both ends are open; the text says so."""
    from stt_codegen.report.bounds import ProvedGains

    _, setting, task = case("plain")
    monkeypatch.setattr("stt_codegen.sampling.gains.GAIN_SEARCH_LIMIT", 1.5)
    assert GAIN_SEARCH_LIMIT == 1e6
    found = Gains(setting, setting.law.gain, kinds=("sharp",)).range(float(task.sampling_period + task.control.latency))
    assert found is not None
    assert found.last is not None
    assert not found.first_is_end
    assert not found.last_is_end
    text = ProvedGains(tuple(found.first.tolist()), tuple(found.last.tolist()), found.first_is_end, found.last_is_end).text
    assert re.fullmatch(r"from [\d.]+ or less to at least [\d.]+", text)
