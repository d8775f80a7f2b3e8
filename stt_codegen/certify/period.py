"""P9: sampled at `control.period`, from every start in the task's share of gamma(0), under every plant within the bounds of
[plant], the state stays in the tube. The sharp statement (sampling/statements.py, lemmas/sampled.py) in exact fractions.

With rho_i = e^E_i rational, 1/(1 + e^-E) = rho/(1 + rho) and tanh(E/2) = (rho - 1)/(rho + 1); |e| < e_max bounds rho by
(1 + e_max)/(1 - e_max), |e(0)| <= share from below alike. Only logarithms of rationals are left; a series with its remainder
encloses each.

Long because the statement, its search and its refusal are one story.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import Finding, PeriodProof
from stt_codegen.certify.components import Component, inertial_components, inertial_shift, start_ratios
from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.program.enclosed import logarithm
from stt_codegen.program.number import FORMATS, round_down
from stt_codegen.sampling import (
    Gains,
    Period,
    Setting,
    extremes,
    least,
    longest,
    most_room,
)
from stt_codegen.sampling.gains import MUCH, natural_gain, rounded_gain
from stt_codegen.sampling.loops import loop_of
from stt_codegen.sampling.setting import ROUNDING, back
from stt_codegen.task import Task

Array = npt.NDArray[np.float64]
# Above the rho of an E that was found in doubles, as shares of it, until the fractions agree.
TRIED = (Fraction(0), Fraction(1, 10**6), Fraction(1, 10**4), Fraction(1, 10**3))


@dataclass(frozen=True)
class SharpStatement:
    """The sharp statement for one task and tube; `shift`: what the law sees of x and the edges is wrong by, by component. ln:
    encloses a logarithm; the lemmas `sampled.fractions` and `.inputs` run the same code with symbols and another one."""

    task: Task
    design: RefinedDesign
    shift: tuple[Fraction, ...]
    ln: Callable[[Any], tuple[Any, Any]] = logarithm

    @property
    def age(self) -> Fraction:
        """The greatest age of a sample, seconds."""
        assert self.task.control.period is not None
        return self.task.control.period + self.task.control.latency

    @property
    def rounding(self) -> Fraction:
        return Fraction(ROUNDING[self.task.emit.scalar, self.task.emit.math])

    def windows(self) -> Iterator[tuple[Component, ...]]:
        """Every segment and the time after t_c, each with what the one before adds."""
        if self.task.order == 2:
            yield from inertial_components(self.design)
            return
        found, unit = extremes(self.design), self.design.unit
        per_second = 3 * self.design.segments / Fraction(self.design.prescribed_time) * unit
        columns = (found.narrow, back(found.narrow, np.minimum), found.wide, back(found.step, np.maximum))
        for narrow, seen, wide, step in zip(*(v.tolist() for v in columns), strict=True):
            lengths = zip(narrow, seen, wide, step, strict=True)
            yield tuple(Component(a * unit, b * unit, c * unit, d * per_second) for a, b, c, d in lengths)

    def inputs(self, window: tuple[Component, ...], rho: tuple[Fraction, ...]) -> list[Fraction]:
        """U: |u_i| in this window while a/b and b/a stay below rho_i, of what the law may see."""
        task, r, found = self.task, self.rounding, []
        for i, (c, e) in enumerate(zip(window, rho, strict=True)):
            far, near = c.narrow_seen * e / (1 + e) + self.shift[i], c.narrow_seen / (1 + e) - self.shift[i]
            share, width = (1 - task.e_max[i]) / 2, c.narrow_seen - 2 * self.shift[i]
            limit = None if task.u_max is None else round_down(task.u_max[i], task.emit.scalar)
            if near <= (far + near) * share:  # the clamp acts
                far, near = (1 - share) * width, share * width
            if near > 0:
                pull = (1 / far + 1 / near) * (self.ln(far / near)[1] + r)
                u = abs(task.gain[i]) * pull * (1 + r)
                found.append(u if limit is None else min(u, limit))
            elif limit is not None:
                found.append(limit)
            else:
                return []  # noise wider than the tube: no bound is known
        return found

    def holds(self, rho: tuple[Fraction, ...]) -> tuple[Fraction, ...] | None:
        """A bound on |u| by component where the statement holds with these rho; else None."""
        task, late = self.task, self.task.control.latency
        share, segment = task.initial_set.share, task.prescribed_time / self.design.segments
        first = [(1 + share) / (1 - share)] * task.dimension
        if task.order == 2:
            given = start_ratios(task, self.design)
            if given is None:
                return None
            first = given
        for lowest, e, e_max in zip(first, rho, task.e_max, strict=True):
            if not lowest < e <= (1 + e_max) / (1 - e_max):
                return None
        if self.age > (segment / 2 if late else segment):
            return None
        largest = [Fraction(0)] * task.dimension
        for window in self.windows():
            u = self.inputs(window, rho)
            if not (u and all(self._kept(i, window[i], rho[i], u) for i in range(task.dimension))):
                return None
            largest = [max(a, b) for a, b in zip(largest, u, strict=True)]
        return tuple(largest)

    def _kept(self, i: int, c: Component, rho: Fraction, u: list[Fraction]) -> bool:
        """The conditions on component i in one window."""
        task, plant, r, tau = self.task, self.task.plant_bounds[i], self.rounding, self.age
        g_min, g_max = plant.g_min, plant.g_max
        others = plant.cross * (sum(u, Fraction(0)) - u[i])
        push, aged, turned = (plant.force + (c.speed if v is None else v) + others for v in (c.speed, c.drift, c.middle))
        if c.narrow / 2 * ((rho - 1) / (rho + 1) - r) <= (turned + g_max * u[i]) * tau + self.shift[i]:
            return False  # sampled.same_side
        if task.u_max is not None and g_min * round_down(task.u_max[i], task.emit.scalar) <= push:
            return False  # sampled.saturated
        drift = aged * tau + g_max * u[i] * task.control.latency + self.shift[i]
        for d in (c.narrow, c.wide):
            a, b = d * rho / (1 + rho) - drift, d / (1 + rho) + drift
            if a <= b:
                return False  # sampled.ends
            held = (1 / a + 1 / b) * (self.ln(a / b)[0] - r)
            if abs(task.gain[i]) * (1 - r) * g_min * held <= push:
                return False  # sampled.sharp
        return True


def statement_of(
    task: Task, design: RefinedDesign, edge_error: tuple[Fraction, ...], rate: Sequence[Fraction] = ()
) -> SharpStatement:
    """With what the law sees wrong: both edges' arithmetic, x rounded to the scalar, and noise. rate: what the arithmetic moves
    an edge's rate by, for order 2."""
    if task.order == 2:
        return SharpStatement(task, design, inertial_shift(task, design, edge_error, rate))
    size = max(abs(v) for edge in (task.state_space.lower, task.state_space.upper) for v in edge)
    rest = FORMATS[task.emit.scalar].roundoff * size + (task.plant.noise or 0)
    return SharpStatement(task, design, tuple(2 * v + rest for v in edge_error))


def chosen_gain(
    task: Task, design: RefinedDesign, edge_error: tuple[Fraction, ...], rate: Sequence[Fraction] = ()
) -> tuple[Fraction, ...]:
    """control.gain = "auto": the most room at the period. Where no gain is proved for it, that of the longest period, and the
    refusal says what would do."""
    setting = loop_of(task, design, edge_error, rate)
    shape = natural_gain(setting)
    age = float(task.sampling_period + task.control.latency)
    found = most_room(setting, age, statements=("sharp",)) or Gains(setting, shape, statements=("sharp",)).longest
    gain = rounded_gain(shape) if found is None else found[0]
    return tuple(Fraction(f"{k:.12g}") for k in gain.tolist())


def certify_period(
    task: Task, design: RefinedDesign, edge_error: tuple[Fraction, ...], rate: Sequence[Fraction] = ()
) -> tuple[Finding, PeriodProof | None]:
    """P9, and what is proved with it. The margin is in seconds: by how much a longer period is proved."""
    statement, setting = statement_of(task, design, edge_error, rate), loop_of(task, design, edge_error, rate)
    outside = _outside(task, design)
    if outside is not None:
        i, lack, share = outside
        raised = f", or raise initial_set.share to {share:g}" if share < min(task.e_max) else ""
        advice = f"move initial_state inwards{raised}"
        text = f"initial_state within {decimal(task.initial_set.share)} of gamma(0)'s half widths"
        return Finding("P9", text, -lack, Fraction(0), (Fraction(0), Fraction(0)), i + 1, None, advice), None
    age = statement.age
    most = longest("sharp", setting)
    spare = (Fraction(most.seconds) if most is not None else Fraction(0)) - age
    found = _proved(statement, setting, most)
    if found is None:
        lack = min(spare, -age / 1000)  # where the balls alone prove the period, which is no proof here, some lack is told
        return Finding("P9", _told(task), lack, Fraction(0), advice=_advice(task, setting, age)), None
    e = tuple((v - 1) / (v + 1) for v in found.rho)
    of = "|e|" if task.order == 1 else "|e| of v + lambda x"
    text = f"{_told(task)}: {of} < {_bounds(e)}, |u| <= {_bounds(found.u)}"
    return Finding("P9", text, Fraction(str(below(max(spare, Fraction(0)), 3))), Fraction(0)), found


def _outside(task: Task, design: RefinedDesign) -> tuple[int, Fraction, float] | None:
    """The component in which initial_state is farthest outside the share, by how much (a length), and the share that has it; None
    where it is inside."""
    share, edges = task.initial_set.share, design.bezier()[0, :, :, 0]
    ends = [(int(a) * design.unit, int(b) * design.unit) for a, b in edges]
    lack = [abs(x - (a + b) / 2) - share * (b - a) / 2 for x, (a, b) in zip(task.initial_state, ends, strict=True)]
    i = lack.index(max(lack))
    needed = max(abs(2 * x - a - b) / (b - a) for x, (a, b) in zip(task.initial_state, ends, strict=True))
    return (i, lack[i], above(needed, 4)) if lack[i] > 0 else None


def _proved(statement: SharpStatement, setting: Setting, longest_period: Period | None) -> PeriodProof | None:
    """What is proved with the least E that is found for the period; near the longest period only with that of the longest."""
    task, age = statement.task, float(statement.age)
    assert task.control.period is not None
    tried = [least("sharp", setting, age), longest_period if longest_period and longest_period.seconds >= age else None]
    most = [(1 + v) / (1 - v) for v in task.e_max]
    for period, more in itertools.product((p for p in tried if p is not None), TRIED):
        reached = [Fraction(str(above(Fraction(math.exp(v)) * (1 + more), 9))) for v in period.reach]
        rho = tuple(map(min, reached, most))
        u = statement.holds(rho)
        if u is not None:
            return PeriodProof(task.control.period, task.control.latency, task.initial_set.share, rho, u, statement.shift)
    return None


def _bounds(values: tuple[Fraction, ...]) -> str:
    return by_component([above(v, 4) for v in values])


def _told(task: Task) -> str:
    plant, control = task.plant, task.control
    assert control.period is not None
    stated = task.plant_bounds
    force, g_min, g_max, cross = (by_component([getattr(b, k) for b in stated]) for k in ("force", "g_min", "g_max", "cross"))
    g_ii = "g_ii" if task.gain[0] > 0 else "-g_ii"
    g = f"{g_ii} = {g_min}" if g_min == g_max else f"{g_min} <= {g_ii} <= {g_max}"
    told = [f"|f + w| <= {force}", g, f"|g_ij| <= {cross}"]
    told += [f"x measured to {decimal(plant.noise)}"] if plant.noise else []
    told += [f"u {decimal(control.latency)} s after its sample at most, the first at once"] if control.latency else []
    starts = f"|e(0)| <= {decimal(task.initial_set.share)}"
    if task.order == 2:
        at_most = by_component(task.start_speed)
        starts += f" and |v(0)| <= {at_most}" if any(task.start_speed) else " at rest"
        told += [f"v measured to {decimal(plant.noise_v)}"] if plant.noise_v else []
    often = "s or faster"
    if task.differs:
        often = f"s or faster, but not below {decimal(task.shortest_period)} s, with v = (x - x before) / time between"
    at = "at ticks, every" if task.emit.scalar == "fixed" else "every"
    return f"sampled {at} {decimal(control.period)} {often}, from every start with {starts}, for {', '.join(told)}"


def _advice(task: Task, setting: Setting, age: Fraction) -> str:
    """Which gain, period or limit would do, as a task file has them: with the sign of the task's gain."""
    if task.differs:
        why = "the error of a velocity by differences grows with it, what noise adds falls"
        return f"use another control.period ({why}), state less noise, or measure the velocity"
    gains, latency = Gains(setting, natural_gain(setting), statements=("sharp",)), float(task.control.latency)
    sign = 1 if task.gain[0] > 0 else -1

    def shown(gain: Array) -> str:
        return by_component((sign * gain).tolist())

    best = most_room(setting, float(age), statements=("sharp",))
    if best is not None:
        return f'use control.gain = "auto" (here {shown(best[0])})' if sign > 0 else f"use control.gain = {shown(best[0])}"
    told = []
    if gains.longest is not None and gains.longest[1].seconds > latency:
        told.append(f"control.period = {_below(gains.longest[1].seconds - latency):g} with gain {shown(gains.longest[0])}")
    limited = gains.limited
    if limited is not None and limited[2].seconds > max(MUCH * (gains.longest[1].seconds if gains.longest else 0.0), latency):
        seconds = min(_below(limited[2].seconds - latency), float(age) - latency)
        u_max = by_component(limited[0].tolist())
        told.append(f"control.u_max = {u_max} and control.period = {seconds:.6g} with gain {shown(limited[1])}")
    nothing = "no gain is proved for any period: widen or slow the tube, or state a milder plant"
    return f"use {', or '.join(told)}" if told else nothing


def _below(seconds: float) -> float:
    return below(Fraction(seconds), 3)
