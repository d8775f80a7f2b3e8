"""The longest period of a statement: E and tau are searched for in doubles, and what is returned has been shown in balls
(Arb)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.sampling.setting import Setting, in_balls
from stt_codegen.sampling.statements import STATEMENTS, input_bound, u_of

Array = npt.NDArray[Any]
BACK_OFF = (1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1)  # below the searched tau, until the balls agree


@dataclass(frozen=True)
class Period:
    """tau seconds are proved with |eps| < reach throughout; u bounds |u| by component; tight: time window (seconds) and
    dimension (from 1; 0 for all) that allow no more."""

    statement: str
    seconds: float
    reach: float
    u: tuple[float, ...]
    tight: tuple[float, float, int]

    @property
    def e(self) -> float:
        """The bound on |e| that goes with |eps| < reach."""
        return float(np.tanh(self.reach / 2))


def holds(statement: str, s: Setting, reach: float, tau: float) -> bool:
    """Shown in balls: with |eps(0)| < reach and samples no older than tau the state stays in the tube."""
    start = float(np.sqrt((s.start**2).sum())) if statement == "general" else float(s.start.max())
    if not (math.isfinite(start) and start * (1 + 1e-12) < reach <= s.law.farthest * (1 - 1e-12)):
        return False
    if not s.law.latency <= tau <= s.longest_age:
        return False
    return all(bool(np.all(c.values > 0)) for c in STATEMENTS[statement](in_balls(s), arb(reach), arb(tau)))


def longest(statement: str, s: Setting) -> Period | None:
    """The longest period that is found and proved; None where none is, not even a short one."""
    found = proposal(statement, s)
    if found is None:
        return None
    tau, reach = found
    for share in BACK_OFF:
        if holds(statement, s, reach, tau * (1 - share)):
            window, dimension = _tightest(statement, s, reach, tau)
            ends = (*s.windows.times.tolist(), float(s.windows.times[-1]))
            u = np.asarray(input_bound(s, reach) if statement == "sharp" else u_of(s, reach, s.narrow), dtype=float).max(axis=0)
            tight = (ends[window], ends[window + 1], dimension)
            return Period(statement, tau * (1 - share), reach, tuple(u.tolist()), tight)
    return None


@dataclass(frozen=True)
class Search:
    """How many values of E are tried, how often around the best of them, and how often tau is halved for each."""

    reaches: int
    rounds: int
    halvings: int


FINE, COARSE = Search(24, 2, 24), Search(14, 1, 10)  # what is proved; what gains are compared by


def proposal(statement: str, s: Setting, search: Search = FINE) -> tuple[float, float] | None:
    """(tau, E) in doubles, for `longest` to show in balls: tau by bisection for many E at once, then again around the best."""
    start = float(np.sqrt((s.start**2).sum())) if statement == "general" else float(s.start.max())
    low, high = max(start * 1.0001, 1e-3), s.law.farthest * 0.9999
    if not low < high:
        return None
    best: tuple[float, float] | None = None
    for _ in range(search.rounds):
        grid = np.geomspace(low, high, search.reaches)
        taus = _longest_at(statement, s, grid, search.halvings)
        k = int(np.argmax(taus))
        if taus[k] > 0 and (best is None or taus[k] > best[0]):
            best = (float(taus[k]), float(grid[k]))
        low, high = float(grid[max(k - 1, 0)]), float(grid[min(k + 1, search.reaches - 1)])
    return best


def _longest_at(statement: str, s: Setting, grid: Array, halvings: int) -> Array:
    """The largest tau for every E, by bisection; 0 where none is."""
    inner = (1,) if statement == "general" else (1, 1)
    reach = grid.reshape(-1, *inner)

    def good(tau: Array) -> Array:
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            conditions = STATEMENTS[statement](s, reach, tau.reshape(-1, *inner))
        each = [np.all(c.values > 0, axis=tuple(range(-len(inner), 0))) for c in conditions]
        return np.asarray(np.logical_and.reduce(each))

    low, high = np.zeros(len(grid)), np.full(len(grid), s.longest_age)
    possible = good(low)
    low = np.where(good(high), high, low)
    for _ in range(halvings):
        middle = (low + high) / 2
        fine = good(middle)
        low, high = np.where(fine, middle, low), np.where(fine, high, middle)
    return np.where(possible, low, 0.0)


def _tightest(statement: str, s: Setting, reach: float, tau: float) -> tuple[int, int]:
    """Window and dimension (from 1; 0 for all) with the least slack, relative to the slack of tau = 0."""
    now, rest = STATEMENTS[statement](s, reach, tau), STATEMENTS[statement](s, reach, 0.0)
    pairs = [(np.asarray(a.values, float), np.asarray(b.values, float)) for a, b in zip(now, rest, strict=True)]
    share = np.min([np.divide(a, b, out=np.full(a.shape, np.inf), where=(b > 0) & np.isfinite(b)) for a, b in pairs], axis=0)
    place = np.unravel_index(int(np.argmin(share)), share.shape)
    return int(place[0]), int(place[1]) + 1 if len(place) > 1 else 0
