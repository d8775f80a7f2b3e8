"""A closed loop run: the emitted C, held between samples, drives a plant under a disturbance; every state on the way is judged.

Between samples a classical Runge-Kutta method integrates the plant, u being held: steps of at most STEP seconds and a quarter of
the period, halved until the error of a step is below 1e-13. Runs are the same on every machine of one libm: random numbers come
from the seed in templates/loop/loop.c.

Long because a scenario, what C is given of a task, and what came of it belong together.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.arrays import as_floats
from stt_codegen.certify.missions import cycle_of
from stt_codegen.errors import BadInput
from stt_codegen.loop.compiled import Judged, Own, Setting, driver, is_constant, own
from stt_codegen.loop.mission import missed
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.task import Task
from stt_codegen.task.sets import SOLID, ConvexSet, Course, HalfSpace

Array = npt.NDArray[Any]
KINDS = ("none", "constant", "sinusoidal", "random", "nearest", "outward")
CLOCKS = ("stated", "early", "late", "worst")  # what the sets' clock shows, within timing and start_delay
STEP = 0.001  # seconds, of the integrator at most
PARTS = 4  # of a period, at least
MOST_SAMPLES = 10_000_000  # of a run
TICK_ROUNDING = 1e-6  # of a tick: what a rate in decimals may be off by
MOST_FACES = 1024  # of an unsafe set, as in loop.h
WAITS = 8  # of a tube that waits, after which a run is not made longer
CYCLES = 2  # more than the first, of a tube that repeats itself
WAITING = 100  # inputs on their way, less than in loop.h


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What a loop runs under. rate: samples a second; strength: bound on |w|; noise, noise_v: bounds on the error of every
    measured component of x and v; lost: samples that may be lost in a row; start: x(0), of order 2 with v(0) behind it or at
    rest, the task's own where None; latency: seconds from a sample to its input;
    lag: seconds, what acts follows u by a first-order lag. shares: of w by component, where its bounds differ: then `strength` is
    the largest of them, and every |w_i| is within its own. clock: of sets that move,
    stated (their times are right, and the controller starts in time), early (they are as far behind as may be), late (as far
    ahead, with the controller's start_delay), or worst (at every moment and for every set the worst of nine readings from early
    to late)."""

    rate: float = 1000.0
    disturbance: str = "none"
    strength: float = 0.0
    seed: int = 0
    noise: float = 0.0
    lost: int = 0
    start: tuple[float, ...] | None = None
    latency: float = 0.0
    clock: str = "stated"
    noise_v: float = 0.0
    lag: float = 0.0
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.disturbance not in KINDS:
            raise BadInput(f"--disturbance {self.disturbance}: is none of {', '.join(KINDS)}")
        if self.clock not in CLOCKS:
            raise BadInput(f"--clock {self.clock}: is none of {', '.join(CLOCKS)}")
        for name, value in self._numbers():
            if as_floats(name, value, finite=False).ndim:
                raise BadInput(f"{name}: is an array; one number is needed")
            if not (math.isfinite(value) and value >= 0) or (name == "--rate" and value == 0):
                raise BadInput(f"{name} {value:g}: a finite number {'above 0' if name == '--rate' else 'of 0 or more'} is needed")
        for name, count in (("--lost", self.lost), ("--seed", self.seed)):
            if isinstance(count, bool) or not isinstance(count, int | np.integer):
                raise BadInput(f"{name}: is {count!r:.40}; a whole number is needed")
        if not 0 <= self.lost <= MOST_SAMPLES:
            raise BadInput(f"--lost {self.lost}: use 0 to {MOST_SAMPLES}")
        if self.latency * self.rate > WAITING:
            raise BadInput(
                f"--latency {self.latency:g}: is {self.latency * self.rate:g} periods; at most {WAITING} are simulated"
            )

    def _numbers(self) -> tuple[tuple[str, float], ...]:
        return (
            ("--rate", self.rate),
            ("--w-max", self.strength),
            ("--noise", self.noise),
            ("--latency", self.latency),
            ("--lag", self.lag),
            ("noise_v", self.noise_v),
        )

    @property
    def age(self) -> float:
        """The greatest age of a sample whose input still acts, seconds."""
        return (self.lost + 1) / self.rate + self.latency


@dataclass(frozen=True, kw_only=True)
class Run:
    """What came of it. hit: the unsafe set that was entered first; times are None where it did not happen; outside: samples at
    which the controller said OUTSIDE_TUBE; margin: least distance to an edge over the width, all along; e, u: largest |e_i|,
    |u_i|; waited: seconds the tube did (control.outside = "hold"), by which the run is longer; missed: entries of the mission,
    from 1, that were not carried out. trace: rows of t, x, u, lower, upper, w, status at every sample and at the end, where asked
    for."""

    hit: str | None
    hit_at: float | None
    left_at: float | None
    outside: int
    outside_at: float | None
    reached: bool
    margin: float
    e: tuple[float, ...]
    u: tuple[float, ...]
    last: tuple[float, ...]
    waited: float = 0.0
    missed: tuple[int, ...] = ()
    trace: Array | None = field(default=None, compare=False, repr=False)

    @property
    def good(self) -> bool:
        """The task is fulfilled: no unsafe set entered, never outside the state space, in the target at the end, the mission
        carried out."""
        return self.hit is None and self.left_at is None and self.reached and not self.missed

    @property
    def kept(self) -> bool:
        """Whether the state was inside its tube all along."""
        return self.margin > 0


class Loop:
    """A controller and a plant, compiled: run it under as many scenarios as you like."""

    def __init__(self, controller: EmittedController, plant: Model, step: Own | None = None) -> None:
        self.controller, self.plant = controller, plant
        self.run_loop = driver(plant, controller.task.dimension, controller.task.order)
        self.own = step or own(controller)
        self.field = _Field(controller.task)
        self.constant = is_constant(plant, controller.task.dimension, controller.task.order)
        self.cycle = cycle_of(controller.design)
        self.filter = np.array([float(v) for v in controller.design.filter])

    def run(self, scenario: Scenario, trace: bool = False) -> Run:
        task = self.controller.task
        try:
            start = as_floats("--start", task.initial_state if scenario.start is None else scenario.start, texts=True)
        except BadInput as refusal:
            raise BadInput(f"{str(refusal).rpartition(';')[0]}; {task.dimension} numbers are needed") from None
        if start.ndim != 1:
            raise BadInput(f"--start: has shape {start.shape}; {task.dimension} numbers are needed")
        most = task.order * task.dimension
        if start.size not in (task.dimension, most):
            told = "" if task.order == 1 else f", or {most} with the speeds"
            raise BadInput(f"--start: has {start.size} numbers, {task.dimension} are needed{told}")
        start = np.concatenate(
            [start, np.zeros(most - start.size)]
        )  # doubles, whatever numbers they were: C reads them by address
        constants = _constants(self.plant, scenario.seed)
        t_c = float(task.prescribed_time)
        if self.cycle is not None:
            t_c += CYCLES * float(self.cycle.length)
        end, run = t_c, self._until(t_c, scenario, start, constants, trace)
        for _ in range(WAITS):  # a tube that waits is late by as much
            if t_c + run.waited <= end:
                break
            end = t_c + run.waited
            run = self._until(end, scenario, start, constants, trace)
        return run

    def _until(self, end: float, scenario: Scenario, start: Array, constants: Array, trace: bool) -> Run:
        """The run to that time, seconds."""
        shares = np.array(scenario.shares or (1.0,) * self.controller.task.dimension)
        task, field_ = self.controller.task, self.field
        period = 1 / scenario.rate
        tick = self.controller.program.tick
        if tick is not None and abs(period / float(tick) - max(1, round(period / float(tick)))) > TICK_ROUNDING:
            told = f"samples come every {period:g} s, and time is counted in ticks of {float(tick):g} s"
            raise BadInput(f"--rate {scenario.rate:g}: {told}; use {1 / float(tick):.9g} divided by a whole number")
        samples = max(1, math.ceil(end / period - 1e-9))
        if samples > MOST_SAMPLES:
            raise BadInput(f"--rate {scenario.rate:g}: makes {samples} samples in {end:g} s; at most {MOST_SAMPLES}")
        setting = Setting(
            n=task.dimension,
            sets=len(field_.names),
            order=task.order,
            samples=samples,
            parts=self._parts(period),
            kind=KINDS.index(scenario.disturbance),
            lost=scenario.lost,
            constant=self.constant and not scenario.lag,
            seed=scenario.seed,
            period=period,
            end=end,
            strength=scenario.strength,
            noise=scenario.noise,
            noise_v=scenario.noise_v,
            filter=self.filter.ctypes.data,
            constants=constants.ctypes.data,
            shares=shares.ctypes.data,
            lag=scenario.lag,
            latency=scenario.latency,
            start=start.ctypes.data,
            walls=len(field_.space),
            goals=len(field_.target),
            space=field_.space.ctypes.data,
            target=field_.target.ctypes.data,
            first=field_.first.ctypes.data,
            faces=field_.faces.ctypes.data,
            radius=field_.radius.ctypes.data,
            ends=field_.ends.ctypes.data,
            clock=CLOCKS.index(scenario.clock),
            turn=field_.turn.ctypes.data,
            turns=field_.turns.ctypes.data,
            hours=field_.hours.ctypes.data,
        )
        wanted = trace or bool(task.mission)
        rows = np.empty((samples + 1, (4 + task.order) * task.dimension + 2)) if wanted else None
        judged = Judged()
        self.own.start()
        pointers = [
            None if f is None else ctypes.cast(f, ctypes.c_void_p) for f in (self.own.step, self.own.tube, self.own.advance)
        ]
        self.run_loop(ctypes.byref(setting), *pointers, ctypes.byref(judged), None if rows is None else rows.ctypes.data)
        return self._judged(judged, rows)

    def _parts(self, period: float) -> int:
        """Steps of the integrator in a period; of an adaptive tube no shorter than its certificate allows."""
        parts = max(PARTS, math.ceil(period / STEP))
        steps = self.controller.certificate.steps
        return parts if steps is None else max(1, min(parts, math.floor(period / float(steps[0]))))

    def _judged(self, r: Judged, rows: Array | None) -> Run:
        task = self.controller.task
        n = task.dimension

        def at(value: float) -> float | None:
            return None if value < 0 else float(value)

        return Run(
            hit=None if r.hit < 0 else self.field.names[r.hit],
            hit_at=at(r.hit_at),
            left_at=at(r.left_at),
            outside=r.outside,
            outside_at=at(r.outside_at),
            reached=bool(r.reached),
            margin=r.margin,
            e=tuple(r.e[:n]),
            u=tuple(r.u[:n]),
            last=tuple(r.last[:n]),
            waited=self.own.lag(),
            missed=() if rows is None or not task.mission else missed(task, rows[:, 0], rows[:, 1 : 1 + n], self.cycle),
            trace=rows,
        )


def _constants(plant: Model, seed: int) -> Array:
    """Of this run: by turns at an end of its range and anywhere in it, drawn from the seed."""
    low, high = np.array(plant.constants).reshape(-1, 2).T
    draw = np.random.default_rng([seed, len(low)])
    share = draw.uniform(size=len(low))
    return np.ascontiguousarray(low + (np.round(share) if seed % 2 == 0 else share) * (high - low))


class _Field:
    """The task's sets as arrays of doubles, unsafe sets grown and the state space shrunk by the body: unit normals and offsets of
    half-spaces. faces: of every polytope; first: where each set's begin, and their number at the end; radius, ends: of round
    sets; turn, turns, hours: of those that move, as loop.h has them."""

    def __init__(self, task: Task) -> None:
        walls = sorted(task.free_space.faces, key=lambda face: [-abs(c) for c in face[0]] + [-sum(face[0])])  # of two as near, up
        self.space = _unit([*walls, *task.space_cuts], task.dimension)
        self.target = _unit([*task.target.faces, *task.target_cuts], task.dimension)
        sets = task.obstacles
        self.names = [s.name or f"U{j + 1}" for j, s in enumerate(sets)]
        cores = [_bounding(s) for s in sets]
        self.radius = np.array([float(s.radius) for s in sets])
        self.ends = np.array([_ends(s, task) for s in sets]).reshape(-1, 3, task.dimension)
        self.faces = _unit([face for faces in cores for face in faces], task.dimension)
        for s, faces in zip(sets, cores, strict=True):
            if len(faces) > MOST_FACES:
                raise BadInput(f"unsafe set {s.name}: has {len(faces)} faces; a loop takes at most {MOST_FACES}")
        self.first = np.cumsum([0, *map(len, cores)]).astype(np.int32)
        knots = [() if c is None else c.knots for c in task.courses]
        self.turn = np.cumsum([0, *map(len, knots)]).astype(np.int32)
        told = [[float(at), *map(float, by)] for own in knots for at, by in own]
        self.turns = np.array(told).reshape(-1, task.dimension + 1)
        self.hours = np.array([_hours(c) for c in task.courses]).reshape(-1, 5)


def _hours(course: Course | None) -> list[float]:
    if course is None:
        return [-math.inf, math.inf, 0.0, 0.0, 0.0]
    first, last = course.active_interval or (-math.inf, math.inf)
    closed = float(last) if last != course.t_c else math.inf  # a window that ends at t_c stays closed
    return [float(first), closed, float(course.spread), float(course.clock_lag), float(course.clock_lead)]


def doubtful(task: Task) -> list[str]:
    """Unsafe sets that are judged by more than they are: grown by a body, or in time, polytopes of four and more dimensions have
    faces that are not known here."""
    grown = any(task.half_extents)
    found = [s for s, table in zip(task.obstacles, task.unsafe, strict=True) if (grown or table.spread) and not s.radius]
    return [s.name for s in found if len(s.bounded_axes) > SOLID and any(sum(map(bool, normal)) > 1 for normal in s.normals)]


def _bounding(convex: ConvexSet) -> list[HalfSpace]:
    """The half-spaces of a polytope in the dimensions that it bounds; none of a round set."""
    if convex.radius:
        return []
    others = [i for i in range(convex.dimension) if i not in convex.bounded_axes]
    return [(normal, offset) for normal, offset in convex.faces if not any(normal[i] for i in others)]


def _ends(convex: ConvexSet, task: Task) -> Array:
    """Both ends of a round set's segment, and half the box about every point of it, without end in dimensions that it leaves
    free."""
    ends, half = np.zeros((2, task.dimension)), np.full(task.dimension, np.inf)
    if convex.radius:
        for i in convex.bounded_axes:
            ends[:, i] = [float(end[i]) for end in convex.segment_ends]
            half[i] = float(task.half_extents[i])
    return np.vstack([ends, half])


def _unit(half_spaces: Sequence[HalfSpace], n: int) -> Array:
    """Half-spaces as rows of a unit normal and an offset, (F, n + 1). Their whole numbers may have any number of digits."""
    rows = []
    for normal, offset in half_spaces:
        largest = max(map(abs, normal))
        rows.append([*(float(Fraction(c, largest)) for c in normal), float(offset / largest)])
    found = np.array(rows).reshape(-1, n + 1)
    return np.asarray(found / np.sqrt((found[:, :-1] ** 2).sum(axis=1, keepdims=True)))


def of_task(task: Task) -> dict[str, Any]:
    """What a task says of its loop, by the names of `Scenario`: rate, noise, latency."""
    return {
        "rate": float(1 / task.sampling_period),
        "noise": float(task.plant.noise or 0),
        "noise_v": float(task.plant.noise_v or 0),
        "latency": float(task.control.latency),
    }


def columns(task: Task) -> list[str]:
    """The names of a trace's columns, and of those of sets that move: their displacement, and whether they are unsafe."""
    n, moving = task.dimension, [s.name for s, c in zip(task.unsafe, task.courses, strict=True) if c is not None]
    own = [f"{name}.{word}" for name in moving for word in (*(f"d{i + 1}" for i in range(n)), "unsafe")]
    kinds = ("x", "u", "lower", "upper", "w", *(("v",) if task.order == 2 else ()))
    return ["t", *(f"{name}{i + 1}" for name in kinds for i in range(n)), "status", *own]


def csv(trace: Array, task: Task, clock: str = "stated") -> bytes:
    """A trace as CSV; numbers in nine digits. Sets that move are where they are by that clock, by the worst as stated."""
    lines, courses = [",".join(columns(task))], [c for c in task.courses if c is not None]
    behind = {c: {"early": -c.clock_lag, "late": c.clock_lead}.get(clock, Fraction(0)) for c in courses}
    for row in trace.tolist():
        told = [f"{v:.9g}" for v in row[:-1]] + [f"{int(row[-1])}"]
        for course in courses:
            tau = Fraction(row[0]) + behind[course]
            told += [f"{float(v):.9g}" for v in course.displacement(tau)] + [f"{int(course.is_unsafe_at(tau))}"]
        lines.append(",".join(told))
    return ("\n".join(lines) + "\n").encode()


def starts(gamma: Sequence[tuple[Fraction, Fraction]], e: float, seed: int, corner: bool = False) -> tuple[float, ...]:
    """A random start in the initial set with |e| up to a bound, by component, for gamma(0); or one with |e| at the bound."""
    draw = np.random.default_rng(seed)
    middle = np.array([float(a + b) / 2 for a, b in gamma])
    half = np.array([float(b - a) / 2 for a, b in gamma])
    places = draw.uniform(-1, 1, len(middle))
    return tuple((middle + half * e * (np.sign(places) if corner else places)).tolist())
