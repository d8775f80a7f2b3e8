"""Read the YAML file of an occupancy map as the map server of ROS 2 does, within bounds.

Size, depth and aliases are checked before any value is built, because a few hundred bytes of aliases can stand for gigabytes.
occupancy.py and upright.py call `read_header`.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, get_args

from stt_codegen.errors import BadInput
from stt_codegen.files import read_input

FILE_SIZE_LIMIT = 16384  # bytes
DEPTH_LIMIT = 4  # levels of lists and tables; a map needs two
KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")
NUMBER_POWER = 9  # a number is 0 or from 1e-9 to 1e9, as in a task
REQUIRED = ("image", "resolution", "origin", "occupied_thresh", "free_thresh")
BOOLEANS = {word: word in ("1", "true", "yes", "on", "y") for word in ("0", "1", *"true yes on y false no off n".split())}

Mode = Literal["trinary", "scale", "raw"]
MODES: tuple[Mode, ...] = get_args(Mode)


@dataclass(frozen=True, kw_only=True)
class MapHeader:
    """The checked fields of the file.

    resolution: side of a cell, in units; origin: lower left corner; yaw: rotation from x to y, in radians; occupied_above and
    free_below: thresholds of the occupancy p, from 0 to 1."""

    path: Path
    image: Path
    resolution: Fraction
    origin: tuple[Fraction, Fraction]
    yaw: Fraction
    occupied_above: Fraction
    free_below: Fraction
    mode: Mode
    negate: bool


def read_header(path: Path) -> MapHeader:
    """Read the YAML file of a map. Raises `BadInput` where a field is missing or wrong, or the file exceeds the bounds."""
    fields = _fields(path)
    resolution, origin = _number(path, "resolution", fields["resolution"]), fields["origin"]
    if resolution <= 0:
        raise BadInput(f"{path}: resolution: is {fields['resolution']}; it must be greater than 0")
    if not isinstance(origin, list) or len(origin) not in (2, 3):
        raise BadInput(f"{path}: origin: is {origin!r:.60}; [x, y, yaw] of the lower left corner is needed")
    x, y, *yaw = (_number(path, "origin", v) for v in origin)
    occupied_above, free_below = (_number(path, name, fields[name]) for name in ("occupied_thresh", "free_thresh"))
    if not 0 <= free_below <= occupied_above <= 1:
        limits = f"{fields['free_thresh']} and {fields['occupied_thresh']}"
        raise BadInput(
            f"{path}: free_thresh, occupied_thresh: are {limits}; both must lie in 0 to 1, the first not above the second"
        )
    mode = str(fields.get("mode", "trinary")).lower()
    if mode not in MODES:
        raise BadInput(f"{path}: mode: is {fields['mode']!r:.40}; use one of {', '.join(MODES)}")
    negate = BOOLEANS.get(str(fields.get("negate", "0")).lower())
    if negate is None:
        raise BadInput(f"{path}: negate: is {fields['negate']!r:.40}; use 0 or 1, or false or true")
    if negate and mode == "raw":
        raise BadInput(
            f"{path}: negate: is {fields['negate']} with mode: raw, which map servers read in two ways; use negate: 0, and save "
            "the image with each pixel's occupancy, 0 (free) to 100"
        )
    if not isinstance(fields["image"], str) or not fields["image"] or "\0" in fields["image"]:
        raise BadInput(f"{path}: image: is {fields['image']!r:.40}; give the path of the image, from the folder of this file")
    image, turn = path.parent / fields["image"], yaw[0] if yaw else Fraction(0)
    return MapHeader(
        path=path,
        image=image,
        resolution=resolution,
        origin=(x, y),
        yaw=turn,
        occupied_above=occupied_above,
        free_below=free_below,
        mode=mode,
        negate=negate,
    )


def _fields(path: Path) -> dict[str, Any]:
    """Return the fields of the file. Numbers stay text, so that they are read as exact decimals.

    Raises `BadInput` where it is no YAML table, exceeds the bounds, repeats a key or lacks one."""
    import yaml

    try:
        text = read_input(path, FILE_SIZE_LIMIT, "give the .yaml of a map, which has a few lines").decode("utf-8-sig")
        _require_bounded(path, text)
        node = yaml.compose(text, Loader=yaml.BaseLoader)
        fields = yaml.load(text, Loader=yaml.BaseLoader)  # it makes texts, lists and dictionaries, nothing else
    except (ValueError, OverflowError, yaml.YAMLError) as error:
        raise BadInput(f"{path}: is no YAML: {str(error).splitlines()[0]}") from None
    if not isinstance(fields, dict):
        raise BadInput(f"{path}: is no map; image, resolution, origin and two thresholds are needed")
    repeated, count = Counter(str(key.value) for key, _ in node.value).most_common(1)[0] if node.value else ("", 0)
    if count > 1:
        raise BadInput(f"{path}: {repeated:.40}: stands twice; leave one line of it")
    missing = [name for name in REQUIRED if name not in fields]
    if missing:
        raise BadInput(f"{path}: {missing[0]}: is missing; a map has {', '.join(KEYS)}")
    return fields


def _require_bounded(path: Path, text: str) -> None:
    """Raise `BadInput` at an alias or deep nesting, from the events of the parser, before a value is built."""
    import yaml

    depth = 0
    for event in yaml.parse(text, Loader=yaml.BaseLoader):
        if isinstance(event, yaml.AliasEvent):
            raise BadInput(f"{path}: line {event.start_mark.line + 1}: has an alias (*{event.anchor:.40}); write its value out")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEPTH_LIMIT:
            raise BadInput(
                f"{path}: line {event.start_mark.line + 1}: is nested more than {DEPTH_LIMIT} deep; a map is a flat table"
            )


def _number(path: Path, field: str, text: Any) -> Fraction:
    """Return the exact value of a field. Raises `BadInput` where its text is no decimal, or one that no task may have."""
    try:
        value = Decimal(text)
        if value.is_finite() and len(value.as_tuple().digits) < 40:
            if value and not -NUMBER_POWER <= value.adjusted() < NUMBER_POWER:
                raise BadInput(
                    f"{path}: {field}: is {text!r:.40}; use 0 or a magnitude from 1e-{NUMBER_POWER} to 1e{NUMBER_POWER}"
                )
            return Fraction(value)
    except (ArithmeticError, TypeError, ValueError):
        pass
    raise BadInput(f"{path}: {field}: {text!r:.40} is no number; use a decimal, for example 0.05")
