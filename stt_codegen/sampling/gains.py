"""Gains of the law (13) for a sampled loop: the best for a period, that of the longest period, and the range proved for a period.

Every gain is a multiple of `Gains.proportions`, |k| by component. The search for candidates runs in doubles; every returned gain
is proved (sampling/periods.py). E is a bound on |eps|, and q(E) = E cosh(E/2)^2. The design and `control.gain = "auto"` choose by
`choose_proved_gain`; reports show the ranges.
Long because all three searches share the candidates and the proof of a range.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.decimals import above, below
from stt_codegen.sampling.periods import (
    COMPARISON_EFFORT,
    SMALLEST_EPS_BOUND,
    Period,
    is_proved,
    longest_proved_period,
    period_candidate,
    prove_for_period,
    smallest_bound_candidate,
)
from stt_codegen.sampling.sampled_loop import SampledLoop
from stt_codegen.task import SMALLEST_SHARE, Task, is_within_norm, shares_of_norm

Array = npt.NDArray[np.float64]
GAIN_MULTIPLES = np.geomspace(1e-2, 1e2, 25)  # times the balancing gain
SEARCH_TOLERANCE = 0.01  # relative, of the ends of a range of gains and of the gain of the longest period
MULTIPLE_REFINEMENT = 3  # times as many multiples as GAIN_MULTIPLES, in the search for the smallest error
GAIN_RETREATS = (1.0, 0.98, 0.9, 0.7, 0.5)  # times a searched gain, where the proof may just fail
GAIN_SEARCH_LIMIT = 1e6  # times a proved gain, where the search for an end of the range stops
SMALLEST_STEP = 1.001  # the shortest step of the search for an end
UNBOUNDED = math.inf
WORTHWHILE_PERIOD_RATIO = 1.2  # a limit on u is suggested where it allows a period longer by this factor
INPUT_MARGIN_FACTOR = 1.1  # times the input that is needed, where a limit on u is suggested
GAIN_DIGITS = 3  # of a suggested gain
LIMIT_FACTORS = tuple(Fraction(v) for v in ("1.5", "1.8", "2.2", "2.7"))  # times the needed input, of a limit that is chosen
# the same, where none of those is proved: the smaller the limit, the longer a late input may act, until u is hardly enough
SMALL_LIMIT_FACTORS = tuple(Fraction(v) for v in ("1.25", "1.1", "1.03"))
LIMIT_DIGITS = 3


def longest_proved_period_from(shortest_period: float, kind: str, loop: SampledLoop) -> Period | None:
    """Return the longest proved period, or None if it is below `shortest_period`, in seconds.

    shortest_period: the shortest step of alpha that the certificate of an adaptive tube allows; 0 for a refined tube.
    """
    period = longest_proved_period(kind, loop)
    return None if period is None or period.seconds < shortest_period else period


def needed_input(loop: SampledLoop) -> Array:
    """Return by component the |u| that balances the largest closing speed, the largest over the windows."""
    return np.asarray(balancing_input(loop.diagonal_min, loop.cross, loop.closing_speed).max(axis=0))


def balancing_input(diagonal: Array, cross: Array, closing_speed: Array) -> Array:
    """Return by window and component the |u| that balances the closing speed P, (W, n).

    It is the inverse of g's comparison matrix (g_ii on the diagonal, -|g_ij| elsewhere) times P, or P/g_ii where that matrix has
    no inverse of positive entries. diagonal: the least |g_ii|, (W, n). cross: the largest |g_ij|, (W, n, n).
    """
    matrix = np.eye(closing_speed.shape[1]) * np.maximum(diagonal, 1e-300)[:, :, None] - cross
    with np.errstate(all="ignore"):
        uncoupled = closing_speed / np.maximum(diagonal, 1e-300)
        try:
            coupled = np.linalg.solve(matrix, closing_speed[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            coupled = uncoupled
    return np.asarray(np.where((coupled >= uncoupled).all(axis=1, keepdims=True), coupled, uncoupled))


def limits_for(task: Task, loop: SampledLoop, factor: Fraction) -> tuple[Fraction, ...]:
    """Return the limit of |u| by component: `factor` times the needed input, rounded up, or what control.u_norm leaves of it.

    loop: in doubles, its u_max is not read. A component that nothing moves has a small part of the others' input; where nothing
    moves at all, enough to cross the tube in its time. Limits that the task states beside control.u_norm hold too.
    """
    needed, norm, stated = needed_input(loop), task.control.u_norm, task.stated_u_max
    crossing_speed = loop.windows.wide.max(axis=0) / loop.windows.times[-1]
    floor = needed.max() * float(SMALLEST_SHARE) if needed.any() else crossing_speed
    inputs = np.maximum(needed, floor)
    limits = tuple(Fraction(str(above(factor * Fraction(v), LIMIT_DIGITS))) for v in inputs.tolist())
    if norm is None or (is_within_norm(limits, norm) and all(map(operator.le, limits, stated or limits))):
        return limits
    return shares_of_norm([Fraction(v) for v in (needed if needed.any() else inputs).tolist()], norm, stated)


def balancing_gain(loop: SampledLoop) -> Array:
    """Return the |k| by component at which the law balances the largest closing speed at |eps| = 0.25 (|e| = 0.12).

    That is k = |u| d+, with `needed_input` |u| and the largest width d+ of the tube: the law gives |u| = 4 k q(E)/d+, and
    q(0.246) = 1/4. A component whose closing speed is 0 has k = d+^2/t_c instead.
    """
    largest_width = loop.windows.wide.max(axis=0)
    with np.errstate(over="ignore"):
        gain = needed_input(loop) * largest_width
    return np.asarray(np.where(gain > 0, gain, largest_width**2 / loop.windows.times[-1]))


def rounded_gain(gain: Array, up: bool | None = None) -> Array:
    """Return gains of GAIN_DIGITS digits: the nearest, or rounded up or down."""
    if up is None:
        return np.array([float(f"{k:.{GAIN_DIGITS}g}") for k in gain.tolist()])
    return np.array([(above if up else below)(Fraction(k), GAIN_DIGITS) for k in gain.tolist()])


@dataclass(frozen=True)
class GainRange:
    """A range of |k|, by component: every gain in these proportions from `smallest` to `largest` is proved.

    largest: None where every gain from `smallest` on is proved, because u is limited. fails_below, fails_above: whether the proof
    fails beyond that end of the range; False where only the search stopped there.
    """

    smallest: Array
    largest: Array | None
    fails_below: bool
    fails_above: bool


class GainChoice(NamedTuple):
    """A |k| by component, and a period that is proved at this gain."""

    gain: Array
    period: Period


class LimitChoice(NamedTuple):
    """Limits on |u| by component, and the gain and the period that are proved with them."""

    u_max: Array
    gain: Array
    period: Period


class _BestMultiple(NamedTuple):
    """The multiple of the gain's proportions with the longest period, and the kind of sampling conditions that gives it."""

    kind: str
    multiple: float


@dataclass(frozen=True)
class Gains:
    """The search for proved gains of one loop, for the starts that the loop bounds.

    proportions: |k| by component; the search tries multiples of it. shortest_period: as in `longest_proved_period_from`.
    kinds: of sampling conditions; the first kind that proves a period counts.
    """

    loop: SampledLoop
    proportions: Array
    shortest_period: float = 0.0
    kinds: tuple[str, ...] = ("sharp", "general")

    def longest_period_at(self, gain: Array) -> Period | None:
        """Return the longest proved period at this |k|, by the first kind of conditions that proves one; None without a proof."""
        loop = self.loop.with_law(gain=gain)
        periods = (longest_proved_period_from(self.shortest_period, kind, loop) for kind in self.kinds)
        return next((p for p in periods if p is not None), None)

    @cached_property
    def multiples(self) -> Array:
        """The multiples of `proportions` to try, around the balancing gain; empty where the balancing gain overflows a double."""
        with np.errstate(over="ignore"):
            multiples = GAIN_MULTIPLES * float((balancing_gain(self.loop) / self.proportions).max())
        return multiples if np.isfinite(multiples).all() else multiples[:0]

    @cached_property
    def _best_multiple(self) -> _BestMultiple | None:
        """The multiple with the longest period: the best of `multiples`, refined by golden section; None without any period."""
        for kind in self.kinds:

            def seconds(multiple: float, kind: str = kind) -> float:
                candidate = period_candidate(kind, self.loop.with_law(gain=multiple * self.proportions), COMPARISON_EFFORT)
                return 0.0 if candidate is None else candidate.seconds

            multiples = self.multiples.tolist()
            if not multiples:
                return None
            periods = [seconds(m) for m in multiples]
            k = int(np.argmax(periods))
            if periods[k] > 0:
                neighbours = multiples[max(k - 1, 0)], multiples[min(k + 1, len(multiples) - 1)]
                return _BestMultiple(kind, _highest(seconds, *neighbours))
        return None

    @cached_property
    def with_longest_period(self) -> GainChoice | None:
        """The |k| with the longest period; None where no period is proved."""
        if self._best_multiple is None:
            return None
        gain = rounded_gain(self._best_multiple.multiple * self.proportions)
        period = self.longest_period_at(gain)
        return None if period is None else GainChoice(gain, period)

    @cached_property
    def with_suggested_limits(self) -> LimitChoice | None:
        """Limits of INPUT_MARGIN_FACTOR times the needed input, with the gain of the longest period under them.

        None where the loop's own limits already exceed the needed input, or where no period is proved. A limit may help a loop
        that has none: |u| then stops growing with E, so a larger E does not shorten the period.
        """
        needed, u_max = needed_input(self.loop), self.loop.law.u_max
        if np.isfinite(u_max).any() and (needed < u_max).all():
            return None
        wanted = rounded_gain(needed * INPUT_MARGIN_FACTOR)
        u_max = np.where(np.isfinite(u_max), np.maximum(u_max, wanted), wanted)
        best = replace(self, loop=self.loop.with_law(u_max=u_max)).with_longest_period
        return None if best is None else LimitChoice(u_max, *best)

    def proved_range(self, seconds: float) -> GainRange | None:
        """Return the range of multiples of `proportions` in which every gain is proved for a period of so many seconds.

        Both ends are rounded to GAIN_DIGITS digits. None where no gain is proved.
        """
        if seconds < self.shortest_period:
            return None

        def proved(low: Array, high: Array | None = None) -> bool:
            """Return whether the period is proved for every gain from `low` to `high`, or for `low` alone."""
            loop = self.loop.with_law(gain=low, gain_high=high)
            return any(is_proved(kind, loop, seconds) for kind in self.kinds)

        proved_multiple = self._proved_multiple(proved)
        if proved_multiple is None:
            return None
        low, fails_below = self._end_of_range(proved, proved_multiple, up=False)
        high, fails_above = self._end_of_range(proved, proved_multiple, up=True)
        smallest = self._rounded_inward(proved, low, up=True)
        largest = None if math.isinf(high) else self._rounded_inward(proved, high, up=False)
        if smallest is None or (math.isfinite(high) and (largest is None or (smallest > largest).any())):
            smallest = rounded_gain(proved_multiple * self.proportions)  # the range is narrower than the rounding of its ends
            largest = None if math.isinf(high) else smallest
            if not proved(smallest, None if largest is not None else UNBOUNDED * self.proportions):
                return None
        return GainRange(smallest, largest, fails_below, fails_above)

    def _proved_multiple(self, proved: Callable[..., bool]) -> float | None:
        """Return a proved multiple, from which the search for the ends of the range starts; None where none is proved.

        It is the multiple with the longest period if that is proved. Else it is the first from which on all multiples are
        proved, or the first that is proved by itself.
        """
        if self._best_multiple is not None and proved(self._best_multiple.multiple * self.proportions):
            return self._best_multiple.multiple
        multiples: list[float] = self.multiples.tolist()
        if not multiples:
            return None
        largest = GAIN_SEARCH_LIMIT * multiples[-1]
        if proved(largest * self.proportions, UNBOUNDED * self.proportions):
            return next(m for m in (*multiples, largest) if proved(m * self.proportions, UNBOUNDED * self.proportions))
        return next((m for m in multiples if proved(m * self.proportions)), None)

    def _end_of_range(self, proved: Callable[..., bool], proved_multiple: float, up: bool) -> tuple[float, bool]:
        """Return the end of the range up or down from `proved_multiple`, and whether the proof fails beyond it.

        Each step of the search proves all gains in the step. The end is infinite where all larger multiples are proved. The
        second value is False where only the search stopped.
        """
        multiple, step = proved_multiple, 2.0
        while 1 / GAIN_SEARCH_LIMIT < multiple / proved_multiple < GAIN_SEARCH_LIMIT:
            if up and proved(multiple * self.proportions, UNBOUNDED * self.proportions):
                return math.inf, False
            farther = multiple * step if up else multiple / step
            if proved(min(multiple, farther) * self.proportions, max(multiple, farther) * self.proportions):
                multiple, step = farther, min(step * step, 4.0)
            elif step < SMALLEST_STEP:
                return multiple, True
            else:
                step = math.sqrt(step)
        return multiple, False

    def _rounded_inward(self, proved: Callable[..., bool], multiple: float, up: bool) -> Array | None:
        """Return the gain at an end of the range, rounded inward, or a little farther inward where that is not proved."""
        factors = ((1 + SEARCH_TOLERANCE if up else 1 - SEARCH_TOLERANCE) ** k for k in range(4))
        return next((gain for factor in factors if proved(gain := rounded_gain(multiple * factor * self.proportions, up))), None)

    def with_smallest_error(self, seconds: float) -> GainChoice | None:
        """Return the |k| that keeps |e| smallest in a run from the middle of the tube, and the period proved for it.

        Only gains that are proved for `seconds` from all starts count. None where there is no such gain.
        """
        if self._best_multiple is None or seconds < self.shortest_period:
            return None
        kind, proved_multiple = self._best_multiple
        middle = self.loop.with_start(np.full(self.loop.start.shape, SMALLEST_EPS_BOUND))
        best: tuple[float, Array] | None = None
        finer = np.geomspace(self.multiples[0], self.multiples[-1], MULTIPLE_REFINEMENT * len(self.multiples)).tolist()
        for multiple in (proved_multiple, *finer):
            gain = rounded_gain(multiple * self.proportions)
            if smallest_bound_candidate(kind, self.loop.with_law(gain=gain), seconds) is not None:
                eps_bound = smallest_bound_candidate(kind, middle.with_law(gain=gain), seconds)
                if eps_bound is not None and (best is None or float(eps_bound.max()) < best[0]):
                    best = float(eps_bound.max()), gain
        if best is None:
            return None
        for factor in GAIN_RETREATS:
            gain = rounded_gain(best[1] * factor)
            period = prove_for_period(kind, self.loop.with_law(gain=gain), seconds)
            if period is not None:
                return GainChoice(gain, period)
        return None


def choose_proved_gain(
    loop: SampledLoop, seconds: float, shortest_period: float = 0.0, kinds: tuple[str, ...] = ("sharp", "general")
) -> GainChoice | None:
    """Choose the gain for control.gain = "auto", and prove it for a sampling period in seconds.

    The gain keeps |e| smallest in a run from the middle of the tube: by component, or, where inputs are coupled, as a multiple of
    the balancing gain. None where no gain is proved from all starts of the loop.
    """
    n = loop.closing_speed.shape[1]
    parts = [loop] if loop.cross.any() else [loop.component(i) for i in range(n)]
    choices = [Gains(part, balancing_gain(part), shortest_period, kinds).with_smallest_error(seconds) for part in parts]
    gain = np.concatenate([choice.gain for choice in choices if choice is not None] or [np.zeros(0)])
    if len(gain) < n:
        return None
    proofs = (prove_for_period(kind, loop.with_law(gain=gain), seconds) for kind in kinds)
    period = next((p for p in proofs if p is not None), None)
    return None if period is None else GainChoice(gain, period)


def _highest(value: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function with one peak is highest, by golden section over the logarithm, to SEARCH_TOLERANCE."""
    shrink = (math.sqrt(5) - 1) / 2
    start, end = math.log(low), math.log(high)
    left, right = end - shrink * (end - start), start + shrink * (end - start)
    at_left, at_right = value(math.exp(left)), value(math.exp(right))
    while end - start > SEARCH_TOLERANCE:
        if at_left >= at_right:
            end, right, at_right = right, left, at_left
            left = end - shrink * (end - start)
            at_left = value(math.exp(left))
        else:
            start, left, at_left = left, right, at_right
            right = start + shrink * (end - start)
            at_right = value(math.exp(right))
    return math.exp(left if at_left >= at_right else right)
