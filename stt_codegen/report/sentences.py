"""What is said of sampling, gains and effort, in sentences: for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stt_codegen.decimals import by_component
from stt_codegen.report.bounds import ProvedPeriod, Sampling
from stt_codegen.sampling import WORTHWHILE_PERIOD_RATIO


@dataclass(frozen=True)
class Line:
    """A sentence; under: it belongs to the one before that is not; note: something that a user may not expect."""

    text: str
    under: bool = False
    note: bool = False


def sampling_lines(sampling: Sampling, tick_period: float | None) -> Iterator[Line]:
    """What `Analysis.sampling` says, for people: first for all the starts, then for initial_state alone."""
    own, plant = sampling.at_this_gain, f"for {sampling.plant}"
    starts, longest, wanted = sampling.starts, sampling.longest, time_told(sampling.wanted)
    least = f", but not below {time_told(sampling.shortest)} ({sampling.shortest_for})" if sampling.shortest else " or faster"

    def every(proved: ProvedPeriod) -> str:
        late = f", u at most {time_told(sampling.latency)} after its sample" if sampling.latency else ""
        most = f"sample every {time_told(proved.period)}{least}{late}"
        return f"{most} ({proved.statement} statement): |e| stays below {few(proved.e)}, |u| is at most {few(proved.u)}"

    yield Line(f"sampling, proved {plant} from every start with {starts}:")
    if own is None:
        yield Line(f"gain {by_component(sampling.gain)} is proved at no sampling period from there", under=True, note=True)
    else:
        yield Line(every(own), under=True)
    if longest is not None and (own is None or longest.proved.period > 1.1 * own.period):
        told = f"gain {by_component(longest.gain)}"
        yield Line(f"{told} would allow {time_told(longest.proved.period)}, |u| is at most {few(longest.proved.u)}", under=True)
    limited, best = sampling.limited, 0.0 if longest is None else longest.proved.period
    if limited is not None and limited.u_max is not None and limited.proved.period > WORTHWHILE_PERIOD_RATIO * best:
        told = f"control.u_max {by_component(limited.u_max)} and gain {by_component(limited.gain)}"
        yield Line(f"{told} would allow {time_told(limited.proved.period)}", under=True)
    if sampling.gains is None:
        yield Line(f"no gain is proved for a period of {wanted}", under=True, note=True)
    else:
        alike = ", in these proportions," if len(set(sampling.gain)) > 1 else ""
        yield Line(f"gains{alike} proved for a period of {wanted}: {sampling.gains.text}", under=True)
    if sampling.roomiest is not None:
        yield Line(f"gain {by_component(sampling.roomiest.gain)} leaves the most room at {wanted}", under=True)
    if sampling.from_initial_state is not None:
        yield Line(f"from initial_state alone: {every(sampling.from_initial_state)}")
    for line in sampling.assumes:
        yield Line(f"assumed: {line}")
    if tick_period is not None and (own is None or tick_period > own.period):
        yield Line(f"emit.tick_period {time_told(tick_period)} is longer than what is proved at this gain", note=True)


def few(values: Sequence[float]) -> str:
    """Four digits of each."""
    return ", ".join(f"{v:.4g}" for v in values)


def time_told(seconds: float) -> str:
    """Four digits, in s, ms or us."""
    return f"{seconds:.4g} s" if seconds >= 1 else f"{1e3 * seconds:.4g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.4g} us"
