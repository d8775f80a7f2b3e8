"""Choose the times of the Arduino example sketch: how often it samples, and up to which gap between samples it is proved.

The sketch counts the microseconds of the board's micros(), so no time is lost when a step takes long. record/package.py calls
`sketch_words`, `generate` prints `sketch_notes`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from stt_codegen.certify.missions import cycle_of
from stt_codegen.designs import uncertified_alpha_step
from stt_codegen.emit import clock_words
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.properties import Property
from stt_codegen.record.uno import CLOCK_FREQUENCY, INTEGER_TO_FLOAT_RATIO, RELATIVE_ERROR, step_cycles
from stt_codegen.report import input_report

DEFAULT_PERIOD = Fraction(1, 100)  # seconds between samples of the sketch, unless the task needs longer or shorter ones
JITTER_SHARE = Fraction(1, 10)  # of the longest proved gap, left for samples that come late
MICROS_RESOLUTION = 4  # microseconds, of micros() on an Uno
MICROSECOND = Fraction(1, 10**6)


@dataclass(frozen=True)
class LoopTimes:
    """Times of the sketch in seconds.

    period: from one sample to the next. longest: the longest gap that is proved, None where the period is not. source: what
    proves it, for a comment in the sketch.
    """

    period: Fraction
    longest: Fraction | None
    source: str

    @property
    def longest_us(self) -> int:
        """Return the gap in microseconds beyond which the sketch sets `late`, rounded down by the resolution of micros().

        Without a proof it is one and a half periods, so that a missed step counts as late.
        """
        if self.longest is None:
            return math.floor(self.period * Fraction(3, 2) / MICROSECOND)
        return max(0, math.floor(self.longest / MICROSECOND) - MICROS_RESOLUTION)


def loop_times(controller: EmittedController) -> LoopTimes:
    """Choose how often the sketch samples: every tick, else the proved gap less `JITTER_SHARE`, within the limits of the task."""
    task, steps = controller.task, controller.certificate.steps
    longest, source = _longest_gap(controller)
    period = DEFAULT_PERIOD if longest is None else longest * (1 - JITTER_SHARE)
    if task.emit.tick_period is not None:
        period = task.emit.tick_period
    else:
        if task.control.period is None:
            period = min(DEFAULT_PERIOD, period)
        if task.uses_differences:
            period = max(period, task.shortest_period)
        if steps is not None:
            period = min(max(period, steps[0] + MICROSECOND), steps[1] * (1 - JITTER_SHARE))
        round_us = _ceil_us if task.uses_differences else _floor_us
        period = max(1, round_us(period)) * MICROSECOND
    return LoopTimes(period, longest if longest is not None and longest >= period else None, source)


def _longest_gap(controller: EmittedController) -> tuple[Fraction | None, str]:
    """Return the longest gap in seconds for which the state is proved to stay in the tube, and what proves it."""
    if not controller.certificate.holds:
        return None, ""
    if controller.certificate.proved_period is not None:
        return controller.certificate.proved_period.period, f"proved ({Property.PERIOD.code})"
    sampling = input_report(controller).sampling
    proved = None if sampling is None else sampling.at_this_gain
    return (None, "") if proved is None else (Fraction(proved.period), "proved for this gain (stt-codegen design)")


def _ceil_us(seconds: Fraction) -> int:
    return math.ceil(seconds / MICROSECOND)


def _floor_us(seconds: Fraction) -> int:
    return math.floor(seconds / MICROSECOND)


def sketch_words(controller: EmittedController) -> dict[str, Any]:
    """Return the numbers of time, sensors and actuators for the sketches' templates, as text or integers.

    Raises `BadInput` for ticks shorter than the resolution of micros().
    """
    task, times, steps = controller.task, loop_times(controller), controller.certificate.steps
    tick = task.emit.tick_period
    if tick is not None and tick < MICROS_RESOLUTION * MICROSECOND:
        problem = f"is {float(tick / MICROSECOND):g} us; an Uno's micros() counts by {MICROS_RESOLUTION} us"
        raise BadInput(
            f"emit.tick_period: {problem}: give at least 0.{MICROS_RESOLUTION:06d} s, or take --package plain or cmake"
        )
    period, cycle = times.period / MICROSECOND, cycle_of(controller.design)
    words: dict[str, Any] = {
        "clock": clock_words(task),
        "starts": controller.design.capabilities.emits_covered_starts,
        "by_ticks": tick is not None and (task.emit.scalar == "fixed" or task.control.outside == "return"),
        "period_us": math.floor(period),
        "period_rest": period.numerator % period.denominator,
        "period_parts": period.denominator,
        "period_ms": f"{float(times.period * 1000):g}",
        "longest_us": times.longest_us,
        "proved_by": "" if times.longest is None else times.source,
        "shortest_us": _ceil_us(task.shortest_period) if task.uses_differences else 0,
        "latency_us": _floor_us(task.control.latency),
        "alpha_us": _floor_us(steps[1] if steps else uncertified_alpha_step(task.prescribed_time)),
    }
    if cycle is not None:
        length = cycle.length / MICROSECOND
        words["end_us"] = _ceil_us(cycle.end)
        words["cycle_us"], words["cycle_rest"] = math.floor(length), length.numerator % length.denominator
        words["cycle_parts"] = length.denominator
    space, proved = task.state_space, controller.certificate.proved_period
    low, high = float(min(space.lower)), float(max(space.upper))
    largest = max(task.u_max or (proved.u if proved else ()) or (1,))
    scaled_by = ("largest u_max" if task.u_max else "largest |u| proved") if task.u_max or proved else ""
    words |= {"low": f"{low:.9g}", "range": f"{high - low:.9g}", "most": f"{float(largest):.9g}"}
    return words | {"most_is": scaled_by}


def sketch_notes(controller: EmittedController) -> list[str]:
    """Return notes on the sketch's time: a tick that leaves no margin for lateness, a step longer than its period on an Uno."""
    times, notes, cycles = loop_times(controller), [], step_cycles(controller)
    if times.longest is not None and times.longest_us * MICROSECOND < times.period:
        cause = f"the sketch samples every {_milliseconds(times.period)}, and {_milliseconds(times.longest)} is {times.source}"
        remedy = "state a control.period of two ticks" if controller.task.emit.tick_period else "no board keeps that"
        notes.append(f"{cause}: a sample that is microseconds late sets `late`; {remedy}")
    limit, limit_source = times.longest, times.source
    if limit is None:
        limit, limit_source = times.period, "the sketch's period"
    if cycles is not None and Fraction(cycles, CLOCK_FREQUENCY) * (1 + RELATIVE_ERROR) > limit:
        step = Fraction(cycles, CLOCK_FREQUENCY)
        estimate = f"a step takes about {_milliseconds(step)} on an Uno (16 MHz; an estimate)"
        cause = f"{estimate}, and {_milliseconds(limit)} is {limit_source}"
        integers_help = controller.program.scalar != "fixed" and step * INTEGER_TO_FLOAT_RATIO <= limit
        remedy = '; emit.scalar = "fixed" takes less than half of that' if integers_help else ""
        notes.append(f"{cause}: it will be late there, and says so by `late`{remedy}")
    return notes


def _milliseconds(seconds: Fraction) -> str:
    return f"{float(seconds * 1000):.3g} ms"
