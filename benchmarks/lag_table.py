"""Measure the slowest drive that is proved for robots with a refined tube, at three rates and start shares.

    python -m benchmarks lag_table [--rate HZ ..] [--share SHARE ..] [--task NAME ..] [--record FILE.md]

For each task of the list: the largest lag in milliseconds for which some gain and some limit on u of a grid are proved by the worst
path, by component where inputs are not coupled; then the same for two equal lags in series, their sum; and the proof's time. Gains
are multiples of the balancing gain, limits multiples of the input that the plant bounds need. W/P is the least width over closing
speed. Without --rate all three rates are measured, which takes hours; the rate of 50 Hz alone takes half of one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.suites.report import command, record, table
from stt_codegen.controller import edge_and_rate_errors
from stt_codegen.designs import RefinedDesign, require_refined
from stt_codegen.pipeline import build_program, design_tube
from stt_codegen.sampling.gains import balancing_gain, needed_input
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.order_two import inertial_start_bound
from stt_codegen.sampling.path.drive_response import Drive
from stt_codegen.sampling.path.path_proof import prove_path
from stt_codegen.sampling.path.path_windows import PathLoop
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task

ROOT = Path(__file__).parents[1]
RATES, SHARES = (50, 100, 1000), (Fraction(9, 10), Fraction(8, 10), Fraction(5, 10))
GAIN_MULTIPLES = np.geomspace(0.01, 1, 13).tolist()
INPUT_MULTIPLES = (1.15, 1.3, 1.5, 1.8, 2.2, 2.7, 3.5, 5.0)
SEARCH_STEPS = 7  # of bisection, after a lag is known up to a factor of 1.5
FIRST_LAG, LAG_FACTOR = Fraction(2, 1000), Fraction(3, 2)

WAREHOUSE = """
name = "amr"
prescribed_time = 15.0
initial_state = [1.0, 1.2]
body = [0.35, 0.35]
[state_space]
lower = [0.0, 0.0]
upper = [12.0, 6.0]
[initial_set]
lower = [0.7, 0.9]
upper = [1.3, 1.5]
[target_set]
lower = [10.6, 4.3]
upper = [11.4, 5.1]
[[unsafe]]
lower = [3.0, 0.0]
upper = [3.6, 3.0]
[[unsafe]]
lower = [6.5, 3.2]
upper = [7.1, 6.0]
[tube]
clearance = 0.05
min_width = 0.3
max_speed = 0.8
[plant]
w_max = 0.1
g_min = 0.95
g_max = 1.05
noise = 0.003
"""
QUADROTOR = """
name = "quadrotor"
prescribed_time = 14.0
initial_state = [0.8, 0.8, 1.0]
body = [0.2, 0.2, 0.1]
[state_space]
lower = [0.0, 0.0, 0.2]
upper = [10.0, 6.0, 3.0]
[initial_set]
lower = [0.3, 0.3, 0.5]
upper = [1.3, 1.3, 1.5]
[target_set]
lower = [8.6, 4.6, 1.2]
upper = [9.6, 5.6, 2.2]
[[unsafe]]
axes = ["x1", "x2"]
lower = [3.2, 0.0]
upper = [6.0, 2.2]
[[unsafe]]
axes = ["x1", "x2"]
lower = [3.2, 3.7]
upper = [6.0, 6.0]
[tube]
clearance = 0.03
min_width = 0.3
[plant]
order = 2
f_max = 0.05
w_max = 1.5
g_min = 0.95
g_max = 1.05
noise = 0.005
noise_v = 0.03
"""
SHIPPED = ("omni_s2", "crawler", "trolley", "rover", "drone", "crane", "base", "attitude", "arm")
TASKS = ("amr", *SHIPPED, "quadrotor")


@dataclass(frozen=True)
class Robot:
    """A task with its tube, its loop for the worst path, the balancing gain, the needed input, and the least W/P in seconds."""

    task: Task
    design: RefinedDesign
    loop: PathLoop
    balancing: list[Fraction]
    needed: list[Fraction]
    width_over_speed: float

    def with_share(self, share: Fraction) -> Robot:
        """Return the robot for other starts."""
        task = self.task.changed(initial_set={"share": share})
        ratios = (
            [(1 + share) / (1 - share)] * task.dimension
            if task.order == 1
            else inertial_start_bound(task, self.design, None, FRACTIONS).tolist()
        )
        laws = [replace(law, rho_at_start=ratio) for law, ratio in zip(self.loop.laws, ratios, strict=True)]
        return replace(self, loop=self.loop.with_laws(laws))


def robot_of(name: str) -> Robot:
    """Return a robot by its name: of tasks/, or one of the two above."""
    text = {"amr": WAREHOUSE, "quadrotor": QUADROTOR}.get(name)
    task = load_task(ROOT / "tasks" / f"{name}.toml") if text is None else parse_task(text)
    design = require_refined(design_tube(task))
    task = task.with_gain([Fraction(1, 10)] * task.dimension) if task.has_automatic_gain else task
    errors = edge_and_rate_errors(design, build_program(task, design))
    exact, loop = exact_loop(task, design, *errors), loop_of(task, design, *errors)
    rates = design.filter if task.order == 2 else ()
    path_loop = PathLoop.of(exact, [Drive()] * task.dimension, Fraction(1, 50), rates, design.seam)
    numbers = [[Fraction(v) for v in values.tolist()] for values in (balancing_gain(loop), needed_input(loop))]
    with np.errstate(divide="ignore"):
        crossing = float((loop.windows.narrow / loop.closing_speed).min())
    return Robot(task, design, path_loop, *numbers, width_over_speed=crossing)


def choices(loop: PathLoop, balancing: Sequence[Fraction], needed: Sequence[Fraction]) -> Iterator[PathLoop]:
    """Yield the loop with every gain and limit of the grid: one multiple for all components, those in the middle first."""
    grid = [(k, f) for k in GAIN_MULTIPLES for f in INPUT_MULTIPLES]
    grid.sort(key=lambda choice: abs(np.log(choice[0] / 0.06)) + abs(np.log(choice[1] / 2.0)))
    for multiple, factor in grid:
        laws = [
            replace(law, gain=Fraction(multiple) * k, u_max=Fraction(factor) * u)
            for law, k, u in zip(loop.laws, balancing, needed, strict=True)
        ]
        yield loop.with_laws(laws)


def largest_lag(robot: Robot, rate: int, lag_count: int) -> Fraction:
    """Return the largest lag in seconds, or the sum of two equal ones, that some choice proves; 0 where none is."""
    loop = robot.loop.with_period(Fraction(1, rate))
    if any(any(row.cross) for rows in loop.rows for row in rows):
        return _largest(loop, robot.balancing, robot.needed, lag_count)
    parts = range(loop.n)
    return min(_largest(loop.component(i), robot.balancing[i : i + 1], robot.needed[i : i + 1], lag_count) for i in parts)


def _largest(loop: PathLoop, balancing: Sequence[Fraction], needed: Sequence[Fraction], lag_count: int) -> Fraction:
    """Return the largest lag of all components of a loop."""

    def is_proved(choice: PathLoop, lag: Fraction) -> bool:
        drive = Drive((lag / lag_count,) * lag_count)
        return prove_path(choice.with_drives([drive] * choice.n)) is not None

    best = Fraction(0)
    for choice in choices(loop, balancing, needed):
        low = best * Fraction(101, 100) if best else FIRST_LAG
        if not is_proved(choice, low):
            continue
        high = low * LAG_FACTOR
        while is_proved(choice, high):
            low, high = high, high * LAG_FACTOR
        for _ in range(SEARCH_STEPS):
            middle = (low + high) / 2
            low, high = (middle, high) if is_proved(choice, middle) else (low, middle)
        best = low
    return best


def row_of(name: str, rates: Sequence[int], shares: Sequence[Fraction]) -> list[str]:
    """Return the table's row of a robot: lags in milliseconds, by start share, for every rate, and for two lags at 50 Hz."""
    robot, begin = robot_of(name), time.process_time()
    robots = [robot.with_share(share) for share in shares]
    cells = [" / ".join(f"{float(largest_lag(r, rate, 1)) * 1e3:.0f}" for r in robots) for rate in rates]
    two = " / ".join(f"{float(largest_lag(r, 50, 2)) * 1e3:.0f}" for r in robots)
    return [name, f"{robot.width_over_speed:.2f}", *cells, two, f"{time.process_time() - begin:.0f}"]


def main() -> int:
    """Print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rate", type=int, action="append")
    parser.add_argument("--share", type=Fraction, action="append")
    parser.add_argument("--task", action="append", choices=TASKS)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    rates, shares = options.rate or RATES, options.share or SHARES
    headings = ["task", "W/P, s", *(f"{rate} Hz" for rate in rates), "two equal lags, sum, 50 Hz", "s CPU"]
    rows = []
    for name in options.task or TASKS:
        rows.append(row_of(name, rates, shares))
        print(" | ".join(rows[-1]), flush=True)
    text = table(headings, rows)
    print(text)
    if options.record:
        shown = " / ".join(f"{float(v):g}" for v in shares)
        about = f"The largest lag in ms that is proved, from start shares of {shown}."
        record(options.record, "lag-table", f"## Drives that lag\n\n`{command()}`\n\n{about}\n\n{text}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
