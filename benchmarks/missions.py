"""Published tasks: from task files to certified C in one process, beside the times that were published for the same tasks.

    python benchmarks/missions.py [--record benchmarks/RESULTS.md]

The published times are for synthesis by an SMT solver over sampled times, as the authors state them in their code's comments;
their machine is another. Ours are wall times of loading, design, certificate and the text of all files, the median of nine
in this process, imports not counted; the first one's time is shown too.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

from stt_codegen.bench.report import command, machine, record, table
from stt_codegen.pipeline import build

TASKS = Path(__file__).parent.parent / "tasks"
PUBLISHED = (
    ("robot mission over two waypoints", ("mission_leg1", "mission_leg2", "mission_leg3"), 13 * 60 + 28.0),
    ("spacecraft", ("spacecraft",), 97.0),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    rows = []
    for title, names, published in PUBLISHED:
        for scalar in ("float", "double"):
            times = []
            for _ in range(9):
                begin = time.perf_counter()
                for name in names:
                    build(TASKS / f"{name}.toml", "refined", scalar)  # raises when it is not certified
                times.append(time.perf_counter() - begin)
            median = statistics.median(times)
            rows.append([title, scalar, f"{median:.3f}", f"{times[0]:.3f}", f"{published:g}", f"{published / median:.0f}"])
    found = table(["task", "type", "seconds", "the first time", "published seconds", "times as long"], rows)
    print(found)
    if options.record:
        record(options.record, "missions", f"## Published tasks\n\nMade by `{command()}`; {machine()}.\n\n{found}")


if __name__ == "__main__":
    main()
