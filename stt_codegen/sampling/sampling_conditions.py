"""Conditions under which a sampled control law keeps the state in its tube, in three kinds: sharp, diagonal and general.

The input u is held between samples. tau is the age of the oldest sample that may still act: the period, plus what lost samples
add, plus the latency l. The first sample is taken at 0 and acts at once. Write q(E) = E cosh(E/2)^2, h(a, b) = (1/a + 1/b)
ln(a/b), d- <= gamma_d <= d+ for the width, P = |f + w| + |edge rate| for the closing speed and U for a bound on |u|, all in one
time window. Then |eps| < E at the start stays true if one of the following holds.

    sharp (by component; g may couple a little): P' = P + sum_j |g_ij| U_j over j != i, c = P' tau + g_ii U l,
        (P' + g_ii U) tau < (d-/2) tanh(E/2), and for d = d- and d = d+, a = d/(1 + e^-E) - c, b = d/(1 + e^E) + c:
        a > b and k g_min h(a, b) > P'
    diagonal (by component, g diagonal):  P/g_min + R tau < 4 k q(E)/d+
    general (eps a vector, |.| its norm): P + G R tau < 4 k g_min q_n(E)/d+,  q_n(E) = E cosh(E/(2 sqrt n))^2
    with R = 16 k q'(E) cosh(E/2)^2 (F + G U + S)/d-^2 + 4 k q(E) D/d-^2.

`lemmas/sampling/sampled.py` proves them. A sample may stem from the window before, so P, U, D and d- of R take the worse of both
windows. tau is at most one window, and half of one where there is latency. Two kinds of error are allowed for. `shift` bounds the
error of what the law measures of x and of the edges (noise, P7, x rounded to the scalar). `rounding` bounds the error of the law
itself, relative and in eps.

For order 2 (sampling/order_two.py) P in c and in the first condition are other numbers, and only the sharp conditions are known.
The formulas are written once, for doubles, balls, symbols and exact fractions (sampling/numbers.py). The search, the certificate,
reports and the lemma book call these functions. Each condition names the lemma that it rests on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from stt_codegen.sampling.sampled_loop import SampledLoop, worst_with_previous_window


@dataclass(frozen=True)
class Condition:
    """An inequality that holds where every entry of `values` is positive.

    values: by window, and by component where the inequality is about one; doubles, or balls for a proof. lemma: the name of the
    lemma that shows why the inequality is enough.
    """

    lemma: str
    values: Any


def first_failing(conditions: Iterable[Condition]) -> int | None:
    """Return the number, from 1, of the first condition that fails, or None; later conditions are not computed."""
    return next((k for k, c in enumerate(conditions, 1) if not np.all(c.values > 0)), None)


def q(e: Any) -> Any:
    """Return q(E) = E cosh(E/2)^2: |u| is 4 k q/width where |eps| = E."""
    return e * np.cosh(e / 2) ** 2


def q_rate(e: Any) -> Any:
    """Return the derivative of q."""
    return np.cosh(e / 2) ** 2 * (1 + e * np.tanh(e / 2))


def input_per_gain(far: Any, near: Any, logarithm: Callable[[Any], Any], rounding: Any) -> Any:
    """Return h = |u|/|k| of the law at distances far > near to the edges; its eps = ln(far/near) is off by `rounding`."""
    with np.errstate(invalid="ignore", divide="ignore"):  # beyond an edge no condition holds
        steepness = 1 / far + 1 / near
        return steepness * logarithm(far / near) + rounding * steepness


def emitted_input(gain: Any, far: Any, near: Any, logarithm: Callable[[Any], Any], rounding: Any) -> Any:
    """Return the largest |u| that the emitted law with |k| = `gain` computes at these distances.

    logarithm: a function that bounds logarithms from above.
    """
    return gain * input_per_gain(far, near, logarithm, rounding) * (1 + rounding)


def measured_distances(loop: SampledLoop, eps_bound: Any) -> tuple[Any, Any]:
    """Return the largest and the smallest distance to an edge that the law may measure, at the width where its |u| is largest."""
    width = loop.narrow + 0 * eps_bound
    far = width / loop.numbers.far_divisor(eps_bound) + loop.law.shift
    return far, width / loop.numbers.near_divisor(eps_bound) - loop.law.shift


def input_bound(loop: SampledLoop, eps_bound: Any) -> Any:
    """Return U (.., W + 1, n), a bound on |u| while |eps| < eps_bound, for eps_bound (n,) or (.., 1, n).

    Where noise may carry the measured error beyond e_max, the clamp gives the bound. U is at most u_max. It is infinite, or
    1e300, where nothing bounds it because the law may measure any width.
    """
    far, near = measured_distances(loop, eps_bound)
    share, width = (1 - loop.law.e_max) / 2, loop.narrow - 2 * loop.law.shift
    is_free = near > (far + near) * share  # for certain, where these are balls
    is_bounded = is_free | (width > 0)
    clamped_width = np.where(width > 0, width, 1 + 0 * width)
    far = np.where(is_free, far, (1 - share) * clamped_width)
    near = np.where(is_free, near, share * clamped_width)
    law_input = emitted_input(loop.law.largest_gain, far, near, loop.numbers.log_above, loop.law.rounding)
    return loop.numbers.lesser(np.where(is_bounded, law_input, np.inf), loop.law.u_max)


def sharp_closing_speed(loop: SampledLoop, u: Any) -> Any:
    """Return P' of the sharp conditions: P and the effect of the other inputs, the sum over j != i of |g_ij| U_j."""
    return loop.closing_speed + (loop.cross * u[..., None, :]).sum(axis=-1)


def drift_of_sample(loop: SampledLoop, aging: Any, tau: Any, u: Any) -> Any:
    """Return c of the sharp conditions, by which the distances that the law measured may be off when its input acts."""
    return aging * tau + loop.diagonal_max * u * loop.law.latency + loop.law.shift


def distances_at_sample(loop: SampledLoop, width: Any, eps_bound: Any, drift: Any) -> tuple[Any, Any]:
    """Return a and b of the sharp conditions: distances to the edges whose input acts at |eps| = E, for a tube of this width."""
    return width / loop.numbers.far_divisor(eps_bound) - drift, width / loop.numbers.near_divisor(eps_bound) + drift


def weakest_effect(loop: SampledLoop, far: Any, near: Any) -> Any:
    """Return k g_min h(a, b) less what rounding takes: the speed at which the emitted law's input moves x back at least."""
    r = loop.law.rounding
    return loop.law.gain * (1 - r) * loop.diagonal_min * input_per_gain(far, near, loop.numbers.log_below, -r)


def sharp(loop: SampledLoop, eps_bound: Any, tau: Any) -> list[Condition]:
    """Return the sharp conditions, with |u| and the closing speed as the loop bounds them."""
    u = input_bound(loop, eps_bound)
    return list(sharp_under(loop, eps_bound, tau, u, sharp_closing_speed(loop, u)))


def sharp_under(loop: SampledLoop, eps_bound: Any, tau: Any, u: Any, closing_speed: Any) -> Iterator[Condition]:
    """Yield the sharp conditions for |u_i| <= `u` and P' = `closing_speed`, which includes the effect of the other inputs.

    The order matters: as long as the conditions hold, the next one can be computed, so no logarithm is taken of less than 1.
    """
    r, coupling = loop.law.rounding, closing_speed - loop.closing_speed
    in_order_two = (loop.closing_speed_aging, loop.closing_speed_middle)
    aging, from_middle = (closing_speed if v is None else v + coupling for v in in_order_two)
    half_width = loop.windows.narrow / 2 * (loop.numbers.share_of_eps(eps_bound) - r)
    yield Condition("sampled.same_side", half_width - (from_middle + loop.diagonal_max * u) * tau - loop.law.shift)
    yield Condition("sampled.saturated", np.minimum(loop.law.u_max, 1e300) * loop.diagonal_min - closing_speed)
    drift = drift_of_sample(loop, aging, tau, u)
    for d in (loop.windows.narrow, loop.windows.wide):
        far, near = distances_at_sample(loop, d, eps_bound, drift)
        yield Condition("sampled.ends", far - near)
        yield Condition("sampled.sharp", weakest_effect(loop, far, near) - closing_speed)


def _measured_eps_bound(eps_bound: Any, width: Any, shift: Any) -> tuple[Any, Any]:
    """Return E', the bound on |eps| that the law measures at this width, and its smallest measured distance to an edge."""
    near = width / (1 + np.exp(eps_bound)) - shift
    far = width / (1 + np.exp(-eps_bound)) + shift
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.log(far / near), near


@dataclass(frozen=True, kw_only=True)
class Staleness:
    """The numbers that bound how far the held input may be from the law's present value.

    gain: |k|; rounding: of the law; eps_bound, measured_eps_bound: E and E'; closing_speed: P; g_max: a bound on |g|; widening:
    of the tube; width: d-; shift: the error of what is measured; root: sqrt(n) where eps is a vector, else 1.
    """

    gain: Any
    rounding: Any
    eps_bound: Any
    measured_eps_bound: Any
    closing_speed: Any
    g_max: Any
    widening: Any
    width: Any
    shift: Any
    root: Any

    def input_bound(self) -> Any:
        """Return U = 4 k q(E')/d-, with what rounding adds, relative and in eps."""
        added = self.rounding * self.root * 4 * self.gain * np.cosh(self.measured_eps_bound / 2) ** 2 / self.width
        return (4 * self.gain * q(self.measured_eps_bound) / self.width + added) * (1 + 2 * self.rounding)

    def input_change(self, tau: Any) -> Any:
        """Return a bound on |u held - u now| for a sample of age tau: the sum of three parts.

        The first is R tau. The second is the effect of `shift` at the law's steepest slope, 16 k q' cosh^2/d-^2 at E'. The third
        is rounding, of u, and of eps in every component, whose norm is `root` times that of one.
        """
        reach, measured, d = self.eps_bound, self.measured_eps_bound, self.width
        u = self.input_bound()
        rate = 16 * self.gain * q_rate(reach) * np.cosh(reach / 2) ** 2 / d**2 * (self.closing_speed + self.g_max * u)
        rate = rate + 4 * self.gain * q(reach) * self.widening / d**2
        steepest = 16 * self.gain * q_rate(measured) * np.cosh(measured / 2) ** 2 / d**2
        rounded = self.rounding * (u + self.root * 4 * self.gain * np.cosh(measured / 2) ** 2 / d)
        return rate * tau + steepest * self.shift + rounded


def _diagonal_staleness(loop: SampledLoop, eps_bound: Any) -> tuple[Staleness, Any]:
    """Return the staleness by component, and the smallest distance to an edge that the law measures."""
    measured, near = _measured_eps_bound(eps_bound, loop.narrow, loop.law.shift)
    staleness = Staleness(
        gain=loop.law.gain,
        rounding=loop.law.rounding,
        eps_bound=eps_bound,
        measured_eps_bound=measured,
        closing_speed=loop.closing_speed,
        g_max=loop.diagonal_max,
        widening=worst_with_previous_window(loop.windows.widening, np.maximum),
        width=loop.narrow,
        shift=loop.law.shift,
        root=1,
    )
    return staleness, near


def diagonal(loop: SampledLoop, eps_bound: Any, tau: Any) -> list[Condition]:
    """Return the conditions for a diagonal g, by component."""
    staleness, near = _diagonal_staleness(loop, eps_bound)
    u, needed = staleness.input_bound(), loop.closing_speed / np.maximum(loop.diagonal_min, 1e-300)
    law_input = 4 * loop.law.gain * q(eps_bound) / loop.windows.wide
    return [
        Condition("sampled.diagonal", law_input - staleness.input_change(tau) - needed),
        Condition("sampled.saturated", loop.law.u_max - u + 0 * eps_bound),
        Condition("sampled.diagonal", loop.diagonal_min + 0 * eps_bound),
        Condition("sampled.shift", near),
        Condition("sampled.diagonal", 1e-300 - loop.cross.sum(axis=-1) + 0 * eps_bound),
    ]


def _general_staleness(loop: SampledLoop, eps_bound: Any) -> tuple[Staleness, Any]:
    """Return the staleness of the norm, and the smallest distance to an edge that the law measures."""
    width, shift = loop.narrow.min(axis=1), loop.law.shift.max()
    measured, near = _measured_eps_bound(eps_bound, width, shift)
    root = np.sqrt(float(loop.narrow.shape[1])) * (1 + 1e-12)
    staleness = Staleness(
        gain=loop.law.gain[0],
        rounding=loop.law.rounding,
        eps_bound=eps_bound,
        # a bound on the norm of the measured eps, and on every component of it
        measured_eps_bound=eps_bound + root * (measured - eps_bound),
        closing_speed=loop.closing_speed_norm,
        g_max=loop.norm,
        widening=worst_with_previous_window(loop.windows.widening.max(axis=1), np.maximum),
        width=width,
        shift=shift * root,
        root=root,
    )
    return staleness, near


def general(loop: SampledLoop, eps_bound: Any, tau: Any) -> list[Condition]:
    """Return the conditions for any g and one gain, in norms."""
    staleness, near = _general_staleness(loop, eps_bound)
    q_n = eps_bound * np.cosh(eps_bound / (2 * staleness.root)) ** 2
    wide, gain, change = loop.windows.wide.max(axis=1), loop.law.gain[0], staleness.input_change(tau)
    u = staleness.input_bound()
    one_gain = 1.0 if (loop.law.gain == gain).all() else -1.0
    return [
        Condition("sampled.general", gain * loop.eigenvalue_min * 4 / wide * q_n - loop.closing_speed_norm - loop.norm * change),
        Condition("sampled.saturated", loop.law.u_max.min() - u + 0 * eps_bound),
        Condition("sampled.general", loop.eigenvalue_min + 0 * eps_bound),
        Condition("sampled.shift", near),
        Condition("sampled.general", one_gain + 0 * loop.eigenvalue_min + 0 * eps_bound),
    ]


@dataclass(frozen=True)
class ConditionSet:
    """The conditions of one kind, and the bound on |u| by component while they hold.

    conditions(loop, E, tau): all must hold. inputs(loop, E): the bound on |u|.
    """

    conditions: Callable[[SampledLoop, Any, Any], list[Condition]]
    inputs: Callable[[SampledLoop, Any], Any]


SAMPLING_CONDITIONS = {
    "sharp": ConditionSet(sharp, input_bound),
    "diagonal": ConditionSet(diagonal, lambda loop, eps_bound: _diagonal_staleness(loop, eps_bound)[0].input_bound()),
    "general": ConditionSet(
        general, lambda loop, eps_bound: _general_staleness(loop, eps_bound)[0].input_bound()[..., None] + 0 * loop.narrow
    ),
}


def conditions_of(kind: str, loop: SampledLoop, eps_bound: Any, tau: Any) -> list[Condition]:
    """Return the conditions of a kind, for every |k| from `law.gain` to `law.gain_high`.

    In the sharp conditions k enters twice: |u| rises with it, which makes every condition harder, and k g_min h rises with it. So
    the largest |u| and the smallest k g_min h are enough. Where gains are unbounded, u_max is the largest |u|. In the other two
    kinds, with one E, the margin of every condition is concave in k: what holds at both ends holds between them.
    """
    conditions, high = SAMPLING_CONDITIONS[kind].conditions, loop.law.gain_high
    if high is None or kind == "sharp":
        return conditions(loop, eps_bound, tau)
    ends = (loop.with_law(gain=gain, gain_high=None) for gain in (loop.law.gain, high))
    return [condition for end in ends for condition in conditions(end, eps_bound, tau)]
