"""P10: whether a tube satisfies its mission, and when it serves each of its entries."""

from stt_codegen.certify.missions.proof import SLICES, avoiding_pieces, certify_mission, cycle_of
from stt_codegen.certify.missions.schedule import (
    ServedEntry,
    describe_entry,
    describe_visit,
    has_momentary_visit,
    phases,
    served_entries,
)

__all__ = [
    "SLICES",
    "ServedEntry",
    "avoiding_pieces",
    "certify_mission",
    "cycle_of",
    "describe_entry",
    "describe_visit",
    "has_momentary_visit",
    "phases",
    "served_entries",
]
