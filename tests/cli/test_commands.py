"""Every registered command has a description, stands in README.md and can print JSON."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import get_type_hints

import pytest
from typer.testing import CliRunner

from stt_codegen import pipeline
from stt_codegen.cli.check_commands import COMMANDS as CHECKS
from stt_codegen.cli.design_commands import COMMANDS as DESIGNS
from stt_codegen.cli.main import app
from stt_codegen.cli.options import EffortOption
from stt_codegen.effort import Effort
from stt_codegen.errors import NotCertified
from tests.support.controllers import ROOT

README = (ROOT / "README.md").read_text()
ALWAYS_JSON = {"schema"}  # it needs no option for it


@pytest.mark.parametrize("command", [*DESIGNS, *CHECKS], ids=lambda command: command.__name__.rstrip("_"))
def test_a_command_is_described_listed_in_the_readme_and_prints_json(command) -> None:
    name = command.__name__.rstrip("_")
    assert len((inspect.getdoc(command) or "").split()) > 4
    assert f"stt-codegen {name}" in README
    assert "json" in inspect.signature(command).parameters or name in ALWAYS_JSON


def test_every_file_of_a_command_is_listed() -> None:
    """The file of a command has its name, except that of `map`, whose name would hide Python's function."""
    for commands, folder in ((DESIGNS, "design_commands"), (CHECKS, "check_commands")):
        files = {path.stem for path in (ROOT / "stt_codegen" / "cli" / folder).glob("[!_]*.py")}
        assert {"maps" if command.__name__ == "map_" else command.__name__ for command in commands} == files


@pytest.mark.parametrize("command", [*DESIGNS, *CHECKS], ids=lambda command: command.__name__.rstrip("_"))
def test_what_reads_a_path_says_that_it_cannot_be_read_not_typer(command) -> None:
    """Typer's message would be one about a value, in another style, and only for paths that exist."""
    for name, hint in get_type_hints(command, include_extras=True).items():
        if "Path" in str(hint):
            assert [info.readable for info in hint.__metadata__ if hasattr(info, "readable")] == [False], name


TASK = str(ROOT / "tasks" / "omni_s1.toml")
ARGUMENTS = {"pil": ("--board", "m4f"), "certify": ("none.c", "none.json"), "theorem": ("none.c",)}  # beside the task
OF_A_TASK = [command for command in (*DESIGNS, *CHECKS) if {"task", "tasks"} & set(inspect.signature(command).parameters)]


@pytest.mark.parametrize("command", OF_A_TASK, ids=lambda command: command.__name__.rstrip("_"))
def test_every_command_that_may_refuse_a_task_takes_the_effort_of_the_search(
    command: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What one command certifies in its time another one must not refuse for lack of it."""
    seconds: list[float] = []

    def refuse(_task: object, effort: Effort, **_: object) -> None:
        seconds.append(effort.seconds)
        raise NotCertified("refused")

    monkeypatch.setattr(pipeline, "certified_attempt", refuse)
    name = command.__name__.rstrip("_")
    has_effort = get_type_hints(command, include_extras=True).get("effort") == EffortOption
    options = ("--effort", "37") if has_effort else ()
    result = CliRunner().invoke(app, [name, TASK, *ARGUMENTS.get(name, ()), *options])
    assert "Usage:" not in result.output
    assert seconds == ([37.0] if has_effort else [])
