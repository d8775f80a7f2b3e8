"""Which gains of the law (13) a loop could have: that of the longest proved period, that of the most room at a period, the least
and the largest that are proved for a period.

Gains are multiples of `shape`, |k| by component. What is proposed was searched for in doubles; what is returned was proved.
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
from stt_codegen.sampling.periods import COARSE, MIDDLE, Period, is_proved, least, least_proposed, longest, proposal
from stt_codegen.sampling.setting import Setting

Array = npt.NDArray[np.float64]
TRIED = np.geomspace(1e-2, 1e2, 25)  # times the natural gain
CLOSE = 0.01  # how near, as a share, the least and the largest gain are searched for
FINER = 3  # values of a gain for one of TRIED, where the most room is searched for
NEARER = (1.0, 0.98, 0.9, 0.7, 0.5)  # times a searched gain, which may lie where the proof just fails
FAR = 1e6  # times a proved gain, where the search for an end gives up
FINEST = 1.001  # the shortest step towards an end
ENDLESS = math.inf
MUCH = 1.2  # times as long a period, for a limit on u to be worth a word
SPARE = 1.1  # of the input that is needed, where a limit on it is proposed
DIGITS = 3  # of a proposed gain


def longest_from(shortest: float, statement: str, setting: Setting) -> Period | None:
    """`longest`; none below `shortest` seconds, what the certificate of an adaptive tube allows `alpha_step`."""
    period = longest(statement, setting)
    return None if period is None or period.seconds < shortest else period


def needed_input(s: Setting) -> Array:
    """By component the |u| that holds against everything that pushes, the largest over the windows: the inverse of g's comparison
    matrix (g_ii on the diagonal, -|g_ij| beside) times P; where that matrix has no such inverse, P/g_ii."""
    n = s.push.shape[1]
    matrix = np.eye(n) * np.maximum(s.least, 1e-300)[:, :, None] - s.cross
    with np.errstate(all="ignore"):
        alone = s.push / np.maximum(s.least, 1e-300)
        try:
            joined = np.linalg.solve(matrix, s.push[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:
            joined = alone
    return np.asarray(np.where((joined >= alone).all(axis=1, keepdims=True), joined, alone).max(axis=0))


def natural_gain(s: Setting) -> Array:
    """|k| by component that keeps |eps| near 1; where nothing pushes, that which is slow beside the mission."""
    wide = s.windows.wide.max(axis=0)
    with np.errstate(over="ignore"):
        pushed = needed_input(s) * wide
    return np.asarray(np.where(pushed > 0, pushed, wide**2 / s.windows.times[-1]))


def rounded_gain(gain: Array, up: bool | None = None) -> Array:
    """Each to DIGITS digits: the nearest, or up or down."""
    if up is None:
        return np.array([float(f"{k:.{DIGITS}g}") for k in gain.tolist()])
    return np.array([(above if up else below)(Fraction(k), DIGITS) for k in gain.tolist()])


@dataclass(frozen=True)
class GainRange:
    """|k| by component: every gain in these proportions from `first` to `last` is proved; last None: every gain from `first` on,
    for u is limited. `first_is_end`, `last_is_end`: whether what is proved ends there; else the search was cut."""

    first: Array
    last: Array | None
    first_is_end: bool
    last_is_end: bool


@dataclass(frozen=True)
class Gains:
    """For one loop and the starts in `setting`. shape: |k| by component, of which multiples are tried. shortest: as in
    `longest_from`. statements: those that may prove a period, the first that does being taken."""

    setting: Setting
    shape: Array
    shortest: float = 0.0
    statements: tuple[str, ...] = ("sharp", "general")

    def at(self, gain: Array) -> Period | None:
        """The longest period at another |k|, of the first statement that has one."""
        setting = self.setting.with_law(gain=gain)
        found = (longest_from(self.shortest, statement, setting) for statement in self.statements)
        return next((p for p in found if p is not None), None)

    @cached_property
    def tried(self) -> Array:
        """Multiples of `shape` around the natural gain; none where no number is large enough against what pushes."""
        with np.errstate(over="ignore"):
            multiples = TRIED * float((natural_gain(self.setting) / self.shape).max())
        return multiples if np.isfinite(multiples).all() else multiples[:0]

    @cached_property
    def _peak(self) -> tuple[str, float] | None:
        """The statement and the multiple with the longest period, as the search has it: the best of those tried, then a golden
        section about it."""
        for statement in self.statements:

            def seconds(multiple: float, statement: str = statement) -> float:
                found = proposal(statement, self.setting.with_law(gain=multiple * self.shape), COARSE)
                return 0.0 if found is None else found[0]

            tried = self.tried.tolist()
            if not tried:
                return None
            found = [seconds(m) for m in tried]
            k = int(np.argmax(found))
            if found[k] > 0:
                return statement, _highest(seconds, tried[max(k - 1, 0)], tried[min(k + 1, len(tried) - 1)])
        return None

    @cached_property
    def longest(self) -> tuple[Array, Period] | None:
        """The |k| of the longest period, and what is proved for it."""
        if self._peak is None:
            return None
        gain = rounded_gain(self._peak[1] * self.shape)
        period = self.at(gain)
        return None if period is None else (gain, period)

    @cached_property
    def limited(self) -> tuple[Array, Array, Period] | None:
        """Limits on u SPARE above what is needed, with the gain of the longest period under them, and what is proved then: where
        u is not limited (once a limit binds, a larger E asks for no more input), or where its limits are below that."""
        needed, given = needed_input(self.setting), self.setting.law.u_max
        if np.isfinite(given).any() and (needed < given).all():
            return None
        u_max = np.where(np.isfinite(given), np.maximum(given, rounded_gain(needed * SPARE)), rounded_gain(needed * SPARE))
        best = replace(self, setting=self.setting.with_law(u_max=u_max)).longest
        return None if best is None else (u_max, *best)

    def range(self, seconds: float) -> GainRange | None:
        """Multiples of `shape`, as short decimals, between which every gain is proved for a period of so many seconds; None where
        no gain is."""
        if seconds < self.shortest:
            return None

        def proved(low: Array, high: Array | None = None) -> bool:
            setting = self.setting.with_law(gain=low, gain_high=high)
            return any(is_proved(statement, setting, seconds) for statement in self.statements)

        inside = self._proved_multiple(proved)
        if inside is None:
            return None
        low, low_is_end = self._walk(proved, inside, up=False)
        high, high_is_end = self._walk(proved, inside, up=True)
        first = self._inward(proved, low, up=True)
        last = None if math.isinf(high) else self._inward(proved, high, up=False)
        if first is None or (math.isfinite(high) and (last is None or (first > last).any())):
            first = rounded_gain(inside * self.shape)  # the range is narrower than what its ends are rounded by
            last = None if math.isinf(high) else first
            if not proved(first, None if last is not None else ENDLESS * self.shape):
                return None
        return GainRange(first, last, low_is_end, high_is_end)

    def _proved_multiple(self, proved: Callable[..., bool]) -> float | None:
        """A multiple from which to search: that of the longest period, or one from which on all are proved."""
        if self._peak is not None and proved(self._peak[1] * self.shape):
            return self._peak[1]
        multiples: list[float] = self.tried.tolist()
        if not multiples:
            return None
        largest = FAR * multiples[-1]
        if proved(largest * self.shape, ENDLESS * self.shape):
            return next(m for m in (*multiples, largest) if proved(m * self.shape, ENDLESS * self.shape))
        return next((m for m in multiples if proved(m * self.shape)), None)

    def _walk(self, proved: Callable[..., bool], inside: float, up: bool) -> tuple[float, bool]:
        """How far from `inside` every multiple is proved, and whether that is an end. Each step is proved for all gains in it.
        Infinite where all larger ones are proved; no end where the search was cut."""
        multiple, step = inside, 2.0
        while 1 / FAR < multiple / inside < FAR:
            if up and proved(multiple * self.shape, ENDLESS * self.shape):
                return math.inf, False
            reached = multiple * step if up else multiple / step
            if proved(min(multiple, reached) * self.shape, max(multiple, reached) * self.shape):
                multiple, step = reached, min(step * step, 4.0)
            elif step < FINEST:
                return multiple, True
            else:
                step = math.sqrt(step)
        return multiple, False

    def _inward(self, proved: Callable[..., bool], multiple: float, up: bool) -> Array | None:
        """The gain there, rounded to the inner side, or a little farther in where that is not proved."""
        shares = ((1 + CLOSE if up else 1 - CLOSE) ** k for k in range(4))
        return next((gain for share in shares if proved(gain := rounded_gain(multiple * share * self.shape, up))), None)

    def roomiest(self, seconds: float) -> tuple[Array, Period] | None:
        """Of the |k| proved for the period from these starts that which keeps |e| least in a run from the middle of the tube, and
        what is proved for it from these starts."""
        if self._peak is None or seconds < self.shortest:
            return None
        statement, inside = self._peak
        middle = self.setting.begun_at(np.full(self.setting.start.shape, MIDDLE))
        best: tuple[float, Array] | None = None
        for multiple in (inside, *np.geomspace(self.tried[0], self.tried[-1], FINER * len(self.tried)).tolist()):
            gain = rounded_gain(multiple * self.shape)
            if least_proposed(statement, self.setting.with_law(gain=gain), seconds) is not None:
                reach = least_proposed(statement, middle.with_law(gain=gain), seconds)
                if reach is not None and (best is None or float(reach.max()) < best[0]):
                    best = float(reach.max()), gain
        if best is None:
            return None
        for share in NEARER:
            gain = rounded_gain(best[1] * share)
            period = least(statement, self.setting.with_law(gain=gain), seconds)
            if period is not None:
                return gain, period
        return None


def most_room(
    setting: Setting, seconds: float, shortest: float = 0.0, statements: tuple[str, ...] = ("sharp", "general")
) -> tuple[Array, Period] | None:
    """The gain that control.gain = "auto" takes, and what is proved with it for the period from these starts: by component that
    which keeps |e| least in a run from the middle; where inputs are coupled the multiple of the natural gain that does. None
    where no gain is found that is proved."""
    n = setting.push.shape[1]
    parts = [setting] if setting.cross.any() else [setting.component(i) for i in range(n)]
    found = [Gains(part, natural_gain(part), shortest, statements).roomiest(seconds) for part in parts]
    gain = np.concatenate([f[0] for f in found if f is not None] or [np.zeros(0)])
    if len(gain) < n:
        return None
    proofs = (least(statement, setting.with_law(gain=gain), seconds) for statement in statements)
    period = next((p for p in proofs if p is not None), None)
    return None if period is None else (gain, period)


def _highest(value: Callable[[float], float], low: float, high: float) -> float:
    """Where a function of one peak is highest, by golden section over the logarithm, to a share of CLOSE."""
    shrink = (math.sqrt(5) - 1) / 2
    a, b = math.log(low), math.log(high)
    c, d = b - shrink * (b - a), a + shrink * (b - a)
    at_c, at_d = value(math.exp(c)), value(math.exp(d))
    while b - a > CLOSE:
        if at_c >= at_d:
            b, d, at_d = d, c, at_c
            c = b - shrink * (b - a)
            at_c = value(math.exp(c))
        else:
            a, c, at_c = c, d, at_d
            d = a + shrink * (b - a)
            at_d = value(math.exp(d))
    return math.exp(c if at_c >= at_d else d)
