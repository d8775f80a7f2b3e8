"""What a tube for a plant of order 2 must satisfy besides: width for v + lambda x, starts inside, and input enough (P8).

All are comparisons of exact Bezier coefficients of the filtered tube (designs/filtered.py). docs/certificate-format.md says what
the certificate claims, and the lemmas `filtered.*` prove that it is enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stt_codegen.certify.certificate import Finding
from stt_codegen.constraints import control_authority
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import (
    LOWER,
    NARROWEST_WIDTH,
    UPPER,
    RefinedDesign,
    demanded_accelerations,
    filtered_edges,
    slopes_at_start,
)
from stt_codegen.properties import Property
from stt_codegen.task import Task


@dataclass(frozen=True)
class FilteredSlack:
    """The smallest slack of one property, in whole `units` rounded down, with its segment and its dimension, both from 0."""

    units: int
    unit: Fraction
    segment: int
    dimension: int


def distance_errors(design: RefinedDesign, edge: Sequence[Fraction], rate: Sequence[Fraction]) -> list[Fraction]:
    """Return a bound on the arithmetic's error of the distance to an edge of the filtered tube, by dimension.

    edge, rate: the errors of edges and of their rates. They are rounded up as the certificate claims them: to whole units of the
    table, and to one unit in a segment's time.
    """
    speed = design.unit * design.segments / Fraction(design.prescribed_time)
    both = zip(edge, rate, design.filter, strict=True)
    return [2 * (math.ceil(r / speed) * speed + v * math.ceil(e / design.unit) * design.unit) for e, r, v in both]


def filtered_width_slack(design: RefinedDesign) -> FilteredSlack:
    """Return by how much the filtered tube is wider than NARROWEST_WIDTH."""
    pieces = filtered_edges(design)
    width = (pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).min(axis=-1)
    k, i = np.unravel_index(int(width.argmin()), width.shape)
    return FilteredSlack(int(width[k, i]) - math.ceil(NARROWEST_WIDTH / pieces.unit), pieces.unit, int(k), int(i))


def start_slack(task: Task, design: RefinedDesign, errors: Sequence[Fraction]) -> FilteredSlack:
    """Return by how much v + lambda x is inside at t = 0 for every start, in units of the table in a segment's time.

    At rest x may be anywhere in gamma(0) if no edge moves towards it. With speeds of at most V, x is in the share of gamma(0);
    lambda times its distance to an edge must be above V less the edge's own speed away from x, and above `errors` of the
    arithmetic, so that no start is on an edge.
    """
    unit = design.unit * design.segments / Fraction(design.prescribed_time)
    slacks = []
    for i, (low, high) in enumerate(slopes_at_start(design)):
        speed, slack = task.start_speed[i], min(-low, high)
        if speed:
            a, b = (int(v) * design.unit for v in design.bezier()[0, i, :, 0])
            slack += design.filter[i] * (1 - task.initial_set.share) * (b - a) / 2 - speed - errors[i]
        slacks.append(FilteredSlack(math.floor(slack / unit), unit, 0, i))
    return min(slacks, key=lambda s: s.units)


def input_slack(task: Task, design: RefinedDesign) -> FilteredSlack | None:
    """Return by how much the control authority exceeds the acceleration that an edge demands; None where it is not asked for."""
    if not task.requires_input_limits:
        return None
    pieces, slacks = demanded_accelerations(design), []
    for i, authority in enumerate(control_authority(task)):
        demanded = np.maximum(pieces.coefficients[:, i, LOWER], -pieces.coefficients[:, i, UPPER]).max(axis=-1)
        k = int(demanded.argmax())
        slacks.append(FilteredSlack(math.floor(authority / pieces.unit) - int(demanded[k]), pieces.unit, k, i))
    return min(slacks, key=lambda s: s.units)


def certify_inertia(task: Task, design: RefinedDesign, edge: tuple[Fraction, ...], rate: tuple[Fraction, ...]) -> list[Finding]:
    """Return the findings for order 2.

    edge, rate: bounds on the arithmetic's error of an edge and of its rate, by dimension.
    """
    errors = distance_errors(design, edge, rate)
    return [
        _finding(
            design,
            filtered_width_slack(design),
            Property.WIDTH,
            f"v + lambda x has room: (R - L)' + lambda (R - L) > 0, lambda = {by_component(design.filter)}",
            required=max(errors),
            advice="raise tube.filter or prescribed_time, or narrow the initial set",
        ),
        _start_finding(task, design, errors),
        *_input_finding(task, design),
    ]


def _start_finding(task: Task, design: RefinedDesign, errors: Sequence[Fraction]) -> Finding:
    """Return the finding that v + lambda x is inside for every start."""
    speed = by_component(task.start_speed)
    moving = f"every start with |e(0)| <= {decimal(task.initial_set.share)} and |v(0)| <= {speed}"
    start = moving if any(task.start_speed) else "every start at rest in gamma(0)"
    statement, slack = f"v + lambda x inside for {start}", start_slack(task, design, errors)
    at_start = (Fraction(0), Fraction(0))
    return Finding(
        Property.START,
        statement,
        slack.units * slack.unit,
        Fraction(0),
        at_start,
        dimension=slack.dimension + 1,
        advice="lower initial_set.speed",
        about=("initial_set.speed",) if any(task.start_speed) else (),
    )


def _input_finding(task: Task, design: RefinedDesign) -> list[Finding]:
    """Return the finding of P8, or none where it is not asked for."""
    slack = input_slack(task, design)
    if slack is None:
        return []
    assert task.u_max is not None
    statement = (
        f"|u| <= {by_component(task.u_max)} holds v + lambda x off every edge: it turns it by "
        f"{by_component(control_authority(task))}/s^2 against all that pushes"
    )
    advice = f"raise {task.limit_key} or prescribed_time, lower tube.filter, or state a milder plant"
    return [_finding(design, slack, Property.LIMITS, statement, required=slack.unit, advice=advice)]


def _finding(
    design: RefinedDesign, slack: FilteredSlack, subject: Property, statement: str, *, required: Fraction, advice: str
) -> Finding:
    """Return a finding whose time interval is the segment with the smallest slack."""
    length = Fraction(design.prescribed_time) / design.segments
    time = (slack.segment * length, (slack.segment + 1) * length)
    return Finding(subject, statement, slack.units * slack.unit, required, time, dimension=slack.dimension + 1, advice=advice)
