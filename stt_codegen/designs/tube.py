"""What all designs share: a tube has a lower and an upper edge in every dimension."""

from __future__ import annotations

from fractions import Fraction

LOWER, UPPER = 0, 1  # the sides, as indices
Edge = tuple[Fraction, Fraction]  # lower, upper
LEAST_WIDTH = Fraction(1, 1 << 20)  # narrower tubes are treated as this wide, so that xi stays finite
