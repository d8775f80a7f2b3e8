"""control.u_norm: the emitted u never has a larger Euclidean norm, the shares are what the tube needs, and the checker compares."""

from __future__ import annotations

import json
import math
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.suites.remedies import remedies_of, with_remedy
from stt_codegen import pipeline
from stt_codegen.checker.stt_checker.claims import _read_limits
from stt_codegen.checker.stt_checker.task import Task as CheckedTask
from stt_codegen.designs import require_refined
from stt_codegen.effort import Effort
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.remedies import CertificationTests
from stt_codegen.remedies.adjustments import adjustments_of
from stt_codegen.remedies.remedy_search import smallest_change
from stt_codegen.report.figures.control_notes import choice_lines
from stt_codegen.task import is_within_norm, parse_task, shares_of_norm
from tests.certify.test_control_choice import STATED
from tests.support.checked_files import (
    REFUSED,
    UNUSABLE,
    VERIFIED,
    Files,
    certificate_of,
    verdict,
    with_certificate,
    with_hashes,
    with_text,
)
from tests.support.controllers import ROOT, build_once

SAMPLED = STATED.replace("period = 0.02", "period = 0.02\nu_norm = 1.5")
CONTINUOUS = SAMPLED.replace("period = 0.02\n", "").replace("noise = 0.002\n", "")
INERTIAL = CONTINUOUS.replace("[plant]", "[plant]\norder = 2").replace("u_norm = 1.5", "u_norm = 4")
# The second axis needs 1.6 times as much as the first.
UNEVEN = SAMPLED.replace("w_max = 0.1", "w_max = [0.1, 0.5]").replace("u_norm = 1.5", "u_norm = 1.7")
EMISSIONS = {
    "float": "",
    "double": '\n[emit]\nscalar = "double"\n',
    "fixed": '\n[emit]\nscalar = "fixed"\ntick_period = 0.001\n',
}
# On the sphere exactly: the certificate chooses [3, 4], and one unit more of either is outside.
TOUCHING = SAMPLED.replace("u_norm = 1.5", "u_norm = 5\nu_max = [3, 4]")
NUMBERS = st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=10**6)


def files_of(controller: EmittedController, text: str) -> Files:
    return {**controller.files, "task.toml": text.encode()}


def squares(values: Any) -> Fraction:
    """Return the sum of the squares of numbers, exactly."""
    return sum((Fraction(v) ** 2 for v in values), Fraction(0))


# ------------------------------------------------------------------------------------------------------------ the shares


# A share has SHARE_DIGITS = 6 digits and is rounded down: it is less than 1e-5 of itself below what it stands for.
ROUNDING = Fraction(1, 10**5)


@settings(deadline=None)
@given(st.lists(NUMBERS | st.just(Fraction(0)), min_size=1, max_size=6), NUMBERS, st.data())
def test_shares_keep_the_norm_and_the_caps_and_no_larger_ones_in_their_proportions_do(
    needed: list[Fraction], norm: Fraction, data: Any
) -> None:
    caps = data.draw(st.none() | st.lists(NUMBERS, min_size=len(needed), max_size=len(needed)))
    shares = shares_of_norm(needed, norm, caps)
    assert min(shares) > 0
    assert is_within_norm(shares, norm)
    assert all(v <= cap for v, cap in zip(shares, caps or shares, strict=True))
    ratios = {i: shares[i] / v for i, v in enumerate(needed) if v >= max(needed) / 50 > 0}
    if ratios:
        factor = max(ratios.values())
        assert min(ratios.values()) >= factor * (1 - ROUNDING)
        larger = [factor / (1 - ROUNDING) * max(v, max(needed) / 50) for v in needed]
        is_above_a_cap = caps is not None and any(v > cap for v, cap, n in zip(larger, caps, needed, strict=True) if n)
        assert squares(larger) > norm**2 or is_above_a_cap


@settings(deadline=None)
@given(st.integers(2, 4), st.randoms(use_true_random=False))
def test_where_the_needed_input_is_within_norm_and_caps_the_shares_balance_what_acts(n: int, random: Any) -> None:
    """Every u_i <= share_i outweighs P_i while the others push with all of their shares: g_ii s_i - |g_ij| s_j >= P_i."""
    number = lambda low, high: Fraction(random.randint(low, high), 1000)  # noqa: E731
    needed = [number(50, 1000) for _ in range(n)]
    coupling = [[number(0, 300) if i != j else Fraction(0) for j in range(n)] for i in range(n)]
    pushed = [sum((c * v for c, v in zip(row, needed, strict=True)), Fraction(0)) for row in coupling]
    closing = [v - push for v, push in zip(needed, pushed, strict=True)]  # with g_ii = 1 the needed input just balances this
    norm = Fraction(math.sqrt(squares(needed))) * number(1001, 5000)
    caps = random.choice([None, [v * number(1001, 9000) for v in needed]])
    shares = shares_of_norm(needed, norm, caps)
    for i, row in enumerate(coupling):
        if closing[i] >= 0:
            rest = shares[i] - sum((c * v for c, v in zip(row, shares, strict=True)), Fraction(0))
            assert rest >= closing[i] - ROUNDING * shares[i]


@pytest.mark.parametrize("text", [CONTINUOUS, SAMPLED])
def test_a_larger_norm_refuses_no_task_that_a_smaller_one_certifies(text: str) -> None:
    """With a limit on one axis and coupling, more for the other axis pushes the first, and nothing is left to hold it."""
    for norm in ("1.9", "5", "45"):
        coupled = text.replace("[plant]", "[plant]\ng_cross = 0.2")
        assert build_once(parse_task(coupled.replace("u_norm = 1.5", f"u_norm = {norm}\nu_max = [1.2, 50]"))).certificate.holds


@pytest.mark.parametrize("text", [SAMPLED, UNEVEN, CONTINUOUS, INERTIAL])
def test_every_component_has_the_same_reserve(text: str) -> None:
    """Where the norm binds, the limits are in proportion to the needed inputs, and all of the norm is used."""
    task = parse_task(text)
    norms = [Fraction(task.control.u_norm or 0) * v for v in (Fraction(1), Fraction(98, 100))]
    limits = [build_once(task.changed(control={"u_norm": norm})).task.u_max for norm in norms]
    for norm, limit in zip(norms, limits, strict=True):
        assert limit is not None
        assert norm**2 * Fraction("0.9999") <= squares(limit) <= norm**2
    first, second = limits
    assert [float(a / b) for a, b in zip(first or (), second or (), strict=True)] == pytest.approx([1 / 0.98] * 2, rel=1e-4)


def test_a_norm_beyond_the_automatic_limits_changes_nothing_that_acts() -> None:
    text = SAMPLED.replace("u_norm = 1.5", "u_norm = 50")
    plain, bounded = build_once(parse_task(STATED)), build_once(parse_task(text))
    assert (plain.task.u_max, plain.task.gain) == (bounded.task.u_max, bounded.task.gain)


def test_the_shares_succeed_where_the_equal_split_fails() -> None:
    equal = shares_of_norm([Fraction(0)] * 2, Fraction("1.7"))
    controller = build_once(parse_task(UNEVEN))
    assert controller.certificate.holds
    first, second = controller.task.u_max or ()
    assert first < equal[0] < second
    split = parse_task(UNEVEN.replace("u_norm = 1.7", f"u_max = {float(equal[0])}"))
    refused = pipeline.attempt(split, controller.design).certificate
    assert not refused.holds
    assert "period (P9): in dimension 2 " in refused.reason.problem


def test_without_a_period_the_tube_is_designed_within_the_shares() -> None:
    """At 1.02 the tube that is found without limits needs more than the norm, and a slower one is within it."""
    task = parse_task(CONTINUOUS.replace("u_norm = 1.5", "u_norm = 1.02"))
    unlimited = task.changed(control={"u_norm": 50})
    assert not pipeline.attempt(task, pipeline.preferred_tube(unlimited)).certificate.holds
    controller = build_once(task)
    assert controller.certificate.holds
    assert controller.task.u_max is not None
    assert any(finding.code == "P8" for finding in controller.certificate.findings)


# ----------------------------------------------------------------------------------------------------- the emitted code


class Attack:
    """A search for the largest |u| of emitted C. u counts units of 2^-bits where the C is in integers."""

    def __init__(self, controller: EmittedController) -> None:
        self.controller, self.code, self.rng = controller, CompiledC(controller), np.random.default_rng(11)
        self.is_integer = controller.task.emit.scalar == "fixed"
        self.states = 2 if controller.task.order == 2 else 1

    def norms(self, times: np.ndarray, *states: np.ndarray) -> list[Fraction]:
        """Return |u|^2 at every point, exactly."""
        u = self.code.call("control", times, *states)[-1]
        unit = Fraction(1, 1 << certificate_of(dict(self.controller.files))["integers"]["u_bits"]) if self.is_integer else 1
        return [squares(Fraction(v) * unit for v in row) for row in u.tolist()]

    def points(self, count: int) -> list[np.ndarray]:
        """Return random times and states: in the tube, beside it, far from it, and none that a sensor gives."""
        n = self.controller.task.dimension
        if self.is_integer:
            bits = require_refined(self.controller.design).bits
            near = self.rng.uniform(-1, 5, (count, n)) * 2.0**bits
            far = self.rng.choice([-(2**31), 2**31 - 1, 0, 1], (count, n))
            times = self.rng.choice([0, 1, 5999, 6000, 6001, 2**32 - 1, *self.rng.integers(0, 6000, 20)], count)
            return [times, *(np.where(self.rng.random((count, n)) < 0.8, near, far).astype(np.int64) for _ in range(self.states))]
        special = [np.inf, -np.inf, np.nan, 1e30, -1e30, 1e-42, 0.0, -0.0]
        values = [self.rng.uniform(-1, 5, (count, n)) for _ in range(self.states)]
        far = self.rng.choice(special, (count, n))
        times = self.rng.choice([0.0, 6.0, 7.0, -1.0, *special, *self.rng.uniform(0, 6, 20)], count)
        return [times, *(np.where(self.rng.random((count, n)) < 0.8, v, far) for v in values)]

    def largest(self, count: int = 4000, climbs: int = 5) -> Fraction:
        """Return the largest |u|^2 of random points, and of steps away from the best of them."""
        points = self.points(count)
        best = 0 * Fraction(1)
        for _ in range(climbs):
            norms = self.norms(*points)
            best = max([best, *norms])
            order = sorted(range(len(norms)), key=norms.__getitem__)[-40:]
            times, *states = (np.repeat(values[order], 25, axis=0) for values in points)
            scale = 2.0**12 if self.is_integer else 0.05
            moved = [np.nan_to_num(v.astype(float)) + self.rng.normal(0, scale, v.shape) for v in states]
            points = [times, *(np.clip(v, -(2**31), 2**31 - 1).astype(np.int64) if self.is_integer else v for v in moved)]
        return best


@pytest.mark.parametrize("scalar", EMISSIONS)
@pytest.mark.parametrize("text", [SAMPLED, CONTINUOUS, UNEVEN, INERTIAL])
def test_no_state_and_no_time_gives_a_larger_norm(text: str, scalar: str) -> None:
    """The search is strong enough: it comes within a ten thousandth of the norm, or of what was chosen below it."""
    controller = build_once(parse_task(text + EMISSIONS[scalar]))
    norm, limits = controller.task.control.u_norm, controller.task.u_max
    assert norm is not None
    assert limits is not None
    largest = Attack(controller).largest()
    assert squares(limits) * Fraction("0.9998") <= largest <= norm**2


def test_the_attack_finds_limits_that_are_too_large() -> None:
    """The law can fail: with an entry of the table above its share, the search finds a u outside of the ball."""
    controller = build_once(parse_task(CONTINUOUS))
    source = controller.files["cart.c"].decode()
    (table,) = re.findall(r"cart_u_max\[2\] = \{.*?\}", source, re.S)
    files = {**controller.files, "cart.c": source.replace(table, "cart_u_max[2] = { 1.02F, 1.11F }").encode()}
    changed = EmittedController(controller.task, controller.design, controller.program, controller.certificate, files)
    assert Attack(changed).largest() > Fraction("1.5") ** 2


@pytest.mark.parametrize("text", [SAMPLED, CONTINUOUS, INERTIAL])
def test_header_and_design_say_the_norm(text: str) -> None:
    controller = build_once(parse_task(text))
    norm = float(controller.task.control.u_norm or 0)
    header = re.sub(r"\s+\*\s+", " ", controller.files["cart.h"].decode())
    assert f"its Euclidean norm is at most {norm:g}." in header
    assert any(f"the Euclidean norm, is at most {norm:g}" in line for line in choice_lines(controller))


# ---------------------------------------------------------------------------------------------------------- the checker


@pytest.mark.parametrize("scalar", EMISSIONS)
@pytest.mark.parametrize("text", [SAMPLED, CONTINUOUS, INERTIAL, TOUCHING, TOUCHING.replace("[3, 4]", "[9, 0.9]")])
def test_the_checker_verifies_what_is_chosen_and_what_is_stated(text: str, scalar: str, tmp_path: Path) -> None:
    text += EMISSIONS[scalar]
    answer = verdict(files_of(build_once(parse_task(text)), text), tmp_path)
    assert answer.code == VERIFIED, answer.message


@pytest.mark.parametrize(("scalar", "bits"), [("float", 24), ("double", 53)])
def test_the_checker_refuses_a_box_that_leaves_the_ball_by_one_unit(scalar: str, bits: int, tmp_path: Path) -> None:
    """The task leaves the limits open, so that [3, 4] of the certificate is one choice, and allowed; one unit more is not."""
    honest = files_of(build_once(parse_task(TOUCHING + EMISSIONS[scalar])), TOUCHING + EMISSIONS[scalar])
    open_limits = with_hashes(honest | {"task.toml": honest["task.toml"].replace(b"u_max = [3, 4]", b"u_max = [4, 4]")})
    assert _read_limits(CheckedTask(open_limits["task.toml"]), {"u_max": ["3", "4"]}) == [3, 4]
    larger_limit = 3 + Fraction(4, 1 << bits)  # the next number of the scalar above 3
    (table,) = re.findall(r"u_max\[2\] = \{.*?\}", honest["cart.c"].decode(), re.S)
    larger = with_text(open_limits, "cart.c", table, table.replace("3.0", repr(float(larger_limit))))
    certificate = certificate_of(larger)
    certificate["control"]["u_max"] = [str(larger_limit), "4"]
    answer = verdict(with_certificate(larger, certificate), tmp_path)
    assert answer.code == REFUSED
    assert "allows a u whose norm is above u_norm" in answer.message


def changed_control(files: Files, **values: Any) -> Files:
    """Return the files with other values in the certificate's `control`; None removes one."""
    certificate = certificate_of(files)
    certificate["control"] |= values
    certificate["control"] = {name: v for name, v in certificate["control"].items() if v is not None}
    return with_certificate(files, json.loads(json.dumps(certificate)))


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ({"u_norm": None}, "control is unknown, or its u_norm is not the task's"),
        ({"u_norm": "2"}, "u_norm is not the task's"),
        ({"u_norm": ["3/2"]}, "u_norm is not the task's"),
        ({"u_max": ["1", "2"]}, "allows a u whose norm is above u_norm"),
        ({"u_max": ["-1", "1"]}, "u_max is not positive, or above"),
        ({"u_max": ["1"]}, "no list of fractions"),
    ],
)
def test_the_checker_refuses_a_control_that_does_not_keep_the_norm(control: Any, message: str, tmp_path: Path) -> None:
    files = files_of(build_once(parse_task(SAMPLED)), SAMPLED)
    answer = verdict(changed_control(files, **control), tmp_path)
    assert answer.code == REFUSED
    assert message in answer.message


def test_the_checker_refuses_limits_above_the_stated_ones(tmp_path: Path) -> None:
    text = CONTINUOUS.replace("u_norm = 1.5", "u_norm = 1.5\nu_max = [1.4, 1.0]")
    controller = build_once(parse_task(text))
    first, second = controller.task.u_max or ()
    assert first < Fraction("1.4")  # in proportion to the second, whose limit is the stated one
    assert second == 1
    answer = verdict(changed_control(files_of(controller, text), u_max=["1", "11/10"]), tmp_path)
    assert answer.code == REFUSED
    assert "u_max is not positive, or above the task's" in answer.message


def test_the_checker_knows_no_norm_of_u_that_is_scaled(tmp_path: Path) -> None:
    files = files_of(build_once(parse_task(CONTINUOUS)), CONTINUOUS)
    text = files["task.toml"].replace(b"u_norm = 1.5", b'u_norm = 1.5\nu_max = 1\nsaturate = "scale"')
    assert verdict({**files, "task.toml": text}, tmp_path).code == UNUSABLE


# --------------------------------------------------------------------------------------------------------- what is asked


def test_a_norm_with_stated_limits_within_it_changes_no_number_of_the_code() -> None:
    with_norm = build_once(parse_task(TOUCHING))
    without = build_once(parse_task(TOUCHING.replace("u_norm = 5\n", "")))
    assert with_norm.program == without.program
    assert not with_norm.task.has_chosen_limit


def test_a_refusal_names_a_larger_norm_that_works() -> None:
    task = parse_task(CONTINUOUS.replace("u_norm = 1.5", "u_norm = 0.8"))
    with pytest.raises(NotCertified) as refusal:
        build_task(task, effort=Effort(60.0))
    (remedy, *_) = [v for v in remedies_of(str(refusal.value)) if set(v) == {"control.u_norm"}]
    assert 0.8 < remedy["control.u_norm"] < 1.5
    assert build_task(with_remedy(task, remedy)).certificate.holds


@pytest.mark.parametrize(("limits", "key"), [("u_norm = 45\nu_max = [0.5, 50]", "u_max"), ("u_norm = 0.6", "u_norm")])
@pytest.mark.parametrize("text", [CONTINUOUS, SAMPLED])
def test_the_limit_that_is_to_be_raised_is_the_one_that_binds(text: str, limits: str, key: str) -> None:
    """A larger norm is no help where an axis stands at its own u_max, and all limits are in proportion to it."""
    task = parse_task(text.replace("u_norm = 1.5", limits))
    tube = pipeline.preferred_tube(parse_task(text.replace("u_norm = 1.5", "u_norm = 50")))
    reason = pipeline.attempt(task, tube).certificate.reason
    assert f"raise control.{key} or" in reason.hint
    stated = "control.u_max = [0.5, 50]" if key == "u_max" else "control.u_norm = 0.6"
    assert text == CONTINUOUS or f"{stated} leaves" in reason.problem


@pytest.mark.parametrize("text", [CONTINUOUS, INERTIAL])
def test_where_u_is_too_weak_the_norm_that_is_tried_first_works_and_is_not_far_above_what_is_needed(text: str) -> None:
    task = parse_task(text)
    task = task.changed(control={"u_norm": Fraction(task.control.u_norm or 0) / 4})
    reason = pipeline.attempt(task, pipeline.preferred_tube(task)).certificate.reason
    adjustment = next(a for a in adjustments_of(task, reason) if a.keys == ("control.u_norm",))
    tests = CertificationTests(pipeline._quick_test(task), lambda changed: pipeline._is_certified(changed, task))
    change = smallest_change(task, adjustment, tests)
    assert change is not None
    certified = change.of(task)
    assert certified.control.u_norm is not None
    assert certified.control.u_norm < Fraction("1.1") * (dict(reason.sufficient)["control.u_norm"])
    assert build_once(certified).certificate.holds


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ("u_norm = 0", "control.u_norm: is 0; it must be greater than 0"),
        ("u_norm = [1, 2]", "control.u_norm: is a list; a number is needed"),
        ("u_norm = 1\nu_max = [-5, 1]", "control.u_max[0]: is -5; it must be greater than 0"),
        ('u_norm = 1\nsaturate = "scale"', "leave u_norm out and give control.u_max = 0.707106, which keeps |u| within 1"),
        ("u_norm = 1\nreserve = 2", "control.reserve: is read where"),
    ],
)
def test_a_norm_that_cannot_be_kept_is_refused_with_the_reason(control: str, message: str) -> None:
    with pytest.raises(BadInput, match=re.escape(message)):
        parse_task(CONTINUOUS.replace("u_norm = 1.5", control))


def test_only_tubes_whose_needs_are_known_have_a_norm() -> None:
    with pytest.raises(BadInput, match=r"control\.u_norm: is for refined tubes"):
        parse_task(CONTINUOUS.replace("[tube]", '[tube]\ndesign = "adaptive"'))


def test_the_rover_of_the_page_has_wheels_that_allow_the_norm() -> None:
    """|u| = 1.5 in any direction turns no wheel faster than 1.93 m/s, and some direction one faster than 1.92 m/s."""
    angles = np.linspace(0, 2 * math.pi, 10001)
    forward, sideways = 1.5 * np.cos(angles), 1.5 * np.sin(angles)
    wheels = np.array([forward + sign * 0.2 * sideways / 0.25 for sign in (1, -1)])
    assert 1.92 < np.abs(wheels).max() <= 1.5 * 1.281 <= 1.93
    text = (ROOT / "docs" / "task.md").read_text()
    assert "sqrt(1 + 0.8^2), less than 1.281 times |u|" in text
