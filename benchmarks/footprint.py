"""Measure seconds of `--help` and `generate`, the time of a step on this machine, and bytes on a Cortex-M4F.

    python -m benchmarks footprint

Seconds are the median of nine processes. The time of a step is compared with one `logf` in the same process. Bytes need
arm-none-eabi-gcc. They are of the float file of every example task at -O2, for each function and for the tables.
"""

from __future__ import annotations

import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build
from stt_codegen.program.targets.c.runner import STRICT

TASKS = sorted(Path(__file__).parent.parent.glob("tasks/*.toml"))
CORTEX_M4F = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")


def seconds(*arguments: str) -> float:
    """Return the median wall time of nine runs of the command line with these arguments."""
    times = []
    for _ in range(9):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-m", "stt_codegen.cli", *arguments], check=True, capture_output=True)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


STEP_PROGRAM = r"""
#include <math.h>
#include <stdio.h>
#include <time.h>
#include "omni_s2.h"
#define TURNS 2000000
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
int main(void)
{
    volatile float sink = 0.0F;
    double step = 1e9, log1 = 1e9;
    for (int round = 0; round < 9; round++) { /* the smallest of nine, because other processes only add time */
        float u[2], x[2] = {0.4F, 0.4F};
        double begin = now();
        for (int k = 0; k < TURNS; k++) {
            x[0] = 0.3F + 1e-7F * (float)k;
            omni_s2_control(4.5e-6F * (float)k, x, u);
            sink += u[0];
        }
        const double middle = now();
        for (int k = 0; k < TURNS; k++) { sink += logf(0.5F + 1e-6F * (float)k); }
        const double end = now();
        step = fmin(step, (middle - begin) / TURNS);
        log1 = fmin(log1, (end - middle) / TURNS);
    }
    printf("%.3g %.3g", step * 1e9, log1 * 1e9);
    return 0;
}
"""


def step_over_logarithm(task_path: Path) -> str:
    """Return as text the nanoseconds of one refined `control` and of one `logf`, and their ratio; n = 2, -O2."""
    controller = build(task_path, "refined", "float")
    with tempfile.TemporaryDirectory() as folder:
        for name, data in controller.files.items():
            Path(folder, name).write_bytes(data)
        Path(folder, "main.c").write_text(STEP_PROGRAM)
        flags = ["-std=gnu99", "-ffp-contract=off", "-O2"]
        subprocess.run(["cc", *flags, "main.c", "omni_s2.c", "-o", "main", "-lm"], cwd=folder, check=True)
        result = subprocess.run([f"{folder}/main"], check=True, capture_output=True, text=True).stdout
    step, logarithm = map(float, result.split())  # nanoseconds
    return f"{step:.3g} ns, one logf {logarithm:.3g} ns: {step / logarithm:.2g} times"


def sections(task_path: Path, design: str) -> dict[str, int]:
    """Return the bytes of each function and of the tables, by name; functions are not inlined into each other."""
    controller = build(task_path, design, "float", uncertified=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, data in controller.files.items():
            Path(folder, name).write_bytes(data)
        source, target = f"{folder}/{controller.task.name}.c", f"{folder}/o.o"
        flags = [*CORTEX_M4F, *STRICT, "-ffunction-sections", "-c"]
        subprocess.run(["arm-none-eabi-gcc", *flags, source, "-o", target], check=True)
        lines = subprocess.run(["arm-none-eabi-size", "-A", target], check=True, capture_output=True, text=True).stdout
    rows = (line.split() for line in lines.splitlines() if line.startswith((".text.", ".rodata")))
    return {row[0].removeprefix(".text.").removeprefix(f"{controller.task.name}_"): int(row[1]) for row in rows}


def main() -> None:
    """Print all measurements."""
    with tempfile.TemporaryDirectory() as folder:
        print(f"--help    {seconds('--help'):.2f} s")
        print(f"generate  {seconds('generate', str(TASKS[0].with_name('omni_s1.toml')), '--out', folder):.2f} s")
    print(f"control   {step_over_logarithm(TASKS[0].with_name('omni_s2.toml'))}")
    if shutil.which("arm-none-eabi-gcc") is None:
        print("no arm-none-eabi-gcc: bytes on a Cortex-M4F not measured (Debian: gcc-arm-none-eabi)")
        return
    for design in ("refined", "adaptive"):
        for task in TASKS:
            try:
                sizes = sections(task, design)
            except BadInput:  # the task has options that this kind does not offer
                continue
            print(f"{task.stem:14s}{design:10s}", ", ".join(f"{name} {size}" for name, size in sizes.items()))


if __name__ == "__main__":
    main()
