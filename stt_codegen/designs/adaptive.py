"""What an adaptive or literal design is: the numbers of (2)-(11), as exact fractions."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from stt_codegen.decimals import nine_digits
from stt_codegen.designs.tube import LOWER, UPPER, Edge


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

    stateful = True  # the caller keeps alpha

    @property
    def dimension(self) -> int:
        return len(self.start)

    @property
    def parts(self) -> int | None:
        """Into how many parts of equal length its data divide the time: none."""
        return None

    def parameters(self) -> dict[str, Any]:
        """What a certificate tells of the design itself: all of its numbers, to nine digits."""
        names = ("theta0", "kappa", "mu", "varsigma", "nu")
        bumps = [
            {
                "unsafe_set": b.unsafe,
                "dimension": b.dimension + 1,
                "side": "lower" if b.side == LOWER else "upper",
                **{name: nine_digits(getattr(b, name)) for name in ("height", "steepness", "middle", "radius")},
            }
            for b in self.bumps
        ]
        seed = {} if self.seed is None else {"seed": self.seed}
        return {**{name: nine_digits(getattr(self, name)) for name in names}, **seed, "circumvent_functions": bumps}

    @property
    def size(self) -> str:
        """How large the design is, in words."""
        return f"{len(self.bumps)} circumvent function{'' if len(self.bumps) == 1 else 's'}"

    def of(self, dimension: int, side: int) -> tuple[Bump, ...]:
        """The bumps on one side of one dimension."""
        return tuple(b for b in self.bumps if (b.dimension, b.side) == (dimension, side))

    @property
    def slots(self) -> tuple[int, int]:
        """Rows of bumps that every dimension has, lower and upper side: as many as the fullest dimension needs."""
        low, high = (max(len(self.of(i, side)) for i in range(self.dimension)) for side in (LOWER, UPPER))
        return low, high
