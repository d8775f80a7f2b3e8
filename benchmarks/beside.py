"""Compare this checkout with another one: both design the same arenas in turn, in new processes.

    python -m benchmarks beside ../other [--family paper] [--count 60] [--rounds 3]

It prints for each stage the median over the arenas of the ratio of processor times, each the smallest of the rounds; the ratio of
the times that 95 % of the arenas stay below; and how many tubes and certificates differ. Machines are noisy, so a ratio of times
from one run says more than times from two runs.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np

STAGES = ("design", "program", "certificate")
ARENA_SCRIPT = """
import hashlib, json, sys, time
try:
    from benchmarks.suites.families import FAMILIES, arena_task
except ImportError:  # the place in older checkouts
    from stt_codegen.bench.families import FAMILIES, arena_task
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_program, certify
try:
    from stt_codegen.pipeline import preferred_tube
except ImportError:  # its name in older checkouts
    from stt_codegen.pipeline import design_tube as preferred_tube
family, count = sys.argv[1], int(sys.argv[2])
results = {}
for seed in [0, 1, *range(count)]:  # the first two are repeated, so that imports and caches do not count
    task = arena_task(FAMILIES[family], seed)
    begin = time.process_time()
    try:
        design = preferred_tube(task)
    except NotCertified as error:
        results[seed] = {"digest": str(error), "seconds": [time.process_time() - begin]}
        continue
    designed = time.process_time()
    program = build_program(task, design)
    build_end = time.process_time()
    c = certify(task, design, program)
    end = time.process_time()
    text = repr((design, [(f.code, f.margin, f.required, f.time, f.dimension, f.obstacle) for f in c.findings], c.speed, c.start))
    digest = hashlib.sha256(text.encode()).hexdigest()
    results[seed] = {"digest": digest, "seconds": [designed - begin, build_end - designed, end - build_end]}
print(json.dumps(results))
"""


def run_checkout(checkout: Path, family: str, count: int) -> dict[str, dict]:
    """Return digest and seconds of each arena, by seed, as the checkout computes them, with its .venv if it has one."""
    local_python = checkout / ".venv" / "bin" / "python"
    python = str(local_python) if local_python.exists() else sys.executable
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    command = [python, "-c", ARENA_SCRIPT, family, str(count)]
    return json.loads(subprocess.run(command, env=environment, check=True, capture_output=True, text=True, cwd=checkout).stdout)


def main() -> int:
    """Run both checkouts, and print ratios of times and the number of differences. Return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("other", type=Path)
    parser.add_argument("--family", default="paper")
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    checkouts = (Path(__file__).resolve().parent.parent, options.other.resolve())
    rounds = [[run_checkout(c, options.family, options.count) for c in checkouts] for _ in range(options.rounds)]
    arenas = rounds[0][0]
    different = [seed for seed in arenas if arenas[seed]["digest"] != rounds[0][1][seed]["digest"]]
    print(f"{len(arenas)} arenas of {options.family}: {len(different)} tubes or certificates differ {different[:8] or ''}")

    def seconds(checkout: int, seed: str, stage: int) -> float:
        return min(results[checkout][seed]["seconds"][stage] for results in rounds)

    def total(checkout: int, seed: str) -> float:
        return sum(seconds(checkout, seed, stage) for stage in range(len(STAGES)))

    complete = [seed for seed in arenas if all(len(c[seed]["seconds"]) == len(STAGES) for results in rounds for c in results)]
    for k, name in enumerate(STAGES):
        ratio = statistics.median(seconds(0, seed, k) / seconds(1, seed, k) for seed in complete)
        print(f"{name}: {ratio:.3f} times, {1e3 * statistics.median(seconds(0, seed, k) for seed in complete):.2f} ms")
    print(f"together: {statistics.median(total(0, seed) / total(1, seed) for seed in complete):.3f} times")
    late = [float(np.quantile([total(checkout, seed) for seed in complete], 0.95)) for checkout in (0, 1)]
    print(f"at 95 %: {late[0] / late[1]:.3f} times, {1e3 * late[0]:.2f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
