"""Bounds on the update function alpha (11) that hold for its equation and for every sequence of the emitted implicit steps.

Take one side of one dimension: alphadot = F(psi, alpha) = theta(psi)/(psi + alpha)^2 - kappa alpha, alpha(0) = 0. F falls in psi
and in alpha. An implicit step of length dt ends where (alpha' - alpha)/dt = F(psi(t + dt), alpha'). So a curve u that starts at
or above alpha stays above when its mean slope over every [t, t + dt] is at least F(psi(t + dt), u(t + dt)), and that follows when

    its slope in a cell is at least F(least psi, least u) over the cell and `reach` beyond it,  reach >= dt.

u is piecewise linear and may jump up. The least u over the reach is a promise that later cells keep. The lower curve is the
mirror image. The equation is the limit of steps of length 0, so its solution lies between the curves too. The lemmas `update.*`
prove this.

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
MINIMUM_FORCE = 1e-60  # q of the cubic; a smaller one is replaced by it, or by 0
SLACK = 2.0**-40  # relative; covers a chain of less than 100 roundings in double
Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Steps:
    """The sequences of steps that curves must hold for.

    shortest, longest: of a step dt, in seconds; the emitted code rounds it once. late: each step begins where the last one ended,
    to within so many seconds. roundoff: half a unit in the last place of 1 in the emitted type.
    """

    shortest: Fraction
    longest: Fraction
    late: float
    roundoff: float

    @property
    def reach(self) -> float:
        """An upper bound on a step, with both of its ends late, in seconds."""
        return float(self.longest) * (1 + 2 * self.roundoff + SLACK) + 2 * self.late

    @property
    def minimum(self) -> float:
        """A lower bound on a step, in seconds."""
        return float(self.shortest) * (1 - 2 * self.roundoff - SLACK)


def extremes_ahead(times: Array, values: Array, reach: float, largest: bool) -> Array:
    """Return for every cell the smallest (largest) of `values` over the cell and `reach` seconds beyond it.

    times: cell boundaries (N + 1). values: by cell along the first axis.
    """
    choose = np.max if largest else np.min
    last = np.searchsorted(times[:-1], times[1:] + reach, side="right")
    return np.stack([choose(values[k : last[k]], axis=0) for k in range(len(values))])


def upper_curve(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], kappa: float, steps: Steps) -> list[float]:
    """Return the largest value in each cell of a curve above alpha, and last the same for all later times.

    times: cell boundaries (N + 1). psi, theta: the smallest psi and the largest theta of each cell and the reach beyond it (N),
    and last those that hold from times[N] on.
    """
    return curve_values(times, psi, theta, Curve.of(1, kappa, steps))


def lower_curve(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], kappa: float, steps: Steps) -> list[float]:
    """Return the smallest value in each cell of a curve below alpha; as `upper_curve`, with largest psi and smallest theta."""
    return [max(v, 0.0) for v in curve_values(times, psi, theta, Curve.of(-1, kappa, steps))]


def curve_values(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], curve: Curve) -> list[float]:
    """Return the curve's extreme in each cell, and last the same for all later times."""
    if curve.decay <= 0 or curve.speed_factor >= 2:  # steps are as short as their rounding or lateness: nothing is known
        return [float("inf") if curve.side > 0 else 0.0] * len(psi)
    u, result = 0.0, []
    promises: deque[tuple[float, float]] = deque()  # until when the curve must stay beyond which value; the strictest last
    for k in range(len(psi) - 1):
        end, promise, extreme = curve.cell(u, times[k + 1] - times[k], psi[k], theta[k])
        while promises and curve.outer(promise, promises[-1][1]) == promise:
            promises.pop()
        promises.append((times[k + 1] + curve.reach, promise))
        while promises[0][0] < times[k]:
            promises.popleft()
        u = max(curve.outer(end, promises[0][1]), 0.0)
        result.append(curve.outer(extreme, u))
    return [*result, curve.outer(u, curve.balance(psi[-1], theta[-1]))]


class Cell(NamedTuple):
    """A curve in a cell: its value at the cell's end, the value that it promises to stay beyond, and its extreme."""

    end: Any
    promise: Any
    extreme: Any


@dataclass(frozen=True)
class Curve:
    """The construction of a curve on one side of alpha; side: 1 above it, -1 below.

    share: the relative error of rounding in a step, so that u (1 - side share) is on the far side of the exact step. decay: kappa
    with the effect of rounding. speed_factor: a bound on a step's length over the time that it takes. reach: seconds. The lemmas
    `update.rises` and `.falls` run `cell`, `.root` runs `root` and `beyond`, `.promise` runs `curve_values`.
    """

    side: int
    share: Any
    decay: Any
    speed_factor: Any
    reach: Any

    @classmethod
    def of(cls, side: int, kappa: float, steps: Steps) -> Curve:
        """Return the curve for an equation with this kappa and these steps."""
        share = STEP_ROUNDINGS * steps.roundoff
        share = share if side > 0 else share / (1 - share)
        decay = (kappa * (1 - side * share) - side * share / steps.minimum) * (1 - side * SLACK)
        return cls(side, share, decay, 1 + 2 * steps.late / steps.minimum + SLACK, steps.reach)

    def outer(self, a: Any, b: Any) -> Any:
        """Return the value that is farther from alpha."""
        return a if self.side * a >= self.side * b else b

    def cell(self, u: Any, h: Any, psi: Any, theta: Any) -> Cell:
        """Return the curve in a cell of h seconds that begins at u; the promise lasts until `reach` seconds after the cell.

        The curve is a line, or an earlier promise where that is farther out.
        """
        side, share = self.side, self.share
        z = psi + u * (1 - side * share)
        slope = (theta / (z * z) * (1 + side * SLACK) - self.decay * u) if z > 0 else float("inf")
        if side * slope >= 0:  # away from alpha: at this speed, or with a jump to where the speed is 0
            rest = self.outer(u, self.balance(psi, theta))
            explicit = u + h * slope * self.speed_factor * (1 + SLACK)
            return Cell(rest, rest, rest) if side * rest <= side * explicit else Cell(explicit, u, explicit)
        span = (h + self.reach) * (2 - self.speed_factor)
        damping = (1 + span * self.decay) * (1 - side * SLACK)
        root = self.root(psi + u / damping, span * theta / damping)
        promise = (root - psi) * (1 + side * 2 * share) * (1 + side * SLACK) + side * SLACK * abs(psi)
        promise = promise if side * promise <= side * u else u
        return Cell(u + (promise - u) * (h / (h + self.reach)) * (1 - SLACK), promise, u)

    def balance(self, psi: Any, theta: Any) -> Any:
        """Return, on the far side, the alpha where theta/(psi + alpha)^2 = decay alpha, with the effect of rounding."""
        side = self.side
        root = self.root(psi, theta / self.decay * (1 + side * SLACK))
        alpha = (root - psi) * (1 + side * SLACK) + side * SLACK * abs(psi)
        return (alpha if alpha > 0 else 0.0) * (1 + side * 2 * self.share)

    def root(self, p: Any, q: Any) -> Any:
        """Return, on the far side, the root z > max(p, 0) of (z - p) z^2 = q; Newton's result is verified."""
        if q < MINIMUM_FORCE:
            if self.side < 0:
                return max(p, 0.0)
            q = MINIMUM_FORCE
        return self.beyond(_near_root(p, q), p, q)

    def beyond(self, z: Any, p: Any, q: Any) -> Any:
        """Return a value near z that is verified to be on the far side of the root."""
        widening = SLACK
        while widening < 1:
            bound = z * (1 + self.side * widening)
            value = (bound - p) * bound * bound
            if (value >= q * (1 + SLACK / 8)) if self.side > 0 else (value <= q * (1 - SLACK / 8)):
                return bound
            widening *= 4
        low = p if p > 0 else 0.0
        return (low + math.cbrt(q)) * (1 + SLACK) if self.side > 0 else low


def _near_root(p: float, q: float) -> float:
    """Return the root by Newton's method; `Curve.beyond` verifies it."""
    cubic = math.cbrt(q)
    z = p + cubic if p >= 0 else min(cubic, math.sqrt(q / -p))
    for _ in range(40):
        residual = (z - p) * z * z - q
        step = residual / (z * (z + 2 * (z - p)))
        z -= step
        if abs(step) <= 1e-14 * z:
            break
    return z
