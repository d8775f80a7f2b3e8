"""`theorem`: ask Coq whether the theorems about an emitted controller hold."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import Json, TaskFile, patience, print_json, say


def theorem(
    task: TaskFile,
    source: Annotated[Path, typer.Argument(metavar="FILE.c", help="the emitted C file; its certificate lies beside it")],
    json: Json = False,
) -> None:
    """Write the theorems of a refined tube from task, header, C and certificate, and ask coqc whether they hold. Exit code
    1 when one does not, 4 without Coq."""
    from stt_codegen.theorem import ask

    with patience(f"theorems of {source} (and once the library, which takes a minute)"):
        answer = ask(task, source, source.with_suffix(".certificate.json"))
    if json:
        print_json(answer.document())
    else:
        print(f"theorem: {'yes' if answer.holds else 'NO'}: {answer.task}: {answer.what}")
        if answer.holds:
            say(f"axioms, all of Coq's real numbers: {', '.join(name.rpartition('.')[2] for name in answer.axioms)}")
    if not answer.holds:
        raise typer.Exit(1)
