"""Programs of controllers, for refined and adaptive tubes and for plants of order 2, and the errors of their arithmetic.

kernels/ has what all functions are built from, the *_frame.py files the public functions, integers/ the controller in integers.
"""

from stt_codegen.controller.adaptive_frame import adaptive_program
from stt_codegen.controller.covered_starts import compute_covered_starts, start_share, without_covered_starts
from stt_codegen.controller.edge_errors import edge_and_rate_errors, edge_error, edge_error_of_design, rate_error
from stt_codegen.controller.probes import lines_program, probe_program
from stt_codegen.controller.refined_frame import refined_program
from stt_codegen.controller.ticks import tick_constants

__all__ = [
    "adaptive_program",
    "compute_covered_starts",
    "edge_and_rate_errors",
    "edge_error",
    "edge_error_of_design",
    "edge_errors",
    "integers",
    "kernels",
    "lines_program",
    "probe_program",
    "rate_error",
    "refined_program",
    "start_share",
    "tick_constants",
    "without_covered_starts",
]
