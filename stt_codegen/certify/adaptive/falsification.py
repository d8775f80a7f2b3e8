"""P1 to P6 for an adaptive or literal tube at samples: this finds faults, and proves nothing between the samples.

P4 takes the hull of consecutive samples, so that no thin unsafe set is missed between them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Certificate, Finding
from stt_codegen.constraints import (
    Constraint,
    avoidances,
    clearance_statement,
    initial_state_constraints,
    minimum_widths,
    reach_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.decimals import by_dimension
from stt_codegen.designs import GRID_STEPS, AdaptiveDesign, grid_tube
from stt_codegen.properties import Property
from stt_codegen.task import Task

Array = npt.NDArray[Any]


def falsify(task: Task, design: AdaptiveDesign) -> Certificate:
    """Return the findings at samples. They are no proof: `method` is "sampled", and the certificate does not hold."""
    t, _, gamma, rate = grid_tube(design)
    low, high = gamma[:, :, 0], gamma[:, :, 1]
    settings = 'use tube.design = "refined", or other parameters in [tube.adaptive]'
    findings = [
        _finding(
            t,
            width_constraints(task),
            (low, high),
            Property.WIDTH,
            f"width >= {by_dimension(minimum_widths(task))}",
            advice=settings,
        ),
        *_start(task, t, low, high),
        _finding(t, stay_constraints(task), (low, high), Property.STAY, "gamma within the state space", advice=settings),
        _avoid(task, t, low, high, settings),
        _finding(
            t[-1:],
            reach_constraints(task),
            (low[-1:], high[-1:]),
            Property.REACH,
            "gamma(t_c) within the target set",
            advice=settings,
        ),
    ]
    speed = np.abs(rate).max(axis=(0, 2))
    bound = ", ".join(f"{v:.4g}" for v in speed)
    limit = task.max_speed
    margin = min(_exact(float(m) - v) for m, v in zip(limit, speed.tolist(), strict=True)) if limit is not None else Fraction(0)
    findings.append(
        Finding(
            Property.SMOOTH,
            f"|gammadot| up to {bound} at {GRID_STEPS} samples",
            margin,
            Fraction(0),
            advice="raise tube.max_speed",
        )
    )
    return Certificate(
        findings=tuple(findings),
        edge_error=(),
        speed=tuple(_exact(v) for v in speed),
        minimum_width=_exact(float((high - low).min())),
        start=tuple((_exact(float(a)), _exact(float(b))) for a, b in gamma[0]),
        covers_initial_set=False,
        method="sampled",
    )


def _exact(value: float) -> Fraction:
    """Return a sampled number to nine digits and nine decimals, so that a mere rounding is no failure."""
    return Fraction(f"{value:.9g}").limit_denominator(10**9) if math.isfinite(value) else Fraction(-(10**9))


def _slack(constraints: Sequence[Constraint], low: Array, high: Array) -> Array:
    """Return the slack of each constraint for tubes (S, n), as a distance: (S, R)."""
    slack = []
    for constraint in constraints:
        left: Any = 0.0
        for i, side, c in constraint.terms:
            left = left + float(c) * (high if side else low)[:, i]
        slack.append((left - float(constraint.bound) - float(constraint.clearance)) / float(constraint.slack_per_distance))
    return np.stack(slack, axis=1)


def _finding(
    t: Array, constraints: Sequence[Constraint], tube: tuple[Array, Array], subject: Property, statement: str, *, advice: str
) -> Finding:
    """Return the finding of constraints at these times: the one with the smallest slack. tube: lower and upper edges, (S, n)."""
    slack = _slack(constraints, *tube)
    slack = np.where(np.isnan(slack), -np.inf, slack)
    k, r = np.unravel_index(int(np.argmin(slack)), slack.shape)
    time, index = _exact(float(t[k])), constraints[int(r)].dimension
    dimension = None if index is None else index + 1
    return Finding(
        subject,
        statement,
        _exact(float(slack[k, r])),
        Fraction(0),
        (time, time),
        dimension=dimension,
        advice=advice,
    )


def _start(task: Task, t: Array, low: Array, high: Array) -> list[Finding]:
    """Return the findings of P2 at t = 0."""
    tube, inside, within = (low[:1], high[:1]), "x(0) inside gamma(0)", "gamma(0) within the initial set"
    state, start, advice = initial_state_constraints(task), start_constraints(task), Property.START.advice
    return [
        _finding(t[:1], state, tube, Property.START, inside, advice=advice),
        _finding(t[:1], start, tube, Property.START, within, advice="use another design"),
    ]


def _avoid(task: Task, t: Array, low: Array, high: Array, advice: str) -> Finding:
    """Return the finding of P4 on the hulls of consecutive samples."""
    sets = avoidances(task)
    if not sets:
        return Finding(Property.AVOID, "there is no unsafe set", Fraction(0), Fraction(0))
    below, above = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
    gap = np.stack([_slack(avoidance.alternatives, below, above).max(axis=1) for avoidance in sets], axis=1)  # (S, J)
    gap = np.where(np.isnan(gap), -np.inf, gap)
    k, j = np.unravel_index(int(np.argmin(gap)), gap.shape)
    statement = clearance_statement(task, len(sets))
    time = (_exact(float(t[k])), _exact(float(t[k + 1])))
    return Finding(
        Property.AVOID,
        statement,
        _exact(float(gap[k, j])),
        Fraction(0),
        time,
        obstacle=sets[int(j)].name,
        advice=advice,
    )
