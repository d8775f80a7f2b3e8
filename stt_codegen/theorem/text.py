"""Choose which theorems are written about a controller: about its whole C if Coq can read it, else about its tube and law."""

from __future__ import annotations

from stt_codegen.theorem.controller_theorem import controller_theorem_text, reason_not_covered
from stt_codegen.theorem.reading import read_facts
from stt_codegen.theorem.tube_theorem import tube_theorem_text


def theorem_text(task: bytes, header: bytes, source: bytes, certificate: bytes) -> bytes:
    """Return the text of `<p>.v`. Raises as `read_facts` does."""
    facts = read_facts(task, source, certificate)
    if reason := reason_not_covered(facts, task, header, source):
        return tube_theorem_text(facts, reason)
    return controller_theorem_text(task, header, source, certificate).encode()
