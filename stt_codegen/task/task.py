"""`Task`: the checked tables of a task, from a file or from Python.

An outline becomes unsafe sets (map/floor_plans.py) and the turns of closed axes become images of sets (closed_axes.py); every
later stage reads the result. load.py and users of the Python interface make tasks.
Long because a task is one class, with what follows from its fields.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any, get_args

from pydantic import BaseModel, ModelWrapValidatorHandler, PrivateAttr, ValidationError, model_validator

from stt_codegen.arrays import one_if_equal
from stt_codegen.decimals import exact_decimal
from stt_codegen.design_kinds import DesignKind
from stt_codegen.errors import BadInput
from stt_codegen.task.checks import explain, first_problem, structure_problem
from stt_codegen.task.closed_axes import ClosedAxis, SetImage, expand_turns, turns_problem
from stt_codegen.task.input_norm import uses_norm_up
from stt_codegen.task.map import FloorPlan, expand_outline, name_walls
from stt_codegen.task.schema import ControlOptions, PlantBounds, Scalar, TaskTables
from stt_codegen.task.sets import Unsafe
from stt_codegen.task.values import ADD_IT


class Task(TaskTables):
    """A reach-avoid-stay task with prescribed time (Definition 2.1), and the options of its controller.

    `load_task` makes it from a file. In Python, use the same names: numbers may be floats (each means its shortest decimal),
    ints, fractions that are decimals, decimals as text, or NumPy numbers; vectors are lists, tuples or arrays of one axis; tables
    are dictionaries. docs/task.md explains each key, `Task.model_json_schema()` gives its range. Raises `BadInput` for whatever
    a file would be refused for, with the field and the remedy.
    """

    _digest: str = PrivateAttr(default="")
    _expanded_text: str | None = PrivateAttr(default=None)
    _map_notes: tuple[str, ...] = PrivateAttr(default=())
    _expanded_keys: tuple[str, ...] = PrivateAttr(default=())
    _floor_plan: FloorPlan | None = PrivateAttr(default=None)
    _with_outline: TaskTables | None = PrivateAttr(default=None)
    _as_stated: Task | None = PrivateAttr(default=None)
    _before_choice: tuple[ControlOptions, PlantBounds] | None = PrivateAttr(default=None)
    _closed_axes: tuple[ClosedAxis, ...] = PrivateAttr(default=())
    _overridden_keys: frozenset[str] = PrivateAttr(default=frozenset())
    _images: tuple[SetImage, ...] = PrivateAttr(default=())

    @model_validator(mode="wrap")
    @classmethod
    def _validated(cls, data: Any, handler: ModelWrapValidatorHandler[Task]) -> Task:
        """Return the checked task. `BadInput` is no `ValueError`, so it passes through pydantic."""
        stated = data._as_stated if isinstance(data, Task) else None
        try:
            task = handler(data if stated is None else stated)
        except ValidationError as error:
            raise BadInput(explain(error, TaskTables)) from None
        if isinstance(data, Task) and data.floor_plan is not None:
            task._expanded_text, task._expanded_keys = data._expanded_text, data._expanded_keys
            task._floor_plan, task._with_outline = data._floor_plan, data._with_outline
        space = task.state_space
        if space.outline is not None or space.holes is not None:
            task.__setstate__(
                cls._with_walls(task.model_copy()).__getstate__()
            )  # pydantic wants the same object from a validator
            return task
        missing = next((field for field, vector in space.vectors() if not vector), None)
        if missing is not None:
            raise BadInput(f"state_space.{missing}: is missing; {ADD_IT}")
        task._digest = document_digest(task)
        task._expand_and_check()
        return task

    def _expand_and_check(self) -> None:
        """Expand the turns of closed axes, in this object. Raise `BadInput` where its fields do not fit together."""
        problem = structure_problem(self) if self.periodic else None
        problem = problem or (turns_problem(self) if self.periodic else None)
        if self.periodic and not problem:
            stated = self.model_copy()
            changes, self._closed_axes, self._images = expand_turns(stated)
            self._as_stated = stated
            self.__dict__.update(changes)
        problem = problem or first_problem(self)
        if problem:
            raise BadInput(problem)

    @classmethod
    def _with_walls(cls, task: TaskTables) -> Task:
        """Return the task with a box and unsafe sets in place of its outline."""
        from stt_codegen.task.map import to_toml

        fields, floor_plan = expand_outline(task)
        try:
            expanded = cls(**fields)
        except BadInput as error:
            raise BadInput(name_walls(str(error), len(task.unsafe), floor_plan)) from None
        expanded._floor_plan, expanded._with_outline = floor_plan, task
        expanded._expanded_text, expanded._expanded_keys = to_toml(document_of(expanded.as_stated)), ("outline",)
        return expanded

    @property
    def floor_plan(self) -> FloorPlan | None:
        """The outline, its holes, and the names of the unsafe sets in their place; None for a task without an outline."""
        return self._floor_plan

    @property
    def digest(self) -> str:
        """SHA-256 of the file's data (comments, spacing and the order of keys do not count)."""
        return self._digest

    @property
    def expanded_text(self) -> str | None:
        """The text of a task file that has the sets of the map or outline in its place; None for a task without these."""
        return self._expanded_text

    @property
    def map_notes(self) -> tuple[str, ...]:
        """Notes on the task's maps: which cells have a grey that only the thresholds make free."""
        return self._map_notes

    @property
    def expanded_keys(self) -> tuple[str, ...]:
        """The keys in whose place the expanded text has unsafe sets: "map", "outline", both or neither."""
        return self._expanded_keys

    @property
    def as_stated(self) -> Task:
        """The task before the turns of closed axes were expanded; without such axes this task."""
        return self if self._as_stated is None else self._as_stated

    @property
    def closed_axes(self) -> tuple[ClosedAxis, ...]:
        """The axes that close, each with the turns chosen in it."""
        return self._closed_axes

    def stated_set(self, j: int) -> Unsafe:
        """Return the table of unsafe set j as the file has it, or of the set whose image it is."""
        return self.as_stated.unsafe[self._images[j].source if j < len(self._images) else j]

    def unsafe_field(self, j: int) -> str:
        """Return the field of the file that has unsafe set j, or the set whose image it is."""
        return super().unsafe_field(self._images[j].source if j < len(self._images) else j)

    def with_options(self, design: str | None = None, scalar: str | None = None, language: str | None = None) -> Task:
        """Return the task with the options that the command line may override. language: one more language to print.

        Raises `BadInput` for an unknown design or scalar, and where the other options do not fit to that design."""
        for field, value, names in (("tube.design", design, get_args(DesignKind)), ("emit.scalar", scalar, get_args(Scalar))):
            if value is not None and value not in names:
                raise BadInput(f"{field}: is {value!r:.40}; use one of {', '.join(names)}")
        stated = self.as_stated
        tube = stated.tube.model_copy(update={"design": design}) if design else stated.tube
        overrides = ({"scalar": scalar} if scalar else {}) | ({language: True} if language else {})
        emit = stated.emit.model_copy(update=overrides) if overrides else stated.emit
        changed = stated.model_copy(update={"tube": tube, "emit": emit})
        changed._overridden_keys = frozenset(({"tube.design"} if design else set()) | ({"emit.scalar"} if scalar else set()))
        if self._with_outline is not None:  # what `changed` starts from
            changed._with_outline = self._with_outline.model_copy(update={"tube": tube, "emit": emit})
        if self.periodic:  # the error of unwrapping depends on the scalar
            changed._expanded_text, changed._map_notes, changed._expanded_keys = (
                self._expanded_text,
                self._map_notes,
                self._expanded_keys,
            )
            changed._floor_plan = self._floor_plan
            changed._expand_and_check()
            return changed
        problem = first_problem(changed) if design or language or scalar == "fixed" else None
        if problem and self._floor_plan is not None:
            problem = name_walls(problem, len(stated.unsafe) - len(self._floor_plan.walls), self._floor_plan)
        if problem:
            raise BadInput(problem)
        return changed

    @property
    def overridden_keys(self) -> frozenset[str]:
        """The keys of the task file that options of the command line stand for: changing them in the file changes nothing."""
        return self._overridden_keys

    def with_gain(self, gain: Sequence[Fraction]) -> Task:
        """Return the task, with the same digest, with this gain by component in place of its own."""
        value = one_if_equal(gain)
        with_gain = self.model_copy(update={"control": self.control.model_copy(update={"gain": value})})
        if self._before_choice is not None:
            control, plant = self._before_choice
            with_gain._before_choice = (control.model_copy(update={"gain": value}), plant)
        return with_gain

    def with_choices(
        self,
        *,
        plant: PlantBounds | None = None,
        u_max: Sequence[Fraction] | None = None,
        gain: Sequence[Fraction] | None = None,
    ) -> Task:
        """Return the task, with the same digest, with what was chosen for its tube in place of what it leaves open.

        plant: the bounds that are assumed. u_max, gain: by component. `changed` starts again from what the task states.
        """
        values = {name: one_if_equal(v) for name, v in (("u_max", u_max), ("gain", gain)) if v is not None}
        tables: dict[str, Any] = {"control": self.control.model_copy(update=values)} | ({"plant": plant} if plant else {})
        chosen = self.model_copy(update=tables)
        chosen._before_choice = self._before_choice or (self.control, self.plant)
        return chosen

    @property
    def assumes_plant(self) -> bool:
        """Whether the task has a period and says nothing of its plant of order 1, so that bounds are assumed."""
        plant = self._as_stated.plant if self._as_stated is not None else self._stated_tables[1]
        return self.control.period is not None and self.order == 1 and not plant.is_stated and not plant.exact

    @property
    def has_chosen_limit(self) -> bool:
        """Whether u_max was chosen for the tube."""
        return self.u_max is not None and self.control.u_max != self._stated_tables[0].u_max

    @property
    def stated_u_max(self) -> tuple[Fraction, ...] | None:
        """The numbers of control.u_max by component, whatever was chosen within them; None where it has none."""
        return self._limits_in(self._stated_tables[0])

    @property
    def limit_key(self) -> str:
        """The key of the task file to raise where u is too small: that of its norm, where the chosen limits use the norm up."""
        if self.control.u_norm is None or not self.has_chosen_limit:
            return "control.u_max"
        return "control.u_norm" if uses_norm_up(self.u_max or (), self.control.u_norm) else "control.u_max"

    @property
    def has_gentle_gain(self) -> bool:
        """Whether the gain was chosen for the tube as the gentlest with a reserve."""
        stated, has_gain = self._stated_tables[0].gain, not self.has_automatic_gain
        return has_gain and self.control.period is not None and stated in (None, "auto")

    @property
    def has_tight_gain(self) -> bool:
        """Whether the gain was chosen for the tube as the one that keeps |e| smallest."""
        return not self.has_automatic_gain and self._stated_tables[0].gain == "tight"

    @property
    def _stated_tables(self) -> tuple[ControlOptions, PlantBounds]:
        """The tables [control] and [plant] as they were before anything was chosen."""
        return self._before_choice or (self.control, self.plant)

    def changed(self, **values: Any) -> Task:
        """Return the task with other values for some fields, checked like a new task.

        A dictionary changes the fields of a table that it names and leaves the others; None removes a field. What was chosen for
        a tube is open again."""
        source = self._with_outline or self.as_stated
        fields = {name: getattr(source, name) for name in source.model_fields_set}
        if source is self and self._before_choice is not None:
            control, plant = self._before_choice
            for name, stated_table in (("control", control), ("plant", plant)):
                fields.pop(name, None)
                fields.update({name: stated_table} if stated_table.model_fields_set else {})
        for name, value in values.items():
            table = fields.get(name)
            if isinstance(value, dict):
                present = (
                    {field: getattr(table, field) for field in table.model_fields_set} if isinstance(table, BaseModel) else {}
                )
                fields[name] = {field: v for field, v in {**present, **value}.items() if v is not None}
            else:
                fields[name] = value
        return Task(**{name: value for name, value in fields.items() if value is not None})


def document_of(task: TaskTables) -> dict[str, Any]:
    """Return the data of a task file with these tables, in the order of the schema; fields that were not set are left out."""

    def plain(value: Any) -> Any:
        """Return a value as TOML has it."""
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
    """Return the SHA-256 of a task's data: of JSON with sorted keys and every number as a reduced fraction "p/q".

    document: a parsed file, or the tables made of it. Fields that were not set are left out, so a task made in Python has the
    digest of a file with the same fields.
    """

    def plain(value: object) -> object:
        """Return a value as JSON has it."""
        if isinstance(value, BaseModel):
            fields = {name: getattr(value, name) for name in value.model_fields_set}
            return plain({name: v for name, v in fields.items() if v is not None})
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
