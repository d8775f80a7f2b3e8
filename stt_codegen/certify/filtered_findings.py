"""What a tube for a plant of order 2 must have besides: room for v + lambda x, starts at rest in it, and input enough (P8).

All are comparisons of exact Bezier coefficients; designs/filtered.py has them, docs/certificate-format.md what is claimed.
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
    MINIMUM_WIDTH,
    UPPER,
    RefinedDesign,
    demanded_accelerations,
    filtered_edges,
    slopes_at_start,
)
from stt_codegen.properties import Property
from stt_codegen.task import Task


@dataclass(frozen=True)
class Slack:
    """The least slack of one property, in whole `units` rounded down: in which segment and of which dimension, from 0."""

    units: int
    unit: Fraction
    segment: int
    dimension: int


def allowance(design: RefinedDesign, edge: Sequence[Fraction], rate: Sequence[Fraction]) -> list[Fraction]:
    """What is left for the arithmetic's error of a distance to an edge of the filtered tube, by dimension: as the certificate
    claims the errors of edges and of their rates, in whole units of the table and of it in a segment's time."""
    speed = design.unit * design.segments / Fraction(design.prescribed_time)
    both = zip(edge, rate, design.filter, strict=True)
    return [2 * (math.ceil(r / speed) * speed + v * math.ceil(e / design.unit) * design.unit) for e, r, v in both]


def filtered_width(design: RefinedDesign) -> Slack:
    """By how much the filtered tube is wider than MINIMUM_WIDTH."""
    pieces = filtered_edges(design)
    room = (pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).min(axis=-1)
    k, i = np.unravel_index(int(room.argmin()), room.shape)
    return Slack(int(room[k, i]) - math.ceil(MINIMUM_WIDTH / pieces.unit), pieces.unit, int(k), int(i))


def starts(task: Task, design: RefinedDesign, wrong: Sequence[Fraction]) -> Slack:
    """By how much v + lambda x is inside at t = 0 for every start: at rest, wherever it is, where no edge comes towards it; with
    a speed of at most V in the share of gamma(0) where lambda times the distance to the edge is above V less what the edge gives
    way and what the arithmetic is `wrong` by, so that none is on an edge. In units of the table in a segment's time."""
    unit = design.unit * design.segments / Fraction(design.prescribed_time)
    found = []
    for i, (low, high) in enumerate(slopes_at_start(design)):
        speed, room = task.start_speed[i], min(-low, high)
        if speed:
            a, b = (int(v) * design.unit for v in design.bezier()[0, i, :, 0])
            room += design.filter[i] * (1 - task.initial_set.share) * (b - a) / 2 - speed - wrong[i]
        found.append(Slack(math.floor(room / unit), unit, 0, i))
    return min(found, key=lambda s: s.units)


def spare_acceleration(task: Task, design: RefinedDesign) -> Slack | None:
    """By how much an input within u_max outdoes what pushes v + lambda x at an edge; None where that is not asked for."""
    if not task.requires_input_limits:
        return None
    pieces, found = demanded_accelerations(design), []
    for i, spare in enumerate(control_authority(task)):
        asked = np.maximum(pieces.coefficients[:, i, LOWER], -pieces.coefficients[:, i, UPPER]).max(axis=-1)
        k = int(asked.argmax())
        found.append(Slack(math.floor(spare / pieces.unit) - int(asked[k]), pieces.unit, k, i))
    return min(found, key=lambda s: s.units)


def certify_inertia(task: Task, design: RefinedDesign, edge: tuple[Fraction, ...], rate: tuple[Fraction, ...]) -> list[Finding]:
    """The findings. edge, rate: what the arithmetic moves an edge and its rate by, by dimension."""
    length = Fraction(design.prescribed_time) / design.segments

    def finding(
        subject: Property, statement: str, slack: Slack, required: Fraction, advice: str, at_start: bool = False
    ) -> Finding:
        where = (Fraction(0), Fraction(0)) if at_start else (slack.segment * length, (slack.segment + 1) * length)
        return Finding(subject, statement, slack.units * slack.unit, required, where, slack.dimension + 1, None, advice)

    wrong = allowance(design, edge, rate)
    told = f"v + lambda x has room: (R - L)' + lambda (R - L) > 0, lambda = {by_component(design.filter)}"
    speed = by_component(task.start_speed)
    moving = f"every start with |e(0)| <= {decimal(task.initial_set.share)} and |v(0)| <= {speed}"
    start = moving if any(task.start_speed) else "every start at rest in gamma(0)"
    found = [
        finding(
            Property.WIDTH,
            told,
            filtered_width(design),
            max(wrong),
            "raise tube.filter or prescribed_time, or narrow the initial set",
        ),
        finding(
            Property.START,
            f"v + lambda x inside for {start}",
            starts(task, design, wrong),
            Fraction(0),
            "lower initial_set.speed",
            True,
        ),
    ]
    spare = spare_acceleration(task, design)
    if spare is not None:
        assert task.u_max is not None
        statement = (
            f"|u| <= {by_component(task.u_max)} holds v + lambda x off every edge: it turns it by "
            f"{by_component(control_authority(task))}/s^2 against all that pushes"
        )
        advice = "raise control.u_max or prescribed_time, lower tube.filter, or state a milder plant"
        found.append(finding(Property.LIMITS, statement, spare, spare.unit, advice))
    return found
