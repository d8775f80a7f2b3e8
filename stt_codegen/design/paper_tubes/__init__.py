"""Designs with the paper's own functions: adaptive (sound, searched for) and literal (the printed rule)."""

from stt_codegen.design.paper_tubes.adaptive_search import adaptive
from stt_codegen.design.paper_tubes.literal import OVERSHOOT, literal

__all__ = ["OVERSHOOT", "adaptive", "conflict_windows", "literal"]
