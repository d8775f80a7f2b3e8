"""The longest period of a statement, and the least E for a period: searched for in doubles; what is returned has been shown in
balls (Arb).

In the sharp statement every component has an E of its own. What an input pushes the other components with rises with its E, and
what a component must withstand rises with what the others push. So for one tau there is a least E in all components at once: each
is raised, from its least, until its own conditions hold; where one finds none there is no E at all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.sampling.setting import Setting, in_balls
from stt_codegen.sampling.statements import STATEMENTS, conditions_of, first_failing, input_bound, sharp_push, sharp_under

Array = npt.NDArray[Any]
Found = tuple[float, Array]  # tau in seconds and E by component
BACK_OFF = (1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1)  # of the searched tau or E, until the balls agree
FIRST_HALVINGS = 24  # more than a search has, where it has met no period yet
MIDDLE = 0.01  # the least E that is tried, |e| = 0.005: as good as a start in the middle


@dataclass(frozen=True)
class Period:
    """tau seconds are proved with |eps_i| < reach[i] throughout; u bounds |u| by component; tight: time window (seconds) and
    dimension (from 1; 0 for all) that allow no more."""

    statement: str
    seconds: float
    reach: tuple[float, ...]
    u: tuple[float, ...]
    tight: tuple[float, float, int]

    @property
    def e(self) -> tuple[float, ...]:
        """The bounds on |e| by component that go with |eps| < reach."""
        return tuple(math.tanh(v / 2) for v in self.reach)


@dataclass(frozen=True)
class Search:
    """How many values of E are tried, how often around the best of them, and how often tau is halved for each."""

    reaches: int
    rounds: int
    halvings: int


FINE, COARSE = Search(32, 2, 24), Search(32, 1, 12)  # what is proved; what gains are compared by


def holds(statement: str, s: Setting, reach: Array, tau: float) -> bool:
    """Shown in balls: with |eps_i(0)| < reach[i] and samples no older than tau the state stays in the tube. The general statement
    speaks of the norm of eps, and reach has the same bound on it in every place."""
    reach = np.asarray(reach, dtype=float)
    if not is_in_range(statement, s, reach, tau):
        return False
    e = arb(float(reach[0])) if statement == "general" else np.array([arb(v) for v in reach.tolist()], dtype=object)
    return first_failing(conditions_of(statement, in_balls(s), e, arb(tau))) is None


def is_in_range(statement: str, s: Setting, reach: Array, tau: Any) -> bool:
    """Whether the statement speaks of these: reaches that no start has and that the clamp leaves, samples from this window or the
    one before. Of the numbers that the setting has."""
    start = s.numbers.outward(_start(statement, s), 1e-12)
    ends = bool((start < reach).all() and (reach <= _farthest(statement, s)).all())
    return ends and bool(s.law.latency <= tau <= s.longest_age)


def inputs_where_proved(loop: Setting, rho: Sequence[Fraction], age: Fraction) -> tuple[Fraction, ...] | None:
    """A bound on |u| by component where the sharp statement holds in fractions (`exact_loop`) with these rho = e^E for samples of
    that age; else None. Window by window, so that the first condition that fails is the last one that is computed."""
    reach = np.array(rho, dtype=object)
    if not is_in_range("sharp", loop, reach, age):
        return None
    largest = 0 * reach
    for k in range(len(loop.narrow)):
        window = loop.window(k)
        u = input_bound(window, reach)
        if first_failing(sharp_under(window, reach, age, u, sharp_push(window, u))) is not None:
            return None
        largest = np.maximum(largest, u[0])
    return tuple(largest.tolist())


def longest(statement: str, s: Setting) -> Period | None:
    """The longest period that is found and proved; None where none is, not even a short one."""
    found = proposal(statement, s)
    if found is None:
        return None
    tau, reach = found
    shares = (tau * (1 - share) for share in BACK_OFF)
    return next((_period(statement, s, reach, t, tau) for t in shares if holds(statement, s, reach, t)), None)


def least(statement: str, s: Setting, tau: float) -> Period | None:
    """The statement at tau seconds with the least E that is found and proved; None where none is."""
    reach = _least_proved(statement, s, tau)
    return None if reach is None else _period(statement, s, reach, tau, tau)


def is_proved(statement: str, s: Setting, tau: float) -> bool:
    """Whether some E is found and proved for tau seconds: for every |k| from `law.gain` to `law.gain_high`."""
    return _least_proved(statement, s, tau) is not None


def _least_proved(statement: str, s: Setting, tau: float) -> Array | None:
    reach = least_proposed(statement, s, tau)
    if reach is None:
        return None
    tried = (np.minimum(reach * (1 + share), _farthest(statement, s)) for share in BACK_OFF)
    return next((e for e in tried if holds(statement, s, e, tau)), None)


def _period(statement: str, s: Setting, reach: Array, tau: float, longest_tau: float) -> Period:
    window, dimension = _tightest(statement, s, reach, longest_tau)
    ends = (*s.windows.times.tolist(), float(s.windows.times[-1]))
    given = float(reach[0]) if statement == "general" else reach
    u = np.minimum(np.asarray(STATEMENTS[statement].inputs(s, given, tau), dtype=float).max(axis=0) * (1 + 1e-12), s.law.u_max)
    return Period(statement, tau, tuple(reach.tolist()), tuple(u.tolist()), (ends[window], ends[window + 1], dimension))


def _start(statement: str, s: Setting) -> Array:
    """What E must be above, by component: |eps(0)|, or its norm in every place."""
    return np.full(s.start.shape, np.sqrt((s.start**2).sum())) if statement == "general" else s.start


def _farthest(statement: str, s: Setting) -> Array:
    """What E may be at most, by component: eps at the clamp."""
    most = s.numbers.outward(s.law.farthest, -1e-12)
    return np.full(most.shape, most.min()) if statement == "general" else most


# ------------------------------------------------------------------------------------------- search


def proposal(statement: str, s: Setting, search: Search = FINE) -> Found | None:
    """(tau, E) in doubles, for `longest` to show in balls: tau by halving, then again with values of E around the best."""
    best: Found | None = None
    grid = _first_grid(statement, s, search)
    for _ in range(search.rounds):
        found = None if grid is None else grid.longest(search.halvings)
        if found is not None and (best is None or found[0] > best[0]):
            best = found
        grid = None if grid is None or best is None else grid.around(best[1])
    return best


def least_proposed(statement: str, s: Setting, tau: float) -> Array | None:
    """The least E for tau seconds in doubles, for `least` to show in balls."""
    reach: Array | None = None
    grid = _first_grid(statement, s, FINE)
    for _ in range(FINE.rounds):
        found = None if grid is None else grid.least(tau)
        reach = reach if found is None else found
        grid = None if grid is None or reach is None else grid.around(reach)
    return reach


@dataclass(frozen=True)
class _Grid:
    """Values of E to try, (R, n)."""

    statement: str
    setting: Setting
    values: Array

    def least(self, tau: float) -> Array | None:
        """The least E of these, by component, for which the conditions hold at tau."""
        raise NotImplementedError

    def longest(self, halvings: int) -> Found | None:
        """The largest tau by halving, and an E for it."""
        best = self.least(0.0)
        if best is None:
            return None
        low, high = 0.0, self.setting.longest_age
        whole = self.least(high)
        if whole is not None:
            return high, whole
        for k in range(halvings + FIRST_HALVINGS):
            if k >= halvings and low > 0:
                break  # until a first one is met the halvings go on, for a period may be short beside a window
            middle = (low + high) / 2
            found = self.least(middle)
            if found is None:
                high = middle
            else:
                low, best = middle, found
        return (low, best) if low > 0 else None

    def around(self, reach: Array) -> _Grid:
        """As many values between the neighbours of these."""
        k = np.argmin(np.abs(self.values - reach), axis=0)
        columns, last = np.arange(len(k)), len(self.values) - 1
        low, high = self.values[np.maximum(k - 1, 0), columns], self.values[np.minimum(k + 1, last), columns]
        return replace(self, values=np.geomspace(low, high, last + 1))


def _first_grid(statement: str, s: Setting, search: Search) -> _Grid | None:
    """Values of E over all that may be; None where none may be."""
    low, high = np.maximum(_start(statement, s) * 1.0001, MIDDLE), _farthest(statement, s) * 0.9999
    if not (np.isfinite(low).all() and (low < high).all()):
        return None
    kind = _Sharp if statement == "sharp" else _Scalar
    return kind(statement, s, np.geomspace(low, high, search.reaches))


class _Sharp(_Grid):
    @cached_property
    def inputs(self) -> Array:
        """A bound on |u| for every E, by window and component: (R, W + 1, n)."""
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            return np.asarray(input_bound(self.setting, self.values[:, None, :]))

    def least(self, tau: float) -> Array | None:
        s, components = self.setting, np.arange(self.values.shape[1])
        chosen = np.zeros(len(components), dtype=int)
        while True:
            push = sharp_push(s, self.inputs[chosen, :, components].T)
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                conditions = sharp_under(s, self.values[:, None, :], tau, self.inputs, push)
            good = np.logical_and.reduce([np.all(np.broadcast_to(c.values > 0, self.inputs.shape), axis=1) for c in conditions])
            good &= np.arange(len(self.values))[:, None] >= chosen
            if not good.any(axis=0).all():
                return None
            raised = good.argmax(axis=0)
            if (raised == chosen).all() or not s.cross.any():
                return np.asarray(self.values[raised, components])
            chosen = raised


class _Scalar(_Grid):
    """The statements with one E for all components."""

    def least(self, tau: float) -> Array | None:
        inner = (1,) if self.statement == "general" else (1, 1)
        reach = self.values.max(axis=1).reshape(-1, *inner)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            conditions = conditions_of(self.statement, self.setting, reach, tau)
        good = np.all([np.all(c.values > 0, axis=tuple(range(-len(inner), 0))) for c in conditions], axis=0)
        if not good.any():
            return None
        return np.full(self.values.shape[1], reach.ravel()[int(good.argmax())])


def _tightest(statement: str, s: Setting, reach: Array, tau: float) -> tuple[int, int]:
    """Window and dimension (from 1; 0 for all) with the least slack, relative to the slack of tau = 0."""
    given, conditions = float(reach[0]) if statement == "general" else reach, STATEMENTS[statement].conditions
    now, rest = conditions(s, given, tau), conditions(s, given, 0.0)
    pairs = [(np.asarray(a.values, float), np.asarray(b.values, float)) for a, b in zip(now, rest, strict=True)]
    share = np.min([np.divide(a, b, out=np.full(a.shape, np.inf), where=(b > 0) & np.isfinite(b)) for a, b in pairs], axis=0)
    place = np.unravel_index(int(np.argmin(share)), share.shape)
    return int(place[0]), int(place[1]) + 1 if len(place) > 1 else 0
