"""Build the sampled loop of one controller and one plant, and compute the periods and gains that the sampling conditions prove.

report/hypotheses.py and report/analysis.py say and write what follows. docs/certificate.md has the sampling conditions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.arrays import entries_of
from stt_codegen.certify.adaptive import enclosed_tube, enclosed_windows
from stt_codegen.controller import rate_error
from stt_codegen.decimals import by_component, decimal
from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design, require_refined
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.properties import Property
from stt_codegen.report.bounds import UpdateFunctionBounds, round_down, round_up
from stt_codegen.report.plant_table import uncovered_bounds
from stt_codegen.sampling import (
    KNOWN_AGE_FACTOR,
    SAMPLING_CONDITIONS,
    Bounds,
    Gains,
    Period,
    PlantEnclosure,
    SampledLoop,
    Windows,
    bounds_of_task,
    condition_kinds_of,
    longest_proved_period_from,
    loop_of,
    refined_windows,
    start_bound_of_task,
    velocity_bounds,
    worst_with_previous_window,
)
from stt_codegen.task import Task

Array = npt.NDArray[Any]


class LoopAnalysis:
    """The sampled loop of a controller and a plant, with the periods and gains that are proved for it.

    plant: None for any plant within the task's table [plant]. noise: bound on the error of a measured state, one number or one
    for each component; latency: seconds
    from a sample until its input acts, a part of the age of a sample; None for what the task states. start: prove for this x(0)
    alone; None for all starts in the task's start share of gamma(0). Raises `BadInput` for a noise or latency that is negative.
    """

    def __init__(
        self,
        controller: EmittedController,
        plant: Model | None = None,
        noise: float | Sequence[float] | None = None,
        latency: float | None = None,
        start: Sequence[float] | None = None,
    ) -> None:
        task = controller.task
        self.noise = entries_of("--noise", [float(v) for v in task.noise] if noise is None else noise, task.dimension)
        latency = float(task.control.latency) if latency is None else latency
        if not (math.isfinite(latency) and latency >= 0):
            raise BadInput(f"--latency {latency:g}: a finite number of 0 or more is needed")
        self.controller, self.latency = controller, latency
        self.plant = plant
        self.tube_reading = READINGS[controller.design.kind](task, controller.design)
        self.windows = self.tube_reading.windows
        self.bounds = list(self.plant_bounds_over_tube(1 if task.gain[0] > 0 else -1))
        self.sampled_loop = self._build_sampled_loop(start)
        self.condition_kinds = condition_kinds_of(task)
        self.starts = f"|e(0)| <= {decimal(task.initial_set.share)} by component" if start is None else "x(0) as given"
        if task.order == 2 and (start is None or len(start) == task.dimension):
            moving = any(task.start_speed)
            self.starts += f" and |v(0)| <= {by_component(task.start_speed)}" if moving else " and at rest"

    def _build_sampled_loop(self, start: Sequence[float] | None) -> SampledLoop:
        """Return the loop with its windows and bounds; of order 2, its tube is the one of v + lambda x."""
        controller, design = self.controller, self.controller.design
        rate = rate_error(require_refined(design), controller.program) if design.filter else ()
        loop = loop_of(
            controller.task,
            design,
            controller.certificate.edge_error,
            rate,
            windows=self.windows,
            bounds=self.bounds,
            noise=self.noise,
            latency=self.latency,
            start=start,
        )
        return replace(loop, largest_known_age=min(loop.largest_known_age, self.known_mixing_age))

    def _start_bound(self, state: Sequence[float] | None) -> Array:
        """Bound |eps(0)| by component, for a state, or (None) for all starts in the start share."""
        return start_bound_of_task(self.controller.task, self.controller.design, self.windows, state)

    def plant_bounds_over_tube(self, sign: int) -> Iterator[Bounds]:
        """Yield the bounds of the plant, with g times `sign`, over the box of each window joined with the window before."""
        task, windows = self.controller.task, self.windows
        if self.plant is None:
            yield from [bounds_of_task(task)] * len(windows.narrow)
            return
        enclosure = PlantEnclosure(self.plant, task.dimension, sign, task.order)
        low, high = windows.low, windows.high
        if task.order == 2:
            slow, fast = velocity_bounds(require_refined(self.controller.design))
            low, high = np.concatenate([low, slow], axis=1), np.concatenate([high, fast], axis=1)
        for a, b in zip(worst_with_previous_window(low, np.minimum), worst_with_previous_window(high, np.maximum), strict=True):
            yield enclosure.over(list(zip(a.tolist(), b.tolist(), strict=True)), self._sample_drift(a, b))

    @property
    def known_mixing_age(self) -> float:
        """The age of a sample, in seconds, up to which bounds hold on a plant whose input depends on the sample; infinite for
        others."""
        if self.plant is None or self.plant.mixing is None or self.controller.task.order == 1:
            return math.inf
        return (self.wanted_period + self.latency) * float(KNOWN_AGE_FACTOR)

    def _sample_drift(self, low: Array, high: Array) -> list[float]:
        """Bound by component how far x may move from its sample while both are in the box of a window.

        Of order 2 the speed bounds it, for an age of `known_mixing_age`; of order 1 it may be anywhere in the box.
        """
        n = self.controller.task.dimension
        distance = high[:n] - low[:n]
        if math.isfinite(self.known_mixing_age):
            distance = np.minimum(distance, np.maximum(np.abs(low[n:]), np.abs(high[n:])) * self.known_mixing_age)
        return [float(v) for v in (distance + np.array(self.noise)) * (1 + 1e-12)]

    @property
    def name(self) -> str:
        """The name of the plant, for messages."""
        if self.plant is not None:
            return self.plant.name
        if self.controller.task.assumes_plant:
            return "the plant that is assumed"
        if self.controller.task.plant.is_stated:
            drive = ", but with a drive that acts at once," if self.controller.task.has_drive else ""
            return f"[plant] of the task{drive}"
        return "xdot = u" if self.controller.task.gain[0] > 0 else "xdot = -u"

    # ------------------------------------------------------------------------------------ sampled control

    @cached_property
    def periods(self) -> dict[str, Period | None]:
        """The longest period proved for the task's gain, by kind of the sampling conditions."""
        task = self.controller.task
        kinds = SAMPLING_CONDITIONS if task.order == 1 and not task.scales_input else self.condition_kinds
        return {kind: longest_proved_period_from(self.shortest, kind, self.sampled_loop) for kind in kinds}

    @property
    def shortest(self) -> float:
        """The lower limit of periods in seconds.

        It is 0 except for adaptive tubes, whose certificate has a shortest step of alpha, and for a velocity by differences.
        """
        steps = self.controller.certificate.steps
        if self.controller.task.uses_differences:
            return float(self.controller.task.shortest_period)
        return 0.0 if steps is None else float(steps[0])

    @property
    def state_is_outside(self) -> bool:
        """Whether initial_state is outside the start share."""
        state = self._start_bound([float(v) for v in self.controller.task.initial_state])
        return bool((state > self._start_bound(None)).any())

    def assumptions(self) -> list[str]:
        """Return sentences on what the periods rest on and no program can check."""
        task, assumptions = self.controller.task, list[str]()
        if task.emit.scalar == "fixed":
            assumptions.append("samples are taken at ticks; `generate` says which gains integers hold beside u_max")
        if task.order == 2:
            assumptions.append("below, |e| is that of v + lambda x in its tube; x stays in its own")
        if task.uses_differences:
            assumptions.append(
                f"samples are at least {decimal(task.shortest_period)} s apart, and their distance is measured exactly"
            )
        if task.has_drive:
            assumptions.append(f"the drive acts at once; {Property.PERIOD.label} alone counts the drive of [plant]")
        if self.state_is_outside:
            assumptions.append(
                "the start is not initial_state, which is nearer to an edge of gamma(0) than initial_set.share allows"
            )
        if self.plant is None and task.plant.is_stated and not task.assumes_plant:
            if task.plant.g_cross is None and task.dimension > 1:
                assumptions.append("g is diagonal, for plant.g_cross is not stated; `prove TASK --plant` takes any g")
            if task.plant.g_min is None:
                assumptions.append(f"plant.g_min, which is not stated, is {round_down(float(self.bounds[0].eigenvalue_min)):g}")
        if self.shortest and not task.uses_differences:
            assumptions.append("alpha follows (11); what the emitted steps differ from it by is not in the period")
        return assumptions

    @cached_property
    def period(self) -> Period | None:
        """The longest proved period, over all kinds of sampling conditions."""
        proved = [p for p in self.periods.values() if p is not None]
        return max(proved, key=lambda p: p.seconds, default=None)

    @cached_property
    def from_initial_state(self) -> Period | None:
        """The longest period from initial_state alone, None unless it is longer than from all starts of the start share."""
        loop = self.sampled_loop.with_start(self._start_bound([float(v) for v in self.controller.task.initial_state]))
        periods = (longest_proved_period_from(self.shortest, kind, loop) for kind in self.periods)
        best = max((p for p in periods if p is not None), key=lambda p: p.seconds, default=None)
        return None if best is None or (self.period is not None and best.seconds <= self.period.seconds) else best

    @cached_property
    def gains(self) -> Gains:
        """What multiples of the task's gain prove."""
        return Gains(self.sampled_loop, self.sampled_loop.law.gain, self.shortest, self.condition_kinds)

    @property
    def wanted_period(self) -> float:
        """The period in seconds, without the latency, for which proved gains are reported."""
        return float(self.controller.task.sampling_period)

    @property
    def is_covered(self) -> bool:
        """Whether the plant is within the task's table [plant] all over the tube, so that the certificate is about it.

        It is compared in norm where u is scaled, else by component.
        """
        return not uncovered_bounds(self.controller.task, self.bounds)


# ------------------------------------------------------------------------------------------------ by kind of design


@dataclass(frozen=True)
class TubeReading:
    """The windows of a tube, and bounds on its update function where it has one."""

    windows: Windows
    update_function: UpdateFunctionBounds | None = None


def _read_splines(_task: Task, design: RefinedDesign) -> TubeReading:
    return TubeReading(refined_windows(design))


def _read_adaptive(task: Task, design: AdaptiveDesign) -> TubeReading:
    """Enclose the tube in balls, and bound what the repaired Lemma 3.3 needs: psi, alpha and the four gaps."""
    tube = enclosed_tube(task, design)
    psi, alpha, rho, beta = tube.lines.psi, tube.alpha, tube.lines.rho, tube.lines.beta
    low, high = 0, 1
    upper = (rho[:, :, 1, low] + alpha[:, :, 1, low], beta[:, :, 1, low])
    lower = (rho[:, :, 0, high] - alpha[:, :, 0, low], beta[:, :, 0, high])
    gap = min(float((a - b).min()) for a in upper for b in lower)
    bounds = UpdateFunctionBounds(
        round_down(float((psi[..., low] + alpha[..., low]).min())),
        round_down(float(psi[0, ..., low].min())),
        round_up(float(alpha[..., high].max())),
        round_down(gap),
        round_up(math.log(4) / float(design.nu)),
    )
    return TubeReading(enclosed_windows(tube), bounds)


READINGS: Mapping[DesignKind, Callable[[Task, Design], TubeReading]] = {
    "refined": for_any_design(RefinedDesign, _read_splines),
    "adaptive": for_any_design(AdaptiveDesign, _read_adaptive),
    "literal": for_any_design(AdaptiveDesign, _read_adaptive),
}
