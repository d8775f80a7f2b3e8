"""The adaptive design: the paper's functions, with windows, sides and parameters from a search (conflict_search.py).

Lengths scale with the narrowest start or target (0.5 in the arenas), times with t_c (9 s there); several settings are tried.
Parameters are rounded to few bits, so that they are exact in float and no last digit of a library reaches the output. The lemmas
`bumps.*` and `smooth.*` are about the functions; certify/adaptive/ proves each tube.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache

import casadi as ca
import numpy as np

from stt_codegen.design.arena import Arena, arena_of, starting_box
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.lattice import shared_lattice
from stt_codegen.design.paper_tubes.conflict_search import ConflictProblem, Push, search_pushes
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, Bump
from stt_codegen.errors import NotCertified
from stt_codegen.paper import adaptive_tube, reach_tube
from stt_codegen.paper.circumvent import CUT, bump
from stt_codegen.paper.smooth import smooth_join, smooth_max
from stt_codegen.properties import Property
from stt_codegen.task import Task

SEARCH_STEPS = 450  # time steps of the search's tube
WALL_INSET_RATIO = 0.02  # of the target margin: rest levels stay clear of the walls, since an enclosure cannot show equality
BITS = 18  # significant bits of every parameter


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The parameters of one try, for lengths of 0.5 and t_c = 9 s.

    overshoot: dB of (7). clearance: kept beyond the task's over a push. ramp: seconds from rest to level and back. reserve: what
    the search keeps beyond the task's clearance. tries_holds, node_limit: as in `ConflictProblem`.
    """

    overshoot: float = 0.15
    clearance: float = 0.06
    ramp: float = 1.2
    theta0: float = 1.5
    kappa: float = 30.0
    mu: float = 0.2
    varsigma: float = 20.0
    nu: float = 100.0
    target_margin: float = 0.03
    reserve: float = 0.015
    tries_holds: bool = False
    node_limit: int = 80


SETTINGS = (
    Settings(),
    Settings(ramp=0.7),
    Settings(ramp=0.4),
    Settings(ramp=0.7, overshoot=0.12, kappa=50.0),
    Settings(ramp=0.35, overshoot=0.12, kappa=50.0, theta0=0.8),
    Settings(ramp=0.7, tries_holds=True, node_limit=250),
    Settings(ramp=0.35, overshoot=0.12, kappa=50.0, theta0=0.8, tries_holds=True, node_limit=250),
)


def design_adaptive(task: Task) -> AdaptiveDesign:
    """Design an adaptive tube. Raises `NotCertified` when the search finds none."""
    arena = arena_of(task, shared_lattice(task))
    start = starting_box(arena)
    for settings in SETTINGS:
        scaled = _scaled(task, arena, start, settings)
        design = _empty_design(task, arena, start, scaled)
        model = _Model(arena, design, scaled)
        pushes = search_pushes(
            ConflictProblem(
                times=model.times,
                unsafe=model.unsafe,
                min_widths=arena.min_widths,
                edges=model.edges,
                is_possible=model.is_possible,
                tries_holds=settings.tries_holds,
                node_limit=settings.node_limit,
            )
        )
        if pushes is not None:
            return replace(design, bumps=tuple(b for b in map(model.bump, pushes) if b is not None))
    task_parameters = [name for name, value in task.tube.adaptive if value is not None]
    raise NotCertified(
        f"{Property.AVOID.label}: the search found no circumvent functions that keep the tube clear of every unsafe set"
        + (f", with the task's own {', '.join(task_parameters)} in [tube.adaptive]; leave them out" if task_parameters else "")
        + '; use tube.design = "refined" (its refusal says whether there is a way at all), or lower tube.clearance'
    )


def _scaled(task: Task, arena: Arena, start: Array, settings: Settings) -> Settings:
    """Return the settings in the task's units, with the task's parameters in place of ours where it names them."""
    widths = np.minimum(start[1] - start[0], arena.target[1] - arena.target[0])
    length, time = float(widths.min()) / 0.5, arena.prescribed_time / 9.0
    options = task.tube.adaptive

    def chosen(task_value: Fraction | None, ours: float) -> float:
        return ours if task_value is None else float(task_value)

    return Settings(
        overshoot=chosen(options.overshoot, settings.overshoot * length),
        clearance=settings.clearance * length,
        ramp=settings.ramp * time,
        theta0=chosen(options.theta0, settings.theta0 * length**3 / time),
        kappa=chosen(options.kappa, settings.kappa / time),
        mu=chosen(options.mu, settings.mu * length),
        varsigma=chosen(options.varsigma, settings.varsigma / length),
        nu=chosen(options.nu, settings.nu / length),
        target_margin=chosen(options.target_margin, settings.target_margin * length),
        reserve=settings.reserve * length,
        tries_holds=settings.tries_holds,
        node_limit=settings.node_limit,
    )


def _round_to_bits(value: float) -> Fraction:
    """Return the nearest number of BITS significant bits."""
    if value == 0:
        return Fraction(0)
    mantissa, exponent = math.frexp(value)
    return Fraction(round(mantissa * 2**BITS)) * Fraction(2) ** (exponent - BITS)


def _empty_design(task: Task, arena: Arena, start: Array, settings: Settings) -> AdaptiveDesign:
    """Return the design without circumvent functions, its parameters rounded."""
    margin, inset = settings.target_margin, WALL_INSET_RATIO * settings.target_margin

    def pairs(lower: Array, upper: Array) -> tuple[tuple[Fraction, Fraction], ...]:
        return tuple((_round_to_bits(float(a)), _round_to_bits(float(b))) for a, b in zip(lower, upper, strict=True))

    return AdaptiveDesign(
        kind="adaptive",
        prescribed_time=task.prescribed_time,
        start=pairs(start[0], start[1]),
        target=pairs(arena.target[0] + margin, arena.target[1] - margin),
        walls=pairs(arena.space[0] + inset, arena.space[1] - inset),
        bumps=(),
        theta0=_round_to_bits(settings.theta0),
        kappa=_round_to_bits(settings.kappa),
        mu=_round_to_bits(settings.mu),
        varsigma=_round_to_bits(settings.varsigma),
        nu=_round_to_bits(settings.nu),
    )


class _Model:
    """The adaptive tube on the search's time grid, as the parameters of its circumvent functions change."""

    def __init__(self, arena: Arena, design: AdaptiveDesign, settings: Settings) -> None:
        self.arena, self.design, self.settings = arena, design, settings
        self.times: Array = np.array([k * (arena.prescribed_time / SEARCH_STEPS) for k in range(SEARCH_STEPS + 1)])
        distance = arena.clearance + settings.reserve
        self.unsafe = np.stack([arena.unsafe[:, 0] - distance, arena.unsafe[:, 1] + distance], axis=1)
        self.profile = np.array(_grid_profile()(self.times[None], arena.prescribed_time)).ravel()

    def bump(self, push: Push) -> Bump | None:
        """Return the circumvent function of a push; None when the wall is too near, or there is no time for its ramps.

        r^2 = q^2 (1 + k/c), c = -ln(1 - (dB - delta)/B), keeps delta over the half width q; here r is chosen and k follows.
        """
        i, s, t_c = push.dimension, self.settings, self.arena.prescribed_time
        floor, ceiling = (float(v) for v in self.design.walls[i])
        beyond = self.arena.clearance + s.overshoot
        edge = self.arena.unsafe[push.unsafe, 1 if push.above else 0, i]
        height = edge - floor + beyond if push.above else ceiling - edge + beyond
        if height > ceiling - floor - float(self.arena.min_widths[i]) - 2 * math.log(4) / s.nu:
            return None
        middle, half = (push.begin + push.end) / 2, max((push.end - push.begin) / 2, t_c / 50)
        radius = min(half + s.ramp, middle, t_c - middle)
        if radius < half + s.ramp / 8:
            return None
        c = -math.log1p(-(s.overshoot - min(s.clearance, s.overshoot / 2)) / height)
        steepness = c * (radius * radius / (half * half) - 1)
        side = LOWER if push.above else UPPER
        m = _round_to_bits(middle)
        time_to_end = min(m, self.design.prescribed_time - m)  # the bump must not be alive at 0 or t_c
        r = min(_round_to_bits(radius), _round_to_bits(float(time_to_end) * (1 - 2.0**-BITS)))
        return Bump(
            dimension=i,
            side=side,
            height=_round_to_bits(height),
            steepness=_round_to_bits(steepness),
            middle=m,
            radius=r,
            unsafe=self.arena.names[push.unsafe],
        )

    def is_possible(self, push: Push) -> bool:
        return self.bump(push) is not None

    def edges(self, i: int, pushes: tuple[Push, ...]) -> Array:
        """Return gamma_L and gamma_U of dimension i on the grid, shape (2, N + 1), alpha stepped implicitly from 0."""
        d = self.design
        bumps = [b for b in map(self.bump, pushes) if b is not None]
        joined = []
        for side in (LOWER, UPPER):
            total = np.zeros(SEARCH_STEPS + 1)
            for b in bumps:
                if b.side == side:
                    shape = _grid_bump()(self.times[None], float(b.height), float(b.steepness), float(b.middle), float(b.radius))
                    total = np.array(_grid_join()(total[None], shape, float(d.nu))).ravel()
            joined.append(total)
        (a, b_), (c, e), (floor, ceiling) = d.start[i], d.target[i], d.walls[i]
        rho_low = float(a) + float(c - a) * self.profile
        rho_high = float(b_) + float(e - b_) * self.profile
        beta_low, beta_high = float(floor) + joined[LOWER], float(ceiling) - joined[UPPER]
        step = self.arena.prescribed_time / SEARCH_STEPS
        parameters = [float(v) for v in (d.theta0, d.kappa, d.mu, d.varsigma, d.nu)]
        _, edges = _grid_tube()(np.zeros(2), np.stack([rho_low, rho_high, beta_low, beta_high]), step, *parameters)
        result = np.array(edges)
        if not np.isfinite(result).all():
            result = np.stack([np.ones(SEARCH_STEPS + 1), np.zeros(SEARCH_STEPS + 1)])  # an empty tube, which the search rejects
        return result


@cache
def _grid_profile() -> ca.Function:
    t, t_c = ca.SX.sym("t"), ca.SX.sym("t_c")
    return ca.Function("profile", [t, t_c], [reach_tube.sigma(t, t_c)]).map("p", "serial", SEARCH_STEPS + 1, [1], [])


@cache
def _grid_bump() -> ca.Function:
    t, *shape = symbols = [ca.SX.sym(n) for n in ("t", "B", "k", "m", "r")]
    return ca.Function("bump", symbols, [bump(t, (*shape, ca.SX(float(CUT["double"]))))]).map(
        "b", "serial", SEARCH_STEPS + 1, [1, 2, 3, 4], []
    )


@cache
def _grid_join() -> ca.Function:
    a, b, nu = (ca.SX.sym(n) for n in ("a", "b", "nu"))
    return ca.Function("join", [a, b, nu], [smooth_join(a, b, nu)]).map("j", "serial", SEARCH_STEPS + 1, [2], [])


@cache
def _grid_tube() -> ca.Function:
    """Return the function that makes a tube on the grid, alpha accumulated from step to step.

    Its arguments are alpha (2) before, [rho_L, rho_U, beta_L, beta_U], the step and the parameters; it gives alpha (2) after and
    [gamma_L, gamma_U]. The first sample of the grid takes a step too, of the same length: alpha is then a step ahead, which errs
    to the wide side.
    """
    alpha, lines, step = ca.SX.sym("alpha", 2), ca.SX.sym("lines", 4), ca.SX.sym("step")
    theta0, kappa, mu, varsigma, nu = (ca.SX.sym(n) for n in ("theta0", "kappa", "mu", "varsigma", "nu"))
    rho_low, rho_high, beta_low, beta_high = ca.vertsplit(lines)
    after = [
        adaptive_tube.implicit_step(psi, alpha[k], step, (theta0, kappa, mu, varsigma))
        for k, psi in enumerate((beta_high - rho_low, rho_high - beta_low))
    ]
    low = smooth_max(rho_low - after[0], beta_low, nu)
    high = -smooth_max(-rho_high - after[1], -beta_high, nu)
    inputs = [alpha, lines, step, theta0, kappa, mu, varsigma, nu]
    grid_step = ca.Function("tube", inputs, [ca.vertcat(*after), ca.vertcat(low, high)])
    return grid_step.mapaccum("tube", SEARCH_STEPS + 1, [0], [0])
