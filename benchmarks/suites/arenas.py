"""Random arenas by the hundred: how many tubes are certified, how fast, how wide, how slow; literal, adaptive, refined.

Each arena is one job, run in this process, in processes of this machine, or on a Dask cluster; the results do not depend
on where. Times are processor time of one job, imports and a first design not counted. Long because jobs, families and tables
are told together.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.suites.families import BOX, FAMILIES, arena_task, feasible
from benchmarks.suites.report import number
from stt_codegen.certify.certificate import Certificate
from stt_codegen.design_kinds import CAPABILITIES, DesignKind
from stt_codegen.errors import BadInput, MissingTool, NotCertified, SttError

WAIT = 30  # seconds for a first worker of a cluster
FLOODED = 3  # dimensions up to which feasibility is decided by flood fill; beyond, every arena counts as feasible


@dataclass(frozen=True)
class Job:
    """One arena, and what is asked of its tube."""

    family: str
    seed: int
    design: DesignKind
    clearance: float = 0.03
    min_width: float = 0.05


@dataclass(frozen=True)
class Result:
    """What came of a job. Seconds of processor time; least_width in units; speed: bound on the edges' speed over the least
    possible; slowest: the same for the slowest tube found (refined). `reason`: why it is not certified."""

    job: Job
    feasible: bool
    certified: bool
    design_seconds: float
    certificate_seconds: float
    least_width: float = float("nan")
    speed: float = float("nan")
    slowest: float = float("nan")
    reason: str = ""
    broken: tuple[str, ...] = ()


def run(job: Job) -> Result:
    """Design and certify one arena."""
    from stt_codegen.pipeline import build_program, certify, design_tube

    family = FAMILIES[job.family]
    _warm(job.design)
    task = arena_task(family, job.seed, job.clearance, job.min_width).with_options(job.design)
    reach = max(family.reach, job.clearance + job.min_width / 2)
    way = family.dimension > FLOODED or (reach < BOX / 2 and feasible(family, job.seed, reach))
    begin = time.process_time()
    try:
        design = design_tube(task)
    except NotCertified as error:
        return Result(job, way, False, time.process_time() - begin, 0.0, reason=str(error))
    middle = time.process_time()
    certificate = certify(task, design, build_program(task, design))
    end = time.process_time()
    speed, slowest = _speeds(job, certificate)
    return Result(
        job, way, certificate.holds, middle - begin, end - middle, float(certificate.minimum_width), speed, slowest,
        "" if certificate.holds else certificate.refusal(), tuple(sorted({f.code for f in certificate.failures})),
    )  # fmt: skip


@cache
def _warm(design: str) -> None:
    """Pay for imports and caches before the first time is taken."""
    from stt_codegen.pipeline import build_program, certify, design_tube

    task = arena_task(FAMILIES["paper"], 0).with_options(design)
    tube = design_tube(task)
    certify(task, tube, build_program(task, tube))


def _speeds(job: Job, certificate: Certificate) -> tuple[float, float]:
    """The shipped tube's speed bound and the slowest tube's, over the least possible: the shortest route in the
    largest-component metric among unsafe sets grown by clearance + min_width / 2, over t_c."""
    from stt_codegen.certify.exact import certify_refined
    from stt_codegen.design.arena import arena_of, starting_box
    from stt_codegen.design.refine import refine
    from stt_codegen.design.routes.shortest_route import find_corner_route

    task = arena_task(FAMILIES[job.family], job.seed, job.clearance, job.min_width)
    arena = arena_of(task)
    try:
        route = find_corner_route(arena, starting_box(arena), np.full(arena.dimension, arena.min_width))
    except NotCertified:  # a literal tube of an arena in which no other could start
        route = None
    if route is None:
        return float("nan"), float("nan")
    least = route.length / arena.prescribed_time
    slowest = float("nan")
    if CAPABILITIES[job.design].offers_widths and certificate.holds and FAMILIES[job.family].length is None:
        slow = certify_refined(task, refine(task.changed(tube={"prefer": "slow"})), certificate.edge_error)
        slowest = float(max(slow.speed)) / least
    return float(max(certificate.speed)) / least, slowest


# ------------------------------------------------------------------------------------------------- where


def spread(work: Callable[[Any], Any], items: Sequence[Any], processes: int, scheduler: str | None) -> Iterator[Any]:
    """`work` of every item, in any order: in this process (processes 1), in some of this machine, or on a Dask cluster.
    `work` must be importable there."""
    if scheduler is not None:
        yield from _on_cluster(work, items, scheduler)
    elif processes == 1:
        yield from map(work, items)
    else:
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NPROC"):
            os.environ.setdefault(name, "1")  # one thread each, read when a process starts: the processes are the parallelism
        # spawned, not forked: the solver's threads and a peer's runtime do not survive a fork
        with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
            yield from pool.map(work, items, chunksize=max(1, min(16, len(items) // (4 * processes))))


def _on_cluster(work: Callable[[Any], Any], items: Sequence[Any], scheduler: str) -> Iterator[Any]:
    try:
        import distributed
    except ImportError:
        raise MissingTool("--scheduler needs Dask: pip install 'stt-codegen[cluster]' here and on the workers") from None
    try:
        client: Any = distributed.Client(scheduler, timeout="10s")  # type: ignore[no-untyped-call]
    except (OSError, TimeoutError, ValueError) as error:
        raise BadInput(f"--scheduler {scheduler}: no Dask scheduler answers there ({error})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=WAIT)
        except TimeoutError:
            raise BadInput(f"--scheduler {scheduler}: it has no worker, and none came within {WAIT} s") from None
        done: Any = distributed.as_completed(client.map(work, items, pure=False))  # type: ignore[no-untyped-call]
        for future in done:
            if future.status != "finished":  # an error of the work itself, a worker or the scheduler lost
                raise SttError(f"--scheduler {scheduler}: an arena was not finished there ({future.status}: {_cause(future)})")
            yield future.result()


def _cause(future: Any) -> str:
    try:
        return f"{future.exception(timeout=1)}"
    except Exception as error:  # the cluster is gone: nothing more is to be had
        return str(error)


# ------------------------------------------------------------------------------------------------ tables


@dataclass(frozen=True)
class Summary:
    """A family and design in numbers; times in ms."""

    family: str
    design: str
    arenas: int
    feasible: int
    certified: int
    certified_of_feasible: int
    design_ms: tuple[float, float]  # median, 95 %
    certificate_ms: tuple[float, float]
    both_ms: tuple[float, float]
    least_width: float
    speed: tuple[float, float]
    slowest: tuple[float, float]
    broken: dict[str, int]
    missed: tuple[tuple[int, str], ...]  # seed and reason, of the feasible ones


def summary(results: Iterable[Result]) -> Summary:
    """Counts and quantiles over the results of one family and design."""
    found = sorted(results, key=lambda r: r.job.seed)
    good = [r for r in found if r.certified]

    def spread_of(values: list[float]) -> tuple[float, float]:
        known = [v for v in values if np.isfinite(v)]
        return (float(np.median(known)), float(np.percentile(known, 95))) if known else (float("nan"), float("nan"))

    return Summary(
        family=found[0].job.family,
        design=found[0].job.design,
        arenas=len(found),
        feasible=sum(r.feasible for r in found),
        certified=len(good),
        certified_of_feasible=sum(r.feasible for r in good),
        design_ms=spread_of([1e3 * r.design_seconds for r in found]),
        certificate_ms=spread_of([1e3 * r.certificate_seconds for r in good]),
        both_ms=spread_of([1e3 * (r.design_seconds + r.certificate_seconds) for r in good]),
        least_width=spread_of([r.least_width for r in good])[0],
        speed=spread_of([r.speed for r in good]),
        slowest=spread_of([r.slowest for r in good]),
        broken=dict(Counter(code for r in found for code in r.broken)),
        missed=tuple((r.job.seed, r.reason) for r in found if r.feasible and not r.certified),
    )


@dataclass(frozen=True)
class Part:
    """One row of the table: so many arenas of a family, designed so."""

    family: str
    design: DesignKind
    count: int
    clearance: float = 0.03
    min_width: float = 0.05

    def jobs(self) -> list[Job]:
        return [Job(self.family, seed, self.design, self.clearance, self.min_width) for seed in range(self.count)]

    @property
    def name(self) -> str:
        family = FAMILIES[self.family]
        options = "" if (self.clearance, self.min_width) == (0.03, 0.05) else f", {self.clearance}/{self.min_width}"
        shape = "" if family.shape == "cube" else f" {family.shape}s"
        sets = f"{family.count}{shape} of {family.size:g}" + (f", {family.length:g} long" if family.length else "")
        return f"{self.family} ({family.dimension}-D, {sets}{options})"


EVERYTHING = (
    Part("paper", "refined", 500),
    Part("paper", "refined", 500, 0.02, 0.04),
    Part("dense12", "refined", 200),
    Part("dense24", "refined", 200),
    Part("space3", "refined", 200),
    Part("space6", "refined", 100),
    Part("corridor", "refined", 3),
    Part("discs", "refined", 200),
    Part("balls", "refined", 100),
    Part("polygons", "refined", 200),
    Part("solids", "refined", 100),
    Part("paper", "adaptive", 500),
    Part("paper", "literal", 300),
)
HEADINGS = (
    "family", "design", "certified of feasible", "of all", "design ms", "certificate ms", "both ms", "least width",
    "speed / least", "slowest / least",
)  # fmt: skip


def row(part: Part, s: Summary) -> list[str]:
    """A summary as the cells of HEADINGS; two figures are median and 95 %."""

    def pair(values: tuple[float, float]) -> str:
        return f"{number(values[0])} / {number(values[1])}"

    return [
        part.name, s.design, f"{s.certified_of_feasible} of {s.feasible}", f"{s.certified} of {s.arenas}", pair(s.design_ms),
        pair(s.certificate_ms), pair(s.both_ms), number(s.least_width), pair(s.speed), pair(s.slowest),
    ]  # fmt: skip


def failures(part: Part, s: Summary) -> list[str]:
    """Lines on what is not certified: properties that fail, then every feasible arena missed, unless the design never holds."""
    lines = []
    if s.broken:
        lines.append(f"{part.name}, {s.design}: fails " + ", ".join(f"{c} in {n}" for c, n in sorted(s.broken.items())))
    if s.certified:
        seeds: dict[str, list[str]] = {}
        for seed, reason in s.missed:
            seeds.setdefault(reason, []).append(str(seed))
        for reason, own in seeds.items():
            lines.append(f"{part.name}, {s.design}: missed seed{'s' if len(own) > 1 else ''} {', '.join(own)}: {reason}")
    return lines


def run_peers(count: int, processes: int, policies: Path) -> tuple[dict[str, list[Any]], dict[str, float]]:
    """Outcomes of every peer on the paper's arenas, by name, and the steps' times."""
    from benchmarks.peers.barrier import step_times
    from benchmarks.peers.in_arenas import all_peers

    found = {}
    for k, peer in enumerate(all_peers(policies)):
        items = [(k, seed, policies) for seed in range(min(count, peer.sample or count))]
        # never in this process: a peer's threads are not ours
        found[peer.name] = list(spread(ask_peer, items, max(processes, 2), None))
    return found, step_times(range(min(count, 100)))


def ask_peer(item: tuple[int, int, Path]) -> Any:
    """One peer on one of the paper's arenas."""
    from benchmarks.peers.in_arenas import all_peers

    return all_peers(item[2])[item[0]].run(FAMILIES["paper"], item[1])
