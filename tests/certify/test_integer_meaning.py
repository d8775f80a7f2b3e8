"""What the listing in integers means, derived from its statements on symbols, for every combination of its options; the constants of
integers.py for its weights; and its arithmetic, compiled. test_integer_listing.py has ranges and runs on numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stt_codegen.checker.stt_checker import source
from tests.support.listings.changes import replaced_text
from tests.support.listings.integer_arithmetic import check_arithmetic
from tests.support.listings.integer_meaning import (
    check_integer_meaning,
    check_weight_errors,
    integer_combinations,
)
from tests.support.listings.integer_run import integer_functions, results_at_every_s
from tests.support.listings.mutants import ARITHMETIC, headings
from tests.support.listings.reader import UnknownMeaning

COMBINATIONS = list(integer_combinations())
FULL = {"order 2", "long", "fine", "negative", "scaled filter"}
NUMBERS: dict[str, Any] = {  # of a task, as far as the weights need them
    **{f"{name}_{part}": "16" for name in ("coefficients", "filters") for part in ("type", "bits")},
    **dict.fromkeys("n pairs entries rows row_1 row_2 row_3 ticks clock_scale clock_bits tick_end fine_shift".split(), 1),
    **dict.fromkeys("largest_x filter_scale smallest_width smallest_x_width largest_e smallest_y".split(), 1),
    **{f"{name}start_{side}_bits": "16" for name in ("", "filtered_") for side in ("lower", "upper")},
    "rate_mantissa": 50000, "rate_half": 1 << 19, "rate_shift": 20, "rate_bits": 9,
}  # fmt: skip


@pytest.mark.parametrize("options", COMBINATIONS, ids=lambda options: ", ".join(sorted(options)))
def test_the_listing_in_integers_does_what_the_specification_says(options: set[str]) -> None:
    """Both with every loss of bits, and with none, where the specification has the formulas."""
    assert check_integer_meaning(options) == (18 if "order 2" in options else 15)


def test_every_line_of_the_listing_in_integers_is_in_a_combination() -> None:
    """Of all pieces but the header, which no function is in."""
    reached = {line for options in COMBINATIONS for line in source.chosen_lines("integer controller", options)}
    for heading in headings("integer controller"):
        lines = [line.partition("  [")[0] for line in source.pieces()[heading]]
        assert [line for line in lines if line not in reached and not line.lstrip().startswith("<<")] == []
    unreached = {name for name in source.pieces() if name.startswith("integer ")} - {*headings("integer controller")}
    assert unreached == {"integer header"}


# Changes after which a listing may even compile; each is of another kind than those of mutants.py.
CHANGES = [
    ("integer edges", "P_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate)",
     "P_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_rate, &upper_edge)"),
    ("integer edges", "P_edge_at(lower_at, w0, w1, w2, r0, r1, r2", "P_edge_at(lower_at, r0, r1, r2, w0, w1, w2"),
    ("integer distances", "        <<limited x>>\n", "        u[i] = 0;\n        <<limited x>>\n"),
    ("integer control", "bool outside = false;", "bool outside = true;"),
    ("integer control", "        outside = outside_next;\n", ""),
    ("integer margin", "int32_t margin = 32768;", "int32_t margin = 65535;"),
    ("integer tube", "for (int32_t i = 0; i < $n; ++i) {", "for (int32_t i = 0; i < $pairs; ++i) {"),
    ("integer controller", "uint16_t P_gains[$n]", "uint8_t P_gains[$n]"),
    ("integer controller", "P_levels[$rows]", "P_levels[$n]"),
    ("integer law", "M_READ_16(P_gains[i])", "M_READ_8(P_gains[i])"),
    ("integer law", "P_gains[i]", "P_gains[y_row]"),
    ("integer controller", "#include <stdbool.h>", "#define bool int"),
]  # fmt: skip


@pytest.mark.parametrize(("heading", "old", "new"), CHANGES)
def test_a_listing_in_integers_with_another_meaning_is_refused(heading: str, old: str, new: str) -> None:
    with replaced_text(heading, old, new), pytest.raises((UnknownMeaning, KeyError)):
        check_integer_meaning(FULL)


# ------------------------------------------------------------------------------------------------ errors of the weights


def test_the_errors_of_all_weights_are_the_checker_s_constants() -> None:
    """At every s, and no smaller: another constant is refused."""
    check_weight_errors(FULL, NUMBERS)
    functions = integer_functions(FULL, NUMBERS)
    w0, w1, w2 = results_at_every_s(functions["weights"].tokens)
    assert (w0.max(), w1.max(), w2.max()) == (1 << 15, 65535, (1 << 15) - 1)
    assert min(w0.min(), w1.min(), w2.min()) >= 0


def test_a_mantissa_of_17_bits_is_refused() -> None:
    """No controller has it; with 2^16 the products would be exact."""
    functions = integer_functions(FULL, NUMBERS | {"rate_mantissa": 1 << 16})
    with pytest.raises(UnknownMeaning, match="gets other numbers"):
        results_at_every_s(functions["rates"].tokens)


@pytest.mark.parametrize(
    ("heading", "old", "new", "message"),
    [
        ("integer weights", "middle_raised + 8192", "middle_raised + 8100", "weights of an edge"),
        ("integer weights", "square, s)", "square, s_fine)", "gets other numbers"),
        ("integer rates", "difference_limited * 2", "difference_limited * 1", "powers of s"),
    ],
)
def test_other_weights_have_other_constants(heading: str, old: str, new: str, message: str) -> None:
    with replaced_text(heading, old, new), pytest.raises(UnknownMeaning, match=message):
        check_weight_errors(FULL, NUMBERS)


# ------------------------------------------------------------------------------------------------ the arithmetic in C


@pytest.mark.parametrize("is_avr", [True, False], ids=["AVR", "others"])
def test_the_arithmetic_of_integers_is_what_its_comments_say(is_avr: bool, tool, tmp_path: Path) -> None:
    """Both halves of the piece, with shifts by constants, and reads of tables of each type."""
    check_arithmetic(tool("gcc"), tmp_path, is_avr)


def test_a_wrong_branch_for_constant_shifts_is_noticed(tool, tmp_path: Path) -> None:
    """An AVR has it alone, and no call with a variable reaches it."""
    with replaced_text(ARITHMETIC, "(16 - n)", "(15 - n)"), pytest.raises(UnknownMeaning):
        check_arithmetic(tool("gcc"), tmp_path, True)
