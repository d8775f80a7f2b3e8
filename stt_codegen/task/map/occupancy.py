"""Read an occupancy map: which cells are free, occupied or unknown.

The occupancy of a pixel v of 0 to 255 is p = (255 - v) / 255, or v / 255 where the map is negated, or v / 100 in mode raw. A cell
with p above `occupied_thresh` is occupied, one with p below `free_thresh` is free, any other is unknown. Map servers differ in
colours (mean or luminance), ties and transparency. Here a cell is free where all of them call it free: every colour is below the
threshold, and the pixel is opaque.

Savers write an unknown cell as grey 205, p = 0.196, which free_thresh 0.25 would make free. So the rule "white" takes only cells
with p below `WHITE` as free, and "thresholds" takes all that the thresholds make free. `expand_maps` calls `read_map`.
"""

from __future__ import annotations

import io
from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from shlex import quote
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput
from stt_codegen.files import read_input
from stt_codegen.task.map.map_yaml import MapHeader, read_header

SIDE_CELLS_LIMIT = 4096
IMAGE_SIZE_LIMIT = 64_000_000  # bytes of the file
IMAGE_FORMATS = ("PNG", "PPM", "BMP", "GIF", "JPEG", "TIFF", "TGA", "WEBP")  # PGM is a PPM; no format that runs a program
WHITE = Fraction(2, 100)  # p below this is white: grey 250 to 255, savers write 254
OPAQUE = 255
LEVELS = 256
COLOURS = 3

Cells = npt.NDArray[np.bool_]
Window = tuple[slice, slice]
PieceKind = Literal["boxes", "polygons"]  # the sets that cover the unsafe cells of a map
KINDS: tuple[PieceKind, ...] = get_args(PieceKind)
FreeRule = Literal["white", "thresholds"]  # which of the cells that the thresholds make free are free
FREE_RULES: tuple[FreeRule, ...] = get_args(FreeRule)
ALL: Window = (slice(None), slice(None))


@dataclass(frozen=True, kw_only=True)
class OccupancyMap:
    """An occupancy map. Cells are indexed [x, y] from the lower left corner.

    grey: the cells that are free by the thresholds but not white; they are unknown where `free_rule` is "white". shade: for each
    cell the one of its colours with the largest occupancy."""

    header: MapHeader
    free_rule: FreeRule
    occupied: Cells
    unknown: Cells
    grey: Cells
    shade: npt.NDArray[np.uint8]

    @property
    def path(self) -> Path:
        """The YAML file."""
        return self.header.path

    @property
    def image(self) -> Path:
        """The image that the YAML file names."""
        return self.header.image

    @property
    def origin(self) -> tuple[Fraction, Fraction]:
        """The lower left corner."""
        return self.header.origin

    @property
    def resolution(self) -> Fraction:
        """The side of a cell, in units."""
        return self.header.resolution

    @property
    def unsafe(self) -> Cells:
        """The cells that are not known to be free."""
        return self.occupied | self.unknown

    @property
    def upper(self) -> tuple[Fraction, Fraction]:
        """The upper right corner."""
        x, y = (o + k * self.resolution for o, k in zip(self.origin, self.occupied.shape, strict=True))
        return x, y

    def grey_levels(self, window: Window = ALL) -> dict[int, int]:
        """Return the number of cells in a window by each grey that only the thresholds make free, the darkest first."""
        return dict(sorted(Counter(self.shade[window][self.grey[window]].tolist()).items()))

    def grey_note(self, window: Window = ALL) -> str | None:
        """Return a note on how grey cells of a window are read, and how to choose the opposite; None where there are none."""
        levels = self.grey_levels(window)
        if not levels:
            return None
        first, last = min(levels), max(levels)
        greys = f"grey {first}" if first == last else f"{len(levels)} greys from {first} to {last}"
        count = sum(levels.values())
        cells = f"{self.path}: {count:,} cell{'s' * (count > 1)} of {greys}"
        limit = decimal(self._threshold_without(window))
        if self.free_rule == "thresholds":
            return f'{cells} count as free, as free = "thresholds" says; with free_thresh: {limit} there they are unknown'
        reason = "" if self.header.mode == "raw" else ": map savers write unknown cells in grey"
        return (
            f"{cells} count as unknown, although free_thresh {decimal(self.header.free_below)} makes them free{reason}. "
            f'free_thresh: {limit} there says the same; if they are free floor, write free = "thresholds" into [map]'
        )

    def _threshold_without(self, window: Window) -> Fraction:
        """Return the largest threshold of three decimals with which no grey cell of a window is free."""
        shares = _shares(self.header)
        worst = min(shares[level] for level in self.grey_levels(window))
        return Fraction(worst * 1000 // 1, 1000)


def read_map(path: Path, free_rule: FreeRule = "white") -> OccupancyMap:
    """Return the map of a YAML file and its image. Raises `BadInput` where one is missing or wrong, rotated, or too large."""
    header = read_header(path)
    if header.yaw:
        command = f"stt-codegen map {quote(str(path))} --upright {quote(str(path.with_name(path.stem + '_upright.yaml')))}"
        raise BadInput(
            f"{path}: origin: the map is rotated by {decimal(header.yaw)} rad; `{command}` writes one that is not, in which all "
            "that is not free stays so"
        )
    return cells_of(header, free_rule)


def cells_of(header: MapHeader, free_rule: FreeRule = "white") -> OccupancyMap:
    """Return the map of a header, in the frame of the image, whatever its yaw."""
    darkest, total, opaque = _pixels(header)
    full = 100 if header.mode == "raw" else LEVELS - 1
    shares = _shares(header)
    # tables by grey level, made of exact comparisons, so that no rounding decides whether a cell is free
    below = np.array([p < header.free_below for p in shares])
    white = np.array([p < min(header.free_below, WHITE) for p in shares])
    steps = range(COLOURS * (LEVELS - 1) + 1)
    means = [Fraction(v, COLOURS * full) for v in (steps if _dark_is_free(header) else reversed(steps))]
    occupied = opaque & np.array([header.occupied_above < p <= 1 for p in means])[total]
    known_free = opaque & ~occupied & below[darkest]
    grey = known_free & ~white[darkest]
    free = known_free if free_rule == "thresholds" else known_free & ~grey
    occupied, unknown, grey, shade = (
        np.ascontiguousarray(cells[::-1].T) for cells in (occupied, ~occupied & ~free, grey, darkest)
    )
    return OccupancyMap(header=header, free_rule=free_rule, occupied=occupied, unknown=unknown, grey=grey, shade=shade)


def _dark_is_free(header: MapHeader) -> bool:
    return header.negate or header.mode == "raw"


def _shares(header: MapHeader) -> list[Fraction]:
    """Return the occupancy p of every grey level; above 1 it is none."""
    if header.mode == "raw":
        return [Fraction(v, 100) for v in range(LEVELS)]
    full = LEVELS - 1
    return [Fraction(v if header.negate else full - v, full) for v in range(LEVELS)]


def _pixels(header: MapHeader) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], Cells]:
    """Return for every pixel the colour with the largest occupancy, the sum of its colours, and whether it is opaque.

    Rows are from the top. Raises `BadInput` where the image cannot be read exactly."""
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None  # the size is checked below
    image = header.image
    remedy = f"it is the image of {header.path}"
    data = io.BytesIO(read_input(image, IMAGE_SIZE_LIMIT, remedy))
    try:
        with Image.open(data, formats=IMAGE_FORMATS) as opened:
            if max(opened.size) > SIDE_CELLS_LIMIT:
                raise BadInput(
                    f"{image}: has {opened.size[0]} x {opened.size[1]} cells; at most {SIDE_CELLS_LIMIT} a side are taken"
                )
            encoding = str(getattr(opened, "tile", ""))
            if opened.mode.startswith(("I", "F")) or ";16" in encoding:  # Pillow would drop the lower 8 bits
                raise BadInput(f"{image}: has more than 8 bits a colour; save it with 8")
            if (
                opened.format == "PPM"
                and "'ppm" in encoding
                and opened.mode != "1"
                and (LEVELS - 1) not in _largest_greys(opened)
            ):
                raise BadInput(f"{image}: its largest grey is not 255, and to scale it would round greys; save it with 255")
            if "A" in opened.getbands() or "transparency" in opened.info:
                _require_clear_alpha(header)
            pixels = np.array(opened.convert("RGBA"))
    except BadInput:
        raise
    except Exception:  # decoders raise what they like at a damaged image
        raise BadInput(f"{image}: is no image, or damaged; {', '.join(IMAGE_FORMATS)} are read; {remedy}") from None
    colours = pixels[..., :COLOURS]
    darkest = colours.max(axis=-1) if _dark_is_free(header) else colours.min(axis=-1)
    return darkest, colours.sum(axis=-1, dtype=np.uint16), np.asarray(pixels[..., COLOURS] == OPAQUE)


def _largest_greys(opened: Any) -> set[object]:
    """Return the last arguments of an opened image's decoders: for a PGM that is not in bytes, the largest grey."""
    return {tile[3][-1] for tile in opened.tile if isinstance(tile[3], tuple)}


def _require_clear_alpha(header: MapHeader) -> None:
    """Raise `BadInput` where some map servers would take alpha as a fourth colour, so that no cell is free."""
    if header.mode == "trinary" and header.negate:
        raise BadInput(
            f"{header.image}: has transparency, and the map is negated in mode trinary, where map servers disagree; save the "
            "image without transparency, or use mode: scale"
        )
