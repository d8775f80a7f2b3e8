"""`report`: one page about a controller, to look at, to drive, and to hand over."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stt_codegen.cli.options import (
    DesignOption,
    Json,
    PlantOption,
    ScalarOption,
    TaskFile,
    Uncertified,
    patience,
    print_json,
)

if TYPE_CHECKING:
    from stt_codegen.pipeline import Controller
    from stt_codegen.report.evidence import Check


def report(
    task: TaskFile,
    out: Annotated[Path | None, typer.Option(metavar="FILE.html", help="the page; by default <name>.report.html")] = None,
    plant: PlantOption = None,
    board: Annotated[
        list[str] | None,
        typer.Option(metavar="BOARD", help="run the C on this emulated board too, as `pil` does; may be given again"),
    ] = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    json: Json = False,
    uncertified: Uncertified = False,
) -> None:
    """Write one HTML page about a controller: the tube over time, the C to drive, certificate, evidence. It needs no network."""
    from stt_codegen.errors import BadInput
    from stt_codegen.plants import plant_of
    from stt_codegen.record.files import write_files

    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--out {out}: is no page; use a name that ends in .html")
    begin = time.perf_counter()
    with patience(f"designing {task}"):
        from stt_codegen.pipeline import build
        from stt_codegen.report.design import design_report

        controller = build(task, design, scalar, uncertified)
        figures = design_report(controller, time.perf_counter() - begin)
        model = None if plant is None else plant_of(plant, controller.task.dimension, controller.task.order)
    with patience(f"compiling and comparing {controller.task.name}"):
        from stt_codegen.report.page import Extras, page

        ran = [_on_board(controller, name) for name in board or ()]
        text = page(controller, figures, Extras(task, model, ran))
    path = out or Path(f"{controller.task.name}.report.html")
    write_files(path.parent, {path.name: text})
    if json:
        seconds = round(time.perf_counter() - begin, 3)
        print_json({"task": controller.task.name, "page": str(path), "bytes": len(text), "seconds": seconds})
    else:
        print(f"{controller.task.name}: {path}, {len(text)} bytes; open it in a browser")


def _on_board(controller: Controller, name: str) -> Check:
    """What `pil` finds on a board, in a line."""
    from stt_codegen.board.emulated import BOARDS, run_on_board
    from stt_codegen.errors import BadInput
    from stt_codegen.report.evidence import Check

    if name not in BOARDS:
        raise BadInput(f"--board {name}: is none of {', '.join(BOARDS)}")
    board = BOARDS[name]
    rows, costs = run_on_board(controller, board, 500)
    told = [f"{f}: {c.least} to {c.most} {board.unit}, {c.stack} B of stack" for f, c in costs.items()]
    worst = max(rows, key=lambda r: r.share)
    told.append(f"{sum(r.points for r in rows):,} values, nearest to its bound: {worst.quantity}, at {worst.share:.0%} of it")
    return Check(f"{board.title}, emulated", all(r.holds for r in rows), "; ".join(told))
