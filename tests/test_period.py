"""P9: a task with a period. What is proved in fractions, what is refused, and whether what a refusal advises is true."""

from __future__ import annotations

import json
import math
import random
import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, controller_of
from flint import arb
from typer.testing import CliRunner

import stt_codegen as stt
from stt_codegen.certify.period import SharpStatement, statement_of
from stt_codegen.cli.main import app
from stt_codegen.controller.arithmetic import edge_error
from stt_codegen.loop.command import within_bounds
from stt_codegen.loop.simulate import Loop, Scenario, starts
from stt_codegen.pipeline import build_task
from stt_codegen.program.enclosed import logarithm
from stt_codegen.record.package import loop_period
from stt_codegen.sampling import STATEMENTS, holds, least, longest
from stt_codegen.sampling.loops import loop_of
from stt_codegen.task import Task

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
def case(name: str) -> tuple[SharpStatement, Any]:
    task = with_period(*CASES[name])
    made = controller_of(CASES[name][0])
    error = edge_error(made.design, made.program)
    return statement_of(task, made.design, error), loop_of(task, made.design, error)


def at(statement: SharpStatement, seconds: float) -> SharpStatement:
    """The statement with another period: the age less the latency."""
    task = statement.task
    period = Fraction(f"{seconds:.12g}") - task.control.latency
    return replace(statement, task=task.model_copy(update={"control": task.control.model_copy(update={"period": period})}))


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
    statement, setting = case(name)
    period = longest("sharp", setting)
    assert period is not None
    rho = tuple(Fraction(f"{math.exp(v) * (1 + 1e-9):.12g}") for v in period.reach)
    u = at(statement, 0.9999 * period.seconds).holds(rho)
    assert u is not None
    assert all(float(a) == pytest.approx(b, rel=1e-6) for a, b in zip(u, period.u, strict=True))
    for more in (1, 1 + Fraction(1, 1000), 1 + Fraction(1, 50)):
        assert at(statement, 1.001 * period.seconds).holds(tuple(v * more for v in rho)) is None


@pytest.mark.parametrize("name", CASES)
def test_fractions_and_balls_agree_on_any_e(name: str) -> None:
    """Both are the same inequalities: they differ only where a slack is below what either rounds by."""
    statement, setting = case(name)
    period = longest("sharp", setting)
    assert period is not None
    draw, agreed = random.Random(2), {True: 0, False: 0}
    for _ in range(12):
        seconds = period.seconds * draw.uniform(0.2, 1.2)
        reach = np.array([draw.uniform(2.95, 5.2) for _ in period.reach])
        rho = tuple(Fraction(f"{math.exp(v):.15g}") for v in reach)
        balls = holds("sharp", setting, np.array([math.log(v) for v in rho]), float(at(statement, seconds).age))
        exact = at(statement, seconds).holds(rho) is not None
        assert balls == exact
        agreed[exact] += 1
    assert all(agreed.values()), agreed


@pytest.mark.parametrize("name", CASES)
def test_windows_are_those_of_the_statement(name: str) -> None:
    """Width and speed of a window and of the one before, where a sample may stem from: as the doubles have them."""
    statement, setting = case(name)
    for k, window in enumerate(statement.windows()):
        for i, c in enumerate(window):
            exact = [float(v) for v in (c.narrow, c.narrow_seen, c.wide)]
            assert exact == [setting.windows.narrow[k, i], setting.narrow[k, i], setting.windows.wide[k, i]]
            push = float(c.speed + statement.task.plant_bounds[i].force)
            assert push == pytest.approx(setting.push[k, i], rel=1e-11)  # which is rounded up by 1e-12


@pytest.mark.parametrize("latency", ["0", "0.0002", "0.0005", "0.001"])
def test_latency_counts_as_in_the_statement(latency: str) -> None:
    """For one E the longest age by halving, in fractions and in doubles; at a gain so low that what moves before u acts binds."""
    name = "spacecraft"
    task = with_period(name, {"gain": "0.004", "latency": latency}, {"g_min": "0.9", "g_max": "1.1", "w_max": "0.01"})
    made = controller_of(name)
    error = edge_error(made.design, made.program)
    statement, setting = statement_of(task, made.design, error), loop_of(task, made.design, error)
    rho = (Fraction(60),) * task.dimension
    reach = np.full(task.dimension, math.log(60))

    def last(good: Any) -> float:
        low, high = float(latency), setting.longest_age
        for _ in range(20):
            middle = (low + high) / 2
            low, high = (middle, high) if good(middle) else (low, middle)
        return low

    exact = last(lambda age: at(statement, age).holds(rho) is not None)
    doubles = last(lambda age: all((c.values > 0).all() for c in STATEMENTS["sharp"].conditions(setting, reach, age)))
    assert exact == pytest.approx(doubles, rel=1e-5)
    assert exact > float(latency)


@pytest.mark.parametrize(
    "change",
    [
        {"shift": Fraction(1, 10)},
        {"rounding": Fraction(1, 4)},
    ],
)
def test_what_the_law_sees_wrong_counts(change: dict[str, Fraction], monkeypatch: pytest.MonkeyPatch) -> None:
    statement, setting = case("plain")
    period = longest("sharp", setting)
    assert period is not None
    rho = tuple(Fraction(f"{math.exp(v) * (1 + 1e-9):.12g}") for v in period.reach)
    early = at(statement, 0.9 * period.seconds)
    assert early.holds(rho) is not None
    if "shift" in change:
        early = replace(early, shift=(change["shift"],) * 2)
    else:
        monkeypatch.setattr(SharpStatement, "rounding", change["rounding"])
    assert early.holds(rho) is None


def test_rho_is_held_between_share_and_clamp() -> None:
    statement, _ = case("plain")
    least_rho, most = Fraction(19), Fraction(199)  # of |e| = 0.9 and 0.99
    early = at(statement, 1e-6)
    assert early.holds((least_rho, least_rho)) is None
    assert early.holds((least_rho * Fraction(1001, 1000),) * 2) is not None
    assert early.holds((most, most)) is not None
    assert early.holds((most + 1, most)) is None


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
    u = statement_of(made.task, made.design, error).holds(rho)
    assert u is not None
    assert all(a <= Fraction(b) for a, b in zip(u, sampled["u"], strict=True))
    for text in (header, made.files["trolley.py"].decode(), made.files["trolley.c"].decode()):
        assert "(P9)" in text
        assert "|e(0)| <= 0.9" in text.replace("\n * ", " ").replace("\n# ", " ")
    longer = build_task(made.task.changed(control={**dict(made.task.control), "period": Fraction("0.02") + ninth.margin}))
    assert longer.certificate.holds  # as the margin says


def test_the_example_sketch_keeps_to_what_is_proved() -> None:
    """The task's period where it has one; else the proved one, less the latency that is in a sample's age."""
    task = controller_of("omni_s2").task
    assert loop_period(build_task(task.changed(control={"gain": "auto", "period": "0.002"}))) == Fraction(1, 500)
    late = build_task(task.changed(control={"gain": "0.2", "latency": "0.0004"}))
    age = loop_period(late) + Fraction("0.0004")
    setting = loop_of(late.task, late.design, edge_error(late.design, late.program))
    assert least("sharp", setting, float(age)) is not None


def test_bytes_are_the_same_without_a_period() -> None:
    """[plant] alone, and what it says of the bounds, changes nothing but the task's digest."""
    plain = controller_of("omni_s2")
    told = build_task(plain.task.changed(plant={"w_max": "0.1", "g_cross": "0.1", "noise": "0.001"}))
    strip = re.compile(r"[0-9a-f]{16}")
    for name in ("omni_s2.c", "omni_s2.h", "omni_s2.py"):
        assert strip.sub("", plain.files[name].decode()) == strip.sub("", told.files[name].decode())


def test_a_component_that_nothing_pushes_gets_a_gain_too() -> None:
    """omni_heading's third edge stands still, and xdot = u has no wind: any gain does there, but it must be one."""
    made = build_task(controller_of("omni_heading").task.changed(control={"gain": "auto", "period": "0.001"}))
    assert made.certificate.holds
    assert all(k > 0 for k in made.task.gain)


def test_a_chosen_gain_is_proved_and_no_other_leaves_clearly_more_room() -> None:
    task = with_period("omni_s2", {"gain": "auto"}, {"w_max": "0.1"}, "0.005")
    made = build_task(task)
    assert made.certificate.holds
    assert made.task.digest == task.digest
    setting = loop_of(made.task, made.design, edge_error(made.design, made.program))
    middle = setting.begun_at(np.full(2, 0.01))

    def room(factor: float, i: int) -> float | None:
        gain = setting.law.gain.copy()
        gain[i] *= factor
        if least("sharp", setting.with_law(gain=gain), 0.005) is None:
            return None
        inner = least("sharp", middle.with_law(gain=gain), 0.005)
        return None if inner is None else inner.reach[i]

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
    with pytest.raises(stt.NotCertified, match="P9 period") as refused:
        build_task(task)
    told = str(refused.value).partition("use ")[2].partition(" (or --uncertified")[0]
    tried = 0
    for option in told.split(", or "):
        if "auto" in option:
            changed = {**control, "gain": "auto"}
        else:
            found = dict(re.findall(r"control\.(\w+) = (\[[^\]]*\]|[\d.e+-]+)", option))
            found["gain"] = re.findall(r"gain (\[[^\]]*\]|[\d.e+-]+)", option)[0]
            changed = {**control, **{k: v.strip("[]").split(", ") if "[" in v else v for k, v in found.items()}}
        assert build_task(task.changed(control=changed)).certificate.holds, option
        tried += 1
    assert tried


def test_the_board_at_a_slower_tick_is_refused_with_what_would_do() -> None:
    """Gain 0.5 at four times the tick of tasks/omni_board.toml holds from initial_state, not from all of the share."""
    task = controller_of("omni_board").task
    with pytest.raises(stt.NotCertified, match=r'fails by 0\.000.*use control.gain = "auto"'):
        build_task(task.changed(control={"gain": "0.5", "period": 4 * task.emit.tick_period}))
    assert build_task(task.changed(control={"gain": "auto", "period": 4 * task.emit.tick_period})).certificate.holds
    assert build_task(task.changed(control={"gain": "0.5", "period": task.emit.tick_period})).certificate.holds


def test_an_initial_state_outside_the_share_is_refused() -> None:
    task = controller_of("omni_s2").task.changed(initial_state=("0.499", "0.25"), control={"period": "0.001"})
    with pytest.raises(stt.NotCertified, match=r"P9 period at t = 0 s, dimension 1: fails by 0\.024"):
        build_task(task)


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
        build_task(controller_of("omni_s1").task.changed(tube={"design": design}, control={"period": "0.001"}))


def test_uncertified_files_name_p9(tmp_path: Path) -> None:
    made = build_task(controller_of("omni_s2").task.changed(control={"gain": "0.5", "period": "0.01"}), uncertified=True)
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
        made = build_task(made.task.changed(control={**dict(made.task.control), "gain": made.task.gain, "period": more}))
    sampled = made.certificate.proved_period
    assert sampled is not None
    e = [(v - 1) / (v + 1) for v in sampled.rho]
    for model in within_bounds(made.task):
        loop = Loop(made, model)
        for seed, kind in enumerate(("outward", "nearest", "constant", "random")):
            begin = starts(made.task, made.certificate.start, float(sampled.share), seed, corner=seed % 2 == 0)
            run = loop.run(
                Scenario(float(1 / sampled.period), kind, 0.15, seed, 0.002, start=begin, latency=float(sampled.latency))
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
    made = build_task(task)
    assert "-g_ii" in next(f.statement for f in made.certificate.findings if f.code == "P9")
    for model in within_bounds(task):
        assert Loop(made, model).run(Scenario(1000.0)).kept
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

    one, two = (Analysis(build_task(t)) for t in (task, other))
    assert one.period is not None
    assert two.period is not None
    assert one.gains.longest is not None
    assert two.gains.longest is not None
    assert two.period.seconds == pytest.approx(one.period.seconds * float(slow), rel=0.01)
    assert two.gains.longest[1].seconds == pytest.approx(one.gains.longest[1].seconds * float(slow), rel=0.01)
    ends, scaled_ends = one.gains.range(0.001), two.gains.range(float(slow / 1000))
    assert ends is not None
    assert scaled_ends is not None
    for mine, theirs in zip(ends, scaled_ends, strict=True):
        assert theirs == pytest.approx(mine * float(size**2 / slow), rel=0.03)  # each is searched to 1 %
