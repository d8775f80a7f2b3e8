"""The question: where the system may be, what is unsafe, where it starts, where it must be by the prescribed time."""

from stt_codegen.task.load import document_digest, json_schema, load_task, parse_task
from stt_codegen.task.schema import Box, Task, UnsafeSet

__all__ = ["Box", "Task", "UnsafeSet", "document_digest", "json_schema", "load_task", "parse_task"]
