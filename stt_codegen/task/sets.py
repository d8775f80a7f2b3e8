"""Convex sets as the rest of the package sees them: by normals and support.

    h(n) = max over C of n.x,       low_n(B) = sum_i (n_i > 0 ? n_i L_i : n_i R_i)  for a box B = prod [L_i, R_i]

The box B and the set C are apart where low_n(B) > h(n) for one normal n (the separating hyperplane theorem). A set says which
normals are worth a try, and h for every n. Design, certificate, search, loops and pictures ask no more, so a new shape is one
class here, its table in shapes.py, and its place in the stand-alone checker, which shares nothing with this file.

All numbers are exact fractions in the task's units.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import product
from math import gcd, lcm

Vector = tuple[Fraction, ...]
Normal = tuple[int, ...]  # whole numbers: any rational normal has a multiple of these
ZERO = Fraction(0)


def axis(dimension: int, i: int, sign: int) -> Normal:
    """The normal +e_i or -e_i."""
    return tuple(sign if k == i else 0 for k in range(dimension))


@cache
def axes(dimension: int) -> tuple[Normal, ...]:
    """-e_1, +e_1, -e_2, +e_2, ..: below the set in dimension 1, above it, and so on."""
    return tuple(axis(dimension, i, sign) for i in range(dimension) for sign in (-1, 1))


class ConvexSet(ABC):
    """A convex and compact set in `dimension` dimensions."""

    name: str

    @property
    @abstractmethod
    def dimension(self) -> int: ...

    @property
    @abstractmethod
    def normals(self) -> tuple[Normal, ...]:
        """Those that are worth a try, the 2n of `axes` first; a polytope's faces must be among them."""

    @abstractmethod
    def support(self, normal: Normal) -> Fraction:
        """h(normal), the greatest of normal.x over the set, exact or rounded up."""

    @property
    @abstractmethod
    def vertices(self) -> tuple[Vector, ...]:
        """Points whose hull is the set."""

    # ---- what follows from these

    @cached_property
    def faces(self) -> tuple[tuple[Normal, Fraction], ...]:
        """Half-spaces normal.x <= offset that hold the set; for a polytope with all faces among its normals they meet in it."""
        return tuple((n, self.support(n)) for n in self.normals)

    def span(self, i: int) -> tuple[Fraction, Fraction]:
        """The least and the largest x_i in the set."""
        return -self.support(axis(self.dimension, i, -1)), self.support(axis(self.dimension, i, 1))

    def grown(self, half: Sequence[Fraction]) -> ConvexSet:
        """All points within the box of these half extents about some point of the set: where the middle of a body that touches
        the set may be."""
        return Grown(self, tuple(half)) if any(half) else self

    def apart(self, lower: Vector, upper: Vector) -> bool:
        """True only where the box and the set have no point in common, edges included; true wherever they have none if the faces
        are all of the set's and, beyond the plane, of the difference of both (for boxes and polygons they are)."""
        return any(low_of(n, lower, upper) > h for n, h in self.faces)

    def covers(self, lower: Vector, upper: Vector) -> bool:
        """Whether the whole box lies in all of the set's half-spaces: in the set, where its faces are all there."""
        return all(-low_of(tuple(-v for v in n), lower, upper) <= h for n, h in self.faces)


def low_of(normal: Normal, lower: Vector, upper: Vector) -> Fraction:
    """low_n of a box: the least of n.x over it."""
    return sum((c * (a if c > 0 else b) for c, a, b in zip(normal, lower, upper, strict=True) if c), ZERO)


@dataclass(frozen=True)
class BoxSet(ConvexSet):
    """A product of intervals."""

    lower: Vector
    upper: Vector
    name: str = ""

    @property
    def dimension(self) -> int:
        return len(self.lower)

    @property
    def normals(self) -> tuple[Normal, ...]:
        return axes(self.dimension)

    @cached_property
    def faces(self) -> tuple[tuple[Normal, Fraction], ...]:
        offsets = (v for a, b in zip(self.lower, self.upper, strict=True) for v in (-a, b))
        return tuple(zip(self.normals, offsets, strict=True))

    def span(self, i: int) -> tuple[Fraction, Fraction]:
        return self.lower[i], self.upper[i]

    def support(self, normal: Normal) -> Fraction:
        return sum((c * (b if c > 0 else a) for c, a, b in zip(normal, self.lower, self.upper, strict=True) if c), ZERO)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(product(*zip(self.lower, self.upper, strict=True)))

    def grown(self, half: Sequence[Fraction]) -> BoxSet:
        if not any(half):
            return self
        lower = tuple(a - h for a, h in zip(self.lower, half, strict=True))
        return BoxSet(lower, tuple(b + h for b, h in zip(self.upper, half, strict=True)), self.name)


Point = tuple[Fraction, Fraction]


def hull_of_points(points: Sequence[Point]) -> tuple[Point, ...]:
    """The corners of the hull of points in the plane, by turns to the left (Andrew's monotone chain); exact."""

    def turn(a: Point, b: Point, c: Point) -> Fraction:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    ordered, sides = sorted(set(points)), []
    for way in (ordered, ordered[::-1]):
        side: list[Point] = []
        for p in way:
            while len(side) > 1 and turn(side[-2], side[-1], p) <= 0:
                side.pop()
            side.append(p)
        sides.append(side[:-1])
    return (*sides[0], *sides[1])


@dataclass(frozen=True)
class Prism(ConvexSet):
    """A convex polygon, by its corners in order around it to the left, in the dimensions of `plane`; in all others what `lower`
    and `upper` say, whose entries in the plane are not read."""

    corners: tuple[Point, ...]
    plane: tuple[int, int]
    lower: Vector
    upper: Vector
    name: str = ""

    @property
    def dimension(self) -> int:
        return len(self.lower)

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        found = dict.fromkeys(axes(self.dimension))
        for (a, b), (c, d) in zip(self.corners, self.corners[1:] + self.corners[:1], strict=True):
            outward = (d - b, a - c)
            whole = [int(v * lcm(*(w.denominator for w in outward))) for v in outward]
            full = [0] * self.dimension
            for i, v in zip(self.plane, whole, strict=True):
                full[i] = v // gcd(*whole)
            found[tuple(full)] = None
        return tuple(found)

    def support(self, normal: Normal) -> Fraction:
        i, j = self.plane
        ends = [c * (b if c > 0 else a) for c, a, b in zip(normal, self.lower, self.upper, strict=True)]
        rest = sum((v for k, v in enumerate(ends) if k not in (i, j)), ZERO)
        return max(normal[i] * x + normal[j] * y for x, y in self.corners) + rest

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        i, j = self.plane
        ends = [(ZERO,) if k in (i, j) else pair for k, pair in enumerate(zip(self.lower, self.upper, strict=True))]
        found = []
        for corner, rest in product(self.corners, product(*ends)):
            point = list(rest)
            point[i], point[j] = corner
            found.append(tuple(point))
        return tuple(found)


class Grown(ConvexSet):
    """A set and the box of these half extents about every point of it (their Minkowski sum): supports add up."""

    def __init__(self, inner: ConvexSet, half: Vector) -> None:
        self.inner, self.half, self.name = inner, half, inner.name

    @property
    def dimension(self) -> int:
        return self.inner.dimension

    @property
    def normals(self) -> tuple[Normal, ...]:
        return self.inner.normals  # in the plane the sum has no other faces; elsewhere a missing one costs room, not soundness

    def support(self, normal: Normal) -> Fraction:
        return self.inner.support(normal) + sum((abs(c) * h for c, h in zip(normal, self.half, strict=True)), ZERO)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        corners = tuple(product(*((-h, h) for h in self.half)))
        return tuple(tuple(v + c for v, c in zip(p, corner, strict=True)) for p in self.inner.vertices for corner in corners)
