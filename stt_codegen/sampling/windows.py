"""A certified tube in time windows, with bounds for each on its width, the speed of its edges, the rate of its width, and x.

All bounds are rounded outward. The sampling conditions and the bounds on u use them; the lemma `sampled.windows` shows that they
hold. Refined tubes have one window for each segment, and only the last rounding is inexact. Adaptive tubes have windows of
several cells, all with the speed that P6 proves (certify/adaptive/enclosure.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.designs import LOWER, UPPER, RefinedDesign
from stt_codegen.sampling.numbers import DOUBLES, Numbers

Array = npt.NDArray[Any]
OUTWARD_MARGIN = 2.0**-48  # relative; more than the roundings of a quotient or product of doubles


@dataclass(frozen=True, kw_only=True)
class Windows:
    """W time windows, and one more from t_c on.

    times: (W + 1) boundaries, seconds. start: gamma(0), lower and upper, rounded inward, (n, 2). All other fields are (W + 1, n):
    narrow <= gamma_d <= wide, |edge rate| <= speed, |gammadot_d| <= widening, low <= gamma_L, gamma_U <= high.
    """

    times: Array
    narrow: Array
    wide: Array
    speed: Array
    widening: Array
    low: Array
    high: Array
    start: Array

    @property
    def shortest(self) -> Any:
        """The length of the shortest window before t_c, in seconds."""
        return min(np.diff(self.times).tolist())


@dataclass(frozen=True, kw_only=True)
class BezierExtremes:
    """Extremes of a refined tube's Bezier coefficients in each segment, and from t_c on: whole units of the table, (K + 1, n).

    step, width_step: the largest |difference| of neighbouring coefficients, of the edges and of the width. 3 K/t_c times a step
    bounds a rate (the lemma `sampled.windows`).
    """

    narrow: Array
    wide: Array
    step: Array
    width_step: Array
    low: Array
    high: Array


def extremes(design: RefinedDesign) -> BezierExtremes:
    """Return the extremes of every segment, int64; they are below 6 * 2^50, so doubles hold them exactly."""
    bezier = design.windows()
    width = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    return BezierExtremes(
        narrow=width.min(axis=-1),
        wide=width.max(axis=-1),
        step=design.largest_steps(),
        width_step=np.abs(np.diff(width, axis=-1)).max(axis=-1),
        low=bezier[:, :, LOWER].min(axis=-1),
        high=bezier[:, :, UPPER].max(axis=-1),
    )


def refined_windows(design: RefinedDesign, numbers: Numbers = DOUBLES) -> Windows:
    """Return one window for each segment.

    In doubles, products with the unit, a power of 2, are exact; those with `per_second` are rounded outward.
    """
    bounds, unit = extremes(design), numbers.of(design.unit)
    rate = Fraction(3 * design.segments) / design.prescribed_time
    per_second = numbers.outward(numbers.of(rate), OUTWARD_MARGIN) * unit
    return Windows(
        times=numbers.evenly(Fraction(design.prescribed_time), design.segments),
        narrow=bounds.narrow * unit,
        wide=bounds.wide * unit,
        speed=bounds.step * per_second,
        widening=bounds.width_step * per_second,
        low=bounds.low * unit,
        high=bounds.high * unit,
        start=design.bezier()[0, :, :, 0] * unit,
    )
