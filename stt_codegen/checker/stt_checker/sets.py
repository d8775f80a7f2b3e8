"""The sets of a task. `Inside` is a set that the tube must stay or arrive in; `Obstacle` is a set that it must avoid."""

import itertools
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from .exact import Unusable, number, require, vector
from .moving import Course

# The fields that describe the shape of a set, in every combination that is known. A set with any other field is refused.
FORMS = ({"lower", "upper"}, {"vertices"}, {"normals", "offsets"}, {"centre", "radius"}, {"segment", "radius"})
SHAPE_FIELDS = set[str]().union(*FORMS)
ZERO = Fraction(0)
HalfSpace = tuple[list[Fraction], Fraction]  # normal n and offset b: all x with n.x <= b


def dot(a: Iterable[Any], b: Iterable[Any]) -> Any:
    return sum(v * w for v, w in zip(a, b, strict=True))


def euclidean_norm(normal: Sequence[int]) -> Fraction:
    """Return |n|_2 of whole numbers, rounded up to a multiple of 2^-32."""
    square = sum(c * c for c in normal) << 64
    root = math.isqrt(square)
    return Fraction(root + (root * root < square), 1 << 32)


def axes_of(table: Any, names: list[str]) -> list[int]:
    """Return the dimensions in which a set is bounded; in all others it goes as far as the state space."""
    axes = table.get("axes", names)
    if not isinstance(axes, list) or not axes or not {*axes} <= {*names} or len({*axes}) < len(axes):
        raise Unusable("the task has a set whose axes are none, twice the same, or not the task's")
    return [names.index(a) for a in axes]


def points(value: Any, d: int) -> list[list[Fraction]]:
    """Return a list of points or normals with d coordinates each."""
    if not isinstance(value, list) or not value:
        raise Unusable("the task has a set without a list of points")
    return [vector(p, d) for p in value]


def box(table: Any, d: int) -> tuple[list[Fraction], list[Fraction]]:
    """Return the lower and upper edges of a box."""
    (lower,), (upper,) = points([table["lower"]], d), points([table["upper"]], d)
    if any(a >= b for a, b in zip(lower, upper, strict=True)):
        raise Unusable("the task has a set with a lower edge that is not below the upper one")
    return lower, upper


def half_spaces(table: Any, d: int) -> list[HalfSpace]:
    """Return the half-spaces that a set lists as `normals` and `offsets`."""
    normals = points(table["normals"], d)
    return list(zip(normals, vector(table["offsets"], len(normals)), strict=True))


def hull_faces(corners: list[list[Fraction]], d: int) -> list[HalfSpace]:
    """Return every plane through d of the points that has all others on one side."""
    if d > 3 or len(corners) > 64:
        raise Unusable("the task has a set of too many points or dimensions")
    faces = list[HalfSpace]()
    for first, *rest in itertools.combinations(corners, d):
        if any(all(dot(normal, p) == height for p in (first, *rest)) for normal, height in faces):
            continue  # a plane that is known
        u = [[b - a for a, b in zip(first, p, strict=True)] for p in rest]
        if d == 3:
            normal = [u[0][j] * u[1][k] - u[0][k] * u[1][j] for j, k in ((1, 2), (2, 0), (0, 1))]
        else:
            normal = [Fraction(1)] if d == 1 else [u[0][1], -u[0][0]]
        height = dot(normal, first)
        for sign in (1, -1):
            if any(normal) and all(sign * dot(normal, p) <= sign * height for p in corners):
                faces.append(([sign * c for c in normal], sign * height))
    return faces


def spread_over(axes: list[int], values: Sequence[Fraction], n: int) -> list[Fraction]:
    """Return a vector of n dimensions with these values in some axes, and 0 in the others."""
    by_axis = dict(zip(axes, values, strict=True))
    return [by_axis.get(i, ZERO) for i in range(n)]


class Inside:
    """A set that the tube must stay or arrive in: half-spaces, and perhaps a ball in the dimensions `axes`."""

    def __init__(self, table: Any, names: list[str], body: list[Fraction], box_has_all_axes: bool = True) -> None:
        """body: half extents by which the set is smaller on every side. A box of a state space or target has all axes."""
        self.axes, n = axes_of(table, names), len(names)
        d, faces = len(self.axes), list[HalfSpace]()
        self.ball: tuple[list[Fraction], Fraction] | None = None
        kinds = {*table} & {"centre", "vertices", "normals"}
        unknown = {*table} & SHAPE_FIELDS - {"lower", "upper"} not in (set(), *FORMS[1:4])
        if unknown or len(kinds) > 1 or ("lower" in table) != ("upper" in table):
            raise Unusable("the task has a set to be in with a shape that is unknown here")
        if "lower" in table:
            box_axes = list(range(n)) if box_has_all_axes else self.axes
            for i, a, b in zip(box_axes, *box(table, len(box_axes)), strict=True):
                axis = spread_over([i], [Fraction(1)], n)
                faces += [(axis, b), ([-c for c in axis], -a)]
        listed = list[HalfSpace]()
        if "normals" in table:
            listed = half_spaces(table, d)
        if "vertices" in table:
            listed = hull_faces(points(table["vertices"], d), d)
            if not listed:
                raise Unusable("the task has a set whose vertices have no interior")
        if "centre" in table:
            self.ball = vector(table["centre"], d), number(table["radius"])
        faces += [(spread_over(self.axes, normal, n), offset) for normal, offset in listed]
        self.faces = [(normal, offset - dot(map(abs, normal), body)) for normal, offset in faces]
        is_empty = not (self.faces or self.ball) or (self.ball is not None and self.ball[1] <= 0)
        if is_empty or not all(any(normal) for normal, _ in self.faces):  # all of no half-spaces would hold anywhere
            raise Unusable("the task has a set to be in without a half-space or a ball, or a half-space whose normal is 0")

    def move(self, by: list[Fraction], smaller_by: list[Fraction] | None = None) -> None:
        """Move the set, and make it smaller in every dimension by what the displacement may be wrong by."""
        error = smaller_by or [ZERO] * len(by)
        self.faces = [(normal, b + dot(normal, by) - dot(map(abs, normal), error)) for normal, b in self.faces]
        if self.ball:
            self.ball = (
                [c + by[i] for i, c in zip(self.axes, self.ball[0], strict=True)],
                self.ball[1] - sum(error[i] for i in self.axes),
            )
            if self.ball[1] <= 0:
                raise Unusable("the task has a target that is smaller than what its turns are wrong by")

    def contains(self, edges: list[tuple[Any, Any]], margin: int, unit: Fraction) -> bool:
        """Return whether the box of these edges, in units and larger by the margin on every side, is in the set."""
        low, high = [(a - margin) * unit for a, _ in edges], [(b + margin) * unit for _, b in edges]
        for normal, offset in self.faces:
            if sum(c * (high if c > 0 else low)[i] for i, c in enumerate(normal) if c) > offset:
                return False
        if not self.ball:
            return True
        centre, radius = self.ball
        return sum(max(high[i] - c, c - low[i]) ** 2 for i, c in zip(self.axes, centre, strict=True)) <= radius**2


class Obstacle:
    """A set that the tube must avoid: the hull of points, about each point a box and in the set's own axes a ball; or the part of
    a box that is within half-spaces. The robot's body is about all of it."""

    def __init__(self, table: Any, name: str, task: Any) -> None:
        self.name, self.body, self.axes = name, task.body, axes_of(table, task.names)
        form, d, axes = {*table} & SHAPE_FIELDS, len(self.axes), self.axes
        self.radius = number(table.get("radius", 0))
        if form not in FORMS or ("radius" in table and self.radius <= 0):
            raise Unusable("the task has an unsafe set with a shape that is unknown here")
        lower, upper = task.box
        middle, self.half = (
            [(a + b) / 2 for a, b in zip(lower, upper, strict=True)],
            [(b - a) / 2 for a, b in zip(lower, upper, strict=True)],
        )
        self.faces: list[HalfSpace] = []
        corners, extents = list[list[Fraction]](), [ZERO] * d
        if "lower" in form:
            low, high = box(table, d)
            corners, extents = (
                [[(a + b) / 2 for a, b in zip(low, high, strict=True)]],
                [(b - a) / 2 for a, b in zip(low, high, strict=True)],
            )
        elif "normals" in form:
            corners, extents = [[middle[i] for i in axes]], [self.half[i] for i in axes]
            self.faces = [(spread_over(axes, normal, task.n), offset) for normal, offset in half_spaces(table, d)]
        else:
            corners = points([table["centre"]] if "centre" in form else table["vertices" if "vertices" in form else "segment"], d)
        for i, extent in zip(axes, extents, strict=True):
            self.half[i] = extent
        self.points = [[dict(zip(axes, p, strict=True)).get(i, v) for i, v in enumerate(middle)] for p in corners]
        self.timing, self.states_timing, self.course = number(table.get("timing", 0)), "timing" in table, None
        if {"motion", "during"} & {*table} or table.get("spread"):
            moves = [(v["at"], dict(zip(axes, points([v["by"]], d)[0], strict=True))) for v in table.get("motion", [])]
            self.course = Course(table, moves, task)

    def image(self, name: str, by: list[Fraction]) -> "Obstacle":
        """Return the set moved by full turns of axes that close."""
        moved = object.__new__(Obstacle)
        moved.__dict__ |= self.__dict__ | {"name": name}
        moved.points = [[v + w for v, w in zip(p, by, strict=True)] for p in self.points]
        moved.faces = [(normal, offset + dot(normal, by)) for normal, offset in self.faces]
        return moved

    def largest_height(self, normal: list[int], multipliers: Sequence[Fraction]) -> Fraction:
        """Return a bound on n.x over the set. For half-spaces a_k.x <= b_k and any y_k >= 0 it is y.b plus the largest
        (n - y a).x over the box: weak duality, so wrong multipliers only make the bound larger."""
        good = len(multipliers) == len(self.faces) and all(y >= 0 for y in multipliers)
        require(good, "a hint does not have a multiplier for every half-space")
        rest, height = [Fraction(c) for c in normal], ZERO
        for y, (face, offset) in zip(multipliers, self.faces, strict=True):
            rest, height = [a - y * b for a, b in zip(rest, face, strict=True)], height + y * offset
        height += max(dot(rest, p) for p in self.points) + dot(map(abs, rest), self.half)
        return height + dot(map(abs, normal), self.body) + self.radius * euclidean_norm([normal[i] for i in self.axes])
