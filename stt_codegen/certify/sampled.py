"""P1 to P6 for an adaptive or literal tube at samples: it finds faults, it proves nothing between the samples.

alpha is stepped by the implicit step that the target makes; everything else is `reference.py`, which shares no code with
what is emitted. P4 takes the hull of consecutive samples, so that a thin unsafe set is not jumped over.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.certify.certificate import Certificate, Finding
from stt_codegen.design.adapted import AdaptiveDesign
from stt_codegen.task import Box, Task
from stt_codegen.wording import decimal

SAMPLES = 4000
Array = npt.NDArray[Any]


def parameters_of(design: AdaptiveDesign) -> reference.Parameters:
    """The plain data of a design for the reference."""

    def edges(pairs: tuple[tuple[Fraction, Fraction], ...]) -> Array:
        return np.array([[reference.exact(v) for v in pair] for pair in pairs])

    e = reference.exact
    return reference.Parameters(
        e(design.prescribed_time), edges(design.start), edges(design.target), edges(design.walls),
        tuple((b.dimension, b.side, e(b.height), e(b.steepness), e(b.middle), e(b.radius)) for b in design.bumps),
        e(design.theta0), e(design.kappa), e(design.mu), e(design.varsigma), e(design.nu),
    )  # fmt: skip


def sample_tube(design: AdaptiveDesign, samples: int = SAMPLES) -> tuple[Array, Array, Array, Array]:
    """Times (S + 1,), and alpha, gamma and gammadot of shape (S + 1, n, 2), alpha stepped from 0 with dt = t_c / S."""
    p = parameters_of(design)
    step = float(design.prescribed_time) / samples
    t = np.arange(samples + 1) * step
    now = reference.lines(p, t)
    alpha = step_alpha(design, now.psi.astype(float), step)
    gamma, rate = reference.adaptive_tube(p, now, alpha)
    return t, alpha, gamma.astype(float), rate.astype(float)


def step_alpha(design: AdaptiveDesign, psi: Array, dt: float) -> Array:
    """alpha on a grid of step dt from 0, by the implicit step that is emitted; psi and the result of shape (S + 1, n, 2)."""
    steps = _steps(len(psi) - 1)
    parameters = [float(v) for v in (design.theta0, design.kappa, design.mu, design.varsigma)]
    alpha = np.zeros(psi.shape)
    for i, side in np.ndindex(*psi.shape[1:]):
        alpha[1:, i, side] = np.array(steps(0.0, psi[1:, i, side][None], dt, *parameters)).ravel()
    return alpha


@cache
def _steps(count: int) -> Any:
    from stt_codegen.paper.adaptive_tube import implicit_step_function

    return implicit_step_function().mapaccum("steps", count)


def certify_sampled(task: Task, design: AdaptiveDesign) -> Certificate:
    """The findings at samples. Never a proof: `method` is "sampled", and the certificate does not hold."""
    t, _, gamma, rate = sample_tube(design)
    low, high = gamma[:, :, 0], gamma[:, :, 1]
    settings = 'use tube.design = "refined", or other parameters in [tube.adaptive]'
    findings = [
        _at(t, (high - low) - float(task.tube.min_width), "P1", f"width >= {decimal(task.tube.min_width)}", settings),
        *_start(task, t, low, high),
        _at(t, _within(low, high, task.free_space), "P3", "gamma within the state space", settings),
        _avoid(task, t, low, high, settings),
        _at(t[-1:], _within(low[-1:], high[-1:], task.target_set), "P5", "gamma(t_c) within the target set", settings),
    ]
    speed = np.abs(rate).max(axis=(0, 2))
    bound = ", ".join(f"{v:.4g}" for v in speed)
    limit = task.tube.max_speed
    margin = _exact(float(limit) - float(speed.max())) if limit is not None else Fraction(0)
    findings.append(
        Finding("P6", f"|gammadot| up to {bound} at {SAMPLES} samples", margin, Fraction(0), advice="raise tube.max_speed")
    )
    return Certificate(
        findings=tuple(findings),
        edge_error=(),
        speed=tuple(_exact(v) for v in speed),
        least_width=_exact(float((high - low).min())),
        start=tuple((_exact(float(a)), _exact(float(b))) for a, b in gamma[0]),
        whole_start=False,
        method="sampled",
    )


def _exact(value: float) -> Fraction:
    """A sampled number to nine digits and nine decimals: samples have no more to say, and a pure rounding is no failure."""
    return Fraction(f"{value:.9g}").limit_denominator(10**9) if math.isfinite(value) else Fraction(-(10**9))


def _within(low: Array, high: Array, box: Box) -> Array:
    lower, upper = (np.array([float(v) for v in edge]) for edge in (box.lower, box.upper))
    return np.asarray(np.minimum(low - lower, upper - high))


def _at(t: Array, slack: Array, code: str, statement: str, advice: str) -> Finding:
    """A finding from slack of shape (S, n)."""
    slack = np.where(np.isnan(slack), -np.inf, slack)
    k, i = np.unravel_index(int(np.argmin(slack)), slack.shape)
    time = _exact(float(t[k]))
    return Finding(code, statement, _exact(float(slack[k, i])), Fraction(0), (time, time), int(i) + 1, None, advice)


def _start(task: Task, t: Array, low: Array, high: Array) -> list[Finding]:
    x = np.array([float(v) for v in task.initial_state])
    inside = np.minimum(x - low[:1], high[:1] - x)
    within = _within(low[:1], high[:1], task.initial_set)
    return [
        _at(t[:1], inside, "P2", "x(0) inside gamma(0)", "move initial_state inside the initial set"),
        _at(t[:1], within, "P2", "gamma(0) within the initial set", "use another design"),
    ]


def _avoid(task: Task, t: Array, low: Array, high: Array, advice: str) -> Finding:
    """P4 on the hull of samples k and k + 1."""
    if not task.grown_unsafe:
        return Finding("P4", "there is no unsafe set", Fraction(0), Fraction(0))
    below, above = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
    gaps = []
    for s in task.grown_unsafe:
        lower, upper = (np.array([float(v) for v in edge]) for edge in (s.lower, s.upper))
        gaps.append(np.maximum(lower - above, below - upper).max(axis=1))
    gap = np.stack(gaps, axis=1) - float(task.tube.clearance)  # (S, J)
    gap = np.where(np.isnan(gap), -np.inf, gap)
    k, j = np.unravel_index(int(np.argmin(gap)), gap.shape)
    name = task.grown_unsafe[int(j)].name
    statement = f"gamma at least {decimal(task.tube.clearance)} from each of {len(task.grown_unsafe)} unsafe sets"
    time = (_exact(float(t[k])), _exact(float(t[k + 1])))
    return Finding("P4", statement, _exact(float(gap[k, j])), Fraction(0), time, None, name, advice)
