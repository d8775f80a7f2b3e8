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


def uses_norm_up(limits: Sequence[Fraction], norm: Fraction) -> bool:
    """Return whether limits leave no more of the norm than their rounding takes."""
    return sum((v * v for v in limits), Fraction(0)) >= (norm * (1 - Fraction(1, 10 ** (SHARE_DIGITS - 2)))) ** 2


def shares_of_norm(needed: Sequence[Fraction], norm: Fraction, caps: Sequence[Fraction] | None = None) -> tuple[Fraction, ...]:
    """Return the largest limits of |u_i| in proportion to the needed inputs with which |u| stays within the norm.

    needed: by component, 0 or more, in balance: each outweighs what acts while the others push by as much as they need. So all
    grow by one factor, for a component with more than its part would push the others by more. A component that needs nothing
    gets SMALLEST_SHARE of the largest. caps: limits that hold besides. Each limit is a decimal that is rounded down, and
    greater than 0.
    """
    largest = max(needed)
    parts = [max(v, largest * SMALLEST_SHARE) if largest else Fraction(1) for v in needed]
    factor = Fraction(float(norm) / math.sqrt(sum(v * v for v in parts)) * (1 - ROOT_MARGIN))
    if caps is not None:
        factor = min([factor, *(cap / v for cap, v in zip(caps, needed, strict=True) if v)])
    limits = [factor * v for v in parts]
    if caps is not None:
        limits = list(map(min, limits, caps))
    shares = tuple(Fraction(str(below(v, SHARE_DIGITS))) for v in limits)
    assert is_within_norm(shares, norm)
    return shares
