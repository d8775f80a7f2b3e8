"""Write the report page: one HTML file with views of the tube, the C to drive, evidence and a bill of materials."""

from stt_codegen.report.page.evidence import Check, evidence
from stt_codegen.report.page.page import page

__all__ = ["Check", "evidence", "page"]
