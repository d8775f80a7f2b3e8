"""The emitted C on emulated boards: results within the reference's bounds, the same counts on every run, a message without tools."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

from stt_codegen.board import emulated
from stt_codegen.board.boards import BOARDS
from stt_codegen.board.emulated import Emulated, run_on_board
from stt_codegen.cli.main import app
from stt_codegen.errors import MissingTool
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.task import load_task
from tests.support.controllers import ROOT, build_once

INSTRUCTION_LIMITS = {"refined": 330, "adaptive": 1300}  # instructions of the longest control step on a Cortex-M4F, n = 2


def controller_of_design(design: str, scalar: str = "float", name: str = "omni_s2") -> EmittedController:
    """Return the controller of an example task with this kind of design and this scalar type."""
    return build_once(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design, scalar))


@pytest.mark.parametrize("board", ["m4f", "m3"])
@pytest.mark.parametrize("design", ["refined", "adaptive"])
def test_a_cortex_m_agrees_with_the_reference_within_the_bounds(design: str, board: str, tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    rows, costs = run_on_board(controller_of_design(design), BOARDS[board], 2000)
    assert {r.quantity for r in rows} >= {"tube", "tube rate", "e", "epsilon", "xi", "u", "status"}
    assert all(r.holds for r in rows), [r for r in rows if not r.holds]
    assert all(r.points >= 2000 for r in rows)
    if board == "m4f":
        assert costs["control"].maximum <= INSTRUCTION_LIMITS[design]


def test_double_precision_runs_on_a_board_too(tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    rows, _ = run_on_board(controller_of_design("refined", "double", "spacecraft"), BOARDS["m7"], 200)
    assert all(r.holds for r in rows)


def test_integers_on_a_cortex_m0_have_the_bits_of_the_python_and_take_few_instructions(tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    for name, instruction_limit in (("gantry", 800), ("crane", 1000)):
        rows, costs = run_on_board(controller_of_design("refined", "fixed", name), BOARDS["m0"], 1000)
        assert {r.quantity for r in rows} >= {"tube", "u", "status", "margin", "bits as Python's"}
        assert all(r.holds for r in rows), [r for r in rows if not r.holds]
        assert costs["control"].maximum <= instruction_limit


def test_counts_are_the_same_in_every_run_and_do_not_depend_on_the_other_points(tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    t = np.linspace(-1, 10, 40, dtype=np.float32)
    counts = []
    for order in (slice(None), slice(None), slice(None, None, -1)):
        board = Emulated(controller_of_design("refined"), BOARDS["m4f"])
        board.tube(t[order])
        counts.append(np.rint(board.counts["tube"].costs)[order])
    assert np.array_equal(counts[0], counts[1])
    assert np.array_equal(counts[0], counts[2])


def test_host_and_board_compute_the_same_bits_where_no_library_is_called(tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    controller = controller_of_design("refined")
    t = np.linspace(0, 9, 300, dtype=np.float32)
    for on_host, on_board in zip(CompiledC(controller).tube(t), Emulated(controller, BOARDS["m4f"]).tube(t), strict=True):
        assert np.array_equal(on_host, on_board)  # the tube calls no library function


def test_without_a_tool_the_message_says_what_to_install(monkeypatch) -> None:
    monkeypatch.setattr(emulated.shutil, "which", lambda _: None)
    with pytest.raises(MissingTool, match="qemu-system-arm"):
        Emulated(controller_of_design("refined"), BOARDS["m4f"])
    result = CliRunner().invoke(app, ["pil", str(ROOT / "tasks" / "omni_s2.toml"), "--board", "rv32"])
    assert isinstance(result.exception, MissingTool)
    assert "picolibc" in str(result.exception)
