"""Design random arenas by the hundred: how many tubes are certified, how fast, how wide, how slow; literal, adaptive, refined.

benchmarks/suites/command.py calls this for `python -m benchmarks arenas`. Each arena is one job. It runs in this process, in
several processes, or on a Dask cluster, with the same result. Times are processor time of one job, imports not counted.
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

from benchmarks.suites.families import BOX, FAMILIES, arena_task, is_feasible
from benchmarks.suites.report import number
from stt_codegen.certify.certificate import Certificate
from stt_codegen.design_kinds import CAPABILITIES, DesignKind
from stt_codegen.errors import BadInput, MissingTool, NotCertified, SttError

WORKER_TIMEOUT = 30  # seconds until a cluster must have a worker
FLOOD_FILL_DIMENSIONS = (
    3  # up to which flood fill decides whether an arena is feasible; with more, every arena counts as feasible
)


@dataclass(frozen=True)
class ArenaJob:
    """One arena, by its family and seed, and how its tube is designed."""

    family: str
    seed: int
    design: DesignKind
    clearance: float = 0.03
    min_width: float = 0.05


@dataclass(frozen=True)
class ArenaResult:
    """The result of a job.

    design_seconds, certificate_seconds: processor time. smallest_width: of the tube, in units of the task. speed: bound on the
    edges' speed, over the smallest possible speed. slowest: the same of the slowest tube that the design finds (refined). reason:
    why it is not certified. failing: codes of the properties that do not hold.
    """

    job: ArenaJob
    is_feasible: bool
    certified: bool
    design_seconds: float
    certificate_seconds: float
    smallest_width: float = float("nan")
    speed: float = float("nan")
    slowest: float = float("nan")
    reason: str = ""
    failing: tuple[str, ...] = ()


def run_arena(job: ArenaJob) -> ArenaResult:
    """Design and certify one arena."""
    from stt_codegen.pipeline import build_program, certify, preferred_tube

    family = FAMILIES[job.family]
    _warm_up(job.design)
    task = arena_task(family, job.seed, job.clearance, job.min_width).with_options(job.design)
    distance = max(family.reach, job.clearance + job.min_width / 2)
    has_way = family.dimension > FLOOD_FILL_DIMENSIONS or (distance < BOX / 2 and is_feasible(family, job.seed, distance))
    begin = time.process_time()
    try:
        design = preferred_tube(task)
    except NotCertified as error:
        return ArenaResult(job, has_way, False, time.process_time() - begin, 0.0, reason=str(error))
    middle = time.process_time()
    certificate = certify(task, design, build_program(task, design))
    end = time.process_time()
    speed, slowest = _relative_speeds(job, certificate)
    return ArenaResult(
        job, has_way, certificate.holds, middle - begin, end - middle, float(certificate.minimum_width), speed, slowest,
        "" if certificate.holds else certificate.refusal(), tuple(sorted({f.code for f in certificate.failures})),
    )  # fmt: skip


@cache
def _warm_up(design: str) -> None:
    """Design one arena, so that imports and caches do not count as time of the first job."""
    from stt_codegen.pipeline import build_program, certify, preferred_tube

    task = arena_task(FAMILIES["paper"], 0).with_options(design)
    tube = preferred_tube(task)
    certify(task, tube, build_program(task, tube))


def _relative_speeds(job: ArenaJob, certificate: Certificate) -> tuple[float, float]:
    """Return the speed bounds of the certified tube and of the slowest tube, over the smallest possible speed.

    That is the length of the shortest route over t_c, in the largest-component metric, among unsafe sets grown by clearance +
    min_width / 2. NaN where a number is not known.
    """
    from stt_codegen.certify.exact import certify_refined
    from stt_codegen.design.arena import arena_of, starting_box
    from stt_codegen.design.refine import refine
    from stt_codegen.design.routes.shortest_route import find_corner_route

    task = arena_task(FAMILIES[job.family], job.seed, job.clearance, job.min_width)
    arena = arena_of(task)
    try:
        route = find_corner_route(arena, starting_box(arena), arena.min_widths)
    except NotCertified:  # a literal tube may exist where no route with the smallest width begins
        route = None
    if route is None:
        return float("nan"), float("nan")
    smallest_speed = route.length / arena.prescribed_time
    slowest = float("nan")
    if CAPABILITIES[job.design].offers_widths and certificate.holds and FAMILIES[job.family].length is None:
        slow = certify_refined(task, refine(task.changed(tube={"prefer": "slow"})), certificate.edge_error)
        slowest = float(max(slow.speed)) / smallest_speed
    return float(max(certificate.speed)) / smallest_speed, slowest


# ------------------------------------------------------------------------------------------------- execution


def run_jobs(work: Callable[[Any], Any], items: Sequence[Any], processes: int, scheduler: str | None) -> Iterator[Any]:
    """Yield `work(item)` of every item, in any order.

    It runs in this process (processes = 1), in several processes, or on the workers of the Dask cluster at the address
    `scheduler`, which must be able to import `work`. Raises BadInput, MissingTool or SttError where the cluster fails.
    """
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
    """Yield `work(item)` of every item, computed by a Dask cluster."""
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
            client.wait_for_workers(1, timeout=WORKER_TIMEOUT)
        except TimeoutError:
            raise BadInput(f"--scheduler {scheduler}: it has no worker, and none came within {WORKER_TIMEOUT} s") from None
        done: Any = distributed.as_completed(client.map(work, items, pure=False))  # type: ignore[no-untyped-call]
        for future in done:
            if future.status != "finished":  # an error of the work itself, a worker or the scheduler lost
                raise SttError(f"--scheduler {scheduler}: an arena was not finished there ({future.status}: {_cause(future)})")
            yield future.result()


def _cause(future: Any) -> str:
    try:
        return f"{future.exception(timeout=1)}"
    except Exception as error:  # the cluster may be lost, and then there is no other reason to give
        return str(error)


# ------------------------------------------------------------------------------------------------ tables


@dataclass(frozen=True)
class Summary:
    """A family and design in numbers: counts of arenas, times in ms, and by property how many tubes violate it."""

    family: str
    design: str
    arenas: int
    feasible: int
    certified: int
    certified_of_feasible: int
    design_ms: tuple[float, float]  # median, 95 %
    certificate_ms: tuple[float, float]
    both_ms: tuple[float, float]
    smallest_width: float
    speed: tuple[float, float]
    slowest: tuple[float, float]
    failing: dict[str, int]
    missed: tuple[tuple[int, str], ...]  # seed and reason, of the feasible ones


def summarize(results: Iterable[ArenaResult]) -> Summary:
    """Return counts and quantiles over the results of one family and design."""
    by_seed = sorted(results, key=lambda r: r.job.seed)
    certified = [r for r in by_seed if r.certified]

    def median_and_95(values: list[float]) -> tuple[float, float]:
        known = [v for v in values if np.isfinite(v)]
        return (float(np.median(known)), float(np.percentile(known, 95))) if known else (float("nan"), float("nan"))

    return Summary(
        family=by_seed[0].job.family,
        design=by_seed[0].job.design,
        arenas=len(by_seed),
        feasible=sum(r.is_feasible for r in by_seed),
        certified=len(certified),
        certified_of_feasible=sum(r.is_feasible for r in certified),
        design_ms=median_and_95([1e3 * r.design_seconds for r in by_seed]),
        certificate_ms=median_and_95([1e3 * r.certificate_seconds for r in certified]),
        both_ms=median_and_95([1e3 * (r.design_seconds + r.certificate_seconds) for r in certified]),
        smallest_width=median_and_95([r.smallest_width for r in certified])[0],
        speed=median_and_95([r.speed for r in certified]),
        slowest=median_and_95([r.slowest for r in certified]),
        failing=dict(Counter(code for r in by_seed for code in r.failing)),
        missed=tuple((r.job.seed, r.reason) for r in by_seed if r.is_feasible and not r.certified),
    )


@dataclass(frozen=True)
class ArenaPart:
    """One row of the table: the first `count` arenas of a family, and how their tubes are designed."""

    family: str
    design: DesignKind
    count: int
    clearance: float = 0.03
    min_width: float = 0.05

    def jobs(self) -> list[ArenaJob]:
        return [ArenaJob(self.family, seed, self.design, self.clearance, self.min_width) for seed in range(self.count)]

    @property
    def name(self) -> str:
        family = FAMILIES[self.family]
        options = "" if (self.clearance, self.min_width) == (0.03, 0.05) else f", {self.clearance}/{self.min_width}"
        shape = "" if family.shape == "cube" else f" {family.shape}s"
        sets = f"{family.count}{shape} of {family.size:g}" + (f", {family.length:g} long" if family.length else "")
        return f"{self.family} ({family.dimension}-D, {sets}{options})"


USUAL_PARTS = (
    ArenaPart("paper", "refined", 500),
    ArenaPart("paper", "refined", 500, 0.02, 0.04),
    ArenaPart("dense12", "refined", 200),
    ArenaPart("dense24", "refined", 200),
    ArenaPart("space3", "refined", 200),
    ArenaPart("space6", "refined", 100),
    ArenaPart("corridor", "refined", 3),
    ArenaPart("discs", "refined", 200),
    ArenaPart("balls", "refined", 100),
    ArenaPart("polygons", "refined", 200),
    ArenaPart("solids", "refined", 100),
    ArenaPart("paper", "adaptive", 500),
    ArenaPart("paper", "literal", 300),
)
HEADINGS = (
    "family", "design", "certified of feasible", "of all", "design ms", "certificate ms", "both ms", "least width",
    "speed / least", "slowest / least",
)  # fmt: skip


def table_row(part: ArenaPart, s: Summary) -> list[str]:
    """Return a summary as the cells of HEADINGS; two figures are median and 95 %."""

    def pair(values: tuple[float, float]) -> str:
        return f"{number(values[0])} / {number(values[1])}"

    return [
        part.name, s.design, f"{s.certified_of_feasible} of {s.feasible}", f"{s.certified} of {s.arenas}", pair(s.design_ms),
        pair(s.certificate_ms), pair(s.both_ms), number(s.smallest_width), pair(s.speed), pair(s.slowest),
    ]  # fmt: skip


def failure_lines(part: ArenaPart, s: Summary) -> list[str]:
    """Return lines about tubes that are not certified: the properties that fail, then the feasible arenas without a tube.

    The arenas are left out where no tube of the design is certified.
    """
    lines = []
    if s.failing:
        lines.append(f"{part.name}, {s.design}: fails " + ", ".join(f"{c} in {n}" for c, n in sorted(s.failing.items())))
    if s.certified:
        seeds: dict[str, list[str]] = {}
        for seed, reason in s.missed:
            seeds.setdefault(reason, []).append(str(seed))
        for reason, missed in seeds.items():
            lines.append(f"{part.name}, {s.design}: missed seed{'s' if len(missed) > 1 else ''} {', '.join(missed)}: {reason}")
    return lines


def run_peers(count: int, processes: int, policies: Path) -> tuple[dict[str, list[Any]], dict[str, float]]:
    """Return the outcomes of every peer on the paper's arenas, by name, and the times of the barrier filter's steps and ours."""
    from benchmarks.peers.barrier import step_times
    from benchmarks.peers.in_arenas import all_peers

    outcomes = {}
    for k, peer in enumerate(all_peers(policies)):
        items = [(k, seed, policies) for seed in range(min(count, peer.arena_limit or count))]
        # never in this process: a peer may start threads that do not end
        outcomes[peer.name] = list(run_jobs(run_peer, items, max(processes, 2), None))
    return outcomes, step_times(range(min(count, 100)))


def run_peer(item: tuple[int, int, Path]) -> Any:
    """Run a peer on one of the paper's arenas. item: index of the peer, seed of the arena, folder of policies."""
    from benchmarks.peers.in_arenas import all_peers

    return all_peers(item[2])[item[0]].run(FAMILIES["paper"], item[1])
