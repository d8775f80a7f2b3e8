"""P7: bounds on how far the emitted arithmetic moves an edge of a refined tube, and its rate.

There are two causes; eps is half a unit in the last place of 1. *Time.* The emitted u is fl(t * fl(K/t_c)), within K (2 eps +
eps^2) of K t / t_c, clamped to the largest number below K, which is at most 2 K eps below K. So u is within K (2 eps + eps^2) of
the exact one for every t. Twice that is allowed: the other half is for a t that was itself rounded, as `ticks / 1000` is. The
edge then moves by its steepest slope times that error. *Evaluation.* `rounding_error` bounds the rounding of weights and blend
from the kernels that are printed. s = u - floor(u) is exact, and so is the table of control points.

The certificate, the design and compare/ call this file. The lemma `refined.late` is about `rounded_time_error`.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from stt_codegen.controller.integers import integer_errors
from stt_codegen.controller.kernels import build_blending_kernels
from stt_codegen.designs import RefinedDesign
from stt_codegen.program import FORMATS, Kernel, Program
from stt_codegen.program.analyse import Inexact, rounding_error
from stt_codegen.task import Task


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
    return _edge_error(design, program.kernel("basis"), program.kernel("blend"), program.scalar)


def edge_error_of_design(task: Task, design: RefinedDesign) -> tuple[Fraction, ...]:
    """Derive `edge_error` before there is a program, for floats and doubles: the kernels of a tube are the same for all tasks."""
    basis, _, blend = build_blending_kernels()
    return _edge_error(design, basis, blend, task.emit.scalar)


@lru_cache(maxsize=4)  # the design, the program and the certificate need the same bound
def _edge_error(design: RefinedDesign, basis: Kernel, blend: Kernel, scalar: str) -> tuple[Fraction, ...]:
    """Bound the error of an edge by dimension: that of its evaluation, and its steepest slope times the error of time."""
    largest_steps = design.largest_steps().max(axis=0)  # between Bezier control points; 3 of them bound a slope by segment
    time_error = spline_time_error(design, scalar)
    evaluation_errors = _blend_error(design, basis, blend, scalar)
    slopes = [3 * int(step) * design.unit for step in largest_steps]
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
    evaluation_errors = _blend_error(design, program.kernel("basis_rate"), program.kernel("blend"), program.scalar)
    for i, evaluation_error in enumerate(evaluation_errors):
        slope_error = evaluation_error + time_error * 6 * int(largest_bends[i]) * design.unit
        steepest_slope = 3 * int(largest_steps[i]) * design.unit
        scaling_error = (steepest_slope + slope_error) * segments_per_second * 2 * number_format.roundoff
        error = slope_error * segments_per_second * (1 + number_format.roundoff) + scaling_error
        errors.append(_rounded_up(error + number_format.tiny))
    return tuple(errors)


def _blend_error(design: RefinedDesign, weights_kernel: Kernel, blend: Kernel, scalar: str) -> list[Fraction]:
    """Bound the rounding of weights, a kernel of s in [0, 1], and of the blend of the largest control points, by dimension."""
    weights = rounding_error(weights_kernel, {"s": Inexact(Fraction(0), Fraction(1))}, scalar)
    names = [v.name for v in blend.inputs]
    errors = []
    for i in range(design.dimension):
        largest = int(np.abs(design.integers()[:, i]).max()) * design.unit
        inputs = dict(zip(names[:4], weights, strict=True)) | dict.fromkeys(names[4:], Inexact(-largest, largest))
        (edge,) = rounding_error(blend, inputs, scalar)
        errors.append(edge.error)
    return errors


def _rounded_up(value: Fraction) -> Fraction:
    """Return a slightly larger fraction with a short numerator, about 17 bits, so that later arithmetic stays quick."""
    if value == 0:
        return value
    shift = value.denominator.bit_length() - value.numerator.bit_length() + 16
    unit = Fraction(1, 1 << max(shift, 0))
    return -(-value // unit) * unit
