"""P8: an input within u_max moves the state faster than any edge comes towards it. For tasks with u_max."""

import itertools
import math
from fractions import Fraction
from typing import Any

from .exact import require, rounded
from .tube import Tube, take_claim


def emitted_limits(task: Any, bits: int) -> list[Fraction]:
    """Return u_max as the C has it: rounded down to the scalar. Empty where u is not limited."""
    return [rounded(v, bits, math.floor) for v in task.u_max or []]


def input_margins(task: Any, bits: int) -> list[Fraction]:
    """Return by component what an input at its limit is worth beyond the plant bounds, in the task's units a second."""
    limit, margins = emitted_limits(task, bits), []
    for i, v in enumerate(limit):
        force, g_min, _, cross = task.bounds(i)
        if task.scales:  # the norm of u is limited: a component may have 1/sqrt(n) of it, rounded down
            margins.append((g_min * v - force) * Fraction(math.isqrt(10**24 // task.n), 10**12))
        else:
            margins.append(g_min * v - force - cross * (sum(limit) - v))
    return margins


def prove(task: Any, tube: Tube, claims: list, cuts: int, bits: int) -> None:
    """Prove P8 of order 1: an edge moves at most 3 times a difference of its Bezier coefficients in a segment's time."""
    margin = take_claim(claims, "P8", [0, tube.segments * cuts], 1)["margin"]
    for i, input_margin in enumerate(input_margins(task, bits)):
        allowed = input_margin * task.t_c / tube.segments / tube.unit
        for piece in tube.pieces:
            low, high = piece[i]
            rates = [3 * (b - a) for a, b in itertools.pairwise(low)] + [3 * (a - b) for a, b in itertools.pairwise(high)]
            fastest = max(abs(v) if task.scales else v for v in rates)
            require(fastest + margin <= allowed, f"P8 does not hold: u_max is too small in {task.names[i]}")
