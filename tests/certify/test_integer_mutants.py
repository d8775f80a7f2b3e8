"""Wrong listings in integers are noticed by the symbolic machine, or for their arithmetic by its results in C.

Every sign, comparison, choice, number, hole, call, order of operands and name of a statement is changed, one at a time.
"""

from __future__ import annotations

import re
from functools import cache, partial
from pathlib import Path

import pytest

from tests.support.listings.integer_arithmetic import check_arithmetic
from tests.support.listings.integer_meaning import check_integer_meaning, integer_combinations
from tests.support.listings.mutants import ARITHMETIC, Mutant, combinations_with, mutants

COMBINATIONS = list(integer_combinations())
SAMPLE_STEP = 24  # of the mutants that every run of the tests looks at
SAME_VALUES = {  # why a mutant means the same, by a pattern of its text
    r"d(\d)_weighted = .* -> .*\(difference_\1, ": "a step has 16 bits, so its lower half is the step",
    r"-> typedef .*(?:\? 1 : -2|\? 2 : -1|\(-4\) >> 1)": "this compiler shifts down, and any negative size stops the others",
    r"-> if \(__builtin_constant_p\(n\) && \((?:n >=? 1[2367]|a > 12)\)": "both branches shift by these n",
    r"-> return \(\(shifted >> 16\)": "nothing is shifted yet",
}


@cache
def all_mutants() -> tuple[Mutant, ...]:
    return tuple(mutants("integer controller"))


def is_noticed(mutant: Mutant, compiler: str, folder: Path) -> bool:
    if mutant.heading == ARITHMETIC:
        return any(mutant.notices(partial(check_arithmetic, compiler, folder, is_avr)) for is_avr in (True, False))
    options = combinations_with(mutant, COMBINATIONS, "integer controller")
    return any(mutant.notices(partial(check_integer_meaning, combination)) for combination in options)


def is_explained(mutant: Mutant) -> bool:
    return any(re.search(pattern, str(mutant)) for pattern in SAME_VALUES)


def test_there_are_mutants_of_every_piece_of_the_listing_in_integers() -> None:
    assert len(all_mutants()) > 1100
    assert len({mutant.heading for mutant in all_mutants()}) == 25


def test_the_listing_in_integers_itself_is_noticed_by_nobody(tool, tmp_path: Path) -> None:
    """So what notices a mutant is its change, and no fault of the checks."""
    by_heading = {mutant.heading: mutant._replace(replacement=mutant.line) for mutant in all_mutants()}
    assert [str(same) for same in by_heading.values() if is_noticed(same, tool("gcc"), tmp_path)] == []


@pytest.mark.parametrize("mutant", all_mutants()[::SAMPLE_STEP], ids=str)
def test_a_wrong_statement_in_integers_is_noticed(mutant: Mutant, tool, tmp_path: Path) -> None:
    assert is_noticed(mutant, tool("gcc"), tmp_path) or is_explained(mutant)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_every_wrong_statement_in_integers_is_noticed(part: int, tool, tmp_path: Path) -> None:
    unseen = [mutant for mutant in all_mutants()[part::4] if not is_noticed(mutant, tool("gcc"), tmp_path)]
    assert [str(mutant) for mutant in unseen if not is_explained(mutant)] == []
    assert len(unseen) <= 10  # of some 300
