"""`count`: how long a task is."""

from __future__ import annotations

from stt_codegen.cli.options import Json, TaskFile, print_json


def count(task: TaskFile, json: Json = False) -> None:
    """Count the unsafe sets of a task."""
    from stt_codegen.task import load_task

    found = len(load_task(task).unsafe)
    print_json({"unsafe": found}) if json else print(f"{task}: {found} unsafe sets")
