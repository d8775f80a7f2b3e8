"""Limits of u by component that keep its Euclidean norm |u| within control.u_norm: a box inside the ball.

A law that limits each component by itself then keeps the norm, whatever the other components do.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from stt_codegen.decimals import below

SHARE_DIGITS = 6  # of a limit that is chosen
SMALLEST_SHARE = Fraction(1, 50)  # of the largest needed input: what a component has that needs nothing
ROOT_MARGIN = 1e-12  # relative, for the rounding of a square root


def is_within_norm(limits: Sequence[Fraction], norm: Fraction) -> bool:
    """Return whether every u with |u_i| <= limits_i has a Euclidean norm of at most `norm`, exactly."""
    return sum((v * v for v in limits), Fraction(0)) <= norm * norm


def shares_of_norm(needed: Sequence[Fraction], norm: Fraction, caps: Sequence[Fraction] | None = None) -> tuple[Fraction, ...]:
    """Return the largest limits of |u_i| in proportion to the needed inputs with which |u| stays within the norm.

    needed: by component, 0 or more. caps: limits that hold besides; what a capped component leaves goes to the others. Each limit
    is a decimal that is rounded down, and greater than 0.
    """
    largest = max(needed)
    parts = [max(v, largest * SMALLEST_SHARE) if largest else Fraction(1) for v in needed]
    limits: dict[int, Fraction] = {}
    while len(limits) < len(parts):
        free = [i for i in range(len(parts)) if i not in limits]
        remaining = norm**2 - sum((v * v for v in limits.values()), Fraction(0))
        factor = Fraction(math.sqrt(remaining / sum(parts[i] ** 2 for i in free)) * (1 - ROOT_MARGIN))
        capped = [i for i in free if caps is not None and caps[i] <= factor * parts[i]]
        limits |= {i: caps[i] for i in capped} if caps is not None else {}
        if not capped:
            limits |= {i: Fraction(str(below(factor * parts[i], SHARE_DIGITS))) for i in free}
    result = tuple(limits[i] for i in range(len(parts)))
    assert is_within_norm(result, norm)
    return result
