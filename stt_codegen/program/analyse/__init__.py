"""Readers that compute about a Program: ranges, rounding errors, costs, enclosures in ball arithmetic, comparisons."""

from stt_codegen.program.analyse.ball_arithmetic import Ball, ball, hull
from stt_codegen.program.analyse.balls import Enclosure
from stt_codegen.program.analyse.comparisons import comparisons
from stt_codegen.program.analyse.cost import cost_of, table_bytes
from stt_codegen.program.analyse.exact_logarithm import logarithm
from stt_codegen.program.analyse.ranges import OutOfRange, ranges
from stt_codegen.program.analyse.rounding import Inexact, rounding_error
from stt_codegen.program.analyse.running import Runner

__all__ = [
    "Ball",
    "Enclosure",
    "Inexact",
    "OutOfRange",
    "Runner",
    "ball",
    "comparisons",
    "cost_of",
    "exact_logarithm",
    "hull",
    "logarithm",
    "ranges",
    "rounding_error",
    "table_bytes",
]
