"""What `prove TASK` and `design` say of a loop, as data: hypotheses, bounds with their numbers, proved periods. Every number is
rounded to the safe side, to four digits; None where nothing is proved."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any

import numpy.typing as npt

from stt_codegen.decimals import above, below
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


@dataclass(frozen=True)
class ProvedPeriod:
    """A period (seconds, rounded down) with what |e| and |u| stay below, and the time window and dimension (0: all) that allow no
    more."""

    statement: str
    period: float
    e: float
    u: tuple[float, ...]
    time: tuple[float, float]
    dimension: int

    @classmethod
    def of(cls, period: Period) -> ProvedPeriod:
        begin, end, dimension = period.tight
        numbers = below_float(period.seconds), above_float(period.e), tuple(above_float(v) for v in period.u)
        return cls(period.statement, *numbers, (begin, end), dimension)

    def document(self) -> dict[str, Any]:
        tight = {"time": list(self.time), "dimension": self.dimension or "all"}
        return {"statement": self.statement, "period": self.period, "e": self.e, "u": list(self.u), "tight": tight}


@dataclass(frozen=True)
class Sampling:
    """What a user chooses from: the proved period at his gain, the gain with the longest, the gains for a period.

    assumes: what the periods rest on and nothing here can show. shortest: seconds below which alpha may not be stepped.
    gains: the least and largest gain proved for `wanted` seconds."""

    plant: str
    latency: float
    assumes: tuple[str, ...]
    shortest: float
    gain: float
    at_this_gain: ProvedPeriod | None
    best_gain: float | None
    at_best_gain: ProvedPeriod | None
    wanted: float
    gains: tuple[float, float] | None

    def document(self) -> dict[str, Any]:
        best = self.at_best_gain
        return {
            "plant": self.plant,
            "latency": self.latency,
            "assumes": list(self.assumes),
            "shortest": self.shortest,
            "gain": self.gain,
            "at_this_gain": None if self.at_this_gain is None else self.at_this_gain.document(),
            "longest": None if best is None else {"gain": self.best_gain, **best.document()},
            "gains_at": {"period": self.wanted, "gains": None if self.gains is None else list(self.gains)},
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


@dataclass(frozen=True)
class BoundsReport:
    """All of it for one controller and one plant."""

    task: str
    design: str
    scalar: str
    plant: str
    noise: float
    latency: float
    hypotheses: tuple[Hypothesis, ...]
    tube: TubeBounds
    plant_over_the_tube: PlantOverTube
    continuous: ContinuousBounds
    sampled: Mapping[str, ProvedPeriod | None]
    sampling: Sampling
    update_function: UpdateFunctionBounds | None

    @property
    def good(self) -> bool:
        return all(h.holds for h in self.hypotheses)

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
        data = {name: getattr(self, name) for name in ("task", "design", "scalar", "plant", "noise", "latency")}
        data["hypotheses"] = [asdict(h) for h in self.hypotheses]
        data |= {name: asdict(getattr(self, name)) for name in ("tube", "plant_over_the_tube", "continuous")}
        data["sampled"] = {name: None if p is None else p.document() for name, p in self.sampled.items()}
        data["sampling"] = self.sampling.document()
        if self.update_function is not None:
            data["update_function"] = asdict(self.update_function)
        return data
