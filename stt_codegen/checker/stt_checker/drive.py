"""What acts of u: the drive that a task states; and the plant that is assumed where a task with a period states none."""

from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction
from typing import Any

from .exact import Unusable, numbers


class Drive:
    """The drive of each component. lags: in series, in seconds; slew: the rate at which it follows u at least, None where it
    follows at once; opposite: M + M^2 + .. for an overshoot by the share M."""

    def __init__(self, plant: dict[str, Any], n: int) -> None:
        self.stated = {k: numbers(plant[k], n) for k in ("lag", "lag2", "slew", "overshoot") if k in plant}
        if min([Fraction(0), *(v for values in self.stated.values() for v in values)]) < 0:
            raise Unusable("the task has a negative number")
        if min(self.stated.get("slew", [1])) <= 0 or max(self.stated.get("overshoot", [0])) >= 1:
            raise Unusable("the task has a slew that is not positive, or an overshoot that is not below 1")
        lags = [self.stated.get(k, [Fraction(0)] * n) for k in ("lag", "lag2")]
        self.lags = [[t for t in pair if t] for pair in zip(*lags, strict=True)]
        self.slew = self.stated.get("slew", [None] * n)
        self.opposite = [m / (1 - m) for m in self.stated.get("overshoot", [Fraction(0)] * n)]
        self.acts_at_once = not (any(map(any, self.lags)) or any(self.slew) or any(self.opposite))


def assumed_plant(speeds: list[Fraction]) -> dict[str, list[Fraction]]:
    """Return the bounds that are assumed: g within a fifth of 1, disturbances up to a tenth of the speed of the tube's fastest
    edge by component, rounded up to three digits. speeds: of these edges."""
    to_three_digits = Context(prec=3, rounding=ROUND_CEILING)
    tenths = [(v / 10).as_integer_ratio() for v in speeds]
    w_max = [Fraction(to_three_digits.divide(Decimal(p), Decimal(q))) for p, q in tenths]
    return {"w_max": w_max, "g_min": [Fraction(4, 5)] * len(speeds), "g_max": [Fraction(6, 5)] * len(speeds)}
