"""A change of a task file: keys with other values, as text that a reader can copy, and as the task that follows from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from stt_codegen.decimals import exact_decimal
from stt_codegen.task import Task

Value = Fraction | tuple[Fraction, ...] | str | None


class Edit(NamedTuple):
    """One key of a task file and its new value; None leaves the key out, or the whole entry of a list.

    key: such as "control.period", "prescribed_time", "mission[1].between" or "unsafe[0].timing".
    """

    key: str
    value: Value


@dataclass(frozen=True)
class Change:
    """Edits that are made together. remark: what they are, where the keys do not say it."""

    edits: tuple[Edit, ...]
    remark: str = ""

    @property
    def text(self) -> str:
        """The edits as a task file has them: "with control.period = 0.02 and without tube.prefer"."""
        stated = " and ".join(f"{key} = {written(value)}" for key, value in self.edits if value is not None)
        left_out = " and ".join(key for key, value in self.edits if value is None)
        parts = [f"{word} {keys}" for word, keys in (("with", stated), ("without", left_out)) if keys]
        return " and ".join(parts) + (f" ({self.remark})" if self.remark else "")

    def and_also(self, change: Change) -> Change:
        """Return both changes as one."""
        return Change((*self.edits, *change.edits), "; ".join(filter(None, (self.remark, change.remark))))

    def is_part_of(self, change: Change, task: Task) -> bool:
        """Return whether another change of the task makes each of these edits, and none of them by less."""
        edits = dict(change.edits)
        return all(key in edits and _is_up_to(value, edits[key], _stated_value(task, key)) for key, value in self.edits)

    def of(self, task: Task) -> Task:
        """Return the changed task. Raises `BadInput` where its fields no longer fit together."""
        return task.changed(**_changed_fields(task, self.edits))


def written(value: Value) -> str:
    """Write a value as TOML does."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(exact_decimal, value))}]"
    return f'"{value}"' if isinstance(value, str) else exact_decimal(value or Fraction(0))


def _is_up_to(value: Value, stronger: Value, stated: Any) -> bool:
    """Return whether a value lies between the stated one and a stronger one, of lists each entry; words are equal or not."""
    if value == stronger:
        return True
    if isinstance(value, tuple) and isinstance(stronger, tuple):
        entries = stated if isinstance(stated, tuple) else (stated,) * len(value)
        return all(map(_is_up_to, value, stronger, entries))
    if isinstance(value, Fraction) and isinstance(stronger, Fraction) and isinstance(stated, Fraction):
        return stated <= value <= stronger or stated >= value >= stronger
    return False


def _stated_value(task: Task, key: str) -> Any:
    """Return what the task file has for a key such as "unsafe[0].timing"; None where it has nothing."""
    value: Any = task.as_stated
    for name in key.split("."):
        field, _, index = name.rstrip("]").partition("[")
        value = getattr(value, field)[int(index)] if index else getattr(value, field)
    return value


def _changed_fields(task: Task, edits: Sequence[Edit]) -> dict[str, Any]:
    """Return the arguments of `Task.changed` for the edits."""
    fields: dict[str, Any] = {}
    for key, value in edits:
        table, _, field = key.partition(".")
        name, _, index = table.rstrip("]").partition("[")
        if index:
            entries = fields.setdefault(name, [_fields_of(entry) for entry in getattr(task.as_stated, name)])
            entries[int(index)] = None if not field else {**entries[int(index)], field: value}
        elif field:
            fields.setdefault(name, {})[field] = value
        else:
            fields[name] = value
    return {name: _without_removed(value) if isinstance(value, list) else value for name, value in fields.items()}


def _fields_of(entry: Any) -> dict[str, Any]:
    """Return the fields of a list's entry that the task file sets."""
    return {name: getattr(entry, name) for name in entry.model_fields_set}


def _without_removed(entries: Sequence[Mapping[str, Any] | None]) -> list[dict[str, Any]] | None:
    """Return the entries that are left, without keys of no value; None where no entry is left."""
    left = [{name: value for name, value in entry.items() if value is not None} for entry in entries if entry is not None]
    return left or None
