"""Convex sets as the rest of the package sees them: by normals and support.

    h(n) = max over C of n.x,       low_n(B) = sum_i (n_i > 0 ? n_i L_i : n_i R_i)  for a box B = prod [L_i, R_i]

The box B and the set C are apart where low_n(B) > h(n) for one normal n (the separating hyperplane theorem). A set says which
normals are worth a try, and h for every n. Design, certificate, search, loops and pictures ask no more, so a new shape is one
class here, its table in shapes.py, and its place in the stand-alone checker, which shares nothing with this file.

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
Bend = tuple[Vector, tuple[int, ...]]  # a point, and the signs of a corner of the box by which a set is grown
Shadow = list[tuple[float, float]]
ZERO = Fraction(0)
MOST_CORNERS = 10  # dimensions in which all corners of a box are looked at


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
        """Points whose hull is the set; of a round one, whose hull holds it."""

    # ---- what follows from these, where nothing better is known

    @property
    def bounded_axes(self) -> tuple[int, ...]:
        """The dimensions that it bounds; all others may be anything."""
        return tuple(range(self.dimension))

    @property
    def bends(self) -> tuple[Bend, ...]:
        """Where a shortest way around the set, grown by a box, may bend: point + sign * half extent, by dimension."""
        signs = tuple(product((-1, 1), repeat=self.dimension))
        return tuple((p, s) for p in self.vertices for s in signs)

    @property
    def radius(self) -> Fraction:
        """Of a round set: it is all that is so near to its line, and boxes about that. 0 of a polytope."""
        return ZERO

    @property
    def line(self) -> tuple[Vector, Vector]:
        """The ends of the segment that a round set is about; 0 in dimensions that are not its own."""
        raise NotImplementedError(f"{type(self).__name__} is not round")

    def shadow(self, i: int, j: int) -> Shadow:
        """Points whose hull is what is seen of the set in dimensions i and j, for a picture."""
        return [(float(p[i]), float(p[j])) for p in self.vertices]

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

    def spread(self, by: Fraction) -> ConvexSet:
        """The set larger by so much on every side, in its own dimensions: a round one by a ball, others by a box."""
        return self.grown([by if i in self.bounded_axes else ZERO for i in range(self.dimension)])

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


@dataclass(frozen=True)
class Prism(ConvexSet):
    """A set in the dimensions of `axes`; in all others what `lower` and `upper` say, whose entries in `axes` are not read."""

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

    def _full(self, own: Sequence[int]) -> tuple[int, ...]:
        """A vector of the base's dimensions in all of them, 0 elsewhere."""
        place = dict(zip(self.axes, own, strict=True))
        return tuple(place.get(k, 0) for k in range(self.dimension))

    def _ends(self) -> list[tuple[Fraction, ...]]:
        """By dimension the ends of the others, one 0 in the base's."""
        pairs = zip(self.lower, self.upper, strict=True)
        return [(ZERO,) if k in self.axes else pair for k, pair in enumerate(pairs)]

    def _points(self, own: Vector) -> list[Vector]:
        """A point of the base with all ends of the others."""
        place = dict(zip(self.axes, own, strict=True))
        return [tuple(place.get(k, v) for k, v in enumerate(ends)) for ends in product(*self._ends())]

    @cached_property
    def normals(self) -> tuple[Normal, ...]:
        return tuple(dict.fromkeys([*axes(self.dimension), *(self._full(n) for n in self.base.normals)]))

    def support(self, normal: Normal) -> Fraction:
        rest = (c * (ends[-1] if c > 0 else ends[0]) for c, ends in zip(normal, self._ends(), strict=True) if c)
        return self.base.support(tuple(normal[k] for k in self.axes)) + sum(rest, ZERO)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(p for v in self.base.vertices for p in self._points(v))

    @cached_property
    def bends(self) -> tuple[Bend, ...]:
        return tuple((p, self._full(signs)) for v, signs in self.base.bends for p in self._points(v)[:1])

    @property
    def line(self) -> tuple[Vector, Vector]:
        places = [dict(zip(self.axes, end, strict=True)) for end in self.base.line]
        first, last = (tuple(place.get(k, ZERO) for k in range(self.dimension)) for place in places)
        return first, last

    @property
    def radius(self) -> Fraction:
        return self.base.radius

    def shadow(self, i: int, j: int) -> Shadow:
        spans = [[float(v) for v in self.span(k)] for k in (i, j)]
        if i in self.axes and j in self.axes:
            return self.base.shadow(self.axes.index(i), self.axes.index(j))
        return [(x, y) for x in spans[0] for y in spans[1]]

    def spread(self, by: Fraction) -> ConvexSet:
        return Prism(self.base.spread(by), self.axes, self.lower, self.upper, self.name)

    def _within_others(self, lower: Vector, upper: Vector) -> bool:
        others = [k for k in range(self.dimension) if k not in self.axes]
        return all(self.lower[k] <= lower[k] and upper[k] <= self.upper[k] for k in others)

    def apart(self, lower: Vector, upper: Vector) -> bool:
        others = (k for k in range(self.dimension) if k not in self.axes)
        if any(upper[k] < self.lower[k] or lower[k] > self.upper[k] for k in others):
            return True
        return self.base.apart(tuple(lower[k] for k in self.axes), tuple(upper[k] for k in self.axes))

    def covers(self, lower: Vector, upper: Vector) -> bool:
        own = (tuple(edge[k] for k in self.axes) for edge in (lower, upper))
        return self._within_others(lower, upper) and self.base.covers(*own)


class Grown(ConvexSet):
    """A set and the box of these half extents about every point of it (their Minkowski sum): supports add up."""

    def __init__(self, inner: ConvexSet, half: Vector) -> None:
        self.inner, self.half, self.name = inner, half, inner.name

    @property
    def dimension(self) -> int:
        return self.inner.dimension

    @property
    def normals(self) -> tuple[Normal, ...]:
        return self.inner.normals  # to be apart from a box is already asked of these; elsewhere a missing one costs room

    def support(self, normal: Normal) -> Fraction:
        return self.inner.support(normal) + sum((abs(c) * h for c, h in zip(normal, self.half, strict=True)), ZERO)

    @cached_property
    def vertices(self) -> tuple[Vector, ...]:
        corners = tuple(product(*((-h, h) for h in self.half)))
        return tuple(tuple(v + c for v, c in zip(p, corner, strict=True)) for p in self.inner.vertices for corner in corners)

    @cached_property
    def bends(self) -> tuple[Bend, ...]:
        half = self.half
        return tuple((tuple(v + s * h for v, s, h in zip(p, signs, half, strict=True)), signs) for p, signs in self.inner.bends)

    @property
    def line(self) -> tuple[Vector, Vector]:
        return self.inner.line

    @property
    def radius(self) -> Fraction:
        return self.inner.radius

    def shadow(self, i: int, j: int) -> Shadow:
        a, b = float(self.half[i]), float(self.half[j])
        return [(x + s * a, y + t * b) for x, y in self.inner.shadow(i, j) for s in (-1, 1) for t in (-1, 1)]

    def spread(self, by: Fraction) -> ConvexSet:
        return Grown(self.inner.spread(by), self.half)

    def apart(self, lower: Vector, upper: Vector) -> bool:
        half = self.half  # the box may be grown in the set's stead
        wider = tuple(a - h for a, h in zip(lower, half, strict=True)), tuple(b + h for b, h in zip(upper, half, strict=True))
        return self.inner.apart(*wider)

    def covers(self, lower: Vector, upper: Vector) -> bool:
        if self.dimension > MOST_CORNERS:
            return False  # not known; whoever asks only refuses what is covered
        corners = product(*zip(lower, upper, strict=True))
        return super().covers(lower, upper) and not any(self.apart(c, c) for c in corners)

    @property
    def bounded_axes(self) -> tuple[int, ...]:
        return self.inner.bounded_axes
