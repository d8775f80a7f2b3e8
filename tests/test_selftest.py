"""`emit.selftest`: passes for every right build, fails for a wrong number, a wrong sign, and arithmetic without NaN."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT

from stt_codegen.compare.backends import CompiledC
from stt_codegen.compare.comparison import compare_backend
from stt_codegen.pipeline import Controller, build_task
from stt_codegen.task import parse_task

TASK = (ROOT / "tasks" / "omni_s2.toml").read_text()
EMPTY = (ROOT / "tasks" / "empty.toml").read_text()
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


@pytest.mark.parametrize("segments", [4, 32, 100])
def test_a_changed_coefficient_anywhere_in_the_table_fails(segments: int, tool, tmp_path) -> None:
    """Every row, lower and upper edge, off by a twentieth of a metre (a 120th in the divided table)."""
    text = TASK.replace("min_width = 0.05", f"min_width = 0.05\nsegments = {segments}") if segments > 4 else EMPTY
    controller = build_task(parse_task(f"{text}\n[emit]\nselftest = true\n"))
    name = controller.task.name
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    source = (tmp_path / f"{name}.c").read_text()
    table = re.search(rf"static const {name}_real {name}_coefficients\[(\d+)\] = \{{", source)
    assert table
    # a copy that can be written to, and a main that bends one entry after the other
    (tmp_path / f"{name}.c").write_text(source.replace("static const " + table.group(0)[13:], table.group(0)[13:]))
    (tmp_path / "main.c").write_text(
        f'#include "{name}.c"\nint main(void)\n{{\n    if ({name}_selftest() != 0) return 1;\n'
        f"    for (int k = 0; k < {table.group(1)}; k++) {{\n        const float was = {name}_coefficients[k];\n"
        f"        {name}_coefficients[k] += 0.05F / 6.0F;\n        if ({name}_selftest() == 0) return 2;\n"
        f"        {name}_coefficients[k] = was;\n    }}\n    return 0;\n}}\n"
    )
    command = [tool("gcc"), "-std=c99", "-O1", "main.c", f"{name}_selftest.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0


@pytest.mark.parametrize(
    "bend",
    [
        ("running ? tick : 9000U", "running ? tick + 30U : 9000U"),
        ("part / 1125.0F", "part / 1126.0F"),
        ("place / 1125", "place / 1200"),
    ],
)
def test_wrong_time_in_ticks_fails(bend: tuple[str, str], tool, tmp_path) -> None:
    controller = selftested("refined", "float", "tick_period = 0.001")
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path) == 0
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path, bend) > 0


@pytest.mark.parametrize("limit", ["0.3", "3.0", "1000.0"])
@pytest.mark.parametrize("gain", ["-0.5", "20.0"])
def test_saturation_and_other_gains_pass_too(limit: str, gain: str, tool, tmp_path) -> None:
    text = TASK.replace("gain = 0.5", f"gain = {gain}\nu_max = [{limit}, {limit}]")
    assert text != TASK
    controller = build_task(parse_task(f"{text}\n[emit]\nselftest = true\n"))
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path) == 0


def test_another_designs_header_is_refused(tool, tmp_path) -> None:
    ours, other = selftested("refined", "float"), selftested("refined", "double")
    mixed = {**ours.files, "omni_s2_selftest.c": other.files["omni_s2_selftest.c"]}
    for name, data in mixed.items():
        (tmp_path / name).write_bytes(data)
    result = subprocess.run([tool("gcc"), "-c", "omni_s2_selftest.c"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "of another design" in result.stderr


def test_arithmetic_without_nan_is_found(tool, tmp_path) -> None:
    """The refusal to compile with -ffast-math taken out: the last vector finds it."""
    controller = selftested("refined", "float")
    calls = int(re.findall(r"omni_s2_expected\[(\d+)\]", controller.files["omni_s2_selftest.c"].decode())[0])
    flags = ["-O2", "-ffinite-math-only", "-D__FINITE_MATH_ONLY__=0", "-Wno-builtin-macro-redefined"]
    assert answer(controller, tool("gcc"), flags, tmp_path, ("#error", "#warning")) == calls + 1


def test_without_the_request_there_is_none() -> None:
    files = build_task(parse_task(TASK)).files
    assert "omni_s2_selftest.c" not in files
    assert b"selftest" not in files["omni_s2.h"]


def test_the_comparison_of_an_adaptive_design_bears_the_request(tool) -> None:
    """Its probe has no `control` to call."""
    tool("cc")
    controller = selftested("adaptive", "float")
    assert all(r.holds for r in compare_backend(controller, CompiledC, 200))
