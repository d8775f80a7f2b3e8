"""P7: the derived bound on the emitted arithmetic beside the worst error met, for every example task, float and double.

    python -m benchmarks arithmetic [--points 1000000] [--record benchmarks/RESULTS.md]

Points: random t in [0, t_c], and every knot with its four neighbours among the floats, at which the segment changes. The
reference evaluates the exact spline at the very t in extended precision (64 bits). Exit code 1 when a bound is exceeded.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from benchmarks.suites.report import command, record, table
from stt_codegen import reference
from stt_codegen.controller.edge_errors import rate_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.pipeline import build
from stt_codegen.program.targets.c.runner import CompiledC

TASKS = sorted(Path(__file__).parent.parent.glob("tasks/*.toml"))
CHUNK = 100_000


def points_of(design: RefinedDesign, number: type, count: int, random: np.random.Generator) -> np.ndarray:
    """Times in the emitted type, shape (P,)."""
    t_c = float(design.prescribed_time)
    knots = (np.arange(design.segments + 1) * (t_c / design.segments)).astype(number)
    near = [knots]
    for direction in (-np.inf, np.inf):
        neighbour = knots
        for _ in range(2):
            neighbour = np.nextafter(neighbour, number(direction))
            near.append(neighbour)
    return np.concatenate([*near, random.uniform(0.0, t_c, count).astype(number)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    count = options.points
    rows, exceeded = [], False
    for path in TASKS:
        for scalar in ("float", "double"):
            controller = build(path, "refined", scalar)
            design = controller.design
            assert isinstance(design, RefinedDesign)
            c = CompiledC(controller)
            times = points_of(design, c.number, count, np.random.default_rng(0))
            worst = np.zeros((2, design.dimension))
            for start in range(0, len(times), CHUNK):
                t = times[start : start + CHUNK]
                exact = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
                slope = reference.tube_rate(design.integers(), design.unit, design.prescribed_time, t)
                for row, got, want in ((0, c.tube(t), exact), (1, c.tube_rate(t), slope)):
                    for edge, true in zip(got, want, strict=True):
                        worst[row] = np.maximum(worst[row], np.abs(edge - true).max(axis=0).astype(float))
            bounds = [controller.certificate.edge_error, rate_error(design, controller.program)]
            for name, error, bound in zip(("edge", "rate"), worst, bounds, strict=True):
                share = max(float(e) / float(b) for e, b in zip(error, bound, strict=True))
                exceeded |= share > 1
                rows.append(
                    [controller.task.name, scalar, name, f"{max(map(float, bound)):.2e}", f"{error.max():.2e}", f"{share:.0%}"]
                )
            print(f"{path.stem} {scalar}", file=sys.stderr)
    found = table(["task", "type", "of", "bound", "worst error", "of its bound"], rows)
    print(found)
    if options.record:
        head = f"## P7: the bound on the arithmetic, {count} random points and the knots\n\nMade by `{command()}`."
        record(options.record, "arithmetic", f"{head}\n\n{found}")
    sys.exit(exceeded)


if __name__ == "__main__":
    main()
