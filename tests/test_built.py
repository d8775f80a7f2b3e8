"""The store of controllers: what it gives is what `build_task` would give for that very task."""

from __future__ import annotations

import pytest

from stt_codegen.task import Task, load_task
from tests.support.controllers import ROOT, built

PLAIN = load_task(ROOT / "tasks" / "omni_s2.toml")


@pytest.mark.parametrize(
    "spelled",
    [PLAIN.with_options(None, "float"), PLAIN.changed(emit={"scalar": "float"}), PLAIN.changed(plant={"order": 1})],
)
def test_a_task_that_spells_a_default_out_has_a_controller_of_its_own(spelled: Task) -> None:
    """The tasks read the same, but their digests differ, or what `changed` makes of them."""
    assert repr(spelled) == repr(PLAIN)
    for task in (PLAIN, spelled, PLAIN):
        kept = built(task)
        assert kept.task.digest == task.digest
        assert task.digest in kept.files[f"{task.name}.certificate.json"].decode()
        assert kept.task.changed(control={"u_max": "1"}).digest == task.changed(control={"u_max": "1"}).digest
