"""Constraints against exact arithmetic: the slack that a certificate computes is a lower bound, and close to the true one."""

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
from tests.support.controllers import build_once
from tests.task.test_sets import polygon_of, with_sets

coefficients = st.integers(-20, 20)


@st.composite
def tables(draw: st.DrawFn) -> RefinedDesign:
    """A design of six segments in two dimensions with small whole coefficients."""
    rows = tuple(tuple((draw(coefficients), draw(coefficients)) for _ in range(2)) for _ in range(9))
    return RefinedDesign(Fraction(1), 6, 0, rows)


@st.composite
def constraints(draw: st.DrawFn) -> Constraint:
    """A constraint on two dimensions with small whole coefficients; a bound from below is on the lower edge, from above on the upper."""
    normal = draw(st.tuples(st.integers(-7, 7), st.integers(-7, 7)).filter(any))
    terms = tuple((i, LOWER if v > 0 else UPPER, v) for i, v in enumerate(normal) if v)
    return Constraint(
        terms,
        Fraction(draw(st.integers(-400, 400)), draw(st.integers(1, 9))),
        Fraction(draw(st.integers(0, 9)), 4),
        sum(map(abs, normal)),
    )


def exact_slack(constraint: Constraint, design: RefinedDesign, k: int, s: Fraction) -> Fraction:
    """Return a constraint's slack at local time s of segment k, as a distance, from the B-spline basis itself."""
    weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    left = sum(c * sum(w * design.table[k + j][i][side] for j, w in enumerate(weights)) for i, side, c in constraint.terms)
    return (left * design.unit - constraint.bound - constraint.clearance) / constraint.slack_per_distance


LOCAL_TIMES = [Fraction(k, 24) for k in range(25)]  # within a segment


@given(tables(), constraints(), st.integers(0, 60))
@settings(max_examples=150, deadline=None)
def test_the_smallest_slack_is_below_every_value_and_near_the_smallest(
    design: RefinedDesign, constraint: Constraint, error: int
) -> None:
    """Where it says that the constraint fails, the slack is that small at the time it names; else no value is smaller."""
    needed = Fraction(error, 7)
    smallest = smallest_slack(design.bezier(), ConstraintBlock.of([constraint], design.unit), needed)
    values = {(k, s): exact_slack(constraint, design, k, s) for k in range(6) for s in LOCAL_TIMES}
    if smallest.slack >= needed * constraint.distance_error:
        assert min(values.values()) >= smallest.slack
        hull = min(
            sum(
                c * int(v)
                for (i, side, c), v in zip(constraint.terms, (b[i, side, q] for i, side, _ in constraint.terms), strict=True)
            )
            for b in design.bezier()
            for q in range(4)
        )
        assert smallest.slack >= (hull - constraint.bound - constraint.clearance) / constraint.slack_per_distance - 1 - Fraction(
            1, constraint.slack_per_distance
        )
    else:
        assert min(values.values()) < needed * constraint.distance_error + 1 + Fraction(
            1, constraint.slack_per_distance
        ) + Fraction(700 * constraint.size, 24)
        a, b = smallest.interval
        k = min(int(a), 5)
        if a == b:
            assert exact_slack(constraint, design, k, a - k) <= smallest.slack + 1 + Fraction(1, constraint.slack_per_distance)


@given(tables(), st.lists(constraints(), min_size=2, max_size=4))
@settings(max_examples=100, deadline=None)
def test_the_best_side_of_a_set_counts_and_the_worst_of_several_sets(design: RefinedDesign, sides: list[Constraint]) -> None:
    first, second = Avoidance("first", tuple(sides[:1])), Avoidance("second", tuple(sides[1:]))
    needed = Fraction(-(10**6))
    together = smallest_slack(design.bezier(), ConstraintBlock.choice([first, second], design.unit), needed)
    separate = [smallest_slack(design.bezier(), ConstraintBlock.choice([s], design.unit), needed) for s in (first, second)]
    assert together.slack == min(e.slack for e in separate)
    assert separate[together.set_index].slack == together.slack  # either may be named where both are equal
    assert (
        separate[1].slack
        >= max(smallest_slack(design.bezier(), ConstraintBlock.of([r], design.unit), needed).slack for r in sides[1:])
        or len(sides) > 2
    )


def test_a_violation_in_the_second_half_of_a_segment_is_seen() -> None:
    """An edge dips only late in a segment: a halving that forgot the later half would not see it."""
    dip = (0, 0, 0, 0, 0, 0, -3, 0, 0)
    design = RefinedDesign(Fraction(1), 6, 0, tuple(((v, 40), (0, 40)) for v in dip))
    constraint = Constraint(((0, LOWER, 1),), Fraction(0))
    for bound in range(-14, 0):
        smallest = smallest_slack(
            design.bezier(), ConstraintBlock.of([Constraint(constraint.terms, Fraction(bound))], design.unit), Fraction(0)
        )
        smallest_value = min(
            exact_slack(Constraint(constraint.terms, Fraction(bound)), design, k, s) for k in range(6) for s in LOCAL_TIMES
        )
        assert (smallest.slack >= 0) == (smallest_value >= 0)


ends = st.floats(-1e3, 1e3)


@given(
    st.tuples(ends, ends),
    st.tuples(ends, ends),
    st.tuples(st.integers(-(10**18), 10**18), st.integers(-(10**18), 10**18)).filter(any),
    st.fractions(-1000, 1000),
)
@settings(max_examples=300)
def test_the_finders_slack_is_a_lower_bound(begin, end, normal, bound: Fraction) -> None:
    """The finder computes in doubles, for coefficients that need not be doubles; the truth is exact."""
    terms = tuple((i, LOWER if v > 0 else UPPER, v) for i, v in enumerate(normal) if v)
    constraint = Constraint(terms, bound, Fraction(0), sum(map(abs, normal)))
    gamma = np.array([[[sorted(begin)] * 2, [sorted(end)] * 2]])
    computed = Finder(with_sets(), np.array([0.0, 1.0]), gamma).slack(constraint)
    true_slack = (
        sum(v * Fraction(gamma[0, i, side, 0 if v > 0 else 1]) for i, side, v in terms) - bound
    ) / constraint.slack_per_distance
    assert Fraction(float(computed[0])) <= true_slack
    assert float(computed[0]) >= float(true_slack) - 1e-9 * (1 + abs(float(true_slack)))


def test_an_unknown_edge_proves_no_avoidance() -> None:
    """An edge that is not known (NaN) must not make the finder skip the set."""
    task = with_sets(polygon_of("tri", ("2", "1"), ("3", "1"), ("3", "2")))
    gamma = np.zeros((1, 2, 2, 2))
    gamma[..., 1] = 0.5
    gamma[...] = np.nan
    avoidance = Finder(task, np.array([0.0, 1.0]), gamma).avoid()
    assert not avoidance.holds
    assert avoidance.obstacle == "tri"


def test_the_start_is_cut_along_a_slanted_face() -> None:
    """A triangle is 0.025 from the initial set: the start loses a corner, not a whole side, and the tube is certified."""
    near_triangle = polygon_of("near", ("0.1", "0.95"), ("0.95", "0.1"), ("1.5", "1.5"))
    task = with_sets(near_triangle)
    box = starting_box(arena_of(task))
    assert (box[1] - box[0]).prod() >= 0.48 * 0.43
    assert build_once(task).certificate.holds
    far_triangle = polygon_of("far", ("0.3", "0.72"), ("0.72", "0.3"), ("1.5", "1.5"))
    box = starting_box(arena_of(with_sets(far_triangle)))
    assert (box[1] - box[0]).min() >= 0.4


def test_every_property_has_its_constraints() -> None:
    task = build_once(with_sets()).task
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
    """The standard rounds to half a unit or exactly; functions of the library to LIBRARY_ULPS. Sums do not underflow."""
    operation = OPERATIONS[name]
    if name in ("add", "sub", "mul", "div", "sqrt"):
        assert operation.ulps == 0.5
    elif name in ("neg", "fabs", "floor", "ceil", "mantissa"):
        assert operation.ulps == 0
    elif operation.ulps is not None:
        assert operation.ulps == LIBRARY_ULPS
    assert operation.underflows == (name not in ("add", "sub"))
