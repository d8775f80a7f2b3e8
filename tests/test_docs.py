"""What the documents show is what happens: commands of docs/board.md print what stands there, its C compiles strictly."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

from stt_codegen.compare.toolchain import STRICT

PAGE = (ROOT / "docs" / "board.md").read_text()
LEMMAS = (ROOT / "docs" / "lemmas.md").read_text()
GCC = "12.2"  # the counts on the page are of this compiler


def steps(page: str = PAGE) -> list[tuple[str, str]]:
    """Every command of the page, in order, with what it prints."""
    blocks = re.findall(r"^```console\n(.*?)^```", page, re.M | re.S)
    return [(c, out) for block in blocks for c, out in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.M)]


@pytest.fixture
def folder(tmp_path) -> Path:
    shutil.copytree(ROOT / "tasks", tmp_path / "tasks")
    return tmp_path


def test_every_command_prints_what_the_page_shows(folder: Path, tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    version = subprocess.run(["arm-none-eabi-gcc", "-dumpversion"], capture_output=True, text=True, check=True).stdout
    found = steps()
    assert len(found) == 7
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command, shown in found:
        result = subprocess.run(
            command, shell=True, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
        )
        assert result.returncode == 0, (command, result.stderr)
        if command.startswith("stt-codegen generate") or version.startswith(GCC):
            assert result.stdout == shown, command
    if not version.startswith(GCC):
        pytest.skip(f"the sizes and counts on the page are those of arm-none-eabi-gcc {GCC}, this is {version.strip()}")


M4F = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")


@pytest.mark.parametrize(
    ("which", "name", "scalar", "board"),
    [(0, "omni_board", "float", M4F), (1, "gantry", "fixed", ("-mcpu=cortex-m0", "-mthumb"))],
)
def test_the_pages_loops_compile_for_their_boards_without_a_warning(
    which: int, name: str, scalar: str, board: tuple[str, ...], folder: Path, tool
) -> None:
    source = re.findall(r"^```c\n(.*?)^```", PAGE, re.M | re.S)[which]
    shutil.copytree(ROOT / "generated" / name / "refined" / scalar, folder / "firmware")
    own = "void SysTick_Handler(void);\n" if which == 0 else "void every_millisecond(void);\n"  # declared where it is called
    (folder / "firmware" / "main.c").write_text(own + source)
    flags = [v for v in STRICT if v != "-Wcast-qual"]
    for file in ("main.c", f"{name}.c", f"{name}_selftest.c"):
        subprocess.run([tool("arm-none-eabi-gcc"), *board, *flags, "-c", file], cwd=folder / "firmware", check=True)


def test_the_page_on_lemmas_shows_what_design_prints_and_a_plant_that_works(folder: Path) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    ((command, shown),) = steps(LEMMAS)
    ran = subprocess.run(
        command, shell=True, check=False, cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": path}
    )
    assert ran.stdout == shown
    (source,) = re.findall(r"^```python\n(.*?)^```", LEMMAS, re.M | re.S)
    (folder / "mine.py").write_text(source)
    command = "stt-codegen prove tasks/omni_s3.toml --plant mine.py"
    ran = subprocess.run(
        command, shell=True, check=False, cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": path}
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr


@pytest.mark.parametrize("page", ["docs/loop.md", "docs/loop_example.py"])
def test_the_closed_loop_in_python_control_ends_in_the_target(page: str) -> None:
    text = (ROOT / page).read_text()
    source = text if page.endswith(".py") else re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)[0]
    source = source.replace("__file__", repr(str(ROOT / page)))
    ran = subprocess.run([sys.executable, "-c", source], check=False, cwd=ROOT, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    x1, x2 = (float(v) for v in re.findall(r"\d\.\d+", ran.stdout)[:2])
    assert 4.5 <= x1 <= 5.0
    assert 4.5 <= x2 <= 5.0
