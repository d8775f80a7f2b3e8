"""Theorem 4.1 in numbers, for a law in continuous time: eps*, the bound on |eps|, and a bound on |u|.

Both hold from every start with |eps(0)| within `SampledLoop.start`. Symbols, by time window: P is `closing_speed` (a bound on |f
+ w| plus the speed of the edges) and Phi = `closing_speed_norm`/`eigenvalue_min`; g_min is `diagonal_min`; d+ is `windows.wide`,
the largest width gamma_d; k is |`gain`|; E is a bound on |eps|, and q(E) = E cosh(E/2)^2, so |u| = 4 k q(E)/gamma_d at |eps| = E.
eps(e_max) is |eps| where the law clamps e.

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
    """Return eps* by component (n,), by Theorem 4.1 for a diagonal g.

    It is the smallest E with 4 k g_min q(E)/d+ >= P in every window, and at least |eps(0)|. It is infinite where no E below
    eps(e_max) is large enough, and in a component that inputs of other components move.
    """
    effect_per_q = 4 * loop.law.gain * np.maximum(loop.diagonal_min, 1e-300)
    needed_q = np.where(loop.diagonal_min > 0, loop.closing_speed * loop.windows.wide / effect_per_q, np.inf).max(axis=0)
    needed_q = np.where(loop.cross.sum(axis=(0, 2)) > 0, np.inf, needed_q) * (1 + 1e-9)
    return np.maximum(_inverse_q(needed_q, loop.law.eps_at_clamp), loop.start)


def epsilon_star_norm(loop: SampledLoop) -> float:
    """Return eps* as a bound on the norm of eps: the larger of |eps(0)| and the largest d+ Phi/(4 k) over the windows.

    g may couple the components. The result is infinite where the components have different gains, or where g is not known to be
    positive definite.
    """
    if not (loop.eigenvalue_min > 0).all() or not (loop.law.gain == loop.law.gain[0]).all():
        return math.inf
    needed_eps = loop.closing_speed_norm / loop.eigenvalue_min * loop.windows.wide.max(axis=1) / (4 * loop.law.gain[0])
    return max(float(needed_eps.max()) * (1 + 1e-9), float(np.sqrt((loop.start**2).sum())))


def continuous_input_bound(loop: SampledLoop) -> Array:
    """Return a bound on |u_i| by component (n,): the larger of |u_i(0)| and P_i/g_min,i; infinite where g couples component i."""
    with np.errstate(divide="ignore", invalid="ignore"):
        balancing = np.where(loop.diagonal_min > 0, loop.closing_speed / loop.diagonal_min, np.inf).max(axis=0)
    initial_input = 4 * loop.law.gain * q(loop.start) / loop.windows.narrow[0] * (1 + 1e-9)
    return np.where(loop.cross.sum(axis=(0, 2)) > 0, np.inf, np.maximum(balancing * (1 + 1e-9), initial_input))


def holds_saturated(loop: SampledLoop) -> bool:
    """Return whether it is proved that the law keeps |eps| below eps(e_max) while u_max saturates each input, for a diagonal g.

    It is where eps* is below eps(e_max), and g_min u_max > P in every window (the lemma `limits.saturated`).
    """
    is_enough = (np.minimum(loop.law.u_max, 1e300) * loop.diagonal_min * (1 - 1e-12) > loop.closing_speed).all()
    return bool(is_enough and (epsilon_star(loop) < loop.law.eps_at_clamp).all())


def holds_scaled(loop: SampledLoop) -> bool:
    """Return whether it is proved that the law keeps |eps| below eps(e_max) while u_max scales u as a vector, for any g.

    It is where eps* in norm is below eps(e_max), and g_min u_max > |P| in every window (the lemma `limits.scaled_stays`).
    """
    is_enough = (loop.law.u_max.min() * loop.eigenvalue_min * (1 - 1e-12) > loop.closing_speed_norm).all()
    return bool(is_enough and epsilon_star_norm(loop) < loop.law.eps_at_clamp.min())


def _inverse_q(needed_q: Array, largest: Array) -> Array:
    """Return the smallest E (rounded up) with q(E) >= `needed_q`, by component.

    Balls (Arb) prove the inequality. The result is infinite where no E up to `largest` satisfies it.
    """
    low, high = np.zeros(needed_q.shape), np.array(largest)
    for _ in range(60):
        middle = (low + high) / 2
        is_enough = q(middle) >= needed_q
        low, high = np.where(is_enough, low, middle), np.where(is_enough, middle, high)
    high = high * (1 + 1e-9)
    is_proved = [
        bool(q(np.array([arb(e)], dtype=object))[0] >= arb(v)) if math.isfinite(v) else False
        for e, v in zip(high, needed_q, strict=True)
    ]
    return np.where(is_proved, high, np.inf)
