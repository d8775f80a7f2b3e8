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

`lemmas/sampling/sampled.py` proves them. A sample in a window may stem from the window before it, so P, U, D and d- of R take
the worse of both; tau is at most a window, half of one where there is latency. Two kinds of error are allowed for: `shift`, by
which what the law sees of x and of the edges is wrong (noise, P7, x rounded to the scalar), and the law's own rounding, relative
and in eps.

For order 2 (sampling/order_two.py) P in c and in the first condition are other numbers, and only the sharp statement is known.
The formulas are written once, for doubles, for balls, for symbols and for exact fractions (sampling/numbers.py): the search, the
certificate, reports and the lemma book call these functions. A condition names the lemma that says why it is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
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


def first_failing(conditions: Iterable[Condition]) -> int | None:
    """The number, from 1, of the first condition that does not hold; None where all do. Those behind it are not computed."""
    return next((k for k, c in enumerate(conditions, 1) if not np.all(c.values > 0)), None)


def q(e: Any) -> Any:
    return e * np.cosh(e / 2) ** 2


def q_rate(e: Any) -> Any:
    """The derivative of q."""
    return np.cosh(e / 2) ** 2 * (1 + e * np.tanh(e / 2))


def pull(far: Any, near: Any, logarithm: Callable[[Any], Any], rounding: Any) -> Any:
    """h(far, near): the law's |u|/k at distances far > near to the edges, its eps = ln(far/near) wrong by `rounding`."""
    with np.errstate(invalid="ignore", divide="ignore"):  # beyond an edge, where no condition holds
        steepness = 1 / far + 1 / near
        return steepness * logarithm(far / near) + rounding * steepness


def emitted_input(gain: Any, far: Any, near: Any, logarithm: Callable[[Any], Any], rounding: Any) -> Any:
    """The greatest |u| that the emitted law with |k| = `gain` computes at these distances; logarithm: bounds one from above."""
    return gain * pull(far, near, logarithm, rounding) * (1 + rounding)


def _seen(s: Setting, reach: Any) -> tuple[Any, Any]:
    """The farthest and the nearest distance to an edge that the law may see, at the width at which its |u| is greatest."""
    d = s.narrow + 0 * reach
    return d / s.numbers.far_divisor(reach) + s.law.shift, d / s.numbers.near_divisor(reach) - s.law.shift


def input_bound(s: Setting, reach: Any) -> Any:
    """U (.., W + 1, n), for reach (n,) or (.., 1, n): |u| while |eps| < reach; by the clamp where noise may carry what is seen
    beyond e_max; at most u_max; infinite, or 1e300, where nothing bounds it, for the law may see any width."""
    far, near = _seen(s, reach)
    share, width = (1 - s.law.e_max) / 2, s.narrow - 2 * s.law.shift
    is_free = near > (far + near) * share  # for certain, where these are balls
    is_bounded = is_free | (width > 0)
    clamped_width = np.where(width > 0, width, 1 + 0 * width)
    far = np.where(is_free, far, (1 - share) * clamped_width)
    near = np.where(is_free, near, share * clamped_width)
    law = emitted_input(s.law.strongest, far, near, s.numbers.log_above, s.law.rounding)
    return s.numbers.lesser(np.where(is_bounded, law, np.inf), s.law.u_max)


def sharp_push(s: Setting, u: Any) -> Any:
    """P' of the sharp statement: P and what the other inputs push, the sum over j != i of |g_ij| U_j."""
    return s.push + (s.cross * u[..., None, :]).sum(axis=-1)


def sharp(s: Setting, reach: Any, tau: Any) -> list[Condition]:
    u = input_bound(s, reach)
    return list(sharp_under(s, reach, tau, u, sharp_push(s, u)))


def sharp_under(s: Setting, reach: Any, tau: Any, u: Any, push: Any) -> Iterator[Condition]:
    """The sharp statement's conditions for |u| <= `u` (its own component's) and P' = `push` (with what the others push). In an
    order in which those that hold make the next one computable: no logarithm is taken of what is below 1."""
    r, others = s.law.rounding, push - s.push
    aged, turned = (push if v is None else v + others for v in (s.drift, s.middle))
    half = s.windows.narrow / 2 * (s.numbers.share_of_reach(reach) - r)
    yield Condition("sampled.same_side", half - (turned + s.most * u) * tau - s.law.shift)
    yield Condition("sampled.saturated", np.minimum(s.law.u_max, 1e300) * s.least - push)
    drift = aged * tau + s.most * u * s.law.latency + s.law.shift
    for d in (s.windows.narrow, s.windows.wide):
        far, near = d / s.numbers.far_divisor(reach) - drift, d / s.numbers.near_divisor(reach) + drift
        yield Condition("sampled.ends", far - near)
        held = pull(far, near, s.numbers.log_below, -r)
        yield Condition("sampled.sharp", s.law.gain * (1 - r) * s.least * held - push)


def _seen_reach(reach: Any, d: Any, shift: Any) -> tuple[Any, Any]:
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
    seen, near = _seen_reach(reach, s.narrow, s.law.shift)
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
    seen, near = _seen_reach(reach, d, each)
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
    "sharp": Statement(sharp, lambda s, reach, _: input_bound(s, reach)),
    "diagonal": Statement(diagonal, lambda s, reach, tau: _diagonal_staleness(s, reach, tau)[0]),
    "general": Statement(general, lambda s, reach, tau: _general_staleness(s, reach, tau)[0][..., None] + 0 * s.narrow),
}


def conditions_of(statement: str, s: Setting, reach: Any, tau: Any) -> list[Condition]:
    """What must hold for every |k| from `law.gain` to `law.gain_high`.

    In the sharp statement k enters twice: |u| rises with it, which makes every condition harder, and k g_min h rises with it. So
    the largest |u| and the least k g_min h are enough; of gains without end the limit of u is the largest |u|. In the two with
    one E the slack of every condition is concave in k: what both ends meet is met between them.
    """
    conditions, high = STATEMENTS[statement].conditions, s.law.gain_high
    if high is None or statement == "sharp":
        return conditions(s, reach, tau)
    ends = (s.with_law(gain=gain, gain_high=None) for gain in (s.law.gain, high))
    return [condition for end in ends for condition in conditions(end, reach, tau)]
