"""How slowly a control law may be sampled and still keep the state in its tube: three statements, evaluated.

u is held; tau is the greatest age of the sample it was made from: the period, what lost samples add, and the latency l. The first
sample is taken at 0 and acts from then on. With q(E) = E cosh(E/2)^2, h(a, b) = (1/a + 1/b) ln(a/b), widths
d- <= gamma_d <= d+, P = |f + w| + |edge rate| and U a bound on |u|, all in one time window, |eps| < E at the start stays so if

    sharp (by component; g may couple a little): P' = P + sum_j |g_ij| U_j over j != i, c = P' tau + g_ii U l,
        (P' + g_ii U) tau < (d-/2) tanh(E/2), and for d = d- and d = d+, a = d/(1 + e^-E) - c, b = d/(1 + e^E) + c:
        a > b and k g_min h(a, b) > P'
    diagonal (by component, g diagonal):  P/g_min + R tau < 4 k q(E)/d+
    general (eps a vector, |.| its norm): P + G R tau < 4 k g_min q_n(E)/d+,  q_n(E) = E cosh(E/(2 sqrt n))^2
    with R = 16 k q'(E) cosh(E/2)^2 (F + G U + S)/d-^2 + 4 k q(E) D/d-^2.

`lemmas/sampled.py` proves them. A sample in a window may stem from the window before it, so P, U, D and d- of R take the worse of
both; tau is at most a window, half of one where there is latency. Two kinds of error are allowed for: `shift`, by which what the
law sees of x and of the edges is wrong (noise, P7, x rounded to the scalar), and the law's own rounding, relative and in eps.

For order 2 (sampling/inertia.py) P in c and in the first condition are other numbers, and only the sharp statement is known.
The formulas are written once, for doubles, for balls and for symbols. A condition names the lemma that says why it is asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stt_codegen.sampling.setting import Setting, back


@dataclass(frozen=True)
class Condition:
    """An inequality of a sampled statement: it holds where every entry of `values` is positive.

    values: by window, and by component where the inequality is about one; doubles, or balls for a proof. lemma: the one of the
    book that shows why the inequality is enough.
    """

    lemma: str
    values: Any


def q(e: Any) -> Any:
    return e * np.cosh(e / 2) ** 2


def q_rate(e: Any) -> Any:
    """The derivative of q."""
    return np.cosh(e / 2) ** 2 * (1 + e * np.tanh(e / 2))


def pull(a: Any, b: Any) -> Any:
    """h(a, b): the law's |u|/k at distances a > b to the edges."""
    return (1 / a + 1 / b) * np.log(a / b)


def _seen(s: Setting, reach: Any) -> tuple[Any, Any]:
    """The farthest and the nearest distance to an edge that the law may see, at the width at which its |u| is greatest."""
    d = s.narrow + 0 * reach
    return d / (1 + np.exp(-reach)) + s.law.shift, d / (1 + np.exp(reach)) - s.law.shift


def input_bound(s: Setting, reach: Any) -> Any:
    """U (.., W + 1, n), for reach (n,) or (.., 1, n): |u| while |eps| < reach; by the clamp where noise may carry what is seen
    beyond e_max; at most u_max."""
    far, near = _seen(s, reach)
    c = (1 - s.law.e_max) / 2
    width = s.narrow - 2 * s.law.shift
    known = np.asarray(width, dtype=float) > 0  # else the law may see any width, and no bound is known
    held = np.where(known, width, 1 + 0 * width)
    clamped = np.where(known, _law(s, (1 - c) * held, c * held), np.inf) + 0 * reach
    free = np.asarray(near, dtype=float) > np.asarray(far + near, dtype=float) * c
    with np.errstate(invalid="ignore", divide="ignore"):
        safe_far, safe_near = np.where(free, far, 2 + 0 * reach), np.where(free, near, 1 + 0 * reach)
        law = _law(s, safe_far, safe_near)
    u = np.where(free, law, clamped)
    return np.where(np.asarray(u, dtype=float) < s.law.u_max * (1 - 1e-9), u, np.minimum(s.law.u_max, 1e300) + 0 * reach)


def _law(s: Setting, far: Any, near: Any) -> Any:
    """The greatest |u| that the emitted law computes at these distances."""
    return s.law.gain * (pull(far, near) + s.law.rounding * (1 / far + 1 / near)) * (1 + s.law.rounding)


def sharp_push(s: Setting, u: Any) -> Any:
    """P' of the sharp statement: P and what the other inputs push, the sum over j != i of |g_ij| U_j."""
    return s.push + (s.cross * u[..., None, :]).sum(axis=-1)


def sharp(s: Setting, reach: Any, tau: Any) -> list[Condition]:
    u = input_bound(s, reach)
    return sharp_under(s, reach, tau, u, sharp_push(s, u))


def sharp_under(s: Setting, reach: Any, tau: Any, u: Any, push: Any) -> list[Condition]:
    """The sharp statement's conditions for |u| <= `u` (its own component's) and P' = `push` (with what the others push)."""
    aged, turned = (push if v is None else v + (push - s.push) for v in (s.drift, s.middle))  # with what the others push
    drift = aged * tau + s.most * u * s.law.latency + s.law.shift
    narrow = s.windows.narrow
    side = narrow / 2 * (np.tanh(reach / 2) - s.law.rounding) - (turned + s.most * u) * tau - s.law.shift
    conditions = [Condition("sampled.same_side", side)]
    for d in (narrow, s.windows.wide):
        far, near = d / (1 + np.exp(-reach)) - drift, d / (1 + np.exp(reach)) + drift
        conditions.append(Condition("sampled.ends", far - near))
        with np.errstate(invalid="ignore", divide="ignore"):
            held = pull(far, near) - s.law.rounding * (1 / far + 1 / near)
        conditions.append(Condition("sampled.sharp", s.law.gain * (1 - s.law.rounding) * s.least * held - push))
    conditions.append(Condition("sampled.saturated", np.minimum(s.law.u_max, 1e300) * s.least - push))
    return conditions


def _seen_reach(s: Setting, reach: Any, d: Any, shift: Any) -> tuple[Any, Any]:
    """E of what the law may see at width d while |eps| < reach, and by how much its nearer distance stays above 0."""
    near = d / (1 + np.exp(reach)) - shift
    far = d / (1 + np.exp(-reach)) + shift
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.log(far / near), near


def _stale(
    s: Setting, reach: Any, seen: Any, tau: Any, push: Any, g: Any, widening: Any, d: Any, shift: Any, root: Any
) -> tuple[Any, Any]:
    """U, and |u held - u now|: R tau, then what `shift` adds, at the law's steepest (16 k q' cosh^2/d-^2 at E'), and rounding: of
    u, and of eps in every component, whose norm is `root` times one."""
    u = _input(s, seen, d, root)
    rate = 16 * s.law.gain * q_rate(reach) * np.cosh(reach / 2) ** 2 / d**2 * (push + g * u)
    rate = rate + 4 * s.law.gain * q(reach) * widening / d**2
    steep = 16 * s.law.gain * q_rate(seen) * np.cosh(seen / 2) ** 2 / d**2
    return u, rate * tau + steep * shift + s.law.rounding * (u + root * 4 * s.law.gain * np.cosh(seen / 2) ** 2 / d)


def _input(s: Setting, seen: Any, d: Any, root: Any) -> Any:
    """U = 4 k q(E')/d-, E' of what is seen, and what rounding adds, relative and in eps."""
    added = s.law.rounding * root * 4 * s.law.gain * np.cosh(seen / 2) ** 2 / d
    return (4 * s.law.gain * q(seen) / d + added) * (1 + 2 * s.law.rounding)


def _diagonal_staleness(s: Setting, reach: Any, tau: Any) -> tuple[Any, Any, Any]:
    """U, |u held - u now|, and by how much the nearer distance that is seen stays above 0."""
    seen, near = _seen_reach(s, reach, s.narrow, s.law.shift)
    widening = back(s.windows.widening, np.maximum)
    u, stale = _stale(s, reach, seen, tau, s.push, s.most, widening, s.narrow, s.law.shift, 1)
    return u, stale, near


def diagonal(s: Setting, reach: Any, tau: Any) -> list[Condition]:
    u, stale, near = _diagonal_staleness(s, reach, tau)
    return [
        Condition("sampled.diagonal", 4 * s.law.gain * q(reach) / s.windows.wide - stale - s.push / np.maximum(s.least, 1e-300)),
        Condition("sampled.saturated", s.law.u_max - np.asarray(u, dtype=float) + 0 * reach),
        Condition("sampled.diagonal", s.least + 0 * reach),
        Condition("sampled.shift", near),
        Condition("sampled.diagonal", 1e-300 - s.cross.sum(axis=-1) + 0 * reach),
    ]


def _general_staleness(s: Setting, reach: Any, tau: Any) -> tuple[Any, Any, Any, Any]:
    """U (of the norm), |u held - u now|, sqrt(n), and by how much the nearer distance that is seen stays above 0."""
    d, widening = s.narrow.min(axis=1), back(s.windows.widening.max(axis=1), np.maximum)
    each = s.law.shift.max()
    seen, near = _seen_reach(s, reach, d, each)
    root = np.sqrt(float(s.narrow.shape[1])) * (1 + 1e-12)
    seen = reach + root * (seen - reach)  # a bound on the norm of what is seen, and on every component
    single = replace(s, law=replace(s.law, gain=s.law.gain[0]))
    u, stale = _stale(single, reach, seen, tau, s.push_norm, s.norm, widening, d, each * root, root)
    return u, stale, root, near


def general(s: Setting, reach: Any, tau: Any) -> list[Condition]:
    u, stale, root, near = _general_staleness(s, reach, tau)
    q_n = reach * np.cosh(reach / (2 * root)) ** 2
    wide, gain = s.windows.wide.max(axis=1), s.law.gain[0]
    return [
        Condition("sampled.general", gain * s.definite * 4 / wide * q_n - s.push_norm - s.norm * stale),
        Condition("sampled.saturated", s.law.u_max.min() - np.asarray(u, dtype=float) + 0 * reach),
        Condition("sampled.general", s.definite + 0 * reach),
        Condition("sampled.shift", near),
        Condition("sampled.general", (1.0 if (s.law.gain == gain).all() else -1.0) + 0 * s.definite + 0 * reach),
    ]


@dataclass(frozen=True)
class Statement:
    """conditions(setting, E, tau): all must hold. inputs(setting, E, tau): a bound on |u| by component while they do."""

    conditions: Callable[[Setting, Any, Any], list[Condition]]
    inputs: Callable[[Setting, Any, Any], Any]


STATEMENTS = {
    "sharp": Statement(sharp, lambda s, reach, tau: input_bound(s, reach)),
    "diagonal": Statement(diagonal, lambda s, reach, tau: _diagonal_staleness(s, reach, tau)[0]),
    "general": Statement(general, lambda s, reach, tau: _general_staleness(s, reach, tau)[0][..., None] + 0 * s.narrow),
}
