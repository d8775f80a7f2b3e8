"""P1 to P6 for an adaptive or literal tube at samples: it finds faults, it proves nothing between the samples.

P4 takes the hull of consecutive samples, so that a thin unsafe set is not jumped over.
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
    initial_state_constraints,
    minimum_width,
    reach_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.decimals import decimal
from stt_codegen.designs import GRID_STEPS, AdaptiveDesign, grid_tube
from stt_codegen.properties import Property
from stt_codegen.task import Task

Array = npt.NDArray[Any]


def falsify(task: Task, design: AdaptiveDesign) -> Certificate:
    """The findings at samples. Never a proof: `method` is "sampled", and the certificate does not hold."""
    t, _, gamma, rate = grid_tube(design)
    low, high = gamma[:, :, 0], gamma[:, :, 1]
    settings = 'use tube.design = "refined", or other parameters in [tube.adaptive]'
    findings = [
        _at(t, width_constraints(task), (low, high), Property.WIDTH, f"width >= {decimal(minimum_width(task))}", settings),
        *_start(task, t, low, high),
        _at(t, stay_constraints(task), (low, high), Property.STAY, "gamma within the state space", settings),
        _avoid(task, t, low, high, settings),
        _at(t[-1:], reach_constraints(task), (low[-1:], high[-1:]), Property.REACH, "gamma(t_c) within the target set", settings),
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
        least_width=_exact(float((high - low).min())),
        start=tuple((_exact(float(a)), _exact(float(b))) for a, b in gamma[0]),
        whole_start=False,
        method="sampled",
    )


def _exact(value: float) -> Fraction:
    """A sampled number to nine digits and nine decimals: samples have no more to say, and a pure rounding is no failure."""
    return Fraction(f"{value:.9g}").limit_denominator(10**9) if math.isfinite(value) else Fraction(-(10**9))


def _slack(rows: Sequence[Constraint], low: Array, high: Array) -> Array:
    """By how much each row holds for tubes (S, n), as a distance: (S, R)."""
    found = []
    for row in rows:
        left: Any = 0.0
        for i, side, c in row.terms:
            left = left + float(c) * (high if side else low)[:, i]
        found.append((left - float(row.bound) - float(row.clearance)) / float(row.slack_per_distance))
    return np.stack(found, axis=1)


def _at(
    t: Array, rows: Sequence[Constraint], tube: tuple[Array, Array], subject: Property, statement: str, advice: str
) -> Finding:
    """The row that holds by least at these times. tube: lower and upper edges, (S, n) each."""
    slack = _slack(rows, *tube)
    slack = np.where(np.isnan(slack), -np.inf, slack)
    k, r = np.unravel_index(int(np.argmin(slack)), slack.shape)
    time, dimension = _exact(float(t[k])), rows[int(r)].dimension
    where = None if dimension is None else dimension + 1
    return Finding(subject, statement, _exact(float(slack[k, r])), Fraction(0), (time, time), where, None, advice)


def _start(task: Task, t: Array, low: Array, high: Array) -> list[Finding]:
    tube = low[:1], high[:1]
    return [
        _at(t[:1], initial_state_constraints(task), tube, Property.START, "x(0) inside gamma(0)", Property.START.advice),
        _at(t[:1], start_constraints(task), tube, Property.START, "gamma(0) within the initial set", "use another design"),
    ]


def _avoid(task: Task, t: Array, low: Array, high: Array, advice: str) -> Finding:
    """P4 on the hull of samples k and k + 1."""
    sets = avoidances(task)
    if not sets:
        return Finding(Property.AVOID, "there is no unsafe set", Fraction(0), Fraction(0))
    below, above = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
    gap = np.stack([_slack(one.alternatives, below, above).max(axis=1) for one in sets], axis=1)  # (S, J)
    gap = np.where(np.isnan(gap), -np.inf, gap)
    k, j = np.unravel_index(int(np.argmin(gap)), gap.shape)
    statement = f"gamma at least {decimal(task.tube.clearance)} from each of {len(sets)} unsafe sets"
    time = (_exact(float(t[k])), _exact(float(t[k + 1])))
    return Finding(Property.AVOID, statement, _exact(float(gap[k, j])), Fraction(0), time, None, sets[int(j)].name, advice)
