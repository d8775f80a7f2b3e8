"""Why a sampling period is not proved, in words: on which axis, and which numbers are beside each other."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.sampling import SampledLoop, longest_proved_period, needed_input
from stt_codegen.sampling.path import Drive
from stt_codegen.task import Task

DIFFERENCES_ADVICE = (
    "use another control.period (the error of a velocity by differences grows with it, what noise adds falls), state less noise, "
    "or measure the velocity"
)
NOISE_SHARE = 1 / 20  # of the tube's width: a smaller error of the measured state is not what leaves no room
LATE_SHARE = 1 / 8  # of the time in which x crosses the tube: an input that is later may be too late, whatever the gain
SAMPLE_AGE_SHARE = 0.6  # of the age of a sample, that counts like a delay of the drive


class LongestProof(NamedTuple):
    """The longest proved period in seconds.

    bottleneck: from when to when, and on which axis (from 1; 0 for all), it fails first.
    """

    seconds: Fraction
    bottleneck: tuple[float, float, int] | None = None


class PeriodFailure(NamedTuple):
    """What is wrong, the axis (from 0) that fails, None for no one axis, what may help, and the keys that it is about."""

    problem: str
    axis: int | None
    hint: str
    about: tuple[str, ...] = ()


def explain_period(task: Task, loop: SampledLoop, longest: LongestProof | None) -> PeriodFailure:
    """Return why the task's period is not proved. loop: in doubles; longest: at the task's gain, None where none is proved."""
    weak = _axis_without_authority(task, loop)
    if weak is not None:
        needed, limit = needed_input(loop)[weak], loop.law.u_max[weak]
        against = f"|u| must exceed {above(Fraction(needed), 3):g} to outweigh the edges, f, w and coupling"
        key, norm, stated = task.limit_key, task.control.u_norm, task.stated_u_max
        limit_words = f"{key} is {limit:g}"
        if key == "control.u_norm" and norm is not None:
            limit_words = f"{key} = {decimal(norm)} leaves {limit:g} there"
        elif stated is not None and task.u_max is not None and task.u_max[weak] < stated[weak]:  # in proportion to another axis
            limit_words = f"{key} = {by_component(stated)} leaves {limit:g} there"
        problem = f"in {task.axis_words[weak]} {against}, and {limit_words}"
        return PeriodFailure(problem, weak, f"raise {key} or prescribed_time", (key, "prescribed_time"))
    gain = f"gain {by_component(task.gain)}"
    if task.uses_differences:  # the error of v is known for the task's own period alone
        problem = f"control.period = {decimal(task.sampling_period)} s is not proved with {gain} and a velocity by differences"
        return PeriodFailure(problem, None, DIFFERENCES_ADVICE)
    if longest is not None and longest.seconds > 0:
        problem = f"control.period = {decimal(task.sampling_period)} s is too long"
        problem += f"; {below(longest.seconds, 3):g} s is the longest that is proved with {gain}"
        hint, about = "lower control.period", ("control.period",)  # a larger limit of u is proved for a shorter one
        begin, end, dimension = longest.bottleneck or (0.0, 0.0, 0)
        if not dimension:
            return PeriodFailure(problem, None, hint, about)
        first = f"{task.axis_words[dimension - 1]} fails first, at t in [{begin:.3g}, {end:.3g}] s"
        return PeriodFailure(f"{problem}, where {first}", dimension - 1, hint, about)
    noisy = _axis_without_room_for_noise(task, loop)
    problem = f"no period is proved with {gain}"
    if noisy is not None:
        return _noise_failure(task, loop, noisy, problem)
    axis, delay, crossing = _latest_axis(task, loop)
    if delay < LATE_SHARE * crossing:  # then the gain is to blame
        return PeriodFailure(problem, None, 'state control.gain = "auto"', ("control.gain",))
    problem += f": in {task.axis_words[axis]} the input is late by {delay:.3g} s "
    problem += f"(drive, and {SAMPLE_AGE_SHARE:g} of latency and period); the state crosses the tube in {crossing:.3g} s"
    return PeriodFailure(problem, axis, "state a quicker drive, or more time", ("control.latency", "plant.lag", "plant.lag2"))


def _axis_without_authority(task: Task, loop: SampledLoop) -> int | None:
    """Return the axis whose limit of u is farthest below what is needed there; None where every limit is enough."""
    if task.u_max is None:
        return None
    ratio = needed_input(loop) / loop.law.u_max
    axis = int(ratio.argmax())
    return axis if ratio[axis] >= 1 else None


def _axis_without_room_for_noise(task: Task, loop: SampledLoop) -> int | None:
    """Return the axis whose tube is narrowest beside the error of its measured state; None where noise is not to blame.

    It is where the error is half of the width, so that the side of the middle is not known, or where a period is proved as soon
    as the state is measured exactly.
    """
    share = (loop.law.shift / loop.windows.narrow).max(axis=0)
    axis = int(share.argmax())
    if not (task.noise[axis] or task.noise_v[axis]):
        return None
    is_to_blame = share[axis] >= 1 / 2 or (
        share[axis] >= NOISE_SHARE and longest_proved_period("sharp", loop.with_law(shift=loop.law.shift * 0)) is not None
    )
    return axis if is_to_blame else None


def _noise_failure(task: Task, loop: SampledLoop, axis: int, problem: str) -> PeriodFailure:
    """Return the failure of an axis on which the error of the measured state is large beside the tube's width."""
    error, width = loop.law.shift[axis], below(Fraction(loop.windows.narrow[:, axis].min()), 3)
    keys = [key for key, values in (("plant.noise", task.noise), ("plant.noise_v", task.noise_v)) if values and values[axis]]
    measured = "x" if task.order == 1 else "v + lambda x"
    unit = f" {task.units[axis]}{'' if task.order == 1 else '/s'}" if task.units and task.units[axis] else ""
    problem += (
        f": in {task.axis_words[axis]} {measured} is measured to {error:.3g}{unit} ({' and '.join(keys)}), and its tube is "
    )
    problem += f"{width:g}{unit} wide where it is narrowest"
    return PeriodFailure(problem, axis, "state less noise there, or widen the tube", tuple(keys))


def _latest_axis(task: Task, loop: SampledLoop) -> tuple[int, float, float]:
    """Return the axis on which the input is latest beside the tube: its delay, and the least width over closing speed."""
    drives = [Drive.of(bounds) for bounds in task.drive_bounds]
    limits = task.u_max or (Fraction(1),) * task.dimension
    age = SAMPLE_AGE_SHARE * float(task.sampling_period + task.control.latency)
    delays = np.array([float(drive.delay(u)) + age for drive, u in zip(drives, limits, strict=True)])
    with np.errstate(divide="ignore"):
        crossings = (loop.windows.narrow / loop.closing_speed).min(axis=0)
    axis = int((delays / crossings).argmax())
    return axis, float(delays[axis]), float(crossings[axis])
