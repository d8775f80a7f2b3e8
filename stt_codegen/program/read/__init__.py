"""Readers of emitted text: C back to a Program."""

from stt_codegen.program.read.c import differences

__all__ = ["differences"]
