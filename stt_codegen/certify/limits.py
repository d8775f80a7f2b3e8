"""P8: an input within its limits is enough. At an edge that comes towards the state it can move the state away faster, whatever
pushes the state within the bounds of [plant].

At the upper edge (R - x)' = R' - f - g u - w, which for u = -u_max is at least R' + g_min u_max - |f| - |w| - ..: that this is
above 0 is needed, and with a law that asks for enough it is enough (lemmas `limits.*`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stt_codegen.certify.certificate import Finding
from stt_codegen.constraints import control_authority, limit_constraints
from stt_codegen.decimals import by_component
from stt_codegen.designs import RefinedDesign
from stt_codegen.properties import Property
from stt_codegen.task import Task


@dataclass(frozen=True)
class LeastSpare:
    """The least slack of P8's rows in whole units of the table by one segment's time, rounded down: in which segment, and of
    which dimension (both from 0)."""

    slack: int
    segment: int
    dimension: int


def least_spare(task: Task, design: RefinedDesign) -> LeastSpare | None:
    """None where P8 is not asked for."""
    steps = 3 * np.diff(design.bezier(), axis=3)
    scale = design.prescribed_time / design.segments / design.unit
    found = []
    for row in limit_constraints(task):
        ((i, side, sign),) = row.terms
        rate = (sign * steps[:, i, side]).min(axis=1)
        segment = int(rate.argmin())
        found.append(LeastSpare(int(rate[segment]) - math.ceil(row.bound * scale), segment, i))
    return min(found, key=lambda one: one.slack, default=None)


def certify_limits(task: Task, design: RefinedDesign) -> tuple[Finding, ...]:
    """P8, which demands more than 0: one unit of the table in a segment's time. None where it is not asked for."""
    least = least_spare(task, design)
    if least is None:
        return ()
    length = design.prescribed_time / design.segments
    per_second = design.unit / length
    spare = by_component(control_authority(task))
    assert task.u_max is not None
    statement = f"|u| <= {by_component(task.u_max)} holds x off every edge: it moves x by {spare}/s against all that pushes"
    if task.scales_input:
        most = by_component(task.u_max)
        statement = f"|u| <= {most}, scaled as a whole, outdoes all that pushes: no edge moves at {spare}/s or more"
    where = (least.segment * length, (least.segment + 1) * length)
    return (Finding(Property.LIMITS, statement, least.slack * per_second, per_second, where, least.dimension + 1),)
