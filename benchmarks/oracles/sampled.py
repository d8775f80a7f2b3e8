"""What refutes P9 for a plant of order 2: a held loop that leaves. Found none, nothing is known.

The law as it is printed, in doubles, and the plant within its bounds at its worst: f + w, every g and every measured number are
chosen against the law, samples are as old as they may be, starts lie in the corners of the share with the speed that is stated.
Between two moments all that acts is constant, so x and v follow exactly, and z = v + lambda x is compared with the spline's own
edges. The steepest force pushes outwards, along with z, along with u (which overshoots), one way, to and fro, or at random.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.oracles.order_two import WEIGHTS, emitted_limit, least_g
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.task.task import Task

Array = npt.NDArray[np.float64]
LONGER = 1.15  # how far beyond t_c a run goes
MOST_STEPS = 2_500
CLEAR = 1e-9  # of the width, beyond which z has left
WAYS = ("outwards", "inwards", "with z", "with u", "against u", "up", "down", "random", "wave 2", "wave 3", "wave 5", "wave 8")
LIES = ("hide", "show", "random")


@dataclass(frozen=True)
class Left:
    """A run outside the filtered tube or the tube, or beyond a bound that is claimed: when, which component, how it was made."""

    time: float
    dimension: int
    way: str
    what: str


@dataclass(frozen=True)
class Bounds:
    """What a certificate says of e of z and of u, by component."""

    e: tuple[float, ...]
    u: tuple[float, ...]


def edges_at(design: RefinedDesign, t: Array) -> tuple[Array, Array, Array, Array]:
    """L, R, L', R' at times (M,), each (M, n); from t_c on they stand."""
    table = np.array(design.table, dtype=float) * float(design.unit)
    t_c, segments = float(design.prescribed_time), design.segments
    place = np.clip(t / t_c, 0, 1) * segments
    k = np.minimum(place.astype(int), segments - 1)
    s = (place - k)[:, None]
    powers = np.concatenate([np.ones_like(s), s, s**2, s**3], axis=1)
    slopes = np.concatenate([np.zeros_like(s), np.ones_like(s), 2 * s, 3 * s**2], axis=1)
    weights = np.array(WEIGHTS, dtype=float)
    places, rates = (np.einsum("mp,jp,mjis->mis", v, weights, table[k[:, None] + np.arange(4)]) for v in (powers, slopes))
    rates = np.where((t < t_c)[:, None, None], rates, 0) * segments / t_c
    return places[..., 0], places[..., 1], rates[..., 0], rates[..., 1]


def moments(period: float, latency: float, end: float) -> list[tuple[float, bool, bool]]:
    """Times up to the end, whether a sample is taken then, and whether one begins to act: (time, taken, acts)."""
    count = int(end / period) + 1
    found: dict[float, list[bool]] = {}
    for k in range(count):
        found.setdefault(round(k * period, 12), [False, False])[0] = True  # both have that many decimals at most
        found.setdefault(round(k * period + (latency if k else 0.0), 12), [False, False])[1] = True
    parts = 4 if latency == 0 else 2
    times, result = sorted(found), []
    for a, b in itertools.pairwise(times):
        result.append((a, *found[a]))
        result += [(a + (b - a) * j / parts, False, False) for j in range(1, parts)]
    return result[:MOST_STEPS]


@dataclass(frozen=True)
class Loop:
    """The law's numbers and the plant's bounds, as doubles; n of each."""

    lam: Array
    gain: Array
    clamp: Array
    limit: Array
    wrong: float | Array  # what the measured z is wrong by
    force: float
    g: tuple[float, float]
    cross: float

    @classmethod
    def of(cls, task: Task, design: RefinedDesign) -> Loop:
        lam, gain, clamp = (np.array([float(v) for v in given]) for given in (design.filter, task.gain, task.e_max))
        limit = np.array([float(v) for v in emitted_limit(task)] or [np.inf] * task.dimension)
        noise, noise_v = float(task.plant.noise or 0), float(task.plant.noise_v or 0)
        force = float((task.plant.f_max or 0) + (task.plant.w_max or 0))
        g_min = float(least_g(task))
        g_max = float(task.plant.g_max) if task.plant.g_max is not None else max(1.0, g_min)
        cross = float(task.plant.g_cross or 0)
        return cls(lam, gain, clamp, limit, noise_v + lam * noise, force, (g_min, g_max), cross)

    def law(self, seen: Array, first: Array, second: Array) -> Array:
        """u for a measured z in the filtered tube (first, second)."""
        width, a, b = second - first, seen - first, second - seen
        near = np.maximum(np.minimum(a, b), (1 - self.clamp) / 2 * width)
        far = width - near
        u = np.minimum(self.gain * (1 + far / near) / far * np.log(far / near), self.limit)
        return np.where(b < a, -u, u)

    def acceleration(self, d: Array, u: Array) -> Array:
        """With all that is free pushing in the directions d."""
        others = np.abs(u).sum(axis=1, keepdims=True) - np.abs(u)
        return d * (self.force + self.cross * others) + np.where(u * d > 0, self.g[1], self.g[0]) * u


def corners(task: Task, low: Array, high: Array, runs: int, dice: np.random.Generator) -> tuple[Array, Array]:
    """x and v of starts in corners of the share, most with their speed outwards."""
    corner = dice.choice((-1.0, 1.0), (runs, task.dimension))
    x = (low + high) / 2 + corner * float(task.initial_set.share) * (1 - 1e-9) * (high - low) / 2
    return x, corner * dice.choice((-1.0, 1.0, 1.0), (runs, 1)) * np.array([float(v) for v in task.start_speed])


def counterexample(task: Task, design: RefinedDesign, seed: int = 0, bounds: Bounds | None = None) -> Left | None:
    """A run that leaves, or that passes the bounds where some are given; None where none was found."""
    assert task.control.period is not None
    dice, loop = np.random.default_rng(seed), Loop.of(task, design)
    plan = moments(float(task.control.period), float(task.control.latency), LONGER * float(design.prescribed_time))
    low, high, low_rate, high_rate = edges_at(design, np.array([t for t, _, _ in plan]))
    first, second = low_rate + loop.lam * low, high_rate + loop.lam * high
    lies = LIES if np.any(loop.wrong) else LIES[:1]
    rows = list(itertools.product(WAYS, lies, range(6 // len(lies))))
    ways, told = np.array([w for w, _, _ in rows]), np.array([v for _, v, _ in rows])[:, None]

    def found(outside: npt.NDArray[np.bool_], what: str) -> Left | None:
        r, i = np.argwhere(outside)[0] if outside.any() else (-1, -1)
        return None if r < 0 else Left(t, int(i), f"{ways[r]}, {told[r, 0]}", what)

    x, v = corners(task, low[0], high[0], len(rows), dice)
    acting, moved, wave, queue, sampled = np.zeros_like(x), np.zeros_like(x), np.ones_like(x), list[Array](), 0
    for m, (t, taken, acts) in enumerate(plan):
        z, width = v + loop.lam * x, second[m] - first[m]
        e = (2 * z - first[m] - second[m]) / width
        left = found((np.abs(e) > 1 + CLEAR) | (x < low[m] - CLEAR * width) | (x > high[m] + CLEAR * width), "left")
        if left is None and bounds is not None:
            left = found(np.abs(e) > np.array(bounds.e) + CLEAR, "e")
        if taken:
            wave = waves(ways, sampled, wave, dice)
            sampled += 1
            d = directions(ways, e, moved, acting, wave)
            lie = np.where(told == "hide", -d, np.where(told == "show", d, dice.choice((-1.0, 1.0), d.shape)))
            queue.append(loop.law(z + lie * loop.wrong, first[m], second[m]))
            if left is None and bounds is not None:
                left = found(np.abs(queue[-1]) > np.array(bounds.u) * (1 + 1e-6), "u")
        if left is not None or m + 1 == len(plan):
            return left
        if acts:
            acting = queue.pop(0)
        h, rate = plan[m + 1][0] - t, loop.acceleration(directions(ways, e, moved, acting, wave), acting)
        x, v = x + v * h + rate * h * h / 2, v + rate * h
        moved = (rate + loop.lam * v) - (first[m + 1] + second[m + 1] - first[m] - second[m]) / (2 * h)
    return None


def waves(ways: npt.NDArray[np.str_], sampled: int, wave: Array, dice: np.random.Generator) -> Array:
    """Random directions until the next sample, and those that turn after every so many."""
    found = dice.choice((-1.0, 1.0), wave.shape) if sampled else wave.copy()
    for length in (2, 3, 5, 8):
        found[ways == f"wave {length}"] = 1.0 if sampled // length % 2 else -1.0
    return found


def directions(ways: npt.NDArray[np.str_], e: Array, moved: Array, acting: Array, wave: Array) -> Array:
    """Where all that is free pushes, by run and component."""
    found = wave.copy()
    for name, by in (("outwards", e), ("inwards", -e), ("with z", moved), ("with u", acting), ("against u", -acting)):
        found[ways == name] = np.where(by >= 0, 1.0, -1.0)[ways == name]
    found[ways == "up"], found[ways == "down"] = 1.0, -1.0
    return found
