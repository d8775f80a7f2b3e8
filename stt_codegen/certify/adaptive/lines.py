"""What is enclosed of an adaptive or literal tube: bounds on rho, beta and psi over cells of time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from stt_codegen.program.analyse import Ball

Array = npt.NDArray[Any]
LOW, HIGH = 0, 1  # ends of an enclosure


@dataclass(frozen=True)
class Lines:
    """Bounds over each cell, last those for all times from t_c on: arrays of shape (N + 1, n, 2 sides, 2 ends)."""

    times: Array  # (N + 1,) boundaries
    rho: Array
    beta: Array
    psi: Array


def ends(value: Ball) -> tuple[float, float]:
    """Doubles that enclose a ball; infinite where the ball is not finite."""
    if not value.is_finite():
        return -math.inf, math.inf
    return math.nextafter(float(value.lower()), -math.inf), math.nextafter(float(value.upper()), math.inf)
