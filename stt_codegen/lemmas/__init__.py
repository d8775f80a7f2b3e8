"""The lemma book: what the certificates rest on, proved about the Program and the code that evaluates it.

Large because the proofs of a whole book are here; no other room imports a family.
"""

from stt_codegen.lemmas.book import page, prove_all
from stt_codegen.lemmas.cache import folder
from stt_codegen.lemmas.lemma import Verdict

__all__ = ["Verdict", "folder", "page", "prove_all"]
