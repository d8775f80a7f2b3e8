"""`report`: one page about a controller, to look at, to drive, and to hand over."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

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
    say,
)


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
    """Write one HTML page about a controller: the tube over time, the C to drive, certificate, evidence. It needs no network.
    Exit code 1 when something that was run for the evidence is not as it should be."""
    from stt_codegen.errors import BadInput
    from stt_codegen.plants import plant_of
    from stt_codegen.record import write_files

    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--out {out}: is no page; use a name that ends in .html")
    for name in board or ():
        from stt_codegen.board.summary import require_board

        require_board(name)
    begin = time.perf_counter()
    with patience(f"designing {task}"):
        from stt_codegen.pipeline import build
        from stt_codegen.report import design_report
        from stt_codegen.task import load_task

        loaded = load_task(task)
        model = None if plant is None else plant_of(plant, loaded.dimension, loaded.order)
        controller = build(task, design, scalar, uncertified)
        figures = design_report(controller, time.perf_counter() - begin)
    with patience(f"compiling and comparing {controller.task.name}"):
        from stt_codegen.report.page import evidence, page

        ran = []
        for name in board or ():
            from stt_codegen.board.summary import on_board

            ran.append(on_board(controller, name))
        shown = evidence(controller, task, ran)
        text = page(controller, figures, shown, model)
    path = out or Path(f"{controller.task.name}.report.html")
    write_files(path.parent, {path.name: text})
    if json:
        seconds = round(time.perf_counter() - begin, 3)
        print_json(
            {
                "task": controller.task.name,
                "page": str(path),
                "bytes": len(text),
                "seconds": seconds,
                "evidence_holds": shown.good,
            }
        )
    else:
        print(f"{controller.task.name}: {path}, {len(text)} bytes; open it in a browser")
    if not shown.good:
        failed = [one.name for one in shown.checks if one.good is False] + [f"MISRA rule {rule}" for rule in shown.unlisted]
        say(f"note: {controller.task.name}: not as it should be: {', '.join(failed)}; the page's evidence has more")
        raise typer.Exit(1)
