"""The sampled statements against adversaries: never violated, and how many times longer a period would have to be to fail.

    python benchmarks/sampled.py [COUNT] [--record FILE.md]

One or two components, random bounds. Every adversary keeps to the bounds that the statement was told (|f + w|, edge speeds,
width, g) and pushes as hard as they allow: up, down, with the motion, against the middle, at random. A period of `longest` is run
first, where |eps| must stay below E; then longer ones until the state leaves the tube. Deterministic.
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

from stt_codegen.bench.report import command, record, table
from stt_codegen.sampling import Law, Period, Setting, longest
from stt_codegen.sampling.statements import STATEMENTS
from stt_codegen.sampling.windows import Windows

STEPS, PARTS, TRIES = 150, 6, 40  # samples of a run, parts of a period, doublings of it by a quarter
E_MAX = 0.999
Adversary = Callable[[random.Random, float, float], float]  # draw, place e, last motion -> direction

ADVERSARIES: dict[str, Adversary] = {
    "up": lambda draw, e, moved: 1.0,
    "outward": lambda draw, e, moved: 1.0 if e >= 0 else -1.0,
    "with the motion": lambda draw, e, moved: 1.0 if moved >= 0 else -1.0,
    "through the middle": lambda draw, e, moved: -1.0 if e >= 0 else 1.0,
    "at random": lambda draw, e, moved: draw.choice((-1.0, 1.0)),
}


@dataclass(frozen=True)
class Loop:
    """Bounds of one loop: push >= |f + w|, edge speed, g in [least, most], widths, gain, and the turn of a planar g."""

    push: float
    speed: float
    least: float
    most: float
    narrow: float
    wide: float
    gain: float
    turn: float = 0.0  # radians: g = least..most times a rotation by up to so much, in two components

    @property
    def n(self) -> int:
        return 2 if self.turn else 1

    def setting(self, start: float) -> Setting:
        """What the statements read, for a run that begins at eps = start in every component."""
        n, ones = self.n, np.ones((2, self.n))
        speeds = (self.speed * ones, 2 * self.speed * ones)
        start_box = np.array([[-self.narrow / 2, self.narrow / 2]] * n)
        times = np.array([0.0, 1e3])
        windows = Windows(times, self.narrow * ones, self.wide * ones, *speeds, -ones, ones, start_box)
        law = Law(self.gain, E_MAX, np.zeros(n), np.full(n, np.inf), 2.0**-46)
        cosine, sine = math.cos(self.turn), math.sin(self.turn)
        cross = self.most * sine * (np.ones((n, n)) - np.eye(n)) * np.ones((2, 1, 1))
        push = (self.push + self.speed) * ones
        root = math.sqrt(n)
        return Setting(
            windows, law, self.least * cosine * ones, self.most * ones, cross, push, self.narrow * ones,
            np.full(2, self.least * cosine), np.full(2, self.most), np.full(2, self.push + root * self.speed), start * np.ones(n),
        )  # fmt: skip


def run(loop: Loop, period: float, reach: float, start: float, adversary: Adversary, draw: random.Random) -> tuple[float, float]:
    """Largest |eps| (its norm for the general statement is taken by the caller) and largest |e| over a run."""
    n, part = loop.n, period / PARTS
    width = np.array([draw.uniform(loop.narrow, loop.wide) for _ in range(n)])
    low = -width / 2
    x = low + width * (1 + math.tanh(start / 2)) / 2
    moved, worst, norm = np.zeros(n), 0.0, 0.0
    for _ in range(STEPS):
        e = (2 * x - (2 * low + width)) / width
        held = np.clip(e, -E_MAX, E_MAX)
        u = -loop.gain * 4 / (width * (1 - held**2)) * np.log((1 + held) / (1 - held))
        for _ in range(PARTS):
            e = (2 * x - (2 * low + width)) / width
            way = np.array([adversary(draw, float(v), float(m)) for v, m in zip(e, moved, strict=True)])
            # f + w within its norm; g the weaker where u opposes the adversary's way, the stronger where it helps
            size = np.where(u * way < 0, loop.least, loop.most)
            angle = loop.turn * (1 if way[0] * u[-1] < 0 else -1)
            turned = (
                u
                if n == 1
                else np.array([math.cos(angle) * u[0] - math.sin(angle) * u[1], math.sin(angle) * u[0] + math.cos(angle) * u[1]])
            )
            if n == 2:
                size = np.full(2, loop.least if float(turned @ way) < 0 else loop.most)
            rate = loop.push / math.sqrt(n) * way + size * turned
            x, moved = x + rate * part, rate
            low_rate, high_rate = _edge_rates(loop, way, width, part, draw)
            low, width = low + low_rate * part, width + (high_rate - low_rate) * part
            e = (2 * x - (2 * low + width)) / width
            inside = np.abs(e) < 1
            eps = np.where(inside, 2 * np.arctanh(np.where(inside, e, 0)), np.inf)
            worst, norm = max(worst, float(np.abs(eps).max())), max(norm, float(np.sqrt((eps**2).sum())))
            if not inside.all():
                return math.inf, math.inf
    return worst, norm


def _edge_rates(
    loop: Loop, way: npt.NDArray[Any], width: npt.NDArray[Any], part: float, draw: random.Random
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
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
    return Loop(push, speed, least, least * draw.uniform(1.0, 1.5), narrow, wide, gain, draw.uniform(0.05, 0.6) if turn else 0.0)


def violations(loop: Loop, statement: str, period: Period, start: float, seed: int) -> list[str]:
    """Adversaries that drive |eps| to E or beyond at the proved period: there must be none."""
    found = []
    for name, adversary in ADVERSARIES.items():
        worst, norm = run(loop, period.seconds, period.reach, start, adversary, random.Random(seed))
        if not (norm if statement == "general" else worst) < period.reach:
            found.append(name)
    return found


def factor(loop: Loop, period: Period, start: float, seed: int) -> float:
    """How many times the proved period some adversary needs to drive the state out; infinite when none does."""
    times = 1.0
    for _ in range(TRIES):
        for adversary in ADVERSARIES.values():
            if math.isinf(run(loop, period.seconds * times, period.reach, start, adversary, random.Random(seed))[0]):
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
    for statement in STATEMENTS:
        for turn in (False, True) if statement != "diagonal" else (False,):
            loops, proved, broken, factors = 0, 0, 0, []
            for seed in range(options.count):
                loop = drawn(draw, turn)
                start = draw.uniform(0.0, 1.0)
                loops += 1
                period = longest(statement, loop.setting(start))
                if period is None:
                    continue
                proved += 1
                broken += bool(violations(loop, statement, period, start, seed))
                if seed % 4 == 0:
                    factors.append(factor(loop, period, start, seed))
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
