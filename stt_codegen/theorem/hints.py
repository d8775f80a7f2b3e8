"""Hints for Coq's proof of P9, which Coq checks before it uses them: bounds on |u| and its logarithm, and a number of cells.

theorem/tube_theorem.py and theorem/controller_theorem.py write them. The formulas are those of sampling/sampling_conditions.py.
proof/Period.v differs from them in two places. It cuts the range of a width into cells, in place of a lemma on what lies between
both ends. And it lets rounding take its share of the broadest width of two windows, not of the narrowest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.sampling import (
    Bounds,
    Fractions,
    SampledLaw,
    SampledLoop,
    distances_at_sample,
    drift_of_sample,
    emitted_input,
    first_order_loop,
    in_doubles,
    measured_distances,
    refined_windows,
    sharp_closing_speed,
    start_bound_of_share,
    weakest_effect,
    worst_with_previous_window,
)
from stt_codegen.theorem.facts import Facts, SampledFacts

HINT_BITS = 24  # of a hint after the binary point, so that fractions in Coq stay short
INPUT_MARGIN = 1 + Fraction(1, 1 << 20)
CELL_COUNTS = (1, 2, 4, 8, 16, 32, 64, 128)
LOGARITHM_MARGIN = Fraction(1, 1 << 16)  # proof/HeldInputLaw.v knows exponentials that closely
FLOAT_MARGIN = 2.0**-16  # of the conditions that are decided here in floating point, and by Coq exactly
Array = npt.NDArray[Any]
Hint = tuple[Fraction, Fraction]  # bounds on |u| and on the logarithm


def _enclosed_logarithm(value: Any) -> tuple[float, Fraction]:
    """Return a lower and an upper bound on a logarithm that Coq can prove, the upper one of few bits."""
    logarithm = math.log(value)
    return logarithm - FLOAT_MARGIN, _round_up(Fraction(logarithm) + LOGARITHM_MARGIN)


def _round_up(value: Fraction) -> Fraction:
    return Fraction(math.ceil(value * (1 << HINT_BITS)), 1 << HINT_BITS)


NUMBERS = Fractions(_enclosed_logarithm)


def loop_of_facts(facts: Facts, sampling: SampledFacts) -> SampledLoop:
    """Return the sampled loop of the files, in fractions; bounds on |eps| are rho = e^E."""

    def array(values: tuple[Fraction, ...]) -> Array:
        return np.array(values, dtype=object)

    windows, n = refined_windows(facts.design, NUMBERS), facts.n
    plant = Bounds(
        disturbance=array(sampling.disturbance),
        diagonal_min=array(sampling.g_min),
        diagonal_max=array(sampling.g_max),
        cross=array(sampling.g_cross)[:, None] * (1 - np.eye(n, dtype=int)),
        disturbance_norm=Fraction(0),  # no theorem is about the conditions in norms
        eigenvalue_min=Fraction(0),
        norm=Fraction(0),
    )
    law = SampledLaw(
        gain=array(facts.gain),
        e_max=array(facts.e_max),
        shift=array(sampling.shift),
        u_max=np.full(n, np.inf) if facts.u_max is None else array(facts.u_max),
        rounding=sampling.law_error,
        latency=sampling.latency,
        numbers=NUMBERS,
    )
    return first_order_loop(windows, [plant] * len(windows.narrow), law, start_bound_of_share(sampling.share, n, NUMBERS))


def input_hints(facts: Facts, sampling: SampledFacts) -> list[list[Hint]]:
    """Return the hints by window and component; a window is a segment, or the time from t_c on."""
    loop = loop_of_facts(facts, sampling)
    far, near = measured_distances(loop, np.array(sampling.rho, dtype=object))
    return [[_hint(loop, i, far[k, i], near[k, i]) for i in range(facts.n)] for k in range(len(far))]


def _hint(loop: SampledLoop, i: int, far: Fraction, near: Fraction) -> Hint:
    """Return the hint of a component in a window in which the law measures at least `near` and at most `far`."""
    limit = loop.law.u_max[i]
    if near <= 0:
        return Fraction(0) if math.isinf(limit) else limit, Fraction(0)
    logarithm = loop.numbers.log_above(far / near)
    u = _round_up(emitted_input(loop.law.gain[i], far, near, lambda _: logarithm, loop.law.rounding) * INPUT_MARGIN)
    return (limit, Fraction(0)) if limit <= u else (u, logarithm)


@dataclass(frozen=True)
class CoqConditions:
    """The conditions of `period_check` of proof/Period.v, in floating point and so with a margin.

    loop: in doubles. rho, tau: as in the sharp conditions. inputs, closing_speed: U and P' by window and component.
    """

    loop: SampledLoop
    rho: Array
    tau: float
    inputs: Array
    closing_speed: Array

    @classmethod
    def of(cls, facts: Facts, sampling: SampledFacts, hints: list[list[Hint]]) -> CoqConditions:
        """Return the conditions for the inputs that the hints state."""
        loop = loop_of_facts(facts, sampling)
        inputs = np.array([[u for u, _ in row] for row in hints], dtype=object)
        closing_speed = sharp_closing_speed(loop, inputs).astype(float)
        age = float(sampling.period + sampling.latency)
        return cls(in_doubles(loop), np.array(sampling.rho, dtype=float), age, inputs.astype(float), closing_speed)

    def turns_in_time(self) -> bool:
        """Whether x stays on its side of the tube until the next input acts, and u_max outdoes the closing speed."""
        loop, windows, law = self.loop, self.loop.windows, self.loop.law
        moved = (self.closing_speed + loop.diagonal_max * self.inputs) * self.tau
        broadest = worst_with_previous_window(windows.wide, np.maximum)  # Coq's own, see the head of this file
        uncertain = 2 * law.shift + law.rounding * (broadest + 2 * law.shift) + FLOAT_MARGIN * windows.narrow
        stays = uncertain < windows.narrow * loop.numbers.share_of_eps(self.rho) - 2 * moved
        outdoes = self.closing_speed * (1 + FLOAT_MARGIN) <= loop.diagonal_min * law.u_max
        return bool(np.all(stays & outdoes))

    def pushes_back(self, cell_count: int) -> bool:
        """Whether in every one of so many cells the input moves x back faster than an edge closes in."""
        low, high = self.loop.windows.narrow, self.loop.windows.wide
        drift = drift_of_sample(self.loop, self.closing_speed, self.tau, self.inputs)
        for k in range(cell_count):
            begin, end = (low + (high - low) * j / cell_count for j in (k, k + 1))
            far, near = distances_at_sample(self.loop, begin, self.rho, drift)
            _, near_at_end = distances_at_sample(self.loop, end, self.rho, drift)
            if not np.all(far > near):
                return False
            # Coq knows only one 1/b for a whole cell: that of its end
            if not np.all(weakest_effect(self.loop, far, near) * near / near_at_end > self.closing_speed):
                return False
        return True


def smallest_cell_count(facts: Facts, sampling: SampledFacts, hints: list[list[Hint]]) -> int:
    """Return the smallest number of cells in which Coq finds that the law pushes back enough, or the largest allowed."""
    conditions = CoqConditions.of(facts, sampling, hints)
    return next((m for m in CELL_COUNTS if conditions.pushes_back(m)), CELL_COUNTS[-1])


def is_period_proved(facts: Facts, sampling: SampledFacts) -> bool:
    """Return whether the conditions of every window hold that `period_check` of proof/Period.v asks for, decided with a margin.

    Not decided here is what `period_check` asks besides: of the clamp, the start share, rho and the age of a sample."""
    if any((1 - e) / 2 * (1 + rho) > 1 for e, rho in zip(facts.e_max, sampling.rho, strict=True)):
        return False
    conditions = CoqConditions.of(facts, sampling, input_hints(facts, sampling))
    return conditions.turns_in_time() and any(map(conditions.pushes_back, CELL_COUNTS))
