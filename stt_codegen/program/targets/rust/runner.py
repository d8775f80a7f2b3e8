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
    """Return the path of the Rust compiler: $RUSTC, or rustc. Raises `MissingTool`."""
    return find_rust_compilers()[0]


def find_rust_compilers() -> list[str]:
    """Return $RUSTC alone, or every rustc on the path: rustup's and the distribution's may both be. Raises `MissingTool`."""
    folders = [None] if os.environ.get("RUSTC") else os.get_exec_path()
    paths = [shutil.which(os.environ.get("RUSTC") or "rustc", path=folder) for folder in folders]
    if not any(paths):
        raise MissingTool("no Rust compiler found; install rustc (Debian: apt-get install rustc, or rustup), or set RUSTC")
    return [path for path in dict.fromkeys(paths) if path]


class CompiledRust(CompiledC):
    """The emitted Rust, warnings denied, with the standard library's mathematics."""

    def __init__(self, controller: Emitted) -> None:
        rustc = find_rustc()
        with tempfile.TemporaryDirectory() as folder:
            compiled = f"{folder}/controller.so"
            rlib = compile_controller_library(controller, rustc, folder, ("--cfg", 'feature="std"'))
            abi = write_c_interface(controller.program, folder, board=False)
            extern = ("--extern", f"{controller.program.prefix}={rlib}")
            run_compiler([rustc, *EDITION, *OPTIMIZED, "--crate-type", "cdylib", *extern, abi, "-o", compiled])
            super().__init__(controller, library=Path(compiled))
        self.name = f"Rust {self.scalar}"


def compile_controller_library(controller: Emitted, rustc: str, folder: str, flags: Sequence[str]) -> str:
    """Compile the emitted file into a library of Rust in this folder, and return its path."""
    prefix = controller.program.prefix
    source, library = Path(folder, f"{prefix}.rs"), f"{folder}/lib{prefix}.rlib"
    source.write_bytes(controller.files[source.name])
    crate_flags = ("-D", "warnings", "--crate-type", "rlib", "--crate-name", prefix)
    run_compiler([rustc, *EDITION, *OPTIMIZED, *crate_flags, *flags, str(source), "-o", library])
    return library


def write_c_interface(program: Program, folder: str, board: bool) -> str:
    """Write a Rust file that gives the public functions C's names and parameters, and return its path.

    board: whether it has a panic handler too, which a board needs.
    """
    path = Path(folder, "abi.rs")
    path.write_text(template("rust/abi.rs.j2").render(prefix=program.prefix, functions=program.functions, board=board))
    return str(path)
