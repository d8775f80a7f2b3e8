"""A controller in integers alone, for boards without a floating-point unit, and the errors of its arithmetic."""

from stt_codegen.controller.integers.constants import build_integer_law
from stt_codegen.controller.integers.curves import H_PIECE_BITS, RECIPROCAL_PIECE_BITS
from stt_codegen.controller.integers.fixed_program import certified_constants, fixed_program
from stt_codegen.controller.integers.integer_errors import largest_law_width, law_error
from stt_codegen.controller.integers.integer_kernels import choose_clock
from stt_codegen.controller.integers.integer_statements import LARGEST_STATE, MARGIN_BITS

__all__ = [
    "H_PIECE_BITS",
    "LARGEST_STATE",
    "MARGIN_BITS",
    "RECIPROCAL_PIECE_BITS",
    "build_integer_law",
    "certified_constants",
    "choose_clock",
    "curves",
    "fixed_program",
    "integer_errors",
    "largest_law_width",
    "law_error",
]
