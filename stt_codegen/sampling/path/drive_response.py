"""How a drive answers to its commands: lag, slew and overshoot, for one component.

`Drive` is data; `DriveCells` bounds what a drive makes of commands that are at most c, cell by cell, in whole numbers. All
values of `DriveCells` are in one unit of the input, and every rounding is up (docs/sampling-path.md, section 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.task import DriveBounds

SHARE_BITS = 48  # of factors between 0 and 1, and of those of the overshoot
SHARE_ONE = 1 << SHARE_BITS
EXPONENTIAL_TERMS = 8  # of e^x, x <= 1 mostly: what is left out makes the decay larger, which is the safe side


@dataclass(frozen=True)
class Drive:
    """The drive of one component.

    lags: time constants of first-order lags in series, in seconds; the drive is never behind them. slew: the rate, in units
    of u a second, at which it follows at least; None where it follows at once. overshoot: the share of a step by which the
    answer overshoots at most; it rings down by that share or faster at every half wave.
    """

    lags: tuple[Fraction, ...] = ()
    slew: Fraction | None = None
    overshoot: Fraction = Fraction(0)

    @classmethod
    def of(cls, bounds: DriveBounds) -> Drive:
        """Return the drive of a component of a task; a lag of 0 is none."""
        lags = tuple(lag for lag in (bounds.lag, bounds.lag2) if lag)
        return cls(lags, bounds.slew, bounds.overshoot)

    @property
    def opposite_weight(self) -> Fraction:
        """The weight nu of past commands that act with the opposite sign: M + M^2 + .. for an overshoot by the share M."""
        return self.overshoot / (1 - self.overshoot)

    @property
    def amplification(self) -> Fraction:
        """The largest |y|/|u|: 1 + 2 nu."""
        return 1 + 2 * self.opposite_weight

    def delay(self, input_bound: Fraction) -> Fraction:
        """Return a measure of how long the drive takes, in seconds, for |u| <= input_bound; it decides the length of cells."""
        return sum(self.lags, Fraction(0)) + (2 * input_bound / self.slew if self.slew else 0)

    def scaled(self, factor: Fraction) -> Drive:
        """Return the drive that is slower by this factor; it overshoots as much."""
        return Drive(tuple(v * factor for v in self.lags), None if self.slew is None else self.slew / factor, self.overshoot)


def decay_above(x: Fraction) -> int:
    """Return an upper bound on e^-x, x >= 0, in units of 2^-48: 1 over the first terms of e^x."""
    total = term = Fraction(1)
    for j in range(1, EXPONENTIAL_TERMS):
        term = term * x / j
        total += term
    return -(-SHARE_ONE * total.denominator // total.numerator)


class DriveCells:
    """A bound on what acts of commands that do not rise from cell to cell, in units of `input_unit`.

    In the far past commands and what acts are `input_bound`. `acting` bounds what acts from the begin of the next cell on,
    while commands stay at most what they were; `step` passes one cell.
    """

    def __init__(self, drive: Drive, input_bound: int, input_unit: Fraction, cell: Fraction) -> None:
        self.input_bound = input_bound
        self.decays = [decay_above(cell / lag) for lag in drive.lags]
        # rounded down: it follows more slowly
        self.slew_step = None if drive.slew is None else math.floor(drive.slew * cell / input_unit)
        self.opposite_weight = math.ceil(drive.opposite_weight * SHARE_ONE)
        self.ramp = input_bound  # what the limit of the rate makes of the commands
        self.stages = [input_bound] * len(drive.lags)

    def acting(self, command: int) -> int:
        """Return a bound on what acts in the cell that begins now; command: a bound on the commands in it."""
        ramp = command if self.slew_step is None else max(command, self.ramp)
        value = self.stages[-1] if self.stages else ramp
        both_ways = value + self.input_bound
        return value - (-both_ways * self.opposite_weight >> SHARE_BITS) if both_ways > 0 else value

    def is_steady(self, command: int) -> bool:
        """Return whether all that acts has come to a constant command, up to rounding, and will not change."""
        return all(value - command <= 1 for value in (*self.stages, *([] if self.slew_step is None else [self.ramp])))

    def step(self, command: int) -> None:
        """Pass one cell in which the commands are at most `command`, which is not above those of earlier cells."""
        source = command
        if self.slew_step is not None:
            source = max(command, self.ramp)  # the rate's limit has this value at the cell's begin, and falls
            self.ramp = max(command, self.ramp - self.slew_step)
        for k, decay in enumerate(self.decays):
            value = self.stages[k]
            self.stages[k] = source - (-(value - source) * decay >> SHARE_BITS)
            source = value  # the next stage sees at most what this one was at the cell's begin
