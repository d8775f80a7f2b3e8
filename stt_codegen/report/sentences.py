"""Sentences on sampling and gains, for the terminal (cli/show.py) and the page (report/page/)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stt_codegen.decimals import by_component
from stt_codegen.properties import Property
from stt_codegen.report.bounds import ProvedPeriod, SamplingReport
from stt_codegen.sampling import WORTHWHILE_PERIOD_RATIO


@dataclass(frozen=True)
class Line:
    """A sentence. is_detail: it explains the last line that is no detail. is_note: a user may not expect it."""

    text: str
    is_detail: bool = False
    is_note: bool = False


def sampling_lines(sampling: SamplingReport, tick_period: float | None) -> Iterator[Line]:
    """Yield what is proved about sampling: first from all starts of the start share, then from initial_state alone.

    tick_period: emit.tick_period of the task, in seconds.
    """
    if sampling.has_drive:
        yield Line(f"sampling: {Property.PERIOD.label} alone counts the drive of [plant]; no other gain or period is looked for")
        return
    about = f"for {sampling.plant} from every start with {sampling.starts}"
    if sampling.has_proved_period:
        period = f"{Property.PERIOD.label} is proved for [plant] of the task, every {format_time(sampling.wanted)} or faster"
        yield Line(f"sampling: {period}; its proof follows the worst path")
        yield Line(f"a second proof takes the worst case at each time, and so proves other periods, {about}:")
    else:
        yield Line(f"sampling, proved {about}:")
    at_this_gain = sampling.at_this_gain
    if at_this_gain is None and sampling.has_proved_period:
        yield Line("no period: the worst path alone proves it", is_detail=True)
    elif at_this_gain is None:
        gain = by_component(sampling.gain)
        yield Line(f"gain {gain} is proved at no sampling period from there", is_detail=True, is_note=True)
    else:
        yield Line(_describe_period(sampling, at_this_gain), is_detail=True)
    yield from _longer_periods(sampling)
    yield from _proved_gains(sampling)
    if sampling.from_initial_state is not None:
        yield Line(f"from initial_state alone: {_describe_period(sampling, sampling.from_initial_state)}")
    for assumption in sampling.assumptions:
        yield Line(f"assumed: {assumption}")
    if tick_period is not None and (at_this_gain is None or tick_period > at_this_gain.period):
        yield Line(f"emit.tick_period {format_time(tick_period)} is longer than what is proved at this gain", is_note=True)


def _describe_period(sampling: SamplingReport, proved: ProvedPeriod) -> str:
    """Say how often to sample, and the bounds on e and u that are proved then."""
    lower_limit = (
        f", but not below {format_time(sampling.shortest)} ({sampling.shortest_for})" if sampling.shortest else " or faster"
    )
    delay = f", u at most {format_time(sampling.latency)} after its sample" if sampling.latency else ""
    bounds = f"|e| stays below {format_numbers(proved.e)}, |u| is at most {format_numbers(proved.u)}"
    return f"sample every {format_time(proved.period)}{lower_limit}{delay} ({proved.statement} statement): {bounds}"


def _longer_periods(sampling: SamplingReport) -> Iterator[Line]:
    """Yield the gain, and the gain with other limits, that prove a clearly longer period than the task's gain."""
    longest, limited = sampling.longest, sampling.longest_with_limits
    if longest is not None and (sampling.at_this_gain is None or longest.proved.period > 1.1 * sampling.at_this_gain.period):
        period, u = format_time(longest.proved.period), format_numbers(longest.proved.u)
        yield Line(f"gain {by_component(longest.gain)} would allow {period}, |u| is at most {u}", is_detail=True)
    longest_period = 0.0 if longest is None else longest.proved.period
    if limited is not None and limited.u_max is not None and limited.proved.period > WORTHWHILE_PERIOD_RATIO * longest_period:
        choice = f"control.u_max {by_component(limited.u_max)} and gain {by_component(limited.gain)}"
        yield Line(f"{choice} would allow {format_time(limited.proved.period)}", is_detail=True)


def _proved_gains(sampling: SamplingReport) -> Iterator[Line]:
    """Yield the gains that are proved for the wanted period, and the one with the smallest |e|."""
    wanted = format_time(sampling.wanted)
    if sampling.gains is None and sampling.has_proved_period:
        return
    if sampling.gains is None:
        yield Line(f"no gain is proved for a period of {wanted}", is_detail=True, is_note=True)
    else:
        proportions = ", in these proportions," if len(set(sampling.gain)) > 1 else ""
        yield Line(f"gains{proportions} proved for a period of {wanted}: {sampling.gains.text}", is_detail=True)
    if sampling.smallest_error is not None:
        yield Line(f"gain {by_component(sampling.smallest_error.gain)} leaves the most room at {wanted}", is_detail=True)


def format_numbers(values: Sequence[float]) -> str:
    """Return the values with four digits, separated by commas."""
    return ", ".join(f"{v:.4g}" for v in values)


def format_time(seconds: float) -> str:
    """Return the time with four digits, in s, ms or us."""
    return f"{seconds:.4g} s" if seconds >= 1 else f"{1e3 * seconds:.4g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.4g} us"
