"""The truth about a tube for a plant of order 2, besides P1 to P6 of `tubes.py`: from the definitions of the filtered tube alone,
in fractions, with Sturm's theorem (`sturm.py`). Nothing of `stt_codegen` is used but the data of task and design.

With edges L < R, W = R - L, lambda by component, F the bound on |f + w| and on g's cross terms, and u as large as the C allows:

    P1   W' + lambda W >= 2^-20: the width of the filtered tube, in which z = v + lambda x must stay
    P2   at 0, z is strictly between L' + lambda L and R' + lambda R for every start that is claimed
    P6   L and R are at rest at t_c: their first and second derivatives vanish
    P8   g_min u - F > max(lambda^2 W + L'', lambda^2 W - R''): the acceleration that keeps z inside at either edge

Where P8 fails strictly a state in the set leaves it whatever |u| <= u_max is; `leaving_state` finds one. docs/paper.md has the
law, docs/certificate.md the properties.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from benchmarks.oracles.sturm import (
    HALF,
    Polynomial,
    differentiate,
    evaluate,
    linear_combination,
    negative_point,
    nonpositive_point,
    polynomial,
)
from benchmarks.oracles.tubes import SMALLEST_WIDTH, Fault
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.task.task import Task

# Of four control points, times 6, by powers of s.
SPLINE_WEIGHTS = ((1, -3, 3, -1), (4, 0, -6, 3), (1, 3, 3, -3), (0, 0, 0, 1))
SIGNIFICANT_BITS = {"float": 24, "double": 53}  # of the C's numbers


# ------------------------------------------------------------------------------------------------ the tube


@dataclass(frozen=True)
class SplinePiece:
    """One component in one segment, by s in [0, 1]: the edges L and R in the task's units."""

    lower: Polynomial
    upper: Polynomial
    segments_per_second: Fraction
    lambda_: Fraction

    def time_derivative(self, p: Polynomial) -> Polynomial:
        return linear_combination((self.segments_per_second, differentiate(p)))

    @property
    def width(self) -> Polynomial:
        return linear_combination((1, self.upper), (-1, self.lower))

    @property
    def filtered_width(self) -> Polynomial:
        """W' + lambda W, the width of the filtered tube."""
        return linear_combination((1, self.time_derivative(self.width)), (self.lambda_, self.width))

    @property
    def demanded_accelerations(self) -> tuple[Polynomial, Polynomial]:
        """lambda^2 W + L'' and lambda^2 W - R'', inwards, at the lower edge and at the upper one."""
        low, high = (self.time_derivative(self.time_derivative(p)) for p in (self.lower, self.upper))
        square = self.lambda_**2
        return linear_combination((square, self.width), (1, low)), linear_combination((square, self.width), (-1, high))


def spline_piece(design: RefinedDesign, k: int, i: int) -> SplinePiece:
    """Return component i in segment k of a design."""
    rows = design.table[k : k + 4]
    lower, upper = (
        polynomial(design.unit * sum(w[m] * row[i][side] for w, row in zip(SPLINE_WEIGHTS, rows, strict=True)) for m in range(4))
        for side in (0, 1)
    )
    return SplinePiece(lower, upper, Fraction(design.segments) / design.prescribed_time, design.filter[i])


def emitted_input_limits(task: Task) -> list[Fraction]:
    """Return u_max as the C has it: the largest numbers of the scalar that are not above. Empty where u is not limited."""
    bits = SIGNIFICANT_BITS[task.emit.scalar]
    limits = []
    for v in task.u_max or ():
        step = Fraction(2) ** (math.frexp(float(v))[1] - bits)
        step *= 2 if v / step >= 1 << bits else HALF if v / step < 1 << (bits - 1) else 1
        limits.append(math.floor(v / step) * step)
    return limits


def control_authority(task: Task) -> list[Fraction] | None:
    """Return g_min u_max - F by component, with the other inputs at their limits. None where the task does not claim P8."""
    plant = task.plant
    bounds = (plant.f_max, plant.w_max, plant.g_min, plant.g_max, plant.g_cross)
    if task.control.u_max is None or task.control.period is not None or all(v is None for v in bounds):
        return None
    u, force, cross = emitted_input_limits(task), (plant.f_max or 0) + (plant.w_max or 0), plant.g_cross or 0
    return [smallest_g(task) * v - force - cross * (sum(u) - v) for v in u]


def smallest_g(task: Task) -> Fraction:
    """Return g_min; where the task does not state it 1, or g_max if that is smaller."""
    low, high = task.plant.g_min, task.plant.g_max
    return low if low is not None else Fraction(1) if high is None else min(Fraction(1), high)


def order_two_faults(
    task: Task, design: RefinedDesign, units: Fraction | int = 0, segments: Iterable[int] | None = None
) -> Iterator[Fault]:
    """Yield where a property of order 2 fails.

    units: margin, in table units, of the rates and accelerations of an edge (by segment's time); segments: those that are looked
    at, all by default."""
    rate, t_c = Fraction(design.segments) / design.prescribed_time, design.prescribed_time
    available, margin = control_authority(task), units * design.unit
    for i in range(task.dimension):
        first, last = spline_piece(design, 0, i), spline_piece(design, design.segments - 1, i)
        distance = min(_start_distances(task, first, i)) - margin * rate
        if distance < 0 or (task.start_speed[i] and distance == 0):  # at rest no start is on the edge itself
            yield Fault("P2 z" if distance else "P2 z, on the edge", Fraction(0), i)
        for edge in (last.lower, last.upper):
            speed = last.time_derivative(edge)
            if evaluate(speed, Fraction(1)) or evaluate(last.time_derivative(speed), Fraction(1)):
                yield Fault("P6", t_c, i)
        for k in range(design.segments) if segments is None else segments:
            piece = spline_piece(design, k, i)
            s = negative_point(linear_combination((1, piece.filtered_width), (-1, polynomial((SMALLEST_WIDTH + margin * rate,)))))
            if s is not None:
                yield Fault("P1 z", (k + s) / rate, i)
            for required in piece.demanded_accelerations if available is not None else ():
                allowed = polynomial((available[i] - margin * rate**2,))
                s = nonpositive_point(linear_combination((1, allowed), (-1, required)))
                if s is not None:
                    yield Fault("P8", (k + s) / rate, i)


def _start_distances(task: Task, first: SplinePiece, i: int) -> tuple[Fraction, Fraction]:
    """Return the smallest distance of z at 0 to the lower edge of the filtered tube and to the upper one, over all starts.

    At rest a start is anywhere between the edges, so only the rate of an edge separates z from it. With a speed the starts are
    the start share, its bounds included."""
    rates = [evaluate(first.time_derivative(p), Fraction(0)) for p in (first.lower, first.upper)]
    speed, width = task.start_speed[i], evaluate(first.width, Fraction(0))
    inside = first.lambda_ * (1 - task.initial_set.share) / 2 * width - speed if speed else Fraction(0)
    return inside - rates[0], inside + rates[1]


def first_order_two_fault(
    task: Task, design: RefinedDesign, units: Fraction | int = 0, segments: Iterable[int] | None = None
) -> Fault | None:
    """Return a property of order 2 that fails, as in `order_two_faults`; None where all hold."""
    return next(order_two_faults(task, design, units, segments), None)


def property_that_hulls_miss(task: Task, design: RefinedDesign, width_margin: Fraction, units: int) -> str:
    """Return which property the hull of a whole segment's Bezier ordinates does not show; empty where it shows all.

    So a certificate that halves no segment may refuse a safe tube. width_margin: of the filtered tube's width; units: of the
    acceleration, as in `order_two_faults`."""
    available, rate = control_authority(task), Fraction(design.segments) / design.prescribed_time
    for i in range(task.dimension):
        for k in range(design.segments):
            piece = spline_piece(design, k, i)
            if min(_bezier_ordinates(piece.filtered_width)) < SMALLEST_WIDTH + width_margin:
                return "P1 z"
            if available is None:
                continue
            required = max(v for p in piece.demanded_accelerations for v in _bezier_ordinates(p))
            if required > available[i] - units * design.unit * rate**2:
                return "P8"
    return ""


def _bezier_ordinates(p: Polynomial) -> list[Fraction]:
    """Return the ordinates of degree 3."""
    a, b, c, d = (*p, *[Fraction(0)] * (4 - len(p)))
    return [a, a + b / 3, a + 2 * b / 3 + c / 3, a + b + c + d]


def largest_demanded_acceleration(design: RefinedDesign, i: int) -> Fraction:
    """Return the largest acceleration that a component requires at either edge: a value that it takes, in doubles next to the
    maximum."""
    largest = []
    for k in range(design.segments):
        for p in spline_piece(design, k, i).demanded_accelerations:
            a, b, c = (float(v) for v in (*differentiate(p), *[Fraction(0)] * 3)[:3])
            root = math.sqrt(max(b * b - 4 * a * c, 0.0))
            stationary = [(-b + sign * root) / (2 * c) for sign in (1, -1)] if c else [-a / b] if b else []
            points = [Fraction(0), Fraction(1), *(Fraction(s) for s in stationary if 0 < s < 1)]
            largest.append(max(evaluate(p, s) for s in points))
    return max(largest)


# ------------------------------------------------------------------------------------------------ a state that leaves


@dataclass(frozen=True)
class LeavingState:
    """A state of one component, in the tube and in the filtered tube, that leaves the latter whatever |u| <= u_max is.

    It is outside `seconds` after `time` if f + w = F towards the edge and g = g_min. side: 1 for the upper edge, 0 for the lower
    one; acceleration: with u at its limit against it."""

    time: Fraction
    dimension: int
    side: int
    x: Fraction
    v: Fraction
    acceleration: Fraction
    seconds: Fraction


def leaving_state(task: Task, design: RefinedDesign, fault: Fault) -> LeavingState | None:
    """Find a state that leaves where P8 fails: x next to the far edge, z next to the near one.

    Returns None where the filtered tube has no width there, or where required and available acceleration are equal, so that no
    state leaves."""
    available, rate, i = control_authority(task), Fraction(design.segments) / design.prescribed_time, fault.dimension
    assert available is not None
    assert i is not None
    k = min(math.floor(fault.time * rate), design.segments - 1)
    s = fault.time * rate - k
    for nudged in (s, *(s + sign * HALF**j for j in range(4, 40) for sign in (1, -1))):
        if not 0 <= nudged < 1:
            continue
        for side in (1, 0):
            piece = spline_piece(design, k, i)
            leaving = _leaves_above(piece if side else _upside_down(piece), nudged, available[i])
            if leaving is not None:
                x, v, seconds = leaving
                sign = 1 if side else -1
                return LeavingState((k + nudged) / rate, i, side, sign * x, sign * v, -sign * available[i], seconds)
    return None


def _upside_down(piece: SplinePiece) -> SplinePiece:
    """Return the piece mirrored at 0, whose upper edge is minus the lower one."""
    lower, upper = linear_combination((-1, piece.upper)), linear_combination((-1, piece.lower))
    return SplinePiece(lower, upper, piece.segments_per_second, piece.lambda_)


def _leaves_above(piece: SplinePiece, s: Fraction, available: Fraction) -> tuple[Fraction, Fraction, Fraction] | None:
    """Return x and v at s, and the seconds after which z is above the upper edge of the filtered tube; None where none is
    found."""
    required, width = evaluate(piece.demanded_accelerations[1], s), evaluate(piece.width, s)
    lacking, filtered_width = required - available, evaluate(piece.filtered_width, s)
    if lacking <= 0 or width <= 0 or filtered_width <= 0:
        return None
    x = evaluate(piece.lower, s) + min(width / 2, lacking / (4 * piece.lambda_**2))
    edge = linear_combination((1, piece.time_derivative(piece.upper)), (piece.lambda_, piece.upper))  # R' + lambda R
    for j in range(80):
        seconds = (1 - s) / piece.segments_per_second * HALF**j
        distance = min(seconds * lacking / 8, filtered_width / 2)
        v = evaluate(edge, s) - piece.lambda_ * x - distance
        later_v, later_x = v - available * seconds, x + v * seconds - available * seconds**2 / 2
        if later_v + piece.lambda_ * later_x >= evaluate(edge, s + seconds * piece.segments_per_second):
            return x, v, seconds
    return None
