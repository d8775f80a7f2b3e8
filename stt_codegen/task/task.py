"""`Task`: the tables of a task, checked, wherever they come from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

from pydantic import BaseModel, ModelWrapValidatorHandler, PrivateAttr, ValidationError, model_validator

from stt_codegen.errors import BadInput
from stt_codegen.task.checks import first_problem
from stt_codegen.task.refusals import explain
from stt_codegen.task.schema import TaskTables


class Task(TaskTables):
    """A reach-avoid-stay task with prescribed time (Definition 2.1), and the options of its controller.

    Made from a file by `load_task`, or in Python from the same names: numbers may be floats (each means its shortest decimal),
    ints, fractions that are decimals, decimals as text, NumPy numbers; vectors lists, tuples or arrays of one axis; tables
    dictionaries. docs/task.md says what each means, `Task.model_json_schema()` its range. Raises `BadInput`, with the field and
    what would be right, for whatever a file would be refused for.
    """

    _digest: str = PrivateAttr(default="")
    _written: str | None = PrivateAttr(default=None)

    @model_validator(mode="wrap")
    @classmethod
    def _checked(cls, data: Any, handler: ModelWrapValidatorHandler[Task]) -> Task:
        """`BadInput` is no ValueError, so pydantic lets it through."""
        try:
            task = handler(data)
        except ValidationError as error:
            raise BadInput(explain(error, TaskTables)) from None
        problem = first_problem(task)
        if problem:
            raise BadInput(problem)
        task._digest = document_digest(task)
        return task

    @property
    def digest(self) -> str:
        """SHA-256 of the file's data (comments, spacing and the order of keys do not count)."""
        return self._digest

    @property
    def written(self) -> str | None:
        """The task as the text of a file with the sets of its map spelled out; None for a task without a map."""
        return self._written

    def with_options(self, design: str | None = None, scalar: str | None = None, rust: bool = False) -> Task:
        """The same task with the options that the command line may override. Raises `BadInput` where its other options are not
        for that design."""
        tube = self.tube.model_copy(update={"design": design}) if design else self.tube
        chosen = ({"scalar": scalar} if scalar else {}) | ({"rust": True} if rust else {})
        emit = self.emit.model_copy(update=chosen) if chosen else self.emit
        changed = self.model_copy(update={"tube": tube, "emit": emit})
        problem = first_problem(changed) if design or rust or scalar == "fixed" else None
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
        given = {name: getattr(self, name) for name in self.model_fields_set}
        for name, value in values.items():
            table = given.get(name)
            if isinstance(value, dict) and isinstance(table, BaseModel):
                fields = {**{field: getattr(table, field) for field in table.model_fields_set}, **value}
                given[name] = {field: v for field, v in fields.items() if v is not None}
            else:
                given[name] = value
        return Task(**{name: value for name, value in given.items() if value is not None})


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
