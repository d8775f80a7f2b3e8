"""The mission of a task: named regions, formulas over them, and the grammar of their text."""

from stt_codegen.task.mission.complements import left_over
from stt_codegen.task.mission.formulas import (
    WORDS,
    Always,
    And,
    Eventually,
    Formula,
    In,
    Interval,
    Or,
    Until,
    both,
    regions_of,
    windows_of,
)
from stt_codegen.task.mission.regions import FORMS, AnyRegion, Choice, Entry, State, expanded, states_of, with_states

__all__ = [
    "FORMS",
    "WORDS",
    "Always",
    "And",
    "AnyRegion",
    "Choice",
    "Entry",
    "Eventually",
    "Formula",
    "In",
    "Interval",
    "Or",
    "State",
    "Until",
    "both",
    "expanded",
    "left_over",
    "regions_of",
    "states_of",
    "windows_of",
    "with_states",
]
