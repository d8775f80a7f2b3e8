"""A compiler of any target language, run on emitted code."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable

from stt_codegen.errors import SttError


def run_compiler(arguments: Iterable[str], **environment: str) -> None:
    """Run a compiler, of C or Rust; its messages become the error when it fails. Raises `SttError`."""
    command = list(arguments)
    result = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **environment})
    if result.returncode != 0:
        message = result.stderr.strip() or f"it said nothing, and ended with {result.returncode}; does it compile anything?"
        raise SttError(f"{command[0]} refused the emitted code:\n{message}")
