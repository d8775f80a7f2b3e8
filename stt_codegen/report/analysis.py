"""What Theorem 4.1 and the sampled statements give for one controller and one plant: hypotheses, and bounds with numbers.

`design` shows the short form, `prove TASK` writes all of it to <p>.bounds.json; bounds.py has both as data.

Long because every number of the report is asked of one setting, which stands here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.adaptive import enclosed_tube, enclosed_windows
from stt_codegen.controller import rate_error
from stt_codegen.decimals import by_component, decimal
from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design, require_refined
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.properties import Property
from stt_codegen.report.bounds import (
    Advice,
    BoundsReport,
    ContinuousBounds,
    Hypothesis,
    PlantOverTube,
    ProvedGains,
    ProvedPeriod,
    Sampling,
    TubeBounds,
    UpdateFunctionBounds,
    above_float,
    below_float,
    rounded,
)
from stt_codegen.report.plant_table import ProposedBounds, propose_bounds, uncovered_bounds
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
    choose_proved_gain,
    condition_kinds_of,
    continuous_input_bound,
    epsilon_star,
    epsilon_star_norm,
    holds_saturated,
    holds_scaled,
    longest_proved_period_from,
    loop_of,
    refined_windows,
    start_bound_of_task,
    velocity_bounds,
    worst_with_previous_window,
)
from stt_codegen.task import Task

Array = npt.NDArray[Any]


class Analysis:
    """A controller with a plant (None: the bounds in the task's [plant]); `noise` bounds the error of a measured
    state, `latency` the seconds from a sample to the input that it makes (in the age of a sample it counts too); None: what the
    task says. `start`: speak of this x(0) alone, in place of all starts in the task's share of gamma(0)."""

    def __init__(
        self,
        controller: EmittedController,
        plant: Model | None = None,
        noise: float | None = None,
        latency: float | None = None,
        start: Sequence[float] | None = None,
    ) -> None:
        task = controller.task
        noise = float(task.plant.noise or 0) if noise is None else noise
        latency = float(task.control.latency) if latency is None else latency
        for name, value in (("--noise", noise), ("--latency", latency)):
            if not (math.isfinite(value) and value >= 0):
                raise BadInput(f"{name} {value:g}: a finite number of 0 or more is needed")
        self.controller, self.noise, self.latency = controller, noise, latency
        self.plant = plant
        self.reading = READINGS[controller.design.kind](task, controller.design)
        self.windows = self.reading.windows
        self.bounds = list(self._bounds(1 if task.gain[0] > 0 else -1))
        self.setting = self._setting(start)
        self.statements = condition_kinds_of(task)
        self.starts = f"|e(0)| <= {decimal(task.initial_set.share)} by component" if start is None else "x(0) as given"
        if task.order == 2 and (start is None or len(start) == task.dimension):
            moving = any(task.start_speed)
            self.starts += f" and |v(0)| <= {by_component(task.start_speed)}" if moving else " and at rest"

    def _setting(self, start: Sequence[float] | None) -> SampledLoop:
        """The loop; of order 2 what is held is v + lambda x."""
        controller, design = self.controller, self.controller.design
        rate = rate_error(require_refined(design), controller.program) if design.filter else ()
        edge, windows = controller.certificate.edge_error, self.windows
        made = loop_of(
            controller.task,
            design,
            edge,
            rate,
            windows=windows,
            bounds=self.bounds,
            noise=self.noise,
            latency=self.latency,
            start=start,
        )
        return replace(made, largest_known_age=min(made.largest_known_age, self.mixed_age))

    def _eps_of(self, state: Sequence[float] | None) -> Array:
        """What |eps(0)| is at most, of a state, or of the starts in the share."""
        return start_bound_of_task(self.controller.task, self.controller.design, self.windows, state)

    def _bounds(self, sign: int) -> Iterator[Bounds]:
        """The plant over every window's box, joined with that of the window before; its g times `sign`."""
        task, w = self.controller.task, self.windows
        if self.plant is None:
            yield from [bounds_of_task(task)] * len(w.narrow)
            return
        enclosure = PlantEnclosure(self.plant, task.dimension, sign, task.order)
        low, high = w.low, w.high
        if task.order == 2:
            slow, fast = velocity_bounds(require_refined(self.controller.design))
            low, high = np.concatenate([low, slow], axis=1), np.concatenate([high, fast], axis=1)
        for a, b in zip(worst_with_previous_window(low, np.minimum), worst_with_previous_window(high, np.maximum), strict=True):
            yield enclosure.over(list(zip(a.tolist(), b.tolist(), strict=True)), self._drift(a, b))

    @property
    def mixed_age(self) -> float:
        """To which age of a sample the bounds on a plant that mixes are known, seconds; without end for others."""
        if self.plant is None or self.plant.mixing is None or self.controller.task.order == 1:
            return math.inf
        return (self.wanted + self.latency) * float(KNOWN_AGE_FACTOR)

    def _drift(self, low: Array, high: Array) -> list[float]:
        """How far x of a sample may be from x in a window of that box: of order 2 as far as it gets in `mixed_age`; of order 1
        both may be anywhere in it."""
        n = self.controller.task.dimension
        far = high[:n] - low[:n]
        if math.isfinite(self.mixed_age):
            far = np.minimum(far, np.maximum(np.abs(low[n:]), np.abs(high[n:])) * self.mixed_age)
        return [float(v) for v in (far + self.noise) * (1 + 1e-12)]

    @property
    def name(self) -> str:
        if self.plant is not None:
            return self.plant.name
        return (
            "[plant] of the task"
            if self.controller.task.plant.is_stated
            else "xdot = u"
            if self.controller.task.gain[0] > 0
            else "xdot = -u"
        )

    # ------------------------------------------------------------------------------------ sampled control

    @cached_property
    def periods(self) -> dict[str, Period | None]:
        """By statement, the longest period proved for the task's gain."""
        known = (
            SAMPLING_CONDITIONS if self.controller.task.order == 1 and not self.controller.task.scales_input else self.statements
        )
        return {statement: longest_proved_period_from(self.shortest, statement, self.setting) for statement in known}

    @property
    def shortest(self) -> float:
        """The shortest period: 0 but for adaptive tubes, whose alpha may not be stepped more finely than is certified, and for a
        velocity by differences."""
        steps = self.controller.certificate.steps
        if self.controller.task.uses_differences:
            return float(self.controller.task.shortest_period)
        return 0.0 if steps is None else float(steps[0])

    @property
    def state_is_outside(self) -> bool:
        """Whether initial_state is none of the starts in the share."""
        state = self._eps_of([float(v) for v in self.controller.task.initial_state])
        return bool((state > self._eps_of(None)).any())

    def assumptions(self) -> list[str]:
        """What the periods rest on and nothing here can show."""
        task, found = self.controller.task, list[str]()
        if task.emit.scalar == "fixed":
            found.append("samples are taken at ticks; `generate` says which gains integers hold beside u_max")
        if task.order == 2:
            found.append("below, |e| is that of v + lambda x in its tube; x stays in its own")
        if task.uses_differences:
            found.append(f"samples are at least {decimal(task.shortest_period)} s apart, and their distance is measured exactly")
        if self.state_is_outside:
            found.append("the start is not initial_state, which is nearer to an edge of gamma(0) than initial_set.share allows")
        if self.plant is None and task.plant.is_stated:
            if task.plant.g_cross is None and task.dimension > 1:
                found.append("g is diagonal, for plant.g_cross is not stated; `prove TASK --plant` takes any g")
            if task.plant.g_min is None:
                found.append(f"plant.g_min, which is not stated, is {below_float(float(self.bounds[0].eigenvalue_min)):g}")
        if self.shortest and not task.uses_differences:
            found.append("alpha follows (11); what the emitted steps differ from it by is not in the period")
        return found

    @cached_property
    def period(self) -> Period | None:
        """The period of the statement that allows the longest."""
        found = [p for p in self.periods.values() if p is not None]
        return max(found, key=lambda p: p.seconds, default=None)

    @cached_property
    def from_initial_state(self) -> Period | None:
        """The longest period from initial_state alone, where that is longer than from all starts of the share."""
        setting = self.setting.with_start(self._eps_of([float(v) for v in self.controller.task.initial_state]))
        found = [p for p in (longest_proved_period_from(self.shortest, name, setting) for name in self.periods) if p is not None]
        best = max(found, key=lambda p: p.seconds, default=None)
        return None if best is None or (self.period is not None and best.seconds <= self.period.seconds) else best

    @cached_property
    def gains(self) -> Gains:
        """What multiples of the task's gain would allow."""
        return Gains(self.setting, self.setting.law.gain, self.shortest, self.statements)

    @property
    def wanted(self) -> float:
        """The period, latency not in it, for which gains are told."""
        return float(self.controller.task.sampling_period)

    # ---------------------------------------------------------------------------------------- hypotheses

    def hypotheses(self) -> Iterator[Hypothesis]:
        s, task, c = self.setting, self.controller.task, self.controller.certificate
        yield Hypothesis("tube", f"the certificate holds: {Property.WIDTH.code} to {Property.ARITHMETIC.code}", c.tube_holds)
        yield Hypothesis("start", f"starts strictly inside gamma(0): {self.starts}", bool(np.isfinite(s.start).all()))
        least = float(s.eigenvalue_min.min())
        sign = "" if task.gain[0] > 0 else "-"
        known = f"{sign}g_s > 0 over the tube" + (f", at least {below_float(least):g}" if math.isfinite(least) else "")
        yield Hypothesis("Assumption 2", known, least > 0)
        clamp = s.law.eps_at_clamp
        inside = (epsilon_star(s) < clamp).all() or (epsilon_star_norm(s) < clamp).all() or self.period is not None
        most = by_component([float(f"{below_float(v):.4g}") for v in clamp.tolist()])
        told = f"eps* <= eps(e_max) = {most} under continuous control, or a sampled statement holds: the clamp never acts"
        yield Hypothesis("Theorem 4.1", told, bool(inside))
        if task.u_max is not None:
            free = self.period is not None or (holds_scaled(s) if task.scales_input else holds_saturated(s))
            free = free or bool(((continuous_input_bound(s) <= s.law.u_max) & (epsilon_star(s) < clamp)).all())
            told = f"control.u_max is at least what the law may ask for, or outdoes all that pushes ({Property.LIMITS.code})"
            yield Hypothesis("saturation", told, free)
        if task.emit.tick_period is not None:
            period = self.period
            enough = period is not None and float(task.emit.tick_period) + self.latency <= period.seconds
            yield Hypothesis("sampling", f"emit.tick_period = {float(task.emit.tick_period):g} s is proved short enough", enough)
        if self.plant is not None and (task.control.period is not None or task.requires_input_limits):
            stated = Property.PERIOD if task.control.period is not None else Property.LIMITS
            told = f"this plant is one of those that {stated.code} is about: {self._stated}"
            easier = self.noise < float(task.plant.noise or 0) or self.latency < float(task.control.latency)
            told += "; asked with less noise or latency than the task's" if easier else ""
            beyond = uncovered_bounds(task, self.bounds)
            told += f"; but {'; '.join(beyond)}" if beyond else ""
            yield Hypothesis("[plant]", told, self.is_covered and not easier)
        if self.reading.update_function is not None:
            yield from _hypotheses_about(self.reading.update_function)

    @property
    def _stated(self) -> str:
        stated = self.controller.task.plant_bounds
        if self.controller.task.scales_input:
            one = stated[0]
            return f"|f + w| <= {decimal(one.force)}, g_s >= {decimal(one.g_min)}, |g| <= {decimal(one.g_max)}"
        force, low, high, cross = (by_component([getattr(b, k) for b in stated]) for k in ("force", "g_min", "g_max", "cross"))
        return f"|f_i + w_i| <= {force}, {low} <= g_ii <= {high}, |g_ij| <= {cross}"

    @property
    def is_covered(self) -> bool:
        """Whether [plant] holds of the plant all over the tube, component by component, or in norm where u is scaled: then what
        the certificate says of plants within [plant] is true of it."""
        return not uncovered_bounds(self.controller.task, self.bounds)

    # -------------------------------------------------------------------------------------------- reports

    # What overflows in a search is infinite, and proves nothing; what is said was shown in balls. So NumPy need not warn.
    @np.errstate(all="ignore")
    def sampling(self) -> Sampling:
        """The proved period at the task's gain, the gain with the longest, the gains for the task's tick or a millisecond."""
        task, own, alone, age = self.controller.task, self.period, self.from_initial_state, self.wanted + self.latency
        sign = 1 if task.gain[0] > 0 else -1
        longest, limited, gains = self.gains.longest, self.gains.limited, self.gains.range(age)
        roomiest = choose_proved_gain(self.setting, age, self.shortest, self.statements)

        def signed(gain: Array) -> tuple[float, ...]:
            return tuple((sign * gain).tolist())

        def advice(found: tuple[Array, Period] | None, u_max: tuple[float, ...] | None = None) -> Advice | None:
            proved = None if found is None else ProvedPeriod.of(found[1], self.latency)
            return None if found is None or proved is None else Advice(signed(found[0]), proved, u_max)

        return Sampling(
            plant=self.name,
            latency=self.latency,
            assumes=tuple(self.assumptions()),
            shortest=above_float(self.shortest),
            shortest_for="control.period_min" if task.uses_differences else "alpha_step",
            starts=self.starts,
            gain=tuple(float(v) for v in task.gain),
            at_this_gain=ProvedPeriod.of(own, self.latency),
            from_initial_state=ProvedPeriod.of(alone, self.latency),
            longest=advice(longest),
            limited=None if limited is None else advice(limited[1:], tuple(limited[0].tolist())),
            wanted=self.wanted,
            roomiest=advice(roomiest),
            gains=None
            if gains is None
            else ProvedGains(
                signed(gains.first), None if gains.last is None else signed(gains.last), gains.first_is_end, gains.last_is_end
            ),
        )

    @np.errstate(all="ignore")
    def report(self) -> BoundsReport:
        """Everything that is known of this loop, rounded outwards for print."""
        controller, s, w = self.controller, self.setting, self.windows
        return BoundsReport(
            task=controller.task.name,
            design=controller.design.kind,
            scalar=controller.program.scalar,
            plant=self.name,
            axes=controller.task.axis_names,
            noise=self.noise,
            latency=self.latency,
            hypotheses=tuple(self.hypotheses()),
            tube=TubeBounds(
                rounded(w.low.min(axis=0), below_float),
                rounded(w.high.max(axis=0), above_float),
                rounded(w.narrow.min(axis=0), below_float),
                rounded(w.wide.max(axis=0), above_float),
                rounded(w.speed.max(axis=0), above_float),
            ),
            plant_over_the_tube=PlantOverTube(
                rounded(np.array([b.disturbance for b in self.bounds]).max(axis=0), above_float),
                rounded(s.diagonal_min.min(axis=0), below_float),
                rounded(s.cross.max(axis=(0, 2)), above_float),
                below_float(float(s.eigenvalue_min.min())),
                above_float(float(s.norm.max())),
            ),
            continuous=ContinuousBounds(
                rounded(epsilon_star(s), above_float),
                above_float(epsilon_star_norm(s)),
                rounded(continuous_input_bound(s), above_float),
            ),
            sampled={name: ProvedPeriod.of(p, self.latency) for name, p in self.periods.items()},
            sampling=self.sampling(),
            update_function=self.reading.update_function,
            proposed=self.proposed,
            filter=tuple(float(v) for v in controller.design.filter),
        )

    @property
    def proposed(self) -> ProposedBounds | None:
        """[plant] for the plant that equations describe, over the tube."""
        if self.plant is None:
            return None
        sign = -1 if self.controller.task.gain[0] > 0 else 1
        return propose_bounds(self.controller.task, self.bounds, Fraction(self.plant.w_max), lambda: list(self._bounds(sign)))


# ------------------------------------------------------------------------------------------------ by kind


@dataclass(frozen=True)
class TubeReading:
    """What the report computes from a design alone: its windows, and bounds on its update function where it has one."""

    windows: Windows
    update_function: UpdateFunctionBounds | None = None


def _read_splines(_task: Task, design: RefinedDesign) -> TubeReading:
    return TubeReading(refined_windows(design))


def _read_adaptive(task: Task, design: AdaptiveDesign) -> TubeReading:
    """Read the tube in balls, and with it what the statements about the rate of the update function need."""
    tube = enclosed_tube(task, design)
    psi, alpha, rho, beta = tube.lines.psi, tube.alpha, tube.lines.rho, tube.lines.beta
    low, high = 0, 1
    upper = (rho[:, :, 1, low] + alpha[:, :, 1, low], beta[:, :, 1, low])
    lower = (rho[:, :, 0, high] - alpha[:, :, 0, low], beta[:, :, 0, high])
    gap = min(float((a - b).min()) for a in upper for b in lower)
    bounds = UpdateFunctionBounds(
        below_float(float((psi[..., low] + alpha[..., low]).min())),
        below_float(float(psi[0, ..., low].min())),
        above_float(float(alpha[..., high].max())),
        below_float(gap),
        above_float(math.log(4) / float(design.nu)),
    )
    return TubeReading(enclosed_windows(tube), bounds)


def _hypotheses_about(bounds: UpdateFunctionBounds) -> list[Hypothesis]:
    """Return Lemma 3.3 repaired, and the four gaps, for an update function within these bounds."""
    gap, star = bounds.least_gap, bounds.s_star
    if gap is None or star is None:
        return [Hypothesis("update function", "psi + alpha is bounded away from 0", False)]
    required = bounds.ln4_over_nu
    return [
        Hypothesis("update function", f"psi + alpha >= s* = {star:g} > 0", star > 0),
        Hypothesis("four gaps", f"the least gap, {gap:g}, is above ln 4/nu = {required:g}", gap > required),
    ]


READINGS: Mapping[DesignKind, Callable[[Task, Design], TubeReading]] = {
    "refined": for_any_design(RefinedDesign, _read_splines),
    "adaptive": for_any_design(AdaptiveDesign, _read_adaptive),
    "literal": for_any_design(AdaptiveDesign, _read_adaptive),
}
