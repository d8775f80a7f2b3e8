"""What `python -m benchmarks` does: choose the parts, show progress, print and record the tables."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import cast, get_args

from benchmarks.peers.in_loops import FEW, POLICIES
from benchmarks.suites.arenas import EVERYTHING, HEADINGS, Part, Result, Summary, failures, row, run, run_peers, spread, summary
from benchmarks.suites.families import FAMILIES
from benchmarks.suites.report import command, machine, record, table, versions
from stt_codegen.design_kinds import CAPABILITIES, DesignKind
from stt_codegen.errors import BadInput

DESIGNS: tuple[DesignKind, ...] = get_args(DesignKind)


@dataclass(frozen=True)
class Where:
    """Where jobs run (processes of this machine, 0 for one a core, or a Dask cluster), and where tables go."""

    processes: int = 0
    scheduler: str | None = None
    out: Path | None = None
    as_json: bool = False

    def __post_init__(self) -> None:
        if self.out is not None and not (self.out.parent.is_dir() and os.access(self.out.parent, os.W_OK)):
            raise BadInput(f"--record {self.out}: {self.out.parent} is no folder that can be written to")

    @property
    def workers(self) -> int:
        return self.processes or os.cpu_count() or 1


@dataclass(frozen=True)
class Arenas:
    """Which arenas `python -m benchmarks arenas` runs; None: all of RESULTS.md. demand: the share of the feasible ones that must
    be certified."""

    family: list[str] | None = None
    design: list[str] | None = None
    count: int | None = None
    clearance: float | None = None
    min_width: float | None = None
    peers: bool = False
    demand: float = 0.0
    policies: Path = POLICIES


def run_arenas(wanted: Arenas, where: Where) -> bool:
    """`python -m benchmarks arenas`. True when every part certifies the share that is demanded."""
    parts, out, peers, count = parts_of(wanted), where.out, wanted.peers, wanted.count
    processes, scheduler, as_json = where.workers, where.scheduler, where.as_json
    jobs = [job for part in parts for job in part.jobs()]
    found: list[Result] = []
    with _progress(len(jobs)) as advance:
        for result in spread(run, jobs, processes, scheduler):
            found.append(result)
            advance()
    by_job = {r.job: r for r in found}
    summaries = [(part, summary(by_job[job] for job in part.jobs())) for part in parts]
    rows = [row(part, s) for part, s in summaries]
    lines = [line for part, s in summaries for line in failures(part, s)]
    beside = _beside(count or 500, processes, [s for part, s in summaries if _is_paper(part)], wanted.policies) if peers else {}
    if as_json:
        tables = {name: [dict(zip(heads, r, strict=True)) for r in own] for name, (heads, own, _) in beside.items()}
        document = {"arenas": [asdict(s) for _, s in summaries], **tables}
        print(json.dumps(_without_nan(document), indent=2, allow_nan=False))
    else:
        print(text(rows, lines, beside))
    if out is not None:
        place = f"a Dask cluster, {scheduler}" if scheduler else f"{processes} process{'es' if processes > 1 else ''}"
        head = f"## Arenas\n\nMade by `{command()}` in {place}; {machine()}{versions() if beside else ''}."
        record(out, "arenas", f"{head}\n\n{text(rows, lines, beside)}")
    return all(s.certified_of_feasible >= wanted.demand * s.feasible for _, s in summaries)


def parts_of(wanted: Arenas) -> list[Part]:
    """The rows of the table. Raises `BadInput` for a family or design that there is not."""
    family, design, count = wanted.family, wanted.design, wanted.count
    clearance, min_width = wanted.clearance, wanted.min_width
    for option, given, known in (("--family", family, tuple(FAMILIES)), ("--design", design, DESIGNS)):
        for name in given or ():
            if name not in known:
                raise BadInput(f"{option} {name}: is none of {', '.join(known)}")
    if family is None and design is None and clearance is None and min_width is None:
        parts = list(EVERYTHING)
    else:
        usual = {p.family: p.count for p in reversed(EVERYTHING)}  # of the first row of each family
        parts = [
            Part(f, d, usual[f], 0.03 if clearance is None else clearance, 0.05 if min_width is None else min_width)
            for f in family or FAMILIES
            for d in cast(Sequence[DesignKind], design or DESIGNS)
            if (FAMILIES[f].length is None and FAMILIES[f].shape == "cube") or CAPABILITIES[d].avoids_any_shape
        ]
    return [Part(p.family, p.design, min(p.count, count or p.count), p.clearance, p.min_width) for p in parts]


READING = """
Two figures are median and 95 %. Times: processor time of one arena. speed: bound on the edges' speed over the least possible
(shortest route in the largest-component metric among unsafe sets grown by clearance + min_width/2, over t_c); slowest: of the
slowest tube found, which the shipped one exceeds for width (docs/design.md). Adaptive bounds on speed are proved, not sharp. A
corridor's slowest tube is not computed.
""".strip()
TABLE_I = """
Printed: Das and Jagtap (2024), in MATLAB on an i7-11700, of what is not said. Measured: the same kind of arenas, not the
same ones; a peer's question is in the table below. A path of A* or RRT* is checked exactly, a policy by ten runs an arena,
symbolic control by its own fixed point, tubes by their certificates.
""".strip()
GRIDS = """
A cell's byte is the number of its input. memory: the most that NumPy held. runs: from random states of the start's box, the
wind at a random corner in every period; states are looked at every millisecond.
""".strip()
STEPS = """
In closed loop at 1 kHz (xdot = u, {arenas:.0f} arenas, states checked at the samples) the barrier filter takes
{cbf_microseconds:.2g} us a step, arrives in {cbf_reaches:.0%} and collides in {cbf_collides:.0%}. The emitted C step of the
{certified:.0f} certified designs takes {own_microseconds:.2g} us (the filter {ratio:.2g} times as long), arrives in
{own_reaches:.0%} and collides in {own_collides:.0%}.
""".strip()


Beside = dict[str, tuple[tuple[str, ...], list[list[str]], str]]  # headings, rows, what is to be said, by title


def _is_paper(part: Part) -> bool:
    return part.family == "paper" and (part.clearance, part.min_width) == (0.03, 0.05)


def _beside(count: int, processes: int, tubes: list[Summary], policies: Path) -> Beside:
    """The peers' tables."""
    from benchmarks.suites import printed

    found, steps = run_peers(count, processes, policies)
    return {
        "Table I of the paper, printed and measured": (
            printed.TABLE_I, printed.table_i(found, tubes, policies), f"{printed.ways(count)}\n\n{TABLE_I}"
        ),
        "Peers, in the same run, on the paper's arenas": (
            printed.HEADINGS, printed.peer_rows(found, policies), STEPS.format(**steps)
        ),
        "Policies, every run": (printed.RUNS, printed.policy_rows(found, policies), ""),
        "Symbolic control, the first arena": (printed.SYMBOLIC, printed.symbolic_rows(count > FEW), GRIDS),
        "Controllers of the first arena on a microcontroller": (printed.BOARD, printed.board_rows(policies), ""),
    }  # fmt: skip


def text(rows: list[list[str]], lines: list[str], beside: Beside) -> str:
    """The tables and what is to be said about them."""
    parts = [table(HEADINGS, rows), READING]
    if lines:
        parts.append("\n".join(f"- {line}" for line in lines))
    for title, (headings, own, told) in beside.items():
        parts += [f"### {title}", table(headings, own), *([told] if told else [])]
    return "\n\n".join(parts)


def _without_nan(value: object) -> object:
    """JSON has no NaN: null in its place."""
    if isinstance(value, dict):
        return {k: _without_nan(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def _progress(total: int) -> Iterator[Callable[[], None]]:
    """A progress bar on stderr where that is a terminal, else nothing."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "left", TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("arenas", total=total)
        yield lambda: bar.advance(task)


@dataclass(frozen=True)
class Loops:
    """Which loops `python -m benchmarks loop` runs: so many of the paper's arenas, `runs` each, at rate Hz with |w| <= w_max;
    policies: where trained ones are."""

    count: int = 500
    rate: float = 1000.0
    w_max: float = 0.3
    runs: int = 10
    peers: bool = False
    policies: Path = POLICIES


LOOPS = """
has none: arenas in which there is nothing to drive by, whose runs are not counted. good: no collision, never outside the
room, in the target at 9 s. Collisions are looked for at every step of the integrator, a millisecond apart, not at the
controllers' own samples. Symbolic control is given |u_i| <= 1.5, the filter, the policies and predictive control to the goal
1, with our tube 3; the others are not limited. Policies decide at 20 Hz, as they were trained to; predictive control too;
grids at their period.
""".strip()


def run_loop(asked: Loops, where: Where) -> bool:
    """`python -m benchmarks loop`. True when no run of ours failed."""
    from benchmarks.peers import cascade
    from benchmarks.suites import loop

    out, processes, begin = where.out, where.workers, time.perf_counter()
    wanted, outcomes = loop.jobs(asked.count, asked.rate, asked.w_max, asked.runs, asked.peers, asked.policies), []
    with _progress(len(wanted)) as advance:
        for outcome in spread(loop.run, wanted, processes, where.scheduler):
            outcomes.append(outcome)
            advance()
    outcomes.sort(key=lambda o: o.job.seed)
    rows, lines = loop.rows(outcomes), loop.lines(outcomes, time.perf_counter() - begin, processes)
    inert, told, kept = cascade.compare(asked.w_max, processes) if asked.peers else ([], [], True)
    second = f"{table(cascade.HEADINGS, inert)}\n\n" + "\n\n".join(told)
    worth = loop.worth(asked.policies) if asked.peers else []
    first = table(loop.HEADINGS, rows) + (f"\n\n{table(loop.WORTH, worth)}\n\n{LOOPS}" if worth else "")
    if where.as_json:
        document: dict[str, object] = {"rows": [dict(zip(loop.HEADINGS, r, strict=True)) for r in rows], "lines": lines}
        if asked.peers:
            document["order 2"] = {"rows": [dict(zip(cascade.HEADINGS, r, strict=True)) for r in inert], "lines": told}
        print(json.dumps(document, indent=2))
    else:
        print(first + "\n\n" + "\n".join(lines) + (f"\n\n{second}" if asked.peers else ""))
    if out is not None:
        head = f"## Closed loops\n\nMade by `{command()}`; {machine()}{versions() if asked.peers else ''}."
        record(out, "loop", f"{head}\n\n{first}\n\n" + "\n\n".join(lines))
        if asked.peers:
            record(out, "cascade", f"## Plants of order 2 beside a cascade\n\nMade by `{command()}`; {machine()}.\n\n{second}")
    return kept and all(r.good and r.kept for o in outcomes for r in o.runs.get("own", ()))
