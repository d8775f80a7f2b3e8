"""No task has a name whose files would hide a header, a module or a file of this tool from a compiler."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from stt_codegen.board import BOARDS
from stt_codegen.board.emulated import run_on_board
from stt_codegen.errors import BadInput
from stt_codegen.loop.compiled import load_controller
from stt_codegen.plants import plant_of
from stt_codegen.program.targets.c.headers import HEADERS, HEADERS_BY_SOURCE
from stt_codegen.report.page.drive import DriveModule, compile_drive_module
from stt_codegen.task import Task, load_task
from tests.support.controllers import ROOT, build_once

COMPILERS = ("gcc", "clang", "avr-gcc", "arm-none-eabi-gcc", "riscv64-unknown-elf-gcc")
TASK_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


def task_called(name: str) -> Task:
    return load_task(ROOT / "tasks" / "empty.toml").changed(name=name)


def included_headers(compiler: str, folder: Path) -> set[str]:
    """Return the names of the headers, without .h, that those of C11 and POSIX include and find in a folder of includes itself."""
    names = f"{HEADERS_BY_SOURCE['C11 and C23']} {HEADERS_BY_SOURCE['POSIX']}".split()
    for name in names:
        (folder / f"{name}.c").write_text(f"#include <{name}.h>\n")
    search = subprocess.run([compiler, "-E", "-v", "-xc", "/dev/null"], capture_output=True, text=True, check=True, cwd=folder)
    roots = {Path(line.strip()).resolve() for line in search.stderr.splitlines() if line.startswith(" /")}
    runs = [subprocess.run([compiler, "-M", f"{n}.c"], capture_output=True, text=True, check=False, cwd=folder) for n in names]
    words = " ".join(run.stdout for run in runs).replace("\\\n", " ").split()  # empty for a header that the compiler lacks
    paths = [Path(word).resolve() for word in words if word.endswith(".h")]
    return {path.stem for path in paths if path.parent in roots and TASK_NAME.fullmatch(path.stem)}


@pytest.mark.parametrize("compiler", COMPILERS)
def test_every_header_that_the_standard_ones_include_is_listed(compiler: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    included = included_headers(compiler, tmp_path)
    assert included
    assert included - HEADERS == set()


def test_a_listed_header_is_no_name_in_capitals_either() -> None:
    for name in sorted(HEADERS):
        for spelling in (name, name.upper(), name.capitalize()):
            with pytest.raises(BadInput, match=f"^name: '{spelling}'"):
                task_called(spelling)


@pytest.mark.parametrize("name", ["con", "NUL", "Com1", "lpt9"])
def test_a_device_of_windows_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match=f"^name: '{name}' is a device of Windows"):
        task_called(name)


@pytest.mark.parametrize("name", ["asyncore", "Distutils", "token"])
def test_a_module_of_any_python_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match="standard library of Python"):
        task_called(name)


@pytest.mark.parametrize("name", ["adapter", "plant"])
def test_a_task_called_like_a_file_of_a_simulation_is_compiled(name: str, reference_module: DriveModule) -> None:
    """The tool writes files of its own beside the controller's when it compiles them."""
    controller = build_once(task_called(name))
    assert load_controller(controller).step is not None
    if shutil.which("wasm-ld"):
        module = compile_drive_module(controller, plant_of("integrator", 2, 1))
        assert module.reason == ""
        assert len(module.wasm) == len(reference_module.wasm)  # nothing is left out


@pytest.mark.parametrize("name", ["board", "arm"])
def test_a_task_called_like_a_file_for_a_board_is_compiled(name: str) -> None:
    assert run_on_board(build_once(task_called(name)), BOARDS["m4f"], 1)[0]


@pytest.fixture(scope="module")
def reference_module() -> DriveModule:
    """Return the module of a task with another name; one with a reason where a compiler is missing."""
    return compile_drive_module(build_once(task_called("other")), plant_of("integrator", 2, 1))
