"""Measure how good tubes are: smallest width over the widest box with a route, and peak speed over the slowest tube's.

    python -m benchmarks tubes [--family paper] [--count 60] [--others 0] [--disc]

No tube along a route can be wider than the widest box that has a route, which is searched by bisection. --others N: N arenas are
designed again with other min_width. --disc: a disc is compared with covers of it by 16, 64 and 128 boxes. The exit code is 1
where an arena with a way has no certificate, or where another min_width gives a wider tube that is no faster.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from fractions import Fraction
from typing import Any

import numpy as np

from benchmarks.suites.families import FAMILIES, arena_task, is_feasible
from stt_codegen.design.arena import arena_of, normalise, starting_box
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.refine import refine
from stt_codegen.design.routes.shortest_route import find_route
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_program, certify
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task

WIDER, FASTER = 1.1, 1.001  # a tube is dominated by one that is WIDER times as wide and at most FASTER times as fast
WIDTH_SHARES = (0.1, 0.2, 0.3, 0.4, 0.5)  # values of min_width to try, over the width of start and target
START_WIDTH = 0.5  # of start and target


def first_feasible_seeds(family: str, count: int) -> list[int]:
    """Return the seeds of the first `count` feasible arenas of a family."""
    feasible_seeds: list[int] = []
    seed = 0
    while len(feasible_seeds) < count:
        if is_feasible(FAMILIES[family], seed):
            feasible_seeds.append(seed)
        seed += 1
    return feasible_seeds


def width_and_speed(design: Any) -> tuple[float, float]:
    """Return the smallest width and the peak speed of a tube, by its Bezier coefficients."""
    bezier, unit = design.bezier(), float(design.unit)
    steps = np.abs(np.diff(bezier, axis=3)).max() * unit
    return float((bezier[:, :, 1] - bezier[:, :, 0]).min()) * unit, float(steps * 3 * design.segments / design.prescribed_time)


def widest_box(task: Task) -> float:
    """Return the largest width of a cube that has a route, in the task's units."""
    lattice = lattice_of(task)
    arena = normalise(arena_of(task, lattice), lattice.exponent)
    start = starting_box(arena)
    full = float(np.minimum(start[1] - start[0], arena.target[1] - arena.target[0]).min())

    def has_route(width: float) -> bool:
        return find_route(arena, start, np.full(arena.dimension, width)) is not None

    low, high = float(arena.min_widths.max()), full
    if has_route(high):
        return high * arena.length_unit
    while high - low > 1e-3 * full:
        middle = (low + high) / 2
        low, high = (middle, high) if has_route(middle) else (low, middle)
    return low * arena.length_unit


def quantiles(values: list[float], low: bool = False) -> str:
    """Return the median and the 95 % quantile as text; with `low` the 5 % quantile instead."""
    return f"{np.median(values):.3f} / {np.quantile(values, 0.05 if low else 0.95):.3f}"


def measure_family(family: str, count: int, compared_count: int) -> bool:
    """Design the first feasible arenas of a family, and print the measurements.

    compared_count: number of arenas that are designed again with other min_width. Return whether all are certified and none is
    dominated.
    """
    width, speed, design_ms, total_ms = [], [], [], []
    missing: list[int] = []
    dominated: list[int] = []
    for k, seed in enumerate(first_feasible_seeds(family, count)):
        task = arena_task(FAMILIES[family], seed)
        begin = time.process_time()
        try:
            design = refine(task)
            designed = time.process_time()
            is_certified = certify(task, design, build_program(task, design)).holds
        except NotCertified:
            is_certified = False
        if not is_certified:
            missing.append(seed)
            continue
        if k:  # the time of the first arena contains imports
            design_ms.append(1e3 * (designed - begin))
            total_ms.append(1e3 * (time.process_time() - begin))
        w, v = width_and_speed(design)
        width.append(w / widest_box(task))
        speed.append(v / width_and_speed(refine(task.changed(tube={"prefer": "slow"})))[1])
        if k < compared_count:
            dominated += [seed] if _is_dominated(task, w, v) else []
    print(f"{family}: {len(width)} of {count} certified{f', not {missing}' if missing else ''}")
    print(f"  least width over the widest box's, median / 5 %: {quantiles(width, low=True)}")
    print(f"  peak speed over the slowest tube's, median / 95 %: {quantiles(speed)}")
    print(f"  design, ms, median / 95 %: {quantiles(design_ms)}; with certificate: {quantiles(total_ms)}")
    if compared_count:
        print(f"  dominated by a tube at another min_width: {len(dominated)} of {min(compared_count, count)} {dominated or ''}")
    return not missing and not dominated


def _is_dominated(task: Task, width: float, speed: float) -> bool:
    """Return whether another min_width gives a tube that is wider than `width` and no faster than `speed`."""
    for share in WIDTH_SHARES:
        try:
            design = refine(task.changed(tube={"min_width": Fraction(str(share * START_WIDTH))}))
        except NotCertified:
            continue
        w, v = width_and_speed(design)
        if w >= WIDER * width and v <= FASTER * speed:
            return True
    return False


def disc_task(boxes: int) -> Task:
    """Return the task of a disc of radius 0.5 in the middle of the paper's arena.

    boxes: the number of upright strips that cover it; 0 for the disc itself. A cover with more strips is within one with fewer.
    """
    lines = [] if boxes else ["[[unsafe]]\ncentre = [2.5, 2.5]\nradius = 0.5\n"]
    for k in range(boxes):
        low, high = -0.5 + k / boxes, -0.5 + (k + 1) / boxes
        nearest = 0.0 if low <= 0 <= high else min(abs(low), abs(high))
        half = math.sqrt(0.25 - nearest**2)
        lines.append(f"[[unsafe]]\nlower = [{2.5 + low!r}, {2.5 - half!r}]\nupper = [{2.5 + high!r}, {2.5 + half!r}]\n")
    return parse_task(
        'name = "disc"\nprescribed_time = 9.0\ninitial_state = [0.25, 0.25]\n'
        "[state_space]\nlower = [0.0, 0.0]\nupper = [5.0, 5.0]\n[initial_set]\nlower = [0.0, 0.0]\nupper = [0.5, 0.5]\n"
        "[target_set]\nlower = [4.5, 4.5]\nupper = [5.0, 5.0]\n" + "".join(lines) + "[tube]\nclearance = 0.03\n"
    )


def main() -> int:
    """Measure all families. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--family", action="append", choices=sorted(FAMILIES))
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--others", type=int, default=0)
    parser.add_argument("--disc", action="store_true")
    options = parser.parse_args()
    results = [measure_family(family, options.count, options.others) for family in options.family or ["paper"]]
    if options.disc:
        widths = {boxes: width_and_speed(refine(disc_task(boxes)))[0] for boxes in (0, 16, 64, 128)}
        print("disc: least width " + ", ".join(f"by {k} boxes {w:.3f}" if k else f"itself {w:.3f}" for k, w in widths.items()))
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
