"""Every command that is registered: it is explained, named on the first page, and speaks JSON."""

from __future__ import annotations

import inspect

import pytest

from stt_codegen.cli.check_commands import COMMANDS as CHECKS
from stt_codegen.cli.design_commands import COMMANDS as DESIGNS
from tests.support.controllers import ROOT

README = (ROOT / "README.md").read_text()
JSON_ALONE = {"schema"}  # what it prints is a JSON document


@pytest.mark.parametrize("command", [*DESIGNS, *CHECKS], ids=lambda command: command.__name__.rstrip("_"))
def test_a_command_is_explained_and_named_and_speaks_json(command) -> None:
    name = command.__name__.rstrip("_")
    assert len((inspect.getdoc(command) or "").split()) > 4
    assert f"stt-codegen {name}" in README
    assert "json" in inspect.signature(command).parameters or name in JSON_ALONE


def test_every_file_of_a_command_is_listed() -> None:
    """A command is a file with a function of its name; `map` would hide Python's own."""
    for commands, folder in ((DESIGNS, "design_commands"), (CHECKS, "check_commands")):
        files = {path.stem for path in (ROOT / "stt_codegen" / "cli" / folder).glob("[!_]*.py")}
        assert {"maps" if command.__name__ == "map_" else command.__name__ for command in commands} == files
