"""Published tasks: from task files to certified C in one process, beside the times that were published for the same tasks.

    python benchmarks/missions.py

The published times are for synthesis by an SMT solver over sampled times, as the authors state them in their code's comments;
their machine is another. Ours are wall times of loading, design, certificate and the text of all files, the median of nine
in this process, imports not counted; the first one's time is shown too.
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path

from stt_codegen.pipeline import build

TASKS = Path(__file__).parent.parent / "tasks"
PUBLISHED = (
    ("robot mission over two waypoints", ("mission_leg1", "mission_leg2", "mission_leg3"), 13 * 60 + 28.0),
    ("spacecraft", ("spacecraft",), 97.0),
)


def main() -> None:
    for title, names, published in PUBLISHED:
        for scalar in ("float", "double"):
            times = []
            for _ in range(9):
                begin = time.perf_counter()
                certified = all([build(TASKS / f"{name}.toml", "refined", scalar).certificate.holds for name in names])
                times.append(time.perf_counter() - begin)
                assert certified
            median = statistics.median(times)
            print(
                f"{title}, {scalar}: {median:.3f} s (first {times[0]:.3f} s); published {published:g} s, {published / median:.0f} times as long"
            )


if __name__ == "__main__":
    main()
