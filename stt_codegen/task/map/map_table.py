"""The table [map] of a task file: when the file is read, unsafe sets replace the occupancy maps.

    [map]
    file = "hall.yaml"          # beside the task file; or a list: the floor's map, then masks of areas to avoid
    axes = ["x", "y"]           # the dimensions of the map; absent: those of a task in the plane
    as = "boxes"                # or "polygons": fewer sets, which may take free cells too
    free = "white"              # or "thresholds": greys that the thresholds make free are free

A state is free where the first map says so, and every further map that covers it. The first map must cover the state space. The
proofs are about the sets. `to_toml` prints the task with these sets, which a checker can read.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput, about
from stt_codegen.files import parse_toml, read_task_text
from stt_codegen.task.checks import describe_unknown_key
from stt_codegen.task.keys import MAP_KEYS, TableOfKeys
from stt_codegen.task.map.map_yaml import read_header
from stt_codegen.task.map.occupancy import FREE_RULES, KINDS, FreeRule, PieceKind, read_map
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.values import kind_of

PLANE = 2
MAX_MAPS = 16


@dataclass(frozen=True)
class MapTable:
    """The checked table [map]. files: the floor's map, then masks."""

    files: tuple[str, ...]
    axes: tuple[str, ...] | None
    kind: PieceKind
    free_rule: FreeRule


class Expansion(NamedTuple):
    """The data of a task with sets in place of [map], and notes on the maps for its reader."""

    document: dict[str, Any]
    notes: tuple[str, ...]


def require_map_table(value: Any) -> MapTable:
    """Check the table of a value, and return it. Raises `BadInput` where it is no table [map]."""
    if not isinstance(value, dict):
        raise BadInput(f"map: is {kind_of(value)}; a table is needed")
    for name in value:
        if name not in MAP_KEYS:
            table = TableOfKeys("map", False, MAP_KEYS)
            raise BadInput(describe_unknown_key(f"map.{name}", name, table, value[name]))
    axes, kind, free_rule = value.get("axes"), value.get("as", "boxes"), value.get("free", "white")
    if axes is not None and not (isinstance(axes, list) and len(axes) == PLANE and all(isinstance(v, str) for v in axes)):
        raise BadInput(f"map.axes: is {axes!r:.60}; the names of two dimensions are needed")
    if kind not in KINDS:
        raise BadInput(f"map.as: is {kind!r:.40}; use one of {', '.join(KINDS)}")
    if free_rule not in FREE_RULES:
        raise BadInput(f"map.free: is {free_rule!r:.40}; use one of {', '.join(FREE_RULES)}")
    return MapTable(_files_of(value), None if axes is None else tuple(axes), kind, free_rule)


def input_files(path: Path) -> list[Path]:
    """Return the task file, its maps and their images, which no output may replace. path: a task file that was read before."""
    value = parse_toml(read_task_text(path)).get("map")
    maps = [] if value is None else [path.parent / file for file in require_map_table(value).files]
    return [path, *maps, *(read_header(file).image for file in maps)]


def _files_of(value: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the paths of the maps' YAML files."""
    remedy = "give the path of the map's .yaml, from the task file's folder, or a list of such paths, the floor's map first"
    files = value.get("file")
    if isinstance(files, str):
        return (files,)
    if not isinstance(files, list):
        raise BadInput(f"map.file: {'is missing' if files is None else f'is {kind_of(files)}'}; {remedy}")
    for path in files:
        if not isinstance(path, str):
            raise BadInput(f"map.file: has {kind_of(path)} in its list; {remedy}")
    if not 0 < len(files) <= MAX_MAPS:
        raise BadInput(f"map.file: lists {len(files)} maps; list 1 to {MAX_MAPS}")
    return tuple(files)


def expand_maps(document: dict[str, Any], task: TaskTables, folder: Path) -> Expansion:
    """Return the data of a task with the unsafe sets of its maps in place of [map]. task: the task without [map]."""
    from stt_codegen.task.map.convex_pieces import cover_cells, require_cover, unsafe_cells_in, unsafe_tables, window_near

    table = require_map_table(document["map"])
    names = _axes_of_map(table, task)
    indices = [task.axis_names.index(name) for name in names]
    axes = names if task.dimension > PLANE or indices != [0, 1] else None
    lower, upper = ([edges[i] for i in indices] for edges in (task.state_space.lower, task.state_space.upper))
    tables, notes = [], []
    for number, file in enumerate(table.files, 1):
        chart = read_map(folder / file, table.free_rule)
        if number == 1:
            require_cover(chart, lower, upper, names)
        window = window_near(chart, lower, upper, [task.clearances[i] for i in indices])
        pieces = cover_cells(unsafe_cells_in(chart, window), table.kind)
        tables += unsafe_tables(chart, pieces, axes, "map " if len(table.files) == 1 else f"map {number}.")
        notes += [note for note in (chart.grey_note(window),) if note]
    fields = {name: value for name, value in document.items() if name != "map"}
    stated_names = {str(unsafe.get("name")) for unsafe in fields.get("unsafe", []) if isinstance(unsafe, dict)}
    with about("map"):
        clash = next((t["name"] for t in tables if t["name"] in stated_names), None)
        if clash is not None:
            raise BadInput(f"{clash!r} is the name of an unsafe set already; the map's are called {tables[0]['name']}, ..")
    return Expansion({**fields, "unsafe": [*fields.get("unsafe", []), *_decimals(tables)]}, tuple(notes))


def _axes_of_map(table: MapTable, task: TaskTables) -> tuple[str, ...]:
    """Return the names of the map's two dimensions. Raises `BadInput` where they are no two open axes of the task."""
    names = table.axes or task.axis_names
    if len(names) != PLANE or len(set(names)) < PLANE or not set(names) <= set(task.axis_names):
        problem = f"are {', '.join(names)}" if table.axes else "are missing"
        raise BadInput(f"map.axes: {problem}; name two different ones of {', '.join(task.axis_names)}")
    closed = next((name for name in names if name in (task.periodic or {})), None)
    if closed is not None:
        raise BadInput(
            f"map.axes: are {', '.join(names)}, and {closed} closes (periodic); a map has no turns, leave {closed} out"
        )
    return names


def _decimals(value: Any) -> Any:
    """Return a value with its fractions as the decimals of a task file."""
    if isinstance(value, dict):
        return {k: _decimals(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_decimals(v) for v in value]
    return Decimal(decimal(value)) if isinstance(value, Fraction) else value


def to_toml(document: Mapping[str, Any]) -> str:
    """Return a task's data as the text of a TOML file."""
    lines = [f"{name} = {_plain(v)}" for name, v in document.items() if not _is_table(v)]

    def tables(prefix: str, inner: Mapping[str, Any]) -> None:
        for name, value in inner.items():
            if not _is_table(value):
                continue
            header = f"{prefix}{name}"
            for table in value if isinstance(value, list) else [value]:
                lines.extend(["", f"[[{header}]]" if isinstance(value, list) else f"[{header}]"])
                lines.extend(f"{k} = {_plain(v)}" for k, v in table.items() if not _is_table(v))
                tables(f"{header}.", table)

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
