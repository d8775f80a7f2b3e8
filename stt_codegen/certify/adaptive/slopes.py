"""P6 for an adaptive or literal tube: a bound on the speed of its edges, from the steepest slope of every circumvent function
by Arb."""

from __future__ import annotations

import heapq
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.certify.adaptive.lines import HIGH, LOW, Lines, ends
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, Bump
from stt_codegen.paper.circumvent import CUT
from stt_codegen.program.analyse import Enclosure, ball, hull
from stt_codegen.task import Task

Array = npt.NDArray[Any]
SHARP, PIECES = 1.05, 400  # how near the bound on a slope comes to the steepest slope, and pieces at most
SIGMA_RATE = 1.83489  # above the maximum of t_c sigmadot (design of (4))


def speed_bound(task: Task, design: AdaptiveDesign, exact: Enclosure, lines: Lines, alpha: Array) -> Array:
    """A bound on |gammadot| along (11) by dimension, shape (n,).

    gamma's weights lie in [0, 1], so |gammadot| <= max(|rhodot| + |alphadot|, |betadot|). With a = alphadot,
    adot = F_psi psidot + F_alpha a and both derivatives negative: |a| <= max(|a(0)|, sup |F_psi / F_alpha| sup |psidot|).
    It holds where P1 does, which keeps psi + alpha above MINIMUM_WIDTH, and so above the floors of the emitted divisions.
    """
    t_c, kappa = float(design.prescribed_time), float(design.kappa)
    theta0, sharp, mu = float(design.theta0), float(design.varsigma), float(design.mu)
    bounds = []
    for i in range(design.dimension):
        reach = [abs(float(design.target[i][s] - design.start[i][s])) * SIGMA_RATE / t_c for s in (LOWER, UPPER)]
        rise = [_beta_rate(task, design, exact, i, s) for s in (LOWER, UPPER)]
        fastest = 0.0
        for side in (LOWER, UPPER):
            psi, a = lines.psi[:, i, side], alpha[:, i, side]
            least, most = np.maximum(psi[:, LOW] + a[:, LOW], 1e-9), psi[:, HIGH] + a[:, HIGH]  # of z = psi + alpha
            # theta/(2 theta0) at most, and at most how far from 1 it is
            share, rest = (
                1 / (1 + np.exp(np.clip(s * 2 * sharp * (psi[:, e] - mu), -700, 700))) for s, e in ((1, LOW), (-1, HIGH))
            )
            force = 2 * theta0 * share
            # |F_psi| z^3 = 2 theta + |theta'| z, |theta'| = 2 varsigma theta (1 - share); |F_alpha| z^3 = 2 theta + kappa z^3;
            # the quotient rises with theta
            ratio = (2 * force + 2 * sharp * force * rest * most) / (2 * force + kappa * least**3)
            first = force[0] / least[0] ** 2
            moving = np.max([first, ratio.max() * (reach[side] + rise[1 - side])])  # NumPy's: a NaN stays
            fastest = float(np.max([fastest, reach[side] + moving, rise[side]]))
        bounds.append(fastest * (1 + 1e-9))
    return np.array(bounds)


def _beta_rate(task: Task, design: AdaptiveDesign, exact: Enclosure, i: int, side: int) -> float:
    """A bound on |betadot|: the steepest slope of each circumvent function, summed over those alive at one time (joining
    weights each by at most 1)."""
    slopes = [
        (float(b.middle - b.radius), float(b.middle + b.radius), steepest_slope(b, task.emit.scalar, exact))
        for b in design.bumps_on(i, side)
    ]
    return max((sum(s for c, d, s in slopes if c <= a <= d) for a, _, _ in slopes), default=0.0)


def steepest_slope(bump: Bump, scalar: str, exact: Enclosure) -> float:
    """A bound on the slope of a circumvent function, at most SHARP above the steepest: pieces of its half are halved, the
    steepest first."""
    shape = [ball(v) for v in (bump.height, bump.steepness, Fraction(0), bump.radius, CUT[scalar])]

    def bound(low: float, high: float) -> tuple[float, float, float]:
        return -max(map(abs, ends(exact.kernel("circumvent_rate", hull(low, high), *shape)[1]))), low, high

    pieces, met = [bound(0.0, float(bump.radius))], 0.0
    for _ in range(PIECES):
        worst, low, high = pieces[0]
        middle = (low + high) / 2
        met = max(met, abs(float(exact.kernel("circumvent_rate", arb(middle), *shape)[1])))
        if -worst <= SHARP * met:
            break
        heapq.heapreplace(pieces, bound(low, middle))
        heapq.heappush(pieces, bound(middle, high))
    return -pieces[0][0]
