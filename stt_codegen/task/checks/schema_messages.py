"""What pydantic finds wrong with a task, in this project's words."""

from __future__ import annotations

import difflib
from typing import Any

from pydantic import BaseModel, ValidationError

from stt_codegen.task.keys import tables_in
from stt_codegen.task.sets import SET_TABLES, fields_of_shape
from stt_codegen.task.values import ADD_IT, MAX_LABEL, MAX_NAME, kind_of

_FIELDS = [fields_of_shape(table) for table in SET_TABLES]
FORMS = [set(fields) for fields in _FIELDS]
SHAPE_FIELDS = set().union(*FORMS)
*_first, _last = (" and ".join(fields) for fields in _FIELDS)
SHAPES = f"{', '.join(_first)}, or {_last}"


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """The first of pydantic's findings about such a table, in this project's words."""
    found = error.errors(include_url=False)
    first = found[0]
    if first["type"] == "missing":  # or misspelt
        table, missing = first["loc"][:-1], str(first["loc"][-1])
        unknown = (e for e in found if e["type"] == "extra_forbidden" and e["loc"][:-1] == table)
        first = next((e for e in unknown if missing in _close(e["loc"], model)), first)
    where = _field(first["loc"])
    kind = first["type"]
    value = first.get("input")
    if kind == "missing":
        of_a_shape = first["loc"][0] == "unsafe" and first["loc"][-1] in SHAPE_FIELDS
        given = SHAPE_FIELDS & set(first["input"]) if of_a_shape else set()
        if of_a_shape and not any(given & form and given <= form for form in FORMS):
            told = f"says two shapes ({', '.join(sorted(given))})" if given else "says no shape"
            return f"{where.rpartition('.')[0]}: {told}; give one of {SHAPES}"
        return f"{where}: is missing; {ADD_IT}"
    if kind == "extra_forbidden" and first["loc"][0] == "unsafe" and first["loc"][-1] in SHAPE_FIELDS:
        return f"{where}: stands beside fields of another shape; a set has one, {SHAPES}"
    if kind == "extra_forbidden":
        close = _close(first["loc"], model)
        hint = f"did you mean {close[0]!r}?" if close else f"known keys here are {', '.join(_known_keys(first['loc'], model))}"
        home = [] if close else [n for n, f in model.model_fields.items() if str(first["loc"][-1]) in _keys(f.annotation)]
        hint = f"it belongs to [{home[0]}]" if home else hint
        return f"{where}: unknown key; {hint}"
    if kind == "value_error":
        return f"{where}: {first['ctx']['error']}"
    if kind in ("string_pattern_mismatch", "string_too_long"):
        if first["loc"][0] == "unsafe":
            allowed = "letters, digits, spaces or . _ ( ) # + -"
            return f"{where}: {_quoted(value)} is no name; use {allowed}, at most {MAX_LABEL} characters"
        return f"{where}: {_quoted(value)} is no name; use a letter, then letters, digits or _, at most {MAX_NAME} characters"
    if kind == "literal_error":
        return f"{where}: is {kind_of(value)}; use one of {first['ctx']['expected']}"
    if kind in ("greater_than_equal", "less_than_equal"):
        bound = first["ctx"].get("ge", first["ctx"].get("le"))
        return f"{where}: is {value}; it must be {'at least' if kind == 'greater_than_equal' else 'at most'} {bound}"
    if kind in ("model_type", "model_attributes_type"):
        return f"{where}: is {kind_of(value)}; a table is needed"
    if kind == "tuple_type":
        return f"{where}: is {kind_of(value)}; a list of tables [[{where}]] is needed"
    if kind == "bool_type":
        return f"{where}: is {kind_of(value)}; use true or false, without quotes"
    if kind == "string_type":
        return f"{where}: is {kind_of(value)}; text in quotes is needed"
    return f"{where}: is {kind_of(value)}; {first['msg']}"


def _keys(annotation: Any) -> set[str]:
    """The keys of the tables that a field's type is made of."""
    return {name for table in tables_in(annotation) for name in table.model_fields}


def _quoted(value: object) -> str:
    """A value in quotes, the end of a long one left out."""
    text = str(value)
    return repr(text) if len(text) <= MAX_NAME else f"{text[:MAX_NAME]!r}.. ({len(text)} characters)"


def _close(location: tuple[int | str, ...], model: type[BaseModel]) -> list[str]:
    """The known key that an unknown one is like, if there is one."""
    return difflib.get_close_matches(str(location[-1]), _known_keys(location, model), 1)


def _field(location: tuple[int | str, ...]) -> str:
    text = ""
    for part in location:
        if isinstance(part, str) and part.startswith("<"):  # which kind of value it was read as, not a key
            continue
        shown = part if isinstance(part, int) or part.isidentifier() else f"{part!r:.40}"
        text += f"[{part}]" if isinstance(part, int) else f".{shown}" if text else str(shown)
    return text or "the file"


def _known_keys(location: tuple[int | str, ...], model: type[BaseModel]) -> list[str]:
    """The keys of the table that a field of the model is in, from the models themselves."""
    tables: list[type[BaseModel]] = []
    for part in location[:-1]:
        field = model.model_fields.get(str(part))
        if field is not None:
            tables = list(tables_in(field.annotation))
        named = [table for table in tables if f"<{table.__name__}>" == part]  # which of several it was read as
        model = next(iter(named or tables), model) if field is not None or named else model
    return list(model.model_fields)
