"""Missions: their formulas, the algebra that proves them, unions of regions, tubes that carry missions out, and the checker."""

from __future__ import annotations

import dataclasses
import json
import re
import sys
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.mission_mutants import judge_mutant
from benchmarks.suites.scenarios import SCENARIO_FAMILIES, random_mission
from stt_codegen.certify.missions.schedule import describe_entry, has_momentary_visit, phases, served_entries
from stt_codegen.certify.monitor import holds, satisfied
from stt_codegen.checker import check_files
from stt_codegen.constraints import mission_avoidances
from stt_codegen.design.mission_search import MissionSearch
from stt_codegen.design.missions import TIME_MARGIN_SPEED, Plan, Skeleton
from stt_codegen.design.missions.orders import Stop
from stt_codegen.design.missions.plans import _pauses
from stt_codegen.design.missions.skeleton import Hold
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.effort import Effort
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import with_gain
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import EmittedController, build, build_task, certify, render_files
from stt_codegen.plants import plant_of
from stt_codegen.task.load import parse_task
from stt_codegen.task.mission.formulas import (
    Always,
    And,
    Eventually,
    Formula,
    InRegion,
    Interval,
    Or,
    Until,
    conjunction,
    disjunction,
    negation,
    replace_regions,
)
from stt_codegen.task.mission.grammar import parse_formula
from stt_codegen.task.mission.regions import StateFormula, state_formulas_of, with_state_formulas
from tests.benchmarks.test_peers import needs
from tests.support.controllers import ROOT, build_once

NAMES = ("a", "b", "c")
LAST = 12  # seconds after which nothing changes; all times in these formulas are whole seconds
GRID = 2 * LAST + 1  # places in time: every whole second, and every open interval between two of them
Signal = Mapping[str, np.ndarray[Any, Any]]  # by region: whether the state is in it at each place of the grid

COURIER = """
name = "courier"
prescribed_time = 24
initial_state = [0.5, 0.5]
state_space = { lower = [0, 0], upper = [8, 6] }
initial_set = { lower = [0.1, 0.1], upper = [0.9, 0.9] }
target_set = { lower = [6.5, 4.5], upper = [7.8, 5.8] }
unsafe = [{ name = "shelf", lower = [3, 1], upper = [4, 4] }]
region = [
  { name = "dock", lower = [1, 4.5], upper = [2.2, 5.7] },
  { name = "left", lower = [4.5, 0.3], upper = [5.5, 1.3] },
  { name = "right", lower = [6.5, 0.3], upper = [7.5, 1.3] },
  { name = "exit", any_of = ["left", "right"] },
  { name = "lab", centre = [2.5, 2.6], radius = 0.4 },
]
mission = [
  { visit = "dock", between = [4, 9], stay = 2, then = "exit", within = 8 },
  { never = "lab", before = "dock" },
]
"""


@cache
def courier_controller() -> EmittedController:
    """Return the controller of `COURIER`."""
    return build_once(parse_task(COURIER))


# --------------------------------------------------------------------------------------------------- formulas


def windows() -> Any:
    """Windows [a, b] of whole seconds between 0 and 4."""
    return st.tuples(st.integers(0, 4), st.integers(0, 4)).map(lambda v: Interval(Fraction(min(v)), Fraction(max(v))))


def formulas(depth: int = 3) -> Any:
    """Formulas about the regions of `NAMES`, with at most `depth + 1` regions."""
    leaves = st.builds(InRegion, st.sampled_from(NAMES), st.booleans())
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.builds(conjunction, inner, inner),
            st.builds(disjunction, inner, inner),
            st.builds(Always, windows(), inner),
            st.builds(Eventually, windows(), inner),
            st.builds(Until, windows(), inner, inner),
        ),
        max_leaves=depth + 1,
    )


def truth(formula: Formula, signal: Signal) -> np.ndarray[Any, Any]:
    """Return whether a formula holds at each place of the grid, by its definition.

    Windows are whole seconds, so nothing changes between two whole seconds; after the last place everything stays as it is there."""
    places = np.arange(GRID)

    def places_in_window(t: int, over: Interval) -> range:
        """Return the places of the window that begins at place t."""
        assert over.end is not None
        return range(t + 2 * int(over.begin), t + 2 * int(over.end) + 1)

    match formula:
        case StateFormula(inner):
            return truth(inner, signal)
        case InRegion(region, is_negated):
            return signal[region] != is_negated
        case And(parts):
            return np.all([truth(p, signal) for p in parts], axis=0)
        case Or(parts):
            return np.any([truth(p, signal) for p in parts], axis=0)
    if isinstance(formula, Always | Eventually):
        inner = truth(formula.part, signal)
        values = [[bool(inner[min(s, GRID - 1)]) for s in places_in_window(t, formula.over)] for t in places]
        return np.array([(all if isinstance(formula, Always) else any)(value_in_window) for value_in_window in values])
    assert isinstance(formula, Until)
    first, last = truth(formula.first, signal), truth(formula.last, signal)
    return np.array(
        [
            any(
                last[min(s, GRID - 1)] and all(first[min(r, GRID - 1)] for r in range(t, s + 1))
                for s in places_in_window(t, formula.over)
            )
            for t in places
        ]
    )


def signals() -> Any:
    """Signals that are true on closed intervals: what is true between two whole seconds is true at both."""

    def closed(bits: list[bool]) -> np.ndarray[Any, Any]:
        signal = np.array(bits, dtype=bool)
        signal[0::2][:-1] |= signal[1::2]
        signal[0::2][1:] |= signal[1::2]
        return signal

    return st.lists(st.booleans(), min_size=GRID, max_size=GRID).map(closed)


@given(formulas())
def test_a_formula_is_read_as_it_is_written(formula: Formula) -> None:
    assert parse_formula(str(formula)) == formula


@given(formulas(), st.fixed_dictionaries({name: st.lists(st.booleans(), min_size=GRID, max_size=GRID) for name in NAMES}))
@settings(max_examples=150, deadline=None)
def test_a_formula_and_its_negation_never_hold_together(formula: Formula, bits: dict[str, list[bool]]) -> None:
    signal = {name: np.array(v) for name, v in bits.items()}
    assert not (truth(formula, signal) & truth(negation(formula), signal)).any()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("always[0,3) a", "']' is needed"),
        ("a b", "the end"),
        ("", "ends where a region"),
        ("eventually[2,1] a", "from must not be after to"),
        ("a $ b", "no word of a formula"),
        ("not until a", "a region"),
        ("always[0, x] a", "a number of seconds"),
        ("(" * 60 + "a" + ")" * 60, "nested more than"),
    ],
)
def test_a_text_that_is_no_formula_is_refused_with_the_reason(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        parse_formula(text)


# --------------------------------------------------------------------------------------------------- the monitor


def spans(bits: np.ndarray[Any, Any]) -> list[tuple[Any, Any]]:
    """Return the closed intervals of a signal, in seconds; one that contains the first or last place has no end there."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], bits, [False]]).astype(int)))
    intervals = []
    for a, b in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        if a % 2 == 0 and b % 2 == 0:
            intervals.append((-float("inf") if a == 0 else Fraction(a, 2), float("inf") if b == GRID - 1 else Fraction(b, 2)))
    return intervals


def proved_of(formula: Formula, signal: Signal) -> dict[StateFormula, list[tuple[Any, Any]]]:
    """Return, by state formula, the closed intervals on which it holds."""
    intervals = {}
    for state in state_formulas_of(formula):
        bits = truth(state.inner, signal)
        for k in range(1, GRID - 1, 2):  # an open interval counts only with both of its ends
            bits[k] &= bits[k - 1] and bits[k + 1]
        intervals[state] = spans(bits)
    return intervals


@given(formulas(4), st.fixed_dictionaries({name: signals() for name in NAMES}))
@settings(max_examples=300, deadline=None)
def test_what_the_algebra_proves_is_true(formula: Formula, signal: Signal) -> None:
    stated = with_state_formulas(formula, frozenset(NAMES))
    proved = satisfied(stated, proved_of(stated, signal))
    true_at = truth(formula, signal)
    for k in range(GRID):
        if any(a <= Fraction(k, 2) <= b for a, b in proved):
            assert true_at[k], (str(formula), k)


@given(formulas(3), st.fixed_dictionaries({name: signals() for name in NAMES}))
@settings(max_examples=300, deadline=None)
def test_for_closed_sets_the_algebra_proves_all_that_is_true(formula: Formula, signal: Signal) -> None:
    """Without "not" every set is closed, and each state has its own intervals, so nothing is lost."""
    plain = replace_regions(formula, lambda leaf: InRegion(leaf.region))
    stated = with_state_formulas(plain, frozenset())
    proved = satisfied(stated, proved_of(stated, signal))
    true_at = truth(plain, signal)
    for k in range(0, GRID, 2):
        assert any(a <= Fraction(k, 2) <= b for a, b in proved) == true_at[k], (str(plain), k)


@given(formulas(3), st.fixed_dictionaries({name: signals() for name in NAMES}), st.integers(-2, 2))
@settings(max_examples=200, deadline=None)
def test_a_formula_with_a_margin_in_time_holds_for_a_clock_that_is_off_by_it(
    formula: Formula, signal: Signal, error: int
) -> None:
    stated = with_state_formulas(formula, frozenset(NAMES))
    proved = proved_of(stated, signal)
    if holds(stated, proved, Fraction(2)):
        shifted = {s: [(a + error, b + error) for a, b in intervals] for s, intervals in proved.items()}
        assert holds(stated, shifted)


# --------------------------------------------------------------------------------------------------- unions


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_a_tube_avoids_the_rest_exactly_where_it_lies_in_the_union(data: Any) -> None:
    """A state formula of regions becomes sets to avoid: what is left of the space outside of the formula's union."""
    boxes = {}
    for name in NAMES:
        low = [data.draw(st.integers(0, 6)) for _ in range(2)]
        boxes[name] = (low, [v + data.draw(st.integers(1, 4)) for v in low])
    regions = ", ".join(f'{{ name = "{k}", lower = {a}, upper = {b} }}' for k, (a, b) in boxes.items())
    formula = data.draw(st.sampled_from(["a or b", "a or b or c", "a or not b", "a and b or c", "not a or not b"]))
    head = COURIER[: COURIER.index("unsafe")].replace("upper = [8, 6]", "upper = [12, 12]")
    task = parse_task(f'{head}region = [{regions}]\nmission = [{{ formula = "{formula}" }}]\n[tube]\nclearance = 0\n')
    states = [*state_formulas_of(task.formula)]  # type: ignore[arg-type]
    all_avoidances = [avoidance for state in states for avoidance in mission_avoidances(task, state)]
    avoidances_of_state = {str(state): [a for a in all_avoidances if a.name == str(state)] for state in states}
    low = [data.draw(st.integers(0, 9)) + 0.25 for _ in range(2)]
    high = [v + data.draw(st.integers(0, 3)) + 0.5 for v in low]
    is_avoided = {
        name: all(
            any(
                sum(c * (high if side else low)[i] for i, side, c in constraint.terms)
                >= float(constraint.bound + constraint.clearance)
                for constraint in avoidance.alternatives
            )
            for avoidance in avoidances
        )
        for name, avoidances in avoidances_of_state.items()
    }
    (avoids_the_rest,) = is_avoided.values()
    steps = [np.arange(a + 0.125, b, 0.25) for a, b in zip(low, high, strict=True)]

    def is_inside(name: str, x: tuple[float, ...]) -> bool:
        return all(a < v < b for a, v, b in zip(boxes[name][0], x, boxes[name][1], strict=True))

    def is_true_at(formula_at: Formula, x: tuple[float, ...]) -> bool:
        match formula_at:
            case InRegion(region, is_negated):
                return is_inside(region, x) != is_negated
            case And(parts):
                return all(is_true_at(p, x) for p in parts)
            case Or(parts):
                return any(is_true_at(p, x) for p in parts)
        raise AssertionError(formula_at)

    assert avoids_the_rest == all(is_true_at(parse_formula(formula), x) for x in product(*steps))


# --------------------------------------------------------------------------------------------------- tubes


def exit_code_of_checker(controller: EmittedController, text: str, folder: Path) -> int:
    """Write the task and the controller's files into the folder, and return the checker's exit code."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    (folder / "task.toml").write_text(text)
    name = controller.task.name
    return check_files([str(folder / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")])


def regions_at(controller: EmittedController, x: np.ndarray[Any, Any]) -> dict[str, bool]:
    """Return, by region that is one set, whether a point is in it."""
    is_inside = {}
    for name, region in controller.task.regions.items():
        if hasattr(region, "any_of"):
            continue
        if hasattr(region, "vertices"):
            faces = [([float(c) for c in n], float(h)) for n, h in region.half_spaces()]
            is_inside[name] = all(float(np.dot(n, x)) <= h for n, h in faces)
        elif hasattr(region, "radius"):
            is_inside[name] = bool(np.hypot(*(x - [float(v) for v in region.centre])) <= float(region.radius))
        else:
            low, high = ([float(v) for v in e] for e in (region.lower, region.upper))  # type: ignore[union-attr]
            is_inside[name] = all(a <= v <= b for a, v, b in zip(low, x, high, strict=True))
    return is_inside


def test_a_courier_is_certified_and_its_witnesses_are_true(tmp_path: Path, capsys: Any) -> None:
    controller = courier_controller()
    assert exit_code_of_checker(controller, COURIER, tmp_path) == 0
    assert "P10" in capsys.readouterr().out
    proof = controller.certificate.mission
    assert proof is not None
    (visit, choice), (key,) = proof.witnesses
    assert (str(visit.state), str(choice.state), str(key.state)) in {
        ("dock", "left", "dock"), ("dock", "right", "dock"), ("dock", "(left or right)", "dock"),
    }  # fmt: skip
    assert 4 <= visit.begin <= 9
    assert visit.end - visit.begin >= 2

    times = np.linspace(float(visit.begin), float(visit.end), 50)
    low, high = controller.design.edges_at(times)
    assert (low >= [1, 4.5]).all()
    assert (high <= [2.2, 5.7]).all()
    times_before_key = np.linspace(0, float(key.begin), 200)
    low, high = controller.design.edges_at(times_before_key)
    nearest = np.clip([2.5, 2.6], low, high)
    assert (np.hypot(*(nearest - [2.5, 2.6]).T) >= 0.4).all()


def test_the_documents_example_is_what_design_prints(tmp_path: Path) -> None:
    controller = build(ROOT / "tasks" / "courier.toml")
    proof = controller.certificate.mission
    assert proof is not None
    page = (ROOT / "docs" / "missions.md").read_text()
    for served in served_entries(controller.task, proof):
        assert f"    mission {served.entry}, {describe_entry(served)}\n" in page


def test_phases_follow_the_visits() -> None:
    controller = courier_controller()
    phases_of_mission = phases(controller.task, controller.certificate.mission)  # type: ignore[arg-type]
    assert [k for _, k in phases_of_mission] == [1]
    module: dict[str, Any] = {}
    exec(controller.files["courier.py"].decode(), module)
    (end, _) = phases_of_mission[-1]
    assert module["phase"](0.0) == 1
    assert module["phase"](float(end) - 0.01) == 1
    assert module["phase"](float(end) + 0.01) == 0
    assert "int courier_phase(courier_real t);" in controller.files["courier.h"].decode()
    assert b"phase" not in controller.files["courier.c"]


@pytest.mark.parametrize("name", [s.name for family in SCENARIO_FAMILIES.values() for s in family() if not s.is_infeasible])
def test_the_scenarios_of_the_benchmark_are_certified_and_accepted(name: str, tmp_path: Path) -> None:
    (scenario,) = (s for family in SCENARIO_FAMILIES.values() for s in family() if s.name == name)
    assert exit_code_of_checker(build_once(parse_task(scenario.text)), scenario.text, tmp_path) == 0


@pytest.mark.parametrize("n", [2, 3])
def test_random_missions_are_carried_out_by_every_trajectory(n: int, tmp_path: Path) -> None:
    """Trajectories between random corners of the tube meet the missions' definitions at 3001 times."""

    for seed in range(3):
        text = random_mission(seed, n, 6)
        controller = build_once(parse_task(text))
        assert exit_code_of_checker(controller, text, tmp_path) == 0
        task, draw = controller.task, np.random.default_rng(seed)
        t = np.linspace(0, float(task.prescribed_time), 3001)
        low, high = controller.design.edges_at(t)
        for _ in range(4):
            share = np.interp(t, np.linspace(0, t[-1], 40), draw.integers(0, 2, 40))[:, None]
            regions_by_time = [regions_at(controller, x) for x in low + share * (high - low)]
            is_in = {name: np.array([regions[name] for regions in regions_by_time]) for name in regions_by_time[0]}
            is_in["either"] = is_in["r2"] | is_in["r5"]
            for entry in task.mission:
                if entry.visit is not None:
                    begin, end = entry.between or (0, task.prescribed_time)
                    window = (t >= float(begin)) & (t <= float(end))
                    stay = float(entry.stay or 0)
                    is_met = [is_in[entry.visit][(t >= s) & (t <= s + stay)].all() for s in t[window & is_in[entry.visit]]]
                    assert any(is_met), (seed, entry.visit)
                if entry.never is not None and entry.before is not None:
                    assert is_in[entry.before].any()
                    reached = int(np.argmax(is_in[entry.before]))
                    assert not is_in[entry.never][: reached + 1].any()


def test_stones_without_a_route_are_refused_with_the_reason() -> None:
    (scenario,) = (s for s in SCENARIO_FAMILIES["stlpy"]() if s.is_infeasible)
    with pytest.raises(NotCertified, match=r"mission \(P10\): no order .*certified without mission\[0\]"):
        build_once(parse_task(scenario.text))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("lower = [1, 4.5]", "lower = [1, 5.695]"), r"no place was found in dock"),
        (('before = "dock"', 'before = "lab"'), r"without mission\[1\] \(never lab before lab\)"),
        (
            ('name = "shelf", lower = [3, 1], upper = [4, 4]', 'name = "shelf", lower = [3, 0], upper = [4, 6]'),
            r"without|no order",
        ),
    ],
)
def test_a_refusal_names_the_region_or_entry_that_prevents_a_tube(change: tuple[str, str], message: str) -> None:
    with pytest.raises(NotCertified, match=message):
        build_once(parse_task(COURIER.replace(*change)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('visit = "dock"', 'visit = "dok"'), "mission[0].visit: 'dok' is no region"),
        (("between = [4, 9]", "between = [9, 4]"), "mission[0].between: is [9, 4]"),
        (("stay = 2", "stay = 30"), "mission[0].stay: lasts to 34 s"),
        (('never = "lab", ', ""), "mission[1]: says nothing"),
        (('never = "lab"', 'never = "lab", visit = "dock"'), "mission[1]: has visit and never"),
        (('before = "dock"', "every = 3"), "mission[1].every: is not for never"),
        (('any_of = ["left", "right"]', 'any_of = ["left", "up"]'), "region[3].any_of: 'up' is no region before"),
        (('name = "dock"', 'name = "the dock"'), "region[0].name"),
        (('name = "right"', 'name = "left"'), "region[2].name: 'left' is already"),
        (
            ('{ never = "lab", before = "dock" }', '{ formula = "always[0, 30] not lab" }'),
            "mission[1].formula: the window [0, 30]",
        ),
        (('{ never = "lab", before = "dock" }', '{ formula = "always not lab)" }'), "mission[1].formula: has ')'"),
        (('{ never = "lab", before = "dock" }', '{ patrol = ["dock"] }'), "mission[1].every: is missing"),
        (
            ("centre = [2.5, 2.6], radius = 0.4", "centre = [2.5, 2.6], radius = 0.4, motion = [{ at = 0, by = [0, 0] }]"),
            "region[4].motion",
        ),
    ],
)
def test_an_inconsistent_mission_is_refused_with_one_message(change: tuple[str, str], message: str) -> None:
    with pytest.raises(BadInput, match=re.escape(message)):
        parse_task(COURIER.replace(*change))


def test_a_capsule_can_be_avoided_and_not_visited() -> None:
    text = COURIER.replace("centre = [2.5, 2.6]", "segment = [[2, 2], [2.8, 2.8]]")
    assert build_once(parse_task(text)).certificate.holds
    with pytest.raises(BadInput, match=r"mission\[0\].visit: lab can only be avoided"):
        parse_task(text.replace('visit = "dock"', 'visit = "lab"'))


@given(data=st.data())
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_checker_accepts_exactly_what_the_tool_certifies(data: Any, tmp_path: Path) -> None:
    """Random formulas about the courier's regions (boxes, a ball, a union), for the courier's tube."""
    courier = courier_controller()
    names = {"a": "exit", "b": "dock", "c": "lab"}
    formula = re.sub(r"\b[abc]\b", lambda m: names[m.group()], str(data.draw(formulas(4))))
    text = COURIER[: COURIER.index("mission = [")] + f'mission = [{{ formula = "{formula}" }}]\n'
    controller = build_task(parse_task(text), True, courier.design)
    exit_code = exit_code_of_checker(controller, text, tmp_path)
    assert (exit_code == 0) == controller.certificate.holds, formula


@pytest.mark.parametrize(
    "entry",
    [
        'formula = "eventually[3, 6] (home or dock or lab)"', 'formula = "eventually[3, 9] (lab or (left and eventually[0, 4] right) or right or left)"',
        'visit = "exit", between = [3, 5.3999999999999995]', 'formula = "dock or not dock"', 'formula = "eventually[3, 5] not lab"',
        'visit = "home", between = [0, 3]', 'formula = "always[0, 5] home"', 'formula = "always not lab"', 'visit = "dock", between = [24, 24]',
        'visit = "dock", between = [22, 24], stay = 2', 'formula = "always[23.98, 24] dock"', 'formula = "always (not lab until[0, 14] dock)"',
        'formula = "eventually[2, 9] always[0.005, 3] dock"', 'formula = "always[0, 4] eventually[5, 5] dock"', 'formula = "eventually always dock"',
        'formula = "always[3, 5] dock or always[10, 12] left"', 'formula = "not (dock until[1, 4] left)"', 'patrol = ["dock", "left"], every = 12',
    ],
)  # fmt: skip
def test_missions_with_windows_at_their_ends_and_of_many_kinds_get_a_tube(entry: str, tmp_path: Path) -> None:
    text = COURIER[: COURIER.index("mission = [")].replace(
        "region = [", 'region = [ { name = "home", lower = [0, 0], upper = [1, 1] },'
    )
    text = "\n".join(line for line in text.splitlines() if not line.startswith("target_set")) + f"\nmission = [{{ {entry} }}]\n"
    assert exit_code_of_checker(build_once(parse_task(text)), text, tmp_path) == 0


def test_a_start_that_breaks_the_mission_at_once_is_refused() -> None:
    text = COURIER.replace("centre = [2.5, 2.6], radius = 0.4", "lower = [0.91, 0], upper = [1.5, 1]")
    with pytest.raises(NotCertified, match="at t = 0: the initial set is nearer to lab than the clearance"):
        build_once(parse_task(text))


def test_with_a_start_delay_the_margin_in_time_is_at_least_the_delay() -> None:
    certificate = build_once(parse_task(COURIER.replace("prescribed_time", "start_delay = 0.1\nprescribed_time"))).certificate
    (finding,) = (f for f in certificate.findings if f.in_time)
    assert certificate.holds
    assert finding.margin >= finding.required >= Fraction(1, 10)


ERRAND = """
name = "errand"
prescribed_time = 40
initial_state = [1, 1]
state_space = { lower = [0, 0], upper = [10, 10] }
initial_set = { lower = [0.6, 0.6], upper = [1.4, 1.4] }
unsafe = [{ name = "desk", lower = [4, 3], upper = [6, 7] }]
region = [{ name = "a", lower = [8, 1], upper = [9, 2] }, { name = "b", lower = [1, 8], upper = [2, 9] }]
mission = [{ visit = "a", between = [5, %s], then = "b" }]
"""


@pytest.mark.parametrize("latest", [17, 20, 25])
def test_visits_are_longer_than_a_moment_and_off_the_ends_of_their_windows_for_little_speed(
    latest: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The slowest tube is in a at 16.25 s alone. A margin of a window is t_c/16; knots are t_c/64 apart."""
    task = parse_task(ERRAND % latest)
    controller = build_once(task)
    proof = controller.certificate.mission
    assert proof is not None
    ((visit, _),) = proof.witnesses
    assert visit.end - visit.begin >= Fraction(2 * 40, 64)
    assert visit.begin + visit.end <= 2 * (latest - Fraction(40, 16) + Fraction(40, 64))
    monkeypatch.setattr(MissionSearch, "_with_time_margin", lambda _, candidate, width: candidate.tube)
    hurried = build_task(task)
    assert max(controller.certificate.speed) <= Fraction(TIME_MARGIN_SPEED) * max(hurried.certificate.speed)
    assert hurried.certificate.mission is not None
    assert proof.time_margin > 10 * hurried.certificate.mission.time_margin


@pytest.mark.parametrize(
    ("entry", "is_momentary"),
    [
        ('visit = "dock"', True),
        ('visit = "dock", stay = 2', False),
        ('visit = "dock", stay = 2, then = "exit"', True),
        ('never = "lab", before = "dock"', True),
        ('never = "lab"', False),
        ('patrol = ["dock"], every = 9', True),
        ('formula = "eventually[4, 9] always[0, 2] dock and always not lab"', False),
        ('formula = "always (lab -> eventually[0, 3] (dock and always[0, 2] not lab))"', True),
    ],
)
def test_the_note_on_stays_is_for_missions_with_a_visit_at_one_moment(entry: str, is_momentary: bool) -> None:
    task = parse_task(f"{COURIER[: COURIER.index('mission = [')]}mission = [{{ {entry} }}]\n")
    assert any(has_momentary_visit(formula) for formula in task.formulas) == is_momentary


def test_stops_at_one_place_have_one_pause_whichever_of_them_is_the_visit() -> None:
    """The legs are long, and then of no length; the last stop is the visit."""
    stops = tuple(Stop(event, np.zeros((0, 2))) for event in (2, 3, 4))
    state = next(iter(state_formulas_of(parse_task(COURIER).formula)))  # type: ignore[arg-type]
    for visit in (2, 3, 4):
        skeleton = Skeleton(5).with_hold(Hold(state, visit, visit))
        plan = Plan(skeleton, np.zeros(2), stops, (1.0, 0.0, 0.0), 1.0)
        assert list(_pauses(plan, [True, False, False])) == [1.0, 0.0, 0.0]


def test_a_tube_without_margin_in_time_is_taken_where_only_that_is_slow_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    text = f'tube.prefer = "balanced"\n{ERRAND % 17}control = {{ u_max = 0.475, period = 0.02 }}\nplant = {{ exact = true }}\n'
    controller = build_task(parse_task(text))
    assert controller.certificate.holds
    problem = "the preferred tube is not certified (period (P9): in dimension 1 |u| must exceed"
    assert controller.replaces.startswith(problem)
    assert re.search(r"; taken: one with peak speed 0\.4\d+ in place of 0\.5\d+$", controller.replaces)
    monkeypatch.setattr(MissionSearch, "generate_other_plans", lambda _: iter(()))
    with pytest.raises(NotCertified, match="P9"):
        build_task(parse_task(text), effort=Effort(0.1))


def test_without_a_mission_a_target_is_needed_and_regions_are_for_missions() -> None:
    bare = COURIER[: COURIER.index("mission = [")]
    with pytest.raises(BadInput, match="region: is only read by a mission"):
        parse_task(bare)
    bare = bare[: bare.index("region = [")]
    with pytest.raises(BadInput, match="target_set: is missing"):
        parse_task("\n".join(line for line in bare.splitlines() if not line.startswith("target_set")))


def test_a_mission_may_have_no_target_and_is_not_for_other_designs() -> None:
    text = "\n".join(line for line in COURIER.splitlines() if not line.startswith("target_set"))
    certificate = build_once(parse_task(text)).certificate
    assert certificate.holds
    assert not [f for f in certificate.findings if f.code == "P5"]
    with pytest.raises(BadInput, match="mission: is for the refined design"):
        parse_task(COURIER + '[tube]\ndesign = "adaptive"\n')


# --------------------------------------------------------------------------------------------------- the checker


def claim_of(document: dict[str, Any], state: str) -> dict[str, Any]:
    """Return the certificate's claim of P10 about this state formula."""
    return next(c for c in document["claims"] if c["property"] == "P10" and c["set"] == state)


def change_claim(state: str, key: str, value: Any) -> Any:
    """Return a function that changes one entry of a claim of P10, to a value or to a function of the entry and the number of cuts."""

    def change(d: dict[str, Any]) -> None:
        claim = claim_of(d, state)
        claim[key] = value(claim[key], d["grid"]["cuts"]) if callable(value) else value

    return change


CHANGES = {  # changes of the courier's certificate, each of which makes it false or incomplete
    "longer": change_claim("dock", "on", lambda on, cuts: [on[0], on[1] + cuts]),
    "earlier": change_claim("dock", "on", lambda on, cuts: [on[0] - 4 * cuts, on[1]]),
    "wider": change_claim("dock", "margin", lambda margin, _: 50 * margin),
    "another set": change_claim("dock", "set", "lab"),
    "late": lambda d: d["mission"].update(time_margin=4 * d["mission"]["time_margin"]),
    "timeless": lambda d: d["mission"].update(time_margin=0),
    "another formula": lambda d: d["mission"].update(formula="not lab"),
    "one claim fewer": lambda d: d["claims"].remove(claim_of(d, "not lab")),
    "no hints": lambda d: claim_of(d, "not lab").pop("hints"),
    "a wrong normal": change_claim("not lab", "hints", lambda hints, _: [[hints[0][0], hints[0][1], [1, 0]], *hints[1:]]),
    "a gap": change_claim("not lab", "hints", lambda hints, _: hints[:-1]),
}


@pytest.mark.parametrize("name", CHANGES)
def test_the_checker_refuses_a_changed_certificate(name: str, tmp_path: Path, capsys: Any) -> None:
    controller = courier_controller()
    document = json.loads(controller.files["courier.certificate.json"])
    CHANGES[name](document)
    files = {**controller.files, "courier.certificate.json": json.dumps(document).encode()}
    assert exit_code_of_checker(dataclasses.replace(controller, files=files), COURIER, tmp_path) == 1
    assert "refused" in capsys.readouterr().out


@pytest.mark.parametrize(
    "change",
    [
        ("between = [4, 9]", "between = [4, 5]"), ("stay = 2", "stay = 6"), ('then = "exit"', 'then = "dock"'), ("within = 8", "within = 1"),
        ('before = "dock"', 'before = "exit"'), ("lower = [1, 4.5]", "lower = [1, 5]"), ("radius = 0.4", "radius = 1.4"),
    ],
)  # fmt: skip
def test_checker_and_tool_agree_on_the_tube_for_another_mission(change: tuple[str, str], tmp_path: Path, capsys: Any) -> None:
    """The courier's tube is certified for another mission. Where the tool refuses it, the certificate claims what is true of the first
    mission, and the checker refuses it by P10."""
    controller = courier_controller()
    design = controller.design
    assert isinstance(design, RefinedDesign)
    text = COURIER.replace(*change)
    task = parse_task(text)
    certified = certify(task, design, controller.program)
    files = render_files(
        task, design, controller.program, dataclasses.replace(certified, findings=controller.certificate.findings)
    )
    if not certified.holds:
        document = json.loads(files["courier.certificate.json"])
        first = json.loads(controller.files["courier.certificate.json"])
        document["claims"], document["grid"] = first["claims"], first["grid"]
        document["mission"] = {"formula": str(task.formula), "time_margin": first["mission"]["time_margin"]}
        files["courier.certificate.json"] = json.dumps(document).encode()
    exit_code = exit_code_of_checker(dataclasses.replace(controller, files=files), text, tmp_path)
    output = capsys.readouterr().out
    assert (exit_code == 0) == certified.holds, output
    assert exit_code == 0 or "P10" in output or "phase" in output or "hashes" in output, output


# --------------------------------------------------------------------------------------------------- runs


def as_rtamt(formula: Formula, end: float) -> str:
    """Return a formula in the language of rtamt (Nickovic and Yamaguchi, 2020); a region is a signal that is 0 or more inside."""
    match formula:
        case StateFormula(inner):
            return as_rtamt(inner, end)
        case InRegion(region, is_negated):
            return f"({region} < 0)" if is_negated else f"({region} >= 0)"
        case And(parts):
            return f"({' and '.join(as_rtamt(p, end) for p in parts)})"
        case Or(parts):
            return f"({' or '.join(as_rtamt(p, end) for p in parts)})"
    assert isinstance(formula, Always | Eventually | Until)
    over = formula.over
    window = f"[{float(over.begin)}:{end if over.end is None else float(over.end)}]"
    if isinstance(formula, Until):
        return f"({as_rtamt(formula.first, end)} until{window} {as_rtamt(formula.last, end)})"
    operator = "always" if isinstance(formula, Always) else "eventually"
    return f"({operator}{window} {as_rtamt(formula.part, end)})"


@pytest.mark.parametrize("gain", ["1/2", "1/50", "1/100000"])
@pytest.mark.parametrize("name", ["courier", "either", "waypoints"])
def test_the_monitor_of_rtamt_agrees_about_every_run(name: str, gain: str) -> None:
    """rtamt judges runs of the emitted C in dense time; with a small gain the state leaves the tube and misses entries."""
    needs("rtamt", "gcc")
    import rtamt

    controller = build(ROOT / "tasks" / f"{name}.toml")
    controller = with_gain(controller, [float(Fraction(gain))] * 2)
    task, end = controller.task, float(controller.task.prescribed_time)
    run = Loop(controller, plant_of("integrator", 2, 1)).run(Scenario(rate=200.0), trace=True)
    assert run.trace is not None
    t, x = run.trace[:, 0], run.trace[:, 1:3]
    missed = []
    for k, formula in enumerate(task.formulas, 1):
        spec = rtamt.StlDenseTimeSpecification()
        samples = []
        for region in [r for r, shape in task.regions.items() if not hasattr(shape, "any_of")]:
            spec.declare_var(region, "float")
            is_inside = np.array([1.0 if regions_at(controller, p)[region] else -1.0 for p in x])
            later = [[end * (1 + s / 8), float(is_inside[-1])] for s in range(1, 17)]  # the state stands after the last sample
            samples.append([region, [[float(a), float(b)] for a, b in zip(t, is_inside, strict=True)] + later])
        spec.spec = as_rtamt(formula, end)
        spec.parse()
        missed += [] if spec.evaluate(*samples)[0][1] > 0 else [k]
    assert tuple(missed) == run.missed
    assert (gain == "1/100000") <= bool(missed)


def test_no_certified_mutant_is_broken_by_a_trajectory_and_without_the_monitor_some_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oracle searches trajectories inside the tube that break the mission; the second half replaces the tool's monitor."""
    numbers = range(80)
    assert not [n for n in numbers if (judgement := judge_mutant(n)) and judgement.is_certified and judgement.is_broken]
    monkeypatch.setattr(sys.modules["stt_codegen.certify.missions.proof"], "holds", lambda *_: True)
    monkeypatch.setattr(sys.modules["stt_codegen.certify.missions.proof"], "witnesses", lambda *_: ())
    assert [n for n in numbers if (judgement := judge_mutant(n)) and judgement.is_certified and judgement.is_broken]


def test_eight_visits_do_not_change_the_c_of_a_step() -> None:
    """The C is the same as with one target, except names, numbers and the length of the table."""

    def without_names_and_numbers(controller: EmittedController) -> str:
        name = controller.task.name
        text = (
            re.sub(r"/\*.*?\*/", "", controller.files[f"{name}.c"].decode(), flags=re.S)
            .replace(name, "p")
            .replace(name.upper(), "P")
        )
        text = re.sub(r"(?<=coefficients\[)\d+|\{[-\d., F\n{}e]*\};", "N", text)
        return re.sub(r"-?\b\d+\.?\d*(e-?\d+)?F?\b", "N", text)

    (scenario,) = (s for s in SCENARIO_FAMILIES["own"]() if s.name == "eight visits, four windows")
    controller = build_once(parse_task(scenario.text))
    with_one_target = build_once(
        parse_task(scenario.text[: scenario.text.index("[[region]]")] + "[target_set]\nlower = [8.5, 8]\nupper = [9.5, 9]\n")
    )
    assert without_names_and_numbers(controller) == without_names_and_numbers(with_one_target)
