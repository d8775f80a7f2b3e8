"""`design`: the tube of a task before anything is emitted."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import (
    Axes,
    DesignOption,
    EffortOption,
    Json,
    ScalarOption,
    TaskFile,
    Uncertified,
    effort_for,
    patience,
    print_json,
)


def design(
    task: TaskFile,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    picture: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="PATH", help="folder for <name>.png, or a file .png, .svg, .pdf; none without"),
    ] = None,
    axes: Axes = None,
    pareto: Annotated[
        bool, typer.Option("--pareto", help="what tubes of several widths trade: width, speed, longest proved period")
    ] = False,
    json: Json = False,
    effort: EffortOption = None,
    uncertified: Uncertified = False,
) -> None:
    """Show the tube of a task before anything is emitted: width, speed, certificate, cost, picture."""
    if pareto:
        _compare_tubes(task, design, scalar, picture, json)
        return
    with patience(f"designing {task}"):
        from stt_codegen.pipeline import build
        from stt_codegen.report import design_report

        begin = time.perf_counter()
        controller = build(task, design, scalar, uncertified, effort=effort_for(task, effort))
        report = design_report(controller, time.perf_counter() - begin)
        if picture is not None:
            from stt_codegen.record import refuse_to_overwrite_inputs
            from stt_codegen.report.pictures import draw, picture_path, plane_named

            path = picture_path(picture, controller.task.name)
            refuse_to_overwrite_inputs([path], [task])
            draw(controller, path, [plane_named(controller.task, text) for text in axes or ()])
            report = report.with_picture(path)
    if json:
        print_json(report.document())
    else:
        from stt_codegen.cli.show import show_design

        show_design(report)


def _compare_tubes(task: Path, design: str | None, scalar: str | None, picture: Path | None, json: bool) -> None:
    """Show what several tubes of the task trade: width, speed, and longest proved period."""
    with patience(f"designing tubes for {task}"):
        from stt_codegen.errors import about
        from stt_codegen.report import trade_report
        from stt_codegen.task import load_task

        with about(task):
            report = trade_report(load_task(task).with_options(design, scalar))
        if picture is not None:
            from stt_codegen.record import refuse_to_overwrite_inputs
            from stt_codegen.report.pictures import draw_trade, picture_path

            path = picture_path(picture, f"{report.task}-pareto")
            refuse_to_overwrite_inputs([path], [task])
            draw_trade(report, path)
            report = report.with_picture(path)
    if json:
        print_json(report.document())
    else:
        from stt_codegen.cli.show import show_trade

        show_trade(report)
