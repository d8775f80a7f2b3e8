"""A certified tube cut into time windows, with what the statements about effort and sampling need of each: bounds on its
width, on the speed of its edges, on the rate of its width, and on the place where it is. All rounded outward.

Refined tubes have a window for each segment, exact but for the last rounding; enclosed ones (certify/adaptive/enclosure.py) have
their cells' places joined, and the one speed of P6.
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
OUT = 2.0**-48  # as a share: more than the few roundings of a quotient or product of doubles


@dataclass(frozen=True, kw_only=True)
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
    def shortest(self) -> Any:
        """The length of the shortest window before t_c, in seconds."""
        return min(np.diff(self.times).tolist())


@dataclass(frozen=True, kw_only=True)
class Extremes:
    """What the Bezier coefficients of a refined tube say of every segment, and last of the time from t_c on: whole numbers, in
    units of the table, (K + 1, n). step, width_step: the largest |difference| of neighbouring coefficients, of the edges and of
    the width; 3 K/t_c of these bound a rate (the lemma `sampled.windows`)."""

    narrow: Array
    wide: Array
    step: Array
    width_step: Array
    low: Array
    high: Array


def extremes(design: RefinedDesign) -> Extremes:
    """The extremes of every segment, int64: 6 times a table of less than 2^50, so that doubles hold them too."""
    bezier = design.windows()
    width = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    return Extremes(
        narrow=width.min(axis=-1),
        wide=width.max(axis=-1),
        step=np.abs(np.diff(bezier, axis=-1)).max(axis=(2, 3)),
        width_step=np.abs(np.diff(width, axis=-1)).max(axis=-1),
        low=bezier[:, :, LOWER].min(axis=-1),
        high=bezier[:, :, UPPER].max(axis=-1),
    )


def refined_windows(design: RefinedDesign, numbers: Numbers = DOUBLES) -> Windows:
    """A window for each segment. In doubles products with a power of 2 are exact, those with `per_second` rounded outward."""
    found, unit = extremes(design), numbers.of(design.unit)
    rate = Fraction(3 * design.segments) / design.prescribed_time
    per_second = numbers.outward(numbers.of(rate), OUT) * unit
    return Windows(
        times=numbers.evenly(Fraction(design.prescribed_time), design.segments),
        narrow=found.narrow * unit,
        wide=found.wide * unit,
        speed=found.step * per_second,
        widening=found.width_step * per_second,
        low=found.low * unit,
        high=found.high * unit,
        start=design.bezier()[0, :, :, 0] * unit,
    )
