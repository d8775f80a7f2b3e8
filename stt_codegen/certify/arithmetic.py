"""P7: a bound on how far the emitted arithmetic moves an edge of a refined tube.

Two causes. *Time*: the emitted u is fl(t * fl(K/t_c)), within K (2 eps + eps^2) of K t / t_c (eps half a unit in the
last place of 1), and the comparison with fl(t_c) moves the end by no more than that again; the edge then moves by its
steepest slope times that. *Evaluation*: weights and blend, bounded by the `rounding` reader over the very kernels that
are printed. s = u - floor(u) is exact. The table is exact.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from stt_codegen.design.tube import RefinedDesign
from stt_codegen.program.number import FORMATS
from stt_codegen.program.program import Program
from stt_codegen.program.rounding import Inexact, rounding_error


def time_error(design: RefinedDesign, scalar: str) -> Fraction:
    """Bound on the error of the emitted spline time u, in segments."""
    eps = FORMATS[scalar].roundoff
    return design.segments * (4 * eps + 4 * eps * eps) + FORMATS[scalar].tiny


def edge_error(design: RefinedDesign, program: Program) -> tuple[Fraction, ...]:
    """By dimension, a bound on |emitted edge - gamma(t)| for every finite t, in the task's units."""
    slope = np.abs(np.diff(design.bezier(), axis=3)).max(axis=(0, 2, 3))
    late = time_error(design, program.scalar)
    weights = rounding_error(program.kernel("basis"), {"s": Inexact(Fraction(0), Fraction(1))}, program.scalar)
    result = []
    for i in range(design.dimension):
        largest = int(np.abs(design.integers()[:, i]).max()) * design.unit
        names = program.kernel("blend").inputs
        inputs = dict(zip([v.name for v in names[:4]], weights, strict=True))
        inputs |= {v.name: Inexact(-largest, largest) for v in names[4:]}
        (edge,) = rounding_error(program.kernel("blend"), inputs, program.scalar)
        result.append(_short(edge.error + late * 3 * int(slope[i]) * design.unit))
    return tuple(result)


def rate_error(design: RefinedDesign, program: Program) -> tuple[Fraction, ...]:
    """By dimension, a bound on |emitted rate - gammadot(t)| for every finite t, in units per second."""
    scalar = program.scalar
    form = FORMATS[scalar]
    bend = np.abs(np.diff(design.bezier(), n=2, axis=3)).max(axis=(0, 2, 3))
    slope = np.abs(np.diff(design.bezier(), axis=3)).max(axis=(0, 2, 3))
    weights = rounding_error(program.kernel("basis_rate"), {"s": Inexact(Fraction(0), Fraction(1))}, scalar)
    per_second = design.segments / design.prescribed_time
    result = []
    for i in range(design.dimension):
        largest = int(np.abs(design.integers()[:, i]).max()) * design.unit
        names = program.kernel("blend").inputs
        inputs = dict(zip([v.name for v in names[:4]], weights, strict=True))
        inputs |= {v.name: Inexact(-largest, largest) for v in names[4:]}
        (edge,) = rounding_error(program.kernel("blend"), inputs, scalar)
        steepest = 3 * int(slope[i]) * design.unit
        error = edge.error + time_error(design, scalar) * 6 * int(bend[i]) * design.unit
        total = error * per_second * (1 + form.roundoff) + (steepest + error) * per_second * 2 * form.roundoff
        result.append(_short(total + form.tiny))
    return tuple(result)


def _short(value: Fraction) -> Fraction:
    """A slightly larger fraction with a short numerator, so that later arithmetic stays quick."""
    if value == 0:
        return value
    shift = value.denominator.bit_length() - value.numerator.bit_length() + 16
    unit = Fraction(1, 1 << max(shift, 0))
    return -(-value // unit) * unit
