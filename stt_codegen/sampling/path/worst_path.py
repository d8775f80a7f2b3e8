"""The worst path of one component under one set of bounds, in whole numbers: how near to an edge any run can come.

docs/sampling-path.md states and proves the theorem. In short: b is the distance to the edge that x approaches, y what acts of
u, and -b' <= P - lambda b + gamma(y). The path Q falls at least as fast as every run may, with commands Psi(Q(t - tau)) and a
drive that is as late as its bounds allow. If Q turns round at Q_pk, no run comes nearer to the edge.

Every rounding makes the path fall faster, its commands larger and its drive later. Lengths are multiples of `length_unit`,
inputs of `input_unit`, both powers of two below 2^-47 of the largest width and input. Time passes in cells of one length.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from stt_codegen.sampling.path.drive_response import SHARE_BITS, SHARE_ONE, Drive, DriveCells
from stt_codegen.sampling.path.integer_logarithm import LOG_BITS, log_bounds

UNIT_BITS = 48  # the largest width and the largest input have so many bits
DELAY_CELLS = 96  # a cell is at most this part of the input delay and the drive's delay, or ..
CROSSING_CELLS = 512  # .. this part of the time in which x crosses the tube at its largest speed
CELL_COUNT_LIMIT = 1 << 14  # a path that takes longer proves nothing
SLOWEST_SHARE_BITS = 6  # the path falls at least by 2^-6 of P, so that it ends
SLOWEST_START_BITS = 4  # before own time 0 it falls at least by 2^-4 of P + G U


@dataclass(frozen=True, kw_only=True)
class PathBounds:
    """The bounds of one component over the time that a path is about; exact, in the task's units and seconds.

    closing_speed: P, with the effect of the other inputs. filter_rate: lambda, 0 for order 1. g_min, g_max: of g_ii.
    input_bound: U, on |u|; u_max: None where u is not limited. gain: |k|. narrow, wide: the least and the largest width.
    shift: on the error of a measured distance. rounding: of the law, relative and in eps. e_max: the clamp. age: tau, of the
    oldest sample that may act.
    """

    closing_speed: Fraction
    filter_rate: Fraction
    g_min: Fraction
    g_max: Fraction
    input_bound: Fraction
    u_max: Fraction | None
    gain: Fraction
    narrow: Fraction
    wide: Fraction
    shift: Fraction
    rounding: Fraction
    e_max: Fraction
    age: Fraction
    drive: Drive

    def covers(self, tighter: PathBounds) -> bool:
        """Return whether these bounds hold wherever those of `tighter` hold, which is about the same law and drive."""
        return (
            self.closing_speed >= tighter.closing_speed
            and self.input_bound >= tighter.input_bound
            and self.narrow <= tighter.narrow
            and self.wide >= tighter.wide
            and self.g_min <= tighter.g_min
            and self.g_max >= tighter.g_max
        )

    @property
    def cell(self) -> Fraction:
        """The length of a cell in seconds: 4 to 7 times a power of two, a constant of the method."""
        delays = self.age + self.drive.delay(self.input_bound)
        crossing = self.narrow / (self.closing_speed + self.g_max * self.input_bound)
        longest = max(delays / DELAY_CELLS, crossing / CROSSING_CELLS)
        unit = power_below(longest) / 4
        return longest // unit * unit


@dataclass(frozen=True)
class Start:
    """How runs start: `nearest` is a lower bound of the distance to an edge, and no input needs to act before `first_input`."""

    nearest: Fraction
    first_input: Fraction


@dataclass(frozen=True)
class WorstPath:
    """The result of a path.

    nearest: Q_pk, to which no run comes nearer; 0 where the path meets the edge. history: A in seconds, so that bounds over
    the last A seconds are enough; None for a path from the start, and where no A is known. cells: how many cells were passed.
    """

    nearest: Fraction
    history: Fraction | None
    cells: int

    def rho(self, wide: Fraction) -> Fraction | None:
        """Return e^E of the smallest E that this path proves in a tube of at most this width; None where it proves none."""
        return wide / self.nearest - 1 if self.nearest > 0 else None


def power_below(value: Fraction) -> Fraction:
    """Return the largest power of two that is at most a positive value."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length()
    power = Fraction(2) ** exponent
    return power if power <= value else power / 2


class _Law:
    """The law as it is seen from the edge that x approaches, in whole units: Psi of docs/sampling-path.md."""

    def __init__(self, bounds: PathBounds, length_unit: Fraction, input_unit: Fraction) -> None:
        self.narrow = math.floor(bounds.narrow / length_unit)
        self.largest = math.ceil(bounds.input_bound / input_unit)
        self.smallest = -self.largest if bounds.u_max is None else -math.floor(bounds.u_max / input_unit)
        self.log_rounding = math.ceil(bounds.rounding * (1 << LOG_BITS))
        factor = bounds.gain / length_unit / input_unit
        self.weak_gain, self.strong_gain = math.floor(factor * (1 - bounds.rounding)), math.ceil(factor * (1 + bounds.rounding))
        self.clamped = self._clamped(bounds, length_unit)

    def _clamped(self, bounds: PathBounds, length_unit: Fraction) -> int:
        """Return an upper bound on u where the law is clamped: at |e| = e_max, in the largest width that it may measure."""
        ratio = (1 + bounds.e_max) / (1 - bounds.e_max)
        log = log_bounds(ratio.numerator, ratio.denominator)[0] - self.log_rounding
        steepness = 4 / ((1 - bounds.e_max**2) * (bounds.wide + 2 * bounds.shift)) * length_unit
        return -math.floor(self.weak_gain * log * steepness / (1 << LOG_BITS)) if log > 0 else self.largest

    def command(self, near: int) -> int:
        """Return an upper bound on u where the law measures at most `near` to the edge, and x crosses a tube of that width."""
        far = self.narrow - near
        if far <= 0:
            return self.largest
        log = log_bounds(far, near)[0] - self.log_rounding
        if log > 0:
            u = -(self.weak_gain * log * self.narrow // (far * near << LOG_BITS))
        else:
            u = -(self.strong_gain * log * self.narrow // (far * near << LOG_BITS))
        return min(max(u, self.clamped, self.smallest), self.largest)


@dataclass(frozen=True, kw_only=True)
class _Fall:
    """By how much the path falls in a cell, in whole units; gamma and the filter's part with it.

    closing, top: h P and h (P + G U). The factors are in units of 2^-48 for each unit: of g_max and g_min above and below, of
    lambda h below, and of 1/(1 - lambda h) above.
    """

    closing: int
    top: int
    g_max: int
    g_min: int
    filter_share: int
    growth: int

    @classmethod
    def of(cls, bounds: PathBounds, units: Fraction, length_unit: Fraction) -> _Fall:
        """Return the numbers of a path; units: of an input, over that of a length."""
        cell, share = bounds.cell, bounds.filter_rate * bounds.cell
        closing = cell * bounds.closing_speed / length_unit
        return cls(
            closing=math.ceil(closing),
            top=math.ceil(closing + cell * bounds.g_max * bounds.input_bound / length_unit),
            g_max=math.ceil(cell * bounds.g_max * units * SHARE_ONE),
            g_min=math.floor(cell * bounds.g_min * units * SHARE_ONE),
            filter_share=math.floor(share * SHARE_ONE),
            growth=math.ceil(SHARE_ONE / (1 - share)),
        )

    def at_edge(self, acting: int) -> int:
        """Return h (P + gamma(y)) for y = acting."""
        return self.closing - (-acting * (self.g_max if acting > 0 else self.g_min) >> SHARE_BITS)

    def at(self, level: int, acting: int) -> int:
        """Return h (P - lambda Q + gamma(y)) at Q = level and y = acting."""
        return self.at_edge(acting) - (level * self.filter_share >> SHARE_BITS)

    def through_cell(self, fall: int) -> int:
        """Return the fall through a cell, for a positive one at its begin: -lambda Q grows while Q falls."""
        return -(-fall * self.growth >> SHARE_BITS)


class _Path:
    """One path, followed cell by cell."""

    def __init__(self, bounds: PathBounds, start: Start | None) -> None:
        self.bounds, self.start, self.cell = bounds, start, bounds.cell
        self.length_unit = power_below(bounds.wide) / (1 << UNIT_BITS - 1)
        self.input_unit = power_below(bounds.input_bound) / (1 << UNIT_BITS - 1)
        self.law = _Law(bounds, self.length_unit, self.input_unit)
        self.fall = _Fall.of(bounds, self.input_unit / self.length_unit, self.length_unit)
        self.shift = math.ceil(bounds.shift / self.length_unit)
        self.age_cells = max(
            math.ceil(bounds.age / self.cell), 1
        )  # cells from a cell's begin to the one in which its sample lies
        self.newer_share = math.floor((self.age_cells - bounds.age / self.cell) * SHARE_ONE)
        self.start_level = 0 if start is None else math.floor(start.nearest / self.length_unit)

    @cached_property
    def first_level(self) -> int:
        """A level at which the law still asks for U, as at all levels above; the path falls to it at once."""
        level = math.ceil(self.bounds.wide / self.length_unit)
        while (lower := level * 7 >> 3) > self.start_level and self.law.command(lower + self.shift) == self.law.largest:
            level = lower
        return level

    def follow(self) -> WorstPath:
        """Follow the path from the begin to its end, to the edge, or to CELL_COUNT_LIMIT."""
        fall, drive, levels = self.fall, self._drive(), [self.first_level]
        is_started, clipped_cells = self.start is None, 0 if self.start is None else math.ceil(self.start.first_input / self.cell)
        slowest = max(-(-fall.closing >> SLOWEST_SHARE_BITS), 1)
        while len(levels) < CELL_COUNT_LIMIT:
            level, command = levels[-1], self._command(levels)
            if not is_started and level <= self.start_level:
                is_started = True
            if self.start is not None and (not is_started or clipped_cells > 0):
                command = max(command, 0)
                clipped_cells -= is_started
            acting = drive.acting(command)
            falls = fall.at(level, acting)
            # From the start the path ends where (2) turns round; bounds of recent windows need (4).
            if is_started and (falls if self.start is not None else fall.at_edge(acting)) < 0:
                return WorstPath(level * self.length_unit, self._history(level, len(levels)), len(levels))
            at_least = slowest if is_started else max(slowest, -(-fall.top >> SLOWEST_START_BITS))
            level -= max(fall.through_cell(falls) if falls > 0 else 0, at_least)
            if level <= 0:
                break
            levels.append(level)
            drive.step(command)
        return WorstPath(Fraction(0), None, len(levels))

    def _drive(self) -> DriveCells:
        return DriveCells(self.bounds.drive, self.law.largest, self.input_unit, self.cell)

    def _command(self, levels: list[int]) -> int:
        """Return a bound on u in the cell that begins at the last level: of the sample tau before, on the broken line."""
        older = len(levels) - 1 - self.age_cells
        if older < 0:
            return self.law.largest
        fallen = (levels[older] - levels[older + 1]) * self.newer_share >> SHARE_BITS
        return self.law.command(levels[older] - fallen + self.shift)

    def _history(self, level: int, cells: int) -> Fraction | None:
        """Return A of a path without a start: its life, tau, and the time in which the drive forgets; None where it does not."""
        if self.start is not None:
            return None
        drive, command, forgetting = self._drive(), self.law.command(level + self.shift), 0
        while self.fall.at_edge(drive.acting(command)) >= 0:
            if forgetting == CELL_COUNT_LIMIT or drive.is_steady(command):
                return None
            drive.step(command)
            forgetting += 1
        return (cells + self.age_cells + forgetting + 1) * self.cell


def follow_worst_path(bounds: PathBounds, start: Start | None = None) -> WorstPath:
    """Follow the path under these bounds: from all starts of `start`, or of a run about which only recent bounds are known."""
    if bounds.narrow <= 2 * bounds.shift or bounds.filter_rate * bounds.cell >= 1:
        return WorstPath(Fraction(0), None, 0)
    return _Path(bounds, start).follow()
