"""Reports about a controller: what is proved of its closed loop, notes on its task, pictures, and a page of HTML."""

from stt_codegen.report.analysis import Analysis
from stt_codegen.report.bounds import BoundsReport, SamplingReport, round_down, round_up
from stt_codegen.report.figures import (
    DesignReport,
    TradeReport,
    control_notes,
    design_report,
    input_report,
    trade_report,
)
from stt_codegen.report.notes import controller_notes
from stt_codegen.report.outlines import Plane, outline
from stt_codegen.report.sentences import format_numbers, format_time, sampling_lines

__all__ = [
    "Analysis",
    "BoundsReport",
    "DesignReport",
    "Plane",
    "SamplingReport",
    "TradeReport",
    "control_notes",
    "controller_notes",
    "design_report",
    "format_numbers",
    "format_time",
    "input_report",
    "outline",
    "page",
    "pictures",
    "round_down",
    "round_up",
    "sampling_lines",
    "trade_report",
]
