"""P8: an input within its limits is enough, for every plant within the bounds of [plant].

At an edge that moves towards the state, the input can move the state away faster. At the upper edge (R - x)' = R' - f - g u - w,
which for u = -u_max is at least R' + g_min u_max - |f| - |w| - ..; this must be above 0, and with a law that asks for enough it
is sufficient (lemmas `limits.*`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stt_codegen.certify.certificate import Finding
from stt_codegen.certify.filtered_findings import input_slack
from stt_codegen.constraints import control_authority, limit_constraints
from stt_codegen.decimals import by_component
from stt_codegen.designs import RefinedDesign
from stt_codegen.properties import Property
from stt_codegen.task import Task


@dataclass(frozen=True)
class LimitSlack:
    """The smallest slack of P8's constraints, with its segment and its dimension, both from 0.

    slack: in whole units of the table by one segment's time, rounded down.
    """

    slack: int
    segment: int
    dimension: int


def smallest_limit_slack(task: Task, design: RefinedDesign) -> LimitSlack | None:
    """Return the smallest slack of P8's constraints; None where the task does not ask for P8."""
    steps = 3 * np.diff(design.bezier(), axis=3)
    scale = design.prescribed_time / design.segments / design.unit
    slacks = []
    for constraint in limit_constraints(task):
        ((i, side, sign),) = constraint.terms
        rate = (sign * steps[:, i, side]).min(axis=1)
        segment = int(rate.argmin())
        slacks.append(LimitSlack(int(rate[segment]) - math.ceil(constraint.bound * scale), segment, i))
    return min(slacks, key=lambda s: s.slack, default=None)


def certify_limits(task: Task, design: RefinedDesign) -> tuple[Finding, ...]:
    """Return the finding of P8, or none where the task does not ask for it.

    It requires more than 0: one unit of the table in a segment's time.
    """
    smallest = smallest_limit_slack(task, design)
    if smallest is None:
        return ()
    length = design.prescribed_time / design.segments
    per_second = design.unit / length
    speed = by_component(control_authority(task))
    assert task.u_max is not None
    statement = f"|u| <= {by_component(task.u_max)} holds x off every edge: it moves x by {speed}/s against all that pushes"
    if task.scales_input:
        limit = by_component(task.u_max)
        statement = f"|u| <= {limit}, scaled as a whole, outdoes all that pushes: no edge moves at {speed}/s or more"
    time = (smallest.segment * length, (smallest.segment + 1) * length)
    return (Finding(Property.LIMITS, statement, smallest.slack * per_second, per_second, time, dimension=smallest.dimension + 1),)


def outweighs_disturbances(task: Task, design: RefinedDesign) -> bool:
    """Return whether P8 holds, or is not asked for, without the rest of a certificate."""
    if task.order == 2:
        inertial_slack = input_slack(task, design)
        return inertial_slack is None or inertial_slack.units >= 1
    smallest = smallest_limit_slack(task, design)
    return smallest is None or smallest.slack >= 1
