"""The longest sampling period for which sampling conditions hold, and the smallest bound E on |eps| for a period.

Both are searched for in doubles, and then proved in balls (Arb) before they are returned. certify/sampled/period.py proves them
once more in fractions; lemmas/sampling/ has the mathematics.

In the sharp conditions every component has an E of its own. The effect of an input on the other components rises with its E, and
so does the E that they need. For one tau there is therefore a smallest E in all components at once: each starts from its own
smallest and is raised until its own conditions hold. Where a component has no such E, there is none at all.

Here tau is the age of the oldest sample that may still act, in seconds. The code calls E `eps_bound`; in
fractions it uses rho = e^E. Long because the same conditions are searched in doubles, and proved in balls and in fractions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.effort import require_effort
from stt_codegen.sampling.sampled_loop import SampledLoop, in_balls
from stt_codegen.sampling.sampling_conditions import (
    SAMPLING_CONDITIONS,
    conditions_of,
    first_failing,
    input_bound,
    sharp_closing_speed,
    sharp_under,
)

Array = npt.NDArray[Any]
RELATIVE_RETREATS = (1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.1)  # a searched tau is shortened, or E raised, until balls prove it
FIRST_HALVINGS = 24  # halvings beyond those of a search, while no period has been proved yet
SMALLEST_EPS_BOUND = 0.01  # of the search; |e| = 0.005 is as good as a start in the middle of the tube


class PeriodCandidate(NamedTuple):
    """A period from the search in doubles, not proved yet: seconds, and E by component, (n,)."""

    seconds: float
    eps_bound: Array


@dataclass(frozen=True)
class Period:
    """A proved period.

    kind: of the sampling conditions. seconds: the age of a sample, for which |eps_i| < eps_bound[i] throughout. u: a bound on
    |u| by component. bottleneck: begin and end of the time window (seconds) and the dimension (from 1; 0 for all) where the
    margin is smallest.
    """

    kind: str
    seconds: float
    eps_bound: tuple[float, ...]
    u: tuple[float, ...]
    bottleneck: tuple[float, float, int]

    @property
    def e(self) -> tuple[float, ...]:
        """The bounds on |e| by component that correspond to eps_bound."""
        return tuple(math.tanh(v / 2) for v in self.eps_bound)


@dataclass(frozen=True)
class SearchEffort:
    """How long a search runs.

    grid_values: the number of E on a grid. grids: the number of grids, each around the best E of the grid before.
    halvings: of tau, for each grid.
    """

    grid_values: int
    grids: int
    halvings: int


PROOF_EFFORT = SearchEffort(grid_values=32, grids=2, halvings=24)
COMPARISON_EFFORT = SearchEffort(grid_values=32, grids=1, halvings=12)  # to compare gains


def holds(kind: str, loop: SampledLoop, eps_bound: Array, tau: float) -> bool:
    """Return whether balls prove: with |eps_i(0)| < eps_bound[i] and samples no older than tau the state stays in the tube.

    For the general conditions, which are about the norm of eps, every entry of eps_bound is the same bound on it.
    """
    eps_bound = np.asarray(eps_bound, dtype=float)
    if not is_in_range(kind, loop, eps_bound, tau):
        return False
    return first_failing(conditions_of(kind, in_balls(loop), _as_balls(kind, eps_bound), arb(tau))) is None


def _as_balls(kind: str, eps_bound: Array) -> Any:
    """Return E as conditions of this kind take it, in balls: one for the norm, or one by component."""
    return arb(float(eps_bound[0])) if kind == "general" else np.array([arb(v) for v in eps_bound.tolist()], dtype=object)


def _inputs_above(kind: str, loop: SampledLoop, eps_bound: Array) -> Array:
    """Return doubles that are not below the bound on |u|, by window and component.

    They are ends of balls: near an edge the smallest measured distance is a difference of nearly equal numbers, and a double
    loses digits there.
    """
    inputs = np.asarray(SAMPLING_CONDITIONS[kind].inputs(in_balls(loop), _as_balls(kind, eps_bound)), dtype=object)
    return np.asarray(np.vectorize(lambda u: math.nextafter(float(arb(u).abs_upper()), math.inf), otypes=[float])(inputs))


def is_in_range(kind: str, loop: SampledLoop, eps_bound: Array, tau: Any) -> bool:
    """Return whether the conditions apply: every start is inside E, E is within the clamp, and samples are not too old.

    eps_bound and tau are of the loop's kind of number.
    """
    start = loop.numbers.outward(_start_bound(kind, loop), 1e-12)
    is_between = bool((start < eps_bound).all() and (eps_bound <= _largest_eps_bound(kind, loop)).all())
    return is_between and bool(loop.law.latency <= tau <= loop.longest_age)


def inputs_where_proved(loop: SampledLoop, rho: Sequence[Fraction], age: Fraction) -> tuple[Fraction, ...] | None:
    """Return a bound on |u| by component if the sharp conditions hold in fractions (`exact_loop`) for samples of this age.

    rho: e^E by component. None where a condition fails. Windows are checked one by one, so nothing is computed after the first
    condition that fails.
    """
    ratios = np.array(rho, dtype=object)
    if not is_in_range("sharp", loop, ratios, age):
        return None
    largest = 0 * ratios
    for k in range(len(loop.narrow)):
        window = loop.window(k)
        u = input_bound(window, ratios)
        if first_failing(sharp_under(window, ratios, age, u, sharp_closing_speed(window, u))) is not None:
            return None
        largest = np.maximum(largest, u[0])
    return tuple(largest.tolist())


def longest_proved_period(kind: str, loop: SampledLoop) -> Period | None:
    """Return the longest period that the search finds and balls prove; None where not even a short one is proved."""
    candidate = period_candidate(kind, loop)
    if candidate is None:
        return None
    tau, eps_bound = candidate
    shorter = (tau * (1 - retreat) for retreat in RELATIVE_RETREATS)
    return next((_period(kind, loop, eps_bound, t, tau) for t in shorter if holds(kind, loop, eps_bound, t)), None)


def prove_for_period(kind: str, loop: SampledLoop, tau: float) -> Period | None:
    """Prove the conditions at tau seconds with the smallest E that the search finds; None where none is proved."""
    eps_bound = _smallest_proved_bound(kind, loop, tau)
    return None if eps_bound is None else _period(kind, loop, eps_bound, tau, tau)


def is_proved(kind: str, loop: SampledLoop, tau: float) -> bool:
    """Return whether some E is found and proved for tau seconds, for every |k| from `law.gain` to `law.gain_high`."""
    return _smallest_proved_bound(kind, loop, tau) is not None


def _smallest_proved_bound(kind: str, loop: SampledLoop, tau: float) -> Array | None:
    """Return the smallest E that the search finds for tau, raised until balls prove it."""
    candidate = smallest_bound_candidate(kind, loop, tau)
    if candidate is None:
        return None
    raised = (np.minimum(candidate * (1 + retreat), _largest_eps_bound(kind, loop)) for retreat in RELATIVE_RETREATS)
    return next((e for e in raised if holds(kind, loop, e, tau)), None)


def _period(kind: str, loop: SampledLoop, eps_bound: Array, tau: float, longest_tau: float) -> Period:
    """Return the record of a proved period, with its bottleneck at the longest tau."""
    window, dimension = _bottleneck(kind, loop, eps_bound, longest_tau)
    ends = (*loop.windows.times.tolist(), float(loop.windows.times[-1]))
    u = np.minimum(_inputs_above(kind, loop, eps_bound).max(axis=0), loop.law.u_max)
    return Period(kind, tau, tuple(eps_bound.tolist()), tuple(u.tolist()), (ends[window], ends[window + 1], dimension))


def _as_argument(kind: str, eps_bound: Array) -> Any:
    """Return E as conditions of this kind take it: one number for the norm, or one by component."""
    return float(eps_bound[0]) if kind == "general" else eps_bound


def _start_bound(kind: str, loop: SampledLoop) -> Array:
    """Return a lower limit of E, (n,): |eps(0)| by component, or for the general conditions its norm in every entry."""
    return np.full(loop.start.shape, np.sqrt((loop.start**2).sum())) if kind == "general" else loop.start


def _largest_eps_bound(kind: str, loop: SampledLoop) -> Array:
    """Return the largest E that conditions allow, (n,): |eps| at the clamp."""
    largest = loop.numbers.outward(loop.law.eps_at_clamp, -1e-12)
    return np.full(largest.shape, largest.min()) if kind == "general" else largest


# ------------------------------------------------------------------------------------------- search


def period_candidate(kind: str, loop: SampledLoop, effort: SearchEffort = PROOF_EFFORT) -> PeriodCandidate | None:
    """Return the longest period that a search in doubles finds; None where it finds none.

    The period is found by halving for each E of a grid, then again on a grid around the best E.
    """
    require_effort()
    best: PeriodCandidate | None = None
    grid = _first_grid(kind, loop, effort)
    for _ in range(effort.grids):
        candidate = None if grid is None else grid.longest_candidate(effort.halvings)
        if candidate is not None and (best is None or candidate.seconds > best.seconds):
            best = candidate
        grid = None if grid is None or best is None else grid.around(best.eps_bound)
    return best


def smallest_bound_candidate(kind: str, loop: SampledLoop, tau: float) -> Array | None:
    """Return the smallest E, by component, that a search in doubles finds for tau seconds; None where it finds none."""
    eps_bound: Array | None = None
    grid = _first_grid(kind, loop, PROOF_EFFORT)
    for _ in range(PROOF_EFFORT.grids):
        finer = None if grid is None else grid.smallest_bound(tau)
        eps_bound = eps_bound if finer is None else finer
        grid = None if grid is None or eps_bound is None else grid.around(eps_bound)
    return eps_bound


@dataclass(frozen=True)
class _Grid:
    """A grid of E to try. values: (R, n), R bounds E by component, rising."""

    kind: str
    loop: SampledLoop
    values: Array

    def smallest_bound(self, tau: float) -> Array | None:
        """Return the smallest of these E, by component, for which the conditions hold at tau."""
        raise NotImplementedError

    def longest_candidate(self, halvings: int) -> PeriodCandidate | None:
        """Return the longest tau that halving finds, with an E for it; None where not even a short tau has one."""
        best = self.smallest_bound(0.0)
        if best is None:
            return None
        low, high = 0.0, self.loop.longest_age
        at_longest_age = self.smallest_bound(high)
        if at_longest_age is not None:
            return PeriodCandidate(high, at_longest_age)
        for k in range(halvings + FIRST_HALVINGS):
            if k >= halvings and low > 0:
                break  # until then halving goes on, since a period may be short compared with a window
            middle = (low + high) / 2
            eps_bound = self.smallest_bound(middle)
            if eps_bound is None:
                high = middle
            else:
                low, best = middle, eps_bound
        return PeriodCandidate(low, best) if low > 0 else None

    def around(self, eps_bound: Array) -> _Grid:
        """Return a grid of as many values between the neighbours of these."""
        k = np.argmin(np.abs(self.values - eps_bound), axis=0)
        columns, last = np.arange(len(k)), len(self.values) - 1
        low, high = self.values[np.maximum(k - 1, 0), columns], self.values[np.minimum(k + 1, last), columns]
        return replace(self, values=np.geomspace(low, high, last + 1))


def _first_grid(kind: str, loop: SampledLoop, effort: SearchEffort) -> _Grid | None:
    """Return a grid over the whole range of E; None where the range is empty."""
    low, high = np.maximum(_start_bound(kind, loop) * 1.0001, SMALLEST_EPS_BOUND), _largest_eps_bound(kind, loop) * 0.9999
    if not (np.isfinite(low).all() and (low < high).all()):
        return None
    grid_class = _SharpGrid if kind == "sharp" else _SharedBoundGrid
    return grid_class(kind, loop, np.geomspace(low, high, effort.grid_values))


class _SharpGrid(_Grid):
    """A grid for the sharp conditions, which have one E for each component."""

    @cached_property
    def inputs(self) -> Array:
        """A bound on |u| for every E, by window and component: (R, W + 1, n)."""
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            return np.asarray(input_bound(self.loop, self.values[:, None, :]))

    def smallest_bound(self, tau: float) -> Array | None:
        """Raise the E of each component until its conditions hold under the inputs of the others, as often as these change."""
        loop, components = self.loop, np.arange(self.values.shape[1])
        chosen = np.zeros(len(components), dtype=int)
        while True:
            closing_speed = sharp_closing_speed(loop, self.inputs[chosen, :, components].T)
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                conditions = sharp_under(loop, self.values[:, None, :], tau, self.inputs, closing_speed)
            holds_at = np.logical_and.reduce(
                [np.all(np.broadcast_to(c.values > 0, self.inputs.shape), axis=1) for c in conditions]
            )
            holds_at &= np.arange(len(self.values))[:, None] >= chosen
            if not holds_at.any(axis=0).all():
                return None
            raised = holds_at.argmax(axis=0)
            if (raised == chosen).all() or not loop.cross.any():
                return np.asarray(self.values[raised, components])
            chosen = raised


class _SharedBoundGrid(_Grid):
    """A grid for the conditions that have one E for all components."""

    def smallest_bound(self, tau: float) -> Array | None:
        """Return the first E of the grid for which all conditions hold, in every entry."""
        inner = (1,) if self.kind == "general" else (1, 1)
        eps_bound = self.values.max(axis=1).reshape(-1, *inner)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            conditions = conditions_of(self.kind, self.loop, eps_bound, tau)
        holds_at = np.all([np.all(c.values > 0, axis=tuple(range(-len(inner), 0))) for c in conditions], axis=0)
        if not holds_at.any():
            return None
        return np.full(self.values.shape[1], eps_bound.ravel()[int(holds_at.argmax())])


def _bottleneck(kind: str, loop: SampledLoop, eps_bound: Array, tau: float) -> tuple[int, int]:
    """Return the window and the dimension (from 1; 0 for all) with the smallest margin, relative to the margin at tau = 0."""
    e, conditions = _as_argument(kind, eps_bound), SAMPLING_CONDITIONS[kind].conditions
    at_tau, at_rest = conditions(loop, e, tau), conditions(loop, e, 0.0)
    pairs = [(np.asarray(a.values, float), np.asarray(b.values, float)) for a, b in zip(at_tau, at_rest, strict=True)]
    margin_ratio = np.min(
        [np.divide(a, b, out=np.full(a.shape, np.inf), where=(b > 0) & np.isfinite(b)) for a, b in pairs], axis=0
    )
    position = np.unravel_index(int(np.argmin(margin_ratio)), margin_ratio.shape)
    return int(position[0]), int(position[1]) + 1 if len(position) > 1 else 0
