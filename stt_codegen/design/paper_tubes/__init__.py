"""Designs with the paper's own functions: adaptive (sound, from a search) and literal (the printed rule)."""

from stt_codegen.design.paper_tubes.adaptive_search import design_adaptive
from stt_codegen.design.paper_tubes.literal import OVERSHOOT, design_literal

__all__ = ["OVERSHOOT", "conflict_windows", "design_adaptive", "design_literal"]
