"""`report`: one page about a controller, with pictures, the C to drive, and the evidence."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from stt_codegen.cli.options import (
    DesignOption,
    EffortOption,
    Json,
    PlantOption,
    ScalarOption,
    TaskFile,
    Uncertified,
    effort_for,
    patience,
    print_json,
    print_line,
    say,
)
from stt_codegen.errors import BadInput


def report(
    task: TaskFile,
    out: Annotated[
        Path | None, typer.Option(readable=False, metavar="FILE.html", help="the page; by default <name>.report.html")
    ] = None,
    plant: PlantOption = None,
    board: Annotated[
        list[str] | None,
        typer.Option(metavar="BOARD", help="run the C on this emulated board too, as `pil` does; may be given again"),
    ] = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    json: Json = False,
    effort: EffortOption = None,
    uncertified: Uncertified = False,
) -> None:
    """Write one HTML page about a controller: the tube over time, the C to drive, certificate, evidence. It needs no network.
    Exit code 1 when a check that was run for the evidence fails."""
    _require_page_and_boards(out, board or ())
    begin = time.perf_counter()
    with patience(f"designing {task}"):
        from stt_codegen.pipeline import build
        from stt_codegen.plants import plant_of
        from stt_codegen.report import design_report
        from stt_codegen.task import load_task

        loaded = load_task(task)
        model = None if plant is None else plant_of(plant, loaded.dimension, loaded.order)
        controller = build(task, design, scalar, uncertified, effort=effort_for(task, effort))
        figures = design_report(controller, time.perf_counter() - begin)
    with patience(f"compiling and comparing {controller.task.name}"):
        from stt_codegen.report.page import evidence, page

        page_evidence = evidence(controller, task, _run_on_boards(controller, board or ()))
        text = page(controller, figures, page_evidence, model)
    path = out or Path(f"{controller.task.name}.report.html")
    _write_page(path, text)
    if json:
        print_json(
            {
                "task": controller.task.name,
                "page": str(path),
                "bytes": len(text),
                "seconds": round(time.perf_counter() - begin, 3),
                "evidence_holds": page_evidence.has_no_failure,
            }
        )
    else:
        print_line(f"{controller.task.name}: {path}, {len(text)} bytes; open it in a browser")
    if not page_evidence.has_no_failure:
        failed = [check.name for check in page_evidence.checks if check.has_passed is False]
        failed += [f"MISRA rule {rule}" for rule in page_evidence.unlisted]
        say(f"note: {controller.task.name}: failed: {', '.join(failed)}; the page's evidence has more")
        raise typer.Exit(1)


def _require_page_and_boards(out: Path | None, boards: Sequence[str]) -> None:
    """Raise `BadInput` for a page that is no HTML file, or for an unknown board."""
    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--out {out}: is no page; use a name that ends in .html")
    for name in boards:
        from stt_codegen.board.summary import require_board

        require_board(name)


def _run_on_boards(controller: Any, boards: Sequence[str]) -> list[Any]:
    """Run the C on each emulated board and compare it with the reference."""
    checks = []
    for name in boards:
        from stt_codegen.board.summary import on_board

        checks.append(on_board(controller, name))
    return checks


def _write_page(path: Path, text: bytes) -> None:
    from stt_codegen.files import write_files

    write_files(path.parent, {path.name: text})
