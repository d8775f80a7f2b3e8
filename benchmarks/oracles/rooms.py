"""An independent test of tubes in rooms with outline and holes, from the corners that the task lists, in exact fractions.

A box is in a room if no side of the room enters the box and the middle of the box is inside. The middle is inside if the number
of sides to its right is odd. To find the area that two polygons share, one is cut by the sides of the other (Sutherland and
Hodgman, 1974). The polygon that is cut may be concave, because only its signed area is used.

Nothing is shared with `stt_codegen.task.map.rooms` or `polygons`. `benchmarks/rooms.py` and tests call this file.
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
BoxEdges = tuple[Sequence[Fraction], Sequence[Fraction]]  # lower and upper, by axis


@dataclass(frozen=True)
class ListedRoom:
    """The corners of a room in the plane, as a task lists them."""

    outline: Polygon
    holes: list[Polygon]

    @property
    def polygons(self) -> list[Polygon]:
        return [self.outline, *self.holes]

    @property
    def bounding_box(self) -> BoxEdges:
        xs, ys = zip(*self.outline, strict=True)
        return (min(xs), min(ys)), (max(xs), max(ys))


def room_from_numbers(outline: Sequence[Any], holes: Sequence[Any] = ()) -> ListedRoom:
    """Return the room with these corners; a double stands for its shortest decimal."""
    first, *rest = ([(Fraction(str(x)), Fraction(str(y))) for x, y in polygon] for polygon in (outline, *holes))
    return ListedRoom(first, rest)


def sides(polygon: Polygon) -> Iterator[tuple[Corner, Corner]]:
    """Yield each corner with the next one, around the polygon."""
    yield from zip(polygon, polygon[1:] + polygon[:1], strict=True)


def contains_point(listed_room: ListedRoom, point: Sequence[Fraction]) -> bool:
    """Whether a point is in the outline and in no hole: the number of sides to its right is odd."""
    sides_to_the_right = 0
    for polygon in listed_room.polygons:
        for (ax, ay), (bx, by) in sides(polygon):
            if (ay <= point[1]) != (by <= point[1]):
                sides_to_the_right += ax + (point[1] - ay) / (by - ay) * (bx - ax) > point[0]
    return sides_to_the_right % 2 == 1


def enters_box(a: Corner, b: Corner, box: BoxEdges) -> bool:
    """Whether the side from a to b has a point strictly inside of a box (Liang and Barsky, 1984)."""
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


def contains_box(listed_room: ListedRoom, box: BoxEdges, clearance: Fraction = Fraction(0)) -> bool:
    """Whether the inside of a box is in the room, and, in the largest component, stays clear of all sides that are not on the
    bounding box."""
    bounding_box, grown = listed_room.bounding_box, ([v - clearance for v in box[0]], [v + clearance for v in box[1]])
    for polygon in listed_room.polygons:
        for a, b in sides(polygon):
            is_on_bounding_box = any(a[i] == b[i] == end[i] for end in bounding_box for i in (0, 1))
            if enters_box(a, b, box if is_on_bounding_box else grown):
                return False
    return contains_point(listed_room, [(low + high) / 2 for low, high in zip(*box, strict=True)])


def tube_boxes(design: RefinedDesign, times_per_segment: int) -> Iterator[tuple[Fraction, BoxEdges]]:
    """Yield the exact tube at `times_per_segment` times of every segment and at t_c, as seconds and edges."""
    for k in range(design.segments * times_per_segment + 1):
        segment = min(k // times_per_segment, design.segments - 1)
        s = Fraction(k, times_per_segment) - segment
        weights = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
        points = design.table[segment : segment + 4]
        lower, upper = (
            [sum(w * p[i][side] for w, p in zip(weights, points, strict=True)) * design.unit for i in range(design.dimension)]
            for side in (0, 1)
        )
        yield design.prescribed_time * k / (design.segments * times_per_segment), (lower, upper)


def times_outside(
    listed_room: ListedRoom,
    design: RefinedDesign,
    axes: Sequence[int],
    body: Sequence[Fraction],
    *,
    clearance: Fraction,
    times_per_segment: int = 8,
) -> list[Fraction]:
    """Return the times at which the tube on two axes, grown by the body, is not in the room, or is nearer to a
    wall than `clearance`. It is compared at `times_per_segment` times of every segment."""
    times = []
    for time, (lower, upper) in tube_boxes(design, times_per_segment):
        box = [lower[i] - body[i] for i in axes], [upper[i] + body[i] for i in axes]
        if not contains_box(listed_room, box, clearance):
            times.append(time)
    return times


def signed_area(polygon: Polygon) -> Fraction:
    """Return the area, negative where the corners go around clockwise."""
    return sum((a[0] * b[1] - a[1] * b[0] for a, b in sides(polygon)), Fraction(0)) / 2


def shared_area(polygon: Polygon, convex: Polygon) -> Fraction:
    """Return the area that a polygon shares with a convex one."""
    if signed_area(convex) < 0:
        convex = convex[::-1]
    rest = polygon if signed_area(polygon) > 0 else polygon[::-1]
    for (ax, ay), (bx, by) in sides(convex):
        inside: Polygon = []
        for p, q in sides(rest) if rest else ():
            first, second = ((bx - ax) * (v[1] - ay) - (by - ay) * (v[0] - ax) for v in (p, q))
            if first >= 0:
                inside.append(p)
            if first * second < 0:
                part = first / (first - second)
                inside.append((p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])))
        rest = inside
    return signed_area(rest) if rest else Fraction(0)


def partition_fault(listed_room: ListedRoom, pieces: Sequence[Polygon]) -> str | None:
    """Return why polygons are no partition, into convex pieces, of the bounding box without the room; None if they are one."""
    for k, piece in enumerate(pieces):
        turns = [signed_area([*corners]) for corners in zip(piece, piece[1:] + piece[:1], piece[2:] + piece[:2], strict=True)]
        if not (all(t > 0 for t in turns) or all(t < 0 for t in turns)):
            return f"piece {k} is not strictly convex"
        in_holes = sum((shared_area(hole, piece) for hole in listed_room.holes), Fraction(0))
        in_room = shared_area(listed_room.outline, piece) - in_holes
        if in_room:
            return f"piece {k} takes {in_room} of the room"
        if any(not low <= v <= high for p in piece for v, low, high in zip(p, *listed_room.bounding_box, strict=True)):
            return f"piece {k} is not in the box around the outline"
    overlap = next(((a, b) for (a, p), (b, q) in combinations(enumerate(pieces), 2) if shared_area(p, q)), None)
    if overlap is not None:
        return f"pieces {overlap} overlap"
    (left, bottom), (right, top) = listed_room.bounding_box
    free = abs(signed_area(listed_room.outline)) - sum((abs(signed_area(hole)) for hole in listed_room.holes), Fraction(0))
    missing = (right - left) * (top - bottom) - free - sum((abs(signed_area(p)) for p in pieces), Fraction(0))
    return f"an area of {missing} is in no piece" if missing else None


def corners_of(unsafe: Any) -> Polygon:
    """Return the corners of an unsafe set of a task, a box or a polytope in the plane."""
    if hasattr(unsafe, "vertices"):
        return [tuple(p) for p in unsafe.vertices]
    (a, c), (b, d) = unsafe.lower, unsafe.upper
    return [(a, c), (b, c), (b, d), (a, d)]
