"""`certify`: run the stand-alone checker on a task, a C file and a certificate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import Json, TaskFile, print_json


def certify(
    task: TaskFile,
    source: Annotated[Path, typer.Argument(metavar="FILE.c", help="the emitted C file")],
    certificate: Annotated[Path, typer.Argument(metavar="CERTIFICATE", help="its .certificate.json")],
    json: Json = False,
) -> None:
    """Repeat the proof of a refined tube from the C file alone, by the stand-alone checker. Exit code 1 when it fails."""
    import contextlib
    import io

    from stt_codegen.checker import check_files
    from stt_codegen.errors import BadInput

    verdict, problem = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(verdict), contextlib.redirect_stderr(problem):
        code = check_files([str(task), str(source), str(certificate)])
    if problem.getvalue():
        raise BadInput(problem.getvalue().strip())
    if json:
        print_json({"holds": code == 0, "message": verdict.getvalue().strip()})
    else:
        print(verdict.getvalue(), end="")
    if code:
        raise typer.Exit(code)
