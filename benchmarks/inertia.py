"""Plants of order 2: how many tubes are certified and how fast, what u they take beside the least possible, which periods are
proved, and closed loops at them.

    python -m benchmarks inertia [--count 100] [--loops 2000] [--board m4f] [--record FILE.md]

- paper: the arenas of four unit squares, |w| <= 0.3.
- least: the least u_max, one for all components, for which a tube is designed and P8 proved, over |w| and 4 length/t_c^2, what
  a point needs on the shortest route from rest to rest.
- periods: omni_s2 and spacecraft as double integrators, |w| <= 0.3, u_max 1.1, 1.3 and 2 times what pushes, and none; by gain the
  longest that is proved for every start at rest with |e(0)| <= 0.9.
- loops: at that period and at 1 kHz, corner and random starts, every disturbance in turn, the weakest and strongest plants.

Exit code 1 when an arena that order 1 certifies has no tube, or a loop leaves its tube or meets a set.
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
from stt_codegen.pipeline import EmittedController, build_program, build_task, certify, design_tube
from stt_codegen.report.analysis import Analysis
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task

ROOT = Path(__file__).resolve().parent.parent
PUSH = "0.3"
SLOWER = (1, 1.5, 2, 3, 4, 6)  # times the proved period


@dataclass(frozen=True)
class Result:
    """One arena: seconds of processor time for design and certificate."""

    controller: EmittedController | None
    seconds: float
    reason: str = ""


def arena(seed: int) -> Result:
    task = arena_task(FAMILIES["paper"], seed).changed(plant={"order": 2, "w_max": PUSH})
    begin = time.process_time()
    try:
        design = design_tube(task)
        certificate = certify(task, design, build_program(task, design))
    except NotCertified as error:
        return Result(None, time.process_time() - begin, str(error))
    took = time.process_time() - begin
    if not certificate.holds:
        return Result(None, took, certificate.refusal())
    return Result(build_task(task, tube=design), took)


def least_acceleration(task: Task) -> float:
    """4 length/t_c^2 of the shortest route for the least width, in the largest component."""
    lattice = lattice_of(task)
    normalised_arena = normalise(arena_of(task, lattice), lattice.exponent)
    route = shortest_route(
        normalised_arena, starting_box(normalised_arena), np.full(normalised_arena.dimension, normalised_arena.min_width)
    )
    return float(4 * route.length * normalised_arena.length_unit / normalised_arena.time_unit**2)


def least_limit(name: str) -> str:
    """By halving, to 2 %."""
    task, low, high = inertial(name), float(PUSH), 8.0
    bound = float(PUSH) + least_acceleration(task)
    while high / low > 1.02:
        middle = (low * high) ** 0.5
        try:
            good = build_task(task.changed(control={"u_max": f"{middle:.6g}"})).certificate.holds
        except NotCertified:
            good = False
        low, high = (low, middle) if good else (middle, high)
    return f"| {name} | {high:.3g} | {bound:.3g} | {high / bound:.2f} |"


def first_order(seed: int) -> bool:
    try:
        return build_task(arena_task(FAMILIES["paper"], seed)).certificate.holds
    except NotCertified:
        return False


def inertial(name: str) -> Task:
    return load_task(ROOT / "tasks" / f"{name}.toml").changed(plant={"order": 2, "w_max": PUSH})


def periods(name: str) -> tuple[list[str], list[EmittedController]]:
    """Rows of what is proved under several limits, and the controllers with them."""
    free = build_task(inertial(name))
    push = Analysis(free).sampled_loop.closing_speed.max(axis=0)
    rows, controllers = [], []
    for factor in (1.1, 1.3, 2.0, None):
        control: dict[str, Any] = {} if factor is None else {"u_max": [f"{v * factor:.4g}" for v in push]}
        controller = build_task(free.task.changed(control=control), tube=free.design)
        best = Analysis(controller).gains.longest
        if best is None:
            rows.append(f"| {name} | {factor or 'none'} | none | | |")
            continue
        gain = [f"{v:.6g}" for v in best[0].tolist()]
        controller = build_task(controller.task.changed(control={**control, "gain": gain}), tube=free.design)
        controllers.append(controller)
        u = ", ".join(f"{v:.3g}" for v in best[1].u)
        rows.append(
            f"| {name} | {factor or 'none'} | {best[1].seconds * 1e3:.3g} | {u} | {failures(controller, best[1].seconds)} |"
        )
    return rows, controllers


def failures(controller: EmittedController, seconds: float) -> str:
    """The shares of loops that leave their tubes at several times the period."""
    percentages = []
    for factor in SLOWER:
        runs = [
            loop.run(
                Scenario(
                    rate=1 / (factor * seconds),
                    disturbance=DISTURBANCES[1 + k % 5],
                    strength=float(PUSH),
                    seed=k,
                    start=random_start(controller.certificate.start, 0.9, k, k % 2 == 0),
                )
            )
            for loop in (Loop(controller, model) for model in corner_plants(controller.task))
            for k in range(10)
        ]
        percentages.append(f"{100 * sum(not r.kept for r in runs) / len(runs):.0f}")
    return ", ".join(percentages)


def loops(tubes: list[EmittedController], count: int) -> tuple[str, bool]:
    """At the proved period and at 1 kHz in turn."""
    pairs = [
        (controller, Loop(controller, model), Analysis(controller).period)
        for controller in tubes
        for model in corner_plants(controller.task)
    ]
    hit = left = run_count = 0
    for k, (controller, loop, period) in enumerate(itertools.islice(itertools.cycle(pairs), count)):
        rate = 1000.0 if period is None or k // len(pairs) % 2 else 1 / period.seconds
        start = random_start(controller.certificate.start, 0.9, k, k % 3 == 0)
        kind = DISTURBANCES[1 + k % 5]
        run = loop.run(Scenario(rate=max(rate, 1.0), disturbance=kind, strength=float(PUSH), seed=k, start=start))
        hit, left, run_count = hit + (run.hit is not None), left + (not run.kept), run_count + 1
    return f"{run_count} closed loops in {len(tubes)} tubes: {hit} collisions, {left} tubes left", not hit and not left


def steps(board: str) -> list[str]:
    """Instructions of `control` on an emulated board, with the library and inline."""
    from benchmarks.suites.mcu import measure_on_board
    from stt_codegen.board.boards import BOARDS

    rows = []
    for math in ("libm", "inline"):
        task = inertial("omni_s2").changed(emit={"math": math})
        try:
            line, _ = measure_on_board(build_task(task), BOARDS[board], math, 400)
        except MissingTool as error:
            return [f"not counted: {error}"]
        taken = f"{line.minimum:.0f} to {line.maximum:.0f}"
        rows.append(f"| {board}, {math} | {taken} | {line.stack} | {line.code} | {line.tables} | {line.within_bounds} |")
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--loops", type=int, default=2000)
    parser.add_argument("--board", default="m4f")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    build_task(inertial("omni_s2"))  # imports are warm
    results = [arena(seed) for seed in range(options.count)]
    good, took = [r for r in results if r.controller is not None], 1e3 * np.array([r.seconds for r in results])
    missed = [seed for seed, r in enumerate(results) if r.controller is None and first_order(seed)]
    lines = [
        "| arenas | certified | ms, median / 95 % |",
        "|---|---|---|",
        f"| paper | {len(good)} of {len(results)} | {np.median(took):.0f} / {np.percentile(took, 95):.0f} |",
        *(f"paper {seed}: {results[seed].reason}" for seed in missed),
        "",
        "| tube | least u_max | a point's | over it |",
        "|---|---|---|---|",
        *(least_limit(name) for name in ("omni_s2", "spacecraft")),
        "",
        "| tube | u_max over what pushes | proved, ms | \\|u\\| | left at 1, 1.5, 2, 3, 4, 6 times that, % |",
        "|---|---|---|---|---|",
    ]
    proved: list[EmittedController] = []
    for name in ("omni_s2", "spacecraft"):
        rows, tubes = periods(name)
        lines += rows
        proved += tubes
    summary, all_kept = loops([*proved, *(r.controller for r in good[:8] if r.controller is not None)], options.loops)
    lines += [
        "",
        summary,
        "",
        "| control | instructions | stack, B | code, B | tables, B | within its bounds |",
        "|---|---|---|---|---|---|",
    ]
    lines += steps(options.board)
    text = "\n".join(lines)
    print(text)
    if options.record:
        record(options.record, "inertia", f"## Plants of order 2\n\nMade by `{command()}`; {machine()}.\n\n{text}")
    return 0 if all_kept and not missed else 1


if __name__ == "__main__":
    sys.exit(main())
