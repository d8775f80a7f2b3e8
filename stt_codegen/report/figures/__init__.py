"""What a command prints of more than a line, as data: frozen dataclasses with `document()`, for people and for --json."""

from stt_codegen.report.figures.design_figures import DesignReport, clamp_input, design_report, input_report
from stt_codegen.report.figures.trade import TradeReport, trade_report

__all__ = ["DesignReport", "TradeReport", "clamp_input", "design_report", "input_report", "trade_report"]
