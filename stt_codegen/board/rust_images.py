"""The emitted Rust linked into a board's image in place of the C, with Rust's core library for that board."""

from __future__ import annotations

import subprocess
import tempfile
from functools import cache
from pathlib import Path

from stt_codegen.errors import MissingTool
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.rust import RustPrinter
from stt_codegen.program.targets.rust.runner import EDITION, OPTIMIZED, compilers, controller_library, interface


@cache
def core_library(target: str) -> tuple[str, str]:
    """A rustc that can compile for the target, and its core library: the one that is installed, or made from its source (about
    half a minute, once a process). Raises `MissingTool`."""
    for rustc in compilers():
        said = subprocess.run([rustc, "--print", "sysroot"], capture_output=True, text=True, check=False)
        root = Path(said.stdout.strip()) / "lib" / "rustlib"
        installed = sorted((root / target / "lib").glob("libcore-*.rlib"))
        if installed:
            return rustc, str(installed[0])
        source = root / "src" / "rust" / "library" / "core" / "src" / "lib.rs"
        if source.is_file():
            return rustc, _made_core(rustc, target, source)
    raise MissingTool(
        f"{' and '.join(compilers())}: no core library for {target}; rustup target add {target}, or its source "
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


def board_objects(controller: EmittedController, target: str, folder: Path) -> list[str]:
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
    rlib = controller_library(controller, rustc, where, (*to, "--extern", f"libm={mathematics}", "--cfg", 'feature="libm"'))
    abi, made = interface(program, where, board=True), f"{where}/abi.o"
    linked = ("--extern", f"{program.prefix}={rlib}", "-L", where)
    run_compiler([rustc, *EDITION, *OPTIMIZED, "--crate-type", "lib", "--emit", "obj", *to, *linked, abi, "-o", made])
    return [made, rlib, mathematics, core]
