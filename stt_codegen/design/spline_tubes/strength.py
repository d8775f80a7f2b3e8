"""How well a tube bears sampled and late inputs, before there is a program.

`tube.prefer` and the search for other tubes (design/refine.py) compare tubes by it.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from stt_codegen.designs import RefinedDesign
from stt_codegen.sampling import (
    LIMIT_FACTORS,
    Gains,
    SampledLoop,
    balancing_gain,
    condition_kinds_of,
    limits_for,
    loop_of,
    loop_without_limits,
    needed_input,
)
from stt_codegen.task import Task, with_assumed_plant

PROMISING_RATIO = 0.97  # times the crossing time of a tube that is not certified: a tube that is quicker to cross is not tried


class Strength(NamedTuple):
    """How well a tube bears late inputs: the time in which x crosses it, seconds, and whether u outweighs all that acts."""

    crossing_time: float
    has_authority: bool

    def is_promising_beside(self, failing: Strength) -> bool:
        """Return whether a tube may be certified although another one of the task is not."""
        is_slower = self.crossing_time > PROMISING_RATIO * failing.crossing_time
        return self.has_authority and (is_slower or not failing.has_authority)


def strength_of(task: Task, design: RefinedDesign, allowance: Fraction) -> Strength:
    """Return how well a tube bears late inputs. allowance: as in `longest_period`."""
    _, loop = _loop_with_choices(task, design, allowance)
    with np.errstate(all="ignore"):
        crossing_time = float((loop.windows.narrow / loop.closing_speed).min())
        return Strength(crossing_time, bool((needed_input(loop) < loop.law.u_max).all()))


def crossing_time(task: Task, design: RefinedDesign, allowance: Fraction) -> float:
    """Return the least width over closing speed of any window and component, in seconds, without the others' inputs; a
    proved lag is a part of it.
    """
    return strength_of(task, design, allowance).crossing_time


def _loop_with_choices(task: Task, design: RefinedDesign, allowance: Fraction) -> tuple[Task, SampledLoop]:
    """Return the task with the plant and the limit that it leaves open, and its loop with this tube."""
    edge, rate = ((v,) * task.dimension for v in (allowance, allowance * design.segments / design.prescribed_time))
    task = with_assumed_plant(task, design.edge_speed_bounds())
    if task.has_automatic_limit:
        unlimited = loop_without_limits(task, design, edge, rate)
        task = task.with_choices(u_max=limits_for(task, unlimited, LIMIT_FACTORS[0]))
    return task, loop_of(task, design, edge, rate)


def longest_period(task: Task, design: RefinedDesign, allowance: Fraction) -> float:
    """Return the longest sampling period, in seconds, that is proved for the plant bounds and the start share.

    It is at the task's gain, or over all gains where that is left open; 0 where there is none. allowance: for the arithmetic,
    whose error is not derived yet.
    """
    task, loop = _loop_with_choices(task, design, allowance)
    kinds = condition_kinds_of(task)
    if task.control.gain is None or task.has_automatic_gain:
        best = Gains(loop, balancing_gain(loop), kinds=kinds).with_longest_period
        return 0.0 if best is None else best.period.seconds
    period = Gains(loop, loop.law.gain, kinds=kinds).longest_period_at(loop.law.gain)
    return 0.0 if period is None else period.seconds
