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
DEFAULT_BOARDS = ("m0", "m3", "m4f", "rv32", "avr")
TASKS = ("omni_s2", "crane")


def limited(task: Task) -> Task:
    """Return the task in integers, with a limit of u and a tick period where it has none."""
    limits = {"u_max": task.control.u_max or (Fraction(4),) * task.dimension}
    tick = {"tick_period": task.emit.tick_period or Fraction(1, 1000), "scalar": "fixed", "math": "libm"}
    tick |= {target.key: False for target in optional_targets()}
    return task.model_copy(update={"control": task.control.model_copy(update=limits), "emit": task.emit.model_copy(update=tick)})


def in_floats(task: Task, math: str) -> EmittedController:
    """Build the same task in single precision, with time in seconds. math: of the logarithm, libm or inline."""
    emit = {"scalar": "float", "math": math, "tick_period": None}
    return build_task(task.model_copy(update={"emit": task.emit.model_copy(update=emit)}))


def cost_cells(controller: EmittedController, name: str, board: Emulated) -> list[str]:
    """Return minimum, median and maximum cost of `control`, bytes of code, of tables in memory, and of stack, as text."""
    call_cost = board.counts["control"].summary()
    code, tables, _ = sizes(controller, BOARDS[name])
    steps = f"{call_cost.minimum:,.0f} / {call_cost.median:,.0f} / {call_cost.maximum:,.0f}"
    return [steps, f"{code:,}", f"{tables:,}", str(call_cost.stack)]


def rows_of(name: str, boards: list[str], points: int) -> tuple[list[list[str]], bool]:
    """Run one task on each board. Return its rows of the table, and whether every board gave the bits of the Python."""
    task = limited(load_task(ROOT / "tasks" / f"{name}.toml"))
    controller, all_equal = build_task(task), True
    tick, *states = ticks_and_states(controller, controller.design, points)
    status, u = GeneratedPython(controller).call("control", tick, *states)
    unit = float(controller.design.unit)  # type: ignore[union-attr]
    t = np.minimum(tick * float(task.emit.tick_period or 0), float(task.prescribed_time)).astype(np.float32)
    float_controllers = {math: in_floats(task, math) for math in ("libm", "inline")}
    rows = []
    for board_name in boards:
        board = Emulated(controller, BOARDS[board_name])
        board_status, board_u = board.call("control", tick, *states)
        is_equal = bool((board_status == status).all() and (board_u == u).all())
        all_equal &= is_equal
        rows.append([f"{name}, {board_name}: integers", *cost_cells(controller, board_name, board), "yes" if is_equal else "NO"])
        for math, float_controller in float_controllers.items():
            board = Emulated(float_controller, BOARDS[board_name])
            board.call("control", t, *((v * unit).astype(np.float32) for v in states))
            rows.append([f"{name}, {board_name}: float, {math}", *cost_cells(float_controller, board_name, board), "-"])
    return rows, all_equal


def main() -> int:
    """Run all tasks, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--task", nargs="+", default=list(TASKS))
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument("--board", choices=tuple(BOARDS), action="append")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    results = [rows_of(name, options.board or list(DEFAULT_BOARDS), options.points) for name in options.task]
    head = ["", "least / median / most seen", "code B", "tables B", "stack B", "the Python's bits"]
    text = table(head, [row for rows, _ in results for row in rows])
    print(text)
    if options.record:
        title = f"## Integers in place of floats\n\nMade by `{command()}`: `control`, -O2; {machine()}."
        title += " For avr cycles; there the integers' tables are in flash, and counted with the code."
        record(options.record, "fixed", f"{title}\n\n{text}")
    return int(not all(all_equal for _, all_equal in results))


if __name__ == "__main__":
    raise SystemExit(main())
