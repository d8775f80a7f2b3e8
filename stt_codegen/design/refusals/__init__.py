"""Why no tube is found, which option would have to change, and how far."""

from stt_codegen.design.refusals.reasons import explain_refusal

__all__ = ["explain_refusal"]
