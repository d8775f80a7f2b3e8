"""A sampled loop as the worst path needs it: bounds by component, over any stretch of time windows, in exact fractions.

`PathLoop` is made of a `SampledLoop` in fractions. A tube that repeats has its cycle's windows a second time behind the first, so
that the windows with smaller numbers are those before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from stt_codegen.sampling.path.drive_response import Drive
from stt_codegen.sampling.path.integer_logarithm import LOG_BITS, log_bounds
from stt_codegen.sampling.path.worst_path import PathBounds, Start
from stt_codegen.sampling.sampled_loop import SampledLoop

# P is at least so much of its largest value, and where nothing moves a component of G U, so that every path ends.
SMALLEST_SPEED_SHARE, SMALLEST_INPUT_EFFECT = Fraction(1, 50), Fraction(1, 256)
LARGEST_RHO = 2.0**100  # stands for a start at or outside an edge, from which no path is a proof


@dataclass(frozen=True, kw_only=True)
class WindowBounds:
    """The bounds of one component in one window: P without the other inputs, |g_ij| by j, and g_ii, and the widths."""

    closing_speed: Fraction
    cross: tuple[Fraction, ...]
    g_min: Fraction
    g_max: Fraction
    narrow: Fraction
    wide: Fraction


@dataclass(frozen=True, kw_only=True)
class ComponentLaw:
    """The law and the start of one component: as in `SampledLaw`; u_max is None without a limit, rho_at_start is e^|eps(0)|."""

    gain: Fraction
    e_max: Fraction
    shift: Fraction
    u_max: Fraction | None
    rounding: Fraction
    filter_rate: Fraction
    rho_at_start: Fraction

    def input_bound(self, narrow: Fraction, rho: Fraction) -> Fraction | None:
        """Return U, a bound on |u| while |eps| < E in a tube at least so narrow; None where nothing bounds it.

        rho: e^E. Where noise may carry the measured error beyond e_max, the clamp gives the bound. The law's |u| is largest in
        the narrowest tube (the lemma `sampled.shift`).
        """
        far, near = narrow * rho / (1 + rho) + self.shift, narrow / (1 + rho) - self.shift
        clamp, smallest_width = (1 - self.e_max) / 2, narrow - 2 * self.shift
        if near <= (far + near) * clamp:
            far, near = (1 - clamp) * smallest_width, clamp * smallest_width
        if near <= 0:
            return self.u_max
        ratio = far / near
        log = Fraction(log_bounds(ratio.numerator, ratio.denominator)[1], 1 << LOG_BITS) + self.rounding
        largest = self.gain * (1 / far + 1 / near) * log * (1 + self.rounding)
        return largest if self.u_max is None else min(largest, self.u_max)


@dataclass(frozen=True, kw_only=True)
class PathLoop:
    """A loop for the worst path.

    begins: when each window begins, seconds. windows[i][k]: of component i in window k. laws, drives: by component. age: tau.
    latency: seconds in which no input needs to act. largest_known_age: as in `SampledLoop`. shift_time: seconds;
    a further disturbance makes the laws' shift larger by so many times itself. It is 0 unless v is measured by differences.
    """

    begins: tuple[Fraction, ...]
    windows: tuple[tuple[WindowBounds, ...], ...]
    laws: tuple[ComponentLaw, ...]
    drives: tuple[Drive, ...]
    age: Fraction
    latency: Fraction
    largest_known_age: Any
    shift_time: Fraction = Fraction(0)

    @classmethod
    def of(
        cls,
        loop: SampledLoop,
        drives: Sequence[Drive],
        period: Fraction,
        filter_rates: Sequence[Fraction] = (),
        seam: int | None = None,
    ) -> PathLoop:
        """Return the loop for a sampling period, from a loop in fractions.

        filter_rates: lambda by component, for order 2. seam: the segment with which a tube that repeats begins its cycle.
        """
        segments, n = len(loop.narrow) - 1, len(drives)
        times = [Fraction(v) for v in loop.windows.times.tolist()]
        order = list(range(segments + 1)) if seam is None else [*range(segments), *range(seam, segments)]
        begins = [times[k] for k in range(min(len(order), segments + 1))]
        while len(begins) < len(order):
            begins.append(begins[-1] + times[1] - times[0])
        columns = {
            name: part.tolist()
            for name, part in (
                ("closing_speed", loop.closing_speed),
                ("cross", loop.cross),
                ("g_min", loop.diagonal_min),
                ("g_max", loop.diagonal_max),
                ("narrow", loop.windows.narrow),
                ("wide", loop.windows.wide),
            )
        }

        def window(i: int, k: int) -> WindowBounds:
            numbers = {name: Fraction(values[k][i]) for name, values in columns.items() if name != "cross"}
            return WindowBounds(cross=tuple(Fraction(v) for v in columns["cross"][k][i]), **numbers)

        law, rates = loop.law, [*filter_rates] or [Fraction(0)] * n
        laws = [
            ComponentLaw(
                gain=Fraction(law.gain[i]),
                e_max=Fraction(law.e_max[i]),
                shift=Fraction(law.shift[i]),
                u_max=None if law.u_max[i] == float("inf") else Fraction(law.u_max[i]),
                rounding=Fraction(law.rounding),
                filter_rate=rates[i],
                rho_at_start=Fraction(min(float(loop.start[i]), LARGEST_RHO)),
            )
            for i in range(n)
        ]
        windows = tuple(tuple(window(i, k) for k in order) for i in range(n))
        latency = Fraction(law.latency)
        return cls(
            begins=tuple(begins),
            windows=windows,
            laws=tuple(laws),
            drives=tuple(drives),
            age=period + latency,
            latency=latency,
            largest_known_age=loop.largest_known_age,
        )

    @property
    def has_known_start(self) -> bool:
        """Whether every start is inside the tube, and no sample is older than what is known before the start."""
        return self.age <= self.largest_known_age and all(law.rho_at_start < LARGEST_RHO for law in self.laws)

    def with_period(self, period: Fraction) -> PathLoop:
        """Return the same loop for another sampling period."""
        return replace(self, age=period + self.latency)

    def with_drives(self, drives: Sequence[Drive]) -> PathLoop:
        """Return the same loop with other drives, by component."""
        return replace(self, drives=tuple(drives))

    def component(self, i: int) -> PathLoop:
        """Return the loop of component i alone, for a plant whose inputs are not coupled."""
        windows = tuple(replace(window, cross=(Fraction(0),)) for window in self.windows[i])
        return replace(self, windows=(windows,), laws=(self.laws[i],), drives=(self.drives[i],))

    @property
    def n(self) -> int:
        """The number of components."""
        return len(self.laws)

    @cached_property
    def _largest(self) -> list[tuple[Fraction, tuple[Fraction, ...], Fraction]]:
        """The largest P, |g_ij| by j, and g_ii of each component over all windows."""
        return [
            (
                max(window.closing_speed for window in windows),
                tuple(map(max, zip(*(window.cross for window in windows), strict=True))),
                max(window.g_max for window in windows),
            )
            for windows in self.windows
        ]

    @property
    def has_windows(self) -> bool:
        """Whether bounds of recent windows may differ from those of the whole time."""
        return len(self.begins) > 1

    def start(self, i: int) -> Start:
        """Return how runs of component i start."""
        return Start(self.windows[i][0].narrow / (1 + self.laws[i].rho_at_start), self.latency)

    def bounds_over(self, i: int, first: int, last: int, inputs: Sequence[Fraction]) -> PathBounds:
        """Return the bounds of component i over the windows `first` to `last`.

        inputs: a bound on each |u_j| at all times, since a drive remembers older commands.
        """
        windows, law = self.windows[i][first : last + 1], self.laws[i]
        acting = [drive.amplification * u for drive, u in zip(self.drives, inputs, strict=True)]
        pushed = (r.closing_speed + _effect(r.cross, acting) for r in windows)
        largest_speed, largest_cross, largest_g = self._largest[i]
        smallest_speed = SMALLEST_SPEED_SHARE * (largest_speed + _effect(largest_cross, acting))
        return PathBounds(
            closing_speed=max(*pushed, smallest_speed or SMALLEST_INPUT_EFFECT * largest_g * inputs[i]),
            filter_rate=law.filter_rate,
            g_min=min(r.g_min for r in windows),
            g_max=max(r.g_max for r in windows),
            input_bound=inputs[i],
            u_max=law.u_max,
            gain=law.gain,
            narrow=min(r.narrow for r in windows),
            wide=max(r.wide for r in windows),
            shift=law.shift,
            rounding=law.rounding,
            e_max=law.e_max,
            age=self.age,
            drive=self.drives[i],
        )

    def input_bound(self, i: int, rho: Fraction) -> Fraction | None:
        """Return U of component i while |eps| < E in all windows; rho: e^E. None where nothing bounds it."""
        return self.laws[i].input_bound(min(window.narrow for window in self.windows[i]), rho)

    def window_at(self, time: Fraction) -> int:
        """Return the last window that begins at or before a time that is not negative."""
        return max(k for k, begin in enumerate(self.begins) if begin <= time)


def _effect(cross: Sequence[Fraction], inputs: Sequence[Fraction]) -> Fraction:
    """Return the sum of |g_ij| |u_j|."""
    return sum((g * v for g, v in zip(cross, inputs, strict=True)), Fraction(0))
