"""Why no tube is found: limits, sets that close every route, or times that are in conflict."""

from stt_codegen.design.refusals.reasons import explain_refusal

__all__ = ["explain_refusal"]
