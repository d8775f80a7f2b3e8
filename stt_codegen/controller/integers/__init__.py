"""A controller in integers alone, for boards without a floating-point unit."""

from stt_codegen.controller.integers.constants import law_of
from stt_codegen.controller.integers.curves import OVER_BITS, RISE_BITS
from stt_codegen.controller.integers.fixed_program import fixed_program
from stt_codegen.controller.integers.frame import FARTHEST, MARGIN_BITS
from stt_codegen.controller.integers.integer_errors import law_error, widest
from stt_codegen.controller.integers.integer_kernels import clock_of

__all__ = [
    "FARTHEST",
    "MARGIN_BITS",
    "OVER_BITS",
    "RISE_BITS",
    "clock_of",
    "curves",
    "fixed_program",
    "integer_errors",
    "law_error",
    "law_of",
    "widest",
]
