"""Recipes of CONTRIBUTING.md, followed: what a section tells to change, and a sample made by it in a copy of the repository.

A recipe names each place to change by a link in bold: a file, or a folder for new files. Other links are examples.
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
Edits = Mapping[str, Sequence[tuple[str, str]]]  # by path: a text that stands there once, and what comes in its place


def section(title: str, page: str = PAGE) -> str:
    """Return the text of a section."""
    (text,) = re.findall(rf"^## {title}\n(.*?)(?=^## |\Z)", page, re.M | re.S)
    return str(text)


def places(text: str) -> set[str]:
    """Return the places that a recipe tells to change: paths of its links in bold."""
    return {path.rstrip("/") for path in re.findall(r"\*\*\[[^\]]*\]\(([^)#]+)\)\*\*", text)}


def commands(text: str) -> list[str]:
    """Return the shell commands that write a file, which a recipe tells to run."""
    return re.findall(r"`(stt-codegen [^`]* > [^`]*)`", text)


@dataclass(frozen=True)
class Sample:
    """Something that is added by a recipe. title: of its section; edits: of files that are there; files: the folder of `SAMPLES` with
    its new files, if it has any."""

    title: str
    edits: Edits
    files: str = ""

    @property
    def recipe(self) -> str:
        return section(self.title)


def copy_of_the_repository(folder: Path) -> Path:
    """Return a copy of all that recipes are about, inside the folder."""
    copy = folder / "copy"
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__", "*.png"))
        else:
            shutil.copy(source, copy / name)
    return copy


def follow(sample: Sample, copy: Path) -> None:
    """Make the sample in a copy: its new files, its edits, and the commands of the recipe."""
    if sample.files:
        shutil.copytree(SAMPLES / sample.files, copy, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    for path, changes in sample.edits.items():
        text = (copy / path).read_text()
        for old, new in changes:
            assert text.count(old) == 1, (path, old, text.count(old))
            text = text.replace(old, new)
        (copy / path).write_text(text)
    for command in commands(sample.recipe):
        done = in_copy(copy, *command.partition(" > ")[0].split()[1:])
        assert done.returncode == 0, done.stderr
        (copy / command.partition(" > ")[2]).write_text(done.stdout)


def in_copy(copy: Path, *arguments: str, module: str = "stt_codegen.cli") -> subprocess.CompletedProcess[str]:
    """Run the command line, or a module, of the copy."""
    environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", module, *arguments]
    return subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, check=False)


def pytest_in_copy(copy: Path, *arguments: str) -> None:
    """Run tests of the copy, in its own process; AssertionError with what they say where one fails or none ran."""
    done = in_copy(copy, "-q", "-n", "0", "-p", "no:cacheprovider", *arguments, module="pytest")
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]


def touched(copy: Path, original: Path = ROOT) -> set[str]:
    """Return the files of a copy that are new, or other than in the original."""
    paths = [p for name in COPIED for p in ((copy / name).rglob("*") if (copy / name).is_dir() else [copy / name])]
    files = [p.relative_to(copy) for p in paths if p.is_file() and "__pycache__" not in p.parts]
    return {str(p) for p in files if not (original / p).is_file() or (original / p).read_bytes() != (copy / p).read_bytes()}


def astray(named: set[str], changed: set[str], original: Path = ROOT) -> list[str]:
    """Return what is wrong with a recipe that names these places, where what it adds changed these files."""
    told = [f"{path}: is named, and is not there" for path in sorted(named) if not (original / path).exists()]
    new = {path for path in changed if not (original / path).exists()}
    for path in sorted(changed):
        in_a_folder = path in new and any((original / place).is_dir() and path.startswith(place + "/") for place in named)
        if path not in named and not in_a_folder:
            told.append(f"{path}: is changed, and is not named")
    for place in sorted(named):
        if not any(path == place or (path in new and path.startswith(place + "/")) for path in changed):
            told.append(f"{place}: is named, and nothing is changed there")
    return told
