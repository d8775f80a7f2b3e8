"""P6 for an adaptive or literal tube: a bound on the speed of its edges, from the steepest slope of every circumvent function.

The slopes are enclosed by Arb; the docstring of `speed_bound` has the mathematics.
"""

from __future__ import annotations

import heapq
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.certify.adaptive.lines import HIGH, LOW, LineBounds, ends
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, Bump
from stt_codegen.paper.circumvent import CUT
from stt_codegen.program.analyse import Enclosure, ball, hull
from stt_codegen.task import Task

Array = npt.NDArray[Any]
SLOPE_TOLERANCE = 1.05  # a bound on a slope over the steepest slope that was seen
PIECE_COUNT_LIMIT = 400  # of the half of a circumvent function
SIGMA_RATE = 1.83489  # above the maximum of t_c sigmadot (design of (4))


def speed_bound(task: Task, design: AdaptiveDesign, exact: Enclosure, lines: LineBounds, alpha: Array) -> Array:
    """Return a bound on |gammadot| along (11) by dimension, shape (n,).

    gamma's weights lie in [0, 1], so |gammadot| <= max(|rhodot| + |alphadot|, |betadot|). With a = alphadot,
    adot = F_psi psidot + F_alpha a and both derivatives negative: |a| <= max(|a(0)|, sup |F_psi / F_alpha| sup |psidot|).
    The bound is valid where P1 holds, because then psi + alpha is above MINIMUM_WIDTH, and so above the floors of the emitted
    divisions.
    """
    t_c, kappa = float(design.prescribed_time), float(design.kappa)
    theta0, sharp, mu = float(design.theta0), float(design.varsigma), float(design.mu)
    bounds = []
    for i in range(design.dimension):
        rho_rate = [abs(float(design.target[i][s] - design.start[i][s])) * SIGMA_RATE / t_c for s in (LOWER, UPPER)]
        beta_rate = [_beta_rate(task, design, exact, i, s) for s in (LOWER, UPPER)]
        fastest = 0.0
        for side in (LOWER, UPPER):
            psi, a = lines.psi[:, i, side], alpha[:, i, side]
            z_min, z_max = np.maximum(psi[:, LOW] + a[:, LOW], 1e-9), psi[:, HIGH] + a[:, HIGH]  # z = psi + alpha
            # upper bounds on theta/(2 theta0), and on its distance from 1
            share, rest = (
                1 / (1 + np.exp(np.clip(s * 2 * sharp * (psi[:, e] - mu), -700, 700))) for s, e in ((1, LOW), (-1, HIGH))
            )
            force = 2 * theta0 * share
            # |F_psi| z^3 = 2 theta + |theta'| z, |theta'| = 2 varsigma theta (1 - share); |F_alpha| z^3 = 2 theta + kappa z^3;
            # the quotient rises with theta
            ratio = (2 * force + 2 * sharp * force * rest * z_max) / (2 * force + kappa * z_min**3)
            first = force[0] / z_min[0] ** 2
            alpha_rate = np.max([first, ratio.max() * (rho_rate[side] + beta_rate[1 - side])])  # np.max keeps a NaN
            fastest = float(np.max([fastest, rho_rate[side] + alpha_rate, beta_rate[side]]))
        bounds.append(fastest * (1 + 1e-9))
    return np.array(bounds)


def _beta_rate(task: Task, design: AdaptiveDesign, exact: Enclosure, i: int, side: int) -> float:
    """Return a bound on |betadot|: the steepest slopes of all circumvent functions that are active at one time, added up.

    Joining weights each of them by at most 1.
    """
    slopes = [
        (float(b.middle - b.radius), float(b.middle + b.radius), steepest_slope(b, task.emit.scalar, exact))
        for b in design.bumps_on(i, side)
    ]
    return max((sum(s for c, d, s in slopes if c <= a <= d) for a, _, _ in slopes), default=0.0)


def steepest_slope(bump: Bump, scalar: str, exact: Enclosure) -> float:
    """Return a bound on the slope of a circumvent function, within SLOPE_TOLERANCE of the steepest.

    Pieces of its half are halved, the steepest first.
    """
    shape = [ball(v) for v in (bump.height, bump.steepness, Fraction(0), bump.radius, CUT[scalar])]

    def bound(low: float, high: float) -> tuple[float, float, float]:
        return -max(map(abs, ends(exact.kernel("circumvent_rate", hull(low, high), *shape)[1]))), low, high

    pieces, steepest = [bound(0.0, float(bump.radius))], 0.0
    for _ in range(PIECE_COUNT_LIMIT):
        worst, low, high = pieces[0]
        middle = (low + high) / 2
        steepest = max(steepest, abs(float(exact.kernel("circumvent_rate", arb(middle), *shape)[1])))
        if -worst <= SLOPE_TOLERANCE * steepest:
            break
        heapq.heapreplace(pieces, bound(low, middle))
        heapq.heappush(pieces, bound(middle, high))
    return -pieces[0][0]
