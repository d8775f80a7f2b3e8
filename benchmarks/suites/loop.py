"""Simulate closed loops: the emitted C drives xdot = u + w through the paper's random arenas, with ten disturbances each.

benchmarks/suites/command.py calls this for `python -m benchmarks loop`. In every certified arena the controller has the gain of
the longest proved sampling period. Its runs have samples at a given rate, |w| <= w_max, and starts in the start share, every
second one in a corner. The peers (benchmarks/peers/in_loops.py) drive the same runs. Longer periods show when tubes are left. One
arena is one job, as in the arenas benchmark.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.peers.driven import seconds_a_step
from benchmarks.peers.in_loops import DISTURBANCES, POLICIES, LoopArena, all_contenders
from benchmarks.peers.policy import DECISIONS_PER_SECOND
from benchmarks.suites.families import FAMILIES, arena_task
from benchmarks.suites.report import number
from stt_codegen.errors import NotCertified
from stt_codegen.loop.command import with_disturbance_bound, with_gain
from stt_codegen.loop.simulate import Loop, Run, Scenario, random_start
from stt_codegen.pipeline import EmittedController, build_program, certify, preferred_tube
from stt_codegen.plants import PLANTS
from stt_codegen.report.analysis import Analysis
from stt_codegen.task.task import Task

Array = npt.NDArray[Any]
PERIOD_FACTORS = (1, 2, 3, 4, 6, 8, 16)  # times the proved period


@dataclass(frozen=True)
class LoopJob:
    """The runs of one arena.

    rate: samples a second. w_max: bound on |w|. peers, with_longer_periods: whether peers and PERIOD_FACTORS are run, too.
    policies: the folder of trained policies.
    """

    seed: int
    rate: float = 1000.0
    w_max: float = 0.3
    runs: int = 10
    peers: bool = False
    with_longer_periods: bool = False
    policies: Path = POLICIES


@dataclass(frozen=True)
class LoopOutcome:
    """The result of one job.

    runs: by controller; "own" is ours, and a peer without a path in this arena has no runs. period: proved, seconds. left_tube:
    for each of PERIOD_FACTORS, whether some run left the tube. exceeding_runs: number of our runs, at the rate and at the proved
    period, in which |e| or |u| exceeded its proved bound. reason: why there is no tube. steps: seconds a step, by controller.
    """

    job: LoopJob
    runs: dict[str, tuple[Run, ...]]
    gain: float = float("nan")
    period: float = float("nan")
    left_tube: tuple[bool, ...] = ()
    exceeding_runs: int = 0
    reason: str = ""
    steps: dict[str, float] = field(default_factory=dict)


def run_job(job: LoopJob) -> LoopOutcome:
    """Design and certify the tube of one arena, choose its gain, compile the controller, and run all loops."""
    task = arena_task(FAMILIES["paper"], job.seed)
    plant = with_disturbance_bound(PLANTS["integrator"], job.w_max)
    try:
        controller = certified_tube(task)
    except NotCertified as error:
        return LoopOutcome(job, {}, reason=str(error))
    gains = Analysis(controller, plant).gains
    best = gains.with_longest_period
    if best is None:
        return LoopOutcome(job, {}, reason="no gain is proved at any period")
    gain, period = best.gain.tolist(), best.period
    controller = with_gain(controller, gain)
    loop = Loop(controller, plant)
    scenarios = scenarios_of(job, controller, float(task.initial_set.share))
    peer_runs, steps = _peer_runs(job, loop, scenarios)
    runs = {"own": tuple(map(loop.run, scenarios)), **peer_runs}
    bounded_runs = [r for s, r in zip(scenarios, runs["own"], strict=True) if s.age <= period.seconds]
    left_tube: tuple[bool, ...] = ()
    if job.with_longer_periods:
        slow_runs = [[loop.run(replace(s, rate=1 / (period.seconds * k))) for s in scenarios] for k in PERIOD_FACTORS]
        left_tube = tuple(any(not r.kept for r in runs_of_factor) for runs_of_factor in slow_runs)
        bounded_runs += slow_runs[PERIOD_FACTORS.index(1)]
    exceeding_runs = sum(
        any(a >= b for a, b in (*zip(r.e, period.e, strict=True), *zip(r.u, period.u, strict=True))) for r in bounded_runs
    )
    return LoopOutcome(job, runs, gain[0], period.seconds, left_tube, exceeding_runs, steps=steps)


def certified_tube(task: Task) -> EmittedController:
    """Return the controller of an arena, without files: these need the gain. Raises NotCertified."""
    design = preferred_tube(task)
    program = build_program(task, design)
    certificate = certify(task, design, program)
    if not certificate.holds:
        raise NotCertified(certificate.refusal())
    return EmittedController(task, design, program, certificate, {})


def scenarios_of(job: LoopJob, controller: EmittedController, e: float) -> tuple[Scenario, ...]:
    """Return the runs of an arena.

    The first begins at the task's initial state, the others where |e| is at most the bound `e`, every second one at a corner.
    """
    scenarios = []
    for k in range(job.runs):
        kind = DISTURBANCES[k % len(DISTURBANCES)]
        start = random_start(controller.certificate.start, e, 1000 * job.seed + k, corner=k % 2 == 1) if k else None
        strength = 0.0 if kind == "none" else job.w_max
        scenarios.append(Scenario(rate=job.rate, disturbance=kind, strength=strength, seed=1000 * job.seed + k, start=start))
    return tuple(scenarios)


def _peer_runs(job: LoopJob, ours: Loop, scenarios: Sequence[Scenario]) -> tuple[dict[str, tuple[Run, ...]], dict[str, float]]:
    """Run the same scenarios with every peer. Return the runs, and seconds a step, by name."""
    if not job.peers:
        return {}, {}
    runs, steps = {}, {"own": seconds_a_step(ours.loaded, _undisturbed_states(ours, 1 / DECISIONS_PER_SECOND))}
    for contender in all_contenders(job.policies):
        if contender.arena_limit is not None and job.seed >= contender.arena_limit:
            continue
        ready = contender.prepare(LoopArena(job.seed, job.w_max, ours, scenarios))
        runs[contender.name] = () if ready is None else tuple(map(ready.loop.run, ready.scenarios))
        if ready is not None and ready.loop.loaded.advance is None:
            steps[contender.name] = seconds_a_step(ready.loop.loaded, _undisturbed_states(ours, contender.period))
    return runs, steps


def _undisturbed_states(ours: Loop, period: float) -> Array:
    """Return t and x of an undisturbed run of ours, (samples, 1 + n): each step is timed at these samples."""
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


def table_rows(outcomes: Iterable[LoopOutcome]) -> list[list[str]]:
    """Return a row of HEADINGS for each controller.

    A run is good without a collision, inside the state space, with the target reached. Margin and input are medians over runs,
    the time is one over arenas.
    """
    by_name: dict[str, list[tuple[Run, ...]]] = {}
    steps: dict[str, list[float]] = {}
    tubes = {"own", *(c.name for c in all_contenders() if c.has_tube)}
    for o in outcomes:
        for name, runs in o.runs.items():
            by_name.setdefault(name, []).append(runs)
        for name, seconds in o.steps.items():
            steps.setdefault(name, []).append(seconds)
    rows = []
    for name, runs_by_arena in by_name.items():
        all_runs = [r for runs in runs_by_arena for r in runs]
        has_tube = name in tubes

        def share(count: int, of: int = len(all_runs)) -> str:
            return f"{100 * count / of:.1f} %" if of else "-"

        rows.append(
            [
                name, str(len(runs_by_arena)), str(sum(not runs for runs in runs_by_arena)), str(len(all_runs)),
                str(sum(r.hit is not None for r in all_runs)), str(sum(r.left_at is not None for r in all_runs)),
                str(sum(not r.kept for r in all_runs)) if has_tube else "-", share(sum(r.reached for r in all_runs)),
                share(sum(r.good for r in all_runs)), _median([r.margin for r in all_runs]) if has_tube else "-",
                _median([max(r.u) for r in all_runs]), _median([1e6 * v for v in steps.get(name, [])]),
            ]
        )  # fmt: skip
    return rows


def _median(values: Sequence[float]) -> str:
    return number(float(np.median(values))) if values else "-"


def strengths(policies: Path = POLICIES) -> list[list[str]]:
    """Return for each peer what it does better than our controller, and what it guarantees."""
    return [[c.name, c.advantages, c.guarantees] for c in all_contenders(policies)]


STRENGTH_HEADINGS = ("controller", "better than ours", "guarantees")


def summary_lines(outcomes: Sequence[LoopOutcome], seconds: float, processes: int) -> list[str]:
    """Return lines about gains, periods, arenas without a tube, and periods that are too long."""
    with_tube = [o for o in outcomes if o.runs.get("own")]
    lines = [
        f"{sum(len(o.runs['own']) for o in with_tube)} runs of our controller, designs, proofs and compiling included, in "
        f"{seconds:.0f} s on {processes} "
        f"process{'es' if processes > 1 else ''}.",
    ]
    if with_tube:
        periods = np.array([o.period for o in with_tube]) * 1e3  # ms
        proved_count = sum(o.period >= 1 / o.job.rate for o in with_tube)
        setting = f"{with_tube[0].job.rate:g} Hz and |w| <= {with_tube[0].job.w_max:g}"
        gains = f"{min(o.gain for o in with_tube):.2g} to {max(o.gain for o in with_tube):.2g}"
        lines.append(
            f"Longest proved sampling period: {periods.min():.2f} ms at least, {np.median(periods):.1f} ms in the "
            f"median; {proved_count} of {len(with_tube)} are proved at {setting}. Gains for it: {gains}."
        )
    exceeding_count = sum(o.exceeding_runs for o in with_tube)
    lines.append(f"Runs at the rate or at the proved period in which |e| or |u| passed its bound: {exceeding_count}.")
    left_tubes = [o.left_tube for o in with_tube if o.left_tube]
    if left_tubes:
        shares = (f"{100 * float(np.mean([left[k] for left in left_tubes])):.0f} % at {v}" for k, v in enumerate(PERIOD_FACTORS))
        lines.append(f"Of {len(left_tubes)} arenas, share in which some run leaves its tube, by multiples of the proved period:")
        lines.append(", ".join(shares) + ".")
    for o in outcomes:
        if o.reason:
            lines.append(f"Arena {o.job.seed}: {o.reason}")
        failures = [r for r in o.runs.get("own", ()) if not (r.good and r.kept)]
        lines += [f"Arena {o.job.seed}, gain {o.gain:g}, proved to {1e3 * o.period:.3g} ms: {r}" for r in failures]
    return lines


def loop_jobs(count: int, rate: float, w_max: float, runs: int, *, peers: bool, policies: Path = POLICIES) -> list[LoopJob]:
    """Return the jobs of the first `count` arenas; the first hundred have longer periods, too."""
    return [LoopJob(seed, rate, w_max, runs, peers, seed < 100, policies) for seed in range(count)]
