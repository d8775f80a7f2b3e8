"""Standard streams that are closed, full, or in an encoding without some character: no command ends because of them.

A closed stream counts as /dev/null. `prepare_streams` comes before a command opens a file: descriptors 0 to 2 that are free
would go to the next files, and what a C library prints would then go into an output file.
"""

from __future__ import annotations

import io
import os
import sys
import unicodedata
from contextlib import suppress
from typing import TextIO


def prepare_streams() -> None:
    """Occupy descriptors 0 to 2, give Python the streams that it lacks, and let them write characters they lack as escapes."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number, which is this one
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 - until the process ends
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def discard(stream: TextIO) -> None:
    """Send what the stream still has, and all that follows, to /dev/null: else Python tries again when it ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def escape_control_characters(text: str) -> str:
    """Return a text as one line without control characters: those of a path or a value are written as escapes."""
    return "".join(
        character if not unicodedata.category(character).startswith(("C", "Zl", "Zp")) else repr(character)[1:-1]
        for character in text
    )
