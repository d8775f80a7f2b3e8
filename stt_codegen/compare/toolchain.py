"""The system's C compiler, the flags that emitted C must pass, and emitted Python made callable."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterable
from types import ModuleType

from stt_codegen.errors import MissingTool, SttError

# What the emitted C must pass without a warning, with gcc and clang (docs/c.md).
STRICT = tuple(
    "-std=c99 -O2 -pedantic -Wall -Wextra -Werror -Wconversion -Wsign-conversion -Wdouble-promotion -Wfloat-equal -Wshadow "
    "-Wstrict-prototypes -Wmissing-prototypes -Wundef -Wcast-qual -Wvla -ffp-contract=off".split()
)


def find_compiler() -> str:
    """The system's C compiler: $CC, or the first of cc, gcc, clang. Raises `MissingTool`."""
    own = os.environ.get("CC", "")
    for candidate in (own,) if own else ("cc", "gcc", "clang"):
        found = shutil.which(candidate)
        if found:
            return found
    if own:
        raise MissingTool(f"CC names {own!r}, which is not found; set it to the command of a C compiler")
    raise MissingTool("no C compiler found; install gcc or clang (Debian: apt-get install gcc libc6-dev), or set CC")


def run_compiler(arguments: Iterable[str], **environment: str) -> None:
    """Run a compiler, of C or Rust; its messages become the error when it fails. Raises `SttError`."""
    command = list(arguments)
    result = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **environment})
    if result.returncode != 0:
        told = result.stderr.strip() or f"it said nothing, and ended with {result.returncode}; does it compile anything?"
        raise SttError(f"{command[0]} refused the emitted code:\n{told}")


def load_module(name: str, text: bytes) -> ModuleType:
    """A module from the text of a Python file that this package has just made."""
    module = ModuleType(name)
    exec(compile(text, f"{name}.py", "exec"), module.__dict__)
    return module
