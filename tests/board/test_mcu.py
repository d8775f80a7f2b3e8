"""`python -m benchmarks mcu`: sizes, other implementations that compute the same law, complete tables, and the exit code where a
controller exceeds its bounds."""

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
    """Return the board m4f; without its tools the test is skipped."""
    for name in ("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"):
        tool(name)
    return BOARDS["m4f"]


def times_and_states(controller: Any, count: int = 300) -> tuple[np.ndarray, ...]:
    """Return times, alpha where there is one, and states inside the tube; another implementation need not know a status."""
    random = np.random.default_rng(5)
    t = random.uniform(0, 9, count).astype(np.float32)
    alpha = np.full((count, 4), 0.1, np.float32)
    has_alpha = any(p.name == "alpha" for p in controller.program.function("control").params)
    low, high = CompiledC(controller).tube(t, alpha) if has_alpha else CompiledC(controller).tube(t)
    x = (low + (high - low) * random.uniform(0.1, 0.9, low.shape)).astype(np.float32)
    is_wide = ((high - low) > 0.1).all(axis=1)
    return tuple(v[is_wide] for v in ((t, alpha, x) if has_alpha else (t, x)))


@pytest.mark.parametrize(("design", "single"), [("refined", False), ("refined", True), ("adaptive", False), ("adaptive", True)])
def test_the_c_that_casadi_prints_computes_the_same_law(design: str, single: bool, board: Any) -> None:
    controller = mcu.arena_controller(design, "float", "libm")
    u = CompiledC(controller).control(*times_and_states(controller))[1]
    text = rivals.casadi_text(controller, single)
    casadi_controller = replace(controller, files={**controller.files, f"{controller.task.name}.c": text.encode()})
    casadi_u = Emulated(casadi_controller, board, extra_flags=("-w",)).call("control", *times_and_states(controller))[1]
    assert np.max(np.abs(u - casadi_u) / (1 + np.abs(u))) < 1e-3


def test_the_hand_written_c_computes_the_same_law_and_status(board: Any) -> None:
    controller = mcu.arena_controller("refined", "float", "libm")
    t, x = times_and_states(controller)
    x[::5] += 3.0
    x[1, 0] = np.nan
    status, u = CompiledC(controller).control(t, x)
    hand_controller = replace(controller, files={**controller.files, "arena.c": rivals.hand_text(controller).encode()})
    hand_status, hand_u = Emulated(hand_controller, board, extra_flags=("-w",)).call("control", t, x)
    assert np.array_equal(hand_status, status)
    assert set(status) == {0, 1, 2}
    assert np.max(np.abs(u - hand_u) / (1 + np.abs(u))) < 1e-3


def test_text_in_single_precision_has_no_call_or_literal_in_double() -> None:
    text = rivals.casadi_text(mcu.arena_controller("refined", "float", "libm"), True)
    body = text[text.index("static int casadi_f0") :]
    assert not rivals._LITERAL.search(body)
    assert "log(" not in body.replace("logf(", "")


def test_the_size_of_control_is_its_code_and_its_table(board: Any) -> None:
    controller = controller_of("omni_s2")
    code, tables, ram = mcu.sizes(controller, board)
    assert tables == 4 * len(controller.program.table("coefficients").values)
    assert ram == 0
    assert 0 < mcu.sizes(controller, board, "tube")[0] < code < 2048 - tables


@pytest.mark.slow
def test_a_small_run_has_complete_tables(board: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(mcu, "VARIANTS", mcu.VARIANTS[:2])
    monkeypatch.setattr(mcu, "DIMENSIONS", (1, 3))
    monkeypatch.setattr(mcu, "OBSTACLE_COUNTS", (("empty", 0), ("paper", 4)))
    result = CliRunner().invoke(suites, ["mcu", "--board", "m4f", "--points", "40", "--json"])
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert document["within_bounds"] is True
    assert [v["label"] for v in document["boards"]] == ["refined", "refined, inline"]
    rust = [v for v in document["beside"] if "Rust" in v["label"]]
    assert len(document["beside"]) - len(rust) == 9
    if not rust:
        skip_without("Rust's core library for the board is not here; `.ci/tools integration` installs it")
    assert [v["within_bounds"] for v in rust] == [True, True]
    maximum_1, maximum_3 = (v["maximum"] for v in document["by_dimension"])
    assert 2 < maximum_3 / maximum_1 < 3  # linear in the dimension, plus a constant part
    maximum_empty, maximum_4 = (v["maximum"] for v in document["by_obstacles"])
    assert abs(maximum_empty - maximum_4) <= 15  # the code is the same; the logarithm sometimes takes another branch
    assert all(v["stack"] <= 128 for v in document["boards"])


def test_a_controller_beyond_its_bounds_is_an_exit_code(board: Any, monkeypatch: Any) -> None:
    def wrong_variant(*arguments: Any) -> Any:
        controller = original(*arguments)
        text = controller.files["arena.c"].replace(b"(-0.5F) : 0.5F", b"(-0.5F) : 0.6F")
        assert text != controller.files["arena.c"]
        return replace(controller, files={**controller.files, "arena.c": text})

    original = mcu.arena_controller
    monkeypatch.setattr(mcu, "arena_controller", wrong_variant)
    monkeypatch.setattr(mcu, "rival_costs", lambda *_: [])
    monkeypatch.setattr(mcu, "growth_costs", lambda *_: ([], []))
    monkeypatch.setattr(mcu, "VARIANTS", mcu.VARIANTS[:1])
    result = CliRunner().invoke(suites, ["mcu", "--board", "m4f", "--points", "40"])
    assert result.exit_code == 1
    assert "| NO " in result.stdout
