"""Compute what Theorem 4.1 and the sampling conditions prove for one controller and one plant: hypotheses, and bounds with
numbers.

`design` prints the short form, `prove TASK` writes all of it to <p>.bounds.json; bounds.py has both as data. docs/paper.md has
the theorem, docs/certificate.md the sampling conditions.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.arrays import one_if_equal
from stt_codegen.report.bounds import (
    Advice,
    BoundsReport,
    ContinuousBounds,
    Hypothesis,
    PlantOverTube,
    ProvedGains,
    ProvedPeriod,
    SamplingReport,
    TubeBounds,
    round_down,
    round_each,
    round_up,
)
from stt_codegen.report.hypotheses import closed_loop_hypotheses
from stt_codegen.report.loop_analysis import LoopAnalysis
from stt_codegen.report.plant_table import ProposedBounds, propose_bounds
from stt_codegen.sampling import Period, choose_proved_gain, continuous_input_bound, epsilon_star, epsilon_star_norm

Array = npt.NDArray[Any]


class Analysis(LoopAnalysis):
    """The reports on a controller in a closed loop with a plant: its hypotheses, bounds, periods and gains."""

    def hypotheses(self) -> Iterator[Hypothesis]:
        """Yield what the bounds assume, and whether it holds."""
        yield from closed_loop_hypotheses(self)

    # A number that overflows in a search is infinite and proves nothing; so NumPy need not warn.
    @np.errstate(all="ignore")
    def sampling(self) -> SamplingReport:
        """Return what is proved at the task's gain, the gain with the longest period, and the gains for `wanted_period`."""
        task, age = self.controller.task, self.wanted_period + self.latency
        sign = 1 if task.gain[0] > 0 else -1
        limited, gains = self.gains.with_suggested_limits, self.gains.proved_range(age)
        smallest_error = choose_proved_gain(self.sampled_loop, age, self.shortest, self.condition_kinds)

        def signed(gain: Array) -> tuple[float, ...]:
            return tuple((sign * gain).tolist())

        def advice(choice: tuple[Array, Period] | None, u_max: tuple[float, ...] | None = None) -> Advice | None:
            if choice is None:
                return None
            gain, period = choice
            proved = ProvedPeriod.of(period, self.latency)
            return None if proved is None else Advice(signed(gain), proved, u_max)

        proved_gains = None
        if gains is not None:
            last = None if gains.largest is None else signed(gains.largest)
            proved_gains = ProvedGains(signed(gains.smallest), last, gains.fails_below, gains.fails_above)
        proof = self.controller.certificate.proved_period
        return SamplingReport(
            plant=self.name,
            latency=self.latency,
            assumptions=tuple(self.assumptions()),
            has_drive=task.has_drive,
            has_proved_period=bool(proof and proof.paths),
            shortest=round_up(self.shortest),
            shortest_for="control.period_min" if task.uses_differences else "alpha_step",
            starts=self.starts,
            gain=tuple(float(v) for v in task.gain),
            at_this_gain=ProvedPeriod.of(self.period, self.latency),
            from_initial_state=ProvedPeriod.of(self.from_initial_state, self.latency),
            longest=advice(self.gains.with_longest_period),
            longest_with_limits=None if limited is None else advice(limited[1:], tuple(limited.u_max.tolist())),
            wanted=self.wanted_period,
            smallest_error=advice(smallest_error),
            gains=proved_gains,
        )

    @np.errstate(all="ignore")
    def report(self) -> BoundsReport:
        """Return all hypotheses and bounds, rounded towards the weaker statement."""
        controller, s, w = self.controller, self.sampled_loop, self.windows
        return BoundsReport(
            task=controller.task.name,
            design=controller.design.kind,
            scalar=controller.program.scalar,
            plant=self.name,
            axes=controller.task.axis_names,
            noise=one_if_equal(self.noise),
            latency=self.latency,
            hypotheses=tuple(self.hypotheses()),
            tube=TubeBounds(
                round_each(w.low.min(axis=0), round_down),
                round_each(w.high.max(axis=0), round_up),
                round_each(w.narrow.min(axis=0), round_down),
                round_each(w.wide.max(axis=0), round_up),
                round_each(w.speed.max(axis=0), round_up),
            ),
            plant_over_the_tube=PlantOverTube(
                round_each(np.array([b.disturbance for b in self.bounds]).max(axis=0), round_up),
                round_each(s.diagonal_min.min(axis=0), round_down),
                round_each(s.cross.max(axis=(0, 2)), round_up),
                round_down(float(s.eigenvalue_min.min())),
                round_up(float(s.norm.max())),
            ),
            continuous=ContinuousBounds(
                round_each(epsilon_star(s), round_up),
                round_up(epsilon_star_norm(s)),
                round_each(continuous_input_bound(s), round_up),
            ),
            sampled={name: ProvedPeriod.of(p, self.latency) for name, p in self.periods.items()},
            sampling=self.sampling(),
            update_function=self.tube_reading.update_function,
            proposed=self.proposed,
            filter=tuple(float(v) for v in controller.design.filter),
        )

    @property
    def proposed(self) -> ProposedBounds | None:
        """The table [plant] that states the bounds of a plant with equations over the tube; None without such a plant."""
        if self.plant is None:
            return None
        sign = -1 if self.controller.task.gain[0] > 0 else 1
        return propose_bounds(
            self.controller.task,
            self.bounds,
            Fraction(self.plant.w_max),
            lambda: list(self.plant_bounds_over_tube(sign)),
            self.windows.times.tolist(),
        )
