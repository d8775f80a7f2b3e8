"""How long the search for another way may take, and what is said of it while it goes on."""

from __future__ import annotations

from contextlib import suppress
from fractions import Fraction

import pytest

from benchmarks.suites.remedies import remedies_of
from stt_codegen.effort import Effort, EffortSpent, require_effort
from stt_codegen.errors import BadInput
from stt_codegen.remedies import CertificationTests, find_remedies
from stt_codegen.task import Task
from tests.remedies.test_remedies import TOO_LONG, period_of, sampled_task


def test_a_limit_counts_within_its_block_alone() -> None:
    effort = Effort(0.0)
    require_effort()
    with pytest.raises(EffortSpent), effort.limit(1.0):
        require_effort()
    require_effort()


@pytest.mark.parametrize(("delay", "said"), [(0.0, ["too narrow"]), (60.0, [])])
def test_the_first_reason_is_said_once_where_the_search_goes_on(
    delay: float, said: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stt_codegen.effort.effort.ANNOUNCEMENT_DELAY", delay)
    lines: list[str] = []
    effort = Effort(60.0, lambda reason, _: lines.append(reason))
    effort.begin_search("too narrow")
    effort.begin_search("a later one")
    with effort.limit(1.0):
        for _ in range(3):
            require_effort()
    assert lines == said


@pytest.mark.parametrize(("elapsed", "said"), [(1.0, []), (4.0, [6]), (6.0, [4]), (7.5, []), (15.0, [])])
def test_the_time_that_is_left_is_said_and_nothing_where_the_search_ends_at_once(elapsed: float, said: list[int]) -> None:
    """The search for changes ends at 8 of 10 s."""
    seconds: list[int] = []
    effort = Effort(10.0, lambda _, left: seconds.append(round(left)))
    effort._begin -= elapsed
    effort.begin_search("too narrow")
    with suppress(EffortSpent), effort.limit(0.8):
        require_effort()
    assert seconds == said


def test_a_change_whose_proof_takes_too_long_is_named_as_one_that_is_not_proved() -> None:
    """The quick test admits it; the proof goes on until its time is over."""

    def prove_for_ever(_: Task) -> bool:
        while True:
            require_effort()

    with Effort(0.5).limit(0.8):
        remedies = find_remedies(sampled_task(), TOO_LONG, CertificationTests(lambda _: True, prove_for_ever))
    assert not remedies.changes
    sentence = remedies.sentence("", "")
    assert sentence.startswith("with control.")
    assert "it may be certified, for which the time for a proof was too short; the time was over" in sentence
    assert not remedies_of(f"no; {sentence}")


def test_a_change_is_made_milder_only_while_its_proof_has_the_time_that_the_first_attempt_took() -> None:
    effort, trials = Effort(10.0), list[Task]()
    effort._begin -= 7.0
    effort.begin_search("too long")  # 7 of 10 s, and a proof takes as long
    with effort.limit(0.8):
        find_remedies(sampled_task(), TOO_LONG, CertificationTests(lambda task: not trials.append(task), lambda _: True))
    assert {period_of(task) for task in trials} == {period_of(sampled_task()), Fraction(1, 20)}  # the strongest step alone


@pytest.mark.parametrize("seconds", [float("nan"), -1, float("inf"), "x", None])
def test_an_effort_that_is_no_number_of_seconds_is_bad_input(seconds: object) -> None:
    with pytest.raises(BadInput, match="effort: is .*; a number of seconds is needed, 0 or more"):
        Effort(seconds)  # type: ignore[arg-type]
