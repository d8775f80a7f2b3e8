"""The text of emitted files: C, Python, Rust, certificate, self-test."""

from stt_codegen.emit.driven import adapter_source, cycle_literal, driven_sources, plant_source
from stt_codegen.emit.extras import extra_files
from stt_codegen.emit.naming import (
    file_names,
    guard_name,
    phase_name,
    selftest_name,
    spelled_name,
    unwrap_name,
    wrap_name,
)
from stt_codegen.emit.render import Files, clock_words, design_hash, notice, render
from stt_codegen.emit.selftest import selftest_suites

__all__ = [
    "Files",
    "adapter_source",
    "clock_words",
    "cycle_literal",
    "design_hash",
    "driven_sources",
    "extra_files",
    "file_names",
    "guard_name",
    "notice",
    "phase_name",
    "plant_source",
    "render",
    "selftest_name",
    "selftest_suites",
    "spelled_name",
    "unwrap_name",
    "wrap_name",
]
