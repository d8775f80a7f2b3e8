"""P10: whether a tube satisfies its mission, and when it serves each of its entries."""

from stt_codegen.certify.missions.proof import SLICES, certify_mission, cycle_of, kept_off
from stt_codegen.certify.missions.schedule import Served, phases, sentence, served, told_visit

__all__ = ["SLICES", "Served", "certify_mission", "cycle_of", "kept_off", "phases", "sentence", "served", "told_visit"]
