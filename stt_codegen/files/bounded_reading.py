"""Read a file that may be of any size, or no file at all: within a bound, and without waiting for what never comes.

A pipe (`<(command)`, /dev/stdin) is read as a file is; a device without an end is refused at the bound.
"""

from __future__ import annotations

import os
import select
import stat
from pathlib import Path

from stt_codegen.errors import BadInput

PIECE = 1 << 16  # bytes that are read at once
PIPE_WAIT_LIMIT = 10.0  # seconds for which nothing may come from a pipe


def read_input(path: Path, limit: int, remedy: str) -> bytes:
    """Return the content of a file of at most `limit` bytes.

    remedy: what to do instead, the end of the message. Raises `BadInput` where the file cannot be read or is larger.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        try:
            data = _read(descriptor, limit)
        finally:
            os.close(descriptor)
    except (OSError, ValueError) as error:  # ValueError: a path with a NUL
        reason = error.strerror if isinstance(error, OSError) else "no such path"
        raise BadInput(f"{path}: cannot be read ({reason}); {remedy}") from None
    if len(data) > limit:
        raise BadInput(f"{path}: has more than {limit:,} bytes; {remedy}")
    return data


def _read(descriptor: int, limit: int) -> bytes:
    """Return what a descriptor has, at most one byte more than `limit`. Raises `OSError` where nothing comes in time."""
    pieces, size = [], 0
    if stat.S_ISFIFO(os.fstat(descriptor).st_mode):
        _wait(descriptor)  # a pipe without a writer reads as one that has ended, and its writer may come later
    while size <= limit:
        try:
            piece = os.read(descriptor, min(PIECE, limit + 1 - size))
        except BlockingIOError:
            _wait(descriptor)
            continue
        if not piece:
            break
        pieces.append(piece)
        size += len(piece)
    return b"".join(pieces)


def _wait(descriptor: int) -> None:
    """Wait until a pipe has something, or its writer has left. Raises `OSError` where neither comes in time."""
    if not select.select([descriptor], [], [], PIPE_WAIT_LIMIT)[0]:
        raise OSError(0, f"nothing came for {PIPE_WAIT_LIMIT:.0f} s")


def decode(path: Path, data: bytes, remedy: str) -> str:
    """Return the text of a file in UTF-8, without a byte order mark. Raises `BadInput`."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: byte {error.start} is not UTF-8; {remedy}") from None
