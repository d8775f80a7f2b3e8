"""The list of target languages."""

from __future__ import annotations

from stt_codegen.program.targets import c, python, rust
from stt_codegen.program.targets.target import TargetLanguage

TARGETS: tuple[TargetLanguage, ...] = (c.TARGET, python.TARGET, rust.TARGET)  # in the order in which their files are listed


def optional_targets() -> list[TargetLanguage]:
    """Return the languages that a task has to ask for."""
    return [target for target in TARGETS if target.option]


def targets_of(emit: object) -> list[TargetLanguage]:
    """Return the languages that a task is printed in: those that are always printed, and those that its table [emit] asks for."""
    return [target for target in TARGETS if not target.option or getattr(emit, target.key)]
