"""Simple polygons with integer corners in the plane: test whether they are simple, and split them into convex pieces, all exact.

A polygon is the list of its corners in order, without repetition. The pieces have only corners of the polygon. Where all of its
sides are along the axes, a piece may combine the coordinates of two corners. So no new number arises. floor_plans.py calls it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from stt_codegen.task.map.convex_pieces import cover_cells
from stt_codegen.task.values import MAX_POINTS

Point = tuple[int, int]
Side = tuple[Point, Point]


def turn(a: Point, b: Point, c: Point) -> int:
    """Return a number above 0 where a, b, c turn to the left, 0 where they are on one line."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def sides_of(polygon: Sequence[Point]) -> list[Side]:
    """Return the sides of a polygon; side k begins at corner k."""
    return list(zip(polygon, [*polygon[1:], polygon[0]], strict=True))


def twice_area(polygon: Sequence[Point]) -> int:
    """Return twice the signed area, above 0 where the corners are counterclockwise."""
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in sides_of(polygon))


def meet(first: Side, second: Side) -> bool:
    """Whether two sides share a point, their ends included."""
    (a, b), (c, d) = first, second
    for i in (0, 1):
        if max(a[i], b[i]) < min(c[i], d[i]) or max(c[i], d[i]) < min(a[i], b[i]):
            return False
    across = [(v > 0) - (v < 0) for v in (turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b))]
    return across[0] * across[1] <= 0 and across[2] * across[3] <= 0


def meeting_sides(first: Sequence[Side], second: Sequence[Side]) -> tuple[int, int] | None:
    """Return the first pair of sides, one of each polygon, that share a point, by index; None where there is none."""
    return next(((i, j) for i, a in enumerate(first) for j, b in enumerate(second) if meet(a, b)), None)


def touching_sides(polygon: Sequence[Point]) -> tuple[int, int] | None:
    """Return two sides that share a point and are no neighbours, by index; None for a simple polygon.

    In a polygon of four or more corners, a side that folds back onto its neighbour also meets another side."""
    sides = sides_of(polygon)
    count = len(sides)
    pairs = ((i, j) for i in range(count) for j in range(i + 2, count) if (i, j) != (0, count - 1))
    return next(((i, j) for i, j in pairs if meet(sides[i], sides[j])), None)


def contains(polygon: Sequence[Point], point: Point) -> bool:
    """Whether a point that is on no side is inside, by the parity of the sides above it."""
    inside = False
    for a, b in sides_of(polygon):
        if (a[0] > point[0]) != (b[0] > point[0]):
            left, right = (a, b) if a[0] < b[0] else (b, a)
            inside ^= turn(left, right, point) < 0
    return inside


def with_neighbours(polygon: Sequence[Point]) -> Iterator[tuple[Point, Point, Point]]:
    """Yield every corner with the corner before and the corner after it."""
    yield from zip([polygon[-1], *polygon[:-1]], polygon, [*polygon[1:], polygon[0]], strict=True)


def without_straight_corners(polygon: Sequence[Point]) -> list[Point]:
    """Return the corners at which the polygon turns."""
    return [b for a, b, c in with_neighbours(polygon) if turn(a, b, c)]


def convex_pieces(polygon: Sequence[Point]) -> list[list[Point]]:
    """Return convex polygons, counterclockwise, that together are a simple polygon and share at most sides."""
    corners = without_straight_corners(polygon)
    if twice_area(corners) < 0:
        corners.reverse()
    if is_convex(corners) and len(corners) <= MAX_POINTS:
        return [corners]
    if all(a[0] == b[0] or a[1] == b[1] for a, b in sides_of(corners)):
        return _boxes(corners)
    rules: tuple[Callable[[Point, Point], int], ...] = (_length, lambda a, b: -_length(a, b), lambda *_: 0)
    partitions = [_merged(_triangles(corners, rule)) for rule in rules]
    return [without_straight_corners(piece) for piece in min(partitions, key=len)]


def is_convex(polygon: Sequence[Point]) -> bool:
    """Whether a counterclockwise polygon, which goes around once, never turns to the right."""
    return all(turn(a, b, c) >= 0 for a, b, c in with_neighbours(polygon))


def _boxes(corners: Sequence[Point]) -> list[list[Point]]:
    """Return few boxes that are a polygon whose sides are along the axes, from the cells between neighbouring coordinates."""
    xs, ys = (sorted({p[i] for p in corners}) for i in (0, 1))
    doubled = [(2 * x, 2 * y) for x, y in corners]  # so that the middle of a cell has integer coordinates
    cells = np.array([[contains(doubled, (a + b, c + d)) for c, d in pairwise(ys)] for a, b in pairwise(xs)])
    return [[(xs[i], ys[j]) for i, j in piece.corners] for piece in cover_cells(cells)]


def _length(a: Point, b: Point) -> int:
    """Return the squared distance of two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2


def _triangles(corners: Sequence[Point], rule: Callable[[Point, Point], int]) -> list[list[Point]]:
    """Return triangles that are the polygon, by cutting ears; the ear whose cut has the smallest `rule` is cut first.

    An ear stays an ear when others are cut, and a corner that blocks an ear does so until it is cut itself, so both are stored.
    """
    remaining, triangles = list(corners), []
    blockers: dict[tuple[Point, Point, Point], Point | None] = {}
    while len(remaining) > 3:
        ears, uncut = [], set(remaining)
        inward = [b for a, b, c in with_neighbours(remaining) if turn(a, b, c) <= 0]
        for ear in with_neighbours(remaining):
            if ear not in blockers or (blockers[ear] is not None and blockers[ear] not in uncut):
                blockers[ear] = _blocker(ear, inward)
            if blockers[ear] is None:
                ears.append(ear)
        cut = min(ears, key=lambda ear: rule(ear[0], ear[2]))
        triangles.append(list(cut))
        remaining.remove(cut[1])
    return [*triangles, remaining]


def _blocker(ear: tuple[Point, Point, Point], inward: Sequence[Point]) -> Point | None:
    """Return the point because of which the triangle at a corner is no ear, or None.

    It is the corner itself where it does not turn to the left, or a corner inside the triangle or on its sides. inward: the
    corners that do not turn to the left; if any corner is inside, one of these is.
    """
    a, b, c = ear
    if turn(a, b, c) <= 0:
        return b
    inside = (p for p in inward if turn(a, b, p) >= 0 and turn(b, c, p) >= 0 and turn(c, a, p) >= 0 and p not in ear)
    return next(inside, None)


def _merged(triangles: Sequence[list[Point]]) -> list[list[Point]]:
    """Return triangles joined across common sides, long ones first, while the union is convex (Hertel and Mehlhorn, 1983)."""
    pieces = dict(enumerate(triangles))
    owner = {side: k for k, piece in pieces.items() for side in sides_of(piece)}
    cuts = sorted((side for side in owner if side[::-1] in owner and side < side[::-1]), key=lambda s: (-_length(*s), s))
    for a, b in cuts:
        left, right = owner[a, b], owner[b, a]
        union = _joined(pieces[left], pieces[right], (a, b))
        if len(union) <= MAX_POINTS and is_convex(union):
            pieces[left] = union
            for side in sides_of(pieces.pop(right)):
                owner[side] = left
    return list(pieces.values())


def _joined(left: Sequence[Point], right: Sequence[Point], side: Side) -> list[Point]:
    """Return the union of two polygons with a common side: `side` in the left polygon, its reverse in the right one."""
    i, j = left.index(side[1]), right.index(side[0])
    return [*left[i:], *left[:i], *right[j + 1 :], *right[:j]][: len(left) + len(right) - 2]
