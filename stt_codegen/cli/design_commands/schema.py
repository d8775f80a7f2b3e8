"""`schema`: the JSON Schema of task files."""

from __future__ import annotations

from stt_codegen.cli.options import Json


def schema(json: Json = True) -> None:  # noqa: ARG001 (every command has --json; this one prints nothing else)
    """Print the JSON Schema of task files, for editors."""
    from stt_codegen.task import json_schema

    print(json_schema(), end="")
