"""What commands print, as frozen dataclasses: cli/show.py prints them for people, `document()` gives the data of --json."""

from stt_codegen.report.figures.control_notes import assumed_words, control_notes
from stt_codegen.report.figures.design_figures import DesignReport, clamp_input, design_report, input_report
from stt_codegen.report.figures.trade import TradeReport, trade_report

__all__ = [
    "DesignReport",
    "TradeReport",
    "assumed_words",
    "clamp_input",
    "control_notes",
    "design_report",
    "input_report",
    "trade_report",
]
