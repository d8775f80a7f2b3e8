"""What the tool chooses for a tube where a task with a period leaves it open: the assumed plant, the limit of u, the gain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.sampled.late_inputs import disturbances
from stt_codegen.designs import RefinedDesign
from stt_codegen.sampling import (
    LIMIT_FACTORS,
    SMALL_LIMIT_FACTORS,
    Gains,
    SampledLoop,
    balancing_gain,
    choose_proved_gain,
    exact_loop,
    limits_for,
    loop_of,
    loop_without_limits,
    needed_input,
    path_loop_of,
    prove_for_period,
    rounded_gain,
)
from stt_codegen.sampling.path import PathGain, PathLoop, choose_path_gain, prove_path, reserve_of_gain, with_gain
from stt_codegen.task import Task, with_assumed_plant

PERIOD_WITH_MARGIN = Fraction(1001, 1000)  # times the period for which a gain is chosen

ArithmeticErrors = tuple[Sequence[Fraction], Sequence[Fraction]]


class ControlChoice(NamedTuple):
    """A task with limit and gain, and the factor of the disturbance for which the worst path proves it; 0 for no such proof.

    is_proved: whether the path or the sharp conditions prove the period.
    """

    task: Task
    reserve: Fraction
    is_proved: bool


# An overflow in a search is infinite, and proves nothing; what is returned was proved in fractions. So NumPy need not warn.
@np.errstate(all="ignore")
def choose_control(task: Task, design: RefinedDesign, edge_error: Sequence[Fraction], rate: Sequence[Fraction] = ()) -> Task:
    """Return the task with what it leaves open chosen for this tube: its plant, u_max and the gain.

    u_max is 1.5 times the needed input, or what control.u_norm leaves of that. Where the drive lags it is the first of
    LIMIT_FACTORS that is proved with the reserve, or the one with the largest part of it; the same where 1.5 times is not proved
    at all. Where none of them is proved it is the largest of SMALL_LIMIT_FACTORS that is. edge_error, rate: bounds on the
    arithmetic's error of an edge and of its rate, by dimension.
    """
    task, errors = with_assumed_plant(task, design.edge_speed_bounds()), (edge_error, rate)
    if not (task.has_automatic_limit or task.has_automatic_gain):
        return task
    choices: list[ControlChoice] = []
    acts_at_once = all(bounds.acts_at_once for bounds in task.drive_bounds)
    for task_with_limit in _with_limits(task, design, errors, LIMIT_FACTORS):
        choices.append(_with_gain(task_with_limit, design, errors, task.reserve))
        if choices[-1].reserve >= (1 if acts_at_once else task.reserve):
            break
    if not any(choice.is_proved for choice in choices) and task.has_automatic_limit:
        choices += _with_small_limit(task, design, errors)
    best = max(choices, key=lambda choice: (choice.reserve, choice.is_proved))
    if best.is_proved or not task.has_automatic_gain:
        return best.task
    return choices[0].task.with_choices(gain=_longest_gain(choices[0].task, design, errors))


@np.errstate(all="ignore")
def is_any_control_proved(
    task: Task, design: RefinedDesign, edge_error: Sequence[Fraction], rate: Sequence[Fraction] = ()
) -> bool:
    """Return whether the worst path or the sharp conditions prove the period for a choice of what the task leaves open.

    Of the limits of u that `choose_control` tries, the first, the smallest and the largest are tried here, and no reserve is
    asked for.
    """
    task, errors = with_assumed_plant(task, design.edge_speed_bounds()), (edge_error, rate)
    limited_tasks = _with_limits(task, design, errors, (LIMIT_FACTORS[0], SMALL_LIMIT_FACTORS[-1], LIMIT_FACTORS[-1]))
    if task.control.u_norm is not None:  # without authority no gain is proved, and the search would take long to say so
        limited_tasks = (v for v in limited_tasks if _has_authority(loop_of(v, design, *errors)))
    return any(_with_gain(limited_task, design, errors, Fraction(1)).is_proved for limited_task in limited_tasks)


def _has_authority(loop: SampledLoop) -> bool:
    """Return whether u outweighs all that acts, in every component."""
    return bool((needed_input(loop) < loop.law.u_max).all())


def _with_limits(task: Task, design: RefinedDesign, errors: ArithmeticErrors, factors: Sequence[Fraction]) -> Iterator[Task]:
    """Yield the task with each of the limits of u: so many times the needed input. A limit that the task states stays."""
    if not task.has_automatic_limit:
        yield task
        return
    loop = loop_without_limits(task, design, *errors)
    limits = dict.fromkeys(limits_for(task, loop, factor) for factor in factors)  # control.u_norm may leave the same of several
    yield from (task.with_choices(u_max=limit) for limit in limits)


def _with_small_limit(task: Task, design: RefinedDesign, errors: ArithmeticErrors) -> list[ControlChoice]:
    """Return the choice with the largest of the small limits that is proved; none where not even the smallest is."""
    *larger, smallest = _with_limits(task, design, errors, SMALL_LIMIT_FACTORS)
    smallest_choice = _with_gain(smallest, design, errors, task.reserve)
    if not smallest_choice.is_proved:
        return []
    choices = (_with_gain(task_with_limit, design, errors, task.reserve) for task_with_limit in larger)
    return [next((choice for choice in choices if choice.is_proved), smallest_choice)]


def _with_gain(task: Task, design: RefinedDesign, errors: ArithmeticErrors, reserve: Fraction) -> ControlChoice:
    """Return the task, whose u_max is known, with the gain that it states or else the one that is chosen for a reserve."""
    # a little longer than the period, since the arithmetic's errors with the chosen gain are not known yet
    path_loop = path_loop_of(task, design, exact_loop(task, design, *errors))
    path_loop = path_loop.with_period(task.sampling_period * PERIOD_WITH_MARGIN)
    loop = loop_of(task, design, *errors)
    if not task.has_automatic_gain:
        return _judge_control(task, loop, path_loop, reserve)
    gentle = choose_path_gain(path_loop, disturbances(task), task.resting_error, reserve)
    if task.control.gain != "tight" and gentle is not None:
        return ControlChoice(task.with_choices(gain=gentle.gain), gentle.reserve, is_proved=True)
    gain = _tight_gain(task, loop, path_loop, gentle)
    if gain is None:
        return ControlChoice(task, Fraction(0), is_proved=False)
    tight_loop = loop.with_law(gain=np.array([float(k) for k in gain]))
    return _judge_control(task.with_choices(gain=gain), tight_loop, with_gain(path_loop, gain), reserve)


def _judge_control(task: Task, loop: SampledLoop, path_loop: PathLoop, reserve: Fraction) -> ControlChoice:
    """Return the choice of the task's own limit and gain, which both loops have."""
    proved_reserve = reserve_of_gain(path_loop, disturbances(task), reserve)
    is_proved = proved_reserve is not None
    if not is_proved and not task.has_late_input:
        is_proved = prove_for_period("sharp", loop, float(task.sampling_period)) is not None
    return ControlChoice(task, proved_reserve or Fraction(0), is_proved)


def _tight_gain(task: Task, loop: SampledLoop, path_loop: PathLoop, gentle: PathGain | None) -> tuple[Fraction, ...] | None:
    """Return the gain that keeps |e| smallest at the task's period: control.gain = "tight".

    Where the drive lags, or the sharp conditions prove no gain for the period, it is the gentlest that the worst path proves.
    None where no gain is proved at all.
    """
    age = float(task.sampling_period + task.control.latency)
    acts_at_once = all(bounds.acts_at_once for bounds in task.drive_bounds)
    choice = choose_proved_gain(loop, age, kinds=("sharp",)) if acts_at_once else None
    gain = None if choice is None else _as_fractions(choice.gain)
    if gain is None or (task.has_late_input and prove_path(with_gain(path_loop, gain)) is None):
        return gain if gentle is None else gentle.gain
    return gain


def _longest_gain(task: Task, design: RefinedDesign, errors: ArithmeticErrors) -> tuple[Fraction, ...]:
    """Return the gain of the longest period, for a task whose own period no gain is proved for; the refusal says so."""
    loop = loop_of(task, design, *errors)
    proportions = balancing_gain(loop)
    longest = Gains(loop, proportions, kinds=("sharp",)).with_longest_period
    return _as_fractions(rounded_gain(proportions) if longest is None else longest.gain)


def _as_fractions(gain: npt.NDArray[np.float64]) -> tuple[Fraction, ...]:
    return tuple(Fraction(f"{k:.12g}") for k in gain.tolist())
