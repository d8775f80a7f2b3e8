"""P9: sampled at `control.period`, from every start in the task's share of gamma(0), under every plant within the bounds of
[plant], the state stays in the tube.

Where every input acts at once, the proof evaluates the sharp sampling conditions (sampling/sampling_conditions.py) in exact
fractions, with rho = e^E rational (sampling/numbers.py). Candidates for rho are searched for in doubles. Else, and where these
conditions fail, the worst path is the proof (late_inputs.py). lemmas/sampling/ has the mathematics.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from stt_codegen.certify.certificate import Finding, PeriodProof
from stt_codegen.certify.limits import sufficient_norm
from stt_codegen.certify.sampled.failures import LongestProof, explain_period
from stt_codegen.certify.sampled.late_inputs import drive_words, prove_late_period
from stt_codegen.certify.sampled.lost_turns import LostTurn, lost_turn
from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.effort import require_effort
from stt_codegen.properties import Property
from stt_codegen.sampling import (
    Period,
    SampledLoop,
    exact_loop,
    inputs_where_proved,
    longest_proved_period,
    loop_of,
    needed_input,
    path_loop_of,
    prove_for_period,
)
from stt_codegen.sampling.path import longest_path_period
from stt_codegen.task import Task

# Shares by which the rho of an E from the search in doubles is raised, until the fractions agree.
RAISES = (Fraction(0), Fraction(1, 10**6), Fraction(1, 10**4), Fraction(1, 10**3))


# An overflow in a search is infinite, and proves nothing; what is returned was proved in fractions. So NumPy need not warn.
@np.errstate(all="ignore")
def certify_period(
    task: Task, design: RefinedDesign, edge_error: tuple[Fraction, ...], rate: Sequence[Fraction] = ()
) -> tuple[Finding, PeriodProof | None]:
    """Certify P9, and return its proof where it holds.

    The margin is in seconds: by how much a longer period is proved. edge_error, rate: bounds on the arithmetic's error of an edge
    and of its rate, by dimension.
    """
    exact, loop = exact_loop(task, design, edge_error, rate), loop_of(task, design, edge_error, rate)
    if (outside := _start_outside_share(task, design)) is not None:
        return outside, None
    evidence = _evidence(task, design, exact, loop)
    proof, margin = evidence.proof, evidence.margin
    if proof is None:
        failure = explain_period(task, loop, evidence.longest)
        axis = None if failure.axis is None else failure.axis + 1
        needed = needed_input(loop).tolist()
        sufficient = sufficient_norm(task, [Fraction(v) for v in needed]) if all(map(math.isfinite, needed)) else ()
        sufficient += () if evidence.longest is None else (("control.period", evidence.longest.seconds),)
        finding = Finding(Property.PERIOD, _statement(task), margin, Fraction(0), dimension=axis, advice=failure.hint)
        return replace(finding, problem=failure.problem, sufficient=sufficient, about=failure.about), None
    if (lost := lost_turn(task, design, proof)) is not None:
        return _lost_turn_finding(task, lost), None
    if (unseen := _guard_finding(task, design, exact, proof)) is not None:
        return unseen, None
    e = tuple((v - 1) / (v + 1) for v in proof.rho)
    symbol = "|e|" if task.order == 1 else "|e| of v + lambda x"
    statement = f"{_statement(task)}: {symbol} < {_bounds(e)}, |u| <= {_bounds(proof.u)}"
    return Finding(Property.PERIOD, statement, Fraction(str(below(max(margin, Fraction(0)), 3))), Fraction(0)), proof


class PeriodEvidence(NamedTuple):
    """The proof of a period, or None; by how many seconds a longer period is proved, negative without a proof.

    longest: the longest proved period, where there is no proof of the task's; None where none is proved, and for a velocity by
    differences, whose error is known for the task's own period alone.
    """

    proof: PeriodProof | None
    margin: Fraction
    longest: LongestProof | None = None


def _evidence(task: Task, design: RefinedDesign, exact: SampledLoop, loop: SampledLoop) -> PeriodEvidence:
    """Prove the period by the sharp conditions where inputs act at once; else, and where these fail, by the worst path."""
    sharp = None if task.has_late_input else _sharp_evidence(task, exact, loop)
    if sharp is not None and sharp.proof is not None:
        return sharp
    period, path_loop = task.sampling_period, path_loop_of(task, design, exact)
    proof = prove_late_period(task, path_loop, _rho_of_conditions(task, exact, loop))
    longest_period = longest_path_period(path_loop, period)
    margin = (longest_period or Fraction(0)) - period
    if proof is not None:
        return PeriodEvidence(proof, margin)
    if sharp is not None and (sharp.margin >= margin or task.uses_differences):
        return sharp
    longest = None if longest_period is None or task.uses_differences else LongestProof(longest_period)
    return PeriodEvidence(None, min(margin, -period / 1000), longest)


def _sharp_evidence(task: Task, exact: SampledLoop, loop: SampledLoop) -> PeriodEvidence:
    """Prove the period by the sharp conditions, for inputs that act at their samples."""
    longest_period = longest_proved_period("sharp", loop)
    margin = (Fraction(longest_period.seconds) if longest_period is not None else Fraction(0)) - task.sampling_period
    proof = prove_period(task, exact, loop, longest_period)
    if proof is None:
        # Where balls alone prove the period, which is no proof here, a small negative margin is stated.
        longest = None
        if longest_period is not None and not task.uses_differences:
            longest = LongestProof(Fraction(longest_period.seconds), longest_period.bottleneck)
        return PeriodEvidence(None, min(margin, -task.sampling_period / 1000), longest)
    return PeriodEvidence(proof, margin)


def _rho_of_conditions(task: Task, exact: SampledLoop, loop: SampledLoop) -> tuple[Fraction, ...] | None:
    """Return the rho of the sharp conditions where nothing but latency is late, which they prove under another assumption."""
    if not all(bounds.acts_at_once for bounds in task.drive_bounds):
        return None
    proof = prove_period(task, exact, loop, longest_proved_period("sharp", loop))
    return None if proof is None else proof.rho


def _start_outside_share(task: Task, design: RefinedDesign) -> Finding | None:
    """Return the finding that initial_state is outside the share of gamma(0); None where it is inside."""
    share, edges = task.initial_set.share, design.bezier()[0, :, :, 0]
    ends = [(int(a) * design.unit, int(b) * design.unit) for a, b in edges]
    distance = [abs(x - (a + b) / 2) - share * (b - a) / 2 for x, (a, b) in zip(task.initial_state, ends, strict=True)]
    i = distance.index(max(distance))
    if distance[i] <= 0:
        return None
    needed = above(max(abs(2 * x - a - b) / (b - a) for x, (a, b) in zip(task.initial_state, ends, strict=True)), 4)
    larger = f", or raise initial_set.share to {needed:g}" if needed < min(task.e_max) else ""
    statement = f"initial_state within {decimal(share)} of gamma(0)'s half widths"
    at_start, advice = (Fraction(0), Fraction(0)), f"move initial_state inwards{larger}"
    problem = f"initial_state is outside the starts that sampling is proved for: {statement}, and in {task.axis_words[i]} it is "
    problem += f"{above(distance[i], 3):g} beyond"
    return Finding(
        Property.PERIOD, statement, -distance[i], Fraction(0), at_start, dimension=i + 1, advice=advice, problem=problem
    )


def _guard_finding(task: Task, design: RefinedDesign, exact: SampledLoop, proof: PeriodProof) -> Finding | None:
    """Return the finding that a guard may act on a state in the tube, as a measured one may be outside; None where it may not.

    The state is W/(1 + rho) away from the edges at least, and what is measured of that is wrong by `shift`. Of order 2, y = x - L
    has y' = b - lambda y for the distance b of v + lambda x, so y is never below the smaller one of its start and b/lambda.
    """
    if task.control.outside == "return":
        return None
    for i, (rho, shift) in enumerate(zip(proof.rho, proof.shift, strict=True)):
        nearest = min(Fraction(v) for v in exact.windows.narrow[:, i].tolist()) / (1 + rho)
        if task.order == 2:
            low, high = design.bezier()[0, i, :, 0]
            nearest = min(nearest, design.filter[i] * (1 - proof.share) / 2 * int(high - low) * design.unit)
        if nearest <= shift:
            name, option = task.axis_words[i], f'control.outside = "{task.control.outside}"'
            problem = f"{name} is measured to {above(shift, 3):g}, and may be {below(nearest, 3):g} from an edge"
            problem = f"{problem}: {option} would act inside the tube"
            advice = 'state less noise, or use control.outside = "return"'
            time, margin = (Fraction(0), task.prescribed_time), nearest - shift
            return Finding(
                Property.PERIOD, _statement(task), margin, Fraction(0), time, dimension=i + 1, advice=advice, problem=problem
            )
    return None


def _lost_turn_finding(task: Task, lost: LostTurn) -> Finding:
    """Return the finding that x may move so far between samples that a turn is miscounted."""
    name = task.axis_words[lost.axis]
    statement = f"x is on a known turn of {name}: it moves by at most {above(lost.motion, 4):g} from sample to sample"
    moved, allowed = f"{above(lost.motion, 4):g}", f"{below(lost.allowed, 4):g}"
    problem = f"{name} may move by {moved} from sample to sample, and only less than {allowed} tells its turns apart"
    advice = "lower control.period, or control.u_max there"
    time, margin = (Fraction(0), task.prescribed_time), lost.allowed - lost.motion
    return Finding(Property.PERIOD, statement, margin, Fraction(0), time, dimension=lost.axis + 1, advice=advice, problem=problem)


def prove_period(task: Task, exact: SampledLoop, loop: SampledLoop, longest_period: Period | None) -> PeriodProof | None:
    """Prove the task's period in fractions (`exact`) with the smallest E from the search in doubles (`loop`).

    Near the longest period only the E of the longest period may be enough. None where no E is proved.
    """
    period, latency = task.sampling_period, task.control.latency
    age = period + latency
    candidates = [prove_for_period("sharp", loop, float(age))]
    candidates += [longest_period] if longest_period and longest_period.seconds >= age else []
    for candidate, raised in itertools.product((p for p in candidates if p is not None), RAISES):
        require_effort()
        wanted = [Fraction(str(above(Fraction(math.exp(v)) * (1 + raised), 9))) for v in candidate.eps_bound]
        rho = tuple(map(min, wanted, exact.law.eps_at_clamp.tolist()))
        u = inputs_where_proved(exact, rho, age)
        if u is not None:
            return PeriodProof(
                period=period, latency=latency, share=task.initial_set.share, rho=rho, u=u, shift=tuple(exact.law.shift.tolist())
            )
    return None


def _bounds(values: tuple[Fraction, ...]) -> str:
    return by_component([_bound(v) for v in values])


def _bound(value: Fraction) -> float:
    """Round up to four digits, or to as many as keep a value below 1 below 1."""
    digits = (k for k in range(4, 17) if value >= 1 or above(value, k) < 1)
    return above(value, next(digits, 4))


def _statement(task: Task) -> str:
    """Return what P9 states for this task, in words: the period, the starts and the plants."""
    control = task.control
    assert control.period is not None
    stated = task.plant_bounds
    force, g_min, g_max, cross = (by_component([getattr(b, k) for b in stated]) for k in ("force", "g_min", "g_max", "cross"))
    g_ii = "g_ii" if task.gain[0] > 0 else "-g_ii"
    g = f"{g_ii} = {g_min}" if g_min == g_max else f"{g_min} <= {g_ii} <= {g_max}"
    assumed = " (assumed, as [plant] states no bounds)" if task.assumes_plant else ""
    bounds = [f"|f + w| <= {force}", g, f"|g_ij| <= {cross}{assumed}"]
    bounds += [f"x measured to {by_component(task.noise)}"] if any(task.noise) else []
    bounds += drive_words(task)
    starts = f"|e(0)| <= {decimal(task.initial_set.share)}"
    if task.order == 2:
        at_most = by_component(task.start_speed)
        starts += f" and |v(0)| <= {at_most}" if any(task.start_speed) else " at rest"
        bounds += [f"v measured to {by_component(task.noise_v)}"] if any(task.noise_v) else []
    if task.has_chosen_limit and task.u_max is not None:
        norm = task.control.u_norm
        reason = "" if norm is None else f" so that its Euclidean norm is at most {decimal(norm)}"
        bounds += [f"u limited to {by_component(task.u_max)}, which was chosen{reason}"]
    often = "s or faster"
    if task.uses_differences:
        often = f"s or faster, but not below {decimal(task.shortest_period)} s, with v = (x - x before) / time between"
    at = "at ticks, every" if task.emit.scalar == "fixed" else "every"
    return f"sampled {at} {decimal(control.period)} {often}, from every start with {starts}, for {', '.join(bounds)}"
