"""The question: where the system may be, what is unsafe, where it starts, where it must be by the prescribed time.

Large because the task format is here with all its checks: sets, missions, maps, rooms, axes that close.
"""

from stt_codegen.task.assumed_plant import with_assumed_plant
from stt_codegen.task.closed_axes import SET_TURNS_LIMIT, TWO_PI, ClosedAxis
from stt_codegen.task.demands import require_offered
from stt_codegen.task.input_norm import SMALLEST_SHARE, is_within_norm, shares_of_norm
from stt_codegen.task.keys import task_keys
from stt_codegen.task.load import json_schema, load_task, parse_task
from stt_codegen.task.schema import DriveBounds
from stt_codegen.task.task import Task

__all__ = [
    "SET_TURNS_LIMIT",
    "SMALLEST_SHARE",
    "TWO_PI",
    "ClosedAxis",
    "DriveBounds",
    "Task",
    "is_within_norm",
    "json_schema",
    "load_task",
    "map",
    "mission",
    "parse_task",
    "require_offered",
    "sets",
    "shares_of_norm",
    "task_keys",
    "with_assumed_plant",
]  # fmt: skip
