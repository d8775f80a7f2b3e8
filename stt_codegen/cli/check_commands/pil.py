"""`pil`: processor in the loop, on an emulated board."""

from __future__ import annotations

from typing import Annotated

import typer

from stt_codegen.board import BOARDS
from stt_codegen.cli.options import (
    DesignOption,
    EffortOption,
    Json,
    ScalarOption,
    TaskFile,
    effort_for,
    one_of,
    patience,
    print_json,
)


def pil(
    task: TaskFile,
    board: Annotated[str, one_of(tuple(BOARDS), "the emulated board")],
    design: DesignOption = None,
    scalar: ScalarOption = None,
    points: Annotated[int, typer.Option(min=1, help="random points, beside the edges")] = 2000,
    rust: Annotated[bool, typer.Option("--rust", help="the emitted Rust in place of the C, on an ARM board")] = False,
    json: Json = False,
    effort: EffortOption = None,
) -> None:
    """Processor in the loop: run the emitted code on an emulated board, compare it with the reference, count each call's cost."""
    from dataclasses import asdict

    with patience(f"running {task} on {board}"):
        from stt_codegen.board.emulated import run_on_board
        from stt_codegen.pipeline import build

        controller = build(
            task, design, scalar, language="rust" if rust else None, effort=effort_for(task, effort, has_uncertified=False)
        )
        rows, costs = run_on_board(controller, BOARDS[board], points, rust)
    good = all(r.holds for r in rows)
    if json:
        compared = [{**asdict(r), "holds": r.holds} for r in rows]
        print_json(
            {
                "task": controller.task.name,
                "board": board,
                "within_bounds": good,
                "rows": compared,
                "calls": {name: cost.document() for name, cost in costs.items()},
            }
        )
    else:
        from stt_codegen.cli.show import show_rows

        show_rows(f"{controller.task.name}, {controller.design.kind}", rows)
        unit = BOARDS[board].unit
        for name, cost in costs.items():
            span = f"{cost.minimum} to {cost.maximum} {unit}, median {cost.median}"
            worst = cost.describe_worst([p.name for p in controller.program.function(name).inputs])
            print(f"  {name}: {span}; {cost.stack} B of stack; worst case at {worst}")
    if not good:
        raise typer.Exit(1)
