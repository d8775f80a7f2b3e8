"""Start-up, generation and size: seconds of `--help` and `generate` (median of nine processes), bytes on a Cortex-M4F.

    python benchmarks/footprint.py

Bytes need arm-none-eabi-gcc and are of the float file of every example task at -O2, by function, tables apart.
"""

from __future__ import annotations

import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from stt_codegen.backends import STRICT
from stt_codegen.pipeline import build

TASKS = sorted(Path(__file__).parent.parent.glob("tasks/*.toml"))
CORTEX_M4F = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")


def seconds(*arguments: str) -> float:
    """Median wall time of nine runs of the command line."""
    times = []
    for _ in range(9):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-m", "stt_codegen.cli", *arguments], check=True, capture_output=True)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def sections(task: Path, design: str) -> dict[str, int]:
    """Bytes of each function (when nothing is inlined across them) and of the tables."""
    controller = build(task, design, "float", uncertified=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, data in controller.files.items():
            Path(folder, name).write_bytes(data)
        source, target = f"{folder}/{controller.task.name}.c", f"{folder}/o.o"
        flags = [*CORTEX_M4F, *STRICT, "-ffunction-sections", "-c"]
        subprocess.run(["arm-none-eabi-gcc", *flags, source, "-o", target], check=True)
        lines = subprocess.run(["arm-none-eabi-size", "-A", target], check=True, capture_output=True, text=True).stdout
    found = (line.split() for line in lines.splitlines() if line.startswith((".text.", ".rodata")))
    return {row[0].removeprefix(".text.").removeprefix(f"{controller.task.name}_"): int(row[1]) for row in found}


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        print(f"--help    {seconds('--help'):.2f} s")
        print(f"generate  {seconds('generate', str(TASKS[0].with_name('omni_s1.toml')), '--out', folder):.2f} s")
    if shutil.which("arm-none-eabi-gcc") is None:
        print("no arm-none-eabi-gcc: bytes on a Cortex-M4F not measured (Debian: gcc-arm-none-eabi)")
        return
    for design in ("refined", "adaptive"):
        for task in TASKS:
            print(f"{task.stem:14s}{design:10s}", ", ".join(f"{name} {size}" for name, size in sections(task, design).items()))


if __name__ == "__main__":
    main()
