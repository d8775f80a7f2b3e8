"""`emit.selftest`: passes for every right build, fails for a wrong number, a wrong sign, and arithmetic without NaN."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT

from stt_codegen.pipeline import Controller, build_task
from stt_codegen.task import parse_task

TASK = (ROOT / "tasks" / "omni_s2.toml").read_text()
MAIN = '#include "omni_s2.h"\nint main(void) { return omni_s2_selftest(); }\n'


def selftested(design: str, scalar: str, more: str = "") -> Controller:
    return build_task(parse_task(f"{TASK}\n[emit]\nselftest = true\n{more}").with_options(design, scalar))


def answer(controller: Controller, compiler: str, flags: list[str], folder: Path, bend: tuple[str, str] | None = None) -> int:
    for name, data in controller.files.items():
        text = data.decode()
        if bend is not None and name == "omni_s2.c":
            assert bend[0] in text
            text = text.replace(*bend, 1)
        (folder / name).write_text(text)
    (folder / "main.c").write_text(MAIN)
    command = [compiler, *flags, "main.c", "omni_s2.c", "omni_s2_selftest.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run([folder / "main"], check=False).returncode


@pytest.mark.parametrize(("design", "more"), [("refined", ""), ("refined", 'math = "inline"'), ("adaptive", "")])
@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_every_right_build_passes(design: str, more: str, scalar: str, compiler: str, tool, tmp_path) -> None:
    """Fused multiply-add and the compiler's own idea of order within the standard included."""
    controller = selftested(design, scalar, more)
    for flags in (["-std=c99", "-O0"], ["-std=c99", "-O2"], ["-O3", "-mfma", "-ffp-contract=fast"]):
        assert answer(controller, tool(compiler), flags, tmp_path) == 0, flags


@pytest.mark.parametrize(
    "bend",
    [
        ("? (-0.5F) : 0.5F", "? 0.5F : 0.5F"),
        ("? (-0.5F) : 0.5F", "? (-0.501F) : 0.5F"),
        ("room * 0.005F", "room * 0.006F"),
        ("const bool within = 0.0F < nearest", "const bool within = -1.0F < nearest"),
        ("logf(v0)", "log2f(v0)"),
    ],
)
def test_a_wrong_controller_fails(bend: tuple[str, str], tool, tmp_path) -> None:
    assert answer(selftested("refined", "float"), tool("gcc"), ["-O2"], tmp_path, bend) > 0


def test_a_changed_coefficient_in_any_quarter_of_the_table_fails(tool, tmp_path) -> None:
    controller = selftested("refined", "float")
    literals = re.findall(r"-?\d\.\d+(?:e-?\d+)?F", controller.files["omni_s2.c"].decode())
    for k in (20, 50, 80, 110):
        assert answer(controller, tool("gcc"), ["-O2"], tmp_path, (literals[k], f"{float(literals[k][:-1]) + 0.01}F")) > 0


def test_arithmetic_without_nan_is_found(tool, tmp_path) -> None:
    """The refusal to compile with -ffast-math taken out: the last vector finds it."""
    controller = selftested("refined", "float")
    flags = ["-O2", "-ffinite-math-only", "-D__FINITE_MATH_ONLY__=0", "-Wno-builtin-macro-redefined"]
    assert answer(controller, tool("gcc"), flags, tmp_path, ("#error", "#warning")) == 13


def test_without_the_request_there_is_none() -> None:
    files = build_task(parse_task(TASK)).files
    assert "omni_s2_selftest.c" not in files
    assert b"selftest" not in files["omni_s2.h"]
