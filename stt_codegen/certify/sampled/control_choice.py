"""What the tool chooses for a tube where a task with a period leaves it open: the assumed plant, the limit of u, the gain."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.sampled.late_inputs import disturbances
from stt_codegen.designs import RefinedDesign
from stt_codegen.sampling import (
    LIMIT_FACTORS,
    Gains,
    SampledLoop,
    balancing_gain,
    choose_proved_gain,
    exact_loop,
    limits_for,
    loop_of,
    path_loop_of,
    rounded_gain,
)
from stt_codegen.sampling.path import PathLoop, choose_path_gain, prove_path, reserve_of_gain, with_gain
from stt_codegen.task import Task, with_assumed_plant

PERIOD_WITH_MARGIN = Fraction(1001, 1000)  # times the period for which a gain is chosen

ArithmeticErrors = tuple[Sequence[Fraction], Sequence[Fraction]]


class ControlChoice(NamedTuple):
    """A task with limit and gain, and the factor of the disturbance for which the worst path proves it; 0 for no proof."""

    task: Task
    reserve: Fraction


# An overflow in a search is infinite, and proves nothing; what is returned was proved in fractions. So NumPy need not warn.
@np.errstate(all="ignore")
def choose_control(task: Task, design: RefinedDesign, edge_error: Sequence[Fraction], rate: Sequence[Fraction] = ()) -> Task:
    """Return the task with what it leaves open chosen for this tube: its plant, u_max and the gain.

    u_max is 1.5 times the needed input. Where the drive lags it is the first of LIMIT_FACTORS that is proved with the reserve, or
    the one with the largest part of it; the same where 1.5 times is not proved at all. edge_error, rate: bounds on the
    arithmetic's error of an edge and of its rate, by dimension.
    """
    task = with_assumed_plant(task, design.edge_speed_bounds())
    errors = (edge_error, rate)
    if not task.has_automatic_limit:
        return _with_gain(task, design, errors).task if task.has_automatic_gain else task
    # the input that is needed does not depend on the limit, and a velocity by differences cannot be read without one
    loop = loop_of(task.with_choices(u_max=(Fraction(1),) * task.dimension), design, *errors)
    acts_at_once = all(bounds.acts_at_once for bounds in task.drive_bounds)
    choices: list[ControlChoice] = []
    for factor in LIMIT_FACTORS:
        choices.append(_with_gain(task.with_choices(u_max=limits_for(loop, factor)), design, errors))
        if choices[-1].reserve >= (1 if acts_at_once else task.reserve):
            break
    return max(choices, key=lambda choice: choice.reserve).task


def _with_gain(task: Task, design: RefinedDesign, errors: ArithmeticErrors) -> ControlChoice:
    """Return the task, whose u_max is known, with the gain that it states or else the one that is chosen."""
    # a little longer than the period, since the arithmetic's errors with the chosen gain are not known yet
    path_loop = path_loop_of(task, design, exact_loop(task, design, *errors))
    path_loop = path_loop.with_period(task.sampling_period * PERIOD_WITH_MARGIN)
    if not task.has_automatic_gain:
        return ControlChoice(task, reserve_of_gain(path_loop, disturbances(task), task.reserve) or Fraction(0))
    if task.control.gain != "tight":
        choice = choose_path_gain(path_loop, disturbances(task), task.resting_error, task.reserve)
        if choice is not None:
            return ControlChoice(task.with_choices(gain=choice.gain), choice.reserve)
    gain = _tight_gain(task, loop_of(task, design, *errors), path_loop)
    reserve = reserve_of_gain(with_gain(path_loop, gain), disturbances(task), task.reserve)
    return ControlChoice(task.with_choices(gain=gain), reserve or Fraction(0))


def _tight_gain(task: Task, loop: SampledLoop, path_loop: PathLoop) -> tuple[Fraction, ...]:
    """Return the gain that keeps |e| smallest at the task's period: control.gain = "tight".

    Where the drive lags, or the sharp conditions prove no gain for the period, it is the gentlest that the worst path proves.
    Where no gain is proved at all, it is that of the longest period; the refusal then says what would do.
    """
    age = float(task.sampling_period + task.control.latency)
    acts_at_once = all(bounds.acts_at_once for bounds in task.drive_bounds)
    choice = choose_proved_gain(loop, age, kinds=("sharp",)) if acts_at_once else None
    gain = None if choice is None else _as_fractions(choice.gain)
    if gain is None or (task.has_late_input and prove_path(with_gain(path_loop, gain)) is None):
        gentle = choose_path_gain(path_loop, disturbances(task), task.resting_error, task.reserve)
        gain = gain if gentle is None else gentle.gain
    if gain is None:
        proportions = balancing_gain(loop)
        longest = Gains(loop, proportions, kinds=("sharp",)).with_longest_period
        gain = _as_fractions(rounded_gain(proportions) if longest is None else longest.gain)
    return gain


def _as_fractions(gain: npt.NDArray[np.float64]) -> tuple[Fraction, ...]:
    return tuple(Fraction(f"{k:.12g}") for k in gain.tolist())
