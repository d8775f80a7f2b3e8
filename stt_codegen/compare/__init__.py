"""Every backend (CasADi, and each target language) against the NumPy reference, within derived bounds."""

from stt_codegen.compare.comparison import Row, compare, compare_backend

__all__ = ["Row", "compare", "compare_backend"]
