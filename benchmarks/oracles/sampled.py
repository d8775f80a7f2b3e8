"""Adversaries against P9 of a plant of order 2: a loop with held inputs that leaves refutes a claimed period. A search that finds
no such loop proves nothing.

The law is the printed one, in doubles, and the plant is at its worst within its bounds: f + w, every g and every measured number
are chosen against the law, samples are as old as the task allows, starts lie in the corners of the start share with the stated
speed. Between two moments all that acts is constant, so x and v follow exactly, and z = v + lambda x is compared with the
spline's edges. The largest force pushes outwards, along with z, along with u (so that u overshoots), always one way, to and fro,
or at random. `mutations.py --inertia` calls `counterexample`.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from benchmarks.oracles.order_two import SPLINE_WEIGHTS, emitted_input_limits, smallest_g
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.task.task import Task

Array = npt.NDArray[np.float64]
RUN_LENGTH = 1.15  # times t_c
MOMENTS_LIMIT = 2_500  # of a run
TOLERANCE = 1e-9  # of the width, for the rounding of these doubles
WAVE_LENGTHS = (2, 3, 5, 8)  # samples after which a wave changes its sign
# How f + w and g push.
PUSHES = (
    "outwards",
    "inwards",
    "with z",
    "with u",
    "against u",
    "up",
    "down",
    "random",
    *(f"wave {length}" for length in WAVE_LENGTHS),
)
ERRORS = ("hide", "show", "random")  # of a measurement: against the push, along with it, or at random
RUNS_PER_PUSH = 6


@dataclass(frozen=True)
class LeavingRun:
    """A run that leaves the filtered tube or the tube, or exceeds a claimed bound: when, which component, push and measurement
    error, and what it exceeds: "left", "e" or "u"."""

    time: float
    dimension: int
    way: str
    what: str


@dataclass(frozen=True)
class ClaimedBounds:
    """The bounds that a certificate states, by component: of |e| of z, and of |u|."""

    e: tuple[float, ...]
    u: tuple[float, ...]


class SampledEdges(NamedTuple):
    """L, R, L', R' at times: (M, n) each."""

    lower: Array
    upper: Array
    lower_rate: Array
    upper_rate: Array


def edges_at(design: RefinedDesign, t: Array) -> SampledEdges:
    """Evaluate the tube at times (M,). From t_c on the edges stand still."""
    table = np.array(design.table, dtype=float) * float(design.unit)
    t_c, segments = float(design.prescribed_time), design.segments
    spline_time = np.clip(t / t_c, 0, 1) * segments
    k = np.minimum(spline_time.astype(int), segments - 1)
    s = (spline_time - k)[:, None]
    powers = np.concatenate([np.ones_like(s), s, s**2, s**3], axis=1)
    slopes = np.concatenate([np.zeros_like(s), np.ones_like(s), 2 * s, 3 * s**2], axis=1)
    weights = np.array(SPLINE_WEIGHTS, dtype=float)
    values, rates = (np.einsum("mp,jp,mjis->mis", v, weights, table[k[:, None] + np.arange(4)]) for v in (powers, slopes))
    rates = np.where((t < t_c)[:, None, None], rates, 0) * segments / t_c
    return SampledEdges(values[..., 0], values[..., 1], rates[..., 0], rates[..., 1])


class Moment(NamedTuple):
    """A time of a run, whether a sample is taken then, and whether an input begins to act."""

    time: float
    is_sampled: bool
    is_acting: bool


def run_moments(period: float, latency: float, end: float) -> list[Moment]:
    """Return the moments of a run up to its end: samples, beginnings of inputs, and a few in between."""
    events: dict[float, list[bool]] = {}
    for k in range(int(end / period) + 1):
        events.setdefault(round(k * period, 12), [False, False])[0] = True  # both have at most that many decimals
        events.setdefault(round(k * period + (latency if k else 0.0), 12), [False, False])[1] = True
    parts = 4 if latency == 0 else 2
    moments = []
    for a, b in itertools.pairwise(sorted(events)):
        moments.append(Moment(a, *events[a]))
        moments += [Moment(a + (b - a) * j / parts, False, False) for j in range(1, parts)]
    return moments[:MOMENTS_LIMIT]


@dataclass(frozen=True)
class WorstCaseLoop:
    """The numbers of law and plant in doubles. By component: lambda, gain, e_max, the limit of u, and the largest error of the
    measured z. Of all: the bounds on |f + w|, on g (smallest, largest) and on the cross terms of g."""

    lambda_: Array
    gain: Array
    e_max: Array
    input_limit: Array
    z_error: float | Array
    force: float
    g: tuple[float, float]
    cross: float

    @classmethod
    def of(cls, task: Task, design: RefinedDesign) -> WorstCaseLoop:
        """Take the numbers from a task and its design; a bound that the task does not state is 0, of g 1."""
        lambda_, gain, e_max = (np.array([float(v) for v in values]) for values in (design.filter, task.gain, task.e_max))
        limit = np.array([float(v) for v in emitted_input_limits(task)] or [np.inf] * task.dimension)
        noise, noise_v = (np.array([float(v) for v in values]) for values in (task.noise, task.noise_v))
        force = float((task.plant.f_max or 0) + (task.plant.w_max or 0))
        g_min = float(smallest_g(task))
        g_max = float(task.plant.g_max) if task.plant.g_max is not None else max(1.0, g_min)
        cross = float(task.plant.g_cross or 0)
        return cls(lambda_, gain, e_max, limit, noise_v + lambda_ * noise, force, (g_min, g_max), cross)

    def control(self, z: Array, lower: Array, upper: Array) -> Array:
        """Return u for a measured z between the edges of the filtered tube."""
        width, a, b = upper - lower, z - lower, upper - z
        near = np.maximum(np.minimum(a, b), (1 - self.e_max) / 2 * width)
        far = width - near
        u = np.minimum(self.gain * (1 + far / near) / far * np.log(far / near), self.input_limit)
        return np.where(b < a, -u, u)

    def acceleration(self, direction: Array, u: Array) -> Array:
        """Return the acceleration under u while f + w, g and its cross terms push in these directions, 1 or -1."""
        cross_inputs = np.abs(u).sum(axis=1, keepdims=True) - np.abs(u)
        return direction * (self.force + self.cross * cross_inputs) + np.where(u * direction > 0, self.g[1], self.g[0]) * u


def corner_starts(task: Task, low: Array, high: Array, runs: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Draw x and v of starts in corners of the start share, two thirds of them with their speed outwards. low, high: edges at
    0."""
    corner = rng.choice((-1.0, 1.0), (runs, task.dimension))
    x = (low + high) / 2 + corner * float(task.initial_set.share) * (1 - 1e-9) * (high - low) / 2
    return x, corner * rng.choice((-1.0, 1.0, 1.0), (runs, 1)) * np.array([float(v) for v in task.start_speed])


class _Adversaries:
    """So many runs, each with a push and a kind of measurement error, and the random state of both."""

    def __init__(self, dimension: int, has_noise: bool, rng: np.random.Generator) -> None:
        errors = ERRORS if has_noise else ERRORS[:1]
        runs = list(itertools.product(PUSHES, errors, range(RUNS_PER_PUSH // len(errors))))
        self.rng = rng
        self.pushes = np.array([push for push, _, _ in runs])
        self.errors = np.array([error for _, error, _ in runs])[:, None]
        self.samples = 0
        self.wave = np.ones((len(runs), dimension))

    def turn_waves(self) -> None:
        """Draw random directions until the next sample, and change the sign of waves whose time is up."""
        wave = self.rng.choice((-1.0, 1.0), self.wave.shape) if self.samples else self.wave.copy()
        for length in WAVE_LENGTHS:
            wave[self.pushes == f"wave {length}"] = 1.0 if self.samples // length % 2 else -1.0
        self.wave = wave
        self.samples += 1

    def directions(self, e: Array, z_change: Array, u: Array) -> Array:
        """Return where f + w and g push, 1 or -1, by run and component."""
        directions = self.wave.copy()
        for name, by in (("outwards", e), ("inwards", -e), ("with z", z_change), ("with u", u), ("against u", -u)):
            directions[self.pushes == name] = np.where(by >= 0, 1.0, -1.0)[self.pushes == name]
        directions[self.pushes == "up"], directions[self.pushes == "down"] = 1.0, -1.0
        return directions

    def measurement_errors(self, directions: Array) -> Array:
        """Return the signs of the measurement errors by run and component."""
        at_random = self.rng.choice((-1.0, 1.0), directions.shape)
        return np.where(self.errors == "hide", -directions, np.where(self.errors == "show", directions, at_random))

    def first_leaving(self, is_outside: npt.NDArray[np.bool_], time: float, what: str) -> LeavingRun | None:
        """Report the first run and component that is outside; None where all are inside."""
        if not is_outside.any():
            return None
        r, i = np.argwhere(is_outside)[0]
        return LeavingRun(time, int(i), f"{self.pushes[r]}, {self.errors[r, 0]}", what)


def counterexample(task: Task, design: RefinedDesign, seed: int = 0, bounds: ClaimedBounds | None = None) -> LeavingRun | None:
    """Search for a run that leaves, or that exceeds the bounds, if any; None where the search finds none."""
    assert task.control.period is not None
    rng, loop = np.random.default_rng(seed), WorstCaseLoop.of(task, design)
    moments = run_moments(float(task.control.period), float(task.control.latency), RUN_LENGTH * float(design.prescribed_time))
    edges = edges_at(design, np.array([moment.time for moment in moments]))
    z_lower, z_upper = edges.lower_rate + loop.lambda_ * edges.lower, edges.upper_rate + loop.lambda_ * edges.upper
    adversaries = _Adversaries(task.dimension, bool(np.any(loop.z_error)), rng)
    x, v = corner_starts(task, edges.lower[0], edges.upper[0], len(adversaries.pushes), rng)
    u, z_change, computed = np.zeros_like(x), np.zeros_like(x), list[Array]()
    for m, (t, is_sampled, is_acting) in enumerate(moments):
        z, width = v + loop.lambda_ * x, z_upper[m] - z_lower[m]
        e = (2 * z - z_lower[m] - z_upper[m]) / width
        is_outside_tube = (x < edges.lower[m] - TOLERANCE * width) | (x > edges.upper[m] + TOLERANCE * width)
        leaving = adversaries.first_leaving((np.abs(e) > 1 + TOLERANCE) | is_outside_tube, t, "left")
        if leaving is None and bounds is not None:
            leaving = adversaries.first_leaving(np.abs(e) > np.array(bounds.e) + TOLERANCE, t, "e")
        if is_sampled:
            adversaries.turn_waves()
            errors = adversaries.measurement_errors(adversaries.directions(e, z_change, u))
            computed.append(loop.control(z + errors * loop.z_error, z_lower[m], z_upper[m]))
            if leaving is None and bounds is not None:
                leaving = adversaries.first_leaving(np.abs(computed[-1]) > np.array(bounds.u) * (1 + 1e-6), t, "u")
        if leaving is not None or m + 1 == len(moments):
            return leaving
        if is_acting:
            u = computed.pop(0)
        h, rate = moments[m + 1].time - t, loop.acceleration(adversaries.directions(e, z_change, u), u)
        x, v = x + v * h + rate * h * h / 2, v + rate * h
        middle_change = (z_lower[m + 1] + z_upper[m + 1] - z_lower[m] - z_upper[m]) / (2 * h)
        z_change = (rate + loop.lambda_ * v) - middle_change
    return None
