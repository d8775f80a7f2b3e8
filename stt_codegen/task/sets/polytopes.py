"""Convex polytopes between their points and their half-spaces, in exact fractions.

    hull of points      <->      all x with normal.x <= offset for every face

Both ways are one algorithm: a box is cut by one half-space after the other, and two vertices have an edge between them where no
third lies on all the faces that both lie on (the double description of Motzkin, Raiffa, Thompson and Thrall, 1953). The faces
of a hull are the vertices of its polar about a point inside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, cmp_to_key
from itertools import pairwise, product
from math import gcd, lcm
from typing import TypeVar

from stt_codegen.task.sets.convex_sets import ZERO, Bend, ConvexSet, Normal, Vector, axes, low_of

HalfSpace = tuple[Normal, Fraction]  # all x with normal.x <= offset
PLANE, SOLID = 2, 3
Number = TypeVar("Number", int, float, Fraction)


@dataclass(frozen=True)
class Vertex:
    """A point, and on which faces it lies: bit k for half-space number k."""

    point: Vector
    on: int


def dot(normal: Iterable[int | Fraction], point: Iterable[Fraction]) -> Fraction:
    return sum((c * v for c, v in zip(normal, point, strict=True) if c), ZERO)


def whole(vector: Sequence[Fraction]) -> tuple[Normal, Fraction]:
    """The whole numbers without a common divisor along a vector that is not 0, and by what it was multiplied."""
    factor = lcm(*(v.denominator for v in vector))
    numbers = [int(v * factor) for v in vector]
    common = gcd(*numbers)
    return tuple(v // common for v in numbers), Fraction(factor, common)


def cut_box(lower: Vector, upper: Vector, half_spaces: Sequence[HalfSpace]) -> list[Vertex]:
    """The vertices of a box that is cut by half-spaces. Faces of the box come first: bits 2i and 2i + 1 of dimension i."""
    n = len(lower)
    vertices = [
        Vertex(
            tuple(upper[i] if high else lower[i] for i, high in enumerate(corner)),
            sum(1 << 2 * i + h for i, h in enumerate(corner)),
        )
        for corner in product((0, 1), repeat=n)
    ]
    for k, (normal, offset) in enumerate(half_spaces, 2 * n):
        room = [offset - dot(normal, v.point) for v in vertices]
        bit, masks = 1 << k, [v.on for v in vertices]
        found = {v.point: Vertex(v.point, v.on | bit if r == 0 else v.on) for v, r in zip(vertices, room, strict=True) if r >= 0}
        inner, outer = [q for q, r in enumerate(room) if r > 0], [q for q, r in enumerate(room) if r < 0]
        for a, b in product(inner, outer):
            shared = masks[a] & masks[b]
            if shared.bit_count() < n - 1 or any(shared & m == shared for q, m in enumerate(masks) if q not in (a, b)):
                continue
            part = room[a] / (room[a] - room[b])
            point = tuple(v + part * (w - v) for v, w in zip(vertices[a].point, vertices[b].point, strict=True))
            before = found.get(point)
            found[point] = Vertex(point, shared | bit | (before.on if before else 0))
        vertices = list(found.values())
    return vertices


def around(points: Iterable[tuple[Number, Number]]) -> list[tuple[Number, Number]]:
    """The corners of the hull of points in the plane, in order around it to the left (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    sides: list[list[tuple[Number, Number]]] = []
    for way in (ordered, ordered[::-1]):
        side: list[tuple[Number, Number]] = []
        for p in way:
            while len(side) > 1 and _turn(side[-2], side[-1], p) <= 0:
                side.pop()
            side.append(p)
        sides.append(side[:-1])
    return sides[0] + sides[1]


def _turn(a: tuple[Number, Number], b: tuple[Number, Number], c: tuple[Number, Number]) -> Number:
    """Above 0 where a, b, c turn to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def spanned(points: Sequence[Vector]) -> int:
    """The dimension of the hull of points, by elimination."""
    rows = [[a - b for a, b in zip(p, points[0], strict=True)] for p in points[1:]]
    rank = 0
    for i in range(len(points[0])):
        pivot = next((r for r in rows[rank:] if r[i]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        rows.insert(rank, pivot)
        rank += 1
        rows[rank:] = [[v - r[i] / pivot[i] * w for v, w in zip(r, pivot, strict=True)] for r in rows[rank:]]
    return rank


@dataclass(frozen=True)
class Hull:
    """The hull of points that span their space: its faces, and its corners among the points, each with the faces it lies on."""

    faces: tuple[HalfSpace, ...]
    corners: tuple[Vertex, ...]

    @classmethod
    @cache
    def of(cls, points: tuple[Vector, ...]) -> Hull:
        """Of points whose hull has an interior."""
        points = tuple(dict.fromkeys(points))
        n = len(points[0])
        middle = tuple(sum((p[i] for p in points), ZERO) / len(points) for i in range(n))
        around = [whole([a - b for a, b in zip(p, middle, strict=True)]) for p in points if p != middle]
        places = [p for p in points if p != middle]
        reach = Fraction(1)
        while True:  # the polar is bounded, by how much is not known
            box = tuple(-reach for _ in range(n)), tuple(reach for _ in range(n))
            polar = cut_box(*box, [(normal, factor) for normal, factor in around])
            if not any(v.on & ((1 << 2 * n) - 1) for v in polar):
                break
            reach *= 16
        faces = []
        for v in polar:
            normal, factor = whole(v.point)
            faces.append((normal, (1 + dot(v.point, middle)) * factor, v.on >> 2 * n))
        faces.sort()
        on = [sum(1 << k for k, (_, _, mask) in enumerate(faces) if mask >> q & 1) for q in range(len(places))]
        corners = [
            Vertex(p, own) for p, own in zip(places, on, strict=True) if own and not any(own & o == own and o != own for o in on)
        ]
        return cls(tuple((normal, offset) for normal, offset, _ in faces), tuple(corners))


class Polytope(ConvexSet):
    """The hull of points that span their space."""

    def __init__(self, points: Sequence[Vector], name: str = "") -> None:
        self.points, self.name = tuple(points), name

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polytope) and (self.vertices, self.name) == (other.vertices, other.name)

    __hash__ = None  # type: ignore[assignment]

    @property
    def dimension(self) -> int:
        return len(self.points[0])

    @cached_property
    def hull(self) -> Hull:
        return Hull.of(self.points)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(sorted(v.point for v in self.hull.corners))

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        """The axes, the faces, and in space what is across an edge and an axis: the faces of the difference of box and set."""
        found = dict.fromkeys(axes(self.dimension))
        found.update(dict.fromkeys(normal for normal, _ in self.hull.faces))
        if self.dimension == SOLID:
            found.update(dict.fromkeys(self._across()))
        return tuple(found)

    def _across(self) -> list[Normal]:
        """Normals of an edge's supporting planes that hold a direction of an axis too."""
        corners, found = self.hull.corners, []
        for a in range(len(corners)):
            for b in range(a):
                shared = corners[a].on & corners[b].on
                if shared.bit_count() < SOLID - 1:
                    continue
                (x, y, z), _ = whole([v - w for v, w in zip(corners[a].point, corners[b].point, strict=True)])
                for normal in ((0, z, -y), (-z, 0, x), (y, -x, 0)):
                    if not any(normal):
                        continue
                    here = dot(normal, corners[a].point)
                    values = [dot(normal, v.point) for v in corners]
                    sign = 1 if here == max(values) else -1 if here == min(values) else 0
                    if sign:
                        found.append(whole([Fraction(sign * c) for c in normal])[0])
        return sorted(set(found))

    def support(self, normal: Normal) -> Fraction:
        return max(dot(normal, p) for p in self.points)

    @cached_property
    def bends(self) -> tuple[Bend, ...]:
        return bends_of(self)

    def apart(self, lower: Vector, upper: Vector) -> bool:
        """Exact in any dimension: beyond space, where normals are missing, the box is cut by the faces."""
        if any(low_of(n, lower, upper) > h for n, h in self.faces):
            return True
        return self.dimension > SOLID and not cut_box(lower, upper, self.hull.faces)


def bends_of(convex: ConvexSet) -> tuple[Bend, ...]:
    """The corners of a set grown by a box, each by a vertex and the signs of the box's corner that is added. In the plane all of
    them: between two neighbours among the normals, axes included, one vertex and one corner are farthest out. Elsewhere for each
    vertex the corner that leads away from the middle."""
    vertices = convex.vertices
    if convex.dimension == PLANE:
        ring = sorted(convex.normals, key=cmp_to_key(_turned))
        found = []
        for a, b in pairwise([*ring, ring[0]]):
            between = tuple(v * sum(map(abs, b)) + w * sum(map(abs, a)) for v, w in zip(a, b, strict=True))
            found.append((max(vertices, key=lambda p: dot(between, p)), _signs(between)))
        return tuple(dict.fromkeys(found))
    middle = [sum((p[i] for p in vertices), ZERO) / len(vertices) for i in range(convex.dimension)]
    found = []
    for p in vertices:
        signs = _signs([v - m for v, m in zip(p, middle, strict=True)])
        found += [(p, s) for s in product(*((v,) if v else (-1, 1) for v in signs))]
    return tuple(found)


def _signs(vector: Sequence[int | Fraction]) -> tuple[int, ...]:
    return tuple((v > 0) - (v < 0) for v in vector)


def _turned(a: Normal, b: Normal) -> int:
    """Below 0 where a comes before b on the way around from the first axis."""
    late = [(v[1], v[0]) < (0, 0) for v in (a, b)]
    return late[0] - late[1] or a[1] * b[0] - a[0] * b[1]
