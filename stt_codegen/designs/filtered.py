"""A tube filtered, for plants of order 2: with z = v + lambda x, the state stays in (L, R) while z stays in

    (A, B) = (L' + lambda L, R' + lambda R)

because (R - x)' = (B - z) - lambda (R - x), and the same at L. At an edge of the filtered tube u must outdo what pushes z, and

    lambda^2 (R - L) + L''   at the lower one,      lambda^2 (R - L) - R''   at the upper one

(lemmas `filtered.*`). Of a spline both are cubics on every segment, with Bezier coefficients that are exact here.
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
class Pieces:
    """Bezier coefficients of degree 3 for every segment, dimension and side: (K, n, 2, 4) whole numbers, multiples of `unit`."""

    coefficients: npt.NDArray[Any]
    unit: Fraction

    def floats(self) -> npt.NDArray[np.float64]:
        """As doubles, each rounded."""
        return np.asarray(self.coefficients.astype(float) * float(self.unit))


@dataclass(frozen=True)
class _Scale:
    """K/t_c = a/b, lambda_i = whole_i/common."""

    a: int
    b: int
    whole: npt.NDArray[Any]
    common: int

    @classmethod
    def of(cls, design: RefinedDesign) -> _Scale:
        per_second = design.segments / Fraction(design.prescribed_time)
        common = math.lcm(*(v.denominator for v in design.filter))
        whole = np.array([int(v * common) for v in design.filter], dtype=object)[None, :, None, None]
        return cls(per_second.numerator, per_second.denominator, whole, common)


def filtered(design: RefinedDesign) -> Pieces:
    """A and B, in units per second."""
    scale, edges = _Scale.of(design), design.bezier().astype(object)
    step = np.diff(edges, axis=3)
    d0, d1, d2 = (step[..., j] for j in range(3))
    rate = np.stack([3 * d0, d0 + 2 * d1, 2 * d1 + d2, 3 * d2], axis=-1)
    whole = scale.a * scale.common * rate + scale.b * scale.whole * edges
    return Pieces(whole, design.unit / (scale.b * scale.common))


def pressed(design: RefinedDesign) -> Pieces:
    """What the tube's own motion asks of u: lambda^2 (R - L) + L'' at the lower edge, and less that at the upper one, R'' -
    lambda^2 (R - L); in units per second squared."""
    scale, edges = _Scale.of(design), design.bezier().astype(object)
    turn = np.diff(edges, n=2, axis=3)
    first, last = turn[..., 0], turn[..., 1]
    bend = np.stack([6 * first, 4 * first + 2 * last, 2 * first + 4 * last, 6 * last], axis=-1)
    width = edges[:, :, UPPER] - edges[:, :, LOWER]
    press = (scale.b * scale.whole[:, :, 0]) ** 2 * width
    whole = (scale.a * scale.common) ** 2 * bend
    whole[:, :, LOWER] += press
    whole[:, :, UPPER] -= press
    return Pieces(whole, design.unit / (scale.b * scale.common) ** 2)


def slopes_at_start(design: RefinedDesign) -> list[tuple[Fraction, Fraction]]:
    """L'(0) and R'(0) by dimension, in units per second."""
    step = 3 * np.diff(design.bezier()[0], axis=-1)[..., 0]
    value = design.unit * design.segments / Fraction(design.prescribed_time)
    return [(int(a) * value, int(b) * value) for a, b in step.tolist()]
