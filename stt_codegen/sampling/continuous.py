"""Theorem 4.1 in numbers, for a law that is not sampled: eps*, and the input it takes, from all starts in the setting."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.sampling.setting import Setting
from stt_codegen.sampling.statements import q

Array = npt.NDArray[Any]


def epsilon_star(s: Setting) -> Array:
    """eps* by component (Theorem 4.1 for g that couples nothing): the least E with 4 k g_min q(E)/d+ >= P, and |eps(0)|; infinite
    where there is none below eps(e_max)."""
    need = np.where(s.least > 0, s.push * s.windows.wide / (4 * s.law.gain * np.maximum(s.least, 1e-300)), np.inf).max(axis=0)
    need = np.where(s.cross.sum(axis=(0, 2)) > 0, np.inf, need) * (1 + 1e-9)
    return np.maximum(_inverse_q(need, s.law.farthest), s.start)


def epsilon_star_norm(s: Setting) -> float:
    """eps* in norm, for any g and one gain: max(|eps(0)|, max gamma_d Phi/(4 k g_min)); infinite where gains differ."""
    if not (s.definite > 0).all() or not (s.law.gain == s.law.gain[0]).all():
        return math.inf
    phi = s.push_norm / s.definite * s.windows.wide.max(axis=1) / (4 * s.law.gain[0])
    return max(float(phi.max()) * (1 + 1e-9), float(np.sqrt((s.start**2).sum())))


def effort(s: Setting) -> Array:
    """|u_i| <= max(|u_i(0)|, P_i/g_min,i) under continuous control, for g that couples nothing; else infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        held = np.where(s.least > 0, s.push / s.least, np.inf).max(axis=0)
    first = 4 * s.law.gain * q(s.start) / s.windows.narrow[0] * (1 + 1e-9)
    return np.where(s.cross.sum(axis=(0, 2)) > 0, np.inf, np.maximum(held * (1 + 1e-9), first))


def holds_saturated(s: Setting) -> bool:
    """Whether the law that u_max saturates keeps |eps| below eps(e_max) under continuous control, for g that couples nothing:
    eps* is below that, and in every window g_min u_max > P (the lemma `limits.saturated`)."""
    enough = (np.minimum(s.law.u_max, 1e300) * s.least * (1 - 1e-12) > s.push).all()
    return bool(enough and (epsilon_star(s) < s.law.farthest).all())


def holds_scaled(s: Setting) -> bool:
    """Whether the law that u_max scales as a whole keeps |eps| below eps(e_max) under continuous control, for any g: eps* in norm
    is below that, and in every window g_min u_max > |P| (the lemma `limits.scaled_stays`)."""
    enough = (s.law.u_max.min() * s.definite * (1 - 1e-12) > s.push_norm).all()
    return bool(enough and epsilon_star_norm(s) < s.law.farthest.min())


def _inverse_q(need: Array, most: Array) -> Array:
    """The least E (rounded up) with q(E) >= need, shown in balls; infinite above `most`."""
    low, high = np.zeros(need.shape), np.array(most)
    for _ in range(60):
        middle = (low + high) / 2
        enough = q(middle) >= need
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    high = high * (1 + 1e-9)
    shown = [
        bool(q(np.array([arb(e)], dtype=object))[0] >= arb(v)) if math.isfinite(v) else False
        for e, v in zip(high, need, strict=True)
    ]
    return np.where(shown, high, np.inf)
