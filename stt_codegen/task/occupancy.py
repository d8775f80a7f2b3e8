"""An occupancy map: which cells are free, occupied, unknown.

A pixel v of 0 to 255 is occupied with p = (255 - v) / 255, or v / 255 where the map is negated; v is the mean of the colours. A
cell with p above `occupied_thresh` is occupied, one with p below `free_thresh` free, any other unknown. So the map server of ROS
has it in its modes trinary and scale, but that here the mean is exact and what is transparent is unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from stt_codegen.errors import BadInput

MOST_CELLS = 4096  # of a side
KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")
REQUIRED = ("image", "resolution", "origin", "occupied_thresh", "free_thresh")
OPAQUE = 255
FULL = 3 * 255  # the sum of three colours

Cells = npt.NDArray[np.bool_]
Kind = Literal["boxes", "polygons"]  # as what a map is taken
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True)
class OccupancyMap:
    """occupied, unknown: cells [x, y] from the lower left corner, `origin`, on; resolution: the side of a cell, units."""

    path: Path
    image: Path
    occupied: Cells
    unknown: Cells
    origin: tuple[Fraction, Fraction]
    resolution: Fraction

    @property
    def unsafe(self) -> Cells:
        """What is not known to be free."""
        return self.occupied | self.unknown

    @property
    def upper(self) -> tuple[Fraction, Fraction]:
        """The upper right corner."""
        x, y = (o + k * self.resolution for o, k in zip(self.origin, self.occupied.shape, strict=True))
        return x, y


def read_map(path: Path) -> OccupancyMap:
    """A map by its YAML file, with the image beside it. Raises `BadInput` where it is missing, rotated, or too large."""
    found = _fields(path)
    resolution, origin = _number(path, "resolution", found["resolution"]), found["origin"]
    if resolution <= 0:
        raise BadInput(f"{path}: resolution: is {found['resolution']}; it must be greater than 0")
    if not isinstance(origin, list) or len(origin) not in (2, 3):
        raise BadInput(f"{path}: origin: is {origin!r}; [x, y, yaw] of the lower left corner is needed")
    x, y, *turned = (_number(path, "origin", v) for v in origin)
    if any(turned):
        raise BadInput(f"{path}: origin: the map is rotated by {origin[2]}; turn the image, and make the yaw 0")
    occupied_above, free_below = (_number(path, name, found[name]) for name in ("occupied_thresh", "free_thresh"))
    if not 0 <= free_below <= occupied_above <= 1:
        told = f"{found['free_thresh']} and {found['occupied_thresh']}"
        raise BadInput(
            f"{path}: free_thresh, occupied_thresh: are {told}; both must lie in 0 to 1, the first not above the second"
        )
    mode, negate = found.get("mode", "trinary"), found.get("negate", 0)
    if mode not in ("trinary", "scale"):
        raise BadInput(f"{path}: mode: is {mode!r}; use trinary or scale")
    if negate not in (0, 1):
        raise BadInput(f"{path}: negate: is {negate!r}; use 0 or 1")
    image = path.parent / str(found["image"])
    value, opaque = _pixels(image, path)
    level = (value if negate else FULL - value).astype(np.int64)  # p = level / FULL
    # whole numbers on both sides: no rounding decides whether a cell is free
    occupied = opaque & (level * occupied_above.denominator > FULL * occupied_above.numerator)
    free = opaque & ~occupied & (level * free_below.denominator < FULL * free_below.numerator)
    known, doubtful = (np.ascontiguousarray(cells[::-1].T) for cells in (occupied, ~occupied & ~free))
    return OccupancyMap(path, image, known, doubtful, (x, y), resolution)


def _fields(path: Path) -> dict[str, Any]:
    """What the YAML file says; numbers stay text, so that they are read as exact decimals."""
    import yaml

    try:
        text = path.read_text(encoding="utf-8")
        found = yaml.load(text, Loader=yaml.BaseLoader)  # it makes texts, lists and dictionaries, nothing else
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); give the .yaml of a map") from None
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise BadInput(f"{path}: is no YAML: {str(error).splitlines()[0]}") from None
    if not isinstance(found, dict):
        raise BadInput(f"{path}: is no map; image, resolution, origin and two thresholds are needed")
    missing = [name for name in REQUIRED if name not in found]
    if missing:
        raise BadInput(f"{path}: {missing[0]}: is missing; a map has {', '.join(KEYS)}")
    if str(found.get("negate", "0")) in ("0", "1"):
        found["negate"] = int(found.get("negate", "0"))
    return found


def _number(path: Path, field: str, text: Any) -> Fraction:
    try:
        value = Decimal(text)
        if value.is_finite() and -20 < value.adjusted() < 20:
            return Fraction(value)
    except (ArithmeticError, TypeError, ValueError):
        pass
    raise BadInput(f"{path}: {field}: {text!r:.40} is no number; use a decimal, for example 0.05")


def _pixels(image: Path, path: Path) -> tuple[npt.NDArray[np.int64], Cells]:
    """The sum of every pixel's colours, and which pixels are opaque, rows from the top."""
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None  # its size is looked at here
    try:
        with Image.open(image) as opened:
            if max(opened.size) > MOST_CELLS:
                raise BadInput(f"{image}: has {opened.size[0]} x {opened.size[1]} cells; at most {MOST_CELLS} a side are taken")
            if opened.mode.startswith(("I", "F")):
                raise BadInput(f"{image}: has more than 8 bits a pixel; save it with 8")
            pixels = np.array(opened.convert("RGBA"))
    except OSError as error:
        told = error.strerror or "is no image"
        raise BadInput(f"{image}: cannot be read ({told}); it is the image of {path}") from None
    return pixels[..., :3].astype(np.int64).sum(axis=-1), np.asarray(pixels[..., 3] == OPAQUE)
