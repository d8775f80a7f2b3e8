"""Our filtered law beside the cascade of prescribed performance (Bechlioulis and Rovithakis), for plants of order 2.

A cascade has two stages. The first one keeps x in the tube by asking for a speed v_ref, the second one makes v follow it:

    v_ref = [c'] - k1 xi1 eps1,    |v - v_ref| < rho,    u = -k2 xi2 eps2

with eps1, xi1 of x between the edges, eps2, xi2 of v between v_ref - rho and v_ref + rho, c the tube's middle. The plain cascade
lacks the term in brackets, which feeds the middle's speed forward.

How slowly may u be sampled? By component, let W- <= W <= W+ be the tube's width in a window, S = |W'|/2 or, of the plain cascade,
the edges' speed, and q as in sampling/sampling_conditions.py. While |v - v_ref| < rho, |eps1| < E1 stays if

    4 k1 q(E1)/W+ > rho + S

and then v_ref moves no faster than

    A = k1 (16 q'(E1) cosh(E1/2)^2 (4 k1 q(E1)/W- + rho + S)/W-^2 + 4 q(E1) |W'|/W-^2) + [|c''|].

So the second stage is a loop of order 1 in a tube of width 2 rho whose edges move at A, and the sharp sampling conditions give
its longest period. A is computed in doubles, so no period of a cascade is proved here. Ours is the tool's, proved in balls.

The peer is treated well: every component has the k1, rho and k2 of its longest period, its law has no rounding, and its limit of
u is 1.1 times what it needs, as ours is. The tubes are those that the tool designs for our law. All drive the same plant, xdot =
v, vdot = u + w with |w_i| <= w_max, in the same loops, and are judged by the tube of x.

Long because laws, conditions, search and loops stand together, so that a reader can check that the peer was treated fairly.
`python -m benchmarks loop --peers` calls `compare`.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.arenas import run_jobs
from benchmarks.suites.report import number
from stt_codegen import reference
from stt_codegen.designs.filtered import slopes_at_start
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.program.targets.template_files import template_folder
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling.gains import INPUT_MARGIN_FACTOR, Gains, balancing_gain, needed_input, rounded_gain
from stt_codegen.sampling.order_two import filtered_extremes
from stt_codegen.sampling.sampled_loop import SampledLaw, SampledLoop, first_order_loop
from stt_codegen.sampling.sampling_conditions import q, q_rate
from stt_codegen.sampling.windows import refined_windows
from stt_codegen.task.load import load_task

Array = npt.NDArray[Any]
TUBES = ("omni_s2", "spacecraft")  # tasks whose tubes are compared
START_SHARES = (0.05, 0.9)  # |e(0)| of the starts that a cascade is made for: near the middle, and those of our law
E_MAX = Fraction(99, 100)  # where all laws clamp e
EPS_LIMIT = 2 * math.atanh(E_MAX) * (1 - 1e-6)  # a little below eps at e = E_MAX
GRID_SIZE = 120  # values of E1, and of rho, that the search compares
GAIN_FACTOR = 1.001  # times the smallest k1, whose condition is strict
LONGEST_STEP = 0.005  # seconds of a simulation
CORNER = 0.9  # |e_i(0)| of the starts in corners
PERIODS_MS = (1, 2, 5, 10, 20, 30, 50, 80, 100, 130, 160, 200, 250, 300, 400, 500, 600, 800, 1000)  # u is reported at the first
WIND_COUNT = 10
GUST_SECONDS = 0.05


# ------------------------------------------------------------------------------------------------ laws


@dataclass(frozen=True)
class TubeEdges:
    """A tube at one time: both edges and their rates, (n,)."""

    lower: Array
    upper: Array
    lower_rate: Array
    upper_rate: Array

    @property
    def middle(self) -> Array:
        return np.asarray((self.lower + self.upper) / 2)


def edges_at(design: RefinedDesign, t: Array) -> list[TubeEdges]:
    """Evaluate the tube at times t."""
    table, t_c = design.integers(), design.prescribed_time
    edges = [*reference.tube(table, design.unit, t_c, t), *reference.tube_rate(table, design.unit, t_c, t)]
    return [TubeEdges(*row) for row in zip(*(v.astype(float) for v in edges), strict=True)]


@dataclass(frozen=True)
class FilteredLaw:
    """Our law, which keeps v + lambda x in the filtered tube. filter: lambda; all by component."""

    filter: Array
    gain: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...]

    def __call__(self, edges: TubeEdges, x: Array, v: Array) -> tuple[Array, Array]:
        """Return u, and e of v + lambda x, beyond 1 in size outside of the filtered tube. x and v: (P, n)."""
        low, high = edges.lower_rate + self.filter * edges.lower, edges.upper_rate + self.filter * edges.upper
        z = v + self.filter * x
        _, u = reference.control(low, high, z, self.gain, (E_MAX,) * len(self.gain), u_max=self.u_max)
        return u.astype(float), (2 * z - low - high) / (high - low)


@dataclass(frozen=True)
class CascadeLaw:
    """The peer's law. feeds_forward: whether v_ref contains c'; k1, rho, k2 and u_max by component."""

    feeds_forward: bool
    k1: Array
    rho: Array
    k2: Array
    u_max: Array

    def reference_speed(self, edges: TubeEdges, x: Array) -> Array:
        """Return v_ref."""
        middle_rate = (edges.lower_rate + edges.upper_rate) / 2 if self.feeds_forward else 0.0
        return np.asarray(middle_rate - self.k1 * xi_eps(x - edges.lower, edges.upper - x))

    def __call__(self, edges: TubeEdges, x: Array, v: Array) -> tuple[Array, Array]:
        """Return u, and (v - v_ref) / rho, beyond 1 in size where v is too far from v_ref. x and v: (P, n)."""
        error = v - self.reference_speed(edges, x)
        u = -self.k2 * xi_eps(self.rho + error, self.rho - error)
        return np.clip(u, -self.u_max, self.u_max), error / self.rho


def xi_eps(a: Array, b: Array) -> Array:
    """Return xi times eps at distances a and b to the lower and the upper edge, with e clamped to E_MAX."""
    width, closest_share = a + b, float(1 - E_MAX) / 2
    a = np.clip(a, closest_share * width, (1 - closest_share) * width)
    return np.asarray(width / (a * (width - a)) * np.log(a / (width - a)))


# ------------------------------------------------------------------------------------------------ periods of the controllers


@dataclass(frozen=True)
class FirstStage:
    """The first stage of a cascade over a tube's windows, (W + 1, n). In its functions E1, rho and k1 may be many: (.., 1, n).

    narrow, wide: bounds on the width, W- and W+; widening: |W'|; edge_speed: S; middle_acceleration: |c''| where it is fed
    forward, else 0."""

    narrow: Array
    wide: Array
    widening: Array
    edge_speed: Array
    middle_acceleration: Array

    @classmethod
    def of(cls, design: RefinedDesign, feeds_forward: bool) -> FirstStage:
        windows, middle_acceleration = refined_windows(design), filtered_extremes(design).middle
        return cls(
            windows.narrow,
            windows.wide,
            windows.widening,
            windows.widening / 2 if feeds_forward else windows.speed,
            middle_acceleration if feeds_forward else 0 * middle_acceleration,
        )

    def smallest_gain(self, e1: Array, rho: Array) -> Array:
        """Return the smallest k1 for which |eps1| < E1 stays in every window."""
        return np.asarray(((rho + self.edge_speed) * self.wide / (4 * q(e1))).max(axis=-2, keepdims=True))

    def reference_acceleration(self, k1: Array, e1: Array, rho: Array) -> Array:
        """Return A, the bound on |v_ref'|, by window."""
        speed = 4 * k1 * q(e1) / self.narrow + rho + self.edge_speed
        bends = 16 * q_rate(e1) * np.cosh(e1 / 2) ** 2 * speed + 4 * q(e1) * self.widening
        return np.asarray(k1 * bends / self.narrow**2 + self.middle_acceleration)


@dataclass(frozen=True)
class TimedController:
    """A law with its longest period and its bound on |u|, for starts at rest with |e(0)| <= share.

    period: in seconds, proved for our law, computed in doubles for a cascade; input_bounds: by component; sampled_loop: what the
    sampling conditions are about; e1: E1 of a cascade."""

    share: float
    law: FilteredLaw | CascadeLaw
    period: float
    input_bounds: tuple[float, ...]
    sampled_loop: SampledLoop
    e1: Array | None = None


@dataclass(frozen=True)
class _StageNumbers:
    """k1, rho and E1 of a first stage, and |v - v_ref| / rho at 0 for its starts, by component."""

    k1: Array
    rho: Array
    e1: Array
    start_error: Array


def cascade_of_longest_period(controller: EmittedController, feeds_forward: bool, share: float) -> TimedController | None:
    """Search for the cascade of the longest period on the tube of a controller; None where no period is proved.

    With u limited to a fixed multiple of what it needs, P, that period is a fixed multiple of rho/P. So E1 and rho are, by
    component, those of the largest rho/P; k1 is the smallest for them; k2 and the period come from the sharp conditions.
    """
    design, bounds = _refined(controller), Analysis(controller).bounds
    n, stage, windows = design.dimension, FirstStage.of(design, feeds_forward), refined_windows(design)
    numbers = _best_first_stage(controller, stage, feeds_forward, share)
    if numbers is None:
        return None
    zero, width = 0 * windows.narrow, 0 * windows.narrow + 2 * numbers.rho
    edge_speed = stage.reference_acceleration(numbers.k1, numbers.e1, numbers.rho)
    second_windows = replace(windows, narrow=width, wide=width, speed=edge_speed, widening=zero)
    law = SampledLaw(gain=np.ones(n), e_max=np.full(n, float(E_MAX)), shift=np.zeros(n), u_max=np.full(n, np.inf), rounding=0.0)
    sampled_loop = first_order_loop(second_windows, bounds, law, 2 * np.arctanh(numbers.start_error) * (1 + 1e-9))
    sampled_loop = sampled_loop.with_law(u_max=rounded_gain(needed_input(sampled_loop) * INPUT_MARGIN_FACTOR))
    longest = Gains(sampled_loop, balancing_gain(sampled_loop)).with_longest_period
    if longest is None:
        return None
    k2, period = longest
    cascade = CascadeLaw(feeds_forward, numbers.k1, numbers.rho, k2, sampled_loop.law.u_max)
    return TimedController(share, cascade, period.seconds, period.u, sampled_loop.with_law(gain=k2), numbers.e1)


def _best_first_stage(
    controller: EmittedController, stage: FirstStage, feeds_forward: bool, share: float
) -> _StageNumbers | None:
    """Choose E1 and rho from a grid, by component; None where no pair of the grid suits the starts."""
    design, bounds = _refined(controller), Analysis(controller).bounds
    n, windows, start_eps = design.dimension, refined_windows(design), 2 * math.atanh(share)
    grid = np.meshgrid(np.geomspace(max(start_eps * 1.001, 0.05), EPS_LIMIT, GRID_SIZE), np.geomspace(0.005, 5, GRID_SIZE))
    e1, rho = (np.tile(v.reshape(-1, 1, 1), n) for v in grid)
    k1 = stage.smallest_gain(e1, rho) * GAIN_FACTOR
    # a start at rest is as far from v_ref as v_ref(0) is from 0
    middle_speed = np.array([abs(float(a + b)) / 2 if feeds_forward else 0.0 for a, b in slopes_at_start(design)])
    start_error = (middle_speed + k1 * 4 * q(start_eps) / np.diff(windows.start)[:, 0]) / rho
    needed = np.array([b.disturbance for b in bounds]) + stage.reference_acceleration(k1, e1, rho)
    score = np.where(start_error < float(E_MAX) * (1 - 1e-6), rho, 0)[:, 0] / needed.max(axis=1)
    best = score.argmax(axis=0), 0, np.arange(n)
    if not (score.max(axis=0) > 0).all():
        return None
    return _StageNumbers(k1[best], rho[best], e1[best], start_error[best])


def filtered_controller(controller: EmittedController) -> TimedController | None:
    """Return our law with u limited to 1.1 times what it needs, at the gain of the longest proved period; None without one."""
    analysis, design = Analysis(controller), _refined(controller)
    limited = analysis.gains.with_suggested_limits
    if limited is None:
        return None
    u_max, gain, period = limited
    gain_exact, u_max_exact = (tuple(map(Fraction, values.tolist())) for values in (gain, u_max))
    law = FilteredLaw(np.array([float(v) for v in design.filter]), gain_exact, u_max_exact)
    sampled_loop = analysis.sampled_loop.with_law(gain=gain, u_max=u_max)
    return TimedController(float(controller.task.initial_set.share), law, period.seconds, period.u, sampled_loop)


def _refined(controller: EmittedController) -> RefinedDesign:
    assert isinstance(controller.design, RefinedDesign)
    return controller.design


# ------------------------------------------------------------------------------------------------ loops


@dataclass(frozen=True)
class LoopExtremes:
    """By start, over all winds: the smallest distance of x to an edge over the width, the largest |u_i|, and the largest error
    that the law returns."""

    margin: Array
    u: Array
    error: Array


def corner_starts(n: int) -> Array:
    """Return e(0) of the middle, then of the corners: (1 + 2^n, n)."""
    return np.array([np.zeros(n), *(CORNER * np.array(signs) for signs in itertools.product((-1, 1), repeat=n))])


def simulate(
    design: RefinedDesign, law: FilteredLaw | CascadeLaw, period: float, w_max: float, start_errors: Array
) -> LoopExtremes:
    """Simulate the double integrator from rest at each e(0) of `start_errors` (S, n), under every wind.

    u stays for a period, w for a step, so every step is exact. Stops where all starts have left the tube."""
    shape, parts = (WIND_COUNT, *start_errors.shape), math.ceil(period / LONGEST_STEP)
    samples, h = math.ceil(float(design.prescribed_time) / period - 1e-9), period / parts
    tube, rng = edges_at(design, h * np.arange(samples * parts + 1)), np.random.default_rng(0)
    x = np.tile(tube[0].middle + start_errors * (tube[0].upper - tube[0].lower) / 2, (WIND_COUNT, 1, 1))
    v, u, gust = np.zeros(shape), np.zeros(shape), np.zeros(start_errors.shape)
    margin, largest_u, largest_error = np.full(shape[1], 0.5), np.zeros(shape[1]), np.zeros(shape[1])
    for k, edges in enumerate(tube):
        share_to_edge = np.minimum(x - edges.lower, edges.upper - x) / (edges.upper - edges.lower)
        margin = np.minimum(margin, share_to_edge.min(axis=(0, 2)))
        computed_u, error = (v_.reshape(shape) for v_ in law(edges, x.reshape(-1, shape[2]), v.reshape(-1, shape[2])))
        largest_error = np.maximum(largest_error, np.abs(error).max(axis=(0, 2)))
        if k == samples * parts or (margin <= 0).all():
            break
        if k % parts == 0:
            u = computed_u
            largest_u = np.maximum(largest_u, np.abs(u).max(axis=(0, 2)))
        if k % max(1, round(GUST_SECONDS / h)) == 0:
            gust = rng.choice((-1.0, 1.0), start_errors.shape)
        acceleration = u + w_max * _wind_directions(k * h, x - edges.middle, error, v, gust)
        x = x + h * v + h * h / 2 * acceleration
        v = v + h * acceleration
    return LoopExtremes(margin, largest_u, largest_error)


def _wind_directions(t: float, offset: Array, error: Array, v: Array, gust: Array) -> Array:
    """Return w over w_max, (WIND_COUNT, S, n): outward and inward, by x and by the law's error; along v; both ways; two sines;
    gusts. offset: of x from the tube's middle."""
    w = np.empty_like(offset)
    w[0], w[1], w[2], w[3] = np.sign(offset[0]), np.sign(error[1]), -np.sign(offset[2]), -np.sign(error[3])
    w[4], w[5], w[6], w[7], w[8], w[9] = np.sign(v[4]), 1.0, -1.0, math.sin(2 * t), math.sin(8 * t), gust
    return w


@dataclass(frozen=True)
class ComparedController:
    """A controller on a tube, None where there is none, for starts with |e(0)| <= share; and how its loops went, once measured.

    extremes: at the first of PERIODS_MS; left_from_middle, left_from_corner: the first of PERIODS_MS at which it leaves the tube
    from the middle, and from some corner; None where it never does."""

    tube: str
    name: str
    share: float
    controller: TimedController | None = None
    extremes: LoopExtremes | None = None
    left_from_middle: int | None = None
    left_from_corner: int | None = None

    @property
    def stays_where_proved(self) -> bool:
        """Whether no loop left its tube at a period that is proved for it, from starts that the proof is about."""
        left_at = (self.left_from_middle, self.left_from_corner if self.share >= CORNER else None)
        return self.controller is None or all(ms is None or ms > 1e3 * self.controller.period for ms in left_at)


def measure(compared: ComparedController, design: RefinedDesign, w_max: float) -> ComparedController:
    """Simulate longer and longer periods, until the controller has left the tube from the middle and from a corner."""
    if compared.controller is None:
        return compared
    first_extremes, middle, corner = None, None, None
    for ms in PERIODS_MS:
        extremes = simulate(design, compared.controller.law, ms / 1e3, w_max, corner_starts(design.dimension))
        first_extremes = first_extremes or extremes
        middle = ms if middle is None and extremes.margin[0] <= 0 else middle
        corner = ms if corner is None and (extremes.margin[1:] <= 0).any() else corner
        if middle is not None and corner is not None:
            break
    return replace(compared, extremes=first_extremes, left_from_middle=middle, left_from_corner=corner)


def build_double_integrator(tube: str, w_max: float) -> EmittedController:
    """Build one of TUBES as a double integrator. Raises `NotCertified`."""
    return build_task(load_task(example_tasks() / f"{tube}.toml").changed(plant={"order": 2, "w_max": f"{w_max:.9g}"}))


def example_tasks() -> Path:
    """Return the folder of the example tasks, which a checkout has beside the package."""
    return template_folder().parent / "tasks"


def compare_on_tube(tube: str, w_max: float) -> list[ComparedController] | str:
    """Measure all controllers of a tube; where there is no tube, return the reason."""
    try:
        controller = build_double_integrator(tube, w_max)
    except NotCertified as error:
        return f"{tube}: {error}"
    design, share = _refined(controller), float(controller.task.initial_set.share)
    compared = [ComparedController(tube, "filtered (ours)", share, filtered_controller(controller))]
    for name, feeds_forward in (("cascade, c' fed forward", True), ("cascade, plain", False)):
        for start_share in START_SHARES:
            cascade = cascade_of_longest_period(controller, feeds_forward, start_share)
            compared.append(ComparedController(tube, name, start_share, cascade))
    return [measure(c, design, w_max) for c in compared]


# ------------------------------------------------------------------------------------------------ table

HEADINGS = (
    "tube",
    "controller",
    "e(0) up to",
    "period, ms",
    "u up to",
    "left first at, ms",
    "largest u",
    "least margin",
)
READING = """
Plants of order 2, as double integrators: xdot = v, vdot = u + w, |w_i| <= {w_max:g}. Every controller is made for starts at rest
with |e(0)| up to the bound, and u is limited to {factor:g} times what the controller needs. period: ours is proved in balls;
those of the cascades are sums in doubles, with the k1, rho and k2 of the longest one that a search finds; others may do better
in loops. Two figures: from the middle, and the worst corner at |e(0)| = {corner:g}, which a cascade made for the middle need not
stay from. Left first at: the first of a row of longer and longer periods at which some loop leaves its tube. Largest u, and
smallest margin over the width from the middle: at {rate:g} Hz.
""".strip()


def compare(w_max: float, processes: int) -> tuple[list[list[str]], list[str], bool]:
    """Compare on all TUBES: return rows of the table, lines that explain it, and whether ours stayed in its tube wherever that is
    proved."""
    if not example_tasks().is_dir():
        return [], [f"Plants of order 2 are not compared: {example_tasks()} is not there; it is in a checkout"], True
    results = list(run_jobs(partial(compare_on_tube, w_max=w_max), TUBES, min(processes, len(TUBES)), None))
    compared = [c for result in results if not isinstance(result, str) for c in result]
    reading = READING.format(w_max=w_max, factor=INPUT_MARGIN_FACTOR, corner=CORNER, rate=1e3 / PERIODS_MS[0])
    lines = [reading, *(result for result in results if isinstance(result, str))]
    ours = [c for c in compared if c.controller and isinstance(c.controller.law, FilteredLaw)]
    return [table_row(c) for c in compared], lines, all(c.stays_where_proved for c in ours)


def table_row(compared: ComparedController) -> list[str]:
    """Return the cells of one controller; dashes where there is none."""
    head = [compared.tube, compared.name, f"{compared.share:g}"]
    controller, extremes = compared.controller, compared.extremes
    if controller is None or extremes is None:
        return [*head, "none", *["-"] * (len(HEADINGS) - 4)]
    left_at = " / ".join("never" if ms is None else f"{ms}" for ms in (compared.left_from_middle, compared.left_from_corner))
    largest_u = " / ".join(number(float(u)) for u in (extremes.u[0], extremes.u[1:].max()))
    input_bounds = ", ".join(number(u) for u in controller.input_bounds)
    margin = number(float(extremes.margin[0]))
    return [*head, number(1e3 * controller.period), input_bounds, left_at, largest_u, margin]
