"""What `prove TASK` and `design` say of a loop, as data: hypotheses, bounds with their numbers, proved periods. Every number is
rounded to the safe side, to four digits; None where nothing is proved."""

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


def below_float(value: float) -> Any:
    """Four digits, not above the value; None where it is not finite."""
    return below(Fraction(value), 4) if math.isfinite(value) else None


def above_float(value: float) -> Any:
    """Four digits, not below the value; None where it is not finite."""
    return above(Fraction(value), 4) if math.isfinite(value) else None


def rounded(values: npt.NDArray[Any], rounding: Callable[[float], float | None]) -> Numbers:
    """Every number by `below_float` or `above_float`."""
    return tuple(rounding(float(v)) for v in values)


@dataclass(frozen=True)
class Hypothesis:
    """Something that a theorem assumes: whether it holds for this tube and plant, with the numbers."""

    name: str
    statement: str
    holds: bool


@dataclass(frozen=True, kw_only=True)
class ProvedPeriod:
    """A period (seconds, rounded down; latency is not in it) with what |e| and |u| stay below by component, and the time window
    and dimension (0: all) that allow no more."""

    statement: str
    period: float
    e: tuple[float, ...]
    u: tuple[float, ...]
    time: tuple[float, float]
    dimension: int

    @classmethod
    def of(cls, period: Period | None, latency: float = 0.0) -> ProvedPeriod | None:
        """What is proved where u acts up to `latency` after its sample: the age of a sample less that; None where none is."""
        if period is None or not period.seconds > latency:
            return None
        begin, end, dimension = period.bottleneck
        e, u = (tuple(above_float(v) for v in values) for values in (period.e, period.u))
        return cls(
            statement=period.kind,
            period=below_float(period.seconds - latency),
            e=e,
            u=u,
            time=(begin, end),
            dimension=dimension,
        )

    def document(self) -> dict[str, Any]:
        tight = {"time": list(self.time), "dimension": self.dimension or "all"}
        return {"statement": self.statement, "period": self.period, "e": list(self.e), "u": list(self.u), "tight": tight}


@dataclass(frozen=True)
class Advice:
    """A gain by component, with limits on u where they are part of it, and what is proved with it."""

    gain: tuple[float, ...]
    proved: ProvedPeriod
    u_max: tuple[float, ...] | None = None

    def document(self) -> dict[str, Any]:
        limits = {} if self.u_max is None else {"u_max": list(self.u_max)}
        return {"gain": list(self.gain), **limits, **self.proved.document()}


@dataclass(frozen=True)
class ProvedGains:
    """Every gain from `first` to `last`, by component in fixed proportions, is proved; last None: every gain from `first` on.
    `first_is_end`, `last_is_end`: whether the proof ends there; else the search did."""

    first: tuple[float, ...]
    last: tuple[float, ...] | None
    first_is_end: bool
    last_is_end: bool

    def document(self) -> dict[str, Any]:
        last = None if self.last is None else list(self.last)
        ends = {"from_is_end": self.first_is_end, "to_is_end": self.last_is_end}
        return {"from": list(self.first), "to": last, **ends}

    @property
    def text(self) -> str:
        """In words, as "from 0.0005 to at least 1.8"; nothing is said of gains beyond."""
        first = by_component(self.first) + ("" if self.first_is_end else " or less")
        if self.last is None:
            return f"from {first} on, for u_max limits what a larger gain asks for"
        return f"from {first} to {'' if self.last_is_end else 'at least '}{by_component(self.last)}"


@dataclass(frozen=True, kw_only=True)
class Sampling:
    """What a user chooses from, all of it for the starts that `starts` names but for `from_initial_state`.

    assumes: what the periods rest on and nothing here can show. shortest: seconds below which alpha may not be stepped. longest:
    the gain with the longest period; limited: the same with limits on u; roomiest: of the gains proved for `wanted` seconds the
    one that keeps |e| least in a run from the middle; gains: the range of them."""

    plant: str
    latency: float
    assumes: tuple[str, ...]
    shortest: float
    starts: str
    gain: tuple[float, ...]
    at_this_gain: ProvedPeriod | None
    from_initial_state: ProvedPeriod | None
    longest: Advice | None
    limited: Advice | None
    wanted: float
    roomiest: Advice | None
    gains: ProvedGains | None
    shortest_for: str = ""  # what asks for it

    def document(self) -> dict[str, Any]:
        def shown(value: ProvedPeriod | Advice | None) -> dict[str, Any] | None:
            return None if value is None else value.document()

        return {
            "plant": self.plant,
            "latency": self.latency,
            "assumes": list(self.assumes),
            "shortest": self.shortest,
            "starts": self.starts,
            "gain": list(self.gain),
            "at_this_gain": shown(self.at_this_gain),
            "from_initial_state_alone": shown(self.from_initial_state),
            "longest": shown(self.longest),
            "longest_with_limits": shown(self.limited),
            "wanted": {
                "period": self.wanted,
                "most_room": shown(self.roomiest),
                "gains": None if self.gains is None else self.gains.document(),
            },
        }


@dataclass(frozen=True)
class TubeBounds:
    lower: Numbers
    upper: Numbers
    least_width: Numbers
    largest_width: Numbers
    speed: Numbers


@dataclass(frozen=True)
class PlantOverTube:
    """|f + w|, g_ii and |g_ij| over the tube by component; the least eigenvalue of g_s and |g|."""

    push: Numbers
    g_diagonal_least: Numbers
    g_cross_largest: Numbers
    g_s_least_eigenvalue: float | None
    g_norm: float | None


@dataclass(frozen=True)
class ContinuousBounds:
    epsilon_star: Numbers
    epsilon_star_norm: float | None
    u: Numbers


@dataclass(frozen=True)
class UpdateFunctionBounds:
    """Bounds on psi + alpha, alpha and the gaps of an adaptive tube; s_star = min over cells of psi + alpha."""

    s_star: float | None
    psi_0: float | None
    alpha_max: float | None
    least_gap: float | None
    ln4_over_nu: float


@dataclass(frozen=True, kw_only=True)
class BoundsReport:
    """All of it for one controller and one plant."""

    task: str
    design: str
    scalar: str
    plant: str
    axes: tuple[str, ...]
    noise: float
    latency: float
    hypotheses: tuple[Hypothesis, ...]
    tube: TubeBounds
    plant_over_the_tube: PlantOverTube
    continuous: ContinuousBounds
    sampled: Mapping[str, ProvedPeriod | None]
    sampling: Sampling
    update_function: UpdateFunctionBounds | None
    proposed: ProposedBounds | None
    filter: tuple[float, ...] = ()

    @property
    def good(self) -> bool:
        return all(h.holds for h in self.hypotheses)

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
        data = {name: getattr(self, name) for name in ("task", "design", "scalar", "plant", "noise", "latency")}
        data["hypotheses"] = [asdict(h) for h in self.hypotheses]
        data |= {"tube": asdict(self.tube), "plant_over_the_tube": asdict(self.plant_over_the_tube)}
        data["continuous"] = asdict(self.continuous)
        data["sampled"] = {name: None if p is None else p.document() for name, p in self.sampled.items()}
        data["sampling"] = self.sampling.document()
        if self.proposed is not None:
            data["proposed_plant"] = self.proposed.document()
        if self.update_function is not None:
            data["update_function"] = asdict(self.update_function)
        return data
