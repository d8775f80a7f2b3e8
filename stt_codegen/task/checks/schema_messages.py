"""The messages for fields that pydantic refuses: unknown and missing keys, wrong types, numbers out of range."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from stt_codegen.task.keys import TOP, TableOfKeys, all_tables, similar_key, tables_in
from stt_codegen.task.sets import SET_TABLES, fields_of_shape
from stt_codegen.task.values import ADD_IT, MAX_LABEL, MAX_NAME, NEEDS_NUMBER, kind_of

NEEDS_NUMBER_OR_LIST = "a number is needed, or a list with one for each dimension"
FIELDS_BY_SHAPE = [fields_of_shape(table) for table in SET_TABLES]
SHAPE_FIELDS = {field for fields in FIELDS_BY_SHAPE for field in fields}
*_first, _last = (" and ".join(fields) for fields in FIELDS_BY_SHAPE)
SHAPES = f"{', '.join(_first)}, or {_last}"

ONE_SIGN_REMEDY = (
    "the law is odd, so u must reach as far one way as the other. For an input of one sign write u = u_0 + v, add g u_0 to f in "
    '[plant], and limit v by u_max = min(u_0 - lower, upper - u_0) (docs/drive.md, "Inputs of one sign")'
)


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the message for the first field that pydantic refuses. model: the table that was validated."""
    errors = error.errors(include_url=False)
    first = errors[0]
    if first["type"] == "missing":  # perhaps its key is misspelt, or stands elsewhere; then the unknown key is the one to report
        table, missing = first["loc"][:-1], str(first["loc"][-1])
        unknown_keys = [e for e in errors if e["type"] == "extra_forbidden" and not _is_of_shape(e["loc"])]
        misspelt = (e for e in unknown_keys if e["loc"][:-1] == table and _is_similar(e["loc"], model, missing))
        misplaced = (e for e in unknown_keys if e["loc"][-1] == missing)
        first = next((e for keys in (misspelt, misplaced, unknown_keys) for e in keys), first)
    field = _field(first["loc"])
    if first["type"] == "missing":
        return _missing_message(field, first)
    if first["type"] == "extra_forbidden":
        return _unknown_key_message(field, first, model)
    return f"{field}: {_value_message(field, first)}"


def _is_of_shape(location: tuple[int | str, ...]) -> bool:
    """Return whether a field is one of those that give an unsafe set its shape."""
    return location[0] == "unsafe" and location[-1] in SHAPE_FIELDS


def _is_similar(location: tuple[int | str, ...], model: type[BaseModel], missing: str) -> bool:
    """Return whether the unknown key at a location may be the misspelt missing one of its table."""
    similar = similar_key(str(location[-1]), _known_keys(location, model))
    return similar is not None and similar.table is None and similar.key == missing


def _missing_message(field: str, error: ErrorDetails) -> str:
    """Return the message for a missing field; where it is one of a set's shape, for the shape."""
    is_of_shape = _is_of_shape(error["loc"])
    keys = SHAPE_FIELDS & set(error["input"]) if is_of_shape else set()
    if is_of_shape and not any(keys & set(fields) and keys <= set(fields) for fields in FIELDS_BY_SHAPE):
        problem = f"says two shapes ({', '.join(sorted(keys))})" if keys else "says no shape"
        return f"{field.rpartition('.')[0]}: {problem}; give one of {SHAPES}"
    return f"{field}: is missing; {ADD_IT}"


def _unknown_key_message(field: str, error: ErrorDetails, model: type[BaseModel]) -> str:
    """Return the message for a key that its table does not have, or for a set with the fields of two shapes."""
    location = error["loc"]
    if _is_of_shape(location):
        return f"{field}: stands beside fields of another shape; a set has one, {SHAPES}"
    if location == ("control", "u_min"):
        return f"{field}: unknown key; {ONE_SIGN_REMEDY}"
    names = [part for part in location[:-1] if isinstance(part, str) and not part.startswith("<")]
    table = TableOfKeys(".".join(names), any(isinstance(part, int) for part in location), tuple(_known_keys(location, model)))
    key = str(location[-1])
    return describe_unknown_key(field, key, table, error["input"])


def describe_unknown_key(field: str, key: str, table: TableOfKeys, value: object) -> str:
    """Return the message for a key that its table does not have: where it belongs, a similar key, or the known keys.

    field: the key as messages write it; table: where it stands, with the keys known there; value: what the key has.
    """
    similar = similar_key(key, table.keys)
    homes = [home for home in all_tables() if key in home.keys]
    if homes and _is_table(value):
        return f"{field}: stands {table.position}; write {_either([home.heading_of(key) for home in homes])}"
    if homes:
        destinations = [home.heading if home.heading == TOP else f"to {home.heading}" for home in homes]
        is_near = similar is not None and similar.table is None
        return f"{field}: stands {table.position}; move it {_either(destinations)}" + (
            f", or did you mean {similar.key!r}?" if similar and is_near else ""
        )
    if similar is None:
        return f"{field}: unknown key; known keys here are {', '.join(table.keys)}"
    home = "" if similar.table is None else f", {similar.table.position}"
    return f"{field}: unknown key; did you mean {similar.key!r}{home}?"


def _either(names: Sequence[str]) -> str:
    """Join names by commas and "or"."""
    return " or ".join([*([", ".join(names[:-1])] if names[:-1] else []), names[-1]])


def _is_table(value: object) -> bool:
    """Return whether a value is a table of TOML, or a list of them."""
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value))


def _value_message(field: str, error: ErrorDetails) -> str:
    """Return the message for a value of a wrong type or out of range."""
    kind, value, context = error["type"], error.get("input"), error.get("ctx", {})
    if error["loc"][:2] == ("control", "u_max") and (ends := _two_ends(value)):
        low, high = ends
        example = (
            f"here u_0 = {(low + high) / 2:g} and u_max = {(high - low) / 2:g}" if low < high else "give the lower one first"
        )
        return f"is [{low:g}, {high:g}]; one number is needed: {ONE_SIGN_REMEDY}; {example}"
    if kind == "value_error":
        message = str(context["error"])
        return message.replace(NEEDS_NUMBER, NEEDS_NUMBER_OR_LIST) if error["loc"][-1] == "<number>" else message
    if kind in ("string_pattern_mismatch", "string_too_long"):
        if error["loc"][0] == "unsafe":
            allowed = "letters, digits, spaces or . _ ( ) # + -"
            return f"{_quoted(value)} is no name; use {allowed}, at most {MAX_LABEL} characters, or leave it out"
        return f"{_quoted(value)} is no name; use a letter, then letters, digits or _, at most {MAX_NAME} characters"
    if kind in ("greater_than_equal", "less_than_equal"):
        bound = context.get("ge", context.get("le"))
        return f"is {value}; it must be {'at least' if kind == 'greater_than_equal' else 'at most'} {bound}"
    needed = {
        "literal_error": f"use one of {context.get('expected')}",
        "model_type": f"a table [{field}] is needed",
        "model_attributes_type": f"a table [{field}] is needed",
        "tuple_type": f"a list of tables [[{field}]] is needed",
        "bool_type": "use true or false, without quotes",
        "string_type": "text in quotes is needed",
        "union_tag_invalid": NEEDS_NUMBER_OR_LIST,  # "auto" where no rule chooses the value
    }
    return f"is {kind_of(value)}; {needed.get(kind, error['msg'])}"


def _two_ends(value: object) -> tuple[float, float] | None:
    """Return the ends of a range of u that stands where one number is needed; None where the value is no pair of numbers."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        return None
    if any(isinstance(v, bool) or not isinstance(v, int | float | Decimal | Fraction) for v in value):
        return None
    try:
        return float(value[0]), float(value[1])
    except OverflowError:
        return None


def _quoted(value: object) -> str:
    """Return a value in quotes, a long one cut."""
    text = str(value)
    return repr(text) if len(text) <= MAX_NAME else f"{text[:MAX_NAME]!r}.. ({len(text)} characters)"


def _field(location: tuple[int | str, ...]) -> str:
    """Return the name of a field as messages write it, tables[index].key."""
    text = ""
    for part in location:
        if isinstance(part, str) and part.startswith("<"):  # the tag of the type as which it was read, no key
            continue
        shown = part if isinstance(part, int) or part.isidentifier() else f"{part!r:.40}"
        text += f"[{part}]" if isinstance(part, int) else f".{shown}" if text else str(shown)
    return text or "the file"


def _known_keys(location: tuple[int | str, ...], model: type[BaseModel]) -> list[str]:
    """Return the keys of the table that a field of the model is in."""
    tables: list[type[BaseModel]] = []
    for part in location[:-1]:
        field = model.model_fields.get(str(part))
        if field is not None:
            tables = list(tables_in(field.annotation))
        named = [table for table in tables if f"<{table.__name__}>" == part]  # the one of several as which it was read
        model = next(iter(named or tables), model) if field is not None or named else model
    return list(model.model_fields)
