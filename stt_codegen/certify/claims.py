"""The claims of certificate format 3 about a refined tube: for every property the smallest slack, and hints where to find it.

A slack is in whole units of the table. The hints say which normal of an unsafe set proves it on which stretch of time, with which
multipliers of its half-spaces, and where a segment must be cut. They help a checker to repeat the proof and need not be trusted;
docs/certificate-format.md describes them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Certificate, MissionProof
from stt_codegen.certify.filtered_findings import distance_errors, filtered_width_slack, input_slack, start_slack
from stt_codegen.certify.limits import smallest_limit_slack
from stt_codegen.certify.missions import SLICES, avoiding_pieces
from stt_codegen.certify.moving_slack import moving_slack_by_piece
from stt_codegen.certify.multipliers import Multipliers, multipliers_in
from stt_codegen.certify.slack import ConstraintBlock, PieceSlack, slack_by_piece
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
from stt_codegen.task.mission import InRegion, StateFormula
from stt_codegen.task.sets import Normal, Unsafe, UnsafeSet


@dataclass(frozen=True)
class Stretch:
    """An interval of spline time, in segments, with the normal that proves it; None where every constraint must hold.

    multipliers: of the set's half-spaces (multipliers.py); None for other sets."""

    begin: Fraction
    end: Fraction
    normal: Normal | None
    multipliers: Multipliers | None = None


@dataclass(frozen=True)
class SlackClaim:
    """A claim that one property has at least some slack on an interval of spline time.

    on: the interval, in segments. margin: the slack, in units of the table; None where there is no constraint. name: of the
    unsafe set. hints: empty where whole segments and all constraints prove it. order: of the derivative, where the property alone
    does not say it.
    """

    subject: Property
    on: tuple[int | Fraction, ...]
    margin: int | None
    name: str | None = None
    hints: tuple[Stretch, ...] = ()
    _: KW_ONLY
    order: int | None = None


def claims_of(task: Task, design: RefinedDesign, certificate: Certificate) -> list[SlackClaim]:
    """Return the claims P1 to P6, P8 and P10, in that order; P4 for every unsafe set."""
    tube = _ClaimedTube(task, design, design.bezier(), units_of_error(design, certificate.edge_error))
    start = (*initial_state_constraints(task), *start_constraints(task))
    kink = int(design.kink(task.order).max())
    acceleration = tube.rate_slack(2, acceleration_constraints(task))
    return [
        tube.claim_always(Property.WIDTH, width_constraints(task)),
        tube.claim_at(Property.START, start, 0, 0),
        tube.claim_always(Property.STAY, stay_constraints(task)),
        *tube.claim_avoidance(),
        *([] if task.target_set is None else [tube.claim_at(Property.REACH, reach_constraints(task), -1, -1)]),
        SlackClaim(Property.SMOOTH, tube.always, -kink if kink else tube.rate_slack(1, speed_constraints(task))),
        *([] if acceleration is None else [SlackClaim(Property.SMOOTH, tube.always, acceleration, order=2)]),
        *(_limit_claims(tube) if task.order == 1 else _inertial_claims(tube, certificate)),
        *([] if certificate.mission is None else _mission_claims(task, design, certificate.mission)),
    ]


@dataclass(frozen=True)
class _ClaimedTube:
    """A task and a design, with the Bezier coefficients and P7's error in whole units of the table."""

    task: Task
    design: RefinedDesign
    bezier: npt.NDArray[np.int64]
    error: int

    @property
    def always(self) -> tuple[int, int]:
        """The whole spline time, in segments."""
        return (0, self.design.segments)

    def claim_always(self, subject: Property, constraints: Sequence[Constraint]) -> SlackClaim:
        """Return the claim of constraints that must all hold for all t; hints say where a segment is cut."""
        block = ConstraintBlock.of(constraints, self.design.unit)
        pieces = slack_by_piece(self.bezier, block, self.error * _largest_distance_error(constraints))
        cuts = tuple(Stretch(p.begin, p.end, None) for p in pieces if p.end - p.begin < 1)
        return SlackClaim(subject, self.always, min(_floor(p.slack.min(keepdims=True)[0]) for p in pieces), hints=cuts)

    def claim_at(self, subject: Property, constraints: Sequence[Constraint], piece: int, point: int) -> SlackClaim:
        """Return the claim of constraints at one moment: the control point `point` of segment `piece`."""
        moment = 0 if piece == 0 else self.design.segments
        points = np.repeat(self.bezier[piece : piece + 1 or None, ..., point : point + 1 or None], 4, axis=-1)
        slack = ConstraintBlock.of(constraints, self.design.unit).slack(points)[0][0]
        return SlackClaim(subject, (moment, moment), int(slack))

    def claim_avoidance(self) -> list[SlackClaim]:
        """Return the claims of P4; hints say which normal proves it when."""
        claims = []
        for j, avoidance in enumerate(avoidances(self.task)):
            constraints = avoidance.alternatives
            required = self.error * _largest_distance_error(constraints)
            if avoidance.course is None:
                pieces = slack_by_piece(self.bezier, ConstraintBlock.choice([avoidance], self.design.unit), required)
            else:
                pieces = list(moving_slack_by_piece(avoidance, self.design, required))
            margin = min(_floor(p.slack.max()) for p in pieces)
            stretches = _stretches(pieces, constraints, margin, self.task.dimension)
            hints = _with_multipliers(stretches, multipliers_in(self.task, self.task.stated_set(j)))
            claims.append(SlackClaim(Property.AVOID, self.always, margin, avoidance.name, hints))
        return claims

    def rate_slack(self, order: int, constraints: Sequence[Constraint]) -> int | None:
        """Return the smallest slack of rates (order 1) or accelerations (2); None without constraints.

        It is in units of the table by one segment's time to that power.
        """
        edges = self.bezier
        for degree in range(3, 3 - order, -1):
            edges = degree * np.diff(edges, axis=3)
        scale = (self.design.prescribed_time / self.design.segments) ** order / self.design.unit
        return min(
            (
                int((c * edges[:, i, side]).min()) - math.ceil(constraint.bound * scale)
                for constraint in constraints
                for i, side, c in constraint.terms
            ),
            default=None,
        )


def _limit_claims(tube: _ClaimedTube) -> list[SlackClaim]:
    """Return the claim of P8 for order 1, where the task asks for it."""
    limit = smallest_limit_slack(tube.task, tube.design)
    return [] if limit is None else [SlackClaim(Property.LIMITS, tube.always, limit.slack)]


def _inertial_claims(tube: _ClaimedTube, certificate: Certificate) -> list[SlackClaim]:
    """Return the claims for order 2: the filtered tube's width, its starts, and P8 where the task asks for it."""
    task, design = tube.task, tube.design
    errors = distance_errors(design, certificate.edge_error, certificate.rate_error)
    limit = input_slack(task, design)
    return [
        SlackClaim(Property.WIDTH, tube.always, filtered_width_slack(design).units, order=2),
        SlackClaim(Property.START, (0, 0), start_slack(task, design, errors).units, order=2),
        *([] if limit is None else [SlackClaim(Property.LIMITS, tube.always, limit.units)]),
    ]


def _mission_claims(task: Task, design: RefinedDesign, proof: MissionProof) -> list[SlackClaim]:
    """Return the claims of P10, one for every interval of every state; with hints where a region that is no box is avoided."""
    claims = []
    for state, spans in proof.spans.items():
        for span in spans:
            hints = _mission_hints(task, design, proof, state, span)
            claims.append(SlackClaim(Property.MISSION, tuple(Fraction(v, SLICES) for v in span), proof.margin, str(state), hints))
    return claims


def _mission_hints(
    task: Task, design: RefinedDesign, proof: MissionProof, state: StateFormula, span: tuple[int, int]
) -> tuple[Stretch, ...]:
    """Return the hints of a claim of P10: none, but where a region that is no box is avoided."""
    inner = state.inner
    region = task.regions[inner.region] if isinstance(inner, InRegion) and inner.is_negated else None
    if not isinstance(region, Unsafe) or isinstance(region, UnsafeSet):
        return ()
    (constraints,) = [a.alternatives for a in mission_avoidances(task, state)]
    pieces = avoiding_pieces(design, ConstraintBlock.of(constraints, design.unit), span, proof.margin)
    stretches = [Stretch(p.begin, p.end, _normal(constraints[p.constraint], task.dimension)) for p in pieces]
    return _with_multipliers(stretches, multipliers_in(task, region))


def _with_multipliers(
    stretches: Sequence[Stretch], multipliers_of: Callable[[Normal], Multipliers | None]
) -> tuple[Stretch, ...]:
    """Return the stretches with the multipliers of their normals."""
    by_normal = {h.normal: multipliers_of(h.normal) for h in stretches if h.normal is not None}
    return tuple(h if h.normal is None else replace(h, multipliers=by_normal[h.normal]) for h in stretches)


def _normal(constraint: Constraint, n: int) -> Normal:
    """Return the coefficients of a constraint by dimension."""
    normal = [0] * n
    for i, _, c in constraint.terms:
        normal[i] = c
    return tuple(normal)


def _floor(slack: Any) -> int:
    """Round a slack down, exactly: a NumPy number of 64 bits must not go through a double."""
    return math.floor(slack) if isinstance(slack, Fraction) else int(slack)


def units_of_error(design: RefinedDesign, edge_error: Sequence[Fraction]) -> int:
    """Return P7's bound over all edges in whole units of the table, which P1 to P5 need as margin."""
    return math.ceil(max(edge_error) / design.unit)


def cuts_of(claims: Sequence[SlackClaim]) -> int:
    """Return the finest division of a segment in the hints, a power of two; with missions at least SLICES."""
    moments = [v for claim in claims for hint in claim.hints for v in (hint.begin, hint.end)]
    finest = max((v.denominator for v in moments), default=1)
    return max(finest, SLICES) if any(claim.subject is Property.MISSION for claim in claims) else finest


def _largest_distance_error(constraints: Sequence[Constraint]) -> Fraction:
    return max(constraint.distance_error for constraint in constraints)


def _stretches(pieces: list[PieceSlack], constraints: Sequence[Constraint], margin: int, n: int) -> list[Stretch]:
    """Return the fewest stretches with one normal each that prove the margin; pieces of a cut segment stay apart."""
    result: list[Stretch] = []
    k = 0
    while k < len(pieces):
        reach = []
        for r in range(len(constraints)):
            last = k
            while last < len(pieces) and pieces[last].slack[r] >= margin and _may_join(pieces, k, last):
                last += 1
            reach.append(last)
        best = int(np.argmax(reach))
        last = max(reach[best], k + 1)
        result.append(Stretch(pieces[k].begin, pieces[last - 1].end, _normal(constraints[best], n)))
        k = last
    return result


def _may_join(pieces: list[PieceSlack], first: int, last: int) -> bool:
    """Return whether a piece may share a stretch with the first: both are whole segments, or it is the first."""
    return first == last or all(pieces[k].end - pieces[k].begin == 1 for k in (first, last))
