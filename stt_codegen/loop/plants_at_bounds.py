"""Plants at the corners of the bounds of [plant]: the worst that the proof of a sampling period allows."""

from __future__ import annotations

import math
from fractions import Fraction

from stt_codegen.plants import Plant
from stt_codegen.task import Task


def corner_plants(task: Task) -> list[Plant]:
    """Return plants at the corners of the set of plants that P9 covers.

    Every g_ii is the weakest or the strongest (of -g for a negative gain), every g_ij as large as may be with either sign. f
    counts as a part of w, which acts in the direction of the disturbance.
    """
    bounds = task.plant_bounds
    cross = _largest_couplings(task)
    weakest, strongest = [b.g_min for b in bounds], [b.g_max for b in bounds]
    gains = [("weakest g", weakest), ("strongest g", strongest)][: 1 + (weakest != strongest)]
    gains = gains[:1] if task.scales_input and task.is_coupled else gains
    signs = [(", coupled", 1), (", coupled the other way", -1)] if task.is_coupled else [("", 0)]
    return [
        _plant_with_matrix(task, f"[plant], {gain_name}{coupling}", _corner_matrix(task, diagonal, cross, sign))
        for gain_name, diagonal in gains
        for coupling, sign in signs
    ]


def _largest_couplings(task: Task) -> list[Fraction]:
    """Return the largest |g_ij| of each row i that the bounds allow.

    Where u is scaled as a whole, g_min and g_max bound norms. Couplings are antisymmetric then, so that the symmetric part of g
    stays the diagonal, and they are as large as g_max allows.
    """
    bounds, n = task.plant_bounds, task.dimension
    cross = [b.cross for b in bounds]
    if task.scales_input and n > 1:
        g_min, g_max = float(bounds[0].g_min), float(bounds[0].g_max)
        within_norm = Fraction(math.sqrt(max(g_max**2 - g_min**2, 0.0)) / (n - 1)) * Fraction(999, 1000)
        cross = [min(c, within_norm) for c in cross]
    return cross


def _corner_matrix(task: Task, diagonal: list[Fraction], cross: list[Fraction], coupling_sign: int) -> list[list[float]]:
    """Return g with this diagonal and couplings of this sign, with a negative sign for a negative gain, (n, n)."""
    gain_sign, n = 1 if task.gain[0] > 0 else -1, task.dimension

    def entry(i: int, j: int) -> Fraction:
        if i == j:
            return diagonal[i]
        return coupling_sign * cross[i] * (-1 if task.scales_input and j < i else 1)

    return [[float(gain_sign * entry(i, j)) for j in range(n)] for i in range(n)]


def _plant_with_matrix(task: Task, name: str, matrix: list[list[float]]) -> Plant:
    """Return a plant without drift and with a constant g; its disturbance is as large as the force that [plant] allows."""
    return Plant(
        name=name,
        dimension=None,
        drift=lambda x, *_: [0] * x.shape[0],
        input_matrix=lambda *_: matrix,
        w_max=max(b.force for b in task.plant_bounds),
        order=None,
    )
