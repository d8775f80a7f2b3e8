"""`python -m benchmarks toolchains`: gcc, clang and a big-endian processor pass, and what a compiler may do wrong is seen.

The whole table is the job `toolchains` of benchmarks/integration.py.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from functools import cache

import pytest

from benchmarks import toolchains
from benchmarks.compilers.builds import REFUSED, BuildResult, fast_math_answer, try_build
from benchmarks.compilers.targets import FLAG_SETS, S390X, TARGETS, X86, X86_FMA, Target
from benchmarks.toolchains import ToolchainRow, main, selftested
from stt_codegen.pipeline import EmittedController
from tests.support.controllers import ROOT
from tests.support.missing_tools import skip_without

FUSING = "-O2 -std=gnu17"  # gcc contracts under these flags, where no pragma forbids it
CLANG = next(target for target in TARGETS if target.compiler == "clang" and not target.emulator)


@cache
def controller_of(name: str, scalar: str) -> EmittedController:
    return selftested(name, scalar)


def require(target: Target) -> None:
    """Skip visibly without the target's tools; in CI fail."""
    if target.missing_tools:
        skip_without(f"{', '.join(target.missing_tools)} is not installed; `.ci/tools test` installs it")


def changed(controller: EmittedController, pattern: str, replacement: str) -> EmittedController:
    """Return the controller with one place of its C changed."""
    name = f"{controller.task.name}.c"
    text, count = re.subn(pattern, replacement, controller.files[name].decode(), count=1)
    assert count == 1
    return replace(controller, files={**controller.files, name: text.encode()})


@pytest.mark.parametrize("target", [X86, CLANG, S390X], ids=["gcc", "clang", "big-endian"])
@pytest.mark.parametrize(
    ("name", "scalar"), [("omni_s2", "float"), ("crane", "double"), ("crane", "fixed"), ("courier", "fixed")]
)
def test_a_compiler_neither_warns_nor_fuses_and_the_self_test_passes(target: Target, name: str, scalar: str) -> None:
    require(target)
    for flags in (FLAG_SETS[0], FUSING):
        result = try_build(controller_of(name, scalar), target, flags.split())
        assert (result.warnings, result.fused, result.answer, result.failure) == ((), 0, 0, "")
    if scalar != "fixed":
        assert fast_math_answer(controller_of(name, scalar), target) == REFUSED


@pytest.mark.parametrize("target", [X86_FMA, S390X], ids=["FMA", "big-endian"])
def test_what_a_compiler_does_wrong_is_seen(target: Target) -> None:
    """A fused operation, a warning, a wrong coefficient, a flag that is not refused: each fails the row."""
    require(target)
    controller = controller_of("omni_s2", "float")
    assert try_build(controller, target, FUSING.split()).fused_without_pragmas > 0
    fused = changed(controller, r"#pragma GCC optimize .*", "")
    assert try_build(fused, target, FUSING.split()).fused > 0
    unused = changed(controller, r"\n(    const \w+ segment)", r"\n    int unused;\n\1")
    assert any("unused" in line for line in try_build(unused, target, FUSING.split()).warnings)
    wrong = changed(controller, r"(_coefficients\[\d+\] = \{\s*)(-?[\d.]+F)", r"\1(\2 + 0.05F)")
    assert (try_build(wrong, target, FUSING.split()).answer or 0) > 0
    silent = changed(controller, r'#error "omni_s2.c: compile without -ffast-math.*', "")
    assert fast_math_answer(silent, target) != REFUSED
    broken = changed(controller, r"#include", "#include <none.h>\n#include")
    assert "none.h" in try_build(broken, target, FUSING.split()).failure


@pytest.mark.parametrize(
    ("result", "has_passed", "words"),
    [
        (BuildResult(answer=0), True, "passes"),
        (BuildResult(reason="refused"), True, "refused"),
        (BuildResult(answer=0, warnings=("a warning",)), False, "passes"),
        (BuildResult(answer=0, fused=1), False, "passes"),
        (BuildResult(answer=7), False, "CALL 7 IS OFF"),
        (BuildResult(failure="NO ANSWER"), False, "NO ANSWER"),
        (BuildResult(), False, "passes"),
    ],
)
def test_a_row_fails_with_any_build(result: BuildResult, has_passed: bool, words: str) -> None:
    good = BuildResult(answer=0)
    results = {scalar: {"order 1": good, "order 2": good} for scalar in toolchains.SCALARS}
    results["double"]["order 2"] = result
    row = ToolchainRow(X86, FUSING, "12", results, ["refused"])
    assert row.has_passed == has_passed
    assert words in row.cells()[5]
    assert not replace(row, fast_math=["NOT REFUSED"]).has_passed


def test_a_missing_compiler_is_a_line_and_in_ci_a_failure(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    lost = replace(X86, name="lost", compiler="no-such-gcc", packages="gcc-of-nobody")
    monkeypatch.setattr(toolchains, "TARGETS", (lost,))
    monkeypatch.setattr(toolchains, "all_controllers", dict)
    for ci, code in (("false", 0), ("true", 1)):
        monkeypatch.setenv("CI", ci)
        assert main([]) == code
        assert "no-such-gcc is not installed (Debian names: gcc-of-nobody)" in capsys.readouterr().out


def test_ci_installs_every_compiler_and_emulator_of_the_table() -> None:
    text = (ROOT / ".ci" / "tools").read_text()
    for target in TARGETS:
        for package in target.packages.split():
            assert package in text or package in ("binutils",), (target.name, package)


def test_two_processors_are_big_endian() -> None:
    """As their compilers say."""
    big = []
    for target in TARGETS:
        if target.missing_tools:
            continue
        command = [target.compiler, *target.flags, "-dM", "-E", "-x", "c", "/dev/null"]
        macros = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        is_big = "#define __BYTE_ORDER__ __ORDER_BIG_ENDIAN__" in macros
        assert is_big == ("big-endian" in target.name)
        big += [target.name] * is_big
    if len(set(big)) < 2:
        pytest.skip("cross compilers of a second big-endian processor are not installed; `.ci/tools integration` installs them")


def test_the_page_names_every_processor_and_compiler_of_the_table() -> None:
    text = (ROOT / "docs" / "c.md").read_text().partition("## Compilers that were tried")[2].partition("\n## ")[0]
    assert all(f"`{flags}`" in text for flags in FLAG_SETS)
    rows = re.findall(r"^\| ([^|]*) \| ([^|]*) \| [^|]* \|$", text, re.M)[1:]
    compilers: dict[str, set[str]] = {}
    for target in TARGETS:
        words = next(word for word in re.findall(r"[\w-]+\+?", target.name) if word != "Cortex")
        compilers.setdefault(words.removeprefix("Cortex-"), set()).add(target.compiler.rpartition("-")[2])
    for name, kinds in compilers.items():
        (row,) = [row for row in rows if re.search(rf"(?<![\w-]){re.escape(name)}(?![\w+])", row[0].replace("Cortex-", ""))]
        assert set(row[1].split(", ")) == kinds, name
