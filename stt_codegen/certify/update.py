"""Bounds on the update function alpha (11) that hold for its equation and for every sequence of the emitted implicit steps.

One side of one dimension: alphadot = F(psi, alpha) = theta(psi)/(psi + alpha)^2 - kappa alpha, alpha(0) = 0. F falls in psi and
in alpha. An implicit step of length dt ends where (alpha' - alpha)/dt = F(psi(t + dt), alpha'). So a curve u that starts at or
above alpha stays above when its mean slope over every [t, t + dt] is at least F(psi(t + dt), u(t + dt)), and that follows when

    its slope in a cell is at least F(least psi, least u) over the cell and `reach` beyond it,  reach >= dt.

u is piecewise linear and may jump up. The least u over the reach is a promise which later cells keep ("floor"). The lower
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
from typing import Any

import numpy as np
import numpy.typing as npt

STEP_ROUNDINGS = 64
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
    share = STEP_ROUNDINGS * steps.roundoff  # u (1 - share) is below the exact step wherever u is above the rounded one
    decay = (kappa * (1 - share) - share / steps.least) * (1 - SLACK)
    rush = 1 + 2 * steps.late / steps.least + SLACK
    if decay <= 0:
        return [float("inf")] * (len(psi))
    u, result = 0.0, []
    floors: deque[tuple[float, float]] = deque()  # until when the curve must stay above what; values fall
    for k in range(len(psi) - 1):
        h = times[k + 1] - times[k]
        p, force = psi[k], theta[k]
        z = p + u * (1 - share)
        slope = (force / (z * z) * (1 + SLACK) - decay * u) if z > 0 else float("inf")
        if slope >= 0:
            rest = max(u, _balance(p, force, decay, 1) * (1 + 2 * share))
            explicit = u + h * slope * rush * (1 + SLACK)
            after, least = (rest, rest) if rest <= explicit else (explicit, u)
            top = after
        else:
            span = (h + steps.reach) * (2 - rush)
            damping = 1 + span * decay
            start = u / damping
            least = min(u, (_root(p + start, span * force / damping, 1) - p) * (1 + 2 * share) * (1 + SLACK) + SLACK * abs(p))
            after = u - (u - least) * (h / (h + steps.reach)) * (1 - SLACK)
            top = u
        while floors and floors[-1][1] <= least:
            floors.pop()
        floors.append((times[k + 1] + steps.reach, least))
        while floors[0][0] < times[k]:
            floors.popleft()
        u = max(after, floors[0][1])
        result.append(max(top, u))
    rest = _balance(psi[-1], theta[-1], decay, 1) * (1 + 2 * share)
    return [*result, max(u, rest)]


def lower_curve(times: Sequence[float], psi: Sequence[float], theta: Sequence[float], kappa: float, steps: Steps) -> list[float]:
    """The least value in each cell of a curve below alpha; arguments as `upper_curve`, with largest psi and least theta."""
    share = STEP_ROUNDINGS * steps.roundoff
    share /= 1 - share  # low (1 + share) is above the exact step wherever low is below the rounded one
    decay = (kappa * (1 + share) + share / steps.least) * (1 + SLACK)
    rush = 1 + 2 * steps.late / steps.least + SLACK
    low, result = 0.0, []
    ceilings: deque[tuple[float, float]] = deque()  # values rise
    for k in range(len(psi) - 1):
        h = times[k + 1] - times[k]
        p, force = psi[k], theta[k]
        z = p + low * (1 + share)
        slope = (force / (z * z) * (1 - SLACK) - decay * low) if z > 0 else float("inf")
        if slope <= 0:
            rest = min(low, _balance(p, force, decay, -1) * (1 - 2 * share))
            explicit = low + h * slope * rush * (1 + SLACK)
            after, most = (rest, rest) if rest >= explicit else (explicit, low)
            bottom = after
        else:
            span = (h + steps.reach) * (2 - rush)
            damping = (1 + span * decay) * (1 + SLACK)
            start = low / damping
            most = max(low, (_root(p + start, span * force / damping, -1) - p) * (1 - 2 * share) * (1 - SLACK) - SLACK * abs(p))
            after = low + (most - low) * (h / (h + steps.reach)) * (1 - SLACK)
            bottom = low
        while ceilings and ceilings[-1][1] >= most:
            ceilings.pop()
        ceilings.append((times[k + 1] + steps.reach, most))
        while ceilings[0][0] < times[k]:
            ceilings.popleft()
        low = max(min(after, ceilings[0][1]), 0.0)
        result.append(max(min(bottom, low), 0.0))
    rest = _balance(psi[-1], theta[-1], decay, -1) * (1 - 2 * share)
    return [*result, max(min(low, rest), 0.0)]


def _balance(psi: float, force: float, decay: float, side: int) -> float:
    """The alpha where force/(psi + alpha)^2 = decay alpha; rounded up for side 1, down for -1."""
    q = force / decay
    return max((_root(psi, q * (1 + side * SLACK), side) - psi) * (1 + side * SLACK) + side * SLACK * abs(psi), 0.0)


def _root(p: float, q: float, side: int) -> float:
    """The root z > max(p, 0) of (z - p) z^2 = q; rounded up for side 1, down for -1: verified, not trusted."""
    if q < 1e-60:
        if side < 0:
            return max(p, 0.0)
        q = 1e-60
    cubic = math.cbrt(q)
    z = p + cubic if p >= 0 else min(cubic, math.sqrt(q / -p))
    for _ in range(40):
        residual = (z - p) * z * z - q
        step = residual / (z * (z + 2 * (z - p)))
        z -= step
        if abs(step) <= 1e-14 * z:
            break
    room = SLACK
    while True:
        bound = z * (1 + side * room)
        value = (bound - p) * bound * bound
        if (value >= q * (1 + SLACK / 8)) if side > 0 else (value <= q * (1 - SLACK / 8)):
            return bound
        room *= 4
        if room >= 1:
            return max(p, 0.0) + cubic * (1 + SLACK) if side > 0 else max(p, 0.0)
