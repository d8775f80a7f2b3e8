"""Every registered command has a description, stands in README.md and can print JSON."""

from __future__ import annotations

import inspect
from typing import get_type_hints

import pytest

from stt_codegen.cli.check_commands import COMMANDS as CHECKS
from stt_codegen.cli.design_commands import COMMANDS as DESIGNS
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
