"""What format 2 of the certificate claims of a refined tube: for every property the least slack of its rows in whole units of the
table, and where a checker finds it: which normal of an unsafe set on which stretch of time, and where a segment must be cut.

The hints are for whoever repeats the proof and need not be believed; docs/certificate-format.md is for them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.certify.certificate import Certificate
from stt_codegen.certify.filtered_findings import allowance, filtered_width, spare_acceleration, starts
from stt_codegen.certify.limits import least_spare
from stt_codegen.certify.missions import SLICES, kept_off
from stt_codegen.certify.moving_slack import moving_pieces
from stt_codegen.certify.slack import Found, RowBlock, pieces_of
from stt_codegen.constraints import (
    Constraint,
    acceleration_constraints,
    avoidances,
    initial_state_constraints,
    mission_avoidances,
    reach_constraints,
    speed_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.designs import RefinedDesign
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import InRegion
from stt_codegen.task.sets import UnsafeSet


@dataclass(frozen=True)
class Stretch:
    """From a place to another of spline time, in segments, along a normal (None where every row must hold)."""

    begin: Fraction
    end: Fraction
    normal: tuple[int, ...] | None


@dataclass(frozen=True)
class Claim:
    """One property for all of `on` (spline time, in segments): the slack of its rows is at least `margin` units of the table,
    None where there is no row. name: of the unsafe set. hints: empty where whole segments and every row do. order: of the
    derivative, where the property does not tell it."""

    subject: Property
    on: tuple[int | Fraction, ...]
    margin: int | None
    name: str | None = None
    hints: tuple[Stretch, ...] = ()
    order: int | None = None


def claims_of(task: Task, design: RefinedDesign, certificate: Certificate) -> list[Claim]:
    """The claims P1 to P6, P8 and P10, in that order; P4 for every unsafe set."""
    unit, bezier, segments = design.unit, design.bezier(), design.segments
    error = units_of_error(design, certificate.edge_error)
    always, n = (0, segments), task.dimension

    def every(subject: Property, rows: Sequence[Constraint]) -> Claim:
        found = pieces_of(bezier, RowBlock.of(rows, unit), error * _demand(rows))
        worst = [(a, b, slack.min(keepdims=True)) for a, b, slack in found]
        cut = tuple(Stretch(a, b, None) for a, b, _ in found if b - a < 1)
        return Claim(subject, always, min(_whole(slack[0]) for _, _, slack in worst), hints=cut)

    def at(subject: Property, rows: Sequence[Constraint], piece: int, point: int) -> Claim:
        place = 0 if piece == 0 else segments
        held = np.repeat(bezier[piece : piece + 1 or None, ..., point : point + 1 or None], 4, axis=-1)
        return Claim(subject, (place, place), int(RowBlock.of(rows, unit).slack(held)[0][0]))

    def avoid() -> list[Claim]:
        found = []
        for one in avoidances(task):
            required = error * _demand(one.alternatives)
            if one.course is None:
                pieces = pieces_of(bezier, RowBlock.choice([one], unit), required)
            else:
                pieces = list(moving_pieces(one, design, required))
            margin = min(_whole(slack.max()) for _, _, slack in pieces)
            found.append(Claim(Property.AVOID, always, margin, one.name, tuple(_stretches(pieces, one.alternatives, margin, n))))
        return found

    kink = int(design.kink(task.order).max())

    def within(order: int, rows: Sequence[Constraint]) -> int | None:
        """The least room of rates, or accelerations, in units of the table by one segment's time to that power."""
        edges = bezier
        for degree in range(3, 3 - order, -1):
            edges = degree * np.diff(edges, axis=3)
        scale = (design.prescribed_time / segments) ** order / unit
        return min(
            (int((c * edges[:, i, e]).min()) - math.ceil(r.bound * scale) for r in rows for i, e, c in r.terms), default=None
        )

    if task.order == 2:
        wrong = allowance(design, certificate.edge_error, certificate.rate_error)
        width, first, pushed = filtered_width(design), starts(task, design, wrong), spare_acceleration(task, design)
        inert = [Claim(Property.WIDTH, always, width.units, order=2), Claim(Property.START, (0, 0), first.units, order=2)]
        inert += [] if pushed is None else [Claim(Property.LIMITS, always, pushed.units)]
    else:
        spare = least_spare(task, design)
        inert = [] if spare is None else [Claim(Property.LIMITS, always, spare.slack)]
    second = within(2, acceleration_constraints(task))
    return [
        every(Property.WIDTH, width_constraints(task)),
        at(Property.START, (*initial_state_constraints(task), *start_constraints(task)), 0, 0),
        every(Property.STAY, stay_constraints(task)),
        *avoid(),
        *([] if task.target_set is None else [at(Property.REACH, reach_constraints(task), -1, -1)]),
        Claim(Property.SMOOTH, always, -kink if kink else within(1, speed_constraints(task))),
        *([] if second is None else [Claim(Property.SMOOTH, always, second, order=2)]),
        *inert,
        *_mission(task, design, certificate),
    ]


def _mission(task: Task, design: RefinedDesign, certificate: Certificate) -> list[Claim]:
    """P10: every stretch on which a state holds; with hints where a region that is no box is kept off."""
    shown, found = certificate.mission, []
    for state, spans in () if shown is None else shown.spans.items():
        assert shown is not None
        inner = state.inner
        hinted = isinstance(inner, InRegion) and inner.is_negated and not isinstance(task.regions[inner.region], UnsafeSet)
        (rows,) = [one.alternatives for one in mission_avoidances(task, state)] if hinted else [()]
        for span in spans:
            told = kept_off(design, RowBlock.of(rows, design.unit), span, shown.margin) if hinted else []
            hints = tuple(Stretch(a, b, _normal(rows[r], task.dimension)) for a, b, r in told)
            found.append(Claim(Property.MISSION, tuple(Fraction(v, SLICES) for v in span), shown.margin, str(state), hints))
    return found


def _normal(row: Constraint, n: int) -> tuple[int, ...]:
    normal = [0] * n
    for i, _, c in row.terms:
        normal[i] = c
    return tuple(normal)


def _whole(slack: Any) -> int:
    """Rounded down, exactly: a NumPy number of 64 bits would go through a double."""
    return math.floor(slack) if isinstance(slack, Fraction) else int(slack)


def units_of_error(design: RefinedDesign, edge_error: Sequence[Fraction]) -> int:
    """P7's bound over all edges in whole units of the table: what P1 to P5 must have to spare."""
    return math.ceil(max(edge_error) / design.unit)


def cuts_of(claims: Sequence[Claim]) -> int:
    """Into how many parts a segment is cut where the hints have it finest: a power of two; of missions into slices."""
    places = [v for claim in claims for hint in claim.hints for v in (hint.begin, hint.end)]
    finest = max((v.denominator for v in places), default=1)
    return max(finest, SLICES) if any(claim.subject is Property.MISSION for claim in claims) else finest


def _demand(rows: Sequence[Constraint]) -> Fraction:
    return max(row.distance_error for row in rows)


def _stretches(pieces: list[Found], rows: Sequence[Constraint], margin: int, n: int) -> list[Stretch]:
    """The fewest stretches with one normal each that show the margin; pieces of a cut segment stay apart."""
    result: list[Stretch] = []
    k = 0
    while k < len(pieces):
        reach = []
        for r in range(len(rows)):
            last = k
            while last < len(pieces) and pieces[last][2][r] >= margin and _joins(pieces, k, last):
                last += 1
            reach.append(last)
        best = int(np.argmax(reach))
        last = max(reach[best], k + 1)
        result.append(Stretch(pieces[k][0], pieces[last - 1][1], _normal(rows[best], n)))
        k = last
    return result


def _joins(pieces: list[Found], first: int, last: int) -> bool:
    """Whether a piece may share a stretch with the first: both are whole segments, or it is the first."""
    return first == last or all(pieces[k][1] - pieces[k][0] == 1 for k in (first, last))
