"""Refused tasks of all kinds: whether each remedy that a refusal names is true, what became certified, and the seconds.

    python -m benchmarks refusals [--count 200] [--before CHECKOUT] [--record FILE.md]

Tasks are drawn by kind and seed (benchmarks/suites/demanding.py) until so many are refused. With --before they are those that the
code of another checkout refuses; the table then has how many of these are certified now. Every remedy is read from the text of
its refusal, put into the task, and built to the end. Exit code 1 where one is not certified.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.suites.demanding import KINDS, task_text
from benchmarks.suites.remedies import Remedy, remedies_of, with_remedy
from benchmarks.suites.report import record, table
from stt_codegen.effort import Effort
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task
from stt_codegen.task import Task, parse_task

SEED_LIMIT = 2_000
# What runs in the other checkout: it reads the text of a task in a line of JSON, and answers whether the task is refused.
JUDGE = """
import json, sys
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task
from stt_codegen.task import parse_task
for line in sys.stdin:
    try:
        build_task(parse_task(json.loads(line)))
        print(0, flush=True)
    except NotCertified:
        print(1, flush=True)
"""


@dataclass
class TimedEffort(Effort):
    """An effort that notes when the first reason is known, in words."""

    seconds_to_reason: float = 0.0

    def begin_search(self, reason: str) -> None:
        super().begin_search(reason)
        self.seconds_to_reason = self.elapsed


@dataclass
class Outcome:
    """What became of a task. false_remedies: those with which it is not certified. Seconds are of the clock."""

    kind: str
    is_certified: bool
    seconds_to_reason: float
    seconds: float
    remedies: list[Remedy] = field(default_factory=list)
    false_remedies: list[Remedy] = field(default_factory=list)


def judge(kind: str, task: Task) -> Outcome:
    """Build a task, and follow each remedy of its refusal."""
    effort, begin = TimedEffort(), time.monotonic()
    try:
        build_task(task, effort=effort)
        return Outcome(kind, True, effort.seconds_to_reason, time.monotonic() - begin)
    except NotCertified as refusal:
        remedies = remedies_of(str(refusal))
        outcome = Outcome(kind, False, effort.seconds_to_reason, time.monotonic() - begin, remedies)
    outcome.false_remedies = [remedy for remedy in outcome.remedies if not is_certified(with_remedy(task, remedy))]
    return outcome


def is_certified(task: Task) -> bool:
    """Return whether a task is certified as it is."""
    try:
        return build_task(task, effort=Effort(0)).certificate.holds
    except NotCertified:
        return False


def draw() -> Iterator[tuple[str, str]]:
    """Yield kinds and texts of tasks, one of each kind for each seed."""
    return ((kind, task_text(kind, seed)) for seed in range(SEED_LIMIT) for kind in KINDS)


def refused_by(checkout: Path) -> Iterator[tuple[str, str]]:
    """Yield the drawn tasks that the code of another checkout refuses."""
    with subprocess.Popen(
        [sys.executable, "-c", JUDGE], cwd=checkout, env={**os.environ, "PYTHONPATH": str(checkout)},
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        for kind, text in draw():
            process.stdin.write(json.dumps(text) + "\n")
            process.stdin.flush()
            if process.stdout.readline().strip() == "1":
                yield kind, text


def summary(outcomes: Sequence[Outcome]) -> str:
    """Return the table by kind, and a line about all."""
    rows = [_row(kind, [o for o in outcomes if o.kind == kind]) for kind in KINDS if any(o.kind == kind for o in outcomes)]
    headings = [
        "kind", "tasks", "certified now", "refused with a remedy", "remedies", "of them false", "s to the reason, median, 95 %",
        "s to the end, median, 95 %",
    ]  # fmt: skip
    return table(headings, [*rows, _row("all", outcomes)])


def _row(kind: str, outcomes: Sequence[Outcome]) -> list[str]:
    """Return a row of the table."""

    def seconds(values: list[float]) -> str:
        return f"{np.median(values):.1f}, {np.quantile(values, 0.95):.1f}"

    counts = (
        len(outcomes),
        sum(o.is_certified for o in outcomes),
        sum(bool(o.remedies) for o in outcomes),
        sum(len(o.remedies) for o in outcomes),
        sum(len(o.false_remedies) for o in outcomes),
    )
    times = [[o.seconds_to_reason for o in outcomes], [o.seconds for o in outcomes]]
    return [kind, *map(str, counts), *map(seconds, times)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw, build, follow, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=200, help="refused tasks")
    parser.add_argument("--before", type=Path, metavar="CHECKOUT", help="tasks that the code there refuses")
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args(arguments)
    outcomes: list[Outcome] = []
    if options.before:
        tasks = itertools.islice(refused_by(options.before.resolve()), options.count)
        outcomes += (judge(kind, parse_task(text)) for kind, text in tasks)
    else:
        judged = (judge(kind, parse_task(text)) for kind, text in draw())
        outcomes += itertools.islice((o for o in judged if not o.is_certified), options.count)
    for outcome in outcomes:
        for remedy in outcome.false_remedies:
            print(f"false: {outcome.kind}: {remedy}")
    text = summary(outcomes)
    print(text)
    if options.record:
        record(options.record, "refusals", text)
    return int(any(o.false_remedies for o in outcomes))


if __name__ == "__main__":
    sys.exit(main())
