"""A certified controller's theorems for Coq: read what is shipped, write `<p>.v`, ask coqc. The library is proof/."""

from stt_codegen.theorem.asking import ask
from stt_codegen.theorem.text import theorem_text

__all__ = ["ask", "theorem_text"]
