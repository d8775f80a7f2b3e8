"""Run the suites `arenas` and `loop` of `python -m benchmarks`: choose the jobs, show progress, print and record the tables.

benchmarks/command_line.py has the options and calls this; arenas.py and loop.py do the work.
"""

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

from benchmarks.peers.in_loops import POLICIES, SLOW_PEER_ARENAS
from benchmarks.suites.arenas import (
    HEADINGS,
    USUAL_PARTS,
    ArenaJob,
    ArenaPart,
    ArenaResult,
    Summary,
    failure_lines,
    run_arena,
    run_jobs,
    run_peers,
    summarize,
    table_row,
)
from benchmarks.suites.families import FAMILIES
from benchmarks.suites.report import command, machine, record, table, versions
from stt_codegen.design_kinds import CAPABILITIES, DesignKind
from stt_codegen.errors import BadInput

DESIGNS: tuple[DesignKind, ...] = get_args(DesignKind)


@dataclass(frozen=True)
class Execution:
    """Where jobs run, and where tables go.

    processes: of this machine, 0 for one per core. scheduler: address of a Dask cluster instead. out: file for the tables.
    """

    processes: int = 0
    scheduler: str | None = None
    out: Path | None = None
    as_json: bool = False

    def __post_init__(self) -> None:
        if self.out is not None and not (self.out.parent.is_dir() and os.access(self.out.parent, os.W_OK)):
            raise BadInput(f"--record {self.out}: {self.out.parent} is no folder that can be written to")

    @property
    def workers(self) -> int:
        """Number of processes on this machine."""
        return self.processes or os.cpu_count() or 1

    def __str__(self) -> str:
        if self.scheduler:
            return f"a Dask cluster, {self.scheduler}"
        return f"{self.workers} process{'es' if self.workers > 1 else ''}"


@dataclass(frozen=True)
class ArenaOptions:
    """Which arenas are designed; None for the usual ones of RESULTS.md. demand: share of the feasible arenas to be certified."""

    family: list[str] | None = None
    design: list[str] | None = None
    count: int | None = None
    clearance: float | None = None
    min_width: float | None = None
    peers: bool = False
    demand: float = 0.0
    policies: Path = POLICIES


def run_arenas(options: ArenaOptions, execution: Execution) -> bool:
    """Run `python -m benchmarks arenas`. Return whether each part has the demanded share of certified arenas."""
    parts = parts_of(options)
    summaries = list(zip(parts, summaries_of(parts, execution), strict=True))
    rows = [table_row(part, s) for part, s in summaries]
    lines = [line for part, s in summaries for line in failure_lines(part, s)]
    peer_tables: PeerTables = {}
    if options.peers:
        paper_summaries = [s for part, s in summaries if _is_paper_part(part)]
        peer_tables = _peer_tables(options.count or 500, execution.workers, paper_summaries, options.policies)
    if execution.as_json:
        tables = {name: [dict(zip(heads, r, strict=True)) for r in cells] for name, (heads, cells, _) in peer_tables.items()}
        document = {"arenas": [asdict(s) for _, s in summaries], **tables}
        print(json.dumps(_without_nan(document), indent=2, allow_nan=False))
    else:
        print(report_text(rows, lines, peer_tables))
    if execution.out is not None:
        head = f"## Arenas\n\nMade by `{command()}` in {execution}; {machine()}{versions() if peer_tables else ''}."
        record(execution.out, "arenas", f"{head}\n\n{report_text(rows, lines, peer_tables)}")
    return all(s.certified_of_feasible >= options.demand * s.feasible for _, s in summaries)


def summaries_of(parts: Sequence[ArenaPart], execution: Execution) -> list[Summary]:
    """Run the jobs of all parts, and return a summary of each part."""
    jobs = [job for part in parts for job in part.jobs()]
    by_job: dict[ArenaJob, ArenaResult] = {}
    with _progress(len(jobs)) as advance:
        for result in run_jobs(run_arena, jobs, execution.workers, execution.scheduler):
            by_job[result.job] = result
            advance()
    return [summarize(by_job[job] for job in part.jobs()) for part in parts]


def parts_of(options: ArenaOptions) -> list[ArenaPart]:
    """Return the rows of the table. Raises BadInput for an unknown family or design."""
    family, design, count = options.family, options.design, options.count
    clearance, min_width = options.clearance, options.min_width
    for option, names, known in (("--family", family, tuple(FAMILIES)), ("--design", design, DESIGNS)):
        for name in names or ():
            if name not in known:
                raise BadInput(f"{option} {name}: is none of {', '.join(known)}")
    if family is None and design is None and clearance is None and min_width is None:
        parts = list(USUAL_PARTS)
    else:
        usual_counts = {p.family: p.count for p in reversed(USUAL_PARTS)}  # of the first row of each family
        parts = [
            ArenaPart(f, d, usual_counts[f], 0.03 if clearance is None else clearance, 0.05 if min_width is None else min_width)
            for f in family or FAMILIES
            for d in cast(Sequence[DesignKind], design or DESIGNS)
            if (FAMILIES[f].length is None and FAMILIES[f].shape == "cube") or CAPABILITIES[d].avoids_any_shape
        ]
    return [ArenaPart(p.family, p.design, min(p.count, count or p.count), p.clearance, p.min_width) for p in parts]


ARENA_NOTE = """
Two figures are median and 95 %. Times: processor time of one arena. speed: bound on the edges' speed over the least possible
(shortest route in the largest-component metric among unsafe sets grown by clearance + min_width/2, over t_c); slowest: of the
slowest tube found, which the shipped one exceeds for width (docs/design.md). Adaptive bounds on speed are proved, not sharp. A
corridor's slowest tube is not computed.
""".strip()
TABLE_I_NOTE = """
Printed: Das and Jagtap (2024), in MATLAB on an i7-11700, of what is not said. Measured: the same kind of arenas, not the
same ones; a peer's question is in the table below. A path of A* or RRT* is checked exactly, a policy by ten runs an arena,
symbolic control by its own fixed point, tubes by their certificates.
""".strip()
GRID_NOTE = """
A cell's byte is the number of its input. memory: the most that NumPy held. runs: from random states of the start's box, the
wind at a random corner in every period; states are looked at every millisecond.
""".strip()
STEP_NOTE = """
In closed loop at 1 kHz (xdot = u, {arenas:.0f} arenas, states checked at the samples) the barrier filter takes
{cbf_microseconds:.2g} us a step, arrives in {cbf_reaches:.0%} and collides in {cbf_collides:.0%}. The emitted C step of the
{certified:.0f} certified designs takes {own_microseconds:.2g} us (the filter {ratio:.2g} times as long), arrives in
{own_reaches:.0%} and collides in {own_collides:.0%}.
""".strip()


PeerTables = dict[str, tuple[tuple[str, ...], list[list[str]], str]]  # by title: headings, rows, note


def _is_paper_part(part: ArenaPart) -> bool:
    return part.family == "paper" and (part.clearance, part.min_width) == (0.03, 0.05)


def _peer_tables(count: int, processes: int, tubes: list[Summary], policies: Path) -> PeerTables:
    """Run the peers in `count` arenas, and return their tables. tubes: summaries of our designs in the paper's arenas."""
    from benchmarks.suites import printed

    outcomes, steps = run_peers(count, processes, policies)
    return {
        "Table I of the paper, printed and measured": (
            printed.TABLE_I,
            printed.table_i(outcomes, tubes, policies),
            f"{printed.feasibility_sentence(count)}\n\n{TABLE_I_NOTE}",
        ),
        "Peers, in the same run, on the paper's arenas": (
            printed.HEADINGS, printed.peer_rows(outcomes, policies), STEP_NOTE.format(**steps)
        ),
        "Policies, every run": (printed.RUNS, printed.policy_rows(outcomes, policies), ""),
        "Symbolic control, the first arena": (printed.SYMBOLIC, printed.symbolic_rows(count > SLOW_PEER_ARENAS), GRID_NOTE),
        "Controllers of the first arena on a microcontroller": (printed.BOARD, printed.board_rows(policies), ""),
    }  # fmt: skip


def report_text(rows: list[list[str]], lines: list[str], peer_tables: PeerTables) -> str:
    """Return the tables with their notes as Markdown."""
    parts = [table(HEADINGS, rows), ARENA_NOTE]
    if lines:
        parts.append("\n".join(f"- {line}" for line in lines))
    for title, (headings, cells, note) in peer_tables.items():
        parts += [f"### {title}", table(headings, cells), *([note] if note else [])]
    return "\n\n".join(parts)


def _without_nan(value: object) -> object:
    """Return a JSON document with null in place of NaN and infinity, which JSON does not have."""
    if isinstance(value, dict):
        return {k: _without_nan(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def _progress(total: int) -> Iterator[Callable[[], None]]:
    """Show a progress bar where stderr is a terminal; yield a function that advances it by one job."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "left", TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("arenas", total=total)
        yield lambda: bar.advance(task)


@dataclass(frozen=True)
class LoopOptions:
    """Which closed loops run: `runs` in each of `count` of the paper's arenas, at `rate` Hz, with |w| <= w_max.

    policies: folder of the trained ones.
    """

    count: int = 500
    rate: float = 1000.0
    w_max: float = 0.3
    runs: int = 10
    peers: bool = False
    policies: Path = POLICIES


LOOP_NOTE = """
has none: arenas for which the controller has no path or table; their runs are not counted. good: no collision, never outside the
state space, in the target at 9 s. Collisions are checked at every step of the integrator, a millisecond apart, not only at the
controllers' samples. Symbolic control has |u_i| <= 1.5; the filter, the policies and predictive control to the goal have 1, and
predictive control with our tube 3; the others have no limit. Policies and predictive control decide at 20 Hz, for which policies
were trained; grids decide at their period.
""".strip()


def run_loop(options: LoopOptions, execution: Execution) -> bool:
    """Run `python -m benchmarks loop`. Return whether no run of our controllers failed."""
    from benchmarks.peers import cascade
    from benchmarks.suites import loop

    out, begin, outcomes = execution.out, time.perf_counter(), []
    jobs = loop.loop_jobs(
        options.count, options.rate, options.w_max, options.runs, peers=options.peers, policies=options.policies
    )
    with _progress(len(jobs)) as advance:
        for outcome in run_jobs(loop.run_job, jobs, execution.workers, execution.scheduler):
            outcomes.append(outcome)
            advance()
    outcomes.sort(key=lambda o: o.job.seed)
    rows, lines = loop.table_rows(outcomes), loop.summary_lines(outcomes, time.perf_counter() - begin, execution.workers)
    order_two_rows, order_two_lines, order_two_kept = (
        cascade.compare(options.w_max, execution.workers) if options.peers else ([], [], True)
    )
    order_two = f"{table(cascade.HEADINGS, order_two_rows)}\n\n" + "\n\n".join(order_two_lines)
    strengths = loop.strengths(options.policies) if options.peers else []
    tables = table(loop.HEADINGS, rows)
    tables += f"\n\n{table(loop.STRENGTH_HEADINGS, strengths)}\n\n{LOOP_NOTE}" if strengths else ""
    if execution.as_json:
        document: dict[str, object] = {"rows": [dict(zip(loop.HEADINGS, r, strict=True)) for r in rows], "lines": lines}
        if options.peers:
            cells = [dict(zip(cascade.HEADINGS, r, strict=True)) for r in order_two_rows]
            document["order 2"] = {"rows": cells, "lines": order_two_lines}
        print(json.dumps(document, indent=2))
    else:
        print(tables + "\n\n" + "\n".join(lines) + (f"\n\n{order_two}" if options.peers else ""))
    if out is not None:
        head = f"## Closed loops\n\nMade by `{command()}`; {machine()}{versions() if options.peers else ''}."
        record(out, "loop", f"{head}\n\n{tables}\n\n" + "\n\n".join(lines))
        if options.peers:
            record(out, "cascade", f"## Plants of order 2 beside a cascade\n\nMade by `{command()}`; {machine()}.\n\n{order_two}")
    return order_two_kept and all(r.good and r.kept for o in outcomes for r in o.runs.get("own", ()))
