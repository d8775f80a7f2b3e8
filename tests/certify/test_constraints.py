"""Rows against exact arithmetic: what the certificates say of a row is a lower bound, and a sharp one."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.certify.adaptive.finder import Finder
from stt_codegen.certify.slack import ConstraintBlock, smallest_slack
from stt_codegen.constraints import (
    Avoidance,
    Constraint,
    avoidances,
    initial_state_constraints,
    reach_constraints,
    speed_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.design.arena import arena_of, starting_box
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import LOWER, UPPER
from stt_codegen.program.operations import LIBRARY_ULPS, OPERATIONS
from tests.support.controllers import built
from tests.task.test_sets import polygon_of, with_sets

small = st.integers(-20, 20)


@st.composite
def tables(draw: st.DrawFn) -> RefinedDesign:
    """Six segments in two dimensions with small whole coefficients."""
    rows = tuple(tuple((draw(small), draw(small)) for _ in range(2)) for _ in range(9))
    return RefinedDesign(Fraction(1), 6, 0, rows)


@st.composite
def rows(draw: st.DrawFn) -> Constraint:
    c = draw(st.tuples(st.integers(-7, 7), st.integers(-7, 7)).filter(any))
    terms = tuple((i, LOWER if v > 0 else UPPER, v) for i, v in enumerate(c) if v)
    return Constraint(
        terms,
        Fraction(draw(st.integers(-400, 400)), draw(st.integers(1, 9))),
        Fraction(draw(st.integers(0, 9)), 4),
        sum(map(abs, c)),
    )


def exact(row: Constraint, design: RefinedDesign, k: int, s: Fraction) -> Fraction:
    """The row's slack at place s of segment k, as a distance, by the basis itself."""
    weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    left = sum(c * sum(w * design.table[k + j][i][side] for j, w in enumerate(weights)) for i, side, c in row.terms)
    return (left * design.unit - row.bound - row.clearance) / row.slack_per_distance


PLACES = [Fraction(k, 24) for k in range(25)]


@given(tables(), rows(), st.integers(0, 60))
@settings(max_examples=150, deadline=None)
def test_the_least_slack_is_below_every_value_and_near_the_least(design: RefinedDesign, row: Constraint, error: int) -> None:
    """Where a row fails, what is told is met at the place that is told; where it holds with the error, no value lacks it."""
    needed = Fraction(error, 7)
    found = smallest_slack(design.bezier(), ConstraintBlock.of([row], design.unit), needed)
    values = {(k, s): exact(row, design, k, s) for k in range(6) for s in PLACES}
    if found.slack >= needed * row.distance_error:
        assert min(values.values()) >= found.slack
        hull = min(
            sum(c * int(v) for (i, side, c), v in zip(row.terms, (b[i, side, q] for i, side, _ in row.terms), strict=True))
            for b in design.bezier()
            for q in range(4)
        )
        assert found.slack >= (hull - row.bound - row.clearance) / row.slack_per_distance - 1 - Fraction(
            1, row.slack_per_distance
        )
    else:
        assert min(values.values()) < needed * row.distance_error + 1 + Fraction(1, row.slack_per_distance) + Fraction(
            700 * row.size, 24
        )
        a, b = found.interval
        k = min(int(a), 5)
        if a == b:
            assert exact(row, design, k, a - k) <= found.slack + 1 + Fraction(1, row.slack_per_distance)


@given(tables(), st.lists(rows(), min_size=2, max_size=4))
@settings(max_examples=100, deadline=None)
def test_of_a_choice_the_best_row_counts_and_of_sets_the_worst(design: RefinedDesign, several: list[Constraint]) -> None:
    one, rest = Avoidance("one", tuple(several[:1])), Avoidance("rest", tuple(several[1:]))
    low = Fraction(-(10**6))
    both = smallest_slack(design.bezier(), ConstraintBlock.choice([one, rest], design.unit), low)
    each = [smallest_slack(design.bezier(), ConstraintBlock.choice([s], design.unit), low) for s in (one, rest)]
    assert both.slack == min(e.slack for e in each)
    assert each[both.set_index].slack == both.slack  # of equals either may be named
    assert (
        each[1].slack
        >= max(smallest_slack(design.bezier(), ConstraintBlock.of([r], design.unit), low).slack for r in several[1:])
        or len(several) > 2
    )


def test_a_fault_in_the_second_half_of_a_segment_is_met() -> None:
    """An edge that dips only late: halving that forgot the later half would not see it."""
    dip = (0, 0, 0, 0, 0, 0, -3, 0, 0)
    design = RefinedDesign(Fraction(1), 6, 0, tuple(((v, 40), (0, 40)) for v in dip))
    row = Constraint(((0, LOWER, 1),), Fraction(0))
    for bound in range(-14, 0):
        found = smallest_slack(
            design.bezier(), ConstraintBlock.of([Constraint(row.terms, Fraction(bound))], design.unit), Fraction(0)
        )
        least = min(exact(Constraint(row.terms, Fraction(bound)), design, k, s) for k in range(6) for s in PLACES)
        assert (found.slack >= 0) == (least >= 0)


ends = st.floats(-1e3, 1e3)


@given(
    st.tuples(ends, ends),
    st.tuples(ends, ends),
    st.tuples(st.integers(-(10**18), 10**18), st.integers(-(10**18), 10**18)).filter(any),
    st.fractions(-1000, 1000),
)
@settings(max_examples=300)
def test_the_finders_slack_is_a_lower_bound(first, second, c, bound: Fraction) -> None:
    """In doubles, for coefficients that are no doubles too, against exact numbers."""
    terms = tuple((i, LOWER if v > 0 else UPPER, v) for i, v in enumerate(c) if v)
    row = Constraint(terms, bound, Fraction(0), sum(map(abs, c)))
    gamma = np.array([[[sorted(first)] * 2, [sorted(second)] * 2]])
    told = Finder(with_sets(), np.array([0.0, 1.0]), gamma).slack(row)
    true = (sum(v * Fraction(gamma[0, i, side, 0 if v > 0 else 1]) for i, side, v in terms) - bound) / row.slack_per_distance
    assert Fraction(float(told[0])) <= true
    assert float(told[0]) >= float(true) - 1e-9 * (1 + abs(float(true)))


def test_an_enclosure_that_says_nothing_shows_nothing() -> None:
    """An edge that is not known (NaN) is no slack: the set must not drop out of the judgement."""
    task = with_sets(polygon_of("tri", ("2", "1"), ("3", "1"), ("3", "2")))
    gamma = np.zeros((1, 2, 2, 2))
    gamma[..., 1] = 0.5
    gamma[...] = np.nan
    found = Finder(task, np.array([0.0, 1.0]), gamma).avoid()
    assert not found.holds
    assert found.obstacle == "tri"


def test_the_start_is_cut_along_a_slanted_face() -> None:
    """A triangle 0.025 from the initial set, in the largest component: a corner is cut, not the whole side, and the tube is certified."""
    near = polygon_of("near", ("0.1", "0.95"), ("0.95", "0.1"), ("1.5", "1.5"))
    task = with_sets(near)
    box = starting_box(arena_of(task))
    assert (box[1] - box[0]).prod() >= 0.48 * 0.43
    assert built(task).certificate.holds
    far = polygon_of("far", ("0.3", "0.72"), ("0.72", "0.3"), ("1.5", "1.5"))
    box = starting_box(arena_of(with_sets(far)))
    assert (box[1] - box[0]).min() >= 0.4


def test_every_property_has_its_rows() -> None:
    task = built(with_sets()).task
    assert [
        len(f(task))
        for f in (width_constraints, initial_state_constraints, start_constraints, stay_constraints, reach_constraints)
    ] == [2, 4, 4, 4, 4]
    assert speed_constraints(task) == ()
    assert avoidances(task) == ()
    limited = task.changed(tube={"max_speed": 2})
    assert {(r.order, r.bound) for r in speed_constraints(limited)} == {(1, Fraction(-2))}


@pytest.mark.parametrize("name", OPERATIONS)
def test_roundings_are_those_of_ieee_754(name: str) -> None:
    """Half a unit for what the standard rounds correctly, none for what is exact, LIBRARY_ULPS for the library; sums do not underflow."""
    row = OPERATIONS[name]
    if name in ("add", "sub", "mul", "div", "sqrt"):
        assert row.ulps == 0.5
    elif name in ("neg", "fabs", "floor", "ceil", "mantissa"):
        assert row.ulps == 0
    elif row.ulps is not None:
        assert row.ulps == LIBRARY_ULPS
    assert row.underflows == (name not in ("add", "sub"))
