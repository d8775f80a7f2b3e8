"""The tables of a task file that describe a set: boxes, polytopes by points or half-spaces, balls and capsules.

An unsafe set may be given in some of the dimensions only; then it is unsafe whatever the others are. A table knows what its
fields must be (`problem`) and which set it is (`to_convex_set`). docs/task.md explains the keys.

Long because every table of a set is here, with the checks of its fields.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Annotated, Any, ClassVar, Union

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, GetCoreSchemaHandler, Tag, WrapValidator

from stt_codegen.decimals import decimal
from stt_codegen.task.sets.convex_sets import BoxSet, ConvexSet, Prism
from stt_codegen.task.sets.polytopes import SOLID, HalfSpace, Hull, Polytope, affine_dimension, cut_box, dot, primitive_normal
from stt_codegen.task.sets.round_sets import RoundSet, inscribed
from stt_codegen.task.values import (
    ADD_IT,
    MAX_LABEL,
    MAX_NORMALS,
    MAX_POINTS,
    MAX_POINTS_BEYOND,
    NotNegative,
    Positive,
    Vector,
    Window,
    labels,
    points,
    polygons,
    waypoints,
)

POLYTOPE_DIMENSION_LIMIT = 6  # computing the faces of a polytope exactly takes too long in more dimensions

Axes = Annotated[tuple[str, ...], BeforeValidator(labels)]
Points = Annotated[tuple[Vector, ...], BeforeValidator(points)]
EdgesOrNone = Annotated[
    Vector, WrapValidator(lambda value, handler: value if isinstance(value, tuple) and not value else handler(value))
]


class TomlTable(BaseModel):
    """A table of a task file: frozen, without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, revalidate_instances="always")


class Box(TomlTable):
    """An axis-aligned box: `lower` and `upper` edges by dimension, in the task's units."""

    lower: Vector
    upper: Vector

    def vectors(self) -> list[tuple[str, Vector]]:
        """Return the vectors that must have one entry for each dimension, by field name."""
        return [("lower", self.lower), ("upper", self.upper)]

    def problem(self) -> str | None:
        """Return a message where the fields do not describe a set, else None."""
        for i, (a, b) in enumerate(zip(self.lower, self.upper, strict=True)):
            if a >= b:
                return f"lower[{i}] = {decimal(a)} is not below upper[{i}] = {decimal(b)}"
        return None

    def convex(self) -> BoxSet:
        """Return the box as a set."""
        return BoxSet(self.lower, self.upper)


class Waypoint(TomlTable):
    """A displacement at a time on the clock of the sets."""

    at: NotNegative = Field(description="seconds")
    by: Vector = Field(description="one entry for each of the set's axes")


Motion = Annotated[tuple[Waypoint, ...], BeforeValidator(waypoints)]


class Region(Box):
    """A box, or its intersection with half-spaces or with the hull of points: a set to start, stay or arrive in."""

    axes: Axes | None = Field(default=None, description="the dimensions of vertices or normals, by name; absent: all")
    vertices: Points | None = Field(default=None, description="points whose hull cuts the box")
    normals: Points | None = Field(default=None, description="of half-spaces that cut the box, normals[k].x <= offsets[k]")
    offsets: Vector | None = Field(default=None, description="one for each of the normals")

    @property
    def convex_instead(self) -> str:
        """The remedy where some of the points lie inside the hull of all."""
        return "leave it out where the hull is meant, or list the corners of a convex part"

    @property
    def points(self) -> tuple[str, tuple[Vector, ...]]:
        """The name of the field that cuts the box, and its points or normals."""
        return ("vertices", self.vertices) if self.vertices is not None else ("normals", self.normals or ())

    def problem(self) -> str | None:
        """Return a message where the fields do not describe a set, else None."""
        field, vectors = self.points
        if self.vertices is not None and (self.normals is not None or self.offsets is not None):
            return "vertices: stand beside normals and offsets; give the one or the others"
        if (self.normals is None) != (self.offsets is None):
            return f"{'offsets' if self.offsets is None else 'normals'}: are missing; both are needed"
        if self.axes is not None and not vectors:
            return "axes: are those of vertices or normals; give these, or leave the axes out"
        if not vectors:
            return super().problem()
        if len(vectors[0]) > SOLID:
            return f"{field}: are in {len(vectors[0])} dimensions; at most {SOLID} are taken, name them in axes"
        if self.offsets is not None:
            return super().problem() or half_space_problem(vectors, self.offsets)
        return super().problem() or hull_problem(vectors) or concave_problem(vectors, self.convex_instead)

    def cuts(self, axes: Sequence[int], dimension: int) -> tuple[HalfSpace, ...]:
        """Return the half-spaces that cut the box, in all dimensions. axes: those of the points or normals, by index."""
        entries = [(dict(zip(axes, normal, strict=True)), offset) for normal, offset in self.half_spaces()]
        return tuple((tuple(normal.get(i, 0) for i in range(dimension)), offset) for normal, offset in entries)

    def half_spaces(self) -> Sequence[HalfSpace]:
        """Return the half-spaces that cut the box, in the dimensions of the points or normals."""
        return Hull.of(self.vertices).faces if self.vertices is not None else half_spaces(self.normals or (), self.offsets or ())


class StateSpace(Region):
    """A region, or a floor plan by its outline and holes, which task/map/floor_plans.py turns into a box and unsafe sets."""

    lower: EdgesOrNone = ()
    upper: EdgesOrNone = ()
    outline: Points | None = Field(default=None, description="corners of a room in the plane, in order; it may be concave")
    holes: Annotated[tuple[Points, ...], BeforeValidator(polygons)] | None = Field(
        default=None, description="areas inside the outline that are not free, each by its corners in order"
    )

    @property
    def convex_instead(self) -> str:
        return "a concave room in the plane is given by outline = [..], its corners in order, in place of vertices"


class Target(Region):
    """A region, or a ball, in place of which a polytope inside it is used.

    Where a ball comes without a box, its target spans the state space in the dimensions that the ball does not have."""

    lower: EdgesOrNone = ()
    upper: EdgesOrNone = ()
    centre: Vector | None = Field(default=None, description="of a ball, in place of vertices or normals; no box is needed then")
    radius: Positive | None = Field(default=None, description="of the ball")
    motion: Motion | None = Field(default=None, description="displacements by time; the target counts where it is at t_c")

    @property
    def points(self) -> tuple[str, tuple[Vector, ...]]:
        return ("centre", (self.centre,)) if self.centre is not None else super().points

    def vectors(self) -> list[tuple[str, Vector]]:
        return [pair for pair in super().vectors() if pair[1]]

    def problem(self) -> str | None:
        """Return a message where the fields do not describe a target, else None."""
        edges = [field for field, _ in self.vectors()]
        if self.centre is None and self.radius is None:
            missing = next((field for field in ("lower", "upper") if field not in edges), None)
            return f"{missing}: is missing; {ADD_IT}" if missing else super().problem()
        if self.centre is None or self.radius is None:
            return f"{'centre' if self.centre is None else 'radius'}: is missing; both are needed"
        if any(field is not None for field in (self.vertices, self.normals, self.offsets)):
            return "centre: stands beside vertices or normals; give the one or the others"
        if len(self.centre) > SOLID:
            return f"centre: is in {len(self.centre)} dimensions; at most {SOLID} are taken, name them in axes"
        if len(edges) == 1:
            return f"{edges[0]}: stands alone; give lower and upper, or neither beside centre and radius"
        return Box.problem(self) if edges else None

    def half_spaces(self) -> Sequence[HalfSpace]:
        return super().half_spaces() if self.centre is None or self.radius is None else inscribed(self.centre, self.radius)

    def box(self, space: BoxSet, axes: Sequence[int]) -> BoxSet:
        """Return the box that half-spaces cut: that of the fields or, without these, the state space about the ball.

        space: the state space; axes: the dimensions of the ball, by index."""
        if self.lower or self.centre is None or self.radius is None:
            return BoxSet(self.lower, self.upper)
        lower, upper = list(space.lower), list(space.upper)
        for i, c in zip(axes, self.centre, strict=True):
            lower[i], upper[i] = c - self.radius, c + self.radius
        return BoxSet(tuple(lower), tuple(upper))


class Unsafe(TomlTable):
    """The keys that all unsafe sets U_j share; sets without a name are called U1, U2, ... in the order of the file.

    point_fields: the fields that are points or lists of points, which a translation of the set moves. A set without any is
    refused in an axis that closes.
    """

    point_fields: ClassVar[tuple[str, ...]] = ()

    name: str = Field(default="", pattern=r"^[A-Za-z0-9_ .()#+-]+$", max_length=MAX_LABEL)
    axes: Axes | None = Field(
        default=None, description="the dimensions that the set is in, by name: all others may be anything; absent: all"
    )

    motion: Motion | None = Field(default=None, description="displacements, linear between times, constant before and after")
    during: Window | None = Field(
        default=None, description="active interval [from, to], seconds: unsafe only then; absent: always"
    )
    timing: NotNegative | None = Field(
        default=None, description="timing uncertainty: seconds by which its times may be wrong; absent: 0"
    )
    spread: NotNegative | None = Field(default=None, description="growth on every side, a second; absent: 0")

    @property
    def is_timed(self) -> bool:
        """Whether the set moves, grows or is active only for a while."""
        return self.motion is not None or self.during is not None or bool(self.spread)

    @abstractmethod
    def vectors(self) -> list[tuple[str, Vector]]:
        """Return the vectors that must have one entry for each of the set's dimensions, by field name."""

    @abstractmethod
    def problem(self) -> str | None:
        """Return a message where the fields do not describe a set, else None."""

    @abstractmethod
    def to_convex_set(self, lower: Vector, upper: Vector) -> ConvexSet:
        """Return the set in its dimensions. lower, upper: the edges of the state space in these dimensions."""

    def half_spaces(self) -> Sequence[HalfSpace]:
        """Return half-spaces whose intersection is the set or a polytope inside it, in its dimensions; none for a capsule."""
        return ()

    def to_set_in(self, space: Box, axes: Sequence[int]) -> ConvexSet:
        """Return the set in all dimensions; in those that it does not have it spans the state space, as nothing beyond counts.

        axes: the dimensions of the set, by index."""
        base = self.to_convex_set(*(tuple(edges[k] for k in axes) for edges in (space.lower, space.upper)))
        if tuple(axes) == tuple(range(len(space.lower))):
            return base
        return Prism(base, tuple(axes), space.lower, space.upper, self.name)


class UnsafeSet(Unsafe):
    """A box: `lower` and `upper` edges by dimension."""

    point_fields = ("lower", "upper")
    lower: Vector
    upper: Vector

    def vectors(self) -> list[tuple[str, Vector]]:
        return [("lower", self.lower), ("upper", self.upper)]

    def problem(self) -> str | None:
        return Box(lower=self.lower, upper=self.upper).problem()

    def half_spaces(self) -> Sequence[HalfSpace]:
        return BoxSet(self.lower, self.upper).faces

    def to_convex_set(self, _lower: Vector, _upper: Vector) -> ConvexSet:
        return BoxSet(self.lower, self.upper, self.name)


class UnsafePolytope(Unsafe):
    """A polytope: the hull of points."""

    point_fields = ("vertices",)
    vertices: Points = Field(description="points in any order; their hull counts")

    def vectors(self) -> list[tuple[str, Vector]]:
        return [(f"vertices[{k}]", p) for k, p in enumerate(self.vertices)]

    def problem(self) -> str | None:
        return hull_problem(self.vertices)

    @property
    def has_inner_points(self) -> bool:
        """Whether some points lie inside the hull of all; then the author may have meant a smaller, concave set."""
        return inner_point(self.vertices) is not None

    def half_spaces(self) -> Sequence[HalfSpace]:
        return Hull.of(self.vertices).faces

    def to_convex_set(self, _lower: Vector, _upper: Vector) -> ConvexSet:
        return Polytope(self.vertices, self.name)


class UnsafeHalfSpaces(Unsafe):
    """All points of the state space with normals[k].x <= offsets[k] for every k."""

    normals: Points = Field(description="of half-spaces, normals[k].x <= offsets[k]")
    offsets: Vector = Field(description="one for each of the normals")

    def vectors(self) -> list[tuple[str, Vector]]:
        return [(f"normals[{k}]", p) for k, p in enumerate(self.normals)]

    def problem(self) -> str | None:
        if len(self.normals[0]) > SOLID:
            return (
                f"normals: have {len(self.normals[0])} entries; half-spaces are for at most {SOLID} dimensions, name them in axes"
            )
        return half_space_problem(self.normals, self.offsets)

    def half_spaces(self) -> Sequence[HalfSpace]:
        return half_spaces(self.normals, self.offsets)

    def to_convex_set(self, lower: Vector, upper: Vector) -> ConvexSet:
        """Return the intersection of the half-spaces with the state space.

        Raises `ValueError` where it is empty, has no interior, or moves although the half-spaces leave it unbounded."""
        corners = corners_of_cut_box(lower, upper, tuple(half_spaces(self.normals, self.offsets)))
        if not corners:
            raise ValueError(
                "normals: nothing of the state space lies in all of the half-spaces; turn the signs, or leave the set out"
            )
        if affine_dimension(corners) < len(lower):
            raise ValueError("normals: what they leave of the state space has no interior; move two of the offsets apart")
        if self.motion is not None and set(corners) != set(self._corners_in_wider_space(lower, upper)):
            raise ValueError(
                "motion: the half-spaces leave the set open, so it ends at the state space, and what ends there would move as a "
                "whole; close it with more normals, or give its vertices"
            )
        return Polytope(corners, self.name)

    def _corners_in_wider_space(self, lower: Vector, upper: Vector) -> tuple[Vector, ...]:
        """Return the corners in a state space three times as wide, to see whether the half-spaces bound the set."""
        widths = [b - a for a, b in zip(lower, upper, strict=True)]
        wider = (tuple(v + s * d for v, d in zip(edge, widths, strict=True)) for edge, s in ((lower, -1), (upper, 1)))
        return corners_of_cut_box(*wider, tuple(half_spaces(self.normals, self.offsets)))


class UnsafeBall(Unsafe):
    """All points within a radius of a centre: a ball, in some of the dimensions alone a cylinder."""

    point_fields = ("centre",)
    centre: Vector
    radius: Positive

    def vectors(self) -> list[tuple[str, Vector]]:
        return [("centre", self.centre)]

    def problem(self) -> str | None:
        return None

    def half_spaces(self) -> Sequence[HalfSpace]:
        return inscribed(self.centre, self.radius)

    def to_convex_set(self, _lower: Vector, _upper: Vector) -> ConvexSet:
        return RoundSet((self.centre,), self.radius, self.name)


class UnsafeCapsule(Unsafe):
    """All points within a radius of a segment."""

    point_fields = ("segment",)
    segment: Points = Field(description="the two ends of the segment")
    radius: Positive

    def vectors(self) -> list[tuple[str, Vector]]:
        return [(f"segment[{k}]", p) for k, p in enumerate(self.segment)]

    def problem(self) -> str | None:
        if len(self.segment) != 2:
            return f"segment: has {len(self.segment)} points; two are needed, its ends"
        if self.segment[0] == self.segment[1]:
            return "segment: its ends are the same; use centre"
        return None

    def to_convex_set(self, _lower: Vector, _upper: Vector) -> ConvexSet:
        return RoundSet(self.segment, self.radius, self.name)


@cache
def corners_of_cut_box(lower: Vector, upper: Vector, cuts: tuple[HalfSpace, ...]) -> tuple[Vector, ...]:
    """Return the corners of the intersection of a box with half-spaces."""
    return tuple(v.point for v in cut_box(lower, upper, cuts))


def half_spaces(normals: Sequence[Vector], offsets: Vector) -> list[HalfSpace]:
    """Return the half-spaces normals[k].x <= offsets[k] with normals in integers without a common divisor."""
    integers = ((primitive_normal(vector), offset) for vector, offset in zip(normals, offsets, strict=True))
    return [(normal, offset * factor) for (normal, factor), offset in integers]


def hull_problem(vertices: Sequence[Vector]) -> str | None:
    """Return a message where the points are not the vertices of a polytope with an interior, else None."""
    n, count = len(vertices[0]), len(vertices)
    limit = MAX_POINTS if n <= SOLID else MAX_POINTS_BEYOND
    if n > POLYTOPE_DIMENSION_LIMIT:
        return f"vertices: are in {n} dimensions; at most {POLYTOPE_DIMENSION_LIMIT} are taken, name them in axes"
    if count > limit:
        return f"vertices: has {count} points; at most {limit} are taken in {n} dimensions"
    if affine_dimension(vertices) < n:
        flat = {1: "in one place", 2: "on one line", 3: "in one plane"}.get(n, "in one hyperplane")
        return f"vertices: have no interior; at least {n + 1} points that are not all {flat} are needed"
    return None


def inner_point(points: tuple[Vector, ...]) -> int | None:
    """Return the index of the first point that lies inside the hull of all, not on its boundary."""
    faces = Hull.of(points).faces
    return next((k for k, p in enumerate(points) if all(dot(normal, p) < offset for normal, offset in faces)), None)


def concave_problem(points: tuple[Vector, ...], instead: str) -> str | None:
    """Return a message where a point of a set to stay or arrive in lies inside the hull, else None. instead: the remedy."""
    k = inner_point(points)
    return None if k is None else f"vertices[{k}]: lies inside the hull of the others; a set is convex: {instead}"


def half_space_problem(normals: Sequence[Vector], offsets: Sequence[Fraction]) -> str | None:
    """Return a message where normals and offsets are not half-spaces, else None."""
    if len(normals) > MAX_NORMALS:
        return f"normals: has {len(normals)} entries; at most {MAX_NORMALS} are taken"
    if len(offsets) != len(normals):
        return f"offsets: has {len(offsets)} entries; normals has {len(normals)}, and both must agree"
    for k, normal in enumerate(normals):
        if not any(normal):
            return f"normals[{k}]: is 0 in every entry; give the direction that leads out of the set"
    return None


KINDS: dict[str, type[Unsafe]] = {  # the field that decides the kind of a set, and its table; the first field present decides
    "vertices": UnsafePolytope,
    "normals": UnsafeHalfSpaces,
    "offsets": UnsafeHalfSpaces,
    "centre": UnsafeBall,
    "segment": UnsafeCapsule,
    "radius": UnsafeBall,
}
SET_TABLES: tuple[type[Unsafe], ...] = tuple(dict.fromkeys((UnsafeSet, *KINDS.values())))


def kind_of_set(value: Any) -> str:
    """Return the tag of the table as which an entry of [[unsafe]] is read."""
    if isinstance(value, Unsafe):
        return f"<{type(value).__name__}>"
    keys = value if isinstance(value, dict) else {}
    return next((f"<{kind.__name__}>" for field, kind in KINDS.items() if field in keys), "<UnsafeSet>")


def fields_of_shape(table: type[Unsafe]) -> list[str]:
    """Return the required fields of a table that are not keys of every unsafe set."""
    return [name for name, field in table.model_fields.items() if field.is_required() and name not in Unsafe.model_fields]


@dataclass(frozen=True)
class OneOf:
    """Annotation for pydantic: the tables that a field may hold, and `kind`, which gives a value's tag `<name of the table>`."""

    tables: tuple[type[TomlTable], ...]
    kind: Callable[[Any], str]

    def __get_pydantic_core_schema__(self, _source: Any, handler: GetCoreSchemaHandler) -> Any:
        tagged = tuple(Annotated[table, Tag(f"<{table.__name__}>")] for table in self.tables)
        return handler.generate_schema(Annotated[Union[tagged], Discriminator(self.kind)])  # noqa: UP007


AnyUnsafe = Annotated[Unsafe, OneOf(SET_TABLES, kind_of_set)]
