"""Emulated boards, which run emitted C and Rust under QEMU and simavr; `pil` and `report --board` use them."""

from stt_codegen.board.boards import BOARDS

__all__ = ["BOARDS", "emulated", "summary"]
