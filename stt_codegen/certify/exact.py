"""P1 to P6 for a refined tube, in exact integer arithmetic.

The coefficients are integers in units of 2**-bits. A bound v from the task (an exact decimal) enters as the integer
floor or ceiling of v / 2**-bits, on the safe side, so every comparison is between integers and nothing is rounded the
wrong way. A cubic lies within the hull of its Bezier coefficients; where that is too coarse the piece is halved by
de Casteljau's rule, exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Certificate, Finding, above
from stt_codegen.controller.component import LEAST_WIDTH
from stt_codegen.design.tube import LOWER, UPPER, RefinedDesign
from stt_codegen.task import Task
from stt_codegen.wording import decimal

DEPTH = 20  # a piece is halved at most this often before its property counts as failed

Pieces = npt.NDArray[Any]  # Bezier coefficients (P, n, 2, 4): int64, or Fraction objects once halved


@dataclass(frozen=True)
class _Least:
    """Least slack in units of the table: where, in spline time, and which dimension and unsafe set it concerns."""

    slack: Fraction
    interval: tuple[Fraction, Fraction]
    dimension: int | None = None
    obstacle: int | None = None


Measure = Callable[[Pieces], tuple[npt.NDArray[Any], npt.NDArray[np.int64], npt.NDArray[np.int64]]]


def certify_refined(task: Task, design: RefinedDesign, edge_error: Sequence[Fraction]) -> Certificate:
    """Check P1-P6 for the exact tube, demanding P7's `edge_error` (by dimension) as margin of P1-P5.

    The tube is cubic on K segments and constant after t_c, so P1-P6 are finitely many comparisons.
    """
    error = max(edge_error)
    bezier = design.bezier()
    width = _width(task, design, bezier, error)
    speed = _speed(design, bezier)
    start = tuple((int(a) * design.unit, int(b) * design.unit) for a, b in bezier[0, :, :, 0])
    return Certificate(
        findings=(
            width,
            *_start(task, design, bezier[0, :, :, 0], error),
            _stay(task, design, bezier, error),
            _avoid(task, design, bezier, error),
            _reach(task, design, bezier[-1, :, :, 3], error),
            _smooth(task, design, speed),
        ),
        edge_error=tuple(edge_error),
        speed=speed,
        least_width=width.margin + _least_width(task),
        start=start,
        whole_start=all(
            1000 * max(start[i][0] - a, b - start[i][1]) <= b - a
            for i, (a, b) in enumerate(zip(task.initial_set.lower, task.initial_set.upper, strict=True))
        ),
    )


# --------------------------------------------------------------------------------- the single properties


def _found(
    task: Task, design: RefinedDesign, code: str, statement: str, least: _Least, required: Fraction, advice: str
) -> Finding:
    """A finding from the least slack over all pieces, with its place in seconds."""
    scale = design.prescribed_time / design.segments
    return Finding(
        code,
        statement,
        least.slack * design.unit,
        required,
        (least.interval[0] * scale, least.interval[1] * scale),
        None if least.dimension is None else least.dimension + 1,
        None if least.obstacle is None else task.grown_unsafe[least.obstacle].name,
        advice,
    )


def _least_width(task: Task) -> Fraction:
    """What P1 demands: below LEAST_WIDTH the emitted law is another."""
    return max(task.tube.min_width, LEAST_WIDTH)


def _width(task: Task, design: RefinedDesign, bezier: Pieces, error: Fraction) -> Finding:
    """P1: both edges may move by the arithmetic, so twice its error is demanded."""
    least = _least_width(task)
    slack = _least(bezier, _width_measure(units_above(least, design.unit)), 2 * error / design.unit)
    advice = "lower tube.min_width, or leave tube.segments out so that a finer tube is tried"
    return _found(task, design, "P1", f"width >= {decimal(least)} in every dimension", slack, 2 * error, advice)


def _stay(task: Task, design: RefinedDesign, bezier: Pieces, error: Fraction) -> Finding:
    """P3."""
    space, unit = task.free_space, design.unit
    measure = _stay_measure([units_above(v, unit) for v in space.lower], [units_below(v, unit) for v in space.upper])
    statement = "gamma within the state space" + (" less the body" if task.body and any(task.body) else "")
    slack = _least(bezier, measure, error / unit)
    return _found(task, design, "P3", statement, slack, error, "enlarge the state space there, or design the tube again")


def _avoid(task: Task, design: RefinedDesign, bezier: Pieces, error: Fraction) -> Finding:
    """P4."""
    unsafe, unit, clearance = task.grown_unsafe, design.unit, task.tube.clearance
    if not unsafe:
        return Finding("P4", "there is no unsafe set", Fraction(0), Fraction(0))
    measure = _avoid_measure(
        [[units_below(v - clearance, unit) for v in s.lower] for s in unsafe],
        [[units_above(v + clearance, unit) for v in s.upper] for s in unsafe],
    )
    statement = f"gamma at least {decimal(clearance)} from each of {len(unsafe)} unsafe sets"
    slack = _least(bezier, measure, error / unit)
    return _found(task, design, "P4", statement, slack, error, "lower tube.clearance or tube.min_width, or move the unsafe set")


def _start(task: Task, design: RefinedDesign, start: npt.NDArray[np.int64], error: Fraction) -> list[Finding]:
    """P2: x(0) inside gamma(0), and gamma(0) within the initial set."""
    unit = design.unit
    inside, within = [], []
    for i in range(task.dimension):
        lower, upper = int(start[i, LOWER]) * unit, int(start[i, UPPER]) * unit
        inside.append(min(task.initial_state[i] - lower, upper - task.initial_state[i]))
        within.append(min(lower - task.initial_set.lower[i], task.initial_set.upper[i] - upper))
    at = (Fraction(0), Fraction(0))
    first, second = inside.index(min(inside)), within.index(min(within))
    return [
        Finding(
            "P2", "x(0) inside gamma(0)", inside[first], error, at, first + 1, None, "move initial_state inside the initial set"
        ),
        Finding("P2", "gamma(0) within the initial set", within[second], error, at, second + 1, None, "design the tube again"),
    ]


def _reach(task: Task, design: RefinedDesign, end: npt.NDArray[np.int64], error: Fraction) -> Finding:
    """P5: gamma(t_c) within the target set, and held there."""
    slack = [
        min(
            int(end[i, LOWER]) * design.unit - task.target_set.lower[i],
            task.target_set.upper[i] - int(end[i, UPPER]) * design.unit,
        )
        for i in range(task.dimension)
    ]
    i = slack.index(min(slack))
    at = (design.prescribed_time, design.prescribed_time)
    return Finding("P5", "gamma(t_c) within the target set", slack[i], error, at, i + 1, None, "widen the target set")


def _speed(design: RefinedDesign, bezier: npt.NDArray[np.int64]) -> tuple[Fraction, ...]:
    """A bound on |gammadot| by dimension: 3 (K / t_c) times the largest step between Bezier coefficients."""
    steps = np.abs(np.diff(bezier, axis=3)).max(axis=(0, 2, 3))
    return tuple(3 * int(v) * design.unit * design.segments / design.prescribed_time for v in steps)


def _smooth(task: Task, design: RefinedDesign, speed: tuple[Fraction, ...]) -> Finding:
    """P6: C2 inside (a uniform cubic B-spline is), C1 at t_c, and within max_speed when the task bounds it."""
    at = (design.prescribed_time, design.prescribed_time)
    table = design.integers()
    kink = np.abs(table[-1] - table[-3]).max(axis=1)
    if kink.any():
        i = int(kink.argmax())
        return Finding(
            "P6", "gamma is C2 up to t_c and C1 there", -Fraction(int(kink[i])) * design.unit, Fraction(0), at, i + 1, None,
            "the last control point must equal the last but two",
        )  # fmt: skip
    bound = ", ".join(f"{above(v, 4):g}" for v in speed)
    statement = f"gamma is C2, C1 at t_c; |gammadot| <= {bound}"
    if task.tube.max_speed is None:
        return Finding("P6", statement, Fraction(0), Fraction(0))
    i = speed.index(max(speed))
    return Finding(
        "P6", f"{statement}, within max_speed {decimal(task.tube.max_speed)}", task.tube.max_speed - speed[i], Fraction(0),
        None, i + 1, None, "raise tube.max_speed or prescribed_time",
    )  # fmt: skip


# -------------------------------------------------------------------------------- slack of Bezier pieces


def _width_measure(least: int) -> Measure:
    def measure(pieces: Pieces) -> Any:
        slack = (pieces[:, :, UPPER] - pieces[:, :, LOWER]).min(axis=2) - least  # (P, n)
        return _pick(slack)

    return measure


def _stay_measure(lower: list[int], upper: list[int]) -> Measure:
    def measure(pieces: Pieces) -> Any:
        low = pieces[:, :, LOWER].min(axis=2) - np.array(lower)
        high = np.array(upper) - pieces[:, :, UPPER].max(axis=2)
        return _pick(np.minimum(low, high))

    return measure


def _avoid_measure(lower: list[list[int]], upper: list[list[int]]) -> Measure:
    """Slack of the best separating dimension and side for each piece and set; the worst set is picked."""
    low, high = np.array(lower), np.array(upper)  # (J, n)

    def measure(pieces: Pieces) -> Any:
        below = low[None] - pieces[:, :, UPPER].max(axis=2)[:, None]  # (P, J, n)
        above = pieces[:, :, LOWER].min(axis=2)[:, None] - high[None]
        best = np.maximum(below, above)
        dimension = best.argmax(axis=2)
        slack = best.max(axis=2)
        worst = slack.argmin(axis=1)
        rows = np.arange(len(pieces))
        return slack[rows, worst], dimension[rows, worst], worst

    return measure


def _pick(slack: npt.NDArray[Any]) -> Any:
    i = slack.argmin(axis=1)
    return slack[np.arange(len(slack)), i], i, np.full(len(slack), -1)


def _least(bezier: npt.NDArray[np.int64], measure: Measure, required: Fraction) -> _Least:
    """The least slack over all segments, halving those whose hull does not show `required` (in units)."""
    slack, dimension, obstacle = measure(bezier)

    def least(k: int) -> _Least:
        interval = (Fraction(k), Fraction(k + 1))
        if slack[k] < required:
            return _halve(bezier[k].astype(object), interval, measure, required, DEPTH)
        return _least_of(slack[k], interval, dimension[k], obstacle[k])

    doubtful = [k for k in range(len(bezier)) if slack[k] < required]
    sound = [k for k in range(len(bezier)) if slack[k] >= required]
    candidates = [least(k) for k in doubtful]
    if sound:
        candidates.append(least(min(sound, key=lambda k: slack[k])))
    return min(candidates, key=lambda c: c.slack)


def _halve(piece: Pieces, interval: tuple[Fraction, Fraction], measure: Measure, required: Fraction, depth: int) -> _Least:
    """Least slack of one piece (shape (n, 2, 4)) by halving until the hull shows `required` or `depth` is used up; the
    slack at one failing point as soon as one is met."""
    slack, dimension, obstacle = measure(piece[None])
    if slack[0] >= required or depth == 0:
        return _least_of(slack[0], interval, dimension[0], obstacle[0])
    at_start = measure(np.repeat(piece[None, ..., :1], 4, axis=-1))
    if at_start[0][0] < required:  # the curve itself fails here: halving cannot help
        return _least_of(at_start[0][0], (interval[0], interval[0]), at_start[1][0], at_start[2][0])
    early, late = halves(piece * Fraction(1))
    middle = (interval[0] + interval[1]) / 2
    first = _halve(early, (interval[0], middle), measure, required, depth - 1)
    second = _halve(late, (middle, interval[1]), measure, required, depth - 1)
    return first if first.slack <= second.slack else second


def halves(piece: Pieces) -> tuple[Pieces, Pieces]:
    """The Bezier coefficients of both halves of cubics (the last axis), by de Casteljau's rule."""
    c0, c1, c2, c3 = (piece[..., j] for j in range(4))
    a, b, c = (c0 + c1) / 2, (c1 + c2) / 2, (c2 + c3) / 2
    d, e = (a + b) / 2, (b + c) / 2
    f = (d + e) / 2
    return np.stack([c0, a, d, f], axis=-1), np.stack([f, e, c, c3], axis=-1)


def _least_of(slack: Any, interval: tuple[Fraction, Fraction], dimension: Any, obstacle: Any) -> _Least:
    exact = slack if isinstance(slack, Fraction) else Fraction(int(slack))
    return _Least(exact, interval, int(dimension), None if obstacle < 0 else int(obstacle))


def units_above(value: Fraction, unit: Fraction) -> int:
    """The least whole number of units that is not below the value."""
    return math.ceil(value / unit)


def units_below(value: Fraction, unit: Fraction) -> int:
    """The largest whole number of units that is not above the value."""
    return math.floor(value / unit)
