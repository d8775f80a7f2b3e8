"""`schema`: the JSON Schema of task files."""

from __future__ import annotations

from stt_codegen.cli.options import Json


def schema(json: Json = True) -> None:
    """Print the JSON Schema of task files, for editors."""
    from stt_codegen.task import json_schema

    print(json_schema(), end="")
