"""Enclosures of an adaptive or literal tube's rho, beta and psi over cells of time, which enclosure.py computes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from stt_codegen.program.analyse import Ball

Array = npt.NDArray[Any]
LOW, HIGH = 0, 1  # ends of an enclosure


@dataclass(frozen=True)
class LineBounds:
    """Bounds over each cell, and last for all times from t_c on: arrays of shape (N + 1, n, 2 sides, 2 ends).

    times: cell boundaries, (N + 1,).
    """

    times: Array
    rho: Array
    beta: Array
    psi: Array


def ends(value: Ball) -> tuple[float, float]:
    """Return two doubles that enclose a ball; infinite where the ball is not finite."""
    if not value.is_finite():
        return -math.inf, math.inf
    return math.nextafter(float(value.lower()), -math.inf), math.nextafter(float(value.upper()), math.inf)
