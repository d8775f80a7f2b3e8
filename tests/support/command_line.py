"""Run `stt-codegen` as a user calls it: in this process, which has its imports already, or in a new one."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from stt_codegen.cli.main import main
from tests.support.controllers import ROOT


@dataclass(frozen=True)
class CommandResult:
    """Exit code and output of a command; its fields have the names of `subprocess.CompletedProcess`."""

    returncode: int
    stdout: str
    stderr: str


def run_command(*arguments: str, cwd: Path = ROOT, env: dict[str, str] | None = None) -> CommandResult:
    """Run a command of `stt-codegen` in this process, in the folder `cwd` and with `env` added to the environment."""
    stdout, stderr = io.StringIO(), io.StringIO()
    with (
        mock.patch.object(sys, "argv", ["stt-codegen", *arguments]),
        mock.patch.dict(os.environ, env or {}),
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(stdout),
        contextlib.redirect_stderr(stderr),
    ):
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
    return CommandResult(code, stdout.getvalue(), stderr.getvalue())


def run_in_new_process(*arguments: str, cwd: Path = ROOT, env: dict[str, str] | None = None) -> CommandResult:
    """Run a command of `stt-codegen` in a new process, for tests of what depends on the process, such as its hash seed."""
    command = [sys.executable, "-W", "ignore", "-m", "stt_codegen.cli", *arguments]
    result = subprocess.run(command, cwd=cwd, env={**os.environ, **(env or {})}, capture_output=True, text=True, check=False)
    return CommandResult(result.returncode, result.stdout, result.stderr)
