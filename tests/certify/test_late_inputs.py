"""P9 for inputs that act late: certified tasks with a drive, what the checker refuses, refusals whose remedies work, fields of [plant]."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import stt_codegen as stt
from benchmarks.suites.remedies import follow_remedies, refusal_of
from stt_codegen.designs import require_refined
from stt_codegen.pipeline import EmittedController
from stt_codegen.properties import Property
from stt_codegen.report.figures.control_notes import choice_lines
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.path import PROVED_FACTORS
from stt_codegen.sampling.windows import refined_windows
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task
from stt_codegen.theorem.reading import read_facts
from tests.support.checked_files import REFUSED, VERIFIED, Files, verdict, verdict_of_proof, with_certificate, with_hashes
from tests.support.controllers import ROOT, build_once, controller_of

CART = """
name = "cart"
prescribed_time = 15.0
initial_state = [1.0, 1.2]
body = [0.35, 0.35]

[state_space]
lower = [0.0, 0.0]
upper = [12.0, 6.0]

[initial_set]
lower = [0.7, 0.9]
upper = [1.3, 1.5]
share = 0.8

[target_set]
lower = [10.6, 4.3]
upper = [11.4, 5.1]

[[unsafe]]
lower = [3.0, 0.0]
upper = [3.6, 3.0]

[[unsafe]]
lower = [6.5, 3.2]
upper = [7.1, 6.0]

[tube]
clearance = 0.05
min_width = 0.3
max_speed = 0.8

[control]
period = 0.02
u_max = 1.7

[plant]
w_max = 0.1
g_min = 0.95
g_max = 1.05
noise = 0.003
lag = 0.08
"""
DRONE = (ROOT / "tasks" / "drone.toml").read_text()
WATCHMAN = (ROOT / "tasks" / "watchman.toml").read_text()
RAIL = CART.replace("[10.6, 4.3]", "[10.6, 0.9]").replace("[11.4, 5.1]", "[11.4, 1.5]")
RAIL = RAIL[: RAIL.index("[[unsafe]]")] + RAIL[RAIL.index("[tube]") : RAIL.index("u_max")] + "[plant]\nlag = 0.08\n"
DRIVES = {
    "cart": CART,
    "an axis at rest": RAIL,
    "two lags, slew and overshoot": CART.replace("lag = 0.08", "lag = [0.05, 0.06]\nlag2 = 0.01\nslew = 40.0\novershoot = 0.05"),
    "latency": CART.replace("lag = 0.08", "lag = 0.06").replace("period = 0.02", "period = 0.02\nlatency = 0.01"),
    "order 2": DRONE.replace("[plant]", "[plant]\nlag = [0.04, 0.04, 0.02]"),
    "integers": CART + '\n[emit]\nscalar = "fixed"\ntick_period = 0.001\n',
    "repeated, by recent bounds": WATCHMAN + "\n[control]\nperiod = 0.02\nu_max = 1.5\n[plant]\nw_max = 0.05\nlag = 0.08\n",
}


def task_of(name: str) -> Task:
    return parse_task(DRIVES[name])


def files_of(controller: EmittedController, text: str) -> Files:
    """Return the files of a controller with its task."""
    return {**controller.files, "task.toml": text.encode()}


def sampled_of(files: Files) -> dict[str, Any]:
    (name,) = (file for file in files if file.endswith(".certificate.json"))
    claim: dict[str, Any] = json.loads(files[name])["sampled"]
    return claim


def with_claim(files: Files, change: Callable[[dict[str, Any]], None]) -> Files:
    """Return the files with a changed claim about samples."""
    (name,) = (file for file in files if file.endswith(".certificate.json"))
    certificate = json.loads(files[name])
    change(certificate["sampled"])
    return with_certificate(files, certificate)


@pytest.mark.parametrize("name", DRIVES)
def test_a_task_with_a_drive_is_certified_and_the_checker_verifies_it(name: str, tmp_path: Path) -> None:
    controller = build_once(task_of(name))
    assert controller.certificate.holds
    files = files_of(controller, DRIVES[name])
    assert verdict(files, tmp_path).code == VERIFIED
    path = sampled_of(files)["path"]
    assert len(path) == controller.task.dimension
    assert any(v["history"] for v in path) == (name == "repeated, by recent bounds")


def test_what_design_says_of_slower_drives_is_proved() -> None:
    """The factor that is printed is proved, and the next one that is looked for is not."""
    controller = build_once(task_of("cart"))
    (line,) = (v for v in choice_lines(controller) if v.startswith("gain"))
    factor = Fraction(re.findall(r"([\d.]+) times the delay of the drive", line)[0])
    assert factor > 1
    lag, following = controller.task.drive_bounds[0].lag, PROVED_FACTORS[PROVED_FACTORS.index(factor) + 1]
    chosen = {"gain": controller.task.gain}
    assert build_once(parse_task(CART).changed(plant={"lag": lag * factor}, control=chosen)).certificate.holds
    with pytest.raises(stt.NotCertified, match=r"period \(P9\)"):
        build_once(parse_task(CART).changed(plant={"lag": lag * following}, control=chosen))


def test_the_carts_bound_is_that_of_its_path_and_its_header_says_what_is_assumed() -> None:
    controller = build_once(task_of("cart"))
    (finding,) = [f for f in controller.certificate.findings if f.subject is Property.PERIOD]
    header = " ".join(controller.files["cart.h"].decode().split())
    for text in (finding.statement, header.replace(" * ", " ")):
        assert "a drive that is no slower than a first-order lag of 0.08 s" in text
        assert "never below 1 - e^(-t/0.08)" in text
    proof = controller.certificate.proved_period
    assert proof is not None
    widths = refined_windows(require_refined(controller.design), FRACTIONS).wide.max(axis=0)
    for rho, path, width in zip(proof.rho, proof.paths, widths, strict=True):
        assert rho * path.nearest > width - path.nearest
    assert all(Fraction(8, 10) < (v - 1) / (v + 1) < Fraction(92, 100) for v in proof.rho)


def raised(value: str, factor: Fraction) -> str:
    return str(Fraction(value) * factor)


CHANGES: dict[str, Callable[[dict[str, Any]], None]] = {
    "a path that stays farther from the edge": lambda s: s["path"][0].update(
        nearest=raised(s["path"][0]["nearest"], Fraction(101, 100))
    ),
    "a smaller rho": lambda s: s["rho"].__setitem__(0, raised(s["rho"][0], Fraction(99, 100))),
    "a smaller u": lambda s: s["u"].__setitem__(0, raised(s["u"][0], Fraction(99, 100))),
    "no path": lambda s: s.pop("path"),
    "a path of one component": lambda s: s["path"].pop(),
    "recent bounds for a drive that needs more": lambda s: s["path"][0].update(history="1/10"),
    "another lag": lambda s: s["plant"].update(lag="1/100"),
    "no lag": lambda s: s["plant"].pop("lag"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_checker_refuses_a_changed_claim(change: str, tmp_path: Path) -> None:
    files = with_claim(files_of(build_once(task_of("cart")), CART), CHANGES[change])
    result = verdict_of_proof(files, tmp_path)
    assert result.code == REFUSED, change
    assert "P9" in result.message or "sampled" in result.message or "path" in result.message


def test_the_checker_refuses_less_history_than_the_paths_need(tmp_path: Path) -> None:
    text = DRIVES["repeated, by recent bounds"]
    files = files_of(build_once(task_of("repeated, by recent bounds")), text)
    histories = [Fraction(v["history"]) for v in sampled_of(files)["path"]]
    for factor, code in ((Fraction(1), VERIFIED), (Fraction(1, 2), REFUSED)):

        def change(sampled: dict[str, Any], factor: Fraction = factor) -> None:
            for path, history in zip(sampled["path"], histories, strict=True):
                path["history"] = str(history * factor)

        assert verdict_of_proof(with_claim(files, change), tmp_path).code == code
    assert verdict_of_proof(with_claim(files, lambda s: [v.update(history=None) for v in s["path"]]), tmp_path).code == REFUSED


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("lag = 0.08", "lag = 0.11"),
        ("lag = 0.08", "lag = 0.08\nlag2 = 0.04"),
        ("lag = 0.08", "lag = 0.08\nslew = 15.0"),
        ("lag = 0.08", "lag = 0.08\novershoot = 0.2"),
        ("period = 0.02", "period = 0.08"),
        ("period = 0.02", "period = 0.02\nlatency = 0.06"),
        ("w_max = 0.1", "w_max = 0.4"),
        ("share = 0.8", "share = 0.92"),
    ],
)
def test_the_checker_refuses_the_proof_for_a_harder_task(old: str, new: str, tmp_path: Path) -> None:
    """The claim is changed with the task, so that the paths alone can refuse it."""
    assert old in CART
    text = CART.replace(old, new)
    task = parse_task(text)

    def change(sampled: dict[str, Any]) -> None:
        sampled.update(period=str(task.control.period), latency=str(task.control.latency), share=str(task.initial_set.share))
        sampled["plant"] = {k: None if v is None else str(v) for k, v in task.plant.bounds.items()}

    files = with_claim({**files_of(build_once(task_of("cart")), CART), "task.toml": text.encode()}, change)
    result = verdict_of_proof(with_hashes(files), tmp_path)
    assert result.code == REFUSED
    assert "P9 does not hold" in result.message


@pytest.mark.parametrize("name", ["cart", "order 2"])
def test_a_guard_needs_measured_positions_inside(name: str, tmp_path: Path) -> None:
    """Noise that the law endures may show a state in the tube outside, and a guard acts on what is measured."""
    noisy = {"cart": ("noise = 0.003\nlag = 0.08", "noise = 0.05\nlag = 0.06"), "order 2": ("noise = 0.005", "noise = 0.03")}[
        name
    ]
    text = DRIVES[name].replace(*noisy)
    controller = build_once(parse_task(text))
    guarded = text.replace("[control]\n", '[control]\noutside = "stop"\n')
    with pytest.raises(
        stt.NotCertified, match=r'control.outside = "stop" would act inside the tube; certified with control.outside = "return"'
    ):
        build_once(parse_task(guarded))
    quieter = parse_task(DRIVES[name].replace("[control]\n", '[control]\noutside = "stop"\n'))
    assert build_once(quieter).certificate.holds
    assert verdict(files_of(controller, text), tmp_path).code == VERIFIED
    files = {**files_of(controller, text), "task.toml": guarded.encode()}
    result = verdict_of_proof(with_hashes(files), tmp_path)
    assert result.code == REFUSED
    assert "the guard may act inside the tube, by noise of" in result.message


@pytest.mark.parametrize("history", ["0", "-1", "1/0"])
def test_the_checker_refuses_paths_without_a_distance_or_with_a_history_that_is_none(history: str, tmp_path: Path) -> None:
    files = files_of(build_once(task_of("cart")), CART)
    for change in ({"history": history}, {"nearest": None, "history": "1/100"}):
        result = verdict_of_proof(with_claim(files, lambda s, v=change: s["path"][0].update(v)), tmp_path)
        assert result.code == REFUSED
    result = verdict_of_proof(with_claim(files, lambda s: s.update(rho=["-1", *s["rho"][1:]])), tmp_path)
    assert result.code == REFUSED


def test_a_latency_alone_is_proved_by_the_path_and_sharp_conditions_are_for_inputs_that_act_at_once() -> None:
    for name, is_late in (("trolley", True), ("crawler", False)):
        proof = controller_of(name).certificate.proved_period
        assert proof is not None
        assert bool(proof.paths) == is_late == controller_of(name).task.has_late_input


def test_the_path_proves_periods_that_the_sharp_conditions_do_not(tmp_path: Path) -> None:
    text = CART.replace("lag = 0.08", "").replace("period = 0.02", "period = 0.14").replace("u_max = 1.7", "u_max = 1.4")
    controller = build_once(parse_task(text))
    proof = controller.certificate.proved_period
    assert proof is not None
    assert proof.paths
    assert verdict(files_of(controller, text), tmp_path).code == VERIFIED


@pytest.mark.parametrize("lag", ["0.13", "0.16"])
def test_every_remedy_of_a_refusal_works(lag: str) -> None:
    """Each remedy alone is put into the task."""
    text = CART.replace("lag = 0.08", f"lag = {lag}")
    task = parse_task(text)
    assert refusal_of(task).startswith("period (P9): ")
    assert follow_remedies(task)


def test_a_drive_that_no_gain_can_use_is_refused_with_the_tubes_width_over_speed() -> None:
    refusal = r"in dimension 2 the input is late by 1\.5\d* s \(.*\); the state crosses the tube in 0\.\d+ s"
    with pytest.raises(stt.NotCertified, match=refusal):
        build_once(parse_task(CART.replace("lag = 0.08", "lag = 1.5")))


@pytest.mark.parametrize(
    ("plant", "control", "message"),
    [
        ({"lag": "-0.1"}, {}, "plant.lag: is -0.1; it must be 0 or greater"),
        ({"lag": ["0.1", "-0.1"]}, {}, r"plant.lag\[1\]: is -0.1"),
        ({"lag": ["0.1"]}, {}, "plant.lag: has 1 entries"),
        ({"slew": "0"}, {}, "plant.slew: is 0; it must be greater than 0"),
        ({"overshoot": "1"}, {}, "plant.overshoot: is 1; it must be less than 1"),
        ({"slew": "3"}, {"period": None}, "control.period: is missing; with plant.slew a proof needs the time between samples"),
    ],
)
def test_a_wrong_drive_is_named(plant: dict[str, Any], control: dict[str, Any], message: str) -> None:
    with pytest.raises(stt.BadInput, match=message):
        task_of("cart").changed(plant={"lag": None, **plant}, control=control)


def test_an_overshoot_makes_what_moves_the_plant_larger() -> None:
    task = task_of("two lags, slew and overshoot")
    amplification = 1 + 2 * Fraction(5, 95)
    assert task.largest_derivative([Fraction(1), Fraction(1)]) == (Fraction(1, 10) + Fraction(105, 100) * amplification,) * 2


def test_a_task_without_a_drive_keeps_its_certificates_keys() -> None:
    assert set(sampled_of(controller_of("crawler").files)) == {"period", "latency", "share", "plant", "rho", "u", "shift"}
    assert set(load_task(ROOT / "tasks" / "crawler.toml").plant.bounds) == {
        "f_max",
        "w_max",
        "g_min",
        "g_max",
        "g_cross",
        "noise",
    }


def test_no_theorem_is_about_a_loop_with_a_drive() -> None:
    files = files_of(build_once(task_of("cart")), CART)
    facts = read_facts(files["task.toml"], files["cart.c"], files["cart.certificate.json"])
    assert facts.uncovered_loop_feature == "a drive of [plant]"
    assert facts.sampling is None
