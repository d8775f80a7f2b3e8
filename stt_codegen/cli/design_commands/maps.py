"""`map`: the unsafe sets that stand for an occupancy map."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from stt_codegen.cli.options import Json, counted, patience, print_json, print_line
from stt_codegen.errors import BadInput


def map_(
    file: Annotated[
        Path, typer.Argument(readable=False, metavar="MAP", help="the .yaml of a map server, with its image beside it")
    ],
    kind: Annotated[Literal["boxes", "polygons"], typer.Option("--as", help="the sets that it is taken as")] = "boxes",
    picture: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="PATH", help="folder for <name>_map.png, or a file .png, .svg, .pdf; default: here"),
    ] = None,
    free: Annotated[
        Literal["white", "thresholds"],
        typer.Option(help="which cells are free: white ones, or all that the thresholds make free"),
    ] = "white",
    upright: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="YAML", help="write a rotated map as one that is not, with its .png beside it"),
    ] = None,
    json: Json = False,
) -> None:
    """Show the unsafe sets that stand for an occupancy map, how many and what they cover, and draw them. A task with [map] uses
    those near its state space."""
    if upright is not None:
        _turn_upright(file, upright, free, json)
        return
    with patience(f"reading {file}"):
        from stt_codegen.report.pictures import draw_map, map_report, picture_path
        from stt_codegen.task.map import read_map

        report = map_report(read_map(file, free), kind)
        path = picture_path(picture or Path(), f"{file.stem}_map")
        if path.resolve() == report.occupancy_map.image.resolve():
            raise BadInput(f"{path}: is the map's own image; give another --picture")
        draw_map(report, path)
    if json:
        print_json({**report.document(), "picture": str(path)})
        return
    counts, grid = report.counts, report.occupancy_map
    width, height = grid.occupied.shape
    print_line(f"{file}: {width} x {height} cells of {float(grid.resolution):g}")
    print(f"  from {', '.join(f'{float(v):g}' for v in grid.origin)} to {', '.join(f'{float(v):g}' for v in grid.upper)}")
    print(f"  {counts['occupied']} occupied, {counts['unknown']} unknown, {counts['free']} free; occupied and unknown are unsafe")
    if note := grid.grey_note():
        print_line(f"  note: {note}")
    unsafe = counts["occupied"] + counts["unknown"]
    more = f", {report.covered_free_cells / unsafe:.1%} of the unsafe ones" if unsafe else ""
    cover = f"which cover the middle of {report.covered_free_cells} free cells{more}"
    print(f"  as {kind}: {counted(len(report.pieces), 'set')}, {cover}")
    print_line(f"  picture: {path}")


def _turn_upright(file: Path, target: Path, free: Literal["white", "thresholds"], json: bool) -> None:
    """Write a rotated map as an upright one, in which no cell is free that was not."""
    with patience(f"turning {file}"):
        from stt_codegen.task.map import write_upright_map

        cells = write_upright_map(file, target, free)
    if json:
        print_json({"map": str(target), "image": str(target.with_suffix(".png")), **cells})
        return
    print_line(
        f"{target}: {cells['free']} free cells of {cells['free_before']} in {file}; all that is not free there is not free here"
    )
