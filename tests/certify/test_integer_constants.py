"""The constants of controllers in integers: the checker verifies what the tool writes for every option and law, and refuses every
other constant, also where C and certificate have it both."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from benchmarks.fixed import limited
from benchmarks.mutations import checked_tube
from stt_codegen.checker.stt_checker.exact import Refused
from stt_codegen.controller.integers.fixed_program import fixed_program
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_task
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.map.map_table import to_toml
from stt_codegen.task.task import document_of
from tests.controller.test_fixed import LAWS, design_of
from tests.support.checked_files import (
    REFUSED,
    VERIFIED,
    Files,
    certificate_of,
    recorded_files,
    verdict,
    with_certificate,
    with_text,
)
from tests.support.controllers import ROOT, controller_of

GANTRY, CRANE = ((ROOT / "tasks" / f"{name}.toml").read_text() for name in ("gantry", "crane"))


def edited(text: str, *changes: tuple[str, str]) -> str:
    """Return the text of a task with parts of it replaced."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


# ------------------------------------------------------------------------------------------------ what the tool writes is verified


CONTINUOUS = ("period = 0.01                 # s: ten ticks\n", "")
CRANE_CONTINUOUS = ("period = 0.02                 # s\n", "")
UNBOUNDED = (GANTRY[GANTRY.index("[plant]") : GANTRY.index("[emit]")], "")
# Near the origin of a large space: entries of its tables have 16 bits without a sign.
CORNER = """name = "corner"
prescribed_time = 4
initial_state = [0.5]
state_space = {lower = [0], upper = [20]}
initial_set = {lower = [0.2], upper = [0.8]}
target_set = {lower = [1.6], upper = [2.2]}
control = {u_max = [3]}
emit = {scalar = "fixed", tick_period = 0.001}
"""
SPACE = """name = "space"
prescribed_time = 6
initial_state = [0.5, 0.5, -0.5]
state_space = {lower = [-4, -4, -4], upper = [4, 4, 4]}
initial_set = {lower = [0.2, 0.2, -0.8], upper = [0.8, 0.8, -0.2]}
target_set = {lower = [2, 2, -3], upper = [2.6, 2.6, -2]}
control = {u_max = [3, 4, 5], gain = [0.5, 0.6, 0.7]}
emit = {scalar = "fixed", tick_period = 0.01, selftest = true}
plant = {w_max = 0.05}
"""
# Tasks by label: the text, and whether the recorded tube of its name is taken in place of a search.
TASKS = {
    "gains": (edited(GANTRY, ("u_max = [", "gain = [0.112, 0.12]\nu_max = [")), True),
    "another clamp": (edited(GANTRY, ("u_max = [", "e_max = 0.95\nu_max = [")), True),
    "fine ticks": (edited(GANTRY, ("tick_period = 0.001", "tick_period = 0.0001")), True),
    "limits of u": (edited(GANTRY, CONTINUOUS), True),
    "one dimension": (CORNER, False),
    "three dimensions": (SPACE, False),
    "order 2 without a period": (edited(CRANE, CRANE_CONTINUOUS, ("u_max = [", "gain = [0.4, 0.5]\nu_max = [")), True),
    "order 2, lambda of 15 bits": (
        edited(CRANE, CRANE_CONTINUOUS, ("[tube]\n", "[tube]\nfilter = [1.3, 0.7]\n"), ("[1.5, 1.5]", "[6, 6]")),
        False,
    ),
    "order 2, lambda of 14 bits": (
        edited(CRANE, CRANE_CONTINUOUS, ("[tube]\n", "[tube]\nfilter = [2.3, 0.7]\n"), ("[1.5, 1.5]", "[12, 12]")),
        False,
    ),
}


@cache
def files_of(label: str) -> Files:
    """Build the controller of an entry of TASKS, and return its files with the task."""
    text, has_recorded_tube = TASKS[label]
    task = parse_task(text)
    tube = controller_of(task.name, "fixed").design if has_recorded_tube else None
    return {**build_task(task, tube=tube).files, "task.toml": text.encode()}


@pytest.mark.parametrize("label", TASKS)
def test_the_controller_of_every_option_is_verified(label: str, tmp_path: Path) -> None:
    code, message = verdict(files_of(label), tmp_path)
    assert code == VERIFIED, message


@pytest.mark.parametrize(("name", "control"), LAWS)
def test_every_law_that_the_tool_writes_is_verified(name: str, control: dict[str, Any], tmp_path: Path) -> None:
    """The bounds of both on the error of u are computed in different ways."""
    task = limited(load_task(ROOT / "tasks" / f"{name}.toml"))
    task = task.model_copy(update={"control": task.control.model_copy(update=control)})
    text = to_toml(document_of(task))
    try:
        controller = build_task(parse_task(text), tube=design_of(name))
    except BadInput as refusal:
        assert "control.u_max: in integers of 32 bits the least of u_max" in str(refusal)
        return
    code, message = verdict({**controller.files, "task.toml": text.encode()}, tmp_path)
    assert code == VERIFIED, message


# ------------------------------------------------------------------------------------------------ other constants are refused


def bent_constants(constants: dict[str, int]) -> list[dict[str, Any]]:
    """Return constants with one key that has another value or type, is left out or is added."""
    bent: list[dict[str, Any]] = [{**constants, "more": 1}, {}]
    for key, value in constants.items():
        bent_values = (
            value + 1,
            value - 1,
            2 * value,
            value // 2,
            0,
            -1,
            -value,
            1 << 31,
            1 << 70,
            True,
            str(value),
            [value],
            None,
        )
        bent += [{**constants, key: v} for v in bent_values if v is True or v != value]
        bent.append({k: v for k, v in constants.items() if k != key})
    return bent


@pytest.mark.parametrize("name", ["gantry", "crane"])
def test_every_bent_constant_is_refused(name: str, tmp_path: Path) -> None:
    files = recorded_files(name, "fixed")
    certificate = certificate_of(files)
    for constants in bent_constants(certificate["integers"]):
        code, message = verdict(with_certificate(files, {**certificate, "integers": constants}), tmp_path)
        assert code == REFUSED, (constants, message)
    for missing in ({}, {"integers": None}, {"integers": 1}, {"integers": []}):
        changed = {k: v for k, v in certificate.items() if k != "integers"} | missing
        assert verdict(with_certificate(files, changed), tmp_path).code == REFUSED


@pytest.mark.parametrize(
    ("name", "constant", "value", "message"),
    [
        ("gantry", "smallest_width", 262144, "wider than it is"),
        ("gantry", "smallest_width", 1, "before it is at its limit"),
        ("gantry", "largest_e", 1062000000, "wrong by more than 2.-10"),  # e is clamped before e_max
        ("gantry", "largest_e", (1 << 30) - 1, "wrong by more than 2.-10"),
        ("gantry", "smallest_y", 11000000, "wrong by more than 2.-10"),
        ("gantry", "smallest_y", 9000000, "wrong by more than 2.-10"),
        ("gantry", "clock_scale", 34359739, "other ticks"),
        ("crane", "smallest_x_width", 1 << 29, "smallest width"),
        ("crane", "smallest_width", 1 << 19, "wider than it is"),
        ("crane", "rate_mantissa", 43600, "P7"),
        ("crane", "rate_bits", 12, "P7"),
    ],
)
def test_another_constant_of_c_and_certificate_is_refused(
    name: str, constant: str, value: int, message: str, tmp_path: Path
) -> None:
    """So that the file is a listing: only the proof can refuse it."""
    files = recorded_files(name, "fixed")
    certificate = certificate_of(files)
    old = certificate["integers"][constant]
    shift = "crane_shift_down(d1_per_second, "
    pair = (f"{shift}{old})", f"{shift}{value})") if constant == "rate_bits" else (str(old), str(value))
    changed = with_text(files, f"{name}.c", *pair)
    certificate = certificate_of(changed)
    certificate["integers"][constant] = value
    code, text = verdict(with_certificate(changed, certificate), tmp_path)
    assert code == REFUSED
    assert re.search(message, text), text


@pytest.mark.parametrize(
    ("name", "constant", "value"),
    [
        ("gantry", "smallest_y", 0),
        ("gantry", "smallest_y", 1 << 10),  # for which the curves have no rows
        ("gantry", "smallest_width", 0),
        ("gantry", "smallest_width", 1 << 30),
        ("gantry", "largest_e", 1 << 30),
        ("gantry", "largest_e", -1),
        ("crane", "smallest_x_width", 0),
        ("crane", "rate_mantissa", 1 << 16),
        ("crane", "rate_mantissa", 0),
        ("crane", "rate_shift", 13),  # weights above 16 bits
        ("crane", "rate_bits", 0),  # rates above 28 bits
    ],
)
def test_a_constant_out_of_range_is_refused(name: str, constant: str, value: int) -> None:
    """These are constants that the C could have as well, so that only the proof of the ranges can refuse them."""
    _, tube, target = checked_tube(recorded_files(name, "fixed"))
    assert target is not None
    target.stated = {**target.stated, constant: value}
    with pytest.raises(Refused, match="out of range|no row"):
        target._check_ranges(tube)


@pytest.mark.parametrize(("constant", "value"), [("clock_bits", 17), ("clock_scale", 0), ("clock_scale", 34359739)])
def test_another_clock_is_refused(constant: str, value: int) -> None:
    _, tube, target = checked_tube(recorded_files("gantry", "fixed"))
    assert target is not None
    target.stated = {**target.stated, constant: value}
    with pytest.raises(Refused, match="other ticks"):
        target.check_clock(tube)


@pytest.mark.parametrize("name", ["gantry", "crane"])
def test_units_that_are_too_coarse_are_refused_by_tool_and_checker(name: str) -> None:
    """P9 allows for x with an error of 2^-20 of the largest coordinate, and x is rounded to its unit."""
    recorded = controller_of(name, "fixed")
    assert isinstance(recorded.design, RefinedDesign)
    coarse = tuple(tuple((round(a / 4), round(b / 4)) for a, b in row) for row in recorded.design.table)
    with pytest.raises(BadInput, match="which is too coarse"):
        fixed_program(recorded.task, replace(recorded.design, bits=recorded.design.bits - 2, table=coarse))
    _, tube, target = checked_tube(recorded_files(name, "fixed"))
    assert target is not None
    with pytest.raises(Refused, match="units of x are too large"), mock.patch.object(tube, "unit", 4 * tube.unit):
        target._check_ranges(tube)
