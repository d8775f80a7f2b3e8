"""Compare the derived error bands of the emitted arithmetic (P7) with the largest measured errors, in float and double.

    python -m benchmarks arithmetic [--points 1000000] [--record benchmarks/RESULTS.md]

The points are random t in [0, t_c], and every knot with its four neighbours among the floats, where the segment changes. The
reference evaluates the exact spline at the same t in extended precision (64 bits). The exit code is 1 when a bound is exceeded.
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
from stt_codegen.pipeline import EmittedController, build
from stt_codegen.program.targets.c.runner import CompiledC

TASKS = sorted(Path(__file__).parent.parent.glob("tasks/*.toml"))
CHUNK = 100_000  # points per call, which bounds the memory


def points_of(design: RefinedDesign, number_type: type, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return times in the emitted type, (P,): knots, their neighbours, and `count` random ones."""
    t_c = float(design.prescribed_time)
    knots = (np.arange(design.segments + 1) * (t_c / design.segments)).astype(number_type)
    times = [knots]
    for direction in (-np.inf, np.inf):
        neighbour = knots
        for _ in range(2):
            neighbour = np.nextafter(neighbour, number_type(direction))
            times.append(neighbour)
    return np.concatenate([*times, rng.uniform(0.0, t_c, count).astype(number_type)])


def largest_errors(controller: EmittedController, count: int) -> np.ndarray:
    """Return the largest errors of the emitted edges and of their rates, (2, n), over all points."""
    design = controller.design
    assert isinstance(design, RefinedDesign)
    c = CompiledC(controller)
    times = points_of(design, c.number, count, np.random.default_rng(0))
    largest = np.zeros((2, design.dimension))
    for start in range(0, len(times), CHUNK):
        t = times[start : start + CHUNK]
        exact = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
        exact_rate = reference.tube_rate(design.integers(), design.unit, design.prescribed_time, t)
        for row, edges, exact_edges in ((0, c.tube(t), exact), (1, c.tube_rate(t), exact_rate)):
            for edge, exact_edge in zip(edges, exact_edges, strict=True):
                largest[row] = np.maximum(largest[row], np.abs(edge - exact_edge).max(axis=0).astype(float))
    return largest


def main() -> None:
    """Measure every example task, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    rows, exceeded = [], False
    for path in TASKS:
        for scalar in ("float", "double"):
            controller = build(path, "refined", scalar)
            errors = largest_errors(controller, options.points)
            bounds = [controller.certificate.edge_error, rate_error(controller.design, controller.program)]
            for name, error, bound in zip(("edge", "rate"), errors, bounds, strict=True):
                share = max(float(e) / float(b) for e, b in zip(error, bound, strict=True))
                exceeded |= share > 1
                rows.append(
                    [controller.task.name, scalar, name, f"{max(map(float, bound)):.2e}", f"{error.max():.2e}", f"{share:.0%}"]
                )
            print(f"{path.stem} {scalar}", file=sys.stderr)
    text = table(["task", "type", "of", "bound", "worst error", "of its bound"], rows)
    print(text)
    if options.record:
        head = f"## P7: the bound on the arithmetic, {options.points} random points and the knots\n\nMade by `{command()}`."
        record(options.record, "arithmetic", f"{head}\n\n{text}")
    sys.exit(exceeded)


if __name__ == "__main__":
    main()
