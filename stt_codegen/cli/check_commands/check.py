"""`check`: build every recorded controller again and compare it with its files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import Json, counted, print_json, print_line, say


def check(
    folder: Annotated[Path, typer.Argument(metavar="[DIR]", help="the folder of MANIFEST.json")] = Path("generated"),
    accept: Annotated[bool, typer.Option("--accept", help="write what the tool makes now, instead of comparing")] = False,
    json: Json = False,
) -> None:
    """Build every recorded controller again and compare with the files on disk, both ways. Exit code 1 on any difference."""
    from stt_codegen.record import check as checks

    progress = (lambda name: say(f"  {name}")) if sys.stderr.isatty() else (lambda _: None)
    if accept:
        written, dropped = checks.accept(folder, progress)
        note = f", {dropped} dropped (their task files are gone)" if dropped else ""
        print_json({"written": written, "dropped": dropped}) if json else print_line(
            f"{folder}: {counted(written, 'folder')} written{note}"
        )
        return
    differences = checks.check(folder, progress)
    tools = checks.changed_tools(folder)
    if json:
        print_json(
            {
                "differences": [
                    {"path": d.path, "what": d.problem, "numbers": d.numbers, "diff": list(d.diff)} for d in differences
                ],
                "changed_tools": tools,
            }
        )
    else:
        for d in differences:
            print_line(f"{d.path}: {d.problem}" + (f" ({d.numbers})" if d.numbers else ""))
            for line in d.diff:
                print_line(f"    {line}")
        for line in tools:
            print_line(f"note: other version than recorded: {line}")
        if differences:
            count = counted(len(differences), "difference")
            print()
            print_line(f"{count}. To accept what the tool makes now:  stt-codegen check {folder} --accept")
        else:
            print_line(f"{folder}: {counted(checks.folder_count(folder), 'folder')}, no difference")
    if differences:
        raise typer.Exit(1)
