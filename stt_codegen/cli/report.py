"""`report`: one page about a controller, to look at and to hand over."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import DesignOption, Json, ScalarOption, TaskFile, Uncertified, patience, print_json


def report(
    task: TaskFile,
    out: Annotated[Path | None, typer.Option(metavar="FILE.html", help="the page; by default <name>.report.html")] = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    json: Json = False,
    uncertified: Uncertified = False,
) -> None:
    """Write one HTML page about a controller: the tube over time, its certificate, its files. It needs no network."""
    from stt_codegen.errors import BadInput
    from stt_codegen.record.files import write_files

    if out is not None and out.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--out {out}: is no page; use a name that ends in .html")
    with patience(f"designing {task}"):
        from stt_codegen.pipeline import build
        from stt_codegen.report.design import design_report
        from stt_codegen.report.page import page

        begin = time.perf_counter()
        controller = build(task, design, scalar, uncertified)
        text = page(controller, design_report(controller, time.perf_counter() - begin))
    path = out or Path(f"{controller.task.name}.report.html")
    write_files(path.parent, {path.name: text})
    if json:
        print_json({"task": controller.task.name, "page": str(path), "bytes": len(text)})
    else:
        print(f"{controller.task.name}: {path}, {len(text)} bytes; open it in a browser")
