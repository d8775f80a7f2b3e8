"""`count`: the number of unsafe sets of a task."""

from __future__ import annotations

from stt_codegen.cli.options import Json, TaskFile, print_json


def count(task: TaskFile, json: Json = False) -> None:
    """Count the unsafe sets of a task."""
    from stt_codegen.task import load_task

    count_of_sets = len(load_task(task).unsafe)
    print_json({"unsafe": count_of_sets}) if json else print(f"{task}: {count_of_sets} unsafe sets")
