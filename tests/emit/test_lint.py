"""clang-tidy has no warning for the emitted C, and its deviations from MISRA C:2012 are those that docs/c.md lists with reasons."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from tests.emit.test_runtime_errors import FOLDERS
from tests.support.controllers import ROOT

CHECKS = "-*,bugprone-*,cert-*,clang-analyzer-*,misc-*,performance-*,portability-*,-bugprone-easily-swappable-parameters"
DEVIATIONS = set(re.findall(r"^\| (\d+\.\d+) \|", (ROOT / "docs" / "c.md").read_text(), re.M))


def broken_misra_rules(folder: Path, cppcheck: str, work: Path) -> set[str]:
    """Return the rules that cppcheck's addon finds broken in a folder's C files, taken as one program.

    It reads copies in `work`, as it writes files beside them, and other tests compare the folder byte by byte.
    """
    for path in folder.glob("*.[ch]"):
        (work / path.name).write_bytes(path.read_bytes())
    paths = sorted(map(str, work.glob("*.c")))
    command = [cppcheck, "--std=c99", "--addon=misra", "-q", *paths]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(re.findall(r"\[misra-c2012-(\d+\.\d+)\]", result.stderr))


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_misra_deviation_is_listed(folder: str, tool, tmp_path) -> None:
    rules = broken_misra_rules(ROOT / "generated" / folder, tool("cppcheck"), tmp_path)
    assert "15.5" in rules  # the addon ran
    assert rules <= DEVIATIONS


def test_every_listed_deviation_occurs(tool, tmp_path) -> None:
    rules: set[str] = set()
    for k, folder in enumerate(("omni_board/refined/float", "gantry/refined/fixed")):
        (tmp_path / str(k)).mkdir()
        rules |= broken_misra_rules(ROOT / "generated" / folder, tool("cppcheck"), tmp_path / str(k))
    assert rules == DEVIATIONS


def test_a_new_deviation_is_found(tool, tmp_path) -> None:
    """The new deviation is an octal constant, rule 7.1."""
    source = ROOT / "generated" / "omni_s2" / "refined" / "float" / "omni_s2.c"
    (tmp_path / "omni_s2.h").write_text(source.with_suffix(".h").read_text())
    (tmp_path / "omni_s2.c").write_text(source.read_text().replace("i * 2;", "i * 02;"))
    (tmp_path / "work").mkdir()
    assert "7.1" in broken_misra_rules(tmp_path, tool("cppcheck"), tmp_path / "work") - DEVIATIONS


@pytest.mark.slow
def test_clang_tidy_gives_no_warning(tool) -> None:
    paths = sorted(map(str, (ROOT / "generated").rglob("*.c")))
    command = [tool("clang-tidy"), "--quiet", f"--checks={CHECKS}", *paths, "--", "-std=c99"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "warning:" not in result.stdout, result.stdout[-2000:]
    assert result.returncode == 0


def test_clang_tidy_warns_about_a_known_defect(tool, tmp_path) -> None:
    (tmp_path / "a.c").write_text("long f(int a, int b);\nlong f(int a, int b) { return a * b + sizeof(sizeof(int)); }\n")
    command = [tool("clang-tidy"), "--quiet", f"--checks={CHECKS}", str(tmp_path / "a.c"), "--", "-std=c99"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "bugprone-sizeof-expression" in result.stdout
