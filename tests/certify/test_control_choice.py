"""What is chosen for a task with a period: the gain that rests inside the tube, the limit of u, the plant that is assumed."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import stt_codegen as stt
from stt_codegen.certify.sampled.control_choice import PERIOD_WITH_MARGIN
from stt_codegen.certify.sampled.period import _bound
from stt_codegen.controller import edge_and_rate_errors
from stt_codegen.designs import require_refined
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.report import control_notes
from stt_codegen.report.figures.control_notes import choice_lines
from stt_codegen.sampling import LIMIT_FACTORS, exact_loop, loop_of, needed_input, path_loop_of
from stt_codegen.sampling.path import PathLoop, prove_path, resting_gain, with_gain
from stt_codegen.task import parse_task
from tests.support.checked_files import (
    REFUSED,
    VERIFIED,
    Files,
    certificate_of,
    verdict,
    verdict_of_proof,
    with_certificate,
    with_hashes,
)
from tests.support.controllers import ROOT, build_once, controller_of

CART = """
name = "cart"
prescribed_time = 6.0
initial_state = [0.5, 0.5]

[state_space]
lower = [0.0, 0.0]
upper = [4.0, 3.0]

[initial_set]
lower = [0.0, 0.0]
upper = [1.0, 1.0]

[target_set]
lower = [3.0, 2.0]
upper = [4.0, 3.0]

[[unsafe]]
name = "pillar"
lower = [1.6, 0.8]
upper = [2.2, 1.8]

[tube]
clearance = 0.05

[control]
period = 0.02
"""
STATED = CART + "\n[plant]\nw_max = 0.1\ng_min = 0.95\ng_max = 1.05\nnoise = 0.002\n"
LATE = STATED + "lag = 0.08\n"
EXACT = CART + "\n[plant]\nexact = true\n"
HASTY = STATED.replace("period = 0.02", "period = 0.09").replace("w_max = 0.1", "w_max = 0.45")


def path_loop(controller: EmittedController) -> PathLoop:
    """Return the loop for which the gain was chosen."""
    design = require_refined(controller.design)
    errors = edge_and_rate_errors(design, controller.program)
    loop = path_loop_of(controller.task, design, exact_loop(controller.task, design, *errors))
    return loop.with_period(controller.task.sampling_period * PERIOD_WITH_MARGIN)


def files_of(controller: EmittedController, text: str) -> Files:
    return {**controller.files, "task.toml": text.encode()}


def forces(controller: EmittedController) -> list[Fraction]:
    return [bounds.force for bounds in controller.task.plant_bounds]


def is_proved(loop: PathLoop, gain: list[Fraction], disturbance: list[Fraction], factor: Fraction) -> bool:
    return prove_path(with_gain(loop, gain, [(factor - 1) * v for v in disturbance])) is not None


@pytest.mark.parametrize("text", [CART, STATED, LATE, STATED.replace("period = 0.02", "period = 0.02\nrest = 0.5\nreserve = 2")])
def test_the_chosen_gain_is_proved_with_the_reserve_and_is_the_first_that_rests_within_the_error(text: str) -> None:
    """A gain that is a step smaller rests farther out, or is not proved with the reserve."""
    controller = build_once(parse_task(text))
    task, loop = controller.task, path_loop(controller)
    assert is_proved(loop, list(task.gain), forces(controller), task.reserve)
    for i, gain in enumerate(task.gain):
        resting = resting_gain(loop, i, task.resting_error)
        assert gain >= resting
        smaller = gain * Fraction(4, 5)
        alone = loop.component(i)
        is_too_small = smaller < resting or not is_proved(alone, [smaller], forces(controller)[i : i + 1], task.reserve)
        assert is_too_small


def test_a_larger_resting_error_gives_a_smaller_gain() -> None:
    gains = [
        build_once(parse_task(STATED.replace("period = 0.02", f"period = 0.02\nrest = {rest}"))).task.gain
        for rest in ("0.5", "0.7", "0.8")
    ]
    assert all(a > b > c for a, b, c in zip(*gains, strict=True))


def test_where_no_gain_has_the_whole_reserve_the_chosen_one_has_a_part_of_it() -> None:
    controller = build_once(parse_task(HASTY.replace("period = 0.09", "period = 0.09\nu_max = 1.35")))
    loop = path_loop(controller)
    assert not is_proved(loop, list(controller.task.gain), forces(controller), controller.task.reserve)
    assert is_proved(loop, list(controller.task.gain), forces(controller), Fraction(1))
    (line,) = choice_lines(controller)
    factor = re.search(r"proved also with ([\d.]+) times the disturbance", line)
    assert "with 1 times" not in line  # that is the task as it stands
    assert 1 <= float(factor[1] if factor else 1) < controller.task.reserve


DIFFERENCES = """
name = "mast"
prescribed_time = 20.0
initial_state = [0.5, 0.5]
[state_space]
lower = [0.0, 0.0]
upper = [6.0, 4.0]
[initial_set]
lower = [0.0, 0.0]
upper = [1.0, 1.0]
share = 0.5
[target_set]
lower = [4.6, 2.6]
upper = [5.8, 3.8]
[control]
period = 0.02
velocity = "differences"
[plant]
order = 2
w_max = 0.1
noise = 0.00005
lag = 0.02
"""


@pytest.mark.parametrize("text", [STATED, DIFFERENCES.replace("w_max = 0.1", "w_max = 0.06"), DIFFERENCES])
def test_the_factor_of_the_disturbance_that_is_printed_is_proved(text: str) -> None:
    """With a velocity by differences a larger disturbance makes the error of v larger, too."""
    controller = build_once(parse_task(text))
    (line,) = (v for v in choice_lines(controller) if v.startswith("gain"))
    factor = Fraction(([*re.findall(r"proved also with ([\d.]+) times the disturbance", line), "1"])[0])
    task, design = controller.task, require_refined(controller.design)
    assert task.plant.w_max is not None
    assert factor >= 1
    disturbed = task.with_choices(plant=task.plant.model_copy(update={"w_max": task.plant.w_max * factor}))
    errors = edge_and_rate_errors(design, controller.program)
    assert prove_path(path_loop_of(disturbed, design, exact_loop(disturbed, design, *errors))) is not None


def test_the_page_quotes_what_is_chosen_for_the_cart_of_the_readme() -> None:
    cart = (ROOT / "README.md").read_text().partition("```toml\n")[2].partition("```")[0]
    page = " ".join((ROOT / "docs" / "task.md").read_text().split())
    lines = list(choice_lines(build_once(parse_task(cart))))
    assert len(lines) == 2
    assert [line for line in lines if line not in page] == []


def test_what_is_said_of_a_bound_near_1_is_below_1() -> None:
    assert [_bound(Fraction(v)) for v in ("0.91234", "0.99996", "1.23456")] == [0.9124, 0.99996, 1.235]
    assert _bound(1 - Fraction(1, 10**30)) == 1


def test_with_a_velocity_by_differences_no_longer_period_is_said_to_be_proved() -> None:
    controller = build_once(parse_task(DIFFERENCES))
    (finding,) = (f for f in controller.certificate.findings if f.code == "P9")
    assert finding.margin == 0
    assert not any("times the period" in line for line in choice_lines(controller))


def test_a_tight_gain_is_said() -> None:
    controller = build_once(parse_task(STATED.replace("period = 0.02", 'period = 0.02\ngain = "tight"')))
    gains = ", ".join(f"{float(k):g}" for k in controller.task.gain)
    assert any(line.startswith(f"gain [{gains}] was chosen") for line in choice_lines(controller))


def test_a_tight_gain_keeps_the_state_nearer_to_the_middle_than_the_gentle_one() -> None:
    tight = build_once(parse_task(STATED.replace("period = 0.02", 'period = 0.02\ngain = "tight"'))).task
    assert all(a > 3 * b for a, b in zip(tight.gain, build_once(parse_task(STATED)).task.gain, strict=True))


def test_the_limit_is_one_and_a_half_times_what_is_needed_and_more_with_a_lag_only_where_that_is_not_proved() -> None:
    factors = list[Fraction]()
    for text in (CART, STATED, LATE, LATE.replace("lag = 0.08", "lag = 0.14")):
        controller = build_once(parse_task(text))
        task = controller.task
        assert task.has_chosen_limit
        assert task.u_max is not None
        design = require_refined(controller.design)
        needed = needed_input(loop_of(task, design, *edge_and_rate_errors(design, controller.program))).tolist()
        (factor,) = {
            min(LIMIT_FACTORS, key=lambda f: abs(f * v - u)) for u, v in zip(task.u_max, map(Fraction, needed), strict=True)
        }
        assert all(0 <= u - factor * Fraction(v) < u / 100 for u, v in zip(task.u_max, needed, strict=True))
        factors.append(factor)
        if factor == LIMIT_FACTORS[0]:
            continue
        assert task.has_late_input
        smaller = LIMIT_FACTORS[LIMIT_FACTORS.index(factor) - 1]
        limited = task.changed(control={"u_max": [f"{float(smaller) * v:.3g}" for v in needed]})
        with_less = build_task(limited, uncertified=True)
        assert not is_proved(path_loop(with_less), list(with_less.task.gain), forces(with_less), task.reserve)
    assert factors == [Fraction(3, 2)] * 3 + [Fraction(9, 5)]


def test_a_limit_that_is_chosen_is_told_and_a_task_without_a_period_is_warned() -> None:
    controller = build_once(parse_task(STATED))
    assert any(line.startswith("u_max [") and "1.51 times" in line for line in choice_lines(controller))
    for name in ("cart.h", "cart.c", "cart.py"):
        text = re.sub(r"\s[*#]?\s*", " ", controller.files[name].decode())
        assert "which was chosen" in text
    (note,) = control_notes(parse_task(CART.replace("period = 0.02", "")), 59.3)
    assert "it may reach 59.3; state control.u_max, or control.period" in note
    assert not list(control_notes(parse_task(CART.replace("period = 0.02", "u_max = 2")), 59.3))


def test_the_assumed_plant_is_a_fifth_of_g_and_a_tenth_of_the_fastest_edge() -> None:
    controller = build_once(parse_task(CART))
    sampled = json.loads(controller.files["cart.certificate.json"])["sampled"]["plant"]
    assert (sampled["g_min"], sampled["g_max"], sampled["f_max"], sampled["noise"]) == ("4/5", "6/5", None, None)
    for w, speed in zip(sampled["w_max"], require_refined(controller.design).edge_speed_bounds(), strict=True):
        assert 0 <= Fraction(w) - speed / 10 < speed / 1000
    for name in ("cart.h", "cart.c", "cart.py"):
        assert "(assumed, as [plant] states no bounds)" in re.sub(r"\s[*#]?\s*", " ", controller.files[name].decode())
    (note,) = control_notes(controller.task, None)
    assert note.startswith("assumed, as [plant] states no bounds: g from 0.8 to 1.2, disturbances up to [")


def test_a_plant_that_is_stated_is_taken_as_it_is() -> None:
    assert not parse_task(EXACT).assumes_plant
    assert not parse_task(STATED).assumes_plant
    assert not parse_task(CART.replace("period = 0.02", "")).assumes_plant
    assert parse_task(CART + "\n[plant]\norder = 1\nexact = false\n").assumes_plant
    plant = json.loads(build_once(parse_task(EXACT)).files["cart.certificate.json"])["sampled"]["plant"]
    assert set(plant.values()) == {None}
    assert "assumed" not in build_once(parse_task(EXACT)).files["cart.h"].decode()
    notes = list(control_notes(build_once(parse_task(EXACT)).task, None))
    assert notes == ["[plant] has neither noise nor lag; no sensor is exact, and no drive is immediate"]
    assert not list(control_notes(build_once(parse_task(STATED)).task, None))


def test_what_was_chosen_is_open_again_in_a_changed_task() -> None:
    task = build_once(parse_task(CART)).task
    assert task.changed(name="cart") == parse_task(CART)
    assert task.changed(name="cart").digest == task.digest == parse_task(CART).digest
    assert task.with_gain(task.gain).changed(name="cart").gain == task.gain


@pytest.mark.parametrize("text", [CART, STATED, LATE, EXACT], ids=["assumed", "stated", "late", "exact"])
def test_the_checker_verifies_what_was_chosen(text: str, tmp_path: Path) -> None:
    assert verdict(files_of(build_once(parse_task(text)), text), tmp_path).code == VERIFIED


@pytest.mark.parametrize("factor", ["0.99", "0.5", "1.01"])
def test_the_checker_refuses_an_assumed_disturbance_that_is_bent(factor: str, tmp_path: Path) -> None:
    files = files_of(build_once(parse_task(CART)), CART)
    certificate = certificate_of(files)
    plant = certificate["sampled"]["plant"]
    plant["w_max"] = [str(Fraction(v) * Fraction(factor)) for v in plant["w_max"]]
    result = verdict_of_proof(with_hashes(with_certificate(files, certificate)), tmp_path)
    assert result.code == REFUSED
    assert "the certificate's sampled plant is not the task's" in result.message


@pytest.mark.parametrize(("text", "claim"), [(CART, "g_min"), (EXACT, "w_max")])
def test_the_checker_assumes_a_plant_only_where_the_task_has_none(text: str, claim: str, tmp_path: Path) -> None:
    """The claim of one plant is not taken for the other."""
    other_text = EXACT if text is CART else CART
    sampled = json.loads(build_once(parse_task(other_text)).files["cart.certificate.json"])["sampled"]

    files = files_of(build_once(parse_task(text)), text)
    certificate = certificate_of(files)
    certificate["sampled"]["plant"][claim] = sampled["plant"][claim]
    assert verdict_of_proof(with_hashes(with_certificate(files, certificate)), tmp_path).code == REFUSED


@pytest.mark.parametrize("factor", ["0.5", "2"])
def test_the_checker_refuses_a_chosen_limit_that_the_proof_or_the_c_does_not_have(factor: str, tmp_path: Path) -> None:
    files = files_of(build_once(parse_task(STATED)), STATED)
    certificate = certificate_of(files)
    certificate["control"]["u_max"] = [str(Fraction(v) * Fraction(factor)) for v in certificate["control"]["u_max"]]
    assert verdict_of_proof(with_hashes(with_certificate(files, certificate)), tmp_path).code == REFUSED


@pytest.mark.parametrize(
    ("control", "plant", "message"),
    [
        ({"rest": "1"}, {}, "control.rest: is 1; it must be less than 1"),
        ({"rest": "0"}, {}, "control.rest: is 0; it must be greater than 0"),
        ({"reserve": "0.9"}, {}, "control.reserve: is 0.9; it must be 1 or greater"),
        ({"gain": "1", "rest": "0.5"}, {}, 'control.rest: is read where control.gain is "auto"'),
        ({"gain": "tight", "rest": "0.5"}, {}, 'control.rest: is read where control.gain is "auto"'),
        ({"gain": "1", "u_max": "2", "reserve": "2"}, {}, "control.reserve: is read where"),
        ({"period": None, "u_max": "auto"}, {}, 'control.u_max: is "auto", which needs control.period'),
        ({"period": None, "gain": "tight"}, {}, 'control.gain: is "tight", which needs control.period'),
        ({"gain": "gentle"}, {}, "control.gain: is the text 'gentle'"),
        ({"u_max": "tight"}, {}, "control.u_max: is the text 'tight'"),
        ({}, {"exact": True, "w_max": "0.1"}, "plant.exact: is true, so f = w = 0 and g = 1; leave plant.w_max out, or exact"),
        ({}, {"exact": 1}, "plant.exact: is the number 1; use true or false"),
    ],
)
def test_a_wrong_choice_is_named(control: dict[str, Any], plant: dict[str, Any], message: str) -> None:
    with pytest.raises(stt.BadInput, match=re.escape(message)):
        parse_task(CART).changed(control=control, plant=plant)


def test_a_shipped_task_of_integers_keeps_its_reserve() -> None:
    """The gantry computes in integers; its gain is gentle too, and its limits are stated."""
    controller = controller_of("gantry")
    assert not controller.task.has_chosen_limit
    loop = path_loop(controller)
    assert is_proved(loop, list(controller.task.gain), forces(controller), controller.task.reserve)


SHARED = """
name = "shared"
prescribed_time = 12
initial_state = [0.5, 0.5]
state_space = { lower = [0, 0], upper = [5, 5] }
initial_set = { lower = [0.2, 0.2], upper = [0.8, 0.8] }
target_set = { lower = [4, 4], upper = [4.8, 4.8] }
control = { period = 0.02, u_norm = 1.2 }
plant = { w_max = [0.01, 0.2], noise = 0.001 }
"""


@pytest.mark.parametrize(
    ("u_max", "beginning"),
    [
        (["0.4", "5"], "u_max 0.630297 of dimension 2 was chosen: 1.21 times"),
        (["4", "5"], "u_max [0.496, 0.781] was chosen: 1.5 times"),
        (["0.4", "0.6"], ""),
    ],
)
def test_no_limit_that_the_task_states_is_said_to_be_chosen(u_max: list[str], beginning: str) -> None:
    task = parse_task(SHARED).changed(control={"u_max": u_max})
    lines = [line for line in choice_lines(build_once(task)) if line.startswith("u_max")]
    assert len(lines) == bool(beginning)
    assert all(line.startswith(beginning) for line in lines)
