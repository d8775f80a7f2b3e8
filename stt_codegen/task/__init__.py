"""The question: where the system may be, what is unsafe, where it starts, where it must be by the prescribed time."""

from stt_codegen.task.load import json_schema, load_task, parse_task
from stt_codegen.task.shapes import Box, UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet
from stt_codegen.task.task import Task, document_digest

__all__ = [
    "Box", "Task", "UnsafeBall", "UnsafeCapsule", "UnsafeHalfSpaces", "UnsafePolytope", "UnsafeSet",
    "document_digest", "json_schema", "load_task", "parse_task",
]  # fmt: skip
