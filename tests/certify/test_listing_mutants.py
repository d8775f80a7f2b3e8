"""Wrong listings are noticed: by the symbolic machine of tests/support/listings, and by `checker.pyz --meaning`.

Every sign, comparison, choice, number and name of a statement is changed, one at a time.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache, partial

import pytest

from stt_codegen.checker.stt_checker import meaning
from tests.support.listings.bits import check_split
from tests.support.listings.combinations import options_of, pairwise_combinations
from tests.support.listings.meaning import check_meaning
from tests.support.listings.mutants import Mutant, combinations_with, mutants

Check = Callable[[], object]
COMBINATIONS = [options_of(alternatives) for alternatives in pairwise_combinations()]
MEANING_COMBINATIONS = [{*combination.split(", ")} for combination in meaning.COMBINATIONS]
SPLIT = "exponent and mantissa"  # by bits; --meaning leaves them to the reader's eye
MEANING_RUNS = 3  # a run draws its own numbers, and may miss a change that shows for few of them
SAMPLE_STEP = 40  # of the mutants that every run of the tests looks at
SAME_VALUES = {
    r"positive \? dt : 2\.0": "the quotient is not used where dt is not positive",
    r"to_nearer = farther \?": "a tube without width has zeros",
}
# Of what --meaning does not notice: why not, by a pattern of the mutant's text.
UNSEEN = SAME_VALUES | {
    r"^(?!.*(?:inside|x_above|x_below|z_above|z_below) = ).* < .* -> .* <= ": "both choices are equal where the compared values are",
    r"segment of a tick: .*early \? whole": "the last segment is counted up to the end",
    r"margin: return margin; -> return margin_next;": "it does not compile",
    r"transform: .*(?:e_above|e_limited) = ": "the clamp of e is for rounding alone: the distances are clamped before",
    r"isfinite|sum of zeros|inputs that are not finite": "tests for NaN are for the reader's eye",
    r"z_beyond = z_distance <": "the distances of v + lambda x are large in these examples",
    r"scale u: .*u_above = .*factor|u_beyond \? \$limit : u_scaled": "the clamp of u is for rounding alone: the largest |u| is the limit",
}


@cache
def all_mutants() -> tuple[Mutant, ...]:
    return tuple(mutants())


def machine_checks(mutant: Mutant) -> list[Check]:
    """Return what the symbolic machine checks where this piece is used."""
    if mutant.heading == SPLIT:
        return [partial(check_split, scalar) for scalar in ("float", "double")]
    return [partial(check_meaning, options) for options in combinations_with(mutant, COMBINATIONS)]


def meaning_checks(mutant: Mutant) -> list[Check]:
    """Return what a run of --meaning checks where this piece is used."""
    checks: list[Check] = [
        partial(meaning.check_functions, options) for options in combinations_with(mutant, MEANING_COMBINATIONS)
    ]
    return checks + ([meaning.check_logarithm] if mutant.heading == "logarithm" else [])


def name_of(check: Check) -> str:
    """Return a text that two checks have in common where they check the same."""
    function, arguments = (check.func, check.args) if isinstance(check, partial) else (check, ())
    return f"{function} {[sorted(v) if isinstance(v, set) else v for v in arguments]}"


def machine_notices(mutant: Mutant) -> bool:
    return any(mutant.notices(check) for check in machine_checks(mutant))


def meaning_notices(mutant: Mutant) -> bool:
    """Whether one of MEANING_RUNS runs of --meaning notices the mutant: each draws other numbers."""
    return any(mutant.notices(check) for check in meaning_checks(mutant) * MEANING_RUNS)


def is_explained(mutant: Mutant, reasons: Mapping[str, str]) -> bool:
    return any(re.search(pattern, str(mutant)) for pattern in reasons)


def test_there_are_mutants_of_every_piece_with_formulas() -> None:
    assert len(all_mutants()) > 600
    assert len({mutant.heading for mutant in all_mutants()}) > 30


def test_the_listing_itself_is_noticed_by_nobody() -> None:
    """So what notices a mutant is its change, and no fault of the checks. Each check that the sample needs is run once."""
    sample = all_mutants()[::SAMPLE_STEP]
    checks = [check for mutant in sample for check in (*machine_checks(mutant), *meaning_checks(mutant))]
    for check in {name_of(check): check for check in checks}.values():
        check()


@pytest.mark.parametrize("mutant", all_mutants()[::SAMPLE_STEP], ids=str)
def test_a_wrong_statement_is_noticed(mutant: Mutant) -> None:
    assert machine_notices(mutant) or is_explained(mutant, SAME_VALUES)
    assert mutant.heading == SPLIT or meaning_notices(mutant) or is_explained(mutant, UNSEEN)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_every_wrong_statement_is_noticed_by_the_symbolic_machine(part: int) -> None:
    unseen = [mutant for mutant in all_mutants()[part::4] if not machine_notices(mutant)]
    assert [str(mutant) for mutant in unseen if not is_explained(mutant, SAME_VALUES)] == []


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_every_wrong_statement_is_noticed_by_the_command(part: int) -> None:
    """`--meaning`: of the mutants at most one in ten means the same, or is for the reader's eye."""
    considered = [mutant for mutant in all_mutants()[part::4] if mutant.heading != SPLIT]
    unseen = [mutant for mutant in considered if not meaning_notices(mutant)]
    assert [str(mutant) for mutant in unseen if not is_explained(mutant, UNSEEN)] == []
    assert len(unseen) < len(considered) / 10
