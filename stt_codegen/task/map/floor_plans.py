"""Concave rooms: a box and convex unsafe sets replace state_space.outline and state_space.holes.

    [state_space]
    outline = [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]      # an L
    holes = [[[0.5, 0.5], [1, 0.5], [1, 1]]]                        # a pillar in it

The box is the one around the outline. The closed sets fill what the room leaves of it, without gaps: room and sets together are
the box, and share only the room's boundary. All of this is exact. Design, proof and check are about the box and the sets. `Task`
calls `expand_outline`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput
from stt_codegen.task.map.polygons import (
    Point,
    contains,
    convex_pieces,
    meeting_sides,
    sides_of,
    touching_sides,
    turn,
    twice_area,
)
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import StateSpace, Vector

PLANE = 2
MAX_CORNERS = 400  # of an outline and its holes; sides are compared pair by pair
IN_ORDER = "list every corner once, in order around it, so that no two sides touch"


@dataclass(frozen=True)
class FloorPlan:
    """The outline of a task's room.

    outline, holes: corners in order; axes: the two dimensions, by index; walls: the names of the sets outside of the room."""

    outline: tuple[Vector, ...]
    holes: tuple[tuple[Vector, ...], ...]
    axes: tuple[int, int]
    walls: tuple[str, ...]


def expand_outline(task: TaskTables) -> tuple[dict[str, Any], FloorPlan]:
    """Return the fields of a task with a box and walls in place of its outline, and the floor plan. Raises `BadInput`."""
    space, n = task.state_space, len(task.initial_state)
    axes = _axes(task, space, n)
    outline = _corners("outline", space.outline or ())
    holes = [_corners(f"holes[{k}]", hole) for k, hole in enumerate(space.holes or ())]
    count = sum(map(len, [outline, *holes]))
    if count > MAX_CORNERS:
        raise BadInput(f"state_space.outline: has {count} corners with its holes; at most {MAX_CORNERS} are taken")
    scale = lcm(*(v.denominator for polygon in (outline, *holes) for _, p in polygon for v in p))
    scaled = [_simple(_scaled(polygon, scale), polygon) for polygon in (outline, *holes)]
    _require_apart(scaled, [outline, *holes])
    box = _box_corners(scaled[0])
    pieces = [[tuple(Fraction(v, scale) for v in p) for p in piece] for piece in partition(scaled[0], scaled[1:])]
    lower, upper = _edges(task, space, axes, [[Fraction(v, scale) for v in corner] for corner in box])
    nearby = [p for p in pieces if _is_near(p, axes, lower, upper, reach=_clearances(task, n))]
    tables = _wall_tables(task, nearby, axes if axes != (0, 1) or n > PLANE else None)
    fields = {name: getattr(task, name) for name in task.model_fields_set}
    fields |= {"state_space": {"lower": lower, "upper": upper}, "unsafe": [*task.unsafe, *tables]}
    floor_plan = FloorPlan(
        tuple(p for _, p in outline), tuple(tuple(p for _, p in hole) for hole in holes), axes, tuple(t["name"] for t in tables)
    )
    return fields, floor_plan


def _clearances(task: TaskTables, n: int) -> tuple[Fraction, ...]:
    """Return the clearance by dimension. Raises `BadInput` for a list of another length: its task was not checked yet."""
    clearance = task.tube.clearance
    if not isinstance(clearance, tuple):
        return (clearance,) * n
    if len(clearance) != n:
        raise BadInput(f"tube.clearance: has {len(clearance)} entries; initial_state has {n}, and all must agree")
    return clearance


def name_walls(problem: str, first: int, floor_plan: FloorPlan) -> str:
    """Return a message with the names of walls, as the file does not have their indices. first: the index of the first wall."""
    for k, name in enumerate(floor_plan.walls, first):
        words = f"{name}, which state_space.outline leaves out of its box"
        problem = problem.replace(f"unsafe[{k}] ({name})", words).replace(f"unsafe[{k}]", words)
    return problem


def partition(outline: Sequence[Point], holes: Sequence[Sequence[Point]]) -> list[list[Point]]:
    """Return convex polygons that fill what an outline and its holes leave of the box around the outline.

    Outline and holes must be simple and disjoint, the holes inside. The areas are summed up as a check of this program itself.
    """
    pieces = [piece for polygon in (*pockets(outline), *holes) for piece in convex_pieces(polygon)]
    (left, bottom), (right, top) = _box_corners(outline)
    covered = sum(map(twice_area, pieces)) + abs(twice_area(outline)) - sum(abs(twice_area(hole)) for hole in holes)
    if covered != 2 * (right - left) * (top - bottom):
        raise AssertionError("the convex pieces do not have the area that the room leaves")
    return pieces


def pockets(outline: Sequence[Point]) -> list[list[Point]]:
    """Return the simple polygons that an outline leaves of the box around it.

    Each is between two consecutive corners on the box: it goes along the box, and back along the outline.
    """
    polygon = list(outline) if twice_area(outline) > 0 else list(outline)[::-1]
    (left, bottom), (right, top) = _box_corners(polygon)
    frame = [(left, bottom), (right, bottom), (right, top), (left, top)]

    def side(p: Point) -> int | None:
        """Return the side of the box that a point is on, the first corner of a side included; None for a point inside."""
        touching = (p[1] == bottom and p[0] < right, p[0] == right and p[1] < top, p[1] == top and p[0] > left, p[0] == left)
        return next((k for k, touches in enumerate(touching) if touches), None)

    first = next(k for k, p in enumerate(polygon) if side(p) is not None)
    polygon = [*polygon[first:], *polygon[: first + 1]]
    polygons, begin = [], 0
    for end in range(1, len(polygon)):
        if side(polygon[end]) is None:
            continue
        a, b = side(polygon[begin]), side(polygon[end])
        assert a is not None
        assert b is not None
        passed = [frame[(a + k) % 4] for k in range(1, (b - a) % 4 + 1)]
        pocket = [polygon[begin], *(p for p in passed if p != polygon[end]), *polygon[begin + 1 : end + 1][::-1]]
        if len(pocket) > 2 and twice_area(pocket):
            polygons.append(pocket)
        begin = end
    return polygons


def _box_corners(polygon: Sequence[Point]) -> tuple[Point, Point]:
    """Return the lower left and the upper right corner of the box around a polygon."""
    xs, ys = zip(*polygon, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))


def _axes(task: TaskTables, space: StateSpace, n: int) -> tuple[int, int]:
    """Return the two dimensions of the outline, by index. Raises `BadInput` where the outline's fields do not fit together."""
    names = task.axes or tuple(f"x{i + 1}" for i in range(n))
    if space.outline is None:
        raise BadInput("state_space.holes: are those of an outline; give outline too, or the holes as [[unsafe]]")
    clash = next((name for name in ("vertices", "normals", "offsets") if getattr(space, name) is not None), None)
    if clash is not None:
        raise BadInput(f"state_space.outline: stands beside {clash}; give the one or the other")
    if space.axes is None and n != PLANE:
        raise BadInput(f"state_space.axes: are missing; an outline is in the plane, name its two of {', '.join(names)}")
    named = names if space.axes is None else space.axes
    if len(named) != PLANE or len(set(named)) < PLANE or not set(named) <= set(names):
        raise BadInput(f"state_space.axes: are {', '.join(named) or 'none'}; two different ones of {', '.join(names)} are needed")
    return names.index(named[0]), names.index(named[1])


def _corners(field: str, points: Sequence[Vector]) -> list[tuple[str, Vector]]:
    """Return the corners, each with its entry in the file, without one that is repeated at once or at the end."""
    for k, p in enumerate(points):
        if len(p) != PLANE:
            raise BadInput(f"state_space.{field}[{k}]: has {len(p)} entries; two are needed, [x, y]")
    corners = [(f"{field}[{k}]", p) for k, p in enumerate(points) if p != points[(k + 1) % len(points)]]
    if len(corners) < PLANE + 1:
        raise BadInput(f"state_space.{field}: has {len(corners)} different corners; at least three are needed")
    return corners


def _scaled(polygon: Sequence[tuple[str, Vector]], scale: int) -> list[Point]:
    return [(int(p[0] * scale), int(p[1] * scale)) for _, p in polygon]


def _simple(polygon: list[Point], entries: Sequence[tuple[str, Vector]]) -> list[Point]:
    """Return the polygon. Raises `BadInput` where it crosses or touches itself, or has no area."""
    field = entries[0][0].rpartition("[")[0]
    if all(turn(polygon[0], polygon[1], p) == 0 for p in polygon):
        raise BadInput(f"state_space.{field}: has no area, all of its corners are on one line; {IN_ORDER}")
    pair = touching_sides(polygon)
    if pair is not None:
        problem = f"the side {_side(entries, pair[0])} meets the side {_side(entries, pair[1])}"
        raise BadInput(f"state_space.{entries[pair[1]][0]}: {problem}; {IN_ORDER}")
    return polygon


def _side(entries: Sequence[tuple[str, Vector]], k: int) -> str:
    return f"from {entries[k][0]} to {entries[(k + 1) % len(entries)][0]}"


def _require_apart(polygons: Sequence[list[Point]], entries: Sequence[Sequence[tuple[str, Vector]]]) -> None:
    """Raise `BadInput` where a hole touches the outline or another hole, or is outside of the outline or inside another hole."""
    at_wall = "a pillar at the wall is part of the outline: list its corners there, or give it as [[unsafe]] vertices"
    for k, hole in enumerate(polygons[1:]):
        for j, pair, name in _meetings(polygons, k + 1):
            problem = f"the side {_side(entries[k + 1], pair[1])} meets the side {_side(entries[j], pair[0])}"
            remedy = at_wall if j == 0 else f"give {name} and this one as one hole, or one of them as [[unsafe]] vertices"
            raise BadInput(f"state_space.{entries[k + 1][pair[1]][0]}: {problem}; {remedy}")
        if not contains(polygons[0], hole[0]):
            raise BadInput(f"state_space.holes[{k}]: lies outside of the outline; leave it out, or move it inside")
        for j, larger in enumerate(polygons[1:]):
            if j != k and contains(larger, hole[0]):
                raise BadInput(f"state_space.holes[{k}]: lies inside holes[{j}], where nothing is free; leave it out")


def _meetings(polygons: Sequence[list[Point]], k: int) -> Iterator[tuple[int, tuple[int, int], str]]:
    """Yield each polygon before polygon k that it meets: its index, the two sides, and its name in messages."""
    for j in range(k):
        pair = meeting_sides(sides_of(polygons[j]), sides_of(polygons[k]))
        if pair is not None:
            yield j, pair, f"holes[{j - 1}]" if j else "the outline"


def _edges(
    task: TaskTables, space: StateSpace, axes: tuple[int, int], box: Sequence[Sequence[Fraction]]
) -> tuple[list[Fraction], list[Fraction]]:
    """Return the lower and upper edges of the state space: the box around the outline, cut by `lower` and `upper` of the task."""
    n = len(task.initial_state)
    names = task.axes or tuple(f"x{i + 1}" for i in range(n))
    without_edges = [i for i in range(n) if i not in axes]  # dimensions that the outline does not have
    dimensions_by_length = {n: list(range(n)), n - PLANE: without_edges}  # lower and upper may be of all, or of these only
    edges = [{i: end[k] for k, i in enumerate(axes)} for end in box]
    for field in ("lower", "upper"):
        edge = getattr(space, field)
        if len(edge) not in dimensions_by_length or (not edge and without_edges):
            problem = f"has {len(edge)} entries" if edge else "is missing"
            few = ", ".join(names[i] for i in without_edges)
            raise BadInput(
                f"state_space.{field}: {problem}; give one for {few or 'each dimension'}"
                + (f", or for all of {', '.join(names)}" if few else ", or leave it out")
            )
    if len(space.lower) != len(space.upper):
        raise BadInput(f"state_space.upper: has {len(space.upper)} entries, lower has {len(space.lower)}; both must agree")
    for k, i in enumerate(dimensions_by_length[len(space.lower)]):
        low, high = space.lower[k], space.upper[k]
        if low >= high:
            raise BadInput(f"state_space: lower[{k}] = {decimal(low)} is not below upper[{k}] = {decimal(high)}")
        if i in axes:
            low, high = max(low, edges[0][i]), min(high, edges[1][i])
        if low >= high:
            problem = f"lower and upper leave nothing of it on axis {names[i]}"
            raise BadInput(f"state_space.outline: {problem}; move one of them, or leave lower and upper out there")
        edges[0][i], edges[1][i] = low, high
    return tuple([edge[i] for i in range(n)] for edge in edges)  # type: ignore[return-value]


def _is_near(
    piece: Sequence[Vector], axes: tuple[int, int], lower: Sequence[Fraction], upper: Sequence[Fraction], *, reach: Vector
) -> bool:
    """Whether the box around a piece is within `reach` of the state space, by dimension, touching included."""
    spans = [(min(p[k] for p in piece), max(p[k] for p in piece)) for k in (0, 1)]
    return all(a <= upper[i] + reach[i] and lower[i] - reach[i] <= b for (a, b), i in zip(spans, axes, strict=True))


def _wall_tables(
    task: TaskTables, pieces: Sequence[Sequence[tuple[Fraction, ...]]], axes: tuple[int, int] | None
) -> list[dict[str, Any]]:
    """Return the pieces as tables [[unsafe]], named wall1, wall2, .. without names that the task already has."""
    stated_names = {table.name for table in (*task.unsafe, *task.region)}
    numbered = (f"wall{k}" for k in range(1, len(pieces) + len(stated_names) + 1))
    names = (name for name in numbered if name not in stated_names)
    tables = []
    for piece in pieces:
        table: dict[str, Any] = {"name": next(names)}
        if axes is not None:
            labels = task.axes or tuple(f"x{i + 1}" for i in range(len(task.initial_state)))
            table["axes"] = [labels[i] for i in axes]
        lower, upper = ([extreme(p[k] for p in piece) for k in (0, 1)] for extreme in (min, max))
        if len(piece) == 4 and all(v in (a, b) for p in piece for v, a, b in zip(p, lower, upper, strict=True)):
            tables.append(table | {"lower": lower, "upper": upper})
        else:
            tables.append(table | {"vertices": [list(p) for p in piece]})
    return tables
