"""Diamonds: all points whose distances from a middle, one for each dimension, sum up to no more than a reach."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

from stt_codegen.task.sets.convex_sets import ConvexSet, Normal, Vector, axis_normals


class Diamond(ConvexSet):
    """|x_1 - m_1| + |x_2 - m_2| + .. <= reach."""

    def __init__(self, middle: Vector, reach: Fraction, name: str = "") -> None:
        self.middle, self.reach, self.name = middle, reach, name

    @property
    def dimension(self) -> int:
        return len(self.middle)

    @property
    def normals(self) -> tuple[Normal, ...]:
        return tuple(dict.fromkeys([*axis_normals(self.dimension), *product((1, -1), repeat=self.dimension)]))

    def support(self, normal: Normal) -> Fraction:
        return sum((c * v for c, v in zip(normal, self.middle, strict=True)), Fraction(0)) + self.reach * max(map(abs, normal))

    @property
    def vertices(self) -> tuple[Vector, ...]:
        return corners(self.middle, self.reach)


def corners(middle: Vector, reach: Fraction) -> tuple[Vector, ...]:
    """The two ends in each dimension."""
    ends = [(i, sign * reach) for i in range(len(middle)) for sign in (-1, 1)]
    return tuple(tuple(v + by * (k == i) for k, v in enumerate(middle)) for i, by in ends)
