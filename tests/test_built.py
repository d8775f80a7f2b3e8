"""The store of controllers for tests (`built`) returns the controller that `build_task` returns for the same task."""

from __future__ import annotations

import pytest

from stt_codegen.task import Task, load_task
from tests.support.controllers import ROOT, built

PLAIN = load_task(ROOT / "tasks" / "omni_s2.toml")


@pytest.mark.parametrize(
    "equal_task",
    [PLAIN.with_options(None, "float"), PLAIN.changed(emit={"scalar": "float"}), PLAIN.changed(plant={"order": 1})],
)
def test_a_task_that_states_a_default_has_a_controller_with_its_own_digest(equal_task: Task) -> None:
    """The tasks look the same, but their digests differ, or the tasks that `changed` returns for them."""
    assert repr(equal_task) == repr(PLAIN)
    for task in (PLAIN, equal_task, PLAIN):
        controller = built(task)
        assert controller.task.digest == task.digest
        assert task.digest in controller.files[f"{task.name}.certificate.json"].decode()
        assert controller.task.changed(control={"u_max": "1"}).digest == task.changed(control={"u_max": "1"}).digest
