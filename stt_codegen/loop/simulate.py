"""A closed loop run: the emitted C, held between samples, drives a plant under a disturbance; every state on the way is judged.

Between samples a classical Runge-Kutta method integrates the plant, u being held: steps of at most MAX_STEP seconds and a quarter
of the period, halved until the error of a step is below 1e-13. Runs are the same on every machine of one libm: random numbers
come from the seed in templates/loop/loop.c.

Long because what a run is given and what it results in are described here beside the run.
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

from stt_codegen.arrays import as_floats, entries_of, one_if_equal
from stt_codegen.certify.missions import cycle_of
from stt_codegen.errors import BadInput
from stt_codegen.loop.compiled import LoadedController, LoopResult, LoopSetting, driver, has_constant_dynamics, load_controller
from stt_codegen.loop.judged_sets import JudgedSets
from stt_codegen.loop.mission import unsatisfied_entries
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.task import DriveBounds, Task

Array = npt.NDArray[Any]
DISTURBANCES = ("none", "constant", "sinusoidal", "random", "nearest", "outward", "motion")
CLOCKS = ("stated", "early", "late", "worst")  # errors of the clock by which sets move; see `Scenario`
MAX_STEP = 0.001  # seconds, of the integrator
MIN_STEPS_PER_PERIOD = 4
STEPS_IN_A_LAG = 10  # of the integrator, from which on the error of a step is negligible
MAX_SAMPLES = 10_000_000  # of a run
TICK_ROUNDING = 1e-6  # of a tick: the error that a period from a rate in decimals may have
MAX_EXTENSIONS = 8  # of a run whose tube waits
EXTRA_CYCLES = 2  # after the first, of a tube that repeats itself
MAX_PENDING_INPUTS = 100  # that wait to act under latency, less than in loop.h


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """The conditions of a run.

    rate: samples a second.
    strength: bound on |w|. shares: ratios, at most 1: |w_i| <= shares[i] strength; empty: all are 1.
    noise, noise_v: bounds on the error of every measured component of x and v, one number for all or one for each.
    lost: samples that may be lost in a row.
    latency: seconds from a sample to its input; the first u acts at once, unless is_adverse.
    drives: by component, how the plant's input follows u, from rest: by a limited rate and then two first-order lags; empty: it
        is u. Nothing overshoots, unless is_adverse.
    is_adverse: drives are the worst of their bounds: at once where that helps the disturbance "outward" or "motion" (others count
        as outward), late elsewhere, and commands of the opposite sign act with the weight of the overshoot.
    start: x(0), of order 2 with v(0) behind it or at rest; None: the task's.
    clock: the error of the clock by which sets move. stated: none. early: it is behind the controller's by `timing`. late: it
        is ahead by `timing` and start_delay. worst: nine errors from early to late are tried for every set at every time; a
        collision with one counts.
    """

    rate: float = 1000.0
    disturbance: str = "none"
    strength: float = 0.0
    seed: int = 0
    noise: float | tuple[float, ...] = 0.0
    lost: int = 0
    start: tuple[float, ...] | None = None
    latency: float = 0.0
    clock: str = "stated"
    noise_v: float | tuple[float, ...] = 0.0
    drives: tuple[DriveBounds, ...] = ()
    is_adverse: bool = False
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Raise `BadInput` for an unknown name, and for a number that is not allowed."""
        if self.disturbance not in DISTURBANCES:
            raise BadInput(f"--disturbance {self.disturbance}: is none of {', '.join(DISTURBANCES)}")
        if self.clock not in CLOCKS:
            raise BadInput(f"--clock {self.clock}: is none of {', '.join(CLOCKS)}")
        for name, value in self._numbers():
            if as_floats(name, value, finite=False).ndim:
                raise BadInput(f"{name}: is an array; one number is needed")
            if not (math.isfinite(value) and value >= 0) or (name == "--rate" and value == 0):
                raise BadInput(f"{name} {value:g}: a finite number {'above 0' if name == '--rate' else 'of 0 or more'} is needed")
        for name, errors in (("--noise", self.noise), ("noise_v", self.noise_v)):
            entries_of(name, errors, np.size(errors))
        for name, count in (("--lost", self.lost), ("--seed", self.seed)):
            if isinstance(count, bool) or not isinstance(count, int | np.integer):
                raise BadInput(f"{name}: is {count!r:.40}; a whole number is needed")
        if not 0 <= self.lost <= MAX_SAMPLES:
            raise BadInput(f"--lost {self.lost}: use 0 to {MAX_SAMPLES}")
        if self.latency * self.rate > MAX_PENDING_INPUTS:
            raise BadInput(
                f"--latency {self.latency:g}: is {self.latency * self.rate:g} periods; at most {MAX_PENDING_INPUTS} are simulated"
            )

    def _numbers(self) -> tuple[tuple[str, float], ...]:
        return (
            ("--rate", self.rate),
            ("--w-max", self.strength),
            ("--latency", self.latency),
            *(("--lag", float(bounds.lag)) for bounds in self.drives),
        )

    @property
    def has_drives(self) -> bool:
        """Whether something acts later or otherwise than it is commanded."""
        return not all(bounds.acts_at_once for bounds in self.drives)

    @property
    def age(self) -> float:
        """The greatest age, in seconds, of a sample whose input acts."""
        return (self.lost + 1) / self.rate + self.latency


@dataclass(frozen=True, kw_only=True)
class Run:
    """The result of a run; times are None where the event did not happen.

    hit, hit_at: the unsafe set that was entered first, and when. left_at: when x left the state space. outside, outside_at:
    samples at which the controller said OUTSIDE_TUBE, and the time of the first. reached: whether x is in the target at the end.
    margin: smallest distance to an edge over the width, all along. e, u: largest |e_i|, |u_i|. last: x at the end. waited:
    seconds that the tube waited (control.outside = "hold"), by which the run is longer. missed: entries of the
    mission, from 1, that were not carried out. trace: rows of t, x, u, lower, upper, w, status at every sample and at the end,
    where one is asked for.
    """

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
        """Whether the task is fulfilled: no unsafe set entered, never outside the state space, in the target at the end, the
        mission carried out."""
        return self.hit is None and self.left_at is None and self.reached and not self.missed

    @property
    def kept(self) -> bool:
        """Whether the state was inside its tube all along."""
        return self.margin > 0


class Loop:
    """A controller and a plant, compiled: run it under as many scenarios as you like.

        Loop(build("tasks/omni_s2.toml"), PLANTS["integrator"]).run(Scenario(rate=500.0)).good

    loaded: a controller that is loaded already; it drives in place of the emitted one.
    """

    def __init__(self, controller: EmittedController, plant: Model, loaded: LoadedController | None = None) -> None:
        task = controller.task
        self.controller, self.plant = controller, plant
        self.run_loop = driver(plant, task.dimension, task.order)
        self.loaded = loaded or load_controller(controller)
        self.sets = JudgedSets(task)
        self.has_constant_dynamics = has_constant_dynamics(plant, task.dimension, task.order)
        self.cycle = cycle_of(controller.design)
        self.filter = np.array([float(v) for v in controller.design.filter])

    def run(self, scenario: Scenario, trace: bool = False) -> Run:
        """Run until t_c, or as much longer as the tube waits; of a tube that repeats itself EXTRA_CYCLES cycles more.

        Raises `BadInput` for a start or a rate that the task cannot have.
        """
        start = self._start(scenario)
        constants = _draw_constants(self.plant, scenario.seed)
        t_c = float(self.controller.task.prescribed_time)
        if self.cycle is not None:
            t_c += EXTRA_CYCLES * float(self.cycle.length)
        end, run = t_c, self._run_until(t_c, scenario, start, constants, trace)
        for _ in range(MAX_EXTENSIONS):
            if t_c + run.waited <= end:
                break
            end = t_c + run.waited
            run = self._run_until(end, scenario, start, constants, trace)
        return run

    def _start(self, scenario: Scenario) -> Array:
        """Return x(0), of order 2 with v(0) behind it, in doubles: C reads them by their address."""
        task = self.controller.task
        try:
            start = as_floats("--start", task.initial_state if scenario.start is None else scenario.start, texts=True)
        except BadInput as refusal:
            raise BadInput(f"{str(refusal).rpartition(';')[0]}; {task.dimension} numbers are needed") from None
        if start.ndim != 1:
            raise BadInput(f"--start: has shape {start.shape}; {task.dimension} numbers are needed")
        state_size = task.order * task.dimension
        if start.size not in (task.dimension, state_size):
            or_speeds = "" if task.order == 1 else f", or {state_size} with the speeds"
            raise BadInput(f"--start: has {start.size} numbers, {task.dimension} are needed{or_speeds}")
        return np.concatenate([start, np.zeros(state_size - start.size)])

    def _run_until(self, end: float, scenario: Scenario, start: Array, constants: Array, trace: bool) -> Run:
        """Return the run to that time, seconds."""
        task, sets = self.controller.task, self.sets
        period = 1 / scenario.rate
        samples = self._sample_count(end, scenario.rate)
        shares = np.array(scenario.shares or (1.0,) * task.dimension)
        drives = _drive_table(scenario)
        bounds = (("--noise", scenario.noise), ("noise_v", scenario.noise_v))
        entries = [entries_of(name, noise, task.dimension) for name, noise in bounds]  # refused also where no v is measured
        measurement_errors = np.array([v for errors in entries[: task.order] for v in errors])
        setting = LoopSetting(
            n=task.dimension,
            sets=len(sets.names),
            order=task.order,
            samples=samples,
            integration_steps=self._steps_per_period(period),
            disturbance_kind=DISTURBANCES.index(scenario.disturbance),
            max_lost_samples=scenario.lost,
            has_constant_dynamics=self.has_constant_dynamics and _passes_in_single_steps(scenario, period),
            seed=scenario.seed,
            period=period,
            end=end,
            w_max=scenario.strength,
            measurement_errors=measurement_errors.ctypes.data,
            filter=self.filter.ctypes.data,
            plant_constants=constants.ctypes.data,
            w_ratios=shares.ctypes.data,
            drives=drives.ctypes.data if scenario.has_drives else None,
            is_adverse=scenario.is_adverse,
            latency=scenario.latency,
            start=start.ctypes.data,
            space_face_count=len(sets.space_faces),
            target_face_count=len(sets.target_faces),
            space_faces=sets.space_faces.ctypes.data,
            target_faces=sets.target_faces.ctypes.data,
            face_range_starts=sets.face_range_starts.ctypes.data,
            faces=sets.faces.ctypes.data,
            radius=sets.radius.ctypes.data,
            segments=sets.segments.ctypes.data,
            clock=CLOCKS.index(scenario.clock),
            knot_range_starts=sets.knot_range_starts.ctypes.data,
            knots=sets.knots.ctypes.data,
            activity_and_clock=sets.activity_and_clock.ctypes.data,
        )
        has_rows = trace or bool(task.mission)
        rows = np.empty((samples + 1, (4 + task.order) * task.dimension + 2)) if has_rows else None
        result = LoopResult()
        self.loaded.start()
        functions = (self.loaded.step, self.loaded.tube, self.loaded.advance)
        pointers = [None if f is None else ctypes.cast(f, ctypes.c_void_p) for f in functions]
        self.run_loop(ctypes.byref(setting), *pointers, ctypes.byref(result), None if rows is None else rows.ctypes.data)
        return self._run_of(result, rows)

    def _sample_count(self, end: float, rate: float) -> int:
        """Return the number of samples until `end`. Raises `BadInput` for too many, or a period of no number of ticks."""
        period, tick = 1 / rate, self.controller.program.tick
        if tick is not None and abs(period / float(tick) - max(1, round(period / float(tick)))) > TICK_ROUNDING:
            problem = f"samples come every {period:g} s, and time is counted in ticks of {float(tick):g} s"
            raise BadInput(f"--rate {rate:g}: {problem}; use {1 / float(tick):.9g} divided by a whole number")
        samples = max(1, math.ceil(end / period - 1e-9))
        if samples > MAX_SAMPLES:
            raise BadInput(f"--rate {rate:g}: makes {samples} samples in {end:g} s; at most {MAX_SAMPLES}")
        return samples

    def _steps_per_period(self, period: float) -> int:
        """Return the steps of the integrator in a period; of an adaptive tube no shorter than its certificate allows."""
        count = max(MIN_STEPS_PER_PERIOD, math.ceil(period / MAX_STEP))
        steps = self.controller.certificate.steps
        return count if steps is None else max(1, min(count, math.floor(period / float(steps[0]))))

    def _run_of(self, result: LoopResult, rows: Array | None) -> Run:
        """Return the run that the C reports, with the entries of the mission that its rows do not satisfy."""
        task = self.controller.task
        n = task.dimension

        def time_or_none(value: float) -> float | None:
            return None if value < 0 else float(value)

        missed: tuple[int, ...] = ()
        if rows is not None and task.mission:
            missed = unsatisfied_entries(task, rows[:, 0], rows[:, 1 : 1 + n], self.cycle)
        return Run(
            hit=None if result.hit < 0 else self.sets.names[result.hit],
            hit_at=time_or_none(result.hit_at),
            left_at=time_or_none(result.left_at),
            outside=result.outside,
            outside_at=time_or_none(result.outside_at),
            reached=bool(result.reached),
            margin=result.margin,
            e=tuple(result.e[:n]),
            u=tuple(result.u[:n]),
            last=tuple(result.last[:n]),
            waited=self.loaded.waited_seconds(),
            missed=missed,
            trace=rows,
        )


def _passes_in_single_steps(scenario: Scenario, period: float) -> bool:
    """Return whether steps need no control of their error, for a plant whose f and g are constant.

    Adverse drives jump between steps. Their lags are then precise to 1e-7 of u where they are long beside a step.
    """
    if not scenario.has_drives:
        return True
    shortest = min((float(lag) for bounds in scenario.drives for lag in (bounds.lag, bounds.lag2) if lag), default=math.inf)
    return scenario.is_adverse and shortest >= STEPS_IN_A_LAG * min(MAX_STEP, period / MIN_STEPS_PER_PERIOD)


def _drive_table(scenario: Scenario) -> Array:
    """Return the drives as loop.h has them, (n, 4); only adverse ones overshoot."""
    return np.array(
        [(b.lag, b.lag2, b.slew or 0, b.overshoot / (1 - b.overshoot) if scenario.is_adverse else 0) for b in scenario.drives],
        dtype=float,
    )


def _draw_constants(plant: Model, seed: int) -> Array:
    """Draw the plant's constants for a run: for an even seed each is an end of its range, for an odd one any value of it."""
    low, high = np.array(plant.constants).reshape(-1, 2).T
    draw = np.random.default_rng([seed, len(low)])
    fraction = draw.uniform(size=len(low))
    return np.ascontiguousarray(low + (np.round(fraction) if seed % 2 == 0 else fraction) * (high - low))


def scenario_of_task(task: Task) -> dict[str, Any]:
    """Return the conditions that a task states, by their names in `Scenario`: rate, noise, noise_v, latency, drives."""
    return {
        "rate": float(1 / task.sampling_period),
        "noise": one_if_equal(tuple(float(v) for v in task.noise)),
        "noise_v": one_if_equal(tuple(float(v) for v in task.noise_v)),
        "latency": float(task.control.latency),
        "drives": task.drive_bounds,
    }


def random_start(gamma: Sequence[tuple[Fraction, Fraction]], e: float, seed: int, corner: bool = False) -> tuple[float, ...]:
    """Return a random start within the tube at t = 0, `gamma`, with every |e_i| up to `e`; with corner every |e_i| is `e`."""
    draw = np.random.default_rng(seed)
    middle = np.array([float(a + b) / 2 for a, b in gamma])
    half = np.array([float(b - a) / 2 for a, b in gamma])
    errors = draw.uniform(-1, 1, len(middle))
    return tuple((middle + half * e * (np.sign(errors) if corner else errors)).tolist())
