"""`certify`: run the stand-alone checker on a task, a C file and a certificate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import Json, TaskFile, patience, print_json


def certify(
    task: TaskFile,
    source: Annotated[Path, typer.Argument(readable=False, metavar="FILE.c", help="the emitted C file")],
    certificate: Annotated[Path, typer.Argument(readable=False, metavar="CERTIFICATE", help="its .certificate.json")],
    json: Json = False,
) -> None:
    """Repeat the proof of a refined tube from the C file alone, by the stand-alone checker. Exit code 1 when it fails."""
    with patience(f"checking {source}"):
        from stt_codegen.checker import verdict
        from stt_codegen.errors import BadInput

        message, code = verdict([str(task), str(source), str(certificate)])
    if code == BadInput.exit_code:
        raise BadInput(message)
    if json:
        print_json({"holds": code == 0, "message": message})
    else:
        print(message)
    if code:
        raise typer.Exit(code)
