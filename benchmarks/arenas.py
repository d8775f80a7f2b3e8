"""Tubes over random arenas: how many are good, how fast, how wide, how slow. One process, imports excluded.

    python benchmarks/arenas.py [--family paper] [--count 500] [--clearance 0.03] [--min-width 0.05] [--design refined]

Good is certified for refined tubes, and P1 to P6 at 4000 samples for adaptive and literal ones.

Prints one table; every arena that is feasible at 0.1 (for the families with cubes below 0.6: 0.13) and not certified is
listed with its reason.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter

import numpy as np

from stt_codegen.arenas import FAMILIES, arena_task, feasible
from stt_codegen.design.arena import arena_of, starting_box
from stt_codegen.design.route import shortest_route
from stt_codegen.design.tube import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_program, certify, design_tube


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--family", choices=sorted(FAMILIES), default="paper")
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--clearance", type=float, default=0.03)
    parser.add_argument("--min-width", type=float, default=0.05)
    parser.add_argument("--design", choices=("refined", "adaptive", "literal"), default="refined")
    options = parser.parse_args()
    family = FAMILIES[options.family]
    reach = 0.1 if options.family == "paper" else 0.13

    rows, missed, refused, free = [], [], 0, 0
    broken: Counter[str] = Counter()
    design_tube(arena_task(family, 0).with_options(options.design))  # imports and caches
    for seed in range(options.count):
        task = arena_task(family, seed, options.clearance, options.min_width).with_options(options.design)
        open_way = feasible(family, seed, reach) if family.dimension <= 3 else None
        free += bool(open_way)
        begin = time.perf_counter()
        try:
            design = design_tube(task)
            middle = time.perf_counter()
            certificate = certify(task, design, build_program(task, design))
            end = time.perf_counter()
        except NotCertified as error:
            refused += 1
            if open_way is not False:
                missed.append((seed, str(error)))
            continue
        if certificate.failures:
            broken.update({f.code for f in certificate.failures})
            missed.append((seed, "; ".join(f.refusal() for f in certificate.failures)))
            continue
        arena = arena_of(task)
        least = shortest_route(arena, starting_box(arena), arena.min_width).length / 9.0
        size = design.segments if isinstance(design, RefinedDesign) else len(design.bumps)
        rows.append((middle - begin, end - middle, float(certificate.least_width), float(max(certificate.speed)) / least, size))
        if sys.stderr.isatty() and seed % 10 == 0:
            print(f"\r{seed + 1}/{options.count}", end="", file=sys.stderr)

    data = np.array(rows).reshape(-1, 5)
    print(
        f"{family.name}, {options.design}: {len(rows)} of {options.count} good; {free} feasible at {reach}, {len(missed)} missed"
    )
    if broken:
        print("properties that fail: " + ", ".join(f"{code} in {count}" for code, count in sorted(broken.items())))
    for name, column, scale, unit in (
        ()
        if not rows
        else (
            ("design", data[:, 0], 1e3, "ms"),
            ("certificate (with Program and P7)", data[:, 1], 1e3, "ms"),
            ("design + certificate", data[:, 0] + data[:, 1], 1e3, "ms"),
            ("least width", data[:, 2], 1, ""),
            ("peak speed / least possible", data[:, 3], 1, ""),
            ("segments (refined) or circumvent functions", data[:, 4], 1, ""),
        )
    ):
        low, mid, high, top = np.percentile(column * scale, [5, 50, 95, 100])
        print(f"{name:44s} 5 % {low:8.3f}   median {mid:8.3f}   95 % {high:8.3f}   largest {top:8.3f} {unit}")
    for seed, reason in missed:
        print(f"missed {seed}: {reason}")


if __name__ == "__main__":
    main()
