"""P7: bounds on how far the emitted arithmetic moves an edge of a refined tube, and its rate.

There are two causes; eps is half a unit in the last place of 1. *Time.* The emitted u is fl(t * fl(K/t_c)), within K (2 eps +
eps^2) of K t / t_c, clamped to the largest number below K, which is at most 2 K eps below K. So u is within K (2 eps + eps^2) of
the exact one for every t. Twice that is allowed: the other half is for a t that was itself rounded, as `ticks / 1000` is. The
edge then moves by its steepest slope times that error. *Evaluation.* Weights and blend round by at most 123 eps + 441 eps^2 of
the largest control point of the dimension, those of a rate by 175 eps + 568 eps^2. The statements are the same in every
controller, so these constants are too; the checker uses them (checker/stt_checker/rounding.py says where they come from), and
tests derive them from the kernels that are printed. s = u - floor(u) is exact, and so is the table of control points.

The certificate, the design and compare/ call this file. The lemma `refined.late` is about `rounded_time_error`.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.controller.integers import integer_errors
from stt_codegen.designs import RefinedDesign
from stt_codegen.program import FORMATS, Program
from stt_codegen.task import Task

EDGE_FACTORS, RATE_FACTORS = (123, 441), (175, 568)  # of eps and of eps^2, times the largest control point
TINY_FACTOR = 200  # of half the least subnormal number, times one more than the largest control point


def spline_time_error(design: RefinedDesign, scalar: str) -> Fraction:
    """Bound the error of the emitted spline time u, in segments; t itself may be rounded once."""
    return Fraction(rounded_time_error(design.segments, FORMATS[scalar].roundoff)) + FORMATS[scalar].tiny


def rounded_time_error(segments: Any, eps: Any) -> Any:
    """Bound the error of spline time without underflow. The lemma `refined.late` calls this with symbols."""
    return segments * (4 * eps + 4 * eps * eps)


def edge_and_rate_errors(
    design: RefinedDesign, program: Program | None, tick: Fraction | None = None
) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """Return `edge_error` and, for order 2, `rate_error`; else () for the latter.

    program: None for a controller in integers before its program is built; then `tick` is the length of a tick in seconds."""
    tick = tick if program is None else program.tick
    if tick is not None:
        return integer_errors.edge_error(design, tick), integer_errors.rate_error(design, tick) if design.filter else ()
    assert program is not None
    return edge_error(design, program), rate_error(design, program) if design.filter else ()


def edge_error(design: RefinedDesign, program: Program) -> tuple[Fraction, ...]:
    """Bound |emitted edge - gamma(t)| for every finite t, by dimension, in the task's units."""
    if program.tick is not None:
        return integer_errors.edge_error(design, program.tick)
    return _edge_error(design, program.scalar)


def edge_error_of_design(task: Task, design: RefinedDesign) -> tuple[Fraction, ...]:
    """Derive `edge_error` before there is a program, for floats and doubles: the kernels of a tube are the same for all tasks."""
    return _edge_error(design, task.emit.scalar)


def _edge_error(design: RefinedDesign, scalar: str) -> tuple[Fraction, ...]:
    """Bound the error of an edge by dimension: that of its evaluation, and its steepest slope times the error of time."""
    largest_steps = design.largest_steps().max(axis=0)  # between Bezier control points; 3 of them bound a slope by segment
    time_error = spline_time_error(design, scalar)
    slopes = [3 * int(step) * design.unit for step in largest_steps]
    evaluation_errors = _evaluation_errors(design, scalar, EDGE_FACTORS)
    return tuple(_rounded_up(e + time_error * slope) for e, slope in zip(evaluation_errors, slopes, strict=True))


def rate_error(design: RefinedDesign, program: Program) -> tuple[Fraction, ...]:
    """Bound |emitted rate - gammadot(t)| for every finite t, by dimension, in units per second."""
    if program.tick is not None:
        return integer_errors.rate_error(design, program.tick)
    number_format = FORMATS[program.scalar]
    largest_bends = np.abs(np.diff(design.bezier(), n=2, axis=3)).max(axis=(0, 2, 3))
    largest_steps = design.largest_steps().max(axis=0)
    segments_per_second = design.segments / design.prescribed_time
    time_error = spline_time_error(design, program.scalar)
    errors = []
    for i, evaluation_error in enumerate(_evaluation_errors(design, program.scalar, RATE_FACTORS)):
        slope_error = evaluation_error + time_error * 6 * int(largest_bends[i]) * design.unit
        steepest_slope = 3 * int(largest_steps[i]) * design.unit
        scaling_error = (steepest_slope + slope_error) * segments_per_second * 2 * number_format.roundoff
        error = slope_error * segments_per_second * (1 + number_format.roundoff) + scaling_error
        errors.append(_rounded_up(error + number_format.tiny))
    return tuple(errors)


def _evaluation_errors(design: RefinedDesign, scalar: str, factors: tuple[int, int]) -> list[Fraction]:
    """Bound, by dimension, the rounding of weights and of their sum with control points. factors: EDGE_FACTORS or
    RATE_FACTORS."""
    eps, tiny = FORMATS[scalar].roundoff, FORMATS[scalar].tiny
    largest_points = [int(np.abs(design.integers()[:, i]).max()) * design.unit for i in range(design.dimension)]
    factor = factors[0] * eps + factors[1] * eps**2
    return [largest * factor + TINY_FACTOR * (largest + 1) * tiny for largest in largest_points]


def _rounded_up(value: Fraction) -> Fraction:
    """Return a slightly larger fraction with a short numerator, about 17 bits, so that later arithmetic stays quick."""
    if value == 0:
        return value
    shift = value.denominator.bit_length() - value.numerator.bit_length() + 16
    unit = Fraction(1, 1 << max(shift, 0))
    return -(-value // unit) * unit
