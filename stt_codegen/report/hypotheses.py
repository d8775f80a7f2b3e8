"""Say what the bounds of a closed loop assume, and whether each assumption holds for one controller and one plant.

report/analysis.py calls `closed_loop_hypotheses`. docs/paper.md has Theorem 4.1 and its assumptions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from stt_codegen.decimals import by_component, decimal
from stt_codegen.properties import Property
from stt_codegen.report.bounds import Hypothesis, UpdateFunctionBounds, round_down
from stt_codegen.report.loop_analysis import LoopAnalysis
from stt_codegen.report.plant_table import uncovered_bounds
from stt_codegen.sampling import continuous_input_bound, epsilon_star, epsilon_star_norm, holds_saturated, holds_scaled
from stt_codegen.task import Task


def closed_loop_hypotheses(analysis: LoopAnalysis) -> Iterator[Hypothesis]:
    """Yield what the bounds assume, and whether it holds: of the tube, the start, the plant, the clamp, limits and
    periods."""
    certificate = analysis.controller.certificate
    properties = f"{Property.WIDTH.code} to {Property.ARITHMETIC.code}"
    yield Hypothesis("tube", f"the certificate holds: {properties}", certificate.tube_holds)
    is_inside = bool(np.isfinite(analysis.sampled_loop.start).all())
    yield Hypothesis("start", f"starts strictly inside gamma(0): {analysis.starts}", is_inside)
    yield _gain_matrix_hypothesis(analysis)
    yield _clamp_hypothesis(analysis)
    yield from _saturation_hypothesis(analysis)
    yield from _tick_hypothesis(analysis)
    yield from _stated_plant_hypothesis(analysis)
    if analysis.tube_reading.update_function is not None:
        yield from _update_function_hypotheses(analysis.tube_reading.update_function)


def _gain_matrix_hypothesis(analysis: LoopAnalysis) -> Hypothesis:
    """Return whether Assumption 2 holds: g_s, the symmetric part of g (of -g for negative gains), is positive definite."""
    smallest = float(analysis.sampled_loop.eigenvalue_min.min())
    sign = "" if analysis.controller.task.gain[0] > 0 else "-"
    bound = f", at least {round_down(smallest):g}" if math.isfinite(smallest) else ""
    unchecked = "; that f and g are locally Lipschitz is not looked at" if analysis.plant is not None else ""
    return Hypothesis("Assumption 2", f"{sign}g_s > 0 over the tube{bound}{unchecked}", smallest > 0)


def _clamp_hypothesis(analysis: LoopAnalysis) -> Hypothesis:
    """Return whether Theorem 4.1 applies: |eps| never reaches the clamp, under continuous control or by a proved period."""
    loop, clamp = analysis.sampled_loop, analysis.sampled_loop.law.eps_at_clamp
    never_acts = (epsilon_star(loop) < clamp).all() or (epsilon_star_norm(loop) < clamp).all() or analysis.period is not None
    bound = by_component([float(f"{round_down(v):.4g}") for v in clamp.tolist()])
    statement = f"eps* <= eps(e_max) = {bound} under continuous control, or a sampled statement holds: the clamp never acts"
    return Hypothesis("Theorem 4.1", statement, bool(never_acts))


def _saturation_hypothesis(analysis: LoopAnalysis) -> Iterator[Hypothesis]:
    """Yield, for a task with u_max, whether the limits are never reached or outdo the plant."""
    task, loop = analysis.controller.task, analysis.sampled_loop
    if task.u_max is None:
        return
    is_harmless = analysis.period is not None or (holds_scaled(loop) if task.scales_input else holds_saturated(loop))
    is_below = (continuous_input_bound(loop) <= loop.law.u_max) & (epsilon_star(loop) < loop.law.eps_at_clamp)
    statement = f"control.u_max is at least what the law may ask for, or outdoes all that pushes ({Property.LIMITS.code})"
    yield Hypothesis("saturation", statement, is_harmless or bool(is_below.all()))


def _tick_hypothesis(analysis: LoopAnalysis) -> Iterator[Hypothesis]:
    """Yield, for a task with ticks, whether a sample each tick is proved."""
    tick = analysis.controller.task.emit.tick_period
    if tick is None:
        return
    is_proved = analysis.period is not None and float(tick) + analysis.latency <= analysis.period.seconds
    yield Hypothesis("sampling", f"emit.tick_period = {float(tick):g} s is proved short enough", is_proved)


def _stated_plant_hypothesis(analysis: LoopAnalysis) -> Iterator[Hypothesis]:
    """Yield whether a plant with equations is within the table [plant], where the certificate is about that table."""
    task = analysis.controller.task
    if analysis.plant is None or (task.control.period is None and not task.requires_input_limits):
        return
    about = Property.PERIOD if task.control.period is not None else Property.LIMITS
    has_less_noise = any(v < float(stated) for v, stated in zip(analysis.noise, task.noise, strict=True))
    is_easier = has_less_noise or analysis.latency < float(task.control.latency)
    uncovered = uncovered_bounds(task, analysis.bounds, analysis.plant.w_max)
    statement = f"this plant is one of those that {about.code} is about: {_stated_bounds(task)}"
    statement += "; asked with less noise or latency than the task's" if is_easier else ""
    statement += f"; but {'; '.join(uncovered)}" if uncovered else ""
    yield Hypothesis("[plant]", statement, analysis.is_covered and not is_easier)


def _stated_bounds(task: Task) -> str:
    """Return the bounds of the table [plant] as inequalities: in norm where u is scaled, else by component."""
    stated = task.plant_bounds
    if task.scales_input:
        norms = stated[0]
        return f"|f + w| <= {decimal(norms.force)}, g_s >= {decimal(norms.g_min)}, |g| <= {decimal(norms.g_max)}"
    force, g_min, g_max, g_cross = (by_component([getattr(b, k) for b in stated]) for k in ("force", "g_min", "g_max", "cross"))
    return f"|f_i + w_i| <= {force}, {g_min} <= g_ii <= {g_max}, |g_ij| <= {g_cross}"


def _update_function_hypotheses(bounds: UpdateFunctionBounds) -> list[Hypothesis]:
    """Return the hypotheses of the repaired Lemma 3.3: psi + alpha is positive, and the four gaps are wide enough."""
    gap, star = bounds.smallest_gap, bounds.s_star
    if gap is None or star is None:
        return [Hypothesis("update function", "psi + alpha is bounded away from 0", False)]
    required = bounds.ln4_over_nu
    return [
        Hypothesis("update function", f"psi + alpha >= s* = {star:g} > 0", star > 0),
        Hypothesis("four gaps", f"the least gap, {gap:g}, is above ln 4/nu = {required:g}", gap > required),
    ]
