"""A file that may not be read is named, by every command that reads it, as what cannot be read."""

from __future__ import annotations

import builtins
import errno
import io
import os
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.support.command_line import CommandResult, run_command
from tests.support.controllers import ROOT

RECORDED = "generated/empty/refined/float"
FILES_OF_CERTIFY = (f"{RECORDED}/empty.c", f"{RECORDED}/empty.certificate.json")
READERS: list[tuple[str, tuple[str, ...]]] = [  # the file that cannot be read, and a command that reads it
    *(
        ("tasks/empty.toml", (command, "tasks/empty.toml", *options))
        for command, options in (
            ("design", ()),
            ("generate", ()),
            ("simulate", ()),
            ("report", ()),
            ("compare", ()),
            ("pil", ("--board", "m4f")),
            ("prove", ()),
            ("theorem", (f"{RECORDED}/empty.c",)),
            ("certify", FILES_OF_CERTIFY),
        )
    ),
    *((file, ("certify", "tasks/empty.toml", *FILES_OF_CERTIFY)) for file in (*FILES_OF_CERTIFY, f"{RECORDED}/empty.h")),
    *((file, ("theorem", "tasks/empty.toml", f"{RECORDED}/empty.c")) for file in (*FILES_OF_CERTIFY, f"{RECORDED}/empty.h")),
    *((f"{RECORDED}/empty.{end}", ("check",)) for end in ("c", "h", "py", "certificate.json")),
    ("tasks/empty.toml", ("check", "--accept")),
    (f"{RECORDED}/empty.c", ("check", "--accept")),
    ("generated/MANIFEST.json", ("check",)),
    ("step.csv", ("lag", "step.csv")),
    ("plant.py", ("simulate", "tasks/empty.toml", "--plant", "plant.py")),
    ("plant.py", ("prove", "tasks/empty.toml", "--plant", "plant.py")),
    ("map.yaml", ("map", "map.yaml")),
    ("map.png", ("map", "map.yaml")),
    ("book.md", ("prove", "--check", "--out", "book.md")),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a recorded task, and a file of every kind that a command reads."""
    from PIL import Image

    folder = tmp_path_factory.mktemp("unreadable")
    (folder / "tasks").mkdir()
    shutil.copy(ROOT / "tasks" / "empty.toml", folder / "tasks")
    assert run_command("generate", "tasks/empty.toml", "--record", "generated", cwd=folder).returncode == 0
    (folder / "step.csv").write_text("t,u,y\n0,0,0\n1,1,1\n")
    (folder / "plant.py").write_text("")
    (folder / "book.md").write_text("")
    (folder / "map.yaml").write_text(
        "image: map.png\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    Image.new("L", (8, 8), 255).save(folder / "map.png")
    return folder


def run_without_right(monkeypatch: pytest.MonkeyPatch, folder: Path, file: str, command: tuple[str, ...]) -> CommandResult:
    """Run a command to which the system refuses a file, as it does to a user without the right to read it."""
    unreadable = (folder / file).resolve()

    def refusing(function: Any) -> Any:
        def opened(path: Any, *arguments: Any, **options: Any) -> Any:
            if isinstance(path, str | os.PathLike) and Path(path).resolve() == unreadable:
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), os.fspath(path))
            return function(path, *arguments, **options)

        return opened

    for module, name in ((os, "open"), (io, "open"), (io, "open_code"), (builtins, "open")):
        monkeypatch.setattr(module, name, refusing(getattr(module, name)))
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode, **o: Path(path).resolve() != unreadable and access(path, mode, **o))
    return run_command(*command, cwd=folder)


@pytest.mark.parametrize(("file", "command"), READERS, ids=lambda value: " ".join(value) if isinstance(value, tuple) else value)
def test_an_input_that_cannot_be_read_is_named(
    folder: Path, file: str, command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with monkeypatch.context() as patch:
        result = run_without_right(patch, folder, file, command)
    text = result.stdout + result.stderr
    is_compared = command == ("check",) and file.startswith(RECORDED)  # then it is one of the differences
    assert result.returncode == (1 if is_compared else 2), text
    line = next((line for line in text.splitlines() if Path(file).name in line), "")
    assert "cannot be read (Permission denied)" in line or ("plant.py" in line and "Permission denied" in line), text
    assert "output" not in text
    assert "internal" not in text
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
