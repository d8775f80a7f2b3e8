"""Lemmas about the paper's windows of conflict, the dimension and the side of a detour: verdicts, data, and wrong rules.

Their data are those of the case study; a wrong rule is not proved, and repaired data are no counterexample."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from stt_codegen.design.paper_tubes import conflict_windows as shipped
from stt_codegen.design.paper_tubes.literal import design_literal
from stt_codegen.lemmas.lemma import Outcome, Verdict
from stt_codegen.lemmas.paper import conflict
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT

PROVED = {"inverse", "interval", "disjoint", "admissible", "room"}
REFUTED = {
    "printed_defined", "printed_order", "one_dimension", "from_rho", "shortest", "printed_wall", "random_side",
}  # fmt: skip
Interval = tuple[Fraction, Fraction] | None
TASKS = {s: load_task(ROOT / "tasks" / f"omni_{s.lower()}.toml") for s in conflict.STARTS}


def run_lemma(name: str) -> Outcome:
    """Return the outcome of the lemma `windows.<name>`."""
    return next(v for v in conflict.LEMMAS if v.name == f"windows.{name}").run()


def test_the_expected_lemmas_are_proved_and_refuted() -> None:
    outcomes = {lemma.name.removeprefix("windows."): lemma.run() for lemma in conflict.LEMMAS}
    assert {name for name, outcome in outcomes.items() if outcome.verdict is Verdict.PROVED} == PROVED
    assert {name for name, outcome in outcomes.items() if outcome.verdict is Verdict.REFUTED} == REFUTED
    assert all(outcome.evidence for outcome in outcomes.values())


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("printed_defined", ["39 of 96", "16 divide by 0", "6 are atanh of 1 or -1", "17 of what lies beyond"]),
        ("printed_order", ["0.4931 t_c", "[0.5, 1]"]),
        ("one_dimension", ["x1 of T within that of O4", "x2 of T within that of O1"]),
        ("from_rho", ["beta_L = 6.2", "in x2 for none"]),
        ("shortest", ["S1 with O1", "x1 is picked", "S3 with O4", "x2 is picked"]),
        ("printed_wall", ["beta_U = -0.1"]),
        ("random_side", ["beta_L = 5.2, beta_U = 5"]),
    ],
)
def test_the_evidence_shows_the_numbers(name: str, numbers: list[str]) -> None:
    (line,) = run_lemma(name).evidence
    assert [n for n in numbers if n not in line] == []


def test_the_data_are_those_of_the_example_tasks() -> None:
    for name, task in TASKS.items():
        sets = {"X": task.state_space, "X0": task.initial_set, "T": task.target_set, **{u.name: u for u in task.unsafe}}
        boxes = {key: tuple(zip(box.lower, box.upper, strict=True)) for key, box in sets.items()}
        assert boxes == {"X": conflict.STATE_SPACE, "X0": conflict.STARTS[name], "T": conflict.TARGET, **conflict.UNSAFE}


@pytest.mark.parametrize(("start", "unsafe"), [("S1", "O1"), ("S3", "O4")])
def test_the_literal_design_picks_the_dimension_that_the_lemma_refutes(start: str, unsafe: str) -> None:
    dimensions = [b.dimension + 1 for b in design_literal(TASKS[start]).bumps if b.unsafe == unsafe]
    assert len(dimensions) == 1
    assert f"x{dimensions[0]} is picked" in next(
        p for p in run_lemma("shortest").evidence[0].split("; S") if f" with {unsafe}" in p
    )


# ---- wrong functions in place of the shipped ones

shipped_window = shipped.conflict_in_sigma


def wrong_sign(start: Any, target: Any, unsafe: Any) -> Interval:
    """Require rho_L >= upper(U) in the place of rho_L <= upper(U)."""
    above, below = (
        shipped._where_at_least(start[1], target[1], unsafe[0]),
        shipped._where_at_least(start[0], target[0], unsafe[1]),
    )
    if above is None or below is None:
        return None
    low, high = max(above[0], below[0]), min(above[1], below[1])
    return (low, high) if low <= high else None


def from_one_inequality(start: Any, target: Any, unsafe: Any) -> Interval:
    """Use only the first inequality."""
    return shipped._where_at_least(start[1], target[1], unsafe[0])


def hull_of_half_lines(start: Any, target: Any, unsafe: Any) -> Interval:
    """Return the hull of both half lines in the place of their intersection."""
    above, below = (
        shipped._where_at_least(start[1], target[1], unsafe[0]),
        shipped._where_at_least(-start[0], -target[0], -unsafe[1]),
    )
    if above is None or below is None:
        return None
    return min(above[0], below[0]), max(above[1], below[1])


def without_touching(start: Any, target: Any, unsafe: Any) -> Interval:
    """Return no window where it is a single sigma."""
    window = shipped_window(start, target, unsafe)
    return None if window is not None and window[0] == window[1] else window


def extended_to_the_end(start: Any, target: Any, unsafe: Any) -> Interval:
    """Extend a window that begins at 0 to the end, which is right for most data."""
    window = shipped_window(start, target, unsafe)
    return (window[0], Fraction(1)) if window is not None and window[0] == 0 else window


def ended_early(start: Any, target: Any, unsafe: Any) -> Interval:
    """End the window slightly early, between two of the lemma's points."""
    window = shipped_window(start, target, unsafe)
    return (window[0], window[1] - (window[1] - window[0]) / 1000) if window is not None else None


def without_equal_edges(start: Any, target: Any, unsafe: Any) -> Interval:
    """Return no window where the target's edge equals the start's, where the paper's (5) divides by 0."""
    return None if start[1] == target[1] or start[0] == target[0] else shipped_window(start, target, unsafe)


@pytest.mark.parametrize(
    "wrong",
    [
        wrong_sign,
        from_one_inequality,
        hull_of_half_lines,
        without_touching,
        extended_to_the_end,
        ended_early,
        without_equal_edges,
    ],
)
def test_a_wrong_window_is_not_proved(wrong: Callable[..., Interval], monkeypatch: pytest.MonkeyPatch) -> None:
    assert run_lemma("interval").verdict is Verdict.PROVED
    monkeypatch.setattr(shipped, "conflict_in_sigma", wrong)
    outcome = run_lemma("interval")
    assert outcome.verdict is Verdict.OPEN
    assert " 0 wrong" not in outcome.evidence[0]


def wrong_inverse(sigma: Fraction, t_c: Fraction) -> float:
    if sigma >= 1:
        return float(t_c)
    a = math.atanh(float(sigma))
    return float(t_c) * a / (1 - a)


def without_atanh(sigma: Fraction, t_c: Fraction) -> float:
    return float(t_c) * float(sigma) / (1 + float(sigma)) if sigma < 1 else float(t_c)


def wrong_end(sigma: Fraction, t_c: Fraction) -> float:
    a = math.atanh(float(sigma)) if sigma < 1 else 1.0
    return float(t_c) * a / (1 + a)


@pytest.mark.parametrize("wrong", [wrong_inverse, without_atanh, wrong_end])
def test_a_wrong_inverse_is_not_proved(wrong: Callable[..., float], monkeypatch: pytest.MonkeyPatch) -> None:
    assert run_lemma("inverse").verdict is Verdict.PROVED
    monkeypatch.setattr(shipped, "time_of_sigma", wrong)
    outcome = run_lemma("inverse")
    assert outcome.verdict is Verdict.OPEN
    assert outcome.evidence


def touching_is_apart(a: Any, b: Any) -> bool:
    return bool(a[1] <= b[0] or a[0] >= b[1])


def test_boxes_that_touch_are_not_disjoint(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conflict, "_are_apart", touching_is_apart)
    assert run_lemma("disjoint").verdict is Verdict.OPEN


# ---- repaired data are no counterexample

box = conflict._box
FAR = {"O1": box("1 2", "2 3"), "O2": box("3 4", "2 3"), "O3": box("1 2", "1 1.5"), "O4": box("1 1.5", "1.5 2.5")}


@pytest.mark.parametrize(
    ("name", "attribute", "repaired"),
    [
        ("printed_order", "WIDENING", (box("0 1", "4 5"), box("2 2.5", "2.5 3"))),  # both edges rise, where (5) is right
        ("one_dimension", "TARGET", box("4.5 5", "3.6 3.9")),
        ("from_rho", "DETOUR", (*conflict.DETOUR[:3], box("4 6", "6.3 8"))),
        ("from_rho", "DETOUR", (*conflict.DETOUR[:3], box("7 9", "6.1 8"))),
        ("from_rho", "DETOUR", (*conflict.DETOUR[:3], box("4 6", "5.2 8"))),  # rho meets this one
        ("shortest", "UNSAFE", {**conflict.UNSAFE, "O1": box("1 2", "1 2")}),  # x2 never overlaps it, and is chosen
        ("printed_wall", "WALL", box("0 10", "0 1.5")),
        ("printed_wall", "WALL", box("0 10", "0.2 1.5")),
        ("random_side", "SQUEEZE", (conflict.SQUEEZE[0], box("4 6", "5.5 7"))),
        ("random_side", "SQUEEZE", (conflict.SQUEEZE[0], box("7 8", "5.2 7"))),
    ],
)
def test_repaired_data_are_no_counterexample(name: str, attribute: str, repaired: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run_lemma(name).verdict is Verdict.REFUTED
    monkeypatch.setattr(conflict, attribute, repaired)
    outcome = run_lemma(name)
    assert outcome.verdict is Verdict.OPEN
    assert " holds at " in outcome.evidence[0]  # a method ran


def test_terms_that_are_all_defined_are_no_counterexample(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conflict, "STARTS", {"S": box("0 0.5", "0 0.5")})
    monkeypatch.setattr(conflict, "UNSAFE", FAR)
    outcome = run_lemma("printed_defined")
    assert outcome.verdict is Verdict.OPEN
    assert "0 of 32" in outcome.evidence[0]


def test_a_set_as_wide_as_the_space_has_no_admissible_detour(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conflict, "UNSAFE", {**conflict.UNSAFE, "O1": box("1 2", "0.1 4.9")})
    outcome = run_lemma("admissible")
    assert outcome.verdict is Verdict.OPEN
    assert "S1 with O1: none" in outcome.evidence[0]
