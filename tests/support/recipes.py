"""Follows recipes of CONTRIBUTING.md in a copy of the repository, for tests/recipes.

A recipe is a section that says how to add something, such as a board. It names each place to change by a link in bold: a file, or a
folder for new files. Other links are examples.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.support.controllers import ROOT

PAGE = (ROOT / "CONTRIBUTING.md").read_text()
COPIED = (
    "stt_codegen",
    "templates",
    "proof",
    "tests",
    "benchmarks",
    "tasks",
    "docs",
    ".ci",
    "README.md",
    "CONTRIBUTING.md",
    "pyproject.toml",
    "locks",
)
SAMPLES = ROOT / "tests" / "recipes" / "samples"
Edits = Mapping[str, Sequence[tuple[str, str]]]  # by path: pairs of a text that occurs there once, and its replacement


def section(title: str, page: str = PAGE) -> str:
    """Return the text of the page's section with this title."""
    (text,) = re.findall(rf"^## {title}\n(.*?)(?=^## |\Z)", page, re.M | re.S)
    return str(text)


def places_to_change(text: str) -> set[str]:
    """Return the paths that a recipe says to change: those of its links in bold."""
    return {path.rstrip("/") for path in re.findall(r"\*\*\[[^\]]*\]\(([^)#]+)\)\*\*", text)}


def commands_in(text: str) -> list[str]:
    """Return the shell commands of a recipe that write a file."""
    return re.findall(r"`(stt-codegen [^`]* > [^`]*)`", text)


@dataclass(frozen=True)
class Sample:
    """An addition that follows a recipe: the title of its section, its edits of existing files, and, where it has new files, their
    folder in `SAMPLES`."""

    title: str
    edits: Edits
    files: str = ""

    @property
    def recipe(self) -> str:
        return section(self.title)


def copy_of_the_repository(folder: Path) -> Path:
    """Copy everything that a recipe may change into the folder, and return the copy's path."""
    copy = folder / "copy"
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__", "*.png"))
        else:
            shutil.copy(source, copy / name)
    return copy


def follow_recipe(sample: Sample, copy: Path) -> None:
    """Add the sample to a copy: its new files, its edits, and the output of the recipe's commands."""
    if sample.files:
        shutil.copytree(SAMPLES / sample.files, copy, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    for path, changes in sample.edits.items():
        text = (copy / path).read_text()
        for old, new in changes:
            assert text.count(old) == 1, (path, old, text.count(old))
            text = text.replace(old, new)
        (copy / path).write_text(text)
    for command in commands_in(sample.recipe):
        result = run_in_copy(copy, *command.partition(" > ")[0].split()[1:])
        assert result.returncode == 0, result.stderr
        (copy / command.partition(" > ")[2]).write_text(result.stdout)


def run_in_copy(copy: Path, *arguments: str, module: str = "stt_codegen.cli") -> subprocess.CompletedProcess[str]:
    """Run the copy's command line, or another module of the copy, with these arguments."""
    environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", module, *arguments]
    return subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, check=False)


def run_pytest_in_copy(copy: Path, *arguments: str) -> None:
    """Run tests of the copy in a new process; AssertionError with their output where one fails or none ran."""
    result = run_in_copy(copy, "-q", "-n", "0", "-p", "no:cacheprovider", *arguments, module="pytest")
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-2000:]


def changed_files(copy: Path, original: Path = ROOT) -> set[str]:
    """Return the files of a copy that are new, or differ from the original."""
    paths = [p for name in COPIED for p in ((copy / name).rglob("*") if (copy / name).is_dir() else [copy / name])]
    files = [p.relative_to(copy) for p in paths if p.is_file() and "__pycache__" not in p.parts]
    return {str(p) for p in files if not (original / p).is_file() or (original / p).read_bytes() != (copy / p).read_bytes()}


def mismatches(named: set[str], changed: set[str], original: Path = ROOT) -> list[str]:
    """Return a message for each difference between the paths that a recipe names and the files that its sample changed."""
    messages = [f"{path}: is named, and is not there" for path in sorted(named) if not (original / path).exists()]
    new = {path for path in changed if not (original / path).exists()}
    for path in sorted(changed):
        is_in_named_folder = path in new and any((original / p).is_dir() and path.startswith(p + "/") for p in named)
        if path not in named and not is_in_named_folder:
            messages.append(f"{path}: is changed, and is not named")
    for path in sorted(named):
        if not any(file == path or (file in new and file.startswith(path + "/")) for file in changed):
            messages.append(f"{path}: is named, and nothing is changed there")
    return messages
