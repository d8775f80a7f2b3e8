"""The literal design: the paper's rule, with arithmetic that works, so that it can be compared. It is not sound.

Dimension by (6): of the dimension whose window opens last and the one whose window closes first, the one with the shorter
window. Side at random, unless the unsafe set touches a wall. Window of the bump: exactly the conflict (5).
"""

from __future__ import annotations

import math
import random
from fractions import Fraction

from stt_codegen.design.paper_tubes.conflict_windows import conflict_in_sigma, time_of_sigma
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, Bump
from stt_codegen.task import Task

# The case study's numbers (section V); nu, varsigma are not in the paper. k is printed without its index j.
OVERSHOOT, STEEPNESS = Fraction("0.2"), Fraction("0.01")
THETA0, KAPPA, MU, VARSIGMA, NU = Fraction("0.01"), Fraction(5), Fraction(1), Fraction(100), Fraction(100)
BITS = 20  # significant bits of times


def literal(task: Task) -> AdaptiveDesign:
    """The tube that (2)-(11) give as printed: X0hat = X0, That = T, sides drawn with the task's seed."""
    options = task.tube.adaptive
    space = task.free_space
    t_c = task.prescribed_time
    start = tuple(zip(task.start.lower, task.start.upper, strict=True))
    target = tuple(zip(task.target.lower, task.target.upper, strict=True))
    walls = tuple(zip(space.lower, space.upper, strict=True))
    overshoot = options.overshoot or OVERSHOOT
    draw = random.Random(task.tube.seed)
    bumps = []
    for unsafe in task.obstacles:
        sides = tuple(unsafe.span(i) for i in range(task.dimension))
        windows = [conflict_in_sigma(start[i], target[i], sides[i]) for i in range(task.dimension)]
        upward = draw.random() < 0.5  # drawn for every set, so that one set does not shift the luck of the next
        times = [(time_of_sigma(w[0], t_c), time_of_sigma(w[1], t_c)) for w in windows if w is not None]
        if len(times) < task.dimension:
            continue
        opens, closes = max(a for a, _ in times), min(b for _, b in times)
        if opens >= closes:
            continue
        last, first = [a for a, _ in times].index(opens), [b for _, b in times].index(closes)
        i = min((last, first), key=lambda k: times[k][1] - times[k][0])
        (low, high), (floor, ceiling) = sides[i], walls[i]
        if low <= floor:
            upward = True
        elif high >= ceiling:
            upward = False
        height = high - floor + overshoot if upward else ceiling - low + overshoot
        bumps.append(
            Bump(
                dimension=i, side=LOWER if upward else UPPER, height=height, steepness=options.bump_steepness or STEEPNESS,
                middle=_short((opens + closes) / 2), radius=_short((closes - opens) / 2), unsafe=unsafe.name,
            )
        )  # fmt: skip
    return AdaptiveDesign(
        kind="literal", prescribed_time=t_c, start=start, target=target, walls=walls, bumps=tuple(bumps),
        theta0=options.theta0 or THETA0, kappa=options.kappa or KAPPA, mu=options.mu or MU, varsigma=options.varsigma or VARSIGMA,
        nu=options.nu or NU, seed=task.tube.seed,
    )  # fmt: skip


def _short(seconds: float) -> Fraction:
    """A time to BITS significant bits, exact in float."""
    mantissa, exponent = math.frexp(seconds)
    return Fraction(round(mantissa * 2**BITS)) * Fraction(2) ** (exponent - BITS)
