"""The tables of a task that say a set: boxes, polytopes by points or half-spaces, balls and capsules. An unsafe one may be in
some of the dimensions alone; then it is unsafe whatever the others are.

Long because every table of a set is here, and what its fields must be."""

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
from stt_codegen.task.sets.polytopes import SOLID, HalfSpace, Hull, Polytope, cut_box, dot, spanned, whole
from stt_codegen.task.sets.round_sets import Round, inscribed
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

MOST_SPANNED = 6  # dimensions of a polytope: its faces are found exactly, which takes time

Axes = Annotated[tuple[str, ...], BeforeValidator(labels)]
Points = Annotated[tuple[Vector, ...], BeforeValidator(points)]
EdgesOrNone = Annotated[
    Vector, WrapValidator(lambda value, handler: value if isinstance(value, tuple) and not value else handler(value))
]


class Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, revalidate_instances="always")


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


class Waypoint(Table):
    """A displacement at a time on the sets' clock."""

    at: NotNegative = Field(description="seconds")
    by: Vector = Field(description="one entry for each of the set's axes")


Motion = Annotated[tuple[Waypoint, ...], BeforeValidator(waypoints)]


class Region(Box):
    """A box, or what half-spaces or the hull of points leave of it: where something must be."""

    axes: Axes | None = Field(default=None, description="the dimensions of vertices or normals, by name; absent: all")
    vertices: Points | None = Field(default=None, description="points whose hull cuts the box")
    normals: Points | None = Field(default=None, description="of half-spaces that cut the box, normals[k].x <= offsets[k]")
    offsets: Vector | None = Field(default=None, description="one for each of the normals")

    @property
    def convex_instead(self) -> str:
        """What is right in place of points of which some lie inside the hull of all."""
        return "leave it out where the hull is meant, or list the corners of a convex part"

    @property
    def points(self) -> tuple[str, tuple[Vector, ...]]:
        """The field that cuts the box, and its points or normals."""
        return ("vertices", self.vertices) if self.vertices is not None else ("normals", self.normals or ())

    def problem(self) -> str | None:
        field, found = self.points
        if self.vertices is not None and (self.normals is not None or self.offsets is not None):
            return "vertices: stand beside normals and offsets; give the one or the others"
        if (self.normals is None) != (self.offsets is None):
            return f"{'offsets' if self.offsets is None else 'normals'}: are missing; both are needed"
        if self.axes is not None and not found:
            return "axes: are those of vertices or normals; give these, or leave the axes out"
        if not found:
            return super().problem()
        if len(found[0]) > SOLID:
            return f"{field}: are in {len(found[0])} dimensions; at most {SOLID} are taken, name them in axes"
        if self.offsets is not None:
            return super().problem() or half_space_problem(found, self.offsets)
        return super().problem() or hull_problem(found) or concave_problem(found, self.convex_instead)

    def cuts(self, own: Sequence[int], dimension: int) -> tuple[HalfSpace, ...]:
        """The half-spaces that cut the box, in all dimensions; `own`: those of the points or normals, by number."""
        places = [(dict(zip(own, normal, strict=True)), offset) for normal, offset in self.half_spaces()]
        return tuple((tuple(place.get(i, 0) for i in range(dimension)), offset) for place, offset in places)

    def half_spaces(self) -> Sequence[HalfSpace]:
        """The same in the dimensions of the points or normals."""
        return Hull.of(self.vertices).faces if self.vertices is not None else half_spaces(self.normals or (), self.offsets or ())


class StateSpace(Region):
    """A region, or a room by its outline and holes, which `task/map/rooms.py` turns into a box and unsafe sets."""

    lower: EdgesOrNone = ()
    upper: EdgesOrNone = ()
    outline: Points | None = Field(default=None, description="corners of a room in the plane, in order; it may be concave")
    holes: Annotated[tuple[Points, ...], BeforeValidator(polygons)] | None = Field(
        default=None, description="what is not free inside the outline, each by its corners in order"
    )

    @property
    def convex_instead(self) -> str:
        return "a concave room in the plane is given by outline = [..], its corners in order, in place of vertices"


class Target(Region):
    """A region, or a ball, of which a polytope within it counts: in the dimensions that are not its own as long as the state
    space, where no box is given."""

    lower: EdgesOrNone = ()
    upper: EdgesOrNone = ()
    centre: Vector | None = Field(default=None, description="of a ball, in place of vertices or normals; no box is needed then")
    radius: Positive | None = Field(default=None, description="of the ball")
    motion: Motion | None = Field(default=None, description="displacements; what counts is where the target is at t_c")

    @property
    def points(self) -> tuple[str, tuple[Vector, ...]]:
        return ("centre", (self.centre,)) if self.centre is not None else super().points

    def vectors(self) -> list[tuple[str, Vector]]:
        return [pair for pair in super().vectors() if pair[1]]

    def problem(self) -> str | None:
        given = [field for field, _ in self.vectors()]
        if self.centre is None and self.radius is None:
            missing = next((field for field in ("lower", "upper") if field not in given), None)
            return f"{missing}: is missing; {ADD_IT}" if missing else super().problem()
        if self.centre is None or self.radius is None:
            return f"{'centre' if self.centre is None else 'radius'}: is missing; both are needed"
        if any(field is not None for field in (self.vertices, self.normals, self.offsets)):
            return "centre: stands beside vertices or normals; give the one or the others"
        if len(self.centre) > SOLID:
            return f"centre: is in {len(self.centre)} dimensions; at most {SOLID} are taken, name them in axes"
        if len(given) == 1:
            return f"{given[0]}: stands alone; give lower and upper, or neither beside centre and radius"
        return Box.problem(self) if given else None

    def half_spaces(self) -> Sequence[HalfSpace]:
        return super().half_spaces() if self.centre is None or self.radius is None else inscribed(self.centre, self.radius)

    def box(self, space: BoxSet, own: Sequence[int]) -> BoxSet:
        """What is cut: the box, or where there is none the state space and in the ball's dimensions its span."""
        if self.lower or self.centre is None or self.radius is None:
            return BoxSet(self.lower, self.upper)
        lower, upper = list(space.lower), list(space.upper)
        for i, c in zip(own, self.centre, strict=True):
            lower[i], upper[i] = c - self.radius, c + self.radius
        return BoxSet(tuple(lower), tuple(upper))


class Unsafe(Table):
    """What all unsafe sets U_j have; unnamed ones are called U1, U2, ... in the order of the file.

    point_fields: the fields that are points, or lists of points, which move where the set does; without them a set is refused in
    an axis that closes.
    """

    point_fields: ClassVar[tuple[str, ...]] = ()

    name: str = Field(default="", pattern=r"^[A-Za-z0-9_ .()#+-]*$", max_length=MAX_LABEL)
    axes: Axes | None = Field(
        default=None, description="the dimensions that the set is in, by name: all others may be anything; absent: all"
    )

    motion: Motion | None = Field(default=None, description="displacements, linear between times, constant before and after")
    during: Window | None = Field(default=None, description="[from, to], seconds: unsafe only then; absent: always")
    timing: NotNegative | None = Field(default=None, description="seconds by which its times may be wrong; absent: 0")
    spread: NotNegative | None = Field(default=None, description="it grows by so much a second on every side; absent: 0")

    @property
    def timed(self) -> bool:
        """Whether it is not the same at all times."""
        return self.motion is not None or self.during is not None or bool(self.spread)

    @abstractmethod
    def vectors(self) -> list[tuple[str, Vector]]:
        """What must have one entry for each of the set's dimensions, by name."""

    @abstractmethod
    def problem(self) -> str | None:
        """What makes these numbers no set, in words; None where they are one."""

    @abstractmethod
    def to_convex_set(self, lower: Vector, upper: Vector) -> ConvexSet:
        """The set in its dimensions, of which the state space has these edges."""

    def half_spaces(self) -> Sequence[HalfSpace]:
        """In its own dimensions half-spaces that leave the set, or a polytope within it; none of a capsule."""
        return ()

    def within(self, space: Box, own: Sequence[int]) -> ConvexSet:
        """The set in a state space, its dimensions by number: in those that are not its own as long as that, all that counts."""
        base = self.to_convex_set(*(tuple(edges[k] for k in own) for edges in (space.lower, space.upper)))
        if tuple(own) == tuple(range(len(space.lower))):
            return base
        return Prism(base, tuple(own), space.lower, space.upper, self.name)


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
    """The hull of points."""

    point_fields = ("vertices",)
    vertices: Points = Field(description="points in any order; their hull counts")

    def vectors(self) -> list[tuple[str, Vector]]:
        return [(f"vertices[{k}]", p) for k, p in enumerate(self.vertices)]

    def problem(self) -> str | None:
        return hull_problem(self.vertices)

    @property
    def thinned(self) -> bool:
        """Whether points were given that lie inside the hull of all: then it may hold more than was meant."""
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
        """Raises `ValueError` where nothing of the state space is in all half-spaces."""
        found = corners_left(lower, upper, tuple(half_spaces(self.normals, self.offsets)))
        if not found:
            raise ValueError(
                "normals: nothing of the state space lies in all of the half-spaces; turn the signs, or leave the set out"
            )
        if spanned(found) < len(lower):
            raise ValueError("normals: what they leave of the state space has no interior; move two of the offsets apart")
        if self.motion is not None and set(found) != set(self._corners(lower, upper)):
            raise ValueError(
                "motion: the half-spaces leave the set open, so it ends at the state space, and what ends there would move as a "
                "whole; close it with more normals, or give its vertices"
            )
        return Polytope(found, self.name)

    def _corners(self, lower: Vector, upper: Vector) -> tuple[Vector, ...]:
        """The corners in a state space that is larger on every side."""
        size = [b - a for a, b in zip(lower, upper, strict=True)]
        wider = (tuple(v + s * d for v, d in zip(edge, size, strict=True)) for edge, s in ((lower, -1), (upper, 1)))
        return corners_left(*wider, tuple(half_spaces(self.normals, self.offsets)))


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
        return Round((self.centre,), self.radius, self.name)


class UnsafeCapsule(Unsafe):
    """All points within a radius of a segment."""

    point_fields = ("segment",)
    segment: Points = Field(description="its two ends")
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
        return Round(self.segment, self.radius, self.name)


@cache
def corners_left(lower: Vector, upper: Vector, cuts: tuple[HalfSpace, ...]) -> tuple[Vector, ...]:
    """The corners of what half-spaces leave of a box."""
    return tuple(v.point for v in cut_box(lower, upper, cuts))


def half_spaces(normals: Sequence[Vector], offsets: Vector) -> list[HalfSpace]:
    """With normals in whole numbers."""
    found = []
    for vector, offset in zip(normals, offsets, strict=True):
        normal, factor = whole(vector)
        found.append((normal, offset * factor))
    return found


def hull_problem(found: Sequence[Vector]) -> str | None:
    """What makes these points no vertices of a polytope, in words."""
    n, count = len(found[0]), len(found)
    most = MAX_POINTS if n <= SOLID else MAX_POINTS_BEYOND
    if n > MOST_SPANNED:
        return f"vertices: are in {n} dimensions; at most {MOST_SPANNED} are taken, name them in axes"
    if count > most:
        return f"vertices: has {count} points; at most {most} are taken in {n} dimensions"
    if spanned(found) < n:
        flat = {1: "in one place", 2: "on one line", 3: "in one plane"}.get(n, "in one hyperplane")
        return f"vertices: have no interior; at least {n + 1} points that are not all {flat} are needed"
    return None


def inner_point(points: tuple[Vector, ...]) -> int | None:
    """The number of the first point that lies inside the hull of all, not on its boundary."""
    faces = Hull.of(points).faces
    return next((k for k, p in enumerate(points) if all(dot(normal, p) < offset for normal, offset in faces)), None)


def concave_problem(points: tuple[Vector, ...], instead: str) -> str | None:
    """Which of the points of a set to stay or arrive in is no corner of its hull, in words; instead: what would be right."""
    k = inner_point(points)
    return None if k is None else f"vertices[{k}]: lies inside the hull of the others; a set is convex: {instead}"


def half_space_problem(normals: Sequence[Vector], offsets: Sequence[Fraction]) -> str | None:
    """What makes these no half-spaces, in words."""
    if len(normals) > MAX_NORMALS:
        return f"normals: has {len(normals)} entries; at most {MAX_NORMALS} are taken"
    if len(offsets) != len(normals):
        return f"offsets: has {len(offsets)} entries; normals has {len(normals)}, and both must agree"
    for k, normal in enumerate(normals):
        if not any(normal):
            return f"normals[{k}]: is 0 in every entry; give the direction that leads out of the set"
    return None


KINDS: dict[str, type[Unsafe]] = {  # the field that tells what a set is, and its table; of several that are given the first
    "vertices": UnsafePolytope,
    "normals": UnsafeHalfSpaces,
    "offsets": UnsafeHalfSpaces,
    "centre": UnsafeBall,
    "segment": UnsafeCapsule,
    "radius": UnsafeBall,
}
SET_TABLES: tuple[type[Unsafe], ...] = tuple(dict.fromkeys((UnsafeSet, *KINDS.values())))


def kind_of_set(value: Any) -> str:
    """What a table [[unsafe]] is to be read as."""
    if isinstance(value, Unsafe):
        return f"<{type(value).__name__}>"
    given = value if isinstance(value, dict) else {}
    return next((f"<{kind.__name__}>" for field, kind in KINDS.items() if field in given), "<UnsafeSet>")


def fields_of_shape(table: type[Unsafe]) -> list[str]:
    """The fields that a set of this table has to have, beside those that all sets may have."""
    return [name for name, field in table.model_fields.items() if field.is_required() and name not in Unsafe.model_fields]


@dataclass(frozen=True)
class OneOf:
    """Tells pydantic which tables a field may hold, and by `kind` as which of them a value is read: `<name of the table>`."""

    tables: tuple[type[Table], ...]
    kind: Callable[[Any], str]

    def __get_pydantic_core_schema__(self, _source: Any, handler: GetCoreSchemaHandler) -> Any:
        tagged = tuple(Annotated[table, Tag(f"<{table.__name__}>")] for table in self.tables)
        return handler.generate_schema(Annotated[Union[tagged], Discriminator(self.kind)])  # noqa: UP007


AnyUnsafe = Annotated[Unsafe, OneOf(SET_TABLES, kind_of_set)]
