"""Rust: one `no_std` module of safe code, and a crate around it."""

from collections.abc import Callable
from typing import Any

from stt_codegen.program.targets.rust.printer import RustPrinter
from stt_codegen.program.targets.target import Emitted, Layout, TargetLanguage

__all__ = ["TARGET", "RustPrinter", "runner"]

# Reserved words of all editions, and crates that every program has.
RUST_WORDS = frozenset(
    """Self abstract alloc as async await become box break const continue core crate do dyn else enum extern false final fn
    for gen if impl in let libm loop macro match mod move mut override priv proc_macro pub ref return self static std
    struct super test trait true try type typeof union unsafe unsized use virtual where while yield""".split()
)


def _runner() -> Callable[[Emitted], Any]:
    from stt_codegen.program.targets.rust.runner import CompiledRust, find_rustc

    find_rustc()
    return CompiledRust


TARGET = TargetLanguage(
    key="rust",
    title="Rust",
    suffixes=(".rs",),
    printer=RustPrinter,
    words=RUST_WORDS,
    words_are="a reserved word or a crate of Rust",
    option="adds <name>.rs, a no_std module",
    runner=_runner,
    package=Layout(
        sources={".rs": "src/lib.rs"},
        templates={"Cargo.toml": "Cargo.toml.j2"},
        selftest=("tests/selftest.rs", "selftest.rs.j2"),
    ),
)
