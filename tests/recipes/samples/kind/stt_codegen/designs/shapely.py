"""What a shapely design is: the splines of a refined one, of which only shapes are asked."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import ClassVar

from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs.refined import RefinedDesign


@dataclass(frozen=True)
class ShapelyDesign(RefinedDesign):
    """A shapely tube, with the numbers of a refined one."""

    kind: ClassVar[DesignKind] = "shapely"

    @classmethod
    def of(cls, design: RefinedDesign) -> ShapelyDesign:
        """Return the shapely tube with the numbers of a refined one."""
        return cls(**asdict(design))
