"""Target languages: C, Python and Rust, a folder each with printer, templates, reserved words and runner."""

from stt_codegen.program.targets.printer import INDENT
from stt_codegen.program.targets.registry import TARGETS, optional_targets, targets_of
from stt_codegen.program.targets.target import TargetLanguage
from stt_codegen.program.targets.toolchain import run_compiler

__all__ = [
    "INDENT", "TARGETS", "TargetLanguage", "backend", "c", "optional_targets", "python", "run_compiler", "rust", "targets_of",
    "template_files",
]  # fmt: skip
