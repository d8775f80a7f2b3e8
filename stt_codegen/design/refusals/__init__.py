"""Why no tube is found, and which option would have to change, and how far."""

from stt_codegen.design.refusals.advice import refusal

__all__ = ["refusal"]
