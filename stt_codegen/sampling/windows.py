"""A certified tube cut into time windows, with what the statements about effort and sampling need of each: bounds on its
width, on the speed of its edges, on the rate of its width, and on the place where it is. All rounded outward.

Refined tubes have a window for each segment, exact but for the last rounding; enclosed ones (certify/enclosure.py) have their
cells' places joined, and the one speed of P6.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import LOWER, UPPER, RefinedDesign

Array = npt.NDArray[Any]
OUT = 1 + 2.0**-48  # more than the few roundings of a quotient or product of doubles


@dataclass(frozen=True)
class Windows:
    """W time windows and last the one from t_c on. times: (W + 1) boundaries, seconds. start: gamma(0), (n, 2). The rest is
    (W + 1, n): narrow <= gamma_d <= wide, |edge rate| <= speed, |gammadot_d| <= widening, low <= gamma_L, gamma_U <= high."""

    times: Array
    narrow: Array
    wide: Array
    speed: Array
    widening: Array
    low: Array
    high: Array
    start: Array  # gamma(0), lower and upper, rounded inward: (n, 2)

    @property
    def shortest(self) -> float:
        """The length of the shortest window before t_c, in seconds."""
        return float(np.diff(self.times).min())


def refined_windows(design: RefinedDesign) -> Windows:
    """A window for each segment, from its Bezier coefficients: integers below 2^27 in units of a power of 2, so that sums and
    differences are exact doubles."""
    unit = float(design.unit)
    bezier = design.bezier()  # (K, n, 2, 4)
    last = np.repeat(bezier[-1:, ..., 3:], 4, axis=-1)
    bezier = np.concatenate([bezier, last])
    per_second = float(Fraction(3 * design.segments) / design.prescribed_time) * OUT * unit
    width = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    times = np.linspace(0.0, float(design.prescribed_time), design.segments + 1)
    return Windows(
        times,
        width.min(axis=-1) * unit,
        width.max(axis=-1) * unit,
        np.abs(np.diff(bezier, axis=-1)).max(axis=(2, 3)) * per_second,
        np.abs(np.diff(width, axis=-1)).max(axis=-1) * per_second,
        bezier[:, :, LOWER].min(axis=-1) * unit,
        bezier[:, :, UPPER].max(axis=-1) * unit,
        bezier[0, :, :, 0] * unit,
    )
