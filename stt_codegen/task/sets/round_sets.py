"""Balls and capsules: all points within a radius of a point or of a segment.

    h(n) = max over the ends of n.end + radius * size(n)        size(n) >= |n|_2, a fraction

Every rational normal is as good as any other, so a fixed fan of them is tried, and in space one across a capsule's segment.
What is lost by it is below 0.6 % of the radius in the plane and 5 % in space; in four and more dimensions it may be a fifth and
more. It is lost as room; whether something is apart or inside is told by exact distances.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import combinations, pairwise, permutations, product

from stt_codegen.task.sets.convex_sets import ZERO, Bend, ConvexSet, Normal, Shadow, Vector, axes
from stt_codegen.task.sets.polytopes import PLANE, SOLID, HalfSpace, bends_of, cut_box, dot, whole

SIZE_BITS = 32  # size(n) is the least multiple of 2**-SIZE_BITS that is not below |n|_2
FAN = {PLANE: ((1, 0), (5, 1), (5, 2), (3, 2), (1, 1)), SOLID: ((1, 0, 0), (1, 1, 0), (1, 1, 1), (2, 1, 0), (2, 1, 1), (2, 2, 1))}
COARSE = {PLANE: ((1, 0), (5, 2), (1, 1)), SOLID: ((1, 0, 0), (1, 1, 0), (1, 1, 1))}  # for the corners of a route
MOST_PAIRED, MOST_SIGNED = 12, 6  # dimensions in which a fan has normals of two, and of all
ALIKE = 1 << 10  # parts at least of a ratio of lengths
DRAWN = 64  # points of a circle in a picture
FARTHEST = {
    1: Fraction(1),
    PLANE: Fraction("1.0055"),
    SOLID: Fraction("1.0495"),
}  # corners of the fan's polytope about the unit ball


@cache
def size(normal: tuple[int, ...]) -> Fraction:
    """|n|_2 rounded up."""
    square = sum(c * c for c in normal) << 2 * SIZE_BITS
    root = math.isqrt(square)
    return Fraction(root + (root * root < square), 1 << SIZE_BITS)


@cache
def fan(dimension: int, coarse: bool = False) -> tuple[Normal, ...]:
    """The normals of a ball: axes first, then all orders and signs of a few."""
    found, kinds = dict.fromkeys(axes(dimension)), (COARSE if coarse else FAN).get(dimension)
    if kinds is None:  # every two dimensions, and all, while that is not too many
        pairs = combinations(range(dimension), 2) if dimension <= MOST_PAIRED else ()
        orders = [tuple(int(i in pair) for i in range(dimension)) for pair in pairs]
        orders += [(1,) * dimension] if dimension <= MOST_SIGNED else []
    else:
        orders = [order for kind in kinds for order in dict.fromkeys(permutations(kind))]
    for order in orders:
        found.update(dict.fromkeys(product(*((-v, v) if v else (0,) for v in order))))
    return tuple(found)


@cache
def _unit(dimension: int) -> tuple[Vector, ...]:
    """The vertices of a polytope about the unit ball."""
    normals = fan(dimension, coarse=True) if dimension <= SOLID else axes(dimension)
    corner = (Fraction(1),) * dimension
    half_spaces = [(n, size(n)) for n in normals if sum(map(abs, n)) > 1]
    return tuple(v.point for v in cut_box(tuple(-c for c in corner), corner, half_spaces))


@cache
def fan_across(way: Normal) -> tuple[Normal, ...]:
    """Normals in space at right angles to a direction, as close to one another as those of `fan` in the plane."""
    least = min(range(SOLID), key=lambda i: abs(way[i]))
    unit = axes(SOLID)[2 * least + 1]
    first = _cross(way, unit)
    second = _cross(way, first)
    parts = ALIKE << int(size(second) / size(first)).bit_length()
    ratio = Fraction(round(parts * size(first) / size(second)), parts)  # which makes both as long, nearly
    found: dict[Normal, None] = {}
    for a, b in fan(PLANE):
        normal, _ = whole([a * v + b * ratio * w for v, w in zip(first, second, strict=True)])
        found[normal] = None
    return tuple(found)


def _cross(a: Normal, b: Normal) -> Normal:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def inscribed(centre: Vector, radius: Fraction) -> tuple[HalfSpace, ...]:
    """Half-spaces with the normals of the fan that leave a polytope within the ball, in at most three dimensions: they touch a
    smaller ball, so that its corners are no farther from the centre than the radius."""
    inner = radius / FARTHEST[len(centre)]
    return tuple((normal, dot(normal, centre) + inner * size(normal)) for normal in fan(len(centre)))


@dataclass(frozen=True)
class Segment(ConvexSet):
    """A point, or the segment between two: what is round about nothing."""

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
        """With those across the segment and an axis, all faces of the segment grown by a box."""
        found = dict.fromkeys(axes(self.dimension))
        if len(self.ends) > 1:
            way, _ = whole([b - a for a, b in zip(*self.ends, strict=True)])
            for i, j in combinations(range(self.dimension), 2):
                across = [ZERO] * self.dimension
                across[i], across[j] = Fraction(-way[j]), Fraction(way[i])
                if any(across):
                    normal, _ = whole(across)
                    found.update(dict.fromkeys((normal, tuple(-c for c in normal))))
        return tuple(found)

    def support(self, normal: Normal) -> Fraction:
        return max(dot(normal, p) for p in self.ends)

    def square_to(self, lower: Vector, upper: Vector) -> Fraction:
        """The square of the distance to a box, exact: along the segment it is convex and made of parabolas."""
        start, way = self.ends[0], [b - a for a, b in zip(self.ends[0], self.ends[-1], strict=True)]
        turns = {ZERO, Fraction(1)}
        for a, w, low, high in zip(start, way, lower, upper, strict=True):
            turns |= {t for edge in (low, high) if w and 0 < (t := (edge - a) / w) < 1}

        def gaps(t: Fraction) -> list[Fraction]:
            place = [a + t * w for a, w in zip(start, way, strict=True)]
            return [min(v - low, ZERO) + max(v - high, ZERO) for v, low, high in zip(place, lower, upper, strict=True)]

        places = sorted(turns)
        found = [sum((g * g for g in gaps(t)), ZERO) for t in places]
        for before, after in pairwise(places):
            here, slopes = gaps(before), [(b - a) / (after - before) for a, b in zip(gaps(before), gaps(after), strict=True)]
            bend = sum((s * s for s in slopes), ZERO)
            if bend:
                t = -sum((g * s for g, s in zip(here, slopes, strict=True)), ZERO) / bend
                if 0 < t < after - before:
                    found.append(sum(((g + t * s) ** 2 for g, s in zip(here, slopes, strict=True)), ZERO))
        return min(found)


@dataclass(frozen=True)
class Round(ConvexSet):
    """All points within a radius of a point or a segment: a ball or a capsule."""

    ends: tuple[Vector, ...]
    reach: Fraction
    name: str = ""

    @property
    def dimension(self) -> int:
        return len(self.ends[0])

    @property
    def core(self) -> Segment:
        """What it is round about."""
        return Segment(self.ends, self.name)

    @property
    def line(self) -> tuple[Vector, Vector]:
        return self.ends[0], self.ends[-1]

    @property
    def radius(self) -> Fraction:
        return self.reach

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        across: tuple[Normal, ...] = ()
        if self.dimension == SOLID and len(self.ends) > 1:
            way, _ = whole([b - a for a, b in zip(*self.ends, strict=True)])
            across = fan_across(way)
        return tuple(dict.fromkeys([*fan(self.dimension), *self.core.normals, *across]))

    def support(self, normal: Normal) -> Fraction:
        return self.core.support(normal) + self.reach * size(normal)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(
            tuple(v + self.reach * u for v, u in zip(p, unit, strict=True)) for p in self.ends for unit in _unit(self.dimension)
        )

    @cached_property
    def bends(self) -> tuple[Bend, ...]:
        if self.dimension > MOST_SIGNED:  # 2^n corners are too many: the ends of the axes, from where one goes around
            ends = [(p, n) for p in self.ends for n in axes(self.dimension)]
            return tuple((tuple(v + self.reach * c for v, c in zip(p, n, strict=True)), n) for p, n in ends)
        return bends_of(_Coarse(self))

    def spread(self, by: Fraction) -> Round:
        return Round(self.ends, self.reach + by, self.name)

    def shadow(self, i: int, j: int) -> Shadow:
        angles = [2 * math.pi * k / DRAWN for k in range(DRAWN)]
        radius, ends = float(self.reach), [(float(p[i]), float(p[j])) for p in self.ends]
        return [(x + radius * math.cos(a), y + radius * math.sin(a)) for x, y in ends for a in angles]

    def apart(self, lower: Vector, upper: Vector) -> bool:
        return self.core.square_to(lower, upper) > self.reach**2

    def covers(self, lower: Vector, upper: Vector) -> bool:
        corners = product(*zip(lower, upper, strict=True))
        return all(self.core.square_to(c, c) <= self.reach**2 for c in corners)


class _Coarse(ConvexSet):
    """A round set as the search for a route sees its corners: fewer normals."""

    def __init__(self, convex: Round) -> None:
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
