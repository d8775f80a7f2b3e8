"""`prove`: prove the lemma book, or evaluate the bounds of a task."""

from __future__ import annotations

import json as _json
from pathlib import Path
from typing import Annotated, Any

import typer

from stt_codegen.cli.options import (
    DesignOption,
    EffortOption,
    Json,
    Latency,
    Noise,
    PlantOption,
    ScalarOption,
    effort_for,
    patience,
    print_json,
    print_line,
    say,
)
from stt_codegen.errors import BadInput

SIZE_LIMIT = 16_000_000  # bytes of a file that is compared
BOOK = Path("generated/lemmas.md")  # where a repository keeps the book


def prove(
    task: Annotated[
        Path | None, typer.Argument(readable=False, metavar="[TASK]", help="a task file; without one, the lemma book")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="PATH",
            help="the book's page, .md or .tex (default: generated/lemmas.md); with TASK, the folder of <name>.bounds.json",
        ),
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="compare with what is on disk, instead of writing it")] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="prove all lemmas again, even with the same sources")] = False,
    plant: PlantOption = None,
    noise: Noise = None,
    latency: Latency = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    json: Json = False,
    effort: EffortOption = None,
) -> None:
    """Prove or refute the lemmas that controllers rest on, about the printed expressions; with a TASK, evaluate the hypotheses
    and bounds for its tube and plant. Exit code 1 when a lemma is open or a hypothesis fails."""
    if task is None:
        task_options = (plant, noise or None, latency or None, design, scalar, effort)
        if any(option is not None for option in task_options):
            options = "--plant, --noise, --latency, --design, --scalar and --effort"
            raise BadInput(f"prove: {options} belong to a TASK; the book is about every task")
        if out is None and not BOOK.is_file():
            raise BadInput(f"prove: there is no {BOOK} here, which the book replaces; say with --out where it goes (.md or .tex)")
        good = _prove_book(out or BOOK, check, fresh, json)
    else:
        if fresh:
            raise BadInput("prove: --fresh is for the lemma book; bounds of a TASK are always computed again")
        from stt_codegen.pipeline import build

        with patience(f"designing {task}"):
            controller = build(task, design, scalar, effort=effort_for(task, effort, has_uncertified=False))
        good = _prove_task(controller, plant, (noise, latency), folder=out or Path(), check=check, as_json=json)
    if not good:
        raise typer.Exit(1)


def _prove_book(out: Path, check: bool, fresh: bool, json: bool) -> bool:
    """Prove the lemmas and write the book, or compare it with what is on disk; return whether all is well."""
    from stt_codegen.files import write_files
    from stt_codegen.lemmas import Verdict, page, prove_all

    if out.suffix not in (".md", ".tex"):
        raise BadInput(f"--out {out}: the book is written as .md or .tex")
    entries = prove_all(lambda title: say(f"  {title}"), fresh)
    text = page(entries, out.suffix).encode()
    still_open = [e for e in entries if e.verdict is Verdict.OPEN]
    differs = check and _content(out) != text
    if not check:
        write_files(out.parent, {out.name: text})
    if json:
        rows = [
            {"lemma": e.lemma.name, "verdict": e.verdict.value, "method": e.outcome.method, "evidence": list(e.outcome.evidence)}
            for e in entries
        ]
        print_json({"lemmas": rows, "open": len(still_open), "page_differs": differs})
    else:
        for verdict in Verdict:
            print(f"{sum(e.verdict is verdict for e in entries):4d} {verdict.value}")
        for e in still_open:
            print(f"open: {e.lemma.name}: {'; '.join(e.outcome.evidence)}")
        print_line(f"{out}: {_file_state(out, check, differs)}")
    return not still_open and not differs


def _content(path: Path) -> bytes | None:
    """Return what a written file has; None where there is none."""
    from stt_codegen.files import read_input

    return read_input(path, SIZE_LIMIT, "give another --out") if path.is_file() else None


def _file_state(path: Path, check: bool, differs: bool) -> str:
    if differs:
        return f"{'differs' if path.is_file() else 'is missing'}; run without --check to write it"
    return "up to date" if check else "written"


def _prove_task(
    controller: Any, plant: str | None, errors: tuple[float | None, float | None], *, folder: Path, check: bool, as_json: bool
) -> bool:
    """Evaluate hypotheses and bounds of a task and write them, or compare them with the file; return whether all is well.

    errors: noise and latency; None is the task's.
    """
    from stt_codegen.cli.show import show_bounds
    from stt_codegen.files import write_files
    from stt_codegen.plants import plant_of
    from stt_codegen.report import Analysis

    task = controller.task
    model = None if plant is None else plant_of(plant, task.dimension, task.order)
    with patience(f"bounds of {task.name}"):
        report = Analysis(controller, model, *errors).report()
    name = f"{task.name}.bounds.json"
    text = (_json.dumps(report.document(), indent=2) + "\n").encode()
    path = folder / name
    differs = check and _content(path) != text
    if not check:
        write_files(folder, {name: text})
    if as_json:
        print_json({**report.document(), "file_differs": differs})
    else:
        show_bounds(report)
        print_line(f"{path}: {_file_state(path, check, differs)}")
    return report.all_hypotheses_hold and not differs
