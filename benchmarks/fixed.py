"""What a controller in integers alone takes on boards without a floating-point unit, beside the float's.

    python benchmarks/fixed.py [--task omni_s2] [--points 400] [--board m0 ...] [--record FILE.md]

`control` of an example task of order 1 (with limits of u of 4 and ticks of a millisecond, where it has none). First it is proved
that no integer leaves 32 bits, whatever the input; then the C runs on each emulated board, at ticks and states in, about and far
from the tube, and must give the bits of the Python. The command ends with 1 where it does not.

Not a package that can be generated yet: no certificate counts this arithmetic.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from random import Random
from types import ModuleType

import numpy as np
from stt_codegen.controller.fixed import clock_of, fixed_program

from stt_codegen.bench.mcu import sizes
from stt_codegen.bench.report import command, machine, record, table
from stt_codegen.board.emulated import BOARDS, Emulated
from stt_codegen.compare.toolchain import load_module
from stt_codegen.designs import RefinedDesign
from stt_codegen.emit.render import Files
from stt_codegen.pipeline import Controller, build_task
from stt_codegen.program import Program
from stt_codegen.program.print.c import CPrinter
from stt_codegen.program.print.python import PythonPrinter
from stt_codegen.program.ranges import ranges
from stt_codegen.task import Task, load_task

ROOT = Path(__file__).resolve().parent.parent
SHOWN = ("m0", "m3", "m4f", "rv32", "avr")


def limited(name: str) -> Task:
    """The example task with a limit of u and a tick."""
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    limits = {"u_max": task.control.u_max or (Fraction(4),) * task.dimension}
    tick = {"tick_period": task.emit.tick_period or Fraction(1, 1000), "scalar": "fixed"}
    return task.model_copy(update={"control": task.control.model_copy(update=limits), "emit": task.emit.model_copy(update=tick)})


def c_files(program: Program) -> Files:
    """Header and C."""
    c = CPrinter(program)
    head = ["#include <stdbool.h>", "#include <stdint.h>", f"#define {c.macro}_N {program.dimension}"]
    head += [f"typedef enum {{ {c.macro}_OK, {c.macro}_OUTSIDE_TUBE }} {c.prefix}_status;", f"typedef int32_t {c.real};"]
    head += [line for f in program.functions for line in c.prototype(f)]
    body = [f'#include "{c.prefix}.h"', *c.helpers()]
    body += [line for t in program.tables for line in c.table(t)]
    body += [line for k in program.kernels for line in c.kernel(k)]
    body += [line for f in program.functions for line in c.function(f)]
    return {f"{c.prefix}.{end}": ("\n".join(lines) + "\n").encode() for end, lines in (("h", head), ("c", body))}


def python_module(program: Program) -> ModuleType:
    """The same in Python, whose integers have no end."""
    p = PythonPrinter(program)
    lines = ["OK, OUTSIDE_TUBE = 0, 1", "def _whole(name, values, length):", "    return list(values)"]
    lines += ["def _count(name, value):", "    return value"]
    lines += [line for t in program.tables for line in p.table(t)]
    lines += [line for k in program.kernels for line in p.kernel(k)]
    lines += [line for f in program.functions for line in p.function(f)]
    return load_module(program.prefix, "\n".join(lines).encode())


def points(task: Task, design: RefinedDesign, python: ModuleType, count: int, seed: int = 1) -> list[tuple[int, list[int]]]:
    """Ticks of the mission and of none; states in and about the tube, at its edges, and anywhere."""
    assert task.emit.tick_period is not None
    dice, last, found = Random(seed), clock_of(design, task.emit.tick_period).last, []
    for _ in range(count):
        tick = dice.choice([0, last - 1, last, 2**32 - 1, dice.randrange(2**32), *(dice.randrange(last) for _ in range(9))])
        x = []
        for low, high in zip(*python.tube(tick), strict=True):
            near = low + round((high - low) * dice.choice([dice.random(), 0.5, 0.005, dice.uniform(-0.2, 1.2)]))
            x.append(dice.choice([near] * 12 + [low, high, -(2**31), 2**31 - 1, dice.randrange(-(2**31), 2**31)]))
        found.append((tick, x))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--task", default="omni_s2")
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument("--board", choices=tuple(BOARDS), action="append")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    asked = parser.parse_args()
    task = limited(asked.task)
    built = build_task(task.model_copy(update={"emit": task.emit.model_copy(update={"tick_period": None})}))
    assert isinstance(built.design, RefinedDesign)
    program = fixed_program(task, built.design)
    for function in program.functions:
        ranges(program, function.name)
    python = python_module(program)
    given = points(task, built.design, python, asked.points)
    wanted = [python.control(tick, x) for tick, x in given]
    fixed, rows, good = replace(built, program=program, files=c_files(program)), [], True
    for name in asked.board or SHOWN:
        board = Emulated(fixed, BOARDS[name], extra=("-w",))
        status, u = board.call("control", np.array([t for t, _ in given], np.uint32), np.array([x for _, x in given], np.int32))
        same = [(int(s), tuple(int(v) for v in row)) == want for s, row, want in zip(status, u, wanted, strict=True)]
        good &= all(same)
        rows.append([f"{name}: integers", *cost(fixed, name, board), "yes" if all(same) else "NO"])
        x = np.array([[float(v * built.design.unit) for v in x] for _, x in given], np.float32)
        t = np.array([float(min(t * (task.emit.tick_period or 0), task.prescribed_time)) for t, _ in given], np.float32)
        float_board = Emulated(built, BOARDS[name])
        float_board.call("control", t, x)
        rows.append([f"{name}: float", *cost(built, name, float_board), "-"])
    text = table(["", "least / median / most seen", "code B", "tables B", "stack B", "the Python's bits"], rows)
    print(text)
    if asked.record:
        title = f"## Integers in place of floats\n\nMade by `{command()}`: `control` of {task.name}; {machine()}. For avr cycles."
        record(asked.record, "fixed", f"{title}\n\n{text}")
    return int(not good)


def cost(controller: Controller, name: str, board: Emulated) -> list[str]:
    seen = board.counts["control"].summary()
    code, tables, _ = sizes(controller, BOARDS[name])
    return [f"{seen.least:,.0f} / {seen.median:,.0f} / {seen.most:,.0f}", f"{code:,}", f"{tables:,}", str(seen.stack)]


if __name__ == "__main__":
    raise SystemExit(main())
