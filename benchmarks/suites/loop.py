"""Monte Carlo of closed loops: the C that ships drives xdot = u + w through the paper's random arenas, ten disturbances each.

For every certified arena: the gain of the longest proved sampling period, its C compiled, ten runs at the
rate with |w| <= w_max from the whole share of gamma(0) that is proved, every second one from a corner. With peers, in the same
loops and runs: all of `contenders`. And periods beyond the proved one, to see where tubes are left. One arena is one job, in this
process, in processes or on a Dask cluster, as in the arenas benchmark.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.peers.driven import seconds_a_step
from benchmarks.peers.in_loops import DISTURBANCES, POLICIES, Ground, contenders
from benchmarks.peers.policy import HERTZ
from benchmarks.suites.families import FAMILIES, arena_task
from benchmarks.suites.report import number
from stt_codegen.errors import NotCertified
from stt_codegen.loop.command import with_disturbance_bound, with_gain
from stt_codegen.loop.simulate import Loop, Run, Scenario, random_start
from stt_codegen.pipeline import EmittedController, build_program, certify, design_tube
from stt_codegen.plants import PLANTS
from stt_codegen.report.analysis import Analysis
from stt_codegen.task.task import Task

Array = npt.NDArray[Any]
LONGER = (1, 2, 3, 4, 6, 8, 16)  # times the proved period


@dataclass(frozen=True)
class Job:
    """One arena. rate in Hz; w_max: bound on |w|; peers, longer: whether these are run too; policies: the folder of trained
    ones."""

    seed: int
    rate: float = 1000.0
    w_max: float = 0.3
    runs: int = 10
    peers: bool = False
    longer: bool = False
    policies: Path = POLICIES


@dataclass(frozen=True)
class Outcome:
    """Of one job: runs by controller; gain and proved period; for every LONGER whether some run left the tube; beyond: our runs,
    at the rate and at the proved period, in which |e| or |u| passed its bound; why there is no tube; seconds a step by
    controller. A contender that has nothing to drive by in this arena has no runs."""

    job: Job
    runs: dict[str, tuple[Run, ...]]
    gain: float = float("nan")
    period: float = float("nan")
    left: tuple[bool, ...] = ()
    beyond: int = 0
    reason: str = ""
    steps: dict[str, float] = field(default_factory=dict)


def run(job: Job) -> Outcome:
    """Design, prove, compile and run one arena."""
    task = arena_task(FAMILIES["paper"], job.seed)
    plant = with_disturbance_bound(PLANTS["integrator"], job.w_max)
    try:
        controller = _tube_of(task)
    except NotCertified as error:
        return Outcome(job, {}, reason=str(error))
    gains = Analysis(controller, plant).gains
    best = gains.longest
    if best is None:
        return Outcome(job, {}, reason="no gain is proved at any period")
    gain, period = best[0].tolist(), best[1]
    controller = with_gain(controller, gain)
    loop = Loop(controller, plant)
    scenarios = scenarios_of(job, controller, float(task.initial_set.share))
    others, steps = _peers(job, loop, scenarios)
    runs = {"own": tuple(map(loop.run, scenarios)), **others}
    bound = [r for s, r in zip(scenarios, runs["own"], strict=True) if s.age <= period.seconds]
    left: tuple[bool, ...] = ()
    if job.longer:
        slow = [[loop.run(replace(s, rate=1 / (period.seconds * times))) for s in scenarios] for times in LONGER]
        left = tuple(any(not r.kept for r in several) for several in slow)
        bound += slow[LONGER.index(1)]
    beyond = sum(any(a >= b for a, b in (*zip(r.e, period.e, strict=True), *zip(r.u, period.u, strict=True))) for r in bound)
    return Outcome(job, runs, gain[0], period.seconds, left, beyond, steps=steps)


def _tube_of(task: Task) -> EmittedController:
    """The certified tube of an arena; its files are made once the gain is known."""
    design = design_tube(task)
    program = build_program(task, design)
    certificate = certify(task, design, program)
    if not certificate.holds:
        raise NotCertified(certificate.refusal())
    return EmittedController(task, design, program, certificate, {})


def scenarios_of(job: Job, controller: EmittedController, e: float) -> tuple[Scenario, ...]:
    """The runs of an arena: the first from the task's own start, the others from starts with |e| up to a bound, every second one
    from a corner of them."""
    found = []
    for k in range(job.runs):
        kind = DISTURBANCES[k % len(DISTURBANCES)]
        start = random_start(controller.certificate.start, e, 1000 * job.seed + k, corner=k % 2 == 1) if k else None
        strength = 0.0 if kind == "none" else job.w_max
        found.append(Scenario(rate=job.rate, disturbance=kind, strength=strength, seed=1000 * job.seed + k, start=start))
    return tuple(found)


def _peers(job: Job, ours: Loop, scenarios: Sequence[Scenario]) -> tuple[dict[str, tuple[Run, ...]], dict[str, float]]:
    """The same scenarios for everyone of `contenders`, and how long a step of each takes."""
    if not job.peers:
        return {}, {}
    runs, steps = {}, {"own": seconds_a_step(ours.loaded, _way_of(ours, 1 / HERTZ))}
    for contender in contenders(job.policies):
        if contender.first is not None and job.seed >= contender.first:
            continue
        ready = contender.make(Ground(job.seed, job.w_max, ours, scenarios))
        runs[contender.name] = () if ready is None else tuple(map(ready[0].run, ready[1]))
        if ready is not None and ready[0].loaded.advance is None:
            steps[contender.name] = seconds_a_step(ready[0].loaded, _way_of(ours, contender.period))
    return runs, steps


def _way_of(ours: Loop, period: float) -> Array:
    """t and x of an undisturbed run of ours, so far apart that everybody decides at each: what a step is timed at."""
    trace = ours.run(Scenario(rate=1 / period), trace=True).trace
    assert trace is not None
    return np.asarray(trace[:-1, : 1 + ours.controller.task.dimension])


# ------------------------------------------------------------------------------------------------ tables

HEADINGS = (
    "controller",
    "arenas",
    "has none",
    "runs",
    "collisions",
    "state space left",
    "tube left",
    "target reached",
    "good",
    "least margin",
    "largest u",
    "us a step",
)


def rows(outcomes: Iterable[Outcome]) -> list[list[str]]:
    """One row a controller: how many runs failed in which way; good: no collision, never outside, the target reached.
    Medians over the runs, of the time over the arenas."""
    by_name: dict[str, list[tuple[Run, ...]]] = {}
    steps: dict[str, list[float]] = {}
    tubes = {"own", *(c.name for c in contenders() if c.tube)}
    for o in outcomes:
        for name, runs in o.runs.items():
            by_name.setdefault(name, []).append(runs)
        for name, seconds in o.steps.items():
            steps.setdefault(name, []).append(seconds)
    found = []
    for name, arenas in by_name.items():
        all_runs = [r for several in arenas for r in several]
        tube = name in tubes

        def share(count: int, of: int = len(all_runs)) -> str:
            return f"{100 * count / of:.1f} %" if of else "-"

        found.append(
            [
                name, str(len(arenas)), str(sum(not several for several in arenas)), str(len(all_runs)),
                str(sum(r.hit is not None for r in all_runs)), str(sum(r.left_at is not None for r in all_runs)),
                str(sum(not r.kept for r in all_runs)) if tube else "-", share(sum(r.reached for r in all_runs)),
                share(sum(r.good for r in all_runs)), _median([r.margin for r in all_runs]) if tube else "-",
                _median([max(r.u) for r in all_runs]), _median([1e6 * v for v in steps.get(name, [])]),
            ]
        )  # fmt: skip
    return found


def _median(values: Sequence[float]) -> str:
    return number(float(np.median(values))) if values else "-"


def worth(policies: Path = POLICIES) -> list[list[str]]:
    """What each does better than ours, and what it guarantees."""
    return [[c.name, c.better, c.guarantees] for c in contenders(policies)]


WORTH = ("controller", "better than ours", "guarantees")


def lines(outcomes: Sequence[Outcome], seconds: float, processes: int) -> list[str]:
    """What the table does not say: gains, periods, arenas without a tube, periods that are too long."""
    good = [o for o in outcomes if o.runs.get("own")]
    periods = np.array([o.period for o in good]) * 1e3
    ran = sum(len(o.runs["own"]) for o in good)
    found = [
        f"{ran} runs of our controller, designs, proofs and compiling included, in {seconds:.0f} s on {processes} "
        f"process{'es' if processes > 1 else ''}.",
    ]
    if good:
        enough = sum(o.period >= 1 / o.job.rate for o in good)
        asked = f"{good[0].job.rate:g} Hz and |w| <= {good[0].job.w_max:g}"
        gains = f"{min(o.gain for o in good):.2g} to {max(o.gain for o in good):.2g}"
        found.append(
            f"Longest proved sampling period: {periods.min():.2f} ms at least, {np.median(periods):.1f} ms in the "
            f"median; {enough} of {len(good)} are proved at {asked}. Gains for it: {gains}."
        )
    found.append(f"Runs at the rate or at the proved period in which |e| or |u| passed its bound: {sum(o.beyond for o in good)}.")
    longer = [o.left for o in good if o.left]
    if longer:
        shares = (f"{100 * float(np.mean([row[k] for row in longer])):.0f} % at {times}" for k, times in enumerate(LONGER))
        found.append(f"Of {len(longer)} arenas, share in which some run leaves its tube, by multiples of the proved period:")
        found.append(", ".join(shares) + ".")
    for o in outcomes:
        if o.reason:
            found.append(f"Arena {o.job.seed}: {o.reason}")
        bad = [r for r in o.runs.get("own", ()) if not (r.good and r.kept)]
        found += [f"Arena {o.job.seed}, gain {o.gain:g}, proved to {1e3 * o.period:.3g} ms: {r}" for r in bad]
    return found


def jobs(count: int, rate: float, w_max: float, runs: int, peers: bool, policies: Path = POLICIES) -> list[Job]:
    """Longer periods for the first hundred arenas; peers, where asked for, in all, but for those that take long."""
    return [Job(seed, rate, w_max, runs, peers, seed < 100, policies) for seed in range(count)]
