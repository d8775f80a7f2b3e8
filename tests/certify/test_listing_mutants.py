"""Wrong listings are noticed: by the symbolic machine of tests/support/listings, and by `checker.pyz --meaning`.

Every sign, comparison, choice, number and name of a statement is changed, one at a time.
"""

from __future__ import annotations

from functools import cache, partial

import pytest

from stt_codegen.checker.stt_checker import meaning
from tests.support.listings.bits import check_split
from tests.support.listings.combinations import options_of, pairwise_combinations
from tests.support.listings.meaning import check_meaning
from tests.support.listings.mutants import Mutant, combinations_with, mutants

COMBINATIONS = [options_of(alternatives) for alternatives in pairwise_combinations()]
MEANING_COMBINATIONS = [{*combination.split(", ")} for combination in meaning.COMBINATIONS]
SPLIT = "exponent and mantissa"  # by bits; --meaning leaves them to the reader's eye
SAMPLE_STEP = 40  # of the mutants that every run of the tests looks at
# Of other statements `--meaning` notices all; these it cannot see, or they mean the same in exact arithmetic.
SAME_FOR_FRACTIONS: dict[str, str] = {}


@cache
def all_mutants() -> tuple[Mutant, ...]:
    return tuple(mutants())


def machine_notices(mutant: Mutant) -> bool:
    checks = [partial(check_meaning, options) for options in combinations_with(mutant, COMBINATIONS)]
    if mutant.heading == SPLIT:
        checks = [partial(check_split, scalar) for scalar in ("float", "double")]
    return any(mutant.notices(check) for check in checks)


def meaning_notices(mutant: Mutant) -> bool:
    checks = [partial(meaning.check_functions, options) for options in combinations_with(mutant, MEANING_COMBINATIONS)]
    return any(
        mutant.notices(check) for check in (*checks, *([meaning.check_logarithm] if mutant.heading == "logarithm" else []))
    )


def test_there_are_mutants_of_every_piece_with_formulas() -> None:
    assert len(all_mutants()) > 600
    assert len({mutant.heading for mutant in all_mutants()}) > 30


@pytest.mark.parametrize("mutant", all_mutants()[::SAMPLE_STEP], ids=str)
def test_a_wrong_statement_is_noticed_by_the_symbolic_machine(mutant: Mutant) -> None:
    assert machine_notices(mutant)


@pytest.mark.slow
def test_every_wrong_statement_is_noticed_by_the_symbolic_machine() -> None:
    assert [str(mutant) for mutant in all_mutants() if not machine_notices(mutant)] == []
