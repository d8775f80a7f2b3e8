"""What the listings in floating point mean and how they round, derived from their statements by the symbolic machine of
tests/support/listings. `checker.pyz --meaning` computes the same on random fractions, without NaN, aliasing and types.

So the reader of a listing need not take its comments on trust: every function, with its loops, tests for NaN, casts and calls, does what
specification.py says, for every combination of the listing's options.
"""

from __future__ import annotations

import math
from fractions import Fraction
from random import Random

import pytest

from stt_codegen.checker.stt_checker import rounding as checker_rounding
from stt_codegen.checker.stt_checker.tube import Tube
from tests.support.listings.bits import check_split
from tests.support.listings.changes import replaced_text
from tests.support.listings.combinations import all_combinations, options_of, pairs_in, pairwise_combinations
from tests.support.listings.meaning import check_meaning, filled_listing
from tests.support.listings.reader import Listing, UnknownMeaning
from tests.support.listings.rounding import (
    DOUBLE,
    FLOAT,
    UNIT,
    RangeRun,
    RoundedRange,
    Rounding,
    edge_error,
    largest_value,
    speed_error,
    spline_time_error,
)

PAIRWISE = pairwise_combinations()
PLAIN = "float,order 1,ticks,libm,one gain,one clamp,no limits"
FULL = "double,order 2,ticks,libm,gains,clamps,filters,limits,differences"


def test_every_pair_of_options_is_in_one_of_the_combinations() -> None:
    assert set().union(*map(pairs_in, PAIRWISE)) == set().union(*map(pairs_in, all_combinations()))
    assert len(PAIRWISE) < 12


@pytest.mark.parametrize("alternatives", PAIRWISE, ids=", ".join)
def test_the_listing_does_what_the_specification_says(alternatives: tuple[str, ...]) -> None:
    assert check_meaning(options_of(alternatives)) > 100


@pytest.mark.slow
@pytest.mark.parametrize("alternatives", list(all_combinations()), ids=", ".join)
def test_the_listing_of_every_combination_does_what_the_specification_says(alternatives: tuple[str, ...]) -> None:
    assert check_meaning(options_of(alternatives)) > 100


# Changes of a listing, by heading, after which it compiles: its values, its rounding or what may be aliased are others.
CHANGES = [
    # a kernel of the spline may compute nothing else, and gets nothing else
    ("basis", "*w1 = v7;", "*w1 = v9;"),
    ("basis", "const P_real v7 = 1.0 + v6;", "const P_real v7 = 1.0 - v6;"),
    ("rate of the basis", "const P_real v15 = s + s;", "const P_real v15 = s * s;"),
    ("edge", "const int32_t at_3 = at + $row_3;", "const int32_t at_3 = at + $row_2;"),
    ("edge", "const P_real v3 = w2 * q2;", "const P_real v3 = w3 * q2;"),
    ("weights", "P_basis(s, &w0, &w1, &w2, &w3);", "P_basis(s, &w0, &w2, &w1, &w3);"),
    ("segment and s", "P_segment(t, &row, &s);", "const P_real twice = t + t;\n    P_segment(twice, &row, &s);"),
    ("edges", "P_edge_at(upper_at, w0, w1, w2, w3)", "P_edge_at(upper_at, w0, w2, w1, w3)"),
    ("edges", "P_edge_at(lower_at, w0, w1, w2, w3)", "P_edge_at(pair, w0, w1, w2, w3)"),
    ("places in the table", "lower_at + 1;", "lower_at + 2;"),
    # time
    ("segment of a time", "scaled < $last", "scaled < $per_second"),
    ("segment of a time", "(P_real)segment", "(P_real)first"),
    ("segment of a tick", "whole < $last_segment", "whole < $tick_end"),
    ("rate of the tube", "t < $t_c", "t < $last"),
    ("rate of the tube", "moving ? $per_second : 0.0", "moving ? 0.0 : $per_second"),
    # inputs that are not finite
    ("sum of zeros", "const bool finite = zero <= 0.0;  [order 1]", "const bool finite = zero < 1.0;  [order 1]"),
    ("sum of zeros", "x_j * 0.0", "x_j * 1.0"),
    ("NaN unless t is finite", "isfinite(t)", "isfinite(0.0)"),
    ("inputs that are not finite", "return M_BAD_INPUT;", "return M_OK;"),
    ("inputs that are not finite", "u[m] = 0.0;", "u[m] = zero;"),
    # u may be the array of x, so x is read before u is stored
    ("state between the edges", "const P_real x_i = x[i];", "u[i] = 0.0;\n        const P_real x_i = x[i];"),
    ("margins", "<<weights>>", "<<weights>>\n    for (int32_t k = 0; k < $n; ++k) {\n        margin[k] = 0.0;\n    }"),
    # loops
    ("tube", "for (int32_t i = 0; i < $n; ++i) {", "for (int32_t i = 0; i < $pairs; ++i) {"),
    ("sum of zeros", "const P_real zeros = zero + x_zero;", "const P_real zeros = x_zero;"),
    ("control", "P_real zero = t_zero;", "P_real zero = 0.0;"),
    # the law: its value, and where it rounds
    ("state between the edges", "to_upper < to_lower", "to_lower < to_upper"),
    ("state between the edges", "const P_real to_farther = width - to_nearer;", "const P_real to_farther = to_upper;"),
    ("error transform and law", "const P_real v4 = v3 / b;", "const P_real v4 = v3 / a;"),
    ("error transform and law", "const P_real v1 = v0 * epsilon;", "const P_real v1 = epsilon * k;"),
    ("law", "P_transformed_error(to_nearer, to_farther, &epsilon, &xi);", "P_transformed_error(to_farther, to_nearer, &epsilon, &xi);"),
    ("law", "P_law(gain, xi, epsilon)", "P_law(gain, epsilon, xi)"),
    ("law", "bool outside = false;", "bool outside = true;"),
    ("law", "return outside ? M_OUTSIDE_TUBE : M_OK;", "return M_OK;"),
    # margins, starts, transform
    ("margin", "P_real margin = 0.5;", "P_real margin = 1.0;"),
    ("margin of a component", "x_share < (-1.0)", "x_share < 1.0"),
    ("covered", "x_lower < x_i", "x_upper < x_i"),
    ("covered", "bool covered = true;", "bool covered = false;"),
    ("transform", "const bool clear = filled && farther;", "const bool clear = filled && filled;"),
    ("transform", "widened * 0.5", "widened * 0.25"),
    ("transform", "finite_x && finite_width", "finite_x && finite_x"),
    ("transform", "sign * epsilon_nearer", "sign * xi_i"),
]  # fmt: skip
CHANGES_OF_ORDER_2 = [
    ("law", "u_min < u_i;  [limits]", "u_i < u_min;  [limits]"),
    ("edges and rates", "lower_slope * $per_second", "lower_slope * $t_c"),
    ("filtered tube", "const P_real z_upper = upper_rate + upper_part;", "const P_real z_upper = upper_rate + lower_part;"),
    ("velocity", "positive ? mean : (P_real)NAN", "positive ? mean : 0.0"),
    ("velocity", "const bool positive = 0.0 < dt;", "const bool positive = dt < 0.0;"),
    ("sum of zeros of v", "v_k * 0.0", "0.0 * 0.0"),
    ("distances", "const P_real v_width = upper_rate - lower_rate;", "const P_real v_width = upper_edge - lower_edge;"),
    ("filtered distances", "v_to_lower + lower_part", "v_to_upper + lower_part"),
    ("state and rate between the edges", "const bool inside = z_inside && x_inside;", "const bool inside = z_inside && z_inside;"),
    ("state and rate between the edges", "const P_real to_farther = z_width - to_nearer;", "const P_real to_farther = z_to_upper;"),
    ("smaller margin", "x_smaller ? margin_x : margin_z", "x_smaller ? margin_z : margin_x"),
    ("start of v + lambda x", "z_above && z_below", "z_above && z_above"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("options", "heading", "old", "new"),
    [(PLAIN, *change) for change in CHANGES] + [(FULL, *change) for change in CHANGES_OF_ORDER_2],
)
def test_a_listing_with_another_meaning_is_refused(options: str, heading: str, old: str, new: str) -> None:
    with replaced_text(heading, old, new), pytest.raises(UnknownMeaning):
        check_meaning(set(options.split(",")))


WEIGHTS_THAT_HAND_ON = ("basis", "*w0 = v2;\n    *w1 = v7;\n    *w2 = v9;", "*w0 = s;\n    *w1 = 1.0;\n    *w2 = s;")
STATE_AS_A_WEIGHT = (
    "state between the edges", "<<edges>>\n        const P_real x_i = x[i];",
    "<<places in the table>>\n        const P_real x_i = x[i];\n"
    "        const P_real lower_edge = P_edge_at(lower_at, w0, w1, w2, w3);\n"
    "        const P_real upper_edge = P_edge_at(upper_at, w0, w1, x_i, w3);",
)  # fmt: skip


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (WEIGHTS_THAT_HAND_ON, "basis does not compute what it should"),
        (STATE_AS_A_WEIGHT, "edge_at gets something else than the weights"),
    ],
)
def test_inputs_that_no_call_site_passes_are_refused(change: tuple[str, str, str], reason: str) -> None:
    """A basis that hands its input on, and a call that passes the measured state as a weight. The rounding of `edge_at` is bounded for
    weights alone: for a larger number (sum + a^16) - a^16 may lose everything."""
    with replaced_text(*change), pytest.raises(UnknownMeaning, match=reason):
        check_meaning(set(PLAIN.split(",")))


def test_a_macro_in_the_listing_is_refused() -> None:
    macro = "#define isfinite(v) 1\n#if defined(__clang__)"
    with replaced_text("compiler flags", "#if defined(__clang__)", macro), pytest.raises(UnknownMeaning, match="#define"):
        check_meaning(set(PLAIN.split(",")))


# ------------------------------------------------------------------------------------------------ rounding


@pytest.fixture(scope="module")
def listing() -> Listing:
    return filled_listing("controller", set(PLAIN.split(",")))


@pytest.mark.parametrize("rounding", [FLOAT, DOUBLE], ids=["float", "double"])
@pytest.mark.parametrize("order", [0, 1])
def test_the_constants_of_the_checker_follow_from_the_statements(listing: Listing, rounding: Rounding, order: int) -> None:
    """Terms with eps, with eps^2 and more, and with tiny. The last ones are affine in the largest entry."""
    first, second = (checker_rounding.EDGE, checker_rounding.RATE)[order]
    without_tiny = Rounding(rounding.eps, Fraction(0))
    error = edge_error(listing, without_tiny, Fraction(1), order) / rounding.eps
    assert round(error) == first
    assert math.ceil((error - first) / rounding.eps) == second
    for largest in (Fraction(0), Fraction(2) ** 100):
        assert edge_error(listing, without_tiny, largest, order) == largest * error * rounding.eps
        more = edge_error(listing, rounding, largest, order) - edge_error(listing, without_tiny, largest, order)
        assert 0 < more <= 200 * (largest + 1) * rounding.tiny


def test_a_kernel_that_rounds_once_more_has_another_constant() -> None:
    with replaced_text("basis", "const P_real v9 = 1.0 + v8;", "const P_real v8a = v8 * 1.0;\n    const P_real v9 = 1.0 + v8a;"):
        changed = filled_listing("controller", set(PLAIN.split(",")))
    assert round(edge_error(changed, Rounding(FLOAT.eps, Fraction(0)), Fraction(1)) / FLOAT.eps) > checker_rounding.EDGE[0]


@pytest.mark.parametrize("rounding", [FLOAT, DOUBLE], ids=["float", "double"])
def test_no_value_of_the_kernels_overflows(listing: Listing, rounding: Rounding) -> None:
    assert largest_value(listing, rounding, Fraction(2) ** 100) < Fraction(2) ** 127


@pytest.mark.parametrize(("rounding", "bits"), [(FLOAT, 24), (DOUBLE, 53)], ids=["float", "double"])
def test_the_error_of_edges_and_rates_covers_what_is_derived(listing: Listing, rounding: Rounding, bits: int) -> None:
    """The statements' error with that of spline time, which moves an edge by its largest slope, and the product of a rate with K/t_c."""
    random = Random(51)
    for _ in range(20):
        n, t_c = random.choice((1, 3)), Fraction(random.randint(1, 10**6), random.randint(1, 10**4))
        span = 10 ** random.randint(0, 6)
        entries = [Fraction(random.randint(-span, span), 1 << 12) for _ in range(2 * n * random.randint(4, 30))]
        tube = Tube(entries, n, Fraction(1, 1 << 12), t_c, None)
        time_error = spline_time_error(rounding, tube.segments, t_c)
        edges, rates = (checker_rounding.arithmetic_error(tube, bits, order) for order in (0, 1))
        for i in range(n):
            largest = max(abs(v) for row in tube.table for v in row[i]) * tube.unit
            speed, acceleration = (tube.fastest(i, order) * tube.unit for order in (1, 2))
            edge = edge_error(listing, rounding, largest) + time_error * speed
            assert edge <= edges[i] < edge + 4 * (speed * time_error + rounding.eps * largest)
            slope = RoundedRange(-speed, speed, edge_error(listing, rounding, largest, 1) + time_error * acceleration)
            assert speed_error(rounding, slope, tube.segments / t_c) <= rates[i]


def test_a_place_in_a_segment_is_the_only_input_that_is_bounded(listing: Listing) -> None:
    """For s = 2 the weights are larger, and the constant would be another one."""
    run = RangeRun(listing, Rounding(FLOAT.eps, Fraction(0)), {}, RoundedRange(Fraction(-1), Fraction(1)))
    (inside,), (beyond,) = (
        run.results("edge_at", run.results("basis", [RoundedRange(Fraction(0), end)])) for end in (UNIT.high, Fraction(2))
    )
    assert beyond.error > 2 * inside.error


# ------------------------------------------------------------------------------------------------ exponent and mantissa


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_exponent_and_mantissa_split_a_number(scalar: str) -> None:
    check_split(scalar)
