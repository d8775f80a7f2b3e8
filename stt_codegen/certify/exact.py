"""P1 to P7 for a refined tube, in exact integer arithmetic, and the certificate with all findings of an emitted controller.

The coefficients are integers in units of 2**-bits. The bound of a constraint (stt_codegen/constraints.py, an exact decimal)
enters as the smallest integer not below it in these units, so every comparison is between integers and nothing is rounded to the
unsafe side. slack.py compares; the lemmas `rows.*` and `refined.*` prove that it is enough.
Long because the findings of one certificate are read together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Certificate, Finding
from stt_codegen.certify.claims import units_of_error
from stt_codegen.certify.filtered_findings import certify_inertia
from stt_codegen.certify.limits import certify_limits, with_sufficient_norm
from stt_codegen.certify.missions import certify_mission
from stt_codegen.certify.moving_slack import smallest_moving_slack
from stt_codegen.certify.slack import ConstraintBlock, LocatedSlack, smallest_slack
from stt_codegen.constraints import (
    Avoidance,
    Constraint,
    acceleration_constraints,
    avoidances,
    clearance_statement,
    initial_state_constraints,
    minimum_widths,
    reach_constraints,
    speed_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
    width_statement,
)
from stt_codegen.controller import edge_error, rate_error
from stt_codegen.decimals import above, by_component, decimal
from stt_codegen.designs import NARROWEST_WIDTH, RefinedDesign
from stt_codegen.program import Program
from stt_codegen.properties import Property
from stt_codegen.task import Task


def certify_emitted(task: Task, design: RefinedDesign, program: Program) -> Certificate:
    """Certify P1 to P7 of the emitted tube, and P8 to P10 where the task asks for them.

    P8 is for a limited u and a plant with bounds, P9 for a task with a period, P10 for one with a mission.
    """
    error = edge_error(design, program)
    certificate = certify_refined(task, design, error)
    mission_findings, mission = certify_mission(task, design, units_of_error(design, error))
    of_edges = (*certificate.findings, *mission_findings)
    arithmetic = _arithmetic_finding(program, max(error), of_edges)
    rate = rate_error(design, program) if task.order == 2 else ()
    of_law = certify_inertia(task, design, error, rate) if task.order == 2 else certify_limits(task, design)
    limit_findings = with_sufficient_norm(task, design, of_law)
    is_law_defined = program.scalar == "fixed" or _is_law_defined(design, error, limit_findings)
    certificate = replace(certificate, rate_error=rate, mission=mission, is_law_defined=is_law_defined)
    before_period = (*certificate.findings, arithmetic, *limit_findings)
    if task.control.period is None or (task.order == 2 and not all(f.holds for f in limit_findings)):
        return replace(certificate, findings=(*before_period, *mission_findings))
    from stt_codegen.certify.sampled import certify_period

    period_finding, proved = certify_period(task, design, error, rate)
    return replace(certificate, findings=(*before_period, period_finding, *mission_findings), proved_period=proved)


def _is_law_defined(design: RefinedDesign, error: Sequence[Fraction], findings_of_law: Sequence[Finding]) -> bool:
    """Return whether the emitted edges, of order 2 those of v + lambda x, are so far apart that the law can divide by it."""
    narrowest = NARROWEST_WIDTH + 2 * units_of_error(design, error) * design.unit
    is_wide = all(f.holds for f in findings_of_law if f.subject is Property.WIDTH)
    return is_wide and design.smallest_hull_width() >= narrowest


def _arithmetic_finding(program: Program, error: Fraction, of_edges: Sequence[Finding]) -> Finding:
    """Return the finding of P7: the smallest margin that findings about edges leave beyond the arithmetic's error."""
    margins = (f.margin - f.required for f in of_edges if f.required > 0 and not f.in_time)
    arithmetic = "integer" if program.scalar == "fixed" else program.scalar
    if program.scalar == "float":
        advice = (
            'the task needs more room than single precision leaves: use emit.scalar = "double", shift the origin, or, where the '
            "tube is fast, raise prescribed_time"
        )
    elif program.scalar == "fixed":
        advice = (
            'the task needs more room than integers of 15 bits leave: use emit.scalar = "float", shift the origin, or raise '
            "prescribed_time"
        )
    else:
        advice = f"the task needs more room than the tube's grid leaves: {Property.ARITHMETIC.advice}"
    statement = f"{arithmetic} arithmetic moves no edge by more than {above(error, 2):g}"
    return Finding(Property.ARITHMETIC, statement, min(margins, default=Fraction(0)), Fraction(0), advice=advice)


def certify_refined(task: Task, design: RefinedDesign, edge_error: Sequence[Fraction]) -> Certificate:
    """Certify P1 to P6 of the exact tube, with P7's error, in whole units of the table, required as margin of P1 to P5.

    The tube is cubic on K segments and constant after t_c, so P1 to P6 are finitely many comparisons. edge_error: by dimension.
    """
    tube = _CertifiedTube(task, design, units_of_error(design, edge_error) * design.unit, design.bezier())
    width, widths, speed = tube.width(), minimum_widths(task), design.edge_speed_bounds()
    start = tuple((int(a) * design.unit, int(b) * design.unit) for a, b in tube.bezier[0, :, :, 0])
    return Certificate(
        findings=(
            width,
            *tube.start(),
            tube.stay(),
            tube.avoid(),
            *([] if task.target_set is None else [tube.reach()]),
            _smooth_finding(task, design, tube.bezier, speed),
            *_acceleration_findings(task, design, tube.bezier),
        ),
        edge_error=tuple(edge_error),
        speed=speed,
        minimum_width=width.margin + widths[0] if len(set(widths)) == 1 else design.smallest_hull_width(),
        start=start,
        covers_initial_set=all(
            1000 * max(start[i][0] - a, b - start[i][1]) <= b - a
            for i, (a, b) in enumerate(zip(task.start.lower, task.start.upper, strict=True))
        ),
    )


# --------------------------------------------------------------------------------- the single properties


@dataclass(frozen=True)
class _CertifiedTube:
    """A task and a design, with the Bezier coefficients and P7's error, which all findings need."""

    task: Task
    design: RefinedDesign
    error: Fraction
    bezier: npt.NDArray[np.int64]

    def always(self, subject: Property, statement: str, block: ConstraintBlock) -> Finding:
        """Return the finding of constraints that must hold for all t: the smallest slack over all segments."""
        smallest = smallest_slack(self.bezier, block, self.error / self.design.unit)
        required = self.error * max(c.distance_error for c in block.constraints)
        name = block.names[smallest.set_index] if block.names else None
        return self._located_finding(subject, statement, smallest, required, (block.constraints[smallest.constraint], name))

    def _located_finding(
        self,
        subject: Property,
        statement: str,
        smallest: LocatedSlack,
        required: Fraction,
        location: tuple[Constraint, str | None],
    ) -> Finding:
        """Return a finding with the location of its smallest slack; location: its constraint, and the name of its set."""
        (constraint, name), scale = location, self.design.prescribed_time / self.design.segments
        time = (smallest.interval[0] * scale, smallest.interval[1] * scale)
        dimension = None if constraint.dimension is None else constraint.dimension + 1
        return Finding(subject, statement, smallest.slack * self.design.unit, required, time, dimension=dimension, obstacle=name)

    def at(
        self, subject: Property, statement: str, constraints: Sequence[Constraint], point: tuple[int, int], *, advice: str = ""
    ) -> Finding:
        """Return the finding of constraints about one moment, 0 or t_c.

        point: a segment and one of its control points, which is an edge at this moment.
        """
        segment, k = point
        edges, unit = self.bezier[segment, :, :, k], self.design.unit
        left = [sum((c * int(edges[i, side]) for i, side, c in row.terms), Fraction(0)) * unit for row in constraints]
        slack = [
            (value - row.bound - row.clearance) / row.slack_per_distance for value, row in zip(left, constraints, strict=True)
        ]
        margins = [value - self.error * row.distance_error for value, row in zip(slack, constraints, strict=True)]
        worst = margins.index(min(margins))
        time = Fraction(0) if segment == 0 else self.design.prescribed_time
        index = constraints[worst].dimension
        dimension = None if index is None else index + 1
        return Finding(subject, statement, slack[worst], self.error, (time, time), dimension=dimension, advice=advice)

    def width(self) -> Finding:
        """Return the finding of P1; the arithmetic may move both edges, so twice its error is required."""
        block = ConstraintBlock.of(width_constraints(self.task), self.design.unit)
        return self.always(Property.WIDTH, width_statement(self.task), block)

    def start(self) -> list[Finding]:
        """Return the findings of P2: x(0) inside gamma(0), and gamma(0) within the initial set."""
        inside, within, advice = "x(0) inside gamma(0)", "gamma(0) within the initial set", "design the tube again"
        return [
            self.at(Property.START, inside, initial_state_constraints(self.task), (0, 0)),
            self.at(Property.START, within, start_constraints(self.task), (0, 0), advice=advice),
        ]

    def stay(self) -> Finding:
        """Return the finding of P3: both edges within the state space, less the body's half extents."""
        statement = "gamma within the state space" + (" less the body" if any(self.task.half_extents) else "")
        block = ConstraintBlock.of(stay_constraints(self.task), self.design.unit)
        return self.always(Property.STAY, statement, block)

    def avoid(self) -> Finding:
        """Return the finding of P4: at every moment at least the clearance from every unsafe set, along one of its normals."""
        sets = avoidances(self.task)
        if not sets:
            return Finding(Property.AVOID, "there is no unsafe set", Fraction(0), Fraction(0))
        statement = clearance_statement(self.task, len(sets))
        if all(avoidance.course is None for avoidance in sets):
            return self.always(Property.AVOID, statement, ConstraintBlock.choice(sets, self.design.unit))
        uncertainty = [f"start_delay {decimal(self.task.start_delay)} s"] if self.task.start_delay else []
        uncertainty += [f"timing of {s.name} {decimal(s.timing)} s" for s in self.task.unsafe if s.timing]
        within = f", within {', '.join(uncertainty)}" if uncertainty else ""
        return self.avoid_moving(sets, f"{statement}, as they are stated to move{within}")

    def avoid_moving(self, sets: Sequence[Avoidance], statement: str) -> Finding:
        """Return the finding of P4 where some sets move, or are unsafe only at times."""
        design, distance_error = self.design, max(c.distance_error for s in sets for c in s.alternatives)
        required = self.error / design.unit * distance_error
        candidates = [(smallest_moving_slack(s, design, required), s, s.alternatives) for s in sets if s.course is not None]
        standing = [s for s in sets if s.course is None]
        if standing:
            block = ConstraintBlock.choice(standing, design.unit)
            smallest = smallest_slack(self.bezier, block, self.error / design.unit)
            candidates.append((smallest, standing[smallest.set_index], block.constraints))
        smallest, avoidance, constraints = min(candidates, key=lambda candidate: candidate[0].slack)
        location = (constraints[smallest.constraint], avoidance.name)
        return self._located_finding(Property.AVOID, statement, smallest, self.error * distance_error, location)

    def reach(self) -> Finding:
        """Return the finding of P5: gamma(t_c) within the target set, where it then stays."""
        return self.at(Property.REACH, "gamma(t_c) within the target set", reach_constraints(self.task), (-1, 3))


def _derivative(design: RefinedDesign, bezier: npt.NDArray[np.int64], order: int) -> tuple[npt.NDArray[np.int64], Fraction]:
    """Return the Bezier coefficients of the edges' derivative of that order, whole numbers, and their unit."""
    for degree in range(3, 3 - order, -1):
        bezier = degree * np.diff(bezier, axis=3)
    return bezier, design.unit * (Fraction(design.segments) / design.prescribed_time) ** order


def _smooth_finding(task: Task, design: RefinedDesign, bezier: npt.NDArray[np.int64], speed: tuple[Fraction, ...]) -> Finding:
    """Return the finding of P6 about rates: C2 inside (a uniform cubic B-spline is), C1 at t_c, and within max_speed.

    For order 2 the tube must be C2 at t_c too, and for a tube that repeats itself where it begins again.
    """
    statement = "gamma is C2, C1 at t_c" if task.order == 1 else "gamma is C2, at t_c too"
    statement = statement if design.seam is None else "gamma is C2, also where it begins again"
    if design.kink(task.order).any():
        return _kink_finding(task, design, statement)
    bound = ", ".join(f"{above(v, 4):g}" for v in speed)
    statement = f"{statement}; |gammadot| <= {bound}"
    return _limited_finding(design, bezier, speed_constraints(task), statement, "max_speed") or Finding(
        Property.SMOOTH, statement, Fraction(0), Fraction(0)
    )


def _kink_finding(task: Task, design: RefinedDesign, statement: str) -> Finding:
    """Return the finding of a tube that is not smooth enough at t_c."""
    if design.seam is not None:
        advice = "the last three control points must be those with which the cycle begins"
    elif task.order == 1:
        statement, advice = "gamma is C2 up to t_c and C1 there", "the last control point must equal the last but two"
    else:
        advice = "the last three control points must agree"
    kink, time = design.kink(task.order), (design.prescribed_time, design.prescribed_time)
    i = int(kink.argmax())
    margin = -Fraction(int(kink[i])) * design.unit
    return Finding(Property.SMOOTH, statement, margin, Fraction(0), time, dimension=i + 1, advice=advice)


def _acceleration_findings(task: Task, design: RefinedDesign, bezier: npt.NDArray[np.int64]) -> tuple[Finding, ...]:
    """Return the finding of P6 about the second derivative, where the task bounds it; from t_c on gamma stands still."""
    second, unit = _derivative(design, bezier, 2)
    bound = ", ".join(f"{above(int(v) * unit, 4):g}" for v in np.abs(second).max(axis=(0, 2, 3)))
    when = " before t_c" if design.seam is None else ""
    statement, constraints = f"|gammaddot| <= {bound}{when}", acceleration_constraints(task)
    finding = _limited_finding(design, bezier, constraints, statement, "max_acceleration")
    return () if finding is None else (finding,)


def _limited_finding(
    design: RefinedDesign, bezier: npt.NDArray[np.int64], constraints: Sequence[Constraint], statement: str, option: str
) -> Finding | None:
    """Return the finding of P6 for constraints on rates or accelerations, four for each dimension; None without them."""
    slack = []
    for constraint in constraints:
        edges, unit = _derivative(design, bezier, constraint.order)
        left = np.sum([c * edges[:, i, side] for i, side, c in constraint.terms], axis=0)
        slack.append(int(left.min()) * unit - constraint.bound)
    if not slack:
        return None
    worst = slack.index(min(slack))
    limit = by_component([-constraint.bound for constraint in constraints[::4]])
    index, advice = constraints[worst].dimension, f"raise tube.{option} or prescribed_time"
    dimension = None if index is None else index + 1
    return Finding(
        Property.SMOOTH,
        f"{statement}, within {option} {limit}",
        slack[worst],
        Fraction(0),
        None,
        dimension=dimension,
        advice=advice,
    )
