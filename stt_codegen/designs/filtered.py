"""The filtered tube of a design, for plants of order 2. With z = v + lambda x, the state stays in (L, R) while z stays in

    (A, B) = (L' + lambda L, R' + lambda R)

because (R - x)' = (B - z) - lambda (R - x), and the same at L. At an edge of the filtered tube u must outdo the plant bounds and

    lambda^2 (R - L) + L''   at the lower edge,      lambda^2 (R - L) - R''   at the upper edge

(lemmas `filtered.*`). Of a spline both are cubics on every segment, with Bezier coefficients that are exact here. The design
search, the certificate, the controller and the sampling conditions read them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs.refined import RefinedDesign

LOWER, UPPER = 0, 1


@dataclass(frozen=True)
class BezierPieces:
    """Bezier coefficients of degree 3 for every segment, dimension and side: (K, n, 2, 4) whole numbers, multiples of `unit`."""

    coefficients: npt.NDArray[Any]
    unit: Fraction

    def floats(self) -> npt.NDArray[np.float64]:
        """Return the coefficients as doubles, each rounded."""
        return np.asarray(self.coefficients.astype(float) * float(self.unit))


@dataclass(frozen=True)
class _Scale:
    """The factors that make all coefficients whole numbers: K/t_c = a/b, and lambda_i = numerators_i/common."""

    a: int
    b: int
    numerators: npt.NDArray[Any]
    common: int

    @classmethod
    def of(cls, design: RefinedDesign) -> _Scale:
        per_second = design.segments / Fraction(design.prescribed_time)
        common = math.lcm(*(v.denominator for v in design.filter))
        numerators = np.array([int(v * common) for v in design.filter], dtype=object)[None, :, None, None]
        return cls(per_second.numerator, per_second.denominator, numerators, common)


def filtered_edges(design: RefinedDesign) -> BezierPieces:
    """Return A and B, in units per second."""
    scale, edges = _Scale.of(design), design.bezier().astype(object)
    step = np.diff(edges, axis=3)
    d0, d1, d2 = (step[..., j] for j in range(3))
    rate = np.stack([3 * d0, d0 + 2 * d1, 2 * d1 + d2, 3 * d2], axis=-1)
    coefficients = scale.a * scale.common * rate + scale.b * scale.numerators * edges
    return BezierPieces(coefficients, design.unit / (scale.b * scale.common))


def demanded_accelerations(design: RefinedDesign) -> BezierPieces:
    """Return what the tube's own motion demands of u, in units per second squared.

    That is lambda^2 (R - L) + L'' at the lower edge, and the negative of the demand, R'' - lambda^2 (R - L), at the upper edge.
    """
    scale, edges = _Scale.of(design), design.bezier().astype(object)
    second_difference = np.diff(edges, n=2, axis=3)
    first, last = second_difference[..., 0], second_difference[..., 1]
    edge_acceleration = np.stack([6 * first, 4 * first + 2 * last, 2 * first + 4 * last, 6 * last], axis=-1)
    width = edges[:, :, UPPER] - edges[:, :, LOWER]
    from_width = (scale.b * scale.numerators[:, :, 0]) ** 2 * width
    coefficients = (scale.a * scale.common) ** 2 * edge_acceleration
    coefficients[:, :, LOWER] += from_width
    coefficients[:, :, UPPER] -= from_width
    return BezierPieces(coefficients, design.unit / (scale.b * scale.common) ** 2)


def slopes_at_start(design: RefinedDesign) -> list[tuple[Fraction, Fraction]]:
    """Return L'(0) and R'(0) by dimension, in units per second."""
    step = 3 * np.diff(design.bezier()[0], axis=-1)[..., 0]
    value = design.unit * design.segments / Fraction(design.prescribed_time)
    return [(int(a) * value, int(b) * value) for a, b in step.tolist()]
