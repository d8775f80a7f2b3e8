"""Changes of a task file beside each other."""

from __future__ import annotations

from fractions import Fraction

import pytest

from stt_codegen.errors import Reason
from stt_codegen.remedies.adjustments import adjustments_of
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


@pytest.mark.parametrize(
    ("table", "key", "codes"),
    [
        ("plant", "noise", "P9"),
        ("plant", "w_max", "P9"),
        ("plant", "f_max", "P8"),
        ("plant", "g_cross", "P8"),
        ("plant", "lag", "P9"),
        ("plant", "slew", "P9"),
        ("control", "u_max", "P8"),
        ("tube", "clearance", "P4"),
        ("tube", "min_width", "P1"),
    ],
)
def test_of_a_list_the_entry_of_the_axis_that_fails_is_changed_alone_before_all(table: str, key: str, codes: str) -> None:
    values = (Fraction(1, 50), Fraction(3, 100))
    task = sampled_task().changed(**{table: {key: [str(float(v)) for v in values]}})
    changed = [
        dict(adjustment.change(adjustment.factors[0]).edits)[f"{table}.{key}"]
        for adjustment in adjustments_of(task, Reason("", codes=(codes,), axis=1))
        if f"{table}.{key}" in adjustment.keys and not adjustment.is_choice
    ]
    alone, together = changed
    assert isinstance(alone, tuple)
    assert isinstance(together, tuple)
    assert [a == v for a, v in zip(alone, values, strict=True)] == [True, False]
    assert [a == v for a, v in zip(together, values, strict=True)] == [False, False]
