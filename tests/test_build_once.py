"""`build_once` returns the controller that `build_task` returns for the same task, and removes only stores that no run uses."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from stt_codegen.task import Task, load_task
from tests.support.controllers import ROOT, UNUSED_STORE_AGE_LIMIT, build_once, remove_unused_stores

PLAIN = load_task(ROOT / "tasks" / "omni_s2.toml")


@pytest.mark.parametrize(
    "equal_task",
    [PLAIN.with_options(None, "float"), PLAIN.changed(emit={"scalar": "float"}), PLAIN.changed(plant={"order": 1})],
)
def test_a_task_that_states_a_default_has_a_controller_with_its_own_digest(equal_task: Task) -> None:
    """The tasks look the same, but their digests differ, or the tasks that `changed` returns for them."""
    assert repr(equal_task) == repr(PLAIN)
    for task in (PLAIN, equal_task, PLAIN):
        controller = build_once(task)
        assert controller.task.digest == task.digest
        assert task.digest in controller.files[f"{task.name}.certificate.json"].decode()
        assert controller.task.changed(control={"u_max": "1"}).digest == task.changed(control={"u_max": "1"}).digest


def test_stores_of_other_contents_stay_for_a_day(tmp_path: Path) -> None:
    """Another run in this clone may use a store of other package contents."""
    now = time.time()
    for name, age in (("recent", UNUSED_STORE_AGE_LIMIT - 60), ("old", UNUSED_STORE_AGE_LIMIT + 60)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "controller").write_bytes(b"")
        os.utime(tmp_path / name, (now - age, now - age))
    remove_unused_stores(tmp_path)
    assert [folder.name for folder in tmp_path.iterdir()] == ["recent"]
