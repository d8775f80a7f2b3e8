"""P1 to P7 for an adaptive or literal tube by enclosures: a proof for every t, with each cell of time as one ball.

    rho, beta, psi   ball arithmetic (Arb) over the kernels that are printed, roundings included
    alpha            two curves that hold for (11) and for every sequence of emitted steps (alpha_curves.py)
    gamma            (10) is monotone in rho, alpha and beta: its ends are its values at their ends, by Arb, widened by
                     the rounding of the printed kernel (rounding.py)
    gammadot         the steepest slope of each circumvent function by Arb, that of sigma, and a bound on alphadot

Time is cut so that no edge of rho or beta moves by more than a fraction of the tube's width in one cell. The proof holds for the
emitted arithmetic, in C and in Python. The lemmas `update.*` are about alpha.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen import reference
from stt_codegen.certify.adaptive.alpha_curves import Steps, extremes_ahead, lower_curve, upper_curve
from stt_codegen.certify.adaptive.finder import Finder, gap, lower_bound
from stt_codegen.certify.adaptive.lines import HIGH, LOW, LineBounds, ends
from stt_codegen.certify.adaptive.slopes import speed_bound
from stt_codegen.certify.certificate import Certificate, Finding
from stt_codegen.constraints import (
    initial_state_constraints,
    reach_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
    width_statement,
)
from stt_codegen.controller import lines_program
from stt_codegen.controller.kernels import alpha_cap
from stt_codegen.decimals import decimal
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, parameters_of
from stt_codegen.program import FORMATS, round_to
from stt_codegen.program.analyse import Enclosure, Inexact, ball, hull, rounding_error
from stt_codegen.properties import Property
from stt_codegen.sampling import Windows
from stt_codegen.task import Task

CELL_MOTION = 0.02  # of the narrowest start or target: the largest motion of an edge in one cell
CELL_COUNT_MINIMUM = 300
LADDER = ((2000, 1.0), (8000, 1.0), (8000, 0.4))  # t_c over the longest step, and the length of cells over the usual
STEP_RANGE = 16  # longest over shortest step
# Of the emitted theta, relative: 2 * 2 * 40 of the limited exponent, those of exp, sum and quotient, and some more.
THETA_ROUNDINGS = 256

Array = npt.NDArray[Any]
WINDOW_COUNT_LIMIT = 64  # of an enclosed tube, for the sampling conditions
OUT = 1 + 2.0**-48  # more than the few roundings of a product of doubles
BALL_WIDTH_LIMIT = 3  # times CELL_MOTION; where a ball of psi is wider, its cell is halved
HALVING_LIMIT = 3  # of a cell
NAMES = ("rho", "beta", "psi")
TINY = 2.0**-100


@dataclass(frozen=True)
class Enclosed:
    """Bounds over every cell on a tube's lines, alpha and gamma (arrays as in `LineBounds`), and the certificate from them."""

    lines: LineBounds
    alpha: Array
    gamma: Array
    certificate: Certificate


@dataclass(frozen=True, kw_only=True)
class _TubeBounds:
    """Bounds over every cell, and the rounding of the edges' kernel, from which the certificate follows."""

    lines: LineBounds
    alpha: Array
    gamma: Array
    error: Fraction
    steps: Steps


def certify_enclosed(task: Task, design: AdaptiveDesign) -> Certificate:
    """Certify P1 to P7 of an adaptive or literal tube in balls; every finding that holds, holds for all t."""
    return enclosed_tube(task, design).certificate


def enclosed_tube(task: Task, design: AdaptiveDesign) -> Enclosed:
    """Enclose a tube with finer and finer steps and cells, until all properties hold or the ladder ends."""
    program = lines_program(task, design)
    printed, exact = Enclosure(program, rounding=True), Enclosure(program, rounding=False)
    lines, finer = None, 0.0
    for division, fine in LADDER:
        if lines is None or fine != finer:
            lines, finer = enclose_lines(design, printed, fine), fine
        steps = steps_of(design, task.emit.scalar, division)
        alpha = enclose_alpha(design, exact, lines, steps)
        gamma, error = enclose_edges(task, design, exact, lines, alpha)
        bounds = _TubeBounds(lines=lines, alpha=alpha, gamma=gamma, error=error, steps=steps)
        enclosed = Enclosed(lines, alpha, gamma, _certificate(task, design, exact, bounds))
        if enclosed.certificate.holds:
            break
    return enclosed


def steps_of(design: AdaptiveDesign, scalar: str, division: int) -> Steps:
    """Return steps from t_c / (STEP_RANGE division) to t_c / division, as short decimals.

    Each begins where the last one ended, to within 4 units in the last place of t_c.
    """
    t_c, roundoff = float(design.prescribed_time), float(FORMATS[scalar].roundoff)
    shortest, longest = (Fraction(f"{t_c / division / share:.2g}") for share in (STEP_RANGE, 1))
    return Steps(shortest, longest, 8 * roundoff * t_c, roundoff)


# ------------------------------------------------------------------------------------- rho, beta, psi, alpha


def cells_of(design: AdaptiveDesign, fine: float) -> Array:
    """Return cell boundaries from 0 to t_c, close where rho or beta move fast; on a grid of t_c / 2**24."""
    p = parameters_of(design)
    grid = np.linspace(0.0, 1.0, 8193)
    now = reference.lines(p, grid * float(design.prescribed_time))
    moved = np.maximum(np.abs(np.diff(now.rho, axis=0)), np.abs(np.diff(now.beta, axis=0))).max(axis=(1, 2)).astype(float)
    share = moved / (CELL_MOTION * fine * _narrowest(design)) + CELL_COUNT_MINIMUM / fine / len(moved)
    total = np.concatenate([[0.0], np.cumsum(share)])
    cuts = np.interp(np.linspace(0.0, total[-1], math.ceil(total[-1]) + 1), total, grid)
    fine_cuts = np.rint(np.append(cuts, 2.0**-20) * 2**24)  # a short first cell, because P2 is about gamma(0)
    return np.unique(fine_cuts) / 2**24 * float(design.prescribed_time)


def _narrowest(design: AdaptiveDesign) -> float:
    return min(float(b - a) for edges in (design.start, design.target) for a, b in edges)


def enclose_lines(design: AdaptiveDesign, printed: Enclosure, fine: float) -> LineBounds:
    """Return bounds on rho, beta and psi over every cell, for the emitted arithmetic and every t within rounding of the cell."""
    times = cells_of(design, fine)
    late = float(design.prescribed_time) * 8 * float(FORMATS[printed.program.scalar].roundoff)
    width_limit = BALL_WIDTH_LIMIT * CELL_MOTION * fine * _narrowest(design)
    cells = [_lines_in(printed, max(a - late, 0.0), b + late, width_limit) for a, b in itertools.pairwise(times.tolist())]
    cells.append(_lines_in(printed, times[-1] - late, times[-1] + late, width_limit))
    n = design.dimension
    parts = np.array(cells).reshape(len(cells), len(NAMES), 2, n, 2).transpose(1, 0, 3, 2, 4)
    return LineBounds(times, *parts)


def _lines_in(printed: Enclosure, begin: float, end: float, width_limit: float, depth: int = 0) -> Array:
    """Return the ends of rho, beta and psi over one cell, shape (3 * 2n, 2).

    The cell is halved where balls are wider than width_limit, for example where bumps are joined.
    """
    balls = printed.run("lines", t=hull(begin, end))[0]
    bounds = np.array([ends(value) for name in NAMES for value in balls[name]])
    if depth < HALVING_LIMIT and not (bounds[:, HIGH] - bounds[:, LOW]).max() < width_limit:
        middle = (begin + end) / 2
        halves = tuple(_lines_in(printed, a, b, width_limit, depth + 1) for a, b in ((begin, middle), (middle, end)))
        return np.stack([np.minimum(*halves)[:, LOW], np.maximum(*halves)[:, HIGH]], axis=1)
    return bounds


def enclose_alpha(design: AdaptiveDesign, exact: Enclosure, lines: LineBounds, steps: Steps) -> Array:
    """Return bounds on alpha over every cell, and last for all later times: shape (N + 1, n, 2, 2)."""
    result = np.zeros(lines.psi.shape)
    low, high = (
        np.concatenate(
            [extremes_ahead(lines.times, lines.psi[:-1, :, :, end], steps.reach, end == HIGH), lines.psi[-1:, :, :, end]]
        )
        for end in (LOW, HIGH)
    )
    scalar = exact.program.scalar
    constants = [ball(round_to(v, scalar)) for v in (design.theta0, design.mu, design.varsigma)]
    spread = THETA_ROUNDINGS * steps.roundoff
    times, kappa = lines.times.tolist(), float(round_to(design.kappa, scalar))

    @cache
    def theta(psi: float) -> tuple[float, float]:
        if not math.isfinite(psi):
            return (0.0, 2 * float(design.theta0) * (1 + spread))
        return ends(exact.kernel("theta", ball(psi), *constants)[0])

    for i, side in np.ndindex(*result.shape[1:3]):
        low_psi, high_psi = low[:, i, side].tolist(), high[:, i, side].tolist()
        strong = [theta(v)[HIGH] * (1 + spread) for v in low_psi]
        weak = [theta(v)[LOW] * (1 - spread) for v in high_psi]
        # the curves allow for relative roundings, and TINY for the underflow of theta, q and alpha
        result[:, i, side, HIGH] = np.array(upper_curve(times, low_psi, strong, kappa, steps)) + TINY * _narrowest(design)
        result[:, i, side, LOW] = np.maximum(
            np.array(lower_curve(times, high_psi, weak, kappa, steps)) - TINY * _narrowest(design), 0
        )
    return result


# --------------------------------------------------------------------------------------------------- gamma


def enclose_edges(
    task: Task, design: AdaptiveDesign, exact: Enclosure, lines: LineBounds, alpha: Array
) -> tuple[Array, Fraction]:
    """Return gamma over every cell as the emitted `tube` computes it, shape (N + 1, n, 2, 2), and the rounding of its kernel.

    gamma_L rises with rho and beta and falls with alpha_L, gamma_U rises with all three (weights in [0, 1]).
    """
    error = edge_rounding(task, design, exact)
    spread = math.nextafter(float(error), math.inf)
    nu = ball(round_to(design.nu, exact.program.scalar))
    result = np.empty(alpha.shape)
    for name, side in (("lower_edge", LOWER), ("upper_edge", UPPER)):
        for end, widen in ((LOW, -1), (HIGH, 1)):
            a = alpha[:, :, side, HIGH - end if side == LOWER else end]
            rows = zip(lines.rho[:, :, side, end].flat, a.flat, lines.beta[:, :, side, end].flat, strict=True)
            values = [ends(exact.kernel(name, arb(r), arb(v), arb(b), nu)[0])[end] for r, v, b in rows]
            result[:, :, side, end] = np.nextafter(np.reshape(values, a.shape) + widen * spread, widen * np.inf)
    return np.where(np.isnan(result), np.array([-np.inf, np.inf]), result), error


def edge_rounding(task: Task, design: AdaptiveDesign, exact: Enclosure) -> Fraction:
    """Bound the distance of an edge's emitted kernel from (10) for the same rho, alpha and beta, in the task's units."""
    size = max(abs(v) for edge in (*design.start, *design.target, *design.walls) for v in edge)
    size += max((b.height for b in design.bumps), default=Fraction(0)) * 2
    size *= 1 + 8 * FORMATS[task.emit.scalar].roundoff  # rho and beta are rounded themselves
    line, nu = Inexact(-size, size), round_to(design.nu, task.emit.scalar)
    inputs = {"rho": line, "alpha": Inexact(Fraction(0), alpha_cap(design)), "beta": line, "nu": Inexact(nu, nu)}
    kernels = (exact.program.kernel(name) for name in ("lower_edge", "upper_edge"))
    return max(rounding_error(kernel, inputs, task.emit.scalar)[0].error for kernel in kernels)


# ------------------------------------------------------------------------------------------------ findings


def _certificate(task: Task, design: AdaptiveDesign, exact: Enclosure, bounds: _TubeBounds) -> Certificate:
    """Return the certificate of an enclosed tube; a margin may be smaller than the true one, never larger."""
    gamma, steps = bounds.gamma, bounds.steps
    speed = tuple(-lower_bound(-v) for v in speed_bound(task, design, exact, bounds.lines, bounds.alpha))
    finder = Finder(task, bounds.lines.times, gamma)
    width = gap(gamma[:, :, LOWER, HIGH], gamma[:, :, UPPER, LOW])
    inside, within = "x(0) inside gamma(0)", "gamma(0) within the initial set"
    begin, end = slice(0, 1), slice(-1, None)
    return Certificate(
        findings=(
            finder.finding(width_constraints(task), Property.WIDTH, width_statement(task)),
            finder.finding(initial_state_constraints(task), Property.START, inside, cells=begin, advice=Property.START.advice),
            finder.finding(start_constraints(task), Property.START, within, cells=begin),
            finder.finding(stay_constraints(task), Property.STAY, "gamma within the state space"),
            finder.avoid(),
            finder.finding(reach_constraints(task), Property.REACH, "gamma(t_c) within the target set", cells=end),
            finder.smooth(speed),
            Finding(Property.ARITHMETIC, _arithmetic_statement(task, steps), Fraction(0), Fraction(0)),
        ),
        edge_error=(bounds.error,) * task.dimension,
        speed=speed,
        minimum_width=lower_bound(width.min()),
        start=tuple(
            (lower_bound(a), lower_bound(b)) for a, b in zip(gamma[0, :, LOWER, HIGH], gamma[0, :, UPPER, LOW], strict=True)
        ),
        covers_initial_set=False,
        method="enclosure",
        steps=(steps.shortest, steps.longest),
    )


def _arithmetic_statement(task: Task, steps: Steps) -> str:
    """Return the statement of P7, with the steps of alpha that it is proved for."""
    return (
        f"{task.emit.scalar} arithmetic is within the enclosures; "
        f"alpha_step with dt from {decimal(steps.shortest)} to {decimal(steps.longest)} s, without gaps from t = 0 on"
    )


# ------------------------------------------------------------------------------------------- time windows


def enclosed_windows(tube: Enclosed) -> Windows:
    """Return the tube in WINDOW_COUNT_LIMIT time windows, or as many as it has cells, for the sampling conditions."""
    times, gamma = tube.lines.times, tube.gamma
    count = len(times) - 1
    cuts = np.unique(np.linspace(0, count, min(WINDOW_COUNT_LIMIT, count) + 1).astype(int))
    groups = [slice(a, b) for a, b in itertools.pairwise(cuts)] + [slice(count, count + 1)]
    low, high = gamma[:, :, LOWER], gamma[:, :, UPPER]  # (N + 1, n, 2 ends)
    speed = np.tile([float(v) * OUT for v in tube.certificate.speed], (len(groups), 1))
    return Windows(
        times=times[cuts],
        narrow=np.array([np.nextafter(high[g, :, 0] - low[g, :, 1], -np.inf).min(axis=0) for g in groups]),
        wide=np.array([np.nextafter(high[g, :, 1] - low[g, :, 0], np.inf).max(axis=0) for g in groups]),
        speed=speed,
        widening=2 * speed,
        low=np.array([low[g, :, 0].min(axis=0) for g in groups]),
        high=np.array([high[g, :, 1].max(axis=0) for g in groups]),
        start=np.stack([low[0, :, 1], high[0, :, 0]], axis=-1),
    )
