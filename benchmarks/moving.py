"""Design tubes among unsafe sets that move: how many are certified, how fast, how wide; and run closed loops in them.

    python -m benchmarks moving [--count 200] [--loops 2000] [--record FILE.md]

- four: unit squares in [0, 5]^2, up to 0.5 units/s, 9 s.
- twenty: boxes and balls of 0.7 in [0, 5]^3, up to 0.4 units/s, 20 s.
- crossing: discs in a corridor of a differential drive (arXiv 2512.05495, "dynamic obstacle"): two move, two stand, 5 s.
- five: five moving discs, 16 s (arXiv 2512.06151), and discs10, discs30, discs100: random discs in the same room, up to 1 unit/s.
  The tubes of that paper react online to motions that they do not know; ours knows the motion and plans with it.

An arena of four or twenty has a way if a grid has one: cells of 0.05 in space, 200 steps of time, one cell a step. The middle of
a cell keeps 0.1 (twenty: 0.13) from every set, by component. Of crossing, five and discs all arenas count whose sets do not meet
the start at t = 0. The exit code is 1 when an arena of four with a way has no tube, or a loop meets a set or leaves its tube.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.report import command, machine, record
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_program, build_task, certify, preferred_tube
from stt_codegen.task.task import Task

Array = npt.NDArray[np.float64]
Cells = npt.NDArray[np.bool_]  # a flag for each cell, one axis for each of space
CELL, STEPS = 0.05, 200  # of the grid on which a way is searched: its cells in space, its steps from 0 to the end
SIDE, BOX = 5.0, 0.5  # of the state space, of start and target
KEPT_DISTANCE = 0.1  # of the drawn sets from start (at 0) and target (at the end)
TIMING_UNCERTAINTY = 0.1  # s, of the sets of the closed loops and of the start
FIVE_DISCS = (  # x, y, radius, velocity
    (4, 3, 0.5, -0.4, -0.2),
    (5, 6, 0.5, -0.4, -0.2),
    (6, 4, 0.5, 0.2, -0.4),
    (3, 6, 0.5, -0.2, 0.4),
    (4.5, 9, 0.5, -0.2, 0.0),
)


NOTES = (
    "four, twenty: a way has cells of 0.05 and 200 steps, and keeps 0.1 and 0.13. Of discs: all that do not meet the start.",
    "The authors of the discs (arXiv 2512.06151) react online and know no motion beforehand: they arrive in 99, 92 and 19 of 100",
    "(own port). Ours knows the motion.",
)


@dataclass(frozen=True)
class ArenaKind:
    """Arenas with `count` boxes in [0, SIDE]^dimension, and how they are drawn.

    fastest: of a velocity, by component. size: of a box. end: the prescribed time, s. has_balls: whether every second box is
    replaced by the ball in it.
    """

    dimension: int
    count: int
    fastest: float
    size: float
    end: float
    has_balls: bool = False


FOUR = ArenaKind(dimension=2, count=4, fastest=0.5, size=1.0, end=9.0)
TWENTY = ArenaKind(dimension=3, count=20, fastest=0.4, size=0.7, end=20.0, has_balls=True)


@dataclass(frozen=True)
class MovingSets:
    """Boxes: lower corners (J, n) at t = 0, velocities (J, n), size. is_ball: (J,), whether a ball in the box replaces it."""

    low: Array
    velocity: Array
    size: float
    end: float
    is_ball: Array

    @property
    def dimension(self) -> int:
        return self.low.shape[1]

    def table(self, j: int) -> dict[str, Any]:
        """Return set j as a table of a task file."""
        low, displacement = self.low[j], self.velocity[j] * self.end
        half = self.size / 2
        motion = [{"at": 0, "by": [0] * len(low)}, {"at": self.end, "by": _rounded_list(displacement)}]
        if self.is_ball[j]:
            return {"centre": _rounded_list(low + half), "radius": half, "motion": motion}
        return {"lower": _rounded_list(low), "upper": _rounded_list(_rounded(low) + self.size), "motion": motion}


def _rounded(values: Array) -> Array:
    return np.round(values, 6)


def _rounded_list(values: Array) -> list[float]:
    return [round(float(v), 6) for v in values]


def draw_moving_sets(kind: ArenaKind, seed: int) -> MovingSets:
    """Draw sets that avoid the start at t = 0 and the target at the end."""
    rng = np.random.default_rng(seed)
    while True:
        low = rng.uniform(0, SIDE - kind.size, (kind.count, kind.dimension))
        velocity = rng.uniform(-kind.fastest, kind.fastest, (kind.count, kind.dimension))
        low_at_end = low + velocity * kind.end
        meets_start = (low < BOX + KEPT_DISTANCE).all(axis=1).any()
        is_near_target = (low_at_end + kind.size > SIDE - BOX - KEPT_DISTANCE) & (low_at_end < SIDE + KEPT_DISTANCE)
        if not meets_start and not is_near_target.all(axis=1).any():
            return MovingSets(low, velocity, kind.size, kind.end, np.arange(kind.count) % 2 * kind.has_balls)


def task_of(sets: MovingSets, timing: float | None = None, **options: Any) -> Task:
    """Return the task of an arena. timing: uncertainty of the sets' clocks, seconds. options: further keys of a task."""
    n, timing_keys = sets.dimension, {} if timing is None else {"timing": timing}
    return Task(
        name="movers",
        prescribed_time=sets.end,
        initial_state=[BOX / 2] * n,
        state_space={"lower": [0] * n, "upper": [SIDE] * n},
        initial_set={"lower": [0] * n, "upper": [BOX] * n},
        target_set={"lower": [SIDE - BOX] * n, "upper": [SIDE] * n},
        unsafe=[{**sets.table(j), **timing_keys} for j in range(len(sets.low))],
        **options,
    )


def has_way(sets: MovingSets, clearance: float) -> bool:
    """Return whether a path through cells leads from start to target, with at most one cell per step.

    The middle of a cell keeps `clearance` from every set, by component, at both ends of the step before it.
    """
    n, count = sets.dimension, round(SIDE / CELL)
    middles = (np.arange(count) + 0.5) * CELL
    reached: Cells = np.zeros((count,) * n, dtype=bool)
    reached[(int(BOX / 2 / CELL),) * n] = True
    for k in range(STEPS + 1):
        if k:
            reached = with_neighbours(reached)
        for end_of_step in {max(k - 1, 0), k}:
            remove_covered_cells(reached, sets, end_of_step / STEPS, clearance, middles)
        reached &= box_of_cells((middles > clearance) & (middles < SIDE - clearance), n)
    return bool((reached & box_of_cells((middles > SIDE - BOX + clearance) & (middles < SIDE - clearance), n)).any())


def with_neighbours(cells: Cells) -> Cells:
    """Return the cells with all that differ from one of them by at most 1 on each axis."""
    for axis in range(cells.ndim):
        widened = cells.copy()
        ahead, behind = ([slice(None)] * cells.ndim for _ in range(2))
        ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
        widened[tuple(ahead)] |= cells[tuple(behind)]
        widened[tuple(behind)] |= cells[tuple(ahead)]
        cells = widened
    return cells


def remove_covered_cells(cells: Cells, sets: MovingSets, share: float, clearance: float, middles: Array) -> None:
    """Remove the cells nearer than `clearance` to a set, at a share of the prescribed time. middles: of cells on one axis."""
    n, low = sets.dimension, sets.low + sets.velocity * (sets.end * share)
    for j in range(len(low)):
        if sets.is_ball[j]:
            centre, squared_distance = low[j] + sets.size / 2, 0.0
            for i in range(n):
                squared_gap = np.maximum(np.abs(middles - centre[i]) - clearance, 0) ** 2
                squared_distance = squared_distance + along_axis(squared_gap, i, n)
            cells &= np.asarray(squared_distance) >= (sets.size / 2) ** 2
        else:
            spans = [np.searchsorted(middles, (v - clearance, v + sets.size + clearance)) for v in low[j]]
            cells[tuple(slice(int(a), int(b)) for a, b in spans)] = False


def along_axis(values: Any, axis: int, n: int) -> Any:
    """Return the values shaped to be broadcast along one of n axes."""
    return values.reshape([-1 if i == axis else 1 for i in range(n)])


def box_of_cells(is_on_axis: Any, n: int) -> Cells:
    """Return the cells whose index is allowed on each axis. is_on_axis: allowed indices, the same for all axes."""
    return np.logical_and.reduce(np.broadcast_arrays(*(along_axis(is_on_axis, i, n) for i in range(n))))


def crossing_task() -> Task:
    """Return the task of a differential drive among four discs, two of which move."""
    rise = 0.2
    return Task(
        name="crossing",
        prescribed_time=5,
        initial_state=[0.35, 0.35],
        state_space={"lower": [0, 0], "upper": [3, 3]},
        initial_set={"lower": [0.21, 0.21], "upper": [0.49, 0.49]},
        target_set={"centre": [2.65, 2.65], "radius": 0.2},
        unsafe=[
            {
                "name": "A",
                "centre": [0.95, 0.35],
                "radius": 0.25,
                "motion": [{"at": 0, "by": [0, 0]}, {"at": 5, "by": [0, 5 * rise]}],
            },
            {
                "name": "B",
                "centre": [1.65, 2.65],
                "radius": 0.25,
                "motion": [{"at": 0, "by": [0, 0]}, {"at": 5, "by": [0, -1.3]}],
            },
            {"name": "C", "centre": [0.95, 0.35], "radius": 0.25},
            {"name": "D", "centre": [1.35, 2.65], "radius": 0.25},
        ],
    )


def room_task(discs: Any) -> Task:
    """Return the task of discs (x, y, radius, velocity), in the room of the five discs."""
    return Task(
        name="room",
        prescribed_time=16,
        initial_state=[0.5, 1.5],
        state_space={"lower": [-1, -1], "upper": [9, 12]},
        initial_set={"lower": [0.3, 1.3], "upper": [0.7, 1.7]},
        target_set={"centre": [7, 10], "radius": 1},
        unsafe=[
            {
                "centre": [x, y],
                "radius": r,
                "motion": [{"at": 0, "by": [0, 0]}, {"at": 16, "by": _rounded_list(16 * np.array([vx, vy]))}],
            }
            for x, y, r, vx, vy in discs
        ],
    )


def random_discs(seed: int, count: int) -> list[list[float]]:
    """Draw discs as (x, y, radius, velocity)."""
    rng = np.random.default_rng(seed)
    return [
        [*_rounded_list(rng.uniform(1, 8, 2)), round(rng.uniform(0.1, 0.4), 6), *_rounded_list(rng.uniform(-1, 1, 2))]
        for _ in range(count)
    ]


@dataclass(frozen=True)
class DesignResult:
    """The result of one arena. leaves_way: whether it has to have a tube. seconds: of the processor, to design and certify."""

    leaves_way: bool
    controller: EmittedController | None
    seconds: float
    reason: str = ""


def design_result(task: Task, leaves_way: bool) -> DesignResult:
    """Design and certify an arena's tube."""
    begin = time.process_time()
    try:
        design = preferred_tube(task)
        certificate = certify(task, design, build_program(task, design))
    except NotCertified as error:
        return DesignResult(leaves_way, None, time.process_time() - begin, str(error))
    seconds = time.process_time() - begin
    if not certificate.holds:
        return DesignResult(leaves_way, None, seconds, certificate.refusal())
    return DesignResult(leaves_way, build_task(task, tube=design), seconds)


def table_row(name: str, results: list[DesignResult]) -> str:
    """Return the table's row of one kind of arenas."""
    certificates = [r.controller.certificate for r in results if r.controller is not None]
    with_way, milliseconds = [r for r in results if r.leaves_way], 1e3 * np.array([r.seconds for r in results])
    width = np.array([float(c.minimum_width) for c in certificates] or [np.nan])
    speed = np.array([float(max(c.speed)) for c in certificates] or [np.nan])
    certified_with_way = f"{sum(r.controller is not None for r in with_way)} of {len(with_way)}"
    times = f"{np.median(milliseconds):.0f} / {np.percentile(milliseconds, 95):.0f}"
    widths = f"{np.median(width):.3g} / {width.min():.3g}"
    certified = f"{len(certificates)} of {len(results)}"
    return f"| {name} | {certified_with_way} | {certified} | {times} | {widths} | {np.median(speed):.3g} |"


def run_loops(tubes: list[EmittedController], count: int) -> tuple[str, bool]:
    """Simulate closed loops with disturbances and wrong clocks. Return a summary, and whether all stayed in their tubes."""
    from stt_codegen.loop.simulate import DISTURBANCES, Loop, Scenario, random_start
    from stt_codegen.plants import PLANTS
    from stt_codegen.report.analysis import Analysis

    loops_of_tubes = [(Loop(controller, PLANTS["integrator"]), Analysis(controller).period, controller) for controller in tubes]
    collisions = exits = run_count = 0
    for k, (loop, period, controller) in enumerate(itertools.islice(itertools.cycle(loops_of_tubes), count)):
        kind, clock = DISTURBANCES[1 + k % (len(DISTURBANCES) - 1)], ("late", "early", "worst")[k % 3]
        rate = 1000.0 if period is None else max(1.0 / period.seconds, 100.0)
        start = random_start(controller.certificate.start, 0.9, k)
        run = loop.run(
            Scenario(rate=rate, disturbance=kind, strength=0.0 if period is None else 0.05, seed=k, start=start, clock=clock)
        )
        collisions, exits, run_count = collisions + (run.hit is not None), exits + (not run.kept), run_count + 1
    clocks = "clocks late, early and worst in turn"
    summary = f"{run_count} closed loops in {len(tubes)} tubes, {clocks}: {collisions} collisions, {exits} tubes left"
    return summary, not collisions and not exits


def all_results(count: int) -> dict[str, list[DesignResult]]:
    """Return the results of all arenas, by the name of their kind. count: of the arenas of four."""
    four = [draw_moving_sets(FOUR, s) for s in range(count)]
    twenty = [draw_moving_sets(TWENTY, s) for s in range(max(1, count // 7))]
    results = {
        "four": [design_result(task_of(sets), has_way(sets, 0.1)) for sets in four],
        "twenty": [design_result(task_of(sets), has_way(sets, 0.13)) for sets in twenty],
        "crossing": [design_result(crossing_task(), True)],
        "five": [design_result(room_task(FIVE_DISCS), True)],
    }
    for disc_count in (10, 30, 100):
        disc_results = []
        for s in range(max(1, count // 2)):
            try:
                disc_results.append(design_result(room_task(random_discs(s, disc_count)), True))
            except BadInput as error:  # a disc at the start, or over the target
                disc_results.append(DesignResult(False, None, 0.0, str(error)))
        results[f"discs{disc_count}"] = disc_results
    return results


def main() -> int:
    """Design all arenas, run closed loops, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--count", type=int, default=200, help="arenas of four; a seventh as many of twenty, half as many of discs"
    )
    parser.add_argument("--loops", type=int, default=2000)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    build_task(task_of(draw_moving_sets(FOUR, 0)))  # so that imports do not count as design time
    results = all_results(options.count)
    lines = [
        "| arenas | certified, of those with a way | of all | ms, median / 95 % | least width, median / least | speed |",
        "|---|---|---|---|---|---|",
    ]
    lines += [table_row(name, kind_results) for name, kind_results in results.items()]
    missed = [
        (name, k, r.reason)
        for name, kind_results in results.items()
        for k, r in enumerate(kind_results)
        if r.leaves_way and r.controller is None
    ]
    lines += ["", *(f"{name} {k}: {reason}" for name, k, reason in missed)]
    controllers = []
    for seed in range(min(options.count, max(1, options.loops // 100))):
        task = task_of(draw_moving_sets(FOUR, seed), timing=TIMING_UNCERTAINTY, start_delay=TIMING_UNCERTAINTY)
        controller = design_result(task, True).controller
        controllers += [] if controller is None else [controller]
    summary, all_stayed = run_loops(controllers, options.loops)
    lines += ["", summary, "", *NOTES]
    text = "\n".join(lines)
    print(text)
    if options.record:
        record(options.record, "moving", f"## Sets that move\n\nMade by `{command()}`; {machine()}.\n\n{text}")
    return 0 if all_stayed and not any(name == "four" for name, _, _ in missed) else 1


if __name__ == "__main__":
    sys.exit(main())
