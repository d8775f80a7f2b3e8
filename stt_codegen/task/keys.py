"""The keys of a task file, from the tables that read them: the one list that everybody else's is made of, or held against."""

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
    """Return the keys of each table of a task file, by the table's name; those outside of all tables by "".

    A table that is read in several ways, as that of a set, has the keys of all."""
    keys = {"": tuple(TaskTables.model_fields)}
    for name, field in TaskTables.model_fields.items():
        inner = dict.fromkeys(key for table in tables_in(field.annotation) for key in table.model_fields)
        if inner:
            keys[name] = tuple(inner)
    return keys
