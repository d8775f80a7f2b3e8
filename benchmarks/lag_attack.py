"""Test the worst path against adversaries: no proved bound may be violated, and longer delays must fail at some time.

    python -m benchmarks lag_attack [--runs N] [--seed S] [--stretch] [--omit PART] [--record FILE.md]

N runs at the proved value are shared among families of loops: order 1 and 2, one component or two coupled ones, with a lag, two
lags, a limited rate, a drive that rings, or no drive, and with latency. Every loop has random bounds, and the slowest drive (or
the longest period, without a drive) that the worst path proves for it. Seven adversaries respect the bounds and push as hard as
these allow. The drive is the worst of its class at every moment: the weight of every age is put on the worst command that is
not older, or the drive is quick where that helps the adversary. At the proved value |eps| must stay below E and |u| at most U.
With --stretch delays then grow until a run leaves. --omit leaves a part of the statement out, for which the attack must find a
loop that leaves: start (commands before 0 are 0), age (of samples), input (U is halved), or first (the first input is late, too).
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.report import command, record, table
from stt_codegen.sampling.path.drive_response import Drive
from stt_codegen.sampling.path.path_proof import prove_path
from stt_codegen.sampling.path.path_search import largest_proved
from stt_codegen.sampling.path.path_windows import ComponentLaw, PathLoop, WindowBounds
from stt_codegen.sampling.path.worst_path import Start, follow_worst_path

Array = npt.NDArray[Any]
E_MAX = 0.99
ROUNDING = Fraction(1, 1 << 40)  # of the law, which is computed in doubles
ADVERSARIES = ("up", "outward", "with the motion", "through the middle", "at random", "to and fro", "back once")
JITTERS = ("late", "random")  # every sample is used as long as allowed, or for a random time
REPETITIONS = 2
PARTS_PER_DELAY = 12  # steps of a simulation in the shorter one of the delays
STEPS_PER_DELAYS = 120  # and at most so many in both together
REMEMBERED_STEPS = 400  # commands that a drive remembers at most; older ones count as the oldest of these
REMEMBERED_LAGS = 7  # and for so many time constants
RINGING_DEAD_TIME = 0.3  # of a drive that rings, times its lag
LARGEST_PHASE_STEP = 0.1  # radians in a step of a drive that rings
STEP_LIMIT = 1200  # of a run
FACTORS = (1.03, 1.06, 1.1, 1.15, 1.2, 1.3, 1.4, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 6.0)
PARTS = ("start", "age", "input", "first")
NO_DRIVE = Drive()


@dataclass(frozen=True)
class Family:
    """Loops of one kind. drive: "lag", "two lags", "slew", "ringing" or "none". is_quick: the drive is a lag whose time constant
    is small where that helps the adversary, instead of the worst weights. is_late: whether the loops have latency."""

    order: int
    dimension: int
    drive: str
    is_quick: bool = False
    is_late: bool = False

    @property
    def label(self) -> str:
        words = [f"order {self.order}", f"n = {self.dimension}", self.drive]
        return ", ".join([*words, *(["quick where it hurts"] if self.is_quick else []), *(["latency"] if self.is_late else [])])


FAMILIES = (
    Family(1, 1, "lag"),
    Family(1, 1, "lag", is_quick=True),
    Family(1, 1, "lag", is_late=True),
    Family(2, 1, "lag"),
    Family(1, 2, "lag"),
    Family(2, 2, "lag"),
    Family(1, 1, "two lags"),
    Family(2, 1, "two lags"),
    Family(1, 1, "slew"),
    Family(1, 1, "ringing"),
    Family(1, 1, "none"),
    Family(2, 1, "none", is_late=True),
)


@dataclass(frozen=True, kw_only=True)
class AttackedLoop:
    """The bounds of one loop, the same for every component, and its delays.

    push: of |f + w|, an acceleration for order 2. narrow, wide: of the tube, of v + lambda x for order 2, where position_width is
    that of x. cross: |g_ij|. share: of the starts. period, latency: seconds. damping: of a drive that rings.
    """

    family: Family
    g_min: float
    g_max: float
    cross: float
    push: float
    edge_speed: float
    narrow: float
    wide: float
    filter_rate: float
    position_width: float
    gain: float
    u_max: float
    noise: float
    share: float
    period: float
    latency: float
    damping: float
    drive: Drive = NO_DRIVE

    @property
    def closing_speed(self) -> float:
        """P without the other inputs: for order 2 both edges of x stand still."""
        return self.push + (self.edge_speed if self.family.order == 1 else self.filter_rate**2 * self.position_width)

    def with_delay(self, seconds: Fraction) -> AttackedLoop:
        """Return the loop with a drive, or without one a period, of this delay. A slew passes from -u_max to u_max in it."""
        kind, overshoot = self.family.drive, math.exp(-math.pi * self.damping / math.sqrt(1 - self.damping**2))
        if kind == "none":
            return replace(self, period=float(seconds))
        drive = {
            "lag": Drive((seconds,)),
            "two lags": Drive((seconds, seconds)),
            "slew": Drive(slew=2 * Fraction(self.u_max) / seconds),
            "ringing": Drive((seconds,), overshoot=Fraction(overshoot)),
        }[kind]
        latency = RINGING_DEAD_TIME * float(seconds) if kind == "ringing" else self.latency
        return replace(self, drive=drive, latency=latency)

    def to_path_loop(self) -> PathLoop:
        """Return the loop as the worst path reads it: one window."""
        n, exact = self.family.dimension, Fraction
        cross = tuple(exact(self.cross) * (j != 0) for j in range(n))
        ratio = (1 + exact(self.share)) / (1 - exact(self.share))
        window = WindowBounds(
            closing_speed=exact(self.closing_speed), cross=cross, g_min=exact(self.g_min), g_max=exact(self.g_max),
            narrow=exact(self.narrow), wide=exact(self.wide),
        )  # fmt: skip
        windows = tuple((replace(window, cross=tuple(exact(self.cross) * (i != j) for j in range(n))),) for i in range(n))
        law = ComponentLaw(
            gain=exact(self.gain), e_max=exact(E_MAX), shift=exact(self.noise) + exact(1, 10**9), u_max=exact(self.u_max),
            rounding=ROUNDING, filter_rate=exact(self.filter_rate), rho_at_start=ratio,
        )  # fmt: skip
        return PathLoop(
            begins=(exact(0),), windows=windows, laws=(law,) * n, drives=(self.drive,) * n,
            age=exact(self.period) + exact(self.latency), latency=exact(self.latency), largest_known_age=math.inf,
        )  # fmt: skip


@dataclass(frozen=True)
class ProvedLoop:
    """A loop at the largest delay that is proved for it: E bounds |eps|, u bounds |u|."""

    loop: AttackedLoop
    eps_bound: float
    u: float


def draw_loop(family: Family, rng: np.random.Generator) -> AttackedLoop:
    """Draw the bounds of a loop; the period is a share of the time in which x crosses the tube."""
    g_min, push, share = rng.uniform(0.5, 1.2), rng.uniform(0.02, 1.0), rng.choice([0.9, 0.8, rng.uniform(0.05, 0.9)])
    narrow = wide = rng.uniform(0.2, 1.0)
    edge_speed = filter_rate = 0.0
    closing_speed, position_width = push, narrow
    if family.order == 1:
        wide = narrow * rng.choice([1.0, 1.0, rng.uniform(1, 1.6)])
        edge_speed = rng.choice([0.0, rng.uniform(0, 1.5)])
        closing_speed += edge_speed
    else:
        filter_rate = rng.uniform(0.5, 3.0)
        closing_speed += filter_rate**2 * position_width
        narrow = wide = position_width * filter_rate
    cross = rng.choice([0.0, rng.uniform(0, 0.15)]) * g_min * (family.dimension - 1)
    needed_input = closing_speed / g_min * (1 + 3 * cross / g_min)
    period = narrow / closing_speed * rng.choice([0.002, 0.01, 0.03, 0.1]) * rng.uniform(0.5, 1.5)
    return AttackedLoop(
        family=family, g_min=g_min, g_max=g_min * rng.uniform(1, 1.4), cross=cross, push=push, edge_speed=edge_speed,
        narrow=narrow, wide=wide, filter_rate=filter_rate, position_width=position_width,
        gain=rng.choice([1.0, 0.3, 0.1, rng.uniform(0.02, 2)]) * closing_speed / g_min * narrow / 2,
        u_max=needed_input * rng.choice([1.2, rng.uniform(1.1, 3.0), rng.uniform(1.5, 6.0)]),
        noise=narrow * rng.choice([0.0, rng.uniform(0, 0.01)]), share=share, period=period,
        latency=period * rng.uniform(0.2, 1.0) if family.is_late else 0.0, damping=rng.uniform(0.6, 0.95),
    )  # fmt: skip


# ---------------------------------------------------------------------------------------- what is proved


def prove(loop: AttackedLoop, omitted: str = "") -> ProvedLoop | None:
    """Prove a loop by the worst path, or by the statement without one of its PARTS, which is wrong."""
    path_loop = loop.to_path_loop()
    if not omitted:
        proof = prove_path(path_loop)
        return None if proof is None else ProvedLoop(loop, max(math.log(v) for v in proof.rho), float(max(proof.u)))
    law, window = path_loop.laws[0], path_loop.windows[0][0]
    u = law.input_bound(window.narrow, (1 + law.e_max) / (1 - law.e_max))
    assert u is not None
    halved = u / 2 if omitted == "input" else u
    bounds = path_loop.bounds_over(0, 0, 0, [halved] * path_loop.n)
    start: Start | None = path_loop.start(0)
    if omitted == "age":
        bounds = replace(bounds, age=Fraction(0))
    elif omitted == "first":
        start = Start(path_loop.start(0).nearest, Fraction(0))
    elif omitted == "start":
        start = None
    rho = follow_worst_path(bounds, start).rho(bounds.wide)
    smallest = float(law.rho_at_start)
    return None if rho is None or rho <= 1 else ProvedLoop(loop, math.log(max(float(rho), smallest)) * (1 + 1e-9), float(u))


def with_largest_delay(loop: AttackedLoop, omitted: str) -> ProvedLoop | None:
    """Return the loop with the largest proved delay; None where none is proved, or where no delay is too long."""
    crossing = Fraction(loop.narrow / loop.closing_speed)
    delay = largest_proved(lambda seconds: prove(loop.with_delay(seconds), omitted) is not None, crossing / 16)
    return None if delay is None or delay > 4 * crossing else prove(loop.with_delay(delay), omitted)


# ---------------------------------------------------------------------------------------- simulation


def direction_of(value: Array) -> Array:
    return np.where(value >= 0, 1.0, -1.0)


class Adversary:
    """Chooses a direction by run and component at every step, (B, n). kinds: of ADVERSARIES, by run."""

    def __init__(self, kinds: Sequence[str], shape: tuple[int, int], rng: np.random.Generator) -> None:
        self.rng, self.shape = rng, shape
        self.masks = {kind: np.array([[v == kind] for v in kinds]) for kind in ADVERSARIES}
        self.last = np.where(self.masks["back once"], -1.0, np.ones(shape))
        self.level = rng.uniform(0, 0.98, shape)

    def direction(self, e: Array, rate: Array) -> Array:
        """Return where to push; e: normalized errors, rate: of x relative to the tube."""
        is_high, is_low = e > self.level, e < -self.level
        turned = np.where(self.masks["at random"] & (self.rng.random(self.shape) < 0.05), -self.last, self.last)
        turned = np.where(self.masks["to and fro"] & is_high, -1.0, turned)
        self.last = np.where((self.masks["to and fro"] | self.masks["back once"]) & is_low, 1.0, turned)
        outward = direction_of(e)
        by_kind = {"outward": outward, "with the motion": direction_of(rate), "through the middle": -outward}
        return np.select([self.masks[kind] for kind in by_kind], list(by_kind.values()), self.last)  # "up" stays at 1


class WorstDrive:
    """The drives of B loops, as bad as their class allows for a direction, in steps of `dt`, (B, 1)."""

    def __init__(self, loops: Sequence[AttackedLoop], factor: float, dt: Array) -> None:
        self.family, self.dt, self.loops = loops[0].family, dt, loops
        shape = (len(loops), self.family.dimension)
        drives = [loop.drive.scaled(Fraction(factor)) for loop in loops]
        self.lag = np.array([[float(d.lags[0]) if d.lags else 1.0] for d in drives])
        self.slew = np.array([[float(d.slew) if d.slew else math.inf] for d in drives])
        remembered_steps = int(min(REMEMBERED_STEPS, math.ceil(REMEMBERED_LAGS * float((self.lag / dt).max()))))
        self.commands = np.zeros((*shape, remembered_steps))  # the newest first
        self.stages = [np.zeros(shape), np.zeros(shape)]
        ages = dt * np.arange(remembered_steps + 1) / self.lag
        tail = np.exp(-ages) * (1 + ages if self.family.drive == "two lags" else 1)
        tail[:, 0], tail[:, -1] = 1.0, 0.0
        self.weights = tail[:, None, :-1] - tail[:, None, 1:]
        self.damping = np.array([[loop.damping] for loop in loops])
        self.frequency = self._frequencies([factor * loop.latency for loop in loops]) if self.family.drive == "ringing" else None

    def _frequencies(self, dead_times: Sequence[float]) -> Array:
        """Return the natural frequency of a ringing drive, by loop: the least at which its positive part is early enough.

        An oscillator moves with no delay but slowly at first. So its weights are compared with a lag behind a dead time, which is
        the latency of the loop.
        """
        values = []
        for loop, lag, dead_time in zip(self.loops, self.lag[:, 0], dead_times, strict=True):
            ages = np.linspace(0, 30, 30001)
            damped = math.sqrt(1 - loop.damping**2)
            positive = np.maximum(np.exp(-loop.damping * ages) * np.sin(damped * ages), 0)
            mass = np.concatenate([[0], np.cumsum((positive[1:] + positive[:-1]) / 2)])
            tail = 1 - mass / mass[-1]
            usable = tail[1:] > 1e-6
            values.append(float(np.max(ages[1:][usable] / (dead_time - lag * np.log(np.minimum(tail[1:][usable], 1.0))))))
        return np.array(values)[:, None]

    def acting(self, u: Array, direction: Array) -> Array:
        """Return what acts in the next step of the commands so far and `u`."""
        kind = self.family.drive
        if kind == "none":
            return u
        if kind == "slew":
            change = np.clip(u - self.stages[0], -self.slew * self.dt, self.slew * self.dt)
            is_helpful = (u - self.stages[0]) * direction > 0  # to the adversary: at once
            self.stages[0] = np.where(is_helpful, u, self.stages[0] + change)
            return self.stages[0]
        if kind == "ringing":
            return self._ring(u)
        if self.family.is_quick:
            lag = np.where((u - self.stages[0]) * direction > 0, 0.05 * self.lag, self.lag)
            self.stages[0] = u + (self.stages[0] - u) * np.exp(-self.dt / lag)
            return self.stages[0]
        self.commands = np.concatenate([u[..., None], self.commands[..., :-1]], axis=-1)
        worst = np.maximum.accumulate(direction[..., None] * self.commands, axis=-1)
        return direction * (worst * self.weights).sum(axis=-1)

    def _ring(self, u: Array) -> Array:
        """Return the position of a damped oscillator that follows u."""
        assert self.frequency is not None
        parts = math.ceil(float((self.frequency * self.dt).max()) / LARGEST_PHASE_STEP)
        position, speed = self.stages
        for _ in range(parts):
            force = self.frequency**2 * (u - position) - 2 * self.damping * self.frequency * speed
            speed = speed + self.dt / parts * force
            position = position + self.dt / parts * speed
        self.stages = [position, speed]
        return position


@dataclass(frozen=True)
class RunResult:
    """The largest |eps| (infinite once outside) and |u| of B runs, (B,), and which left the tube."""

    eps: Array
    u: Array
    has_left: Array


class Simulation:
    """B runs at once, one of each loop, whose delays are `factor` times their own."""

    def __init__(self, loops: Sequence[AttackedLoop], factor: float, rng: np.random.Generator) -> None:
        self.loops, self.rng, self.factor, self.family = loops, rng, factor, loops[0].family
        self.shape = (len(loops), self.family.dimension)
        self.columns: dict[str, Array] = {}
        # the latency of a drive that rings is its own: commands reach it at once
        self.latency = factor * self.column("latency") * (self.family.drive != "ringing")
        self.age = factor * self.column("period") + self.latency
        drive = np.array([[float(loop.drive.delay(Fraction(loop.u_max)))] for loop in loops]) * factor
        shorter = np.where(drive > 0, np.minimum(self.age, drive), self.age)
        self.dt = np.maximum(shorter / PARTS_PER_DELAY, (self.age + drive) / STEPS_PER_DELAYS)
        crossing = self.column("narrow") / np.array([[loop.closing_speed] for loop in loops])
        self.steps = int(min(STEP_LIMIT, 8 * np.median((self.age + drive + 2 * crossing) / self.dt)))

    def column(self, name: str) -> Array:
        """Return a field of the loops, (B, 1)."""
        if name not in self.columns:
            self.columns[name] = np.array([[getattr(loop, name)] for loop in self.loops])
        return self.columns[name]

    def law(self, a: Array, b: Array) -> Array:
        """Return the input for the measured distances to the edges."""
        width, clamp = a + b, (1 - E_MAX) / 2
        near = np.where(width > 0, np.maximum(np.minimum(a, b), width * clamp), 1.0)
        far = np.where(width > 0, width - near, 2.0)
        u = np.where(b < a, -1, 1) * self.column("gain") * (1 / near + 1 / far) * np.log(far / near)
        return np.clip(u, -self.column("u_max"), self.column("u_max"))

    def run(self, kinds: Sequence[str], jitters: Sequence[str]) -> RunResult:
        """Drive every loop from a corner of its starts or from inside, against its adversary and with its ages of samples."""
        rng, adversary = self.rng, Adversary(kinds, self.shape, self.rng)
        shortest = np.array([[1.0 if jitter == "late" else 0.1] for jitter in jitters])
        e = self.column("share") * direction_of(rng.random(self.shape) - 0.5)
        state = TubeState(self, e * np.where(rng.random(self.shape) < 0.7, 1, rng.random(self.shape)))
        drive = WorstDrive(self.loops, self.factor, self.dt)
        delay_steps = np.floor(self.latency / self.dt + 1e-9).astype(int)
        measured = np.zeros((int(delay_steps.max()) + 1, *self.shape))  # inputs of the last samples, the newest first
        age = np.full((len(self.loops), 1), math.inf)
        allowed, u = np.zeros_like(age), np.zeros(self.shape)
        eps, largest_u, is_inside = np.zeros(len(self.loops)), np.zeros(len(self.loops)), np.ones(len(self.loops), bool)
        for step in range(self.steps):
            direction = adversary.direction(state.e, state.rate)
            lie = direction * self.column("noise")
            measured = np.concatenate([self.law(state.a - lie, state.b + lie)[None], measured[:-1]])
            is_due = (age + self.dt > allowed + 1e-12) & (step >= delay_steps)
            delayed = np.take_along_axis(measured, np.broadcast_to(delay_steps, self.shape)[None], axis=0)[0]
            u = np.where(is_due, delayed, u)
            age = np.where(is_due, delay_steps * self.dt, age) + self.dt
            longest = self.age * rng.uniform(shortest, 1.0)
            allowed = np.where(is_due, np.maximum(longest, age), allowed)
            acting = np.where((step + 1) * self.dt <= self.latency, 0.0, u)
            state.move(drive.acting(acting, direction), direction)
            is_inside &= state.is_inside
            eps = np.where(is_inside, np.maximum(eps, state.eps), math.inf)
            largest_u = np.where(is_inside, np.maximum(largest_u, np.abs(u).max(axis=1)), largest_u)
            state.freeze(~is_inside)
        return RunResult(eps, largest_u, ~is_inside)


class TubeState:
    """The states of B runs: distances to the edges, and for order 2 x and v in a tube that stands still."""

    def __init__(self, simulation: Simulation, e: Array) -> None:
        self.simulation, self.rate = simulation, np.zeros(simulation.shape)
        column, rng = simulation.column, simulation.rng
        if simulation.family.order == 2:
            self.x, self.v = (1 + e) / 2 * column("position_width"), np.zeros(simulation.shape)
            self._filter()
        else:
            width = column("narrow") + rng.random(simulation.shape) * (column("wide") - column("narrow"))
            self.a = width * (1 + e) / 2
            self.b = width - self.a

    def _filter(self) -> None:
        rate, width = self.simulation.column("filter_rate"), self.simulation.column("position_width")
        self.a, self.b = self.v + rate * self.x, -self.v + rate * (width - self.x)

    @property
    def e(self) -> Array:
        """The normalized errors."""
        return (self.a - self.b) / (self.a + self.b)

    @property
    def is_inside(self) -> Array:
        """Whether each run is in its tube, (B,)."""
        inside = ((self.a > 0) & (self.b > 0)).all(axis=1)
        if self.simulation.family.order == 2:
            inside &= ((self.x > 0) & (self.x < self.simulation.column("position_width"))).all(axis=1)
        return inside

    @property
    def eps(self) -> Array:
        """The largest |eps| of each run, (B,)."""
        a, b = (np.maximum(distance, 1e-9) for distance in (self.a, self.b))
        return np.asarray(np.abs(np.log(a / b)).max(axis=1))

    def move(self, acting: Array, direction: Array) -> None:
        """Pass one step in which `acting` acts and everything pushes into `direction` as hard as it may."""
        column, dt = self.simulation.column, self.simulation.dt
        g = np.where(acting * direction < 0, column("g_min"), column("g_max"))
        coupled = np.abs(acting.sum(axis=1, keepdims=True) - acting)
        force = direction * (column("push") + column("cross") * coupled) + g * acting
        if self.simulation.family.order == 2:
            self.x, self.v, self.rate = self.x + self.v * dt + force * dt**2 / 2, self.v + force * dt, force
            self._filter()
            return
        approaching = -column("edge_speed") * direction
        opposite = approaching * direction_of(self.simulation.rng.random(self.simulation.shape) - 0.5)
        low, high = np.where(direction > 0, opposite, approaching), np.where(direction > 0, approaching, opposite)
        width = self.a + self.b + (high - low) * dt
        is_allowed = (width >= column("narrow")) & (width <= column("wide"))
        low, high = np.where(is_allowed, low, approaching), np.where(is_allowed, high, approaching)
        self.a, self.b, self.rate = self.a + (force - low) * dt, self.b + (high - force) * dt, force

    def freeze(self, has_left: Array) -> None:
        """Put runs that have left into the middle, where they no longer count."""
        self.a[has_left] = self.b[has_left] = 0.5
        if self.simulation.family.order == 2:
            self.x[has_left], self.v[has_left] = self.simulation.column("position_width")[has_left] / 2, 0.0


# ---------------------------------------------------------------------------------------- results


@dataclass(frozen=True)
class AttackResult:
    """The result for one family. closest: the largest |eps|/E at the proved value. factors: by loop, of the first failure."""

    family: Family
    loops: int
    runs: int
    violations: int
    broken_loops: int
    closest: float
    factors: tuple[float, ...]

    def row(self) -> list[str]:
        """Return the row of the table."""
        sorted_factors = sorted(self.factors)
        quantiles = [sorted_factors[len(sorted_factors) * k // 20] for k in (0, 2, 10)] if self.factors else []
        numbers = [str(v) for v in (self.loops, self.runs, self.violations, self.broken_loops)]
        first_failures = " / ".join("none" if math.isinf(v) else f"{v:g}" for v in quantiles) or "-"
        return [self.family.label, *numbers, f"{self.closest:.2f}", first_failures]


def attack(family: Family, count: int, seed: int, *, stretches: bool = False, omitted: str = "") -> AttackResult:
    """Attack `count` loops of a family at the largest delay that is proved, with every adversary and jitter."""
    rng = np.random.default_rng([seed, FAMILIES.index(family)])
    proved: list[ProvedLoop] = []
    for _ in range(20 * count):
        candidate = with_largest_delay(draw_loop(family, rng), omitted)
        proved += [] if candidate is None else [candidate]
        if len(proved) == count:
            break
    loops = [p.loop for p in proved]
    eps_bound, u_bound = (np.array([getattr(p, name) for p in proved]) for name in ("eps_bound", "u"))
    violations, closest, broken = 0, 0.0, np.zeros(len(loops), bool)
    runs = [(kind, jitter) for kind in ADVERSARIES for jitter in JITTERS]
    violations, closest, broken = 0, 0.0, np.zeros(len(loops), bool)
    if loops:
        result = _run_all(loops, 1.0, runs * REPETITIONS, rng)
        is_violated = (result.eps >= eps_bound) | (result.u > u_bound)
        violations, broken = int(is_violated.sum()), np.asarray(is_violated.any(axis=0))
        closest = float((result.eps / eps_bound).max())
    first = np.full(len(loops), math.inf)
    for factor in FACTORS if stretches else ():
        indices = np.flatnonzero(np.isinf(first))
        if len(indices):
            left = _run_all([loops[i] for i in indices], factor, runs, rng).has_left.any(axis=0)
            first[indices[left]] = factor
    factors = tuple(first.tolist()) if stretches else ()
    run_count = len(loops) * len(runs) * REPETITIONS
    return AttackResult(family, len(loops), run_count, violations, int(broken.sum()), closest, factors)


def _run_all(
    loops: Sequence[AttackedLoop], factor: float, runs: Sequence[tuple[str, str]], rng: np.random.Generator
) -> RunResult:
    """Run every loop against every pair of an adversary and a jitter, all at once; the arrays of the result are (runs, loops)."""
    kinds, jitters = ([run[part] for run in runs for _ in loops] for part in (0, 1))
    result = Simulation([*loops] * len(runs), factor, rng).run(kinds, jitters)
    eps, u, has_left = (part.reshape(len(runs), len(loops)) for part in (result.eps, result.u, result.has_left))
    return RunResult(eps, u, has_left)


def main() -> int:
    """Attack the loops of every family, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stretch", action="store_true", help="find the first failure of every loop")
    parser.add_argument("--omit", choices=PARTS, default="", help="attack a wrong statement; exit code 1 where no loop leaves")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    runs_per_loop = len(ADVERSARIES) * len(JITTERS) * REPETITIONS
    families = [f for f in FAMILIES if not options.omit or (f.drive == "lag" and f.order == f.dimension == 1)]
    count = max(1, math.ceil(options.runs / len(families) / runs_per_loop))
    rows = []
    for family in families:
        result = attack(family, count, options.seed, stretches=options.stretch, omitted=options.omit)
        rows.append(result.row())
        print(", ".join(rows[-1]), flush=True)
    headings = ("loops", "number", "runs", "violated", "loops broken", "largest |eps|/E", "first failure: least / tenth / median")
    text = table(headings, rows)
    print(text)
    if options.record:
        record(options.record, "lag-attack", f"## The worst path against adversaries\n\n`{command()}`\n\n{text}")
    is_violated = any(row[3] != "0" for row in rows)
    return int(not is_violated if options.omit else is_violated)


if __name__ == "__main__":
    sys.exit(main())
