"""Theorem 4.1 in numbers, for a law in continuous time: eps*, and the input it takes, from all starts of a loop.

Reports call it (report/analysis.py). The lemmas under lemmas/paper/ and `limits.*` have the mathematics.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.sampling.sampled_loop import SampledLoop
from stt_codegen.sampling.sampling_conditions import q

Array = npt.NDArray[Any]


def epsilon_star(loop: SampledLoop) -> Array:
    """Return eps* by component (Theorem 4.1 for g that couples nothing).

    It is the smallest E with 4 k g_min q(E)/d+ >= P, and at least |eps(0)|; infinite where there is none below eps(e_max).
    """
    drive = 4 * loop.law.gain * np.maximum(loop.diagonal_min, 1e-300)
    needed = np.where(loop.diagonal_min > 0, loop.closing_speed * loop.windows.wide / drive, np.inf).max(axis=0)
    needed = np.where(loop.cross.sum(axis=(0, 2)) > 0, np.inf, needed) * (1 + 1e-9)
    return np.maximum(_inverse_q(needed, loop.law.eps_at_clamp), loop.start)


def epsilon_star_norm(loop: SampledLoop) -> float:
    """Return eps* in norm, for any g and one gain: max(|eps(0)|, max gamma_d Phi/(4 k g_min)); infinite where gains differ."""
    if not (loop.eigenvalue_min > 0).all() or not (loop.law.gain == loop.law.gain[0]).all():
        return math.inf
    phi = loop.closing_speed_norm / loop.eigenvalue_min * loop.windows.wide.max(axis=1) / (4 * loop.law.gain[0])
    return max(float(phi.max()) * (1 + 1e-9), float(np.sqrt((loop.start**2).sum())))


def continuous_input_bound(loop: SampledLoop) -> Array:
    """Return the bound max(|u_i(0)|, P_i/g_min,i) on |u_i| by component; infinite where g couples inputs."""
    with np.errstate(divide="ignore", invalid="ignore"):
        balancing = np.where(loop.diagonal_min > 0, loop.closing_speed / loop.diagonal_min, np.inf).max(axis=0)
    first = 4 * loop.law.gain * q(loop.start) / loop.windows.narrow[0] * (1 + 1e-9)
    return np.where(loop.cross.sum(axis=(0, 2)) > 0, np.inf, np.maximum(balancing * (1 + 1e-9), first))


def holds_saturated(loop: SampledLoop) -> bool:
    """Return whether the law that u_max saturates keeps |eps| below eps(e_max), for g that couples nothing.

    It does where eps* is below that, and g_min u_max > P in every window (the lemma `limits.saturated`).
    """
    is_enough = (np.minimum(loop.law.u_max, 1e300) * loop.diagonal_min * (1 - 1e-12) > loop.closing_speed).all()
    return bool(is_enough and (epsilon_star(loop) < loop.law.eps_at_clamp).all())


def holds_scaled(loop: SampledLoop) -> bool:
    """Return whether the law that u_max scales as a vector keeps |eps| below eps(e_max), for any g.

    It does where eps* in norm is below that, and g_min u_max > |P| in every window (the lemma `limits.scaled_stays`).
    """
    is_enough = (loop.law.u_max.min() * loop.eigenvalue_min * (1 - 1e-12) > loop.closing_speed_norm).all()
    return bool(is_enough and epsilon_star_norm(loop) < loop.law.eps_at_clamp.min())


def _inverse_q(needed: Array, largest: Array) -> Array:
    """Return the smallest E (rounded up) with q(E) >= needed, proved in balls; infinite above `largest`."""
    low, high = np.zeros(needed.shape), np.array(largest)
    for _ in range(60):
        middle = (low + high) / 2
        is_enough = q(middle) >= needed
        low, high = np.where(is_enough, low, middle), np.where(is_enough, middle, high)
    high = high * (1 + 1e-9)
    is_proved = [
        bool(q(np.array([arb(e)], dtype=object))[0] >= arb(v)) if math.isfinite(v) else False
        for e, v in zip(high, needed, strict=True)
    ]
    return np.where(is_proved, high, np.inf)
