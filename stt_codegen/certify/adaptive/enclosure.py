"""P1 to P7 for an adaptive or literal tube by enclosures: a proof for every t, every cell of time being one ball.

    rho, beta, psi   ball arithmetic (Arb) over the kernels that are printed, roundings included
    alpha            two curves that hold for (11) and for every sequence of emitted steps (alpha_curves.py)
    gamma            (10) is monotone in rho, alpha and beta: its ends are its values at theirs, by Arb, and widened by
                     the rounding of the printed kernel (rounding.py)
    gammadot         the steepest slope of each circumvent function by Arb, that of sigma, and a bound on alphadot

Time is cut so that no edge of rho or beta moves by more than a fraction of the tube's width in one cell. What is proved holds
for the emitted arithmetic, in C and in Python.
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
from stt_codegen.certify.adaptive.alpha_curves import Steps, ahead, lower_curve, upper_curve
from stt_codegen.certify.adaptive.finder import Finder, gap, lower_bound
from stt_codegen.certify.adaptive.lines import HIGH, LOW, Lines, ends
from stt_codegen.certify.adaptive.slopes import speed_bound
from stt_codegen.certify.certificate import Certificate, Finding
from stt_codegen.constraints import (
    initial_state_constraints,
    minimum_width,
    reach_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.controller import lines_program
from stt_codegen.controller.kernels import alpha_cap
from stt_codegen.decimals import above, by_component, decimal
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, parameters_of
from stt_codegen.program import FORMATS, round_to
from stt_codegen.program.analyse import Enclosure, Inexact, ball, hull, rounding_error
from stt_codegen.properties import Property
from stt_codegen.sampling import Windows
from stt_codegen.task import Task

MOVE = 0.02  # of the narrowest start or target: how far an edge may move in one cell
CELLS = 300  # at least, however slow the tube is
LADDER = ((2000, 1.0), (8000, 1.0), (8000, 0.4))  # t_c over the longest step, and how much finer the cells
STEP_RANGE = 16  # longest over shortest step
THETA_ROUNDINGS = 256  # relative, of the emitted theta: 2 * 2 * 40 of the held exponent, those of exp, sum, quotient, and room

Array = npt.NDArray[Any]
WINDOWS = 64  # of an enclosed tube, for the sampled statements
OUT = 1 + 2.0**-48  # more than the few roundings of a product of doubles
COARSE, HALVINGS = 3, 3  # how many times wider than MOVE a ball of psi may be, and how often its cell is halved for that
NAMES = ("rho", "beta", "psi")
TINY = 2.0**-100


@dataclass(frozen=True)
class Enclosed:
    """What is known of a tube on one rung of the ladder: bounds over every cell on its lines, alpha and gamma (arrays as in
    `Lines`), and the certificate that they make."""

    lines: Lines
    alpha: Array
    gamma: Array
    certificate: Certificate


def certify_enclosed(task: Task, design: AdaptiveDesign) -> Certificate:
    """Prove P1 to P7 of an adaptive or literal tube in balls: every finding that holds, holds for all t."""
    return enclosed_tube(task, design).certificate


def enclosed_tube(task: Task, design: AdaptiveDesign) -> Enclosed:
    """The first rung of the ladder on which all properties hold, or the last."""
    program = lines_program(task, design)
    printed, exact = Enclosure(program, rounding=True), Enclosure(program, rounding=False)
    lines, finer = None, 0.0
    for division, fine in LADDER:
        if lines is None or fine != finer:
            lines, finer = enclose_lines(design, printed, fine), fine
        steps = steps_of(design, task.emit.scalar, division)
        alpha = enclose_alpha(design, exact, lines, steps)
        gamma, error = enclose_edges(task, design, exact, lines, alpha)
        found = Enclosed(lines, alpha, gamma, _certificate(task, design, exact, lines, alpha, (gamma, error), steps))
        if found.certificate.holds:
            break
    return found


def steps_of(design: AdaptiveDesign, scalar: str, division: int) -> Steps:
    """Steps from t_c / (16 division) to t_c / division, as short decimals. Each begins where the last one ended, to within 4
    units in the last place of t_c."""
    t_c, roundoff = float(design.prescribed_time), float(FORMATS[scalar].roundoff)
    shortest, longest = (Fraction(f"{t_c / division / share:.2g}") for share in (STEP_RANGE, 1))
    return Steps(shortest, longest, 8 * roundoff * t_c, roundoff)


# ------------------------------------------------------------------------------------- rho, beta, psi, alpha


def cells_of(design: AdaptiveDesign, fine: float) -> Array:
    """Cell boundaries from 0 to t_c, close where rho or beta move fast; on a grid of t_c / 2**24."""
    p = parameters_of(design)
    grid = np.linspace(0.0, 1.0, 8193)
    now = reference.lines(p, grid * float(design.prescribed_time))
    moved = np.maximum(np.abs(np.diff(now.rho, axis=0)), np.abs(np.diff(now.beta, axis=0))).max(axis=(1, 2)).astype(float)
    share = moved / (MOVE * fine * _narrowest(design)) + CELLS / fine / len(moved)
    total = np.concatenate([[0.0], np.cumsum(share)])
    cuts = np.interp(np.linspace(0.0, total[-1], math.ceil(total[-1]) + 1), total, grid)
    fine_cuts = np.rint(np.append(cuts, 2.0**-20) * 2**24)  # a short first cell, so that P2 speaks about gamma(0)
    return np.unique(fine_cuts) / 2**24 * float(design.prescribed_time)


def _narrowest(design: AdaptiveDesign) -> float:
    return min(float(b - a) for edges in (design.start, design.target) for a, b in edges)


def enclose_lines(design: AdaptiveDesign, printed: Enclosure, fine: float) -> Lines:
    """rho, beta and psi over every cell, for the emitted arithmetic and every t within rounding of the cell."""
    times = cells_of(design, fine)
    late = float(design.prescribed_time) * 8 * float(FORMATS[printed.program.scalar].roundoff)
    coarse = COARSE * MOVE * fine * _narrowest(design)
    found = [_lines_in(printed, max(a - late, 0.0), b + late, coarse) for a, b in itertools.pairwise(times.tolist())]
    found.append(_lines_in(printed, times[-1] - late, times[-1] + late, coarse))
    n = design.dimension
    parts = np.array(found).reshape(len(found), len(NAMES), 2, n, 2).transpose(1, 0, 3, 2, 4)
    return Lines(times, *parts)


def _lines_in(printed: Enclosure, begin: float, end: float, coarse: float, depth: int = 0) -> Array:
    """Ends of rho, beta and psi over one cell, shape (3 * 2n, 2); halved where the balls are wider than `coarse`, as where
    bumps are joined."""
    found = printed.run("lines", t=hull(begin, end))[0]
    bounds = np.array([ends(value) for name in NAMES for value in found[name]])
    if depth < HALVINGS and not (bounds[:, HIGH] - bounds[:, LOW]).max() < coarse:
        middle = (begin + end) / 2
        halves = _lines_in(printed, begin, middle, coarse, depth + 1), _lines_in(printed, middle, end, coarse, depth + 1)
        return np.stack([np.minimum(*halves)[:, LOW], np.maximum(*halves)[:, HIGH]], axis=1)
    return bounds


def enclose_alpha(design: AdaptiveDesign, exact: Enclosure, lines: Lines, steps: Steps) -> Array:
    """Bounds on alpha over every cell, and last for all later times: shape (N + 1, n, 2, 2)."""
    result = np.zeros(lines.psi.shape)
    least = np.concatenate([ahead(lines.times, lines.psi[:-1, :, :, LOW], steps.reach, False), lines.psi[-1:, :, :, LOW]])
    most = np.concatenate([ahead(lines.times, lines.psi[:-1, :, :, HIGH], steps.reach, True), lines.psi[-1:, :, :, HIGH]])
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
        low_psi, high_psi = least[:, i, side].tolist(), most[:, i, side].tolist()
        strong = [theta(v)[HIGH] * (1 + spread) for v in low_psi]
        weak = [theta(v)[LOW] * (1 - spread) for v in high_psi]
        # the curves allow for relative roundings; TINY for what is lost where theta, q and alpha underflow
        result[:, i, side, HIGH] = np.array(upper_curve(times, low_psi, strong, kappa, steps)) + TINY * _narrowest(design)
        result[:, i, side, LOW] = np.maximum(
            np.array(lower_curve(times, high_psi, weak, kappa, steps)) - TINY * _narrowest(design), 0
        )
    return result


# --------------------------------------------------------------------------------------------------- gamma


def enclose_edges(task: Task, design: AdaptiveDesign, exact: Enclosure, lines: Lines, alpha: Array) -> tuple[Array, Fraction]:
    """gamma over every cell as the emitted `tube` gives it, shape (N + 1, n, 2, 2), and the rounding of its kernel.

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
    """How far the emitted kernel of an edge may be from (10) for the same rho, alpha and beta, in the task's units."""
    size = max(abs(v) for edge in (*design.start, *design.target, *design.walls) for v in edge)
    size += max((b.height for b in design.bumps), default=Fraction(0)) * 2
    size *= 1 + 8 * FORMATS[task.emit.scalar].roundoff  # rho and beta are rounded themselves
    line, nu = Inexact(-size, size), round_to(design.nu, task.emit.scalar)
    inputs = {"rho": line, "alpha": Inexact(Fraction(0), alpha_cap(design)), "beta": line, "nu": Inexact(nu, nu)}
    kernels = (exact.program.kernel(name) for name in ("lower_edge", "upper_edge"))
    return max(rounding_error(kernel, inputs, task.emit.scalar)[0].error for kernel in kernels)


# ------------------------------------------------------------------------------------------------ findings


def _certificate(
    task: Task, design: AdaptiveDesign, exact: Enclosure, lines: Lines, alpha: Array, edges: tuple[Array, Fraction], steps: Steps
) -> Certificate:
    gamma, error = edges
    speed = tuple(-lower_bound(-v) for v in speed_bound(task, design, exact, lines, alpha))
    find = Finder(task, lines.times, gamma)
    width = gap(gamma[:, :, LOWER, HIGH], gamma[:, :, UPPER, LOW])
    least = minimum_width(task)
    always, begin, end = slice(None), slice(0, 1), slice(-1, None)
    limit, fastest = task.max_speed, ", ".join(f"{above(v, 4):g}" for v in speed)
    seventh = (
        f"{task.emit.scalar} arithmetic is within the enclosures; "
        f"alpha_step with dt from {decimal(steps.shortest)} to {decimal(steps.longest)} s, without gaps from t = 0 on"
    )
    return Certificate(
        findings=(
            find.least(width_constraints(task), always, Property.WIDTH, f"width >= {decimal(least)} in every dimension"),
            find.least(initial_state_constraints(task), begin, Property.START, "x(0) inside gamma(0)", Property.START.advice),
            find.least(start_constraints(task), begin, Property.START, "gamma(0) within the initial set"),
            find.least(stay_constraints(task), always, Property.STAY, "gamma within the state space"),
            find.avoid(),
            find.least(reach_constraints(task), end, Property.REACH, "gamma(t_c) within the target set"),
            Finding(
                Property.SMOOTH, f"gamma is continuous, C1 up to t_c; |gammadot| <= {fastest}",
                Fraction(0) if limit is None else min(m - v for m, v in zip(limit, speed, strict=True)), Fraction(0),
                advice=f"raise tube.max_speed to {by_component([above(v, 4) for v in speed])}, or use a refined tube: the "
                "bound is not sharp here",
            ),
            Finding(Property.ARITHMETIC, seventh, Fraction(0), Fraction(0)),
        ),
        edge_error=(error,) * task.dimension,
        speed=speed,
        least_width=lower_bound(width.min()),
        start=tuple((lower_bound(a), lower_bound(b)) for a, b in zip(gamma[0, :, LOWER, HIGH], gamma[0, :, UPPER, LOW],
        strict=True)), whole_start=False, method="enclosure", steps=(steps.shortest, steps.longest),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------- time windows


def enclosed_windows(tube: Enclosed) -> Windows:
    """The tube in WINDOWS time windows, or as many as it has cells, for the sampled statements."""
    times, gamma = tube.lines.times, tube.gamma
    count = len(times) - 1
    cuts = np.unique(np.linspace(0, count, min(WINDOWS, count) + 1).astype(int))
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
