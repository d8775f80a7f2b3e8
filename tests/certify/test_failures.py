"""What a refused period is said to fail by: the advice is true, and the noise is named where it leaves no room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pytest

from stt_codegen import pipeline
from stt_codegen.errors import Reason
from stt_codegen.remedies.adjustments import adjustments_of
from stt_codegen.task import Task
from tests.support.controllers import controller_of


def task_with(**tables: Mapping[str, object]) -> Task:
    return controller_of("omni_s2").task.changed(**tables)


def reason_of(task: Task) -> Reason:
    """Return why the preferred tube of a task is refused."""
    certificate = pipeline.attempt(task, pipeline.preferred_tube(task)).certificate
    assert not certificate.holds
    return certificate.reason


@pytest.mark.parametrize("limit", ["0.9", "1.2", "2", "auto"])
def test_advice_against_a_period_that_is_too_long_names_no_limit_of_u(limit: str) -> None:
    """A larger limit is proved for a shorter period, and not for this one."""
    plant = {"w_max": "0.1"}
    task = task_with(control={"u_max": limit, "gain": "0.3", "period": "0.3"}, plant=plant)
    reason = reason_of(task)
    assert "is too long" in reason.problem
    assert "u_max" not in reason.hint
    if limit != "auto":
        raised = task.changed(control={"u_max": f"{1.5 * float(limit):g}"})
        assert not pipeline.attempt(raised, pipeline.preferred_tube(raised)).certificate.holds


@pytest.mark.parametrize(
    ("plant", "axis"),
    [
        ({"noise": ["0.001", "1"]}, 1),
        ({"noise": ["0.4", "0.001"]}, 0),
        ({"noise": "0.3"}, None),
        ({"order": 2, "noise": ["0.001", "0.002"], "noise_v": ["0.4", "0.001"]}, 0),
    ],
)
def test_noise_that_leaves_no_room_is_named_with_its_axis_and_numbers_and_changed_there_first(
    plant: Mapping[str, object], axis: int | None
) -> None:
    task = task_with(control={"period": "0.02", "gain": "auto", "u_max": "auto"}, plant={"w_max": "0.01", **plant})
    reason = reason_of(task)
    assert reason.axis is not None
    assert axis in (None, reason.axis)
    key = "plant.noise_v" if "noise_v" in plant else "plant.noise"
    assert f"in {task.axis_words[reason.axis]} " in reason.problem
    assert key in reason.problem
    assert "wide where it is narrowest" in reason.problem
    assert key in reason.about
    first = next(adjustments_of(task, reason))
    edits = dict(first.change(first.factors[-1]).edits)
    assert key in edits
    stated, changed = plant[key.removeprefix("plant.")], edits[key]
    if isinstance(stated, Sequence) and not isinstance(stated, str):
        assert isinstance(changed, tuple)
        assert [i for i, v in enumerate(changed) if float(v) != float(stated[i])] == [axis]


def test_noise_that_leaves_room_is_not_named() -> None:
    """Here the period is too long, whatever the noise."""
    reason = reason_of(
        task_with(control={"period": "0.3", "gain": "0.3", "u_max": "2"}, plant={"w_max": "0.1", "noise": "0.001"})
    )
    assert "noise" not in reason.problem
    assert reason.about == ("control.period",)
