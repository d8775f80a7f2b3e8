"""The lag, latency and overshoot of a drive from a recorded step of its command.

S(t) is the response as a share of the step, t after the command. docs/sampling-path.md, section 3 says what P9 assumes of it:

    S never falls and is never below 1 - e^(-(t - latency)/lag)             without overshoot
    S+(t)/(1 + nu) >= 1 - e^(-(t - latency)/lag), nu = M/(1 - M)            with an overshoot by the share M

S+ is the sum of all rises until t, and nu the sum of all falls. A record shows samples with noise. So everything is taken
against the drive: the command came right after the last sample that does not show it, the response is what the sample before
showed, and it is lower by the noise. The noise is NOISE_FACTOR times the largest deviation while the drive rests.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.decimals import above
from stt_codegen.errors import BadInput
from stt_codegen.steps.recording import StepRecord

Array = npt.NDArray[np.float64]
COMMAND_TOLERANCE = 0.01  # of the step: commands this near to another count as equal
TAIL_SHARE = 0.2  # of the time after the step: the end of the record, where the response must have settled
FEWEST_SAMPLES = 20  # after the step
FEWEST_TAIL_SAMPLES = 8
NOISE_FACTOR = 1.5
LARGEST_HIDDEN_SHARE = 0.15  # of the step
DRIFT_LIMIT = 0.005  # of the step, between the halves of the tail
SMALLEST_FALL = 0.002  # of the step; smaller ones are not seen
MISSED_PEAK = 0.05  # of the largest change between samples: by how much a peak may be above the samples beside it
SMALLEST_HIDDEN_SHARE = 0.005  # of the step, at its end
LATENCY_WEIGHT = 0.6  # of a second of latency beside a second of lag, in what a tube allows
LATENCY_CANDIDATES = 400
DIGITS = 3
SMALLEST_CHANGE = 1e-9  # of the range of the response: smaller ones are rounding of the numbers in the record
TIME_ROUNDING = 1e-6  # relative: times in decimals are equal up to this


@dataclass(frozen=True, kw_only=True)
class StepEnvelope:
    """What `[plant]` and `[control]` may state of a drive, and how the record shows it.

    lag, latency: seconds. overshoot: a share of the step. gain: response over command, at rest. command: before and after the
    step. step_time: of the first sample that shows it, seconds. sample_time: the longest between samples. Shares of the step are
    noise, by which every sample counts as lower; hidden, at its end, about which the record says nothing; and smallest_fall, the
    smallest fall that is seen.
    """

    lag: float
    latency: float
    overshoot: float
    gain: float
    command: tuple[float, float]
    step_time: float
    sample_time: float
    noise: float
    hidden: float
    smallest_fall: float
    samples: int
    columns: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """Return the envelope as JSON data."""
        return asdict(self)


@dataclass(frozen=True, kw_only=True)
class _Response:
    """The response after the step: seconds since the earliest time of the command, shares of the step; noise and drift too, and
    the numbers of samples at rest before the step and after it."""

    time: Array
    share: Array
    noise: float
    drift: float
    before: int
    after: int
    size: float

    @property
    def smallest_fall(self) -> float:
        """A fall that noise cannot make."""
        return max(2 * self.noise, SMALLEST_FALL)


class _Rises(NamedTuple):
    """Lower bounds by sample of S+/(1 + nu), as a share; overshoot: the M of nu = M/(1 - M), 0 where S is not seen to fall."""

    share: Array
    overshoot: float


def envelope_of(record: StepRecord, latency: float | None = None, name: str = "record") -> StepEnvelope:
    """Return the lag, latency and overshoot that hold for a drive by its recorded step.

    latency: seconds, where it is known; None: the one with the least lag + 0.6 latency. Raises `BadInput`, which begins with
    `name`, for a record that does not show one step from rest to rest.
    """
    if latency is not None and not (math.isfinite(latency) and latency >= 0):
        raise BadInput(f"--latency {latency:g}: a finite number of 0 or more is needed")
    step = _step_index(record, name)
    response = _response(record, step, name)
    rises = _rises(response)
    hidden = max(2 * (1 - float(rises.share[-1])), 2 * response.noise, SMALLEST_HIDDEN_SHARE)
    if hidden > LARGEST_HIDDEN_SHARE:
        problem = f"noise of {100 * response.noise:.2g} % of the step hides {100 * hidden:.2g} % of the response"
        problem += f", at most {100 * LARGEST_HIDDEN_SHARE:g} %"
        raise BadInput(f"{name}: {problem}; record a larger step, or the mean of several")
    times, shares = _visible(response.time, rises.share, hidden)
    first_latency = _up(float(times[shares <= 0].max(initial=0.0)))
    if latency is None:
        latency = _best_latency(times, shares, first_latency)
    elif latency < first_latency:
        problem = f"the response is not above the noise before {first_latency:g} s, counted from the sample before the step"
        raise BadInput(f"--latency {latency:g}: {problem}; use {first_latency:g} or more, or leave it out")
    command = (record.command[step - 1], record.command[step])
    return StepEnvelope(
        lag=_up(_lag(times, shares, latency)),
        latency=latency,
        overshoot=rises.overshoot,
        gain=response.size / (command[1] - command[0]),
        command=command,
        step_time=record.time[step],
        sample_time=float(np.diff(record.time[step - 1 :]).max()),
        noise=response.noise,
        hidden=hidden,
        smallest_fall=response.smallest_fall,
        samples=len(record.time),
        columns=record.columns,
    )


def _up(value: float) -> float:
    """Round up to DIGITS digits; what is above them by rounding alone stays."""
    return above(Fraction(value * (1 - TIME_ROUNDING)), DIGITS)


def _step_index(record: StepRecord, name: str) -> int:
    """Return the index of the first sample that shows the new command. Raises `BadInput` unless there is one step."""
    command = np.array(record.command)
    tolerance = COMMAND_TOLERANCE * float(np.ptp(command))
    if tolerance == 0:
        raise BadInput(f"{name}: the command is {command[0]:g} all along; rows before and after a step of it are needed")
    changes = np.flatnonzero(np.abs(np.diff(command)) > tolerance) + 1
    if len(changes) != 1:
        k = int(changes[min(1, len(changes) - 1)]) if len(changes) else 0
        problem = f"the command changes again, to {command[k]:g}" if len(changes) else "the command changes little by little"
        raise BadInput(f"{name}, line {record.lines[k]}: {problem}; keep the rows of one step, from rest to rest")
    step = int(changes[0])
    levels = np.where(np.arange(len(command)) < step, command[step - 1], command[step])
    moved = np.flatnonzero(np.abs(command - levels) > tolerance)
    if len(moved):
        k = int(moved[0])
        problem = f"the command is {command[k]:g}, and {levels[k]:g} beside the step"
        raise BadInput(f"{name}, line {record.lines[k]}: {problem}; keep the rows in which the command rests")
    return step


def _response(record: StepRecord, step: int, name: str) -> _Response:
    """Return the response as shares of the step. Raises `BadInput` where it does not move, settle, or rise above its noise."""
    time, response = np.array(record.time), np.array(record.response)
    tail = time >= time[-1] - TAIL_SHARE * (time[-1] - time[step])
    if len(time) - step < FEWEST_SAMPLES or tail.sum() < FEWEST_TAIL_SAMPLES:
        needed = f"at least {FEWEST_SAMPLES}, and {FEWEST_TAIL_SAMPLES} of them in the last fifth, are needed"
        raise BadInput(f"{name}: has {len(time) - step} rows after the step; {needed}")
    start, final = response[:step].mean(), response[tail].mean()
    deviation = max(np.abs(response[:step] - start).max(), np.abs(response[tail] - final).max())
    size = float(final - start)
    if not abs(size) > deviation:
        raise BadInput(f"{name}: the response does not follow the command: it goes from {start:.4g} to {final:.4g}")
    if size * (record.command[step] - record.command[step - 1]) < 0:
        problem = f"the response goes from {start:.4g} to {final:.4g}, against the command"
        raise BadInput(f"{name}: {problem}; change the sign of one of the columns")
    share, (early, late) = (response - start) / size, np.array_split((response[tail] - start) / size, 2)
    drift = abs(float(late.mean() - early.mean()))
    spread = math.hypot(float(early.std()), float(late.std())) / math.sqrt(len(early))
    if drift > DRIFT_LIMIT + 3 * spread:
        problem = f"the response has not settled: in the last fifth it still moves by {100 * drift:.2g} % of the step"
        raise BadInput(f"{name}: {problem}; record longer after the step")
    noise = max(NOISE_FACTOR * float(deviation), _resolution(response)) / abs(size)
    return _Response(
        time=time[step:] - time[step - 1],
        share=share[step:],
        noise=noise,
        drift=drift,
        before=step,
        after=int(tail.sum()),
        size=size,
    )


def _resolution(response: Array) -> float:
    """Return the step of a coarse sensor, which shows no noise at rest: all changes are multiples of it, and not all are equal.

    It is 0 for a sensor that is not coarse. A ramp changes by the same amount again and again, and may be seen precisely.
    """
    changes = np.abs(np.diff(response))
    moving = np.flatnonzero(changes > SMALLEST_CHANGE * np.ptp(response))
    if not len(moving):
        return 0.0
    way = changes[moving[0] : moving[-1] + 1]
    step = float(changes[moving].min())
    multiples = np.rint(way / step)
    is_coarse = bool((np.abs(way - multiples * step) <= SMALLEST_CHANGE * way.max()).all() and len(set(multiples.tolist())) > 1)
    return step if is_coarse else 0.0


def _rises(response: _Response) -> _Rises:
    """Add up rises and falls, where one is larger than the noise can be, and bound the share of the rises from below."""
    threshold, share = response.smallest_fall, response.share.tolist()
    risen, falls, turns, is_rising, low, high = 0.0, 0.0, 0, True, 0.0, 0.0
    rises, errors = [], []
    for value in share:
        if is_rising:
            high = max(high, value)
            if value < high - threshold:
                risen, turns, is_rising, low = risen + high - low, turns + 1, False, value
        else:
            low = min(low, value)
            if value > low + threshold:
                falls, is_rising, high = falls + high - low, True, value
        rises.append(risen + (high - low if is_rising else 0.0))
        errors.append(response.noise * (1 + 1 / math.sqrt(response.before) + 2 * turns))
    falls += 0.0 if is_rising else high - low
    if turns:  # noise, peaks between samples, and later falls that are too small to be seen
        between = float(np.abs(np.diff(response.share)).max()) * MISSED_PEAK
        falls += 2 * turns * (response.noise + between) + threshold
    overshoot = _up(falls / (1 + falls))
    total = 1 + 2 * response.drift + response.noise / math.sqrt(response.after) + overshoot / (1 - overshoot)
    return _Rises(np.maximum.accumulate(np.array(rises) - np.array(errors)) / total, overshoot)


def _visible(time: Array, share: Array, hidden: float) -> tuple[Array, Array]:
    """Return until when the response may have stayed at each share: the time of the next sample, until the end is hidden."""
    end = int(np.argmax(share >= 1 - hidden)) if (share >= 1 - hidden).any() else len(share) - 1
    return time[: end + 1], np.concatenate([[0.0], share[:end]])


def _lag(times: Array, shares: Array, latency: float) -> float:
    """Return the least T with share >= 1 - e^(-(t - latency)/T) at all times; shares are positive after the latency."""
    late = times > latency * (1 + 2 * TIME_ROUNDING)
    return float(((times[late] - latency) / -np.log1p(-shares[late])).max(initial=0.0))


def _best_latency(times: Array, shares: Array, smallest: float) -> float:
    """Return the latency, rounded up, with the least lag + LATENCY_WEIGHT latency."""
    candidates = times[times > smallest]
    candidates = candidates[:: max(1, len(candidates) // LATENCY_CANDIDATES)]
    rounded = [smallest, *(_up(float(v)) for v in candidates)]
    return min(rounded, key=lambda v: _lag(times, shares, v) + LATENCY_WEIGHT * v)
