"""Arenas whose unsafe sets move: how many tubes are certified of those that leave a way, how fast, how wide, and closed loops.

    python -m benchmarks moving [--count 200] [--loops 2000] [--record FILE.md]

- four: unit squares in [0, 5]^2, up to 0.5 units/s, 9 s.
- twenty: boxes and balls of 0.7 in [0, 5]^3, up to 0.4 units/s, 20 s.
- crossing: discs in a corridor of a differential drive (arXiv 2512.05495, "dynamic obstacle"): two move, two stand, 5 s.
- five: five moving discs, 16 s (arXiv 2512.06151), and discs10, discs30, discs100: random discs in the same room, up to 1 unit/s.
  The tubes of that paper know no motion beforehand and react online; ours is told the motion and plans with it.

A way: cells of 0.05 in space, 200 steps of time, one cell a step; the middle keeps 0.1 (twenty: 0.13) from every set, by
component. For crossing, five and discs a way is not computed: all count that do not meet the start at t = 0.
Exit code 1 when an arena of four with a way has no tube, or a loop meets a set or leaves its tube.
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
from stt_codegen.pipeline import EmittedController, build_program, build_task, certify, design_tube
from stt_codegen.task.task import Task

Array = npt.NDArray[np.float64]
CELL, STEPS = 0.05, 200
SIDE, BOX = 5.0, 0.5
DOUBT = 0.1  # s, by which the sets of the loops may be early, late, and the start late
DISCS = (
    (4, 3, 0.5, -0.4, -0.2),
    (5, 6, 0.5, -0.4, -0.2),
    (6, 4, 0.5, 0.2, -0.4),
    (3, 6, 0.5, -0.2, 0.4),
    (4.5, 9, 0.5, -0.2, 0.0),
)


NOTES = (
    "four, twenty: a way means cells of 0.05 and 200 steps keep 0.1 and 0.13. Of discs: all that do not meet the start at 0.",
    "Whose discs these are (arXiv 2512.06151) reacts online and knows no motion beforehand: it arrives in 99, 92 and 19 of 100",
    "(own port). Ours is told the motion.",
)


@dataclass(frozen=True)
class Movers:
    """Sets as boxes: lower corners (J, n) at t = 0, velocities (J, n), size; round: which are balls in these boxes."""

    low: Array
    velocity: Array
    size: float
    end: float
    round: Array

    def table(self, j: int) -> dict[str, Any]:
        low, by = self.low[j], self.velocity[j] * self.end
        n, half = len(low), self.size / 2
        motion = [{"at": 0, "by": [0] * n}, {"at": self.end, "by": _short(by)}]
        if self.round[j]:
            return {"centre": _short(low + half), "radius": half, "motion": motion}
        return {"lower": _short(low), "upper": _short(_rounded(low) + self.size), "motion": motion}


def _rounded(values: Array) -> Array:
    return np.round(values, 6)


def _short(values: Array) -> list[float]:
    return [round(float(v), 6) for v in values]


def movers(seed: int, n: int, count: int, fastest: float, size: float, end: float, mixed: bool) -> Movers:
    """Random sets that are off the start at 0 and off the target at the end."""
    draw = np.random.default_rng(seed)
    while True:
        low = draw.uniform(0, SIDE - size, (count, n))
        velocity = draw.uniform(-fastest, fastest, (count, n))
        there = low + velocity * end
        near = 0.1  # room that is left
        first = (low < BOX + near).all(axis=1).any()
        last = ((there + size > SIDE - BOX - near) & (there < SIDE + near)).all(axis=1).any()
        if not first and not last:
            return Movers(low, velocity, size, end, np.arange(count) % 2 * mixed)


def task_of(movers: Movers, timing: float | None = None, **more: Any) -> Task:
    n, doubt = movers.low.shape[1], {} if timing is None else {"timing": timing}
    return Task(
        name="movers",
        prescribed_time=movers.end,
        initial_state=[BOX / 2] * n,
        state_space={"lower": [0] * n, "upper": [SIDE] * n},
        initial_set={"lower": [0] * n, "upper": [BOX] * n},
        target_set={"lower": [SIDE - BOX] * n, "upper": [SIDE] * n},
        unsafe=[{**movers.table(j), **doubt} for j in range(len(movers.low))],
        **more,
    )


def leaves_a_way(movers: Movers, reach: float) -> bool:
    """Cells and steps, each free where its middle keeps `reach` from every set at both ends of the step before it."""
    n, count = movers.low.shape[1], round(SIDE / CELL)
    middle = (np.arange(count) + 0.5) * CELL
    alive: npt.NDArray[np.bool_] = np.zeros((count,) * n, dtype=bool)
    alive[(int(BOX / 2 / CELL),) * n] = True
    for k in range(STEPS + 1):
        if k:
            for axis in range(n):
                wide = alive.copy()
                ahead, behind = ([slice(None)] * n for _ in range(2))
                ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
                wide[tuple(ahead)] |= alive[tuple(behind)]
                wide[tuple(behind)] |= alive[tuple(ahead)]
                alive = wide
        for at in {max(k - 1, 0), k}:
            low = movers.low + movers.velocity * (movers.end * at / STEPS)
            for j in range(len(low)):
                if movers.round[j]:
                    centre, gaps = low[j] + movers.size / 2, 0.0
                    for i in range(n):
                        gap = np.maximum(np.abs(middle - centre[i]) - reach, 0) ** 2
                        gaps = gaps + gap.reshape([-1 if q == i else 1 for q in range(n)])
                    alive &= np.asarray(gaps) >= (movers.size / 2) ** 2
                else:
                    spans = [np.searchsorted(middle, (v - reach, v + movers.size + reach)) for v in low[j]]
                    alive[tuple(slice(int(a), int(b)) for a, b in spans)] = False
        alive &= _inside(middle, reach, n)
    goal = (middle > SIDE - BOX + reach) & (middle < SIDE - reach)
    wanted = np.ones((count,) * n, dtype=bool)
    for i in range(n):
        wanted &= goal.reshape([-1 if q == i else 1 for q in range(n)])
    return bool((alive & wanted).any())


def _inside(middle: Array, reach: float, n: int) -> Any:
    free: Any = True
    for i in range(n):
        free = free & ((middle > reach) & (middle < SIDE - reach)).reshape([-1 if q == i else 1 for q in range(n)])
    return free


def crossing() -> Task:
    """A differential drive among four discs, two of which move."""
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


def room(discs: Any) -> Task:
    """Discs (x, y, radius, velocity) in the room of the five."""
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
                "motion": [{"at": 0, "by": [0, 0]}, {"at": 16, "by": _short(16 * np.array([vx, vy]))}],
            }
            for x, y, r, vx, vy in discs
        ],
    )


def random_discs(seed: int, count: int) -> list[list[float]]:
    draw = np.random.default_rng(seed)
    return [
        [*_short(draw.uniform(1, 8, 2)), round(draw.uniform(0.1, 0.4), 6), *_short(draw.uniform(-1, 1, 2))] for _ in range(count)
    ]


@dataclass(frozen=True)
class Result:
    """What came of one arena; seconds of processor time for design and certificate."""

    way: bool
    controller: EmittedController | None
    seconds: float
    reason: str = ""


def run(task: Task, way: bool) -> Result:
    begin = time.process_time()
    try:
        design = design_tube(task)
        certificate = certify(task, design, build_program(task, design))
    except NotCertified as error:
        return Result(way, None, time.process_time() - begin, str(error))
    took = time.process_time() - begin
    return (
        Result(way, build_task(task, tube=design), took) if certificate.holds else Result(way, None, took, certificate.refusal())
    )


def row(name: str, results: list[Result]) -> str:
    good = [r for r in results if r.controller is not None]
    ways, took = [r for r in results if r.way], 1e3 * np.array([r.seconds for r in results])
    width = (
        np.array([float(r.controller.certificate.minimum_width) for r in good if r.controller]) if good else np.array([np.nan])
    )
    speed = np.array([float(max(r.controller.certificate.speed)) for r in good if r.controller]) if good else np.array([np.nan])
    counted = f"{sum(r.controller is not None for r in ways)} of {len(ways)}", f"{len(good)} of {len(results)}"
    times = f"{np.median(took):.0f} / {np.percentile(took, 95):.0f}"
    widths = f"{np.median(width):.3g} / {width.min():.3g}"
    return f"| {name} | {counted[0]} | {counted[1]} | {times} | {widths} | {np.median(speed):.3g} |"


def loops(tubes: list[EmittedController], count: int) -> tuple[str, bool]:
    """Closed loops whose clock is off, pushed about: how many, what came of them, and whether no set was met and no tube left."""
    from stt_codegen.loop.simulate import KINDS, Loop, Scenario, starts
    from stt_codegen.plants import PLANTS
    from stt_codegen.report.analysis import Analysis

    loops_of_tubes = [(Loop(controller, PLANTS["integrator"]), Analysis(controller).period, controller) for controller in tubes]
    hit = left = run_count = 0
    for k, (loop, period, controller) in enumerate(itertools.islice(itertools.cycle(loops_of_tubes), count)):
        kind, clock = KINDS[1 + k % (len(KINDS) - 1)], ("late", "early", "worst")[k % 3]
        rate = 1000.0 if period is None else max(1.0 / period.seconds, 100.0)
        start = starts(controller.certificate.start, 0.9, k)
        run_ = loop.run(
            Scenario(rate=rate, disturbance=kind, strength=0.0 if period is None else 0.05, seed=k, start=start, clock=clock)
        )
        hit, left, run_count = hit + (run_.hit is not None), left + (not run_.kept), run_count + 1
    clocks = "clocks late, early and worst in turn"
    return f"{run_count} closed loops in {len(tubes)} tubes, {clocks}: {hit} collisions, {left} tubes left", not hit and not left


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200, help="arenas of four; a third as many of twenty, half as many of discs")
    parser.add_argument("--loops", type=int, default=2000)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    build_task(task_of(movers(0, 2, 4, 0.5, 1.0, 9.0, False)))  # imports and compilers are warm
    lines = [
        "| arenas | certified, of those with a way | of all | ms, median / 95 % | least width, median / least | speed |",
        "|---|---|---|---|---|---|",
    ]
    four = [movers(s, 2, 4, 0.5, 1.0, 9.0, False) for s in range(options.count)]
    results = {"four": [run(task_of(f), leaves_a_way(f, 0.1)) for f in four]}
    twenty = [movers(s, 3, 20, 0.4, 0.7, 20.0, True) for s in range(max(1, options.count // 7))]
    results["twenty"] = [run(task_of(f), leaves_a_way(f, 0.13)) for f in twenty]
    results["crossing"] = [run(crossing(), True)]
    results["five"] = [run(room(DISCS), True)]
    for count in (10, 30, 100):
        outcomes = []
        for s in range(max(1, options.count // 2)):
            try:
                outcomes.append(run(room(random_discs(s, count)), True))
            except BadInput as error:  # a disc at the start, or over the target
                outcomes.append(Result(False, None, 0.0, str(error)))
        results[f"discs{count}"] = outcomes
    lines += [row(name, outcomes) for name, outcomes in results.items()]
    missed = [
        (name, k, r.reason)
        for name, outcomes in results.items()
        for k, r in enumerate(outcomes)
        if r.way and r.controller is None
    ]
    lines += ["", *(f"{name} {k}: {reason}" for name, k, reason in missed)]
    delayed = []
    for f in four[: max(1, options.loops // 100)]:
        controller = run(task_of(f, timing=DOUBT, start_delay=DOUBT), True).controller
        delayed += [] if controller is None else [controller]
    summary, kept = loops(delayed, options.loops)
    lines += ["", summary]
    lines += ["", *NOTES]
    text = "\n".join(lines)
    print(text)
    if options.record:
        record(options.record, "moving", f"## Sets that move\n\nMade by `{command()}`; {machine()}.\n\n{text}")
    return 0 if kept and not any(name == "four" for name, _, _ in missed) else 1


if __name__ == "__main__":
    sys.exit(main())
