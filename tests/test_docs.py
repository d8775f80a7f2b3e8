"""Examples of the documents are correct: commands print the output that a page shows, its C compiles strictly, and its loops run."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from stt_codegen.program.targets.c.runner import STRICT
from stt_codegen.task.load import load_task, parse_task
from tests.support.controllers import ROOT, build_once

PAGE = (ROOT / "docs" / "board.md").read_text()
LEMMAS = (ROOT / "docs" / "lemmas.md").read_text()
GCC = "12.2"  # the counts on the page are of this compiler


def steps(page: str = PAGE) -> list[tuple[str, str]]:
    """Return every command of a page, in order, with the output that the page shows."""
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
    commands = steps()
    assert len(commands) == 7
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command, shown in commands:
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
    declaration = (
        "void SysTick_Handler(void);\n" if which == 0 else "void every_millisecond(void);\n"
    )  # the page calls it elsewhere
    (folder / "firmware" / "main.c").write_text(declaration + source)
    flags = [v for v in STRICT if v != "-Wcast-qual"]
    for file in ("main.c", f"{name}.c", f"{name}_selftest.c"):
        subprocess.run([tool("arm-none-eabi-gcc"), *board, *flags, "-c", file], cwd=folder / "firmware", check=True)


README = (ROOT / "README.md").read_text()
# By name of a document's loop: its clock, the function that a timer calls, and bodies by prototype of the user's functions that it calls.
LOOPS = {
    "cart": (
        "uint64_t clock_us(void)",
        "timer_1khz",
        {
            "cart_status cart_control(float t, const float x[2], float u[2])": "u[0] = u[1] = 0; called = (double)t; return CART_OK;",
            "void read_state(float x[2])": "x[0] = x[1] = 0;",
            "void drive(const float u[2])": "",
            "void stop(void)": "",
            "void stand(void)": "",
            "bool cart_covered(const float x[2])": "return ++covered_calls > UNCOVERED;",
            "void warn(void)": "warnings++;",
        },
    ),
    "gantry": (
        "uint32_t timer_us(void)",
        "every_millisecond",
        {
            "gantry_status gantry_control(uint32_t t, const int32_t x[2], int32_t u[2])": "u[0] = u[1] = 0; called = t; return GANTRY_OK;",
            "bool gantry_covered(const int32_t x[2])": "return ++covered_calls > UNCOVERED;",
            "int32_t gantry_margin(uint32_t t, const int32_t x[2])": "return 32768;",
            "void read_steps(int32_t steps[2])": "steps[0] = steps[1] = 0;",
            "void set_speeds(const int32_t u[2])": "",
            "void warn(void)": "warnings++;",
        },
    ),
}
WORLD = """#include <stdio.h>
static uint64_t world = 4294967296U - 2000U; /* microseconds: 32 bits overflow soon */
static double called = -1;
static int warnings, covered_calls;
enum { UNCOVERED = 2 }; /* the first samples, whose start is not covered */
int main(void)
{
    const uint64_t begin = world;
    double gap;
    while (scanf("%lf", &gap) == 1) {
        world += (uint64_t)gap;
        STEP();
        printf("%.0f %.17g %d\\n", (double)(world - begin), called, warnings);
    }
    return 0;
}
"""


def rows_of(text: str) -> list[list[float]]:
    return [[float(v) for v in line.split()] for line in text.splitlines()]


@pytest.mark.parametrize("name", LOOPS)
def test_a_documents_loop_takes_its_time_from_the_clock(name: str, tmp_path: Path, tool) -> None:
    """Interrupts come 1 ms apart or are lost, up to thousands of them. The controller gets the clock's time since the first covered start,
    and a late sample warns. It is not called at a start that is not covered."""
    page = {"cart": README, "gantry": PAGE}[name]
    loop = next(c for c in re.findall(r"^```c\n(.*?)^```", page, re.M | re.S) if f'#include "{name}.h"' in c)
    task = (
        parse_task(page.partition("```toml\n")[2].partition("```")[0])
        if name == "cart"
        else load_task(ROOT / "tasks/gantry.toml")
    )
    (tmp_path / f"{name}.h").write_bytes(build_once(task).files[f"{name}.h"])
    clock, step, user_functions = LOOPS[name]
    declared = f'#include <stdint.h>\n#include "{name}.h"\n' + "".join(
        f"{f};\n" for f in (clock, f"void {step}(void)", *user_functions)
    )
    bodies = user_functions | {clock: f"return ({clock.split()[0]})world;"}
    defined = "\n".join(f"{f} {{ {body} }}" for f, body in bodies.items())
    (tmp_path / "main.c").write_text(declared + loop + WORLD.replace("STEP", step).replace("int main", f"{defined}\nint main"))
    flags = [f for f in STRICT if f not in ("-Wcast-qual", "-Wmissing-prototypes", "-Wunused-parameter")]
    subprocess.run([tool("gcc"), *flags, "-Wno-unused-parameter", "main.c", "-o", "loop"], cwd=tmp_path, check=True)
    gaps = [0, *[1000] * 50, 5000, 1000, 5001, *[1000, 1065] * 200, 2_000_000, 1000]
    if name == "gantry":
        gaps = [0, *[1000, 999, 1001] * 20, 10_000, 1000, 10_001, *[1000, 1065] * 200, 2_000_000, 1000]
    first_late = gaps.index(5001 if name == "cart" else 10_001)
    output = subprocess.run(
        ["./loop"], cwd=tmp_path, input="\n".join(map(str, [700, 90_000, *gaps])), capture_output=True, text=True, check=True
    ).stdout
    uncovered, rows = rows_of(output)[:2], rows_of(output)[2:]
    assert [called for _, called, _ in uncovered] == [-1, -1]
    assert len(rows) == len(gaps)
    begin, earlier_warnings = rows[0][0], uncovered[-1][2]  # a loop may warn while it waits
    rows = [(now - begin, called, warnings - earlier_warnings) for now, called, warnings in rows]
    for k, (now, called, warnings) in enumerate(rows):
        if name == "cart":
            assert called == pytest.approx(now * 1e-6, rel=3.01 * 2.0**-24)  # three roundings to a float
        else:
            assert called == (now + 500) // 1000  # the nearest tick
        assert (warnings > 0) == (k >= first_late)


def test_the_page_on_lemmas_shows_what_design_prints_and_a_plant_that_works(folder: Path) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    ((command, shown),) = steps(LEMMAS)
    result = subprocess.run(
        command, shell=True, check=False, cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": path}
    )
    assert result.stdout == shown
    (source,) = re.findall(r"^```python\n(.*?)^```", LEMMAS, re.M | re.S)
    (folder / "mine.py").write_text(source)
    command = "stt-codegen prove tasks/omni_s3.toml --plant mine.py"
    result = subprocess.run(
        command, shell=True, check=False, cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": path}
    )
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.parametrize("page", ["docs/loop.md", "docs/loop_example.py"])
def test_the_closed_loop_in_python_control_ends_in_the_target(page: str) -> None:
    text = (ROOT / page).read_text()
    source = text if page.endswith(".py") else re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)[0]
    source = source.replace("__file__", repr(str(ROOT / page)))
    result = subprocess.run([sys.executable, "-c", source], check=False, cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    x1, x2 = (float(v) for v in re.findall(r"\d\.\d+", result.stdout)[:2])
    assert 4.5 <= x1 <= 5.0
    assert 4.5 <= x2 <= 5.0


def test_the_page_on_drives_has_the_table_that_its_program_prints() -> None:
    page = (ROOT / "docs" / "drive.md").read_text()
    result = subprocess.run([sys.executable, "docs/drive_example.py"], check=False, cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("\n") == 6
    assert result.stdout in page
