"""P8: an input within its limits is enough, for every plant within the bounds of [plant].

At an edge that moves towards the state, the input can move the state away faster. At the upper edge (R - x)' = R' - f - g u - w,
which for u = -u_max is at least R' + g_min u_max - |f| - |w| - ..; this must be above 0, and with a law that asks for enough it
is sufficient (lemmas `limits.*`).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Finding
from stt_codegen.certify.filtered_findings import input_slack
from stt_codegen.constraints import control_authority, limit_constraints
from stt_codegen.decimals import by_component
from stt_codegen.designs import LOWER, UPPER, RefinedDesign, demanded_accelerations
from stt_codegen.properties import Property
from stt_codegen.task import Task, is_within_norm, shares_of_norm


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
    margin, dimension = smallest.slack * per_second, smallest.dimension + 1
    advice = f"raise {task.limit_key} or prescribed_time, or state a milder plant"
    return (Finding(Property.LIMITS, statement, margin, per_second, time, dimension=dimension, advice=advice),)


def with_shares_of_norm(task: Task, design: RefinedDesign) -> Task:
    """Return a task without a period with the limits of u that control.u_norm leaves each component.

    They are in proportion to the input that P8 asks for: what balances f, w, coupling and the edges of this tube.
    """
    assert task.control.u_norm is not None
    return task.with_choices(u_max=shares_of_norm(_needed_input(task, design), task.control.u_norm, task.stated_u_max))


def sufficient_norm(task: Task, needed: Sequence[Fraction]) -> tuple[tuple[str, Fraction], ...]:
    """Return control.u_norm with a value that leaves each component the needed input, for the search for remedies.

    It is empty where the task's own norm leaves it, or where another limit is too small.
    """
    norm, stated = task.control.u_norm, task.stated_u_max
    if norm is None or is_within_norm(needed, norm) or any(map(operator.ge, needed, stated or ())):
        return ()
    return (("control.u_norm", Fraction(math.sqrt(sum(v * v for v in needed)))),)


def with_sufficient_norm(task: Task, design: RefinedDesign, findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the findings; those of P8 that fail with the control.u_norm that is enough for this tube."""
    return tuple(
        replace(finding, sufficient=sufficient_norm(task, _needed_input(task, design)))
        if finding.subject is Property.LIMITS and not finding.holds
        else finding
        for finding in findings
    )


def _needed_input(task: Task, design: RefinedDesign) -> list[Fraction]:
    """Return by component the |u| that balances all that P8 counts."""
    from stt_codegen.sampling import balancing_input

    bounds, n = task.plant_bounds, task.dimension
    closing_speed = np.array([float(b.force) for b in bounds]) + _demanded_rates(design)
    cross = np.array([[float(b.cross) * (i != j) for j in range(n)] for i, b in enumerate(bounds)])
    needed = balancing_input(np.array([[float(b.g_min) for b in bounds]]), cross[None], closing_speed[None])[0]
    return [Fraction(v) for v in needed.tolist()]


def _demanded_rates(design: RefinedDesign) -> npt.NDArray[np.float64]:
    """Return by component the largest rate towards the state that an edge demands of the input, 0 or more.

    It is a speed in units per second, and for order 2 an acceleration.
    """
    if design.filter:
        pieces = demanded_accelerations(design)
        coefficients, scale = pieces.coefficients, pieces.unit
    else:
        coefficients, scale = 3 * np.diff(design.bezier(), axis=3), design.unit * design.segments / design.prescribed_time
    rates = np.maximum(coefficients[:, :, LOWER], -coefficients[:, :, UPPER]).max(axis=(0, 2))
    return np.asarray(np.maximum(rates.astype(float) * float(scale), 0.0))


def outweighs_disturbances(task: Task, design: RefinedDesign) -> bool:
    """Return whether P8 holds, or is not asked for, without the rest of a certificate."""
    if task.order == 2:
        inertial_slack = input_slack(task, design)
        return inertial_slack is None or inertial_slack.units >= 1
    smallest = smallest_limit_slack(task, design)
    return smallest is None or smallest.slack >= 1
