"""P9: sampled at `control.period`, from every start in the task's share of gamma(0), under every plant within the bounds of
[plant], the state stays in the tube.

The proof evaluates the sharp sampling conditions (sampling/sampling_conditions.py) in exact fractions, with rho = e^E rational
(sampling/numbers.py). Candidates for rho are searched for in doubles. lemmas/sampling/sampled.py has the mathematics.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Finding, PeriodProof
from stt_codegen.certify.sampled.lost_turns import lost_turn
from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.properties import Property
from stt_codegen.sampling import (
    WORTHWHILE_PERIOD_RATIO,
    Gains,
    Period,
    SampledLoop,
    choose_proved_gain,
    exact_loop,
    inputs_where_proved,
    longest_proved_period,
    loop_of,
    natural_gain,
    prove_for_period,
    rounded_gain,
)
from stt_codegen.task import Task

Array = npt.NDArray[np.float64]
# Above the rho of an E that was found in doubles, as shares of it, until the fractions agree.
TRIED = (Fraction(0), Fraction(1, 10**6), Fraction(1, 10**4), Fraction(1, 10**3))


# What overflows in a search is infinite, and proves nothing; what is said was shown in fractions. So NumPy need not warn.
@np.errstate(all="ignore")
def choose_gain(
    task: Task, design: RefinedDesign, edge_error: tuple[Fraction, ...], rate: Sequence[Fraction] = ()
) -> tuple[Fraction, ...]:
    """control.gain = "auto": the most room at the period. Where no gain is proved for it, that of the longest period, and the
    refusal says what would do."""
    setting = loop_of(task, design, edge_error, rate)
    shape = natural_gain(setting)
    age = float(task.sampling_period + task.control.latency)
    found = choose_proved_gain(setting, age, kinds=("sharp",)) or Gains(setting, shape, kinds=("sharp",)).longest
    gain = rounded_gain(shape) if found is None else found[0]
    return tuple(Fraction(f"{k:.12g}") for k in gain.tolist())


@np.errstate(all="ignore")
def certify_period(
    task: Task, design: RefinedDesign, edge_error: tuple[Fraction, ...], rate: Sequence[Fraction] = ()
) -> tuple[Finding, PeriodProof | None]:
    """P9, and what is proved with it. The margin is in seconds: by how much a longer period is proved."""
    loop, setting = exact_loop(task, design, edge_error, rate), loop_of(task, design, edge_error, rate)
    outside = _outside(task, design)
    if outside is not None:
        i, lack, share = outside
        raised = f", or raise initial_set.share to {share:g}" if share < min(task.e_max) else ""
        advice = f"move initial_state inwards{raised}"
        text = f"initial_state within {decimal(task.initial_set.share)} of gamma(0)'s half widths"
        return Finding(Property.PERIOD, text, -lack, Fraction(0), (Fraction(0), Fraction(0)), i + 1, None, advice), None
    age = task.sampling_period + task.control.latency
    most = longest_proved_period("sharp", setting)
    spare = (Fraction(most.seconds) if most is not None else Fraction(0)) - age
    found = prove_period(task, loop, setting, most)
    if found is None:
        lack = min(spare, -age / 1000)  # where the balls alone prove the period, which is no proof here, some lack is told
        return Finding(Property.PERIOD, _told(task), lack, Fraction(0), advice=_advice(task, setting, age)), None
    if (lost := lost_turn(task, design, found)) is not None:
        name, (i, moves, allowed) = task.axis_words[lost.axis], lost
        text = f"x is on a known turn of {name}: it moves by at most {above(moves, 4):g} from sample to sample"
        advice = f"only less than {below(allowed, 4):g} tells turns of {name} apart; lower control.period, or control.u_max there"
        return Finding(
            Property.PERIOD, text, allowed - moves, Fraction(0), (Fraction(0), task.prescribed_time), i + 1, advice=advice
        ), None
    e = tuple((v - 1) / (v + 1) for v in found.rho)
    of = "|e|" if task.order == 1 else "|e| of v + lambda x"
    text = f"{_told(task)}: {of} < {_bounds(e)}, |u| <= {_bounds(found.u)}"
    return Finding(Property.PERIOD, text, Fraction(str(below(max(spare, Fraction(0)), 3))), Fraction(0)), found


def _outside(task: Task, design: RefinedDesign) -> tuple[int, Fraction, float] | None:
    """The component in which initial_state is farthest outside the share, by how much (a length), and the share that has it; None
    where it is inside."""
    share, edges = task.initial_set.share, design.bezier()[0, :, :, 0]
    ends = [(int(a) * design.unit, int(b) * design.unit) for a, b in edges]
    lack = [abs(x - (a + b) / 2) - share * (b - a) / 2 for x, (a, b) in zip(task.initial_state, ends, strict=True)]
    i = lack.index(max(lack))
    needed = max(abs(2 * x - a - b) / (b - a) for x, (a, b) in zip(task.initial_state, ends, strict=True))
    return (i, lack[i], above(needed, 4)) if lack[i] > 0 else None


def prove_period(task: Task, loop: SampledLoop, setting: SampledLoop, longest_period: Period | None) -> PeriodProof | None:
    """What is proved in fractions (`loop`) with the least E that is found for the period in doubles (`setting`); near the longest
    period only with that of the longest."""
    period, latency = task.sampling_period, task.control.latency
    age = period + latency
    tried = [
        prove_for_period("sharp", setting, float(age)),
        longest_period if longest_period and longest_period.seconds >= age else None,
    ]
    for candidate, more in itertools.product((p for p in tried if p is not None), TRIED):
        reached = [Fraction(str(above(Fraction(math.exp(v)) * (1 + more), 9))) for v in candidate.eps_bound]
        rho = tuple(map(min, reached, loop.law.eps_at_clamp.tolist()))
        u = inputs_where_proved(loop, rho, age)
        if u is not None:
            return PeriodProof(period, latency, task.initial_set.share, rho, u, tuple(loop.law.shift.tolist()))
    return None


def _bounds(values: tuple[Fraction, ...]) -> str:
    return by_component([above(v, 4) for v in values])


def _told(task: Task) -> str:
    plant, control = task.plant, task.control
    assert control.period is not None
    stated = task.plant_bounds
    force, g_min, g_max, cross = (by_component([getattr(b, k) for b in stated]) for k in ("force", "g_min", "g_max", "cross"))
    g_ii = "g_ii" if task.gain[0] > 0 else "-g_ii"
    g = f"{g_ii} = {g_min}" if g_min == g_max else f"{g_min} <= {g_ii} <= {g_max}"
    told = [f"|f + w| <= {force}", g, f"|g_ij| <= {cross}"]
    told += [f"x measured to {decimal(plant.noise)}"] if plant.noise else []
    told += [f"u {decimal(control.latency)} s after its sample at most, the first at once"] if control.latency else []
    starts = f"|e(0)| <= {decimal(task.initial_set.share)}"
    if task.order == 2:
        at_most = by_component(task.start_speed)
        starts += f" and |v(0)| <= {at_most}" if any(task.start_speed) else " at rest"
        told += [f"v measured to {decimal(plant.noise_v)}"] if plant.noise_v else []
    often = "s or faster"
    if task.uses_differences:
        often = f"s or faster, but not below {decimal(task.shortest_period)} s, with v = (x - x before) / time between"
    at = "at ticks, every" if task.emit.scalar == "fixed" else "every"
    return f"sampled {at} {decimal(control.period)} {often}, from every start with {starts}, for {', '.join(told)}"


def _advice(task: Task, setting: SampledLoop, age: Fraction) -> str:
    """Which gain, period or limit would do, as a task file has them: with the sign of the task's gain."""
    if task.uses_differences:
        why = "the error of a velocity by differences grows with it, what noise adds falls"
        return f"use another control.period ({why}), state less noise, or measure the velocity"
    gains, latency = Gains(setting, natural_gain(setting), kinds=("sharp",)), float(task.control.latency)
    sign = 1 if task.gain[0] > 0 else -1

    def shown(gain: Array) -> str:
        return by_component((sign * gain).tolist())

    best = choose_proved_gain(setting, float(age), kinds=("sharp",))
    if best is not None:
        return f'use control.gain = "auto" (here {shown(best[0])})' if sign > 0 else f"use control.gain = {shown(best[0])}"
    told = []
    if gains.longest is not None and gains.longest[1].seconds > latency:
        told.append(f"control.period = {_below(gains.longest[1].seconds - latency):g} with gain {shown(gains.longest[0])}")
    limited = gains.limited
    if limited is not None and limited[2].seconds > max(
        WORTHWHILE_PERIOD_RATIO * (gains.longest[1].seconds if gains.longest else 0.0), latency
    ):
        seconds = min(_below(limited[2].seconds - latency), float(age) - latency)
        u_max = by_component(limited[0].tolist())
        told.append(f"control.u_max = {u_max} and control.period = {seconds:.6g} with gain {shown(limited[1])}")
    nothing = "no gain is proved for any period: widen or slow the tube, or state a milder plant"
    return f"use {', or '.join(told)}" if told else nothing


def _below(seconds: float) -> float:
    return below(Fraction(seconds), 3)
