"""The report page: one HTML file with scene, drive, evidence and bill of materials."""

from stt_codegen.report.page.evidence import Check, evidence
from stt_codegen.report.page.page import page

__all__ = ["Check", "evidence", "page"]
