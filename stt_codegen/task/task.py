"""`Task`: the tables of a task, checked, wherever they come from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

from pydantic import BaseModel, ModelWrapValidatorHandler, PrivateAttr, ValidationError, model_validator

from stt_codegen.decimals import exact_decimal
from stt_codegen.errors import BadInput
from stt_codegen.task.checks import explain, first_problem, structure_problem
from stt_codegen.task.closed_axes import ClosedAxis, Image, turns_problem
from stt_codegen.task.closed_axes import spelled_out as with_turns_spelled_out
from stt_codegen.task.map import FloorPlan, expand_outline, name_walls
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.values import ADD_IT


class Task(TaskTables):
    """A reach-avoid-stay task with prescribed time (Definition 2.1), and the options of its controller.

    Made from a file by `load_task`, or in Python from the same names: numbers may be floats (each means its shortest decimal),
    ints, fractions that are decimals, decimals as text, NumPy numbers; vectors lists, tuples or arrays of one axis; tables
    dictionaries. docs/task.md says what each means, `Task.model_json_schema()` its range. Raises `BadInput`, with the field and
    what would be right, for whatever a file would be refused for.
    """

    _digest: str = PrivateAttr(default="")
    _written: str | None = PrivateAttr(default=None)
    _notes: tuple[str, ...] = PrivateAttr(default=())
    _spelled_from: tuple[str, ...] = PrivateAttr(default=())
    _room: FloorPlan | None = PrivateAttr(default=None)
    _with_outline: TaskTables | None = PrivateAttr(default=None)
    _stated: Task | None = PrivateAttr(default=None)
    _closed: tuple[ClosedAxis, ...] = PrivateAttr(default=())
    _images: tuple[Image, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _checked(cls, data: Any, handler: ModelWrapValidatorHandler[Task]) -> Task:
        """`BadInput` is no ValueError, so pydantic lets it through."""
        stated = data._stated if isinstance(data, Task) else None
        try:
            task = handler(data if stated is None else stated)
        except ValidationError as error:
            raise BadInput(explain(error, TaskTables)) from None
        if isinstance(data, Task) and data.floor_plan is not None:
            task._written, task._spelled_from = data._written, data._spelled_from
            task._room, task._with_outline = data._room, data._with_outline
        space = task.state_space
        if space.outline is not None or space.holes is not None:
            task.__setstate__(cls._of_room(task.model_copy()).__getstate__())  # pydantic wants the same object from a validator
            return task
        missing = next((field for field, vector in space.vectors() if not vector), None)
        if missing is not None:
            raise BadInput(f"state_space.{missing}: is missing; {ADD_IT}")
        task._digest = document_digest(task)
        task._settle()
        return task

    def _settle(self) -> None:
        """Spell out turns where axes close, in this object, and refuse what no schema can see."""
        problem = structure_problem(self) if self.periodic else None
        problem = problem or (turns_problem(self) if self.periodic else None)
        if self.periodic and not problem:
            stated = self.model_copy()
            changes, self._closed, self._images = with_turns_spelled_out(stated)
            self._stated = stated
            self.__dict__.update(changes)
        problem = problem or first_problem(self)
        if problem:
            raise BadInput(problem)

    @classmethod
    def _of_room(cls, task: TaskTables) -> Task:
        """The task with the sets that its outline leaves of a box spelled out."""
        from stt_codegen.task.map import to_toml

        fields, room = expand_outline(task)
        try:
            spelled = cls(**fields)
        except BadInput as error:
            raise BadInput(name_walls(str(error), len(task.unsafe), room)) from None
        spelled._room, spelled._with_outline = room, task
        spelled._written, spelled._spelled_from = to_toml(document_of(spelled.as_stated)), ("outline",)
        return spelled

    @property
    def floor_plan(self) -> FloorPlan | None:
        """The outline, the holes and the names of the unsafe sets that it was turned into; None of a task without an outline."""
        return self._room

    @property
    def digest(self) -> str:
        """SHA-256 of the file's data (comments, spacing and the order of keys do not count)."""
        return self._digest

    @property
    def expanded_text(self) -> str | None:
        """The task as the text of a file with the sets of its map or outline spelled out; None for a task without these."""
        return self._written

    @property
    def map_notes(self) -> tuple[str, ...]:
        """What you should know of the task's maps: cells whose grey only the thresholds make free."""
        return self._notes

    @property
    def expanded_keys(self) -> tuple[str, ...]:
        """What was turned into unsafe sets there: "map", "outline", both or neither."""
        return self._spelled_from

    @property
    def as_stated(self) -> Task:
        """The task as the file states it, before turns of axes that close were spelled out; without such axes this one."""
        return self if self._stated is None else self._stated

    @property
    def closed_axes(self) -> tuple[ClosedAxis, ...]:
        """The axes that close, and what was chosen in them."""
        return self._closed

    def unsafe_field(self, j: int) -> str:
        """Where the file has unsafe set j, or the set that it is an image of."""
        return super().unsafe_field(self._images[j].source if j < len(self._images) else j)

    def with_options(self, design: str | None = None, scalar: str | None = None, language: str | None = None) -> Task:
        """The same task with the options that the command line may override; language: one that it is printed in too.
        Raises `BadInput` where its other options are not for that design."""
        stated = self.as_stated
        tube = stated.tube.model_copy(update={"design": design}) if design else stated.tube
        chosen = ({"scalar": scalar} if scalar else {}) | ({language: True} if language else {})
        emit = stated.emit.model_copy(update=chosen) if chosen else stated.emit
        changed = stated.model_copy(update={"tube": tube, "emit": emit})
        if self.periodic:  # the scalar decides what unwrapping is wrong by
            changed._written, changed._notes, changed._spelled_from = self._written, self._notes, self._spelled_from
            changed._room, changed._with_outline = self._room, self._with_outline
            changed._settle()
            return changed
        problem = first_problem(changed) if design or language or scalar == "fixed" else None
        if problem and self._room is not None:
            problem = name_walls(problem, len(stated.unsafe) - len(self._room.walls), self._room)
        if problem:
            raise BadInput(problem)
        return changed

    def with_gain(self, gain: Sequence[Fraction]) -> Task:
        """The same task, of the same digest, with a gain that was chosen for it: by component, or one number where all agree."""
        given = gain[0] if len(set(gain)) == 1 else tuple(gain)
        return self.model_copy(update={"control": self.control.model_copy(update={"gain": given})})

    def changed(self, **values: Any) -> Task:
        """The same task with other values for some fields, checked like a new one. A dictionary changes those fields of a table
        that it names and leaves the others; None takes a field away."""
        source = self._with_outline or self.as_stated
        given = {name: getattr(source, name) for name in source.model_fields_set}
        for name, value in values.items():
            table = given.get(name)
            if isinstance(value, dict) and isinstance(table, BaseModel):
                fields = {**{field: getattr(table, field) for field in table.model_fields_set}, **value}
                given[name] = {field: v for field, v in fields.items() if v is not None}
            else:
                given[name] = value
        return Task(**{name: value for name, value in given.items() if value is not None})


def document_of(task: TaskTables) -> dict[str, Any]:
    """The data of a file that says the same as the tables, in the order of the schema. Only what was given counts."""

    def plain(value: Any) -> Any:
        if isinstance(value, BaseModel):
            fields = [name for name in type(value).model_fields if name in value.model_fields_set]
            return {name: plain(getattr(value, name)) for name in fields if getattr(value, name) is not None}
        if isinstance(value, tuple):
            return [plain(v) for v in value]
        if isinstance(value, dict):
            return {name: plain(entry) for name, entry in value.items()}
        return Decimal(exact_decimal(value)) if isinstance(value, Fraction) else value

    document: dict[str, Any] = plain(task)
    return document


def document_digest(document: object) -> str:
    """SHA-256 of a task's data, of a parsed file or of the tables made of it: JSON with sorted keys, every number as a reduced
    fraction "p/q". Only what was given counts, so a task made in Python has the digest of a file that says the same."""

    def plain(value: object) -> object:
        if isinstance(value, BaseModel):
            given = {name: getattr(value, name) for name in value.model_fields_set}
            return plain({name: v for name, v in given.items() if v is not None})
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items()}
        if isinstance(value, list | tuple):
            return [plain(v) for v in value]
        if isinstance(value, bool | str):
            return value
        assert isinstance(value, int | Decimal | Fraction)
        number = Fraction(value)
        return f"{number.numerator}/{number.denominator}"

    text = json.dumps(plain(document), sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()
