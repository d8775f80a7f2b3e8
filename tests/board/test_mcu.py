"""`python -m benchmarks mcu`: sizes add up, rivals compute the same law, the tables are whole, a controller beyond its bounds is exit code 1."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.command_line import suites
from benchmarks.suites import mcu, rivals
from stt_codegen.board.boards import BOARDS
from stt_codegen.board.emulated import Emulated
from stt_codegen.program.targets.c.runner import CompiledC
from tests.support.controllers import controller_of
from tests.support.missing_tools import skip_without


@pytest.fixture
def board(tool) -> Any:
    for name in ("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"):
        tool(name)
    return BOARDS["m4f"]


def points(controller: Any, count: int = 300) -> tuple[np.ndarray, ...]:
    """Times and states inside the tube, where a rival need not know what a status is."""
    random = np.random.default_rng(5)
    t = random.uniform(0, 9, count).astype(np.float32)
    alpha = np.full((count, 4), 0.1, np.float32)
    stateful = any(p.name == "alpha" for p in controller.program.function("control").params)
    low, high = CompiledC(controller).tube(t, alpha) if stateful else CompiledC(controller).tube(t)
    x = (low + (high - low) * random.uniform(0.1, 0.9, low.shape)).astype(np.float32)
    wide = ((high - low) > 0.1).all(axis=1)
    return tuple(v[wide] for v in ((t, alpha, x) if stateful else (t, x)))


@pytest.mark.parametrize(("design", "single"), [("refined", False), ("refined", True), ("adaptive", False), ("adaptive", True)])
def test_casadis_own_c_is_the_same_law(design: str, single: bool, board: Any) -> None:
    controller = mcu.variant(design, "float", "libm")
    ours = CompiledC(controller).control(*points(controller))[1]
    text = rivals.casadi_text(controller, single)
    other = replace(controller, files={**controller.files, f"{controller.task.name}.c": text.encode()})
    theirs = Emulated(other, board, extra_flags=("-w",)).call("control", *points(controller))[1]
    assert np.max(np.abs(ours - theirs) / (1 + np.abs(ours))) < 1e-3


def test_the_hand_written_c_is_the_same_law_and_tells_the_same_statuses(board: Any) -> None:
    controller = mcu.variant("refined", "float", "libm")
    t, x = points(controller)
    x[::5] += 3.0
    x[1, 0] = np.nan
    status, ours = CompiledC(controller).control(t, x)
    other = replace(controller, files={**controller.files, "arena.c": rivals.hand_text(controller).encode()})
    got, theirs = Emulated(other, board, extra_flags=("-w",)).call("control", t, x)
    assert np.array_equal(got, status)
    assert set(status) == {0, 1, 2}
    assert np.max(np.abs(ours - theirs) / (1 + np.abs(ours))) < 1e-3


def test_single_precision_text_has_no_call_or_literal_in_double_left() -> None:
    text = rivals.casadi_text(mcu.variant("refined", "float", "libm"), True)
    body = text[text.index("static int casadi_f0") :]
    assert not rivals._LITERAL.search(body)
    assert "log(" not in body.replace("logf(", "")


def test_sizes_are_of_what_control_needs(board: Any) -> None:
    controller = controller_of("omni_s2")
    code, tables, ram = mcu.sizes(controller, board)
    assert tables == 4 * len(controller.program.table("coefficients").values)
    assert ram == 0
    assert 0 < mcu.sizes(controller, board, "tube")[0] < code < 2048 - tables


@pytest.mark.slow
def test_the_whole_run_in_small(board: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(mcu, "VARIANTS", mcu.VARIANTS[:2])
    monkeypatch.setattr(mcu, "DIMENSIONS", (1, 3))
    monkeypatch.setattr(mcu, "CROWDS", (("empty", 0), ("paper", 4)))
    result = CliRunner().invoke(suites, ["mcu", "--board", "m4f", "--points", "40", "--json"])
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert document["within_bounds"] is True
    assert [v["label"] for v in document["boards"]] == ["refined", "refined, inline"]
    rust = [v for v in document["beside"] if "Rust" in v["label"]]
    assert len(document["beside"]) - len(rust) == 9
    if not rust:
        skip_without("Rust's core library for the board is not here; `.ci/tools integration` installs it")
    assert [v["within"] for v in rust] == [True, True]
    one, three = (v["most"] for v in document["by_dimension"])
    assert 2 < three / one < 3  # linear, less what there is once
    none, four = (v["most"] for v in document["by_obstacles"])
    assert abs(none - four) <= 15  # the same code; the logarithm takes another way now and then
    assert all(v["stack"] <= 128 for v in document["boards"])


def test_a_controller_beyond_its_bounds_is_an_exit_code(board: Any, monkeypatch: Any) -> None:
    def bent(*arguments: Any) -> Any:
        controller = original(*arguments)
        text = controller.files["arena.c"].replace(b"(-0.5F) : 0.5F", b"(-0.5F) : 0.6F")
        assert text != controller.files["arena.c"]
        controller.files["arena.c"] = text
        return controller

    original = mcu.variant
    monkeypatch.setattr(mcu, "variant", bent)
    monkeypatch.setattr(mcu, "beside", lambda *_: [])
    monkeypatch.setattr(mcu, "growth", lambda *_: ([], []))
    monkeypatch.setattr(mcu, "VARIANTS", mcu.VARIANTS[:1])
    result = CliRunner().invoke(suites, ["mcu", "--board", "m4f", "--points", "40"])
    assert result.exit_code == 1
    assert "| NO " in result.stdout
