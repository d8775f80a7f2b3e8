"""Our filtered law beside the cascade of prescribed performance (Bechlioulis and Rovithakis), for plants of order 2.

The cascade takes the tube for a stage of its own, which asks for a speed, and a second stage follows that:

    v_ref = [c'] - k1 xi1 eps1,    |v - v_ref| < rho,    u = -k2 xi2 eps2

with eps1, xi1 of x between the edges, eps2, xi2 of v between v_ref - rho and v_ref + rho, c the tube's middle. The plain one has
no term in brackets, which feeds the middle's speed forward. What is known of it when u is held, by component, with
W- <= W <= W+ the tube's width in a window, S = |W'|/2 or, of the plain one, the edges' speed, and q of
sampling/sampling_conditions.py:
while |v - v_ref| < rho, |eps1| < E1 stays if

    4 k1 q(E1)/W+ > rho + S

and then v_ref moves no faster than

    A = k1 (16 q'(E1) cosh(E1/2)^2 (4 k1 q(E1)/W- + rho + S)/W-^2 + 4 q(E1) |W'|/W-^2) + [|c''|].

So the second stage is a loop of order 1 in a tube of width 2 rho whose edges move at A, and the sharp statement says how slowly
that may be sampled. A comes from doubles, so no period of a cascade is proved here. Ours is the tool's, shown in balls.

The peer is treated well: every component has the k1, rho and k2 of its longest period, its law has no rounding, and u is limited
to 1.1 times what pushes, as ours is. The tubes are those that the tool makes for its own law. All drive the same plant, xdot = v,
vdot = u + w with |w_i| <= w_max, in the same loops, and are judged by the tube of x.

Long because laws, statement, search and loops stand together, so that a reader can check that the peer was treated fairly.
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
from stt_codegen.sampling.gains import INPUT_MARGIN_FACTOR, Gains, natural_gain, needed_input, rounded_gain
from stt_codegen.sampling.order_two import filtered_extremes
from stt_codegen.sampling.sampled_loop import SampledLaw, SampledLoop, first_order_loop
from stt_codegen.sampling.sampling_conditions import q, q_rate
from stt_codegen.sampling.windows import refined_windows
from stt_codegen.task.load import load_task

Array = npt.NDArray[Any]
TUBES = ("omni_s2", "spacecraft")
SHARES = (0.05, 0.9)  # |e(0)| of the starts that a cascade is made for: near the middle, and those of ours
E_MAX = Fraction(99, 100)  # where all clamp e
FARTHEST = 2 * math.atanh(E_MAX) * (1 - 1e-6)  # eps there, not quite
TRIED = 120  # values of E1, and of rho
ENOUGH = 1.001  # times the least k1
STEP = 0.005  # seconds between two looks at a loop, at most
CORNER = 0.9  # |e(0)| of the corners
PERIODS = (1, 2, 5, 10, 20, 30, 50, 80, 100, 130, 160, 200, 250, 300, 400, 500, 600, 800, 1000)  # ms; u is told at the first
WINDS = 10


# ------------------------------------------------------------------------------------------------ laws


@dataclass(frozen=True)
class Edges:
    """A tube at one time: both edges and their rates, (n,)."""

    lower: Array
    upper: Array
    lower_rate: Array
    upper_rate: Array

    @property
    def middle(self) -> Array:
        return np.asarray((self.lower + self.upper) / 2)


def edges_at(design: RefinedDesign, t: Array) -> list[Edges]:
    """The tube at times t."""
    table, t_c = design.integers(), design.prescribed_time
    found = [*reference.tube(table, design.unit, t_c, t), *reference.tube_rate(table, design.unit, t_c, t)]
    return [Edges(*row) for row in zip(*(v.astype(float) for v in found), strict=True)]


@dataclass(frozen=True)
class Filtered:
    """Ours: v + lambda x in the filtered tube."""

    filter: Array
    gain: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...]

    def __call__(self, at: Edges, x: Array, v: Array) -> tuple[Array, Array]:
        """u, and e of what is held, beyond 1 in size outside; x and v (P, n)."""
        low, high = at.lower_rate + self.filter * at.lower, at.upper_rate + self.filter * at.upper
        z = v + self.filter * x
        _, u = reference.control(low, high, z, self.gain, (E_MAX,) * len(self.gain), u_max=self.u_max)
        return u.astype(float), (2 * z - low - high) / (high - low)


@dataclass(frozen=True)
class Cascade:
    """The peer, with c' fed forward or plain. k1, rho, k2 and u_max by component."""

    forward: bool
    k1: Array
    rho: Array
    k2: Array
    u_max: Array

    def wanted(self, at: Edges, x: Array) -> Array:
        """v_ref."""
        rate = (at.lower_rate + at.upper_rate) / 2 if self.forward else 0.0
        return np.asarray(rate - self.k1 * pulled(x - at.lower, at.upper - x))

    def __call__(self, at: Edges, x: Array, v: Array) -> tuple[Array, Array]:
        """As ours; what is held is v - v_ref."""
        error = v - self.wanted(at, x)
        u = -self.k2 * pulled(self.rho + error, self.rho - error)
        return np.clip(u, -self.u_max, self.u_max), error / self.rho


def pulled(a: Array, b: Array) -> Array:
    """xi eps at distances a and b to the edges, e clamped to E_MAX."""
    width, least = a + b, float(1 - E_MAX) / 2
    a = np.clip(a, least * width, (1 - least) * width)
    return np.asarray(width / (a * (width - a)) * np.log(a / (width - a)))


# ------------------------------------------------------------------------------------------------ what is known of the cascade


@dataclass(frozen=True)
class Stage:
    """The first stage over a tube's windows, (W + 1, n). E1, rho and k1 may be many: (.., 1, n)."""

    narrow: Array
    wide: Array
    widening: Array
    lag: Array  # S
    turn: Array  # |c''| where it is fed forward

    @classmethod
    def of(cls, design: RefinedDesign, forward: bool) -> Stage:
        w, turn = refined_windows(design), filtered_extremes(design).middle
        return cls(w.narrow, w.wide, w.widening, w.widening / 2 if forward else w.speed, turn if forward else 0 * turn)

    def least_gain(self, reach: Array, rho: Array) -> Array:
        """The least k1 for |eps1| < reach in every window."""
        return np.asarray(((rho + self.lag) * self.wide / (4 * q(reach))).max(axis=-2, keepdims=True))

    def rate(self, k1: Array, reach: Array, rho: Array) -> Array:
        """A, by window."""
        speed = 4 * k1 * q(reach) / self.narrow + rho + self.lag
        bends = 16 * q_rate(reach) * np.cosh(reach / 2) ** 2 * speed + 4 * q(reach) * self.widening
        return np.asarray(k1 * bends / self.narrow**2 + self.turn)


@dataclass(frozen=True)
class Proved:
    """A controller and what is known of it: for starts at rest with |e(0)| <= share, so many seconds, and |u|. setting: what the
    sharp statement is told; reach: E1 of a cascade."""

    share: float
    law: Filtered | Cascade
    seconds: float
    u: tuple[float, ...]
    setting: SampledLoop
    reach: Array | None = None


def cascade(controller: EmittedController, forward: bool, share: float) -> Proved | None:
    """The cascade of the longest period; None where none is found.

    With u limited to a fixed multiple of what pushes, P, that period is a fixed multiple of rho/P. So E1 and rho are, by
    component, those of the largest rho/P; k1 is the least for them; k2 and the period come from the sharp statement.
    """
    design, bounds = _refined(controller), Analysis(controller).bounds
    n, stage, windows, begin = design.dimension, Stage.of(design, forward), refined_windows(design), 2 * math.atanh(share)
    reach, rho = np.meshgrid(np.geomspace(max(begin * 1.001, 0.05), FARTHEST, TRIED), np.geomspace(0.005, 5, TRIED))
    reach, rho = (np.tile(v.reshape(-1, 1, 1), n) for v in (reach, rho))
    k1 = stage.least_gain(reach, rho) * ENOUGH
    # a start at rest is as far from v_ref as v_ref(0) is from 0
    first = np.array([abs(float(a + b)) / 2 if forward else 0.0 for a, b in slopes_at_start(design)])
    away = (first + k1 * 4 * q(begin) / np.diff(windows.start)[:, 0]) / rho
    pushed = np.array([b.disturbance for b in bounds]) + stage.rate(k1, reach, rho)
    score = np.where(away < float(E_MAX) * (1 - 1e-6), rho, 0)[:, 0] / pushed.max(axis=1)
    best = score.argmax(axis=0), 0, np.arange(n)
    if not (score.max(axis=0) > 0).all():
        return None
    k1, rho, reach, away = k1[best], rho[best], reach[best], away[best]
    same = 0 * windows.narrow
    moved = replace(windows, narrow=same + 2 * rho, wide=same + 2 * rho, speed=stage.rate(k1, reach, rho), widening=same)
    law = SampledLaw(gain=np.ones(n), e_max=np.full(n, float(E_MAX)), shift=np.zeros(n), u_max=np.full(n, np.inf), rounding=0.0)
    setting = first_order_loop(moved, bounds, law, 2 * np.arctanh(away) * (1 + 1e-9))
    setting = setting.with_law(u_max=rounded_gain(needed_input(setting) * INPUT_MARGIN_FACTOR))
    found = Gains(setting, natural_gain(setting)).longest
    if found is None:
        return None
    k2, period = found
    own = Cascade(forward, k1, rho, k2, setting.law.u_max)
    return Proved(share, own, period.seconds, period.u, setting.with_law(gain=k2), reach)


def filtered(controller: EmittedController) -> Proved | None:
    """Ours, u limited to 1.1 times what pushes, at the gain of the longest proved period."""
    analysis, design = Analysis(controller), _refined(controller)
    found = analysis.gains.limited
    if found is None:
        return None
    u_max, gain, period = found
    k, limit = (tuple(map(Fraction, values.tolist())) for values in (gain, u_max))
    law, share = Filtered(np.array([float(v) for v in design.filter]), k, limit), float(controller.task.initial_set.share)
    return Proved(share, law, period.seconds, period.u, analysis.sampled_loop.with_law(gain=gain, u_max=u_max))


def _refined(controller: EmittedController) -> RefinedDesign:
    assert isinstance(controller.design, RefinedDesign)
    return controller.design


# ------------------------------------------------------------------------------------------------ loops


@dataclass(frozen=True)
class Seen:
    """By start, over all winds: the least distance of x to an edge over the width, the largest |u_i|, the largest |e| of what is
    held."""

    margin: Array
    u: Array
    held: Array


def starts_of(n: int) -> Array:
    """e(0): the middle, then the corners."""
    return np.array([np.zeros(n), *(CORNER * np.array(signs) for signs in itertools.product((-1, 1), repeat=n))])


def drive(design: RefinedDesign, law: Filtered | Cascade, period: float, w_max: float, begin: Array) -> Seen:
    """The double integrator from rest at each e(0) of `begin` (S, n), under every wind. u is held over a period, w from one look
    to the next, so every step is exact. Stops where all starts have left."""
    shape, parts = (WINDS, *begin.shape), math.ceil(period / STEP)
    samples, h = math.ceil(float(design.prescribed_time) / period - 1e-9), period / parts
    edges, draw = edges_at(design, h * np.arange(samples * parts + 1)), np.random.default_rng(0)
    x = np.tile(edges[0].middle + begin * (edges[0].upper - edges[0].lower) / 2, (WINDS, 1, 1))
    v, u, gust = np.zeros(shape), np.zeros(shape), np.zeros(begin.shape)
    margin, peak, most = np.full(shape[1], 0.5), np.zeros(shape[1]), np.zeros(shape[1])
    for k, at in enumerate(edges):
        margin = np.minimum(margin, (np.minimum(x - at.lower, at.upper - x) / (at.upper - at.lower)).min(axis=(0, 2)))
        asked, held = (found.reshape(shape) for found in law(at, x.reshape(-1, shape[2]), v.reshape(-1, shape[2])))
        most = np.maximum(most, np.abs(held).max(axis=(0, 2)))
        if k == samples * parts or (margin <= 0).all():
            break
        if k % parts == 0:
            u = asked
            peak = np.maximum(peak, np.abs(u).max(axis=(0, 2)))
        if k % max(1, round(0.05 / h)) == 0:
            gust = draw.choice((-1.0, 1.0), begin.shape)
        push = u + w_max * _winds(k * h, x - at.middle, held, v, gust)
        x = x + h * v + h * h / 2 * push
        v = v + h * push
    return Seen(margin, peak, most)


def _winds(t: float, y: Array, held: Array, v: Array, gust: Array) -> Array:
    """w over w_max, (WINDS, S, n): outward and inward, as x and as what is held have it; along v; both ways; two sines; gusts."""
    w = np.empty_like(y)
    w[0], w[1], w[2], w[3], w[4] = np.sign(y[0]), np.sign(held[1]), -np.sign(y[2]), -np.sign(held[3]), np.sign(v[4])
    w[5], w[6], w[7], w[8], w[9] = 1.0, -1.0, math.sin(2 * t), math.sin(8 * t), gust
    return w


@dataclass(frozen=True)
class Measured:
    """A controller, None where none is found, in loops: at the first of PERIODS, and the first of them, in ms, at which it leaves
    from the middle and from some corner; None where it never does."""

    tube: str
    name: str
    share: float
    found: Proved | None = None
    seen: Seen | None = None
    middle: int | None = None
    corner: int | None = None

    @property
    def kept(self) -> bool:
        """Whether no loop left its tube at a period that is proved for it, started where that is proved."""
        firsts = (self.middle, self.corner if self.share >= CORNER else None)
        return self.found is None or all(ms is None or ms > 1e3 * self.found.seconds for ms in firsts)


def measured(tube: str, name: str, share: float, found: Proved | None, design: RefinedDesign, w_max: float) -> Measured:
    """Longer and longer periods, until both are seen to fail."""
    if found is None:
        return Measured(tube, name, share)
    seen, middle, corner = None, None, None
    for ms in PERIODS:
        now = drive(design, found.law, ms / 1e3, w_max, starts_of(design.dimension))
        seen = seen or now
        middle = ms if middle is None and now.margin[0] <= 0 else middle
        corner = ms if corner is None and (now.margin[1:] <= 0).any() else corner
        if middle is not None and corner is not None:
            break
    return Measured(tube, name, share, found, seen, middle, corner)


def inertial(tube: str, w_max: float) -> EmittedController:
    """One of TUBES as a double integrator. Raises `NotCertified`."""
    return build_task(load_task(folder() / f"{tube}.toml").changed(plant={"order": 2, "w_max": f"{w_max:.9g}"}))


def folder() -> Path:
    """The example tasks, which a checkout has beside the package."""
    return template_folder().parent / "tasks"


def run(tube: str, w_max: float) -> list[Measured] | str:
    """All controllers of a tube, or why there is none."""
    try:
        controller = inertial(tube, w_max)
    except NotCertified as error:
        return f"{tube}: {error}"
    design, ours = _refined(controller), filtered(controller)
    found = [("filtered (ours)", float(controller.task.initial_set.share), ours)]
    for name, forward in (("cascade, c' fed forward", True), ("cascade, plain", False)):
        found += [(name, share, cascade(controller, forward, share)) for share in SHARES]
    return [measured(tube, *one, design, w_max) for one in found]


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
with |e(0)| up to the bound, and u is limited to {spare:g} times what pushes. period: ours is proved in balls; those of the
cascades are sums in doubles, with the k1, rho and k2 of the longest one that a search finds; others may do better in loops. Two
figures: from the middle, and the worst corner at |e(0)| = {corner:g}, which a cascade made for the middle owes nothing. Left
first at: the first of a row of longer and longer periods at which some loop leaves its tube. Largest u, and least margin over the
width from the middle: at {rate:g} Hz.
""".strip()


def compare(w_max: float, processes: int) -> tuple[list[list[str]], list[str], bool]:
    """Rows, what is to be said of them, and whether ours stayed in its tube wherever that is proved."""
    if not folder().is_dir():
        return [], [f"Plants of order 2 are not compared: {folder()} is not there; it is in a checkout"], True
    results = list(run_jobs(partial(run, w_max=w_max), TUBES, min(processes, len(TUBES)), None))
    told = [m for found in results if not isinstance(found, str) for m in found]
    reading = READING.format(w_max=w_max, spare=INPUT_MARGIN_FACTOR, corner=CORNER, rate=1e3 / PERIODS[0])
    lines = [reading, *(found for found in results if isinstance(found, str))]
    return [row(m) for m in told], lines, all(m.kept for m in told if m.found and isinstance(m.found.law, Filtered))


def row(m: Measured) -> list[str]:
    """One controller; dashes where none is found."""
    head = [m.tube, m.name, f"{m.share:g}"]
    if m.found is None or m.seen is None:
        return [*head, "none", *["-"] * (len(HEADINGS) - 4)]
    left = " / ".join("never" if ms is None else f"{ms}" for ms in (m.middle, m.corner))
    largest = " / ".join(number(float(u)) for u in (m.seen.u[0], m.seen.u[1:].max()))
    bound = ", ".join(number(u) for u in m.found.u)
    return [*head, number(1e3 * m.found.seconds), bound, left, largest, number(float(m.seen.margin[0]))]
