"""Which gains of the law (13) a loop could have: the one with the longest proved period, and those proved for a period."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stt_codegen.sampling.periods import COARSE, Period, longest, proposal
from stt_codegen.sampling.setting import Setting

GAINS = np.geomspace(1e-2, 1e2, 25)  # times the widest tube's natural gain, tried for the longest period


def longest_from(shortest: float, statement: str, setting: Setting) -> Period | None:
    """`longest`; none below `shortest` seconds, what the certificate of an adaptive tube allows `alpha_step`."""
    period = longest(statement, setting)
    return None if period is None or period.seconds < shortest else period


@dataclass(frozen=True)
class Gains:
    """For one loop. shortest: as in `longest_from`; own: the period proved at the loop's own gain."""

    setting: Setting
    shortest: float
    own: Period | None

    def at(self, gain: float) -> Period | None:
        """The longest period of the sharp statement at another |k|; of the general one where that has none."""
        setting = self.setting.with_gain(gain)
        return longest_from(self.shortest, "sharp", setting) or longest_from(self.shortest, "general", setting)

    @cached_property
    def proposed(self) -> list[tuple[float, float]]:
        """(|k|, period in seconds) over a range of gains in short decimals, as the search has it: a proposal, not yet proved."""
        s = self.setting
        natural = float(np.max(s.push * s.windows.wide / np.maximum(s.least, 1e-9)))  # keeps eps near 1
        natural = natural if 0 < natural < 1e6 else float(s.law.gain)
        gains = dict.fromkeys(float(f"{k * natural:.2g}") for k in GAINS)
        found = [(k, proposal("sharp", s.with_gain(k), COARSE) or proposal("general", s.with_gain(k), COARSE)) for k in gains]
        return [(k, p[0]) for k, p in found if p is not None]

    @cached_property
    def best(self) -> tuple[float, Period] | None:
        """The |k| of the longest period, in two digits, and what is proved for it."""
        for k, _ in sorted(self.proposed, key=lambda pair: -pair[1]):
            period = self.at(k)
            if period is not None:
                return k, period
        return None

    def safe(self, seconds: float) -> tuple[float, float] | None:
        """The least and the largest |k| tried for which a period of so many seconds is proved."""
        enough = sorted(k for k, p in self.proposed if p >= 0.9 * seconds)  # the search for it was coarse

        def proved(k: float) -> bool:
            period = self.at(k)
            return period is not None and period.seconds >= seconds

        least, largest = next(filter(proved, enough), None), next(filter(proved, reversed(enough)), None)
        good = [k for k in (least, largest) if k is not None]
        good += [self.setting.law.gain] if self.own is not None and self.own.seconds >= seconds else []
        return (min(good), max(good)) if good else None
