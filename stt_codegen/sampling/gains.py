"""Gains of the law (13) for a sampled loop: the best for a period, that of the longest period, and the range proved for a period.

Gains are multiples of `shape`, |k| by component. Candidates are searched for in doubles; what is returned has been proved
(sampling/periods.py). The design and `control.gain = "auto"` choose by `choose_proved_gain`; reports show the ranges.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stt_codegen.decimals import above, below
from stt_codegen.sampling.periods import (
    COARSE,
    SMALLEST_EPS_BOUND,
    Period,
    is_proved,
    longest_proved_period,
    period_candidate,
    prove_for_period,
    smallest_bound_candidate,
)
from stt_codegen.sampling.sampled_loop import SampledLoop

Array = npt.NDArray[np.float64]
GAIN_MULTIPLES = np.geomspace(1e-2, 1e2, 25)  # times the natural gain
SEARCH_TOLERANCE = 0.01  # relative, of the ends of a range of gains and of the gain of the longest period
MULTIPLE_REFINEMENT = 3  # times as many multiples as GAIN_MULTIPLES, in the search for the smallest error
GAIN_RETREATS = (1.0, 0.98, 0.9, 0.7, 0.5)  # times a searched gain, where the proof may just fail
GAIN_SEARCH_LIMIT = 1e6  # times a proved gain, where the search for an end of the range stops
SMALLEST_STEP = 1.001  # the shortest step of the search for an end
UNBOUNDED = math.inf
WORTHWHILE_PERIOD_RATIO = 1.2  # a limit on u is suggested where it allows a period longer by this factor
INPUT_MARGIN_FACTOR = 1.1  # times the input that is needed, where a limit on u is suggested
GAIN_DIGITS = 3  # of a suggested gain


def longest_proved_period_from(shortest: float, kind: str, setting: SampledLoop) -> Period | None:
    """Return the longest proved period, or None if it is below `shortest` seconds.

    shortest: the shortest step of alpha that the certificate of an adaptive tube allows.
    """
    period = longest_proved_period(kind, setting)
    return None if period is None or period.seconds < shortest else period


def needed_input(loop: SampledLoop) -> Array:
    """Return by component the |u| that balances the largest closing speed, the largest over the windows.

    It is the inverse of g's comparison matrix (g_ii on the diagonal, -|g_ij| elsewhere) times P, or P/g_ii where that matrix has
    no inverse of positive entries.
    """
    n = loop.closing_speed.shape[1]
    matrix = np.eye(n) * np.maximum(loop.diagonal_min, 1e-300)[:, :, None] - loop.cross
    with np.errstate(all="ignore"):
        uncoupled = loop.closing_speed / np.maximum(loop.diagonal_min, 1e-300)
        try:
            coupled = np.linalg.solve(matrix, loop.closing_speed[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            coupled = uncoupled
    return np.asarray(np.where((coupled >= uncoupled).all(axis=1, keepdims=True), coupled, uncoupled).max(axis=0))


def natural_gain(loop: SampledLoop) -> Array:
    """Return the |k| by component that keeps |eps| near 1; without disturbances, one that is slow compared with the mission."""
    wide = loop.windows.wide.max(axis=0)
    with np.errstate(over="ignore"):
        gain = needed_input(loop) * wide
    return np.asarray(np.where(gain > 0, gain, wide**2 / loop.windows.times[-1]))


def rounded_gain(gain: Array, up: bool | None = None) -> Array:
    """Return gains of GAIN_DIGITS digits: the nearest, or rounded up or down."""
    if up is None:
        return np.array([float(f"{k:.{GAIN_DIGITS}g}") for k in gain.tolist()])
    return np.array([(above if up else below)(Fraction(k), GAIN_DIGITS) for k in gain.tolist()])


@dataclass(frozen=True)
class GainRange:
    """A range of |k|, by component: every gain in these proportions from `first` to `last` is proved.

    last: None where every gain from `first` on is proved, because u is limited. first_is_end, last_is_end: whether the proof
    fails beyond that end; False where only the search stopped there.
    """

    first: Array
    last: Array | None
    first_is_end: bool
    last_is_end: bool


@dataclass(frozen=True)
class Gains:
    """The gains of one loop, for the starts that it bounds.

    shape: |k| by component, of which multiples are tried. shortest: as in `longest_proved_period_from`. kinds: of sampling
    conditions; the first that proves a period counts.
    """

    loop: SampledLoop
    shape: Array
    shortest: float = 0.0
    kinds: tuple[str, ...] = ("sharp", "general")

    def at(self, gain: Array) -> Period | None:
        """Return the longest period at another |k|, of the first kind that proves one."""
        loop = self.loop.with_law(gain=gain)
        periods = (longest_proved_period_from(self.shortest, kind, loop) for kind in self.kinds)
        return next((p for p in periods if p is not None), None)

    @cached_property
    def multiples(self) -> Array:
        """Multiples of `shape` around the natural gain; none where no double is large enough against the disturbance."""
        with np.errstate(over="ignore"):
            multiples = GAIN_MULTIPLES * float((natural_gain(self.loop) / self.shape).max())
        return multiples if np.isfinite(multiples).all() else multiples[:0]

    @cached_property
    def _peak(self) -> tuple[str, float] | None:
        """The kind of conditions and the multiple with the longest period: the best of `multiples`, then golden section."""
        for kind in self.kinds:

            def seconds(multiple: float, kind: str = kind) -> float:
                candidate = period_candidate(kind, self.loop.with_law(gain=multiple * self.shape), COARSE)
                return 0.0 if candidate is None else candidate.seconds

            multiples = self.multiples.tolist()
            if not multiples:
                return None
            periods = [seconds(m) for m in multiples]
            k = int(np.argmax(periods))
            if periods[k] > 0:
                return kind, _highest(seconds, multiples[max(k - 1, 0)], multiples[min(k + 1, len(multiples) - 1)])
        return None

    @cached_property
    def longest(self) -> tuple[Array, Period] | None:
        """The |k| with the longest period, and that period."""
        if self._peak is None:
            return None
        gain = rounded_gain(self._peak[1] * self.shape)
        period = self.at(gain)
        return None if period is None else (gain, period)

    @cached_property
    def limited(self) -> tuple[Array, Array, Period] | None:
        """Limits on u that are INPUT_MARGIN_FACTOR times what is needed, with the gain of the longest period and that period.

        None where the loop has limits that are above what is needed. Without limits they may help: once a limit binds, a larger E
        asks for no more input.
        """
        needed, u_max = needed_input(self.loop), self.loop.law.u_max
        if np.isfinite(u_max).any() and (needed < u_max).all():
            return None
        wanted = rounded_gain(needed * INPUT_MARGIN_FACTOR)
        u_max = np.where(np.isfinite(u_max), np.maximum(u_max, wanted), wanted)
        best = replace(self, loop=self.loop.with_law(u_max=u_max)).longest
        return None if best is None else (u_max, *best)

    def range(self, seconds: float) -> GainRange | None:
        """Return the range of multiples of `shape`, as short decimals, in which every gain is proved for a period in seconds.

        None where no gain is proved.
        """
        if seconds < self.shortest:
            return None

        def proved(low: Array, high: Array | None = None) -> bool:
            loop = self.loop.with_law(gain=low, gain_high=high)
            return any(is_proved(kind, loop, seconds) for kind in self.kinds)

        inside = self._proved_multiple(proved)
        if inside is None:
            return None
        low, low_is_end = self._walk(proved, inside, up=False)
        high, high_is_end = self._walk(proved, inside, up=True)
        first = self._inward(proved, low, up=True)
        last = None if math.isinf(high) else self._inward(proved, high, up=False)
        if first is None or (math.isfinite(high) and (last is None or (first > last).any())):
            first = rounded_gain(inside * self.shape)  # the range is narrower than the rounding of its ends
            last = None if math.isinf(high) else first
            if not proved(first, None if last is not None else UNBOUNDED * self.shape):
                return None
        return GainRange(first, last, low_is_end, high_is_end)

    def _proved_multiple(self, proved: Callable[..., bool]) -> float | None:
        """Return a multiple to search from: the one of the longest period, or one from which on all multiples are proved."""
        if self._peak is not None and proved(self._peak[1] * self.shape):
            return self._peak[1]
        multiples: list[float] = self.multiples.tolist()
        if not multiples:
            return None
        largest = GAIN_SEARCH_LIMIT * multiples[-1]
        if proved(largest * self.shape, UNBOUNDED * self.shape):
            return next(m for m in (*multiples, largest) if proved(m * self.shape, UNBOUNDED * self.shape))
        return next((m for m in multiples if proved(m * self.shape)), None)

    def _walk(self, proved: Callable[..., bool], inside: float, up: bool) -> tuple[float, bool]:
        """Return how far from `inside` every multiple is proved, and whether the proof fails beyond.

        Each step is proved for all gains in it. The result is infinite where all larger multiples are proved. The second value is
        False where only the search stopped.
        """
        multiple, step = inside, 2.0
        while 1 / GAIN_SEARCH_LIMIT < multiple / inside < GAIN_SEARCH_LIMIT:
            if up and proved(multiple * self.shape, UNBOUNDED * self.shape):
                return math.inf, False
            farther = multiple * step if up else multiple / step
            if proved(min(multiple, farther) * self.shape, max(multiple, farther) * self.shape):
                multiple, step = farther, min(step * step, 4.0)
            elif step < SMALLEST_STEP:
                return multiple, True
            else:
                step = math.sqrt(step)
        return multiple, False

    def _inward(self, proved: Callable[..., bool], multiple: float, up: bool) -> Array | None:
        """Return the gain at an end of the range, rounded inward, or a little farther inward where that is not proved."""
        shares = ((1 + SEARCH_TOLERANCE if up else 1 - SEARCH_TOLERANCE) ** k for k in range(4))
        return next((gain for share in shares if proved(gain := rounded_gain(multiple * share * self.shape, up))), None)

    def smallest_error(self, seconds: float) -> tuple[Array, Period] | None:
        """Return the |k| that keeps |e| smallest in a run from the middle of the tube, and the period proved for it.

        Only gains that are proved for `seconds` from all starts count. None where there is no such gain.
        """
        if self._peak is None or seconds < self.shortest:
            return None
        kind, inside = self._peak
        middle = self.loop.with_start(np.full(self.loop.start.shape, SMALLEST_EPS_BOUND))
        best: tuple[float, Array] | None = None
        finer = np.geomspace(self.multiples[0], self.multiples[-1], MULTIPLE_REFINEMENT * len(self.multiples)).tolist()
        for multiple in (inside, *finer):
            gain = rounded_gain(multiple * self.shape)
            if smallest_bound_candidate(kind, self.loop.with_law(gain=gain), seconds) is not None:
                eps_bound = smallest_bound_candidate(kind, middle.with_law(gain=gain), seconds)
                if eps_bound is not None and (best is None or float(eps_bound.max()) < best[0]):
                    best = float(eps_bound.max()), gain
        if best is None:
            return None
        for share in GAIN_RETREATS:
            gain = rounded_gain(best[1] * share)
            period = prove_for_period(kind, self.loop.with_law(gain=gain), seconds)
            if period is not None:
                return gain, period
        return None


def choose_proved_gain(
    loop: SampledLoop, seconds: float, shortest: float = 0.0, kinds: tuple[str, ...] = ("sharp", "general")
) -> tuple[Array, Period] | None:
    """Choose the gain for control.gain = "auto", and prove it for a sampling period in seconds.

    The gain keeps |e| smallest in a run from the middle of the tube: by component, or, where inputs are coupled, as a multiple of
    the natural gain. None where no gain is proved from all starts of the loop.
    """
    n = loop.closing_speed.shape[1]
    parts = [loop] if loop.cross.any() else [loop.component(i) for i in range(n)]
    choices = [Gains(part, natural_gain(part), shortest, kinds).smallest_error(seconds) for part in parts]
    gain = np.concatenate([choice[0] for choice in choices if choice is not None] or [np.zeros(0)])
    if len(gain) < n:
        return None
    proofs = (prove_for_period(kind, loop.with_law(gain=gain), seconds) for kind in kinds)
    period = next((p for p in proofs if p is not None), None)
    return None if period is None else (gain, period)


def _highest(value: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function with one peak is highest, by golden section over the logarithm, to SEARCH_TOLERANCE."""
    shrink = (math.sqrt(5) - 1) / 2
    a, b = math.log(low), math.log(high)
    c, d = b - shrink * (b - a), a + shrink * (b - a)
    at_c, at_d = value(math.exp(c)), value(math.exp(d))
    while b - a > SEARCH_TOLERANCE:
        if at_c >= at_d:
            b, d, at_d = d, c, at_c
            c = b - shrink * (b - a)
            at_c = value(math.exp(c))
        else:
            a, c, at_c = c, d, at_d
            d = a + shrink * (b - a)
            at_d = value(math.exp(d))
    return math.exp(c if at_c >= at_d else d)
