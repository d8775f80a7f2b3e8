"""What a controller in integers takes on boards without a floating-point unit, beside the same one in floats.

    python -m benchmarks fixed [--task omni_s2 crane] [--points 400] [--board m0 ...] [--record FILE.md]

`control` of example tasks (with limits of u of 4 and ticks of a millisecond, where they have none), at ticks and states in, about
and far from the tube. Every board must give the bits of the emitted Python; the command ends with 1 where one does not. Beside
each the same task in floats, with the C library's logarithm and with its own.
"""

from __future__ import annotations

import argparse
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.suites.mcu import sizes
from benchmarks.suites.report import command, machine, record, table
from stt_codegen.board.boards import BOARDS
from stt_codegen.board.emulated import Emulated
from stt_codegen.compare.integer_comparison import ticks_and_states
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.program.targets import optional_targets
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task

ROOT = Path(__file__).resolve().parent.parent
SHOWN = ("m0", "m3", "m4f", "rv32", "avr")
TASKS = ("omni_s2", "crane")


def limited(task: Task) -> Task:
    """The task in integers, with a limit of u and a tick where it has none."""
    limits = {"u_max": task.control.u_max or (Fraction(4),) * task.dimension}
    tick = {"tick_period": task.emit.tick_period or Fraction(1, 1000), "scalar": "fixed", "math": "libm"}
    tick |= {target.key: False for target in optional_targets()}
    return task.model_copy(update={"control": task.control.model_copy(update=limits), "emit": task.emit.model_copy(update=tick)})


def in_floats(task: Task, math: str) -> EmittedController:
    """The same task in single precision, by seconds."""
    emit = {"scalar": "float", "math": math, "tick_period": None}
    return build_task(task.model_copy(update={"emit": task.emit.model_copy(update=emit)}))


def cost(controller: EmittedController, name: str, board: Emulated) -> list[str]:
    """Least, median and most of `control`; bytes of code, of tables in memory, and of stack."""
    seen = board.counts["control"].summary()
    code, tables, _ = sizes(controller, BOARDS[name])
    return [f"{seen.minimum:,.0f} / {seen.median:,.0f} / {seen.maximum:,.0f}", f"{code:,}", f"{tables:,}", str(seen.stack)]


def rows_of(name: str, boards: list[str], points: int) -> tuple[list[list[str]], bool]:
    """The rows of one task, and whether every board gave the Python's bits."""
    task = limited(load_task(ROOT / "tasks" / f"{name}.toml"))
    made, good = build_task(task), True
    tick, *states = ticks_and_states(made, made.design, points)
    status, u = GeneratedPython(made).call("control", tick, *states)
    unit = float(made.design.unit)  # type: ignore[union-attr]
    t = np.minimum(tick * float(task.emit.tick_period or 0), float(task.prescribed_time)).astype(np.float32)
    floats = {kind: in_floats(task, kind) for kind in ("libm", "inline")}
    rows = []
    for one in boards:
        board = Emulated(made, BOARDS[one])
        got = board.call("control", tick, *states)
        same = bool((got[0] == status).all() and (got[1] == u).all())
        good &= same
        rows.append([f"{name}, {one}: integers", *cost(made, one, board), "yes" if same else "NO"])
        for kind, controller in floats.items():
            board = Emulated(controller, BOARDS[one])
            board.call("control", t, *((v * unit).astype(np.float32) for v in states))
            rows.append([f"{name}, {one}: float, {kind}", *cost(controller, one, board), "-"])
    return rows, good


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--task", nargs="+", default=list(TASKS))
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument("--board", choices=tuple(BOARDS), action="append")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    asked = parser.parse_args()
    found = [rows_of(name, asked.board or list(SHOWN), asked.points) for name in asked.task]
    head = ["", "least / median / most seen", "code B", "tables B", "stack B", "the Python's bits"]
    text = table(head, [row for rows, _ in found for row in rows])
    print(text)
    if asked.record:
        title = f"## Integers in place of floats\n\nMade by `{command()}`: `control`, -O2; {machine()}."
        title += " For avr cycles; there the integers' tables are in flash, and counted with the code."
        record(asked.record, "fixed", f"{title}\n\n{text}")
    return int(not all(good for _, good in found))


if __name__ == "__main__":
    raise SystemExit(main())
