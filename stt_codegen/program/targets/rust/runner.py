"""The emitted Rust made callable: by rustc into a library with C's interface."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from stt_codegen.errors import MissingTool
from stt_codegen.program.nodes import Program
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.program.targets.target import Emitted
from stt_codegen.program.targets.template_files import template
from stt_codegen.program.targets.toolchain import run_compiler

EDITION = ("--edition", "2021")
OPTIMIZED = ("-C", "opt-level=3", "-C", "panic=abort", "-C", "codegen-units=1")


def find_rustc() -> str:
    """The Rust compiler: $RUSTC, or rustc. Raises `MissingTool`."""
    return compilers()[0]


def compilers() -> list[str]:
    """$RUSTC alone, or every rustc on the path: rustup's and the distribution's may stand side by side. Raises `MissingTool`."""
    folders = [None] if os.environ.get("RUSTC") else os.get_exec_path()
    found = [shutil.which(os.environ.get("RUSTC") or "rustc", path=folder) for folder in folders]
    if not any(found):
        raise MissingTool("no Rust compiler found; install rustc (Debian: apt-get install rustc, or rustup), or set RUSTC")
    return [one for one in dict.fromkeys(found) if one]


class CompiledRust(CompiledC):
    """The emitted Rust, warnings denied, with the standard library's mathematics."""

    def __init__(self, controller: Emitted) -> None:
        rustc = find_rustc()
        with tempfile.TemporaryDirectory() as folder:
            made = f"{folder}/controller.so"
            rlib = controller_library(controller, rustc, folder, ("--cfg", 'feature="std"'))
            abi = interface(controller.program, folder, board=False)
            extern = ("--extern", f"{controller.program.prefix}={rlib}")
            run_compiler([rustc, *EDITION, *OPTIMIZED, "--crate-type", "cdylib", *extern, abi, "-o", made])
            super().__init__(controller, library=Path(made))
        self.name = f"Rust {self.scalar}"


def controller_library(controller: Emitted, rustc: str, folder: str, flags: Sequence[str]) -> str:
    """The emitted file, compiled; the path of what was made."""
    prefix = controller.program.prefix
    source, made = Path(folder, f"{prefix}.rs"), f"{folder}/lib{prefix}.rlib"
    source.write_bytes(controller.files[source.name])
    wanted = ("-D", "warnings", "--crate-type", "rlib", "--crate-name", prefix)
    run_compiler([rustc, *EDITION, *OPTIMIZED, *wanted, *flags, str(source), "-o", made])
    return made


def interface(program: Program, folder: str, board: bool) -> str:
    """The path of a Rust file with C's names and parameters for the public functions; for a board with a panic's end."""
    path = Path(folder, "abi.rs")
    path.write_text(template("rust/abi.rs.j2").render(prefix=program.prefix, functions=program.functions, board=board))
    return str(path)
