"""What a design is, as data: the numbers that fix a tube. The search for these numbers is in `design/`."""

from stt_codegen.designs.adaptive import (
    ALPHA_STEPS,
    GRID_STEPS,
    AdaptiveDesign,
    Bump,
    grid_tube,
    parameters_of,
    require_adaptive,
    uncertified_alpha_step,
)
from stt_codegen.designs.filtered import demanded_accelerations, filtered_edges, slopes_at_start
from stt_codegen.designs.refined import COEFFICIENT_BIT_LIMIT, RefinedDesign, require_refined
from stt_codegen.designs.tube import LOWER, MINIMUM_WIDTH, NARROWEST_WIDTH, UPPER, Design, Edge, for_any_design, require_design

__all__ = [
    "ALPHA_STEPS",
    "COEFFICIENT_BIT_LIMIT",
    "GRID_STEPS",
    "LOWER",
    "MINIMUM_WIDTH",
    "NARROWEST_WIDTH",
    "UPPER",
    "AdaptiveDesign",
    "Bump",
    "Design",
    "Edge",
    "RefinedDesign",
    "demanded_accelerations",
    "filtered_edges",
    "for_any_design",
    "grid_tube",
    "parameters_of",
    "require_adaptive",
    "require_design",
    "require_refined",
    "slopes_at_start",
    "uncertified_alpha_step",
]
