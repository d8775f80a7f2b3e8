"""`design`: the tube of a task before anything is emitted."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import DesignOption, Json, ScalarOption, TaskFile, Uncertified, patience, print_json


def design(
    task: TaskFile,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    picture: Annotated[Path | None, typer.Option(metavar="DIR", help="where <name>.png goes; none without")] = None,
    json: Json = False,
    uncertified: Uncertified = False,
) -> None:
    """Show the tube of a task before anything is emitted: width, speed, certificate, cost, picture."""
    with patience(f"designing {task}"):
        from stt_codegen.pipeline import build
        from stt_codegen.report.design import design_report

        begin = time.perf_counter()
        controller = build(task, design, scalar, uncertified)
        report = design_report(controller, time.perf_counter() - begin)
        if picture is not None:
            from stt_codegen.report.picture import draw

            path = picture / f"{controller.task.name}.png"
            draw(controller, path)
            report = report.drawn(path)
    if json:
        print_json(report.document())
    else:
        from stt_codegen.cli.show import show_design

        show_design(report)
