"""Lemmas about scaled inputs, plants of order 2, velocities by differences and feed-forward: verdicts, wrong laws, examples."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
import sympy as sp
from flint import arb

from stt_codegen.lemmas.book import FAMILIES
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict
from stt_codegen.lemmas.sampling import saturated
from stt_codegen.lemmas.tube import inertial_inputs as inertia

PROVED = {
    "limits.scaled", "limits.scaled_size", "limits.scaled_stays", "limits.near_nominal", "filtered.vdot", "filtered.bounded",
    "filtered.gain", "filtered.forever", "filtered.saturated", "filtered.scaled", "filtered.differences", "filtered.stamped", "filtered.forward",
}  # fmt: skip
REFUTED = {
    "limits.clipped", "limits.clipped_leaves", "limits.nominal", "filtered.nominal_period", "filtered.stamps_alone",
    "filtered.forward_held",
}  # fmt: skip


def lemma(name: str) -> Lemma:
    """Return the lemma of this name."""
    return next(v for v in (*saturated.LEMMAS, *inertia.LEMMAS) if v.name == name)


def run_lemma(name: str) -> Outcome:
    """Return the outcome of the lemma of this name."""
    return lemma(name).run()


def test_the_expected_lemmas_are_proved_and_refuted() -> None:
    outcomes = {v.name: v.run() for v in (*saturated.LEMMAS, *inertia.LEMMAS)}
    assert {name for name, outcome in outcomes.items() if outcome.verdict is Verdict.PROVED} == PROVED
    assert {name for name, outcome in outcomes.items() if outcome.verdict is Verdict.REFUTED} == REFUTED
    assert all(outcome.evidence for outcome in outcomes.values())


def test_the_book_contains_them() -> None:
    names = {v.name for _, lemmas in FAMILIES.values() for v in lemmas}
    assert names >= PROVED | REFUTED


def by_component(v: Any, factor: Any) -> Any:
    """Return the input with another gain for every component, which is no scaling."""
    return -saturated.k * factor * sp.Matrix([(i + 1) * value for i, value in enumerate(v)])


def stamps_wrong_by_half(speed: Any, noise: Any, stamp_error: Any, measured_period: Any, true_period: Any) -> Any:
    return inertia.A * true_period**2 / (2 * measured_period) + (speed * stamp_error + 2 * noise) / measured_period


def time_as_measured(speed: Any, noise: Any, stamp_error: Any, measured_period: Any, true_period: Any) -> Any:
    return inertia.A * measured_period / 2 + 2 * (speed * stamp_error + noise) / measured_period


@pytest.mark.parametrize(
    ("module", "name", "wrong", "lemma_name"),
    [
        (saturated, "scaled", by_component, "limits.scaled"),
        (saturated, "scaled", lambda v, factor: saturated.k * factor * v, "limits.scaled"),
        (saturated, "FACTOR", saturated.u_max / saturated.m, "limits.scaled_size"),
        (saturated, "FACTOR", 2 * saturated.FACTOR, "limits.scaled_size"),
        (saturated, "vdot", lambda v, u: v * (2 * saturated.P - saturated.g_min * u), "limits.scaled_stays"),
        (saturated, "vdot", lambda v, u: v * (saturated.P - saturated.g_min * u / 2), "filtered.scaled"),
        (saturated, "V_AT_E", 4 * saturated.Q * saturated.W, "limits.scaled_stays"),
        (saturated, "nominal_error", lambda inverse, m, nominal: inverse * (nominal - m), "limits.near_nominal"),
        (inertia, "REST", inertia.REST - 2 * inertia.lam * inertia.v, "filtered.vdot"),
        (inertia, "REST", inertia.REST.subs(inertia.L, inertia.R), "filtered.vdot"),
        (inertia, "V_MAX", sp.diff(inertia.R, inertia.t), "filtered.bounded"),
        (inertia, "V_MIN", sp.diff(inertia.L, inertia.t), "filtered.bounded"),
        (inertia, "input_over_gain_at", lambda e, width: 4 * e * sp.cosh(e) ** 2 / width, "filtered.saturated"),
        (inertia, "input_over_gain_at", lambda e, width: 4 * e * sp.cosh(e / 2) ** 2 * width, "filtered.saturated"),
        (inertia, "XI_MIN", 2 * inertia.XI_MIN, "filtered.gain"),
        (inertia, "EPSILON_BOUND", inertia.EPSILON_BOUND / 2, "filtered.forever"),
        (inertia, "WEIGHT", inertia.t - inertia.s, "filtered.differences"),
        (inertia, "WEIGHT", 2 * inertia.WEIGHT, "filtered.differences"),
        (inertia, "stamped_bound", stamps_wrong_by_half, "filtered.stamped"),
        (inertia, "stamped_bound", time_as_measured, "filtered.stamped"),
        (inertia, "FEED_FORWARD", -inertia.FEED_FORWARD, "filtered.forward"),
        (inertia, "FEED_FORWARD", sp.diff(inertia.C, inertia.t, 2), "filtered.forward"),
    ],
)
def test_a_wrong_law_leaves_its_lemma_open(module: Any, name: str, wrong: Any, lemma_name: str, monkeypatch: Any) -> None:
    assert run_lemma(lemma_name).verdict is Verdict.PROVED
    monkeypatch.setattr(module, name, wrong)
    outcome = run_lemma(lemma_name)
    assert outcome.verdict is Verdict.OPEN
    assert outcome.evidence
    assert outcome.method != "none"  # a method ran and failed to prove it


UNIT, HALF = sp.Integer(1), sp.Rational(1, 2)


@pytest.mark.parametrize(
    ("module", "name", "harmless", "lemma_name"),
    [
        (saturated, "COUPLED", ((UNIT, HALF), (HALF, 4 * UNIT)), "limits.clipped"),  # row sums say that clipped u points inward
        (
            saturated,
            "COUPLED",
            ((UNIT, 3 * HALF), (3 * HALF, 2 * UNIT)),
            "limits.clipped",
        ),  # not definite, which the statement assumes
        (saturated, "RISES_AT", (HALF / 1000, -HALF / 1000), "limits.clipped"),  # nothing is clipped there
        (saturated, "COUPLED", ((UNIT, HALF), (HALF, 4 * UNIT)), "limits.clipped_leaves"),
        (saturated, "COUPLED", ((UNIT, 3 * HALF), (3 * HALF, 2 * UNIT)), "limits.clipped_leaves"),
        (saturated, "LEAVES_FROM", (HALF / 1000, -HALF / 1000), "limits.clipped_leaves"),
        (saturated, "NOMINAL", saturated.INERTIA, "limits.nominal"),
        (saturated, "INERTIA", saturated.NOMINAL, "limits.nominal"),
        (inertia, "PERIODS", (Fraction(1, 100), Fraction(1, 100)), "filtered.nominal_period"),
        (inertia, "STAMP_ERROR", Fraction(0), "filtered.stamps_alone"),
        (inertia, "JERK", sp.Integer(0), "filtered.forward_held"),
        (inertia, "PERIOD", sp.Rational(1, 1000), "filtered.forward_held"),
    ],
)
def test_a_lemma_is_refuted_only_by_an_example_that_violates_it(
    module: Any, name: str, harmless: Any, lemma_name: str, monkeypatch: Any
) -> None:
    """With an example for which the statement holds, or its assumptions do not, the lemma is open."""
    monkeypatch.setattr(module, name, harmless)
    assert run_lemma(lemma_name).verdict is Verdict.OPEN


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("limits.clipped", ["12.10", "-27.15"]),
        ("limits.clipped_leaves", ["(1, -47/100) at t = 1/5", "-2.619"]),
        ("limits.nominal", ["-26/7", "-143/7"]),
        ("filtered.nominal_period", ["1/10, and 11/2000"]),
        ("filtered.stamps_alone", ["1/45, and 1/50"]),
        ("filtered.forward_held", ["by 1 at most without, by 2 with it", "3/2 and 11/5"]),
    ],
)
def test_the_evidence_shows_the_numbers(name: str, numbers: list[str]) -> None:
    (line,) = run_lemma(name).evidence
    assert [n for n in numbers if n not in line] == []


def simulate(is_clipped: bool, start: tuple[float, float], steps: int = 4000) -> list[tuple[float, float]]:
    """Return the path of the coupled plant in the tube (-1, 1)^2 with u_max = k = 1, by steps of 1/4000 s, until it leaves.

    clip: whether each input is clipped by itself, or the vector is scaled."""
    x, path = [arb(v) for v in start], [start]
    for _ in range(steps):
        v = [(1 / (1 + value) + 1 / (1 - value)) * ((1 + value) / (1 - value)).log() for value in x]
        largest = max(map(abs, v))
        u = [-value / max(abs(value), arb(1)) if is_clipped else -value / max(largest, arb(1)) for value in v]
        x = [
            arb((value + arb(1) / 4000 * (float(row[0]) * u[0] + float(row[1]) * u[1])).mid())
            for value, row in zip(x, saturated.COUPLED, strict=True)
        ]
        path.append((float(x[0]), float(x[1])))
        if max(map(abs, path[-1])) >= 1:
            break
    return path


def test_in_a_simulation_the_clipped_loop_leaves_and_the_scaled_one_does_not() -> None:
    start = (0.9, -0.97)
    clipped, scaled = simulate(True, start), simulate(False, start)
    assert clipped[-1][0] >= 1
    assert len(clipped) / 4000 == pytest.approx(0.2, abs=0.001)
    assert max(abs(c) for state in scaled for c in state) <= 0.97
