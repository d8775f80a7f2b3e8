"""Limits of u that are chosen for a sampled loop: multiples of the input that balances all that moves the state."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from stt_codegen.decimals import above
from stt_codegen.sampling.gains import needed_input
from stt_codegen.sampling.sampled_loop import SampledLoop

LIMIT_FACTORS = tuple(Fraction(v) for v in ("1.5", "1.8", "2.2", "2.7"))  # times the needed input
LIMIT_DIGITS = 3
SMALLEST_SHARE = 0.02  # of the largest needed input: what a component has that nothing moves


def limits_for(loop: SampledLoop, factor: Fraction) -> tuple[Fraction, ...]:
    """Return the limit of |u| by component: `factor` times the needed input, rounded up. loop: in doubles, its u_max is not read.

    A component that nothing moves has a small part of the others' input; where nothing moves at all, enough to cross the tube in
    its time.
    """
    needed = needed_input(loop)
    crossing_speed = loop.windows.wide.max(axis=0) / loop.windows.times[-1]
    floor = needed.max() * SMALLEST_SHARE if needed.any() else crossing_speed
    return tuple(Fraction(str(above(factor * Fraction(v), LIMIT_DIGITS))) for v in np.maximum(needed, floor).tolist())
