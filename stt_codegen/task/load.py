"""Read a task file: from its text to a `Task`.

Every refusal is a `BadInput` with one message: the file, the field, what is wrong and what would be right. The command line and
api.py call it.
"""

from __future__ import annotations

import json
from pathlib import Path

from stt_codegen.errors import about, noted
from stt_codegen.files import parse_toml, read_task_text
from stt_codegen.task.task import Task
from stt_codegen.task.values import FILE


def load_task(path: str | Path) -> Task:
    """Read and check a task file. Raises `BadInput` where the file cannot be read or the task is refused."""
    path = Path(path)
    return parse_task(read_task_text(path), str(path), path.parent)


def parse_task(text: str, source: str = "task", folder: Path | None = None) -> Task:
    """Read and check the text of a task file, as `load_task` does.

    source: the name of the text in messages; folder: where the files of maps are, the current folder if absent.
    """
    with about(source):
        document = parse_toml(text)
        if "map" not in document:
            return Task.model_validate(document, context={FILE: True})
        from stt_codegen.task.map import expand_maps, require_map_table, to_toml

        require_map_table(document["map"])  # before the other tables: a key of theirs may stand in it
        without_map = Task.model_validate({k: v for k, v in document.items() if k != "map"}, context={FILE: True})
        expansion = expand_maps(document, without_map, folder or Path())
        with noted(expansion.notes):
            task = Task.model_validate(expansion.document, context={FILE: True})
        task._map_notes = expansion.notes
        if task.floor_plan is None:  # else the text already has the sets of the outline and of the map
            task._expanded_text = to_toml(expansion.document)
        task._expanded_keys = ("map", *task.expanded_keys)
        return task


def json_schema() -> str:
    """Return the JSON Schema of a task file, for editors that complete and check TOML."""
    schema = Task.model_json_schema()
    texts = {"type": "array", "items": {"type": "string"}}
    schema["properties"]["map"] = {
        "type": "object",
        "description": "occupancy maps of a map server, taken as unsafe sets",
        "properties": {
            "file": {"anyOf": [{"type": "string"}, {**texts, "minItems": 1}]},
            "axes": texts,
            "as": {"enum": ["boxes", "polygons"]},
            "free": {"enum": ["white", "thresholds"]},
        },
        "required": ["file"],
        "additionalProperties": False,
    }
    schema["title"] = "stt_codegen task"
    schema["description"] = schema["description"].partition("\n")[0]
    return json.dumps(schema, indent=2, sort_keys=True) + "\n"
