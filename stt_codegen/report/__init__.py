"""What is said of a controller: analyses, bounds, notes, pictures, one page."""

from stt_codegen.report.analysis import Analysis
from stt_codegen.report.bounds import BoundsReport, Sampling, above_float, below_float
from stt_codegen.report.figures import DesignReport, TradeReport, design_report, input_report, trade_report
from stt_codegen.report.notes import task_notes
from stt_codegen.report.outlines import Plane, outline
from stt_codegen.report.sentences import few, sampling_lines, time_told

__all__ = [
    "Analysis",
    "BoundsReport",
    "DesignReport",
    "Plane",
    "Sampling",
    "TradeReport",
    "above_float",
    "below_float",
    "design_report",
    "few",
    "input_report",
    "outline",
    "page",
    "pictures",
    "sampling_lines",
    "task_notes",
    "time_told",
    "trade_report",
]
