"""The table [map] of a task file: an occupancy map, replaced by the unsafe sets that it is when the file is read.

    [map]
    file = "hall.yaml"          # beside the task file
    axes = ["x", "y"]           # the dimensions of the map; absent: those of a task in the plane
    as = "boxes"                # or "polygons": fewer sets, which may take free cells too

What is proved is about the sets. `written` is the task with them spelled out, which a checker can read.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput, about
from stt_codegen.task.occupancy import KINDS, Kind, read_map
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.values import kind_of

KEYS = ("file", "axes", "as")
PLANE = 2


@dataclass(frozen=True)
class MapTable:
    """What [map] says, checked."""

    file: str
    axes: tuple[str, ...] | None
    kind: Kind


def table_of(value: Any) -> MapTable:
    """Raises `BadInput` for what is no such table."""
    if not isinstance(value, dict):
        raise BadInput(f"map: is {kind_of(value)}; a table is needed")
    for name in value:
        if name not in KEYS:
            raise BadInput(f"map.{name}: unknown key; known keys here are {', '.join(KEYS)}")
    if not isinstance(value.get("file"), str):
        told = "is missing" if "file" not in value else f"is {kind_of(value['file'])}"
        raise BadInput(f"map.file: {told}; give the path of the map's .yaml, from the task file's folder")
    axes, kind = value.get("axes"), value.get("as", "boxes")
    if axes is not None and not (isinstance(axes, list) and len(axes) == PLANE and all(isinstance(v, str) for v in axes)):
        raise BadInput(f"map.axes: is {axes!r:.60}; the names of two dimensions are needed")
    if kind not in KINDS:
        raise BadInput(f"map.as: is {kind!r:.40}; use one of {', '.join(KINDS)}")
    return MapTable(value["file"], None if axes is None else tuple(axes), kind)


def expanded(document: dict[str, Any], task: TaskTables, folder: Path) -> dict[str, Any]:
    """The document of a task with [map] as one without: with the unsafe sets of the map. task: the same, without the map."""
    from stt_codegen.task.pieces import pieces_of, unsafe_tables, within

    given = table_of(document["map"])
    names = given.axes or task.axis_names
    if len(names) != PLANE or len(set(names)) < PLANE or not set(names) <= set(task.axis_names):
        told = f"are {', '.join(names)}" if given.axes else "are missing"
        raise BadInput(f"map.axes: {told}; name two different ones of {', '.join(task.axis_names)}")
    own = [task.axis_names.index(name) for name in names]
    found = read_map(folder / given.file)
    lower, upper = ([edges[i] for i in own] for edges in (task.state_space.lower, task.state_space.upper))
    pieces = pieces_of(within(found, lower, upper, task.tube.clearance, names), given.kind)
    tables = unsafe_tables(found, pieces, names if task.dimension > PLANE or own != [0, 1] else None)
    rest = {name: value for name, value in document.items() if name != "map"}
    taken = {str(table.get("name")) for table in rest.get("unsafe", []) if isinstance(table, dict)}
    with about("map"):
        clash = next((t["name"] for t in tables if t["name"] in taken), None)
        if clash is not None:
            raise BadInput(f"{clash!r} is the name of an unsafe set already; the map's are called map 1, map 2, ..")
    return {**rest, "unsafe": [*rest.get("unsafe", []), *_decimals(tables)]}


def _decimals(value: Any) -> Any:
    """Fractions as the decimals of a task file."""
    if isinstance(value, dict):
        return {k: _decimals(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_decimals(v) for v in value]
    return Decimal(decimal(value)) if isinstance(value, Fraction) else value


def written(document: Mapping[str, Any]) -> str:
    """A task's data as TOML."""
    lines = [f"{name} = {_plain(v)}" for name, v in document.items() if not _is_table(v)]

    def tables(prefix: str, inner: Mapping[str, Any]) -> None:
        for name, value in inner.items():
            if not _is_table(value):
                continue
            place = f"{prefix}{name}"
            for table in value if isinstance(value, list) else [value]:
                lines.extend(["", f"[[{place}]]" if isinstance(value, list) else f"[{place}]"])
                lines.extend(f"{k} = {_plain(v)}" for k, v in table.items() if not _is_table(v))
                tables(f"{place}.", table)

    tables("", document)
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value))


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list):
        return f"[{', '.join(_plain(v) for v in value)}]"
    return format(value, "f") if isinstance(value, Decimal) else str(value)
