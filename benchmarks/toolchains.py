"""Try the emitted C under compilers, processors and flags: warnings, fused operations, and the answer of its self-test.

    python -m benchmarks toolchains [--target NAME ...] [--record FILE.md]

The controllers are of order 1, order 2 (its logarithm written out) and of a mission, each in float, double and integers. Every
compiler gets the flags of real board packages. Images run on this machine, under QEMU or under simavr. Two targets at least are
big-endian. A compiler that is missing is left out with a line that says so; with CI=true that is a failure. The command ends with
1 where a compiler warns, fuses a product and a sum, compiles under -ffast-math, or where a self-test does not pass.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from pathlib import Path

from benchmarks.compilers.builds import REFUSED, BuildResult, fast_math_answer, try_build
from benchmarks.compilers.targets import TARGETS, Target
from benchmarks.suites.report import command, record, table
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.task.load import load_task

ROOT = Path(__file__).resolve().parent.parent
TASKS = {"order 1": "omni_s2", "order 2": "crane", "mission": "courier"}
SCALARS = ("float", "double", "fixed")
Controllers = dict[str, dict[str, EmittedController]]  # by scalar, then by name in TASKS


def selftested(name: str, scalar: str) -> EmittedController:
    """Build the controller of an example with a self-test. In integers it has a limit of u and ticks, where its task has none."""
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    if scalar == "fixed":
        limit = {"u_max": task.control.u_max or (Fraction(4),) * task.dimension}
        emit = {"tick_period": task.emit.tick_period or Fraction(1, 1000), "math": "libm", "scalar": scalar, "selftest": True}
        return build_task(task.changed(control=limit, emit=emit))
    math = "inline" if name == TASKS["order 2"] else "libm"
    return build_task(task.changed(emit={"scalar": scalar, "tick_period": None, "math": math, "selftest": True}))


def all_controllers() -> Controllers:
    """Build every controller that is tried, by scalar and by name."""
    return {scalar: {label: selftested(name, scalar) for label, name in TASKS.items()} for scalar in SCALARS}


@dataclass
class ToolchainRow:
    """A compiler with one set of flags, and what came out by scalar and controller."""

    target: Target
    flags: str
    version: str
    results: dict[str, dict[str, BuildResult]] = field(default_factory=dict)
    fast_math: list[str] = field(default_factory=list)

    @property
    def has_passed(self) -> bool:
        """Whether every build passed, and no float is compiled under -ffast-math."""
        builds = [result for results in self.results.values() for result in results.values()]
        return all(b.has_passed for b in builds) and set(self.fast_math) <= {REFUSED}

    def cells(self) -> list[str]:
        """Return the row of the table."""
        builds = [result for results in self.results.values() for result in results.values()]
        warnings = sum(len(b.warnings) for b in builds)
        fused, without = sum(b.fused for b in builds), sum(b.fused_without_pragmas for b in builds)
        answers = [_answers(self.results[scalar]) for scalar in SCALARS]
        fast_math = self.fast_math[0] if len(set(self.fast_math)) == 1 else "; ".join(self.fast_math)
        name = f"{self.target.name}: {self.target.compiler} {self.version}"
        return [name, f"`{self.flags}`", str(warnings), f"{fused} ({without})", *answers, fast_math]


def _answers(results: dict[str, BuildResult]) -> str:
    """Return the self-tests' answers of one scalar: "passes" where all do, else what each says."""
    texts = {label: result.words() for label, result in results.items()}
    if len(set(texts.values())) == 1:
        return next(iter(texts.values()))
    return "; ".join(f"{label}: {text}" for label, text in texts.items())


def rows_of(target: Target, controllers: Controllers) -> list[ToolchainRow]:
    """Try every controller under every set of flags of a target, whose tools are installed."""
    version = subprocess.run([target.compiler, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    number = re.findall(r"\d+\.\d+\.\d+", version)[-1]
    rows = []
    refusals = [
        fast_math_answer(controller, target)
        for scalar in ("float", "double")
        if scalar == "float" or target.has_doubles
        for controller in controllers[scalar].values()
    ]
    for flags in target.flag_sets():
        row = ToolchainRow(target, flags, number, fast_math=refusals)
        for scalar, by_name in controllers.items():
            row.results[scalar] = {label: try_build(controller, target, flags.split()) for label, controller in by_name.items()}
        rows.append(row)
    print(f"{target.name}: {target.compiler} is done", file=sys.stderr, flush=True)
    return rows


HEADINGS = (
    *("processor and compiler", "flags", "warnings", "fused (without pragmas)"),
    *("self-tests in float", "in double", "in integers", "-ffast-math"),
)
NOTE = """Each row is about nine controllers: order 1 (omni_s2), order 2 with its logarithm written out (crane) and a mission
(courier), in three kinds of numbers. Warnings are those of the strict set of docs/c.md. Fused operations are counted in the
disassembled object code; in brackets those that the compiler makes of the same files without their pragmas. Where `double` has 32
bits the file refuses to compile. An image whose data do not fit the memory is not run; its other columns count.
MIPS32r2 is compiled with -mno-madd4 (docs/c.md says why)."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Try all targets, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", nargs="+", metavar="NAME", help="those whose name or compiler contains one of these")
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args(arguments)
    words = options.target or [""]
    targets = [t for t in TARGETS if any(word in f"{t.name}: {t.compiler}" for word in words)]
    if not targets:
        parser.error(
            f"no target contains {' or '.join(words)}; there are {'; '.join(f'{t.name}: {t.compiler}' for t in TARGETS)}"
        )
    installed = [t for t in targets if not t.missing_tools]
    controllers = all_controllers()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = [row for rows in pool.map(partial(rows_of, controllers=controllers), installed) for row in rows]
    text = table(HEADINGS, [row.cells() for row in rows])
    missing = [
        f"{t.name}: {t.compiler} was not tried: {', '.join(t.missing_tools)} is not installed (Debian names: {t.packages})"
        for t in targets
        if t.missing_tools
    ]
    print("\n".join([text, *missing]))
    for row in rows:
        for results in row.results.values():
            for label, result in results.items():
                for line in result.warnings:
                    print(f"{row.target.name}, {row.flags}, {label}: {line}")
    if options.record:
        parts = [f"## Compilers and processors\n\nMade by `{command()}`. {NOTE}", text, *missing]
        record(options.record, "toolchains", "\n\n".join(parts))
    is_missing_in_ci = bool(missing) and os.environ.get("CI") == "true"
    return int(is_missing_in_ci or not all(row.has_passed for row in rows))


if __name__ == "__main__":
    sys.exit(main())
