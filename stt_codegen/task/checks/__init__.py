"""Checks of a task, each with one message: fields that do not fit together, sets, missions, reserved words."""

from stt_codegen.task.checks.field_checks import first_problem, structure_problem
from stt_codegen.task.checks.schema_messages import describe_unknown_key, explain

__all__ = ["describe_unknown_key", "explain", "first_problem", "structure_problem"]
