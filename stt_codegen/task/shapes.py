"""The tables of a task that say a set: boxes, and polygons in the plane of two axes."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag

from stt_codegen.decimals import decimal
from stt_codegen.task.sets import BoxSet, Point, Prism, hull_of_points
from stt_codegen.task.values import MAX_LABEL, Vector, labels, points

PLANE = 2  # dimensions of a polygon


class Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Box(Table):
    """An axis-aligned box: `lower` and `upper` edges by dimension, in the task's units."""

    lower: Vector
    upper: Vector

    def vectors(self) -> list[tuple[str, Vector]]:
        """What must have one entry for each dimension, by name."""
        return [("lower", self.lower), ("upper", self.upper)]

    def problem(self) -> str | None:
        """What makes these numbers no set, in words; None where they are one."""
        for i, (a, b) in enumerate(zip(self.lower, self.upper, strict=True)):
            if a >= b:
                return f"lower[{i}] = {decimal(a)} is not below upper[{i}] = {decimal(b)}"
        return None

    def convex(self) -> BoxSet:
        """The box as a set."""
        return BoxSet(self.lower, self.upper)


class UnsafeSet(Box):
    """One unsafe set U_j; unnamed sets are called U1, U2, ... in the order of the file."""

    name: str = Field(default="", pattern=r"^[A-Za-z0-9_ .()#+-]*$", max_length=MAX_LABEL)

    def convex(self) -> BoxSet:
        return BoxSet(self.lower, self.upper, self.name)


class UnsafePolygon(Table):
    """One unsafe set U_j: the hull of points in the plane of two axes, whatever the others are."""

    name: str = Field(default="", pattern=r"^[A-Za-z0-9_ .()#+-]*$", max_length=MAX_LABEL)
    vertices: Annotated[tuple[Vector, ...], BeforeValidator(points)] = Field(description="points in any order; their hull counts")
    axes: Annotated[tuple[str, ...], BeforeValidator(labels)] | None = Field(
        default=None, description="the two dimensions, by name; absent: those of a task in the plane"
    )

    def vectors(self) -> list[tuple[str, Vector]]:
        """Nothing here has one entry for each dimension of the task."""
        return []

    def problem(self) -> str | None:
        """What makes these points no set, in words; None where they are one."""
        for k, point in enumerate(self.vertices):
            if len(point) != PLANE:
                return f"vertices[{k}]: has {len(point)} entries; two are needed, one for each of its axes"
        if len(self.corners) <= PLANE:
            return "vertices: have no interior; at least three points that are not on one line are needed"
        return None

    @property
    def corners(self) -> tuple[Point, ...]:
        """Of the hull, in order around it."""
        return hull_of_points([(p[0], p[1]) for p in self.vertices])

    def within(self, space: Box, plane: tuple[int, int]) -> Prism:
        """The set in a state space: in the dimensions that are not its own as long as that, which is all that is asked for."""
        return Prism(self.corners, plane, space.lower, space.upper, self.name)


def _kind_of_set(value: object) -> str:
    """Which of the two a table [[unsafe]] is to be read as."""
    if isinstance(value, UnsafePolygon) or (isinstance(value, dict) and "vertices" in value):
        return "<polygon>"
    return "<box>"


AnyUnsafe = Annotated[
    Annotated[UnsafeSet, Tag("<box>")] | Annotated[UnsafePolygon, Tag("<polygon>")], Discriminator(_kind_of_set)
]
