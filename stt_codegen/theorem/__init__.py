"""Theorems for Coq about a certified controller: read the shipped files, write `<p>.v`, run coqc. The Coq library is proof/."""

from stt_codegen.theorem.coq import check_theorems
from stt_codegen.theorem.text import theorem_text

__all__ = ["check_theorems", "theorem_text"]
