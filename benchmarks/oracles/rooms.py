"""The truth about rooms with an outline and holes, from the listed corners alone, in exact fractions.

Nothing is shared with `stt_codegen.task.map.rooms` or `polygons`: a box is in a room where no side of the room meets the inside
of the box and the middle of the box is inside by counting the sides to the right of it. Areas that sets have in common are those
of polygons cut by half planes (Sutherland and Hodgman, 1974): what is cut may be concave, only its signed area is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

from stt_codegen.designs.refined import RefinedDesign

Corner = tuple[Fraction, Fraction]
Polygon = list[Corner]
Span = tuple[Sequence[Fraction], Sequence[Fraction]]  # lower and upper edges of a box


@dataclass(frozen=True)
class ListedRoom:
    """Corners as a task lists them, in the plane."""

    outline: Polygon
    holes: list[Polygon]

    @property
    def polygons(self) -> list[Polygon]:
        return [self.outline, *self.holes]

    @property
    def frame(self) -> Span:
        """The box around the outline."""
        xs, ys = zip(*self.outline, strict=True)
        return (min(xs), min(ys)), (max(xs), max(ys))


def listed(outline: Sequence[Any], holes: Sequence[Any] = ()) -> ListedRoom:
    """From numbers whose shortest decimal counts."""
    first, *rest = ([(Fraction(str(x)), Fraction(str(y))) for x, y in polygon] for polygon in (outline, *holes))
    return ListedRoom(first, rest)


def sides(polygon: Polygon) -> Iterator[tuple[Corner, Corner]]:
    yield from zip(polygon, polygon[1:] + polygon[:1], strict=True)


def is_inside(room: ListedRoom, point: Sequence[Fraction]) -> bool:
    """Whether a point is in the outline and in no hole: the number of sides to its right is odd."""
    right = 0
    for polygon in room.polygons:
        for (ax, ay), (bx, by) in sides(polygon):
            if (ay <= point[1]) != (by <= point[1]):
                right += ax + (point[1] - ay) / (by - ay) * (bx - ax) > point[0]
    return right % 2 == 1


def meets_inside(a: Corner, b: Corner, box: Span) -> bool:
    """Whether a side has a point strictly inside of a box (Liang and Barsky, 1984)."""
    if any(max(p, q) <= low or high <= min(p, q) for p, q, low, high in zip(a, b, *box, strict=True)):
        return False
    first, last = Fraction(0), Fraction(1)
    for p, q, low, high in zip(a, b, *box, strict=True):
        if p == q:
            if not low < p < high:
                return False
            continue
        ends = sorted(((low - p) / (q - p), (high - p) / (q - p)))
        first, last = max(first, ends[0]), min(last, ends[1])
    return first < last


def box_is_inside(room: ListedRoom, box: Span, keep: Fraction = Fraction(0)) -> bool:
    """Whether the inside of a box is in the room. keep: so far from all sides that are not on the frame,
    in the largest component."""
    frame, wider = room.frame, ([v - keep for v in box[0]], [v + keep for v in box[1]])
    for polygon in room.polygons:
        for a, b in sides(polygon):
            on_frame = any(a[i] == b[i] == end[i] for end in frame for i in (0, 1))
            if meets_inside(a, b, box if on_frame else wider):
                return False
    return is_inside(room, [(low + high) / 2 for low, high in zip(*box, strict=True)])


def tube_boxes(design: RefinedDesign, parts: int) -> Iterator[tuple[Fraction, Span]]:
    """The exact tube at so many times of every segment and at t_c: seconds, and its edges."""
    for k in range(design.segments * parts + 1):
        segment = min(k // parts, design.segments - 1)
        s = Fraction(k, parts) - segment
        weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
        points = design.table[segment : segment + 4]
        lower, upper = (
            [sum(w * p[i][side] for w, p in zip(weights, points, strict=True)) * design.unit for i in range(design.dimension)]
            for side in (0, 1)
        )
        yield design.prescribed_time * k / (design.segments * parts), (lower, upper)


def times_outside(
    room: ListedRoom, design: RefinedDesign, axes: Sequence[int], body: Sequence[Fraction], keep: Fraction, parts: int = 8
) -> list[Fraction]:
    """The times at which the tube in these dimensions, grown by the body, is not in the room, or too near to a wall."""
    times = []
    for at, (lower, upper) in tube_boxes(design, parts):
        box = [lower[i] - body[i] for i in axes], [upper[i] + body[i] for i in axes]
        if not box_is_inside(room, box, keep):
            times.append(at)
    return times


def area(polygon: Polygon) -> Fraction:
    """Above 0 where the corners go around to the left."""
    return sum((a[0] * b[1] - a[1] * b[0] for a, b in sides(polygon)), Fraction(0)) / 2


def common_area(polygon: Polygon, convex: Polygon) -> Fraction:
    """Of a polygon and a convex one."""
    if area(convex) < 0:
        convex = convex[::-1]
    rest = polygon if area(polygon) > 0 else polygon[::-1]
    for (ax, ay), (bx, by) in sides(convex):
        kept: Polygon = []
        for p, q in sides(rest) if rest else ():
            first, second = ((bx - ax) * (v[1] - ay) - (by - ay) * (v[0] - ax) for v in (p, q))
            if first >= 0:
                kept.append(p)
            if first * second < 0:
                part = first / (first - second)
                kept.append((p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])))
        rest = kept
    return area(rest) if rest else Fraction(0)


def partition_fault(room: ListedRoom, pieces: Sequence[Polygon]) -> str | None:
    """What is wrong with polygons that should be convex and fill what the room leaves of its frame; None where nothing is."""
    for k, piece in enumerate(pieces):
        turns = [area([*corners]) for corners in zip(piece, piece[1:] + piece[:1], piece[2:] + piece[:2], strict=True)]
        if not (all(t > 0 for t in turns) or all(t < 0 for t in turns)):
            return f"piece {k} is not strictly convex"
        taken = common_area(room.outline, piece) - sum((common_area(hole, piece) for hole in room.holes), Fraction(0))
        if taken:
            return f"piece {k} takes {taken} of the room"
        if any(not low <= v <= high for p in piece for v, low, high in zip(p, *room.frame, strict=True)):
            return f"piece {k} is not in the frame"
    shared = next(((a, b) for (a, p), (b, q) in combinations(enumerate(pieces), 2) if common_area(p, q)), None)
    if shared is not None:
        return f"pieces {shared} overlap"
    (left, bottom), (right, top) = room.frame
    free = abs(area(room.outline)) - sum((abs(area(hole)) for hole in room.holes), Fraction(0))
    missing = (right - left) * (top - bottom) - free - sum((abs(area(p)) for p in pieces), Fraction(0))
    return f"an area of {missing} is in no piece" if missing else None


def piece_of(table: Any) -> Polygon:
    """The corners of an unsafe set of a task, a box or a polytope in the plane."""
    if hasattr(table, "vertices"):
        return [tuple(p) for p in table.vertices]
    (a, c), (b, d) = table.lower, table.upper
    return [(a, c), (b, c), (b, d), (a, d)]
