"""The keys of a task file, read from the tables of schema.py.

The messages for unknown and missing keys are made of these lists, and tests compare the lists of the checker and of docs/task.md
with them.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple, get_args, get_origin

from pydantic import BaseModel

from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import OneOf

MAP_KEYS = ("file", "axes", "as", "free")  # of [map], which load.py reads
TOP = "above the first table"
# Shares of equal letters, as difflib counts them, from which on a known key counts as the one that was meant.
SIMILARITY_IN_TABLE, SIMILARITY_ELSEWHERE = 0.6, 0.75
SHORT_KEY = 4  # letters: such a key is a misspelt one that has at most one letter more or fewer


class TableOfKeys(NamedTuple):
    """A table of a task file: its path, "" for the keys outside of all tables, whether it is one of a list, and its keys."""

    path: str
    is_listed: bool
    keys: tuple[str, ...]

    @property
    def heading(self) -> str:
        """The table as a file writes it, as in [tube.adaptive] or [[unsafe]]."""
        return f"[[{self.path}]]" if self.is_listed else f"[{self.path}]" if self.path else TOP

    @property
    def position(self) -> str:
        """Where the keys of the table stand, as in "in [tube]"."""
        return f"in {self.heading}" if self.path else TOP

    def heading_of(self, key: str) -> str:
        """Return the heading of a table within this one."""
        path = f"{self.path}.{key}".lstrip(".")
        return next((table.heading for table in all_tables() if table.path == path), f"[{path}]")


@cache
def all_tables() -> tuple[TableOfKeys, ...]:
    """Return every table of a task file, those within tables too. A table of several kinds has the keys of all kinds."""
    return (*_tables_within("", False, (TaskTables,)), TableOfKeys("map", False, MAP_KEYS))


def _tables_within(path: str, is_listed: bool, kinds: Sequence[type[BaseModel]]) -> Iterator[TableOfKeys]:
    """Yield a table and those within it. kinds: the tables that its fields are made of."""
    fields = {name: field for kind in kinds for name, field in kind.model_fields.items()}
    yield TableOfKeys(path, is_listed, tuple(fields))
    for name, field in fields.items():
        if inner := list(tables_in(field.annotation)):
            yield from _tables_within(f"{path}.{name}".lstrip("."), _is_list(field.annotation), inner)


def _is_list(annotation: Any) -> bool:
    """Return whether a field is a list of tables."""
    return get_origin(annotation) is tuple or any(map(_is_list, get_args(annotation)))


class SimilarKey(NamedTuple):
    """A known key that a misspelt one may mean, and its table: None where it is of the table in which the misspelt one stands."""

    key: str
    table: TableOfKeys | None


def similar_key(key: str, known_keys: Sequence[str]) -> SimilarKey | None:
    """Return the known key most similar to an unknown one, first among those of its own table; None where none is similar.

    Capitals count as small letters, and - as _. known_keys: those of the table in which the key stands.
    """
    near = [(_similarity(key, known), SimilarKey(known, None)) for known in known_keys]
    far = [(_similarity(key, known), SimilarKey(known, table)) for table in all_tables() for known in table.keys]
    candidates = [c for c in near if c[0] >= SIMILARITY_IN_TABLE] + [c for c in far if c[0] >= SIMILARITY_ELSEWHERE]
    return max(candidates, key=lambda c: c[0], default=(0.0, None))[1]


@lru_cache(1 << 14)  # all pairs of known keys; those of a task have no end
def _similarity(key: str, known_key: str) -> float:
    """Return the share of equal letters of two keys; 0 for a short one whose letters are just a part of a longer one."""
    if len(key) <= SHORT_KEY and abs(len(key) - len(known_key)) > 1:
        return 0.0
    return difflib.SequenceMatcher(None, known_key, key.lower().replace("-", "_")).ratio()


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
