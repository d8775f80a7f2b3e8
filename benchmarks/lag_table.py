"""Measure the slowest drives and the longest periods that are proved for robots with a refined tube.

    python -m benchmarks lag_table [--rate HZ ..] [--share SHARE ..] [--task TASK ..] [--w-max W] [--record FILE.md]

The first table has for each robot the largest lag in milliseconds that the worst path proves with some gain and some limit on u
of a grid, by rate and by start share; then the same for two equal lags in series, their sum; the limit at 50 Hz as a multiple of
the input that the plant needs; and the processor time of one proof. Where inputs are not coupled, every component has its own
choice, and the least lag counts. Gains are multiples of the balancing gain. W/P is the least width over closing speed. The search
climbs from choice to choice of the grid. The second table has the longest period without a lag, by the sharp conditions and by
the path, with the gentlest gain that is proved at 20 ms and a limit of 1.5 times what is needed. Numbers in brackets are those of
a study in doubles, which tried the whole grid. Both tables take four minutes of
processor time. The climb may stop beside the best choice: a row whose lag falls at a higher rate shows it.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.suites.report import command, record, table
from stt_codegen.controller import edge_and_rate_errors
from stt_codegen.designs import RefinedDesign, require_refined
from stt_codegen.pipeline import build_program, preferred_tube
from stt_codegen.sampling.gains import balancing_gain, needed_input
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.order_two import inertial_start_bound
from stt_codegen.sampling.path import Drive, PathLoop, choose_path_gain, longest_path_period, prove_path, with_gain
from stt_codegen.sampling.periods import longest_proved_period
from stt_codegen.sampling.sampled_loop import SampledLoop
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task

ROOT = Path(__file__).parents[1]
RATES, SHARES = (50, 100, 1000), (Fraction(9, 10), Fraction(8, 10), Fraction(5, 10))
GAIN_MULTIPLES = np.geomspace(0.01, 1, 13).tolist()  # of the balancing gain
INPUT_MULTIPLES = (1.15, 1.3, 1.5, 1.8, 2.2, 2.7, 3.5, 5.0)  # of the needed input
FIRST_CHOICE = (5, 4)  # indices of both, where the search begins
SEARCH_STEPS = 7  # of bisection, after a lag is known up to a factor of 1.5
SMALLEST_RAISE = Fraction(101, 100)  # relative, of a lag for which another choice is looked at
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
TASK_FILES = {"quadrotor": ROOT / "docs" / "quadrotor.toml"}
SHIPPED = ("omni_s2", "crawler", "trolley", "rover", "drone", "crane", "base", "attitude", "arm")
TASKS = ("amr", *SHIPPED, "quadrotor")
# Milliseconds by start share 0.9, 0.8, 0.5, at 50 Hz, 100 Hz, 1 kHz and of two equal lags, as a study in doubles found them.
STUDY_LAGS = {
    "amr": ((89, 115, 153), (95, 123, 162), (101, 129, 169), (74, 104, 138)),
    "omni_s2": ((86, 111, 146), (92, 118, 155), (98, 124, 164), (71, 99, 132)),
    "crawler": ((159, 185, 220), (160, 198, 234), (167, 206, 247), (126, 165, 194)),
    "trolley": ((74, 94, 97), (82, 104, 111), (86, 111, 124), (65, 86, 88)),
    "rover": ((66, 90, 122), (71, 96, 131), (75, 103, 140), (56, 85, 112)),
    "drone": ((53, 75, 101), (59, 82, 111), (65, 88, 121), (45, 68, 93)),
    "crane": ((101, 132, 175), (108, 139, 185), (114, 146, 194), (85, 119, 159)),
    "base": ((19, 23, 23), (25, 35, 36), (28, 42, 46), (14, 21, 21)),
    "attitude": ((36, 52, 73), (39, 57, 81), (42, 62, 87), (29, 49, 69)),
    "arm": ((0, 0, 0), (0, 0, 0), (3, 5, 7), (0, 0, 0)),
    "quadrotor": ((42, 56, 74), (48, 63, 83), (54, 69, 92), (35, 51, 68)),
}
STUDY_PERIODS = {  # milliseconds by the sharp conditions and by the path
    "omni_s2": (83, 115), "crawler": (132, 178), "spacecraft": (304, 427), "rover": (64, 104), "trolley": (71, 89),
    "drone": (42, 95),
}  # fmt: skip
DISTURBANCES = {"omni_s2": 0.1}  # w_max of the second table, where the task has none
PERIOD_OF_GAIN = Fraction(1, 50)  # seconds, for which the second table chooses gains
PERIOD_INPUT_MULTIPLE = Fraction(3, 2)
RESTING_ERROR, RESERVE = Fraction(7, 10), Fraction(3, 2)  # of the gentlest gain


@dataclass(frozen=True)
class Robot:
    """A task with its tube, its loops in doubles and for the worst path, the balancing gain, and the needed input."""

    task: Task
    design: RefinedDesign
    doubles: SampledLoop
    loop: PathLoop
    balancing: list[Fraction]
    needed: list[Fraction]

    @property
    def width_over_speed(self) -> float:
        """The least W/P in seconds."""
        with np.errstate(divide="ignore"):
            return float((self.doubles.windows.narrow / self.doubles.closing_speed).min())

    def with_share(self, share: Fraction) -> Robot:
        """Return the robot for other starts."""
        task = self.task.changed(initial_set={"share": share})
        ratios = (
            [(1 + share) / (1 - share)] * task.dimension
            if task.order == 1
            else inertial_start_bound(task, self.design, None, FRACTIONS).tolist()
        )
        laws = [replace(law, rho_at_start=ratio) for law, ratio in zip(self.loop.laws, ratios, strict=True)]
        return replace(self, loop=replace(self.loop, laws=tuple(laws)))

    def parts(self) -> list[tuple[PathLoop, list[Fraction], list[Fraction]]]:
        """Return the loops that have choices of their own, with balancing gains and needed inputs: all or one component."""
        if any(any(window.cross) for windows in self.loop.windows for window in windows):
            return [(self.loop, self.balancing, self.needed)]
        return [(self.loop.component(i), self.balancing[i : i + 1], self.needed[i : i + 1]) for i in range(self.loop.n)]


def robot_of(name: str, w_max: float | None = None) -> Robot:
    """Return a robot by its name, of tasks/ or of this benchmark, or by its file. w_max: a bound on the disturbance, None for
    the task's."""
    path = Path(name) if name.endswith(".toml") else TASK_FILES.get(name, ROOT / "tasks" / f"{name}.toml")
    task = parse_task(WAREHOUSE) if name == "amr" else load_task(path)
    task = task if w_max is None else task.changed(plant={"w_max": w_max})
    design = require_refined(preferred_tube(task))
    task = task.with_gain([Fraction(1, 10)] * task.dimension) if task.has_automatic_gain else task
    errors = edge_and_rate_errors(design, build_program(task, design))
    exact, loop = exact_loop(task, design, *errors), loop_of(task, design, *errors)
    rates = design.filter if task.order == 2 else ()
    path_loop = PathLoop.of(exact, [Drive()] * task.dimension, Fraction(1, 50), rates, design.seam)
    numbers = [[Fraction(v) for v in values.tolist()] for values in (balancing_gain(loop), needed_input(loop))]
    return Robot(task, design, loop, path_loop, *numbers)


class Search:
    """The largest lag of one loop over the grid of gains and limits. lag_count: of equal lags in series, whose sum counts."""

    def __init__(self, loop: PathLoop, balancing: Sequence[Fraction], needed: Sequence[Fraction], lag_count: int) -> None:
        self.loop, self.balancing, self.needed, self.lag_count = loop, balancing, needed, lag_count

    def loop_for(self, choice: tuple[int, int], lag: Fraction) -> PathLoop:
        """Return the loop with a gain and a limit of the grid, one multiple for all components, and with a lag in seconds."""
        gain, limit = Fraction(GAIN_MULTIPLES[choice[0]]), Fraction(INPUT_MULTIPLES[choice[1]])
        laws = [
            replace(law, gain=gain * k, u_max=limit * u)
            for law, k, u in zip(self.loop.laws, self.balancing, self.needed, strict=True)
        ]
        drive = Drive((lag / self.lag_count,) * self.lag_count)
        return replace(self.loop, laws=tuple(laws)).with_drives([drive] * self.loop.n)

    def is_proved(self, choice: tuple[int, int], lag: Fraction) -> bool:
        return prove_path(self.loop_for(choice, lag)) is not None

    def largest_with(self, choice: tuple[int, int], known: Fraction) -> Fraction:
        """Return the largest lag that a choice proves, to a percent; 0 where it is not clearly above a known one."""
        low = known * SMALLEST_RAISE if known else FIRST_LAG
        if not self.is_proved(choice, low):
            return Fraction(0)
        high = low * LAG_FACTOR
        while self.is_proved(choice, high):
            low, high = high, high * LAG_FACTOR
        for _ in range(SEARCH_STEPS):
            middle = (low + high) / 2
            low, high = (middle, high) if self.is_proved(choice, middle) else (low, middle)
        return low

    def run(self, first: tuple[int, int], enough: Fraction | None) -> tuple[Fraction, tuple[int, int]]:
        """Climb from a choice of the grid to the best one around it, or to a lag that is enough. Return lag and choice."""
        best, at, tried = self.largest_with(first, Fraction(0)), first, {first}
        if not best:
            at = next((c for c in GRID if self.is_proved(c, FIRST_LAG)), first)
            best = self.largest_with(at, Fraction(0)) if at != first else best
        pending = _neighbours(at) if best else []
        while pending and (enough is None or best < enough):
            choice = pending.pop(0)
            if choice in tried:
                continue
            tried.add(choice)
            lag = self.largest_with(choice, best)
            if lag:
                best, at, pending = lag, choice, _neighbours(choice)
        return best, at


GRID = [(k, f) for k in range(len(GAIN_MULTIPLES)) for f in range(len(INPUT_MULTIPLES))]


def _neighbours(choice: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the choices beside one on the grid."""
    k, f = choice
    return [(i, j) for i in (k, k - 1, k + 1) for j in (f, f - 1, f + 1) if (i, j) in GRID and (i, j) != choice]


@dataclass(frozen=True)
class LargestLag:
    """The largest lag of a robot in seconds, its multiple of the needed input, and the processor time of a proof in seconds."""

    seconds: Fraction
    input_multiple: float
    proof_time: float


def largest_lag(robot: Robot, rate: int, lag_count: int) -> LargestLag:
    """Return the largest lag, or the sum of two equal ones, that some choice proves; 0 where none is."""
    smallest_lag: Fraction | None = None
    choice, proof_time = FIRST_CHOICE, 0.0
    for loop, balancing, needed in robot.parts():
        search = Search(loop.with_period(Fraction(1, rate)), balancing, needed, lag_count)
        lag, at = search.run(choice, smallest_lag)
        if smallest_lag is None or lag < smallest_lag:
            smallest_lag, choice = lag, at
        if lag:
            begin = time.process_time()
            search.is_proved(at, min(lag, smallest_lag))
            proof_time += time.process_time() - begin
    return LargestLag(smallest_lag or Fraction(0), INPUT_MULTIPLES[choice[1]], proof_time)


def lag_row(name: str, rates: Sequence[int], shares: Sequence[Fraction], w_max: float | None) -> list[str]:
    """Return the first table's row of a robot; without the study's lags for a disturbance of its own."""
    robot = robot_of(name, w_max)
    robots = [robot.with_share(share) for share in shares]
    cells = []
    for rate, lag_count in [*((rate, 1) for rate in rates), (RATES[0], 2)]:
        lags = [largest_lag(r, rate, lag_count) for r in robots]
        column = (*RATES, None).index(rate if lag_count == 1 else None) if rate in RATES else None
        is_in_study = column is not None and name in STUDY_LAGS and w_max is None
        study = [STUDY_LAGS[name][column][SHARES.index(s)] for s in shares if s in SHARES] if is_in_study else []
        cells.append(_cell([f"{float(v.seconds) * 1e3:.0f}" for v in lags], study))
        if (rate, lag_count) == (rates[0], 1):
            multiples = " / ".join(f"{v.input_multiple:g}" if v.seconds else "-" for v in lags)
            proof_time = f"{max(v.proof_time for v in lags) * 1e3:.1f}"
    return [name, f"{robot.width_over_speed:.2f}", *cells, multiples, proof_time]


def _cell(values: Sequence[str], study: Sequence[int]) -> str:
    """Return values by start share, with those of the study in brackets."""
    return " / ".join(values) + (f" ({' / '.join(map(str, study))})" if study else "")


def period_row(name: str) -> list[str]:
    """Return the second table's row of a robot: the longest periods by the sharp conditions and by the path, in milliseconds."""
    robot, (by_conditions, by_path) = robot_of(name, DISTURBANCES.get(name)), STUDY_PERIODS[name]
    limits, study = [PERIOD_INPUT_MULTIPLE * u for u in robot.needed], f"{by_conditions} -> {by_path}"
    laws = tuple(replace(law, u_max=u) for law, u in zip(robot.loop.laws, limits, strict=True))
    loop = replace(robot.loop, laws=laws)
    disturbance = [bounds.force for bounds in robot.task.plant_bounds]
    choice = choose_path_gain(loop.with_period(PERIOD_OF_GAIN), disturbance, RESTING_ERROR, RESERVE)
    if choice is None:
        return [name, "-", "-", "-", study]
    longest = longest_path_period(with_gain(loop, choice.gain), PERIOD_OF_GAIN)
    law = {"gain": np.array([float(k) for k in choice.gain]), "u_max": np.array([float(u) for u in limits])}
    with np.errstate(all="ignore"):
        period = longest_proved_period("sharp", robot.doubles.with_law(**law))
    seconds = [period.seconds - float(loop.latency) if period else 0.0, float(longest or 0)]
    gains = ", ".join(f"{float(k):.3g}" for k in choice.gain)
    return [name, gains, *(f"{v * 1e3:.0f}" for v in seconds), study]


def main() -> int:
    """Print the tables. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rate", type=int, action="append")
    parser.add_argument("--share", type=Fraction, action="append")
    parser.add_argument("--task", action="append", help=f"a task's file, or one of {', '.join(sorted({*TASKS, *STUDY_PERIODS}))}")
    parser.add_argument("--w-max", type=float, help="the disturbance in the first table, where a task's own is not meant")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    rates, shares, names = options.rate or RATES, options.share or SHARES, options.task or [*TASKS, *STUDY_PERIODS]
    period_rows = _printed(period_row, [name for name in dict.fromkeys(names) if name in STUDY_PERIODS])
    lag_rows = _printed(
        lambda name: lag_row(name, rates, shares, options.w_max),
        [name for name in dict.fromkeys(names) if name in TASKS or name.endswith(".toml")],
    )
    columns = [*(f"{rate} Hz" for rate in rates), "two equal lags, sum, 50 Hz", "u_max/need", "ms of a proof"]
    shown = " / ".join(f"{float(v):g}" for v in shares)
    text = "\n\n".join(
        [
            f"The largest lag in ms that is proved, from start shares of {shown}; in brackets what a study in doubles found.",
            table(["robot", "W/P, s", *columns], lag_rows),
            "The longest period in ms without a lag, from the task's share.",
            table(["robot", "gain", "sharp conditions", "path", "study in doubles"], period_rows),
        ]
    )
    print(text)
    if options.record:
        record(options.record, "lag-table", f"## Drives that lag\n\n`{command()}`\n\n{text}")
    return 0


def _printed(row_of: Callable[[str], list[str]], names: Sequence[str]) -> list[list[str]]:
    """Return the rows, and print each as soon as it is known."""
    rows = []
    for name in names:
        rows.append(row_of(name))
        print(" | ".join(rows[-1]), flush=True)
    return rows


if __name__ == "__main__":
    sys.exit(main())
