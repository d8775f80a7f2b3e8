"""The oracle of benchmarks/mutations.py, which decides whether a changed tube is safe: it is right on known cases and never
milder than samples; and a small run of that benchmark."""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from random import Random
from typing import Any

import numpy as np
import pytest
from flint import fmpz_poly
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.mutants.order_two import ORDER_TWO_MUTATIONS, largest_start_speeds, order_two_base
from benchmarks.mutants.sampled import SAMPLED_MUTATIONS, base_loop, draw_sampled_mutant
from benchmarks.mutants.tubes import MUTATIONS, draw_mutant
from benchmarks.mutations import checked_tube, files_claiming_success, judge, judge_filtered_tube, judge_sampled_loop
from benchmarks.oracles.cubics import less_bound, point_where_all_are_negative, smallest_value
from benchmarks.oracles.order_two import control_authority, largest_demanded_acceleration, leaving_state, order_two_faults
from benchmarks.oracles.sampled import ClaimedBounds, counterexample
from benchmarks.oracles.sturm import evaluate, negative_point, nonpositive_point, polynomial
from benchmarks.oracles.tubes import SMALLEST_WIDTH, Fault, faults, first_fault, signed_edges
from stt_codegen.certify.multipliers import multipliers_in
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.pipeline import build_program, certify
from stt_codegen.task.load import parse_task
from stt_codegen.task.sets.shapes import Box, UnsafeSet
from stt_codegen.task.task import Task
from tests.certify.test_certificate import bend, exact_edges, oracle
from tests.controller.test_order_two import edges as edges_of_order_2
from tests.support.controllers import controller_of

TINY = Fraction(1, 10**60)  # far below any sample's resolution
BASES = ("omni_s3", "spacecraft")


def cubic(*coefficients: int | Fraction) -> fmpz_poly:
    """Return an integer polynomial with the sign of this one. coefficients: of 1, s, s^2, s^3."""
    scale = 1
    for c in coefficients:
        scale *= Fraction(c).denominator
    return fmpz_poly([int(c * scale) for c in coefficients])


def value_of(p: fmpz_poly, s: Fraction) -> Fraction:
    """Return p(s)."""
    return sum((int(a) * s**k for k, a in enumerate(p.coeffs())), Fraction(0))


# ------------------------------------------------------------------------------------------------ known cases


@pytest.mark.parametrize("root", [Fraction(0), Fraction(1, 3), Fraction(1, 2), Fraction(1)])
def test_touching_zero_is_no_fault_and_1e_60_below_is(root: Fraction) -> None:
    """(s - root)^2 (s + 1) >= 0; less 1e-60 it is negative on an interval that no sample hits."""
    a, b, c = root**2, -2 * root, 1
    touching = (a, a + b, b + c, c)
    assert point_where_all_are_negative([cubic(*touching)]) is None
    dipping = cubic(touching[0] - TINY, *touching[1:])
    s = point_where_all_are_negative([dipping])
    assert s is not None
    assert 0 <= s <= 1
    assert value_of(dipping, s) < 0
    assert all(value_of(dipping, Fraction(k, 1000)) > 0 for k in range(1001) if Fraction(k, 1000) != root)


@pytest.mark.parametrize("rising", [(-3, 7), (-1, 0, 2), (-1, 1, 1, 1)])  # roots 3/7, sqrt(1/2), and a cubic's
def test_sides_with_a_shared_root_cover_all_times_and_a_gap_of_1e_60_is_found(rising: tuple[int, ...]) -> None:
    falling = tuple(-a for a in rising)
    assert point_where_all_are_negative([cubic(*rising)]) is not None
    assert point_where_all_are_negative([cubic(*rising), cubic(*falling)]) is None
    gap = [cubic(*rising), cubic(falling[0] - TINY, *falling[1:])]
    s = point_where_all_are_negative(gap)
    assert s is not None
    assert all(value_of(p, s) < 0 for p in gap)
    assert point_where_all_are_negative([cubic(*rising), cubic(falling[0] + TINY, *falling[1:])]) is None
    # The product has a double root, and a simple one 1e-60 away.
    assert point_where_all_are_negative([cubic(*rising), cubic(*falling), cubic(rising[0] - TINY, *rising[1:])]) is None


def test_constants_are_decided() -> None:
    assert point_where_all_are_negative([cubic(0)]) is None
    assert point_where_all_are_negative([cubic(-1), cubic(1)]) is None
    s = point_where_all_are_negative([cubic(-1), cubic(-2, 1)])
    assert s is not None
    assert 0 <= s <= 1


roots = st.fractions(min_value=Fraction(-1, 4), max_value=Fraction(5, 4), max_denominator=6)


@given(st.lists(st.tuples(roots, roots), min_size=1, max_size=6))
def test_cubics_cover_exactly_the_union_of_their_intervals(intervals: list[tuple[Fraction, Fraction]]) -> None:
    """(s - a) (b - s) (s + 2) >= 0 on [a, b]: sorting the ends finds the union's gaps. Shared ends are frequent."""
    intervals = [(min(pair), max(pair)) for pair in intervals]
    cubics = [cubic(-2 * a * b, 2 * (a + b) - a * b, a + b - 2, -1) for a, b in intervals]
    covered_to, gap_begin = Fraction(0), None
    for a, b in sorted(intervals):
        if a > covered_to:
            break
        covered_to = max(covered_to, b)
    else:
        a = Fraction(2)
    if covered_to < 1 or not any(low <= 0 <= high for low, high in intervals):
        gap_begin = covered_to
    s = point_where_all_are_negative(cubics)
    assert (s is None) == (gap_begin is None)
    if s is not None:
        assert 0 <= s <= 1
        assert not any(low <= s <= high for low, high in intervals)


@given(st.lists(st.integers(-(2**26), 2**26), min_size=4, max_size=4))
def test_the_deepest_place_is_below_every_sample(coefficients: list[int]) -> None:
    _, s, value = smallest_value([coefficients])
    assert value == sum(a * s**k for k, a in enumerate(coefficients))
    p = fmpz_poly(coefficients)
    assert all(value_of(p, Fraction(k, 40)) >= value - Fraction(1, 1 << 12) for k in range(41))
    assert point_where_all_are_negative([less_bound(coefficients, value - Fraction(1, 1 << 12))]) is None


# ------------------------------------------------------------------------------------------------ tubes


def is_witness(task: Task, design, fault: Fault) -> bool:
    """Return whether the fault's time shows that the property fails, by de Boor's recursion at that time."""
    u = fault.time * design.segments / design.prescribed_time
    k = min(int(u), design.segments - 1)
    edges = exact_edges(design, k, u - k)
    i, tube = fault.dimension, task.tube
    if fault.code == "P4":
        box = task.obstacles[fault.unsafe]
        return all(
            b + tube.clearance > low and a - tube.clearance < high
            for (a, b), low, high in zip(edges, box.lower, box.upper, strict=True)
        )
    a, b = edges[i]
    inside = {"P2": task.initial_set, "P3": task.free_space, "P5": task.target_set}.get(fault.code)
    if inside is not None:
        is_outside = a < inside.lower[i] or b > inside.upper[i]
        return is_outside or (fault.code == "P2" and not a < task.initial_state[i] < b)
    if fault.code == "P1":
        return b - a < max(tube.min_width, SMALLEST_WIDTH)
    return design.table[-1][i] != design.table[-3][i]


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_a_tube_without_a_fault_is_safe_at_every_sample_and_faults_are_true(data) -> None:
    controller = controller_of(data.draw(st.sampled_from(BASES)))
    task, design = controller.task, controller.design
    row, i = data.draw(st.integers(0, design.segments + 2)), data.draw(st.integers(0, design.dimension - 1))
    amount = data.draw(st.one_of(st.integers(-30, 30), st.integers(-(2**19), 2**19)))
    bent = bend(controller, row, i, data.draw(st.integers(0, 1)), amount)
    fault = first_fault(task, bent)
    if fault is None:
        assert all(oracle(task, bent, Fraction(0)).values())
    else:
        assert is_witness(task, bent, fault)


RAMP = """
name = "ramp"
prescribed_time = 8.0
initial_state = [12.0, 12.0]
state_space = { lower = [0.0, 0.0], upper = [90.0, 90.0] }
initial_set = { lower = [0.0, 0.0], upper = [80.0, 80.0] }
target_set = { lower = [0.0, 0.0], upper = [80.0, 80.0] }
"""
# Both dimensions rise from [6, 18] at speed 6 and slow down in the last of 8 segments, to [52, 64].
RISING = RefinedDesign(Fraction(8), 8, 0, tuple(((v, v + 2),) * 2 for v in (*range(10), 8)))


def test_a_demand_beyond_the_tubes_extreme_breaks_only_its_property() -> None:
    """A demand exactly at the extreme of the tube holds; a demand of 1e-60 more breaks that property and no other."""
    task, design = parse_task(RAMP), RISING
    clearance = task.tube.clearance

    def raised(box: Box, value: Fraction) -> Box:
        return box.model_copy(update={"lower": (value, box.lower[1])})

    def demands(more: Fraction) -> list[tuple[str, Task]]:
        """Return tasks with one demand each that exceeds the tube's extreme by `more`, and the code of its property."""
        # 1e-60 more has too many digits for a task's checks, so `model_construct` leaves them out.
        slab = UnsafeSet.model_construct(lower=(Fraction(0), Fraction(0)), upper=(6 - clearance + more, Fraction(90)))
        # The tube clears this corner at t = 10/3, in dimension 1 until then and in dimension 2 from then on.
        corner = UnsafeSet.model_construct(
            lower=(38 + clearance - more, Fraction(0)), upper=(Fraction(90), 26 - clearance + more)
        )
        changes: list[tuple[str, dict[str, object]]] = [
            ("P1", {"tube": task.tube.model_copy(update={"min_width": 12 + more})}),
            ("P2", {"initial_set": raised(task.initial_set, 6 + more)}),
            ("P3", {"state_space": raised(task.state_space, 6 + more)}),
            ("P4", {"unsafe": (slab,)}),
            ("P4", {"unsafe": (corner,)}),
            ("P5", {"target_set": raised(task.target_set, 52 + more)}),
            ("P6", {"tube": task.tube.model_copy(update={"max_speed": 6 - more})}),
        ]
        return [(code, task.model_copy(update=change)) for code, change in changes]

    assert first_fault(task, design) is None
    for code, extreme in demands(Fraction(0)):
        assert first_fault(extreme, design) is None, code
    for code, broken in demands(TINY):
        assert {f.code for f in faults(broken, design)} == {code}
    relief = Fraction(1, 3)
    for code, easier in demands(-relief):
        margin = relief / 2 if code == "P1" else relief  # both edges of a width may move
        assert first_fault(easier, design, margin) is None, code
        assert {f.code for f in faults(easier, design, margin + TINY)} == ({code} - {"P6"})


def test_the_state_must_be_strictly_inside_and_the_end_smooth() -> None:
    task, design = parse_task(RAMP), RISING
    for coordinate, code in ((Fraction(6), "P2"), (6 + TINY, None), (18 - TINY, None), (Fraction(18), "P2")):
        fault = first_fault(task.model_copy(update={"initial_state": (coordinate, Fraction(12))}), design)
        assert (fault and fault.code) == code
    kinked = RefinedDesign(Fraction(8), 8, 0, (*design.table[:-1], ((8, 10), (9, 11))))
    assert first_fault(task, kinked) == Fault("P6", Fraction(8), 1)


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("step", [-1, 1])
def test_max_speed_limits_both_edges_in_both_directions(side: int, step: int) -> None:
    rows = [[-5 + step * j * (side == 0), 25 + step * j * (side == 1)] for j in (*range(10), 8)]
    design = RefinedDesign(Fraction(8), 8, 0, tuple(((a, b), (2, 3)) for a, b in rows))
    for speed, codes in ((Fraction(6), set()), (6 - TINY, {"P6"})):
        task = parse_task(RAMP)
        task = task.model_copy(update={"tube": task.tube.model_copy(update={"max_speed": speed})})
        assert {f.code for f in faults(task, design)} & {"P6"} == codes


def test_width_and_speed_are_decided_at_their_extremes() -> None:
    """A demand 2^-40 on the mild side of the extreme over all segments holds, and one 2^-40 on the other side does not."""
    controller = controller_of("spacecraft")
    task, design = controller.task, controller.design
    edges = signed_edges(design)
    narrowest = smallest_value(-edges.sum(axis=2).reshape(-1, 4)).value * design.unit
    slopes = [[a, 2 * b, 3 * c, 0] for _, a, b, c in edges.reshape(-1, 4).tolist()]
    steepest = -min(smallest_value([[sign * a for a in s] for s in slopes]).value for sign in (1, -1))
    fastest = steepest * design.unit * design.segments / design.prescribed_time
    slack = Fraction(1, 1 << 40)
    for sign, holds in ((1, True), (-1, False)):
        for option, code, value in (("min_width", "P1", narrowest - sign * slack), ("max_speed", "P6", fastest + sign * slack)):
            changed = task.model_copy(update={"tube": task.tube.model_copy(update={option: value})})
            fault = first_fault(changed, design)
            assert (fault is None) == holds
            assert holds or (fault is not None and fault.code == code)


# ------------------------------------------------------------------------------------------------ mutants


def primitive(normal: Sequence[Fraction], offset: Fraction) -> tuple[tuple[int, ...], Fraction]:
    """Return a half-space with a normal of whole numbers that have no common divisor."""
    scale = Fraction(math.lcm(*(Fraction(c).denominator for c in normal)))
    scale /= math.gcd(*(int(c * scale) for c in normal))
    return tuple(int(c * scale) for c in normal), offset * scale


def test_the_files_of_a_mutant_mean_to_the_checker_what_the_mutant_is() -> None:
    for number in range(40):
        task, design = draw_mutant(Random(f"files {number}"), BASES).mutant
        read, tube, _ = checked_tube(files_claiming_success(task, design, certify(task, design, build_program(task, design))))
        for j, (obstacle, s) in enumerate(zip(read.unsafe, task.obstacles, strict=True)):
            multipliers_of = multipliers_in(task, task.stated_set(j))
            assert (obstacle.name, obstacle.radius) == (s.name, s.radius)
            for normal in s.normals:
                assert obstacle.largest_height(list(normal), multipliers_of(normal) or ()) == s.support(normal)
        for stated, faces, cuts in (
            (task.free_space, read.space.faces, task.space_cuts), (task.target, read.target.faces, task.target_cuts),
        ):  # fmt: skip
            expected = {*stated.faces, *cuts}
            if read.target.ball is None or faces is read.space.faces:
                assert {primitive(*face) for face in faces} == {primitive(*face) for face in expected}
        if read.target.ball is not None:
            target, moved = task.target_set, task.target_course.displacement(task.prescribed_time)
            axes = task.axis_indices(target)
            assert read.target.axes == list(axes)
            centre = [c + moved[i] for i, c in zip(axes, target.centre, strict=True)]
            assert read.target.ball == (centre, target.radius)
        assert read.start == (list(task.start.lower), list(task.start.upper))
        limits = [None if limit is None else list(limit) for limit in (task.max_speed, task.max_acceleration)]
        assert (read.clearance, [read.max_speed, read.max_acceleration]) == ([task.tube.clearance] * task.dimension, limits)
        narrowest = max(task.tube.min_width, SMALLEST_WIDTH)
        assert (read.state, read.min_width) == (list(task.initial_state), [narrowest] * task.dimension)
        assert tube.table == [list(row) for row in design.table]


@pytest.mark.slow
def test_nothing_unsafe_passes_among_some_mutants() -> None:
    """The checker judges every third."""
    verdicts = [judge(number, 1, number % 3 == 0, BASES) for number in range(150)]
    assert all(v.is_decided for v in verdicts)
    assert [v for v in verdicts if v.fault and any(a.passed for a in v.answers)] == []
    unsafe = [v for v in verdicts if v.fault]
    assert 45 <= len(unsafe) <= 105
    assert sum(v.is_near for v in verdicts) >= 15
    assert {v.kind for v in verdicts} == set(MUTATIONS)
    assert sum(all(a.passed for a in v.answers) for v in verdicts if not v.fault) >= 30
    assert judge(24, 1, True, BASES) == verdicts[24]


# ------------------------------------------------------------------------------------------------ order 2


@settings(deadline=None)  # exact bisection down to 1e-60 takes long on a busy machine
@given(roots, roots, st.integers(-3, 3), st.sampled_from([0, TINY, -TINY]))
def test_signs_of_cubics_by_sturm_are_those_of_their_factors(a: Fraction, b: Fraction, c: int, shift: Fraction) -> None:
    """(s - a)(s - b)(s + c), and 1e-60 more or less: a time that is returned is a witness; where no time is
    returned, samples on both sides of the roots are not negative."""
    p = polynomial((a * b * c + shift, a * b - (a + b) * c, c - a - b, 1))
    s, touching = negative_point(p), nonpositive_point(p)
    times = [*(Fraction(k, 40) for k in range(41)), *(v + e for v in (a, b, (a + b) / 2) for e in (-TINY, 0, TINY))]
    values = [evaluate(p, v) for v in times if 0 <= v <= 1]
    assert (s is not None) == (min(values) < 0) or (s is not None and evaluate(p, s) < 0)
    assert (touching is not None) == (min(values) <= 0) or (touching is not None and evaluate(p, touching) <= 0)
    for root, upper_bound in ((s, -1), (touching, 0)):
        assert root is None or (0 <= root <= 1 and evaluate(p, root) * 10**200 <= upper_bound)


def codes(task: Task, design: RefinedDesign) -> set[str]:
    """Return the codes of the faults that the oracle finds in a tube of order 2."""
    return {f.code for f in order_two_faults(task, design)}


def moved(design: RefinedDesign, row: int, side: int, by: int) -> RefinedDesign:
    """Return the design with one integer of its table, in dimension 0, changed by `by`."""
    table = [[list(pair) for pair in pairs] for pairs in design.table]
    table[row][0][side] += by
    return replace(design, table=tuple(tuple((a, b) for a, b in pairs) for pairs in table))


def test_each_property_of_order_2_is_broken_by_a_change_of_the_tube() -> None:
    limited, moving = order_two_base("omni_s2", "float", "limited"), order_two_base("omni_s2", "double", "moving")
    assert limited is not None
    assert moving is not None
    assert codes(limited.task, limited.design) == codes(moving.task, moving.design) == set()
    assert all(
        "P6" in codes(limited.task, moved(limited.design, row, side, by)) for row in (-1, -2) for side in (0, 1) for by in (-1, 1)
    )
    assert "P2 z" in codes(limited.task, moved(limited.design, 2, 0, 1))  # one unit: the lower edge comes towards a start at rest
    assert "P2 z" in codes(limited.task, moved(limited.design, 2, 1, -1))
    assert "P1 z" in codes(moving.task, replace(moving.design, filter=(moving.design.filter[0] / 20, moving.design.filter[1])))
    middle = moving.design.segments // 2
    assert "P1 z" in codes(moving.task, moved(moving.design, middle, 0, 1 << 24))
    start_margins = largest_start_speeds(moving.task, moving.design)
    for excess, code in ((Fraction(0), {"P2 z, on the edge"}), (TINY, {"P2 z"}), (-TINY, set())):
        initial_set = moving.task.initial_set.model_copy(
            update={"speed": (start_margins[0] + excess, moving.task.start_speed[1])}
        )
        assert codes(moving.task.model_copy(update={"initial_set": initial_set}), moving.design) == code


def test_where_u_is_too_weak_the_oracle_shows_a_state_that_leaves() -> None:
    """With 99 % of the input's margin as disturbance P8 holds; with 101 and 103 % the state that the oracle names leaves the tube."""
    base = order_two_base("omni_s2", "double", "limited")
    assert base is not None
    authority = control_authority(base.task)
    assert authority is not None
    margins = [v - largest_demanded_acceleration(base.design, i) for i, v in enumerate(authority)]
    for share, is_broken in ((Fraction(99, 100), False), (Fraction(101, 100), True), (Fraction(103, 100), True)):
        plant = base.task.plant.model_copy(update={"w_max": base.task.plant.w_max + min(margins) * share})
        task = base.task.model_copy(update={"plant": plant})
        faults_of_task = list(order_two_faults(task, base.design))
        assert bool(faults_of_task) == is_broken
        assert {f.code for f in faults_of_task} <= {"P8"}
        for fault in faults_of_task:
            run = leaving_state(task, base.design, fault)
            assert run is not None
            times = np.array([float(run.time), float(run.time + run.seconds)])
            low, high, low_rate, high_rate, _, _ = (v[:, run.dimension] for v in edges_of_order_2(base.design, times))
            lam, x, v, duration = float(base.design.filter[run.dimension]), float(run.x), float(run.v), float(run.seconds)
            filtered_state = (v + float(run.acceleration) * duration) + lam * (
                x + v * duration + float(run.acceleration) * duration * duration / 2
            )
            below, above_ = low_rate + lam * low, high_rate + lam * high
            assert low[0] < x < high[0]
            assert below[0] < v + lam * x < above_[0]
            outside = filtered_state - above_[1] if run.side else below[1] - filtered_state
            assert outside > -1e-12  # of doubles


def test_the_oracle_refutes_a_held_loop_beyond_its_period_and_not_at_it() -> None:
    base = base_loop("omni_s2", "limited")
    assert base is not None
    bounds = ClaimedBounds(tuple(float((r - 1) / (r + 1)) for r in base.proof.rho), tuple(float(v) for v in base.proof.u))
    assert all(counterexample(base.task, base.design, seed, bounds) is None for seed in range(3))
    too_slow = base.task.model_copy(update={"control": base.task.control.model_copy(update={"period": 4 * base.longest})})
    assert counterexample(too_slow, base.design) is not None
    false_bounds = ClaimedBounds(tuple(e / 2 for e in bounds.e), bounds.u)  # the oracle also sees a false bound
    assert counterexample(base.task, base.design, 0, false_bounds) is not None
    weak_gain = base.task.model_copy(
        update={"control": base.task.control.model_copy(update={"gain": tuple(g / 1000 for g in base.task.gain)})}
    )
    assert counterexample(weak_gain, base.design) is not None


@pytest.mark.slow
def test_nothing_unsafe_passes_among_some_mutants_of_order_2() -> None:
    names = ("omni_s2", "paper 3")
    kinds = [k for k in ORDER_TWO_MUTATIONS if k not in ("speed of the starts", "share of the starts")]
    period_kinds = ("held: period", "held: period at its longest", "held: latency")
    verdicts = [judge_filtered_tube(Random(f"order 2 {k}"), k, k % 12 == 0, names=names, kinds=kinds) for k in range(48)]
    sampled_verdicts = [
        judge_sampled_loop(Random(f"held {k}"), k, k % 4 == 0, names=names[:1], kinds=period_kinds) for k in range(10)
    ]
    assert [v for v in (*verdicts, *sampled_verdicts) if v.fault and any(a.passed for a in v.answers)] == []
    assert [v for v in verdicts if v.fault and v.fault.code.endswith("nothing leaves")] == []
    assert {"P1 z", "P6", "P8"} <= {v.fault.code for v in verdicts if v.fault}
    assert sum(v.is_near for v in verdicts) >= 5
    assert sum(all(a.passed for a in v.answers) for v in verdicts if not v.fault) >= 10
    assert any(v.fault for v in sampled_verdicts)
    assert any(a.passed for v in sampled_verdicts for a in v.answers)


@pytest.mark.parametrize("kind", SAMPLED_MUTATIONS)
def test_every_kind_of_held_mutant_is_drawn(kind: str) -> None:
    drawn = draw_sampled_mutant(Random(kind), ("spacecraft",), [kind])
    assert drawn.kind == kind
    assert drawn.mutant.task.control.period is not None


@pytest.mark.parametrize(
    ("forgotten", "kind", "code"),
    [
        ("input_slack", "input limit", "P8"),
        ("filtered_width_slack", "time at the flip", "P1 z"),
        ("start_slack", "start turned", "P2 z"),
    ],
)
def test_a_tool_that_forgets_a_property_is_caught(forgotten: str, kind: str, code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The benchmark can fail: where the tool takes one property for granted, a mutant that breaks only this one passes and counts."""
    module = importlib.import_module("stt_codegen.certify.filtered_findings")
    true_slack = getattr(module, forgotten)

    def huge_slack(*arguments: Any) -> Any:
        slack = true_slack(*arguments)
        return None if slack is None else replace(slack, units=1 << 60)

    monkeypatch.setattr(module, forgotten, huge_slack)
    verdicts = [
        judge_filtered_tube(Random(f"{kind} {k}"), k, False, names=("omni_s2", "paper 3"), kinds=[kind]) for k in range(16)
    ]
    assert code in {v.fault.code for v in verdicts if v.fault and v.answers[0].passed}


def test_starts_that_reach_the_edge_of_the_filtered_tube_are_refused() -> None:
    base = order_two_base("omni_s2", "double", "moving")
    assert base is not None
    speed = (largest_start_speeds(base.task, base.design)[0], base.task.start_speed[1])
    task = base.task.model_copy(update={"initial_set": base.task.initial_set.model_copy(update={"speed": speed})})
    assert codes(task, base.design) == {"P2 z, on the edge"}
    assert not certify(task, base.design, build_program(task, base.design)).holds
