"""`lag`: the lag, latency and overshoot of a drive, from a recorded step."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import Json, patience, print_json


def lag(
    step: Annotated[
        Path, typer.Argument(readable=False, metavar="STEP.csv", help="a row for every sample: time in s, command, response")
    ],
    latency: Annotated[
        float | None, typer.Option(min=0, help="seconds of dead time, where you know it (default: what needs the least lag)")
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(metavar="T,U,Y", help="columns of time, command and response, by name or number (default: 1,2,3)"),
    ] = None,
    json: Json = False,
) -> None:
    """Read a recorded step of a drive, and print the lag, latency and overshoot that a task may state of it."""
    with patience(f"reading {step}"):
        from stt_codegen.steps import envelope_of, read_record

        names = () if columns is None else tuple(name.strip() for name in columns.split(","))
        envelope = envelope_of(read_record(step, names), latency, str(step))
    if json:
        print_json(envelope.document())
    else:
        from stt_codegen.cli.show import show_envelope

        show_envelope(str(step), envelope)
