"""Every backend (CasADi, and each target language) against the NumPy reference, within derived bounds."""

from stt_codegen.compare.comparison import compare, compare_backend
from stt_codegen.compare.comparison_rows import ComparisonRow

__all__ = ["ComparisonRow", "compare", "compare_backend"]
