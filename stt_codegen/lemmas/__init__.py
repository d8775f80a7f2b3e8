"""The lemma book: the mathematics that certificates rely on, proved about the Program and about the code that evaluates it.

`stt-codegen prove` runs it. Large because it has all proofs of the book; no other room imports a family.
"""

from stt_codegen.lemmas.book import page, prove_all
from stt_codegen.lemmas.cache import folder
from stt_codegen.lemmas.lemma import Verdict

__all__ = ["Verdict", "folder", "page", "prove_all"]
