"""Convex sets as the rest of the package sees them: by normals and support.

    h(n) = max over C of n.x,       low_n(B) = min over B of n.x = sum_i (n_i > 0 ? n_i L_i : n_i R_i),  B = prod [L_i, R_i]

The box B and the set C have no common point where low_n(B) > h(n) for one normal n (the separating hyperplane theorem). A set
lists the normals that are worth a try, and computes h for every n. Design, certificate, search, loops and pictures use nothing
else. So a new shape is one class here, its table in shapes.py, and its place in the stand-alone checker, which shares nothing
with this file. The lemmas "rows.*" and "shapes.*" (docs/lemmas.md) prove what a separating normal implies.

All numbers are exact fractions in the task's units.

Long because the interface of sets stands beside boxes, prisms and grown sets, which define it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import product

Vector = tuple[Fraction, ...]
Normal = tuple[int, ...]  # whole numbers: any rational normal has a multiple of these
RouteCorner = tuple[Vector, tuple[int, ...]]  # a point of a set, and the signs of a corner of the box by which the set is grown
PlanePoints = list[tuple[float, float]]
ZERO = Fraction(0)
BOX_CORNERS_DIMENSION_LIMIT = 10  # in more dimensions a box has too many corners to go through them all


def axis_normal(dimension: int, i: int, sign: int) -> Normal:
    """Return the normal +e_i or -e_i."""
    return tuple(sign if k == i else 0 for k in range(dimension))


@cache
def axis_normals(dimension: int) -> tuple[Normal, ...]:
    """Return -e_1, +e_1, -e_2, +e_2, ..: the normal below a set in dimension 1, the one above it, and so on."""
    return tuple(axis_normal(dimension, i, sign) for i in range(dimension) for sign in (-1, 1))


class ConvexSet(ABC):
    """A convex and compact set in `dimension` dimensions."""

    name: str

    @property
    @abstractmethod
    def dimension(self) -> int: ...

    @property
    @abstractmethod
    def normals(self) -> tuple[Normal, ...]:
        """The normals that are worth a try, the 2n of `axis_normals` first; those of a polytope's faces must be among them."""

    @abstractmethod
    def support(self, normal: Normal) -> Fraction:
        """Return h(normal), the maximum of normal.x over the set, exact or rounded up."""

    @property
    @abstractmethod
    def vertices(self) -> tuple[Vector, ...]:
        """Points whose hull is the set; for a round set a hull that contains it."""

    # ---- defaults, which follow from the members above; a subclass may have better ones

    @property
    def bounded_axes(self) -> tuple[int, ...]:
        """The dimensions that the set bounds, by index; in all others it contains every value."""
        return tuple(range(self.dimension))

    @property
    def route_corners(self) -> tuple[RouteCorner, ...]:
        """Corners that a shortest route around the set, grown by a box, may have: point + sign * half extent, by dimension."""
        signs = tuple(product((-1, 1), repeat=self.dimension))
        return tuple((p, s) for p in self.vertices for s in signs)

    @property
    def radius(self) -> Fraction:
        """The distance within which a round set holds all points about its segment; 0 for a polytope."""
        return ZERO

    @property
    def segment_ends(self) -> tuple[Vector, Vector]:
        """The two ends of the segment about which a set is round; 0 in dimensions that it does not bound."""
        raise NotImplementedError(f"{type(self).__name__} is not round")

    def projection(self, i: int, j: int) -> PlanePoints:
        """Return points whose hull is the projection of the set onto dimensions i and j, for a picture."""
        return [(float(p[i]), float(p[j])) for p in self.vertices]

    @cached_property
    def faces(self) -> tuple[tuple[Normal, Fraction], ...]:
        """Half-spaces normal.x <= offset that contain the set; a polytope with complete normals is their intersection."""
        return tuple((n, self.support(n)) for n in self.normals)

    def span(self, i: int) -> tuple[Fraction, Fraction]:
        """Return the minimum and the maximum of x_i over the set."""
        return -self.support(axis_normal(self.dimension, i, -1)), self.support(axis_normal(self.dimension, i, 1))

    def grown(self, half: Sequence[Fraction]) -> ConvexSet:
        """Return the Minkowski sum of the set and the box of these half extents.

        It is where the middle of a body of that size may be while the body touches the set."""
        return GrownSet(self, tuple(half)) if any(half) else self

    def inflated(self, by: Fraction) -> ConvexSet:
        """Return the set larger by this length on every side, in its bounded axes: a round set by a ball, others by a box."""
        return self.grown([by if i in self.bounded_axes else ZERO for i in range(self.dimension)])

    def is_apart_from(self, lower: Vector, upper: Vector) -> bool:
        """Whether one of the set's normals separates it from the closed box; then they have no common point.

        The converse holds where the normals include every face of the set and, in more than two dimensions, every face of the
        Minkowski difference of set and box."""
        return any(minimum_over_box(n, lower, upper) > h for n, h in self.faces)

    def covers(self, lower: Vector, upper: Vector) -> bool:
        """Whether the box lies in all of the set's half-spaces; in the set, where its normals include all of its faces."""
        return all(-minimum_over_box(tuple(-v for v in n), lower, upper) <= h for n, h in self.faces)


def minimum_over_box(normal: Normal, lower: Vector, upper: Vector) -> Fraction:
    """Return low_n of a box: the minimum of n.x over it."""
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
        return axis_normals(self.dimension)

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


@dataclass(frozen=True)
class Prism(ConvexSet):
    """A base set in the dimensions of `axes`, times the interval from `lower` to `upper` in each other dimension.

    The entries of `lower` and `upper` in `axes` are not read."""

    base: ConvexSet
    axes: tuple[int, ...]
    lower: Vector
    upper: Vector
    name: str = ""

    @property
    def dimension(self) -> int:
        return len(self.lower)

    @property
    def bounded_axes(self) -> tuple[int, ...]:
        return self.axes

    def _embedded(self, base_vector: Sequence[int]) -> tuple[int, ...]:
        """Return a vector of the base in all dimensions, with 0 in those that the base does not have."""
        entries = dict(zip(self.axes, base_vector, strict=True))
        return tuple(entries.get(k, 0) for k in range(self.dimension))

    def _interval_ends(self) -> list[tuple[Fraction, ...]]:
        """Return by dimension the two ends of its interval, or a single 0 where the dimension is the base's."""
        pairs = zip(self.lower, self.upper, strict=True)
        return [(ZERO,) if k in self.axes else pair for k, pair in enumerate(pairs)]

    def _points_over(self, base_point: Vector) -> list[Vector]:
        """Return a point of the base combined with all ends of the intervals."""
        entries = dict(zip(self.axes, base_point, strict=True))
        return [tuple(entries.get(k, v) for k, v in enumerate(ends)) for ends in product(*self._interval_ends())]

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        return tuple(dict.fromkeys([*axis_normals(self.dimension), *(self._embedded(n) for n in self.base.normals)]))

    def support(self, normal: Normal) -> Fraction:
        over_intervals = (
            c * (ends[-1] if c > 0 else ends[0]) for c, ends in zip(normal, self._interval_ends(), strict=True) if c
        )
        return self.base.support(tuple(normal[k] for k in self.axes)) + sum(over_intervals, ZERO)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(p for v in self.base.vertices for p in self._points_over(v))

    @cached_property
    def route_corners(self) -> tuple[RouteCorner, ...]:
        return tuple((p, self._embedded(signs)) for v, signs in self.base.route_corners for p in self._points_over(v)[:1])

    @property
    def segment_ends(self) -> tuple[Vector, Vector]:
        entries = [dict(zip(self.axes, end, strict=True)) for end in self.base.segment_ends]
        first, last = (tuple(end.get(k, ZERO) for k in range(self.dimension)) for end in entries)
        return first, last

    @property
    def radius(self) -> Fraction:
        return self.base.radius

    def projection(self, i: int, j: int) -> PlanePoints:
        spans = [[float(v) for v in self.span(k)] for k in (i, j)]
        if i in self.axes and j in self.axes:
            return self.base.projection(self.axes.index(i), self.axes.index(j))
        return [(x, y) for x in spans[0] for y in spans[1]]

    def inflated(self, by: Fraction) -> ConvexSet:
        return Prism(self.base.inflated(by), self.axes, self.lower, self.upper, self.name)

    @property
    def _interval_axes(self) -> list[int]:
        return [k for k in range(self.dimension) if k not in self.axes]

    def is_apart_from(self, lower: Vector, upper: Vector) -> bool:
        if any(upper[k] < self.lower[k] or lower[k] > self.upper[k] for k in self._interval_axes):
            return True
        return self.base.is_apart_from(tuple(lower[k] for k in self.axes), tuple(upper[k] for k in self.axes))

    def covers(self, lower: Vector, upper: Vector) -> bool:
        is_in_intervals = all(self.lower[k] <= lower[k] and upper[k] <= self.upper[k] for k in self._interval_axes)
        return is_in_intervals and self.base.covers(*(tuple(edge[k] for k in self.axes) for edge in (lower, upper)))


class GrownSet(ConvexSet):
    """The Minkowski sum of a set and the box of these half extents; its support is the sum of theirs."""

    def __init__(self, inner: ConvexSet, half: Vector) -> None:
        self.inner, self.half, self.name = inner, half, inner.name

    @property
    def dimension(self) -> int:
        return self.inner.dimension

    @property
    def normals(self) -> tuple[Normal, ...]:
        return self.inner.normals  # they already suffice against boxes; elsewhere a missing normal costs some free space

    def support(self, normal: Normal) -> Fraction:
        return self.inner.support(normal) + sum((abs(c) * h for c, h in zip(normal, self.half, strict=True)), ZERO)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        corners = tuple(product(*((-h, h) for h in self.half)))
        return tuple(tuple(v + c for v, c in zip(p, corner, strict=True)) for p in self.inner.vertices for corner in corners)

    @cached_property
    def route_corners(self) -> tuple[RouteCorner, ...]:
        half = self.half
        return tuple(
            (tuple(v + s * h for v, s, h in zip(p, signs, half, strict=True)), signs) for p, signs in self.inner.route_corners
        )

    @property
    def segment_ends(self) -> tuple[Vector, Vector]:
        return self.inner.segment_ends

    @property
    def radius(self) -> Fraction:
        return self.inner.radius

    def projection(self, i: int, j: int) -> PlanePoints:
        a, b = float(self.half[i]), float(self.half[j])
        return [(x + s * a, y + t * b) for x, y in self.inner.projection(i, j) for s in (-1, 1) for t in (-1, 1)]

    def inflated(self, by: Fraction) -> ConvexSet:
        return GrownSet(self.inner.inflated(by), self.half)

    def is_apart_from(self, lower: Vector, upper: Vector) -> bool:
        half = self.half  # a symmetric box may be added to the other side instead
        wider = tuple(a - h for a, h in zip(lower, half, strict=True)), tuple(b + h for b, h in zip(upper, half, strict=True))
        return self.inner.is_apart_from(*wider)

    def covers(self, lower: Vector, upper: Vector) -> bool:
        if self.dimension > BOX_CORNERS_DIMENSION_LIMIT:
            return False  # not known; callers only refuse what is covered, so the task is not refused for this
        corners = product(*zip(lower, upper, strict=True))
        return super().covers(lower, upper) and not any(self.is_apart_from(c, c) for c in corners)

    @property
    def bounded_axes(self) -> tuple[int, ...]:
        return self.inner.bounded_axes
