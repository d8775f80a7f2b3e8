"""Changes of a task file beside each other."""

from __future__ import annotations

from fractions import Fraction

from stt_codegen.remedies.changes import Change, Edit
from tests.remedies.test_remedies import sampled_task


def test_a_change_is_part_of_one_that_makes_its_edits_and_none_by_less() -> None:
    task = sampled_task().changed(tube={"clearance": ["0.6", "0.4"]})

    def clearance(*values: str) -> Edit:
        return Edit("tube.clearance", tuple(map(Fraction, values)))

    slower, slowest = (Edit("prescribed_time", Fraction(v)) for v in (12, 20))
    alone = Change((clearance("0.3", "0.4"),))
    assert alone.is_part_of(Change((clearance("0.3", "0.2"),)), task)
    assert alone.is_part_of(Change((slower, clearance("0.3", "0.4"))), task)
    assert not alone.is_part_of(Change((clearance("0.5", "0.2"),)), task)
    assert not alone.is_part_of(Change((slower,)), task)
    assert Change((slower,)).is_part_of(Change((slowest,)), task)
    assert not Change((slowest,)).is_part_of(Change((slower,)), task)
    assert not Change((slower,)).is_part_of(Change((Edit("prescribed_time", Fraction(5)),)), task)
    assert not Change((Edit("tube.prefer", None),)).is_part_of(Change((Edit("tube.prefer", "speed"),)), task)
