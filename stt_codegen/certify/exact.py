"""P1 to P6 for a refined tube, in exact integer arithmetic.

The coefficients are integers in units of 2**-bits. The bound of a row (stt_codegen/constraints.py, an exact decimal) enters as
the least integer not below it in these units, so every comparison is between integers and nothing is rounded the wrong way. A
cubic lies within the hull of its Bezier coefficients; where that is too coarse the piece is halved by de Casteljau's rule,
exactly.
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
from stt_codegen.certify.limits import certify_limits
from stt_codegen.certify.missions import certify_mission
from stt_codegen.certify.moving_slack import least_moving
from stt_codegen.certify.slack import RowBlock, least_slack
from stt_codegen.constraints import (
    Avoidance,
    Constraint,
    acceleration_constraints,
    avoidances,
    initial_state_constraints,
    minimum_width,
    reach_constraints,
    speed_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.controller import edge_error, rate_error
from stt_codegen.decimals import above, by_component, decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.program import Program
from stt_codegen.properties import Property
from stt_codegen.task import Task


def certify_emitted(task: Task, design: RefinedDesign, program: Program) -> Certificate:
    """P1 to P7 for the emitted tube; P8 where u is limited and the plant has bounds, P9 where there is a period, P10 where there
    is a mission."""
    error = edge_error(design, program)
    certificate = certify_refined(task, design, error)
    of_mission, mission = certify_mission(task, design, units_of_error(design, error))
    of_arithmetic = Finding(
        Property.ARITHMETIC,
        f"{_arithmetic(program)} arithmetic moves no edge by more than {above(max(error), 2):g}",
        min(
            (f.margin - f.required for f in (*certificate.findings, *of_mission) if f.required > 0 and not f.in_time),
            default=Fraction(0),
        ),
        Fraction(0),
        advice=(
            'the task needs more room than single precision leaves: use emit.scalar = "double", shift the origin, or, where the '
            "tube is fast, raise prescribed_time"
            if program.scalar == "float"
            else 'the task needs more room than integers of 15 bits leave: use emit.scalar = "float", shift the origin, or raise '
            "prescribed_time"
            if program.scalar == "fixed"
            else f"the task needs more room than the tube's grid leaves: {Property.ARITHMETIC.advice}"
        ),
    )
    rate = rate_error(design, program) if task.order == 2 else ()
    certificate = replace(certificate, rate_error=rate, mission=mission)
    of_limits = certify_inertia(task, design, error, rate) if task.order == 2 else certify_limits(task, design)
    if task.control.period is None or (task.order == 2 and not all(f.holds for f in of_limits)):
        return replace(certificate, findings=(*certificate.findings, of_arithmetic, *of_limits, *of_mission))
    from stt_codegen.certify.sampled import certify_period

    of_period, proved = certify_period(task, design, error, rate)
    findings = (*certificate.findings, of_arithmetic, *of_limits, of_period, *of_mission)
    return replace(certificate, findings=findings, proved_period=proved)


def _arithmetic(program: Program) -> str:
    return "integer" if program.scalar == "fixed" else program.scalar


def certify_refined(task: Task, design: RefinedDesign, edge_error: Sequence[Fraction]) -> Certificate:
    """P1-P6 for the exact tube, with P7's `edge_error` (by dimension), in whole units of the table, demanded as margin of P1-P5.

    The tube is cubic on K segments and constant after t_c, so P1-P6 are finitely many comparisons.
    """
    tube = _Tube(task, design, units_of_error(design, edge_error) * design.unit, design.bezier())
    width, speed = tube.width(), _speed(design, tube.bezier)
    start = tuple((int(a) * design.unit, int(b) * design.unit) for a, b in tube.bezier[0, :, :, 0])
    return Certificate(
        findings=(
            width,
            *tube.start(),
            tube.stay(),
            tube.avoid(),
            *([] if task.target_set is None else [tube.reach()]),
            _smooth(task, design, tube.bezier, speed),
            *_accelerated(task, design, tube.bezier),
        ),
        edge_error=tuple(edge_error),
        speed=speed,
        least_width=width.margin + minimum_width(task),
        start=start,
        whole_start=all(
            1000 * max(start[i][0] - a, b - start[i][1]) <= b - a
            for i, (a, b) in enumerate(zip(task.start.lower, task.start.upper, strict=True))
        ),
    )


# --------------------------------------------------------------------------------- the single properties


@dataclass(frozen=True)
class _Tube:
    """A task and a design, with what every finding needs: the Bezier coefficients and P7's error."""

    task: Task
    design: RefinedDesign
    error: Fraction
    bezier: npt.NDArray[np.int64]

    def always(self, subject: Property, statement: str, block: RowBlock) -> Finding:
        """The finding of rows that must hold for all t: the least slack over all segments, and where it is."""
        least = least_slack(self.bezier, block, self.error / self.design.unit)
        scale = self.design.prescribed_time / self.design.segments
        chosen = block.rows[least.row]
        needed = max(row.distance_error for row in block.rows)  # what least_slack has asked of every row
        return Finding(
            subject, statement, least.slack * self.design.unit, self.error * needed,
            (least.interval[0] * scale, least.interval[1] * scale), None if chosen.dimension is None else chosen.dimension + 1,
            block.names[least.choice] if block.names else None,
        )  # fmt: skip

    def at(
        self, subject: Property, statement: str, rows: Sequence[Constraint], piece: int, point: int, advice: str = ""
    ) -> Finding:
        """The finding of rows about one moment, the control point `point` of segment `piece`: 0 or t_c."""
        edges, unit = self.bezier[piece, :, :, point], self.design.unit
        left = [sum((c * int(edges[i, side]) for i, side, c in row.terms), Fraction(0)) * unit for row in rows]
        slack = [(value - row.bound - row.clearance) / row.slack_per_distance for value, row in zip(left, rows, strict=True)]
        room = [value - self.error * row.distance_error for value, row in zip(slack, rows, strict=True)]
        row = room.index(min(room))
        time = Fraction(0) if piece == 0 else self.design.prescribed_time
        where = rows[row].dimension
        return Finding(
            subject, statement, slack[row], self.error, (time, time), None if where is None else where + 1, None, advice
        )

    def width(self) -> Finding:
        """P1: both edges may move by the arithmetic, so twice its error is demanded."""
        statement = f"width >= {decimal(minimum_width(self.task))} in every dimension"
        return self.always(Property.WIDTH, statement, RowBlock.of(width_constraints(self.task), self.design.unit))

    def start(self) -> list[Finding]:
        """P2: x(0) inside gamma(0), and gamma(0) within the initial set."""
        inside, within = "x(0) inside gamma(0)", "gamma(0) within the initial set"
        return [
            self.at(Property.START, inside, initial_state_constraints(self.task), 0, 0),
            self.at(Property.START, within, start_constraints(self.task), 0, 0, "design the tube again"),
        ]

    def stay(self) -> Finding:
        """P3: both edges within the state space, for the body's middle."""
        statement = "gamma within the state space" + (" less the body" if any(self.task.half_extents) else "")
        block = RowBlock.of(stay_constraints(self.task), self.design.unit)
        return self.always(Property.STAY, statement, block)

    def avoid(self) -> Finding:
        """P4: at every moment at least the clearance from every unsafe set, along one of its normals."""
        sets = avoidances(self.task)
        if not sets:
            return Finding(Property.AVOID, "there is no unsafe set", Fraction(0), Fraction(0))
        statement = f"gamma at least {decimal(self.task.tube.clearance)} from each of {len(sets)} unsafe sets"
        standing = [one for one in sets if one.course is None]
        if len(standing) == len(sets):
            return self.always(Property.AVOID, statement, RowBlock.choice(sets, self.design.unit))
        doubt = [f"start_delay {decimal(self.task.start_delay)} s"] if self.task.start_delay else []
        doubt += [f"timing of {s.name} {decimal(s.timing)} s" for s in self.task.unsafe if s.timing]
        told = f", within {', '.join(doubt)}" if doubt else ""
        return self.avoid_moving(sets, standing, f"{statement}, as they are stated to move{told}")

    def avoid_moving(self, sets: Sequence[Avoidance], standing: Sequence[Avoidance], statement: str) -> Finding:
        """P4 where some sets move, or are unsafe only at times."""
        design, needed = self.design, max(row.distance_error for one in sets for row in one.alternatives)
        required = self.error / design.unit * needed
        found = [(least_moving(one, design, required), one) for one in sets if one.course is not None]
        if standing:
            least = least_slack(self.bezier, RowBlock.choice(standing, design.unit), self.error / design.unit)
            found.append((least, standing[least.choice]))
        least, one = min(found, key=lambda pair: pair[0].slack)
        rows = one.alternatives if one.course is not None else tuple(row for other in standing for row in other.alternatives)
        scale, where = design.prescribed_time / design.segments, rows[least.row].dimension
        return Finding(
            Property.AVOID, statement, least.slack * design.unit, self.error * needed,
            (least.interval[0] * scale, least.interval[1] * scale), None if where is None else where + 1, one.name,
        )  # fmt: skip

    def reach(self) -> Finding:
        """P5: gamma(t_c) within the target set, and held there."""
        return self.at(Property.REACH, "gamma(t_c) within the target set", reach_constraints(self.task), -1, 3)


def _derivative(design: RefinedDesign, bezier: npt.NDArray[np.int64], order: int) -> tuple[npt.NDArray[np.int64], Fraction]:
    """Bezier coefficients of the edges' derivative of that order, in whole numbers, and the value of one."""
    for degree in range(3, 3 - order, -1):
        bezier = degree * np.diff(bezier, axis=3)
    return bezier, design.unit * (Fraction(design.segments) / design.prescribed_time) ** order


def _speed(design: RefinedDesign, bezier: npt.NDArray[np.int64]) -> tuple[Fraction, ...]:
    """A bound on |gammadot| by dimension."""
    rate, unit = _derivative(design, bezier, 1)
    return tuple(int(v) * unit for v in np.abs(rate).max(axis=(0, 2, 3)))


def _smooth(task: Task, design: RefinedDesign, bezier: npt.NDArray[np.int64], speed: tuple[Fraction, ...]) -> Finding:
    """P6: C2 inside (a uniform cubic B-spline is), C1 at t_c, for order 2 C2 there too, and within max_speed when the task bounds
    it."""
    at = (design.prescribed_time, design.prescribed_time)
    kink = design.kink(task.order)
    smooth = "gamma is C2, C1 at t_c" if task.order == 1 else "gamma is C2, at t_c too"
    smooth = smooth if design.seam is None else "gamma is C2, also where it begins again"
    if kink.any() and design.seam is not None:
        i = int(kink.argmax())
        advice = "the last three control points must be those with which the cycle begins"
        return Finding(Property.SMOOTH, smooth, -Fraction(int(kink[i])) * design.unit, Fraction(0), at, i + 1, None, advice)
    if kink.any():
        i = int(kink.argmax())
        told, advice = (
            ("gamma is C2 up to t_c and C1 there", "the last control point must equal the last but two")
            if task.order == 1
            else (smooth, "the last three control points must agree")
        )
        return Finding(Property.SMOOTH, told, -Fraction(int(kink[i])) * design.unit, Fraction(0), at, i + 1, None, advice)
    bound = ", ".join(f"{above(v, 4):g}" for v in speed)
    statement = f"{smooth}; |gammadot| <= {bound}"
    return _limited(design, bezier, speed_constraints(task), statement, "max_speed") or Finding(
        Property.SMOOTH, statement, Fraction(0), Fraction(0)
    )


def _accelerated(task: Task, design: RefinedDesign, bezier: npt.NDArray[np.int64]) -> tuple[Finding, ...]:
    """P6, second derivative: within max_acceleration before t_c, when the task bounds it; from t_c on gamma stands still."""
    second, unit = _derivative(design, bezier, 2)
    bound = ", ".join(f"{above(int(v) * unit, 4):g}" for v in np.abs(second).max(axis=(0, 2, 3)))
    when = " before t_c" if design.seam is None else ""
    found = _limited(design, bezier, acceleration_constraints(task), f"|gammaddot| <= {bound}{when}", "max_acceleration")
    return () if found is None else (found,)


def _limited(
    design: RefinedDesign, bezier: npt.NDArray[np.int64], rows: Sequence[Constraint], statement: str, option: str
) -> Finding | None:
    """P6 for rows of rates or accelerations, four for each dimension; None where there are none."""
    slack = []
    for row in rows:
        edges, unit = _derivative(design, bezier, row.order)
        left = np.sum([c * edges[:, i, side] for i, side, c in row.terms], axis=0)
        slack.append(int(left.min()) * unit - row.bound)
    if not slack:
        return None
    worst = slack.index(min(slack))
    dimension = rows[worst].dimension
    told = f"{statement}, within {option} {by_component([-row.bound for row in rows[::4]])}"
    where = None if dimension is None else dimension + 1
    return Finding(Property.SMOOTH, told, slack[worst], Fraction(0), None, where, None, f"raise tube.{option} or prescribed_time")
