"""The literal design: the paper's rule, with arithmetic that works, so that it can be compared. It is not sound.

Dimension by (6): of the dimension whose window opens last and the one whose window closes first, the one with the shorter
window. Side at random, unless the unsafe set touches a wall. Window of the bump: exactly the conflict (5).
"""

from __future__ import annotations

import math
import random
from fractions import Fraction
from typing import NamedTuple

from stt_codegen.design.paper_tubes.conflict_windows import conflict_in_sigma, time_of_sigma
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, Bump, Edge
from stt_codegen.task import Task

# The case study's numbers (section V); nu, varsigma are not in the paper. k is printed without its index j.
OVERSHOOT, STEEPNESS = Fraction("0.2"), Fraction("0.01")
THETA0, KAPPA, MU, VARSIGMA, NU = Fraction("0.01"), Fraction(5), Fraction(1), Fraction(100), Fraction(100)
BITS = 20  # significant bits of times


def design_literal(task: Task) -> AdaptiveDesign:
    """Return the tube that (2)-(11) give as printed: X0hat = X0, That = T, sides drawn with the task's seed."""
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
        is_upward = draw.random() < 0.5  # drawn for every set, so that one set does not shift the draws of the next
        conflict = _conflict_of(start, target, sides, t_c)
        if conflict is None:
            continue
        i = conflict.dimension
        (low, high), (floor, ceiling) = sides[i], walls[i]
        if low <= floor:
            is_upward = True
        elif high >= ceiling:
            is_upward = False
        height = high - floor + overshoot if is_upward else ceiling - low + overshoot
        bumps.append(
            Bump(
                dimension=i, side=LOWER if is_upward else UPPER, height=height, steepness=options.bump_steepness or STEEPNESS,
                middle=_round_time((conflict.opens + conflict.closes) / 2), radius=_round_time((conflict.closes - conflict.opens)
                / 2), unsafe=unsafe.name,
            )
        )  # fmt: skip
    return AdaptiveDesign(
        kind="literal", prescribed_time=t_c, start=start, target=target, walls=walls, bumps=tuple(bumps),
        theta0=options.theta0 or THETA0, kappa=options.kappa or KAPPA, mu=options.mu or MU, varsigma=options.varsigma or VARSIGMA,
        nu=options.nu or NU, seed=task.tube.seed,
    )  # fmt: skip


class _ConflictWindow(NamedTuple):
    """The conflict of the reachability tube with a set: the dimension that (6) chooses, and when all dimensions overlap, in s."""

    dimension: int
    opens: float
    closes: float


def _conflict_of(
    start: tuple[Edge, ...], target: tuple[Edge, ...], sides: tuple[Edge, ...], t_c: Fraction
) -> _ConflictWindow | None:
    """Return the conflict with a set that has these sides; None where some dimension never overlaps, or not at once."""
    windows = [conflict_in_sigma(*edges) for edges in zip(start, target, sides, strict=True)]
    times = [(time_of_sigma(w[0], t_c), time_of_sigma(w[1], t_c)) for w in windows if w is not None]
    if len(times) < len(sides):
        return None
    opens, closes = max(a for a, _ in times), min(b for _, b in times)
    if opens >= closes:
        return None
    last, first = [a for a, _ in times].index(opens), [b for _, b in times].index(closes)
    return _ConflictWindow(min((last, first), key=lambda k: times[k][1] - times[k][0]), opens, closes)


def _round_time(seconds: float) -> Fraction:
    """Return a time to BITS significant bits, exact in float."""
    mantissa, exponent = math.frexp(seconds)
    return Fraction(round(mantissa * 2**BITS)) * Fraction(2) ** (exponent - BITS)
