"""Emulated boards: emitted C and Rust run under QEMU and simavr."""

from stt_codegen.board.boards import BOARDS

__all__ = ["BOARDS", "emulated", "summary"]
