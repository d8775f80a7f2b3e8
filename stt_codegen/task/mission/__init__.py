"""The mission of a task: named regions, formulas over them, and the grammar of their text."""

from stt_codegen.task.mission.complements import complement_boxes
from stt_codegen.task.mission.formulas import (
    KEYWORDS,
    Always,
    And,
    Eventually,
    Formula,
    InRegion,
    Interval,
    Or,
    Until,
    conjunction,
    intervals_of,
    regions_of,
)
from stt_codegen.task.mission.regions import (
    FORMS,
    AnyRegion,
    MissionEntry,
    RegionUnion,
    StateFormula,
    expand_unions,
    state_formulas_of,
    with_state_formulas,
)

__all__ = [
    "FORMS",
    "KEYWORDS",
    "Always",
    "And",
    "AnyRegion",
    "Eventually",
    "Formula",
    "InRegion",
    "Interval",
    "MissionEntry",
    "Or",
    "RegionUnion",
    "StateFormula",
    "Until",
    "complement_boxes",
    "conjunction",
    "expand_unions",
    "intervals_of",
    "regions_of",
    "state_formulas_of",
    "with_state_formulas",
]
