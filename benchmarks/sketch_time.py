"""Run the example sketches on a simulated Uno with slow sensors: compare the tube's time with the clock, and count steps.

    python -m benchmarks sketch_time [--steps 150] [--count 60]

First the real sketch runs with Arduino's core for AVR in simavr; reading the sensors takes up to two and a half periods. At
every sample the time that the controller gets must agree with micros(), to one tick or to the rounding of a float. Then the
cycles of `control`, compiled with the options of Arduino's IDE, are compared with the estimate of `generate`. The exit code is
1 where a time or an estimate is wrong.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fixed import in_floats, limited
from benchmarks.suites.report import table
from stt_codegen.board.boards import BOARDS
from stt_codegen.board.emulated import DECORATION, Emulated
from stt_codegen.certify.missions.proof import cycle_of
from stt_codegen.compare.integer_comparison import ticks_and_states
from stt_codegen.errors import MissingTool
from stt_codegen.files import write_files
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.record.package import package
from stt_codegen.record.sketch import loop_times
from stt_codegen.record.uno import RELATIVE_ERROR, step_cycles
from stt_codegen.task import Task
from stt_codegen.task.load import load_task

ROOT = Path(__file__).resolve().parent.parent
CORE = Path("/usr/share/arduino/hardware/arduino/avr")  # Debian's arduino-core-avr
IDE_FLAGS = ("-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-Os", "-ffunction-sections")
SKETCHES: dict[str, tuple[str, dict[str, Any]]] = {
    "seconds": ("crawler", {"emit": {"tick_period": None}}),
    "ticks": ("crawler", {}),
    "integers": ("gantry", {}),
    "repeat, ticks": ("watchman", {}),
    "repeat, seconds": ("watchman", {"emit": {"tick_period": None}, "prescribed_time": "15.90001"}),
    "hold": ("omni_board", {"control": {"outside": "hold"}, "emit": {"selftest": False}}),
}
COUNTED_TASKS = ("omni_s2", "trolley", "spacecraft", "crane", "drone", "arm", "attitude")
HARNESS = """#include <avr/sleep.h>
static uint32_t dice = 1;
static int slow_read(int pin) {
  if (pin == 0) {
    dice = dice * 1664525UL + 1013904223UL;
    for (uint32_t rest = ((dice >> 16) * %(most)uUL) >> 16; rest > 0; ) {
      const uint32_t part = rest < 8000 ? rest : 8000;
      delayMicroseconds((unsigned int)part);
      rest -= part;
    }
  }
  static const int readings[] = {%(readings)s};  // of a start that is covered: nothing moves before one
  return readings[pin];
}
#define analogRead slow_read
#define loop sketch_loop
#include "sketch.ino"
#undef loop
static %(time)s called_at;
static bool stepped;
extern "C" {
%(status)s __real_%(function)s(%(parameters)s);
%(status)s __wrap_%(function)s(%(parameters)s) {
  if (!stepped) { called_at = t; }
  stepped = true;
  return __real_%(function)s(%(arguments)s);
}
}
static void put(uint32_t word) {
  for (int k = 28; k >= 0; k -= 4) {
    UDR0 = (uint8_t)"0123456789abcdef"[(word >> k) & 15U];
    delayMicroseconds(20);  // longer than a character takes
  }
}
void loop() {
  static int steps;
  stepped = false;
  if (UCSR0B == 0) { UCSR0B = (uint8_t)(1U << TXEN0); }
  sketch_loop();
  if (stepped) {
    uint32_t bits;
    memcpy(&bits, &called_at, sizeof bits);
    put(last); put(bits); put(late_steps);
    UDR0 = '\\n';
    if (++steps >= %(steps)d) { delay(5); cli(); sleep_mode(); }
  }
}
"""


def run(command: list[Any], folder: Path) -> str:
    """Run a command in the folder, and return its output. Raises SystemExit with its errors where it fails."""
    process = subprocess.run([str(c) for c in command], cwd=folder, capture_output=True, text=True, check=False, timeout=120)
    if process.returncode:
        raise SystemExit(f"{command[0]}: {process.stderr[-2000:]}")
    return process.stdout + process.stderr


def core_objects(folder: Path) -> list[Path]:
    """Compile Arduino's core, and return its object files."""
    includes = [f"-I{CORE / 'cores' / 'arduino'}", f"-I{CORE / 'variants' / 'standard'}"]
    objects = []
    for part in sorted((CORE / "cores" / "arduino").glob("*.c*")):
        driver = ["avr-g++", "-std=gnu++11", "-fpermissive", "-fno-exceptions"] if part.suffix == ".cpp" else ["avr-gcc"]
        objects.append(folder / f"core_{part.stem}_{part.suffix[1:]}.o")
        run([*driver, *IDE_FLAGS, *includes, "-DDECIMAL_DIG=__DECIMAL_DIG__", "-w", "-c", part, "-o", objects[-1]], folder)
    return objects


def build_image(controller: EmittedController, steps: int, core: list[Path], folder: Path) -> Path:
    """Build the sketch for an Uno with slow sensors; it writes the controller's arguments on the serial line."""
    p, n = controller.task.name, f"{controller.task.name.upper()}_N"
    write_files(folder, package(controller, "arduino"))
    source = folder / p / "src"
    shutil.copy(folder / p / "examples" / f"{p}_loop" / f"{p}_loop.ino", folder / "sketch.ino")
    integers = controller.program.tick is not None
    by_ticks = controller.task.emit.tick_period is not None and controller.task.control.outside == "return"
    number = "int32_t" if integers else f"{p}_real"
    function, extra_parameter = (
        (f"{p}_guard", f", {number} held[2]") if controller.task.control.outside == "hold" else (f"{p}_control", "")
    )
    words = {
        "readings": ", ".join(map(str, covered_readings(controller.task))),
        "most": int(loop_times(controller).period * 2_500_000), "steps": steps, "status": f"{p}_status",
        "time": "uint32_t" if by_ticks else number, "function": f"{function}{'_tick' if by_ticks and not integers else ''}",
        "parameters": f"{'uint32_t' if by_ticks else number} t, const {number} x[{n}]{extra_parameter}, {number} u[{n}]",
        "arguments": "t, x, held, u" if extra_parameter else "t, x, u",
    }  # fmt: skip
    (folder / "main.cpp").write_text(HARNESS % words)
    includes = [f"-I{v}" for v in (CORE / "cores" / "arduino", CORE / "variants" / "standard", source, folder)]
    objects = [folder / "main.o"]
    run(["avr-g++", *IDE_FLAGS, *includes, "-std=gnu++11", "-include", "Arduino.h", "-c", "main.cpp", "-o", objects[0]], folder)
    for file in source.glob("*.c"):
        objects.append(folder / f"{file.stem}.o")
        run(["avr-gcc", *IDE_FLAGS, *includes, "-std=gnu11", "-ffp-contract=off", "-c", file, "-o", objects[-1]], folder)
    wrap = f"-Wl,--gc-sections,--wrap={words['function']}"
    run(["avr-g++", "-mmcu=atmega328p", wrap, *objects, *core, "-lm", "-o", "uno.elf"], folder)
    return folder / "uno.elf"


def covered_readings(task: Task) -> list[int]:
    """Return the readings of a 10-bit converter, as the sketch scales them, at the initial state."""
    low, high = min(task.state_space.lower), max(task.state_space.upper)
    return [round(1023 * (start - low) / (high - low)) for start in task.initial_state]


@dataclass(frozen=True)
class ClockComparison:
    """Largest difference of the tube's time and the clock over the samples, and the allowed one, both in seconds."""

    samples: int
    difference: Fraction
    limit: Fraction
    late_steps: int


def compare_clock(controller: EmittedController, steps: int, core: list[Path]) -> ClockComparison:
    """Run a sketch in simavr, and compare the tube's time with the clock. Raises SystemExit where samples are missing."""
    task = controller.task
    with tempfile.TemporaryDirectory() as name:
        output = run(
            ["simavr", "-m", "atmega328p", "-f", "16000000", build_image(controller, steps, core, Path(name))], Path(name)
        )
    lines = (DECORATION.sub("", line) for line in output.splitlines())
    rows = [[int(line[k : k + 8], 16) for k in (0, 8, 16)] for line in lines if re.fullmatch(r"[0-9a-f]{24}", line)]
    if len(rows) != steps:
        raise SystemExit(f"{task.name}: {len(rows)} samples for {steps}: {output[-500:]}")
    by_ticks = task.emit.tick_period is not None and task.control.outside == "return"
    cycle, largest = cycle_of(controller.design), Fraction(0)
    for now, bits, _ in rows:
        clock = Fraction((now - rows[0][0]) % 2**32, 10**6)
        if by_ticks:
            assert task.emit.tick_period is not None
            tube = bits * task.emit.tick_period
        else:
            tube = Fraction(float(np.array([bits], np.uint32).view(np.float32)[0]))
        if cycle is not None and clock >= cycle.end:
            clock -= cycle.length * (1 + int((clock - cycle.end) / cycle.length))
        if not task.repeat:
            clock, tube = min(clock, task.prescribed_time), min(tube, task.prescribed_time)
        largest = max(largest, abs(clock - tube))
    limit = task.emit.tick_period if by_ticks else 4 * Fraction(1, 2**24) * task.prescribed_time + Fraction(1, 10**6)
    assert limit is not None
    return ClockComparison(len(rows), largest, limit, rows[-1][2])


def largest_cycles(controller: EmittedController, count: int) -> int:
    """Return the largest number of cycles of `control`, at states near the tube and in it."""
    board, task = Emulated(controller, BOARDS["avr"], ("-Os",)), controller.task
    if controller.program.tick is not None:
        tick, *states = ticks_and_states(controller, controller.design, count)
        board.call("control", tick, *states)
    else:
        rng = np.random.default_rng(1)
        t = np.linspace(0, float(task.prescribed_time), count).astype(np.float32)
        lower, upper = GeneratedPython(controller).call("tube", t.astype(float))
        x = (lower + (upper - lower) * rng.uniform(-0.1, 1.1, lower.shape)).astype(np.float32)
        board.call("control", t, x, *([rng.uniform(-0.1, 0.1, x.shape).astype(np.float32)] * (task.order == 2)))
    return board.counts["control"].summary().maximum


def main() -> int:
    """Run all sketches and count all controllers, and print the tables. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--steps", type=int, default=150)
    parser.add_argument("--count", type=int, default=60)
    options = parser.parse_args()
    for tool in ("avr-gcc", "simavr"):
        if shutil.which(tool) is None:
            raise MissingTool(f"{tool} is not found; install (Debian names): gcc-avr avr-libc simavr arduino-core-avr")
    all_good, rows = True, []
    with tempfile.TemporaryDirectory() as folder:
        core = core_objects(Path(folder))
        for variant, (name, options_of_task) in SKETCHES.items():
            controller = build_task(load_task(ROOT / "tasks" / f"{name}.toml").changed(**options_of_task))
            c = compare_clock(controller, options.steps, core)
            is_equal = c.difference <= c.limit
            all_good &= is_equal
            microseconds = [f"{float(v) * 1e6:,.1f}" for v in (c.difference, c.limit)]
            rows.append([f"{name}, {variant}", str(c.samples), *microseconds, str(c.late_steps), "yes" if is_equal else "NO"])
    print(table(["", "samples", "tube and clock apart, us", "allowed, us", "late", "kept"], rows), flush=True)
    rows = []
    for name in COUNTED_TASKS:
        task = load_task(ROOT / "tasks" / f"{name}.toml")
        for kind, controller in (*((k, in_floats(task, k)) for k in ("libm", "inline")), ("integers", build_task(limited(task)))):
            estimate, cycles = step_cycles(controller), largest_cycles(controller, options.count)
            assert estimate is not None
            error = estimate / cycles - 1
            is_close = abs(error) <= RELATIVE_ERROR
            all_good &= is_close
            rows.append([f"{name}, {kind}", f"{cycles:,}", f"{estimate:,}", f"{error:+.1%}", "yes" if is_close else "NO"])
    print(table(["", "cycles counted, most", "estimate", "off", "within"], rows))
    print("every tube is where the clock is, every estimate within its error" if all_good else "NOT KEPT: see NO above")
    return int(not all_good)


if __name__ == "__main__":
    raise SystemExit(main())
