"""Whatever the standard streams are, a command ends with its exit code, without a traceback, and its files are what they would be."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from stt_codegen.checker import FOLDER as CHECKER
from stt_codegen.cli.main import main
from tests.support.controllers import ROOT

TASK = str(ROOT / "tasks" / "omni_s1.toml")
RECORDED = ROOT / "generated" / "omni_s1" / "refined" / "float"
COMMAND = f"{sys.executable} -m stt_codegen.cli"

# Redirections of a shell, and the exit code of a command that is otherwise good: 2 where its result cannot be written.
STREAMS = {
    ">&-": 0,
    "2>&-": 0,
    "<&-": 0,
    ">&- 2>&- <&-": 0,
    ">/dev/full": 2,
    "2>/dev/full": 0,
    ">/dev/full 2>/dev/full": 2,
    "| true": 0,
}


def run_in_shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a line of a shell in a folder; of a pipe its exit code is that of the first command."""
    variables = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    command = ["bash", "-o", "pipefail", "-c", line]
    return subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("streams", STREAMS)
@pytest.mark.parametrize(
    "arguments", ["schema", f"generate {TASK} --out out", "design nowhere.toml", "design nowhere.toml --json", "--help"]
)
def test_a_stream_that_is_closed_or_full_is_no_traceback(streams: str, arguments: str, tmp_path: Path) -> None:
    result = run_in_shell(f"{COMMAND} {arguments} {streams}", tmp_path)
    output = result.stdout + result.stderr
    expected = 2 if "nowhere" in arguments else STREAMS[streams]
    assert result.returncode == expected, output
    assert "Traceback" not in output
    assert "Exception ignored" not in output
    assert "internal error" not in output
    if arguments.startswith("generate"):
        written = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
        assert written == {name: (RECORDED / name).read_bytes() for name in written}
        assert "omni_s1.certificate.json" in written


def test_progress_to_a_reader_that_left_does_not_end_the_command(tmp_path: Path) -> None:
    """Progress is printed by a thread; its pipe has no reader any more when it begins."""
    code = (
        "import os, sys, time; reader, writer = os.pipe(); os.dup2(writer, 2); os.close(reader)\n"
        "from stt_codegen.cli.options import patience\n"
        "with patience('waiting'):\n    time.sleep(1.3)\nprint('done')"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (0, "done\n", "")


def stderr_in_this_process(name: str, encoding: str, monkeypatch: pytest.MonkeyPatch) -> bytes:
    """Return what `design` writes to stderr about a task file, where the streams have this encoding."""
    buffer = io.BytesIO()
    for stream in ("stdout", "stderr"):
        monkeypatch.setattr(sys, stream, io.TextIOWrapper(buffer, encoding=encoding, errors="strict"))
    monkeypatch.setattr(sys, "argv", ["stt-codegen", "design", name])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    sys.stderr.flush()
    return buffer.getvalue()


def stderr_of_a_process(name: str, encoding: str, _monkeypatch: pytest.MonkeyPatch) -> bytes:
    variables = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": encoding, "LC_ALL": "C"}
    command = [sys.executable, "-m", "stt_codegen.cli", "design", name]
    result = subprocess.run(command, env=variables, capture_output=True, check=False)
    assert result.returncode == 2
    return result.stderr


NAMES = ("täsk.toml", "two\nlines.toml", "bell\a.toml", os.fsdecode(b"\xff.toml"))
IN_THIS_PROCESS = [(stderr_in_this_process, name, code) for name in NAMES for code in ("ascii", "utf-8", "latin-1")]
IN_A_PROCESS = [(stderr_of_a_process, NAMES[0], "ascii"), (stderr_of_a_process, NAMES[-1], "utf-8")]


@pytest.mark.parametrize(("run", "name", "encoding"), [*IN_THIS_PROCESS, *IN_A_PROCESS])
def test_a_character_that_the_encoding_lacks_is_written_as_an_escape(
    run: Callable[..., bytes], name: str, encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).write_text("name = 1\n")
    monkeypatch.chdir(tmp_path)
    lines = run(name, encoding, monkeypatch).decode(encoding).splitlines()
    (line,) = [line for line in lines if not line.endswith(" s ...")]  # no progress
    assert "name: " in line
    assert line.isprintable()


@pytest.mark.parametrize(("streams", "code"), [(">&-", 0), ("2>&-", 0), (">/dev/full", 2), ("2>/dev/full", 0), ("| true", 0)])
def test_the_checker_says_verified_or_its_exit_code_is_not_0(streams: str, code: int, tmp_path: Path) -> None:
    files = f"{RECORDED}/omni_s1.c {RECORDED}/omni_s1.certificate.json"
    result = run_in_shell(f"{sys.executable} -I {CHECKER} {TASK} {files} {streams}", tmp_path)
    assert result.returncode in ((0, 2) if streams == "| true" else (code,))  # a pipe may close before or after the line
    assert "Traceback" not in result.stderr
    assert "Exception ignored" not in result.stderr
