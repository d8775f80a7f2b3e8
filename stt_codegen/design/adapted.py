"""What an adaptive or literal design is: the numbers of (2)-(11), as exact fractions."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.design.tube import LOWER, UPPER

Edge = tuple[Fraction, Fraction]  # lower, upper


@dataclass(frozen=True)
class Bump:
    """One circumvent function (7) or (8): `side` LOWER raises beta_L of `dimension`, UPPER lowers beta_U.

    height: B, the task's units. steepness: k^j. middle, radius: m^j, r^j in seconds. unsafe: name of the set it is for.
    """

    dimension: int
    side: int
    height: Fraction
    steepness: Fraction
    middle: Fraction
    radius: Fraction
    unsafe: str


@dataclass(frozen=True)
class AdaptiveDesign:
    """An adaptive tube (10): `kind` is "adaptive" (sound windows and sides) or "literal" (the paper's rule).

    start, target, walls: X0hat, That and the rest levels X_i of (7), (8), lower and upper by dimension.
    theta0 (units cubed per second), kappa (1/s), mu (units), varsigma, nu (1/units): parameters of (10) and (11).
    """

    kind: str
    prescribed_time: Fraction
    start: tuple[Edge, ...]
    target: tuple[Edge, ...]
    walls: tuple[Edge, ...]
    bumps: tuple[Bump, ...]
    theta0: Fraction
    kappa: Fraction
    mu: Fraction
    varsigma: Fraction
    nu: Fraction
    seed: int | None = None  # of the literal design's random sides

    @property
    def dimension(self) -> int:
        return len(self.start)

    def of(self, dimension: int, side: int) -> tuple[Bump, ...]:
        """The bumps on one side of one dimension."""
        return tuple(b for b in self.bumps if (b.dimension, b.side) == (dimension, side))

    @property
    def slots(self) -> tuple[int, int]:
        """Rows of bumps that every dimension has, lower and upper side: as many as the fullest dimension needs."""
        low, high = (max(len(self.of(i, side)) for i in range(self.dimension)) for side in (LOWER, UPPER))
        return low, high
