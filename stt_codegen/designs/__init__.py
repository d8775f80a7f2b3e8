"""What a design is, as data: the numbers that fix a tube. How one is found stands in `design/`."""

from stt_codegen.designs.adaptive import POINTS, AdaptiveDesign, Bump, grid_tube, parameters_of, require_adaptive
from stt_codegen.designs.filtered import filtered, pressed, slopes_at_start
from stt_codegen.designs.refined import MOST_BITS, RefinedDesign, require_refined
from stt_codegen.designs.tube import LEAST_WIDTH, LOWER, UPPER, Design, Edge

__all__ = [
    "LEAST_WIDTH",
    "LOWER",
    "MOST_BITS",
    "POINTS",
    "UPPER",
    "AdaptiveDesign",
    "Bump",
    "Design",
    "Edge",
    "RefinedDesign",
    "filtered",
    "grid_tube",
    "parameters_of",
    "pressed",
    "require_adaptive",
    "require_refined",
    "slopes_at_start",
]
