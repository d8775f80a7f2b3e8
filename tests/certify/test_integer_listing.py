"""What the listing of integers computes and in which ranges, derived from its statements: the functions are run on numbers and on spans.

integers.py of the checker asks a few comparisons of a controller's numbers, and its first docstring says why no value then leaves 32
bits. Here the spans of all values are computed, for emitted controllers and for numbers at the limits of these comparisons.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

from stt_codegen.checker.stt_checker import source
from stt_codegen.checker.stt_checker.exact import Refused
from stt_codegen.checker.stt_checker.integers import Integers
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.checker.stt_checker.tube import Tube
from tests.support.controllers import ROOT, controller_of
from tests.support.listings.changes import changed_pieces, replaced_text
from tests.support.listings.integer_ranges import UINT32_SPAN, IntegerRanges
from tests.support.listings.integer_run import IntegerRun, integer_functions, results_at_every_s
from tests.support.listings.reader import Block, Function, Statement, UnknownMeaning
from tests.support.listings.tasks import TASKS_OF_INTEGERS, build, compared_files

ORDERS = {1: "selftest", 2: "order 2, scaled filter"}  # a task of each


class Filled(NamedTuple):
    """A task with its filled listing: the checker's task, the options, the numbers, and the functions."""

    task: Task
    options: set[str]
    values: dict[str, Any]
    functions: dict[str, Function]

    @property
    def tube(self) -> Tube:
        unit = Fraction(1, 2 ** int(str(self.values["x_bits"]).strip("()")))
        return Tube([v * unit for v in self.values["coefficients"]], self.task.n, unit, self.task.t_c, None)


@pytest.fixture(scope="module")
def filled() -> dict[str, Filled]:
    result = {}
    for label, text in TASKS_OF_INTEGERS.items():
        with TemporaryDirectory() as folder:
            file = compared_files(text, Path(folder))[0]
        result[label] = Filled(Task(text.encode()), file.options, file.values, integer_functions(file.options, file.values))
    return result


# ------------------------------------------------------------------------------------------------ ranges


@pytest.mark.parametrize("label", TASKS_OF_INTEGERS)
def test_no_value_of_an_emitted_controller_leaves_32_bits(label: str, filled: dict[str, Filled]) -> None:
    """For every tick of 32 bits, and every x and v of 32 bits."""
    task = filled[label]
    assert IntegerRanges(task.functions, task.values).check() == (6 if "order 2" in task.options else 5)


LARGEST_STEP, LARGEST_X = (1 << 15) - 1, {1: (1 << 28) - 1, 2: (1 << 26) - 1}
STEEPEST_ROW = {"levels": 65535, "slopes": 32767, "bends": 0}
FLATTEST_ROW = {"levels": 16384, "slopes": 32767, "bends": 32767}


def extreme_numbers(order: int, filled: Filled, row: dict[str, int], **constants: int) -> dict[str, Any]:
    """Return numbers at the limits of the comparisons: the largest steps and x, gains, shifts and limits."""
    values = dict(filled.values)
    rows = 8 * (31 - (1).bit_length()) + 16  # as many as smallest_y = 1 needs
    farthest = LARGEST_X[order] // 6
    entries = [farthest - LARGEST_STEP * (k % 2) for k in range(len(values["coefficients"]) // 8)]
    columns = itertools.cycle(([*entries], [-v for v in entries]))
    table = [list(next(columns)) for _ in range(2 * filled.task.n)]
    values["coefficients"] = [column[k] for k in range(len(entries)) for column in table] * 4
    values |= {name: [entry] * rows for name, entry in row.items()} | {
        "h_shifts": [255 * (k % 2) for k in range(rows)],
        "rows": rows,
    }
    values |= {"gains": [65535] * filled.task.n, "limits": [(1 << 31) - 1] * filled.task.n, "shift_offsets": [31] * filled.task.n}
    values |= {
        "smallest_y": 1,
        "smallest_width": 1,
        "largest_e": (1 << 30) - 1,
        "smallest_x_width": 1,
        "largest_x": LARGEST_X[order] + 1,
    }
    values["filters"] = [65535] * filled.task.n
    return values | constants


def ask_comparisons(order: int, values: dict[str, Any]) -> None:
    """Ask the checker's comparisons about these numbers. Raises `Refused`."""
    n = len(values["gains"])
    entries = values["coefficients"]
    table = [[(entries[k + 2 * i], entries[k + 2 * i + 1]) for i in range(n)] for k in range(0, len(entries), 2 * n)]
    task = SimpleNamespace(order=order, n=n, farthest=Fraction(1 << 30))
    Integers._check_ranges(
        SimpleNamespace(stated=values, tables=values, task=task, largest_x=values["largest_x"]),  # type: ignore[arg-type]
        SimpleNamespace(table=table, unit=Fraction(1)),  # type: ignore[arg-type]
    )


RATES = [  # mantissa, shift and bits: at the limits of r1 <= 65535, and of a step's rate below 2^28 - 2^20
    {"rate_mantissa": 43690, "rate_shift": 14, "rate_half": 1 << 13, "rate_bits": 4},
    {"rate_mantissa": 65535, "rate_shift": 15, "rate_half": 1 << 14, "rate_bits": 5},
    {"rate_mantissa": 1, "rate_shift": 1, "rate_half": 1, "rate_bits": 3},
]


@pytest.mark.parametrize("row", [STEEPEST_ROW, FLATTEST_ROW], ids=["steepest", "flattest"])
@pytest.mark.parametrize("constants", RATES)
@pytest.mark.parametrize("order", [1, 2])
def test_no_value_leaves_32_bits_at_the_limits_of_the_comparisons(
    order: int, constants: dict[str, int], row: dict[str, int], filled: dict[str, Filled]
) -> None:
    task = filled[ORDERS[order]]
    values = extreme_numbers(order, task, row, **constants)
    ask_comparisons(order, values)
    assert IntegerRanges(integer_functions(task.options, values), values).check() >= 5


@pytest.mark.parametrize(
    ("order", "changes"),
    [
        (1, {"coefficients": lambda v: [LARGEST_STEP + 1, *v[1:2], *v[2:4], 0, *v[5:]]}),
        (1, {"smallest_width": lambda v: 0}),
        (1, {"smallest_y": lambda v: 0}),
        (1, {"shift_offsets": lambda v: [255, *v[1:]]}),
        (1, {name: lambda v: v[:40] for name in ("levels", "slopes", "bends", "h_shifts")}),
        (2, {"rate_mantissa": lambda v: 65535, "rate_shift": lambda v: 13}),
        (2, {"rate_bits": lambda v: 0}),
    ],
)
def test_numbers_beyond_the_comparisons_are_refused_by_them_and_by_the_spans(
    order: int, changes: dict[str, Callable[[Any], Any]], filled: dict[str, Filled]
) -> None:
    """So none of the comparisons is idle, and the spans see what leaves 32 bits."""
    task = filled[ORDERS[order]]
    values = extreme_numbers(order, task, FLATTEST_ROW, **RATES[0])
    values |= {name: change(values[name]) for name, change in changes.items()}
    with pytest.raises(Refused):
        ask_comparisons(order, values)
    with pytest.raises(UnknownMeaning):
        IntegerRanges(integer_functions(task.options, values), values).check()


@pytest.mark.parametrize(("order", "factor"), [(1, 4), (2, 2)])
def test_a_larger_x_leaves_32_bits(order: int, factor: int, filled: dict[str, Filled]) -> None:
    """For order 2 the same holds of lambda and of v, twice as large. For order 1 the spans allow 2^29 too, since an edge is between
    its entries; the checker's docstring has a coarser bound."""
    task, more = filled[ORDERS[order]], (factor - 1) * (LARGEST_X[order] // 6)
    values = extreme_numbers(order, task, FLATTEST_ROW, **RATES[0])
    farther = [v + more if v > 0 else v - more for v in values["coefficients"]]
    beyond = [values | {"largest_x": factor * values["largest_x"], "coefficients": farther}]
    beyond += [values | {"filter_scale": 8}] if order == 2 else []
    for numbers in beyond:
        with pytest.raises(UnknownMeaning):
            IntegerRanges(integer_functions(task.options, numbers), numbers).check()
    if order == 2:
        wider = [line.replace(str(1 << 28), str(1 << 29)) for line in source.pieces()["limited v"]]
        with changed_pieces({"limited v": wider}), pytest.raises(UnknownMeaning):
            IntegerRanges(integer_functions(task.options, values), values).check()


@pytest.mark.parametrize(("label", "last"), [("long", (1 << 31) - 1), ("long", 1 << 16), ("selftest", (1 << 16) - 1)])
def test_the_comparisons_of_the_clock_are_as_large_as_32_bits_allow(label: str, last: int, filled: dict[str, Filled]) -> None:
    """`check_clock` requires (last/2^16 + 1) clock_scale < 2^31, and K 2^clock_bits <= 2^31. A thousandth more leaves 32 bits."""
    task, largest = filled[label], ((1 << 31) - 1) // ((last >> 16) + 1)

    def span_of_segment(**constants: int) -> None:
        values = task.values | {"ticks": last, "clock_bits": 16, "pairs": 2, "tick_end": (1 << 31) - 1} | constants
        IntegerRanges(integer_functions(task.options, values), values).results("segment", UINT32_SPAN)

    span_of_segment(clock_scale=largest)
    for beyond in ({"clock_scale": largest + (largest >> 10)}, {"clock_scale": largest, "tick_end": 1 << 31}):
        with pytest.raises(UnknownMeaning):
            span_of_segment(**beyond)


@pytest.mark.parametrize(
    ("heading", "old", "new"),
    [
        ("integer edge", "const int32_t six_q1 = q1 * 6;", "const int32_t six_q1 = q1 * 600;"),
        ("integer weights", "middle_under ? middle_rounded : 65535", "middle_under ? middle_rounded : 65536"),
        ("limited x", "x_under ? x_raised : $largest_x", "x_under ? x_raised : x_any"),
        ("integer law", "const int32_t safe_width = wide ? width : $smallest_width;", "const int32_t safe_width = width;"),
        ("integer law", "offset_under ? offset : safe_width", "offset_under ? offset : offset"),
        ("integer law", "const int32_t first_row = octave_rows + 8;", "const int32_t first_row = octave_rows + 80;"),
        ("integer law", "shift_over ? shift_any : 0", "shift_over ? shift_any : shift_any"),
        ("integer margin of a component", "x_inside ? x_distance : x_distance_minus", "x_inside ? x_distance_minus : x_distance"),
    ],
)
def test_a_listing_that_may_leave_32_bits_is_refused(heading: str, old: str, new: str, filled: dict[str, Filled]) -> None:
    task = filled[ORDERS[1]]
    values = extreme_numbers(1, task, FLATTEST_ROW)
    with replaced_text(heading, old, new):
        functions = integer_functions(task.options, values)
    with pytest.raises(UnknownMeaning):
        IntegerRanges(functions, values).check()


# ------------------------------------------------------------------------------------------------ rates


@pytest.mark.parametrize("constants", [*RATES, {"rate_mantissa": 50000, "rate_shift": 20, "rate_half": 1 << 19, "rate_bits": 9}])
def test_the_largest_rates_are_those_of_the_comparisons(constants: dict[str, int], filled: dict[str, Filled]) -> None:
    """r1 is largest in the middle of a segment, r0 at its beginning; r2 is at most r0."""
    functions = integer_functions(filled[ORDERS[2]].options, filled[ORDERS[2]].values | constants)
    r0, r1, r2 = results_at_every_s(functions["rates"].tokens)
    m, shift = constants["rate_mantissa"], constants["rate_shift"]
    largest_1, largest_0 = ((v * m >> 16) + (1 << shift - 1) >> shift for v in (9 << 27, 3 << 28))
    assert (r1.max(), r0.max()) == (largest_1, largest_0)
    assert r2.max() <= r0.max()
    assert min(r0.min(), r1.min(), r2.min()) >= 0


# ------------------------------------------------------------------------------------------------ loops and arrays


@pytest.mark.parametrize("label", TASKS_OF_INTEGERS)
def test_loops_are_over_all_components_and_read_before_they_write(label: str, filled: dict[str, Filled]) -> None:
    """u may be the array of x: in a component nothing is read from an array after a store, and results are never read."""
    task = filled[label]
    for function in task.functions.values():
        arrays = {p.name: p.passing for p in function.parameters if p.passing in ("array", "result")}
        loops = [item for item in function.body if isinstance(item, Block)]
        assert len(loops) == (0 if function.is_kernel else 1)
        for loop in loops:
            assert loop.count == str(task.task.n)
            has_stored = False
            for item in loop.body:
                assert isinstance(item, Statement)
                if item.value is not None and item.value.kind == "load":
                    assert not has_stored
                    assert (arrays[item.value.parts[0]], item.value.parts[1]) == ("array", loop.index)
                if item.kind == "store":
                    has_stored = True
                    assert (arrays[item.target], item.index) == ("result", loop.index)
        outside = [item for item in function.body if isinstance(item, Statement)]
        assert not [item for item in outside if item.kind == "store" or (item.value and item.value.kind == "load")]
        stored = {item.target for loop in loops for item in loop.body if isinstance(item, Statement) and item.kind == "store"}
        assert stored == {name for name, passing in arrays.items() if passing == "result"}


# ------------------------------------------------------------------------------------------------ the functions


def exact_edges(tube: Tube, u: Fraction, i: int, order: int = 0) -> tuple[Fraction, Fraction]:
    """Return lower and upper edge of component i at spline time u, in units; order 1: their rates, in units a segment."""
    k = min(math.floor(u), tube.segments - 1)
    s = u - k

    def value(coefficients: Sequence[Fraction]) -> Fraction:
        points = [Fraction(c) for c in coefficients]
        if order:
            points = [3 * (b - a) for a, b in itertools.pairwise(points)]
        while len(points) > 1:
            points = [a + s * (b - a) for a, b in itertools.pairwise(points)]
        return points[0]

    low, high = tube.pieces[k][i]
    return value(low), value(high)


def spline_time(task: Filled, tick: int) -> Fraction:
    tube = task.tube
    return min(Fraction(tube.segments), tick * task.task.tick * tube.segments / task.task.t_c)


@pytest.mark.parametrize("label", TASKS_OF_INTEGERS)
def test_edges_are_the_tube_s_within_their_bound(label: str, filled: dict[str, Filled]) -> None:
    """At every kind of tick, the last one and later ones too; of order 2 the edges of v + lambda x."""
    task, tube = filled[label], filled[label].tube
    run, n, random = IntegerRun(task.functions, task.values), task.task.n, Random(label)
    controller = SimpleNamespace(task=task.task, stated=task.values)
    Integers.check_clock(controller, tube)  # type: ignore[arg-type]
    edge_error, rate_error = (
        [e / tube.unit for e in Integers.arithmetic_error(controller, tube, 20, order)]
        if order == 0 or "order 2" in task.options
        else []  # type: ignore[arg-type]
        for order in (0, 1)
    )
    last = task.values["ticks"]
    for tick in (0, 1, last - 1, last, last + 7, (1 << 32) - 1, *(random.randrange(last) for _ in range(100))):
        u, lower, upper = spline_time(task, tick), [0] * n, [0] * n
        run.call("tube", tick, lower, upper)
        for i in range(n):
            assert all(abs(a - b) <= edge_error[i] for a, b in zip((lower[i], upper[i]), exact_edges(tube, u, i), strict=True))
        if "order 2" not in task.options:
            continue
        run.call("filtered_tube", tick, lower, upper)
        for i in range(n):
            s, per_second = (
                Fraction(task.values["filters"][i] * task.values["filter_scale"], 1 << 16),
                tube.segments / task.task.t_c,
            )
            rates, edges = exact_edges(tube, u, i, 1), exact_edges(tube, u, i)
            exact = [r * per_second + s * e for r, e in zip(rates, edges, strict=True)]
            bound = rate_error[i] + s * edge_error[i]
            assert all(abs(a - b) <= bound for a, b in zip((lower[i], upper[i]), exact, strict=True))


def law(e: float, width: float, gain: float, e_max: float) -> float:
    """Return (13) of the normalized error e in a tube of this width: -k xi epsilon."""
    e = max(-e_max, min(e_max, e))
    return -gain * 4 / (width * (1 - e * e)) * math.log((1 + e) / (1 - e))


@pytest.mark.parametrize("label", TASKS_OF_INTEGERS)
def test_control_and_margins_are_the_law_s(label: str, filled: dict[str, Filled]) -> None:
    """Beside the emitted edges: u within 2^-10, relative and in epsilon; the status exactly; margins within 2^-10 of the width. For order
    2 the distances of v + lambda x are off by 3 units, as products with lambda are rounded down."""
    task, random = filled[label], Random(label)
    run, n, unit = IntegerRun(task.functions, task.values), task.task.n, float(task.tube.unit)
    certificate = json.loads(build(TASKS_OF_INTEGERS[label]).files["cart.certificate.json"])
    gains, e_max = [float(Fraction(v)) for v in certificate["control"]["gain"]], float(task.task.e_max[0])
    u_unit, has_order_2 = 2.0 ** -int(str(task.values["u_bits"]).strip("()")), "order 2" in task.options
    rounding = 3 if has_order_2 else 0
    for _ in range(60):
        tick, lower, upper = random.randrange(task.values["ticks"]), [0] * n, [0] * n
        run.call("tube", tick, lower, upper)
        x = [
            round(a + (b - a) * random.choice((random.random(), random.uniform(-0.2, 1.2), 0, 1)))
            for a, b in zip(lower, upper, strict=True)
        ]
        sides, state = [(p - a, b - p) for a, b, p in zip(lower, upper, x, strict=True)], [x]
        z_sides = sides
        if has_order_2:
            run.call("filtered_tube", tick, lower, upper)
            z = [a + (b - a) * random.uniform(-0.1, 1.1) for a, b in zip(lower, upper, strict=True)]
            scales = [task.values["filters"][i] * task.values["filter_scale"] / 65536 for i in range(n)]
            v = [round(q - s * p) for q, s, p in zip(z, scales, x, strict=True)]
            z_sides = [(w + s * p - a, b - w - s * p) for w, s, p, a, b in zip(v, scales, x, lower, upper, strict=True)]
            state.append(v)
        u, margins = [0] * n, [0] * n
        status = run.call("control", tick, *state, u)
        distances = [min(pair) for pair in (*sides, *z_sides)]
        if min(abs(d) for d in distances) > rounding:
            assert status == int(min(distances) <= 0)
        for i, (a, b) in enumerate(z_sides):
            width, limit = a + b, task.values["limits"][i] * u_unit
            e, slack = (a - b) / width, 2 * rounding / width
            expected = [law(e + d, width * unit, gains[i], e_max) for d in (-slack, 0, slack)]
            clamped = max(-e_max, min(e_max, e))
            tolerance = 2**-10 * (max(map(abs, expected)) + abs(gains[i]) * 4 / (width * unit * (1 - clamped**2))) + 2 * u_unit
            assert min(expected) - tolerance <= u[i] * u_unit <= max(expected) + tolerance or abs(u[i]) * u_unit == limit
            if abs(u[i]) * u_unit == limit:
                assert max(map(abs, expected)) + tolerance >= limit
                assert u[i] * expected[1] > 0
        run.call("margins", tick, *state, margins)
        for i in range(n):
            exact = min(max(min(pair) / sum(pair), -1) for pair in (sides[i], z_sides[i]))
            assert abs(margins[i] / 65536 - exact) <= 2**-10 + 2 * rounding / min(sum(sides[i]), sum(z_sides[i]))
        assert run.call("margin", tick, *state) == min(32768, *margins)


@pytest.mark.parametrize("label", ["selftest", "order 2", "order 2, scaled filter"])
def test_covered_is_that_all_are_strictly_between_their_bounds(label: str, filled: dict[str, Filled]) -> None:
    task = filled[label]
    run, n, values = IntegerRun(task.functions, task.values), task.task.n, task.values
    kinds = ("start", "filtered_start")[: 1 + ("order 2" in task.options)]
    for changed in (None, *itertools.product(kinds, range(n), ("lower", "upper"))):
        x = [(a + b) // 2 for a, b in zip(values["start_lower"], values["start_upper"], strict=True)]
        if changed and changed[0] == "start":
            x[changed[1]] = values[f"start_{changed[2]}"][changed[1]]
        state = [x]
        if len(kinds) == 2:
            z = [(a + b) // 2 for a, b in zip(values["filtered_start_lower"], values["filtered_start_upper"], strict=True)]
            if changed and changed[0] == "filtered_start":
                z[changed[1]] = values[f"filtered_start_{changed[2]}"][changed[1]]
            scales = [f * values["filter_scale"] for f in values["filters"]]
            state.append([q - (p * s >> 16) for q, p, s in zip(z, x, scales, strict=True)])
        assert run.call("covered", *state) == (changed is None)


# ------------------------------------------------------------------------------------------------ wrong listings

WRONG = [
    ("integer segment", "P_low_bits(place, 65535);  [coarse]", "P_low_bits(passed, 32767);  [coarse]"),
    ("integer edge", "const int32_t outer = d2_weighted - d0_weighted;", "const int32_t outer = d2_weighted + d0_weighted;"),
    ("integer edge", "const int32_t at_3 = at + $row_3;", "const int32_t at_3 = at + $row_2;"),
    ("curve", "level - fall", "level + fall"),
    (
        "integer law",
        "const int32_t width = to_lower + to_upper;  [order 1]",
        "const int32_t width = to_lower + to_lower;  [order 1]",
    ),
    ("integer law", "upper_nearer ? size_minus : size;  [positive]", "upper_nearer ? size : size_minus;  [positive]"),
    ("integer law", "const int32_t first_row = octave_rows + 8;", "const int32_t first_row = octave_rows + 16;"),
    ("integer law", "P_low_bits(y_tail, 65535)", "P_low_bits(y_bits, 65535)"),
    ("integer control", "const bool inside = offset < width;  [order 1]", "const bool inside = width < offset;  [order 1]"),
    ("integer margin of a component", "x_nearer ? to_upper : to_lower", "x_nearer ? to_lower : to_upper"),
    ("integer margin of a component", "(-1) - x_share", "(-1) - x_quotient"),
    ("integer covered", "x_lower < x_i", "x_i < x_lower"),
]


@pytest.mark.parametrize(("heading", "old", "new"), WRONG)
def test_a_wrong_listing_of_integers_is_noticed(heading: str, old: str, new: str, filled: dict[str, Filled]) -> None:
    """By one of the tests above."""
    task = filled["selftest"]
    with replaced_text(heading, old, new):
        changed = {"selftest": task._replace(functions=integer_functions(task.options, task.values))}

    def run_tests() -> None:
        test_edges_are_the_tube_s_within_their_bound("selftest", changed)
        test_control_and_margins_are_the_law_s("selftest", changed)
        test_covered_is_that_all_are_strictly_between_their_bounds("selftest", changed)

    with pytest.raises((AssertionError, UnknownMeaning)):
        run_tests()


@pytest.mark.parametrize("name", ["crane", "gantry"])
def test_shipped_controllers_stay_within_32_bits(name: str, tmp_path: Path) -> None:
    """The recorded ones are compared with the listing elsewhere; here their spans."""
    text = (ROOT / "tasks" / f"{name}.toml").read_text()
    file = compared_files(text, tmp_path, controller_of(name, "fixed"))[0]
    assert IntegerRanges(integer_functions(file.options, file.values), file.values).check() >= 5
