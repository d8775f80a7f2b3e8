"""Measure tubes for plants of order 2: how many are certified, how fast, the inputs they need, proved periods, closed loops.

    python -m benchmarks inertia [--count 100] [--loops 2000] [--board m4f] [--record FILE.md]

- paper: the arenas of four unit squares, |w| <= 0.3.
- least u_max: the smallest u_max, the same for all components, with a tube and proved limits (P8); over |w| plus 4 length/t_c^2,
  the acceleration of a point on the shortest route from rest to rest.
- periods: omni_s2 and spacecraft as double integrators, |w| <= 0.3, without u_max and with 1.1, 1.3 and 2 times the largest
  closing speed; the longest period over all gains that is proved for every start at rest with |e(0)| <= 0.9.
- loops: at that period and at 1 kHz, corner and random starts, each disturbance in turn, the weakest and strongest plants.

The exit code is 1 when an arena has a tube of order 1 but none of order 2, or a loop leaves its tube or meets a set.
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

from benchmarks.suites.families import FAMILIES, arena_task
from benchmarks.suites.report import command, machine, record
from stt_codegen.design.arena import arena_of, normalise, starting_box
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.routes.shortest_route import shortest_route
from stt_codegen.errors import MissingTool, NotCertified
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import DISTURBANCES, Loop, Scenario, random_start
from stt_codegen.pipeline import EmittedController, build_program, build_task, certify, preferred_tube
from stt_codegen.report.analysis import Analysis
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task

ROOT = Path(__file__).resolve().parent.parent
DISTURBANCE_BOUND = "0.3"
PERIOD_FACTORS = (1, 1.5, 2, 3, 4, 6)  # times the proved period


@dataclass(frozen=True)
class InertiaResult:
    """The result of one arena. seconds: of the processor, for design and certificate. reason: why there is no controller."""

    controller: EmittedController | None
    seconds: float
    reason: str = ""


def design_arena(seed: int) -> InertiaResult:
    """Design and certify a tube of order 2 in one of the paper's arenas."""
    task = arena_task(FAMILIES["paper"], seed).changed(plant={"order": 2, "w_max": DISTURBANCE_BOUND})
    begin = time.process_time()
    try:
        design = preferred_tube(task)
        certificate = certify(task, design, build_program(task, design))
    except NotCertified as error:
        return InertiaResult(None, time.process_time() - begin, str(error))
    seconds = time.process_time() - begin
    if not certificate.holds:
        return InertiaResult(None, seconds, certificate.refusal())
    return InertiaResult(build_task(task, tube=design), seconds)


def smallest_acceleration(task: Task) -> float:
    """Return 4 length/t_c^2 of the shortest route for the smallest width, in the largest component."""
    lattice = lattice_of(task)
    normalised_arena = normalise(arena_of(task, lattice), lattice.exponent)
    route = shortest_route(normalised_arena, starting_box(normalised_arena), normalised_arena.min_widths)
    return float(4 * route.length * normalised_arena.length_unit / normalised_arena.time_unit**2)


def smallest_limit_row(name: str) -> str:
    """Return the table's row about the smallest u_max of a task, which is searched by bisection to 2 %."""
    task, low, high = order_two_task(name), float(DISTURBANCE_BOUND), 8.0
    bound = float(DISTURBANCE_BOUND) + smallest_acceleration(task)
    while high / low > 1.02:
        middle = (low * high) ** 0.5
        try:
            is_certified = build_task(task.changed(control={"u_max": f"{middle:.6g}"})).certificate.holds
        except NotCertified:
            is_certified = False
        low, high = (low, middle) if is_certified else (middle, high)
    return f"| {name} | {high:.3g} | {bound:.3g} | {high / bound:.2f} |"


def is_certified_at_order_one(seed: int) -> bool:
    try:
        return build_task(arena_task(FAMILIES["paper"], seed)).certificate.holds
    except NotCertified:
        return False


def order_two_task(name: str) -> Task:
    return load_task(ROOT / "tasks" / f"{name}.toml").changed(plant={"order": 2, "w_max": DISTURBANCE_BOUND})


def period_rows(name: str) -> tuple[list[str], list[EmittedController]]:
    """Return the rows about proved periods under several limits of u, and the controllers with them."""
    unlimited = build_task(order_two_task(name))
    closing_speed = Analysis(unlimited).sampled_loop.closing_speed.max(axis=0)
    rows, controllers = [], []
    for factor in (1.1, 1.3, 2.0, None):
        control: dict[str, Any] = {} if factor is None else {"u_max": [f"{v * factor:.4g}" for v in closing_speed]}
        controller = build_task(unlimited.task.changed(control=control), tube=unlimited.design)
        best = Analysis(controller).gains.with_longest_period
        if best is None:
            rows.append(f"| {name} | {factor or 'none'} | none | | |")
            continue
        gain = [f"{v:.6g}" for v in best.gain.tolist()]
        controller = build_task(controller.task.changed(control={**control, "gain": gain}), tube=unlimited.design)
        controllers.append(controller)
        u = ", ".join(f"{v:.3g}" for v in best[1].u)
        left = failure_percentages(controller, best[1].seconds)
        rows.append(f"| {name} | {factor or 'none'} | {best[1].seconds * 1e3:.3g} | {u} | {left} |")
    return rows, controllers


def failure_percentages(controller: EmittedController, seconds: float) -> str:
    """Return the percentages of loops that leave their tubes at PERIOD_FACTORS times the period, as text."""
    percentages = []
    for factor in PERIOD_FACTORS:
        runs = [
            loop.run(
                Scenario(
                    rate=1 / (factor * seconds),
                    disturbance=DISTURBANCES[1 + k % 5],
                    strength=float(DISTURBANCE_BOUND),
                    seed=k,
                    start=random_start(controller.certificate.start, 0.9, k, k % 2 == 0),
                )
            )
            for loop in (Loop(controller, model) for model in corner_plants(controller.task))
            for k in range(10)
        ]
        percentages.append(f"{100 * sum(not r.kept for r in runs) / len(runs):.0f}")
    return ", ".join(percentages)


def run_loops(tubes: list[EmittedController], count: int) -> tuple[str, bool]:
    """Run loops at the proved period and at 1 kHz in turn. Return a summary, and whether all stayed in their tubes."""
    pairs = [
        (controller, Loop(controller, model), Analysis(controller).period)
        for controller in tubes
        for model in corner_plants(controller.task)
    ]
    collisions = exits = run_count = 0
    for k, (controller, loop, period) in enumerate(itertools.islice(itertools.cycle(pairs), count)):
        rate = 1000.0 if period is None or k // len(pairs) % 2 else 1 / period.seconds
        start = random_start(controller.certificate.start, 0.9, k, k % 3 == 0)
        kind = DISTURBANCES[1 + k % 5]
        run = loop.run(Scenario(rate=max(rate, 1.0), disturbance=kind, strength=float(DISTURBANCE_BOUND), seed=k, start=start))
        collisions, exits, run_count = collisions + (run.hit is not None), exits + (not run.kept), run_count + 1
    return (
        f"{run_count} closed loops in {len(tubes)} tubes: {collisions} collisions, {exits} tubes left",
        not collisions and not exits,
    )


def step_rows(board: str) -> list[str]:
    """Return the rows about the cost of `control` on an emulated board, with the library's logarithm and with its own."""
    from benchmarks.suites.mcu import measure_on_board
    from stt_codegen.board.boards import BOARDS

    rows = []
    for math in ("libm", "inline"):
        task = order_two_task("omni_s2").changed(emit={"math": math})
        try:
            cost, _ = measure_on_board(build_task(task), BOARDS[board], math, 400)
        except MissingTool as error:
            return [f"not counted: {error}"]
        steps = f"{cost.minimum:.0f} to {cost.maximum:.0f}"
        rows.append(f"| {board}, {math} | {steps} | {cost.stack} | {cost.code} | {cost.tables} | {cost.within_bounds} |")
    return rows


def main() -> int:
    """Run all measurements, and print the tables. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--loops", type=int, default=2000)
    parser.add_argument("--board", default="m4f")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    build_task(order_two_task("omni_s2"))  # so that imports do not count as design time
    results = [design_arena(seed) for seed in range(options.count)]
    certified, milliseconds = [r for r in results if r.controller is not None], 1e3 * np.array([r.seconds for r in results])
    missed = [seed for seed, r in enumerate(results) if r.controller is None and is_certified_at_order_one(seed)]
    lines = [
        "| arenas | certified | ms, median / 95 % |",
        "|---|---|---|",
        f"| paper | {len(certified)} of {len(results)} | {np.median(milliseconds):.0f} / {np.percentile(milliseconds, 95):.0f} |",
        *(f"paper {seed}: {results[seed].reason}" for seed in missed),
        "",
        "| tube | least u_max | a point's | over it |",
        "|---|---|---|---|",
        *(smallest_limit_row(name) for name in ("omni_s2", "spacecraft")),
        "",
        "| tube | u_max over the largest closing speed | proved, ms | \\|u\\| | left at 1, 1.5, 2, 3, 4, 6 times that, % |",
        "|---|---|---|---|---|",
    ]
    controllers: list[EmittedController] = []
    for name in ("omni_s2", "spacecraft"):
        rows, tubes = period_rows(name)
        lines += rows
        controllers += tubes
    summary, all_kept = run_loops(
        [*controllers, *(r.controller for r in certified[:8] if r.controller is not None)], options.loops
    )
    lines += [
        "",
        summary,
        "",
        "| control | instructions | stack, B | code, B | tables, B | within its bounds |",
        "|---|---|---|---|---|---|",
    ]
    lines += step_rows(options.board)
    text = "\n".join(lines)
    print(text)
    if options.record:
        record(options.record, "inertia", f"## Plants of order 2\n\nMade by `{command()}`; {machine()}.\n\n{text}")
    return 0 if all_kept and not missed else 1


if __name__ == "__main__":
    sys.exit(main())
