"""Test the sampling conditions against adversaries: no proved bound may be violated, and longer periods must fail at some time.

    python -m benchmarks sampled [COUNT] [--record FILE.md]

COUNT loops for each form of the conditions have random bounds, noise, input delay and limits on u, in one or two components; the
law is in single precision. Runs start at corners of the start share, on its faces, and inside. An adversary respects the bounds
that the conditions assume (|f + w|, edge speeds, width, g, noise, age), and pushes as hard as they allow: up, down, with the
motion, against the middle, or at random. At the proved period |eps_i| must stay below E_i, and |u_i| at most U_i. Then periods
grow until the state leaves the tube. The draws are the same in every run. docs/certificate.md states the conditions.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.report import command, record, table
from stt_codegen.sampling.periods import Period, longest_proved_period
from stt_codegen.sampling.sampled_loop import ROUNDING, SampledLaw, SampledLoop
from stt_codegen.sampling.sampling_conditions import SAMPLING_CONDITIONS
from stt_codegen.sampling.windows import Windows

SAMPLES = 150  # of a run
PARTS_PER_PERIOD = 6  # the adversary chooses again in each part
LONGEST_TRIES = 40  # each try is a quarter longer than the one before
E_MAX = 0.999
Array = npt.NDArray[Any]
Adversary = Callable[[random.Random, float, float], float]  # of one component: rng, error e, last rate of x -> direction, 1 or -1

ADVERSARIES: dict[str, Adversary] = {
    "up": lambda *_: 1.0,
    "outward": lambda _rng, e, _last_rate: 1.0 if e >= 0 else -1.0,
    "with the motion": lambda _rng, _e, last_rate: 1.0 if last_rate >= 0 else -1.0,
    "through the middle": lambda _rng, e, _last_rate: -1.0 if e >= 0 else 1.0,
    "at random": lambda rng, *_: rng.choice((-1.0, 1.0)),
}


@dataclass(frozen=True)
class DrawnLoop:
    """The bounds of one sampled loop, the same for each component, on a tube whose middle stays at 0.

    plant_bound: of |f + w|. edge_speed: of an edge, at most. g_min, g_max: of the plant's g. narrow, wide: smallest and largest
    width of the tube. g_rotation: radians; g is a number in [g_min, g_max] times a rotation by at most this angle. A loop with a
    rotation has two components, another one.
    """

    plant_bound: float
    edge_speed: float
    g_min: float
    g_max: float
    narrow: float
    wide: float
    gain: float
    g_rotation: float = 0.0
    noise: float = 0.0
    latency: float = 0.0
    u_max: float = math.inf

    @property
    def dimension(self) -> int:
        return 2 if self.g_rotation else 1

    @property
    def law(self) -> SampledLaw:
        """The law in single precision. |x| is at most 2 wide, and x and the edges are rounded."""
        ones = np.ones(self.dimension)
        shift = (self.noise + 4 * 2.0**-24 * 2 * self.wide) * ones
        return SampledLaw(
            gain=self.gain * ones,
            e_max=E_MAX * ones,
            shift=shift,
            u_max=self.u_max * ones,
            rounding=ROUNDING["float", "libm"],
            latency=self.latency,
        )

    def to_sampled_loop(self, start: float) -> SampledLoop:
        """Return the loop as the sampling conditions read it, for runs that begin with |eps| <= start in every component."""
        n, ones = self.dimension, np.ones((2, self.dimension))
        windows = Windows(
            times=np.array([0.0, 1e3]), narrow=self.narrow * ones, wide=self.wide * ones,
            speed=self.edge_speed * ones, widening=2 * self.edge_speed * ones, low=-ones, high=ones,
            start=np.array([[-self.narrow / 2, self.narrow / 2]] * n),
        )  # fmt: skip
        cosine, sine = math.cos(self.g_rotation), math.sin(self.g_rotation)
        cross = self.g_max * sine * (np.ones((n, n)) - np.eye(n)) * np.ones((2, 1, 1))
        return SampledLoop(
            windows=windows,
            law=self.law,
            diagonal_min=self.g_min * cosine * ones,
            diagonal_max=self.g_max * ones,
            cross=cross,
            closing_speed=(self.plant_bound + self.edge_speed) * ones,
            narrow=self.narrow * ones,
            eigenvalue_min=np.full(2, self.g_min * cosine),
            norm=np.full(2, self.g_max),
            closing_speed_norm=np.full(2, self.plant_bound + math.sqrt(n) * self.edge_speed),
            start=start * np.ones(n),
        )


@dataclass(frozen=True)
class RunExtremes:
    """The largest |eps| and |u| of a run by component, (n,), and the largest norm of eps; infinite once the state has left."""

    eps: Array
    norm: float
    u: Array


def single_precision_input(loop: DrawnLoop, measured: Array, low: Array, width: Array) -> Array:
    """Return the input of equation (13) with the clamp and the limit, in single precision as the emitted C computes it."""
    x, lower, upper = (v.astype(np.float32) for v in (measured, low, low + width))
    wide = upper - lower
    a, b = x - lower, upper - x
    near = np.maximum(np.minimum(a, b), wide * np.float32((1 - E_MAX) / 2))
    ratio = (wide - near) / near
    size = np.float32(loop.gain) * ((1 + ratio) / (wide - near)) * np.log(ratio)
    return np.clip(np.where(b < a, -size, size).astype(float), -loop.u_max, loop.u_max)


def normalized_error(x: Array, low: Array, width: Array) -> Array:
    """Return e, which is -1 at the lower edge and 1 at the upper edge."""
    return (2 * x - (2 * low + width)) / width


def worst_plant_rate(loop: DrawnLoop, u: Array, direction: Array) -> Array:
    """Return f + g u + w where f, g and w push into `direction`, (n,), as hard as their bounds allow."""
    # g is smallest where u opposes the direction, and largest where u helps
    g = np.where(u * direction < 0, loop.g_min, loop.g_max)
    rotated_u = u
    if loop.dimension == 2:
        angle = loop.g_rotation * (1 if direction[0] * u[-1] < 0 else -1)
        cosine, sine = math.cos(angle), math.sin(angle)
        rotated_u = np.array([cosine * u[0] - sine * u[1], sine * u[0] + cosine * u[1]])
        g = np.full(2, loop.g_min if float(rotated_u @ direction) < 0 else loop.g_max)
    return loop.plant_bound / math.sqrt(loop.dimension) * direction + g * rotated_u


def run_loop(loop: DrawnLoop, age: float, e: Array, adversary: Adversary, rng: random.Random) -> RunExtremes:
    """Simulate a loop from the normalized errors `e`, with samples that are `age` old when the next one acts."""
    n, width = loop.dimension, np.array([rng.uniform(loop.narrow, loop.wide) for _ in range(loop.dimension)])

    def directions(e: Array, last_rate: Array) -> Array:
        return np.array([adversary(rng, float(v), float(m)) for v, m in zip(e, last_rate, strict=True)])

    low = -width / 2
    x = low + width * (1 + e) / 2
    rate, eps, norm, largest_u, u = np.zeros(n), np.zeros(n), 0.0, np.zeros(n), np.zeros(n)
    latency = min(loop.latency, age / 2)  # a sample acts before the next one is taken
    period = age - latency
    for step in range(SAMPLES):
        noise = directions(normalized_error(x, low, width), rate) * loop.noise
        last_u, u = u, single_precision_input(loop, x - noise, low, width)
        largest_u = np.maximum(largest_u, np.abs(u))
        delay = latency if step else 0.0  # the first sample acts from the start
        parts = [(last_u, delay / 2)] * 2 * bool(delay) + [(u, (period - delay) / PARTS_PER_PERIOD)] * PARTS_PER_PERIOD
        for acting_u, seconds in parts:
            direction = directions(normalized_error(x, low, width), rate)
            rate = worst_plant_rate(loop, acting_u, direction)
            lower_rate, upper_rate = adversary_edge_rates(loop, direction, width, seconds, rng)
            x, low, width = x + rate * seconds, low + lower_rate * seconds, width + (upper_rate - lower_rate) * seconds
            middle = low + width / 2
            x, low = x - middle, low - middle  # the origin moves along, so that |x| stays below 2 wide
            e = normalized_error(x, low, width)
            is_inside = np.abs(e) < 1
            if not is_inside.all():
                return RunExtremes(np.where(is_inside, eps, np.inf), math.inf, largest_u)
            abs_eps = np.abs(2 * np.arctanh(e))
            eps, norm = np.maximum(eps, abs_eps), max(norm, float(np.sqrt((abs_eps**2).sum())))
    return RunExtremes(eps, norm, largest_u)


def adversary_edge_rates(
    loop: DrawnLoop, direction: Array, width: Array, seconds: float, rng: random.Random
) -> tuple[Array, Array]:
    """Return the rates of the lower and the upper edges, (n,).

    The edge in `direction` approaches at full speed. The opposite edge moves the same way, or, by chance, the other way where the
    width then stays within its bounds.
    """
    approaching = -loop.edge_speed * direction
    opposite = approaching * rng.choice((1, -1))
    low, high = np.where(direction > 0, opposite, approaching), np.where(direction > 0, approaching, opposite)
    next_width = width + (high - low) * seconds
    is_allowed = (next_width >= loop.narrow) & (next_width <= loop.wide)
    return np.where(is_allowed, low, approaching), np.where(is_allowed, high, approaching)


def draw_loop(rng: random.Random, is_rotated: bool) -> DrawnLoop:
    """Draw the bounds of a loop. is_rotated: whether g rotates, in two components."""
    narrow = rng.uniform(0.05, 1.0)
    g_min = rng.uniform(0.3, 1.5)
    edge_speed, plant_bound = rng.uniform(0.0, 2.0), rng.uniform(0.01, 1.0)
    gain = rng.uniform(0.2, 3.0) * narrow * (edge_speed + plant_bound) / g_min
    wide = narrow * rng.choice((1.0, 1.0, rng.uniform(1.0, 2.0)))
    noise = narrow * rng.choice((0.0, rng.uniform(0.0, 0.02)))
    latency = narrow / (edge_speed + plant_bound) * rng.choice((0.0, rng.uniform(0.0, 0.005)))
    u_max = rng.choice((math.inf, rng.uniform(1.1, 4.0) * (edge_speed + plant_bound) / g_min))
    return DrawnLoop(
        plant_bound=plant_bound,
        edge_speed=edge_speed,
        g_min=g_min,
        g_rotation=rng.uniform(0.05, 0.6) if is_rotated else 0.0,
        g_max=g_min * rng.uniform(1.0, 1.5),
        narrow=narrow,
        wide=wide,
        gain=gain,
        noise=noise,
        latency=latency,
        u_max=u_max,
    )


def start_errors(loop: DrawnLoop, share: float, rng: random.Random) -> list[Array]:
    """Return a normalized error, (n,), for each adversary: corners of the start share, a point of a face, and one inside."""
    corner = np.array([rng.choice((-share, share)) for _ in range(loop.dimension)])
    face, inside = corner.copy(), np.array([rng.uniform(-share, share) for _ in range(loop.dimension)])
    face[-1] = inside[-1]
    return [corner, -corner, face, inside, corner]


def violations(loop: DrawnLoop, form: str, period: Period, share: float, seed: int) -> list[str]:
    """Return the adversaries that reach the proved bound of |eps|, or exceed that of |u|, at the proved period.

    There must be none. form: of the sampling conditions that proved the period.
    """
    names, rng = [], random.Random(seed)
    for (name, adversary), e in zip(ADVERSARIES.items(), start_errors(loop, share, rng), strict=True):
        extremes = run_loop(loop, period.seconds, e, adversary, rng)
        is_bounded = extremes.norm < period.eps_bound[0] if form == "general" else (extremes.eps < period.eps_bound).all()
        if not (is_bounded and (extremes.u <= period.u).all()):
            names.append(name)
    return names


def failure_factor(loop: DrawnLoop, period: Period, share: float, seed: int) -> float:
    """Return how many times the proved period is needed until an adversary drives the state out of the tube.

    It is infinite where no adversary does.
    """
    factor = 1.0
    for _ in range(LONGEST_TRIES):
        rng = random.Random(seed)
        for adversary, e in zip(ADVERSARIES.values(), start_errors(loop, share, rng), strict=True):
            if math.isinf(run_loop(loop, period.seconds * factor, e, adversary, rng).norm):
                return factor
        factor *= 1.25
    return math.inf


def form_row(form: str, is_rotated: bool, count: int, rng: random.Random) -> list[str]:
    """Return the table's row of one form of the sampling conditions, over `count` drawn loops."""
    proved, violated, factors = 0, 0, []
    for seed in range(count):
        loop = draw_loop(rng, is_rotated)
        share = rng.choice((0.9, rng.uniform(0.0, 0.9)))
        period = longest_proved_period(form, loop.to_sampled_loop(2 * math.atanh(share) * (1 + 1e-9)))
        if period is None:
            continue
        proved += 1
        violated += bool(violations(loop, form, period, share, seed))
        if seed % 4 == 0:
            factors.append(failure_factor(loop, period, share, seed))
    name = form + (", g turned by up to 0.6 rad" if is_rotated else "")
    factor_text = f"{min(factors):.1f} / {sorted(factors)[len(factors) // 2]:.1f}" if factors else "-"
    return [name, str(count), str(proved), str(violated), factor_text]


def main() -> int:
    """Run the loops of each form, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser()
    parser.add_argument("count", nargs="?", type=int, default=200)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    rng = random.Random(1)
    rows = []
    for form in SAMPLING_CONDITIONS:
        for is_rotated in (False, True) if form != "diagonal" else (False,):  # that form is for a diagonal g
            rows.append(form_row(form, is_rotated, options.count, rng))
    headings = ("statement", "loops", "proved a period", "violated", "first failure, times the period: least / median")
    text = table(headings, rows)
    print(text)
    if options.record:
        record(options.record, "sampled", f"## Sampled statements against adversaries\n\n`{command()}`\n\n{text}")
    return 1 if any(row[3] != "0" for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
