"""How good are the tubes: least width over the widest box that gets through, peak speed over the slowest tube's, and whether the
tool's own tube at another min_width is wider and no faster.

    python -m benchmarks tubes [--family paper] [--count 60] [--others 0] [--disc]

The widest box is found by halving on the width of a route; no tube along a route can be wider. --others N: so many arenas are
designed again at other least widths. --disc: a disc, and the same covered by 16, 64 and
128 boxes. Exit code 1
where an arena with a way has no certificate, or such a tube is found.
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

WIDER, FASTER = 1.1, 1.001  # a tube so much wider at no more than so much of the speed dominates
OTHERS = (0.1, 0.2, 0.3, 0.4, 0.5)  # least widths to try, of the narrower of start and target


def seeds(family: str, count: int) -> list[int]:
    """The first arenas of a family in which a point finds a way."""
    found: list[int] = []
    seed = 0
    while len(found) < count:
        if is_feasible(FAMILIES[family], seed):
            found.append(seed)
        seed += 1
    return found


def measured(design: Any) -> tuple[float, float]:
    """The least width and the peak speed of a tube, by its Bezier coefficients."""
    bezier, unit = design.bezier(), float(design.unit)
    steps = np.abs(np.diff(bezier, axis=3)).max() * unit
    return float((bezier[:, :, 1] - bezier[:, :, 0]).min()) * unit, float(steps * 3 * design.segments / design.prescribed_time)


def widest_box(task: Task) -> float:
    """The largest width of a box that has a route, alike in every dimension, in the task's units."""
    lattice = lattice_of(task)
    arena = normalise(arena_of(task, lattice), lattice.exponent)
    start = starting_box(arena)
    full = float(np.minimum(start[1] - start[0], arena.target[1] - arena.target[0]).min())

    def way(width: float) -> bool:
        return find_route(arena, start, np.full(arena.dimension, width)) is not None

    low, high = arena.min_width, full
    if way(high):
        return high * arena.length_unit
    while high - low > 1e-3 * full:
        middle = (low + high) / 2
        low, high = (middle, high) if way(middle) else (low, middle)
    return low * arena.length_unit


def quantiles(values: list[float], low: bool = False) -> str:
    return f"{np.median(values):.3f} / {np.quantile(values, 0.05 if low else 0.95):.3f}"


def look(family: str, count: int, others: int) -> bool:
    width, speed, both, milliseconds = [], [], [], []
    missing: list[int] = []
    dominated: list[int] = []
    for k, seed in enumerate(seeds(family, count)):
        task = arena_task(FAMILIES[family], seed)
        begin = time.process_time()
        try:
            design = refine(task)
            done = time.process_time()
            good = certify(task, design, build_program(task, design)).holds
        except NotCertified:
            good = False
        if not good:
            missing.append(seed)
            continue
        if k:  # the first pays for imports
            milliseconds.append(1e3 * (done - begin))
            both.append(1e3 * (time.process_time() - begin))
        w, v = measured(design)
        width.append(w / widest_box(task))
        speed.append(v / measured(refine(task.changed(tube={"prefer": "slow"})))[1])
        if k < others:
            dominated += [seed] if _dominated(task, w, v) else []
    print(f"{family}: {len(width)} of {count} certified{f', not {missing}' if missing else ''}")
    print(f"  least width over the widest box's, median / 5 %: {quantiles(width, low=True)}")
    print(f"  peak speed over the slowest tube's, median / 95 %: {quantiles(speed)}")
    print(f"  design, ms, median / 95 %: {quantiles(milliseconds)}; with certificate: {quantiles(both)}")
    if others:
        print(f"  dominated by a tube at another min_width: {len(dominated)} of {min(others, count)} {dominated or ''}")
    return not missing and not dominated


def _dominated(task: Task, width: float, speed: float) -> bool:
    full = 0.5
    for share in OTHERS:
        try:
            other = refine(task.changed(tube={"min_width": Fraction(str(share * full))}))
        except NotCertified:
            continue
        w, v = measured(other)
        if w >= WIDER * width and v <= FASTER * speed:
            return True
    return False


def disc(boxes: int) -> Task:
    """A disc of radius 0.5 in the middle of the paper's room, itself (0) or covered by upright strips, each cover within the
    last."""
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
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--family", action="append", choices=sorted(FAMILIES))
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--others", type=int, default=0)
    parser.add_argument("--disc", action="store_true")
    options = parser.parse_args()
    good = [look(family, options.count, options.others) for family in options.family or ["paper"]]
    if options.disc:
        widths = {boxes: measured(refine(disc(boxes)))[0] for boxes in (0, 16, 64, 128)}
        print("disc: least width " + ", ".join(f"by {k} boxes {w:.3f}" if k else f"itself {w:.3f}" for k, w in widths.items()))
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
