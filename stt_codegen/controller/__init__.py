"""Programs of controllers: the frames around the kernels, for refined and adaptive tubes and for plants of order 2."""

from stt_codegen.controller.adaptive_frame import adaptive_program
from stt_codegen.controller.covered_starts import start_share, starts_of, without_covered_starts
from stt_codegen.controller.edge_errors import edge_error, edge_error_of_design, errors_of_tube, rate_error
from stt_codegen.controller.probes import lines_program, probe_program
from stt_codegen.controller.refined_frame import refined_program
from stt_codegen.controller.ticks import ticks_of

__all__ = [
    "adaptive_program",
    "edge_error",
    "edge_error_of_design",
    "edge_errors",
    "errors_of_tube",
    "integers",
    "kernels",
    "lines_program",
    "probe_program",
    "rate_error",
    "refined_program",
    "start_share",
    "starts_of",
    "ticks_of",
    "without_covered_starts",
]
