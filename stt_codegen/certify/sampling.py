"""How slowly a control law may be sampled and still keep the state in its tube: three statements, evaluated.

u is held; tau is the greatest age of the sample it was made from: the period, what lost samples add, and the latency l. The first
sample is taken at 0 and acts from then on. With q(E) = E cosh(E/2)^2, h(a, b) = (1/a + 1/b) ln(a/b), widths
d- <= gamma_d <= d+, P = |f + w| + |edge rate| and U a bound on |u|, all in one time window, |eps| < E at the start stays so if

    sharp (by component; g may couple a little): P' = P + sum_j |g_ij| U_j over j != i, c = P' tau + g_ii U l,
        (P' + g_ii U) tau < (d-/2) tanh(E/2), and for d = d- and d = d+, a = d/(1 + e^-E) - c, b = d/(1 + e^E) + c:
        a > b and k g_min h(a, b) > P'
    diagonal (by component, g diagonal):  P/g_min + R tau < 4 k q(E)/d+
    general (eps a vector, |.| its norm): P + G R tau < 4 k g_min q_n(E)/d+,  q_n(E) = E cosh(E/(2 sqrt n))^2
    with R = 16 k q'(E) cosh(E/2)^2 (F + G U + S)/d-^2 + 4 k q(E) D/d-^2.

`lemmas/sampled.py` proves them. A sample in a window may stem from the window before it, so P, U and d- of R take the worse of
both; tau is at most a window, half of one where there is latency. Two kinds of error are allowed for: `shift`, by which what the
law sees of x and of the edges is wrong (noise, P7, x rounded to the scalar), and the law's own rounding, relative and in eps.

The formulas are written once. Searched for are E and tau in doubles; what is returned has been shown in balls (Arb).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.certify.plant import Bounds
from stt_codegen.certify.windows import Windows
from stt_codegen.program.number import FORMATS
from stt_codegen.task import Task

Array = npt.NDArray[Any]
STATEMENTS = ("sharp", "diagonal", "general")
# Of the emitted law against (13) on what it sees: relative, and in eps = ln(a/b). Float: less than 32 roundings of 2^-24, the
# library's logarithm within 4 units; inline adds its 2^-14.9 of eps.
ROUNDING = {
    ("float", "libm"): 2.0**-19,
    ("float", "inline"): 2.0**-14,
    ("double", "libm"): 2.0**-46,
    ("double", "inline"): 2.0**-14,
}
BACK_OFF = (1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1)  # below the searched tau, until the balls agree


@dataclass(frozen=True)
class Law:
    """gain = |k|; shift, u_max by component (infinite where u is not limited); rounding relative and in eps."""

    gain: float
    e_max: float
    shift: Array
    u_max: Array
    rounding: float
    latency: float = 0.0  # seconds from a sample to the input that it makes

    @property
    def farthest(self) -> float:
        """eps(e_max)."""
        return float(2 * np.arctanh(self.e_max))


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
        """What |e| stays below."""
        return float(np.tanh(self.reach / 2))


@dataclass(frozen=True)
class Setting:
    """A tube, a plant over it and a law: arrays (W + 1, n) by window, those with `back` the worse of it and the one before."""

    windows: Windows
    law: Law
    least: Array
    most: Array  # back
    cross: Array  # back (W + 1, n, n)
    push: Array  # back: P by component
    narrow: Array  # back
    definite: Array  # (W + 1)
    norm: Array  # back (W + 1)
    push_norm: Array  # back (W + 1): F + S
    start: Array  # |eps(0)|, (n)

    @property
    def longest_age(self) -> float:
        """Of a sample, so that it and what acted before it stem from this window or the one before."""
        return self.windows.shortest / (2 if self.law.latency else 1)

    def with_gain(self, gain: float) -> Setting:
        return replace(self, law=replace(self.law, gain=gain))


def law_of(task: Task, edge_error: Sequence[Fraction], noise: float = 0.0, latency: float = 0.0) -> Law:
    """The law of a task; `noise` bounds the error of a measured x, by component, in the task's units; latency in seconds."""
    n = task.dimension
    limits = task.control.u_max
    size = max(abs(v) for edge in (task.state_space.lower, task.state_space.upper) for v in edge)
    rounded = float(FORMATS[task.emit.scalar].roundoff * size) * (1 + 1e-12)
    return Law(
        abs(float(task.control.gain)),
        float(task.control.e_max),
        np.array([2 * float(e) * (1 + 1e-12) + rounded + noise for e in edge_error]),
        np.full(n, np.inf) if limits is None else np.array([float(v) * (1 - 2.0**-23) for v in limits]),
        ROUNDING[task.emit.scalar, task.emit.math],
        latency,
    )


def setting_of(windows: Windows, plant: Sequence[Bounds], law: Law, x0: Sequence[float]) -> Setting:
    """`plant`: bounds for every window, over it and the one before it. x0: where the run begins, strictly inside."""
    push = np.array([p.push for p in plant])
    speed = _back(windows.speed, np.maximum)
    x = np.array(x0)
    a, b = x - windows.start[:, 0], windows.start[:, 1] - x
    a, b = a - 1e-15 * np.abs(x), b - 1e-15 * np.abs(x)  # more than the differences are rounded by
    with np.errstate(divide="ignore", invalid="ignore"):
        start = np.where((a > 0) & (b > 0), np.abs(np.log(a / b)) * (1 + 1e-9), np.inf)
    total = np.sqrt((speed**2).sum(axis=1)) * (1 + 1e-12)
    return Setting(
        windows,
        law,
        np.array([p.least for p in plant]),
        np.array([p.most for p in plant]),
        np.array([p.cross for p in plant]),
        (push + speed) * (1 + 1e-12),
        _back(windows.narrow, np.minimum),
        np.array([p.definite for p in plant]),
        np.array([p.norm for p in plant]),
        (np.array([p.push_norm for p in plant]) + total) * (1 + 1e-12),
        start,
    )


def _back(values: Array, worse: Callable[[Array, Array], Array]) -> Array:
    """By window the worse of its value and that of the window before."""
    return worse(values, np.concatenate([values[:1], values[:-1]]))


# ------------------------------------------------------------------------------------- formulas, once
# They work on arrays of doubles and on arrays of balls; `reach` (E) and `tau` are a double or a ball.


def q(e: Any) -> Any:
    return e * np.cosh(e / 2) ** 2


def q_rate(e: Any) -> Any:
    """q'(E)."""
    return np.cosh(e / 2) ** 2 * (1 + e * np.tanh(e / 2))


def pull(a: Any, b: Any) -> Any:
    """h(a, b): the law's |u|/k at distances a > b to the edges."""
    return (1 / a + 1 / b) * np.log(a / b)


def _seen(s: Setting, reach: Any) -> tuple[Any, Any]:
    """The farthest and the nearest distance to an edge that the law may see, at the width at which its |u| is greatest."""
    d = s.narrow + 0 * reach
    return d / (1 + np.exp(-reach)) + s.law.shift, d / (1 + np.exp(reach)) - s.law.shift


def input_bound(s: Setting, reach: Any) -> Any:
    """U (W + 1, n): |u| while |eps| < reach; by the clamp where noise may carry what is seen beyond e_max; at most u_max."""
    far, near = _seen(s, reach)
    c = (1 - s.law.e_max) / 2
    width = s.narrow - 2 * s.law.shift
    known = np.asarray(width, dtype=float) > 0  # else the law may see any width, and no bound is known
    held = np.where(known, width, 1 + 0 * width)
    clamped = np.where(known, s.law.gain * pull((1 - c) * held, c * held) * (1 + s.law.rounding), np.inf) + 0 * reach
    free = np.asarray(near, dtype=float) > np.asarray(far + near, dtype=float) * c
    with np.errstate(invalid="ignore", divide="ignore"):
        safe_far, safe_near = np.where(free, far, 2 + 0 * reach), np.where(free, near, 1 + 0 * reach)
        law = s.law.gain * (pull(safe_far, safe_near) + s.law.rounding * (1 / safe_far + 1 / safe_near)) * (1 + s.law.rounding)
    u = np.where(free, law, clamped)
    return np.where(np.asarray(u, dtype=float) < s.law.u_max * (1 - 1e-9), u, np.minimum(s.law.u_max, 1e300) + 0 * reach)


def _sharp_push(s: Setting, u: Any) -> Any:
    """P' = P + sum over j != i of |g_ij| U_j."""
    return s.push + (s.cross * u[..., None, :]).sum(axis=-1)


def sharp(s: Setting, reach: Any, tau: Any) -> list[Any]:
    """What must be positive."""
    u = input_bound(s, reach)
    push = _sharp_push(s, u)
    drift = push * tau + s.most * u * s.law.latency + s.law.shift
    narrow = s.windows.narrow
    conditions = [narrow / 2 * (np.tanh(reach / 2) - s.law.rounding) - (push + s.most * u) * tau - s.law.shift]
    for d in (narrow, s.windows.wide):
        far, near = d / (1 + np.exp(-reach)) - drift, d / (1 + np.exp(reach)) + drift
        conditions.append(far - near)
        with np.errstate(invalid="ignore", divide="ignore"):
            held = pull(far, near) - s.law.rounding * (1 / far + 1 / near)
        conditions.append(s.law.gain * (1 - s.law.rounding) * s.least * held - push)
    conditions.append(np.minimum(s.law.u_max, 1e300) * s.least - push)
    return conditions


def _seen_reach(s: Setting, reach: Any, d: Any, shift: Any) -> tuple[Any, Any]:
    """E of what the law may see at width d while |eps| < reach, and by how much its nearer distance stays above 0."""
    near = d / (1 + np.exp(reach)) - shift
    far = d / (1 + np.exp(-reach)) + shift
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.log(far / near), near


def _stale(s: Setting, reach: Any, seen: Any, tau: Any, push: Any, g: Any, widening: Any, d: Any, shift: Any) -> tuple[Any, Any]:
    """U = 4 k q(E')/d-, E' of what is seen; and |u held - u now|: R tau, then what `shift` adds, at the law's steepest
    (16 k q' cosh^2/d-^2 at E'), and rounding."""
    u = u_of(s, seen, d) * (1 + 2 * s.law.rounding)
    rate = 16 * s.law.gain * q_rate(reach) * np.cosh(reach / 2) ** 2 / d**2 * (push + g * u)
    rate = rate + 4 * s.law.gain * q(reach) * widening / d**2
    steep = 16 * s.law.gain * q_rate(seen) * np.cosh(seen / 2) ** 2 / d**2
    return u, rate * tau + steep * shift + s.law.rounding * (u + 4 * s.law.gain * np.cosh(seen / 2) ** 2 / d)


def u_of(s: Setting, reach: Any, d: Any) -> Any:
    """4 k q(E)/d-."""
    return 4 * s.law.gain * q(reach) / d


def diagonal(s: Setting, reach: Any, tau: Any) -> list[Any]:
    seen, near = _seen_reach(s, reach, s.narrow, s.law.shift)
    widening = _back(s.windows.widening, np.maximum)
    u, stale = _stale(s, reach, seen, tau, s.push, s.most, widening, s.narrow, s.law.shift)
    return [
        4 * s.law.gain * q(reach) / s.windows.wide - stale - s.push / np.maximum(s.least, 1e-300),
        s.law.u_max - np.asarray(u, dtype=float) + 0 * reach,
        s.least + 0 * reach,
        near,
        1e-300 - s.cross.sum(axis=-1) + 0 * reach,
    ]


def general(s: Setting, reach: Any, tau: Any) -> list[Any]:
    n = s.narrow.shape[1]
    d, wide = s.narrow.min(axis=1), s.windows.wide.max(axis=1)
    widening = _back(s.windows.widening.max(axis=1), np.maximum)
    each = float(s.law.shift.max())
    seen, near = _seen_reach(s, reach, d, each)
    root = np.sqrt(float(n)) * (1 + 1e-12)
    seen = reach + root * (seen - reach)  # a bound on the norm of what is seen, and on every component
    u, stale = _stale(s, reach, seen, tau, s.push_norm, s.norm, widening, d, each * root)
    q_n = reach * np.cosh(reach / (2 * root)) ** 2
    return [
        s.law.gain * s.definite * 4 / wide * q_n - s.push_norm - s.norm * stale,
        s.law.u_max.min() - np.asarray(u, dtype=float) + 0 * reach,
        s.definite + 0 * reach,
        near,
    ]


FORMULAS: dict[str, Callable[[Setting, Any, Any], list[Any]]] = {"sharp": sharp, "diagonal": diagonal, "general": general}


# ---------------------------------------------------------------------------------------- search, then proof


def holds(statement: str, s: Setting, reach: float, tau: float) -> bool:
    """Shown in balls: with |eps(0)| < reach and samples no older than tau the state stays in the tube."""
    start = float(np.sqrt((s.start**2).sum())) if statement == "general" else float(s.start.max())
    if not (math.isfinite(start) and start * (1 + 1e-12) < reach <= s.law.farthest * (1 - 1e-12)):
        return False
    if not s.law.latency <= tau <= s.longest_age:
        return False
    return all(bool(np.all(c > 0)) for c in FORMULAS[statement](_in_balls(s), arb(reach), arb(tau)))


def _in_balls(s: Setting) -> Setting:
    """The same with balls in place of doubles where a formula calculates."""
    convert = np.vectorize(arb, otypes=[object])
    windows = replace(s.windows, **{name: convert(getattr(s.windows, name)) for name in ("narrow", "wide", "speed", "widening")})
    names = ("least", "most", "cross", "push", "narrow", "definite", "norm", "push_norm")
    return replace(s, windows=windows, **{name: convert(getattr(s, name)) for name in names})


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
            conditions = FORMULAS[statement](s, reach, tau.reshape(-1, *inner))
        each = [np.all(c > 0, axis=tuple(range(-len(inner), 0))) for c in conditions]
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
    now, rest = FORMULAS[statement](s, reach, tau), FORMULAS[statement](s, reach, 0.0)
    pairs = [(np.asarray(a, float), np.asarray(b, float)) for a, b in zip(now, rest, strict=True)]
    share = np.min([np.divide(a, b, out=np.full(a.shape, np.inf), where=(b > 0) & np.isfinite(b)) for a, b in pairs], axis=0)
    place = np.unravel_index(int(np.argmin(share)), share.shape)
    return int(place[0]), int(place[1]) + 1 if len(place) > 1 else 0
