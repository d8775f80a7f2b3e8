"""The checker as one file, `checker.pyz`, which Python runs: python3 checker.pyz TASK.toml CONTROLLER.c CERTIFICATE.json.

    python -m stt_codegen.checker.archive FILE        # writes it

It holds the folder's `__main__.py` and `stt_checker/`. The bytes depend on nothing else: members are sorted, stored without
compression, and have no times. Packages have it among their extras, and the page for an assessor runs it.
"""

from __future__ import annotations

import io
import sys
import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

ARCHIVE_NAME = "checker.pyz"
INTERPRETER_LINE = b"#!/usr/bin/env python3\n"
FIRST_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest that a member can have
READABLE = 0o100644 << 16


def members() -> Mapping[str, bytes]:
    """Return the files of the archive by name: the program, its package and the listings."""
    folder = Path(__file__).parent
    paths = [folder / "__main__.py", *(p for p in (folder / "stt_checker").iterdir() if p.suffix in (".py", ".c"))]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(paths)}


@cache
def archive_bytes() -> bytes:
    """Return the bytes of `checker.pyz`."""
    data = io.BytesIO()
    data.write(INTERPRETER_LINE)
    with zipfile.ZipFile(data, "w", zipfile.ZIP_STORED) as file:
        for name, text in members().items():
            member = zipfile.ZipInfo(name, FIRST_TIME)
            member.create_system, member.external_attr = 3, READABLE  # as on Unix, wherever it is made
            file.writestr(member, text)
    return data.getvalue()


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(archive_bytes())
