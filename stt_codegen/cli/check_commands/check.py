"""`check`: build every recorded controller again and compare it with its files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from stt_codegen.cli.options import Json, counted, print_json, print_line, say


def check(
    folder: Annotated[Path, typer.Argument(readable=False, metavar="[DIR]", help="the folder of MANIFEST.json")] = Path(
        "generated"
    ),
    accept: Annotated[bool, typer.Option("--accept", help="write what the tool makes now, instead of comparing")] = False,
    json: Json = False,
) -> None:
    """Build every recorded controller again and compare with the files on disk, both ways. Exit code 1 on any difference.

    --accept leaves the folder of a task that is refused as it is; the exit code is then that of the first refusal.

    By hashes it says of each folder that differs whether task, files or tool changed, and it names tasks that were never
    recorded.
    """
    from stt_codegen.record import check as checks

    progress = (lambda name: say(f"  {name}")) if sys.stderr.isatty() else (lambda _: None)
    if accept:
        _accept(folder, checks.accept(folder, progress), json)
        return
    result, tools = checks.check(folder, progress), checks.changed_tools(folder)
    print_json(_document(result, tools)) if json else _show(folder, result, tools)
    if result.differences:
        raise typer.Exit(1)


def _accept(folder: Path, accepted: Any, json: bool) -> None:
    """Print what was accepted and which folders stay as they are; then leave with the exit code of the first refusal."""
    refusals = [{"error": str(error), "exit_code": error.exit_code} for error in accepted.refusals]
    if json:
        print_json({"written": accepted.written, "dropped": accepted.removed, "refused": refusals})
    else:
        note = f", {accepted.removed} dropped (their task files are gone)" if accepted.removed else ""
        note += f", {len(refusals)} not written (refused)" if refusals else ""
        print_line(f"{folder}: {counted(accepted.written, 'folder')} written{note}")
    for error in accepted.refusals:
        say(f"stt-codegen: {error}")
    if refusals:
        raise typer.Exit(accepted.refusals[0].exit_code)


def _document(result: Any, tools: list[str]) -> dict[str, Any]:
    """Return the result as JSON data. tools: those with another version than recorded."""
    return {
        "differences": [
            {"path": d.path, "what": d.problem, "numbers": d.numbers, "diff": list(d.diff)} for d in result.differences
        ],
        "folders": [
            {
                "folder": c.folder,
                "task_changed": c.task_changed,
                "tool_changed": c.tool_changed,
                "edited": list(c.edited),
                "missing": list(c.missing),
                "unreadable": list(c.unreadable),
            }
            for c in result.changes
        ],
        "unrecorded_tasks": list(result.unrecorded_tasks),
        "changed_tools": tools,
    }


def _show(folder: Path, result: Any, tools: list[str]) -> None:
    """Print the differences, what changed of each folder, and tasks that were never recorded."""
    from stt_codegen.record import check as checks

    for d in result.differences:
        print_line(f"{d.path}: {d.problem}" + (f" ({d.numbers})" if d.numbers else ""))
        for line in d.diff:
            print_line(f"    {line}")
    for change in result.changes:
        print_line(change.sentence(tools))
    for line in tools:
        print_line(f"note: other version than recorded: {line}")
    for task in result.unrecorded_tasks:
        print_line(f"note: {task} was never recorded; record it:  stt-codegen generate {task} --record {folder}")
    if result.differences:
        count = counted(len(result.differences), "difference")
        print()
        print_line(f"{count}. To accept what the tool makes now:  stt-codegen check {folder} --accept")
    else:
        print_line(f"{folder}: {counted(checks.folder_count(folder), 'folder')}, no difference")
