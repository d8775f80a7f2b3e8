"""The sampled statements against adversaries: never violated, and how many times longer a period would have to be to fail.

    python -m benchmarks sampled [COUNT] [--record FILE.md]

One or two components, random bounds, noise, latency, limits on u; the law in single precision. Runs start at the corners and
on the faces of the share that is proved, and inside. Every adversary keeps to the bounds that the statement was told (|f + w|,
edge speeds, width, g, noise, age) and pushes as hard as they allow: up, down, with the motion, against the middle, at random;
the first sample is wrong by all of the noise too. The proved period is run first, where |eps_i| must stay below E_i and |u_i|
below U_i; then longer ones until the state leaves the tube. Deterministic.
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

STEPS, PARTS, TRIES = 150, 6, 40  # samples of a run, parts of a period, doublings of it by a quarter
E_MAX = 0.999
Array = npt.NDArray[Any]
Adversary = Callable[[random.Random, float, float], float]  # draw, place e, last motion -> direction

ADVERSARIES: dict[str, Adversary] = {
    "up": lambda *_: 1.0,
    "outward": lambda _draw, e, _moved: 1.0 if e >= 0 else -1.0,
    "with the motion": lambda _draw, _e, moved: 1.0 if moved >= 0 else -1.0,
    "through the middle": lambda _draw, e, _moved: -1.0 if e >= 0 else 1.0,
    "at random": lambda draw, *_: draw.choice((-1.0, 1.0)),
}


@dataclass(frozen=True)
class Loop:
    """Bounds of one loop: push >= |f + w|, edge speed, g in [least, most], widths, gain, the turn of a planar g, noise, latency,
    u_max."""

    push: float
    speed: float
    least: float
    most: float
    narrow: float
    wide: float
    gain: float
    turn: float = 0.0  # radians: g = least..most times a rotation by up to so much, in two components
    noise: float = 0.0
    latency: float = 0.0
    u_max: float = math.inf

    @property
    def n(self) -> int:
        return 2 if self.turn else 1

    @property
    def law(self) -> SampledLaw:
        """What the statements know of it: x is within 2 wide of 0, and is rounded, as the edges are, to single precision."""
        ones = np.ones(self.n)
        shift = (self.noise + 4 * 2.0**-24 * 2 * self.wide) * ones
        return SampledLaw(
            gain=self.gain * ones,
            e_max=E_MAX * ones,
            shift=shift,
            u_max=self.u_max * ones,
            rounding=ROUNDING["float", "libm"],
            latency=self.latency,
        )

    def setting(self, start: float) -> SampledLoop:
        """What the statements read, for runs that begin with |eps| <= start in every component."""
        n, ones = self.n, np.ones((2, self.n))
        windows = Windows(
            times=np.array([0.0, 1e3]), narrow=self.narrow * ones, wide=self.wide * ones,
            speed=self.speed * ones, widening=2 * self.speed * ones, low=-ones, high=ones,
            start=np.array([[-self.narrow / 2, self.narrow / 2]] * n),
        )  # fmt: skip
        cosine, sine = math.cos(self.turn), math.sin(self.turn)
        cross = self.most * sine * (np.ones((n, n)) - np.eye(n)) * np.ones((2, 1, 1))
        push = (self.push + self.speed) * ones
        root = math.sqrt(n)
        return SampledLoop(
            windows=windows,
            law=self.law,
            diagonal_min=self.least * cosine * ones,
            diagonal_max=self.most * ones,
            cross=cross,
            closing_speed=push,
            narrow=self.narrow * ones,
            eigenvalue_min=np.full(2, self.least * cosine),
            norm=np.full(2, self.most),
            closing_speed_norm=np.full(2, self.push + root * self.speed),
            start=start * np.ones(n),
        )


@dataclass(frozen=True)
class Worst:
    """Over a run: the largest |eps| and |u| by component, and the largest norm of eps; infinite once the state has left."""

    eps: Array
    norm: float
    u: Array


def held_input(loop: Loop, seen: Array, low: Array, width: Array) -> Array:
    """(13) with the clamp and the limit in single precision, as the emitted C has it."""
    x, lower, upper = (v.astype(np.float32) for v in (seen, low, low + width))
    wide = upper - lower
    a, b = x - lower, upper - x
    near = np.maximum(np.minimum(a, b), wide * np.float32((1 - E_MAX) / 2))
    ratio = (wide - near) / near
    push = np.float32(loop.gain) * ((1 + ratio) / (wide - near)) * np.log(ratio)
    return np.clip(np.where(b < a, -push, push).astype(float), -loop.u_max, loop.u_max)


def run(loop: Loop, age: float, e: Array, adversary: Adversary, draw: random.Random) -> Worst:
    """A run with samples that are `age` old when the next one acts, from the normalized errors `e`."""
    n, width = loop.n, np.array([draw.uniform(loop.narrow, loop.wide) for _ in range(loop.n)])
    low = -width / 2
    x = low + width * (1 + e) / 2
    moved, eps, norm, most, u = np.zeros(n), np.zeros(n), 0.0, np.zeros(n), np.zeros(n)
    latency = min(loop.latency, age / 2)  # a sample acts before the next one is taken
    period = age - latency
    for step in range(STEPS):
        e = (2 * x - (2 * low + width)) / width
        lie = np.array([adversary(draw, float(v), float(m)) for v, m in zip(e, moved, strict=True)])
        before, u = u, held_input(loop, x - lie * loop.noise, low, width)
        most = np.maximum(most, np.abs(u))
        late = latency if step else 0.0  # the first sample acts from the start
        parts = [(before, late / 2)] * 2 * bool(late) + [(u, (period - late) / PARTS)] * PARTS
        for acting, part in parts:
            e = (2 * x - (2 * low + width)) / width
            way = np.array([adversary(draw, float(v), float(m)) for v, m in zip(e, moved, strict=True)])
            # f + w within its norm; g the weaker where u opposes the adversary's way, the stronger where it helps
            size = np.where(acting * way < 0, loop.least, loop.most)
            turned = acting
            if n == 2:
                angle = loop.turn * (1 if way[0] * acting[-1] < 0 else -1)
                cosine, sine = math.cos(angle), math.sin(angle)
                turned = np.array([cosine * acting[0] - sine * acting[1], sine * acting[0] + cosine * acting[1]])
                size = np.full(2, loop.least if float(turned @ way) < 0 else loop.most)
            rate = loop.push / math.sqrt(n) * way + size * turned
            x, moved = x + rate * part, rate
            low_rate, high_rate = _edge_rates(loop, way, width, part, draw)
            low, width = low + low_rate * part, width + (high_rate - low_rate) * part
            shift = low + width / 2  # the origin goes along, so that the state stays within 2 wide of it
            x, low = x - shift, low - shift
            e = (2 * x - (2 * low + width)) / width
            inside = np.abs(e) < 1
            if not inside.all():
                return Worst(np.where(inside, eps, np.inf), math.inf, most)
            now = np.abs(2 * np.arctanh(e))
            eps, norm = np.maximum(eps, now), max(norm, float(np.sqrt((now**2).sum())))
    return Worst(eps, norm, most)


def _edge_rates(loop: Loop, way: Array, width: Array, part: float, draw: random.Random) -> tuple[Array, Array]:
    """The edge ahead comes at full speed; the other one comes along, or goes the other way while the width keeps its bounds."""
    along = -loop.speed * way
    other = along * draw.choice((1, -1))
    low, high = np.where(way > 0, other, along), np.where(way > 0, along, other)
    after = width + (high - low) * part
    kept = (after >= loop.narrow) & (after <= loop.wide)
    return np.where(kept, low, along), np.where(kept, high, along)


def drawn(draw: random.Random, turn: bool) -> Loop:
    narrow = draw.uniform(0.05, 1.0)
    least = draw.uniform(0.3, 1.5)
    speed, push = draw.uniform(0.0, 2.0), draw.uniform(0.01, 1.0)
    gain = draw.uniform(0.2, 3.0) * narrow * (speed + push) / least
    wide = narrow * draw.choice((1.0, 1.0, draw.uniform(1.0, 2.0)))
    noise = narrow * draw.choice((0.0, draw.uniform(0.0, 0.02)))
    latency = narrow / (speed + push) * draw.choice((0.0, draw.uniform(0.0, 0.005)))
    u_max = draw.choice((math.inf, draw.uniform(1.1, 4.0) * (speed + push) / least))
    turned = draw.uniform(0.05, 0.6) if turn else 0.0
    return Loop(push, speed, least, least * draw.uniform(1.0, 1.5), narrow, wide, gain, turned, noise, latency, u_max)


def begins(loop: Loop, share: float, draw: random.Random) -> list[Array]:
    """Normalized errors to begin with: corners of the share, points of its faces and inside, in turn over the adversaries."""
    corner = np.array([draw.choice((-share, share)) for _ in range(loop.n)])
    face, inside = corner.copy(), np.array([draw.uniform(-share, share) for _ in range(loop.n)])
    face[-1] = inside[-1]
    return [corner, -corner, face, inside, corner]


def violations(loop: Loop, statement: str, period: Period, share: float, seed: int) -> list[str]:
    """Adversaries that drive |eps| to E, or |u| to U, or beyond at the proved period: there must be none."""
    found, draw = [], random.Random(seed)
    for (name, adversary), e in zip(ADVERSARIES.items(), begins(loop, share, draw), strict=True):
        worst = run(loop, period.seconds, e, adversary, draw)
        kept = worst.norm < period.eps_bound[0] if statement == "general" else (worst.eps < period.eps_bound).all()
        if not (kept and (worst.u <= period.u).all()):
            found.append(name)
    return found


def factor(loop: Loop, period: Period, share: float, seed: int) -> float:
    """How many times the proved period some adversary needs to drive the state out; infinite when none does."""
    times = 1.0
    for _ in range(TRIES):
        draw = random.Random(seed)
        for adversary, e in zip(ADVERSARIES.values(), begins(loop, share, draw), strict=True):
            if math.isinf(run(loop, period.seconds * times, e, adversary, draw).norm):
                return times
        times *= 1.25
    return math.inf


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("count", nargs="?", type=int, default=200)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    draw = random.Random(1)
    rows = []
    for statement in SAMPLING_CONDITIONS:
        for turn in (False, True) if statement != "diagonal" else (False,):
            loops, proved, broken, factors = 0, 0, 0, []
            for seed in range(options.count):
                loop = drawn(draw, turn)
                share = draw.choice((0.9, draw.uniform(0.0, 0.9)))
                loops += 1
                period = longest_proved_period(statement, loop.setting(2 * math.atanh(share) * (1 + 1e-9)))
                if period is None:
                    continue
                proved += 1
                broken += bool(violations(loop, statement, period, share, seed))
                if seed % 4 == 0:
                    factors.append(factor(loop, period, share, seed))
            name = statement + (", g turned by up to 0.6 rad" if turn else "")
            spread = f"{min(factors):.1f} / {sorted(factors)[len(factors) // 2]:.1f}" if factors else "-"
            rows.append((name, str(loops), str(proved), str(broken), spread))
    headings = ("statement", "loops", "proved a period", "violated", "first failure, times the period: least / median")
    text = table(headings, rows)
    print(text)
    if options.record:
        record(options.record, "sampled", f"## Sampled statements against adversaries\n\n`{command()}`\n\n{text}")
    return 1 if any(row[3] != "0" for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
