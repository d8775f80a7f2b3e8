"""What `prove TASK` and `design` report about a closed loop, as data: hypotheses, bounds with their numbers, proved periods.

Every number has four digits, rounded towards the weaker statement; None where nothing is proved. report/analysis.py computes
them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any

import numpy.typing as npt

from stt_codegen.decimals import above, below, by_component
from stt_codegen.report.plant_table import ProposedBounds
from stt_codegen.sampling import Period

Numbers = tuple[float | None, ...]  # by dimension


def round_down(value: float) -> Any:
    """Return the value with four digits, rounded down; None where it is not finite."""
    return below(Fraction(value), 4) if math.isfinite(value) else None


def round_up(value: float) -> Any:
    """Return the value with four digits, rounded up; None where it is not finite."""
    return above(Fraction(value), 4) if math.isfinite(value) else None


def round_each(values: npt.NDArray[Any], rounding: Callable[[float], float | None]) -> Numbers:
    """Round every number by `round_down` or `round_up`."""
    return tuple(rounding(float(v)) for v in values)


@dataclass(frozen=True)
class Hypothesis:
    """An assumption of a theorem, as a sentence with numbers, and whether it holds for this tube and plant."""

    name: str
    statement: str
    holds: bool


@dataclass(frozen=True, kw_only=True)
class ProvedPeriod:
    """A proved sampling period in seconds. The age of a sample is at most the period plus the latency.

    statement: the kind of the sampling conditions. e, u: bounds on |e| and |u| by component. critical_window: begin
    and end, in seconds, of the window in which no longer period is proved. critical_dimension: its dimension, from 1; 0: all.
    """

    statement: str
    period: float
    e: tuple[float, ...]
    u: tuple[float, ...]
    critical_window: tuple[float, float]
    critical_dimension: int

    @classmethod
    def of(cls, period: Period | None, latency: float = 0.0) -> ProvedPeriod | None:
        """Return the proved period minus the latency, in seconds; None unless a period longer than the latency is proved."""
        if period is None or not period.seconds > latency:
            return None
        begin, end, dimension = period.bottleneck
        e, u = (tuple(round_up(v) for v in values) for values in (period.e, period.u))
        return cls(
            statement=period.kind,
            period=round_down(period.seconds - latency),
            e=e,
            u=u,
            critical_window=(begin, end),
            critical_dimension=dimension,
        )

    def document(self) -> dict[str, Any]:
        """Return the period as JSON data."""
        critical = {"time": list(self.critical_window), "dimension": self.critical_dimension or "all"}
        return {"statement": self.statement, "period": self.period, "e": list(self.e), "u": list(self.u), "tight": critical}


@dataclass(frozen=True)
class Advice:
    """A gain by component that a user may choose, with limits on u where these have to change too, and what it proves."""

    gain: tuple[float, ...]
    proved: ProvedPeriod
    u_max: tuple[float, ...] | None = None

    def document(self) -> dict[str, Any]:
        """Return the advice as JSON data."""
        limits = {} if self.u_max is None else {"u_max": list(self.u_max)}
        return {"gain": list(self.gain), **limits, **self.proved.document()}


@dataclass(frozen=True)
class ProvedGains:
    """A range of gains in fixed proportions of the components, all of which are proved.

    last: None where every gain from `first` on is proved. first_is_end, last_is_end: whether the search found that no gain beyond
    is proved; False where it stopped there.
    """

    first: tuple[float, ...]
    last: tuple[float, ...] | None
    first_is_end: bool
    last_is_end: bool

    def document(self) -> dict[str, Any]:
        """Return the range as JSON data."""
        last = None if self.last is None else list(self.last)
        ends = {"from_is_end": self.first_is_end, "to_is_end": self.last_is_end}
        return {"from": list(self.first), "to": last, **ends}

    @property
    def text(self) -> str:
        """Describe the range, as in "from 0.0005 to at least 1.8"."""
        first = by_component(self.first) + ("" if self.first_is_end else " or less")
        if self.last is None:
            return f"from {first} on, for u_max limits what a larger gain asks for"
        return f"from {first} to {'' if self.last_is_end else 'at least '}{by_component(self.last)}"


@dataclass(frozen=True, kw_only=True)
class SamplingReport:
    """Periods and gains that a user can choose from, in seconds and by component.

    All hold for every start that `starts` describes; `from_initial_state` holds for that state alone. assumptions: conditions of
    the periods that no program can check. shortest: the lower limit of periods; shortest_for: the key of the task file that sets
    it. at_this_gain: the period of the task's gain. longest: the gain with the longest period. longest_with_limits: that gain if
    control.u_max may change. gains: the proved gains for the period `wanted`. smallest_error: the gain of that range with the
    smallest |e| in a run from the middle. has_drive: whether the task states a drive, which is in none of these numbers.
    has_proved_period: whether P9 proves the task's own period by the worst path, where these conditions may not.
    """

    plant: str
    latency: float
    assumptions: tuple[str, ...]
    shortest: float
    starts: str
    gain: tuple[float, ...]
    at_this_gain: ProvedPeriod | None
    from_initial_state: ProvedPeriod | None
    longest: Advice | None
    longest_with_limits: Advice | None
    wanted: float
    smallest_error: Advice | None
    gains: ProvedGains | None
    shortest_for: str = ""
    has_drive: bool = False
    has_proved_period: bool = False

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""

        def optional_document(value: ProvedPeriod | Advice | None) -> dict[str, Any] | None:
            return None if value is None else value.document()

        return {
            "plant": self.plant,
            "latency": self.latency,
            "assumes": list(self.assumptions),
            "shortest": self.shortest,
            "starts": self.starts,
            "gain": list(self.gain),
            "at_this_gain": optional_document(self.at_this_gain),
            "from_initial_state_alone": optional_document(self.from_initial_state),
            "longest": optional_document(self.longest),
            "longest_with_limits": optional_document(self.longest_with_limits),
            "wanted": {
                "period": self.wanted,
                "most_room": optional_document(self.smallest_error),
                "gains": None if self.gains is None else self.gains.document(),
            },
        }


@dataclass(frozen=True)
class TubeBounds:
    """Bounds on the edges, the width and the speed of the edges, over all times."""

    lower: Numbers
    upper: Numbers
    smallest_width: Numbers
    largest_width: Numbers
    speed: Numbers

    def document(self) -> dict[str, Any]:
        """Return the bounds as JSON data."""
        return _with_key(asdict(self), "smallest_width", "least_width")


@dataclass(frozen=True)
class PlantOverTube:
    """Bounds on the plant over the tube: on |f + w|, g_ii and |g_ij| by component, the eigenvalues of g_s from below, and |g|."""

    disturbance: Numbers
    smallest_g_diagonal: Numbers
    largest_g_cross: Numbers
    smallest_g_s_eigenvalue: float | None
    g_norm: float | None

    def document(self) -> dict[str, Any]:
        """Return the bounds as JSON data."""
        data = _with_key(asdict(self), "disturbance", "push")
        data = _with_key(data, "smallest_g_diagonal", "g_diagonal_least")
        data = _with_key(data, "largest_g_cross", "g_cross_largest")
        return _with_key(data, "smallest_g_s_eigenvalue", "g_s_least_eigenvalue")


@dataclass(frozen=True)
class ContinuousBounds:
    """Bounds of Theorem 4.1 for continuous control: on |eps| by component and in norm, and on |u|."""

    epsilon_star: Numbers
    epsilon_star_norm: float | None
    u: Numbers


@dataclass(frozen=True)
class UpdateFunctionBounds:
    """Bounds on the update function of an adaptive tube.

    s_star: on psi + alpha from below; psi_0: on psi(0) from below; alpha_max: on alpha from above. smallest_gap: of the four gaps
    between edges and obstacles, which have to exceed ln4_over_nu.
    """

    s_star: float | None
    psi_0: float | None
    alpha_max: float | None
    smallest_gap: float | None
    ln4_over_nu: float

    def document(self) -> dict[str, Any]:
        """Return the bounds as JSON data."""
        return _with_key(asdict(self), "smallest_gap", "least_gap")


@dataclass(frozen=True, kw_only=True)
class BoundsReport:
    """All hypotheses and bounds for one controller and one plant."""

    task: str
    design: str
    scalar: str
    plant: str
    axes: tuple[str, ...]
    noise: float | tuple[float, ...]
    latency: float
    hypotheses: tuple[Hypothesis, ...]
    tube: TubeBounds
    plant_over_the_tube: PlantOverTube
    continuous: ContinuousBounds
    sampled: Mapping[str, ProvedPeriod | None]  # by kind of the sampling conditions
    sampling: SamplingReport
    update_function: UpdateFunctionBounds | None
    proposed: ProposedBounds | None
    filter: tuple[float, ...] = ()

    @property
    def all_hypotheses_hold(self) -> bool:
        return all(h.holds for h in self.hypotheses)

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        data = {name: getattr(self, name) for name in ("task", "design", "scalar", "plant", "noise", "latency")}
        data["hypotheses"] = [asdict(h) for h in self.hypotheses]
        data |= {"tube": self.tube.document(), "plant_over_the_tube": self.plant_over_the_tube.document()}
        data["continuous"] = asdict(self.continuous)
        data["sampled"] = {name: None if p is None else p.document() for name, p in self.sampled.items()}
        data["sampling"] = self.sampling.document()
        if self.proposed is not None:
            data["proposed_plant"] = self.proposed.document()
        if self.update_function is not None:
            data["update_function"] = self.update_function.document()
        return data


def _with_key(data: dict[str, Any], old: str, new: str) -> dict[str, Any]:
    """Return the data with a key renamed, in the same order: keys of the JSON stay as they were released."""
    return {new if key == old else key: value for key, value in data.items()}
