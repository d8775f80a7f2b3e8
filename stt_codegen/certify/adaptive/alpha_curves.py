"""Bounds on the update function alpha (11) that hold for its equation and for every sequence of the emitted implicit steps.

One side of one dimension: alphadot = F(psi, alpha) = theta(psi)/(psi + alpha)^2 - kappa alpha, alpha(0) = 0. F falls in psi and
in alpha. An implicit step of length dt ends where (alpha' - alpha)/dt = F(psi(t + dt), alpha'). So a curve u that starts at or
above alpha stays above when its mean slope over every [t, t + dt] is at least F(psi(t + dt), u(t + dt)), and that follows when

    its slope in a cell is at least F(least psi, least u) over the cell and `reach` beyond it,  reach >= dt.

u is piecewise linear and may jump up. The least u over the reach is a promise which later cells keep. The lower
curve is the mirror image. The equation is the limit of steps of length 0, so its solution lies between the curves too.

Rounding enters as a relative error of each emitted step. From exact psi and theta on, it is at most `STEP_ROUNDINGS` times half
a unit in the last place of alpha': with rest = alpha/(1 + dt kappa), w = q/z^2 = alpha' - rest, the roundings of rest move
alpha' by at most 6 of these, of p = psi + rest by at most |p| 2w/(z + 2w) <= 4 alpha' (|psi| <= z for psi > 0, <= alpha' for
psi < 0), of q by 4, of Newton's last residual by 6, of the last sum by 3; the rest is room for products of errors.

Everything here is double arithmetic on + - * / with an outward factor after each short chain; library functions only
give first guesses, which are then verified.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

STEP_ROUNDINGS = 64
LEAST_FORCE = 1e-60  # of the cubic: below it 0 is as good
SLACK = 2.0**-40  # relative, for a chain of less than 100 roundings in double
Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Steps:
    """Which sequences of steps are meant: dt in [shortest, longest] seconds, once rounded; each step begins where the last one
    ended, to within `late` seconds. roundoff: half a unit in the last place of 1 in the emitted type."""

    shortest: Fraction
    longest: Fraction
    late: float
    roundoff: float

    @property
    def reach(self) -> float:
        return float(self.longest) * (1 + 2 * self.roundoff + SLACK) + 2 * self.late

    @property
    def least(self) -> float:
        return float(self.shortest) * (1 - 2 * self.roundoff - SLACK)


def ahead(times: Array, values: Array, reach: float, largest: bool) -> Array:
    """For every cell the least (largest) of `values` (first axis: cells) over the cell and `reach` seconds beyond it."""
    choose = np.max if largest else np.min
    last = np.searchsorted(times[:-1], times[1:] + reach, side="right")
    return np.stack([choose(values[k : last[k]], axis=0) for k in range(len(values))])


def upper_curve(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], kappa: float, steps: Steps) -> list[float]:
    """The largest value in each cell of a curve above alpha, and last the same for all later times.

    times: cell boundaries (N + 1). psi, theta: least psi and largest theta of each cell and the reach beyond it (N), and
    last those that hold from times[N] on.
    """
    return curve_values(times, psi, theta, Curve.of(1, kappa, steps))


def lower_curve(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], kappa: float, steps: Steps) -> list[float]:
    """The least value in each cell of a curve below alpha; arguments as `upper_curve`, with largest psi and least theta."""
    return [max(v, 0.0) for v in curve_values(times, psi, theta, Curve.of(-1, kappa, steps))]


def curve_values(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], curve: Curve) -> list[float]:
    """The curve's extreme in each cell, and last the same for all later times."""
    if curve.decay <= 0 or curve.rush >= 2:  # steps so short that rounding or lateness is all of them: nothing is known
        return [float("inf") if curve.side > 0 else 0.0] * len(psi)
    u, result = 0.0, []
    promises: deque[tuple[float, float]] = deque()  # until when the curve must stay on this side of what; the strictest last
    for k in range(len(psi) - 1):
        after, kept, extreme = curve.cell(u, times[k + 1] - times[k], psi[k], theta[k])
        while promises and curve.outer(kept, promises[-1][1]) == kept:
            promises.pop()
        promises.append((times[k + 1] + curve.reach, kept))
        while promises[0][0] < times[k]:
            promises.popleft()
        u = max(curve.outer(after, promises[0][1]), 0.0)
        result.append(curve.outer(extreme, u))
    return [*result, curve.outer(u, curve.balance(psi[-1], theta[-1]))]


class Cell(NamedTuple):
    """What a curve does in a cell: where it is at the cell's end, what it promises to stay beyond, and its extreme."""

    end: Any
    promise: Any
    extreme: Any


@dataclass(frozen=True)
class Curve:
    """What both curves are made of; side: 1 above alpha, -1 below. share: what rounding may take of alpha in a step, so that
    u (1 - side share) is on the far side of the exact step. decay: kappa with what rounding adds. rush: how much faster than its
    own length a step may pass. reach: seconds. The lemmas
    `update.rises` and `.falls` run `cell`, `.root` runs `root` and `beyond`, `.promise` runs `curve_values`."""

    side: int
    share: Any
    decay: Any
    rush: Any
    reach: Any

    @classmethod
    def of(cls, side: int, kappa: float, steps: Steps) -> Curve:
        share = STEP_ROUNDINGS * steps.roundoff
        share = share if side > 0 else share / (1 - share)
        decay = (kappa * (1 - side * share) - side * share / steps.least) * (1 - side * SLACK)
        return cls(side, share, decay, 1 + 2 * steps.late / steps.least + SLACK, steps.reach)

    def outer(self, a: Any, b: Any) -> Any:
        """The one that is farther from alpha."""
        return a if self.side * a >= self.side * b else b

    def cell(self, u: Any, h: Any, psi: Any, theta: Any) -> Cell:
        """A cell of h seconds that begins at u; the promise is until `reach` seconds after it. The curve is a line, or what was
        promised before where that is farther out."""
        side, share = self.side, self.share
        z = psi + u * (1 - side * share)
        slope = (theta / (z * z) * (1 + side * SLACK) - self.decay * u) if z > 0 else float("inf")
        if side * slope >= 0:  # away from alpha: at this speed, or with a jump to where the speed is 0
            rest = self.outer(u, self.balance(psi, theta))
            explicit = u + h * slope * self.rush * (1 + SLACK)
            return Cell(rest, rest, rest) if side * rest <= side * explicit else Cell(explicit, u, explicit)
        span = (h + self.reach) * (2 - self.rush)
        damping = (1 + span * self.decay) * (1 - side * SLACK)
        root = self.root(psi + u / damping, span * theta / damping)
        kept = (root - psi) * (1 + side * 2 * share) * (1 + side * SLACK) + side * SLACK * abs(psi)
        kept = kept if side * kept <= side * u else u
        return Cell(u + (kept - u) * (h / (h + self.reach)) * (1 - SLACK), kept, u)

    def balance(self, psi: Any, theta: Any) -> Any:
        """The alpha where theta/(psi + alpha)^2 = decay alpha, and what rounding may add: on the far side."""
        side = self.side
        root = self.root(psi, theta / self.decay * (1 + side * SLACK))
        held = (root - psi) * (1 + side * SLACK) + side * SLACK * abs(psi)
        return (held if held > 0 else 0.0) * (1 + side * 2 * self.share)

    def root(self, p: Any, q: Any) -> Any:
        """The root z > max(p, 0) of (z - p) z^2 = q, on the far side: verified, not trusted."""
        if q < LEAST_FORCE:
            if self.side < 0:
                return max(p, 0.0)
            q = LEAST_FORCE
        return self.beyond(_near_root(p, q), p, q)

    def beyond(self, z: Any, p: Any, q: Any) -> Any:
        """A place near z that is shown to be on the far side of the root."""
        room = SLACK
        while room < 1:
            bound = z * (1 + self.side * room)
            value = (bound - p) * bound * bound
            if (value >= q * (1 + SLACK / 8)) if self.side > 0 else (value <= q * (1 - SLACK / 8)):
                return bound
            room *= 4
        least = p if p > 0 else 0.0
        return (least + math.cbrt(q)) * (1 + SLACK) if self.side > 0 else least


def _near_root(p: float, q: float) -> float:
    """Newton's way to the root, which `Curve.beyond` verifies."""
    cubic = math.cbrt(q)
    z = p + cubic if p >= 0 else min(cubic, math.sqrt(q / -p))
    for _ in range(40):
        residual = (z - p) * z * z - q
        step = residual / (z * (z + 2 * (z - p)))
        z -= step
        if abs(step) <= 1e-14 * z:
            break
    return z
