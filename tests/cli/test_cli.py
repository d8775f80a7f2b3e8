"""The command line: exit codes, one message, one JSON document, and help without slow imports."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from stt_codegen.report import design_report
from stt_codegen.task import parse_task
from tests.support.command_line import CommandResult, run_command
from tests.support.controllers import ROOT, build_once

TASK = str(ROOT / "tasks" / "omni_s1.toml")
CODE = str(ROOT / "generated" / "omni_s2" / "refined" / "float" / "omni_s2.c")


def test_help_imports_no_heavy_package() -> None:
    """Help is fast because of this, and imports can be tested exactly, unlike time."""
    code = (
        "import sys; sys.argv = ['stt-codegen', '--help']\n"
        "from stt_codegen.cli.main import main\n"
        "try: main()\nexcept SystemExit: pass\n"
        "heavy = {'casadi', 'numpy', 'matplotlib', 'highspy', 'sympy', 'control', 'pydantic', 'jinja2', 'scipy'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    for command in ("design", "generate", "check", "certify", "theorem", "compare", "schema"):
        assert command in result.stdout


def one_message(result: CommandResult) -> str:
    """Return the one line of a refusal; lines of progress may precede it on a slow machine."""
    lines = [line for line in result.stderr.splitlines() if line and not re.fullmatch(r"  \w+ .*: \d+ s \.\.\.", line)]
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("stt-codegen: ")
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    return lines[0]


@pytest.mark.parametrize("command", ["design", "generate", "compare"])
def test_bad_input_is_exit_code_2_and_one_line(command: str, tmp_path) -> None:
    result = run_command(command, "none.toml", cwd=tmp_path)
    assert result.returncode == 2
    assert "none.toml: cannot be read" in one_message(result)
    (tmp_path / "odd.toml").write_text('name = "odd"\nprescribed_time = [')
    result = run_command(command, "odd.toml", cwd=tmp_path)
    assert result.returncode == 2
    assert "line 2" in one_message(result)
    assert [p.name for p in tmp_path.iterdir()] == ["odd.toml"]


@pytest.mark.parametrize("command", ["design", "generate", "compare"])
def test_an_infeasible_task_is_exit_code_3_and_nothing_is_written(command: str, tmp_path) -> None:
    wall = '\n[[unsafe]]\nname = "wall"\nlower = [2.0, 0.0]\nupper = [2.5, 3.0]\n'
    (tmp_path / "walled.toml").write_text((ROOT / "tasks" / "empty.toml").read_text() + wall)
    result = run_command(command, "walled.toml", cwd=tmp_path)
    assert result.returncode == 3
    assert "avoid (P4)" in one_message(result)
    assert [p.name for p in tmp_path.iterdir()] == ["walled.toml"]


def test_without_a_compiler_compare_is_exit_code_4() -> None:
    result = run_command("compare", TASK, "--points", "10", env={"PATH": "/nonexistent", "CC": ""})
    assert result.returncode == 4
    assert "install gcc or clang" in result.stderr.splitlines()[-1]


def test_an_unknown_option_is_exit_code_2() -> None:
    assert run_command("design", TASK, "--colour").returncode == 2
    assert run_command("generate", TASK, "--scalar", "half").returncode == 2
    assert run_command("generate", TASK, "--out", "a", "--record", "b").returncode == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("desing",), "desing"),
        (("simulate", TASK, "--w-max", "-1"), "--w-max"),
        (("certify", TASK, "nowhere.c", "nowhere.json"), "nowhere.c cannot be read"),
        (("certify", TASK, TASK, TASK), f"{TASK} is not of the form that is read here (JSONDecodeError"),
        (("certify", CODE, CODE, CODE), f"{CODE} is not of the form that is read here (TOMLDecodeError"),
        (("simulate", TASK, "--design", "literal"), TASK),
        (("design", TASK, "--design", "literal"), TASK),
        (("check", "nowhere"), "nowhere"),
    ],
)
def test_a_refusal_is_in_the_json_document_too(arguments: tuple[str, ...], message: str) -> None:
    result = run_command(*arguments, "--json")
    document = json.loads(result.stdout)
    assert document["exit_code"] == result.returncode in (2, 3)
    assert message in document["error"]


@pytest.mark.slow
def test_a_closed_pipe_is_no_error() -> None:
    """The pipe is closed before anything is written; some commands print at once, others while they run."""
    for arguments in (("schema",), ("--help",), ("design", TASK), ("check", "generated")):
        reader, writer = os.pipe()
        os.close(reader)
        command = [sys.executable, "-u", "-m", "stt_codegen.cli", *arguments]
        try:
            result = subprocess.run(command, cwd=ROOT, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
        finally:
            os.close(writer)
        messages = [line for line in result.stderr.splitlines() if not line.endswith(" s ...")]  # without lines of progress
        assert (result.returncode, messages) == (0, []), arguments


def test_compare_prints_one_line_and_with_verbose_a_table() -> None:
    lines = run_command("compare", TASK, "--points", "50").stdout.splitlines()
    assert len(lines) == 1
    assert all(backend in lines[0] for backend in ("CasADi", "Python", "C double", "C float"))
    assert len(run_command("compare", TASK, "--points", "50", "--verbose").stdout.splitlines()) > 8


def test_a_defect_of_the_tool_is_exit_code_5_without_a_traceback(monkeypatch, capsys) -> None:
    from stt_codegen.cli import main as cli

    def fail(*_: object) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr(cli, "_exit_code", fail)
    monkeypatch.delenv("STT_CODEGEN_DEBUG", raising=False)
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert caught.value.code == 5
    assert "internal error: RuntimeError: boom" in capsys.readouterr().err


def test_every_command_prints_one_json_document(tmp_path) -> None:
    report = json.loads(run_command("design", TASK, "--json").stdout)
    assert report["certified"] is True
    assert [p["property"] for p in report["properties"]] == ["P1", "P2", "P2", "P3", "P4", "P5", "P6", "P7"]
    assert report["cost"]["table_bytes"] == (35 * 2 * 2 + 2 * 2) * 4  # control points, and the bounds of starts
    written = json.loads(run_command("generate", TASK, "--out", str(tmp_path), "--json").stdout)["written"][0]
    assert sorted(written["files"]) == sorted(p.name for p in tmp_path.iterdir())
    rows = json.loads(run_command("compare", TASK, "--points", "50", "--json").stdout)
    assert rows["within_bounds"] is True
    assert json.loads(run_command("schema").stdout)["title"] == "stt_codegen task"
    run_command("generate", TASK, "--record", str(tmp_path / "recorded"))
    checked = json.loads(run_command("check", str(tmp_path / "recorded"), "--json").stdout)
    assert checked["differences"] == []


def test_design_shows_the_tube_and_draws_it(tmp_path) -> None:
    result = run_command("design", TASK, "--picture", str(tmp_path / "new"))
    assert result.returncode == 0
    assert re.search(r"least width 0\.\d+", result.stdout)
    assert "one control step: " in result.stdout
    assert (tmp_path / "new" / "omni_s1.png").read_bytes().startswith(b"\x89PNG")


def test_with_the_uncertified_flag_a_certificate_that_holds_stays(tmp_path) -> None:
    result = run_command("generate", TASK, "--uncertified", "--out", str(tmp_path))
    assert result.returncode == 0
    assert b"NOT CERTIFIED" not in (tmp_path / "omni_s1.c").read_bytes()


def test_a_start_that_is_not_covered_is_reported_by_axis_and_amount(tmp_path: Path) -> None:
    """The post is 0.02 from the initial set and the clearance is 0.05, so that 0.03, and the rounding of the grid, are not covered."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    head = text[: text.index("[state_space]")]
    near = (
        head + "[state_space]\nlower = [0, 0]\nupper = [4, 3]\n[initial_set]\nlower = [0, 0]\nupper = [1, 1]\n"
        "[target_set]\nlower = [3, 2]\nupper = [4, 3]\n"
        '[[unsafe]]\nname = "post"\nlower = [1.02, 0.2]\nupper = [1.5, 0.8]\n[tube]\nclearance = 0.05\n'
    )
    (tmp_path / "near.toml").write_text(near)
    result = run_command("design", str(tmp_path / "near.toml"), "--json")
    left_out = json.loads(result.stdout)["start_left_out"]
    assert 0.03 <= left_out[0] < 0.0301
    printed = run_command("design", str(tmp_path / "near.toml")).stdout
    assert f"up to {left_out[0]:.3g} in x1" in printed
    assert "post is 0.02 from it, the clearance 0.05; starts there" in " ".join(printed.split())


HALL = """name = "hall"
prescribed_time = 100
initial_state = [5, 5]
[state_space]
lower = [0, 0]
upper = [161, 63]
[initial_set]
lower = [4, 4]
upper = [5.9, 5.9]
[target_set]
lower = [150, 50]
upper = [152, 52]
[tube]
clearance = 0.05
"""
ROUNDING = "room for the rounding of float, with coordinates up to 161"


@pytest.mark.parametrize(
    ("sets", "cause"),
    [
        ("", ROUNDING),
        ('[[unsafe]]\nname = "far"\nlower = [7, 0]\nupper = [8, 6]\n', ROUNDING),
        ('[[unsafe]]\nname = "door"\nlower = [5.91, 4]\nupper = [7, 6]\nduring = [50, 60]\n', ROUNDING),
        ('[[unsafe]]\nname = "crate"\nlower = [5.92, 0]\nupper = [7, 6]\n', "crate is 0.02 from it, the clearance 0.05"),
        ('[[unsafe]]\nname = "post"\ncentre = [6, 5]\nradius = 0.07\n', "post is 0.03 from it, the clearance 0.05"),
        (
            '[[unsafe]]\nname = "cart"\nlower = [20, 4]\nupper = [21, 5]\n'
            "motion = [{ at = 0, by = [-14.06, 0] }, { at = 50, by = [0, 0] }]\n",
            "cart is 0.04 from it, the clearance 0.05",
        ),
    ],
)
def test_the_note_on_starts_that_are_left_out_names_the_set_or_the_rounding(sets: str, cause: str) -> None:
    """A set is a cause only where it is nearer than the clearance at t = 0."""
    report = design_report(build_once(parse_task(HALL + sets)), 0.0)
    assert not report.covers_initial_set
    assert report.start_cause == cause


def test_no_warning_of_a_library_reaches_a_person() -> None:
    """With Python set to show every warning, a command that warns prints nothing, unless a developer asks for it."""
    code = (
        "import sys, typer, warnings; from stt_codegen.cli.main import run; app = typer.Typer(); sys.argv = ['warns']\n"
        "@app.command()\ndef warns() -> None:\n    warnings.warn('overflow in exp', RuntimeWarning)\n"
        "run(app, 'warns')"
    )
    for debug, is_shown in (("", False), ("1", True)):
        environment = {**os.environ, "STT_CODEGEN_DEBUG": debug}
        command = [sys.executable, "-W", "always", "-c", code]
        process = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
        assert ("overflow in exp" in process.stderr) == is_shown
        assert process.stdout == ""
