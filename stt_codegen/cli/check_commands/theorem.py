"""`theorem`: ask Coq whether the theorems about an emitted controller hold."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import Json, TaskFile, patience, print_json, say


def theorem(
    task: TaskFile,
    source: Annotated[
        Path, typer.Argument(readable=False, metavar="FILE.c", help="the emitted C file; its certificate lies beside it")
    ],
    json: Json = False,
) -> None:
    """Write the theorems of a refined tube from task, header, C and certificate, and ask coqc whether they hold. Exit code
    1 when one does not, 4 without Coq."""
    from stt_codegen.theorem import check_theorems

    with patience(f"theorems of {source} (and once the library, which takes a minute)"):
        verdict = check_theorems(task, source, source.with_suffix(".certificate.json"))
    if json:
        print_json(verdict.document())
    else:
        print(f"theorem: {'yes' if verdict.holds else 'NO'}: {verdict.task}: {verdict.message}")
        if verdict.holds:
            say(f"axioms, all of Coq's real numbers: {', '.join(name.rpartition('.')[2] for name in verdict.axioms)}")
    if not verdict.holds:
        raise typer.Exit(1)
