"""P7: a bound on how far the emitted arithmetic moves an edge of a refined tube.

Two causes. *Time*: the emitted u is fl(t * fl(K/t_c)), within K (2 eps + eps^2) of K t / t_c (eps half a unit in the last
place of 1), held at the last number below K, which is at most 2 K eps below it; so u is within K (2 eps + eps^2) of the true
one for every t. Twice that is allowed: the other half is room for a t that was itself rounded, as `ticks / 1000` is. The edge
then moves by its steepest slope times that. *Evaluation*: weights and blend, bounded by the
`rounding` reader over the very kernels that are printed. s = u - floor(u) is exact. The table is exact.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from stt_codegen.controller.integers import integer_errors
from stt_codegen.controller.kernels import kernels_of_the_tube
from stt_codegen.designs import RefinedDesign
from stt_codegen.program import FORMATS, Kernel, Program
from stt_codegen.program.analyse import Inexact, rounding_error
from stt_codegen.task import Task


def time_error(design: RefinedDesign, scalar: str) -> Fraction:
    """Bound on the error of the emitted spline time u, in segments; t itself may be rounded once."""
    return Fraction(late(design.segments, FORMATS[scalar].roundoff)) + FORMATS[scalar].tiny


def late(segments: Any, eps: Any) -> Any:
    """The same without the least subnormal, for numbers or symbols: the lemma `refined.late` is about this very function."""
    return segments * (4 * eps + 4 * eps * eps)


def errors_of_tube(
    design: RefinedDesign, program: Program | None, tick: Fraction | None = None
) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """`edge_error` and, for order 2, `rate_error`. tick: seconds, of a controller in integers, whose program is still to come."""
    tick = tick if program is None else program.tick
    if tick is not None:
        return integer_errors.edge_error(design, tick), integer_errors.rate_error(design, tick) if design.filter else ()
    assert program is not None
    return edge_error(design, program), rate_error(design, program) if design.filter else ()


def edge_error(design: RefinedDesign, program: Program) -> tuple[Fraction, ...]:
    """By dimension, a bound on |emitted edge - gamma(t)| for every finite t, in the task's units."""
    if program.tick is not None:
        return integer_errors.edge_error(design, program.tick)
    return _edge_error(design, program.kernel("basis"), program.kernel("blend"), program.scalar)


def edge_error_of_design(task: Task, design: RefinedDesign) -> tuple[Fraction, ...]:
    """Derive `edge_error` before there is a program, for floats and doubles: the kernels of a tube are the same for all tasks."""
    basis, _, blend = kernels_of_the_tube()
    return _edge_error(design, basis, blend, task.emit.scalar)


@lru_cache(maxsize=4)  # asked for when a tube is designed, when a program is made, and again for its certificate
def _edge_error(design: RefinedDesign, basis: Kernel, blend: Kernel, scalar: str) -> tuple[Fraction, ...]:
    slope = design.largest_steps().max(axis=0)
    late = time_error(design, scalar)
    evaluation = _blend_error(design, basis, blend, scalar)
    return tuple(_short(e + late * 3 * int(v) * design.unit) for e, v in zip(evaluation, slope, strict=True))


def rate_error(design: RefinedDesign, program: Program) -> tuple[Fraction, ...]:
    """By dimension, a bound on |emitted rate - gammadot(t)| for every finite t, in units per second."""
    if program.tick is not None:
        return integer_errors.rate_error(design, program.tick)
    form = FORMATS[program.scalar]
    bend = np.abs(np.diff(design.bezier(), n=2, axis=3)).max(axis=(0, 2, 3))
    slope = design.largest_steps().max(axis=0)
    per_second = design.segments / design.prescribed_time
    late = time_error(design, program.scalar)
    result = []
    blended = _blend_error(design, program.kernel("basis_rate"), program.kernel("blend"), program.scalar)
    for i, evaluation in enumerate(blended):
        error = evaluation + late * 6 * int(bend[i]) * design.unit
        steepest = 3 * int(slope[i]) * design.unit
        total = error * per_second * (1 + form.roundoff) + (steepest + error) * per_second * 2 * form.roundoff
        result.append(_short(total + form.tiny))
    return tuple(result)


def _blend_error(design: RefinedDesign, weights: Kernel, blend: Kernel, scalar: str) -> list[Fraction]:
    """By dimension, the rounding error of weights (a kernel of s in [0, 1]) and blend for its largest coefficient."""
    values = rounding_error(weights, {"s": Inexact(Fraction(0), Fraction(1))}, scalar)
    names = [v.name for v in blend.inputs]
    result = []
    for i in range(design.dimension):
        largest = int(np.abs(design.integers()[:, i]).max()) * design.unit
        inputs = dict(zip(names[:4], values, strict=True)) | dict.fromkeys(names[4:], Inexact(-largest, largest))
        (edge,) = rounding_error(blend, inputs, scalar)
        result.append(edge.error)
    return result


def _short(value: Fraction) -> Fraction:
    """A slightly larger fraction with a short numerator, so that later arithmetic stays quick."""
    if value == 0:
        return value
    shift = value.denominator.bit_length() - value.numerator.bit_length() + 16
    unit = Fraction(1, 1 << max(shift, 0))
    return -(-value // unit) * unit
