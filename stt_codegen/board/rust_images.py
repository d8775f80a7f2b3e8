"""The objects that put the emitted Rust into a board's image in place of the C, with Rust's core library for that board."""

from __future__ import annotations

import subprocess
import tempfile
from functools import cache
from pathlib import Path

from stt_codegen.errors import MissingTool
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.rust import RustPrinter
from stt_codegen.program.targets.rust.runner import (
    EDITION,
    OPTIMIZED,
    compile_controller_library,
    find_rust_compilers,
    write_c_interface,
)


@cache
def core_library(target: str) -> tuple[str, str]:
    """Return a rustc that can compile for the target, and the path of its core library.

    The library is the installed one, or compiled from its source (about half a minute, once a process). Raises `MissingTool`
    where there is neither.
    """
    for rustc in find_rust_compilers():
        sysroot = subprocess.run([rustc, "--print", "sysroot"], capture_output=True, text=True, check=False)
        root = Path(sysroot.stdout.strip()) / "lib" / "rustlib"
        installed = sorted((root / target / "lib").glob("libcore-*.rlib"))
        if installed:
            return rustc, str(installed[0])
        source = root / "src" / "rust" / "library" / "core" / "src" / "lib.rs"
        if source.is_file():
            return rustc, _compile_core(rustc, target, source)
    raise MissingTool(
        f"{' and '.join(find_rust_compilers())}: no core library for {target}; rustup target add {target}, or its source "
        "(Debian: apt-get install rustc rust-src)"
    )


def _compile_core(rustc: str, target: str, source: Path) -> str:
    """Compile Rust's core library for the target; return its path."""
    library = f"{_process_folder().name}/{target}/libcore.rlib"
    Path(library).parent.mkdir()
    crate = ("--crate-type", "rlib", "--crate-name", "core", "--target", target, *OPTIMIZED)
    run_compiler([rustc, *EDITION, *crate, str(source), "-o", library], RUSTC_BOOTSTRAP="1")
    _compile_empty_builtins(rustc, target, Path(library).parent)
    return library


def _compile_empty_builtins(rustc: str, target: str, folder: Path) -> None:
    """Compile an empty crate `compiler_builtins`, which every other needs; the C compiler's library has its functions."""
    Path(folder, "builtins.rs").write_text("#![feature(compiler_builtins)]\n#![compiler_builtins]\n#![no_std]\n")
    crate = ("--crate-type", "rlib", "--crate-name", "compiler_builtins", "--target", target, "-L", str(folder))
    library = f"{folder}/libcompiler_builtins.rlib"
    run_compiler([rustc, *EDITION, *crate, f"{folder}/builtins.rs", "-o", library], RUSTC_BOOTSTRAP="1")


@cache
def _process_folder() -> tempfile.TemporaryDirectory[str]:
    """Return a folder that exists as long as this process."""
    return tempfile.TemporaryDirectory()


MATH = """#![no_std]
extern "C" {{ {declarations} }}
{definitions}
"""


def board_objects(controller: EmittedController, target: str, folder: Path) -> list[str]:
    """Compile what is linked in place of the emitted C: the emitted Rust, C's interface to it, and the core library.

    A crate `libm` calls the board's C library, so that both languages compute with the same functions. Returns the paths.
    """
    rustc, core = core_library(target)
    program, where = controller.program, str(folder)
    for_target = ("--target", target, "-L", str(Path(core).parent))
    suffix, real = ("f", "f32") if program.scalar == "float" else ("", "f64")
    names = [name + suffix for name in RustPrinter(program).library()]
    arguments = {n: ("x", "y") if n.removesuffix(suffix) == "pow" else ("x",) for n in names}
    parameters = {n: ", ".join(f"{v}: {real}" for v in values) for n, values in arguments.items()}
    declarations = " ".join(f'#[link_name = "{n}"] fn c_{n}({parameters[n]}) -> {real};' for n in names)
    definitions = "\n".join(
        f"#[inline]\npub fn {n}({parameters[n]}) -> {real} {{ unsafe {{ c_{n}({', '.join(arguments[n])}) }} }}" for n in names
    )
    Path(folder, "libm.rs").write_text(MATH.format(declarations=declarations, definitions=definitions))
    mathematics = f"{where}/liblibm.rlib"
    run_compiler(
        [
            rustc,
            *EDITION,
            *OPTIMIZED,
            "--crate-type",
            "rlib",
            "--crate-name",
            "libm",
            *for_target,
            f"{where}/libm.rs",
            "-o",
            mathematics,
        ]
    )
    rlib = compile_controller_library(
        controller, rustc, where, (*for_target, "--extern", f"libm={mathematics}", "--cfg", 'feature="libm"')
    )
    abi, abi_object = write_c_interface(program, where, board=True), f"{where}/abi.o"
    linked = ("--extern", f"{program.prefix}={rlib}", "-L", where)
    run_compiler(
        [rustc, *EDITION, *OPTIMIZED, "--crate-type", "lib", "--emit", "obj", *for_target, *linked, abi, "-o", abi_object]
    )
    return [abi_object, rlib, mathematics, core]
