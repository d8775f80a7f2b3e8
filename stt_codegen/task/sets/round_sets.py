"""Balls and capsules: all points within a radius of a point or of a segment.

    h(n) = max over the ends of n.end + radius * size(n)        size(n) >= |n|_2, a fraction

A round set has infinitely many supporting half-spaces, so a fixed fan of normals is tried, in three dimensions with a second fan
across a capsule's segment. A tube loses free space by it: less than 0.6 % of the radius in the plane and 5 % in three dimensions;
in four and more it may lose a fifth or more. Whether a box is apart from a round set or inside is decided by exact distances.

The lemmas "shapes.round" and "shapes.nearest" (docs/lemmas.md) check supports and distances. The tables of shapes.py call it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import combinations, pairwise, permutations, product

from stt_codegen.task.sets.convex_sets import ZERO, ConvexSet, Normal, PlanePoints, RouteCorner, Vector, axis_normals
from stt_codegen.task.sets.polytopes import PLANE, SOLID, HalfSpace, cut_box, dot, primitive_normal, route_corners_of

SIZE_BITS = 32  # size(n) is the smallest multiple of 2**-SIZE_BITS that is not below |n|_2
FAN = {PLANE: ((1, 0), (5, 1), (5, 2), (3, 2), (1, 1)), SOLID: ((1, 0, 0), (1, 1, 0), (1, 1, 1), (2, 1, 0), (2, 1, 1), (2, 2, 1))}
COARSE = {PLANE: ((1, 0), (5, 2), (1, 1)), SOLID: ((1, 0, 0), (1, 1, 0), (1, 1, 1))}  # for the corners of a route
PAIRED_DIMENSION_LIMIT = 12  # in more dimensions a fan has no normals between two axes, of which there would be too many
SIGNED_DIMENSION_LIMIT = 6  # in more it has no normals between all axes
RATIO_PARTS = 1 << 10  # into at least so many parts a ratio of lengths is rounded
CIRCLE_POINTS = 64  # of a circle in a picture
FAN_CORNER_DISTANCES = {
    1: Fraction(1),
    PLANE: Fraction("1.0055"),
    SOLID: Fraction("1.0495"),
}  # by dimension: how far from the middle the corners of the fan's polytope about the unit ball are


@cache
def size(normal: tuple[int, ...]) -> Fraction:
    """Return |n|_2, rounded up to a multiple of 2**-SIZE_BITS."""
    square = sum(c * c for c in normal) << 2 * SIZE_BITS
    root = math.isqrt(square)
    return Fraction(root + (root * root < square), 1 << SIZE_BITS)


@cache
def fan(dimension: int, coarse: bool = False) -> tuple[Normal, ...]:
    """Return the normals that are tried for a ball: the axes, then all permutations and signs of a few vectors."""
    normals, patterns = dict.fromkeys(axis_normals(dimension)), (COARSE if coarse else FAN).get(dimension)
    if patterns is None:  # between every two axes, and between all of them, while that is not too many
        pairs = combinations(range(dimension), 2) if dimension <= PAIRED_DIMENSION_LIMIT else ()
        unsigned = [tuple(int(i in pair) for i in range(dimension)) for pair in pairs]
        unsigned += [(1,) * dimension] if dimension <= SIGNED_DIMENSION_LIMIT else []
    else:
        unsigned = [vector for pattern in patterns for vector in dict.fromkeys(permutations(pattern))]
    for vector in unsigned:
        normals.update(dict.fromkeys(product(*((-v, v) if v else (0,) for v in vector))))
    return tuple(normals)


@cache
def _unit_ball_corners(dimension: int) -> tuple[Vector, ...]:
    """Return the vertices of a polytope that contains the unit ball."""
    normals = fan(dimension, coarse=True) if dimension <= SOLID else axis_normals(dimension)
    corner = (Fraction(1),) * dimension
    half_spaces = [(n, size(n)) for n in normals if sum(map(abs, n)) > 1]
    return tuple(v.point for v in cut_box(tuple(-c for c in corner), corner, half_spaces))


@cache
def fan_across(direction: Normal) -> tuple[Normal, ...]:
    """Return normals perpendicular to a direction in three dimensions, as dense as those of `fan` in the plane."""
    flattest = min(range(SOLID), key=lambda i: abs(direction[i]))
    first = _cross(direction, axis_normals(SOLID)[2 * flattest + 1])
    second = _cross(direction, first)
    parts = RATIO_PARTS << int(size(second) / size(first)).bit_length()
    ratio = Fraction(round(parts * size(first) / size(second)), parts)  # makes both vectors nearly equally long
    normals = (primitive_normal([a * v + b * ratio * w for v, w in zip(first, second, strict=True)])[0] for a, b in fan(PLANE))
    return tuple(dict.fromkeys(normals))


def _cross(a: Normal, b: Normal) -> Normal:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def inscribed(centre: Vector, radius: Fraction) -> tuple[HalfSpace, ...]:
    """Return half-spaces with the normals of the fan whose intersection lies within the ball, in at most three dimensions.

    They touch a smaller ball, so that the corners of their intersection are no farther from the centre than the radius.
    """
    inner_radius = radius / FAN_CORNER_DISTANCES[len(centre)]
    return tuple((normal, dot(normal, centre) + inner_radius * size(normal)) for normal in fan(len(centre)))


@dataclass(frozen=True)
class Segment(ConvexSet):
    """A point, or the segment between two points: a round set of radius 0."""

    ends: tuple[Vector, ...]
    name: str = ""

    @property
    def dimension(self) -> int:
        return len(self.ends[0])

    @property
    def vertices(self) -> tuple[Vector, ...]:
        return self.ends

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        """The axes and the normals to the segment in the plane of two axes: the faces of the segment grown by a box."""
        normals = dict.fromkeys(axis_normals(self.dimension))
        if len(self.ends) > 1:
            direction, _ = primitive_normal([b - a for a, b in zip(*self.ends, strict=True)])
            for i, j in combinations(range(self.dimension), 2):
                perpendicular = [ZERO] * self.dimension
                perpendicular[i], perpendicular[j] = Fraction(-direction[j]), Fraction(direction[i])
                if any(perpendicular):
                    normal, _ = primitive_normal(perpendicular)
                    normals.update(dict.fromkeys((normal, tuple(-c for c in normal))))
        return tuple(normals)

    def support(self, normal: Normal) -> Fraction:
        return max(dot(normal, p) for p in self.ends)

    def squared_distance_to(self, lower: Vector, upper: Vector) -> Fraction:
        """Return the square of the distance to a box, exact.

        Along the segment, from 0 to 1, that square is convex and piecewise quadratic: it changes where the segment crosses the
        plane of a face. So the minimum is at such a crossing or at the vertex of a parabola between two.
        """
        start, direction = self.ends[0], [b - a for a, b in zip(self.ends[0], self.ends[-1], strict=True)]
        crossings = {ZERO, Fraction(1)}
        for a, w, low, high in zip(start, direction, lower, upper, strict=True):
            crossings |= {t for edge in (low, high) if w and 0 < (t := (edge - a) / w) < 1}

        def gaps(t: Fraction) -> list[Fraction]:
            point = [a + t * w for a, w in zip(start, direction, strict=True)]
            return [min(v - low, ZERO) + max(v - high, ZERO) for v, low, high in zip(point, lower, upper, strict=True)]

        squares = [sum((g * g for g in gaps(t)), ZERO) for t in crossings]
        for before, after in pairwise(sorted(crossings)):
            first, slopes = gaps(before), [(b - a) / (after - before) for a, b in zip(gaps(before), gaps(after), strict=True)]
            curvature = sum((s * s for s in slopes), ZERO)
            if curvature:
                t = -sum((g * s for g, s in zip(first, slopes, strict=True)), ZERO) / curvature
                if 0 < t < after - before:
                    squares.append(sum(((g + t * s) ** 2 for g, s in zip(first, slopes, strict=True)), ZERO))
        return min(squares)


@dataclass(frozen=True)
class RoundSet(ConvexSet):
    """All points within a radius of a point or a segment: a ball or a capsule."""

    ends: tuple[Vector, ...]
    ball_radius: Fraction
    name: str = ""

    @property
    def dimension(self) -> int:
        return len(self.ends[0])

    @property
    def core(self) -> Segment:
        """The point or the segment about which the set is round."""
        return Segment(self.ends, self.name)

    @property
    def segment_ends(self) -> tuple[Vector, Vector]:
        return self.ends[0], self.ends[-1]

    @property
    def radius(self) -> Fraction:
        return self.ball_radius

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        across: tuple[Normal, ...] = ()
        if self.dimension == SOLID and len(self.ends) > 1:
            across = fan_across(primitive_normal([b - a for a, b in zip(*self.ends, strict=True)])[0])
        return tuple(dict.fromkeys([*fan(self.dimension), *self.core.normals, *across]))

    def support(self, normal: Normal) -> Fraction:
        return self.core.support(normal) + self.ball_radius * size(normal)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(
            tuple(v + self.ball_radius * u for v, u in zip(p, corner, strict=True))
            for p in self.ends
            for corner in _unit_ball_corners(self.dimension)
        )

    @cached_property
    def route_corners(self) -> tuple[RouteCorner, ...]:
        if self.dimension > SIGNED_DIMENSION_LIMIT:  # 2^n corners are too many, so a route bends at the ends of the axes
            ends = [(p, n) for p in self.ends for n in axis_normals(self.dimension)]
            return tuple((tuple(v + self.ball_radius * c for v, c in zip(p, n, strict=True)), n) for p, n in ends)
        return route_corners_of(_CoarseRoundSet(self))

    def inflated(self, by: Fraction) -> RoundSet:
        return RoundSet(self.ends, self.ball_radius + by, self.name)

    def projection(self, i: int, j: int) -> PlanePoints:
        angles = [2 * math.pi * k / CIRCLE_POINTS for k in range(CIRCLE_POINTS)]
        radius, ends = float(self.ball_radius), [(float(p[i]), float(p[j])) for p in self.ends]
        return [(x + radius * math.cos(a), y + radius * math.sin(a)) for x, y in ends for a in angles]

    def is_apart_from(self, lower: Vector, upper: Vector) -> bool:
        return self.core.squared_distance_to(lower, upper) > self.ball_radius**2

    def covers(self, lower: Vector, upper: Vector) -> bool:
        corners = product(*zip(lower, upper, strict=True))
        return all(self.core.squared_distance_to(c, c) <= self.ball_radius**2 for c in corners)


class _CoarseRoundSet(ConvexSet):
    """A round set with fewer normals, so that a route around it has fewer corners to choose from."""

    def __init__(self, convex: RoundSet) -> None:
        self.convex = convex

    @property
    def dimension(self) -> int:
        return self.convex.dimension

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        return tuple(dict.fromkeys([*fan(self.dimension, coarse=True), *self.convex.core.normals]))

    def support(self, normal: Normal) -> Fraction:
        return self.convex.support(normal)

    @property
    def vertices(self) -> tuple[Vector, ...]:
        return self.convex.vertices
