"""A concave room: state_space.outline and state_space.holes as the box around the outline, and convex unsafe sets that fill what
the room leaves of that box.

    [state_space]
    outline = [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]      # an L
    holes = [[[0.5, 0.5], [1, 0.5], [1, 1]]]                        # a pillar in it

The sets are closed and have no gap between them: room and sets together are the box, and share only the room's boundary. All of
this is exact. What is designed, proved and checked afterwards is about the box and the sets.
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
MAX_CORNERS = 400  # of an outline and its holes; whether sides meet is looked at pair by pair
IN_ORDER = "list every corner once, in order around it, so that no two sides touch"


@dataclass(frozen=True)
class FloorPlan:
    """What a task says of its room. outline, holes: corners in order; axes: the two dimensions, by number; walls: the names of
    the sets that fill what the room leaves of its box."""

    outline: tuple[Vector, ...]
    holes: tuple[tuple[Vector, ...], ...]
    axes: tuple[int, int]
    walls: tuple[str, ...]


def expand_outline(task: TaskTables) -> tuple[dict[str, Any], FloorPlan]:
    """The fields of a task with an outline as those of one without, and the room. Raises `BadInput`."""
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
    around = _ends(scaled[0])
    pieces = [[tuple(Fraction(v, scale) for v in p) for p in piece] for piece in partition(scaled[0], scaled[1:])]
    lower, upper = _edges(task, space, axes, [[Fraction(v, scale) for v in end] for end in around])
    near = [p for p in pieces if _reaches(p, axes, lower, upper, task.tube.clearance)]
    tables = _tables(task, near, axes if axes != (0, 1) or n > PLANE else None)
    fields = {name: getattr(task, name) for name in task.model_fields_set}
    fields |= {"state_space": {"lower": lower, "upper": upper}, "unsafe": [*task.unsafe, *tables]}
    room = FloorPlan(
        tuple(p for _, p in outline), tuple(tuple(p for _, p in hole) for hole in holes), axes, tuple(t["name"] for t in tables)
    )
    return fields, room


def name_walls(problem: str, first: int, room: FloorPlan) -> str:
    """A message about the walls by their names, which no file has by number. first: the number of the first wall."""
    for k, name in enumerate(room.walls, first):
        words = f"{name}, which state_space.outline leaves out of its box"
        problem = problem.replace(f"unsafe[{k}] ({name})", words).replace(f"unsafe[{k}]", words)
    return problem


def partition(outline: Sequence[Point], holes: Sequence[Sequence[Point]]) -> list[list[Point]]:
    """Convex polygons that fill what an outline and its holes leave of the box around the outline. All simple and apart from one
    another, the holes inside. The areas are counted up: what is missing or taken twice is an error of this program."""
    pieces = [piece for polygon in (*pockets(outline), *holes) for piece in convex_pieces(polygon)]
    (left, bottom), (right, top) = _ends(outline)
    taken = sum(map(twice_area, pieces)) + abs(twice_area(outline)) - sum(abs(twice_area(hole)) for hole in holes)
    if taken != 2 * (right - left) * (top - bottom):
        raise AssertionError("the convex pieces do not have the area that the room leaves")
    return pieces


def pockets(outline: Sequence[Point]) -> list[list[Point]]:
    """The simple polygons that an outline leaves of the box around it: between two neighbouring corners on the box, the way along
    the box and the way back along the outline."""
    polygon = list(outline) if twice_area(outline) > 0 else list(outline)[::-1]
    (left, bottom), (right, top) = _ends(polygon)
    frame = [(left, bottom), (right, bottom), (right, top), (left, top)]

    def side(p: Point) -> int | None:
        """On which side of the box a point is, its first corner included."""
        on = (p[1] == bottom and p[0] < right, p[0] == right and p[1] < top, p[1] == top and p[0] > left, p[0] == left)
        return next((k for k, touches in enumerate(on) if touches), None)

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
        along = [polygon[begin], *(p for p in passed if p != polygon[end]), *polygon[begin + 1 : end + 1][::-1]]
        if len(along) > 2 and twice_area(along):
            polygons.append(along)
        begin = end
    return polygons


def _ends(polygon: Sequence[Point]) -> tuple[Point, Point]:
    """The lower left and the upper right corner of the box around it."""
    xs, ys = zip(*polygon, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))


def _axes(task: TaskTables, space: StateSpace, n: int) -> tuple[int, int]:
    """The two dimensions of the outline, by number."""
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
    """The corners with the entry that each is from, without a corner that is listed again right after itself or at the end."""
    for k, p in enumerate(points):
        if len(p) != PLANE:
            raise BadInput(f"state_space.{field}[{k}]: has {len(p)} entries; two are needed, [x, y]")
    kept = [(f"{field}[{k}]", p) for k, p in enumerate(points) if p != points[(k + 1) % len(points)]]
    if len(kept) < PLANE + 1:
        raise BadInput(f"state_space.{field}: has {len(kept)} different corners; at least three are needed")
    return kept


def _scaled(polygon: Sequence[tuple[str, Vector]], scale: int) -> list[Point]:
    return [(int(p[0] * scale), int(p[1] * scale)) for _, p in polygon]


def _simple(polygon: list[Point], entries: Sequence[tuple[str, Vector]]) -> list[Point]:
    """The polygon. Raises `BadInput` where it crosses or touches itself, or has no area."""
    where = entries[0][0].rpartition("[")[0]
    if all(turn(polygon[0], polygon[1], p) == 0 for p in polygon):
        raise BadInput(f"state_space.{where}: has no area, all of its corners are on one line; {IN_ORDER}")
    met = touching_sides(polygon)
    if met is not None:
        problem = f"the side {_side(entries, met[0])} meets the side {_side(entries, met[1])}"
        raise BadInput(f"state_space.{entries[met[1]][0]}: {problem}; {IN_ORDER}")
    return polygon


def _side(entries: Sequence[tuple[str, Vector]], k: int) -> str:
    return f"from {entries[k][0]} to {entries[(k + 1) % len(entries)][0]}"


def _require_apart(polygons: Sequence[list[Point]], entries: Sequence[Sequence[tuple[str, Vector]]]) -> None:
    """Raises `BadInput` where a hole touches the outline or another hole, is outside of the one or in the other."""
    wall = "a pillar at the wall is part of the outline: list its corners there, or give it as [[unsafe]] vertices"
    for k, hole in enumerate(polygons[1:]):
        for j, met, name in _meetings(polygons, k + 1):
            problem = f"the side {_side(entries[k + 1], met[1])} meets the side {_side(entries[j], met[0])}"
            right = wall if j == 0 else f"give {name} and this one as one hole, or one of them as [[unsafe]] vertices"
            raise BadInput(f"state_space.{entries[k + 1][met[1]][0]}: {problem}; {right}")
        if not contains(polygons[0], hole[0]):
            raise BadInput(f"state_space.holes[{k}]: lies outside of the outline; leave it out, or move it inside")
        for j, larger in enumerate(polygons[1:]):
            if j != k and contains(larger, hole[0]):
                raise BadInput(f"state_space.holes[{k}]: lies inside holes[{j}], where nothing is free; leave it out")


def _meetings(polygons: Sequence[list[Point]], k: int) -> Iterator[tuple[int, tuple[int, int], str]]:
    """Sides of polygon k that meet those of one before it, which has a name."""
    for j in range(k):
        met = meeting_sides(sides_of(polygons[j]), sides_of(polygons[k]))
        if met is not None:
            yield j, met, f"holes[{j - 1}]" if j else "the outline"


def _edges(
    task: TaskTables, space: StateSpace, axes: tuple[int, int], around: Sequence[Sequence[Fraction]]
) -> tuple[list[Fraction], list[Fraction]]:
    """The box of the state space: the one around the outline, which a given box cuts."""
    n = len(task.initial_state)
    names = task.axes or tuple(f"x{i + 1}" for i in range(n))
    rest = [i for i in range(n) if i not in axes]
    known = {n: list(range(n)), n - PLANE: rest}  # of all dimensions, or of those that are not the outline's
    edges = [{i: end[k] for k, i in enumerate(axes)} for end in around]
    for field in ("lower", "upper"):
        edge = getattr(space, field)
        if len(edge) not in known or (not edge and rest):
            problem = f"has {len(edge)} entries" if edge else "is missing"
            few = ", ".join(names[i] for i in rest)
            raise BadInput(
                f"state_space.{field}: {problem}; give one for {few or 'each dimension'}"
                + (f", or for all of {', '.join(names)}" if few else ", or leave it out")
            )
    if len(space.lower) != len(space.upper):
        raise BadInput(f"state_space.upper: has {len(space.upper)} entries, lower has {len(space.lower)}; both must agree")
    for k, i in enumerate(known[len(space.lower)]):
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


def _reaches(
    piece: Sequence[Vector], axes: tuple[int, int], lower: Sequence[Fraction], upper: Sequence[Fraction], keep: Fraction
) -> bool:
    """Whether the box around a piece is within `keep` of the state space, touching included."""
    spans = [(min(p[k] for p in piece), max(p[k] for p in piece)) for k in (0, 1)]
    return all(a <= upper[i] + keep and lower[i] - keep <= b for (a, b), i in zip(spans, axes, strict=True))


def _tables(
    task: TaskTables, pieces: Sequence[Sequence[tuple[Fraction, ...]]], axes: tuple[int, int] | None
) -> list[dict[str, Any]]:
    """The pieces as unsafe sets, called wall1, wall2, .. as far as these names are free."""
    taken = {table.name for table in (*task.unsafe, *task.region)}
    names = (name for name in (f"wall{k}" for k in range(1, len(pieces) + len(taken) + 1)) if name not in taken)
    tables = []
    for piece in pieces:
        table: dict[str, Any] = {"name": next(names)}
        if axes is not None:
            labels = task.axes or tuple(f"x{i + 1}" for i in range(len(task.initial_state)))
            table["axes"] = [labels[i] for i in axes]
        lower, upper = ([pick(p[k] for p in piece) for k in (0, 1)] for pick in (min, max))
        if len(piece) == 4 and all(v in (a, b) for p in piece for v, a, b in zip(p, lower, upper, strict=True)):
            tables.append(table | {"lower": lower, "upper": upper})
        else:
            tables.append(table | {"vertices": [list(p) for p in piece]})
    return tables
