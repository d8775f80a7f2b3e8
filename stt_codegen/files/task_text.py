"""Read the text of a task file within the bound on its size. Rooms that parse it call this."""

from __future__ import annotations

from pathlib import Path

from stt_codegen.files.bounded_reading import decode, read_input

TASK_SIZE_LIMIT = 4_000_000  # bytes; 2,000 boxes are 200,000 bytes


def read_task_text(path: Path) -> str:
    """Return the text of a task file. Raises `BadInput` where it cannot be read, is too large, or is not in UTF-8."""
    return decode(path, read_input(path, TASK_SIZE_LIMIT, "give the path of a task file"), "save the file as UTF-8")
