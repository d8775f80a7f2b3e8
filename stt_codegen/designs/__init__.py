"""What a design is, as data: the numbers that fix a tube. How one is found stands in `design/`."""

from stt_codegen.designs.adaptive import AdaptiveDesign, Bump
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import LEAST_WIDTH, LOWER, UPPER, Edge

__all__ = ["LEAST_WIDTH", "LOWER", "UPPER", "AdaptiveDesign", "Bump", "Edge", "RefinedDesign"]
