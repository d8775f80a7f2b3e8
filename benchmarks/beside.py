"""This checkout beside another one, in one run: the same arenas, turn about, each in a process of its own.

    python -m benchmarks beside ../other [--family paper] [--count 60] [--rounds 3]

Prints, by stage, the median over the arenas of the ratio of processor times (the least of the rounds counts), the ratio of what
95 % of the arenas stay below, and how many tubes and certificates differ. Machines are noisy: a ratio of one run says more than
two times of two.
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
WORK = """
import hashlib, json, sys, time
try:
    from benchmarks.suites.families import FAMILIES, arena_task
except ImportError:  # where a checkout before the move has it
    from stt_codegen.bench.families import FAMILIES, arena_task
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_program, certify, design_tube
family, count = sys.argv[1], int(sys.argv[2])
found = {}
for seed in [0, 1, *range(count)]:  # the first two are made again: imports and what is made once a process do not count
    task = arena_task(FAMILIES[family], seed)
    begin = time.process_time()
    try:
        design = design_tube(task)
    except NotCertified as error:
        found[seed] = {"made": str(error), "seconds": [time.process_time() - begin]}
        continue
    drawn = time.process_time()
    program = build_program(task, design)
    built = time.process_time()
    c = certify(task, design, program)
    end = time.process_time()
    said = repr((design, [(f.code, f.margin, f.required, f.time, f.dimension, f.obstacle) for f in c.findings], c.speed, c.start))
    made = hashlib.sha256(said.encode()).hexdigest()
    found[seed] = {"made": made, "seconds": [drawn - begin, built - drawn, end - built]}
print(json.dumps(found))
"""


def measured(checkout: Path, family: str, count: int) -> dict[str, dict]:
    """Every arena by that checkout's code, with its own Python where it has one."""
    own = checkout / ".venv" / "bin" / "python"
    python = str(own) if own.exists() else sys.executable
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    command = [python, "-c", WORK, family, str(count)]
    return json.loads(subprocess.run(command, env=environment, check=True, capture_output=True, text=True, cwd=checkout).stdout)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("other", type=Path)
    parser.add_argument("--family", default="paper")
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    here, other = Path(__file__).resolve().parent.parent, options.other.resolve()
    rounds = [[measured(c, options.family, options.count) for c in (here, other)] for _ in range(options.rounds)]
    arenas = rounds[0][0]
    different = [seed for seed in arenas if arenas[seed]["made"] != rounds[0][1][seed]["made"]]
    print(f"{len(arenas)} arenas of {options.family}: {len(different)} tubes or certificates differ {different[:8] or ''}")

    def least(side: int, seed: str, stage: int) -> float:
        return min(r[side][seed]["seconds"][stage] for r in rounds)

    whole = [seed for seed in arenas if all(len(r[side][seed]["seconds"]) == len(STAGES) for r in rounds for side in (0, 1))]
    for k, name in enumerate(STAGES):
        ratio = statistics.median(least(0, seed, k) / least(1, seed, k) for seed in whole)
        print(f"{name}: {ratio:.3f} times, {1e3 * statistics.median(least(0, seed, k) for seed in whole):.2f} ms")
    both = statistics.median(sum(least(0, s, k) for k in range(3)) / sum(least(1, s, k) for k in range(3)) for s in whole)
    print(f"together: {both:.3f} times")
    late = [float(np.quantile([sum(least(side, s, k) for k in range(3)) for s in whole], 0.95)) for side in (0, 1)]
    print(f"at 95 %: {late[0] / late[1]:.3f} times, {1e3 * late[0]:.2f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
