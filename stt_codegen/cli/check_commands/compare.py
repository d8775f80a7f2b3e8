"""`compare`: compare every backend with the reference."""

from __future__ import annotations

from typing import Annotated

import typer

from stt_codegen.cli.options import DesignOption, EffortOption, Json, TaskFile, effort_for, patience, print_json, say


def compare(
    task: TaskFile,
    design: DesignOption = None,
    points: Annotated[int, typer.Option(min=1, help="random points, beside the edges")] = 10_000,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="the table, also where all agree")] = False,
    json: Json = False,
    effort: EffortOption = None,
) -> None:
    """Compare CasADi, the Python, and the C in float and double with an independent reference. Exit code 1 beyond a bound."""
    from dataclasses import asdict

    from stt_codegen.errors import about

    with patience(f"comparing {task}"), about(task):
        from stt_codegen.compare import compare as compare_task
        from stt_codegen.pipeline import require_supported
        from stt_codegen.task import load_task

        loaded = load_task(task).with_options(design)
        require_supported(loaded)
        rows = compare_task(loaded, points, say, effort=lambda: effort_for(task, effort, has_uncertified=False))
    good = all(r.holds for r in rows)
    if json:
        print_json({"task": loaded.name, "within_bounds": good, "rows": [{**asdict(r), "holds": r.holds} for r in rows]})
    else:
        from stt_codegen.cli.show import show_agreement, show_rows

        (show_rows if verbose or not good else show_agreement)(f"{loaded.name}, {loaded.tube.design}", rows)
    if not good:
        raise typer.Exit(1)
