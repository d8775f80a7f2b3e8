"""Convex polytopes: from points to half-spaces and back, in exact fractions.

    hull of points      <->      all x with normal.x <= offset for every face

Both directions use one algorithm. A box is cut by one half-space after the other. Two vertices have an edge between them where
no third vertex lies on all the faces that both lie on (the double description of Motzkin, Raiffa, Thompson and Thrall, 1953).
The faces of a hull are the vertices of its polar about a point inside. The lemmas "shapes.*" (docs/lemmas.md) check both.

The tables of shapes.py, the checks of a task and the pictures call it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, cmp_to_key
from itertools import pairwise, product
from math import gcd, lcm
from typing import TypeVar

from stt_codegen.task.sets.convex_sets import ZERO, ConvexSet, Normal, RouteCorner, Vector, axis_normals, minimum_over_box

HalfSpace = tuple[Normal, Fraction]  # all x with normal.x <= offset
PLANE, SOLID = 2, 3
Number = TypeVar("Number", int, float, Fraction)


@dataclass(frozen=True)
class Vertex:
    """A point and the faces that it lies on: bit k of `face_mask` is set for half-space number k."""

    point: Vector
    face_mask: int


def dot(normal: Iterable[int | Fraction], point: Iterable[Fraction]) -> Fraction:
    """Return normal.point."""
    return sum((c * v for c, v in zip(normal, point, strict=True) if c), ZERO)


def primitive_normal(vector: Sequence[Fraction]) -> tuple[Normal, Fraction]:
    """Return the integer vector without a common divisor along a nonzero vector, and the factor between them."""
    factor = lcm(*(v.denominator for v in vector))
    numbers = [int(v * factor) for v in vector]
    common = gcd(*numbers)
    return tuple(v // common for v in numbers), Fraction(factor, common)


def cut_box(lower: Vector, upper: Vector, half_spaces: Sequence[tuple[Sequence[int | Fraction], Fraction]]) -> list[Vertex]:
    """Return the vertices of a box that is cut by half-spaces.

    In a face mask bits 2i and 2i + 1 are the lower and upper face of the box in dimension i; the bits of the half-spaces follow.
    """
    n = len(lower)
    vertices = [
        Vertex(
            tuple(upper[i] if high else lower[i] for i, high in enumerate(corner)),
            sum(1 << 2 * i + h for i, h in enumerate(corner)),
        )
        for corner in product((0, 1), repeat=n)
    ]
    for k, (normal, offset) in enumerate(half_spaces, 2 * n):
        bit, masks, margins = 1 << k, [v.face_mask for v in vertices], [offset - dot(normal, v.point) for v in vertices]
        remaining = {
            v.point: Vertex(v.point, v.face_mask | bit if margin == 0 else v.face_mask)
            for v, margin in zip(vertices, margins, strict=True)
            if margin >= 0
        }
        inner, outer = (
            [q for q, margin in enumerate(margins) if margin > 0],
            [q for q, margin in enumerate(margins) if margin < 0],
        )
        for a, b in product(inner, outer):
            shared = masks[a] & masks[b]
            has_edge = shared.bit_count() >= n - 1 and not any(
                shared & mask == shared for q, mask in enumerate(masks) if q not in (a, b)
            )
            if has_edge:
                part = margins[a] / (margins[a] - margins[b])
                point = tuple(v + part * (w - v) for v, w in zip(vertices[a].point, vertices[b].point, strict=True))
                same_point = remaining.get(point)
                remaining[point] = Vertex(point, shared | bit | (same_point.face_mask if same_point else 0))
        vertices = list(remaining.values())
    return vertices


def hull_corners(points: Iterable[tuple[Number, Number]]) -> list[tuple[Number, Number]]:
    """Return the corners of the hull of points in the plane, counterclockwise (Andrew's monotone chain)."""
    from_left = sorted(set(points))
    chains: list[list[tuple[Number, Number]]] = []
    for ordered in (from_left, from_left[::-1]):
        chain: list[tuple[Number, Number]] = []
        for p in ordered:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        chains.append(chain[:-1])
    return chains[0] + chains[1]


def _turn(a: tuple[Number, Number], b: tuple[Number, Number], c: tuple[Number, Number]) -> Number:
    """Return a number above 0 where a, b, c turn to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def affine_dimension(points: Sequence[Vector]) -> int:
    """Return the dimension of the hull of points, by Gaussian elimination."""
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
    """The hull of points that span their space: its faces, and those of the points that are its corners."""

    faces: tuple[HalfSpace, ...]
    corners: tuple[Vertex, ...]

    @classmethod
    @cache
    def of(cls, points: tuple[Vector, ...]) -> Hull:
        """Return the hull of points that span their space."""
        points = tuple(dict.fromkeys(points))
        n = len(points[0])
        middle = tuple(sum((p[i] for p in points), ZERO) / len(points) for i in range(n))
        points = tuple(p for p in points if p != middle)
        faces = []
        for v in _polar([tuple(a - b for a, b in zip(p, middle, strict=True)) for p in points]):
            normal, factor = primitive_normal(v.point)
            faces.append((normal, (1 + dot(v.point, middle)) * factor, v.face_mask >> 2 * n))
        faces.sort()
        masks = [sum(1 << k for k, (_, _, points_on) in enumerate(faces) if points_on >> q & 1) for q in range(len(points))]
        corners = [
            Vertex(p, mask)
            for p, mask in zip(points, masks, strict=True)
            if mask and not any(mask & larger == mask and larger != mask for larger in masks)
        ]
        return cls(tuple((normal, offset) for normal, offset, _ in faces), tuple(corners))


def _polar(points: Sequence[Vector]) -> list[Vertex]:
    """Return the vertices of the polar {y: p.y <= 1 for every p} of points about 0; bit 2n + q of a face mask is point q."""
    half_spaces, n, half_width = [primitive_normal(p) for p in points], len(points[0]), Fraction(1)
    while True:  # the polar is bounded, but its size is not known before
        vertices = cut_box((-half_width,) * n, (half_width,) * n, half_spaces)
        if not any(v.face_mask & ((1 << 2 * n) - 1) for v in vertices):
            return vertices
        half_width *= 16


class Polytope(ConvexSet):
    """The hull of points that span their space."""

    def __init__(self, points: Sequence[Vector], name: str = "") -> None:
        self.points, self.name = tuple(points), name

    def __eq__(self, value: object) -> bool:
        return isinstance(value, Polytope) and (self.vertices, self.name) == (value.vertices, value.name)

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
        """The axes, the faces and, in three dimensions, the normals to an edge and an axis.

        In up to three dimensions these are the faces of the Minkowski difference of a box and the set."""
        normals = dict.fromkeys(axis_normals(self.dimension))
        normals.update(dict.fromkeys(normal for normal, _ in self.hull.faces))
        if self.dimension == SOLID:
            normals.update(dict.fromkeys(self._edge_normals()))
        return tuple(normals)

    def _edge_normals(self) -> list[Normal]:
        """Return the normals of those supporting planes of an edge that are parallel to an axis."""
        corners, normals = self.hull.corners, []
        for a in range(len(corners)):
            for b in range(a):
                shared = corners[a].face_mask & corners[b].face_mask
                if shared.bit_count() < SOLID - 1:
                    continue
                (x, y, z), _ = primitive_normal([v - w for v, w in zip(corners[a].point, corners[b].point, strict=True)])
                for normal in ((0, z, -y), (-z, 0, x), (y, -x, 0)):
                    if not any(normal):
                        continue
                    on_edge = dot(normal, corners[a].point)
                    values = [dot(normal, v.point) for v in corners]
                    sign = 1 if on_edge == max(values) else -1 if on_edge == min(values) else 0
                    if sign:
                        normals.append(primitive_normal([Fraction(sign * c) for c in normal])[0])
        return sorted(set(normals))

    def support(self, normal: Normal) -> Fraction:
        return max(dot(normal, p) for p in self.points)

    @cached_property
    def route_corners(self) -> tuple[RouteCorner, ...]:
        return route_corners_of(self)

    def is_apart_from(self, lower: Vector, upper: Vector) -> bool:
        """Whether the box and the polytope have no common point, exact in any dimension.

        In more than three dimensions normals are missing, so the box is cut by the faces."""
        if any(minimum_over_box(n, lower, upper) > h for n, h in self.faces):
            return True
        return self.dimension > SOLID and not cut_box(lower, upper, self.hull.faces)


def route_corners_of(convex: ConvexSet) -> tuple[RouteCorner, ...]:
    """Return the corners of a set grown by a box, each by a vertex of the set and the signs of the box's corner added to it.

    In the plane these are all corners: between two neighbouring normals, axes included, one vertex and one corner of the box are
    extreme. In other dimensions each vertex has the corner of the box that leads away from the middle of the set.
    """
    vertices = convex.vertices
    if convex.dimension == PLANE:
        ring = sorted(convex.normals, key=cmp_to_key(_compare_angles))
        corners = []
        for a, b in pairwise([*ring, ring[0]]):
            between = tuple(v * sum(map(abs, b)) + w * sum(map(abs, a)) for v, w in zip(a, b, strict=True))
            corners.append((max(vertices, key=lambda p: dot(between, p)), _signs(between)))
        return tuple(dict.fromkeys(corners))
    middle = [sum((p[i] for p in vertices), ZERO) / len(vertices) for i in range(convex.dimension)]
    corners = []
    for p in vertices:
        signs = _signs([v - m for v, m in zip(p, middle, strict=True)])
        corners += [(p, s) for s in product(*((v,) if v else (-1, 1) for v in signs))]
    return tuple(corners)


def _signs(vector: Sequence[int | Fraction]) -> tuple[int, ...]:
    return tuple((v > 0) - (v < 0) for v in vector)


def _compare_angles(a: Normal, b: Normal) -> int:
    """Return a number below 0 where the angle of a, counterclockwise from the first axis, is smaller than that of b."""
    is_below_axis = [(v[1], v[0]) < (0, 0) for v in (a, b)]
    return is_below_axis[0] - is_below_axis[1] or a[1] * b[0] - a[0] * b[1]
