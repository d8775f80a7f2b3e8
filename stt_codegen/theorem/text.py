"""Which theorems are written about a controller: of its whole C where that is covered, else of its tube and law."""

from __future__ import annotations

from stt_codegen.theorem.controller_theorem import deep, uncovered
from stt_codegen.theorem.reading import facts
from stt_codegen.theorem.tube_theorem import written


def theorem_text(task: bytes, header: bytes, source: bytes, certificate: bytes) -> bytes:
    """The text of `<p>.v`. Raises as `reading.facts` does."""
    found = facts(task, source, certificate)
    if reason := uncovered(found, task, header, source):
        return written(found, reason)
    return deep(task, header, source, certificate).encode()
