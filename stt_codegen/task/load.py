"""From the text of a task file to a `Task`. All refusals are `BadInput` with one message: file, field, what is wrong, what would
be right.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from stt_codegen.errors import BadInput
from stt_codegen.task.checks import first_problem
from stt_codegen.task.schema import (
    MAX_LABEL,
    MAX_NAME,
    AdaptiveOptions,
    Box,
    ControlOptions,
    EmitOptions,
    PlantBounds,
    Task,
    TubeOptions,
    UnsafeSet,
    kind_of,
)


def load_task(path: str | Path) -> Task:
    """Read and check a task file. Raises `BadInput`; never returns a task that section 7 of the contract refuses."""
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); give the path of a task file") from None
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8") from None
    return parse_task(text, str(path))


def parse_task(text: str, source: str = "task") -> Task:
    """As `load_task`, from the text of a task file; `source` names it in messages."""
    # TOML allows CRLF; a lone carriage return or a byte-order mark it does not, and tomllib says so.
    try:
        document = tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        last = text.count("\n") + 1
        where = str(error).replace("at end of document", f"at line {last}, the end of the file")
        raise BadInput(f"{source}: not valid TOML: {where}") from None
    except (ValueError, ArithmeticError, RecursionError):
        raise BadInput(f"{source}: not valid TOML: a number is too long or the nesting is too deep") from None
    try:
        task = Task.model_validate(document)
    except ValidationError as error:
        raise BadInput(f"{source}: {_explain(error)}") from None
    problem = first_problem(task)
    if problem:
        raise BadInput(f"{source}: {problem}")
    named = tuple(s if s.name else s.model_copy(update={"name": f"U{j}"}) for j, s in enumerate(task.unsafe, 1))
    task = task.model_copy(update={"unsafe": named})
    task._digest = document_digest(document)
    return task


def document_digest(document: dict[str, Any]) -> str:
    """SHA-256 of a parsed task file: JSON with sorted keys, every number as a reduced fraction "p/q"."""

    def plain(value: object) -> object:
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items()}
        if isinstance(value, list):
            return [plain(v) for v in value]
        if isinstance(value, bool | str):
            return value
        assert isinstance(value, int | Decimal)
        number = Fraction(value)
        return f"{number.numerator}/{number.denominator}"

    text = json.dumps(plain(document), sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def json_schema() -> str:
    """The JSON Schema of a task file, for editors that complete and check TOML."""
    schema = Task.model_json_schema()
    schema["title"] = "stt_codegen task"
    return json.dumps(schema, indent=2, sort_keys=True) + "\n"


def _explain(error: ValidationError) -> str:
    """The first of pydantic's findings in this project's words."""
    first = error.errors(include_url=False)[0]
    where = _field(first["loc"])
    kind = first["type"]
    value = first.get("input")
    if kind == "missing":
        return f"{where}: is missing; add it (see the task files in tasks/)"
    if kind == "extra_forbidden":
        known = _known_keys(first["loc"])
        close = difflib.get_close_matches(str(first["loc"][-1]), known, 1)
        hint = f"did you mean {close[0]!r}?" if close else f"known keys here are {', '.join(known)}"
        return f"{where}: unknown key; {hint}"
    if kind == "value_error":
        return f"{where}: {first['ctx']['error']}"
    if kind in ("string_pattern_mismatch", "string_too_long"):
        if first["loc"][0] == "unsafe":
            return (
                f"{where}: {value!r:.40} is no name; use letters, digits, spaces or . _ ( ) # + -, at most {MAX_LABEL} characters"
            )
        return f"{where}: {value!r:.40} is no name; use a letter, then letters, digits or _, at most {MAX_NAME} characters"
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


def _field(location: tuple[int | str, ...]) -> str:
    text = ""
    for part in location:
        shown = part if isinstance(part, int) or part.isidentifier() else f"{part!r:.40}"
        text += f"[{part}]" if isinstance(part, int) else f".{shown}" if text else str(shown)
    return text or "the file"


def _known_keys(location: tuple[int | str, ...]) -> list[str]:
    model: type[BaseModel] = Task
    tables: dict[str, type[BaseModel]] = {
        "state_space": Box,
        "initial_set": Box,
        "target_set": Box,
        "unsafe": UnsafeSet,
        "tube": TubeOptions,
        "adaptive": AdaptiveOptions,
        "control": ControlOptions,
        "emit": EmitOptions,
        "plant": PlantBounds,
    }
    for part in location[:-1]:
        model = tables.get(str(part), model)
    return list(model.model_fields)
