"""The emitted Rust made callable: by rustc into a library with C's interface, for this machine or linked into a board's image."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from stt_codegen.compare.backends import CompiledC
from stt_codegen.compare.toolchain import run_compiler
from stt_codegen.emit.naming import rust_name
from stt_codegen.emit.render import template
from stt_codegen.errors import MissingTool
from stt_codegen.pipeline import Controller
from stt_codegen.program import Program
from stt_codegen.program.print.rust import RustPrinter

EDITION = ("--edition", "2021")
OPTIMIZED = ("-C", "opt-level=3", "-C", "panic=abort", "-C", "codegen-units=1")


def find_rustc() -> str:
    """The Rust compiler: $RUSTC, or rustc. Raises `MissingTool`."""
    return _compilers()[0]


def _compilers() -> list[str]:
    """$RUSTC alone, or every rustc on the path: rustup's and the distribution's may stand side by side. Raises `MissingTool`."""
    folders = [None] if os.environ.get("RUSTC") else os.get_exec_path()
    found = [shutil.which(os.environ.get("RUSTC") or "rustc", path=folder) for folder in folders]
    if not any(found):
        raise MissingTool("no Rust compiler found; install rustc (Debian: apt-get install rustc, or rustup), or set RUSTC")
    return [one for one in dict.fromkeys(found) if one]


class CompiledRust(CompiledC):
    """The emitted Rust, warnings denied, with the standard library's mathematics."""

    def __init__(self, controller: Controller) -> None:
        rustc = find_rustc()
        with tempfile.TemporaryDirectory() as folder:
            made = f"{folder}/controller.so"
            rlib = _controller(controller, rustc, folder, ("--cfg", 'feature="std"'))
            abi = _abi(controller.program, folder, board=False)
            extern = ("--extern", f"{controller.program.prefix}={rlib}")
            run_compiler([rustc, *EDITION, *OPTIMIZED, "--crate-type", "cdylib", *extern, abi, "-o", made])
            super().__init__(controller, library=Path(made))
        self.name = f"Rust {self.scalar}"


def _controller(controller: Controller, rustc: str, folder: str, flags: Sequence[str]) -> str:
    """The emitted file, compiled; the path of what was made."""
    prefix = controller.program.prefix
    source, made = Path(folder, rust_name(prefix)), f"{folder}/lib{prefix}.rlib"
    source.write_bytes(controller.files[source.name])
    wanted = ("-D", "warnings", "--crate-type", "rlib", "--crate-name", prefix)
    run_compiler([rustc, *EDITION, *OPTIMIZED, *wanted, *flags, str(source), "-o", made])
    return made


def _abi(program: Program, folder: str, board: bool) -> str:
    path = Path(folder, "abi.rs")
    path.write_text(template("rust/abi.rs.j2").render(prefix=program.prefix, functions=program.functions, board=board))
    return str(path)


# ------------------------------------------------------------------------------------------------ for a board


@cache
def core_library(target: str) -> tuple[str, str]:
    """A rustc that can compile for the target, and its core library: the one that is installed, or made from its source (about
    half a minute, once a process). Raises `MissingTool`."""
    for rustc in _compilers():
        said = subprocess.run([rustc, "--print", "sysroot"], capture_output=True, text=True, check=False)
        root = Path(said.stdout.strip()) / "lib" / "rustlib"
        installed = sorted((root / target / "lib").glob("libcore-*.rlib"))
        if installed:
            return rustc, str(installed[0])
        source = root / "src" / "rust" / "library" / "core" / "src" / "lib.rs"
        if source.is_file():
            return rustc, _made_core(rustc, target, source)
    raise MissingTool(
        f"{' and '.join(_compilers())}: no core library for {target}; rustup target add {target}, or its source "
        "(Debian: apt-get install rustc rust-src)"
    )


def _made_core(rustc: str, target: str, source: Path) -> str:
    made = f"{_kept().name}/{target}/libcore.rlib"
    Path(made).parent.mkdir()
    own = ("--crate-type", "rlib", "--crate-name", "core", "--target", target, *OPTIMIZED, str(source), "-o", made)
    run_compiler([rustc, *EDITION, *own], RUSTC_BOOTSTRAP="1")
    _no_builtins(rustc, target, Path(made).parent)
    return made


def _no_builtins(rustc: str, target: str, folder: Path) -> None:
    """The crate that every other asks for. What would be in it (copying, division) is in the C compiler's own library."""
    Path(folder, "builtins.rs").write_text("#![feature(compiler_builtins)]\n#![compiler_builtins]\n#![no_std]\n")
    own = ("--crate-type", "rlib", "--crate-name", "compiler_builtins", "--target", target, "-L", str(folder))
    made = f"{folder}/libcompiler_builtins.rlib"
    run_compiler([rustc, *EDITION, *own, f"{folder}/builtins.rs", "-o", made], RUSTC_BOOTSTRAP="1")


@cache
def _kept() -> tempfile.TemporaryDirectory[str]:
    """A folder for as long as this process runs."""
    return tempfile.TemporaryDirectory()


MATH = """#![no_std]
extern "C" {{ {declared} }}
{defined}
"""


def board_objects(controller: Controller, target: str, folder: Path) -> list[str]:
    """What is linked in place of the emitted C: objects of the emitted Rust and of C's interface to it, and the core library.
    The crate `libm` stands here for the board's C library, so that both languages compute with the same functions."""
    rustc, core = core_library(target)
    program, where = controller.program, str(folder)
    to = ("--target", target, "-L", str(Path(core).parent))
    suffix, real = ("f", "f32") if program.scalar == "float" else ("", "f64")
    names = [name + suffix for name in RustPrinter(program).library()]
    given = {n: ("x", "y") if n.removesuffix(suffix) == "pow" else ("x",) for n in names}
    typed = {n: ", ".join(f"{v}: {real}" for v in values) for n, values in given.items()}
    declared = " ".join(f'#[link_name = "{n}"] fn c_{n}({typed[n]}) -> {real};' for n in names)
    defined = "\n".join(
        f"#[inline]\npub fn {n}({typed[n]}) -> {real} {{ unsafe {{ c_{n}({', '.join(given[n])}) }} }}" for n in names
    )
    Path(folder, "libm.rs").write_text(MATH.format(declared=declared, defined=defined))
    mathematics = f"{where}/liblibm.rlib"
    run_compiler(
        [rustc, *EDITION, *OPTIMIZED, "--crate-type", "rlib", "--crate-name", "libm", *to, f"{where}/libm.rs", "-o", mathematics]
    )
    rlib = _controller(controller, rustc, where, (*to, "--extern", f"libm={mathematics}", "--cfg", 'feature="libm"'))
    abi, made = _abi(program, where, board=True), f"{where}/abi.o"
    linked = ("--extern", f"{program.prefix}={rlib}", "-L", where)
    run_compiler([rustc, *EDITION, *OPTIMIZED, "--crate-type", "lib", "--emit", "obj", *to, *linked, abi, "-o", made])
    return [made, rlib, mathematics, core]
