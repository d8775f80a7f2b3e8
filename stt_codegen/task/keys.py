"""The keys of a task file, read from the tables of schema.py.

The messages for unknown keys are made of this list, and tests compare the lists of the checker and of docs/task.md with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

from pydantic import BaseModel

from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import OneOf


def tables_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the tables that a field's type is made of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    if isinstance(annotation, OneOf):
        yield from annotation.tables
    for inner in get_args(annotation):
        yield from tables_in(inner)


def task_keys() -> dict[str, tuple[str, ...]]:
    """Return the keys of each table of a task file by the table's name; keys outside of all tables have the name "".

    A table that has several kinds, as that of a set, has the keys of all kinds."""
    keys = {"": tuple(TaskTables.model_fields)}
    for name, field in TaskTables.model_fields.items():
        inner = dict.fromkeys(key for table in tables_in(field.annotation) for key in table.model_fields)
        if inner:
            keys[name] = tuple(inner)
    return keys
