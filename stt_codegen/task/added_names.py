"""Public names that templates add to what the Program has, and when a task owes them: one row for each name.

A language that does not have a function that the task owes refuses the task (`lacks` of its `TargetLanguage`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from stt_codegen.task.schema import TaskTables


@dataclass(frozen=True)
class AddedName:
    """A public name that a template adds. option: what of a task asks for it; is_constant: else it is a function."""

    option: str
    applies_to: Callable[[TaskTables], bool]
    is_constant: bool = False


ADDED_NAMES: Mapping[str, AddedName] = {
    "phase": AddedName("mission", lambda task: bool(task.mission)),
    "wrap": AddedName("repeat", lambda task: task.repeat),
    "wrap_tick": AddedName("repeat", lambda task: task.repeat and task.emit.tick_period is not None),
    "unwrap": AddedName("periodic", lambda task: bool(task.periodic)),
    "guard": AddedName("control.outside", lambda task: task.control.outside != "return"),
    "PERIOD_PROVED": AddedName("control.period", lambda task: task.control.period is not None, is_constant=True),
}
